"""Turns of a Lagrange top's angles about any axis of the scene, against those counted."""

from fractions import Fraction

import pytest

from polhode.closed_forms._winding.argument_of_sum import Sum, Turning
from polhode.closed_forms.lagrange import turns
from polhode.closed_forms.lagrange.attitude import LagrangeAttitude
from polhode.closed_forms.lagrange.top import LagrangeTop
from polhode.numbers.mpmath_context import mpf, mpmath
from shared.closed_form_checks import distance, in_scene, rational_axes
from shared.lagrange_motions import PSI, motion

F = Fraction
NUTATING = ["nutation", "looping", "cusped", "near pole 1e-12", "homoclinic", "second axis"]
OTHERS = [
    *("cusp to come", "upper pole", "lower pole", "from the upper pole", "spherical pendulum"),
    *("librating", "rotating", "separatrix", "weak", "near cusp 1e-15", "next to the pole 1e-30"),
    *("near homoclinic 1e-20", "near homoclinic 1e-100", "unstable sleeper leaving"),
    *("first axis", "sphere"),
]
AXES = [rational_axes(q) for q in ((1, 2, 4, 2), (3, -1, 2, 4), (1, 1, 1, 0))]
TIMES = [F(40), F(-3), F(1, 7), F(150), F(-90)]


def turned(name, axes):
    """The same motion where the top's axes are turned in the scene's."""
    moments, torque, omega, gamma = motion(name)
    omega, gamma = in_scene(omega, axes), in_scene(gamma, axes)
    return LagrangeTop(moments, torque, omega, gamma, PSI, axes)


def counted(top, times, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(LagrangeAttitude, "arguments", lambda *_: None)
        return top.angles(times, 15)


def alternating(top):
    """Whether both terms of al or of bt lead in turn, and nothing has to be counted."""
    with mpmath.workprec(1024):  # at fewer, terms of one size where theta turns are not told
        found = top._attitude(1024)
        leads = [found._lead(row) for row in found.rows]
        return None in leads and found.arguments(mpf(50)) is not None


@pytest.mark.sample(3)
@pytest.mark.parametrize("name", NUTATING)
@pytest.mark.parametrize("axes", AXES)
def test_turns_are_those_counted(name, axes, monkeypatch):
    top = turned(name, axes)
    assert distance(top.angles(TIMES, 15), counted(top, TIMES, monkeypatch)) == 0


@pytest.mark.slow
def test_the_motions_above_are_of_the_kind_that_was_counted():
    found = [alternating(turned(name, axes)) for name in NUTATING for axes in AXES]
    assert sum(found) >= 9


@pytest.mark.slow
@pytest.mark.parametrize("name", OTHERS)
def test_motions_through_and_near_poles_and_separatrices(name, monkeypatch):
    times = [F(7), F(-3)]
    for axes in AXES[1:]:
        top = turned(name, axes)
        assert distance(top.angles(times, 15), counted(top, times, monkeypatch)) == 0


@pytest.mark.parametrize("name", ["looping", "homoclinic"])
def test_far_away(name):
    top, far = turned(name, AXES[1]), [F(10**12), F(-(10**12))]
    assert mpf("1e-40") < distance(top.angles(far, 20), top.angles(far, 35)) < mpf("1e-20")


def more(z, v):
    """The argument with a part that does not belong to it."""
    return z._replace(argument=z.argument + v)


@pytest.mark.parametrize("fault", ["gained", "sense", "missed", "argument"])
def test_a_fault_is_noticed(fault, monkeypatch):
    top = next(found for found in (turned("looping", axes) for axes in AXES) if alternating(found))
    right = counted(top, TIMES, monkeypatch)
    if fault == "gained":
        sums = Turning._gained
        monkeypatch.setattr(Turning, "_gained", lambda self, i, b, n: sums(self, i, b, n) + n)
    elif fault == "sense":
        monkeypatch.setattr(Sum, "sense", lambda self, i: 1)
    elif fault == "missed":
        known = turns._places
        monkeypatch.setattr(turns, "_places", lambda *a: known(*a)[:2])
    else:
        known = turns._polar
        monkeypatch.setattr(turns, "_polar", lambda m, z, v: more(known(m, z, v), v))
    top.__dict__.pop("_attitude")  # made again, with the fault
    assert distance(top.angles(TIMES, 15), right) > 1

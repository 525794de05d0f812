"""The digits of a crossing beside true ones: closed forms, and quad runs of other bodies."""

import json
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.cli import main
from shared.motions import scene_of
from shared.tools import exactly, tiers

EPS = 2.0**-52
GENERIC = polhode.load("general/asymmetric-chaotic")
TOP = (
    "0.91609882742327018"  # of gamma3 on general/asymmetric-regular, at t = 1.34387, by a quad run
)


def true_digits(scene, cut, which):
    """-log10 of the largest error of a crossing's state, beside the crossing of the exact motion.

    The exact motion at the crossing's time is a little before or after its own crossing: an Euler
    step along the flow leads there.  For scenes in principal axes and inner units.
    """
    moments, torque = (tuple(map(Fraction, v)) for v in (scene.body.moments, scene.body.torque))
    times = [Fraction(cut.times[0, m]) + Fraction(cut.times_low[0, m]) for m in which]
    if polhode.reference(scene).is_closed_form:
        exact = polhode.reference(scene).at(times, digits=30)
    else:
        exact = polhode.integrate(scene, at=times, number="quad").states

    def zero(x):
        G = [a * w for a, w in zip(moments, x[:3], strict=True)]
        return sum(g * c for g, c in zip(x[3:], crossed(torque, G), strict=True))

    digits = []
    for m, row in zip(which, exact, strict=True):
        x = [exactly(value) for value in row]
        w, g = x[:3], x[3:]
        G = [a * y for a, y in zip(moments, w, strict=True)]
        pairs = zip(crossed(g, torque), crossed(w, G), moments, strict=True)
        flow = [*((pull - spin) / a for pull, spin, a in pairs), *crossed(g, w)]
        step = Fraction(1, 10**12)
        ahead, behind = ([y + k * step * v for y, v in zip(x, flow, strict=True)] for k in (1, -1))
        late = zero(x) / (zero(ahead) - zero(behind)) * 2 * step
        states = zip(cut.states[0, m], x, flow, strict=True)
        error = max(abs(float(exactly(value) - y + late * v)) for value, y, v in states)
        digits.append(-np.log10(error + EPS / 8))
    return np.array(digits)


def crossed(a, b):
    return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]


def generic(*omega):
    return replace(GENERIC, omega=tuple(Fraction(x) for x in omega))


@pytest.mark.usefixtures("compiled_as_for_users")
@pytest.mark.parametrize(
    ("scene", "crossings"),
    tiers([(generic("0.3", "0.2", "0.9"), 80)], [("lagrange/nutation", 300)]),
    ids=str,
)
def test_true_digits_lie_in_a_band_about_those_told(scene, crossings):
    scene = polhode.load(scene) if isinstance(scene, str) else scene
    cut = polhode.section(scene, starts="scene", crossings=crossings)
    expected = cut.digits[0]
    which = sorted({*np.linspace(4, int((expected > 0.5).sum()) - 1, 9).astype(int).tolist()})
    more = true_digits(scene, cut, which) - expected[which]
    assert more.min() > -2.5
    assert more.max() < 1.5
    assert -2.0 < more.mean() < 1.0


def test_a_crossing_that_grazes_the_section_has_fewer_digits():
    """Just below a top of gamma3, beside quad: 11 are true, where 15.6 were told."""
    scene = polhode.load("general/asymmetric-regular")
    level = Fraction(TOP) - Fraction(1, 10**11)
    by = f"gamma3 - {level.numerator}/{level.denominator}"
    cut = polhode.section(scene, by=by, starts="scene", crossings=2)
    watched = replace(scene, events=(polhode.Event("level", by),)).at([Fraction(27, 20)])
    rows = polhode.integrate(watched, number="quad").events[0].states.astype(float)
    true = -np.log10(np.abs(rows[:2] - cut.states[0]).max(axis=1))
    assert np.abs(true - cut.digits[0]).max() < 1
    assert cut.digits[0].max() < 11.5


def test_no_digit_is_left_where_the_true_ones_end():
    """The first crossing without a digit, beside that of a quad run."""
    scene = generic("0.3", "0.2", "0.9")
    cut = polhode.section(scene, starts="scene", crossings=110)
    (first,) = cut.none_left_from.tolist()
    assert cut.digits[0, first - 1] < 1 <= cut.digits[0, : first - 1].min()
    near = list(range(first - 25, first + 15, 3))
    true = true_digits(scene, cut, near)
    gone = near[int((true < 1).argmax())] + 1
    assert true[0] > 1.5
    assert abs(gone - first) < 15
    assert (cut.digits[0, first + 20 :] == 0).all()


@pytest.mark.slow
def test_regular_orbits_keep_their_digits():
    cut = polhode.section("lagrange/nutation", grid=(3, 3), crossings=200)
    assert (cut.none_left_from == 0).all()
    assert cut.digits.min() > 12
    assert cut.digits[:, 0].min() > 14.5


def test_digits_are_the_same_in_any_unit_of_time():
    quick = scene_of(
        "schema = 1\n[body]\nmoments = [2, 1.5, 1]\ncentre = [0.3, 0.2, 0.5]\nweight = 1048576\n"
        "[start]\nomega = [307.2, 204.8, 1126.4]\ngamma = [0.6, 0, 0.8]\n"
    )
    plain = polhode.section(GENERIC, starts="scene", crossings=12)
    second = polhode.section(quick, starts="scene", crossings=12)
    assert second.start_states[0].tolist() == [307.2, 204.8, 1126.4, 0.6, 0.0, 0.8]
    assert (second.times * 1024 == plain.times).all()
    assert (second.digits == plain.digits).all()


def test_the_verb_tells_them(capsys):
    command = ["section", "general/asymmetric-chaotic", "--starts", "scene", "--crossings", "80"]
    assert main([*command, "--json"]) == 0
    printed = capsys.readouterr()
    content = json.loads(printed.out)
    (first,) = content["orbits"]["none_left_from"]
    digits = content["columns"]["digits_expected"]
    assert digits[first - 1] < 1 <= digits[first - 2]
    assert f"no digits are left from crossing {first} on in 1 of 1 orbits" in printed.err
    regular = "general/asymmetric-regular"
    assert main(["section", regular, "--grid", "2x1", "--crossings", "3"]) == 0
    printed = capsys.readouterr()
    names = ["orbit", "crossing", "t", "l", "L_over_G", "digits_expected"]
    assert printed.out.splitlines()[0].split() == names
    assert "digits or more are expected at every crossing" in printed.err


def test_crossings_soon_after_the_start_are_not_told_of_what_comes_later():
    """On a high level a unit of time holds thousands of turns; two crossings lose nothing."""
    cut = polhode.section("general/asymmetric-regular", h="1e10", f=0, grid=(2, 2), crossings=2)
    assert np.nanmax(cut.times) < 1e-3
    assert np.nanmin(cut.digits) > 15.4

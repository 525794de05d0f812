"""No closed form refuses a scene of its family: random ones, the hard ones among them.

Axes renamed, reversed and turned, in units of 1e20 and 1e-20.  What is answered is held against a
Taylor run that shares nothing with it, and against the same at more digits.
"""

from fractions import Fraction

import pytest

import polhode
from polhode.closed_forms.families import closed_form
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from shared import orbit_checks
from shared.closed_form_checks import full_inertia, in_scene, number
from shared.random_tops import FAMILIES, start
from shared.surface_checks import TURN

F = Fraction
PSI = F(3, 7)
QUICK = "euler", "lagrange", "pendulum", "staude", "grioli", "hess", "goryachev-chaplygin"
LONGER = "kovalevskaya", "bobylev-steklov", "steklov", "goryachev", "n-kowalewski", "chaplygin"
#: In units of the time in which the numbers of a start are of order 1.
NEAR, FAR = F(3, 4), F(30)
UNITS = 1, 1, F(10**20), F(1, 10**20)


def scene_of(plain, axes, unit, mass):
    """The same start about other axes, in other units of time and mass."""
    moments, torque, omega, gamma = plain
    heavy = [mass * x for x in moments]
    return polhode.Scene(
        polhode.Body(
            full_inertia(heavy, axes),
            in_scene([mass * unit * unit * x for x in torque], axes),
            1 if any(torque) else 0,
        ),
        in_scene([unit * x for x in omega], axes),
        in_scene(gamma, axes),
        psi=PSI,
        times=(1,),
    )


@pytest.mark.parametrize("family", QUICK)
def test_no_scene_of_a_family_is_refused(family):
    answers_are_right(family, 0)


@pytest.mark.slow
@pytest.mark.parametrize("family", LONGER)
def test_no_scene_of_the_others_is_refused(family):
    answers_are_right(family, 0)


@pytest.mark.campaign
@pytest.mark.parametrize("seed", range(1, 25))
@pytest.mark.parametrize("family", FAMILIES)
def test_no_scene_of_300_is_refused(family, seed):
    answers_are_right(family, seed)


def answers_are_right(family, seed):
    """State, attitude and angles of one scene, near and farther on."""
    plain, pick = start(family, seed)
    order, signs = pick.sample(range(3), 3), [pick.choice((1, -1)) for _ in range(3)]
    plain = orbit_checks.renamed(plain, tuple(order), signs)
    unit, mass, axes = pick.choice(UNITS), pick.choice(UNITS), pick.choice((None, TURN))
    identity = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    found = closed_form(scene_of(plain, axes or identity, unit, mass))
    assert found is not None
    _, top = found
    times = [NEAR / unit, -NEAR / unit, FAR / unit]
    rows, more = top.at(times, 20), top.at(times, 35)
    attitudes, others = top.attitude([F(0), *times], 20), top.attitude([F(0), *times], 35)
    angles, turns = top.angles(times, 20), top.angles(times, 35)
    with mpmath.workdps(60):
        scale = number(unit) * max([1, *(abs(x) / number(unit) for row in more for x in row[:3])])
        for row, right in zip(rows, more, strict=True):
            assert max(abs(x - y) for x, y in zip(row[:3], right[:3], strict=True)) < scale / 10**19
            assert max(abs(x - y) for x, y in zip(row[3:], right[3:], strict=True)) < mpf("1e-19")
        for row, right in zip(attitudes, others, strict=True):
            assert max(abs(x - y) for x, y in zip(row, right, strict=True)) < mpf("1e-19")
        for row, right, (q0, q1, q2, q3) in zip(angles, turns, others[1:], strict=True):
            assert [x is None for x in row] == [x is None for x in right]
            if row[0] is None:
                continue
            assert max(abs(x - y) for x, y in zip(row, right, strict=True)) < mpf("1e-19")
            psi, theta, phi = right
            one = mpmath.expj((psi + phi) / 2) * mpmath.cos(theta / 2)
            other = mpmath.expj((psi - phi) / 2) * mpmath.sin(theta / 2)
            side = 1 if abs(one - mpc(q0, q3)) + abs(other - mpc(q1, q2)) < 1 else -1
            assert abs(side * one - mpc(q0, q3)) < mpf("1e-30")
            assert abs(side * other - mpc(q1, q2)) < mpf("1e-30")
    for n, t in enumerate((NEAR, -NEAR)):
        (right,) = orbit_checks.taylor(plain, [t], 30, (mpf(1), mpf(0), mpf(0), mpf(0)))
        with mpmath.workdps(60):
            w, up, turn = (seen(right[i : i + 3], axes or identity) for i in (0, 3, 7))
            size = scale / number(unit)
            mine = [x / number(unit) / size for x in more[n][:3]]
            off = [abs(x - y / size) for x, y in zip(mine, w, strict=True)]
            off += [abs(x - y) for x, y in zip(more[n][3:], up, strict=True)]
            turned = orbit_checks.growth(others[n + 1], others[0])
            off += [abs(x - y) for x, y in zip(turned, [right[6], *turn], strict=True)]
            assert max(off) < mpf("1e-25")


def seen(v, axes):
    """A vector in the scene's axes, given along ``axes``."""
    return [sum(number(F(axes[i][j])) * v[i] for i in range(3)) for j in range(3)]

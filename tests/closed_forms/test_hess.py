"""Hess and Appelrot's case against its equations, Taylor runs and states to 50 digits.

The body 1, 25/34, 1/2 with the centre along (3, 0, 4)/5 is on the surface where 3p + 2r = 0.  In
rotation the surface repels, so Taylor runs stay short or carry more digits.  Errors lie in bands:
below what is asked, and above 1e-90, so that nothing is compared with itself.
"""

import json
import random
from fractions import Fraction
from pathlib import Path

import pytest

from polhode.closed_forms import families
from polhode.closed_forms.hess import axes, conditions, explicit, general, series
from polhode.closed_forms.hess.top import HessTop
from polhode.closed_forms.principal_scene import PrincipalScene
from polhode.common.errors import BadInput
from polhode.judging.reference import reference
from polhode.numbers import exact
from polhode.numbers.expression import number as read
from polhode.numbers.private import mpf, mpmath
from polhode.output.description import described
from polhode.scenes import library
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene
from shared import series as taylor
from shared.closed_form_checks import number, unwound

F = Fraction
DATA = Path(__file__).parents[1] / "data" / "other-50-digits.json"
BODY = (F(1), F(25, 34), F(1, 2))
TORQUE = (F(3, 5), F(0), F(4, 5))
ZERO = F(0)
TINY = F(1, 10**30)
TIMES = (F(2), F(7, 2))


def on_surface(p, q):
    """omega with A p T1 + C r T3 = 0."""
    return (F(p), F(q), -F(3, 2) * F(p))


def cone(u, side=1):
    """A start on the steady cone: Gm along Z, u |Z|^2 b + P |Gm|^2 = 0; u < 0.

    b = 34/25, P = 1; Z = Gm sqrt(-P/(b u)), Gm = sqrt(1 - u^2) e2: M along e2 = (-4, 0, 3)/5.
    """
    level = exact.sqrt(1 - u * u)
    momentum = side * level * exact.sqrt(-1 / (u * F(34, 25)))
    e1, e2 = (F(3, 5), F(0), F(4, 5)), (F(-4, 5), F(0), F(3, 5))
    gamma = tuple(u * x + level * y for x, y in zip(e1, e2, strict=True))
    omega = tuple(momentum * y / a for y, a in zip(e2, BODY, strict=True))
    return omega, gamma


TILT = (F(2, 7), F(3, 7), F(6, 7))


MOTIONS = {
    "libration": (on_surface("-6/25", "-34/125"), TILT, axes.LIBRATION),
    "from rest": (on_surface(0, 0), TILT, axes.LIBRATION),
    "general": (on_surface("-4/5", "-17/25"), TILT, axes.GENERAL),
    "fast": (on_surface("2", "3"), TILT, axes.GENERAL),
    "slow": (on_surface("1/10", "1/7"), TILT, axes.GENERAL),
    "cone": (*cone(F(-3, 5)), None),
    "cone, other way": (*cone(F(-1, 10), -1), None),
}


LOXODROME = (F(109, 125), F(-12, 25), F(12, 125))  # u = 3/5, Iw along 3 e2 + 4 e3


def upwards(size):
    """f = 0 with h = (34/25) size^2/2 + 3/5."""
    return tuple(size * x for x in (F(-12, 25), F(-136, 125), F(18, 25)))


MOTIONS["rotation"] = (upwards(F(5, 4)), LOXODROME, axes.ROTATION)
MOTIONS["separatrix"] = (upwards(exact.sqrt(F(10, 17))), LOXODROME, axes.SEPARATRIX)


def top(omega, gamma, torque=TORQUE, body=BODY, psi=ZERO):
    return HessTop(moments=body, torque=torque, omega=omega, gamma=gamma, psi=psi, axes=None)


def largest(one, other):
    with mpmath.workdps(120):
        return max(abs(x - y) for x, y in zip(one, other, strict=True))


def off(omega, gamma, times=TIMES, digits=40, attitudes=False, torque=TORQUE, body=BODY):
    """The largest difference of a closed form from a Taylor run."""
    found = top(omega, gamma, torque, body)
    rows, first = found.at(times, digits), None
    if attitudes:
        first = found.attitude([ZERO], digits)[0]
        rows = [a + b for a, b in zip(rows, found.attitude(times, digits), strict=True)]
    with mpmath.workdps(digits + 25):
        given = [[number(x) for x in row] for row in (body, omega, gamma, torque, times)]
        truth = taylor.integrate(*given[:3], given[4], digits, torque=given[3], quaternion=first)
        return max(largest(a, b) for a, b in zip(rows, truth, strict=True))


@pytest.mark.parametrize("name", MOTIONS)
def test_every_regime_agrees_with_a_taylor_run_state_and_attitude(name):
    omega, gamma, regime = MOTIONS[name]
    found = top(omega, gamma).regime
    assert found == regime if regime is not None else found in axes.CONES
    assert mpf("1e-90") < off(omega, gamma, attitudes=True) < mpf("1e-36")
    assert mpf("1e-90") < off(omega, gamma, (F(-3),), attitudes=True) < mpf("1e-36")


def test_the_cones_turn_and_tend():
    kinds = {top(*cone(F(-u, 40))).regime for u in range(1, 40)}
    assert kinds <= set(axes.CONES)
    assert len(kinds) > 1


def cases():
    found = json.loads(DATA.read_text())["cases"]
    return [case for case in found if case["group"] == "hess-appelrot"]


@pytest.mark.parametrize("case", cases(), ids=lambda case: case["kind"])
def test_published_states_to_50_digits(case):
    moments, centre, omega, gamma = (
        tuple(map(read, case[key])) for key in ("moments", "centre", "omega", "gamma")
    )
    torque = tuple(read(case["weight"]) * x for x in centre)
    rows = top(omega, gamma, torque, moments).at([F(t) for t in case["times"]], 50)
    with mpmath.workdps(60):
        for row, expected in zip(rows, case["states"], strict=True):
            assert largest(row, [mpf(x) for x in expected]) < mpf("5e-50")


@pytest.mark.parametrize("name", MOTIONS)
def test_two_precisions_agree_far_away(name):
    omega, gamma, _ = MOTIONS[name]
    found = top(omega, gamma)
    far = 20 if name == "separatrix" else 10**4  # at rest upright it has no digits to lose
    times = [F(far), F(-far)]
    for one, other in zip(found.at(times, 30), found.at(times, 60), strict=True):
        assert mpf("1e-60") < largest(one, other) < mpf("1e-28")


@pytest.mark.parametrize("name", MOTIONS)
def test_the_six_equations_hold(name):
    """By the five-point rule at 60 digits: truncation and rounding are about 1e-48."""
    omega, gamma, _ = MOTIONS[name]
    found, step = top(omega, gamma), F(1, 10**12)
    one, two, now, four, five = found.at([F(13, 10) + k * step for k in (-2, -1, 0, 1, 2)], 65)
    with mpmath.workdps(80):
        (A, B, C), (K1, K2, K3) = ([number(x) for x in row] for row in (BODY, TORQUE))
        p, q, r, g1, g2, g3 = now
        rules = [
            ((B - C) * q * r + g2 * K3 - g3 * K2) / A,
            ((C - A) * r * p + g3 * K1 - g1 * K3) / B,
            ((A - B) * p * q + g1 * K2 - g2 * K1) / C,
        ]
        rules += [g2 * r - g3 * q, g3 * p - g1 * r, g1 * q - g2 * p]
        for s, t, u, v, rule in zip(one, two, four, five, rules, strict=True):
            slope = (s - 8 * t + 8 * u - v) / (12 * number(step))
            assert abs(slope - rule) < mpf("1e-43")


def random_member(seed):
    """A body on the surface, irrational in general, and a start on it; axes in any order."""
    pick = random.Random(seed)

    def ratio(low, high):
        return F(pick.randint(int(low * 60), int(high * 60)), 60)

    C = ratio(0.5, 1)
    B = C + ratio(0.1, 0.5)
    A = B + ratio(0.05, 0.9) * C
    weight, side = ratio(0.5, 2), pick.choice((1, -1))
    torque = [weight * exact.sqrt(C * (A - B)), ZERO, side * weight * exact.sqrt(A * (B - C))]
    p, q = ratio(-1, 1), ratio(-1, 1)
    omega = [p, q, -A * p * torque[0] / (C * torque[2])]
    x, y = ratio(-2, 2), ratio(-2, 2)
    norm = 1 + x * x + y * y
    gamma = [2 * x / norm, 2 * y / norm, (1 - x * x - y * y) / norm]
    k = pick.randint(0, 2)
    rows = ([A, B, C], torque, omega, gamma)
    return tuple(tuple(row[k:] + row[:k]) for row in rows)


@pytest.mark.parametrize("seed", range(30))
def test_random_members_agree_with_a_taylor_run(seed):
    body, torque, omega, gamma = random_member(seed)
    assert conditions.fits(PrincipalScene(body, torque, omega, gamma))
    found = off(omega, gamma, (F(3, 4),), 25, torque=torque, body=body)
    assert mpf("1e-90") < found < mpf("1e-22")


@pytest.mark.campaign
@pytest.mark.parametrize("seed", range(30, 330))
def test_more_random_members(seed):
    body, torque, omega, gamma = random_member(seed)
    found = off(omega, gamma, (F(4),), 30, True, torque, body)
    assert mpf("1e-90") < found < mpf("1e-20")


CORRUPTIONS = {
    "matrix": (general, "powered", lambda old: lambda N, n: old((N[0] * (1 + TINY_), N[1]), n)),
    "series": (
        series,
        "_series",
        lambda old: lambda start, P, *rest: old(start, P + (1 << (rest[-1] - 100)), *rest),
    ),
    "roots": (general, "_roots", lambda old: lambda *a: (old(*a)[0] - TINY_, *old(*a)[1:])),
}
TINY_ = mpf(10) ** -30


@pytest.mark.parametrize("name", CORRUPTIONS)
def test_a_corrupted_formula_fails(name, monkeypatch):
    where, what, change = CORRUPTIONS[name]
    monkeypatch.setattr(where, what, change(getattr(where, what)))
    omega, gamma, _ = MOTIONS["general"]
    assert off(omega, gamma, (F(9),)) > mpf("1e-34")


def test_a_corrupted_plane_motion_fails(monkeypatch):
    old = explicit._balanced
    monkeypatch.setattr(explicit, "_balanced", lambda x: old(x * (1 + mpf(10) ** -30)))
    omega, gamma, _ = MOTIONS["libration"]
    assert off(omega, gamma) > mpf("1e-34")


@pytest.mark.parametrize("which", range(4))
def test_1e_30_off_is_refused(which):
    body, torque, (omega, gamma, _) = BODY, TORQUE, MOTIONS["general"]
    if which == 0:
        omega = (omega[0] + TINY, *omega[1:])
    elif which == 1:
        body = (BODY[0] + TINY, *BODY[1:])
    elif which == 2:
        torque = (TORQUE[0], TINY, TORQUE[2])
    else:
        torque = (TORQUE[0], ZERO, TORQUE[2] + TINY)
    scene = PrincipalScene(body, torque, omega, gamma)
    assert not conditions.fits(scene)
    wrong = conditions.misfit(scene)
    assert wrong is not None
    assert 1e-32 < abs(float(wrong.off)) < 1e-28
    with pytest.raises(ValueError, match="does not meet this condition"):
        top(omega, gamma, torque, body)


def turned_scene(kind="auto", move=ZERO):
    omega, gamma, _ = MOTIONS["general"]
    omega = (omega[0] + move, *omega[1:])
    R = [[F(1, 3), F(2, 3), F(2, 3)], [F(-2, 3), F(2, 3), F(-1, 3)], [F(-2, 3), F(-1, 3), F(2, 3)]]

    def turned(v):
        return tuple(sum(R[i][j] * v[j] for j in range(3)) for i in range(3))

    inertia = tuple(
        tuple(sum(R[i][k] * BODY[k] * R[j][k] for k in range(3)) for j in range(3))
        for i in range(3)
    )
    body = Body(inertia, turned(TORQUE), F(1))
    return Scene(body=body, omega=turned(omega), gamma=turned(gamma), reference=kind), R


def test_a_scene_in_turned_axes_is_recognised():
    scene, R = turned_scene()
    name, form = families.closed_form(scene)
    assert name == "hess"
    (row,) = form.at([F(2)], 30)
    (plain,) = top(*MOTIONS["general"][:2]).at([F(2)], 30)
    with mpmath.workdps(50):
        for part in (slice(0, 3), slice(3, 6)):
            expected = [sum(number(R[i][j]) * plain[part][j] for j in range(3)) for i in range(3)]
            assert largest(row[part], expected) < mpf("1e-29")


def test_asked_for_by_name_the_failing_condition_is_told():
    scene, _ = turned_scene("hess", F(1, 1000))
    with pytest.raises(BadInput, match="Iw at right angles to r0, off by"):
        reference(scene)


@pytest.mark.parametrize("name", ["libration", "general", "rotation"])
def test_angles_are_continuous(name):
    omega, gamma, _ = MOTIONS[name]
    found = top(omega, gamma)
    (psi, _, phi), (psi_1, _, phi_1) = found.angles([F(1, 10), F(25)], 15)
    grown = unwound(found, F(1, 10), F(25), 300)
    assert abs(psi_1 - psi - grown[0]) < mpf("1e-11")
    assert abs(phi_1 - phi - grown[1]) < mpf("1e-11")


def test_a_motion_that_tends_to_a_periodic_one_does_so_at_the_rate_told():
    """Two starts with the same gamma1, apart by a turn of Z and Gm about r0, come together."""
    omega, gamma, _ = MOTIONS["general"]
    found = top(omega, gamma)
    rate = found.approach(20)
    assert rate is not None
    path = found._path(found._bits((), 30))
    t1 = path.period_of_u
    with mpmath.workprec(200):
        gaps = []
        for n in (20, 30):
            one, other = general.powered(path.N, n)
            ends = [
                (x.conjugate() / x)
                for x in (one + other.conjugate(), 1j * one - 1j * other.conjugate())
            ]
            gaps.append(abs(ends[0] - ends[1]))
        measured = mpmath.log(gaps[0] / gaps[1]) / (10 * t1)
        own = mpmath.ldexp(rate, -found._start.exponent)
        assert abs(measured - own) < mpf("1e-6") * own


def test_period_brings_the_state_back():
    omega, gamma, _ = MOTIONS["libration"]
    found = top(omega, gamma)
    period = found.period(40)
    with mpmath.workdps(80):
        time = F(int(mpmath.nint(mpmath.ldexp(period, 160))), 2**160)
    (row,) = found.at([time], 40)
    with mpmath.workdps(60):
        assert largest(row, [number(x) for x in (*omega, *gamma)]) < mpf("1e-37")


def test_show_tells_what_a_scene_is_near_to_and_where_it_tends():
    near = described(library.load("hard/near-hess"))["near"]
    assert len(near) == 1
    assert near[0].startswith("hess: Iw at right angles to r0, off by")
    assert 0.1 < reference("hess/general").approach < 10
    assert reference("hess/turned-axes").approach is None
    assert "near" not in described(library.load("hess/released"))

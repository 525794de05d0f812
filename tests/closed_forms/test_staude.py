"""Permanent rotations and rest: stability decided exactly, attitude, membership."""

from fractions import Fraction

import numpy as np
import pytest

from polhode.closed_forms._one_orbit.staude import HANGING, UPRIGHT, Staude
from polhode.closed_forms.functions.rotation_stability import STABLE, UNDECIDED, UNSTABLE, Stability
from polhode.numbers import exact
from polhode.numbers.mpmath_context import mpf, mpmath
from shared import orbit_checks as checks
from shared.closed_form_checks import fractions, number

F = Fraction
MOMENTS = (F(2), F(3, 2), F(6, 5))


def rotation(moments, gamma, om, mu):
    """T = om^2 I gamma - mu gamma."""
    torque = tuple((om * om * m - mu) * g for m, g in zip(moments, gamma, strict=True))
    return moments, torque, tuple(om * g for g in gamma), gamma


SHEET = {
    mu: rotation(MOMENTS, fractions(("2/7", "3/7", "6/7")), F(2), F(mu))
    for mu in ("11", "3", "13/2")
}
IRRATIONAL = rotation(
    (F(2), exact.sqrt(F(2)), F(6, 5)),
    (exact.sqrt(F(1, 2)), F(1, 2), F(1, 2)),
    exact.sqrt(F(3)),
    F(7),
)
HANG = (MOMENTS, fractions((1, 2, 2)), fractions((0, 0, 0)), fractions(("-1/3", "-2/3", "-2/3")))
STAND = (MOMENTS, fractions((1, 2, 2)), fractions((0, 0, 0)), fractions(("1/3", "2/3", "2/3")))


def test_stability_of_the_sheet():
    """mu = 11: stable, b = 11.168, d = 7.3415; 3: b^2 < 4d; 13/2: d < 0."""
    regimes = {mu: Staude(*start).regime for mu, start in SHEET.items()}
    assert regimes == {
        "11": "permanent rotation, spectrally stable",
        "3": "permanent rotation, unstable",
        "13/2": "permanent rotation, unstable",
    }
    found = Staude(*SHEET["11"]).stability
    assert abs(float(found.b) - 11.168) < 5e-4
    assert abs(float(found.d) - 7.3415) < 5e-5
    assert Staude(*SHEET["3"]).stability.d > 0
    assert Staude(*SHEET["13/2"]).stability.d < 0


@pytest.mark.parametrize(
    ("b", "d", "verdict"),
    [
        (1, F(1, 8), STABLE),
        (1, F(1, 4), UNDECIDED),  # a double imaginary pair
        (1, 0, UNDECIDED),
        (0, 0, UNDECIDED),
        (0, 1, UNSTABLE),  # lam^4 = -1
        (-1, 0, UNSTABLE),
        (-2, 1, UNSTABLE),
        (1, 1, UNSTABLE),
        (1, -1, UNSTABLE),
    ],
)
def test_verdict(b, d, verdict):
    """On every boundary the roots of lam^4 + b lam^2 + d say what the verdict says."""
    assert Stability(F(b), F(d)).verdict == verdict
    roots = np.roots([1, 0, float(b), 0, float(d)])
    assert (max(roots.real) > 1e-6) == (verdict == UNSTABLE)


def jacobian(start):
    """By differences of the right-hand sides, in doubles: the independent matrix."""
    moments, torque, omega, gamma = ([float(x) for x in row] for row in start)
    inertia = np.diag(moments)

    def rates(state):
        w, g = state[:3], state[3:]
        moment = np.cross(g, torque) - np.cross(w, inertia @ w)
        return np.concatenate([moment / moments, np.cross(g, w)])

    state = np.array([*omega, *gamma])
    columns = []
    for i in range(6):
        step = np.zeros(6)
        step[i] = 1e-3  # the right-hand sides are quadratic: no truncation
        columns.append((rates(state + step) - rates(state - step)) / 2e-3)
    return np.array(columns).T


def axis_rotations(count):
    """Permanent rotations at random: T = om^2 I gamma - mu gamma, gamma rational."""
    rng = np.random.default_rng(5)
    for _ in range(count):
        a, b, c = sorted(F(int(x), 10) for x in rng.integers(10, 40, 3))
        c = min(c, a + b - F(1, 7))
        x, y = (F(int(v), 7) for v in rng.integers(-20, 20, 2))
        over = 1 + x * x + y * y
        gamma = 2 * x / over, 2 * y / over, (1 - x * x - y * y) / over
        om, mu = (F(int(v), 6) for v in rng.integers(-20, 40, 2))
        start = rotation((a, b, c), gamma, om, mu)
        if any(start[1]) and om:
            yield start


def test_stability_against_eigenvalues():
    seen = set()
    for start in axis_rotations(60):
        top = Staude(*start)
        growth = max(np.linalg.eigvals(jacobian(start)).real)
        verdict = top.stability.verdict
        seen.add(verdict)
        if verdict == UNSTABLE:
            assert growth > 1e-5
        elif verdict == STABLE:
            assert growth < 1e-5  # a double eigenvalue 0 is known to sqrt(eps) only
    assert {STABLE, UNSTABLE} <= seen


def test_rest():
    assert Staude(*HANG).regime == HANGING
    assert Staude(*STAND).regime == UPRIGHT
    assert Staude(*HANG).stability.verdict == STABLE
    assert Staude(*STAND).stability.verdict == UNSTABLE
    assert Staude(*HANG).frequencies(20) == {}
    assert Staude(*HANG).at([F(10**9)], 30) == Staude(*HANG).at([F(0)], 30)


def test_stored_values():
    checks.check_stored(Staude, "staude", digits=49)


@pytest.mark.parametrize("start", [SHEET["11"], SHEET["3"], IRRATIONAL])
def test_state_stays_and_the_body_turns(start):
    """The residual of all equations, attitude and angles; cos, sin of half the angle turned."""
    top, om = Staude(*start, F(7, 10)), Staude(*start).frequencies(50)["precession"]
    times = [F(0), F(13, 10), F(-(10**12))]
    rows = top.at(times, 50)
    assert rows[0] == rows[1] == rows[2]
    with mpmath.workdps(60):
        speed = mpmath.sqrt(sum(x * x for x in rows[0][:3]))
        assert abs(abs(om) - speed) < mpf(10) ** -48
        start_angles, *angles = top.angles(times, 40)
        for t, (psi, theta, phi) in zip(times[1:], angles, strict=True):
            assert abs(psi - number(F(7, 10)) - om * number(t)) < mpf(10) ** -38
            assert abs(theta - start_angles[1]) < mpf(10) ** -39
            assert abs(phi - start_angles[2]) < mpf(10) ** -39
        q, *turned = top.attitude(times, 40)
        for t, row in zip(times[1:], turned, strict=True):
            c, s = mpmath.cos_sin(om * number(t) / 2)
            a, x, y, z = q
            expected = [c * a - s * z, c * x - s * y, c * y + s * x, c * z + s * a]
            assert max(abs(u - v) for u, v in zip(row, expected, strict=True)) < mpf(10) ** -38


def test_equations():
    for start in (*SHEET.values(), IRRATIONAL, HANG, STAND):
        with mpmath.workdps(120):
            moments, torque = ([number(x) for x in row] for row in start[:2])
            (row,) = Staude(*start).at([F(1)], 100)
            w, g = row[:3], row[3:]
            for _, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
                moment = (
                    (moments[j] - moments[k]) * w[j] * w[k] + g[j] * torque[k] - g[k] * torque[j]
                )
                assert abs(moment) < mpf(10) ** -97
                assert abs(g[j] * w[k] - g[k] * w[j]) < mpf(10) ** -97


def test_independent_integration():
    start = SHEET["11"]
    (row,) = checks.taylor(start, [F(20)], 30, Staude(*start).attitude([F(0)], 40)[0])
    assert checks.relative([row[:6]], Staude(*start).at([F(20)], 30)) < mpf(10) ** -28
    with mpmath.workdps(40):
        assert checks.distance([row[6:10]], Staude(*start).attitude([F(20)], 30)) < mpf(10) ** -28


@pytest.mark.parametrize("start", [SHEET["11"], IRRATIONAL])
def test_axes_renamed_reflected_and_turned(start):
    checks.check_names_and_axes(Staude, start)


@pytest.mark.parametrize("start", [SHEET["11"], SHEET["3"]])
def test_membership(start):
    checks.check_membership(Staude, start)


def test_a_wrong_matrix_would_be_seen(monkeypatch):
    """One entry of J with its sign changed: the eigenvalues disagree."""
    from polhode.closed_forms.functions import rotation_stability as stability

    right = stability._jacobian

    def wrong(*state):
        rows = right(*state)
        rows[0][4] = -rows[0][4]
        return rows

    monkeypatch.setattr(stability, "_jacobian", wrong)
    with pytest.raises(AssertionError):
        test_stability_of_the_sheet()
    with pytest.raises(AssertionError):
        test_stability_against_eigenvalues()

"""Turns of a torque-free body's angles at any time: against those counted along the motion.

Counted ones (of the same attitude, without what is known about its turns) are another way to the
same whole numbers.  Far away two precisions agree, parts of the way make the whole, and the motion
with w reversed goes the same way back.
"""

import random
from fractions import Fraction

import pytest

from polhode.closed_forms._winding import euler_angles
from polhode.closed_forms._winding.argument_of_sum import Sum, Turning
from polhode.closed_forms.euler import turns
from polhode.closed_forms.euler.attitude import EulerAttitude
from polhode.closed_forms.euler.crossings import crossings
from polhode.closed_forms.euler.top import EulerTop
from polhode.closed_forms.functions.jacobi import MP, jacobi
from polhode.numbers.exact import sqrt
from polhode.numbers.mpmath_context import mpf, mpmath
from shared.closed_form_checks import rational_axes

F = Fraction
POLES = [(F(0), F(0), F(1)), (F(0), F(0), F(-1)), (F(0), F(1), F(0)), (F(1), F(0), F(0))]
SEPARATRIX = (F(9, 4), F(2), F(1)), (F(2, 5), F(0), F(-3, 10))
TURNOVER = (F(1), F(2), F(3)), (F(1, 10**12), F(1), F(0)), (F(3, 5), F(0), F(4, 5))
WIDE = (
    (F(13, 10), F(11, 10), F(9, 5)),
    (F(0), F(3), F(29, 10)),
    (F(7, 25), F(0), F(24, 25)),
)
SKEW = rational_axes((3, -1, 2, 4))


def made(body, axes=None, sense=1):
    moments, omega, gamma = body
    return EulerTop(moments, tuple(sense * x for x in omega), gamma, F(1, 3), axes)


def vertical(pick, size=20):
    """A unit vector at random; size 1/n: near the third axis."""
    x, y = (size * F(pick.randint(-20, 20), 140) for _ in range(2))
    norm = 1 + x * x + y * y
    return 2 * x / norm, 2 * y / norm, (1 - x * x - y * y) / norm


def body(seed):
    """A motion at random: moments nearly or quite equal, rates tiny or zero, starts at poles."""
    pick = random.Random(seed)
    a, b = (F(pick.randint(1, 40), pick.randint(1, 20)) for _ in range(2))
    if pick.random() < 0.3:
        b = a * (1 + F(pick.choice([0, 1]), 10 ** pick.randint(1, 20)))
    moments = [a, b, abs(a - b) + (a + b - abs(a - b)) * F(pick.randint(1, 50), 50)]
    omega = [F(pick.randint(-9, 9), pick.randint(1, 9)) for _ in range(3)]
    for i in range(3):
        omega[i] *= pick.choice([1, 1, 1, 0, F(1, 10 ** pick.randint(1, 15))])
    if not any(omega):
        omega[1] = F(1)
    low, middle, high = sorted(range(3), key=lambda i: moments[i])
    if pick.random() < 0.25 and moments[low] < moments[middle] < moments[high]:
        A, B, C = (moments[i] for i in (low, middle, high))
        omega[low] = omega[low] or F(1)
        omega[high] = omega[low] * sqrt(A * (B - A) / (C * (C - B)))
    gamma = vertical(pick, pick.choice([20, 20, 20, F(1, 10 ** pick.randint(1, 4))]))
    if pick.random() < 0.15:
        gamma = pick.choice(POLES)
    order = pick.sample(range(3), 3)
    axes = rational_axes(tuple(pick.randint(1, 5) for _ in range(4))) if seed % 2 else None
    return (tuple(moments[i] for i in order), tuple(omega[i] for i in order), gamma), axes


def counted(top, times, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(EulerAttitude, "arguments", lambda *_: None)
        return top.angles(times, 15)


def off(one, other):
    """The largest difference of two tables of angles, a pole's None like nothing but itself."""
    pairs = [(x, y) for a, b in zip(one, other, strict=True) for x, y in zip(a, b, strict=True)]
    assert all((x is None) == (y is None) for x, y in pairs)
    return max(abs(x - y) for x, y in pairs if x is not None)


def closed(top, times):
    """Whether no turn was counted."""
    moments = [lambda _, t=t: mpf(float(t)) for t in times]
    return all(euler_angles._closed(top._attitude, t, 192) is not None for t in moments)


def agrees(seed, monkeypatch):
    given, axes = body(seed)
    fast = F(max(abs(float(x)) for x in given[1]))
    pick = random.Random(seed)
    times = [F(pick.randint(-900, 900) or 1, 10) / fast for _ in range(5)]
    top = made(given, axes)
    return closed(top, times) and off(top.angles(times, 15), counted(top, times, monkeypatch)) == 0


@pytest.mark.sample(4, slow=8)
@pytest.mark.parametrize("seed", range(40))
def test_random_motions(seed, monkeypatch):
    assert agrees(seed, monkeypatch)


@pytest.mark.campaign
@pytest.mark.parametrize("seed", range(1000, 1400))
def test_many_random_motions(seed, monkeypatch):
    assert agrees(seed, monkeypatch)


@pytest.mark.sample(2)
@pytest.mark.parametrize("given", [TURNOVER, WIDE])
@pytest.mark.parametrize("axes", [None, SKEW])
def test_around_every_change_of_lead(given, axes, monkeypatch):
    """Just before and after the places where another term leads, on both sides of 0."""
    top = made(given, axes)
    with mpmath.workprec(192):
        found = top._attitude(192)
        motion, period = found.motion, 4 * found.motion.elliptic.K
        phases = [x.u for part in found._turns._parts for x in part.whole.places]
        moments = [(u + n * period - motion.v0) / motion.rate for u in phases for n in (-1, 0)][:4]
    assert len(phases) >= 2
    times = [F(float(t)) + d for t in moments for d in (F(1, 10**6), -F(1, 10**6))]
    assert off(top.angles(times, 15), counted(top, times, monkeypatch)) == 0


@pytest.mark.parametrize(
    "gamma",
    [
        (F(2, 7), F(3, 7), F(6, 7)),  # along Iw
        (F(-2, 7), F(-3, 7), F(-6, 7)),
        (F(3, 5), F(4, 5), F(0)),
        (F(0), F(-2, 1) * sqrt(F(1, 5)), sqrt(F(1, 5))),  # at right angles to it
    ],
)
@pytest.mark.parametrize("axes", [None, SKEW])
def test_a_vertical_along_or_across_the_angular_momentum(gamma, axes, monkeypatch):
    if axes:
        gamma = tuple(sum((axes[i][j] * gamma[i] for i in range(3)), F(0)) for j in range(3))
        omega = tuple(axes[0][j] * 2 + axes[1][j] * F(3, 2) + axes[2][j] * 2 for j in range(3))
    else:
        omega = F(2), F(3, 2), F(2)
    top, times = made(((F(1), F(2), F(3)), omega, gamma), axes), [F(60), F(-45), F(7, 3)]
    assert closed(top, times)
    assert off(top.angles(times, 15), counted(top, times, monkeypatch)) == 0


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_separatrix(seed, monkeypatch):
    gamma, times = vertical(random.Random(seed)), [F(700), F(-900), F(5011)]
    top = made((*SEPARATRIX, gamma))
    assert closed(top, times)
    assert off(top.angles(times, 15), counted(top, times, monkeypatch)) == 0


@pytest.mark.parametrize(
    ("gap", "gamma"),
    [
        (F(1, 10**60), (F(0), F(1), F(0))),
        (F(-1, 10**60), vertical(random.Random(3))),
        pytest.param(F(-1, 10**200), (F(0), F(1), F(0)), marks=pytest.mark.slow),
    ],
)
def test_next_to_a_separatrix_bits_are_added_until_terms_are_told_apart(gap, gamma, monkeypatch):
    """Iw across axis 2: the third axis rests next to the vertical, on one side or the other."""
    monkeypatch.setattr(euler_angles, "_COUNTING_BITS", 1024 if abs(gap) < 1e-100 else 512)
    moments, (p, q, r) = SEPARATRIX
    top = made((moments, (p + gap, q, r), gamma))
    times, far = [F(190), F(-300)], [F(10**9), F(-(10**9))]
    assert closed(top, [*times, *far])
    assert off(top.angles(times, 15), counted(top, times, monkeypatch)) == 0
    assert off(top.angles(far, 20), top.angles(far, 90)) < mpf("1e-20")


def test_a_separatrix_that_passes_the_vertical_ever_nearer_on_one_side(monkeypatch):
    top = made((*SEPARATRIX, (F(0), F(1), F(0))))  # Iw has no part along axis 2
    times = [F(60), F(-60), F(95)]
    assert off(top.angles(times, 15), counted(top, times, monkeypatch)) == 0
    assert off(top.angles([F(10**6)], 20), top.angles([F(10**6)], 90)) < mpf("1e-20")


FAR = [F(10**9) + F(1, 3), F(10**12), F(-(10**12))]
MOTIONS = [TURNOVER, WIDE, (*SEPARATRIX, vertical(random.Random(1)))]


@pytest.mark.parametrize("given", MOTIONS)
@pytest.mark.parametrize("axes", [None, SKEW])
def test_far_away(given, axes):
    if axes and given[0] == SEPARATRIX[0]:
        given = (
            given[0],
            tuple(sum((axes[i][j] * given[1][i] for i in range(3)), F(0)) for j in range(3)),
            given[2],
        )
    top = made(given, axes)
    low, high = top.angles(FAR, 20), top.angles(FAR, 35)
    assert mpf("1e-40") < off(low, high) < mpf("1e-20")
    back = made(given, axes, -1).angles([-t for t in FAR], 20)
    assert off(low, back) < mpf("1e-20")
    with mpmath.workprec(192):
        found = top._attitude(192)._turns
        first, middle, last = mpf(3), mpf("-4.7e11"), mpf(10) ** 12
        parts = found.growth(first, middle), found.growth(middle, last)
        for whole, one, other in zip(found.growth(first, last), *parts, strict=True):
            assert abs(whole - one - other) < mpf("1e-20")


@pytest.mark.slow
@pytest.mark.parametrize(("given", "t"), [(TURNOVER, 400), (WIDE, 5 * 10**4)])
def test_counted_over_a_long_way(given, t, monkeypatch):
    top, times = made(given), [F(t), F(-t)]
    assert off(top.angles(times, 15), counted(top, times, monkeypatch)) == 0


def test_no_time_is_too_far():
    """Turns that a march would take a day for, and psi's mean rate from them."""
    top = made(WIDE)
    one, other = top.angles([F(10**15), F(3 * 10**15)], 20)
    rates = [(other[i] - one[i]) / (2 * 10**15) - one[i] / 10**15 for i in (0, 2)]
    assert max(abs(x) for x in rates) < mpf("1e-13")


@pytest.mark.parametrize("fault", ["gained", "sense", "advance", "spin", "missed", "gain"])
def test_a_fault_is_noticed(fault, monkeypatch):
    given, axes = body(21) if fault == "gain" else (TURNOVER, SKEW)
    fast = F(max(float(abs(x)) for x in given[1]))
    times = [t / fast for t in (F(140), F(60), F(-90), F(-200))]
    right = counted(made(given, axes), times, monkeypatch)
    if fault == "gained":
        sums = Turning._gained
        monkeypatch.setattr(Turning, "_gained", lambda self, i, b, n: sums(self, i, b, n - 1))
    elif fault == "sense":
        monkeypatch.setattr(Sum, "sense", lambda self, i: 1)
    elif fault == "advance":
        known = Sum.advance.func
        monkeypatch.setattr(Sum, "advance", property(lambda s: known(s) + 2 * mpmath.pi))
    elif fault == "spin":
        known = Turning._argument
        monkeypatch.setattr(Turning, "_argument", lambda s, t, *a: known(s, 2 * t, *a))
    elif fault == "missed":
        known = turns.crossings
        monkeypatch.setattr(turns, "crossings", lambda *a: (known(*a)[0], known(*a)[1][2:]))
    else:
        monkeypatch.setattr(Sum, "_gains", property(lambda self: [*range(len(self.places))]))
    assert off(made(given, axes).angles(times, 15), right) > 1


def functions(j, u):
    waves = j.waves(u, MP)
    sn, cn, dn = j.functions(waves)
    side = (-1) ** waves.turns
    return side * cn, side * sn, dn


def test_places_of_a_sum_are_all_found():
    """Against signs of the sum on a fine grid, and each by its value."""
    pick = random.Random(4)
    with mpmath.workprec(128):
        for _ in range(12):
            k2 = 1 - mpf(10) ** -pick.randint(0, 12) / 2
            j = jacobi(k2, 1 - k2)
            row = [mpf(pick.randint(-9, 9)) / 7 for _ in range(3)]
            value = mpf(pick.randint(-9, 9)) / 11
            above, places = crossings(j, row, value)
            grid = [4 * j.K * n / 150 for n in range(150)]

            def side(u, row=row, value=value, j=j):
                waves = functions(j, u)
                return sum(x * y for x, y in zip(row, waves, strict=True)) - value

            signs = [side(u) > 0 for u in grid]
            changes = sum(a != b for a, b in zip(signs, signs[1:] + signs[:1], strict=True))
            assert len(places) == changes
            assert above == signs[0]
            for place in places:
                assert abs(side(place.u)) < mpf(10) ** -33
                assert place.rises == (side(place.u + mpf(10) ** -9) > 0)


def test_places_touched_at_once_and_far_apart():
    with mpmath.workprec(192):
        j = jacobi(mpf(1) / 2, mpf(1) / 2)
        least = mpmath.sqrt(mpf(1) / 2)
        assert crossings(j, (0, 0, mpf(1)), least) == (True, ())  # dn touches k' at K and 3K
        assert crossings(j, (0, 0, mpf(1)), mpf(1)) == (False, ())
        tiny = mpf(10) ** -30
        _, places = crossings(j, (0, 0, mpf(1)), least * (1 + tiny))
        assert len(places) == 4
        assert mpf("1e-15") < places[1].u - places[0].u < mpf("1e-14")
        below, (zero, half) = crossings(j, (0, mpf(1), 0), mpf(0))  # sn, at 0 and 2K
        assert (below, zero.u, zero.rises, half.rises) == (False, 0, True, False)
        assert abs(half.u - 2 * j.K) < mpf(10) ** -50
        assert crossings(jacobi(mpf(0), mpf(1)), (0, 0, mpf(1)), mpf(1)) == (True, ())


def test_what_the_precision_does_not_tell_is_refused():
    """Next to a separatrix sn rests so near 1 that the sum is not told from the value."""
    with mpmath.workprec(128):
        near = mpf(10) ** -90
        with pytest.raises(ArithmeticError, match="too nearly equal"):
            crossings(jacobi(1 - near, near), (0, mpf(1), 0), 1 - near)


def test_a_pole_is_left_on_the_side_of_time(monkeypatch):
    """Starts at both poles next to a separatrix, q and p small: nothing is counted."""
    for third in (1, -1):
        top = made((TURNOVER[0], TURNOVER[1], (F(0), F(0), F(third))))
        times = [F(1, 10), F(-1, 10), F(3), F(-2)]
        assert closed(top, times)
        assert off(top.angles(times, 15), counted(top, times, monkeypatch)) == 0


@pytest.mark.slow
def test_a_third_axis_that_ever_again_is_exactly_vertical_is_counted(monkeypatch):
    """The angular momentum along the vertical and the third axis at t = 0, and so every period."""
    moments = F(1), F(2), F(3)
    rates = [SKEW[i][2] / moments[i] for i in range(3)]
    omega = tuple(sum((SKEW[i][j] * rates[i] for i in range(3)), F(0)) for j in range(3))
    top, times = made((moments, omega, POLES[0]), SKEW), [F(3), F(-1)]
    assert not closed(top, times)
    assert off(top.angles(times, 15), counted(top, times, monkeypatch)) == 0

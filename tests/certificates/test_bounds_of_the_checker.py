"""The checker's bounds beside what they bound: of a step, the set, a box of motions.

Each holds as it stands, and not without one of its terms; those of rounding show at few bits.
``tests/measure/checker.json`` has the terms, one by one.
"""

import math
import random
from collections.abc import Callable, Iterator
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from flint import arb, arb_mat, arb_poly, ctx, fmpq, fmpq_mat

from polhode.certificates import verify
from polhode.numbers.polynomials import middle as exactly
from shared.proofs import body_of

FEW = 10  # bits


@pytest.fixture(autouse=True)
def precision():
    with ctx.workprec(64):
        yield


# -- one step -------------------------------------------------------------------------------------


#: A truth, its bound, and below how many times that the bound is.
Row = tuple[Any, Any, float]


def step_of(a: float, b: float, d: float) -> verify.Step:
    """The bounds of z' = a z + b z^2 + d, of one component, with V = 1."""
    step = verify.Step.__new__(verify.Step)
    step.growth, step.delta, step.beta = arb(a).exp(), arb(d), arb(b)
    step.rho = step.growth * a  # e^a int |A V - V'|
    return step


def end_of(a: float, b: float, d: float, z: float, steps: int = 1000) -> float:
    """z(1), by the classical method of order 4."""
    h = 1 / steps

    def rate(z: float) -> float:
        return a * z + b * z * z + d

    for _ in range(steps):
        k1 = rate(z)
        k2 = rate(z + h / 2 * k1)
        k3 = rate(z + h / 2 * k2)
        z += h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(z + h * k3))
    return z


def off_the_linear_part(_: object) -> Iterator[Row]:
    """A motion is within reach, and off its linear part by the noise at most."""
    rows = (1, 0, 1e-3, 0), (0, 1, 0, 0.2), (1, 0, 0, 1e-3), (0.5, 0.1, 0.1, 0.2)
    for a, b, d, eps in rows:
        step, z = step_of(a, b, d), end_of(a, b, d, eps)
        r = step.reach(arb(eps))
        assert z < r
        yield z - eps, step.noise(arb(eps), r), 4


def test_a_step_whose_motions_have_no_bound_is_refused():
    """z' = z^2 leaves 2 z(0) before 1 from 1/2 on; of a linear part alone all is well."""
    step_of(0, 1, 0).reach(arb("0.24"))
    with pytest.raises(verify.NotProved, match="the condition of the step"):
        step_of(0, 1, 0).reach(arb("0.26"))
    step_of(3, 0, 1).reach(arb(5))


def a_defect(monkeypatch: pytest.MonkeyPatch) -> Iterator[Row]:
    """Of p = 100 tau in each component, and h = 1: d = 100 + 100^2 tau^2 is the largest one."""
    monkeypatch.setattr(verify, "taylor", lambda *_: [[arb(100)]] * 6)
    step = verify.Step(body_of((3, 2, 1)), [arb(0)] * 6, arb(1), 64, verify.STATES)
    yield 100 + 10_000 / 3, step.delta, 1 + 1e-12


def off_the_derivative(_: object) -> Iterator[Row]:
    """D along a motion that stays at r, beside V: D' = (a + 2 b r) D."""
    for a, r in ((0, 0.3), (1, 0.5)):
        yield math.exp(a + 2 * r) - 1, step_of(a, 1, 0).noise_of_derivative(arb(r)), 2


def test_what_may_be_0_is_no_0():
    """Moments that may be equal, products of inertia that may be 0: the rates hold their ends."""
    x = [arb(3), arb(2), arb(1), arb("0.5"), arb(1), arb(2)]
    moments = [[2, 0, 0], [0, 2, 0], [0, 0, 1]]
    for i, j, off in ((0, 0, 0.25), (0, 1, 0.25)):
        rows = {}
        for name, by in (("all", arb(0, off)), ("one", arb(off)), ("other", arb(-off))):
            inertia = [[arb(y) for y in row] for row in moments]
            for k, n in {(i, j), (j, i)}:
                inertia[k][n] += by
            rows[name] = verify.rates(verify.Body(inertia, [arb(0)] * 3), x)
        for k in range(3):
            assert rows["all"][k].overlaps(rows["one"][k])
            assert rows["all"][k].overlaps(rows["other"][k])


#: Of a thin body about its middle axis: A is constant, and hardly less than its norm stretches.
UNSTABLE, TURNING = (1, 0.99, 0.01), [arb(x) for x in (0, 1, 0, 0, 0, 0)]


def what_a_step_stretches_and_no_v_misses(monkeypatch: pytest.MonkeyPatch) -> Iterator[Row]:
    monkeypatch.setattr(verify, "MOST_TERMS", 1)
    body = body_of(UNSTABLE)
    step = verify.Step(body, TURNING, arb(2), 64, verify.STATES)
    ctx.prec = 64
    flow = (arb_mat(verify.slope(body, TURNING)) * arb(2)).exp()
    assert step.v == [arb_mat(verify._unit())]
    for truth, bound in ((flow, step.growth), (flow - step.v[0], step.rho)):
        yield verify.row_sum(truth.table()), bound, 3


def test_norms_of_matrices():
    """The largest row sum; within a factor of it what is found by one product."""
    chance = random.Random(1)
    for _ in range(3):
        rows = [[chance.uniform(-1, 1) * bool((i + j) % 3) for j in range(6)] for i in range(6)]
        matrix = arb_mat([[arb(x) for x in row] for row in rows])
        truth = max(sum(map(abs, row)) for row in rows)
        assert float(verify.row_sum(matrix.table())) == pytest.approx(truth, rel=1e-12)
        assert truth <= verify.rough(matrix) * (1 + arb("1e-15"))
    ones = arb_mat([[arb(int(i == 2))] * 6 for i in range(6)])
    assert float(verify.rough(ones)) == pytest.approx(6, rel=1e-12)  # no smaller factor will do
    rows = ones.table()
    for some in (rows, [[row[i] for row in rows] for i in range(6)]):
        assert float(verify.steepness(some)) == pytest.approx(math.sqrt(6), rel=1e-12)


def steepness_of_all_that_motions_reach(_: object) -> Iterator[Row]:
    body, step = body_of((3, 2, 1), (0.2, 0.1, 0.3)), verify.Step.__new__(verify.Step)
    for far, r in ((3, 0), (0, 3)):  # along p, beside it
        step.p = [arb_poly([0, far]) for _ in range(6)]
        there = [arb(3)] * 6
        size = np.linalg.norm([[float(x) for x in row] for row in verify.slope(body, there)], 2)
        yield size, step.steepness(body, arb(r)), 3


@pytest.mark.parametrize(
    "rows",
    [
        off_the_linear_part,
        a_defect,
        off_the_derivative,
        what_a_step_stretches_and_no_v_misses,
        steepness_of_all_that_motions_reach,
    ],
)
def test_a_bound_of_a_step_holds_and_is_not_slack(rows, monkeypatch):
    for truth, bound, slack in rows(monkeypatch):
        assert truth <= bound * (1 + arb("1e-12"))
        assert bound < slack * truth


# -- the set --------------------------------------------------------------------------------------


def numbers(chance: random.Random, rows: int, columns: int, size: float = 1.0) -> verify.Table:
    """Exact numbers of more than a few bits."""
    return [
        [arb((round(chance.uniform(-size, size) * 2**25), -25)) for _ in range(columns)]
        for _ in range(rows)
    ]


SCALE = 100  # bits of a unit of whole numbers


def wholes(rows: verify.Table) -> Any:
    """Exact numbers as whole ones, times 2^SCALE."""
    return np.array([[int(exactly(x) * 2**SCALE) for x in row] for row in rows], dtype=object)


def reach(points: verify.Set) -> Callable[[int, Any], int]:
    """The largest u.z of a set, by column and u, times 2^(2 SCALE)."""
    m, s, w = wholes(points.m), wholes(points.s), wholes(points.w)
    return lambda column, u: (u @ m[:, column] << SCALE) + np.abs(u @ s) @ w[:, column]


def numbers_of(rows: verify.Table) -> Any:
    return np.array([[exactly(x) for x in row] for row in rows], dtype=object)


def sizes_of(rows: verify.Table) -> verify.Table:
    return [[x.abs_upper() for x in row] for row in rows]


@pytest.mark.parametrize("quiet", [False, True])
def test_a_set_of_few_bits_loses_no_point_from_step_to_step(monkeypatch, quiet):
    """By its reach in many directions, in fractions; two columns of z and one of D.

    Where all is quiet there is no noise: nothing but rounding is left out.
    """
    monkeypatch.setattr(verify, "COARSE", FEW)
    monkeypatch.setattr(verify, "GROUP", 1)
    chance = random.Random(2)
    points = verify.Set(numbers(chance, 6, 3), sizes_of(numbers(chance, 6, 3)), 2)
    axes = [np.array([int(i == j) for j in range(6)], dtype=object) for i in range(6)]
    some = [[chance.randrange(-9, 10) for _ in range(6)] for _ in range(4)]
    for _ in range(3):
        middle, centre = ([row[k] for row in numbers(chance, 6, 2)] for k in range(2))
        v = numbers(chance, 6, 6, 0.5)
        noise = [arb(0)] * 3 if quiet else [arb((k + 1, -4)) for k in range(3)]

        def at(_tau: arb, middle=middle, v=v) -> tuple[list[arb], arb_mat]:
            ctx.prec = FEW
            return middle, arb_mat(v)

        step: Any = SimpleNamespace(bits=FEW, at=at)
        here = wholes([points.sizes()])[0]
        inside = points.within(step, noise, Fraction(1))
        after = points.next(step, noise, centre)
        ctx.prec = 300
        ends = [[wholes([[x.lower(), x.upper()]])[0] for x in row] for row in inside]
        before, later = reach(points), reach(after)
        turn, off = wholes(v), wholes([noise])[0]
        there, from_there = wholes([middle])[0], wholes([centre])[0]
        for k in range(3):
            moved = int(k < points.states)  # a column of D has no centre
            for u in (*axes, *(-x for x in axes), *(np.array(x, dtype=object) for x in some)):
                by = u @ turn  # times 2^SCALE
                truth = before(k, by) + (sum(abs(u)) * off[k] << 2 * SCALE)
                jump = moved * (u @ (there - from_there))
                assert truth + (jump << 2 * SCALE) <= later(k, u) << SCALE
            for i, u in enumerate(axes):
                for sign in (1, -1):
                    truth = before(k, sign * u @ turn) + (off[k] << 2 * SCALE)
                    edge = max(sign * ends[i][k]) - moved * sign * there[i]
                    assert truth <= edge << 2 * SCALE
                    assert before(k, sign * u) <= here[k] << SCALE
        ctx.prec, points = FEW, after


def test_noise_is_that_of_the_widest_set_and_of_each_column():
    """Two sets of starts, the second one wider; columns of D of the sizes 1 and 4."""
    inertia = [[arb(x if i == j else 0) for j in range(3)] for i, x in enumerate((3, 2, 1))]
    guesses = verify.Guesses(10, [0, 128], 20, [[1 << 20] * 6], 64)
    run, wide = verify.Run(guesses, inertia, [arb("0.25")] * 3), arb((1, -10))
    columns, box = [arb(0), arb(0), arb(1), arb(4)], [arb(0), wide, arb(0), arb(0)]
    (stage,) = run.stages(verify.Set([columns] * 6, [box] * 6, 2), verify.DERIVATIVES, None)
    alone, reach = (stage.step.reach(size) for size in (arb(0), wide))
    assert alone < reach <= stage.reach
    of_d = stage.step.noise_of_derivative(reach)
    for size, noise in zip((1, 4), stage.noise[2:], strict=True):
        assert size * of_d <= noise * (1 + arb("1e-15"))


# -- sets of chaos --------------------------------------------------------------------------------


def test_the_inverse_of_a_frame_of_few_bits_holds_the_exact_one():
    rows = numbers(random.Random(6), 6, 6, 0.1)
    rows = [[x + int(i == j) for j, x in enumerate(row)] for i, row in enumerate(rows)]
    wide, deep = arb_mat([row[:2] for row in rows]), arb_mat([row[2:] for row in rows])
    exact = fmpq_mat([[rational(x) for x in row] for row in rows]).inv()
    ctx.prec = FEW
    inverse = verify._frame(verify.Chart([], wide, deep, [], arb(1)))
    assert all(inverse[i, j].contains(exact[i, j]) for i in range(6) for j in range(6))
    assert float(inverse[0, 0].rad()) < 0.1


def rational(x: arb) -> fmpq:
    value = exactly(x)
    return fmpq(value.numerator, value.denominator)


@pytest.mark.parametrize("long", ["middle", "directions"])
def test_starts_of_few_bits_hold_every_point_of_a_set(monkeypatch, long):
    """Only numbers of one part are longer than the bits: what rounding makes of it shows alone."""
    monkeypatch.setattr(verify, "COARSE", FEW)
    chance, middle = random.Random(6), long == "middle"

    def some(columns: int, is_long: bool) -> verify.Table:
        if is_long:
            return numbers(chance, 6, columns)
        return [[arb((chance.randrange(-4, 5), -2)) for _ in range(columns)] for _ in range(6)]

    centre, here = ([row[0] for row in some(1, middle)] for _ in range(2))
    wide, deep = (arb_mat(some(n, not middle)) for n in (2, 4))
    rectangle = verify.Rectangle(0, arb((3 * middle, -2)), arb((1, -1)), arb((1, -3)))
    depth = [arb((k * middle, -3)) + arb(0, arb((k, -5))) for k in range(1, 5)]
    run: Any = SimpleNamespace(bits=FEW, centres=[here])
    starts = verify._starts(run, rectangle, verify.Chart(centre, wide, deep, [], arb(1)), depth)
    ctx.prec = 300
    e, k = numbers_of(wide.table()), numbers_of(deep.table())
    (c, x), (m, *sizes) = numbers_of([centre, here]), [exactly(y) for y in rectangle[1:]]
    off = c - x + e[:, 0] * m + k @ np.array([exactly(y.mid()) for y in depth])
    sizes += [exactly(y.rad()) for y in depth]
    reached, frame = reach(starts), np.hstack([e, k])
    axes = np.array([[int(i == j) for j in range(6)] for i in range(6)], dtype=object)
    for u in (*axes, *-axes):
        truth = u @ off + np.abs(u @ frame) @ np.array(sizes)
        assert truth * 4**SCALE <= reached(0, u) < (truth + Fraction(1, 8)) * 4**SCALE


# -- motions through a box ------------------------------------------------------------------------


def test_all_that_motions_through_a_box_reach_is_around_it():
    """Beside an unstable rotation the speed grows on the way; for long it has no bound."""
    body, span, off = body_of(UNSTABLE), 0.5, 1e-6
    box = [x + arb(0, off) for x in TURNING]
    with pytest.raises(verify.NotProved, match="has no bound"):
        verify.around(body, box, arb(3))
    reached = verify.around(body, box, arb(span))
    flow = (arb_mat(verify.slope(body, TURNING)) * arb(span)).exp()
    far = verify.row_sum(flow.table()[:3]) * off
    for i in (0, 2):
        assert far * arb("0.99") < reached[i].abs_upper() < 3 * far
    drift = verify.drift(body, reached, arb(span))
    assert verify.row_sum((flow - arb_mat(verify._unit())).table()) < drift


def test_a_derivative_near_a_time_drifts_by_its_columns_sizes():
    """D(t) = Phi D: an entry that is 0 is moved by the others of its column."""
    d = [[arb(0), arb(1)], [arb(3), arb(0)]]
    rows = verify.around_in_time(d, arb("0.5"))
    assert [[float(x.rad()) for x in row] for row in rows] == [
        [pytest.approx(1.5), pytest.approx(0.5)]
    ] * 2


# -- numbers that are told ------------------------------------------------------------------------


def test_an_interval_is_a_ball_around_all_of_it():
    ball = verify.ball((Fraction(1, 3), Fraction(1, 7)))
    assert ball.contains(fmpq(1, 3) + fmpq(1, 7))
    assert ball.contains(fmpq(1, 3) - fmpq(1, 7))


@pytest.mark.parametrize(
    ("residue", "kinds"),
    [
        ("-1", ["hyperbolic"]),
        ("0.5", ["elliptic"]),
        ("2", ["inverse hyperbolic"]),
        ("0 +/- 0.1", []),
        ("1 +/- 0.1", []),
    ],
)
def test_a_kind_is_one_of_every_residue_in_the_ball(residue, kinds):
    tests = verify.STABILITY.items()
    assert [kind for kind, test in tests if test(arb(residue)) is True] == kinds

"""Polynomials as single integers: exact there, and back to doubles right to a few roundings."""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from flint import fmpz, fmpz_poly

from polhode.enclosures import (
    fixed_point_problem,
    quaternion,
    step_bound,
    task,
    taylor_polynomials,
    zonotope,
)
from polhode.enclosures.fixed_point_problem import TooImprecise
from polhode.enclosures.taylor_polynomials import Packing
from shared import enclosures as trials

CYCLE = ((1, 2), (2, 0), (0, 1))

EDGES = (0, 1, -1, 2**62 - 1, -(2**62), 2**32, -(2**32), 2**32 - 1, 2**63 - 1, -(2**63))


def _drawn(rng: random.Random, count: int) -> list[int]:
    return [rng.choice((*EDGES, rng.randrange(-(2**63), 2**63))) for _ in range(count)]


def test_a_polynomial_and_its_slope_are_their_values_at_a_power_of_two() -> None:
    rng = random.Random(1)
    for _ in range(100):
        count, words = rng.randrange(2, 20), rng.randrange(1, 6)
        packs = Packing(count, words)
        rows = [_drawn(rng, count) for _ in range(3)]
        at = fmpz(1) << (64 * words)
        for row, x in zip(rows, packs.values(np.array(rows)), strict=True):
            assert x == fmpz_poly(row)(at)
            assert packs.slope(x) == fmpz_poly(row).derivative()(at)
        most = 2 ** (64 * words - 1) - 1
        row = [rng.choice((most, -most, 0, rng.randrange(-most, most))) for _ in range(count)]
        assert packs.slope(fmpz_poly(row)(at)) == fmpz_poly(row).derivative()(at)


def test_unpacked_is_right_relatively_or_refused() -> None:
    rng, worst = random.Random(3), 0.0
    allowed = Fraction(step_bound.gamma(taylor_polynomials.UNPACKED))
    for _ in range(60):
        count, words = rng.randrange(1, 6), rng.randrange(1, 6)
        most = 2 ** (64 * words - 1) - 1
        sizes = (rng.randrange(64 * words) for _ in range(count))
        row = [rng.choice((-1, 1)) * rng.choice((most, rng.randrange(1 << n))) for n in sizes]
        power = rng.randrange(-900, 100)
        value = fmpz_poly(row)(fmpz(1) << (64 * words))
        (unpacked,) = Packing(count, words).doubles([value], np.array([power]))
        for x, y in zip(row, unpacked, strict=True):
            true, near = Fraction(x) * Fraction(2) ** power, Fraction(float(y))
            assert abs(near - true) <= allowed * abs(true)
            worst = max(worst, float(abs(near / true - 1) / allowed) if x else 0.0)
    assert worst > 0.05
    # numbers beyond the doubles
    value = fmpz_poly([1 << 100])(fmpz(1) << 128)
    with pytest.raises(TooImprecise):
        Packing(1, 2).doubles([value], np.array([1000]))
    (last,) = Packing(1, 2).doubles([fmpz(1)], np.array([1023]))
    assert last[0] == 2.0**1023


def _shapes(kind: str, bits: int | None, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Polynomials of a window at all levels that its corrections go through."""
    motion = fixed_point_problem.motion(trials.random_scene(random.Random(5), kind))
    problem, shapes = fixed_point_problem.problem(motion, 200, bits), list[Any]()
    defects = taylor_polynomials.defects
    with monkeypatch.context() as patch:
        patch.setattr(taylor_polynomials, "defects", lambda *x: shapes.append(x[1]) or defects(*x))
        task._window(problem, zonotope.beginning(problem), 9 << 14, 3, 0.3, task.HONEST)
    return problem, shapes


@pytest.mark.parametrize(("kind", "bits"), [("generic", None), ("generic", 212), ("needle", None)])
def test_defects_are_those_of_exact_polynomials(
    kind: str, bits: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem, shapes = _shapes(kind, bits, monkeypatch)
    assert len(shapes) >= 3
    assert [len(shape.parts) for shape in shapes] == [*range(1, len(shapes) + 1)]
    for shape in shapes:
        defects = taylor_polynomials.defects(problem, shape)
        unit = Fraction(2) ** (problem.noise - 2 * shape.level)
        for n in range(shape.count):
            row = shape.polynomials(n)
            h = Fraction(shape.times[n + 1] - shape.times[n], 1 << fixed_point_problem.CLOCK)
            assert [x(1) for x in row] == shape.ends[n].tolist()
            assert [x[0] for x in row] == shape.starts[n].tolist()
            for i, (a, b) in enumerate(CYCLE):
                bend, pull, push = (problem.constants[n] for n in (i, 3 + 2 * i, 4 + 2 * i))
                rate = row[a] * row[b] * bend
                rate += (row[3 + a] * pull + row[3 + b] * push) * (fmpz(1) << shape.level)
                turning = row[3 + a] * row[b] - row[3 + b] * row[a]
                for k, part, below in ((i, rate, problem.denominators[i]), (3 + i, turning, 1)):
                    steep = row[k].derivative() * (fmpz(1) << shape.level)
                    for j in range(defects.values.shape[1]):
                        true = (int(steep[j]) - h * int(part[j]) / below) * unit
                        off = abs(true - Fraction(float(defects.values[n, j, k])))
                        assert off <= Fraction(step_bound.gamma(defects.roundings)) * abs(true)


def test_words_hold_the_largest_coefficient_and_no_word_is_spare(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # Coefficients of one sign and steep polynomials come near the bound; a word less loses them.
    times = (0, 1 << fixed_point_problem.CLOCK)
    near = np.zeros((1, 3, 6))
    near[0, 0] = [2.0**20, 2.0**20, -(2.0**20), 2.0**20, 2.0**20, -(2.0**20)]
    shape = taylor_polynomials.of_doubles(times, near)
    factors: dict[str, Any] = {"slack": (0.0,) * 9, "factors": (1.0,) * 9}
    start: dict[str, Any] = {"factor_slack": (0.0,) * 9, "start": (0,) * 6, "spread": (0.0,) * 6}
    constants = (1 << 76, 1, 1, 0, 0, 0, 0, 0, 0)
    problem = fixed_point_problem.Problem(60, 72, constants, (1, 1, 1), **factors, **start)
    words = taylor_polynomials._words(problem, shape)
    true = -float(1 << 76) * -(2.0**40) * 2.0**60
    assert taylor_polynomials.defects(problem, shape).values[0, 0, 0] == true
    top = (1 << (76 + 14 + 40 + 2 * shape.level)).bit_length() + 1
    assert top <= 64 * words
    monkeypatch.setattr(taylor_polynomials, "_words", lambda *_: words - 1)
    with pytest.raises((OverflowError, AssertionError)):
        assert taylor_polynomials.defects(problem, shape).values[0, 0, 0] == true


def _steep(rows: int, size: float) -> taylor_polynomials.Pieces:
    """Polynomials of one step with three coefficients of one size."""
    near = np.full((1, 3, rows), size)
    near[0, :, 0] *= -1.0
    return taylor_polynomials.of_doubles((0, 3 << fixed_point_problem.CLOCK), near, rows)


def _turn_is_exact(size: float) -> bool:
    """Whether the defect of a turn, and its coefficients, are those of exact polynomials."""
    w, v = _steep(3, size), _steep(4, 2.0 * size)
    near, values, _ = quaternion.defects(w, v, 90)
    unit = Fraction(2) ** (90 - w.level - v.level)
    x, y = v.polynomials(0), w.polynomials(0)
    pairs, allowed = [], Fraction(step_bound.gamma(taylor_polynomials.UNPACKED))
    for i, terms in enumerate(quaternion.PRODUCT):
        turning = sum((x[a] * y[b] * sign for sign, a, b in terms), fmpz_poly([]))
        steep = x[i].derivative() * (fmpz(1) << w.level)
        for k in range(5):
            true = (int(steep[k]) - Fraction(3, 2) * int(turning[k])) * unit
            pairs.append((true, Fraction(values[0, k, i])))
        pairs += [(Fraction(int(x[i][k]), 1 << v.level), Fraction(near[0, k, i])) for k in range(3)]
    return all(abs(exactly - near_it) <= allowed * abs(exactly) for exactly, near_it in pairs)


def test_the_defect_of_a_turn_is_that_of_exact_polynomials() -> None:
    assert all(_turn_is_exact(2.0**k) for k in range(-20, 20))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_sum_of_the_moduli_holds_what_corrections_have_added(sign: float) -> None:
    shape = taylor_polynomials.of_doubles((0, 1), np.full((1, 8, 6), sign * 64.0))
    shape = taylor_polynomials.improved(shape, np.full((1, 8, 6), sign * 32.0), 0, shape.level)
    true = sum(abs(int(x)) for x in shape.polynomials(0)[0].coeffs()) / 2.0**shape.level
    assert true == 8 * 96.0 <= shape.most <= true + 2
    assert shape.ends[0, 0] == sign * true * 2.0**shape.level

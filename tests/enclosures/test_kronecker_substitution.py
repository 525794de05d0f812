"""Polynomials as single integers: exact there, and back to doubles right to a few roundings."""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from flint import fmpz, fmpz_poly

from polhode.enclosures import (
    defect,
    fixed_point_problem,
    kronecker_substitution,
    proof_loop,
    step_bound,
    taylor_polynomials,
    zonotope,
)
from polhode.enclosures.fixed_point_problem import Refused
from polhode.enclosures.kronecker_substitution import MOST_FACTOR, Double
from shared import enclosure_trials as trials
from shared.mutation import without

EDGES = (0, 1, -1, 2**62 - 1, -(2**62), 2**32, -(2**32), 2**32 - 1, 2**63 - 1, -(2**63))
CARRIED = 0x55555555FFFFFFFF  # times 3, the product of its lower half decides the upper word
WIDE = (*EDGES, CARRIED, 2**64, -(2**64), 2**64 - 1, 2**114 - 1, -(2**114), 2**96 + 2**32)


def _of(integers: list[list[int]]) -> Double:
    low = np.array([[x & (2**64 - 1) for x in row] for row in integers], dtype=np.uint64)
    return Double(np.array([[x >> 64 for x in row] for row in integers], dtype=np.int64), low)


def _drawn(rng: random.Random, count: int) -> list[int]:
    return [rng.choice((*WIDE, rng.randrange(-(2**114), 2**114))) for _ in range(count)]


def test_packed_is_the_value_of_the_polynomial() -> None:
    rng = random.Random(1)
    for _ in range(100):
        count, words = rng.randrange(1, 9), rng.randrange(2, 6)
        rows = [_drawn(rng, count) for _ in range(3)]
        factors = [rng.choice((0, 1, 7, MOST_FACTOR, rng.randrange(MOST_FACTOR))) for _ in rows[0]]
        at = fmpz(1) << (64 * words)
        plain = kronecker_substitution.packed(_of(rows), words)
        risen = kronecker_substitution.packed(_of(rows), words, np.array(factors))
        for row, x, y in zip(rows, plain, risen, strict=True):
            assert x == fmpz_poly(row)(at)
            assert y == fmpz_poly([a * b for a, b in zip(row, factors, strict=True)])(at)


def test_sums_of_words_are_exact() -> None:
    rng = random.Random(2)
    for _ in range(100):
        shift = rng.randrange(1, 64)
        most = 2 ** (125 - shift)
        old = [rng.choice((most, -most, rng.randrange(-most, most), *EDGES[:8])) for _ in range(9)]
        old = [x if abs(x) <= most else 0 for x in old]
        new = np.array([[rng.choice(EDGES) for _ in old]], dtype=np.int64)
        found = kronecker_substitution.shifted_sum(_of([old]), shift, new)
        true = [(x << shift) + y for x, y in zip(old, new[0].tolist(), strict=True)]
        assert found.integers().tolist() == [true]
        assert kronecker_substitution.double(new).integers().tolist() == new.tolist()
        kept = _of([[x >> 12 for x in true]])
        assert kept.total().tolist() == [sum(x >> 12 for x in true)]


def test_unpacked_is_right_relatively() -> None:
    rng, worst = random.Random(3), 0.0
    allowed = Fraction(step_bound.gamma(kronecker_substitution.UNPACKED))
    for _ in range(60):
        count, words = rng.randrange(1, 6), rng.randrange(1, 6)
        most = 2 ** (64 * words - 1) - 1
        sizes = (rng.randrange(64 * words) for _ in range(count))
        row = [rng.choice((-1, 1)) * rng.choice((most, rng.randrange(1 << n))) for n in sizes]
        power = rng.randrange(-900, 100)
        value = fmpz_poly(row)(fmpz(1) << (64 * words))
        (found,) = kronecker_substitution.unpacked([value], count, words, np.array([power]))
        for x, y in zip(row, found, strict=True):
            true, near = Fraction(x) * Fraction(2) ** power, Fraction(float(y))
            assert abs(near - true) <= allowed * abs(true)
            worst = max(worst, float(abs(near / true - 1) / allowed) if x else 0.0)
    assert worst > 0.05


FAULTS = [
    ("packed", " + (((low & _LOW) * by) >> _32)", ""),
    ("packed", "high * by + carried", "high * by"),
    ("shifted_sum", "+ carried", ""),
    ("shifted_sum", " + (values >> 63)", ""),
    ("shifted_sum", " + (x.low >> (_64 - by)).astype(np.int64)", ""),
    ("unpacked", "found = np.ldexp(negative.astype(float), powers[:, None])", "found = 0.0"),
    ("unpacked", "~np.uint64(0)", "np.uint64(0)"),
    ("unpacked", "word = word ^ _HALF", "pass"),
    ("unpacked", "-found, found", "found, found"),
]
TESTS = {
    "packed": test_packed_is_the_value_of_the_polynomial,
    "shifted_sum": test_sums_of_words_are_exact,
    "unpacked": test_unpacked_is_right_relatively,
}


@pytest.mark.parametrize(("name", "old", "new"), FAULTS)
def test_a_fault_in_the_words_is_noticed(name: str, old: str, new: str) -> None:
    with without(kronecker_substitution, name, old, new), pytest.raises(AssertionError):
        TESTS[name]()


def test_numbers_beyond_the_doubles_are_refused() -> None:
    value = fmpz_poly([1 << 100])(fmpz(1) << 128)
    with pytest.raises(Refused):
        kronecker_substitution.unpacked([value], 1, 2, np.array([1000]))
    (last,) = kronecker_substitution.unpacked([fmpz(1)], 1, 2, np.array([1023]))
    assert last[0] == 2.0**1023


def _shapes(kind: str, bits: int | None, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Polynomials of a window at all levels that its corrections go through."""
    motion = fixed_point_problem.motion(trials.random_scene(random.Random(5), kind))
    problem, found = fixed_point_problem.problem(motion, 200, bits), list[Any]()
    defects = defect.defects
    with monkeypatch.context() as patch:
        patch.setattr(defect, "defects", lambda *x: found.append(x[1]) or defects(*x))
        proof_loop._window(problem, zonotope.beginning(problem), 9 << 14, 3, 0.3, proof_loop.HONEST)
    return problem, found


@pytest.mark.parametrize(("kind", "bits"), [("generic", None), ("generic", 212), ("needle", None)])
def test_defects_are_those_of_exact_polynomials(
    kind: str, bits: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem, shapes = _shapes(kind, bits, monkeypatch)
    assert len(shapes) >= 3
    assert len(shapes[1].parts) == 1  # two words still hold it
    assert len(shapes[-1].parts) > 1
    for shape in shapes:
        known = defect.defects(problem, shape)
        unit = Fraction(2) ** (problem.noise - 2 * shape.level)
        for n, row in enumerate(shape.rows):
            h = Fraction(shape.times[n + 1] - shape.times[n], 1 << fixed_point_problem.CLOCK)
            assert [x(1) for x in row] == shape.ends[n].tolist()
            assert [x[0] for x in row] == shape.starts[n].tolist()
            for i, (a, b) in enumerate(fixed_point_problem.CYCLE):
                bend, pull, push = problem.constants[i::3]
                rate = row[a] * row[b] * bend
                rate += (row[3 + a] * pull + row[3 + b] * push) * (fmpz(1) << shape.level)
                turned = row[3 + a] * row[b] - row[3 + b] * row[a]
                for k, part, below in ((i, rate, problem.denominators[i]), (3 + i, turned, 1)):
                    steep = row[k].derivative() * (fmpz(1) << shape.level)
                    for j in range(known.values.shape[1]):
                        true = (int(steep[j]) - h * int(part[j]) / below) * unit
                        off = abs(true - Fraction(float(known.values[n, j, k])))
                        assert off <= Fraction(step_bound.gamma(known.roundings)) * abs(true)


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
    words = defect._words(problem, shape)
    true = -float(1 << 76) * -(2.0**40) * 2.0**60
    assert defect.defects(problem, shape).values[0, 0, 0] == true
    top = (1 << (76 + 14 + 40 + 2 * shape.level)).bit_length() + 1
    assert top <= 64 * words
    monkeypatch.setattr(defect, "_words", lambda *_: words - 1)
    with pytest.raises((OverflowError, AssertionError)):
        assert defect.defects(problem, shape).values[0, 0, 0] == true

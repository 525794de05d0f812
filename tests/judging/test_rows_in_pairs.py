"""Rows of a closed form as sums of two doubles: the digits that exact numbers give."""

import math
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.judging import score
from polhode.numbers import double_double
from polhode.numbers.double_double import binary_numbers, of_balls, of_cells
from polhode.numbers.mpmath_context import mpf
from polhode.scenes.vocabulary import ATTITUDE

F = Fraction
CASES = ("euler/largest-axis", "lagrange/nutation", "euler/tiny-units")
HELD = {"number": "extended"}  # what the cells are held to: 26 digits are asked for


def table(case):
    """Right to different digits row by row, one cell empty, one huge; the sign of q is free."""
    reference = polhode.reference(case)
    times = [F(k) / 7 / F(10.0**reference.scene.log10_rate) for k in range(9)]
    states, turns = reference.at(times, 40), reference.attitude(times, 40)
    rows = zip(states, turns, strict=True)
    cells = [
        [x * (1 + F(1, 10 ** (4 + 2 * k))) for x in exact(state)] + [-x for x in exact(turn)]
        for k, (state, turn) in enumerate(rows)
    ]
    cells[3][1], cells[5][4] = None, F(10) ** 6
    names = [*reference.scene.columns, *ATTITUDE]
    return {"t": times} | dict(zip(names, map(list, zip(*cells, strict=True)), strict=True))


def exact(row):
    return [F(*x.as_integer_ratio()) if isinstance(x, float) else fraction(x) for x in row]


def fraction(x):
    sign, mantissa, exponent, _ = x._mpf_
    return (-1) ** sign * int(mantissa) * F(2) ** exponent


@pytest.mark.parametrize("case", CASES)
def test_the_digits_are_those_of_exact_numbers(case, monkeypatch):
    columns = table(case)
    in_pairs = polhode.compare(columns, case, as_it_stands=True, **HELD)
    assert isinstance(in_pairs.comparison.answers.rows("at", 20), double_double.Pairs)
    monkeypatch.setattr(double_double, "DIGITS", 0)
    exactly = polhode.compare(columns, case, as_it_stands=True, **HELD)
    assert isinstance(exactly.comparison.answers.rows("at", 20), list)
    assert max(d for d in exactly.digits if d is not None) > 15
    for name, digits in exactly.part_digits.items():
        assert in_pairs.part_digits[name] == pytest.approx(digits, abs=1e-9)


@pytest.mark.parametrize("size", [F(10) ** 400, F(1.7e308), -F(1e302)])
@pytest.mark.parametrize("column", ["q", "gamma2", "q1"])
def test_a_number_beyond_doubles_or_just_below_is_judged(size, column):
    """One of 1e301 and more has no product in doubles: it was passed over as an empty cell."""
    case = "lagrange/nutation"
    columns = table(case)
    columns[column][2] = size
    found = polhode.compare(columns, case, as_it_stands=True, **HELD)
    digits = found.part_digits["attitude"] if column == "q1" else found.digits
    assert digits[2] == 0
    assert digits[8] > 15


def test_sizes_that_pairs_do_not_hold_are_asked_for_as_numbers(monkeypatch):
    monkeypatch.setattr(score, "_LEAST", 1e3)  # radians a second
    found = polhode.compare(table(CASES[0]), CASES[0], as_it_stands=True, **HELD)
    assert isinstance(found.comparison.answers.rows("at", 20), list)
    assert max(d for d in found.digits if d is not None) > 15


def test_pairs_of_balls_and_cells_are_within_their_digits():
    from flint import arb

    from polhode.numbers.flint_context import ctx

    with ctx.workprec(200):
        pairs = of_balls([[arb(1) / 3, arb(2).sqrt()]])
        for x, wanted in zip(*binary_numbers(pairs), [F(1, 3), None], strict=True):
            if wanted is not None:
                assert abs(fraction(x) - wanted) < wanted / 10**31
    cells = of_cells([F(1, 3), None, 0.1, mpf(2)])
    assert math.isnan(cells.hi[1])
    assert abs(F(cells.hi[0]) + F(cells.lo[0]) - F(1, 3)) < F(1, 10**31)
    assert (cells.hi[2], cells.lo[2], cells.hi[3]) == (0.1, 0, 2)
    with pytest.raises(ValueError, match="not a finite number"):
        of_cells([0.5, float("inf")])
    assert np.isnan(of_cells([None]).hi).all()

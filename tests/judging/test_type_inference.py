"""Of which type somebody's numbers are, and what a judgement says of them then."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.judging.tables.type_inference import type_of
from polhode.numbers.number_types import DOUBLE, EXTENDED, SINGLE, extended_here

CASE, AT = "lagrange/nutation", [1, 2, 3]


@pytest.fixture(scope="module")
def states():
    return np.array(polhode.integrate(CASE, at=AT).states)


@pytest.mark.parametrize(
    ("parts", "number"),
    [
        ([[0.5, 1.5]], DOUBLE),
        ([(0.5, 1)], DOUBLE),
        ([np.array([0.5]), [1, None]], DOUBLE),
        ([np.array([0.5], dtype=object)], DOUBLE),
        ([np.array([1, 2])], None),
        ([[Fraction(1, 2), 0.5]], None),
        ([["0.5"]], None),
        ([iter([0.5])], None),
        ([np.array([0.5], dtype=np.float32)], SINGLE),
        ([[np.float32(0.5), 0.5]], DOUBLE),
        ([np.array([0.5], dtype=np.longdouble), [0.5]], EXTENDED),
        ([np.array([0.5], dtype=np.float16)], None),
        ([], None),
    ],
)
def test_the_widest_type_of_the_cells(parts, number):
    assert type_of(parts) == number


def test_rows_of_floats_are_doubles_however_they_are_held(states):
    """A list of floats, of arrays, an array of objects, a generator; columns with integer times."""
    ways = [
        [[float(x) for x in row] for row in states],
        [*states],
        states.astype(object),
        (row for row in states),
    ]
    for rows in ways:
        found = polhode.compare(rows, CASE, at=AT)
        assert (found.subject.number, found.limit) == (DOUBLE, "rounding")
    columns = {"t": np.array(AT)} | {
        name: [*column] for name, column in zip(polhode.load(CASE).columns, states.T, strict=True)
    }
    assert polhode.compare(columns, CASE).subject.number == DOUBLE


def test_single_precision_limits_what_is_held_in_it(states):
    found = polhode.compare(states.astype(np.float32), CASE, at=AT)
    assert found.subject.number == SINGLE
    assert 7 < found.worst <= SINGLE.most_digits < 7.3
    assert found.limit == "rounding"
    assert "expected in single" in str(found)
    with pytest.raises(polhode.BadInput, match="number = single"):
        polhode.integrate(CASE, number=SINGLE)


@pytest.mark.skipif(not extended_here(), reason="long double is another type here")
def test_doubles_kept_as_long_doubles_are_short_of_digits(states):
    found = polhode.compare(states.astype(np.longdouble), CASE, at=AT)
    assert found.subject.number == EXTENDED
    assert found.limit.startswith("method")


def test_exact_rows_are_of_no_type(states):
    found = polhode.compare([[Fraction(float(x)) for x in row] for row in states], CASE, at=AT)
    assert found.subject.number.name == "mp"

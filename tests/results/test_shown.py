"""Tables as a terminal shows them: rounded as their columns say, never beyond what is known."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from polhode.numbers.decimals import Ball
from polhode.numbers.exact import sqrt
from polhode.results.cells import header_and_rows, lines
from polhode.results.table import Column, Table

THIRD = Fraction(1, 3)


@pytest.mark.parametrize(
    ("column", "shown"),
    [
        (Column("x", [0.1, float("nan"), -2.5e-9]), ["0.1", "", "-2.5e-09"]),
        (Column("x", np.array([1 / 3, 0.0]), digits=17), ["0.33333333333333331", "0"]),
        (Column("x", [1.0, None], digits=17), ["1.0000000000000000", ""]),
        (Column("x", [THIRD, Fraction(1, 8), Fraction(3)], digits=15), ["1/3", "0.125", "3"]),
        (Column("x", [Fraction(10**8, 10**7 + 1), Fraction(1, 3 * 10**9)]), ["10", "3.33333e-10"]),
        (Column("x", [Fraction(1, 10**7), None], type="exact"), ["1e-07", ""]),
        (Column("x", [sqrt(Fraction(2))], digits=12), ["1.41421356237"]),
        (Column("x", np.array([1], np.longdouble), digits=5), ["1.0000"]),
        (Column("x", [Ball(THIRD, 1e-4), None]), ["0.333", ""]),
        (Column("x", [3, 10**6]), ["3", "1000000"]),
        (Column("x", [True, False]), ["true", "false"]),
        (Column("x", ["a", ""]), ["a", ""]),
    ],
)
def test_cells_are_rounded_and_empty_where_there_is_no_number(column, shown):
    assert header_and_rows(Table([column])) == (["x"], [[x] for x in shown])


def test_a_column_of_no_digits_is_not_shown_and_no_rows_are_a_header():
    table = Table([Column("x", [1.5]), Column("y", [2.5], digits=0), Column("z", ["u\x1b"])])
    assert lines(table) == ["x    z", "1.5  u?"]
    assert lines(Table([Column("x", []), Column("name", [], type="text")])) == ["x  name"]

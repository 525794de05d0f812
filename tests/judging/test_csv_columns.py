"""Cells of a file: as exact decimals, rounded once, whatever way is taken."""

from __future__ import annotations

import random
import re
from fractions import Fraction

import pytest

from polhode.judging.tables.csv_file import most_printed, value
from polhode.judging.tables.table import degree
from polhode.judging.tables.table_file import read_table
from polhode.numbers import expression
from polhode.numbers.number_types import DOUBLE, EXTENDED, NumberType

ODD = ["0", "-0.0", "1.", ".5", "+2e3", "1e-310", "4.9e-324", "1e308", "1e400", "-1E-400", "0e300"]
HALFWAY = "1.00000000000000011102230246251565404236316680908203125"  # 1 + 2**-53


def printed(count: int) -> list[str]:
    draw = random.Random(5)
    forms = ("%.17g", "%.16e", "%.3f", "%.20f", "%+.12g")
    return [
        draw.choice(forms) % (draw.gauss(0, 1) * 10 ** draw.uniform(-12, 9)) for _ in range(count)
    ]


@pytest.mark.parametrize("number", [DOUBLE, EXTENDED, NumberType("mp", 53)])
def test_a_cell_is_its_decimal_rounded_once(number):
    cells = [*printed(2000), *ODD, HALFWAY, HALFWAY + "1", "0." + "3" * 70, "1_000.5"]
    for cell in cells:
        decimal = expression.decimal(cell)
        assert value(cell, number) == number.rounded(decimal)


def test_the_most_significant_digits():
    def significant(cell: str) -> int:
        digits = re.sub("[^0-9]", "", re.split("[eE]", cell)[0]).lstrip("0")
        return max(1, len(digits))

    cells = [*printed(500), "-0.00120", "100.", "1e-30", "+12345678901234567890.5", "0"]
    for k in range(1, len(cells)):
        assert most_printed([cells[:k]]) == max(map(significant, cells[:k]))


def test_a_unit_multiplies_the_decimal_and_not_its_double(tmp_path):
    path = tmp_path / "degrees.csv"
    path.write_text("t,p [deg/s]\n0,0.123456789012345678\n")
    (cell,) = read_table(path).columns["p"]
    assert cell == Fraction("0.123456789012345678") * degree()

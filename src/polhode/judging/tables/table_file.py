"""Tables in files of any kind, told by their ending."""

from __future__ import annotations

from pathlib import Path

from polhode.judging.tables.array_file import ENDINGS, read_arrays
from polhode.judging.tables.csv_file import read_csv
from polhode.judging.tables.naming import PLAIN, Naming
from polhode.judging.tables.table import Table
from polhode.numbers.number_types import NumberType


def read_table(path: Path, number: NumberType | None = None, names: Naming = PLAIN) -> Table:
    """A file as a table; raises BadInput.

    ``number``: the type of its numbers, where that is known.  ``names``: columns that were named
    beside it.
    """
    read = read_arrays if path.suffix.lower() in ENDINGS else read_csv
    return read(path, number, names)

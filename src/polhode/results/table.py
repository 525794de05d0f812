"""What a result tells of itself: the columns of a table, and facts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

#: A number of any type, a text, a truth, or None.
Value: TypeAlias = Any

#: The numbers, texts or truths of a column.
Values: TypeAlias = "Sequence[Value] | npt.NDArray[np.generic]"

#: What a file tells besides facts: no fact has one of these names.
RESERVED = ("format", "result", "version", "title", "labels", "about", "columns", "sha256")


class Column(NamedTuple):
    """A column of a table: its name, its values, and what they mean.

    ``type``: a word of :mod:`polhode.results.cells`, needed where the values do not tell it: for
    mpf, and where there are none.  ``digits``: significant digits on a terminal; 0: not shown
    there.
    """

    name: str
    values: Values
    meaning: str = ""
    unit: str = ""
    type: str = ""
    digits: int = 6


class Table(NamedTuple):
    """Columns of one length; the first ``labels`` of them tell the rows apart."""

    columns: Sequence[Column]
    labels: int = 1

    @property
    def rows(self) -> int:
        """How many rows there are."""
        return len(self.columns[0].values) if self.columns else 0


def table_of_rows(
    types: Mapping[str, str], rows: Sequence[Sequence[Value]], labels: int = 1
) -> Table:
    """A table of rows, of which there may be none.

    ``types``: the columns' names, and the words for their types.
    """
    columns = zip(*rows, strict=True) if rows else [()] * len(types)
    typed = zip(types.items(), columns, strict=True)
    return Table([Column(name, x, type=word) for (name, word), x in typed], labels)


class Fact(NamedTuple):
    """A named value of a result.

    ``value``: a number, a text, a truth, None, a list of one of these, a :class:`Table`, or a small
    object of plain values, three deep, such as the provenance.  ``type``: as of a column.
    """

    name: str
    value: Value
    meaning: str = ""
    unit: str = ""
    type: str = ""


class Content(NamedTuple):
    """What a file of a result holds: its kind, the version that wrote it, its line, and the rest.

    ``title``: what the result's ``repr`` says.
    """

    kind: str
    version: str
    title: str
    table: Table
    facts: Sequence[Fact]

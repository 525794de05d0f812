"""Two kinds of results that nobody computes: with every type of value, and with hardly any."""

import math
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from unittest import mock

import mpmath
import numpy as np
import pytest

from polhode import Result
from polhode.common.files import write_whole
from polhode.numbers import expression
from polhode.results import reader, writer
from polhode.results.table import Column, Content, Fact, Table

ROOT = expression.number("sqrt(2)")
TEXTS = ['a,"b"\nc', "", "é#;", "c\rd"]


class Odd(Result):
    """Columns of every type, with what no file format likes, of so many rows."""

    def __init__(self, rows: int = 4) -> None:
        self.rows = rows

    def __repr__(self) -> str:
        return f"<Odd of {self.rows}>"

    def table(self) -> Table:
        """All types, gaps, infinities."""
        with mpmath.workprec(200):
            wide = [mpmath.mpf(1) / 3, None, mpmath.mpf("1e-300"), mpmath.mpf("-inf")]
        exact = [Fraction(1, 3), None, Fraction(5, 2), Fraction(10**40 + 1)]
        extended = np.array([1, np.nan, np.inf, 5], dtype=np.longdouble) / 3
        columns = (
            Column("k", np.arange(4), "the row"),
            Column("x", np.array([np.inf, np.nan, -0.0, 5.0]), "a number", "m", digits=3),
            Column("y", [1, None, -math.inf, 1e-310]),
            Column("a name, quoted", TEXTS),
            Column("ok", np.array([True, False, True, True])),
            Column("e", exact),
            Column("wide", wide, type="200 bits", digits=0),
            Column("extended", extended),
            Column("root", [ROOT, None, ROOT, ROOT]),
            Column("large", [1, 2**53, -(2**60), 0]),
        )
        return Table([x._replace(values=x.values[: self.rows]) for x in columns])

    def facts(self) -> Sequence[Fact]:
        """All types, none, lists, tables, an object."""
        inner = (Column("u", np.zeros(0)), Column("v", [], "nothing", "s", "text", 0))
        marks = (Column("mark", [1, 2]), Column("h", [Fraction(1, 3), None], unit="J"))
        return [
            Fact("count", 1, "how many"),
            Fact("whole double", 2.0),
            Fact("infinite", math.inf),
            Fact("none", None),
            Fact("not a number", math.nan),
            Fact("text", 'two\nlines, "quoted" é\ud800', unit="words"),
            Fact("root", ROOT, "an irrational number", "m"),
            Fact("told root", ROOT, type="20 digits"),
            Fact("exact", Fraction(3)),
            Fact("truth", True),
            Fact("large", 2**70),
            Fact("integers", [1, 2]),
            Fact("texts", ["x", ""]),
            Fact("no list", []),
            Fact("gaps", [None, 2.5]),
            Fact("empty", Table(inner)),
            Fact("marks", Table(marks, 1)),
            Fact("provenance", {"versions": {"a": "1"}, "notes": ["x", 5, math.inf, None]}),
        ]


class Bare(Result):
    """One column of gaps, and no facts."""

    def __repr__(self) -> str:
        return "<Bare>"

    def table(self) -> Table:
        """Of three rows, of which one has a number."""
        return Table([Column("x", [None, 1.5, None])], 0)

    def facts(self) -> Sequence[Fact]:
        """None."""
        return ()


KINDS = ("Odd", "Bare")
ENDINGS = (".csv", ".json", ".npz", ".parquet")


def written(content: Content, path: Path) -> dict[Path, bytes]:
    """The files of a content, each with its place, as they are written there."""
    if path.suffix == ".parquet":
        pytest.importorskip("pyarrow")
    files = writer.files(content, path)
    write_whole(files)
    return files


def facts_beside(path: Path) -> Path:
    """The file of the facts of a table."""
    return path.with_name(f"{path.name}.json")


def content_at(path: Path) -> Content:
    """What a file of one of them says."""
    with mock.patch.object(reader, "KINDS", KINDS):
        return reader.content_of(path)


def read(content: Content, path: Path) -> Content:
    """A content that was written there and read again."""
    written(content, path)
    return content_at(path)

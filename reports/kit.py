"""What studies share: numbers, the rows that are wanted, tables, words, a page, and figures."""

from __future__ import annotations

import math
import re
import statistics
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias, TypeVar

import numpy as np

import polhode
from polhode.common.files import write_whole
from polhode.common.processes import cores, in_order
from polhode.numbers.number_types import DEFAULT_MP_DIGITS, NAMES, named

if TYPE_CHECKING:
    from matplotlib.axes import Axes as Axes

#: Keys, and what JSON can hold.
JsonObject: TypeAlias = dict[str, Any]
#: Told what is being done.
Say: TypeAlias = Callable[[str], object]
Answer = TypeVar("Answer")
Key = TypeVar("Key")
Value = TypeVar("Value")


#: polhode's number types; of mp where it is asked for so many digits.
MP_DIGITS = DEFAULT_MP_DIGITS
TYPES = {name: named(name) for name in NAMES}


def fewest_digits(states: Any, true: Any, scene: polhode.Scene, most: float) -> float:
    """The fewest correct digits of any of the states, at most so many; 0 of what is no number."""
    if not all(math.isfinite(x) for row in states for x in row):
        return 0.0
    with np.errstate(divide="ignore"):
        worst = -np.log10(polhode.state_errors(states, true, scene).max())
    return float(np.clip(worst, 0.0, most))


def groups(pairs: Iterable[tuple[Key, Value]]) -> dict[Key, list[Value]]:
    """Values by their keys, in the order in which they come."""
    lists: dict[Key, list[Value]] = {}
    for key, value in pairs:
        lists.setdefault(key, []).append(value)
    return lists


def inner_rows(rows: Iterable[JsonObject], *keys: str) -> list[JsonObject]:
    """The rows that rows have in lists under these keys, each with what its outer row says."""
    return [{**row, **own} for row in rows for key in keys for own in row.get(key, ())]


def clocked(call: Callable[[], Answer]) -> tuple[Answer, float]:
    """What a call returns, and the processor seconds that it takes."""
    began = time.process_time()
    answer = call()
    return answer, time.process_time() - began


class Timed(NamedTuple):
    """What a call returned, the least processor seconds, and of how many calls.

    The first of them warms up, and counts where a call takes longer than the patience.
    """

    answer: Any
    seconds: float
    calls: int


def timed(calls: Sequence[Callable[[], Answer]], repeats: int, patience: float) -> list[Timed]:
    """What calls return and cost: once each to begin with, then in turns, what is slow no more."""
    first = [Timed(*clocked(call), 1) for call in calls]
    again = [call for call, cost in zip(calls, first, strict=True) if cost.seconds <= patience]
    rounds = [[clocked(call)[1] for call in again] for _ in range(repeats)]
    least = map(min, zip(*rounds, strict=True))
    return [
        x._replace(seconds=next(least), calls=repeats) if x.seconds <= patience else x
        for x in first
    ]


#: The makers of a study's parts, each with what its rows are of.
Parts: TypeAlias = Mapping[str, tuple[Callable[[Any], Any], Sequence[Any]]]


def rows_by_part(parts: Parts, alone: bool, say: Say) -> dict[str, list[Any]]:
    """The rows of each part, by as many processes as there are processors, the first begun first.

    ``alone``: by this one.
    """
    jobs = [(part, make, subject) for part, (make, every) in parts.items() for subject in every]
    rows: dict[str, list[Any]] = {part: [] for part in parts}

    def announce(job: tuple[str, Any, Any]) -> None:
        part, _, subject = job
        say(f"{part}: {getattr(subject, 'name', subject)}")

    workers = 1 if alone or len(jobs) < 2 else cores()
    for (part, *_), row in zip(jobs, in_order(_row, jobs, workers, announce), strict=True):
        rows[part].append(row)
    return rows


def _row(job: tuple[str, Callable[[Any], Any], Any]) -> Any:
    _, make, subject = job
    return make(subject)


def write(texts: Mapping[Path, str]) -> list[Path]:
    """Write files, each of them whole or not at all; their paths."""
    write_whole(texts)
    return [*texts]


# --- row filter -----------------------------------------------------------------------------------
#
# Part of a study: the rows whose names hold every text that was asked for.


@dataclass(frozen=True)
class Only:
    """What is wanted of a study, asked with the labels of a row: ``only("euler/rest", "quad")``.

    A row is wanted where each text stands in one of its labels, capitals or not; without texts
    every row is.  ``passed``: the labels of rows that were not wanted, for the message where none
    was; ``taken``: those of rows that were.
    """

    texts: tuple[str, ...] = ()
    taken: list[str] = field(default_factory=list, compare=False)
    passed: list[str] = field(default_factory=list, compare=False)

    def __call__(self, *labels: str) -> bool:
        """Whether the row of these labels is wanted."""
        is_wanted = all(any(t.lower() in x.lower() for x in labels) for t in self.texts)
        (self.taken if is_wanted else self.passed).extend(labels)
        return is_wanted

    def check(self) -> None:
        """Raise BadInput where no row was wanted."""
        if not self.taken:
            names = ", ".join(dict.fromkeys(self.passed[:8]))
            likely = f"part of the name of a row, such as {names}"
            raise polhode.BadInput("make.py", "--only", " ".join(self.texts), likely)


# --- words ----------------------------------------------------------------------------------------
#
# Numbers and counts of rows in words, as they stand in cells and sentences.


DASH = "–"


def formatted(value: object, form: str) -> str:
    """A value in a form of columns (see ``Column``); a dash where there is none."""
    if isinstance(value, list):
        return ", ".join(value)
    if value is None or value == "":
        return DASH
    if isinstance(value, bool):
        return "yes" if value else "no"
    if form == "code":
        return f"`{value}`"
    return value if isinstance(value, str) else format(value, form)


def median(values: Sequence[float], form: str) -> str:
    """Their median; a dash where there is none."""
    return format(statistics.median(values), form) if values else DASH


def between(values: Sequence[float], form: str, to: str = " to ") -> str:
    """From the least to the largest; a dash where there is none."""
    return f"{min(values):{form}}{to}{max(values):{form}}" if values else DASH


def spread(values: Sequence[float], form: str) -> str:
    """The median, and in brackets the least and the largest of several."""
    middle = median(values, form)
    return f"{middle} ({between(values, form, DASH)})" if len(values) > 1 else middle


def share(flags: Iterable[bool]) -> str:
    """How many of all are true: "3 of 5"."""
    every = [*flags]
    return f"{sum(every)} of {len(every)}"


def counted(counts: Mapping[str, int]) -> str:
    """How many of each, those of which there are some: "3 elliptic, 2 hyperbolic"."""
    return ", ".join(f"{count} {word}" for word, count in counts.items() if count)


# --- page -----------------------------------------------------------------------------------------
#
# A study's page is its template: Markdown with a field {NAME} for each fact, for each table a block
#
#     ```table NAME: the words of the command that makes a row again, {0} its first cell
#     header | where the value stands in a row | form | what the column holds
#     ```
#
# A line that begins with a blank continues the one before; one of a header alone is a column that
# several tables have, see templates/columns.md. A block without lines has the columns of the last.


TABLE = re.compile(r"^```table (\w+)(?:: ([^\n]*))?\n(.*?)^```$", re.M | re.S)


class Column(NamedTuple):
    """A column of a table.

    ``path``: the keys and places that lead to its value in a row; with "*" as the last of them it
    is a column for each key there, which stands for the * in the header.  ``form``: "" for text,
    "code", or a format of numbers, which stand to the right (">" for text that reads as a number).
    A value that is missing is a dash; a text that stands where a number would, such as how a run
    ended, is written as it is.  ``meaning``: what the column holds, for a stranger, in words that
    follow the header and a colon; "" where the header tells it.
    """

    header: str
    path: tuple[str, ...]
    form: str = ""
    meaning: str = ""

    @classmethod
    def of_line(cls, line: str) -> Column:
        """The column that a line of a template describes."""
        header, path, *rest = (part.strip() for part in line.split("|", 3))
        return cls(header, tuple(path.split(".")), *rest)

    @property
    def side(self) -> str:
        """Text stands to the left, numbers to the right, as Markdown has it."""
        return "---" if self.form in ("", "code") else "--:"

    def spread(self, rows: Sequence[JsonObject]) -> list[Column]:
        """A column for each key of the rows' values, where its path asks for that."""
        *place, last = self.path
        if last != "*":
            return [self]
        keys = dict.fromkeys(key for row in rows for key in at(row, place) or ())
        return [
            self._replace(header=self.header.replace("*", key), path=(*place, key)) for key in keys
        ]

    def cell(self, row: JsonObject) -> str:
        """What stands in this column of a row."""
        return formatted(at(row, self.path), self.form)


def at(row: JsonObject, path: Iterable[str]) -> Any:
    """The value at a path of keys and places; None where there is none."""
    value: Any = row
    for part in path:
        if isinstance(value, list):
            value = value[int(part)] if value else None
        else:
            value = value.get(part) if isinstance(value, dict) else None
    return value


class PageTable(NamedTuple):
    """Rows of cells under their columns; ``again``: the command that makes a row again, or ""."""

    columns: tuple[Column, ...]
    rows: tuple[tuple[str, ...], ...]
    again: str = ""

    @property
    def header(self) -> tuple[str, ...]:
        """The names of the columns."""
        return tuple(column.header for column in self.columns)

    def command(self, row: tuple[str, ...]) -> str:
        """The command that makes one of the rows again."""
        return self.again.format(*(cell.strip("`").replace("'", r"'\''") for cell in row))

    @property
    def markdown(self) -> str:
        """The table, what its columns hold, and how to make a row again; empty without rows."""
        if not self.rows:
            return ""
        sides = "|".join(column.side for column in self.columns)
        lines = [_line(self.header), f"|{sides}|", *map(_line, self.rows)]
        # of one meaning, such as number types, together
        headers = groups((column.meaning, column.header) for column in self.columns)
        meanings = [
            f"*{', '.join(names)}*: {meaning}" for meaning, names in headers.items() if meaning
        ]
        lines += ["", f"Columns: {'; '.join(meanings)}."] if meanings else [""]
        if self.again:
            lines.append(f"To make rows again, here the first: `{self.command(self.rows[0])}`.")
        return "\n".join(lines).rstrip()


def _line(cells: Iterable[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def table(rows: Iterable[JsonObject], lines: str, again: str = "") -> PageTable:
    """A table of rows, its columns from lines as a template has them."""
    shown = [*rows]
    every = (_SHARED.get(line, line) for line in re.sub(r"\n +", " ", lines).splitlines())
    columns = [column for line in every for column in Column.of_line(line).spread(shown)]
    cells = (tuple(column.cell(row) for column in columns) for row in shown)
    return PageTable(tuple(columns), tuple(cells), again)


def filled(template: str, page_tables: Mapping[str, PageTable], facts: Mapping[str, object]) -> str:
    """The template with its fields filled, as Markdown.

    Under each heading what names tables is left out where none of them has rows.

    >>> filled("# A\\n\\n{n} rows\\n\\n## B\\n\\n{none}\\n", {"none": PageTable((), ())}, {"n": 2})
    '# A\\n\\n2 rows\\n'
    """
    parts = re.split(r"(?=\n#)", TABLE.sub(r"{\1}", template))

    def is_shown(part: str) -> bool:
        there = [x.rows for name, x in page_tables.items() if f"{{{name}}}" in part]
        return not there or any(there)

    fields = {name: page_table.markdown for name, page_table in page_tables.items()} | dict(facts)
    text = "".join(filter(is_shown, parts)).format_map(fields)
    return f"{text.strip()}\n"


HERE = Path(__file__).parent


def template(name: str) -> str:
    """A file of templates."""
    return (HERE / "templates" / f"{name}.md").read_text(encoding="utf-8")


_SHARED = {line.partition(" |")[0]: line for line in template("columns").splitlines()}


# --- case runs ------------------------------------------------------------------------------------
#
# A case that was run in several number types, as rows of tables.


def expected(band: list[float] | None) -> str | None:
    """The digits expected, from the least to the most of nine in ten runs."""
    return None if band is None else f"{band[0]:.1f}{DASH}{band[2]:.1f}"


def digits(run: JsonObject | None) -> float | str | None:
    """A run's correct digits, or in words why it has none; None where it was not run."""
    if run is None:
        return None
    right: float | str = run["correct_digits"] if "correct_digits" in run else run["outcome"]
    return run.get("lost") or right


def by_number(case: JsonObject, write: Callable[..., object] = digits) -> JsonObject:
    """A case with its runs by their number types, each with the digits expected as text.

    ``cells``: what is written of each run.
    """
    runs = {run["number"]: {**run, "band": expected(run.get("expected"))} for run in case["runs"]}
    headers = {name: f"mp ({MP_DIGITS})" if name == "mp" else name for name in NAMES}
    cells = {header: write(runs.get(name)) for name, header in headers.items()}
    return {**case, "end": float(case["end"]), "runs": runs, "cells": cells}


# --- figures --------------------------------------------------------------------------------------
#
# What figures share: looks of programs, logarithmic axes, legends.


WIDTH = 4.4  # inches: text of 8 points is 9 pixels on a page 400 pixels wide
GUIDE, SHADE = "#777777", "#f4f4f4"
#: Colours of Okabe and Ito's set, told apart by every eye; of number types, and of others.
COLOURS = {"double": "#0072b2", "extended": "#e69f00", "quad": "#009e73", "mp": "#cc79a7"}
MARKS = {"double": "o", "extended": "s", "quad": "D", "mp": "^"}
BLUE, ORANGE, GREEN = SERIES = "#0072b2", "#d55e00", "#009e73"


def _look(color: str, marker: str, ls: str = "-", lw: float = 1.1) -> dict[str, Any]:
    """Keywords of matplotlib's plot."""
    return {"color": color, "marker": marker, "ls": ls, "lw": lw, "ms": 4}


#: Keywords of matplotlib's plot, by program or method: one hue each.
LOOKS: dict[str, dict[str, Any]] = {
    "polhode, double": _look(COLOURS["double"], "o", lw=2.2),
    "polhode, extended": _look(COLOURS["extended"], MARKS["extended"], lw=2.2),
    **{x: _look(COLOURS[x], MARKS[x], "--") for x in COLOURS},
    **{f"{x} projected": _look(COLOURS[x], MARKS[x]) for x in COLOURS},
    "double": _look("#56b4e9", "o", "--"),
    "heyoka by hand": _look("#000000", "x", ":"),
    "SciPy, numba": _look("#999999", "s"),
    "CyRK": _look("#d55e00", "s"),
    "numbalsoda": _look("#b8860b", "v"),
    "diffrax": _look("#8c2d04", "D"),
    "splitting": _look("#6a3d9a", "^"),
}

#: Of a program that has none of these.
OTHER_LOOK = _look("#444444", "+", ":")


def plain(axes: Axes) -> None:
    """Pale lines at the labels of both axes, plain numbers where they are logarithmic."""
    from matplotlib.ticker import LogFormatter

    axes.grid()
    for axis in (axes.xaxis, axes.yaxis):
        if axis.get_scale() == "log":
            axis.set_major_formatter(LogFormatter())
            axis.set_minor_formatter(LogFormatter())


def drawn(draw: Callable[..., None], height: float, names: int = len(NAMES), **how: Any) -> str:
    """A figure as SVG text: ``draw`` is given its panels.

    ``height``: of the whole, in inches.  ``names``: of a line of its legend.  ``how``: keywords of
    matplotlib's subplots.
    """
    with polhode.paper() as plt:
        size, out = (WIDTH, height), StringIO()
        figure, panels = plt.subplots(figsize=size, layout="constrained", squeeze=False, **how)
        draw(*panels.flat)
        handles: dict[str, Any] = {}  # every name of the panels once
        for panel in figure.axes:
            for handle, name in zip(*panel.get_legend_handles_labels(), strict=True):
                handles.setdefault(name, handle)
        figure.legend(handles.values(), handles, loc="outside upper center", ncols=names)
        figure.savefig(out, format="svg", metadata={"Date": None})
    return "\n".join(line.rstrip() for line in out.getvalue().splitlines()) + "\n"


def side_by_side(
    subjects: JsonObject, draw: Callable[..., None], height: float, x: str, y: str, **how: Any
) -> str:
    """A figure of two panels a line, each with its title; ``x``, ``y``: what all axes are of.

    ``height``: of a line, in inches.  ``how``: see :func:`drawn`.
    """
    lines = -(-len(subjects) // 2)

    def draw_all(*panels: Axes) -> None:
        for axes in panels[len(subjects) :]:
            axes.remove()
        for axes, (title, subject) in zip(panels, subjects.items(), strict=False):
            draw(axes, subject)
            axes.set_title(title, size=9, loc="left")
            plain(axes)
        figure: Any = panels[0].figure
        figure.supxlabel(x, size=9)
        figure.supylabel(y, size=9)

    return drawn(draw_all, height * lines + 1, nrows=lines, ncols=2, **how)


# --- strips ---------------------------------------------------------------------------------------
#
# Strips of dots, correct digits of many runs: one per group, one colour per number type.


#: Digits that a number type holds, and that the runs in mp are asked for.
HELD = {name: number.bits * 0.30103 for name, number in TYPES.items() if name != "mp"}
_STRIP = (
    "correct digits, worst of all output times\n"
    "(dotted: what the type holds; ringed: fewer\nthan nine in ten such runs)"
)
_GOLDEN = 0.618034  # of a strip's height from one dot to the next: any few in a row lie apart
_HEIGHT = 0.3  # inches of a strip


def strips(groups: Mapping[str, Sequence[JsonObject]]) -> str:
    """A figure of a study's runs, those that have digits; one strip per group from the top down."""
    count = max(len(groups), 1)

    def draw(axes: Axes) -> None:
        for level in range(0, count, 2):
            axes.axhspan(level - 0.5, level + 0.5, color=SHADE, lw=0)
        for number, digits in HELD.items():
            axes.axvline(digits, color=COLOURS[number], lw=0.8, ls=":")
        for number, mark in MARKS.items():
            rows = [*_dots(number, groups.values())]
            x, y, behind = zip(*rows, strict=True) if rows else ((), (), ())
            look: dict[str, Any] = {"color": COLOURS[number], "ms": 3.4, "mew": 0.9, "alpha": 0.85}
            name = f"{number}, {MP_DIGITS} asked" if number == "mp" else number
            axes.plot(x, y, mark, mec="none", label=name, **look)
            axes.plot(x, y, mark, mec="#000000", markevery=[*behind], **look)
        axes.set(xlabel=_STRIP, xlim=(-1, None), ylim=(count - 0.5, -0.5))
        axes.set_yticks(range(len(groups)), [*groups])
        axes.tick_params(axis="y", length=0)
        axes.grid(axis="x")

    return drawn(draw, 1.1 + _HEIGHT * count)


def _dots(number: str, groups: Iterable[Sequence[JsonObject]]) -> Iterator[tuple[Any, ...]]:
    """The digits of a number type's runs, their heights, and which have fewer than expected."""
    for level, runs in enumerate(groups):
        own = [run for run in runs if run["number"] == number and "correct_digits" in run]
        marks = sorted((run["correct_digits"], _is_behind(run)) for run in own)
        for k, (digits, behind) in enumerate(marks):
            yield digits, level + 0.8 * (k * _GOLDEN % 1 - 0.5), behind


def _is_behind(run: JsonObject) -> bool:
    expected = run.get("expected")
    return expected is not None and run["correct_digits"] < expected[0]

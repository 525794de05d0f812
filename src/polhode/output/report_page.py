"""The page of an accuracy report: blocks, written as Markdown or as HTML that needs nothing else."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from importlib.resources import files
from string import Template
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from polhode.common.errors import BadInput
from polhode.common.provenance import cpu, versions
from polhode.common.text_tables import few, one_line, printable
from polhode.figures import accuracy as figures_of
from polhode.figures.accuracy import Curve, Point
from polhode.figures.canvas import canvas
from polhode.numbers.decimals import brief
from polhode.output.accuracy import BAD, FAIR, GOOD, UNKNOWN, Section
from polhode.output.description import describe
from polhode.results import shown
from polhode.results.cells import doubles, word_of
from polhode.results.table import Table, Value
from polhode.scenes.scene_facts import scene_facts

if TYPE_CHECKING:
    from polhode.output.report import Report

TITLE = "Accuracy report"
ROWS = 13  # of times, on a page; JSON has all
EVENTS = 12
#: What a scene's first lines tell, of what ``polhode show`` does.
_TOLD = (
    *("body", "regime", "conditions", "near", "motion", "units", "moments", "torque", "axes"),
    *("integrals", "frequencies", "tends"),
)
_MARKS = {GOOD: "●", FAIR: "◐", BAD: "○", UNKNOWN: "–"}
_LEGEND = (
    "A verdict is that of a scene's files, or of its best run where it has none. Good: as many "
    "correct digits at every time as were asked for, or, where none were, half of those that the "
    "numbers hold; fair: one or more; bad: none; unknown: nothing could be judged. Correct digits "
    "are -log10 of the relative error, the fewest of state, angles and attitude."
)
_NO_FIGURES = "The figures need matplotlib, which is not installed: pip install 'polhode[figures]'."


class Heading(NamedTuple):
    """A heading; ``anchor``: its name for links."""

    level: int
    text: str
    anchor: str = ""


class Words(NamedTuple):
    """A paragraph."""

    text: str


class Verbatim(NamedTuple):
    """Lines as they are; ``summary``: what they are, where they are folded away."""

    text: str
    summary: str = ""


class Grid(NamedTuple):
    """A table of texts; in the first column links where it has ``anchors``."""

    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    anchors: Sequence[str] = ()


class Picture(NamedTuple):
    """A figure by the name of its file."""

    name: str
    alt: str


Block: TypeAlias = Heading | Words | Verbatim | Grid | Picture


def html(of: Report) -> str:
    """The report as one page."""
    svgs = figures(of)
    parts = [_in_html(block, svgs) for block in blocks(of, bool(svgs))]
    page = (files(__package__) / "report_page.html").read_text(encoding="utf-8")
    return Template(page).substitute(title=TITLE, parts="\n".join(parts))


def markdown(of: Report, folder: str) -> str:
    """The report as Markdown, its figures in a folder beside it."""
    is_drawn = bool(figures(of))
    return "\n\n".join(_in_markdown(block, folder) for block in blocks(of, is_drawn)) + "\n"


def figures(of: Report) -> Mapping[str, str]:
    """All figures as SVG by the names of their files; none where matplotlib is not installed."""
    try:
        canvas.require()
    except BadInput:
        return {}
    drawn = {}
    for k, one in enumerate(of.sections, 1):
        name = one.scene.name
        curves, points = _curves(of, one), _points(of, one)
        makers = {
            "body": (figures_of.body, (one.scene.body,), f"{name}: principal moments, centre"),
            "digits": (figures_of.digits, (one.scene, curves), f"{name}: digits over time"),
            "work": (figures_of.work, (points,), f"{name}: processor time over digits"),
        }
        for word, (draw, what, title) in makers.items():
            if what[-1]:
                drawn[f"{k}-{word}.svg"] = figures_of.drawn(draw, *what, title=title)
    return drawn


def blocks(of: Report, is_drawn: bool) -> Iterator[Block]:
    """The page: a row for each scene, then a section each."""
    yield Heading(1, TITLE)
    yield from _first(of)
    if not is_drawn:
        yield Words(_NO_FIGURES)
    for k, one in enumerate(of.sections, 1):
        yield from _scene(of, one, k, is_drawn)
    packages = ", ".join(f"{name} {version}" for name, version in versions().items())
    yield Heading(2, "Provenance")
    yield Words(f"{packages}; {cpu()}. Seconds are processor seconds on this machine.")


def _first(of: Report) -> Iterator[Block]:
    rows = []
    for one, row in zip(of.sections, _rows(of.table()), strict=True):
        name, _, regime, motion, *digits, limit, _, fewest, verdict = row
        runs = [x for x in (_digits(d) for d in digits) if x]
        mark = f"{_MARKS[verdict]} {verdict}"
        rows.append([name, regime, motion, " / ".join(runs), limit, _digits(fewest), mark])
    header = ["scene", "regime", "motion", "digits of the runs", "limit", "of the files", "verdict"]
    anchors = [f"scene-{k}" for k in range(1, len(rows) + 1)]
    yield Grid(header, rows, anchors)
    types = ", ".join(line.name for line in of.sections[0].lines)
    yield Words(f"Digits of the runs: {types}. {_LEGEND}")


def _scene(of: Report, one: Section, k: int, is_drawn: bool) -> Iterator[Block]:
    scene = one.scene
    title = f"{scene.name}: {one_line(scene.title)}" if scene.title else scene.name
    yield Heading(2, title, f"scene-{k}")
    told = str(describe(scene)).splitlines()
    rows = [line.split(None, 1) for line in told if line.split(None, 1)[0] in _TOLD]
    yield Grid(["what it is", ""], [row for row in rows if len(row) == 2])
    if is_drawn:
        yield Picture(
            f"{k}-body.svg", "ellipsoid of inertia; the arrow leads to the centre of mass"
        )
    yield Heading(3, "Correct digits over time")
    yield Words(_measured_against(one))
    if is_drawn and of.tables["digits"].rows:
        yield Picture(f"{k}-digits.svg", "correct digits over time; shaded: expected")
    yield from _digits_table(of, one)
    for line in one.lines:
        told_line = line.why if line.judgement is None else line.judgement.verdict
        until = f"; {line.why}, judged to t = {brief(line.until)}" if line.until is not None else ""
        yield Words(f"*{line.name}*: {told_line}{until}")
    yield from _limits(of, one)
    yield from _files(of, one)
    yield from _table(of, one, "drift", "Drift of the integrals", _DRIFT_MEANS)
    yield from _events(of, one)
    yield Heading(3, "Speed against error")
    yield Words(
        "Each row is a prepared run to the end of the scene, the least processor time of up to "
        "five calls, and its correct digits there."
    )
    if is_drawn and _points(of, one):
        yield Picture(f"{k}-work.svg", "processor time over correct digits at the end")
    yield from _table(of, one, "work")
    text = str(scene_facts(scene)[1].value).rstrip()
    yield Verbatim(text, f"The scene; fingerprint {scene.provenance()['case']}")


_DRIFT_MEANS = (
    "The largest relative departures of energy, vertical momentum, |gamma|² and the fourth "
    "integral; a run that is projected is put back on them, which is no evidence of accuracy."
)


def _measured_against(one: Section) -> str:
    against, times = one.reference, len(one.scene.times)
    how = "the closed form in balls" if against.is_closed_form else "a proven enclosure"
    thinned = f" ({times} of the scene's {one.thinned} times)" if one.thinned else ""
    return f"Measured against {how} ({against.kind}: {against.regime}) at {times} times{thinned}."


def _digits_table(of: Report, one: Section) -> Iterator[Block]:
    """Times down, runs and files across: the digits, and in brackets the band expected."""
    rows = _own(of, one, "digits")
    names = [*dict.fromkeys(row[1] for row in rows)]
    cells = {(row[1], f"{row[2]:.12g}"): row[3:] for row in rows}
    times = [*dict.fromkeys(time for _, time in sorted(cells, key=lambda x: abs(float(x[1]))))]
    shown_rows = []
    for t in (times[k] for k in few(len(times), ROWS)):
        own = [cells.get((name, t)) for name in names]
        shown_rows.append([t, *("" if x is None else _with_band(*x) for x in own)])
    if shown_rows:
        yield Grid(["t", *names], shown_rows)


def _with_band(digits: float, least: float, most: float) -> str:
    """Digits, and in brackets the band that is expected."""
    text = _digits(digits)
    return text if math.isnan(least) else f"{text} ({least:.1f} to {most:.1f})"


def _digits(x: float) -> str:
    return "" if math.isnan(x) else f"{x:.2f}"


def _limits(of: Report, one: Section) -> Iterator[Block]:
    yield Heading(3, "What limits them, and how far each number type reaches")
    header, rows = _shown(of, one, "runs")
    kept = ("run", "digits", "t_of_digits", "digits_end", "limit", "half_lost_after", "lost_after")
    places = [header.index(name) for name in kept]
    yield Grid(
        ["run", "fewest digits", "at t", "at the end", "limit", "half lost after", "lost after"],
        [[row[k] for k in places] for row in rows],
    )
    growth = one.growth
    kappa, amplification = growth.kappa[-1], growth.log10_amplification[-1]
    told = "" if kappa is None else f" At the end kappa is {kappa:.3g}"
    if told and amplification is not None:
        told += f", and an error made on the way is multiplied by up to {10**amplification:.3g}"
    beyond = "An empty cell: not by the end of the scene. Times beyond it follow from the exponent."
    yield Words(f"The motion is {one.motion}.{told + '.' if told else ''} {beyond}")


def _files(of: Report, one: Section) -> Iterator[Block]:
    for file, row in zip(one.files, _own(of, one, "files"), strict=True):
        yield Heading(3, f"File {file.given.name}: {row[2]}")
        yield Verbatim(str(file.judgement) if file.judgement is not None else str(row[-1]))
        half, lost = row[7], row[8]
        places = {"half of the digits are": half, "no digit is": lost}
        first = [f"from t = {t:.6g} on {x} left" for x, t in places.items() if not math.isnan(t)]
        if first:
            yield Words(f"Where it goes wrong: {'; '.join(first)}.")
    for order in one.orders:
        yield Heading(3, "Order of convergence")
        yield Verbatim(str(order))


def _events(of: Report, one: Section) -> Iterator[Block]:
    header, rows = _shown(of, one, "events")
    if not rows:
        return
    by_run = [[row for row in rows if row[0] == line.name] for line in one.lines]
    kept = [row for own in by_run for row in own[:EVENTS]]
    yield Heading(3, "Events")
    left = len(rows) - len(kept)
    more = f" The first {EVENTS} of each run; JSON has {left} more." if left else ""
    meaning = "Uncertainty: how far rounding can move the time; depth: how far it goes beyond zero."
    yield Words(f"{meaning}{more}")
    yield Grid(header, kept)


def _table(of: Report, one: Section, name: str, title: str = "", text: str = "") -> Iterator[Block]:
    header, rows = _shown(of, one, name)
    if not rows:
        return
    if title:
        yield Heading(3, title)
    if text:
        yield Words(text)
    used = [k for k in range(len(header)) if any(row[k] for row in rows)]
    yield Grid([header[k] for k in used], [[row[k] for k in used] for row in rows])


# -- rows of the tables ---------------------------------------------------------------------------


def _rows(table: Table) -> list[tuple[Value, ...]]:
    """The rows of a table; numbers that are missing are nan."""
    columns = [
        doubles(x.values).tolist() if word_of(x) == "double" else [*x.values] for x in table.columns
    ]
    return [*zip(*columns, strict=True)] if table.rows else []


def _own(of: Report, one: Section, name: str) -> list[tuple[Value, ...]]:
    """The rows of a scene."""
    return [row for row in _rows(of.tables[name]) if row[0] == one.scene.name]


def _shown(of: Report, one: Section, name: str) -> tuple[list[str], list[list[str]]]:
    """Header and rows of a scene as people read them, without the scene's name."""
    table = of.tables[name]
    columns = [x._replace(digits=4) for x in table.columns]
    header, rows = shown.cells(table._replace(columns=columns)) if table.rows else ([], [])
    return header[1:], [row[1:] for row in rows if row[0] == one.scene.name]


def _curves(of: Report, one: Section) -> list[Curve]:
    rows = _own(of, one, "digits")
    types = {x.name: x.run.number.name for x in one.lines if x.run is not None}
    types = {name: kind for name, kind in types.items() if name == kind}
    curves = []
    for name in dict.fromkeys(row[1] for row in rows):
        t, digits, least, most = zip(*(row[2:] for row in rows if row[1] == name), strict=True)
        is_run = name in types
        curves.append(Curve(name, types.get(name, ""), t, digits, *((least, most) * is_run)))
    return curves


def _points(of: Report, one: Section) -> list[Point]:
    names = {x.name for x in one.lines}
    rows = _own(of, one, "work")
    return [Point(name, name * (name in names), d, s) for _, name, _, d, s in rows]


# -- blocks as text -------------------------------------------------------------------------------


def _in_markdown(block: Block, folder: str) -> str:
    match block:
        case Heading(level, text, _):
            return f"{'#' * level} {_plain(text)}"
        case Words(text):
            return printable(text)
        case Verbatim(text, summary):
            fence = "```" + "`" * text.count("```")
            return f"{summary}:\n\n" * bool(summary) + f"{fence}text\n{printable(text)}\n{fence}"
        case Picture(name, alt):
            return f"![{alt}]({folder}/{name})"
        case Grid(header, rows, _):
            lines = [[_plain(x) for x in row] for row in (header, *rows)]
            lines.insert(1, ["---"] * len(header))
            return "\n".join(f"| {' | '.join(row)} |" for row in lines)


def _plain(text: str) -> str:
    """Text in one line of Markdown, in a cell of a table too."""
    return re.sub(r"([|*<\\])", r"\\\1", one_line(text))


def _in_html(block: Block, svgs: Mapping[str, str]) -> str:
    match block:
        case Heading(level, text, anchor):
            named = f' id="{anchor}"' if anchor else ""
            return f"<h{level}{named}>{_escaped(text)}</h{level}>"
        case Words(text):
            emphasised = re.sub(r"^\*(.+?)\*:", r"<b>\1</b>:", _escaped(text))
            return f"<p>{emphasised}</p>"
        case Verbatim(text, summary):
            pre = f"<pre>{_escaped(text)}</pre>"
            return (
                f"<details><summary>{_escaped(summary)}</summary>{pre}</details>"
                if summary
                else pre
            )
        case Picture(name, alt):
            caption = f"<figcaption>{_escaped(alt)}</figcaption>"
            return f"<figure>{svgs[name]}{caption}</figure>" if name in svgs else ""
        case Grid(header, rows, anchors):
            head = "".join(f"<th>{_escaped(x)}</th>" for x in header)
            lines = []
            for k, row in enumerate(rows):
                cells = [_escaped(x) for x in row]
                if anchors:
                    cells[0] = f'<a href="#{anchors[k]}">{cells[0]}</a>'
                lines.append("<tr>" + "".join(map(_cell, cells)) + "</tr>")
            body = "\n".join(lines)
            return f'<div class="wide"><table><tr>{head}</tr>\n{body}\n</table></div>'


def _cell(text: str) -> str:
    """A cell of a table, with the colour of a verdict where it is one."""
    mark, _, word = text.partition(" ")
    verdict = f' class="{word}"' if _MARKS.get(word) == mark else ""
    return f"<td{verdict}>{text}</td>"


def _escaped(text: str) -> str:
    return escape(printable(text), quote=False)

"""The page of an accuracy report: blocks, written as Markdown or as one page of HTML."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from html import escape
from importlib import resources
from pathlib import Path
from string import Template
from typing import NamedTuple, TypeAlias

from polhode.common.errors import BadInput, few, one_line, printable
from polhode.common.files import make_folder, write_whole
from polhode.common.provenance import cpu, versions
from polhode.common.texts import JsonObject
from polhode.figures import accuracy, canvas
from polhode.numbers.decimals import brief
from polhode.output.accuracy import BAD, FAIR, GOOD, UNKNOWN, Section
from polhode.results import writer
from polhode.results.cells import doubles, word_of
from polhode.results.table import Table, Value
from polhode.scenes.scene_facts import scene_facts

#: All numbers by the names of their tables.
Tables: TypeAlias = Mapping[str, Table]

TITLE = "Accuracy report"
ENDINGS = (".html", ".md")
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
_ALTS = {
    "body": "ellipsoid of inertia; an arrow along Mg r0",
    "digits": "correct digits over time; shaded: expected",
    "work": "processor time over correct digits at the end",
}
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


def files(path: Path, page: Sequence[Block], svgs: Mapping[str, str]) -> Mapping[Path, str | bytes]:
    """The files of a page: .md with its figures in a folder beside it, or all in one of HTML."""
    page = [x for x in page if not isinstance(x, Picture) or x.name in svgs]
    if path.suffix.lower() != ".md":
        parts = "\n".join(_in_html(block, svgs) for block in page)
        template = (resources.files(__package__) / "report_page.html").read_text(encoding="utf-8")
        return {path: Template(template).substitute(title=TITLE, parts=parts)}
    folder = path.with_name(f"{path.stem}-figures")
    text = "\n\n".join(_in_markdown(block, folder.name) for block in page) + "\n"
    return {path: text, **{folder / name: svg for name, svg in svgs.items()}}


def write(texts: Mapping[Path, str | bytes]) -> None:
    """Write the files of pages, all or none, in folders that are made where they are not there."""
    for path in texts:
        if path.parent.name.endswith("-figures"):
            make_folder(path.parent)
    write_whole(texts)


def figures(sections: Sequence[Section], parts: Sequence[Tables]) -> Mapping[str, str]:
    """All figures as SVG by the names of their files; none where matplotlib is not installed."""
    try:
        canvas.require()
    except BadInput:
        return {}
    drawn = {}
    for k, (one, of) in enumerate(zip(sections, parts, strict=True), 1):
        draws = {
            "body": partial(accuracy.body, of=one.scene.body),
            "digits": partial(accuracy.digits, scene=one.scene, rows=_rows(of["digits"])),
            "work": partial(accuracy.work, rows=_rows(of["work"])),
        }
        for word, draw in draws.items():
            if word == "body" or draw.keywords["rows"]:
                title = f"{one.scene.name}: {_ALTS[word]}"
                drawn[f"{k}-{word}.svg"] = accuracy.drawn(draw, title)
    return drawn


def blocks(sections: Sequence[Section], parts: Sequence[Tables], is_drawn: bool) -> Iterator[Block]:
    """The page: a row for each scene, then a section each; ``parts``: the tables of each."""
    yield Heading(1, TITLE)
    yield from _first(sections, parts)
    if not is_drawn:
        yield Words(_NO_FIGURES)
    for k, (one, of) in enumerate(zip(sections, parts, strict=True), 1):
        yield from _scene(of, one, k)
    packages = ", ".join(f"{name} {version}" for name, version in versions().items())
    yield Heading(2, "Provenance")
    yield Words(f"{packages}; {cpu()}. Seconds are processor seconds on this machine.")


def _first(sections: Sequence[Section], parts: Sequence[Tables]) -> Iterator[Block]:
    rows = []
    for of in parts:
        ((name, verdict, limit, _, regime, motion, *digits, _, fewest),) = _rows(of["overview"])
        runs = " / ".join(filter(None, map(_digits, digits)))
        mark = f"{_MARKS[verdict]} {verdict}"
        rows.append([name, mark, runs, _digits(fewest), limit, motion, regime])
    header = ["scene", "verdict", "digits of the runs", "of the files", "limit", "motion", "regime"]
    yield _grid(header, rows, [f"scene-{k}" for k in range(1, len(rows) + 1)])
    yield Words(f"Digits of the runs: {', '.join(x.name for x in sections[0].lines)}. {_LEGEND}")


def _scene(of: Tables, one: Section, k: int) -> Iterator[Block]:
    scene = one.scene
    title = f"{scene.name}: {one_line(scene.title)}" if scene.title else scene.name
    yield Heading(2, title, f"scene-{k}")
    told = str(one.description).splitlines()
    rows = [line.split(None, 1) for line in told if line.split(None, 1)[0] in _TOLD]
    yield Grid(["what it is", ""], [row for row in rows if len(row) == 2])
    yield Picture(f"{k}-body.svg", _ALTS["body"])
    yield Heading(3, "Correct digits over time")
    yield Words(_measured_against(one))
    yield Picture(f"{k}-digits.svg", _ALTS["digits"])
    yield from _digits_table(of)
    for line in one.lines:
        until = f"; beyond t = {brief(line.until)} {line.why}" if line.until is not None else ""
        yield Words(f"*{line.name}*: {line.sentence}{until}.")
    yield from _limits(of, one)
    yield from _files(one)
    yield from _table(of, "drift", "Drift of the integrals", _DRIFT_MEANS)
    yield from _events(of, one)
    yield Heading(3, "Speed against error")
    yield Words(
        "Each row is a prepared run to the end of the scene, the least processor time of up to "
        "five calls, and its correct digits there."
    )
    yield Picture(f"{k}-work.svg", _ALTS["work"])
    yield from _table(of, "work")
    text = (scene.source or str(scene_facts(scene)[1].value)).strip()
    yield Verbatim(text, f"The scene; fingerprint {scene.provenance()['case']}")


_DRIFT_MEANS = (
    "The largest relative departures of energy, vertical momentum, |gamma|² and the fourth "
    "integral; a run that is projected is put back on them, which is no evidence of accuracy."
)


def _measured_against(one: Section) -> str:
    against, times = one.reference, len(one.scene.times)
    how = "the closed form in balls" if against.is_closed_form else "a proven enclosure"
    thinned = f" of the scene's {one.times}" if one.times > times else ""
    return f"Measured against {how} ({against.kind}: {against.regime}) at {times}{thinned} times."


def _digits_table(of: Tables) -> Iterator[Block]:
    """Times down, runs and files across: the digits, and in brackets the band expected."""
    rows = _rows(of["digits"])
    names = [*dict.fromkeys(row[1] for row in rows)]
    cells = {(row[1], f"{row[2]:.12g}"): row[3:] for row in rows}
    times = [*dict.fromkeys(time for _, time in sorted(cells, key=lambda x: abs(float(x[1]))))]
    shown_rows = []
    for t in (times[k] for k in few(len(times), ROWS)):
        own = [cells.get((name, t), ()) for name in names]
        shown_rows.append([t, *("" if not x else _with_band(*x) for x in own)])
    if shown_rows:
        yield Grid(["t", *names], shown_rows)


def _with_band(digits: float, least: float, most: float) -> str:
    """Digits, and in brackets the band that is expected."""
    text = _digits(digits)
    return text if math.isnan(least) else f"{text} ({least:.1f}–{most:.1f})"


def _digits(x: float) -> str:
    return "" if math.isnan(x) else f"{x:.2f}"


def _limits(of: Tables, one: Section) -> Iterator[Block]:
    yield Heading(3, "What limits them, and how far each number type reaches")
    header, rows = _shown(of["runs"])
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


def _files(one: Section) -> Iterator[Block]:
    for line in one.files:
        yield Heading(3, f"File {line.name}: {line.mark(one.wanted)}")
        yield Verbatim(line.sentence if line.judgement is None else str(line.judgement))
        words = "fewer than half of the digits are right", "none is"
        places = zip(words, one.reach(line), strict=True)
        first = [f"{x} from t = {t:.6g} on" for x, t in places if t is not None]
        if first:
            yield Words(f"Where it goes wrong: {'; '.join(first)}.")
    for order in one.orders:
        yield Heading(3, "Order of convergence")
        yield Verbatim(str(order))


def _events(of: Tables, one: Section) -> Iterator[Block]:
    header, rows = _shown(of["events"])
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


def _table(of: Tables, name: str, title: str = "", text: str = "") -> Iterator[Block]:
    header, rows = _shown(of[name])
    if not rows:
        return
    if title:
        yield Heading(3, title)
    if text:
        yield Words(text)
    yield _grid(header, rows)


def _grid(
    header: Sequence[str], rows: Sequence[Sequence[str]], anchors: Sequence[str] = ()
) -> Grid:
    """A table without its empty columns."""
    used = [k for k in range(len(header)) if any(row[k] for row in rows)]
    return Grid([header[k] for k in used], [[row[k] for k in used] for row in rows], anchors)


def of_tests(rows: Sequence[JsonObject]) -> tuple[list[Block], Mapping[str, str]]:
    """The page of a test suite's judgements, and its figures.

    ``rows``: of each judgement the test and whether it passed, the scene, the times, the digits,
    and the verdict.
    """
    header = ["test", "verdict", "digits", "scene", "what they mean"]
    marks = {True: f"{_MARKS[GOOD]} passed", False: f"{_MARKS[BAD]} failed"}
    cells = [
        (x["test"], marks[x["passed"]], f"{x['worst']:.2f}", x["scene"], x["verdict"]) for x in rows
    ]
    page: list[Block] = [Heading(1, TITLE), Grid(header, cells)]
    svgs = {}
    for k, scene in enumerate(dict.fromkeys(row["scene"] for row in rows), 1):
        curves = [
            (scene, x["test"].rpartition("::")[2], *pair, math.nan, math.nan)
            for x in rows
            if x["scene"] == scene
            for pair in zip(x["t"], x["digits"], strict=True)
        ]
        with suppress(BadInput):  # without matplotlib there are no figures
            canvas.require()
            draw = partial(accuracy.digits, scene=None, rows=curves)
            svgs[f"{k}-digits.svg"] = accuracy.drawn(draw, f"{scene}: {_ALTS['digits']}")
            page += [Heading(2, scene), Picture(f"{k}-digits.svg", "correct digits over time")]
    return page, svgs


# -- rows of the tables ---------------------------------------------------------------------------


def _rows(table: Table) -> list[tuple[Value, ...]]:
    """The rows of a table; numbers that are missing are nan."""
    columns = [
        doubles(x.values).tolist() if word_of(x) == "double" else [*x.values] for x in table.columns
    ]
    return [*zip(*columns, strict=True)] if table.rows else []


def _shown(table: Table) -> tuple[list[str], list[list[str]]]:
    """Header and rows as people read them, without the scene's name."""
    if not table.rows:
        return [], []
    header, rows = writer.cells(table)
    return header[1:], [row[1:] for row in rows]


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
                f"<details open><summary>{_escaped(summary)}</summary>{pre}</details>"
                if summary
                else pre
            )
        case Picture(name, alt):
            caption = f"<figcaption>{_escaped(alt)}</figcaption>"
            word = name.partition("-")[2].removesuffix(".svg")
            return f'<figure class="{word}">{svgs[name]}{caption}</figure>' if name in svgs else ""
        case Grid(header, rows, anchors):
            head = "".join(f"<th>{_escaped(x)}</th>" for x in header)
            lines = []
            for k, row in enumerate(rows):
                cells = [_escaped(x) for x in row]
                if anchors:
                    name = cells[0].replace("/", "/<wbr>")
                    cells[0] = f'<a href="#{anchors[k]}">{name}</a>'
                lines.append("<tr>" + "".join(map(_cell, cells)) + "</tr>")
            body = "\n".join(lines)
            return f'<div class="wide"><table><tr>{head}</tr>\n{body}\n</table></div>'


def _cell(text: str) -> str:
    """A cell of a table, with the colour of a verdict where it is one."""
    mark, _, word = text.partition(" ")
    named = {x: name for name, x in _MARKS.items()}.get(mark) if word else None
    return f'<td class="{named}">{text}</td>' if named else f"<td>{text}</td>"


def _escaped(text: str) -> str:
    return escape(printable(text), quote=False)

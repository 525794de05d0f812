"""The page of an accuracy report, as Markdown and as one page of HTML."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import partial
from html import escape
from importlib import resources
from pathlib import Path
from string import Template
from typing import TypeAlias

from polhode.common.errors import BadInput, few, one_line, printable
from polhode.common.files import make_folder, write_whole
from polhode.common.provenance import cpu, versions
from polhode.common.texts import JsonObject
from polhode.figures import accuracy, canvas
from polhode.numbers.decimals import brief
from polhode.output.accuracy import BAD, FAIR, GOOD, UNKNOWN, SceneSection
from polhode.results.cells import doubles, word_of
from polhode.results.shown import cells
from polhode.results.table import Table, Value
from polhode.scenes.scene_facts import scene_facts

#: All numbers by the names of their tables.
Tables: TypeAlias = Mapping[str, Table]

TITLE = "Accuracy report"
ENDINGS = (".html", ".md")
ROWS = 13  # of times, on a page; JSON has all
EVENTS = 12
NEVER = "–"
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


class ReportPage:
    """A page as Markdown and as HTML, block by block; pictures are those that were drawn."""

    def __init__(self, path: Path, svgs: Mapping[str, str]) -> None:
        self.path, self.svgs = path, svgs
        self.folder = path.with_name(f"{path.stem}-figures")
        self.markdown: list[str] = []
        self.html: list[str] = []

    def heading(self, level: int, text: str, anchor: str = "") -> None:
        """A heading; ``anchor``: its name for links."""
        named = f' id="{anchor}"' if anchor else ""
        self.markdown.append(f"{'#' * level} {_plain(text)}")
        self.html.append(f"<h{level}{named}>{_escaped(text)}</h{level}>")

    def words(self, text: str) -> None:
        """A paragraph."""
        self.markdown.append(printable(text))
        emphasised = re.sub(r"^\*(.+?)\*:", r"<b>\1</b>:", _escaped(text))
        self.html.append(f"<p>{emphasised}</p>")

    def verbatim(self, text: str, summary: str = "") -> None:
        """Lines as they are; ``summary``: what they are, where they are folded away."""
        fence, pre = "```" + "`" * text.count("```"), f"<pre>{_escaped(text)}</pre>"
        heading = f"{summary}:\n\n" * bool(summary)
        self.markdown.append(f"{heading}{fence}text\n{printable(text)}\n{fence}")
        if summary:
            pre = f"<details open><summary>{_escaped(summary)}</summary>{pre}</details>"
        self.html.append(pre)

    def picture(self, name: str, alt: str) -> None:
        """A figure by the name of its file."""
        if name not in self.svgs:
            return
        word = name.partition("-")[2].removesuffix(".svg")
        caption = f"<figcaption>{_escaped(alt)}</figcaption>"
        self.markdown.append(f"![{alt}]({self.folder.name}/{name})")
        self.html.append(f'<figure class="{word}">{self.svgs[name]}{caption}</figure>')

    def grid(
        self, header: Sequence[str], rows: Sequence[Sequence[str]], anchors: Sequence[str] = ()
    ) -> None:
        """A table without its empty columns; in the first column links where it has ``anchors``."""
        used = [k for k in range(len(header)) if any(row[k] for row in rows)]
        lines = [[_plain(row[k]) for k in used] for row in (header, *rows)]
        lines.insert(1, ["---"] * len(used))
        self.markdown.append("\n".join(f"| {' | '.join(line)} |" for line in lines))
        head = "".join(f"<th>{_escaped(header[k])}</th>" for k in used)
        body = []
        for n, row in enumerate(rows):
            cells = [_escaped(row[k]) for k in used]
            if anchors:
                name = cells[0].replace("/", "/<wbr>")
                cells[0] = f'<a href="#{anchors[n]}">{name}</a>'
            body.append(f"<tr>{''.join(map(_cell, cells))}</tr>")
        table = "\n".join([f"<table><tr>{head}</tr>", *body, "</table>"])
        self.html.append(f'<div class="wide">{table}</div>')

    def files(self) -> Mapping[Path, str | bytes]:
        """Its files: .md with the figures in a folder beside it, or all in one of HTML."""
        if self.path.suffix.lower() == ".md":
            figures = {self.folder / name: svg for name, svg in self.svgs.items()}
            return {self.path: "\n\n".join(self.markdown) + "\n", **figures}
        template = (resources.files(__package__) / "report_page.html").read_text(encoding="utf-8")
        parts = "\n".join(self.html)
        return {self.path: Template(template).substitute(title=TITLE, parts=parts)}


def write(texts: Mapping[Path, str | bytes]) -> None:
    """Write the files of pages, all or none, in folders that are made where they are not there."""
    for path in texts:
        if path.parent.name.endswith("-figures"):
            make_folder(path.parent)
    write_whole(texts)


def figures(sections: Sequence[SceneSection], parts: Sequence[Tables]) -> Mapping[str, str]:
    """All figures as SVG by the names of their files; none where matplotlib is not installed."""
    try:
        canvas.require()
    except BadInput:
        return {}
    drawn = {}
    for k, (section, of) in enumerate(zip(sections, parts, strict=True), 1):
        draws = {
            "body": partial(accuracy.body, of=section.scene.body),
            "digits": partial(accuracy.digits, scene=section.scene, rows=_rows(of["digits"])),
            "work": partial(accuracy.work, rows=_rows(of["work"])),
        }
        for word, draw in draws.items():
            if word == "body" or draw.keywords["rows"]:
                title = f"{section.scene.name}: {_ALTS[word]}"
                drawn[f"{k}-{word}.svg"] = accuracy.drawn(draw, title)
    return drawn


def page(
    path: Path, sections: Sequence[SceneSection], parts: Sequence[Tables], svgs: Mapping[str, str]
) -> ReportPage:
    """A row for each scene, then a section each; ``parts``: the tables of each."""
    to = ReportPage(path, svgs)
    to.heading(1, TITLE)
    _first(to, sections, parts)
    if not svgs:
        to.words(_NO_FIGURES)
    for k, (section, of) in enumerate(zip(sections, parts, strict=True), 1):
        _scene(to, of, section, k)
    packages = ", ".join(f"{name} {version}" for name, version in versions().items())
    to.heading(2, "Provenance")
    to.words(f"{packages}; {cpu()}. Seconds are processor seconds on this machine.")
    return to


def _first(to: ReportPage, sections: Sequence[SceneSection], parts: Sequence[Tables]) -> None:
    rows = []
    for of in parts:
        ((name, verdict, limit, _, regime, motion, *digits, _, fewest),) = _rows(of["overview"])
        runs = " / ".join(filter(None, map(_digits, digits)))
        mark = f"{_MARKS[verdict]} {verdict}"
        rows.append([name, mark, runs, _digits(fewest), limit, motion, regime])
    header = ["scene", "verdict", "digits of the runs", "of the files", "limit", "motion", "regime"]
    to.grid(header, rows, [f"scene-{k}" for k in range(1, len(rows) + 1)])
    to.words(f"Digits of the runs: {', '.join(x.name for x in sections[0].lines)}. {_LEGEND}")


def _scene(to: ReportPage, of: Tables, section: SceneSection, k: int) -> None:
    scene = section.scene
    title = f"{scene.name}: {one_line(scene.title)}" if scene.title else scene.name
    to.heading(2, title, f"scene-{k}")
    described = [line.split(None, 1) for line in str(section.description).splitlines()]
    to.grid(["what it is", ""], [x for x in described if len(x) == 2 and x[0] in _TOLD])
    to.picture(f"{k}-body.svg", _ALTS["body"])
    to.heading(3, "Correct digits over time")
    to.words(_measured_against(section))
    to.picture(f"{k}-digits.svg", _ALTS["digits"])
    _add_digits(to, of)
    for line in section.lines:
        until = f"; beyond t = {brief(line.until)} {line.why}" if line.until is not None else ""
        to.words(f"*{line.name}*: {line.sentence}{until}.")
    _add_limits(to, of, section)
    _add_files(to, section)
    _add_table(to, of, "drift", "Drift of the integrals", _DRIFT_MEANS)
    _add_events(to, of, section)
    to.heading(3, "Speed against error")
    to.words(
        "Each row is a prepared run to the end of the scene, the least processor time of up to "
        "five calls, and its correct digits there."
    )
    to.picture(f"{k}-work.svg", _ALTS["work"])
    _add_table(to, of, "work")
    text = (scene.source or str(scene_facts(scene)[1].value)).strip()
    to.verbatim(text, f"The scene; fingerprint {scene.provenance()['case']}")


_DRIFT_MEANS = (
    "The largest relative departures of energy, vertical momentum, |gamma|² and the fourth "
    "integral; a run that is projected is put back on them, which is no evidence of accuracy."
)


def _measured_against(section: SceneSection) -> str:
    against, times = section.reference, len(section.scene.times)
    how = "the closed form in balls" if against.is_closed_form else "a proven enclosure"
    thinned = f" of the scene's {section.times}" if section.times > times else ""
    return f"Measured against {how} ({against.kind}: {against.regime}) at {times}{thinned} times."


def _add_digits(to: ReportPage, of: Tables) -> None:
    """Times down, runs and files across: the digits, and in brackets the band expected."""
    rows = _rows(of["digits"])
    names = [*dict.fromkeys(row[1] for row in rows)]
    cells = {(row[1], f"{row[2]:.12g}"): row[3:] for row in rows}
    counts = Counter(time for _, time in cells)
    shared = max(counts.values(), default=0)  # where files have other times than the scene
    times = sorted((t for t, n in counts.items() if n == shared), key=lambda t: abs(float(t)))
    shown_rows = []
    for t in (times[k] for k in few(len(times), ROWS)):
        own = [cells.get((name, t), ()) for name in names]
        shown_rows.append([t, *("" if not x else _with_band(*x) for x in own)])
    if shown_rows:
        to.grid(["t", *names], shown_rows)


def _with_band(digits: float, least: float, most: float) -> str:
    """Digits, and in brackets the band that is expected."""
    text = _digits(digits)
    return text if math.isnan(least) else f"{text} ({least:.1f}–{most:.1f})"


def _digits(x: float) -> str:
    return "" if math.isnan(x) else f"{x:.2f}"


def _add_limits(to: ReportPage, of: Tables, section: SceneSection) -> None:
    to.heading(3, "What limits them, and how far each number type reaches")
    header, rows = _shown(of["runs"])
    names = ("run", "digits", "t_of_digits", "digits_end", "limit", "half_lost_after", "lost_after")
    places = [header.index(name) for name in names]
    to.grid(
        ["run", "fewest digits", "at t", "at the end", "limit", "half lost after", "lost after"],
        [[*(row[k] for k in places[:5]), *(row[k] or NEVER for k in places[5:])] for row in rows],
    )
    growth = section.growth
    kappa, amplification = growth.kappa[-1], growth.log10_amplification[-1]
    sentence = "" if kappa is None else f" At the end kappa is {kappa:.3g}"
    if sentence and amplification is not None:
        sentence += f", and an error made on the way is multiplied by up to {10**amplification:.3g}"
    beyond = f"{NEVER}: not by the end of the scene. Times beyond it follow from the exponent."
    to.words(f"The motion is {section.motion}.{sentence + '.' if sentence else ''} {beyond}")


def _add_files(to: ReportPage, section: SceneSection) -> None:
    for line in section.files:
        to.heading(3, f"File {line.name}: {line.mark(section.wanted)}")
        to.verbatim(line.sentence if line.judgement is None else str(line.judgement))
        words = "fewer than half of the digits are right", "none is"
        places = zip(words, section.reach(line), strict=True)
        first = [f"{x} from t = {t:.6g} on" for x, t in places if t is not None]
        if first:
            to.words(f"Where it goes wrong: {'; '.join(first)}.")
    for order in section.orders:
        to.heading(3, "Order of convergence")
        to.verbatim(str(order))


def _add_events(to: ReportPage, of: Tables, section: SceneSection) -> None:
    header, rows = _shown(of["events"])
    if not rows:
        return
    by_run = [[row for row in rows if row[0] == line.name] for line in section.lines]
    shown = [row for own in by_run for row in own[:EVENTS]]
    to.heading(3, "Events")
    left = len(rows) - len(shown)
    more = f" The first {EVENTS} of each run; JSON has {left} more." if left else ""
    meaning = "Uncertainty: how far rounding can move the time; depth: how far it goes beyond zero."
    to.words(f"{meaning}{more}")
    to.grid(header, shown)


def _add_table(to: ReportPage, of: Tables, name: str, title: str = "", text: str = "") -> None:
    header, rows = _shown(of[name])
    if not rows:
        return
    if title:
        to.heading(3, title)
    if text:
        to.words(text)
    to.grid(header, rows)


def of_tests(path: Path, rows: Sequence[JsonObject]) -> ReportPage:
    """The page of a test suite's judgements.

    ``rows``: of each judgement the test and whether it passed, the scene, the times, the digits,
    and the verdict.
    """
    svgs: dict[str, str] = {}
    header = ["test", "verdict", "digits", "scene", "what they mean"]
    marks = {True: f"{_MARKS[GOOD]} passed", False: f"{_MARKS[BAD]} failed"}
    cells = [
        (x["test"], marks[x["passed"]], f"{x['worst']:.2f}", x["scene"], x["verdict"]) for x in rows
    ]
    to = ReportPage(path, svgs)
    to.heading(1, TITLE)
    to.grid(header, cells)
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
            to.heading(2, scene)
            to.picture(f"{k}-digits.svg", "correct digits over time")
    return to


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
    header, rows = cells(table)
    return header[1:], [row[1:] for row in rows]


# -- texts on a page -------------------------------------------------------------------------------


def _plain(text: str) -> str:
    """Text in one line of Markdown, in a cell of a table too."""
    return re.sub(r"([|*<\\])", r"\\\1", one_line(text))


def _cell(text: str) -> str:
    """A cell of a table, with the colour of a verdict where it is one."""
    mark, _, word = text.partition(" ")
    named = {x: name for name, x in _MARKS.items()}.get(mark) if word else None
    return f'<td class="{named}">{text}</td>' if named else f"<td>{text}</td>"


def _escaped(text: str) -> str:
    return escape(printable(text), quote=False)

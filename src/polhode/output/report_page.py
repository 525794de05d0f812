"""An accuracy report's tables, and its page as Markdown and as one page of HTML."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from html import escape
from importlib import resources
from itertools import cycle, groupby
from pathlib import Path
from string import Template
from typing import Any, NamedTuple

import numpy as np

from polhode.common.errors import BadInput, few, one_line, printable
from polhode.common.files import make_folder, write_whole
from polhode.common.provenance import cpu, versions
from polhode.common.texts import JsonObject
from polhode.figures import canvas
from polhode.figures.canvas import COLOURS, MARKS, SPACE, power_of_ten, time_label
from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import Doubles
from polhode.output.accuracy import ReportRow, SceneSection
from polhode.results.cells import DOUBLE, TEXT, header_and_rows
from polhode.results.table import Table, table_of_rows
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import page_text

TITLE = "Accuracy report"
ENDINGS = (".html", ".md")
ROWS = 13  # of a run or a file, on a page; JSON has all
DIGITS = 4  # where people read them
#: Columns of texts, and those that no page shows.
_TEXTS = (
    "scene verdict motion limit regime reference fact text of file files_of run event time number "
    "method remark reading sentence"
)
_HIDDEN = "reference number method steps reading sentence"
_NO_FIGURES = "The figures need matplotlib, which is not installed: pip install 'polhode[figures]'."
_MARKS = {"good": "●", "passed": "●", "fair": "◐", "bad": "○", "failed": "○", "unknown": "–"}


class ReportPart(NamedTuple):
    """A table of a report: its heading on the page, its columns after the scene, what it means.

    ``picture``: what the figure beside it shows, "" for none.
    """

    title: str
    columns: str
    meaning: str = ""
    picture: str = ""


_KNOWN = "limit digits t_of_digits digits_end half_lost_after lost_after"
PARTS: Mapping[str, ReportPart] = {
    "overview": ReportPart(
        TITLE,
        "verdict digits_double digits_extended digits_quad files digits_files motion limit regime "
        "reference",
        "Verdict and limit are those of a scene's worst file; without files the verdict is that of "
        "the best run, the limit that of the first. Good: as many correct digits at every time as "
        "were asked for, or, where none were, half of those that the numbers hold; fair: one or "
        "more; bad: none; unknown: nothing could be judged. Correct digits are -log10 of the "
        "relative error, the fewest of state, angles and attitude.",
    ),
    "description": ReportPart("", "fact text", "", "ellipsoid of inertia; an arrow along Mg r0"),
    "digits": ReportPart(
        "Correct digits over time",
        "of t correct_digits digits_expected_least digits_expected_most",
        "In brackets: where nine in ten runs by steps in that number type would be. A refined run, "
        "such as most in quad, may have more digits.",
        "correct digits over time; shaded: expected",
    ),
    "runs": ReportPart(
        "What limits them, and how far each number type reaches",
        f"run {_KNOWN} judged_until number method steps remark",
        "Half lost after, lost after: the times from which on fewer than half of the digits, and "
        "none, are left; empty where digits are left to the end. Beyond it they follow from the "
        "exponent.",
    ),
    "files": ReportPart("Files", f"file verdict {_KNOWN} seconds reading sentence"),
    "orders": ReportPart("Order of convergence", "files_of order order_least order_most"),
    "drift": ReportPart(
        "Drift of the integrals",
        "of h f gamma fourth",
        "The largest relative departures of energy, vertical momentum, |gamma|² and the fourth "
        "integral; a run that is projected is put back on them, which is no evidence of accuracy.",
    ),
    "events": ReportPart(
        "Events",
        "run event time count sign uncertainty depth",
        "Uncertainty: how far rounding can move the time; depth: how far it goes beyond zero.",
    ),
    "work": ReportPart(
        "Speed against error",
        "of tolerance digits seconds",
        "Each row is a prepared run to the end of the scene, the least processor time of up to "
        "five calls, and its correct digits there; a file's row has the seconds that were told.",
        "processor time over correct digits at the end",
    ),
}


def tables(sections: Sequence[SceneSection]) -> Mapping[str, Table]:
    """All numbers of some sections, by the names of their tables."""
    return {name: _table(name, [(x.scene.name, x.rows[name]) for x in sections]) for name in PARTS}


def _table(name: str, groups: Sequence[tuple[str, Sequence[ReportRow]]]) -> Table:
    """A table of the rows of scenes."""
    texts, hidden = _TEXTS.split(), _HIDDEN.split()
    types = {x: TEXT if x in texts else DOUBLE for x in f"scene {PARTS[name].columns}".split()}
    rows = [(scene, *row) for scene, own in groups for row in own]
    columns = table_of_rows(types, rows).columns
    return Table([x._replace(digits=0 if x.name in hidden else DIGITS) for x in columns])


def shown(table: Table) -> tuple[list[str], list[list[str]]]:
    """Header and rows as people read them, without columns that are empty."""
    header, rows = header_and_rows(table)
    used = [k for k in range(len(header)) if any(row[k] for row in rows)]
    return [header[k] for k in used], [[row[k] for k in used] for row in rows]


class ReportPage:
    """A page as Markdown and as HTML, block by block; ``draws``: whether it can have pictures."""

    def __init__(self, path: Path) -> None:
        self.path, self.folder = path, path.with_name(f"{path.stem}-figures")
        self.markdown: list[str] = []
        self.html: list[str] = []
        self.svgs: dict[str, str] = {}
        self.draws = False
        with suppress(BadInput):
            canvas.pyplot(own=False)
            self.draws = True

    def heading(self, level: int, text: str, anchor: str = "") -> None:
        """A heading; ``anchor``: its name for links."""
        named = f' id="{anchor}"' if anchor else ""
        self.markdown.append(f"{'#' * level} {_plain(text)}")
        self.html.append(f"<h{level}{named}>{_escaped(text)}</h{level}>")

    def words(self, text: str) -> None:
        """A paragraph; several lines are shown as they are."""
        if "\n" in text:
            fence = "```" + "`" * text.count("```")
            self.markdown.append(f"{fence}text\n{printable(text)}\n{fence}")
            self.html.append(f"<pre>{_escaped(text)}</pre>")
        elif text:
            self.markdown.append(printable(text))
            emphasised = re.sub(r"^\*(.+?)\*:", r"<b>\1</b>:", _escaped(text))
            self.html.append(f"<p>{emphasised}</p>")

    def picture(self, name: str, scene: str, text: str, draw: Callable[..., Any], *of: Any) -> None:
        """A figure of a scene, where there can be any; ``name``: of its file."""
        if self.draws:
            self.svgs[f"{name}.svg"] = svg = drawn(f"{scene}: {text}", draw, *of)
            caption = f"<figcaption>{_escaped(text)}</figcaption>"
            self.markdown.append(f"![{text}]({self.folder.name}/{name}.svg)")
            self.html.append(f'<figure class="{name.partition("-")[2]}">{svg}{caption}</figure>')

    def grid(self, header: Sequence[str], rows: Sequence[Sequence[str]], links: str = "") -> None:
        """A table; ``links``: where the first cells lead to, before the number of the row."""
        marks = [k for k, name in enumerate(header) if name == "verdict"]
        lines = [[*map(_plain, header)], ["---"] * len(header)]
        body = ["".join(f"<th>{_escaped(name)}</th>" for name in header)]
        for n, row in enumerate(rows, 1):
            marked = [f"{_MARKS[x]} {x}" if k in marks else x for k, x in enumerate(row)]
            lines.append([*map(_plain, marked)])
            inner = [_escaped(x).replace("–", "\u2060–\u2060") for x in marked]
            if links:
                inner[0] = f'<a href="#{links}{n}">{inner[0].replace("/", "/<wbr>")}</a>'
            words = (f' class="{row[k]}"' if k in marks else "" for k in range(len(row)))
            body.append("".join(f"<td{w}>{x}</td>" for w, x in zip(words, inner, strict=True)))
        self.markdown.append("\n".join(f"| {' | '.join(line)} |" for line in lines))
        head, *trs = (f"<tr>{line}</tr>" for line in body)
        table = ["<table><thead>", head, "</thead><tbody>", *trs, "</tbody></table>"]
        self.html.append(f'<div class="wide">{"".join(table)}</div>')

    def files(self) -> Mapping[Path, str | bytes]:
        """Its files: .md with the figures in a folder beside it, or all in one of HTML."""
        if self.path.suffix.lower() == ".md":
            figures = {self.folder / name: svg for name, svg in self.svgs.items()}
            return {self.path: "\n\n".join(self.markdown) + "\n", **figures}
        template = (resources.files(__package__) / "report_page.html").read_text(encoding="utf-8")
        parts = "\n".join(self.html)
        return {self.path: Template(template).substitute(title=TITLE, parts=parts)}


def write(texts: Mapping[Path, str | bytes]) -> None:
    """Write the files of a page, all or none, in a folder that is made where it is not there."""
    for path in texts:
        if path.parent.name.endswith("-figures"):
            make_folder(path.parent)
    write_whole(texts)


def page(path: Path, sections: Sequence[SceneSection]) -> Mapping[Path, str | bytes]:
    """The files of a page: a row for each scene, then a section each."""
    to = ReportPage(path)
    to.heading(1, TITLE)
    header, lines = shown(tables(sections)["overview"])
    to.grid([name.replace("_", " ") for name in header], lines, links="scene-")
    to.words(PARTS["overview"].meaning)
    if not to.draws:
        to.words(_NO_FIGURES)
    for k, section in enumerate(sections, 1):
        scene, rows_of = section.scene, section.rows
        title = f"{scene.name}: {one_line(scene.title)}" if scene.title else scene.name
        to.heading(2, title, f"scene-{k}")
        pictures: Mapping[str, tuple[Any, ...]] = {
            "description": (body, scene.body),
            "digits": (digits, scene, rows_of["digits"]),
            "work": (work, rows_of["work"]),
        }
        for name, part in [*PARTS.items()][1:]:
            words, rows = section.words.get(name, ()), rows_of[name]
            if not words and not rows:
                continue
            if part.title:
                to.heading(3, part.title)
            for text in (part.meaning, *words):
                to.words(text)
            if rows:
                if name in pictures:
                    to.picture(f"{k}-{name}", scene.name, part.picture, *pictures[name])
                to.grid(*(_side_by_side(rows) if name == "digits" else _thinned(name, rows)))
        to.heading(3, "Scene")
        to.words(f"Fingerprint {scene.provenance()['case']}.")
        to.words(page_text(scene).strip() + "\n")
    packages = ", ".join(f"{name} {version}" for name, version in versions().items())
    to.heading(2, "Provenance")
    to.words(f"{packages}; {cpu()}. Seconds are processor seconds on this machine.")
    return to.files()


def _thinned(name: str, rows: Sequence[ReportRow]) -> tuple[list[str], list[list[str]]]:
    """A table for people, of each run or file a few rows."""
    most = len(rows) if name in ("description", "work") else ROWS
    groups = [[*own] for _, own in groupby(rows, lambda row: row[0])]
    table = _table(name, [("", [own[k] for own in groups for k in few(len(own), most)])])
    header, lines = shown(table)
    return [name.replace("_", " ") for name in header], lines


def _side_by_side(rows: Sequence[ReportRow]) -> tuple[list[str], list[list[str]]]:
    """Times down, runs and files across: the digits, and in brackets the band expected."""
    names = [*dict.fromkeys(row[0] for row in rows)]
    texts = {(row[0], f"{row[1]:.12g}"): _with_band(*row[2:]) for row in rows}
    counts = Counter(time for _, time in texts)
    times = sorted(counts, key=lambda t: abs(float(t)))
    shared = max(counts.values())  # where files have other times than the scene
    times = [t for t in times if counts[t] == shared or t == times[-1]]
    lines = ([t, *(texts.get((name, t), "") for name in names)] for t in times)
    every = [*lines]
    return ["t", *names], [every[k] for k in few(len(every), ROWS)]


def _with_band(digits: float | None, least: float | None, most: float | None) -> str:
    """Digits, and in brackets the band that is expected."""
    text = "" if digits is None else f"{digits:.2f}"
    return text if least is None else f"{text} ({least:.1f}–{most:.1f})"


def of_tests(path: Path, rows: Sequence[JsonObject]) -> Mapping[Path, str | bytes]:
    """The files of the page of a test suite's judgements.

    ``rows``: of each judgement the test and whether it passed, the scene, the times, the digits,
    and what they mean.
    """
    to = ReportPage(path)
    to.heading(1, TITLE)
    words = {True: "passed", False: "failed"}
    lines = [
        (x["test"], words[x["passed"]], f"{x['worst']:.2f}", x["scene"], x["verdict"]) for x in rows
    ]
    to.grid(["test", "verdict", "digits", "scene", "what they mean"], lines)
    for k, scene in enumerate(dict.fromkeys(x["scene"] for x in rows) if to.draws else (), 1):
        curves = [
            (x["test"].rpartition("::")[2], t, d, None, None)
            for x in rows
            if x["scene"] == scene
            for t, d in zip(x["t"], x["digits"], strict=True)
        ]
        to.heading(2, scene)
        text = "correct digits over time"
        to.picture(f"{k}-digits", scene, text, digits, None, curves)
    return to.files()


# --- figures --------------------------------------------------------------------------------------
#
# Digits over time, speed against error, the body.
#
# They stand on pages that are dark or light: what is black takes the colour of the page's text.


SIZE = 4.4, 2.9  # inches: text of 9 points is 9 pixels and more on a page 400 pixels wide
OTHERS = (SPACE, "#8c6d00", "#7d5bbe", "#1b9e9e", "#c0392b")  # of files, beside number types
_DARK = "@media (prefers-color-scheme: dark) { svg { color: #e8e8e8 } }"
_SEEN_FROM = np.array([[-0.64, 0.77, 0.0], [-0.3, -0.25, 0.92]])  # across and up, of the body axes


def digits(plt: Any, scene: Scene | None, rows: Sequence[ReportRow]) -> Any:
    """Correct digits over time of runs and files, over the bands that are expected of the runs.

    ``rows``: name, t, digits, and the band's edges, None where unknown.
    """
    figure, panel = plt.subplots(figsize=SIZE, layout="constrained")
    for name, look, (t, right, least, most) in _series(rows):
        style = "-" if name in COLOURS else "--"
        panel.plot(t, right, label=name, ls=style, ms=2.2, **look)
        panel.fill_between(t, least, most, color=look["color"], alpha=0.2, lw=0)
    panel.set(xlabel=time_label(scene), ylabel="correct digits")
    panel.set_ylim(bottom=0)
    return figure


def work(plt: Any, rows: Sequence[ReportRow]) -> Any:
    """Processor time over correct digits; ``rows``: name, tolerance, digits, seconds."""
    figure, panel = plt.subplots(figsize=SIZE, layout="constrained")
    for name, look, (_, right, seconds) in _series(rows):
        order = np.argsort(right, kind="stable")
        panel.plot(right[order], seconds[order], label=name, ms=4, **look)
    panel.set_yscale("log")
    panel.yaxis.set_major_formatter(lambda x, _: power_of_ten(math.log10(x)))
    panel.minorticks_off()
    panel.set(xlabel="correct digits at the end", ylabel="processor seconds")
    return figure


def body(plt: Any, of: Body) -> Any:
    """The ellipsoid of inertia by its three principal sections, and where the centre of mass is."""
    # wide enough for the moments beside the axes, which no layout makes room for
    figure, panel = plt.subplots(figsize=(4.2, 2.2), layout="constrained")
    panel.set_aspect("equal")
    panel.axis("off")
    moments = np.array([to_double(x) for x in of.moments])
    semi = np.sqrt(moments.min() / moments)
    turn = np.linspace(0, 2 * np.pi, 61)
    for k, (x, y) in enumerate((_SEEN_FROM * (semi + 0.25)).T):  # the tips of the axes
        ring = np.insert([np.cos(turn), np.sin(turn)], k, 0, axis=0)
        panel.plot(*(_SEEN_FROM @ (semi[:, None] * ring)), color=COLOURS["double"], lw=0.8)
        panel.plot([0, x], [0, y], color="#000000", lw=0.5)
        side = "center" if k == 2 else "left" if x > 0 else "right"
        text = f"{'ABC'[k]} = {moments[k]:.4g}"
        panel.annotate(text, (x, y), ha=side, va="bottom" if k == 2 else "top")
    torque = np.array([to_double(x) for x in of.axes.components(of.torque)])
    if (size := float(np.linalg.norm(torque))) > 0:
        x, y = _SEEN_FROM @ (0.8 * torque / size)
        arrow = {"arrowstyle": "-|>", "color": SPACE, "lw": 1.4}
        panel.annotate("", (x, y), (0, 0), arrowprops=arrow)
    return figure


def drawn(title: str, draw: Callable[..., Any], *subject: Any) -> str:
    """The SVG text of a figure of a subject; ``draw``: one of the functions above."""
    with canvas.paper() as plt:
        figure = draw(plt, *subject)
        figure.patch.set_visible(False)
        for panel in figure.axes:
            panel.patch.set_visible(False)
            panel.grid(color="#888888", alpha=0.3)
            if panel.get_legend_handles_labels()[1]:
                canvas.legend(figure.legend, [panel], loc="outside upper left", ncols=3)
        svg = canvas.as_svg(figure, title)
    svg = svg[svg.index("<svg") :].replace("#000000", "currentColor")
    head = f'<svg fill="currentColor" role="img" aria-label="{escape(printable(title))}"'
    head, _, rest = svg.replace("<svg", head, 1).partition(">")
    return f"{head}>\n<style>{_DARK}</style>{rest}"


def _series(rows: Sequence[ReportRow]) -> Iterator[tuple[str, dict[str, str], Doubles]]:
    """The columns of each run or file, with colour and mark: a number type's own, or another's."""
    others = cycle(OTHERS)
    for name in dict.fromkeys(row[0] for row in rows):
        colour = COLOURS.get(name) or next(others)
        look = {"color": colour, "marker": MARKS.get(name, "x")}
        yield name, look, np.array([row[1:] for row in rows if row[0] == name], dtype=float).T


# -- texts on a page -------------------------------------------------------------------------------


def _plain(text: str) -> str:
    """Text in one line of Markdown, in a cell of a table too."""
    return re.sub(r"([|*<\\])", r"\\\1", one_line(text))


def _escaped(text: str) -> str:
    return escape(printable(text), quote=False)

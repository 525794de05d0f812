"""``polhode report``: an accuracy report of somebody's own scenes and files."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from polhode.common.arguments import of_kind, whole
from polhode.common.errors import BadInput, aligned, counted
from polhode.common.files import check_writable
from polhode.common.interrupts import Message
from polhode.common.provenance import provenance
from polhode.common.values import ByValue, cached_property
from polhode.judging.certified import Certified
from polhode.judging.reference import reference
from polhode.judging.tables.table_file import is_table
from polhode.numbers.number_types import MAX_DIGITS, AnyNumber, AnyVector
from polhode.output import accuracy, report_page
from polhode.output.accuracy import Given, ReportRequest, SceneSection
from polhode.results import places, shown, writer
from polhode.results.cells import TEXT
from polhode.results.result import Result
from polhode.results.table import Fact, Table, table_of_rows
from polhode.results.writer import ENDINGS
from polhode.runs.options import choose_number
from polhode.runs.saved import load_result
from polhode.runs.trajectory import Trajectory
from polhode.scenes import library
from polhode.scenes.scene import Scene, even_times
from polhode.scenes.scene_facts import provenance_fact, scene_facts
from polhode.scenes.vocabulary import REQUESTS

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

#: ``mine.csv=0.8s,h=0.01``: a table, what it cost, and its method's step.
_TOLD = re.compile(
    r"(?P<file>.+?)=(?:(?P<cost>[\d.]+(?:e[+-]?\d+)?)\s*(?P<unit>ms|s|min))?"
    r"(?:(?(cost),)h=(?P<step>[^,=]+))?"
)
_UNITS = {"ms": 1e-3, "s": 1.0, "min": 60.0}
#: What a report of a scene takes, roughly: seconds at least, and for each radian of the motion
#: where there is a closed form, and where a proof judges; the radians that are followed at most.
_LEAST, _RADIAN, _PROOF, _FOLLOWED = 2.0, 4e-4, 0.04, 3e5


def _unsaid(text: str) -> None:
    """A message for nobody."""


@dataclass(frozen=True, repr=False, eq=False)
class Report(Result, ByValue):
    """What :func:`polhode.report` measured: ``tables`` of numbers, and a page of them.

    ``sections``: one for each scene.  ``tables`` by name: overview, runs, digits, drift, events,
    work, files, orders; in each the first column is the scene.

    >>> import polhode
    >>> found = polhode.report("lagrange/nutation", at=[1, 2], number="double")
    >>> found.tables["runs"].rows, 14 < found.column("digits_double")[0] < 16
    (1, True)
    """

    sections: Sequence[SceneSection]

    def __repr__(self) -> str:
        return f"<Report: {counted(len(self.sections), 'scene')}>"

    def __str__(self) -> str:
        header, rows = shown.cells(self.table())
        ends = [header.index(name) for name in ("limit", "regime")]  # long ones, which come last
        order = [k for k in range(len(header)) if header[k] != "reference" and k not in ends]
        used = [k for k in (*order, *ends) if any(row[k] for row in rows)]
        lines = aligned([header[k] for k in used], [[row[k] for k in used] for row in rows])
        files = (f"{x.name}: {x.sentence}" for section in self.sections for x in section.files)
        return "\n".join([*lines, *files])

    @cached_property
    def tables(self) -> Mapping[str, Table]:
        """All numbers, by the names of their tables."""
        return accuracy.tables(self.sections)

    @cached_property
    def figures(self) -> Mapping[str, str]:
        """The figures of the page as SVG, by the names of their files; none without matplotlib."""
        return report_page.figures(self.sections, self._parts)

    @cached_property
    def _parts(self) -> Sequence[Mapping[str, Table]]:
        """The tables of each section."""
        return [accuracy.tables([section]) for section in self.sections]

    def table(self) -> Table:
        """A row for each scene: what it is, the fewest correct digits, and what limits them."""
        return self.tables["overview"]

    def facts(self) -> list[Fact]:
        """The other tables, the text of each scene, and the provenance."""
        texts = [(x.scene.name, scene_facts(x.scene)[1].value) for x in self.sections]
        scenes = table_of_rows({"scene": TEXT, "scene_text": TEXT}, texts)
        others = (Fact(name, x) for name, x in self.tables.items() if name != "overview")
        return [
            *others,
            Fact("scenes", scenes, "each as the text of a file"),
            provenance_fact(provenance("\n".join(text for _, text in texts))),
        ]

    def files(self, path: Path) -> Mapping[Path, str | bytes]:
        """What stands in the files of a page or of numbers, by their places."""
        if path.suffix.lower() in ENDINGS:
            return writer.files(self.content(), path)
        return report_page.page(path, self.sections, self._parts, self.figures).files()

    def save(self, path: str | Path) -> None:
        """Write it: .html, one page; .md, with its figures in a folder beside it; or as a result.

        Parameters
        ----------
        path : str or Path
            Its ending says what: ``.html``, ``.md``, or what every result can be written as.

        Raises
        ------
        BadInput
            Another ending, or a place that cannot be written to.
        """
        of_kind("save", "path", path, (str, Path), "the path of a file")
        check_place(Path(path))
        write(self, [Path(path)])


def check_place(path: Path, inputs: Iterable[Path | None] = ()) -> None:
    """Refuse a path to which no report can be written; raises BadInput."""
    check_writable(path, (*report_page.ENDINGS, *ENDINGS), inputs)
    if path.suffix.lower() in ENDINGS:
        places.check_place(path, "Report", inputs)


def write(of: Report, paths: Iterable[Path]) -> None:
    """Write a report in several ways, all files or none."""
    report_page.write({place: text for path in paths for place, text in of.files(path).items()})


def report(
    *what: Scene | Trajectory | str | Path | Mapping[str, AnyVector] | pd.DataFrame | xr.Dataset,
    number: str | None = None,
    digits: int | None = None,
    end: AnyNumber | None = None,
    at: Iterable[AnyNumber] | None = None,
    columns: Sequence[str] | None = None,
    read: str | None = None,
    max_seconds: float = 20.0,
    progress: Message | None = None,
    forecast: Message | None = None,
) -> Report:
    """Make an accuracy report of scenes, and of other programs' tables of their motions.

    Parameters
    ----------
    *what : Scene, str, Path, Trajectory, mapping, DataFrame or Dataset
        Scenes, by name, path or object; and tables as for :func:`polhode.compare`, each judged
        against the scene named before it, or, if none was, against the scene that a run of
        polhode's holds itself.  ``"mine.csv=0.8s,h=0.01"`` tells what a file cost and its method's
        step; files whose names differ in digits alone are one method's.
    number : str, optional
        One number type, instead of double, extended and quad.
    digits : int, optional
        Correct digits wanted: a run that has them is made too, and verdicts go by them.
    end : number, optional
        The last time, instead of each scene's own.
    at : iterable of numbers, optional
        Output times, instead of each scene's own.
    columns : sequence of str, optional
        The columns of the tables, as for :func:`polhode.compare`.
    read : str, optional
        Readings to apply to the tables, as for :func:`polhode.compare`.
    max_seconds : float
        A limit on each proof that judges where there is no closed form; digits are then measured as
        far in time as one goes.
    progress : callable, optional
        Told what is being done, in words.
    forecast : callable, optional
        Told once, in words, how long all will take, roughly.

    Returns
    -------
    Report
        A result with ``tables`` of all numbers; it saves itself as .html, .md or .json.

    Raises
    ------
    BadInput
        A scene or a table that cannot be read, or a table without a scene.

    Examples
    --------
    >>> import polhode
    >>> mine = polhode.integrate("euler/largest-axis", at=[1, 2])
    >>> found = polhode.report("euler/largest-axis", mine, end=2, number="double")
    >>> found
    <Report: 1 scene>
    >>> 15 < found.column("digits_files")[0] <= 16
    True
    """
    request = ReportRequest(number, digits, max_seconds, columns, read)
    say = progress or _unsaid
    groups = _grouped(what)
    scenes = [_timed(scene, end, at) for scene, _ in groups]
    for scene in scenes:
        if number is not None:
            choose_number(scene, number, digits)
        elif digits is not None:
            whole(scene.name, "digits", digits, 1, MAX_DIGITS)
    judged = []
    for scene, tables in groups:  # what cannot be read is refused before the work
        say(f"{scene.name}: {counted(len(tables), 'table')}")
        judged.append([accuracy.of_table(x, scene, request) for x in tables])
    if forecast is not None:
        forecast(_foretold(scenes, groups))
    sections = []
    for k, (scene, files) in enumerate(zip(scenes, judged, strict=True), 1):

        def tell(text: str, which: str = f"{k} of {len(scenes)}") -> None:
            say(f"{which}: {text}")

        sections.append(accuracy.section(scene, files, request, tell))
    return Report(tuple(sections))


def _grouped(sources: Sequence[Any]) -> list[tuple[Scene, list[Given]]]:
    """The scenes, each with the tables that are judged against it; raises BadInput."""
    groups: list[tuple[Scene, list[Given]]] = []
    for k, source in enumerate(sources, 1):
        table_given = None if isinstance(source, Scene) else _table_of(source, k)
        if table_given is None:
            groups.append((library.load(source, takes=REQUESTS), []))
            continue
        if not groups:
            scene = _own_scene(table_given.table)
            if scene is None:
                expected = "a scene before it: polhode report SCENE FILE"
                raise BadInput(table_given.name, "scene", None, expected)
            groups.append((scene, []))
        groups[-1][1].append(table_given)
    if not groups:
        expected = "scenes, and files of them"
        raise BadInput("report", "WHAT", None, expected)
    names = [scene.name for scene, _ in groups]
    for name in names:
        if names.count(name) > 1:
            raise BadInput(
                "report", "WHAT", name, "each scene once, with all of its files after it"
            )
    return groups


def _table_of(source: Any, place: int) -> Given | None:
    """A table; None for what is to be read as a scene."""
    if isinstance(source, Trajectory):
        return Given(f"run of {source.scene.name}", source)
    if not isinstance(source, (str, Path)):
        return Given(f"table {place}", source)
    match = None if Path(source).exists() else _TOLD.fullmatch(str(source))
    name = file_of(str(source))
    if not is_table(name):
        return None
    if match is None:
        return Given(name, name)
    cost = float(match["cost"]) * _UNITS[match["unit"]] if match["cost"] else None
    return Given(name, name, cost, match["step"])


def file_of(text: str) -> str:
    """The name of a file, without what is told of it after it."""
    match = None if Path(text).exists() else _TOLD.fullmatch(text)
    return match["file"] if match else text


def _own_scene(table: Any) -> Scene | None:
    """The scene of a run that polhode made; None of any other table."""
    if isinstance(table, str):
        try:
            table = load_result(table)
        except BadInput:
            return None
    return table.scene if isinstance(table, Trajectory) else None


def _timed(scene: Scene, end: AnyNumber | None, at: Iterable[AnyNumber] | None) -> Scene:
    """The scene at other times, where some are asked for."""
    if end is not None and at is not None:
        raise BadInput("report", "end", end, "no value together with at")
    if at is not None:
        return scene.at(at)
    if end is None:
        return scene
    (last,) = scene.at([end]).times
    if not last:
        raise BadInput(scene.name, "end", end, "a time other than 0")
    return scene.at(even_times(last, max(2, len(scene.times))))


def _foretold(scenes: Sequence[Scene], groups: Sequence[tuple[Scene, Sequence[Given]]]) -> str:
    proofs = [isinstance(reference(scene), Certified) for scene in scenes]
    costs = [_PROOF if proof else _RADIAN for proof in proofs]
    each = zip(costs, scenes, strict=True)
    seconds = sum(_LEAST + cost * min(_FOLLOWED, 10.0**scene.log10_angle) for cost, scene in each)
    tables = sum(len(tables) for _, tables in groups)
    also = f" and {counted(tables, 'table')}" if tables else ""
    return f"{counted(len(scenes), 'scene')}{also}: about {seconds + tables:.0f} s"

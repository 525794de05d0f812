"""``polhode report``: an accuracy report of somebody's own scenes and files."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, count
from pathlib import Path
from typing import TYPE_CHECKING, Any

from polhode.common.arguments import of_kind, whole, with_progress
from polhode.common.errors import BadInput, aligned, counted
from polhode.common.files import check_writable, refuse_foreign
from polhode.common.interrupts import Message
from polhode.common.provenance import provenance
from polhode.common.values import ByValue, cached_property
from polhode.judging.reference import reference
from polhode.judging.tables.column_aliases import AbsentColumn
from polhode.judging.tables.table_file import is_table
from polhode.numbers.conversion import exact_number, to_double
from polhode.numbers.number_types import MAX_DIGITS, AnyNumber, AnyVector
from polhode.output import accuracy, report_page
from polhode.output.accuracy import GivenTable, ReportRequest, SceneSection
from polhode.output.report_page import shown, tables
from polhode.results import writer
from polhode.results.cells import TEXT
from polhode.results.result import Result
from polhode.results.table import Fact, Table, table_of_rows
from polhode.runs.options import choose_number
from polhode.runs.saved import load_result
from polhode.runs.trajectory import Trajectory
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import provenance_fact, scene_facts
from polhode.scenes.vocabulary import REQUESTS

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

#: ``mine.csv=0.8s,h=0.01``: a table, what it cost, and its method's step.
_FILE = re.compile(
    r"(?P<file>.+?)=(?!$)(?:(?P<cost>(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)\s*(?P<unit>ms|s|min))?"
    r"(?:(?(cost),)h=(?P<step>[^,=]+))?"
)
_UNITS = {"ms": 1e-3, "s": 1.0, "min": 60.0}
#: What a report of a scene takes, roughly: seconds at least, and for each radian of the motion
#: where there is a closed form, and where a proof judges; the radians that are followed at most.
_LEAST, _RADIAN, _PROOF, _FOLLOWED = 2.0, 4e-4, 0.04, 3e5


@dataclass(frozen=True, repr=False, eq=False)
class Report(Result, ByValue):
    """What :func:`polhode.report` measured: ``tables`` of numbers, and a page of them.

    ``sections``: one for each scene.  ``tables`` by name: overview, description, digits, runs,
    files, orders, drift, events, work; in each the first column is the scene.

    >>> import polhode
    >>> found = polhode.report("lagrange/nutation", at=[1, 2], number="double")
    >>> found.tables["runs"].rows, 14 < found.column("digits_double")[0] < 16
    (1, True)
    """

    sections: Sequence[SceneSection]

    def __repr__(self) -> str:
        return f"<Report: {counted(len(self.sections), 'scene')}>"

    def __str__(self) -> str:
        files = (f"{row[0]}: {row[-1]}" for x in self.sections for row in x.rows["files"])
        return "\n".join([*aligned(*shown(self.table())), *files])

    @cached_property
    def tables(self) -> Mapping[str, Table]:
        """All numbers, by the names of their tables."""
        return tables(self.sections)

    def table(self) -> Table:
        """A row for each scene: the fewest correct digits, what limits them, what it is."""
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
        if Path(path).suffix.lower() in writer.ENDINGS:
            return super().save(path)
        check_writable(Path(path), (*report_page.ENDINGS, *writer.ENDINGS))
        refuse_foreign(Path(path))
        report_page.write(report_page.page(Path(path), self.sections))
        return None


@with_progress
def report(
    *what: Scene | Trajectory | str | Path | Mapping[str, AnyVector] | pd.DataFrame | xr.Dataset,
    number: str | None = None,
    digits: int | None = None,
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
        Scenes (cases that ship, paths, objects), and tables as for :func:`polhode.compare` (a CSV
        with the header t,p,q,r,gamma1,gamma2,gamma3, say), each after the scene that it is judged
        against (a run of polhode's may stand first, and is judged against the scene that it holds);
        mine.csv=0.8s tells what a file cost, mine.csv=h=0.01 its method's step,
        mine.csv=0.8s,h=0.01 both; files whose names differ in digits alone are one method's, whose
        order is told by these steps.
    number : str, optional
        One number type (double, extended, quad, mp) in place of the first three.
    digits : int, optional
        Correct digits wanted: a run to them is made too, and verdicts go by them.
    at : iterable of numbers, optional
        Output times, instead of each scene's own.
    columns : sequence of str, optional
        Of the tables: their columns in order, or some of them, as for :func:`polhode.compare`.
    read : str, optional
        Of the tables: readings to apply, in their words, as for :func:`polhode.compare`.
    max_seconds : float
        A limit in seconds on each proof that judges where there is no closed form (20).  Digits are
        then measured as far in time as one goes.
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
    >>> found = polhode.report("euler/largest-axis", mine, at=[1, 2], number="double")
    >>> found
    <Report: 1 scene>
    >>> 15 < found.column("digits_files")[0] <= 16
    True
    """
    request = ReportRequest(number, digits, max_seconds, columns, read)
    say = progress or (lambda text: None)
    at = [*at] if isinstance(at, Iterator) else at  # each scene reads them
    groups = [(x if at is None else x.at(at), tables) for x, tables in _grouped(what)]
    for scene, _ in groups:
        if number is not None:
            choose_number(scene, number, digits)
        elif digits is not None:
            whole(scene.name, "digits", digits, 1, MAX_DIGITS)
    files, absent = [], list[AbsentColumn]()
    for scene, tables_given in groups:  # what cannot be read is refused before the work
        say(f"{scene.name}: {counted(len(tables_given), 'table')}")
        files.append([accuracy.of_table(x, scene, request, absent) for x in tables_given])
    count_named = sum(not isinstance(x.table, Trajectory) for _, own in groups for x in own)
    for fault in absent:  # of names that no table has
        if sum(x.value == fault.value for x in absent) == count_named:
            raise fault
    if forecast is not None:
        forecast(_foretold(groups))
    pairs = zip(groups, files, strict=True)
    return Report(tuple(accuracy.section(scene, x, request, say) for (scene, _), x in pairs))


def _grouped(sources: Sequence[Any]) -> list[tuple[Scene, list[GivenTable]]]:
    """The scenes, each with the tables that are judged against it; raises BadInput."""
    groups: list[tuple[Scene, list[GivenTable]]] = []
    for k, source in enumerate(sources, 1):
        table = None if isinstance(source, Scene) else _table_of(source, k)
        if table is None:
            groups.append((library.load(source, takes=REQUESTS), []))
            continue
        if not groups:
            groups.append((_own_scene(table), []))
        there = {x.name for x in groups[-1][1]}
        labels = chain([table.name], (f"{table.name} ({k})" for k in count(2)))
        groups[-1][1].append(table._replace(name=next(x for x in labels if x not in there)))
    names = [scene.name for scene, _ in groups]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None or not names:
        expected = "each scene once, with all of its files after it"
        raise BadInput("report", "WHAT", twice, expected if names else "scenes, and files of them")
    return groups


def _table_of(source: Any, place: int) -> GivenTable | None:
    """A table; None for what is to be read as a scene."""
    if isinstance(source, Trajectory):
        return GivenTable(f"run of {source.scene.name}", source)
    if not isinstance(source, (str, Path)):
        return GivenTable(f"table {place}", source)
    table = file_of(str(source))
    return table if is_table(table.name) else None


def _refuse_no_step(name: str, step: str) -> None:
    """Raise BadInput for what is no step of a method."""
    try:
        length = to_double(exact_number(step))
    except ValueError as fault:
        raise BadInput(name, "h", step, f"the step of its method ({fault})") from None
    if not 0 < length < math.inf:
        raise BadInput(name, "h", step, "the step of its method, above 0")


def file_of(text: str) -> GivenTable:
    """A file, and what is told of it after its name."""
    match = None if Path(text).exists() else _FILE.fullmatch(text)
    if match is None:
        return GivenTable(text, text)
    name = match["file"]
    cost = float(match["cost"]) * _UNITS[match["unit"]] if match["cost"] else None
    if cost is not None and not 0 < cost < math.inf:
        raise BadInput(name, "cost", f"{match['cost']} {match['unit']}", "a time above 0")
    if match["step"]:
        _refuse_no_step(name, match["step"])
    return GivenTable(name, name, cost, match["step"])


def _own_scene(of: GivenTable) -> Scene:
    """The scene of a run that polhode made; raises BadInput for any other table."""
    run = of.table
    if isinstance(run, str):
        try:
            run = load_result(run)
        except BadInput:
            run = None
    if not isinstance(run, Trajectory):
        raise BadInput(of.name, "scene", None, "a scene before it: polhode report SCENE FILE")
    return run.scene


def _foretold(groups: Sequence[tuple[Scene, Sequence[GivenTable]]]) -> str:
    """How long all will take, in words."""
    seconds = 0.0
    for scene, tables_given in groups:
        cost = _PROOF if not reference(scene).is_closed_form else _RADIAN
        radians = min(_FOLLOWED, 10.0**scene.log10_angle)
        seconds += _LEAST + cost * radians + len(tables_given)
    count = sum(len(tables_given) for _, tables_given in groups)
    also = f" and {counted(count, 'table')}" if count else ""
    return f"{counted(len(groups), 'scene')}{also}: about {seconds:.0f} s"

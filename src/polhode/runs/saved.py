"""Results from their files: runs as they were, callable; all others as what they told."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from polhode.common.arguments import of_kind
from polhode.common.errors import BadInput, nearest
from polhode.common.values import cached_property, same
from polhode.equations.integrals import Drift
from polhode.motion.outcomes import Events, EventTimes, Interpolant, Outcome, Projection, RowReader
from polhode.numbers import number_types
from polhode.numbers.conversion import exactly, number_value, to_double
from polhode.numbers.number_types import NumberType, Row, States, read_only
from polhode.results.reader import DAMAGED, content_of
from polhode.results.result import Result
from polhode.results.table import Content, Fact, Table, Value
from polhode.runs.trajectory import Trajectory, solve
from polhode.scenes import scene_file
from polhode.scenes.scene import Scene, listed_times
from polhode.scenes.vocabulary import ANGLES, ATTITUDE

_GAP = float, type(None)


class Saved(Result):
    """A result that was read from a file: its columns and facts, as attributes by their names.

    ``result``: the name of the class that it was made as.  ``scene``: the scene that it is of.  A
    fact that is a table, such as the orbits of a section, is a
    :class:`polhode.results.table.Table`.

    >>> import os, tempfile, polhode
    >>> found = polhode.levels("general/asymmetric-chaotic")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     found.save(os.path.join(folder, "levels.npz"))
    ...     again = polhode.load_result(os.path.join(folder, "levels.npz"))
    >>> again
    <Saved Levels of general/asymmetric-chaotic: 8 curves, 2 cusps>
    >>> again.result, again.h == found.here.h
    ('Levels', True)
    """

    def __init__(self, content: Content) -> None:
        self._content = content

    @property
    def result(self) -> str:
        """The name of the class that it was made as."""
        return self._content.kind

    def __getattr__(self, name: str) -> Any:
        """A fact or a column by its name: what is no attribute else."""
        if name.startswith("_"):
            raise AttributeError(name)
        values = self._named
        if name in values:
            return values[name]
        if name == "kind":
            warnings.warn("kind of a loaded result is result", DeprecationWarning, stacklevel=2)
            return self.result
        words = nearest(name, [*values])
        raise AttributeError(f"a {self.result} from a file has no {name}: expected {words}")

    @cached_property
    def _named(self) -> dict[str, Any]:
        columns = {x.name: x.values for x in self._content.table.columns}
        return columns | {x.name: x.value for x in self._content.facts}

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._named]

    @cached_property
    def scene(self) -> Scene:
        """The scene that it is of; raises BadInput for a result of none."""
        return scene_file.parse(self.fact("scene_text"), self.fact("scene"))

    def content(self) -> Content:
        """What its file holds."""
        return self._content

    def table(self) -> Table:
        """Its columns."""
        return self._content.table

    def facts(self) -> Sequence[Fact]:
        """Its facts."""
        return self._content.facts

    def __repr__(self) -> str:
        return f"<Saved {self._content.title.removeprefix('<').removesuffix('>')}>"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Saved) and same(self._content, other._content)

    __hash__ = None  # type: ignore[assignment]


def load_result(path: str | Path) -> Trajectory | Saved:
    """Load what ``.save`` of any result, or ``-o`` of the command line, wrote.

    Parameters
    ----------
    path : str or Path
        A file ``.csv``, ``.json``, ``.npz`` or ``.parquet``; of a CSV file the facts are read from
        the file beside it.

    Returns
    -------
    Trajectory or Saved
        A run is equal to what was saved, and callable; any other result has the columns and facts
        that it had, as attributes, too: ``load_result("orbit.json").period``.

    Raises
    ------
    BadInput
        A file of another kind, one that was changed, or a damaged one.

    Examples
    --------
    >>> import os, tempfile, polhode
    >>> run = polhode.integrate("lagrange/nutation", at=[1, 2])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run.save(os.path.join(folder, "run.json"))
    ...     again = polhode.load_result(os.path.join(folder, "run.json"))
    >>> again == run, list(again(1.5)) == list(run(1.5))
    (True, True)
    """
    of_kind("load_result", "path", path, (str, Path), "the path of a file")
    try:
        content = content_of(Path(path))
        return run_of(content) if content.kind == Trajectory.__name__ else Saved(content)
    except BadInput:
        raise
    except DAMAGED as fault:
        words = "it is damaged" if isinstance(fault, KeyError) else str(fault)
        raise BadInput(str(path), "file", None, f"a result that polhode saved ({words})") from None


def load_run(path: str | Path) -> Trajectory:
    """Load a run, as :func:`load_result` does.

    Parameters
    ----------
    path : str or Path
        A file in which a run was saved.

    Returns
    -------
    Trajectory
        Equal to what was saved, and callable.

    Raises
    ------
    BadInput
        Any other file, that of another kind of result, too.

    Examples
    --------
    >>> import os, tempfile, polhode
    >>> run = polhode.integrate("lagrange/nutation", at=[1, 2])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run.save(os.path.join(folder, "run.npz"))
    ...     again = polhode.load_run(os.path.join(folder, "run.npz"))
    >>> again == run
    True
    """
    run = load_result(path)
    if not isinstance(run, Trajectory):
        expected = f"a run that polhode saved (it holds a result {run.result})"
        raise BadInput(str(path), "file", None, expected)
    return run


def run_of(content: Content) -> Trajectory:
    """The run of a content; raises ValueError and the like for one that is none."""
    facts = {x.name: x.value for x in content.facts}
    number = _number(facts["number"], facts["bits"])
    columns = _columns(content.table, number)
    times = tuple(map(exactly, columns["t"]))
    scene, outcome = _scene(facts, times), Outcome(facts["outcome"])
    outputs = scene.output_times.rounded(number)
    count = len(times)
    if outputs[:count] != times or (outcome is Outcome.REACHED_END and count < len(outputs)):
        raise ValueError("times: not those of the scene")
    angles = errors = attitude = projection = inputs = None
    digits, events = facts["digits"], Events(())
    if digits is not None and not 0 < _whole(digits) <= number_types.MAX_DIGITS:
        raise ValueError("no digits of a run")
    if scene.events:
        events = _events(facts, scene, number)
    if facts.get("projection") is not None:
        projection = _projection(facts["projection"])
    if facts.get("inputs") is not None:
        inputs = NumberType(_of(str, facts["inputs"]["name"]), _bits(facts["inputs"]["bits"]))
    if "psi" in columns:
        rows = zip(*(columns[name] for name in ANGLES), strict=True)
        angles = tuple(tuple(map(_number_or_none, row)) for row in rows)
    if "q0" in columns:
        attitude = _rows(columns, ATTITUDE, number)
    if "error" in columns:
        errors = tuple(map(_number_or_none, columns["error"]))
    run = Trajectory(
        scene=scene,
        number=number,
        times=times,
        states=_rows(columns, scene.columns, number),
        outcome=outcome,
        steps=_whole(facts["steps"]),
        reached=exactly(facts["reached"]),
        tolerance=float(_of((int, float), facts["tolerance"])),
        digits=digits,
        attitude=attitude,
        angles=angles,
        events=events,
        projection=projection,
        provenance=_of(dict, facts["provenance"]),
        method=_of(str, facts["method"]),
        errors=errors,
        correct_digits=_of(_GAP, facts["correct_digits"]),
        checked_by=_of(str, facts["checked_by"]),
        inputs=inputs,
    )
    if not 0 <= run.tolerance < math.inf or run.method not in ("taylor", "refined"):
        raise ValueError("no tolerance or method of a run")
    vars(run).update(dense=_Recomputed(run))
    drift = Drift(**{name: _of(_GAP, facts[f"drift_{name}"]) for name in Drift._fields})
    outlook = _of(_GAP, facts["digits_expected"]), _of(_GAP, facts["lost_after"])
    vars(run).update(drift=drift, _least_expected=outlook)
    return run


def _number(name: Value, bits: Value) -> NumberType:
    number_type = NumberType(_of(str, name), _bits(bits))
    if name not in number_types.NAMES or not number_types.is_possible(number_type):
        raise ValueError(f"number: {name} of {bits} bits")
    return number_type


def _bits(value: Value) -> int:
    if not _whole(value):
        raise ValueError("no bits")
    return int(value)


def _columns(table: Table, number_type: NumberType) -> dict[str, Any]:
    """Columns by name; those of an mp of 64 bits are read as numbers of extended, and are its."""
    columns = {x.name: x.values for x in table.columns}
    if number_type.name == "mp":
        for name, values in columns.items():
            if isinstance(values, np.ndarray) and values.dtype == np.longdouble:
                numbers = [
                    None if x != x else number_value(exactly(x), number_type) for x in values
                ]
                columns[name] = np.array(numbers, dtype=np.object_)
    return columns


def _scene(facts: Mapping[str, Value], times: tuple[Fraction, ...]) -> Scene:
    """The scene of its text; times that this leaves out are those of an array, in the column t."""
    text, source = _of(str, facts["scene_text"]), facts["scene_source"]
    scene = scene_file.parse(text, _of(str, facts["scene"]))
    if not len(scene.times) and times:
        listed = np.array([to_double(t) for t in times])
        scene = scene.at(listed_times(scene.name, "t", listed))
    return scene if source is None else replace(scene, source=_of(str, source))


def _rows(columns: Mapping[str, Any], names: Sequence[str], number_type: NumberType) -> States:
    first = columns[names[0]]
    rows: Any = np.empty((len(first), len(names)), dtype=first.dtype)
    for k, name in enumerate(names):
        part = columns[name]
        flat = part.dtype.kind == "f"
        finite = (
            np.isfinite(part).all() if flat else all(x is not None and x - x == 0 for x in part)
        )
        if part.dtype != rows.dtype or not finite:
            raise ValueError(f"{name}: not all are numbers of the run")
        rows[:, k] = part
    kinds = {"double": np.float64, "extended": np.longdouble}
    if rows.dtype != kinds.get(number_type.name, np.object_):
        raise ValueError(f"{names[0]}: no {number_type.name} numbers")
    return read_only(rows, len(names))


def _events(facts: Mapping[str, Value], scene: Scene, number_type: NumberType) -> Events:
    columns = _columns(facts["events"], number_type)
    names = columns["event"]
    if not {*names} <= {event.name for event in scene.events}:
        raise ValueError("events: not those of the scene")
    lists = []
    for event, complete in zip(scene.events, facts["events_complete"], strict=True):
        place = [k for k, name in enumerate(names) if name == event.name]
        rows = {name: _picked(values, place) for name, values in columns.items()}
        signs = tuple(rows["sign"].tolist())
        if not {*signs} <= {-1, 0, 1}:
            raise ValueError("sign: expected -1, 1, and 0 where they graze")
        lists.append(
            EventTimes(
                event.name,
                tuple(exactly(t) for t in rows["t"]),
                _rows(rows, scene.columns, number_type),
                signs,
                tuple(rows["uncertainty"].tolist()),
                tuple(rows["depth"].tolist()),
                _of(bool, complete),
            )
        )
    return Events(tuple(lists))


def _picked(values: Any, place: Sequence[int]) -> Any:
    return [values[k] for k in place] if isinstance(values, list) else values[list(place)]


def _projection(fact: Mapping[str, Value]) -> Projection:
    return Projection(
        tuple(_of(str, name) for name in fact["onto"]),
        _whole(fact["every"]),
        _whole(fact["count"]),
        float(_of((int, float), fact["largest"])),
        float(_of((int, float), fact["sum"])),
    )


def _number_or_none(x: Any) -> Any:
    return None if x is None or x != x else x


def _of(kind: type | tuple[type, ...], value: Value) -> Any:
    if not isinstance(value, kind):
        raise ValueError(f"{str(value)[:40]!r}: a value of another type")
    return value


def _whole(value: Value) -> int:
    if type(value) is not int or value < 0:
        raise ValueError(f"{str(value)[:40]!r}: no whole number")
    return value


class _Recomputed:
    """A loaded run at any time: the run made once more when it is first asked."""

    def __init__(self, run: Trajectory) -> None:
        self.run = run

    @property
    def read(self) -> RowReader:
        """What reads its rows."""
        return self.dense.read

    def at(self, times: Sequence[Fraction]) -> tuple[Sequence[Row], Outcome, Fraction]:
        """Rows at exact times, see :class:`polhode.motion.outcomes.Interpolant`."""
        return self.dense.at(times)

    @cached_property
    def dense(self) -> Interpolant:
        """The dense output of the run made once more."""
        from polhode.taylor.motion import Motion  # heyoka: a file is read without

        run = self.run
        again = solve(run.scene, run.number, run.options)
        size = len(run.times)
        if not same(list(again.states[:size]), list(run.states)):
            warnings.warn(
                f"{run.scene.name}: computed again on this machine, the run differs from the "
                "one in the file in its last digits",
                stacklevel=4,
            )
        assert again.dense is not None
        if isinstance(again.dense, Motion):
            again.dense.reached = run.reached  # one that was limited went on a little
        return again.dense

"""A run in a file: NPZ without pickles, which loads again with every digit, and callable."""

from __future__ import annotations

import io
import json
import warnings
import zipfile
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from polhode.common.errors import BadInput
from polhode.common.files import check_writable, npz, read_whole, write_whole
from polhode.common.values import same
from polhode.numbers import expression
from polhode.numbers.convert import number_value
from polhode.numbers.decimals import decimal_in_full, strings
from polhode.numbers.number_types import NumberType
from polhode.output.results import as_json
from polhode.runs import integrate as runs
from polhode.runs.trajectory import Trajectory
from polhode.scenes import scene_file
from polhode.scenes.scene import Scene
from polhode.scenes.scene_text import toml
from polhode.taylor.outcomes import EventTimes, Outcome, Projection

FORMAT = "polhode run 1"
MAX_BYTES = 1 << 31
_PARTS = ("states", "attitude", "angles")


def save(run: Trajectory, path: str | Path) -> None:
    """Write a run to a file; the name ends in .npz; raises BadInput."""
    path = Path(path)
    check_writable(path, [".npz"])
    about: dict[str, Any] = {
        "format": FORMAT,
        "name": run.scene.name,
        "number": run.number.name,
        "bits": run.number.bits,
        "outcome": run.outcome.value,
        "steps": run.steps,
        "reached": decimal_in_full(run.reached),
        "tolerance": run.tolerance.hex(),
        "digits": run.digits,
        "method": run.method,
        "correct_digits": run.correct_digits,
        "checked_by": run.checked_by,
        "projection": None if run.projection is None else vars(run.projection),
        "events": [{"name": e.name, "complete": e.complete} for e in run.events],
        "provenance": dict(run.provenance),
    }
    held: dict[str, Any] = {
        "scene": np.array(toml(run.scene)),
        "source": np.array(run.scene.source),
        "times": np.array(run.time_strings(), dtype=np.str_),
    }
    for name in _PARTS:
        rows = getattr(run, name)
        if rows is not None:
            held[name] = _texts(rows, run.number)
    if run.errors is not None:
        held["errors"] = np.array([np.nan if x is None else x for x in run.errors])
    for k, event in enumerate(run.events):
        held[f"event{k}_times"] = np.array(event.time_strings(), dtype=np.str_)
        held[f"event{k}_states"] = _texts(event.states, run.number)
        held[f"event{k}_grazing"] = np.array(event.grazing, dtype=bool)
    held["about"] = np.array(as_json(about))
    write_whole({path: npz(held, packed=True)})


def load_run(path: str | Path) -> Trajectory:
    """The run that ``run.save`` wrote: equal to it, and callable again; raises BadInput.

    Called at a time between its samples, it is integrated once more, the same steps; where this
    machine does not find the same numbers to the last bit, a warning says so.

    >>> import os, tempfile, polhode
    >>> run = polhode.integrate("lagrange/nutation", at=[1, 2])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run.save(os.path.join(folder, "run.npz"))
    ...     again = polhode.load_run(os.path.join(folder, "run.npz"))
    >>> again == run, list(again(1.5)) == list(run(1.5))
    (True, True)
    """
    name = str(path)
    try:
        raw = io.BytesIO(read_whole(Path(path), MAX_BYTES, "a run that polhode saved"))
        with np.load(raw, allow_pickle=False) as file:
            held = {key: file[key] for key in file.files}
        about = json.loads(str(held["about"]))
        if about["format"] != FORMAT:
            raise ValueError(f"format {about['format']!r}")
        scene = scene_file.parse(str(held["scene"]), about["name"])
        return _run(held, about, replace(scene, source=str(held["source"])))
    except BadInput:
        raise
    except (KeyError, TypeError, ValueError, zipfile.BadZipFile, EOFError, OSError) as fault:
        expected = f"a run that polhode saved ({fault})"
        raise BadInput(name, "file", None, expected) from None


def _run(held: dict[str, Any], about: dict[str, Any], scene: Scene) -> Trajectory:
    number = NumberType(about["number"], int(about["bits"]))
    parts = {name: _numbers(held[name], number) for name in _PARTS if name in held}
    if "angles" in parts:
        parts["angles"] = [list(row) for row in parts["angles"]]
    events = tuple(
        EventTimes(
            told["name"],
            _times(held[f"event{k}_times"]),
            _numbers(held[f"event{k}_states"], number),
            tuple(bool(x) for x in held[f"event{k}_grazing"]),
            told["complete"],
        )
        for k, told in enumerate(about["events"])
    )
    projection = about["projection"]
    if projection is not None:
        projection = Projection(**(projection | {"onto": tuple(projection["onto"])}))
    errors = held.get("errors")
    found = Trajectory(
        scene=scene,
        number=number,
        times=_times(held["times"]),
        outcome=Outcome(about["outcome"]),
        steps=about["steps"],
        reached=expression.decimal(about["reached"]),
        tolerance=float.fromhex(about["tolerance"]),
        digits=about["digits"],
        method=about["method"],
        correct_digits=about["correct_digits"],
        checked_by=about["checked_by"],
        events=events,
        projection=projection,
        errors=None if errors is None else tuple(None if x != x else float(x) for x in errors),
        provenance=about["provenance"],
        **parts,
    )
    object.__setattr__(found, "dense", _Again(found))
    return found


class _Again:
    """A loaded run's states at any time: the run made once more when it is first asked."""

    def __init__(self, run: Trajectory) -> None:
        self.run = run
        self.made: Any = None

    def __call__(self, t: Any) -> Any:
        return self.dense(t)

    @property
    def dense(self) -> Any:
        """The dense output of the run made once more."""
        if self.made is None:
            run = self.run
            every = None if run.projection is None else run.projection.every
            again = runs.integrate(
                run.scene,
                run.number,
                digits=run.digits,
                tol=None if run.at_full_tolerance else run.tolerance,
                project=False if every is None else every,
                method=run.method,
            )
            kept = len(run.times)
            if not same(list(again.states[:kept]), list(run.states)):
                warnings.warn(
                    f"{run.scene.name}: made once more on this machine, the run differs from the "
                    "one in the file in its last digits",
                    stacklevel=4,
                )
            self.made = again.dense
        return self.made


def _texts(rows: Any, number: NumberType) -> Any:
    """Rows as decimal strings that round-trip, empty where undefined; shape (n, columns)."""
    if len(rows) == 0:
        return np.array([], dtype=np.str_)
    kept = [["" if x is None else x for x in row] for row in strings(rows, number)]
    return np.array(kept, dtype=np.str_)


def _numbers(texts: Any, number: NumberType) -> Any:
    """The numbers of the type that strings stand for, as a trajectory holds them."""
    rows = [
        [
            None if not x else number_value(number.rounded(expression.decimal(str(x))), number)
            for x in row
        ]
        for row in texts
    ]
    if not number.flat or any(x is None for row in rows for x in row):
        return rows
    kind = np.float64 if number.name == "double" else np.longdouble
    return np.array(rows, dtype=kind)


def _times(texts: Any) -> tuple[Fraction, ...]:
    return tuple(expression.decimal(str(x)) for x in texts)

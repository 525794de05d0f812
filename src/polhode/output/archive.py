"""A run in a file: NPZ without pickles, which loads again with every digit, and callable."""

from __future__ import annotations

import json
import math
import warnings
from collections.abc import Sequence
from dataclasses import asdict, replace
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from polhode.common.arguments import of_kind
from polhode.common.errors import UNREADABLE, BadInput
from polhode.common.files import read_npz, read_whole
from polhode.common.value_semantics import same
from polhode.motion.outcomes import Events, EventTimes, Outcome, Projection
from polhode.motion.protocols import Interpolant, RowReader
from polhode.numbers.conversion import number_value
from polhode.numbers.decimals import in_full, strings
from polhode.numbers.number_types import LEAST_MP_BITS, MAX_DIGITS, NAMES, NumberType, named
from polhode.numbers.rows import Given, Row, read_only
from polhode.output.json_object import JsonObject
from polhode.output.json_results import as_json
from polhode.results import reader
from polhode.runs import saved
from polhode.runs.trajectory import Trajectory
from polhode.scenes import scene_file
from polhode.scenes.scene import Scene
from polhode.scenes.scene_text import as_toml
from polhode.scenes.vocabulary import ATTITUDE, COLUMNS

if TYPE_CHECKING:
    import numpy.typing as npt

FORMAT = "polhode run 1"
MAX_BYTES = 1 << 31
MOST_BITS = 1 << 16  # of a number in a file
MOST_CHARACTERS = 70_000  # of a decimal, and the most that its exponent may be
#: What a file that is no run makes reading it raise.
DAMAGED = (LookupError, TypeError, AttributeError, ArithmeticError, MemoryError, *UNREADABLE)
_Held: TypeAlias = "dict[str, npt.NDArray[np.generic]]"


def arrays(run: Trajectory) -> JsonObject:
    """The arrays of a run's NPZ file, none of which needs pickle."""
    about: JsonObject = {
        "format": FORMAT,
        "name": run.scene.name,
        "number": run.number.name,
        "bits": run.number.bits,
        "outcome": run.outcome.value,
        "steps": run.steps,
        "reached": in_full(run.reached),
        "tolerance": run.tolerance.hex(),
        "digits": run.digits,
        "method": run.method,
        "correct_digits": run.correct_digits,
        "checked_by": run.checked_by,
        "projection": None if run.projection is None else asdict(run.projection),
        "events": [{"name": e.name, "complete": e.complete} for e in run.events],
        "provenance": dict(run.provenance),
    }
    held: JsonObject = {
        "scene": np.array(as_toml(run.scene)),
        "source": np.array(run.scene.source),
        "times": np.array(run.time_strings(), dtype=np.str_),
    }
    for name in _parts(run.scene):
        rows = getattr(run, name)
        if rows is not None:
            held[name] = _texts(rows, run.number)
    if run.errors is not None:
        held["errors"] = np.array([np.nan if x is None else x for x in run.errors])
    for k, event in enumerate(run.events):
        held[f"event{k}_times"] = np.array(event.time_strings(), dtype=np.str_)
        held[f"event{k}_states"] = _texts(event.states, run.number)
        held[f"event{k}_grazing"] = np.array(event.grazing, dtype=bool)
        held[f"event{k}_signs"] = np.array(event.signs, dtype=np.int8)
        held[f"event{k}_uncertainty"] = np.array(event.uncertainty, dtype=float)
        held[f"event{k}_depths"] = np.array(event.depths, dtype=float)
    held["about"] = np.array(as_json(about))
    return held


def load_run(path: str | Path) -> Trajectory:
    """Load the run that ``run.save`` wrote: equal to it, and callable again.

    When it is called at a time between its samples, it is integrated again with the same steps; if
    the numbers are not the same to the last bit on this machine, a warning says so.

    Parameters
    ----------
    path : str or Path
        A file that ``run.save`` wrote.

    Returns
    -------
    Trajectory
        The run.

    Raises
    ------
    BadInput
        A file of another kind, or a damaged one.

    Examples
    --------
    >>> import os, tempfile, polhode
    >>> run = polhode.integrate("lagrange/nutation", at=[1, 2])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run.save(os.path.join(folder, "run.npz"))
    ...     again = polhode.load_run(os.path.join(folder, "run.npz"))
    >>> again == run, list(again(1.5)) == list(run(1.5))
    (True, True)
    """
    of_kind("load_run", "path", path, (str, Path), "the path of a .npz file")
    name = str(path)
    if reader.is_result(Path(path)):
        return saved.load_run(path)
    if Path(path).suffix.lower() in (".csv", ".json", ".parquet"):
        raise BadInput(name, "file", None, "a .npz file; polhode.load_result reads this one")
    expected = "a run that polhode saved"
    data = read_whole(Path(path), MAX_BYTES, expected)
    try:
        return run_of(read_npz(data))
    except DAMAGED as fault:
        raise BadInput(name, "file", None, f"{expected} ({fault})") from None


def run_of(held: _Held) -> Trajectory:
    """The run of these arrays; raises one of DAMAGED for others."""
    about = json.loads(str(held["about"]), parse_constant=_no_constant)
    if about["format"] != FORMAT:
        raise ValueError(f"format {about['format']!r}")
    scene = scene_file.parse(str(held["scene"]), _told(about, "name", str))
    return _run(held, about, replace(scene, source=str(held["source"])))


def _run(held: _Held, about: JsonObject, scene: Scene) -> Trajectory:
    number, outcome = _number(about), Outcome(about["outcome"])
    ends, count = outcome is Outcome.REACHED_END, held["times"].size
    if count > len(scene.times) or (ends and count < len(scene.times)):
        raise ValueError("times: not those of the scene")
    times = _times(held, "times")
    if scene.output_times.rounded(number)[:count] != times:
        raise ValueError("times: not those of the scene")
    rows = {
        name: _numbers(held, name, number, (len(times), width))
        for name, width in _parts(scene).items()
        if name in held or name == "states"
    }
    if any(x is None for row in rows["states"] for x in row):
        raise ValueError("states: not all are numbers")
    widths = {"states": len(scene.columns), "attitude": len(ATTITUDE)}
    for name in widths.keys() & rows.keys():
        rows[name] = read_only(rows[name], widths[name])
    if "angles" in rows:
        rows["angles"] = tuple(tuple(row) for row in rows["angles"])
    errors = None
    if "errors" in held:
        found = _array(held, "errors", "f", (len(times),))
        errors = tuple(None if x != x else float(x) for x in found.tolist())
    run = Trajectory(
        scene=scene,
        number=number,
        times=times,
        outcome=outcome,
        steps=_told(about, "steps", int),
        reached=_decimal(_told(about, "reached", str)),
        tolerance=float.fromhex(_told(about, "tolerance", str)),
        digits=_told(about, "digits", int, None),
        method=_told(about, "method", str),
        correct_digits=_told(about, "correct_digits", float, None),
        checked_by=_told(about, "checked_by", str),
        events=Events(_events(held, about, scene, number)),
        projection=_projection(about),
        errors=errors,
        provenance=_told(about, "provenance", dict),
        **rows,
    )
    if not 0 <= run.tolerance < math.inf or run.method not in ("taylor", "refined"):
        raise ValueError("no tolerance or method of a run")
    if run.steps < 0 or not (run.digits is None or 0 < run.digits <= MAX_DIGITS):
        raise ValueError("no steps or digits of a run")
    object.__setattr__(run, "dense", _Again(run))
    return run


def _number(about: JsonObject) -> NumberType:
    found = NumberType(_told(about, "number", str), _told(about, "bits", int))
    known = found.name in NAMES and found.bits <= MOST_BITS
    known = known and (found.name != "mp" or found.bits >= LEAST_MP_BITS)
    if not known or (found.name != "mp" and found != named(found.name)):
        raise ValueError(f"number: {found.name} of {found.bits} bits")
    return found


def _events(
    held: _Held, about: JsonObject, scene: Scene, number: NumberType
) -> tuple[EventTimes, ...]:
    """The times of each event of the scene."""
    listed = _told(about, "events", list)
    if [told["name"] for told in listed] != [event.name for event in scene.events]:
        raise ValueError("events: not those of the scene")
    found = []
    for k, told in enumerate(listed):
        times = _times(held, f"event{k}_times")
        states = _numbers(held, f"event{k}_states", number, (len(times), len(scene.columns)))
        states = read_only(states, len(scene.columns))
        if f"event{k}_signs" not in held:
            raise ValueError("events without their signs, of an older version: run again")
        signs, uncertainty, depths = (
            tuple(_array(held, f"event{k}_{name}", kind, (len(times),)).tolist())
            for name, kind in (("signs", "i"), ("uncertainty", "f"), ("depths", "f"))
        )
        grazing = _array(held, f"event{k}_grazing", "b", (len(times),)).tolist()
        if not set(signs) <= {-1, 0, 1} or grazing != [sign == 0 for sign in signs]:
            raise ValueError("signs of events: expected -1, 1, and 0 where they graze")
        complete = _told(told, "complete", bool)
        found.append(EventTimes(told["name"], times, states, signs, uncertainty, depths, complete))
    return tuple(found)


def _projection(about: JsonObject) -> Projection | None:
    told = _told(about, "projection", dict, None)
    if told is None:
        return None
    return Projection(
        tuple(map(str, _told(told, "onto", list))),
        _told(told, "every", int),
        _told(told, "count", int),
        _told(told, "largest", float),
        _told(told, "sum", float),
    )


def _no_constant(text: str) -> float:
    raise ValueError(f"{text}: no number")


def _decimal(text: str) -> Fraction:
    """A decimal of more digits than a scene may have."""
    found = Decimal(text) if len(text) <= MOST_CHARACTERS else Decimal("nan")
    if not found.is_finite() or abs(found.adjusted()) > MOST_CHARACTERS:
        raise ValueError(f"{text[:40]!r} is no number of a run")
    return Fraction(found)


def _told(about: JsonObject, key: str, *kinds: type | None) -> Any:
    """A value of the JSON part, of the one kind that polhode writes there, or None where it may."""
    value = about[key]
    if isinstance(value, int) and not isinstance(value, bool) and float in kinds:
        return float(value)
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError(f"{key}: {value!r}")
    if type(value) not in kinds and not (value is None and None in kinds):
        raise ValueError(f"{key}: {value!r}")
    return value


class _Again:
    """A loaded run at any time: the run made once more when it is first asked."""

    def __init__(self, run: Trajectory) -> None:
        self.run = run
        self.made: Interpolant | None = None

    @property
    def read(self) -> RowReader:
        """What reads its rows."""
        return self.dense.read

    def at(self, times: Sequence[Fraction]) -> tuple[Sequence[Row], Outcome, Fraction]:
        """Rows at exact times, see :class:`polhode.motion.protocols.Interpolant`."""
        return self.dense.at(times)

    @property
    def dense(self) -> Interpolant:
        """The dense output of the run made once more."""
        if self.made is None:
            from polhode.runs.reevaluate import made_again  # heyoka: a file is read without

            run = self.run
            again = made_again(run, run.scene)
            kept = len(run.times)
            if not same(list(again.states[:kept]), list(run.states)):
                warnings.warn(
                    f"{run.scene.name}: computed again on this machine, the run differs from the "
                    "one in the file in its last digits",
                    stacklevel=4,
                )
            assert again.dense is not None
            self.made = again.dense
        return self.made


def _parts(scene: Scene) -> dict[str, int]:
    """What a file holds of a run, and in how many columns: states, and what is integrated too."""
    more = {word: len(it.names) for word, it in COLUMNS.items() if it.how == "integrated"}
    return {"states": len(scene.columns), **more}


def _texts(rows: Given, number: NumberType) -> npt.NDArray[np.str_]:
    """Rows as decimal strings that round-trip, empty where undefined; shape (n, columns)."""
    if len(rows) == 0:
        return np.empty(rows.shape if isinstance(rows, np.ndarray) else (0,), dtype=np.str_)
    kept = [["" if x is None else x for x in row] for row in strings(rows, number)]
    return np.array(kept, dtype=np.str_)


def _array(held: _Held, name: str, kind: str, shape: tuple[int, ...]) -> npt.NDArray[np.generic]:
    """An array of the file that has this kind and shape; an empty one may have fewer axes."""
    found = held[name]
    if found.dtype.kind != kind or (found.shape != shape and (found.size or 0 not in shape)):
        raise ValueError(f"{name}: {found.dtype} of shape {found.shape}")
    return found


def _numbers(held: _Held, name: str, number: NumberType, shape: tuple[int, int]) -> Any:
    """The numbers of the type that strings stand for, as a trajectory holds them."""
    texts = _array(held, name, "U", shape)
    rows = [
        [None if not x else number_value(number.rounded(_decimal(str(x))), number) for x in row]
        for row in texts
    ]
    if not number.flat or any(x is None for row in rows for x in row):
        return rows
    kind = np.float64 if number.name == "double" else np.longdouble
    return np.array(rows, dtype=kind).reshape(texts.shape)


def _times(held: _Held, name: str) -> tuple[Fraction, ...]:
    return tuple(_decimal(str(x)) for x in _array(held, name, "U", (held[name].size,)).tolist())

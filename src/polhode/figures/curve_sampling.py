"""Motions sampled densely enough for a curve, as doubles: what the figures draw.

From a scene, integrated anew at even times, or from the columns of a trajectory file.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

from polhode.common.errors import BadInput
from polhode.common.interrupts import Progress
from polhode.judging.tables.table import Table
from polhode.numbers import exact
from polhode.numbers.conversion import doubles, to_double
from polhode.numbers.exact import Exact, sign
from polhode.numbers.number_types import Doubles, Given, NumberType
from polhode.runs.options import Options, choose_number
from polhode.runs.solve import solve
from polhode.runs.trajectory import Trajectory
from polhode.scenes import library
from polhode.scenes.scene import Scene, even_times
from polhode.scenes.vocabulary import COLUMNS, REQUESTS

SAMPLES, MOST_SAMPLES = 2001, 8001
WINDOW = 100  # radians at the fastest rate of the start: more turns make no clearer curve
_FAR = 300.0  # log10 of an angle beyond any that is drawn


@dataclass(frozen=True)
class Samples:
    """Columns of equal length by name, nan where undefined, and the scene that they belong to.

    ``t`` is among them.  ``eps``: of the numbers that were judged, where that is known.
    """

    name: str
    columns: Mapping[str, Any]
    scene: Scene | None = None
    eps: float | None = None

    def __post_init__(self) -> None:
        if self.scene is not None:
            library.load(self.scene, takes=REQUESTS)

    def has(self, names: Sequence[str]) -> bool:
        """Whether all of these columns are there."""
        return all(name in self.columns for name in names)

    def vectors(self, names: Sequence[str]) -> Doubles:
        """The columns of these names as an array of rows."""
        return np.array([self.columns[name] for name in names]).T


def shown_times(scene: Scene, end: Exact | None, samples: int | None = None) -> Sequence[Exact]:
    """Even times from 0 to ``end``, or to the scene's own.

    With no number of ``samples`` given the scene's own end is cut to the window, and there are
    enough samples for a curve, see :func:`radians_apart`.
    """
    last = scene.end if end is None else end
    if sign(last) == 0:
        raise BadInput(scene.name, "run.end", None, "an end other than 0, or one given with --end")
    if samples is not None:
        return even_times(last, samples)
    angle = 10.0 ** min(_FAR, scene.at((last,)).log10_angle)
    if end is None and angle > WINDOW:
        power = math.floor(scene.log10_rate)
        rate = Fraction(10.0 ** (scene.log10_rate - power)) * Fraction(10) ** power
        reach = WINDOW / rate
        places = 1 - math.floor(exact.log10(reach))
        last = Fraction(round(reach, places)) * sign(last)  # two significant digits
        angle = WINDOW
    wanted = SAMPLES * math.ceil(angle / WINDOW)
    return even_times(last, min(MOST_SAMPLES, max(SAMPLES, wanted)))


def radians_apart(scene: Scene, times: Sequence[Exact]) -> float:
    """How far the motion turns between two samples, at the fastest rate of its start."""
    far = min(_FAR, scene.log10_rate + exact.log10(times[-1]))
    return float(10.0**far / (len(times) - 1))


def run(
    scene: Scene,
    times: Sequence[Exact],
    outputs: tuple[str, ...],
    number: str | NumberType | None = None,
    digits: int | None = None,
    progress: Progress | None = None,
    project: bool | None = None,
) -> Trajectory:
    """A scene integrated at these times with these outputs; of its events only a stop."""
    events = tuple(event for event in scene.events if event.stop)
    plain = replace(scene, times=times, outputs=outputs, events=events)
    chosen = choose_number(plain, number, digits)
    options = Options(project=project, digits=digits)
    return solve(plain, chosen, options, progress, interruptible=False)


def of_run(trajectory: Trajectory) -> Samples:
    """A run's columns."""
    scene = trajectory.scene
    parts: list[tuple[tuple[str, ...], Given]] = [(scene.columns, trajectory.states)]
    parts += [(COLUMNS[word].names, rows) for word, rows in trajectory.outputs.items()]
    columns = {"t": np.array([to_double(t) for t in trajectory.times])}
    for names, rows in parts:
        columns |= dict(zip(names, doubles(rows).T, strict=True))
    return Samples(scene.name, columns, scene, float(trajectory.number.eps))


def of_table(table: Table, scene: Scene | None) -> Samples:
    """A file's columns, in order of time."""
    order = sorted(range(len(table.times)), key=lambda k: table.times[k])
    named = {"t": table.times, **table.columns}
    columns = {name: doubles([[values[k]] for k in order])[:, 0] for name, values in named.items()}
    return Samples(table.name, columns, scene)

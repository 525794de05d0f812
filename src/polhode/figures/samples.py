"""Samples of a motion, at as many times as curves need, and the motion between them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.common.errors import BadInput
from polhode.common.interrupts import Progress
from polhode.equations.kinematics import attitude_rates
from polhode.judging.tables.table import TrajectoryTable
from polhode.numbers import exact
from polhode.numbers.conversion import doubles, to_double
from polhode.numbers.exact import Exact, sign
from polhode.numbers.number_types import Doubles, Given, NumberType
from polhode.runs.options import USUAL, Options, choose_number
from polhode.runs.trajectory import Trajectory, solve
from polhode.scenes import library
from polhode.scenes.scene import Scene, even_times
from polhode.scenes.vocabulary import ATTITUDE, COLUMNS, REQUESTS, STATE

# --- curve sampling -------------------------------------------------------------------------------
#
# Motions sampled densely enough for a curve, as doubles: what the figures draw.
#
# From a scene, integrated anew at even times, or from the columns of a trajectory file.


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
    count = SAMPLES * math.ceil(angle / WINDOW)
    return even_times(last, min(MOST_SAMPLES, max(SAMPLES, count)))


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
    options: Options = USUAL,
) -> Trajectory:
    """A scene integrated at these times with these outputs; of its events only a stop."""
    events = tuple(event for event in scene.events if event.stop)
    plain = replace(scene, times=times, outputs=outputs, events=events)
    chosen = choose_number(plain, number, digits)
    if digits is not None:
        options = options._replace(digits=digits)
    if options.method == "refined" and options.hindrance(plain, chosen) is not None:
        options = options._replace(method="taylor")  # no angles from a pole on
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


def of_table(table: TrajectoryTable, scene: Scene | None) -> Samples:
    """A file's columns, in order of time."""
    order = sorted(range(len(table.times)), key=lambda k: table.times[k])
    named = {"t": table.times, **table.columns}
    columns = {name: doubles([[values[k]] for k in order])[:, 0] for name, values in named.items()}
    return Samples(table.name, columns, scene)


# --- sampled motion -------------------------------------------------------------------------------
#
# A motion of a body as pages and films show it: attitude and omega at even times, and between.


_NEAR = 1e-3
_COARSE = 0.5  # radians from one sample to the next that a cubic does not follow
ANOTHER = "The file is of another motion than the scene's: energy or momentum differ."


class ShownMotion(NamedTuple):
    """Even times in order, the quaternion and omega in the body a row each, and the scene."""

    scene: Scene
    times: Doubles
    attitude: Doubles
    omega: Doubles

    def at(self, times: Doubles | float) -> tuple[Doubles, Doubles]:
        """Attitude and omega between the samples, by cubics; of the attitude with its rates.

        The attitude's have q' = q ⊗ (0, omega) / 2 at both ends, as the page that moves has them.
        """
        step = self.times[1] - self.times[0]
        far = (np.asarray(times, dtype=float) - self.times[0]) / step
        k = np.clip(np.floor(far).astype(int), 0, len(self.times) - 2)
        s = (far - k)[..., None]
        weights = (1 + 2 * s) * (1 - s) ** 2, s * (1 - s) ** 2, s * s * (3 - 2 * s), s * s * (s - 1)
        rates = np.array(attitude_rates([*self.attitude.T], [*self.omega.T])).T
        attitude = _cubic(weights, self.attitude, step * rates, k)
        omega = _cubic(weights, self.omega, np.gradient(self.omega, axis=0), k)
        return attitude / np.linalg.norm(attitude, axis=-1, keepdims=True), omega

    def on_level(self) -> bool:
        """Whether the first sample has the scene's h and f, to a thousandth."""
        body, (q0, q1, q2, q3), w = self.scene.body, self.attitude[0], self.omega[0]
        gamma = [2 * (q1 * q3 - q0 * q2), 2 * (q2 * q3 + q0 * q1), 1 - 2 * (q1 * q1 + q2 * q2)]
        inertia = np.array([[to_double(x) for x in row] for row in body.inertia])
        torque = np.array([to_double(x) for x in body.torque])
        h, f, *_ = self.scene.integrals
        if f is None:
            return True
        momentum = inertia @ w
        sizes = w @ momentum / 2 + np.linalg.norm(torque), float(np.linalg.norm(momentum))
        own = w @ momentum / 2 + torque @ gamma, momentum @ gamma
        return bool(
            abs(own[0] - to_double(h)) <= _NEAR * sizes[0]
            and abs(own[1] - to_double(f)) <= _NEAR * sizes[1]
        )

    def coarse(self) -> str:
        """That what is shown between two samples is not the motion, where that is so."""
        fastest = float(np.max(np.linalg.norm(self.omega, axis=1)))
        apart = fastest * float(self.times[1] - self.times[0])
        if apart < _COARSE:
            return ""
        return (
            f"Two samples are up to {apart:.2g} radians apart: between them the picture is not "
            "the motion. A shorter time, or more rows, shows it."
        )


def _cubic(
    weights: tuple[Doubles, ...], values: Doubles, slopes: Doubles, k: npt.NDArray[np.int_]
) -> Doubles:
    a, b, c, d = weights
    between: Doubles = a * values[k] + b * slopes[k] + c * values[k + 1] + d * slopes[k + 1]
    return between


def of_samples(samples: Samples) -> ShownMotion:
    """The motion in columns, in order of time; raises BadInput where it cannot be shown."""
    if samples.scene is None:
        raise BadInput(samples.name, "--scene", None, "the scene that the file belongs to")
    needed = (*STATE[:3], *ATTITUDE)
    if not samples.has(needed):
        raise BadInput(
            samples.name, "header", ",".join(samples.columns), f"columns {', '.join(needed)}"
        )
    times, attitude, omega = (
        samples.columns["t"],
        samples.vectors(ATTITUDE),
        samples.vectors(STATE[:3]),
    )
    if times[-1] < times[0]:
        times, attitude, omega = times[::-1], attitude[::-1], omega[::-1]
    if not (np.isfinite(attitude).all() and np.isfinite(omega).all()):
        raise BadInput(samples.name, "file", None, "a number in every cell of attitude and omega")
    steps = np.diff(times)
    if len(times) < 3 or np.ptp(steps) > 1e-6 * abs(times[-1] - times[0]):
        raise BadInput(samples.name, "file", None, "three rows or more at even times")
    return ShownMotion(samples.scene, times, attitude, omega)

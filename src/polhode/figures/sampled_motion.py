"""A motion of a body as pages and films show it: attitude and omega at even times, and between."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.common.errors import BadInput
from polhode.figures.curve_sampling import Samples
from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import Doubles
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import ATTITUDE, STATE

_NEAR = 1e-3
_COARSE = 0.5  # radians from one sample to the next that a cubic does not follow
ANOTHER = "The file is of another motion than the scene's: energy or momentum differ."


class Motion(NamedTuple):
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
        attitude = _cubic(weights, self.attitude, step * self._rates, k)
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

    @property
    def _rates(self) -> Doubles:
        """q' at the samples."""
        (a, b, c, d), (x, y, z) = self.attitude.T, self.omega.T
        rates = (
            -b * x - c * y - d * z,
            a * x + c * z - d * y,
            a * y + d * x - b * z,
            a * z + b * y - c * x,
        )
        slopes: Doubles = np.array(rates).T / 2
        return slopes


def _cubic(
    weights: tuple[Doubles, ...], values: Doubles, slopes: Doubles, k: npt.NDArray[np.int_]
) -> Doubles:
    a, b, c, d = weights
    between: Doubles = a * values[k] + b * slopes[k] + c * values[k + 1] + d * slopes[k + 1]
    return between


def of_samples(samples: Samples) -> Motion:
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
    return Motion(samples.scene, times, attitude, omega)

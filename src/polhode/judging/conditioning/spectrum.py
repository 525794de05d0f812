"""All six Lyapunov exponents of a motion: tangents that are made orthonormal as they grow."""

from __future__ import annotations

import numpy as np

from polhode.equations.forms import principal
from polhode.numbers.number_types import DOUBLE
from polhode.numbers.rows import Doubles
from polhode.scenes.scene import Scene
from polhode.taylor.variations.flow_map import Flow


def exponents(scene: Scene, start: Doubles, length: float, looks: int, still: bool) -> list[float]:
    """The exponents over the second half of a time, the largest first (Benettin and others 1980).

    ``start``: in principal axes and the run's unit of time, as ``length`` is, which may be
    negative.  ``still``: whether the start is where the motion stays.  Raises NotFollowed.
    """
    flow = Flow(principal.coefficients(scene.body, scene.time_unit), DOUBLE, derivative=True)
    state, frame, growth = start, np.eye(6), np.zeros((looks, 6))
    for k in range(looks):
        reached = flow.after(state, length / looks)
        frame, triangle = np.linalg.qr(np.asarray(reached.derivative) @ frame)
        growth[k] = np.log(np.abs(np.diag(triangle)))
        state = start if still else np.asarray(reached.state)
    means = growth[looks // 2 :].mean(axis=0) * looks / abs(length)
    found: list[float] = sorted(means.tolist(), reverse=True)
    return found

"""The equations as a function of doubles, for somebody else's integrator (3.16–3.17)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from polhode.numbers.conversion import to_double
from polhode.numbers.rows import Doubles
from polhode.numbers.vectors import cross, inverse
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import REQUESTS


def field(scene: Scene | str | Path) -> Callable[[float, npt.ArrayLike], Doubles]:
    """Give the rates of p q r [gamma1 gamma2 gamma3] as a function f(t, y) of doubles.

    It is the right-hand side for ``scipy.integrate.solve_ivp`` and similar programs.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, a path, or the name of a case.

    Returns
    -------
    callable
        f(t, y) -> ndarray of the shape of ``y``: (6,), or (6, n) for n states at once; three rows
        where a torque-free scene has no gamma.  ``f.start`` is the state at t = 0.

    Raises
    ------
    BadInput
        A scene that cannot be read.

    Notes
    -----
    In the scene's own axes and units ::

        w' = I⁻¹ (Mg gamma × r0 - w × I w),    gamma' = gamma × w

    with w = (p, q, r), (3.16-3.17) of Yehia, *Rigid Body Dynamics: A Lagrangian Approach*.

    Examples
    --------
    >>> import polhode
    >>> f = polhode.field("lagrange/nutation")
    >>> f.start.tolist()
    [0.16, 0.3, 4.1, 0.8, 0.0, 0.6]
    >>> f(0, f.start).round(12).tolist()
    [0.615, -1.128, 0.0, -0.18, -3.184, 0.24]
    """
    return _Field(library.load(scene, takes=REQUESTS))


class _Field:
    def __init__(self, scene: Scene) -> None:
        self._name = scene.name
        body = scene.body
        self.inertia = np.array([[to_double(x) for x in row] for row in body.inertia])
        self.inverse = np.array([[to_double(x) for x in row] for row in inverse(body.inertia)])
        self.torque = np.array([to_double(x) for x in body.torque])
        self.start: Any = np.array([to_double(x) for x in scene.start])

    def __repr__(self) -> str:
        return f"<field of {self._name}: f(t, y)>"

    def __call__(self, t: float, y: npt.ArrayLike) -> Doubles:
        state = np.asarray(y, dtype=np.float64)
        omega, gamma = state[:3], state[3:]
        turning = -np.array(cross(omega, self.inertia @ omega))
        if len(gamma):
            turning = turning + np.array(cross(gamma, self.torque))
        rates = [self.inverse @ turning]
        if len(gamma):
            rates.append(np.array(cross(gamma, omega)))
        return np.concatenate(rates)

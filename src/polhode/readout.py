"""From the integrator's rows to what is asked: scene axes and units, attitude, angles."""

from __future__ import annotations

from functools import cached_property
from types import SimpleNamespace
from typing import Any

from polhode.exact import Number
from polhode.kinematics import angles
from polhode.precision import NumberType, to_double, to_extended, to_mpf
from polhode.scene import ATTITUDE, Scene

GUARD_BITS = 16


class Readout:
    """Reads rows of one run: the state in principal axes, then quaternion, then psi and phi."""

    def __init__(self, scene: Scene, number: NumberType) -> None:
        self.scene, self.number = scene, number
        self.columns = len(scene.columns)

    def states(self, rows: list[Any]) -> Any:
        """p q r [gamma1 gamma2 gamma3] in scene axes: an ndarray, or rows of mpf above extended."""
        turned = self._turned([row[: self.columns] for row in rows])
        exponent = -self.scene.time_unit
        if self._flat:
            import numpy as np

            turned[:, :3] = np.ldexp(turned[:, :3], exponent)
            return turned
        import mpmath

        return [[mpmath.ldexp(x, exponent) for x in row[:3]] + row[3:] for row in turned]

    def attitude(self, rows: list[Any]) -> Any:
        """q0 q1 q2 q3, if asked for or needed."""
        if "attitude" not in self.scene.modelled:
            return None
        return self._kept([row[self.columns : self.columns + 4] for row in rows])

    def angles(self, rows: list[Any]) -> list[list[Any]] | None:
        """psi theta phi, if asked for; psi and phi None at a pole."""
        if "angles" not in self.scene.outputs:
            return None
        states = self.states(rows)
        fn = self._functions
        import mpmath

        first = self.columns + (len(ATTITUDE) if "attitude" in self.scene.modelled else 0)
        with mpmath.workprec(self.number.bits):
            return [
                # a motion that stays at a pole has no psi and phi among its variables
                angles(state[3:], row[first : first + 2] if len(row) > first else (0, 0), fn)
                for state, row in zip(states, rows, strict=True)
            ]

    @property
    def _flat(self) -> bool:
        return self.number.name in ("double", "extended")

    @cached_property
    def _functions(self) -> Any:
        if self._flat:
            import numpy as np

            pi = 4 * np.arctan(np.ones(1, dtype=self._kind))[0]
            return SimpleNamespace(hypot=np.hypot, atan2=np.arctan2, pi=pi, rint=np.rint)
        import mpmath

        return SimpleNamespace(
            hypot=mpmath.hypot, atan2=mpmath.atan2, pi=mpmath.pi, rint=mpmath.nint
        )

    @property
    def _kind(self) -> Any:
        import numpy as np

        return np.float64 if self.number.name == "double" else np.longdouble

    def _kept(self, rows: list[Any]) -> Any:
        if not self._flat:
            return rows
        import numpy as np

        return np.array(rows, dtype=self._kind)

    def _turned(self, rows: list[Any]) -> Any:
        """Rows of vectors from principal to scene axes, computed with more bits than they have."""
        axes = self.scene.body.axes
        if axes.trivial or not rows:
            return (
                self._kept(rows).reshape(len(rows), self.columns)
                if self._flat
                else [list(row) for row in rows]
            )
        if self._flat:
            import numpy as np

            turn = np.array([[to_extended(x) for x in row] for row in axes.rows])
            wide = np.array(rows, dtype=np.longdouble)
            vectors = [wide[:, k : k + 3] @ turn for k in range(0, self.columns, 3)]
            return np.hstack(vectors).astype(self._kind)
        import mpmath

        entries = [[to_mpf(x, self.number.bits + GUARD_BITS) for x in row] for row in axes.rows]
        with mpmath.workprec(self.number.bits):
            return [
                [
                    mpmath.fdot((entries[i][j], row[k + i]) for i in range(3))
                    for k in range(0, self.columns, 3)
                    for j in range(3)
                ]
                for row in rows
            ]


def number_value(x: Number, number: NumberType) -> Any:
    """The number nearest to x of the kind that a trajectory holds: float, longdouble or mpf."""
    if number.name == "double":
        return to_double(x)
    return to_extended(x) if number.name == "extended" else to_mpf(x, number.bits)

"""From the integrator's rows to what is asked: omega and gamma in scene axes, attitude, angles."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

from polhode.equations.form import equations
from polhode.equations.kinematics import AngleFunctions, angles
from polhode.numbers.convert import exactly, to_extended, to_mpf
from polhode.numbers.number_types import NumberType
from polhode.numbers.scalars import Row, Rows, Value, of_extended, of_mpmath
from polhode.scenes.scene import Scene
from polhode.scenes.words import ATTITUDE

if TYPE_CHECKING:
    import numpy as np

GUARD_BITS = 16


class Readout:
    """Reads rows of one run: the form's variables, then quaternion, then psi and phi.

    Omega and gamma are computed from the variables with more bits than those have.
    """

    def __init__(self, scene: Scene, number: NumberType) -> None:
        self.scene, self.number = scene, number
        self.form, self.columns = equations(scene), len(scene.columns)

    def states(self, rows: Sequence[Row]) -> Rows:
        """p q r [gamma1 gamma2 gamma3] in scene axes: an ndarray, or rows of mpf above extended."""
        if not rows:
            return self._kept([]).reshape(0, self.columns) if self.number.flat else []
        turned = self._vectors([row[: len(self.form.variables)] for row in rows])
        exponent = -self.scene.time_unit
        if self.number.flat:
            import numpy as np

            if exponent:
                turned[:, :3] = np.ldexp(turned[:, :3], exponent)
            return turned
        from polhode.numbers.private import mpmath, ordinary

        return [ordinary([mpmath.ldexp(x, exponent) for x in row[:3]] + row[3:]) for row in turned]

    def attitude(self, rows: Sequence[Row]) -> Rows | None:
        """q0 q1 q2 q3, if asked for or needed."""
        if "attitude" not in self.scene.modelled:
            return None
        first = len(self.form.variables)
        return self._kept([row[first : first + 4] for row in rows])

    def angles(self, rows: Sequence[Row]) -> list[list[Value | None]] | None:
        """psi theta phi, if asked for; psi and phi None at a pole."""
        if "angles" not in self.scene.outputs:
            return None
        states = self.states(rows)
        fn = self._functions
        from polhode.numbers.private import mpmath, ordinary, own

        first = len(self.form.variables) + (
            len(ATTITUDE) if "attitude" in self.scene.modelled else 0
        )
        if not self.number.flat:
            states, rows = own(states), own(list(rows))
        with mpmath.workprec(self.number.bits):
            found = [
                # a motion that stays at a pole has no psi and phi among its variables
                angles(state[3:], row[first : first + 2] if len(row) > first else (0, 0), fn)
                for state, row in zip(states, rows, strict=True)
            ]
        return found if self.number.flat else ordinary(found)

    @cached_property
    def _functions(self) -> AngleFunctions:
        if self.number.flat:
            import numpy as np

            pi = 4 * np.arctan(np.ones(1, dtype=self._kind))[0]
            return AngleFunctions(np.hypot, np.arctan2, pi, np.rint)
        from polhode.numbers.private import mpmath

        return AngleFunctions(mpmath.hypot, mpmath.atan2, mpmath.pi, mpmath.nint)

    @property
    def _kind(self) -> type[np.floating[Any]]:
        import numpy as np

        return np.float64 if self.number.name == "double" else np.longdouble

    def _kept(self, rows: Sequence[Row]) -> Rows:
        if not self.number.flat:
            return rows
        import numpy as np

        return np.array(rows, dtype=self._kind)

    def _vectors(self, rows: Sequence[Row]) -> Rows:
        """Rows of omega and gamma in scene axes and the run's unit, rounded once at the end."""
        if self.number.name == "double":
            return self._in_extended(rows)
        from polhode.numbers.private import mpmath

        bits = self.number.bits + GUARD_BITS
        with mpmath.workprec(bits):
            k = {name: to_mpf(x, bits) for name, x in self.form.coefficients.items()}
            fn = of_mpmath()
            found = [
                self.form.state([to_mpf(exactly(x), bits) for x in row], k, fn) for row in rows
            ]
        turned = self._turned(found, bits)
        if not self.number.flat:
            return turned
        wide = [[to_extended(exactly(x)) for x in row] for row in turned]
        return self._kept(wide).reshape(len(rows), self.columns)

    def _turned(self, found: Sequence[Sequence[Row]], bits: int) -> list[list[Value]]:
        """Pairs of omega and gamma, one after the other, turned and rounded to the run's type."""
        from polhode.numbers.private import mpmath

        axes = self.form.axes
        with mpmath.workprec(self.number.bits):
            if axes.trivial:
                return [[+x for vector in pair for x in vector] for pair in found]
            entries = [[to_mpf(x, bits) for x in row] for row in axes.rows]
            return [
                [
                    mpmath.fdot((entries[i][j], vector[i]) for i in range(3))
                    for vector in pair
                    if vector
                    for j in range(3)
                ]
                for pair in found
            ]

    def _in_extended(self, rows: Sequence[Row]) -> Rows:
        """The same for doubles, all rows at once."""
        import numpy as np

        wide = np.array(rows, dtype=np.longdouble)
        k = {name: to_extended(x) for name, x in self.form.coefficients.items()}
        fn = of_extended()
        vectors = [
            np.stack(np.broadcast_arrays(wide[:, 0], *vector)[1:], axis=1)
            for vector in self.form.state(list(wide.T), k, fn)
            if vector
        ]
        axes = self.form.axes
        if not axes.trivial:
            turn = np.array([[to_extended(x) for x in row] for row in axes.rows])
            vectors = [vector @ turn for vector in vectors]
        return np.hstack(vectors).astype(self._kind)

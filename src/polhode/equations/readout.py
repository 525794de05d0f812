"""From the integrator's rows to what is asked: omega and gamma in scene axes, attitude, angles."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from polhode.common.cached_property import cached_property
from polhode.equations.form import equations
from polhode.equations.kinematics import AngleFunctions, angles
from polhode.numbers.conversion import exactly, number_value, to_extended, to_mpf
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Extendeds, Flat, Gapped, Given, GivenRow, Rows, flat
from polhode.numbers.scalars import Scalar, of_extended, of_mpmath
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import ATTITUDE

if TYPE_CHECKING:
    import numpy as np

GUARD_BITS = 16


class Readout:
    """Reads rows of one run: the form's variables, then quaternion, then psi and phi.

    Omega and gamma are computed from the variables with more bits than those have.  Above extended
    those of the start, where a run begins with its row, are the scene's own, rounded once: what is
    0 there is 0.
    """

    def __init__(self, scene: Scene, number: NumberType) -> None:
        self.scene, self.number = scene, number
        self.form, self.columns = equations(scene), len(scene.columns)

    def states(self, rows: Given) -> Rows:
        """p q r [gamma1 gamma2 gamma3] in scene axes: an ndarray, or rows of mpf above extended."""
        if len(rows) == 0:
            return self._kept([]).reshape(0, self.columns) if self.number.flat else []
        exponent = -self.scene.time_unit
        if self.number.flat:
            import numpy as np

            turned = self._flat(self._kept(rows)[:, : len(self.form.variables)])
            if exponent:
                turned[:, :3] = np.ldexp(turned[:, :3], exponent)
            return turned
        wide = self._vectors([row[: len(self.form.variables)] for row in rows])
        from polhode.numbers.mpmath_context import mpmath, ordinary

        found = [ordinary([mpmath.ldexp(x, exponent) for x in row[:3]] + row[3:]) for row in wide]
        if self._begins_with_the_start(rows[0]):
            found[0] = [*self._start]
        return found

    @cached_property
    def _start(self) -> list[Scalar]:
        """The scene's own omega and gamma, rounded to the run's type."""
        given = (*self.scene.omega, *(self.scene.gamma or ()))
        return [number_value(x, self.number) for x in given]

    def _begins_with_the_start(self, row: GivenRow) -> bool:
        """Whether a row is that of the start, to the bit, and omega and gamma no copies of it."""
        if self.form.plain and self.form.axes.trivial:
            return False
        variables = zip(row[: len(self.form.variables)], self.form.start, strict=True)
        return all(exactly(x) == self.number.rounded(y) for x, y in variables)

    def attitude(self, rows: Given) -> Rows | None:
        """q0 q1 q2 q3, if asked for or needed."""
        if "attitude" not in self.scene.modelled:
            return None
        first = len(self.form.variables)
        if not self.number.flat:
            return [[*row[first : first + 4]] for row in rows]
        if len(rows):
            return self._kept(rows)[:, first : first + 4].copy()
        return self._kept([])

    def angles(self, rows: Given) -> Gapped | None:
        """psi theta phi, if asked for; psi and phi None at a pole."""
        if "angles" not in self.scene.modelled:
            return None
        if len(rows) == 0:
            return []
        first = len(self.form.variables) + (
            len(ATTITUDE) if "attitude" in self.scene.modelled else 0
        )
        states = self.states(rows)
        # a motion that stays at a pole has no psi and phi among its variables
        there = len(rows[0]) > first
        if self.number.flat:
            turned = self._kept(rows)[:, first : first + 2] if there else 0
            return self._flat_angles(flat(states), turned)
        found = self._angles(states, [row[first : first + 2] if there else (0, 0) for row in rows])
        for row, state in zip(found, states, strict=True):
            if state[3] == 0 == state[4]:
                row[0] = row[2] = None
        return found

    def _flat_angles(self, states: Flat, integrated: Flat | int) -> Gapped:
        """psi theta phi beside states and integrated psi and phi, all rows at once."""
        import numpy as np

        pi = 4 * np.arctan(np.ones(1, dtype=self._kind))[0]
        fn = AngleFunctions(np.hypot, np.arctan2, pi, np.rint, np.where)
        turned = np.zeros((len(states), 2), dtype=self._kind) + integrated
        found: Gapped = np.stack(angles([*states[:, 3:].T], [*turned.T], fn), axis=1).tolist()
        for k in np.flatnonzero((states[:, 3] == 0) & (states[:, 4] == 0)).tolist():
            found[k][0] = found[k][2] = None
        return found

    def _angles(self, states: Rows, integrated: Sequence[GivenRow]) -> Gapped:
        """The same above extended."""
        from polhode.numbers.mpmath_context import mpmath, ordinary, own

        fn = AngleFunctions(
            mpmath.hypot, mpmath.atan2, mpmath.pi, mpmath.nint, lambda c, a, b: a if c else b
        )
        with mpmath.workprec(self.number.bits):
            pairs = zip(own(states), own(integrated), strict=True)
            found: Gapped = ordinary([angles(s[3:], w, fn) for s, w in pairs])
            return found

    @property
    def _kind(self) -> type[np.floating[Any]]:
        import numpy as np

        return np.float64 if self.number.name == "double" else np.longdouble

    def _kept(self, rows: Given) -> Flat:
        """An array of the type, which numpy holds."""
        import numpy as np

        found: Flat = np.asarray(rows, dtype=self._kind)
        return found

    def _flat(self, rows: Flat) -> Flat:
        """The same of an array, as a new array."""
        if self.form.plain and self.form.axes.trivial:
            return rows[:, : self.columns].copy()
        if self.number.name == "double":
            return self._in_extended(rows)
        wide = [[to_extended(exactly(x)) for x in row] for row in self._vectors(rows)]
        return self._kept(wide).reshape(len(rows), self.columns)

    def _vectors(self, rows: Given) -> list[list[Scalar]]:
        """Rows of omega and gamma in scene axes and the run's unit, rounded once at the end."""
        from polhode.numbers.mpmath_context import mpmath

        bits = self.number.bits + GUARD_BITS
        with mpmath.workprec(bits):
            k = {name: to_mpf(x, bits) for name, x in self.form.coefficients.items()}
            fn = of_mpmath()
            found = [
                self.form.state([to_mpf(exactly(x), bits) for x in row], k, fn) for row in rows
            ]
        return self._turned(found, bits)

    def _turned(self, found: Iterable[Iterable[Sequence[Scalar]]], bits: int) -> list[list[Scalar]]:
        """Pairs of omega and gamma, one after the other, turned and rounded to the run's type."""
        from polhode.numbers.mpmath_context import mpmath

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

    def _in_extended(self, rows: Flat) -> Flat:
        """The same for doubles, all rows at once."""
        import numpy as np

        wide = rows.astype(np.longdouble)
        if self.form.plain:
            vectors = np.split(wide, range(3, self.columns, 3), axis=1)
        else:
            vectors = [
                np.stack(np.broadcast_arrays(wide[:, 0], *vector)[1:], axis=1)
                for vector in self.form.state(list(wide.T), self._extended, of_extended())
                if vector
            ]
        if not self.form.axes.trivial:
            vectors = [vector @ self._turn for vector in vectors]
        return np.hstack(vectors).astype(self._kind)

    @cached_property
    def _extended(self) -> dict[str, Scalar]:
        """The form's coefficients in extended."""
        return {name: to_extended(x) for name, x in self.form.coefficients.items()}

    @cached_property
    def _turn(self) -> Extendeds:
        """The turn from the form's axes to the scene's in extended."""
        import numpy as np

        return np.array([[to_extended(x) for x in row] for row in self.form.axes.rows])

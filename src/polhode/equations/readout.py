"""From the integrator's rows to what is asked: omega and gamma in scene axes, attitude, angles."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any, NamedTuple

from polhode.common.values import cached_property
from polhode.equations import kinematics
from polhode.equations.form import equations
from polhode.equations.kinematics import AngleFunctions, angles, starting_attitude
from polhode.motion.frame import Frame
from polhode.numbers import exact
from polhode.numbers.conversion import exactly, number_value, to_double, to_extended, to_mpf
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import (
    EXTENDED,
    Booleans,
    Extendeds,
    Flat,
    Gapped,
    Given,
    GivenRow,
    NumberType,
    Real,
    Rows,
    Scalar,
    flat,
    of_extended,
    of_mpmath,
)
from polhode.numbers.vectors import (
    Vector,
    dot,
    is_zero,
    parallel,
    quaternion_product,
    scaled,
    upright,
)
from polhode.scenes.scene import Scene

if TYPE_CHECKING:
    import numpy as np


# --- equilibrium ----------------------------------------------------------------------------------
#
# Relative equilibria: the motions in which the state stands still.
#
# All derivatives of (3.29) vanish exactly at the start: rest, hanging or upright, and permanent
# rotation: w along gamma (Staude), or, of a free body without gamma, along a principal axis.  The
# body then turns uniformly about w, which is fixed in body and space.


class Rest(NamedTuple):
    """Whether w, and whether the whole state, stand still."""

    omega: bool
    state: bool


def at_rest(scene: Scene) -> Rest:
    """What stands still: of which every derivative vanishes at the start, by the rule for *equal*.

    w by itself may only where no torque acts on it: then it does not depend on gamma.
    """
    body, omega, gamma = scene.body, scene.omega, scene.gamma
    along = gamma is None or parallel(gamma, omega)  # gamma' = gamma × w
    if not along and not body.torque_free:
        return Rest(False, False)
    still = is_zero(body.moment(omega, gamma))
    return Rest(still, still and along)


def name(scene: Scene) -> str | None:
    """Rest or permanent rotation; None for any other motion."""
    if not at_rest(scene).state:
        return None
    return "rest" if is_zero(scene.omega) else "permanent rotation"


def variables(scene: Scene, t: Fraction) -> list[Exact]:
    """State in principal form, inside its frame, quaternion, psi and phi, at time t.

    As far as the scene asks for them; no psi and phi at a pole.  The quaternion is
    q(0) ⊗ (cos |w|t/2, sin |w|t/2 w/|w|); psi' = w·gamma.
    """
    values, gamma = [*equations(scene).start], scene.gamma
    if gamma is None:
        return values
    if scene.modelled:
        values += _after_turn(kinematics.starting_attitude(gamma, scene.psi), scene.omega, t)
    if "angles" in scene.modelled and not scene.starts_at_pole:
        values += [scene.psi + dot(scene.omega, gamma) * t, kinematics.starting_phi(gamma)]
    return values


def _after_turn(quaternion: tuple[Exact, ...], omega: Vector, t: Fraction) -> tuple[Exact, ...]:
    """A quaternion after a uniform turn with omega, body axes, for a time t."""
    if is_zero(omega) or t == 0:
        return quaternion
    rate = exact.sqrt(dot(omega, omega))
    half = rate * t / 2
    return quaternion_product(quaternion, (exact.cos(half), *scaled(exact.sin(half) / rate, omega)))


# --- readout --------------------------------------------------------------------------------------


GUARD_BITS = 16
_MOST_SPIN = 32.0  # about the third axis, beside the other rates


class Readout:
    """Reads rows of one run: the form's variables, then the quaternion, then psi and phi.

    ``frame``: another than the scene's own, of the same axes.
    Omega and gamma are computed from the variables with more bits than those have.  Above extended
    those of the start, where a run begins with its row, are the scene's own, rounded once: what is
    0 there is 0.
    """

    def __init__(self, scene: Scene, number_type: NumberType, frame: Frame | None = None) -> None:
        self.scene, self.number = scene, number_type
        self.form, self.columns = equations(scene), len(scene.columns)
        self.frame = frame or self.form.frame

    def states(self, rows: Given) -> Rows:
        """p q r [gamma1 gamma2 gamma3] in scene axes: an ndarray, or rows of mpf above extended."""
        if len(rows) == 0:
            return self._array([]).reshape(0, self.columns) if self.number.flat else []
        exponent = -self.frame.exponent
        if self.number.flat:
            import numpy as np

            states = self._flat(self._array(rows)[:, : len(self.form.variables)])
            if exponent:
                states[:, :3] = np.ldexp(states[:, :3], exponent)
            return states
        wide = self._vectors([row[: len(self.form.variables)] for row in rows])
        from polhode.numbers.mpmath_context import mpmath, ordinary

        mantissas = [
            ordinary([mpmath.ldexp(x, exponent) for x in row[:3]] + row[3:]) for row in wide
        ]
        if self._begins_with_the_start(rows[0]):
            mantissas[0] = [*self._start]
        return mantissas

    @cached_property
    def _start(self) -> list[Scalar]:
        """The scene's own omega and gamma, rounded to the run's type."""
        start = (*self.scene.omega, *(self.scene.gamma or ()))
        return [number_value(x, self.number) for x in start]

    def _begins_with_the_start(self, row: GivenRow) -> bool:
        """Whether a row is that of the start, to the bit, and omega and gamma no copies of it."""
        if self.form.plain and self.frame.axes.trivial:
            return False
        variables = zip(row[: len(self.form.variables)], self.form.start, strict=True)
        return all(exactly(x) == self.number.rounded(y) for x, y in variables)

    def attitude(self, rows: Given, states: Rows) -> Rows | None:
        """q0 q1 q2 q3 beside states, if asked for or needed: of length one, and gamma's."""
        if "attitude" not in self.scene.modelled:
            return None
        if self.number.flat:
            return self._upright(self._array(rows), flat(states)).T.astype(self._kind)
        from polhode.numbers.mpmath_context import mpmath, ordinary

        quaternions = []
        for row, state in zip(rows, states, strict=True):
            q = self._upright_row(row, state)
            with mpmath.workprec(self.number.bits):
                quaternions.append(ordinary([+x for x in q]))
        return quaternions

    def angles(self, rows: Given, states: Rows) -> Gapped | None:
        """psi theta phi beside states, if asked for; psi and phi None at a pole.

        psi is the quaternion's, whose rate is finite at a pole, and phi gamma's; their half turns
        are those of the integrated ones.
        """
        if "angles" not in self.scene.modelled:
            return None
        if len(rows) == 0:
            return []
        if self.number.flat:
            rows_of_angles = self._flat_angles(self._array(rows), flat(states))
            import numpy as np

            across = flat(states)[:, 3:5].T
            poles = np.flatnonzero((across[0] == 0) & (across[1] == 0)).tolist()
        else:
            rows_of_angles = [self._angles(*pair) for pair in zip(rows, states, strict=True)]
            poles = [k for k, state in enumerate(states) if state[3] == 0 == state[4]]
        for k in poles:
            rows_of_angles[k][0] = rows_of_angles[k][2] = None
        return rows_of_angles

    def _upright(self, rows: Flat, states: Flat) -> Extendeds:
        """The quaternion beside states, a column each; the start's as it is."""
        import numpy as np

        quaternions = rows[:, self._first : self._first + 4].T.astype(np.longdouble)
        gamma = states[:, 3:].T.astype(np.longdouble)
        nearest = np.array(upright([*quaternions], [*gamma], np.sqrt), dtype=np.longdouble)
        return np.where(self._begin(rows), quaternions, nearest)

    def _upright_row(self, row: GivenRow, state: GivenRow) -> list[Scalar]:
        """The same above extended, with some more bits."""
        from polhode.numbers.mpmath_context import mpmath, own

        q = [*map(own, row[self._first : self._first + 4])]
        if self._begins(row):
            return q
        with mpmath.workprec(self.number.bits + GUARD_BITS):
            return upright(q, [*map(own, state[3:])], mpmath.sqrt)

    def _begin(self, rows: Flat) -> Booleans:
        """Which rows have the quaternion of the start."""
        begins: Booleans = (rows[:, self._first : self._first + 4] == self._first_attitude).all(1)
        return begins

    def _begins(self, row: GivenRow) -> bool:
        """Whether a row has it."""
        return [*row[self._first : self._first + 4]] == self._first_attitude

    @cached_property
    def _first_attitude(self) -> list[Scalar]:
        """The quaternion at the start, rounded to the run's type."""
        assert self.scene.gamma is not None
        first = starting_attitude(self.scene.gamma, self.scene.psi)
        return [number_value(x, self.number) for x in first]

    @cached_property
    def _first(self) -> int:
        """The first column of the quaternion, before psi and phi."""
        return len(self.form.variables)

    @cached_property
    def _spins(self) -> bool:
        """Whether phi grows so much faster that the quaternion has fewer digits of psi."""
        p, q, r = map(to_double, self.scene.omega)
        swing = math.sqrt(to_double(self.scene.pendulum_rate_squared))
        return abs(r) > _MOST_SPIN * max(math.hypot(p, q), swing)

    def _flat_angles(self, rows: Flat, states: Flat) -> Gapped:
        """psi theta phi, all rows at once."""
        import numpy as np

        turns = np.zeros((2, len(rows)), dtype=np.longdouble)
        if rows.shape[1] > self._first + 4:  # not of a motion that stays at a pole
            turns += rows[:, self._first + 4 :].T
        pi = 4 * np.arctan(np.longdouble(1))
        if not self._spins:
            turns[0] = self._psi(rows, states, turns[0])
        fn = AngleFunctions(np.hypot, np.arctan2, pi, np.rint, np.where)
        gamma = states[:, 3:].T.astype(np.longdouble)
        columns = np.array(angles([*gamma], [*turns], fn)).T
        listed: Gapped = columns.astype(self._kind).tolist()
        return listed

    def _psi(self, rows: Flat, states: Flat, integrated: Extendeds) -> Extendeds:
        """psi of the quaternion beside an integrated one."""
        import numpy as np

        q = self._upright(rows, states)
        psi = np.arctan2(q[3], q[0]) + np.arctan2(q[2], q[1])
        high = np.longdouble(np.float32(np.pi))  # whole multiples of it are exact
        low = 4 * np.arctan(np.longdouble(1)) - high
        halves = np.rint((integrated - psi) / (high + low))
        rounded = (psi + halves * high) + halves * low
        return np.where(self._begin(rows), integrated, rounded)

    def _angles(self, row: GivenRow, state: GivenRow) -> list[Real | None]:
        """The same of a row above extended."""
        from polhode.numbers.mpmath_context import mpmath, ordinary, own

        turns = [*map(own, row[self._first + 4 :])] or [mpmath.mpf(0)] * 2
        fn = AngleFunctions(
            mpmath.hypot, mpmath.atan2, mpmath.pi, mpmath.nint, lambda c, a, b: a if c else b
        )
        more = GUARD_BITS + int(abs(turns[0])).bit_length()
        with mpmath.workprec(self.number.bits + more):
            if not (self._spins or self._begins(row)):
                q = self._upright_row(row, state)
                psi = mpmath.atan2(q[3], q[0]) + mpmath.atan2(q[2], q[1])
                turns[0] = psi + mpmath.pi * mpmath.nint((turns[0] - psi) / mpmath.pi)
            values = angles([*map(own, state[3:])], turns, fn)
        with mpmath.workprec(self.number.bits):
            listed: list[Real | None] = ordinary([+x for x in values])
            return listed

    @cached_property
    def _kind(self) -> type[np.floating[Any]]:
        import numpy as np

        return np.float64 if self.number.name == "double" else np.longdouble

    def _array(self, rows: Given) -> Flat:
        """An array of the type, which numpy holds."""
        import numpy as np

        array: Flat = np.asarray(rows, dtype=self._kind)
        return array

    def _flat(self, rows: Flat) -> Flat:
        """The same of an array, as a new array."""
        if self.form.plain and self.frame.axes.trivial:
            return rows[:, : self.columns].copy()
        if self.number.name == "double":
            return self._in_extended(rows)
        wide = [[to_extended(exactly(x)) for x in row] for row in self._vectors(rows)]
        return self._array(wide).reshape(len(rows), self.columns)

    def _vectors(self, rows: Given) -> list[list[Scalar]]:
        """Rows of omega and gamma in scene axes and the frame's unit, rounded once at the end."""
        from polhode.numbers.mpmath_context import mpmath

        bits = self.number.bits + GUARD_BITS
        with mpmath.workprec(bits):
            k = {name: to_mpf(x, bits) for name, x in self.form.coefficients.items()}
            fn = of_mpmath()
            vectors = [
                self.form.state([to_mpf(exactly(x), bits) for x in row], k, fn) for row in rows
            ]
        return self._in_scene_axes(vectors, bits)

    def _in_scene_axes(
        self, rows: Iterable[Iterable[Sequence[Scalar]]], bits: int
    ) -> list[list[Scalar]]:
        """Pairs of omega and gamma, one after the other, turned and rounded to the run's type."""
        from polhode.numbers.mpmath_context import mpmath

        axes = self.frame.axes
        with mpmath.workprec(self.number.bits):
            if axes.trivial:
                return [[+x for vector in pair for x in vector] for pair in rows]
            entries = [[to_mpf(x, bits) for x in row] for row in axes.rows]
            return [
                [
                    mpmath.fdot((entries[i][j], vector[i]) for i in range(3))
                    for vector in pair
                    if vector
                    for j in range(3)
                ]
                for pair in rows
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
        if not self.frame.axes.trivial:
            vectors = [vector @ self._turn for vector in vectors]
        return np.hstack(vectors).astype(self._kind)

    @cached_property
    def _extended(self) -> dict[str, Scalar]:
        """The form's coefficients in extended."""
        return {name: to_extended(x) for name, x in self.form.coefficients.items()}

    @cached_property
    def _turn(self) -> Flat:
        """The turn from the frame's axes to the scene's in extended."""
        return self.frame.matrix(EXTENDED)

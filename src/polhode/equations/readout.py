"""From the integrator's rows to what is asked: omega and gamma in scene axes, attitude, angles."""

from __future__ import annotations

import math
from contextlib import AbstractContextManager, nullcontext
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from polhode.common.values import cached_property
from polhode.equations import kinematics
from polhode.equations.form import Coefficients, FormValues, equations
from polhode.equations.kinematics import AngleFunctions, angles, starting_attitude
from polhode.motion.frame import Frame
from polhode.numbers import exact, number_types, vectors
from polhode.numbers.conversion import exactly, narrowed, number_value, to_double
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import Booleans, Flat, Functions, Given, NumberType, Rows, Scalar
from polhode.numbers.row_formulas import RowMap
from polhode.numbers.vectors import Vector, dot, is_zero, quaternion_product, scaled, upright
from polhode.scenes.scene import Scene

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
    along = gamma is None or vectors.parallel(gamma, omega)  # gamma' = gamma × w
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
#
# Angles and attitude are computed in columns, one for all rows: of longdoubles, or of polhode's own
# mpf with more bits than the numbers have.


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
        self._first = len(self.form.variables)  # column of the quaternion, before psi and phi
        self._copied = self.form.plain and self.frame.axes.trivial

    def __reduce__(self) -> tuple[object, ...]:
        """What it is made of: the rest is made again."""
        return Readout, (self.scene, self.number, self.frame)

    def states(self, rows: Given) -> Rows:
        """p q r [gamma1 gamma2 gamma3] in scene axes: an ndarray, or rows of mpf above extended."""
        if len(rows) == 0:
            return self._array([]).reshape(0, self.columns) if self.number.flat else []
        if self.number.flat:
            variables = self._array(rows)[:, : self._first]
            if self._copied:
                states = variables[:, : self.columns].copy()
            elif self.form.plain and self.number.name == "double":
                vectors = np.split(
                    variables.astype(np.longdouble), range(3, self.columns, 3), axis=1
                )
                states = self._array(np.hstack([vector @ self._turn for vector in vectors]))
            else:
                return self._array(self._states(variables))
            if self.frame.exponent:
                states[:, :3] = np.ldexp(states[:, :3], -self.frame.exponent)
            return states
        read: list[list[Scalar]] = [*self._states([row[: self._first] for row in rows])]
        first = zip(rows[0][: self._first], self.form.start, strict=True)
        if not self._copied and all(exactly(x) == self.number.rounded(y) for x, y in first):
            read[0] = [number_value(x, self.number) for x in self.scene.start]
        return read

    @cached_property
    def _states(self) -> RowMap:
        """omega and gamma of the variables, in the scene's axes and unit of time."""
        form, turn = self.form, self.frame.turn
        coefficients = {**form.coefficients, **turn, "1/unit": 1 / self.frame.unit}
        entries = [
            [(name, i) for i in range(3) if (name := f"turn{i}{j}") in turn] for j in range(3)
        ]

        def state(row: FormValues, k: Coefficients, fn: Functions) -> list[Scalar]:
            omega, gamma = form.state(row, k, fn)
            if turn:
                omega, gamma = (
                    [fn.dot([(k[name], v[i]) for name, i in column]) for column in entries if v]
                    for v in (omega, gamma)
                )
            return [*(k["1/unit"] * x for x in omega), *gamma]

        return RowMap(state, coefficients, self.number, self.columns)

    @cached_property
    def _turn(self) -> Flat:
        """The turn from the frame's axes to the scene's in extended."""
        return self.frame.matrix(number_types.EXTENDED)

    def attitude(self, rows: Given, states: Rows) -> Rows | None:
        """q0 q1 q2 q3 beside states, if asked for or needed: of length one, and gamma's."""
        if "attitude" not in self.scene.modelled:
            return None
        if len(rows) == 0:
            return self._array([]).reshape(0, 4) if self.number.flat else []
        with self._wider():
            columns, gamma = self._columns(rows, self._first), self._columns(states, 3)
            quaternions: Rows = self._narrowed(self._upright(columns, gamma))
            return quaternions

    def angles(self, rows: Given, states: Rows) -> number_types.Gapped | None:
        """psi theta phi beside states, if asked for; psi and phi None at a pole.

        psi is the quaternion's, whose rate is finite at a pole, and phi gamma's; their half turns
        are those of the integrated ones.
        """
        if "angles" not in self.scene.modelled:
            return None
        if len(rows) == 0:
            return []
        columns, gamma = self._columns(rows, self._first), self._columns(states, 3)
        turns = [*columns[4:]] or [0 * gamma[0], 0 * gamma[0]]  # that of a pole
        with self._wider(turns[0]):
            if not self._spins:
                turns[0] = self._psi(columns, gamma, turns[0])
            values = np.array(angles([*gamma], turns, self._functions))
            narrow = self._narrowed(values)
        rows_of_angles: number_types.Gapped = narrow.tolist() if self.number.flat else narrow
        vertical = (gamma[0] == 0) & (gamma[1] == 0)
        if self.scene.starts_at_pole:  # of a start in turned axes gamma is rounded
            vertical |= self._begin(columns)
        for k in np.flatnonzero(vertical).tolist():
            rows_of_angles[k][0] = rows_of_angles[k][2] = None
        return rows_of_angles

    def _upright(self, columns: Any, gamma: Any) -> Any:
        """The quaternion beside gamma, a column each; the start's as it is."""
        nearest = upright([*columns[:4]], [*gamma], self._functions.sqrt)
        return np.where(self._begin(columns), columns[:4], np.array(nearest))

    def _psi(self, columns: Any, gamma: Any, integrated: Any) -> Any:
        """psi of the quaternion beside an integrated one."""
        fn, q = self._functions, self._upright(columns, gamma)
        psi = fn.atan2(q[3], q[0]) + fn.atan2(q[2], q[1])
        high: Scalar = 0
        if self.number.flat:
            high = np.longdouble(np.float32(np.pi))  # whole multiples of it are exact
        halves = fn.rint((integrated - psi) / fn.pi)
        rounded = (psi + halves * high) + halves * (fn.pi - high)
        return np.where(self._begin(columns), integrated, rounded)

    def _begin(self, columns: Any) -> Booleans:
        """Which rows have the quaternion of the start."""
        first = np.array(self._first_attitude)[:, None]
        begins: Booleans = (columns[:4] == first).all(axis=0)
        return begins

    @cached_property
    def _first_attitude(self) -> list[Scalar]:
        """The quaternion at the start, rounded to the run's type."""
        assert self.scene.gamma is not None
        first = starting_attitude(self.scene.gamma, self.scene.psi)
        return [number_value(x, self.number) for x in first]

    @cached_property
    def _spins(self) -> bool:
        """Whether phi grows so much faster that the quaternion has fewer digits of psi."""
        p, q, r = map(to_double, self.scene.omega)
        swing = math.sqrt(to_double(self.scene.pendulum_rate_squared))
        return abs(r) > _MOST_SPIN * max(math.hypot(p, q), swing)

    def _array(self, rows: Given) -> Flat:
        """An array of the type, which numpy holds; not a number where there is none."""
        return np.asarray(rows, dtype=number_types.kind_of(self.number))

    # -- columns ------------------------------------------------------------------------------

    def _columns(self, rows: Given, first: int) -> Any:
        """An array with a row for each column from one on, to be computed with."""
        if self.number.flat:
            return self._array(rows)[:, first:].T.astype(np.longdouble)
        from polhode.numbers.mpmath_context import own

        listed = [[*row[first:]] for row in rows]
        return np.frompyfunc(own, 1, 1)(np.array(listed, dtype=np.object_).T)

    def _narrowed(self, columns: Any) -> Any:
        """The same rounded to the run's type, row by row."""
        if self.number.flat:
            return self._array(columns.T)
        return [[narrowed(x, self.number) for x in row] for row in columns.T.tolist()]

    def _wider(self, turns: Any = ()) -> AbstractContextManager[object]:
        """With some more bits than the numbers have, and those before the point of turns."""
        if self.number.flat:
            return nullcontext()
        from polhode.numbers.mpmath_context import mpmath

        before = max((int(abs(x)).bit_length() for x in turns), default=0)
        wider: AbstractContextManager[object] = mpmath.workprec(
            self.number.bits + GUARD_BITS + before
        )
        return wider

    @property
    def _functions(self) -> AngleFunctions:
        """Of such columns, in the precision in force."""
        if self.number.flat:
            pi = 4 * np.arctan(np.longdouble(1))
            return AngleFunctions(np.hypot, np.arctan2, np.sqrt, np.rint, pi)
        from polhode.numbers.mpmath_context import mpmath

        hypot, atan2 = (np.frompyfunc(f, 2, 1) for f in (mpmath.hypot, mpmath.atan2))
        root, rint = (np.frompyfunc(f, 1, 1) for f in (mpmath.sqrt, mpmath.nint))
        return AngleFunctions(hypot, atan2, root, rint, +mpmath.pi)

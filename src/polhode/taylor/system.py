"""The system that a run integrates: a form of the equations and what its outputs add, in a type."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import NamedTuple, cast

import numpy as np

from polhode.common.errors import BadInput
from polhode.common.values import Recent, cached_property
from polhode.equations import kinematics, readout
from polhode.equations.form import Form, equations
from polhode.equations.readout import Readout
from polhode.motion.frame import Frame
from polhode.numbers import number_types
from polhode.numbers.conversion import ExactNumbers, number_value, rounds_to_nearest
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import Array, Flat, Functions, NumberType, Row, Rows, Scalar, flat
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import ANGLE_VARIABLES, ATTITUDE
from polhode.taylor.engine import Cyclic, Engine, Equations, EventWatcher, built, lent, nearest
from polhode.taylor.heyoka import OutOfRange, array, scalars
from polhode.taylor.projection import Target

_systems: Recent[System] = Recent(16)


class OutputTimes(NamedTuple):
    """A run's output times, numbers of its type: in the scene's unit, and inside the frame."""

    outside: ExactNumbers[Fraction]
    inside: ExactNumbers[Fraction]


@dataclass(frozen=True, eq=False)
class System:
    """What is integrated of a scene in one number type, shared by threads.

    ``scene``: the one outside the frame.  ``names``, ``coefficients``, ``start``: the variables,
    and exactly what they begin with, inside; but quaternion and angles, which ``outputs`` add, are
    those of the scene's axes, and the quaternion is there for the angles, too.
    ``tolerance``: of a step, the type's eps where it is None.  ``inputs``: the narrower type that
    start and coefficients were rounded to first, if any.  ``still``: no rate but zero.
    """

    scene: Scene
    form: Form
    names: tuple[str, ...]
    outputs: tuple[str, ...]
    coefficients: Mapping[str, Exact]
    start: tuple[Exact, ...]
    number: NumberType = number_types.DOUBLE
    tolerance: Fraction | None = None
    inputs: NumberType | None = None
    still: bool = False

    def __reduce__(self) -> tuple[object, ...]:
        """What it is made of: the rest is made again."""
        return system, (self.scene, self.outputs, self.number, self.tolerance, self.inputs)

    @cached_property
    def frame(self) -> Frame:
        """Between the scene's axes and unit of time and those of the run."""
        return self.form.frame

    def field(
        self, state: Sequence[Scalar], k: Mapping[str, Scalar], fn: Functions
    ) -> list[Scalar]:
        """Rates of the state and of what the outputs ask for."""
        n = len(self.form.variables)
        if self.still:
            return [fn.zero] * n
        rates = self.form.field(state[:n], k, fn)
        if not self.outputs:
            return rates
        vectors = self.form.state(state[:n], k, fn)
        omega, gamma = (kinematics.in_scene_axes(vector, k, fn.zero) for vector in vectors)
        rates += kinematics.attitude_rates(state[n : n + 4], omega)
        if "angles" in self.outputs:
            rates += kinematics.angle_rates(omega, gamma)
        return rates

    @cached_property
    def rests(self) -> bool:
        """Whether the state need not be integrated: it is that of a relative equilibrium."""
        principal_form = self.scene.form == "principal" and self.inputs is None
        return principal_form and readout.at_rest(self.scene).state

    @cached_property
    def singular(self) -> bool:
        """Whether the start is too near to the singular set of the form."""
        away = self.form.distance(self.form.start, self.form.coefficients, number_types.EXACT)
        return away is not None and bool(away <= nearest(self.number))

    @cached_property
    def read(self) -> Readout:
        """Reads the run's rows."""
        return Readout(self.scene, self.number)

    @cached_property
    def target(self) -> Target:
        """The integrals that runs are put back on."""
        return Target(self.form.scene, self.number)

    @cached_property
    def equations(self) -> Equations:
        """What compiled code is found by."""
        plain = self.scene.form == "principal"  # what is left of it is among the columns
        rounded = ((name, self.number.rounded(x)) for name, x in self.coefficients.items())
        return Equations(
            self.names,
            tuple(self.coefficients) if plain else (),
            self.number,
            self.tolerance,
            self.scene.form,
            () if plain else tuple(rounded),
            self.still,
            len(ANGLE_VARIABLES) if "angles" in self.outputs else 0,
        )

    @cached_property
    def state(self) -> Array:
        """The start as heyoka's numbers, cyclic variables at zero; raises OutOfRange."""
        start, cyclic = self.start, self.equations.cyclic
        values = [*start[: len(start) - cyclic], *[Fraction(0)] * cyclic]
        return array(scalars(values, self.number), self.number)

    @cached_property
    def parameters(self) -> Array:
        """The coefficients as heyoka's numbers; raises OutOfRange."""
        return array(scalars([*self.coefficients.values()], self.number), self.number)

    @cached_property
    def cyclic(self) -> Cyclic | None:
        """The cyclic variables at the start, for runs to copy; None without any."""
        start, count = self.start, self.equations.cyclic
        return Cyclic(start[len(start) - count :], self.number) if count else None

    @cached_property
    def first(self) -> Rows:
        """The start as the one row of a run; not to be written to."""
        if self.number.flat and not self.equations.cyclic:
            with suppress(OutOfRange):  # whoever integrates says so
                return flat(self.state)[None]
        return self.rows([[number_value(x, self.number) for x in self.start]])

    def with_outputs(self, outputs: tuple[str, ...]) -> System:
        """The system with these outputs alone."""
        return system(self.scene, outputs, self.number, self.tolerance, self.inputs)

    def rows(self, rows: Sequence[Row]) -> Rows:
        """Rows of the run's numbers, as a run holds them: an array, or a list above extended."""
        if not self.number.flat:
            return [[*row] for row in rows]
        width = len(rows[0]) if rows else len(self.start)
        wide = np.array(rows, dtype=np.longdouble).reshape(-1, width)
        return wide if self.number.name == "extended" else wide.astype(np.float64)

    def times(self, scene: Scene) -> OutputTimes:
        """The output times of its scene, or of that one at other times.

        The last two are kept.  Raises BadInput for times that the type does not tell apart.
        """
        given_times, last = scene.times, self._last_times
        for before, times in last:
            if before is given_times:
                return times
        outside = rounded_times(scene, self.number)
        times = OutputTimes(outside, inside(outside, self.frame.exponent, self.number))
        last[:] = [(given_times, times), *last[:1]]
        return times

    @cached_property
    def _last_times(self) -> list[tuple[Sequence[Exact], OutputTimes]]:
        return []

    def engine(
        self, watcher: EventWatcher | None = None, order: int = 0, tolerance: Fraction | None = None
    ) -> Engine:
        """An engine that stands at the start at time 0, and looks for a watcher's events.

        ``order``: of a step, heyoka's own for the tolerance where it is 0; ``tolerance``: that of
        such steps, the system's if None.  Raises OutOfRange for numbers that the type cannot hold,
        before anything is compiled.
        """
        start, parameters, equations = self.state, self.parameters, self.equations
        if order:
            equations = replace(equations, order=order, tolerance=tolerance or self.tolerance)
        key = equations if watcher is None else (equations, watcher.key)

        def build() -> Engine:
            return built(equations, self.field, self.form.distance, watcher)

        engine = lent(key, build, wait=False)
        if watcher is not None:
            engine.damp(array(scalars(watcher.damping, self.number), self.number))
        engine.state[:] = start
        engine.begin(parameters)
        return engine


def system(
    scene: Scene,
    outputs: Sequence[str] = (),
    number: NumberType = number_types.DOUBLE,
    tolerance: Fraction | None = None,
    inputs: NumberType | None = None,
) -> System:
    """The equations of a scene with these outputs and nothing else."""
    form = equations(scene)
    names, start, k = [*form.variables], [*form.start], dict(form.coefficients)
    if scene.gamma is not None:
        if outputs:
            k |= form.frame.turn
            names += ATTITUDE
            start += kinematics.starting_attitude(scene.gamma, scene.psi)
        if "angles" in outputs:
            names += ANGLE_VARIABLES
            start += [scene.psi, kinematics.starting_phi(scene.gamma)]
    if inputs is not None:
        k = {name: inputs.rounded(x) for name, x in k.items()}
        start = [inputs.rounded(x) for x in start]
    parts = scene, form, tuple(names), tuple(outputs), k, tuple(start)
    return System(*parts, number, tolerance, inputs)


def system_of(
    scene: Scene,
    number: NumberType,
    tolerance: Fraction | None = None,
    inputs: NumberType | None = None,
) -> System:
    """The system of such runs, shared by scenes that differ in their times alone.

    Raises BadInput where a library has left this thread another rounding mode than to nearest.
    """
    refuse_other_rounding(scene)
    key = (number, tolerance, inputs)
    return _systems.get(scene.identity, key, lambda: system(scene.apart(), scene.modelled, *key))


def refuse_other_rounding(scene: Scene) -> None:
    """Raise BadInput where a library has left this thread another rounding mode than nearest."""
    if not rounds_to_nearest():
        expected = "nearest: a library has set another one in this thread (fesetround)"
        raise BadInput(scene.name, "rounding mode", "not to nearest", expected)


def rounded_times(scene: Scene, number: NumberType) -> ExactNumbers[Fraction]:
    """The output times as numbers of the run's type."""
    if not scene.times:
        raise BadInput(scene.name, "run.end", None, "a time, or times given with --at")
    times = cast("ExactNumbers[Exact]", scene.times).rounded(number)
    k = times.misplaced()
    if k is not None:
        expected = f"times that differ when rounded to {number.name}"
        raise BadInput(scene.name, f"run.at[{k + 1}]", shown(times[k]), expected)
    return times


def inside(
    times: ExactNumbers[Fraction], exponent: int, number: NumberType
) -> ExactNumbers[Fraction]:
    """Times of a type in a unit of 2**exponent: an array where they are one, and hold as one."""
    if times.floats is not None:
        most = 1000 if number.bits == 53 else 16000
        grid = np.ldexp(times.floats, -exponent) if exponent else times.floats
        sizes = np.frexp(grid[1:] if grid[0] == 0 else grid)[1]
        if np.all(np.abs(sizes) < most):
            return ExactNumbers(floats=grid)
    elif not exponent:
        return times
    unit = Fraction(2) ** -exponent
    return ExactNumbers(tuple(t * unit for t in times.exact))


def time_array(times: ExactNumbers[Fraction], number: NumberType) -> Flat:
    """Times as an array of heyoka's numbers, of a type that numpy holds."""
    if times.floats is not None:
        return times.floats
    return cast("Flat", array(scalars(times.exact, number), number))


def principal_system(scene: Scene) -> System:
    """The equations of a scene's state in the principal form."""
    return system(scene if scene.form == "principal" else replace(scene, form="principal"))

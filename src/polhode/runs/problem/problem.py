"""A scene made ready for one number type: everything that its runs begin with, made once."""

from __future__ import annotations

from dataclasses import dataclass, fields
from fractions import Fraction
from typing import TYPE_CHECKING

from polhode.common.cached_property import cached_property
from polhode.common.recent import Recent
from polhode.equations import equilibrium
from polhode.equations.form import Form, equations
from polhode.equations.readout import Readout
from polhode.equations.system import System, system
from polhode.numbers.conversion import to_extended
from polhode.numbers.exact import Exact
from polhode.numbers.exact_sequences import ExactNumbers
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Extendeds
from polhode.numbers.scalars import EXACT
from polhode.runs.problem.options import refuse_other_rounding, rounded_times
from polhode.scenes.scene import Scene
from polhode.taylor.backend.time_grid import Times

if TYPE_CHECKING:
    from polhode.taylor.corrections.integral_projection import Target
    from polhode.taylor.events.rules import Rules
    from polhode.taylor.integrator.prepared_system import PreparedSystem


@dataclass(frozen=True, eq=False)
class Problem:
    """What depends on a scene, a number type and a tolerance, but not on the output times.

    ``inputs``: the narrower type that start and coefficients are rounded to first, if any.
    Shared by threads: what a property gives does not depend on who asks, nor how often.
    """

    scene: Scene
    number: NumberType
    tolerance: Fraction | None = None
    inputs: NumberType | None = None

    def __getstate__(self) -> dict[str, object]:
        """The fields alone: what is made from them is made again."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    @cached_property
    def unit(self) -> Fraction:
        """The run's own unit of time."""
        return Fraction(2) ** self.scene.time_unit

    @cached_property
    def read(self) -> Readout:
        """Reads the run's rows."""
        return Readout(self.scene, self.number)

    @cached_property
    def form(self) -> Form:
        """The form of the equations."""
        return equations(self.scene)

    @cached_property
    def still(self) -> bool:
        """Whether the state need not be integrated: it is that of a relative equilibrium."""
        principal_form = self.scene.form == "principal" and self.inputs is None
        return principal_form and equilibrium.at_rest(self.scene).state

    @cached_property
    def singular(self) -> bool:
        """Whether the start is too near to the singular set of the form."""
        from polhode.taylor.integrator.singularities import nearest

        away = self.form.distance(self.form.start, self.form.coefficients, EXACT)
        return away is not None and bool(away <= nearest(self.number))

    def prepared(self, variables: tuple[str, ...] = ()) -> PreparedSystem:
        """The equations of the state, and of what is integrated beside it."""
        found = self._prepared.get(variables)
        if found is None:
            from polhode.taylor.integrator.prepared_system import PreparedSystem

            made = PreparedSystem(self.system(variables), self.number, self.tolerance)
            found = self._prepared.setdefault(variables, made)  # another thread's may be there
        return found

    @cached_property
    def _prepared(self) -> dict[tuple[str, ...], PreparedSystem]:
        return {}

    def system(self, variables: tuple[str, ...] = ()) -> System:
        """The same, not kept: its inputs rounded to the narrower type, where that is wanted."""
        found = system(self.scene, variables)
        return found if self.inputs is None else found.rounded(self.inputs)

    @cached_property
    def target(self) -> Target:
        """The integrals that a run is put back on."""
        from polhode.taylor.corrections.integral_projection import Target

        return Target(self.scene, self.number)

    @cached_property
    def turn(self) -> Extendeds | None:
        """The form's axes along the scene's, rows of longdoubles; None where they are the same."""
        import numpy as np

        axes = self.form.axes
        return None if axes.trivial else np.array([[to_extended(x) for x in v] for v in axes.rows])

    def schedule(self, scene: Scene) -> Schedule:
        """The output times of the scene, or of one that differs from it in its times alone.

        The last two are kept.
        """
        times, kept = scene.output_times, self._schedules
        for before, found in kept:
            if before is times:
                return found
        exact = rounded_times(scene, self.number)
        inside = Times.scaled(exact, -self.scene.time_unit, self.number)
        found = Schedule(exact, inside)
        kept[:] = [(times, found), *kept[:1]]
        return found

    def rules(self, scene: Scene) -> Rules:
        """What the events are looked for by; t in one is as large as the end."""
        from polhode.taylor.events.rules import Rules

        def made() -> Rules:
            return Rules(scene, self.number, self.tolerance, self.still)

        timed = any(event.timed for event in scene.events)
        return _rules.get(self, self.schedule(scene).exact[-1] if timed else None, made)

    @cached_property
    def _schedules(self) -> list[tuple[ExactNumbers[Exact], Schedule]]:
        return []


@dataclass(frozen=True, eq=False)
class Schedule:
    """Output times rounded to a run's type: ``exact``, and ``inside`` its own unit."""

    exact: ExactNumbers[Fraction]
    inside: Times


_kept: Recent[Problem] = Recent(16)
_rules: Recent[Rules] = Recent(1)


def problem(
    scene: Scene,
    number: NumberType,
    tolerance: Fraction | None = None,
    inputs: NumberType | None = None,
) -> Problem:
    """The problem of such runs, shared by scenes that differ in their times alone."""
    refuse_other_rounding(scene)
    key = (number, tolerance, inputs)

    def made() -> Problem:
        return Problem(scene.apart(), number, tolerance, inputs)

    return _kept.get(scene.identity, key, made)

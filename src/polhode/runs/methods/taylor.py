"""Taylor steps: the equations that a plan needs, marched from time to time."""

from __future__ import annotations

import time
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

from polhode.common.errors import BadInput
from polhode.common.progress import Progress
from polhode.equations import equilibrium, kinematics
from polhode.equations.form import Form
from polhode.equations.pole_passage import phi_leaving_the_pole
from polhode.equations.system import System, system
from polhode.motion.outcomes import EventTimes, Outcome, Projection
from polhode.numbers import number_types
from polhode.numbers.conversion import exactly, number_value
from polhode.numbers.exact import ZERO
from polhode.numbers.rows import Rows
from polhode.runs.methods.dense_output import Dense, Leg
from polhode.runs.methods.output_loop import march
from polhode.runs.problem.options import USUAL, Options, cadence
from polhode.runs.problem.problem import Prepared, Problem
from polhode.scenes.scene import Scene
from polhode.taylor.backend import defaults
from polhode.taylor.backend.time_grid import Times
from polhode.taylor.integrator.protocols import Corrector, Integrating, Watcher

if TYPE_CHECKING:
    from polhode.taylor.events.watch import Watch

#: Where a start at a pole is left, in the scene's own unit of time: a fraction of a radian on.
_OFF_THE_POLE = Fraction(1, 2)


class TaylorMotion:
    """A problem on its way by Taylor steps in one number type.

    ``scene``: the problem's own, with the times of this run.  ``variables``: integrated beside the
    state.  ``watched``: whether its events are looked for as steps are taken.
    """

    method = "taylor"
    errors: tuple[float | None, ...] | None = None
    remarks: Mapping[str, str] = {}

    def __init__(
        self,
        problem: Problem,
        scene: Scene,
        variables: tuple[str, ...] = (),
        watched: bool = False,
        options: Options = USUAL,
    ) -> None:
        self.problem, self.number, self.scene = problem, problem.number, scene
        self.variables, self.watched, self.options = variables, watched, options
        self.read = problem.read
        self.steps = 0
        self.reached = ZERO
        self.build_seconds = 0.0
        self.events: tuple[EventTimes, ...] = ()
        self.legs: list[Leg] = []
        self.projection: Projection | None = None
        self._watch: Watcher | None = None
        self._working: Integrating | None = None

    def interpolant(self, reached: Fraction) -> Dense:
        """The state at any time up to the one that was reached."""
        first = self._prepared.first
        return Dense(self.scene, self.number, reached, self.legs, first, self.again)

    @property
    def begun(self) -> list[Fraction]:
        """Where the steps' clock began anew."""
        return [mark.offset for leg in self.legs for mark in leg.marks]

    def again(self, leg: Leg) -> Integrating:
        """An integrator that takes a leg's steps again, without looking for events."""
        watch = self._new_watch()
        if watch is not None:
            watch.muted = True
        corrector = self._corrector(leg.system.form, watch) if leg.projected else None
        return self._built(leg.system, leg.origin, watch, corrector)

    def _next_leg(
        self, what: System, origin: Fraction, watch: Watcher | None, corrector: Corrector | None
    ) -> Integrating:
        """The integrator of the next leg."""
        built = self._built(what, origin, watch, corrector)
        self.legs.append(Leg(what, origin, built.marks, corrector is not None))
        return built

    def advance(
        self, times: Sequence[Fraction], progress: Progress | None = None
    ) -> tuple[Rows, Outcome]:
        """Rows at the times, in the run's own unit, as far as they were reached; the outcome."""
        from polhode.taylor.backend import heyoka_numbers

        try:
            watch = self._watch = self._new_watch()
            rows, outcome = self._to(Times.of(times, self.number), progress)
        except heyoka_numbers.OutOfRange as fault:
            expected = f"a type of wider range ({fault})"
            raise BadInput(self.scene.name, "number", self.number.name, expected) from None
        if watch is not None:
            self.events = watch.found()
            if outcome is Outcome.NON_FINITE:  # a contact may be polished to beyond a pole
                self.events = tuple(event.until(self.reached) for event in self.events)
            if self._working is not None and outcome.done:
                self._working.release()
            self._watch = self._working = None
        return rows, outcome

    @property
    def _prepared(self) -> Prepared:
        return self.problem.prepared(self.variables)

    def _to(self, times: Times, progress: Progress | None) -> tuple[Rows, Outcome]:
        problem = self.problem
        if problem.still:
            return self._stand_still(times, progress)
        began = time.perf_counter()
        prepared = self._prepared
        whole, rows = prepared.system, prepared.first[: times[0] == 0]
        self.build_seconds += time.perf_counter() - began
        if len(rows) == len(times):
            return rows, Outcome.REACHED_END
        if problem.singular:
            return rows, Outcome.SINGULAR
        origin = ZERO
        if "angles" in self.variables and self.scene.starts_at_pole:
            whole, origin = self._off_the_pole(whole, times[len(rows)])
            if not isinstance(rows, list):  # a motion that stays at the pole has no angles
                rows = rows[:, : len(whole.start)]
        rows, outcome = self._advanced(whole, origin, times, rows, progress)
        return rows[: self._before_stop(times, len(rows))], outcome

    def _before_stop(self, times: Sequence[Fraction], count: int) -> int:
        """How many of the first times are not beyond an event that ended the run."""
        if not self._stopped:
            return count
        return bisect_right(times, abs(self.reached / self.problem.unit), hi=count, key=abs)

    def _advanced(
        self,
        whole: System,
        origin: Fraction,
        times: Times,
        rows: Rows,
        progress: Progress | None,
    ) -> tuple[Rows, Outcome]:
        """Integrate a system that stands at time ``origin``; ``rows`` and those to come."""
        problem = self.problem
        outcome = Outcome.STOPPED_AT_EVENT
        if not self._stopped:
            corrector = self._corrector(whole.form, self._watch)
            integrator = self._next_leg(whole, origin, self._watch, corrector)
            self._refuse_what_never_moves()
            choices = defaults.of(self.number)
            most = self.options.max_steps
            limit = choices.max_steps if most is None else most
            rows, outcome = march(integrator, times, rows, limit, choices.chunk, progress)
            if corrector is not None:
                self.projection = corrector.found()
                self.build_seconds += corrector.seconds
            self.steps += integrator.steps
            # the end itself, not its rounding relative to where the last chunk began
            done = outcome is Outcome.REACHED_END
            last = times[-1] if done else integrator.time
            self.reached = last if problem.unit == 1 else last * problem.unit
            if self._watch is not None:
                self._working = integrator  # its events are told first
            elif outcome.done:
                integrator.release()
        if self._watch is not None and self._watch.stop is not None:
            self.reached = self.number.rounded(self._watch.stop) * problem.unit
        return rows, outcome

    def _stand_still(self, times: Times, progress: Progress | None) -> tuple[Rows, Outcome]:
        """Rows of a state that never changes; only its events, those of t, need an integrator."""
        unit, prepared = self.problem.unit, self._prepared
        rows = prepared.rows(
            [
                [number_value(x, self.number) for x in equilibrium.variables(self.scene, t * unit)]
                for t in times
            ]
        )
        outcome, self.reached = Outcome.REACHED_END, times[-1] * unit
        if self._watch is None or self.reached == 0:
            return rows, outcome
        whole = replace(system(self.scene, ()), still=True)
        passed = [row[: len(whole.start)] for row in rows[: times[0] == 0]]
        watched, outcome = self._advanced(whole, ZERO, times, prepared.rows(passed), progress)
        return rows[: self._before_stop(times, len(watched))], outcome

    def _corrector(self, form: Form, watch: Watcher | None) -> Corrector | None:
        """What corrects the state now and then; None where nothing does."""
        if form.unit is not None:
            from polhode.taylor.corrections.quaternion_norm import UnitNorm

            return UnitNorm(form.unit, self.number)
        problem = self.problem
        every = cadence(self.scene, self.number, problem.tolerance, self.options.project)
        if every is None or problem.inputs is not None or problem.still:
            return None
        from polhode.taylor.corrections.integral_projection import Projector

        return Projector(problem.target, every, watch)

    def _new_watch(self) -> Watch | None:
        """What looks for the scene's events; None where they are not watched."""
        if not self.watched:
            return None
        from polhode.taylor.events.watch import Watch

        return Watch(self.scene, self.number, self.problem.rules(self.scene))

    @property
    def _stopped(self) -> bool:
        return self._watch is not None and self._watch.stop is not None

    def _refuse_what_never_moves(self) -> None:
        """Refuse an event that is zero all along the motion: in this type, and to 200 digits."""
        suspects = self._watch.still() if self._watch is not None else []
        if not suspects:
            return
        from polhode.taylor.events.rules import Rules
        from polhode.taylor.events.watch import Watch
        from polhode.taylor.integrator.build import build

        fine = number_types.mp(200)
        watch = Watch(self.scene, fine, Rules(self.scene, fine, None, False))
        build(system(self.scene, ()), fine, watcher=watch)
        for k in watch.still():
            if k in suspects:
                event = self.scene.events[k]
                key, text = f"events[{k + 1}].zero", event.expression or event.name
                expected = "an expression that is not zero at all times of the motion"
                raise BadInput(self.scene.name, key, text, expected)

    def _built(
        self,
        what: System,
        origin: Fraction,
        watch: Watcher | None,
        corrector: Corrector | None,
    ) -> Integrating:
        """An integrator that stands at the start of a system."""
        from polhode.taylor.integrator.build import blueprint
        from polhode.taylor.integrator.stepping import Integrator

        began, prepared = time.perf_counter(), self._prepared
        if what is prepared.system:
            plan = prepared.blueprint
        else:
            plan = blueprint(what, self.number, self.problem.tolerance)
        built = Integrator(plan, origin, watch, corrector)
        self.build_seconds += time.perf_counter() - began
        return built

    def _off_the_pole(self, whole: System, first: Fraction) -> tuple[System, Fraction]:
        """The system a moment after a start at a pole, where psi' is 0/0, and that moment.

        The attitude leads over the pole; psi and phi then begin at their one-sided limits, the one
        of psi ± phi that has a meaning at the pole staying continuous.  A motion that stays at
        the pole has no psi and phi at all.
        """
        moment = max(-_OFF_THE_POLE, min(_OFF_THE_POLE, first / 2))
        bridge = self.problem.system(("attitude",))
        leading = self._next_leg(bridge, Fraction(0), self._watch, None)
        self._refuse_what_never_moves()
        found, outcome = leading.chunk([moment], 10**6)
        self.steps += leading.steps
        if self._watch is None and outcome.done:
            leading.release()
        if self._stopped:
            return whole, moment
        row = found[0]
        gamma = self.problem.read.states([row])[0][3:]
        if all(x == 0 for x in gamma[:2]):
            outputs = tuple(name for name in whole.outputs if name != "angles")
            names, start = whole.names[:-2], whole.start[:-2]
            return replace(whole, names=names, outputs=outputs, start=start), Fraction(0)
        variables = len(whole.form.variables)
        kept = row if "attitude" in whole.outputs else row[:variables]
        leaving = phi_leaving_the_pole(self.scene, 1 if moment > 0 else -1)
        psi, phi = kinematics.angles_off_the_pole(
            row[variables:], gamma, self.scene.psi, leaving, self.number.bits
        )
        return replace(whole, start=(*(exactly(x) for x in kept), psi, phi)), moment

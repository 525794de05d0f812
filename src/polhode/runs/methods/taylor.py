"""Taylor steps: state, attitude and angles in one system, marched from time to time."""

from __future__ import annotations

import time
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from polhode.common.cached_property import cached_property
from polhode.common.errors import BadInput
from polhode.common.progress import Progress
from polhode.equations import equilibrium, kinematics
from polhode.equations.form import Form
from polhode.equations.pole_passage import phi_leaving_the_pole
from polhode.equations.system import System, system
from polhode.motion.outcomes import EventTimes, Outcome, Projection
from polhode.numbers.conversion import exactly, number_value
from polhode.numbers.exact import ZERO
from polhode.numbers.expression import ExpressionError
from polhode.numbers.rows import Row, Rows
from polhode.runs.methods.dense_output import Leg, Path, spacing
from polhode.runs.problem.options import USUAL, Options, cadence
from polhode.runs.problem.problem import Problem
from polhode.scenes.scene import Scene
from polhode.taylor.backend import defaults
from polhode.taylor.backend.time_grid import Times
from polhode.taylor.integrator.protocols import Corrector

if TYPE_CHECKING:
    from polhode.taylor.events.watch import Watch
    from polhode.taylor.integrator.prepared_system import PreparedSystem
    from polhode.taylor.integrator.stepping import Integrator

#: Where a start at a pole is left, in the scene's own unit of time: a fraction of a radian on.
_OFF_THE_POLE = Fraction(1, 2)


class TaylorMotion:
    """A problem on its way by Taylor steps in one number type.

    ``scene``: the problem's own, with the times of this run.  What its outputs need is integrated
    with the state, and its events are looked for as steps are taken.  ``steps``: those taken.
    ``reached``: the exact time come to, in the scene's unit.  ``build_seconds``: the time that
    compiling took.  ``remarks``: for the provenance.
    """

    method = "taylor"
    errors: tuple[float | None, ...] | None = None
    remarks: Mapping[str, str] = {}

    def __init__(self, problem: Problem, scene: Scene, options: Options = USUAL) -> None:
        self.problem, self.number, self.scene = problem, problem.number, scene
        self.options, self.read = options, problem.read
        self.steps = 0
        self.reached = ZERO
        self.build_seconds = 0.0
        self.events: tuple[EventTimes, ...] = ()
        self.projection: Projection | None = None
        self._watch: Watch | None = None
        self._working: Integrator | None = None
        self._legs: list[Leg] = []
        self._anchored = 0  # steps between two anchors, where any are kept

    def __getstate__(self) -> dict[str, object]:
        """What ``at`` needs."""
        kept = "problem", "scene", "options", "reached"
        return {name: getattr(self, name) for name in kept}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__init__(state["problem"], state["scene"], state["options"])  # type: ignore[misc]
        self.reached = state["reached"]

    def at(self, times: Sequence[Fraction]) -> tuple[Sequence[Row], Outcome, Fraction]:
        """Rows at exact times in the scene's unit up to ``reached``, in the order of the motion.

        As many as are reached; how the motion ended, and when.
        """
        unit, first = self.problem.unit, self._prepared.first
        if self.problem.still:
            return [*self._at_rest(times)], Outcome.REACHED_END, self.reached
        if not any(times):
            return [first[0] for _ in times], Outcome.REACHED_END, self.reached
        rows, path = list[Row](), self._path
        for t in times:
            inside = t / unit
            if abs(inside) > abs(path.reached):
                break
            if not t:
                rows.append(first[0])
                continue
            leg, row = path.row(inside, self._stepping)
            if "angles" in self.scene.modelled and leg is not path.legs[-1]:
                numbers = [number_value(x, self.number) for x in self._off_pole(row, inside)]
                row = self._prepared.rows([numbers])[0]
            rows.append(row)
        return rows, path.outcome, path.reached * unit

    @cached_property
    def _path(self) -> Path:
        """The same steps once more, with anchors."""
        again = TaylorMotion(self.problem, self.scene, self.options)
        again._anchored = spacing(self.number)
        again._watch = self._muted_watch
        end = self.reached / self.problem.unit
        _, outcome = again._to(Times([end], self.number), None)
        if outcome is Outcome.INTERRUPTED:
            raise KeyboardInterrupt
        reached = end if outcome is Outcome.REACHED_END else again.reached / self.problem.unit
        again._release(outcome)
        return Path(again._legs, self.number, outcome, reached)

    def _stepping(self, leg: Leg) -> Integrator:
        """An integrator that takes a leg's steps again."""
        return self._built(leg.system, leg.origin, self._muted_watch, None)

    @cached_property
    def _muted_watch(self) -> Watch | None:
        """What makes the steps those of a run with events, and looks for none."""
        watch = self._new_watch()
        if watch is not None:
            watch.muted = True
        return watch

    def advance(
        self, times: Sequence[Fraction], progress: Progress | None = None
    ) -> tuple[Rows, Outcome]:
        """Rows at the times, in the run's own unit, as far as they were reached; the outcome."""
        from polhode.taylor.backend.heyoka_numbers import OutOfRange

        try:
            watch = self._watch = self._new_watch() if self.scene.events else None
            rows, outcome = self._to(Times.of(times, self.number), progress)
        except (OutOfRange, ExpressionError) as fault:  # of the system, of an event's number
            expected = f"a type of wider range ({fault})"
            raise BadInput(self.scene.name, "number", self.number.name, expected) from None
        if watch is not None:
            self.events = watch.found()
            if outcome is Outcome.NON_FINITE:  # a contact may be polished to beyond a pole
                self.events = tuple(event.until(self.reached) for event in self.events)
            self._release(outcome)
            self._watch = None
        return rows, outcome

    def _release(self, outcome: Outcome) -> None:
        """Leave the integrator of a run with events to the next one."""
        if self._working is not None and outcome.done:
            self._working.release()
        self._working = None

    @cached_property
    def _prepared(self) -> PreparedSystem:
        return self.problem.prepared(self.scene.modelled)

    def _to(self, times: Times, progress: Progress | None) -> tuple[Rows, Outcome]:
        problem = self.problem
        if problem.still:
            return self._stand_still(times, progress)
        began = time.perf_counter()
        prepared = self._prepared
        whole, rows = prepared.system, prepared.first[: times.now]
        self.build_seconds += time.perf_counter() - began
        if len(rows) == len(times):
            return rows, Outcome.REACHED_END
        if problem.singular:
            return rows, Outcome.SINGULAR
        origin = ZERO
        if "angles" in self.scene.modelled and self.scene.starts_at_pole:
            whole, origin = self._off_the_pole(whole)
            if not isinstance(rows, list):  # a motion that stays at the pole has no angles
                rows = rows[:, : len(whole.start)]
        rows, outcome = self._advanced(whole, origin, times, rows, progress)
        if self._watch is not None:
            rows = rows[: self._before_stop(times, len(rows))]
        return rows, outcome

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
        watch, outcome = self._watch, Outcome.STOPPED_AT_EVENT
        if watch is None or watch.stop is None:
            corrector = self._corrector(whole.form, watch)
            integrator = self._built(whole, origin, watch, corrector)
            if watch is not None:
                self._refuse_what_never_moves(watch)
            most = self.options.max_steps
            limit = defaults.of(self.number).max_steps if most is None else most
            rows, outcome = integrator.advance(times, rows, limit, progress)
            if corrector is not None:
                self.projection = corrector.found()
                self.build_seconds += corrector.seconds
            self.steps += integrator.steps
            # the end itself, not its rounding relative to where the last chunk began
            done = outcome is Outcome.REACHED_END
            last = times.end if done else integrator.time
            self.reached = last * problem.unit if self.scene.time_unit else last
            if watch is not None:
                self._working = integrator  # its events are told first
            elif outcome.done or outcome is Outcome.SINGULAR:
                integrator.release()
        if watch is not None and watch.stop is not None:
            self.reached = self.number.rounded(watch.stop) * problem.unit
        return rows, outcome

    def _stand_still(self, times: Times, progress: Progress | None) -> tuple[Rows, Outcome]:
        """Rows of a state that never changes; only its events, those of t, need an integrator."""
        unit, prepared = self.problem.unit, self._prepared
        rows = self._at_rest([t * unit for t in times])
        outcome, self.reached = Outcome.REACHED_END, times.end * unit
        if self._watch is None or self.reached == 0:
            return rows, outcome
        whole = replace(system(self.scene, ()), still=True)
        passed = [row[: len(whole.start)] for row in rows[: times.now]]
        watched, outcome = self._advanced(whole, ZERO, times, prepared.rows(passed), progress)
        return rows[: self._before_stop(times, len(watched))], outcome

    def _at_rest(self, times: Sequence[Fraction]) -> Rows:
        """Rows of a state that never changes, at times in the scene's unit."""
        exact = (equilibrium.variables(self.scene, t) for t in times)
        return self._prepared.rows([[number_value(x, self.number) for x in row] for row in exact])

    def _corrector(self, form: Form, watch: Watch | None) -> Corrector | None:
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
        if not self.scene.events:
            return None
        from polhode.taylor.events.watch import Watch

        return Watch(self.scene, self.number, self.problem.rules(self.scene))

    @property
    def _stopped(self) -> bool:
        return self._watch is not None and self._watch.stop is not None

    def _refuse_what_never_moves(self, watch: Watch) -> None:
        """Refuse an event that is zero all along the motion, for all that the type can tell."""
        for k in [] if watch.muted else watch.still():
            event = self.scene.events[k]
            key, text = f"events[{k + 1}].zero", event.expression or event.name
            expected = "an expression that is not zero at all times of the motion, to rounding"
            raise BadInput(self.scene.name, key, text, expected)

    def _built(
        self,
        what: System,
        origin: Fraction,
        watch: Watch | None,
        corrector: Corrector | None,
    ) -> Integrator:
        """The integrator of the next leg, at the start of its system."""
        from polhode.taylor.integrator.prepared_system import PreparedSystem
        from polhode.taylor.integrator.stepping import Integrator

        began, prepared = time.perf_counter(), self._prepared
        if what is not prepared.system:
            prepared = PreparedSystem(what, self.number, self.problem.tolerance)
        built = Integrator(prepared, origin, watch, corrector, anchored=self._anchored)
        if self._anchored:
            self._legs.append(Leg(what, origin, built.anchors))
        self.build_seconds += time.perf_counter() - began
        return built

    def _off_the_pole(self, whole: System) -> tuple[System, Fraction]:
        """The system a moment after a start at a pole, where psi' is 0/0, and that moment.

        The attitude leads over the pole, to before the first output.  A motion that stays at the
        pole has no psi and phi at all.
        """
        first = next(t for t in self.problem.schedule(self.scene).inside if t)
        moment = max(-_OFF_THE_POLE, min(_OFF_THE_POLE, first / 2))
        bridge = self.problem.system(("attitude",))
        leading = self._built(bridge, Fraction(0), self._watch, None)
        if self._watch is not None:
            self._refuse_what_never_moves(self._watch)
        found, outcome = leading.chunk([moment], 10**6)
        self.steps += leading.steps
        if self._watch is None and outcome.done:
            leading.release()
        if self._stopped:
            return whole, moment
        gamma = self.read.states(found)[0][3:]
        if all(x == 0 for x in gamma[:2]):
            self._legs.clear()
            outputs = tuple(name for name in whole.outputs if name != "angles")
            names, start = whole.names[:-2], whole.start[:-2]
            return replace(whole, names=names, outputs=outputs, start=start), Fraction(0)
        return replace(whole, start=tuple(self._off_pole(found[0], moment))), moment

    def _off_pole(self, row: Row, t: Fraction) -> list[Fraction]:
        """A row of the state and the attitude soon after a pole, as one with psi and phi.

        Those begin at their one-sided limits, the one of psi ± phi that has a meaning at the pole
        staying continuous.
        """
        variables = len(self.problem.form.variables)
        leaving = phi_leaving_the_pole(self.scene, 1 if t > 0 else -1)
        gamma = self.read.states([row])[0][3:]
        psi, phi = kinematics.angles_off_the_pole(
            [*row[variables:]], gamma, self.scene.psi, leaving, self.number.bits
        )
        return [*(exactly(x) for x in row), psi, phi]

"""One integration under way: the equations that the scene needs, marched from time to time."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from typing import Any, NamedTuple

from polhode.common.errors import BadInput
from polhode.equations import equilibrium, kinematics
from polhode.equations.form import Form, equations
from polhode.equations.readout import Readout
from polhode.equations.system import System, system
from polhode.numbers import exact, number_types
from polhode.numbers.convert import exactly, number_value
from polhode.numbers.number_types import NumberType
from polhode.numbers.scalars import Functions
from polhode.scenes.scene import Scene
from polhode.scenes.words import ANGLE_VARIABLES
from polhode.taylor import policy
from polhode.taylor.outcomes import EventTimes, Outcome, Projection

#: Called now and then with the fraction of the time done and the steps taken.
Progress = Callable[[float, int], None]

#: Where a start at a pole is left, in the scene's own unit of time: a fraction of a radian on.
_OFF_THE_POLE = Fraction(1, 2)

_EXACTLY = Functions(exact.ZERO, exact.sin, exact.cos, exact.sqrt)


class Leg(NamedTuple):
    """One integrator's part of a run: its system, when that began, and its chunks' beginnings."""

    system: System
    origin: Fraction
    marks: list[Any]
    projected: bool


class Run:
    """One run of a scene in one number type; rows of its form's variables come out."""

    def __init__(
        self,
        scene: Scene,
        number: NumberType,
        tolerance: Fraction | None = None,
        max_steps: int | None = None,
        inputs: NumberType | None = None,
        project: int | None = None,
    ) -> None:
        self.scene, self.number, self.tolerance = scene, number, tolerance
        self.max_steps, self.inputs = max_steps, inputs
        self.steps = 0
        self.reached = Fraction(0)
        self.build_seconds = self.seconds = 0.0
        self.events: tuple[EventTimes, ...] = ()
        self.legs: list[Leg] = []
        self.projection: Projection | None = None
        self._every = project
        self._watch: Any = None

    def afresh(self) -> Run:
        """The same run before its start."""
        return Run(
            self.scene, self.number, self.tolerance, self.max_steps, self.inputs, self._every
        )

    def start(self) -> list[Any]:
        """The start of the variables, in the run's own unit, rounded to its type."""
        exact = self._rounded(system(self.scene, ())).start
        return [number_value(x, self.number) for x in exact]

    def again(self, leg: Leg) -> Any:
        """An integrator that takes a leg's steps again, without looking for events."""
        if self.scene.events:
            from polhode.taylor.events import Watch

            self._watch = Watch(self.scene, self.number, self.tolerance, self._still)
            self._watch.muted = True
        projector = self._projector(leg.system.form) if leg.projected else None
        return self.integrator(leg.system, leg.origin, self._watch, projector)

    def to(self, times: list[Fraction], progress: Progress | None) -> tuple[Outcome, list[Any]]:
        """Rows at the times, as far as they were reached, and the outcome."""
        from polhode.taylor import heyoka_numbers

        began = time.perf_counter()
        try:
            if self.scene.events:
                from polhode.taylor.events import Watch

                self._watch = Watch(self.scene, self.number, self.tolerance, self._still)
            outcome, rows = self._to(times, progress)
        except heyoka_numbers.OutOfRange as fault:
            expected = f"a type of wider range ({fault})"
            raise BadInput(self.scene.name, "number", self.number.name, expected) from None
        if self._watch is not None:
            self.events = self._watch.found()
        self.seconds = time.perf_counter() - began
        return outcome, rows

    def _to(self, times: list[Fraction], progress: Progress | None) -> tuple[Outcome, list[Any]]:
        unit = Fraction(2) ** self.scene.time_unit
        inside = times if unit == 1 else [t / unit for t in times]
        if self._still:
            return self._stand_still(times, inside, progress)
        rows: list[Any] = []
        began = time.perf_counter()
        whole = self._rounded(system(self.scene, self.scene.modelled))
        if inside[0] == 0:
            rows.append([number_value(x, self.number) for x in whole.start])
        self.build_seconds += time.perf_counter() - began
        if len(rows) == len(inside):
            return Outcome.REACHED_END, rows
        if self._singular_at_start():
            return Outcome.SINGULAR, rows
        origin = Fraction(0)
        if "angles" in self.scene.outputs and self.scene.starts_at_pole:
            whole, origin = self._off_the_pole(whole, inside[len(rows)])
        outcome = self._advanced(whole, origin, inside, rows, progress)
        if self._stopped:
            rows = [row for row, t in zip(rows, times, strict=False) if abs(t) <= abs(self.reached)]
        return outcome, rows

    def _advanced(
        self,
        whole: System,
        origin: Fraction,
        inside: list[Fraction],
        rows: list[Any],
        progress: Progress | None,
    ) -> Outcome:
        """Integrate a system that stands at time ``origin``, appending rows; the outcome."""

        unit = Fraction(2) ** self.scene.time_unit
        outcome = Outcome.STOPPED_AT_EVENT
        if not self._stopped:
            projector = self._projector(whole.form)
            integrator = self.integrator(whole, origin, self._watch, projector)
            self._refuse_what_never_moves()
            limit = (
                self.max_steps if self.max_steps is not None else policy.of(self.number).max_steps
            )
            chunk = policy.of(self.number).chunk
            outcome = _march(integrator, inside, rows, limit, chunk, progress)
            if projector is not None:
                self.projection = projector.found()
                self.build_seconds += projector.seconds
            self.steps += integrator.steps
            # the end itself, not its rounding relative to where the last chunk began
            done = outcome is Outcome.REACHED_END
            self.reached = (inside[-1] if done else integrator.time) * unit
            if self._watch is None and outcome.done:  # events are told by their integrator
                integrator.release()
        if self._stopped:
            self.reached = self.number.rounded(self._watch.stop) * unit
        return outcome

    @cached_property
    def _still(self) -> bool:
        """Whether the state need not be integrated: it is that of a relative equilibrium."""
        principal_form = self.scene.form == "principal" and self.inputs is None
        return principal_form and equilibrium.stands_still(self.scene)

    def _stand_still(
        self, times: list[Fraction], inside: list[Fraction], progress: Progress | None
    ) -> tuple[Outcome, list[Any]]:
        """Rows of a state that never changes; only its events, those of t, need an integrator."""
        rows = [
            [number_value(x, self.number) for x in equilibrium.variables(self.scene, t)]
            for t in times
        ]
        outcome, self.reached = Outcome.REACHED_END, times[-1]
        if self._watch is None or self.reached == 0:
            return outcome, rows
        passed = rows[: inside[0] == 0]
        whole = replace(system(self.scene, ()), still=True)
        outcome = self._advanced(whole, Fraction(0), inside, passed, progress)
        return outcome, [
            row
            for row, t in zip(rows[: len(passed)], times, strict=False)
            if abs(t) <= abs(self.reached)
        ]

    def _singular_at_start(self) -> bool:
        """Whether the start is too near to the singular set of the form."""
        from polhode.taylor.integrator import nearest

        form = equations(self.scene)
        away = form.distance(form.start, form.coefficients, _EXACTLY)
        return away is not None and bool(away <= nearest(self.number))

    def _projector(self, form: Form) -> Any:
        """What corrects the state now and then; None where nothing does."""
        if form.unit is not None:
            from polhode.taylor.unit_norm import UnitNorm

            return UnitNorm(form.unit, self.number)
        if self._every is None or self._still:
            return None
        from polhode.taylor.projection import Projector

        return Projector(self.scene, self.number, self._every)

    @property
    def _stopped(self) -> bool:
        return self._watch is not None and self._watch.stop is not None

    def _refuse_what_never_moves(self) -> None:
        """Refuse an event that is zero all along the motion: in this type, and to 200 digits."""
        suspects = self._watch.still() if self._watch is not None else []
        if not suspects:
            return
        from polhode.taylor.events import Watch

        fine = Run(self.scene, number_types.mp(200))
        watch = Watch(self.scene, fine.number, None)
        fine.integrator(system(self.scene, ()), watch=watch)
        for k in watch.still():
            if k in suspects:
                event = self.scene.events[k]
                key, text = f"events[{k + 1}].zero", event.expression or event.name
                expected = "an expression that is not zero all along the motion"
                raise BadInput(self.scene.name, key, text, expected)

    def integrator(
        self,
        what: System,
        origin: Fraction = Fraction(0),
        watch: Any = None,
        projector: Any = None,
    ) -> Any:
        """A heyoka integrator of a system that stands at time ``origin``."""
        from polhode.taylor import heyoka_numbers
        from polhode.taylor import integrator as taylor

        began = time.perf_counter()
        built = taylor.Taylor(
            what.names,
            lambda state, k: what.field(state, k, heyoka_numbers.EXPRESSIONS),
            what.coefficients,
            what.start,
            self.number,
            self.tolerance,
            origin,
            watch,
            lambda state, k: what.form.distance(
                state[: len(what.form.variables)], k, heyoka_numbers.EXPRESSIONS
            ),
            projector,
            (what.outputs, what.still) if self.scene.form == "principal" else None,
            len(ANGLE_VARIABLES) if "angles" in what.outputs else 0,
        )
        self.build_seconds += time.perf_counter() - began
        self.legs.append(Leg(what, origin, built.marks, projector is not None))
        return built

    def _rounded(self, what: System) -> System:
        """The system with its inputs rounded to a narrower type, where that was asked for."""
        if self.inputs is None:
            return what
        return System(
            what.form,
            what.names,
            what.outputs,
            {name: self.inputs.rounded(x) for name, x in what.coefficients.items()},
            tuple(self.inputs.rounded(x) for x in what.start),
        )

    def _off_the_pole(self, whole: System, first: Fraction) -> tuple[System, Fraction]:
        """The system a moment after a start at a pole, where psi' is 0/0, and that moment.

        The attitude leads over the pole; psi and phi then begin at their one-sided limits, the one
        of psi ± phi that has a meaning at the pole staying continuous.  A motion that stays at
        the pole has no psi and phi at all.
        """
        moment = max(-_OFF_THE_POLE, min(_OFF_THE_POLE, first / 2))
        bridge = self._rounded(system(self.scene, ("attitude",)))
        leading = self.integrator(bridge, watch=self._watch)
        self._refuse_what_never_moves()
        found, _ = leading.chunk([moment], 10**6)
        self.steps += leading.steps
        if self._stopped:
            return whole, moment
        row = found[0]
        gamma = Readout(self.scene, self.number).states([row])[0][3:]
        if all(x == 0 for x in gamma[:2]):
            outputs = tuple(name for name in whole.outputs if name != "angles")
            start = whole.start[:-2]
            return System(whole.form, whole.names[:-2], outputs, whole.coefficients, start), (
                Fraction(0)
            )
        variables = len(whole.form.variables)
        kept = row if "attitude" in whole.outputs else row[:variables]
        psi, phi = kinematics.angles_off_the_pole(
            row[variables:], gamma, self.scene.psi, self.number.bits
        )
        start = (*(exactly(x) for x in kept), psi, phi)
        names, k = whole.names, whole.coefficients
        return System(whole.form, names, whole.outputs, k, start), moment


def _march(
    integrator: Any,
    times: list[Fraction],
    rows: list[Any],
    limit: int,
    chunk: int,
    progress: Progress | None,
) -> Outcome:
    """Advance chunk by chunk, appending a row for each time reached; the outcome."""
    from polhode.taylor import integrator as taylor

    end = times[-1]
    try:
        while len(rows) < len(times):
            steps = min(chunk, limit - integrator.steps)
            if steps <= 0:
                return Outcome.STEP_LIMIT
            before = integrator.time
            found, ended = integrator.chunk(times[len(rows) :], steps)
            if not taylor.finite(ended):
                return Outcome.NON_FINITE
            rows.extend(found)
            if taylor.at_singular_set(ended):
                return Outcome.SINGULAR
            if integrator.stopped:
                return Outcome.STOPPED_AT_EVENT
            if taylor.at_end(ended):
                break
            passed = abs(integrator.time - before)
            if passed <= steps * abs(integrator.time) * integrator.number.eps:
                return Outcome.STEP_UNDERFLOW
            ahead = abs(end - integrator.time) / passed * steps
            if integrator.steps + ahead > 10 * limit:  # hopeless: no need to try the limit out
                return Outcome.STEP_LIMIT
            if progress is not None:
                progress(float(integrator.time / end), integrator.steps)
    except KeyboardInterrupt:
        return Outcome.INTERRUPTED
    return Outcome.REACHED_END

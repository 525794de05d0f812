"""One integration under way: the equations that the scene needs, marched from time to time."""

from __future__ import annotations

import time
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

from polhode.common.errors import BadInput
from polhode.equations import equilibrium, kinematics
from polhode.equations.form import Form, equations
from polhode.equations.readout import Readout
from polhode.equations.system import System, system
from polhode.numbers import number_types
from polhode.numbers.convert import exactly, number_value
from polhode.numbers.number_types import NumberType
from polhode.numbers.scalars import EXACT, Row, Value
from polhode.runs.march import Progress, march
from polhode.scenes.scene import Scene
from polhode.taylor import policy
from polhode.taylor.outcomes import EventTimes, Outcome, Projection
from polhode.taylor.protocols import Corrector, Integrating, Mark, Watcher

if TYPE_CHECKING:
    from polhode.taylor.events import Watch

#: Where a start at a pole is left, in the scene's own unit of time: a fraction of a radian on.
_OFF_THE_POLE = Fraction(1, 2)


class Leg(NamedTuple):
    """One integrator's part of a run: its system, when that began, and its chunks' beginnings."""

    system: System
    origin: Fraction
    marks: list[Mark]
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
        self._watch: Watcher | None = None

    def afresh(self) -> Run:
        """The same run before its start."""
        return Run(
            self.scene, self.number, self.tolerance, self.max_steps, self.inputs, self._every
        )

    def start(self) -> list[Value]:
        """The start of the variables, in the run's own unit, rounded to its type."""
        start = self._rounded(system(self.scene, ())).start
        return [number_value(x, self.number) for x in start]

    def again(self, leg: Leg) -> Integrating:
        """An integrator that takes a leg's steps again, without looking for events."""
        watch = self._new_watch()
        if watch is not None:
            watch.muted = True
        corrector = self._corrector(leg.system.form, watch) if leg.projected else None
        return self._built(leg.system, leg.origin, watch, corrector)

    def to(self, times: list[Fraction], progress: Progress | None) -> tuple[Outcome, list[Row]]:
        """Rows at the times, as far as they were reached, and the outcome."""
        from polhode.taylor import heyoka_numbers

        began = time.perf_counter()
        try:
            watch = self._watch = self._new_watch()
            outcome, rows = self._to(times, progress)
        except heyoka_numbers.OutOfRange as fault:
            expected = f"a type of wider range ({fault})"
            raise BadInput(self.scene.name, "number", self.number.name, expected) from None
        if watch is not None:
            self.events = watch.found()
        self.seconds = time.perf_counter() - began
        return outcome, rows

    def _to(self, times: list[Fraction], progress: Progress | None) -> tuple[Outcome, list[Row]]:
        unit = Fraction(2) ** self.scene.time_unit
        inside = times if unit == 1 else [t / unit for t in times]
        if self._still:
            return self._stand_still(times, inside, progress)
        rows: list[Row] = []
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
        rows: list[Row],
        progress: Progress | None,
    ) -> Outcome:
        """Integrate a system that stands at time ``origin``, appending rows; the outcome."""

        unit = Fraction(2) ** self.scene.time_unit
        outcome = Outcome.STOPPED_AT_EVENT
        if not self._stopped:
            corrector = self._corrector(whole.form, self._watch)
            integrator = self._built(whole, origin, self._watch, corrector)
            self._refuse_what_never_moves()
            limit = (
                self.max_steps if self.max_steps is not None else policy.of(self.number).max_steps
            )
            chunk = policy.of(self.number).chunk
            outcome = march(integrator, inside, rows, limit, chunk, progress)
            if corrector is not None:
                self.projection = corrector.found()
                self.build_seconds += corrector.seconds
            self.steps += integrator.steps
            # the end itself, not its rounding relative to where the last chunk began
            done = outcome is Outcome.REACHED_END
            self.reached = (inside[-1] if done else integrator.time) * unit
            if self._watch is None and outcome.done:  # events are told by their integrator
                integrator.release()
        if self._watch is not None and self._watch.stop is not None:
            self.reached = self.number.rounded(self._watch.stop) * unit
        return outcome

    @cached_property
    def _still(self) -> bool:
        """Whether the state need not be integrated: it is that of a relative equilibrium."""
        principal_form = self.scene.form == "principal" and self.inputs is None
        return principal_form and equilibrium.at_rest(self.scene).state

    def _stand_still(
        self, times: list[Fraction], inside: list[Fraction], progress: Progress | None
    ) -> tuple[Outcome, list[Row]]:
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
        from polhode.taylor.singular_set import nearest

        form = equations(self.scene)
        away = form.distance(form.start, form.coefficients, EXACT)
        return away is not None and bool(away <= nearest(self.number))

    def _corrector(self, form: Form, watch: Watcher | None) -> Corrector | None:
        """What corrects the state now and then; None where nothing does."""
        if form.unit is not None:
            from polhode.taylor.unit_norm import UnitNorm

            return UnitNorm(form.unit, self.number)
        if self._every is None or self._still:
            return None
        from polhode.taylor.projection import Projector

        return Projector(self.scene, self.number, self._every, watch)

    def _new_watch(self) -> Watch | None:
        """What looks for the scene's events; None for a scene without any."""
        if not self.scene.events:
            return None
        from polhode.taylor.events import Watch

        return Watch(self.scene, self.number, self.tolerance, self._still)

    @property
    def _stopped(self) -> bool:
        return self._watch is not None and self._watch.stop is not None

    def _refuse_what_never_moves(self) -> None:
        """Refuse an event that is zero all along the motion: in this type, and to 200 digits."""
        suspects = self._watch.still() if self._watch is not None else []
        if not suspects:
            return
        from polhode.taylor.build import build
        from polhode.taylor.events import Watch

        fine = number_types.mp(200)
        watch = Watch(self.scene, fine, None)
        build(system(self.scene, ()), fine, watcher=watch)
        for k in watch.still():
            if k in suspects:
                event = self.scene.events[k]
                key, text = f"events[{k + 1}].zero", event.expression or event.name
                expected = "an expression that is not zero all along the motion"
                raise BadInput(self.scene.name, key, text, expected)

    def _built(
        self,
        what: System,
        origin: Fraction,
        watch: Watcher | None,
        corrector: Corrector | None,
    ) -> Integrating:
        """The integrator of a leg of the run."""
        from polhode.taylor.build import build

        began = time.perf_counter()
        built = build(what, self.number, self.tolerance, origin, watch, corrector)
        self.build_seconds += time.perf_counter() - began
        self.legs.append(Leg(what, origin, built.marks, corrector is not None))
        return built

    def _rounded(self, what: System) -> System:
        """The system with its inputs rounded to a narrower type, where that was asked for."""
        return what if self.inputs is None else what.rounded(self.inputs)

    def _off_the_pole(self, whole: System, first: Fraction) -> tuple[System, Fraction]:
        """The system a moment after a start at a pole, where psi' is 0/0, and that moment.

        The attitude leads over the pole; psi and phi then begin at their one-sided limits, the one
        of psi ± phi that has a meaning at the pole staying continuous.  A motion that stays at
        the pole has no psi and phi at all.
        """
        moment = max(-_OFF_THE_POLE, min(_OFF_THE_POLE, first / 2))
        bridge = self._rounded(system(self.scene, ("attitude",)))
        leading = self._built(bridge, Fraction(0), self._watch, None)
        self._refuse_what_never_moves()
        found, _ = leading.chunk([moment], 10**6)
        self.steps += leading.steps
        if self._stopped:
            return whole, moment
        row = found[0]
        gamma = Readout(self.scene, self.number).states([row])[0][3:]
        if all(x == 0 for x in gamma[:2]):
            outputs = tuple(name for name in whole.outputs if name != "angles")
            names, start = whole.names[:-2], whole.start[:-2]
            return replace(whole, names=names, outputs=outputs, start=start), Fraction(0)
        variables = len(whole.form.variables)
        kept = row if "attitude" in whole.outputs else row[:variables]
        psi, phi = kinematics.angles_off_the_pole(
            row[variables:], gamma, self.scene.psi, self.number.bits
        )
        return replace(whole, start=(*(exactly(x) for x in kept), psi, phi)), moment

"""A motion on its way by Taylor steps."""

from __future__ import annotations

import time
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any, NamedTuple

from polhode.common.errors import BadInput
from polhode.common.interrupts import Progress
from polhode.common.values import Recent, cached_property
from polhode.equations import kinematics, readout
from polhode.equations.form import Form
from polhode.equations.kinematics import phi_leaving_the_pole
from polhode.motion.outcomes import EventTimes, Outcome, Projection
from polhode.numbers.conversion import exactly, number_value, to_extended
from polhode.numbers.exact import ZERO
from polhode.numbers.expression import ExpressionError
from polhode.numbers.number_types import Flat, NumberType, Row, Rows, flat, of_extended, of_mpmath
from polhode.runs.options import USUAL, Options, cadence, refuse_other_rounding
from polhode.scenes.scene import Scene
from polhode.taylor import defaults
from polhode.taylor.time_grid import Times
from polhode.taylor.types import Corrector

if TYPE_CHECKING:
    from polhode.taylor.event_watch import Rules, Watch
    from polhode.taylor.stepping import Anchor, Integrator
    from polhode.taylor.system import System


#: Where a start at a pole is left, inside the run's frame: a fraction of a radian on.
_OFF_THE_POLE = Fraction(1, 2)
_PART = 800  # of the steps that take a fifth of a second: a quarter of a millisecond for a row
_systems: Recent[System] = Recent(16)
_rules: Recent[Rules] = Recent(1)


class Leg(NamedTuple):
    """One integrator's part of a motion: its system, and its anchors."""

    system: System
    anchors: list[Anchor]


class TaylorMotion:
    """A motion on its way by Taylor steps in one number type.

    ``scene``: the system's own, with the times of this run.  What its outputs need is integrated
    with the state, and its events are looked for as steps are taken.  ``steps``: those taken.
    ``reached``: the exact time come to, in the scene's unit.  ``build_seconds``: the time that
    compiling took.  ``remarks``: for the provenance.
    """

    method = "taylor"
    errors: tuple[float | None, ...] | None = None
    remarks: Mapping[str, str] = {}

    def __init__(self, system: System, scene: Scene, options: Options = USUAL) -> None:
        self.system, self.number, self.scene = system, system.number, scene
        self.options, self.read = options, system.read
        self.steps = 0
        self.reached = ZERO
        self.build_seconds = 0.0
        self.events: tuple[EventTimes, ...] = ()
        self.projection: Projection | None = None
        self.outcome = Outcome.NOT_RUN
        self._watch: Watch | None = None
        self._working: Integrator | None = None
        self._legs: list[Leg] = []
        self._anchored = 0  # steps between two anchors, where any are kept

    def __getstate__(self) -> dict[str, object]:
        """What ``at`` needs."""
        kept = "system", "scene", "options", "reached"
        return {name: getattr(self, name) for name in kept}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__init__(state["system"], state["scene"], state["options"])  # type: ignore[misc]
        self.reached = state["reached"]

    def at(self, times: Sequence[Fraction]) -> tuple[Sequence[Row], Outcome, Fraction]:
        """Rows at exact times in the scene's unit up to ``reached``, in the order of the motion.

        As many as are reached; how the motion ended, and when.  Each is integrated from the anchor
        before it, by the steps of the run, of which only the last is shorter: as accurate as the
        run's own.
        """
        first = self.system.first
        if self.system.rests:
            return [*self._rows_at_rest(times)], Outcome.REACHED_END, self.reached
        if not any(times):
            return [first[0] for _ in times], Outcome.REACHED_END, self.reached
        rows: list[Row] = []
        path = self._with_anchors
        for t in times:
            inside = self.system.frame.time(t)
            if abs(t) > abs(path.reached):
                break
            if not t:
                rows.append(first[0])
                continue
            leg, anchor = path._anchor(inside)
            integrator = path._integrator(leg.system, ZERO, None, anchored=0)
            row, nearest = integrator.at(anchor, inside)
            integrator.release()
            row = row if inside == nearest else _moved(row, inside - nearest, leg.system)
            if "angles" in self.scene.modelled and leg is not path._legs[-1]:
                numbers = [number_value(x, self.number) for x in self._off_pole(row, inside)]
                row = self.system.rows([numbers])[0]
            rows.append(row)
        return rows, path.outcome, path.reached

    def _anchor(self, t: Fraction) -> tuple[Leg, Anchor]:
        """The last anchor before a time inside the frame, and its leg."""
        anchors, begun = self._anchors
        return anchors[bisect_right(begun, abs(t)) - 1]

    @cached_property
    def _anchors(self) -> tuple[list[tuple[Leg, Anchor]], list[Fraction]]:
        """All anchors of a motion that is over, and |t| of each."""
        anchors = [(leg, anchor) for leg in self._legs for anchor in leg.anchors]
        return anchors, [abs(anchor.time) for _, anchor in anchors]

    @cached_property
    def _with_anchors(self) -> TaylorMotion:
        """The same steps once more, with anchors; events are there, and nobody looks for them."""
        again = TaylorMotion(self.system, self.scene, self.options)
        again._anchored = max(1, defaults.of(self.number).chunk // _PART)
        again._watch = self._new_watch()
        if again._watch is not None:
            again._watch.muted = True
        end = Times([self.system.frame.time(self.reached)], self.number)
        _, again.outcome = again._move(end, None)
        if again.outcome is Outcome.INTERRUPTED:
            raise KeyboardInterrupt
        again._release(again.outcome)
        return again

    def advance(self, times: Times, progress: Progress | None = None) -> tuple[Rows, Outcome]:
        """Rows at the times, inside the frame, as far as they were reached; the outcome."""
        from polhode.taylor.heyoka import OutOfRange

        try:
            watch = self._watch = self._new_watch() if self.scene.events else None
            rows, outcome = (self._rest if self.system.rests else self._move)(times, progress)
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

    def _move(self, times: Times, progress: Progress | None) -> tuple[Rows, Outcome]:
        """Rows of a state that moves."""
        began = time.perf_counter()
        what, origin, rows = self.system, ZERO, self.system.first[: times[0] == 0]
        self.build_seconds += time.perf_counter() - began
        if len(rows) == len(times):
            return rows, Outcome.REACHED_END
        if what.singular:
            return rows, Outcome.SINGULAR
        if "angles" in self.scene.modelled and self.scene.starts_at_pole:
            what, origin = self._off_the_pole(what)
            if not isinstance(rows, list):  # a motion that stays at the pole has no angles
                rows = rows[:, : len(what.start)]
        rows, outcome = self._integrate(what, origin, times, rows, progress)
        if self._watch is not None:
            rows = rows[: self._before_stop(times, len(rows))]
        return rows, outcome

    def _before_stop(self, times: Sequence[Fraction], count: int) -> int:
        """How many of the first times are not beyond an event that ended the run."""
        if not self._stopped:
            return count
        reached = self.system.frame.time(self.reached)
        return bisect_right(times, abs(reached), hi=count, key=abs)

    def _integrate(
        self,
        what: System,
        origin: Fraction,
        times: Times,
        rows: Rows,
        progress: Progress | None,
    ) -> tuple[Rows, Outcome]:
        """Integrate a system that stands at time ``origin``; ``rows`` and those to come."""
        frame = self.system.frame
        watch, outcome = self._watch, Outcome.STOPPED_AT_EVENT
        if watch is None or watch.stop is None:
            corrector = self._corrector(what.form, watch)
            integrator = self._integrator(what, origin, corrector, self._anchored)
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
            last = times[-1] if done else integrator.time
            self.reached = frame.time_outside(last)
            if watch is not None:
                self._working = integrator  # its events are told first
            elif outcome.done or outcome is Outcome.SINGULAR:
                integrator.release()
        if watch is not None and watch.stop is not None:
            self.reached = frame.time_outside(self.number.rounded(watch.stop))
        return rows, outcome

    def _rest(self, times: Times, progress: Progress | None) -> tuple[Rows, Outcome]:
        """Rows of a state that never changes; only its events, those of t, need an integrator."""
        outside = [*map(self.system.frame.time_outside, times)]
        rows = self._rows_at_rest(outside)
        outcome, self.reached = Outcome.REACHED_END, outside[-1]
        if self._watch is None or self.reached == 0:
            return rows, outcome
        what = replace(self._with_outputs(()), still=True)
        passed = what.rows([row[: len(what.start)] for row in rows[: times[0] == 0]])
        watched, outcome = self._integrate(what, ZERO, times, passed, progress)
        return rows[: self._before_stop(times, len(watched))], outcome

    def _with_outputs(self, outputs: tuple[str, ...]) -> System:
        """The system with these outputs alone."""
        from polhode.taylor.system import system

        of = self.system
        return system(of.scene, outputs, of.number, of.tolerance, of.inputs)

    def _rows_at_rest(self, times: Sequence[Fraction]) -> Rows:
        """Rows of a state that never changes, at times in the scene's unit."""
        exact = (readout.variables(self.scene, t) for t in times)
        return self.system.rows([[number_value(x, self.number) for x in row] for row in exact])

    def _corrector(self, form: Form, watch: Watch | None) -> Corrector | None:
        """What corrects the state now and then; None where nothing does."""
        if form.unit is not None:
            from polhode.taylor.projection import UnitNorm

            return UnitNorm(form.unit, self.number)
        system = self.system
        every = cadence(self.scene, self.number, system.tolerance, self.options.project)
        if every is None or system.inputs is not None or system.rests:
            return None
        from polhode.taylor.projection import Projector

        return Projector(system.target, every, watch)

    def _new_watch(self) -> Watch | None:
        """What looks for the scene's events; None where they are not watched."""
        if not self.scene.events:
            return None
        from polhode.taylor.event_watch import Rules, Watch

        of, scene = self.system, self.scene

        def rules_of_events() -> Rules:
            return Rules(scene, of.number, of.tolerance, of.rests)

        timed = any(event.timed for event in scene.events)  # t in one is as large as the end
        rules = _rules.get(of, of.times(scene).outside[-1] if timed else None, rules_of_events)
        return Watch(scene, self.number, rules)

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

    def _integrator(
        self, what: System, origin: Fraction, corrector: Corrector | None, anchored: int
    ) -> Integrator:
        """The integrator of the next leg, at the start of its system."""
        from polhode.taylor.stepping import Integrator

        began = time.perf_counter()
        integrator = Integrator(what, origin, self._watch, corrector, anchored=anchored)
        if anchored:
            self._legs.append(Leg(what, integrator.anchors))
        self.build_seconds += time.perf_counter() - began
        return integrator

    def _off_the_pole(self, what: System) -> tuple[System, Fraction]:
        """The system a moment after a start at a pole, where psi' is 0/0, and that moment.

        The attitude leads over the pole, to before the first output.  A motion that stays at the
        pole has no psi and phi at all.
        """
        first = next(t for t in self.system.times(self.scene) if t)
        moment = max(-_OFF_THE_POLE, min(_OFF_THE_POLE, first / 2))
        bridge = self._with_outputs(("attitude",))
        leading = self._integrator(bridge, ZERO, None, self._anchored)
        if self._watch is not None:
            self._refuse_what_never_moves(self._watch)
        rows, outcome = leading.chunk([moment], 10**6)
        self.steps += leading.steps
        if self._watch is None and outcome.done:
            leading.release()
        if self._stopped:
            return what, moment
        gamma = self.read.states(rows)[0][3:]
        if all(x == 0 for x in gamma[:2]):
            self._legs.clear()
            outputs = tuple(name for name in what.outputs if name != "angles")
            names, start = what.names[:-2], what.start[:-2]
            return replace(what, names=names, outputs=outputs, start=start), ZERO
        return replace(what, start=tuple(self._off_pole(rows[0], moment))), moment

    def _off_pole(self, row: Row, t: Fraction) -> list[Fraction]:
        """A row of the state and the attitude soon after a pole, as one with psi and phi.

        Those begin at their one-sided limits, the one of psi ± phi that has a meaning at the pole
        staying continuous.
        """
        variables = len(self.system.form.variables)
        leaving = phi_leaving_the_pole(self.scene, 1 if t > 0 else -1)
        gamma = self.read.states([row])[0][3:]
        psi, phi = kinematics.angles_off_the_pole(
            [*row[variables:]], gamma, self.scene.psi, leaving, self.number.bits
        )
        return [*(exactly(x) for x in row), psi, phi]


def system_of(
    scene: Scene,
    number: NumberType,
    tolerance: Fraction | None = None,
    inputs: NumberType | None = None,
) -> System:
    """The system of such runs, shared by scenes that differ in their times alone."""
    refuse_other_rounding(scene)
    key = (number, tolerance, inputs)

    def new_system() -> System:
        from polhode.taylor.system import system

        return system(scene.apart(), scene.modelled, *key)

    return _systems.get(scene.identity, key, new_system)


def _moved(row: Row, by: Fraction, what: System) -> Row:
    """A row moved on by less than the last bit of its time."""
    if what.number.flat:
        import numpy as np

        known = {name: to_extended(x) for name, x in what.coefficients.items()}
        wide = flat(row).astype(np.longdouble)
        slopes = np.array(what.field([*wide], known, of_extended()), dtype=np.longdouble)
        moved: Flat = (wide + to_extended(by) * slopes).astype(flat(row).dtype)
        return moved
    from polhode.numbers.mpmath_context import mpmath, ordinary, own

    with mpmath.workprec(what.number.bits):
        k = {name: own(number_value(x, what.number)) for name, x in what.coefficients.items()}
        zero, step = (own(number_value(x, what.number)) for x in (Fraction(0), by))
        fn = of_mpmath()._replace(zero=zero)
        state = [own(x) for x in row]
        rates = what.field(state, k, fn)
        return [ordinary(x + step * rate) for x, rate in zip(state, rates, strict=True)]

"""A refined motion (:mod:`polhode.refined`): steps in double, corrected by exact arithmetic."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np

from polhode.common.interrupts import Progress
from polhode.equations import kinematics
from polhode.equations.readout import Readout
from polhode.motion.frame import Frame
from polhode.motion.outcomes import EventTimes, Outcome, Projection
from polhode.numbers.conversion import exactly, number_value, to_double, to_mpf
from polhode.numbers.exact import ZERO
from polhode.numbers.number_types import Doubles, NumberType, Real, Row, Rows, Scalar
from polhode.refined import refinement
from polhode.refined.attitude import Following, RefinedAttitude
from polhode.refined.compiled_field import CannotRefine, Stalled
from polhode.refined.refinement import MOST_DIGITS, Accuracy, RefinedStates, accuracy, refine
from polhode.runs.options import USUAL, Options
from polhode.scenes.scene import Scene
from polhode.taylor.system import System

_MORE_DIGITS, _OTHER_INTERVALS = 10, 5  # of a second run, which tells the error of the first
_PARTED = 1e-2  # so far apart two runs say nothing of each other
_GUARD = 16  # bits for what is read from states
_TRIES = 3  # with more digits each, until the estimate holds those asked for


class RefinedMotion:
    """A motion on its way by refinement, in the principal form.

    What the scene wants beside the state is refined with it; it has no events.  ``errors``: largest
    error over the columns of each state, absolute, its rounding to the number type included; None
    where the motion multiplies errors too much for an estimate.
    """

    method = "refined"
    projection: Projection | None = None

    def __init__(self, system: System, scene: Scene, options: Options = USUAL) -> None:
        plain = scene if scene.form == "principal" else replace(scene, form="principal")
        self.scene, self.number = plain, system.number
        self.options = options
        self.read = Readout(plain, system.number)
        self.steps, self.reached, self.build_seconds = 0, ZERO, 0.0
        self.events: tuple[EventTimes, ...] = ()
        self.errors: tuple[float | None, ...] | None = None
        self.remarks: Mapping[str, str] = {}
        if plain is not scene:
            self.remarks = {"refined in": "principal axes, the same states"}
        self._accuracy: Accuracy

    def run(
        self, times: Sequence[Fraction], progress: Progress | None = None
    ) -> tuple[Rows, Outcome]:
        """Rows at the times: the form's variables as rationals, then numbers of the run's type.

        With more digits until the estimate holds those wanted, where it can.  Raises CannotRefine.
        """
        scene, number, times = self.scene, self.number, [*times]
        goal, digits = max(34, int(number.most_digits)), self.options.digits
        for _ in range(_TRIES):
            try:
                refinement = self._refinement(times, goal, progress)
            except Stalled:  # near a separatrix
                goal += _MORE_DIGITS
                refinement = self._refinement(times, goal, progress)
            errors = refinement.estimate.errors
            if len(errors) and not refinement.stopped and not math.isfinite(errors.max()):
                errors = self._by_a_second_run(refinement, goal, progress)
            lacking = 0 if digits is None else _lacking(refinement, errors, digits)
            if not 0 < lacking <= MOST_DIGITS - goal or refinement.stopped:
                break
            goal += lacking
        outcome = refinement.stopped or Outcome.REACHED_END
        self._accuracy, self.steps = accuracy(goal), refinement.steps
        self.reached = self.read.frame.time_outside(refinement.reached)
        rows = [refinement.exactly(i) for i in range(len(refinement.states))]
        self.errors = _errors(self.read.frame, number, errors, rows)
        count = len(self.read.form.variables)
        quaternions: list[list[Real]] = [[]] * len(rows)
        if refinement.attitudes is not None:
            quaternions = _attitudes(scene, number, refinement.attitudes)
        whole: list[list[Scalar]] = [
            [*row[:count], *more] for row, more in zip(rows, quaternions, strict=True)
        ]
        return whole, outcome

    def at(self, times: Sequence[Fraction]) -> tuple[Sequence[Row], Outcome, Fraction]:
        """States at exact times in the scene's unit, refined once more.

        None of the attitude and the angles.  Raises CannotRefine.
        """
        again = refine(self.scene, [*map(self.read.frame.time, times)], self._accuracy)
        if again.stopped:
            raise KeyboardInterrupt
        width = self.read.columns
        rows: list[list[Scalar]] = [[*again.exactly(i)[:width]] for i in range(len(times))]
        return rows, Outcome.REACHED_END, self.reached

    def _refinement(
        self, times: Sequence[Fraction], goal: int, progress: Progress | None
    ) -> RefinedStates:
        """One refinement to so many digits, with a following of its own."""
        scene = self.scene
        following = None
        if scene.modelled:
            following = Following(scene, accuracy(goal).limbs.finest, "angles" in scene.modelled)
        return refine(
            scene,
            times,
            accuracy(goal),
            _OTHER_INTERVALS if self.options.other else refinement.STEPS_AN_INTERVAL,
            progress=progress,
            max_steps=self.options.max_steps,
            following=following,
        )

    def _by_a_second_run(
        self, first: RefinedStates, goal: int, progress: Progress | None
    ) -> Doubles:
        """Errors as the estimates are; where infinite, twice the distance from another run.

        That one has other intervals and so many more digits that the distance is the first run's
        error.  Still infinite from where on the two have parted, or the second did not come.
        """
        errors: Doubles = first.estimate.errors.copy()
        digits = goal + _MORE_DIGITS
        if digits > MOST_DIGITS:
            return errors
        most = self.options.max_steps
        steps = None if most is None else 2 * most
        wider = accuracy(digits)
        try:
            second = refine(
                self.scene, first.times, wider, _OTHER_INTERVALS, progress=progress, max_steps=steps
            )
        except CannotRefine:
            return errors
        for i in range(len(second.states)):
            pairs = zip(first.exactly(i), second.exactly(i), strict=True)
            apart = [abs(float(a - b)) for a, b in pairs]
            if max(apart) > _PARTED:
                break
            if not np.isfinite(errors[i]).all():
                errors[i] = 2 * max(apart[:3]), 2 * max(apart[3:])
        return errors


def _attitudes(
    scene: Scene, number: NumberType, attitudes: list[RefinedAttitude]
) -> list[list[Real]]:
    """Quaternion, psi and phi as a run's rows have them behind the state, what is asked of them.

    psi is the sum of the arguments of q0 + i q3 and q1 + i q2; phi only tells its branch.
    """
    from polhode.numbers.mpmath_context import mpmath, ordinary

    bits, rows = number.bits + _GUARD, []
    assert scene.gamma is not None  # else a scene has no outputs
    phi_0 = to_double(kinematics.starting_phi(scene.gamma))
    with mpmath.workprec(bits):
        psi_0 = to_mpf(scene.psi, bits)
        for quaternion, (sum_half, difference_half) in attitudes:
            row = [number_value(x, number) for x in quaternion]
            if "angles" in scene.modelled:
                q0, q1, q2, q3 = (to_mpf(x, bits) for x in quaternion)
                psi = mpmath.atan2(q3, q0) + mpmath.atan2(q2, q1)
                near, whole = psi_0 + sum_half + difference_half, 2 * mpmath.pi
                psi += whole * mpmath.nint((near - psi) / whole)
                phi = mpmath.mpf(phi_0 + sum_half - difference_half)
                row += [number_value(exactly(psi), number), ordinary(phi)]
            rows.append(row)
    return rows


def _lacking(first: RefinedStates, errors: Doubles, digits: int) -> int:
    """How many more digits the errors ask for; 0 where they are infinite: no more would help."""
    if not len(errors) or not math.isfinite(errors.max()):
        return 0
    fastest = max(abs(x) for row in first.states for x in row[:3]) / 2.0**first.bits
    worst = max(errors[:, 0].max() / (fastest or 1.0), errors[:, 1].max())
    return max(0, math.ceil(digits + math.log10(worst)))


def _errors(
    frame: Frame, number: NumberType, estimates: Doubles, rows: list[list[Fraction]]
) -> tuple[float | None, ...]:
    """The estimate of each row outside its frame, rounded to its type."""
    widening = 1.0 if frame.axes.trivial else math.sqrt(3.0)  # of a vector's largest component
    half_eps = float(number.eps) / 2
    errors: list[float | None] = []
    for row, (omega, gamma) in zip(rows, estimates.tolist(), strict=True):
        w, g = (float(max(map(abs, part))) for part in (row[:3], row[3:]))
        with np.errstate(over="ignore"):
            of_omega = float(np.ldexp(omega + half_eps * w, -frame.exponent))
        error = widening * max(of_omega, gamma + half_eps * g)
        errors.append(error if math.isfinite(error) else None)
    return tuple(errors)

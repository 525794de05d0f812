"""How many digits of a run are right: by the closed form, by a proof, or by a second run."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import NamedTuple

from polhode.common.errors import BadInput, few
from polhode.common.interrupts import Progress
from polhode.judging.correct_digits import worst_digits
from polhode.judging.reference import ProofTooLong, reference
from polhode.motion.outcomes import Outcome
from polhode.numbers.number_types import Given, wider
from polhode.runs.options import Options
from polhode.runs.trajectory import Trajectory, solve
from polhode.scenes.scene import Scene
from polhode.taylor import defaults

MOST_SECONDS = 600.0  # that a proof may take, about, where one is asked for
_UNASKED_SECONDS = 10.0  # and where none is
MOST_CHECKED = 20  # output times at which a run is checked
CLOSED_FORM, PROOF, SECOND_RUN = "closed form", "proof", "second run"
_SPARE = 2  # digits that are proven beyond those wanted


class _Judge(NamedTuple):
    """True states, by whom, and the digits to which they are known."""

    states: Given
    by: str
    known: float = math.inf


def checked(
    run: Trajectory, digits: int, proved: bool | None = None, progress: Progress | None = None
) -> Trajectory:
    """A run with ``correct_digits`` and ``checked_by``.

    ``digits``: those wanted.  ``proved``: whether a motion without closed form is to be enclosed; a
    second run tells the digits to which the two agree.
    """
    rows = few(len(run.times), MOST_CHECKED)
    times, states = [run.times[k] for k in rows], [run.states[k] for k in rows]
    scene = run.scene.at(tuple(times))
    judge = _closed_form(run, scene, times)
    if judge is None and proved is not False:
        judge = _proof(run, scene, times, digits, proved is True, progress)
        if judge is None and proved:
            return replace(run, correct_digits=0.0, checked_by=f"{PROOF}, which failed")
    if judge is None:
        second = _second(run, scene, progress)
        if second.outcome is Outcome.INTERRUPTED:
            return replace(run, outcome=Outcome.INTERRUPTED)
        if not second.outcome.done:
            return replace(run, correct_digits=0.0, checked_by=f"{SECOND_RUN}: {second.cause}")
        judge = _Judge(second.states, SECOND_RUN)
    right = worst_digits(states, judge.states, scene, cap=run.number.most_digits)
    if judge.known < math.inf:  # the true state is anywhere in its ball
        right = max(0.0, -math.log10(10.0**-right + 10.0**-judge.known))
    return replace(run, correct_digits=right, checked_by=judge.by)


def _closed_form(run: Trajectory, scene: Scene, times: Sequence[Fraction]) -> _Judge | None:
    against = reference(scene)
    if not against.is_closed_form:
        return None
    try:
        return _Judge(against.at(times, math.ceil(run.number.most_digits) + 6), CLOSED_FORM)
    except BadInput:  # digits that this closed form does not have
        return None


def _proof(
    run: Trajectory,
    scene: Scene,
    times: Sequence[Fraction],
    digits: int,
    demanded: bool,
    progress: Progress | None,
) -> _Judge | None:
    """Midpoints of proven balls; None where there are none, or the second run costs less."""
    if not (demanded or run.number.bits > 64):
        return None
    limit = MOST_SECONDS
    if not demanded:
        limit = min(_UNASKED_SECONDS, defaults.seconds(wider(run.number), run.steps))

    def forecast(seconds: float) -> None:
        if seconds > limit:
            raise ProofTooLong(scene.name, "digits", digits, f"a proof of {limit:.0f} s")

    plain = replace(scene, outputs=(), events=())
    proof = reference(plain, "certified", progress=progress, forecast=forecast)
    try:
        return _Judge(proof.at(times, digits + _SPARE), PROOF, proof.agreement)
    except BadInput:  # ProofTooLong is one
        return None


def _second(run: Trajectory, scene: Scene, progress: Progress | None) -> Trajectory:
    """The same motion otherwise: refined over other intervals to more digits, or by other steps."""
    plain = replace(scene, events=(), outputs=(), form="principal", reference="auto")
    longer = max(10 * run.steps, 1000)
    method = "auto" if run.method == "refined" or scene.events else "taylor"
    return solve(plain, wider(run.number), Options(method, longer, other=True), progress)

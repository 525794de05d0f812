"""Runs to the digits asked for: in a type wide enough, checked, repeated if they fall short."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Literal, Never, TypedDict, Unpack, overload

from polhode.common.arguments import refuse_unknown, whole, with_progress
from polhode.common.errors import BadInput
from polhode.common.interrupts import Progress
from polhode.motion.outcomes import Outcome
from polhode.numbers import number_types
from polhode.numbers.number_types import AnyNumber, Doubles, Extendeds, NumberType, Objects, wider
from polhode.runs.options import Options, checked_options, choose_number
from polhode.runs.trajectory import Trajectory, solve
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import REQUESTS
from polhode.taylor import defaults

MOST_SECONDS = 600.0  # by which the digits that a motion loses may make a run longer, about
MOST_RUNS = 4  # until the digits are reached
#: For a motion that leaves nothing to check.
EXPECTED = "expected error"


class _Options(TypedDict, total=False):
    """What a call gives beside scene, number type and digits, which decide the type of states."""

    at: Iterable[AnyNumber] | None
    tol: AnyNumber | None
    max_steps: int | None
    inputs: NumberType | None
    project: bool | int | None
    method: str
    prove: bool | None
    progress: Progress | bool | None


#: Keys of the scene that are looked for here, and what to say of them.
_OF_THE_SCENE = {
    "outputs": "a key of the scene (a run's angles_at and attitude_at need none)",
    "end": "times as at=[...], or a key of the scene",
}


@overload
def integrate(
    scene: Scene | str | Path,
    number: None = None,
    *,
    digits: None = None,
    **options: Unpack[_Options],
) -> Trajectory[Doubles]: ...
@overload
def integrate(
    scene: Scene | str | Path,
    number: Literal["double"],
    *,
    digits: int | None = None,
    **options: Unpack[_Options],
) -> Trajectory[Doubles]: ...
@overload
def integrate(
    scene: Scene | str | Path,
    number: Literal["extended"],
    *,
    digits: int | None = None,
    **options: Unpack[_Options],
) -> Trajectory[Extendeds]: ...
@overload
def integrate(
    scene: Scene | str | Path,
    number: Literal["quad", "mp"],
    *,
    digits: int | None = None,
    **options: Unpack[_Options],
) -> Trajectory[Objects]: ...
@overload
def integrate(
    scene: Scene | str | Path,
    number: str | NumberType | None = None,
    *,
    digits: int | None = None,
    **options: Unpack[_Options],
) -> Trajectory: ...
@with_progress
def integrate(
    scene: Scene | str | Path,
    number: str | NumberType | None = None,
    *,
    digits: int | None = None,
    at: Iterable[AnyNumber] | None = None,
    tol: AnyNumber | None = None,
    max_steps: int | None = None,
    inputs: NumberType | None = None,
    project: bool | int | None = None,
    method: str = "auto",
    prove: bool | None = None,
    progress: Progress | bool | None = None,
    **unknown: Never,
) -> Trajectory:
    """Integrate the Euler–Poisson equations of a scene with heyoka's Taylor method.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, a path, or the name of a case.
    number : str or NumberType, optional
        The number type, double (the default), extended, quad or mp (50 digits); or a NumberType.
    digits : int, optional
        The correct digits wanted at every time, which are checked.  The number type is chosen by
        how much this motion multiplies errors; the run is then checked, by the closed form, a proof
        or a second run, and repeated in a wider type if digits are missing.
    at : iterable of numbers, optional
        Output times in the scene's unit, instead of the scene's own.
    tol : number, optional
        The tolerance of a step (the type's eps by default).
    max_steps : int, optional
        A limit on the steps; a run that needs more ends there, and its outcome says so.
    inputs : NumberType, optional
        Round start and coefficients to this narrower type first, to see the effect of that rounding
        alone.
    project : bool or int, optional
        Project the state onto the exact scene's first integrals every so many steps, or never.
        True: as often as costs about a tenth of the run's time; False: never.  Left out, as True in
        double and extended at full tolerance, else never, and never in a form other than the
        principal one.
    method : {"auto", "taylor", "refined"}
        How to integrate, taylor (steps in the number type), refined (a run in double, corrected
        exactly, for quad and more digits) or auto (refined if that is possible and faster).
    prove : bool, optional
        Check ``digits`` by a proof, or by a second run, if no closed form is known.  True: by a
        proven enclosure.  False: by a second run, refined over other intervals or in a wider type,
        which is an estimate.  Left out: in quad and mp by a proof if that costs less than steps in
        the wider type, and at most some ten seconds; else by a second run.
    progress : callable or bool, optional
        Called from time to time with the fraction of the time done and the steps; True for a bar.
    **unknown
        No other argument is accepted; one is refused with the nearest known names.

    Returns
    -------
    Trajectory
        States, outputs and events in the scene's body axes and units.  It can be called at any time
        that it reached (:class:`polhode.Trajectory`).  ``method`` is the one
        that was used; ``correct_digits`` and ``checked_by`` are the result of the check of
        ``digits``.  Its outcome is TOO_FEW_DIGITS if they were not reached: because a number type
        or a tolerance was given too, or the motion multiplies errors beyond what can be computed.
        Ctrl-C ends the run within a second; it then holds the states that were reached.

    Raises
    ------
    BadInput
        A scene that cannot be integrated: key, value and what was expected.

    Notes
    -----
    The equations are (3.29) of Yehia, *Rigid Body Dynamics: A Lagrangian Approach*, in principal
    axes.

    Examples
    --------
    >>> import polhode
    >>> run = polhode.integrate("kovalevskaya/generic", digits=30, at=[1, "7/3"])
    >>> run
    <Trajectory of kovalevskaya/generic: quad, 2 times to t = 2.3333333333333333, reached end>
    >>> run.checked_by, 30 <= run.correct_digits < 35
    ('closed form', True)
    """
    if unknown:
        refuse_unknown("integrate", integrate, unknown, **_OF_THE_SCENE)
    assert not isinstance(progress, bool)  # it is a bar's
    scene = library.load(scene, takes=REQUESTS)
    if at is not None:
        scene = scene.at(at)
    if digits is not None:
        digits = whole(scene.name, "digits", digits, 1, number_types.MAX_DIGITS)
    elif prove is not None:
        raise BadInput(scene.name, "prove", prove, "digits given, for their check")
    request = Options(method, max_steps, project, None, inputs, digits)
    if digits is None:
        chosen = choose_number(scene, number, None)
        return solve(scene, chosen, checked_options(scene, chosen, request, tol), progress)
    from polhode.judging.digit_check import checked  # and with it all closed forms

    free = number in (None, "mp") and tol is None and inputs is None
    lost, most = needed(scene, digits) if free else (0.0, math.inf)
    if hopeless := lost > most:  # beyond what can be computed: the type of the digits alone
        chosen = number_types.for_digits(digits, 0.0)
    else:
        chosen = choose_number(scene, number, digits, lost)
    options = checked_options(scene, chosen, request, tol)
    for _ in range(MOST_RUNS):
        run = solve(scene, chosen, options, progress)
        if not (run.outcome.done and run.times):
            return run
        if hopeless:  # nothing is left to check: the fewest digits that it is expected to have
            run = replace(run, correct_digits=min(run.expected.digits), checked_by=EXPECTED)
        else:
            run = checked(run, digits, prove, progress)
        right = run.correct_digits or 0.0
        if right >= digits or run.outcome is Outcome.INTERRUPTED:
            return run
        lost = _missed(lost, chosen, right)
        if not free or lost > most:
            break
        number_type = choose_number(scene, number, digits, lost)
        chosen = number_type if number_type.bits > chosen.bits else wider(chosen)
    return replace(run, outcome=Outcome.TOO_FEW_DIGITS)


def needed(scene: Scene, digits: int) -> tuple[float, float]:
    """The digits that a motion is expected to lose, and the most that a run can make good.

    Beside ``digits`` of them: see :mod:`polhode.taylor.error_growth`.
    A motion that multiplies errors beyond what a double can follow is led by an integration of
    wider type.
    """
    from polhode.taylor.error_growth import LED_FROM, growth

    if not scene.times:
        return 0.0, math.inf  # refused by whoever integrates
    errors = growth(scene, trusted=math.inf)
    most = _affordable(errors.steps) - digits
    lost = max(errors.lost)
    if lost > LED_FROM and lost <= most:
        lost = max(growth(scene, limit=most + 1, led=True).lost)
    return lost, max(most, number_types.DEFAULT_MP_DIGITS)


def _affordable(steps: int) -> float:
    """The digits in which so many steps take MOST_SECONDS."""
    low, high = 1, 1 << 20  # bits
    while high - low > 8:
        middle = (low + high) // 2
        fits = defaults.seconds(NumberType("mp", middle), steps) <= MOST_SECONDS
        low, high = (middle, high) if fits else (low, middle)
    return NumberType("mp", low).most_digits


def _missed(lost: float, number: NumberType, right: float) -> float:
    """The digits lost, now that a run in this type has so many right."""
    if right >= 1:
        return max(lost, number.most_digits - right) + 1
    return 2 * max(lost, number.most_digits)

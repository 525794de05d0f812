"""A run of a scene by refinement (polhode.refined): when it can be, and how it is handed out."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING

from polhode.common.arguments import of_kind
from polhode.common.errors import BadInput, nearest
from polhode.common.progress import Progress
from polhode.equations import equilibrium, kinematics
from polhode.equations.form import equations
from polhode.equations.readout import Readout
from polhode.motion.outcomes import EventTimes, Outcome
from polhode.numbers.conversion import exactly, number_value, to_double, to_mpf
from polhode.numbers.number_types import LOG10_2, NumberType
from polhode.numbers.rows import Doubles, Row, Rows
from polhode.numbers.scalars import AnyNumber, Real, numbers_given
from polhode.runs.methods.dense_output import Dense
from polhode.scenes.scene import Scene

if TYPE_CHECKING:
    from polhode.refined.attitude import Attitude, Following
    from polhode.refined.events import Search
    from polhode.refined.refinement import Accuracy, Motion

METHODS = ("auto", "taylor", "refined")

#: Forms whose variables are linear functions of the principal one's.  Gauss collocation gives the
#: same states in each of them, so it is done in principal axes.
LINEAR = ("principal", "general", "inertia-axes", "momentum", "gyration-axes")

_MOST_LOG10_ANGLE = 12  # beyond it no run ends
_LEAST_ANGLE = (
    120.0  # radians turned: loading what is compiled costs a shorter run more than it gains
)
_LEAST_ANGLE_LOADED = 5.0  # where it is loaded, as in a sweep: heyoka's own steps take no longer
_LEAST_ANGLE_MP = 120.0  # for more limbs than quad's, whose field takes seconds to compile once
_MORE_DIGITS, _OTHER_INTERVALS = 10, 5  # of a second run, which tells the error of the first
_PARTED = 1e-2  # so far apart two runs say nothing of each other
_GUARD = 16  # bits for what is read from states
_TRIES = 3  # with more digits each, until the estimate holds those asked for


@dataclass(frozen=True)
class Refinement:
    """What a refined run gives.

    ``rows``: the form's variables at ``times``, as rationals; ``beside``: what the outputs add to
    each, as numbers of the run's type.  ``errors``: largest error over the
    columns of each state, absolute, its rounding to the run's type included; None where the
    motion multiplies errors too much for an estimate.  ``dense``: the state at any time reached.
    """

    times: tuple[Fraction, ...]
    rows: list[list[Fraction]]
    beside: list[list[Real]]
    errors: tuple[float | None, ...]
    outcome: Outcome
    steps: int
    reached: Fraction
    dense: RefinedDense
    events: tuple[EventTimes, ...] = ()


def check_method(scene: Scene, method: str) -> None:
    """Raise BadInput for a method that is none."""
    of_kind(scene.name, "method", method, str, ", ".join(METHODS))
    if method not in METHODS:
        raise BadInput(scene.name, "method", method, nearest(method, list(METHODS)))


def why_not(
    scene: Scene,
    number: NumberType,
    tolerance: Fraction | None,
    inputs: NumberType | None,
    project: bool | int | None,
) -> str | None:
    """What stands against refining such a run; None where nothing does."""
    if number.bits <= 64:
        return "quad or more digits"
    digits = _digits(number)
    from polhode.refined.refinement import MOST_DIGITS

    if digits > MOST_DIGITS:
        return f"at most {MOST_DIGITS} digits"
    if scene.form not in LINEAR:
        return "one of the forms " + ", ".join(LINEAR)
    if "angles" in scene.modelled and scene.starts_at_pole:
        return "no angles of a motion that starts at a pole"
    if not _all_entire(scene):
        return "events without a division by what varies or a root of it"
    if tolerance is not None or inputs is not None or project:
        return "no tolerance, rounded inputs or projection of its own"
    if scene.log10_angle > _MOST_LOG10_ANGLE:
        return f"a motion of at most 10**{_MOST_LOG10_ANGLE} radians"
    if equilibrium.at_rest(scene).state:
        return "a motion that does not stand still"
    return None


def worth_it(scene: Scene, number: NumberType, loaded: bool = False) -> bool:
    """Whether a run is long enough for refinement to be the faster way.

    ``loaded``: what is compiled serves other runs, too.
    """
    least = _LEAST_ANGLE_LOADED if loaded else _LEAST_ANGLE
    if _digits(number) > 34:
        least = max(least, _LEAST_ANGLE_MP)
    return bool(scene.log10_angle >= math.log10(least))


def accuracy_for(number: NumberType) -> Accuracy:
    """What a run in a number type is refined to, at first."""
    from polhode.refined.refinement import accuracy

    return accuracy(max(34, _digits(number)))


def refinement(
    scene: Scene,
    number: NumberType,
    times: Sequence[Fraction],
    digits: int | None,
    max_steps: int | None,
    progress: Progress | None,
) -> Refinement:
    """Refine a run at times (scene's units); ``digits``: to be had by the estimate, if it can be.

    The scene is one in the principal form, see :func:`in_principal_axes`.  Raises CannotRefine.
    """
    from polhode.refined.errors import Stalled
    from polhode.refined.refinement import MOST_DIGITS, accuracy, refine

    unit = Fraction(2) ** scene.time_unit
    inside = [t / unit for t in times]
    wanted = max(34, _digits(number))

    def run(wanted: int) -> tuple[Search | None, Motion]:
        search = _search(scene, number)
        following = _following(scene, accuracy(wanted))
        return search, refine(
            scene,
            inside,
            accuracy(wanted),
            progress=progress,
            max_steps=max_steps,
            search=search,
            following=following,
        )

    for _ in range(_TRIES):
        try:
            search, found = run(wanted)
        except Stalled:  # near a separatrix
            wanted += _MORE_DIGITS
            search, found = run(wanted)
        told = found.estimate.errors
        if len(told) and not found.stopped and not math.isfinite(told.max()):
            told = _by_a_second_run(scene, found, wanted, max_steps, progress)
        lacking = 0 if digits is None else _lacking(found, told, digits)
        if not 0 < lacking <= MOST_DIGITS - wanted or found.stopped:
            break
        wanted += lacking
    rows = [found.exactly(i) for i in range(len(found.states))]
    count = len(equations(scene).variables)
    outcome = Outcome(found.stopped) if found.stopped else Outcome.REACHED_END
    reached = found.reached * unit
    if outcome is Outcome.STOPPED_AT_EVENT:
        reached = number.rounded(found.reached) * unit
    return Refinement(
        tuple(times[: len(rows)]),
        [row[:count] for row in rows],
        _turned(scene, number, found.attitudes),
        _errors(scene, number, told, rows),
        outcome,
        found.steps,
        reached,
        RefinedDense(scene, number, reached, found),
        () if search is None else _events(scene, number, search, found),
    )


def _following(scene: Scene, wanted: Accuracy) -> Following | None:
    if not scene.modelled:
        return None
    from polhode.refined.attitude import Following

    return Following(scene, wanted.limbs.finest, "angles" in scene.modelled)


def _turned(scene: Scene, number: NumberType, attitudes: list[Attitude] | None) -> list[list[Real]]:
    """Quaternion, psi and phi as a run's rows have them behind the state, what is asked of them.

    psi is the sum of the arguments of q0 + i q3 and q1 + i q2; phi only tells its branch.
    """
    if attitudes is None:
        return []
    from polhode.numbers.mpmath_context import mpmath, ordinary

    bits, found = number.bits + _GUARD, []
    assert scene.gamma is not None  # else a scene has no outputs
    phi_0 = to_double(kinematics.starting_phi(scene.gamma))
    with mpmath.workprec(bits):
        psi_0 = to_mpf(scene.psi, bits)
        for quaternion, (sum_half, difference_half) in attitudes:
            row = []
            if "attitude" in scene.modelled:
                row += [number_value(x, number) for x in quaternion]
            if "angles" in scene.modelled:
                q0, q1, q2, q3 = (to_mpf(x, bits) for x in quaternion)
                psi = mpmath.atan2(q3, q0) + mpmath.atan2(q2, q1)
                near, whole = psi_0 + sum_half + difference_half, 2 * mpmath.pi
                psi += whole * mpmath.nint((near - psi) / whole)
                phi = mpmath.mpf(phi_0 + sum_half - difference_half)
                row += [number_value(exactly(psi), number), ordinary(phi)]
            found.append(row)
    return found


def _all_entire(scene: Scene) -> bool:
    """Whether all events have a value wherever the motion goes."""
    if not scene.events:
        return True
    from polhode.taylor.events.callbacks import is_entire

    return all(is_entire(scene, event) for event in scene.events)


def _search(scene: Scene, number: NumberType) -> Search | None:
    if not scene.events:
        return None
    from polhode.refined.events import Search

    return Search(scene, number)


def _events(
    scene: Scene, number: NumberType, search: Search, found: Motion
) -> tuple[EventTimes, ...]:
    """The events in scene axes and units, in order of integration."""
    read, unit = Readout(scene, number), Fraction(2) ** scene.time_unit
    count = len(equations(scene).variables)
    return tuple(
        EventTimes(
            name=event.name,
            times=tuple(number.rounded(m.time) * unit for m in marks),
            states=read.states([m.row[:count] for m in marks]),
            grazing=tuple(m.slope == 0 for m in marks),
            complete=complete,
        )
        for event, (marks, complete) in zip(
            scene.events, search.sorted_out(found.reached), strict=True
        )
    )


def _digits(number: NumberType) -> int:
    return int(number.bits * LOG10_2)


def in_principal_axes(scene: Scene) -> Scene:
    """The same scene in the form that is refined."""
    return scene if scene.form == "principal" else replace(scene, form="principal")


def _by_a_second_run(
    scene: Scene, found: Motion, wanted: int, max_steps: int | None, progress: Progress | None
) -> Doubles:
    """Errors as the estimates are, where these are infinite: twice the distance from another run.

    That one has other intervals and so many more digits that the distance is the first run's error.
    Still infinite from where on the two have parted, or the second did not come.
    """
    import numpy as np

    from polhode.refined.errors import CannotRefine
    from polhode.refined.refinement import MOST_DIGITS, accuracy, refine

    errors: Doubles = found.estimate.errors.copy()
    digits = wanted + _MORE_DIGITS
    if digits > MOST_DIGITS:
        return errors
    steps = None if max_steps is None else 2 * max_steps
    wider = accuracy(digits)
    try:
        other = refine(
            scene, found.times, wider, _OTHER_INTERVALS, progress=progress, max_steps=steps
        )
    except CannotRefine:
        return errors
    for i in range(len(other.states)):
        pairs = zip(found.exactly(i), other.exactly(i), strict=True)
        apart = [abs(float(a - b)) for a, b in pairs]
        if max(apart) > _PARTED:
            break
        if not np.isfinite(errors[i]).all():
            errors[i] = 2 * max(apart[:3]), 2 * max(apart[3:])
    return errors


def _lacking(found: Motion, errors: Doubles, digits: int) -> int:
    """How many more digits the errors ask for; 0 where they are infinite: no more would help."""
    if not len(errors) or not math.isfinite(errors.max()):
        return 0
    fastest = max(abs(x) for row in found.states for x in row[:3]) / 2.0**found.bits
    worst = max(errors[:, 0].max() / (fastest or 1.0), errors[:, 1].max())
    return max(0, math.ceil(digits + math.log10(worst)))


def _errors(
    scene: Scene, number: NumberType, told: Doubles, rows: list[list[Fraction]]
) -> tuple[float | None, ...]:
    """The estimate of each row in the scene's axes and units, rounded to its type."""
    turned = 1.0 if scene.body.axes.trivial else math.sqrt(3.0)  # of a vector's largest component
    scale, half_eps = 2.0**-scene.time_unit, float(number.eps) / 2
    errors: list[float | None] = []
    for row, (omega, gamma) in zip(rows, told.tolist(), strict=True):
        w, g = (float(max(map(abs, part))) for part in (row[:3], row[3:]))
        error = turned * max(scale * (omega + half_eps * w), gamma + half_eps * g)
        errors.append(error if math.isfinite(error) else None)
    return tuple(errors)


class RefinedDense(Dense):
    """A refined run's state at any time: refined again from the block before it."""

    def __init__(self, scene: Scene, number: NumberType, reached: Fraction, motion: Motion) -> None:
        self.scene, self.number, self.reached = scene, number, reached
        self._unit = Fraction(2) ** scene.time_unit
        self._motion = motion

    def __call__(self, t: AnyNumber | Iterable[AnyNumber]) -> Row | Rows:
        """The state at t, or rows at several times; see
        :class:`polhode.runs.methods.dense_output.Dense`."""
        given, several = numbers_given(t)
        times = [self._time(x) for x in given]
        count = len(equations(self.scene).variables)
        bits = self._motion.bits
        rows = [[Fraction(x, 1 << bits) for x in row[:count]] for row in self._motion.at(times)]
        states = Readout(self.scene, self.number).states(rows)
        return states if several else states[0]

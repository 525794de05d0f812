"""``polhode.certify``: a scene and times to proven balls, the precision chosen."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from functools import partial
from numbers import Real
from pathlib import Path
from typing import Any

from polhode.common.arguments import each, steps, whole
from polhode.common.deadline import NONE, Deadline
from polhode.common.errors import BadInput
from polhode.common.progress import Progress
from polhode.enclosures import (
    attitude,
    fixed_point_problem,
    integral_contraction,
    proof_loop,
)
from polhode.enclosures.approximation import newton_correction, precision_choice
from polhode.enclosures.derived import derived_balls
from polhode.enclosures.fixed_point_problem import (
    CLOCK,
    LEAST_NOISE,
    MOST_NOISE,
    Motion,
    Refused,
    in_scene_axes,
    motion,
    upper,
)
from polhode.enclosures.polynomial import midpoint
from polhode.enclosures.proof_loop import HONEST, SHORT_STEPS
from polhode.enclosures.result import Enclosure, Part, digits_of
from polhode.enclosures.statement import assumed
from polhode.enclosures.variations import flow_derivative
from polhode.enclosures.variations.flow_derivative import BallMatrix, FlowDerivative
from polhode.enclosures.variations.variational_bound import Derivatives
from polhode.equations.column import derived_words
from polhode.motion.outcomes import Outcome
from polhode.numbers import exact
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact, sign
from polhode.numbers.flint_context import ctx
from polhode.numbers.scalars import AnyNumber, AnyVector
from polhode.scenes import start_box
from polhode.scenes.given_numbers import TIME, reader
from polhode.scenes.scene import Scene
from polhode.scenes.start_box import StartBox
from polhode.scenes.vocabulary import COLUMNS

MOST_DIGITS = 250
MAX_STEPS = 300_000
_MOST_TRIES = 6
_SPARE = 6
_BEYOND_A_BOX = 8  # digits that the proof has more than the box
_TENTHS = 12  # of a box that is too wide


def certify(
    scene: Scene | str | Path,
    at: Iterable[AnyNumber] | None = None,
    *,
    digits: int = 15,
    integrals: bool = True,
    progress: Progress | None = None,
    max_steps: int = MAX_STEPS,
    max_seconds: float | None = None,
    forecast: Callable[[float], None] | None = None,
    derivatives: bool = False,
    omega_radius: AnyNumber | AnyVector | None = None,
) -> Enclosure:
    """Enclose the exact motion of any body in proven balls.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, a path, or the name of a case.  In a file omega may have intervals, ``start.omega =
        ["3/10 \u00b1 1e-9", 0, 1]``.
    at : iterable of numbers, optional
        Exact times of either sign in any order, in the scene's unit; the scene's own by default.
    digits : int
        Correct digits wanted at every time, 1 to MOST_DIGITS.  The precision is chosen from a cheap
        run and raised until they are proven.
    integrals : bool
        Whether the first integrals are used to make the set smaller.
    progress : callable, optional
        Called with the fraction of the time done and the steps taken.
    max_steps : int
        A time that needs more steps is refused before the start.
    max_seconds : float, optional
        A limit on the time by the clock; what is proven until then is kept, as after Ctrl-C, and
        the ``outcome`` says so.
    forecast : callable, optional
        Called once, before the proof, with a rough estimate of its seconds.
    derivatives : bool
        Whether the derivative of the states by the start is enclosed too, to as many digits as
        doubles allow; its steps are shorter.
    omega_radius : number or three numbers, optional
        The balls then hold every motion whose omega at the start differs from the scene's by at
        most this, in each component in body axes.  As many digits are proven as the box allows,
        ``digits`` at most; it is followed as far as possible, and the ``outcome`` says so.

    Returns
    -------
    Enclosure
        A ball for each component at each time, in the scene's axes and units; the memory does not
        grow with the time.

    Raises
    ------
    BadInput
        Digits that cannot be proven, or a box that is too wide to be followed at all.

    Notes
    -----
    The theorem and where each step is in the code: ``polhode guide proofs``.

    Examples
    --------
    >>> import polhode
    >>> found = polhode.certify("general/asymmetric-regular", at=[10], digits=30)
    >>> 30 <= found.digits[0] < 40
    True
    >>> max(found.radii[0]) < 1e-29
    True
    >>> found = polhode.certify("general/asymmetric-regular", at=[10], omega_radius="1e-9")
    >>> 1e-9 < max(found.radii[0]) < 1e-7
    True
    """
    box = start_box.chosen(scene, omega_radius)
    scene = box.scene
    times = scene.times
    if at is not None:
        times = each(scene.name, "at", at, reader(scene.units, TIME), "a list of times")
    if not times:
        raise BadInput(scene.name, "at", None, "at least one time")
    digits = whole(scene.name, "digits", digits, 1, MOST_DIGITS)
    max_steps = steps(scene.name, max_steps)
    deadline = time_limit(scene, max_seconds)
    began = time.process_time()
    if box.radii is not None:
        if scene.starts_at_pole and "angles" in scene.modelled:
            expected = "no angles: where the third axis leaves the vertical depends on omega"
            raise BadInput(scene.name, "outputs", "angles", expected)
        digits = min(digits, digits_of_box(box))
    sides = [_Side(box, times, backward) for backward in (False, True)]
    sides = [side for side in sides if side.places]
    for side in sides:
        if (needed := precision_choice.steps(side.motion, side.last)) > max_steps:
            expected = f"a time that {max_steps} steps reach; this one takes about {needed:.2g}"
            raise BadInput(scene.name, "at", shown(side.last), expected)
    forecasts = [
        precision_choice.forecast(side.motion, side.last, digits, deadline) for side in sides
    ]
    bits = max(found.bits for found in forecasts)
    noise = max(LEAST_NOISE, *(math.ceil(found.bits + found.grown) for found in forecasts))
    if forecast is not None:
        turned = bool({"angles", "attitude"} & {*scene.modelled})
        forecast(sum(found.seconds(noise, turned) for found in forecasts))
    best: Enclosure | None = None
    refusal = ""
    for tries in range(1, _MOST_TRIES + 1):
        noise = min(noise, MOST_NOISE)
        started = time.process_time()
        try:
            found = _found(
                box, times, sides, digits, noise, integrals, progress, deadline, derivatives
            )
        except Refused as why:
            refusal = str(why)
            if noise == MOST_NOISE or (box.radii is not None and tries > 1):
                break
            noise = precision_choice.raised(noise, bits, why)
            continue
        seconds = time.process_time() - started
        in_all = time.process_time() - began
        if not found.outcome.done and best is not None:  # fewer digits, but at every time
            return replace(best, outcome=found.outcome, tries=tries, seconds_in_all=in_all)
        best = replace(found, seconds=seconds, tries=tries, seconds_in_all=in_all)
        if best.reached or not best.outcome.done or box.radii is not None:
            if best.times or best.outcome is not Outcome.TOO_WIDE:
                return best
            break
        if noise == MOST_NOISE:
            break
        noise += math.ceil(precision_choice.BITS_A_DIGIT * (digits - best.fewest)) + _SPARE
    if box.radii is not None:
        raise _too_wide(box, times, deadline)
    had = f"{best.fewest:.1f} proven" if best else refusal
    expected = f"digits that can be proven to t = {_farthest(times)} ({had})"
    raise BadInput(scene.name, "digits", digits, expected)


def digits_of_box(box: StartBox) -> int:
    """Digits beyond those that a box leaves of the start."""
    most = max(box.radii or (Fraction(0),))
    if not most:
        return MOST_DIGITS
    mantissa, exponent = exact.rounded(most, 8)
    left = -(exponent + mantissa.bit_length()) / precision_choice.BITS_A_DIGIT
    return min(MOST_DIGITS, max(1, math.ceil(left)) + _BEYOND_A_BOX)


def _too_wide(box: StartBox, times: Sequence[Exact], deadline: Deadline) -> BadInput:
    """The complaint about a box that was followed to none of the times."""
    zero = Fraction(0)
    (a, b, c), at = box.radii or (zero, zero, zero), [min(times, key=abs)]
    size = max([Fraction(1), *map(abs, map(_fraction_near, box.scene.omega))])
    first = next(k for k in itertools.count(1) if max(a, b, c) <= size * 10 ** (k - 1))
    expected = f"narrower intervals, to be followed to t = {shown(at[0])}"
    for k in range(first, first + _TENTHS):
        narrower = StartBox(box.scene, (a / 10**k, b / 10**k, c / 10**k))
        side = _Side(narrower, at, sign(at[0]) < 0)
        fine = digits_of_box(narrower)
        needed = precision_choice.forecast(side.motion, side.last, fine, deadline)
        noise = min(max(LEAST_NOISE, math.ceil(needed.bits + needed.grown)), MOST_NOISE)
        with suppress(Refused):
            if _found(narrower, at, [side], fine, noise, True, None, deadline, False).times:
                expected += f"; a part in {10**k if k < 7 else f'1e{k}'} of these works"
                break
        if deadline.passed:
            break
    return BadInput(box.scene.name, start_box.KEY, box.told, expected)


def _fraction_near(x: Exact) -> Fraction:
    return exact.binary(*exact.rounded(x, 53))


def time_limit(scene: Scene, seconds: float | None) -> Deadline:
    """The deadline so many seconds from now; raises BadInput."""
    if seconds is None:
        return NONE
    if isinstance(seconds, bool) or not isinstance(seconds, Real) or not seconds > 0:
        raise BadInput(scene.name, "max_seconds", seconds, "a number above 0")
    return Deadline.after(float(seconds))


class _Side:
    """The times of one sign, in order and once each, and where they stand among those asked."""

    def __init__(self, box: StartBox, times: Sequence[Exact], backward: bool) -> None:
        chosen = [n for n, t in enumerate(times) if (sign(t) < 0) == backward]
        order = sorted(chosen, key=lambda n: abs(times[n]))  # exact, and so compared
        self.motion: Motion = motion(box.scene, backward, radii=box.radii)
        self.ordered: list[Exact] = []
        self.places: dict[int, int] = {}  # index among those asked -> index in ``ordered``
        for n in order:
            if not self.ordered or sign(times[n] - self.ordered[-1]) != 0:
                self.ordered.append(times[n])
            self.places[n] = len(self.ordered) - 1

    @property
    def last(self) -> Exact:
        """The time farthest from 0."""
        return self.ordered[-1]


def _found(
    box: StartBox,
    times: Sequence[Exact],
    sides: Sequence[_Side],
    digits: int,
    noise: int,
    integrals: bool,
    progress: Progress | None,
    deadline: Deadline,
    derivatives: bool,
) -> Enclosure:
    """The enclosure at one noise level, as far as it came; raises Refused."""
    scene = box.scene
    rows: dict[int, list[Any]] = {}
    poses: dict[int, attitude.Pose] = {}
    slopes: dict[int, BallMatrix] = {}
    steps, outcome, ends = 0, Outcome.REACHED_END, []
    lost: list[float] = []
    for side in sides:
        if not outcome.done:
            break
        problem = fixed_point_problem.problem(side.motion, noise)
        asked = fixed_point_problem.times(side.motion, side.ordered)
        known = (
            integral_contraction.prepared(side.motion, 2 * problem.fine + 100) if integrals else []
        )
        watch = _watch(side, problem, asked, deadline)
        flow = [Derivatives(asked)] if derivatives else []
        proof = proof_loop.run(
            problem,
            asked,
            known,
            untrusted=SHORT_STEPS if derivatives or box.radii is not None else HONEST,
            progress=progress,
            watchers=[*watch, *flow],
            deadline=deadline,
        )
        steps, outcome = steps + proof.steps, proof.outcome
        way = -1.0 if side.motion.backward else 1.0
        ends.append(way * math.ldexp(proof.end.time, side.motion.unit - CLOCK))
        turned = [in_scene_axes(side.motion, row, noise + 100) for row in proof.rows]
        followed = [len(one.poses) for one in watch] + [len(one.found) for one in flow]
        had = min([len(turned), *followed])
        reached = {n: place for n, place in side.places.items() if place < had}
        rows |= {n: turned[place] for n, place in reached.items()}
        for one in watch:
            poses |= {n: one.poses[place] for n, place in reached.items()}
            if "angles" in scene.modelled and one.lost is not None:
                lost.append(way * math.ldexp(one.lost, side.motion.unit))
        for derived in flow:
            turn = partial(flow_derivative.matrix_in_scene_axes, side.motion, bits=noise + 100)
            slopes |= {n: turn(derived.found[place]) for n, place in reached.items()}
    order = sorted(rows)
    centres, radii = balls([rows[n] for n in order], noise + 100)
    given: dict[str, Sequence[Sequence[Any]]] = {"state": [rows[n] for n in order]}
    if "attitude" in scene.modelled:
        given["attitude"] = [poses[n].quaternion for n in order]
    if "angles" in scene.modelled:
        given["angles"] = [attitude.angles(poses[n], rows[n][3:], noise + 100) for n in order]
    for word in derived_words():
        if word in scene.outputs:
            given[word] = derived_balls(word, scene, given, noise + 100)
    parts = {
        word: Part(*balls(found, noise + 100)) for word, found in given.items() if word in COLUMNS
    }
    return Enclosure(
        scene,
        tuple(times[n] for n in order),
        centres,
        radii,
        _digits(scene, sides, centres, radii),
        digits,
        noise,
        steps,
        0.0,
        1,
        0.0,
        parts.pop("angles", None),
        parts.pop("attitude", None),
        outcome,
        parts,
        FlowDerivative(
            tuple(times[n] for n in order),
            tuple(slopes[n] for n in order),
            flow_derivative.fastest(scene, centres),
        )
        if derivatives
        else None,
        assumed(scene, times),
        tuple(lost),
        box.radii,
        ends[-1],
    )


def _watch(
    side: _Side, problem: fixed_point_problem.Problem, times: Sequence[Any], deadline: Deadline
) -> list[attitude.Watch]:
    """What follows the attitude, if the scene's outputs ask for it."""
    modelled = side.motion.scene.modelled
    if not {"angles", "attitude"} & {*modelled}:
        return []
    angles = "angles" in modelled
    return [attitude.Watch(side.motion, problem, times, newton_correction.forced, angles, deadline)]


def balls(rows: Sequence[Sequence[Any]], bits: int) -> tuple[Any, Any]:
    """Balls as midpoints and radii; what is None has the radius 0."""
    with ctx.workprec(bits):
        return (
            tuple(tuple(None if x is None else midpoint(x) for x in row) for row in rows),
            tuple(tuple(0.0 if x is None else upper(x - x.mid()) for x in row) for row in rows),
        )


def _digits(scene: Scene, sides: Sequence[_Side], centres: Any, radii: Any) -> tuple[float, ...]:
    """Proven correct digits at each time, rounded down to a hundredth."""
    if not centres:
        return ()
    sizes = [math.hypot(*map(float, row[:3])) for row in centres]
    largest = sizes.index(max(sizes))  # in doubles: any row's is a lower bound of the largest
    square = sum(x * x for x in centres[largest][:3])
    sure = float(exact.sqrt(square)) - 2.0 * max(radii[largest][:3])
    if _at_rest(sides[0].motion):
        rate = scene.pendulum_rate_squared
        sure = float(exact.sqrt(rate)) if sign(rate) else 1.0
    found = []
    for row in radii:
        worst = max(row[:3]) / sure if sure > 0.0 else math.inf
        worst = max([worst, *row[3:]])
        found.append(digits_of(worst))
    return tuple(found)


def _at_rest(what: Motion) -> bool:
    """Whether w is zero for ever, zero by the rule for *equal*."""
    if what.radii or any(sign(x) for x in what.start[:3]):
        return False
    pull, push, gamma = what.constants[3:6], what.constants[6:], what.start[3:]
    torques = (
        pull[i] * gamma[a] + push[i] * gamma[b]
        for i, (a, b) in enumerate(fixed_point_problem.CYCLE)
    )
    return all(sign(x) == 0 for x in torques)


def _farthest(times: Sequence[Exact]) -> str:
    return shown(max(times, key=abs))

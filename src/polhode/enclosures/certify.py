"""``polhode.certify`` and ``polhode.certify_events``: a scene and times, or its events, to proven
balls, the precision chosen."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from time import process_time
from typing import Any, Unpack

from flint import arb

from polhode.common.arguments import each, refuse_unknown, with_options, with_progress
from polhode.common.errors import BadInput
from polhode.enclosures import approximation, attitude, fixed_point_problem
from polhode.enclosures.fixed_point_problem import (
    CLOCK,
    MOST_NOISE,
    TIME_BITS,
    ExactMotion,
    Problem,
    TooImprecise,
    in_scene_axes,
    upper,
)
from polhode.enclosures.polynomial import Polynomial, ball, constant, rate, total, variable
from polhode.enclosures.result import CertifiedEvents, EnclosedPart, Enclosure, EventTime, digits_of
from polhode.enclosures.statement import assumed
from polhode.enclosures.task import MAX_STEPS, ProofOptions, Side, Task, task
from polhode.enclosures.zeros import Search, first_derivative, is_still
from polhode.equations.columns import FORMULAS, derived_words
from polhode.equations.terms import LINEAR, ROWS
from polhode.motion.outcomes import Outcome
from polhode.numbers import exact, expression
from polhode.numbers.conversion import TIME, reader
from polhode.numbers.decimals import shown
from polhode.numbers.exact import ZERO, sign
from polhode.numbers.expression import Algebra, ExpressionError
from polhode.numbers.flint_context import ctx
from polhode.numbers.number_types import AnyNumber, Functions
from polhode.numbers.polynomials import middle
from polhode.scenes import library
from polhode.scenes.scene import Event, Scene, middle_axis
from polhode.scenes.vocabulary import COLUMNS, STATE

_MOST_TRIES, _TRIES_OF_EVENTS = 6, 4
_SPARE = 6
_DEARER = 1.4  # with events than without

# --- states ---------------------------------------------------------------------------------------
#
# The states, the attitude, the angles and what is derived of them, at the times asked for.


@with_options(ProofOptions)
@with_progress
def certify(
    scene: Scene | str | Path,
    at: Iterable[AnyNumber] | None = None,
    *,
    digits: int = 15,
    max_steps: int = MAX_STEPS,
    **how: Unpack[ProofOptions],
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
    max_steps : int
        A time that needs more steps is refused before the start.

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
    refuse_unknown("certify", certify, how)
    box = library.box_of(scene, how.get("omega_radius"))
    scene = box.scene
    times = scene.times
    if at is not None:
        times = each(scene.name, "at", at, reader(scene.units, TIME), "a list of times")
    if not times:
        raise BadInput(scene.name, "at", None, "at least one time")
    job = task(box, "at", times, digits, max_steps, how)
    began = process_time()
    if box.radii is not None and scene.starts_at_pole and "angles" in scene.modelled:
        expected = "no angles: where the third axis leaves the vertical depends on omega"
        raise BadInput(scene.name, "outputs", "angles", expected)
    job.foretell()
    noise: int | None = job.noise
    best: Enclosure | None = None
    refusal = ""
    for tries in range(1, _MOST_TRIES + 1):
        if noise is None:
            break
        started = process_time()
        try:
            enclosure = _enclosure(job, noise)
        except TooImprecise as why:
            refusal, noise = str(why), job.raised(noise, why, tries)
            continue
        seconds = process_time() - started
        in_all = process_time() - began
        if not enclosure.outcome.done and best is not None:  # fewer digits, but at every time
            return replace(best, outcome=enclosure.outcome, tries=tries, seconds_in_all=in_all)
        best = replace(enclosure, seconds=seconds, tries=tries, seconds_in_all=in_all)
        if best.complete or not best.outcome.done or box.radii is not None:
            if best.times or best.outcome is not Outcome.TOO_WIDE:
                return best
            break
        if noise == MOST_NOISE:
            break
        missing = approximation.BITS_A_DIGIT * (job.digits - best.fewest)
        noise = min(MOST_NOISE, noise + math.ceil(missing) + _SPARE)
    if box.radii is not None:
        nearest = shown(min(job.times, key=abs))
        expected = f"narrower intervals, to be followed to t = {nearest}"
        raise BadInput(scene.name, library.BOX_KEY, box.text, expected)
    had = f"{best.fewest:.1f} proven" if best else refusal
    expected = f"digits that can be proven to t = {shown(max(times, key=abs))} ({had})"
    raise BadInput(scene.name, "digits", job.digits, expected)


def _enclosure(job: Task, noise: int) -> Enclosure:
    """The enclosure at one noise level, as far as it came; raises TooImprecise."""
    scene, times, bits = job.box.scene, job.times, noise + 100
    solution, angles = approximation.forced, "angles" in scene.modelled

    def watch(side: Side, problem: Problem, at: Sequence[Any]) -> list[attitude.AttitudeWatch]:
        if not scene.modelled:
            return []
        return [attitude.AttitudeWatch(side.motion, problem, at, solution, angles, job.deadline)]

    rows: dict[int, list[Any]] = {}
    poses: dict[int, attitude.Pose] = {}
    lost: list[float] = []
    steps, outcome, until = 0, Outcome.REACHED_END, 0.0
    for side, watches, proof in job.proofs(noise, watch):
        steps, outcome = steps + proof.steps, proof.outcome
        unit = float(side.motion.unit_outside)
        until = unit * math.ldexp(proof.end.time, -CLOCK)
        had = min([len(proof.rows), *(len(watcher.poses) for watcher in watches)])
        states = [in_scene_axes(side.motion, row, bits) for row in proof.rows[:had]]
        reached = {n: place for n, place in side.places.items() if place < had}
        rows |= {n: states[place] for n, place in reached.items()}
        for watcher in watches:
            poses |= {n: watcher.poses[place] for n, place in reached.items()}
            if angles and watcher.followed.lost is not None:
                lost.append(unit * watcher.followed.lost)
    order = sorted(rows)
    balls_by_word: dict[str, Sequence[Sequence[Any]]] = {"state": [rows[n] for n in order]}
    if "attitude" in scene.modelled:
        balls_by_word["attitude"] = [poses[n].quaternion for n in order]
    if angles:
        balls_by_word["angles"] = [attitude.angles(poses[n], rows[n][3:], bits) for n in order]
    for word in derived_words():
        if word in scene.outputs:
            balls_by_word[word] = derived_balls(word, scene, balls_by_word, bits)
    centres, radii = balls(balls_by_word["state"], bits)
    parts = {
        word: EnclosedPart(*balls(x, bits)) for word, x in balls_by_word.items() if word in COLUMNS
    }
    return Enclosure(
        scene,
        tuple(times[n] for n in order),
        centres,
        radii,
        _digits(scene, job.sides, centres, radii),
        job.digits,
        noise,
        steps,
        0.0,
        1,
        0.0,
        parts.pop("angles", None),
        parts.pop("attitude", None),
        outcome,
        parts,
        assumed(scene, times),
        tuple(lost),
        job.box.radii,
        until,
    )


def derived_balls(
    word: str, scene: Scene, balls_by_word: Mapping[str, Sequence[Sequence[Any]]], bits: int
) -> list[list[Any]]:
    """Rows of balls that contain the column, by a run's formula: of rows of balls by name.

    A row is None throughout where a number that it needs is, or where no ball is finite.
    """
    width = len(COLUMNS[word].names)
    rows = []
    with ctx.workprec(bits):
        formula, coefficients = FORMULAS[word].of(scene)
        k = {name: ball(x, bits) for name, x in coefficients.items()}
        fn = Functions(arb(0), arb.sin, arb.cos, arb.sqrt)
        for parts in zip(*(balls_by_word[need] for need in COLUMNS[word].needs), strict=True):
            row = [x for part in parts for x in part]
            balls = [] if any(x is None for x in row) else [arb(x) for x in formula(row, k, fn)]
            finite = balls if all(x.is_finite() for x in balls) else []
            rows.append([*finite, *[None] * (width - len(finite))])
    return rows


def balls(rows: Sequence[Sequence[Any]], bits: int) -> tuple[Any, Any]:
    """Balls as midpoints and radii; what is None has the radius 0."""
    with ctx.workprec(bits):
        return (
            tuple(tuple(None if x is None else middle(x) for x in row) for row in rows),
            tuple(tuple(0.0 if x is None else upper(x - x.mid()) for x in row) for row in rows),
        )


def _digits(scene: Scene, sides: Sequence[Side], centres: Any, radii: Any) -> tuple[float, ...]:
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
    of_omega = (max(row[:3]) / sure if sure > 0.0 else math.inf for row in radii)
    return tuple(digits_of(max([x, *row[3:]])) for x, row in zip(of_omega, radii, strict=True))


def _at_rest(motion: ExactMotion) -> bool:
    """Whether w is zero for ever, zero by the rule for *equal*."""
    if motion.radii or any(sign(x) for x in motion.start[:3]):
        return False
    rates = (
        sum((x.of(motion.constants) * motion.start[x.factors[0]] for x in row if x in LINEAR), ZERO)
        for row in ROWS[:3]
    )
    return all(sign(x) == 0 for x in rates)


# --- events ---------------------------------------------------------------------------------------
#
# Certified events of a scene: how many there are, and when, proven.


@with_options(ProofOptions)
@with_progress
def certify_events(
    scene: Scene | str | Path,
    end: AnyNumber | None = None,
    *,
    digits: int = 15,
    max_steps: int = MAX_STEPS,
    **how: Unpack[ProofOptions],
) -> tuple[CertifiedEvents, ...]:
    """Enclose a scene's events from 0 to a time, each proven to exist and to be the only one there.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene with events, a path, or the name of a case.  An event is a polynomial in p q r
        gamma1 gamma2 gamma3 that is not 0 at all times; its ``stop`` is ignored.  In a file omega
        may have intervals, as for :func:`certify`: each event then is one of every motion.
    end : number, optional
        In the scene's unit; the scene's own unless given.
    digits : int
        Digits of the state along the motion, 1 to MOST_DIGITS; more digits make the radii smaller
        and separate zeros that are closer.
    max_steps : int
        An end that needs more steps is refused before the start.

    Returns
    -------
    tuple of CertifiedEvents
        One for each event of the scene: times as balls, and intervals that stayed undecided.

    Raises
    ------
    BadInput
        An event of another kind, or digits that cannot be proven to the end.

    Examples
    --------
    >>> import polhode
    >>> event = polhode.Event("level", "gamma3 - 1/2")
    >>> scene = polhode.Scene(polhode.Body.of_moments((1, 1, 1)), (1, 0, 0), (0, 0, 1),
    ...                       events=(event,))
    >>> (found,) = polhode.certify_events(scene, end=2)
    >>> [round(float(t.time), 12) for t in found.times]  # pi/3
    [1.047197551197]
    >>> [round(float(x), 12) for x in found.times[0].state]  # p q r gamma1 gamma2 gamma3
    [1.0, 0.0, 0.0, 0.0, 0.866025403784, 0.5]
    """
    refuse_unknown("certify_events", certify_events, how)
    box = library.box_of(scene, how.get("omega_radius"))
    scene = box.scene
    last = scene.end
    if end is not None:
        (last,) = each(scene.name, "end", (end,), reader(scene.units, TIME), "a time")
    if sign(last) == 0:
        raise BadInput(scene.name, "end", "0", "a time other than 0")
    job = task(box, "end", [last], digits, max_steps, how)
    (side,) = job.sides
    polynomials = [of_event(side.motion, n, event) for n, event in enumerate(scene.events)]
    for n, (event, g) in enumerate(zip(scene.events, polynomials, strict=True)):
        if is_still(side.motion, g):
            key, text = f"events[{n + 1}].zero", event.expression or event.name
            expected = "an expression that is not zero at all times of the motion"
            raise BadInput(scene.name, key, text, expected)
    job.foretell(_DEARER)
    noise: int | None = job.noise
    for tries in range(1, _TRIES_OF_EVENTS + 1):
        if noise is None:
            break
        try:
            return _events(job, polynomials, noise)
        except TooImprecise as why:
            noise = job.raised(noise, why, tries)
    if box.radii is not None:
        raise BadInput(scene.name, library.BOX_KEY, box.text, "narrower intervals")
    raise BadInput(scene.name, "digits", job.digits, "digits that can be proven to the end")


def _events(
    job: Task, polynomials: Sequence[Polynomial], noise: int
) -> tuple[CertifiedEvents, ...]:
    """The events proven at one noise level, as far as it came; raises TooImprecise."""

    def watch(side: Side, problem: Problem, times: Sequence[Any]) -> list[Search]:
        bits, searches = 2 * problem.fine + 100, []
        for g in polynomials:
            first = first_derivative(side.motion, g)
            at_start = None if first is None else first.balls(bits)
            slope = rate(g, side.motion.field).balls(bits)
            searches.append(Search(g.balls(bits), slope, at_start, job.deadline))
        return searches

    ((side, searches, proof),) = job.proofs(noise, watch)
    for search in searches:
        search.finish()
    motion = side.motion
    (end,) = fixed_point_problem.times(motion, side.ordered)
    until = end if proof.outcome.done else arb((proof.end.time, -CLOCK))
    events = zip(job.box.scene.events, searches, strict=True)
    rows = [_named(motion, event, search, until, noise) for event, search in events]
    if not proof.outcome.done:
        missed = _interval(motion, until, end, end)
        rows = [replace(row, undecided=(*row.undecided, missed)) for row in rows]
    return tuple(rows)


def _named(
    motion: ExactMotion, event: Event, search: Search, end: arb, noise: int
) -> CertifiedEvents:
    """What one search found up to the end, in the scene's unit and direction of time."""
    by = motion.unit_outside
    times, undecided = [], []
    with ctx.workprec(noise + 200):
        for crossing in search.crossings:
            slope = -crossing.slope if motion.backward else crossing.slope
            time, state = crossing.at
            if not event.counts(slope) or time > end:
                continue
            if time < end and time > 0:
                row = in_scene_axes(motion, state, noise + 100)
                times.append(_time(time, by, slope, row, noise + 100))
            else:
                undecided.append(_interval(motion, time, time, end))
    for contact in search.contacts:
        if not contact.begin > end:
            undecided.append(_interval(motion, contact.begin, contact.end, end))
    return CertifiedEvents(event.name, tuple(times), tuple(undecided))


def _interval(motion: ExactMotion, begin: arb, end: arb, last: arb) -> tuple[float, float]:
    """Doubles of the scene around all times of two balls, of those from 0 to ``last``."""
    by = motion.unit_outside
    with ctx.workprec(TIME_BITS):
        low, high = (middle(x) for x in (begin.lower(), end.upper()))
        most = middle(last.upper())
    lower, highest = sorted((by * max(low, Fraction(0)), by * min(high, most)))
    below, above = float(lower), float(highest)
    return (
        below if Fraction(below) <= lower else math.nextafter(below, -math.inf),
        above if Fraction(above) >= highest else math.nextafter(above, math.inf),
    )


def _time(time: arb, by: Fraction, slope: int, row: Sequence[arb], bits: int) -> EventTime:
    radius = upper(arb(time.rad())) * abs(float(by))
    (centres,), (radii,) = balls([row], bits)
    return EventTime(middle(time) * by, radius, slope, centres, radii)


def of_event(motion: ExactMotion, n: int, event: Event) -> Polynomial:
    """What vanishes, of the scene's own sign, as a polynomial in the proof's variables.

    Raises BadInput.
    """
    scene = motion.scene
    text, unit = event.expression, 1 / motion.unit_outside
    key = f"events[{n + 1}].zero"
    if text is None:  # w along the middle principal axis
        return variable(middle_axis(scene)) * unit
    rows = scene.body.axes.rows
    columns = {}
    for k, name in enumerate(STATE):
        part, i = divmod(k, 3)
        rotated = total([variable(3 * part + j) * rows[j][i] for j in range(3)])
        columns[name] = rotated if part else rotated * unit
    if scene.gamma is None:
        columns = {name: columns[name] for name in STATE[:3]}
    functions = dict.fromkeys(expression.FUNCTIONS, _refuse)
    try:
        value = expression.evaluate(text, columns, Algebra(constant, functions))
    except ExpressionError as fault:
        expected = f"a polynomial in {' '.join(columns)} ({fault})"
        raise BadInput(scene.name, key, text, expected) from None
    if not isinstance(value, Polynomial) or not value.terms:
        raise BadInput(scene.name, key, text, "a polynomial that is not a number")
    return value


def _refuse(_: Polynomial) -> Polynomial:
    raise ValueError("a function of a name is no polynomial")

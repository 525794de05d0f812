"""Certified events of a scene: how many there are, and when, proven."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

from flint import arb

from polhode.common.arguments import each
from polhode.common.errors import BadInput
from polhode.common.interrupts import Progress
from polhode.enclosures import fixed_point_problem
from polhode.enclosures.certify import balls
from polhode.enclosures.fixed_point_problem import (
    CLOCK,
    TIME_BITS,
    Motion,
    Problem,
    Refused,
    in_scene_axes,
    upper,
)
from polhode.enclosures.polynomial import Polynomial, constant, rate, total, variable
from polhode.enclosures.result import CertifiedEvents, EventTime
from polhode.enclosures.task import MAX_STEPS, Side, Task, task
from polhode.enclosures.zeros import Search, first_derivative, is_still
from polhode.numbers import expression
from polhode.numbers.conversion import TIME, reader
from polhode.numbers.exact import sign
from polhode.numbers.expression import Algebra, ExpressionError
from polhode.numbers.flint_context import ctx
from polhode.numbers.number_types import AnyNumber, AnyVector
from polhode.numbers.polynomials import middle
from polhode.scenes import library
from polhode.scenes.scene import Event, Scene
from polhode.scenes.vocabulary import STATE

_MOST_TRIES = 4
_DEARER = 1.4  # with events than without


def certify_events(
    scene: Scene | str | Path,
    end: AnyNumber | None = None,
    *,
    digits: int = 15,
    progress: Progress | None = None,
    max_steps: int = MAX_STEPS,
    max_seconds: float | None = None,
    forecast: Callable[[float], None] | None = None,
    omega_radius: AnyNumber | AnyVector | None = None,
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
    progress : callable, optional
        Called with the fraction of the time done and the steps taken.
    max_steps : int
        An end that needs more steps is refused before the start.
    max_seconds : float, optional
        A limit on the time by the clock; events after the time that was reached are undecided.
    forecast : callable, optional
        Called once, before the proof, with a rough estimate of its seconds.
    omega_radius : number or three numbers, optional
        As for :func:`certify`: each event then is one of every motion from the box.

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
    box = library.box_of(scene, omega_radius)
    scene = box.scene
    last = scene.end
    if end is not None:
        (last,) = each(scene.name, "end", (end,), reader(scene.units, TIME), "a time")
    if sign(last) == 0:
        raise BadInput(scene.name, "end", "0", "a time other than 0")
    job = task(box, "end", [last], digits, max_steps, max_seconds, progress)
    (side,) = job.sides
    polynomials = [of_event(side.motion, n, event) for n, event in enumerate(scene.events)]
    for n, (event, g) in enumerate(zip(scene.events, polynomials, strict=True)):
        if is_still(side.motion, g):
            key, text = f"events[{n + 1}].zero", event.expression or event.name
            expected = "an expression that is not zero at all times of the motion"
            raise BadInput(scene.name, key, text, expected)
    job.foretell(forecast, _DEARER)
    noise: int | None = job.noise
    for tries in range(1, _MOST_TRIES + 1):
        if noise is None:
            break
        try:
            return _events(job, polynomials, noise)
        except Refused as why:
            noise = job.raised(noise, why, tries)
    if box.radii is not None:
        raise BadInput(scene.name, library.BOX_KEY, box.text, "narrower intervals")
    raise BadInput(scene.name, "digits", job.digits, "digits that can be proven to the end")


def _events(
    job: Task, polynomials: Sequence[Polynomial], noise: int
) -> tuple[CertifiedEvents, ...]:
    """The events proven at one noise level, as far as it came; raises Refused."""

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


def _named(motion: Motion, event: Event, search: Search, end: arb, noise: int) -> CertifiedEvents:
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


def _interval(motion: Motion, begin: arb, end: arb, last: arb) -> tuple[float, float]:
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


def of_event(motion: Motion, n: int, event: Event) -> Polynomial:
    """What vanishes, as a polynomial in the proof's variables; raises BadInput."""
    scene = motion.scene
    text = event.expression
    key = f"events[{n + 1}].zero"
    if text is None:  # w along the middle principal axis
        return variable(sorted(range(3), key=lambda i: motion.moments[i])[1])
    rows = scene.body.axes.rows
    unit = 1 / motion.unit_outside
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

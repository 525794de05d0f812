"""How a motion multiplies errors."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import islice
from typing import NamedTuple

import numpy as np

from polhode.common.values import cached_property
from polhode.equations.forms import principal
from polhode.equations.readout import at_rest
from polhode.equations.terms import NAMES
from polhode.motion.frame import Frame
from polhode.motion.outcomes import Outcome
from polhode.numbers.conversion import ExactNumbers, to_double
from polhode.numbers.decimals import brief
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import DOUBLE, Doubles, double_array
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import STATE
from polhode.taylor.batches import LANES, in_lanes, until
from polhode.taylor.engine import Equations, lent
from polhode.taylor.motion import Motion
from polhode.taylor.projection import kept_at_zero
from polhode.taylor.system import System, principal_system
from polhode.taylor.variations import Leader, Variations, pendulum, six

# --- state transition -----------------------------------------------------------------------------
#
# What happens to small changes along a motion, stretch by stretch.
#
# From the end of one stretch to that of the next a change v of the state, and changes c of the
# equations' coefficients k in units u of their own, go over into
#
#     Phi v + U c,    Phi' = J(x) Phi,    U' = J(x) U + u df/dk,    Phi = 1 and U = 0 before,
#
# all in principal axes and the scene's own unit of time. Stretches are short enough that a double
# holds each Phi; products of them are taken by :mod:`polhode.judging.conditioning`. Where a run
# leads to is where the next stretch begins, so that the lanes of a batch have one each.


STRIDES = (1.0, 8.0)  # units of the scene's own time a stretch: at least, at most
MOST_STRETCHES = 4000  # of the shortest
_TRIED = 20_000  # steps after which it is seen that no output is within reach
_BLOCK = 8 * LANES  # stretches that are followed before anybody asks how much errors have grown


class Stretch(NamedTuple):
    """A part of the motion, at its end.

    ``time``: own unit.  ``state``: six components, principal axes.  ``steps``: Taylor steps in
    double along it, about.  ``carried``: Phi, (6, 6).  ``driven``: U, a column for each coefficient
    of :data:`polhode.equations.terms.NAMES`.
    """

    time: float
    state: Doubles
    steps: float
    carried: Doubles
    driven: Doubles


@dataclass(frozen=True)
class Passage:
    """The stretches of a scene's motion up to its outputs, |t| increasing.

    ``outputs``: the output times in the scene's own unit; each ends a stretch, as far as they were
    reached.  ``note``: why not further, else empty.
    """

    scene: Scene
    outputs: tuple[float, ...]
    stretches: tuple[Stretch, ...]
    note: str

    @cached_property
    def inside(self) -> Scene:
        """The scene inside its frame."""
        return Frame.of(self.scene).inside(self.scene)

    @cached_property
    def plain(self) -> System:
        """The equations in principal axes."""
        return principal_system(self.inside)

    @cached_property
    def units(self) -> tuple[float, ...]:
        """The units u of the coefficients, in the order of the columns of U."""
        return coefficient_units(self.inside)

    @cached_property
    def turn(self) -> Doubles:
        """From principal axes to the scene's, as a matrix."""
        return double_array(Frame.of(self.scene).matrix(DOUBLE).T)

    @cached_property
    def rate_scale(self) -> float:
        """What changes of w are relative to: the largest |w| at the outputs, as in the digits."""
        outputs = set(self.outputs)
        speeds = (float(np.linalg.norm(s.state[:3])) for s in self.stretches if s.time in outputs)
        return max(speeds, default=0.0) or pendulum(self.inside)


def passage(scene: Scene, max_steps: int = 400_000, until: float = math.inf) -> Passage:
    """The stretches of a scene's motion to its output times.

    Each begins where a run in double leads to or, once that is no longer the scene's motion, one
    in a wider type.  ``max_steps``: of the tangents, of about 10 µs; where not even the first
    output is within them, some are taken.  ``until``: log10 of |Phi| of the whole way beyond which
    nothing is wanted; the passage ends there without a note.
    """
    frame = Frame.of(scene)
    inside = frame.inside(scene)
    outputs = tuple(to_double(frame.time(t)) for t in scene.times)
    plain = principal_system(inside)
    time, state = 0.0, six(plain.start)
    w = float(np.linalg.norm(state[:3])) or pendulum(inside)
    sizes = np.array([w, w, w, 1.0, 1.0, 1.0])
    leader, tangents = Leader(plain), _Tangents(plain, sizes, np.array(coefficient_units(inside)))
    still = at_rest(inside).state
    stretches: list[Stretch] = []
    whole, height, steps, note = np.eye(6), 0.0, 0.0, ""
    nearest = min((abs(t) for t in outputs if t), default=0.0)
    moments = _stops(outputs)
    ahead = [*islice(moments, _BLOCK)]
    while ahead and not note and height <= until:
        states = np.tile(state, (len(ahead), 1)) if still else leader.rows(ahead, height)
        starts, count = np.vstack([state, states[:-1]]), len(stretches)
        parts = tangents.over(starts, np.diff([time, *ahead]), max_steps - int(steps))
        for t, reached, (carried, driven, step_count) in zip(ahead, states, parts, strict=True):
            if steps > _TRIED and 2 * abs(time) * max_steps < nearest * steps:
                step_count = math.inf
            if steps + step_count > max_steps or not np.isfinite(carried).all():
                more = steps + step_count > max_steps
                why = f"more than {max_steps} steps" if more else "not finite in double"
                last = brief(frame.time_outside(Fraction(time)), 3)
                note = f"not followed beyond t = {last}: {why}"
                break
            time, state, steps = t, reached, steps + step_count
            stretches.append(Stretch(t, reached, step_count, carried, driven))
            whole = carried @ whole
            largest = float(np.max(np.abs(whole / sizes[:, None] * sizes)))
            height += math.log10(largest)
            whole /= largest
            if height > until:
                break
            if not (still or leader.holds(height)):
                state = leader.at(t, height)
                break
        ahead = ahead[len(stretches) - count :] or [*islice(moments, _BLOCK)]
    leader.release()
    tangents.release()
    return Passage(scene, outputs, tuple(_with_plain_steps(stretches, plain)), note)


class _Tangents:
    """Phi and U over stretches, as many at a time as a batch has lanes.

    ``sizes``: of the components of the state, for the choice of steps.  ``units``: of the
    coefficients, 0 for those that have no tangent: the fewer there are, the shorter it takes.
    """

    def __init__(self, plain: System, sizes: Doubles, units: Doubles) -> None:
        self._sizes, self._units = sizes, units
        self._used = np.flatnonzero(units)
        count = len(self._used)
        self._ready = lent(Equations(STATE, NAMES, tangents=6 + count, driven=count, lanes=LANES))
        columns = np.hstack([np.diag(sizes), np.zeros((6, count))])
        self._start = np.repeat(columns.T.ravel()[:, None], LANES, axis=1)
        numbers = [to_double(plain.coefficients.get(name, 0)) for name in NAMES]
        drives = np.diag(units)[self._used]
        self._numbers = np.concatenate([numbers, drives.ravel()])[:, None]

    def over(
        self, starts: Doubles, lengths: Doubles, most: int
    ) -> Iterator[tuple[Doubles, Doubles, float]]:
        """Phi, U and the steps of stretches from states on, of such lengths.

        Each in at most so many steps, infinitely many where they do not suffice; nan where it is
        not finite.
        """
        order = np.argsort(np.abs(lengths))
        columns, steps = np.empty((len(order), 6, 6 + len(self._used))), np.empty(len(order))
        batches = in_lanes(starts[order]), in_lanes(lengths[order, None])
        for k, (state, length) in enumerate(zip(*batches, strict=True)):
            self._ready.state[:] = np.concatenate([state, self._start])
            self._ready.begin(self._numbers)
            ended = until(self._ready.heyoka, length[0].tolist(), most)
            here = order[k * LANES : (k + 1) * LANES]
            lanes = self._ready.state[6:].reshape(-1, 6, LANES).transpose(2, 1, 0)
            columns[here] = lanes[: len(here)]
            short = [
                outcome in (Outcome.STEP_LIMIT, Outcome.STEP_UNDERFLOW)
                for outcome in ended.outcomes
            ]
            steps[here] = np.where(short, math.inf, ended.steps)[: len(here)]
        driven = np.zeros((len(order), 6, len(self._units)))
        driven[:, :, self._used] = columns[:, :, 6:]
        yield from zip(columns[:, :, :6] / self._sizes, driven, steps.tolist(), strict=True)

    def release(self) -> None:
        """Leave the compiled code to the next motion; the last call of all."""
        self._ready.release()


def _with_plain_steps(stretches: list[Stretch], plain: System) -> list[Stretch]:
    """Stretches with their share of the steps that a run without tangents and outputs takes."""
    tangents_steps = sum(s.steps for s in stretches)
    if not tangents_steps:
        return stretches
    motion = Motion(plain)
    motion.begin(plain)
    end = ExactNumbers((Fraction(stretches[-1].time),))
    _, outcome = motion.advance(end, math.inf)
    if outcome is Outcome.INTERRUPTED:
        raise KeyboardInterrupt
    share = motion.steps / tangents_steps
    motion.release()
    return [s._replace(steps=s.steps * share) for s in stretches]


def coefficient_units(scene: Scene) -> tuple[float, ...]:
    """The unit of each coefficient: what it changes by where an input changes by itself.

    Of a scene inside its frame.
    """
    units = dict.fromkeys(NAMES, 0.0)
    for by in principal.sensitivities(scene.body):
        for name, x in by.items():
            units[name] = max(units[name], abs(to_double(x)))
    return tuple(units.values())


def _stops(outputs: Sequence[float]) -> Iterator[float]:
    """The output times and every multiple of the stride between them, away from 0."""
    least, most = STRIDES
    end = abs(outputs[-1]) if outputs else 0.0
    stride = min(most, max(least, end / MOST_STRETCHES))
    multiple = 0
    for t in outputs:
        while (multiple + 1) * stride < abs(t):
            multiple += 1
            yield math.copysign(multiple * stride, t)
        if abs(t) == (multiple + 1) * stride:
            multiple += 1
        yield t


# --- error growth ---------------------------------------------------------------------------------
#
# How much a motion multiplies errors on the way: one tangent, by the variational equations.
#
#     G(t) = max over s <= t of |v(t)| / |v(s)|,    v' = J(x) v,    lost(t) = log10(G(t) sqrt(n(t)))
#
# v along no special direction, w measured by the largest |w|, gamma as it is; n the Taylor steps
# so far, each of which rounds the state once. A run whose numbers hold so many digits is expected
# to have lost so many of them at t. Components that the equations keep at exactly zero take no
# rounding, and none is given to them here.
#
# Where a run is put back, once in m steps, on as many integrals as fix its torus, its frequencies
# walk at random for m steps at most. What each walk shifts is another number at random, so that
#
#     lost(t) = log10 max(G, sqrt(n), G m/sqrt(n)),    n > m,
#
# the first for the rounded inputs, which no projection puts right.


MOST_STEPS = 50_000  # of 4 µs
STRIDE = 8.0  # of the scene's own unit of time between two looks where the motion is led
MOST_LOOKS, LONGEST = 64, 256.0  # otherwise: about so many looks, none so far from the last
LED_FROM = 10.0  # log10 of G up to which a motion in double is the scene's to six digits
TRUSTED = 14.0  # log10 of G beyond which a motion in double says nothing of the scene's
_LATEST = 2.0**900  # of the scene's own unit of time; whatever a law says of later times
_EXPONENTIAL = 6.0  # ln of G in the second half of the time: no power of time grows so much
_DIRECTION = (0.6, -0.5, 0.4, 0.3, 0.2, -0.3)  # along no axis


class Growth(NamedTuple):
    """Decimal digits lost, at moments from 0 on; between two of them log10 is linear in time.

    ``times``: in the scene's own unit 2**unit, |t| increasing.  ``lost``: see the module; at least
    0.  ``followed``: the last time to which the tangent was followed; later values continue its
    law.  ``steps``: Taylor steps in double to the end, about.  ``fastest``: the largest |w| seen,
    in that unit.
    """

    times: tuple[float, ...]
    lost: tuple[float, ...]
    followed: float
    steps: int
    unit: int
    fastest: float = 0.0

    def at(self, t: Exact) -> float:
        """The digits lost at a time."""
        here = to_double(abs(t) / Fraction(2) ** self.unit)
        return float(np.interp(here, np.abs(self.times), self.lost))

    def reaches(self, lost: float) -> float | None:
        """The first time at which so many digits are lost; None where they never are."""
        before, height = 0.0, 0.0
        for t, here in zip(self.times, self.lost, strict=True):
            if here >= lost:
                part = (lost - height) / (here - height) if here > height else 1.0
                time = before + min(1.0, max(0.0, part)) * (t - before)
                return to_double(Fraction(time) * Fraction(2) ** self.unit)
            before, height = t, here
        return None


def growth(
    scene: Scene,
    limit: float = math.inf,
    max_steps: int = MOST_STEPS,
    led: bool = False,
    trusted: float = TRUSTED,
    every: int = 0,
    in_all: bool = False,
    end: Exact | None = None,
) -> Growth:
    """The digits lost from 0 to the scene's end or another, followed until ``limit`` of them are.

    ``max_steps``: of the tangent; beyond them its law is continued: exponential where it was so in
    the second half of the time, else in proportion to time.  ``led``: whether an integration of
    wider type, which may cost as much as the run itself, keeps the motion the scene's own once G
    has passed 1e10.  Unled, the law is continued from where G passes 10**trusted; up to there, or
    everywhere with inf, the tangent may be that of a neighbour's motion.  ``every``: the steps
    between two projections of an integrable top onto all its integrals, 0 without.  ``in_all``:
    errors of all components, also of those that the equations keep at zero.
    """
    frame = Frame.of(scene)
    inside, principal = frame.inside(scene), scene.form == "principal" and not in_all
    last = to_double(frame.time(scene.end if end is None else end))
    last = max(-_LATEST, min(_LATEST, last))
    if last == 0 or (principal and at_rest(inside).state):  # nothing is rounded on the way
        return Growth((0.0,), (0.0,), last, 0, frame.exponent)
    plain = principal_system(inside)
    start = six(plain.start)
    tangent = np.array(_DIRECTION)
    tangent[:3] *= float(np.linalg.norm(start[:3])) or 1.0
    if principal:
        tangent[list(kept_at_zero(inside))] = 0
    tangent[len(plain.start) :] = 0
    flow = Variations(plain.coefficients, start, tangent[:, None])
    leader = Leader(plain) if led else None
    looks = [_look(flow)]
    for t in _moments(last, led):
        arrived = flow.to(t, max_steps - flow.steps)
        if not flow.finite:
            break
        flow.rescale()
        looks.append(_look(flow))
        passed = _grown(looks, inside)[-1]
        if not arrived or passed > limit * math.log(10):
            break
        if leader is None and passed > trusted * math.log(10):
            break
        if leader is not None and passed > LED_FROM * math.log(10):
            flow.state = leader.at(t, passed / math.log(10))
    flow.release()
    return _continued(looks, _grown(looks, inside), last, frame.exponent, every)


class _Look(NamedTuple):
    """One moment, in the scene's own unit of time."""

    time: float
    steps: int
    speed: float  # |w|
    sizes: tuple[float, float]  # ln |v|: its part of w, its part of gamma


def _look(flow: Variations) -> _Look:
    v, more = flow.tangents[:, 0], flow.exponent * math.log(2)
    sizes = [_ln(float(np.linalg.norm(part))) + more for part in (v[:3], v[3:])]
    return _Look(flow.time, flow.steps, float(np.linalg.norm(flow.state[:3])), (sizes[0], sizes[1]))


def _grown(looks: list[_Look], scene: Scene) -> list[float]:
    """ln of G at each look."""
    scale = _ln(max(look.speed for look in looks) or pendulum(scene))
    least, sizes = math.inf, []
    for look in looks:
        size = max(look.sizes[0] - scale, look.sizes[1])
        least = min(least, size)
        sizes.append(size - least)
    return sizes


def _continued(looks: list[_Look], grown: list[float], end: float, unit: int, every: int) -> Growth:
    """Growth from what was seen, its law continued to the end."""
    times, last = [look.time for look in looks], looks[-1].time
    added = [0.5 * math.log(max(1, look.steps)) for look in looks]  # ln of sqrt(n)
    whole = [*grown]
    if abs(last) < abs(end):
        half = float(np.interp(abs(last) / 2, np.abs(times), grown))
        ahead = np.geomspace(abs(last) or 1e-3 * abs(end), abs(end), 16)[1:]
        per_time = (grown[-1] - half) / (abs(last) / 2 or 1.0)
        exponential = grown[-1] - half > _EXPONENTIAL
        for t in ahead:
            ratio = float(t) / (abs(last) or float(t))
            more = per_time * (float(t) - abs(last)) if exponential else math.log(ratio)
            times.append(math.copysign(float(t), end))
            whole.append(grown[-1] + more)
            added.append(added[len(looks) - 1] + 0.5 * math.log(ratio))
    lost = [_lost(g, n, every) / math.log(10) for g, n in zip(whole, added, strict=True)]
    steps = math.ceil(looks[-1].steps * abs(end / last)) if last else looks[-1].steps
    fastest = max(look.speed for look in looks)
    return Growth(tuple(times), tuple(lost), last, steps, unit, fastest)


def _lost(grown: float, root: float, every: int) -> float:
    """ln of what a rounding has become: by ln of G and of sqrt(n), see the module."""
    if every == 0 or 2 * root <= math.log(every):
        return grown + root
    return max(grown, root, grown + math.log(every) - root)


def _moments(end: float, led: bool) -> Iterator[float]:
    """Moments from 0 to the end, without 0."""
    stride = STRIDE if led else min(LONGEST, max(STRIDE, abs(end) / MOST_LOOKS))
    count = math.ceil(abs(end) / stride)
    for k in range(1, count):
        yield math.copysign(k * stride, end)
    yield end


def _ln(x: float) -> float:
    return math.log(x) if x > 0 else -math.inf

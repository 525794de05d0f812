"""Whether what a run noted is an event: zeros taken to their last digits, and the rule."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import NamedTuple, TypeAlias

import numpy as np

from polhode.motion.frame import Frame
from polhode.numbers.number_types import Booleans, Flat, Indices, NumberType, Scalar
from polhode.taylor.event_functions import BAND, OWN, Jet, Marks, joined_marks
from polhode.taylor.heyoka import array, as_fraction, scalar, scalars

# --- polishing ------------------------------------------------------------------------------------
#
# Zeros of an expression and of its rate, all of a run at once, taken to their last digits.
#
# heyoka finds a zero to about the last digit of the time, a multiple one to a root of that.  From
# the state there Newton's method takes the rest, along the motion's own Taylor polynomial of third
# order; at extrema in the form that converges at multiple zeros, too.


#: How far a zero may be from where heyoka met it, in the run's unit.
_NEAR = Fraction(1, 1000)
_ROUNDS = 6  # of a method; one or two are the rule

#: Of a place without a slope, a bend and a third derivative: steps in which its width is sought.
_WIDTHS = [2.0**-k for k in range(48, 3, -1)]
_FLAT = 2.0**-7

_NOWHERE = np.empty((4, 0)), np.empty(0)


class Places(NamedTuple):
    """Polished zeros of an expression (``root``) and extrema.

    ``ahead``: the time since the start in the direction of the run, numbers of the run's type.
    ``values`` (4, n): the expression and its derivatives divided by BAND u, plain numbers of numpy;
    ``noise``: what rounding makes of the first of them.  ``near``: where the expression is within
    that of zero, or nothing is known of it.  ``steep``: where a zero would be one for certain.
    ``own``: where the expression may be zero at this very state, but for the rounding of its
    numbers.  ``reach``: the half width of the band there, in time; ``width``: how far off the time
    may be.
    """

    marks: Marks
    ahead: Scalar
    values: Flat
    noise: Flat
    root: Booleans
    steep: Booleans
    own: Booleans
    near: Booleans
    reach: Flat
    width: Flat

    def those(self, which: Booleans | Indices | slice | list[int]) -> Places:
        """Some of them."""
        return Places._make([self.marks.those(which), *(a[..., which] for a in self[1:])])

    @property
    def order(self) -> Indices:
        """Their order in time."""
        return np.argsort(self.ahead, kind="stable")


def polished(jet: Jet, met: Sequence[Marks], ends: Marks, sense: int) -> tuple[Places, Places]:
    """The places that heyoka has met: zeros of the expression, and then zeros of its rate.

    And the same of the motion's ``ends``, as they are.  ``sense``: -1 for a run backward in time.
    """
    zeros, extrema = met
    count = len(zeros.time) + len(extrema.time)
    root = np.ones(count + len(ends.time), dtype=bool)
    root[len(zeros.time) : count] = False
    with np.errstate(all="ignore"):
        marks = _refined(jet, joined_marks(met), ~root[:count])
        every = places(jet, joined_marks([marks, ends]), sense, root)
    return every.those(slice(count)), every.those(slice(count, None))


def _refined(jet: Jet, marks: Marks, extrema: Booleans) -> Marks:
    """The same by some rounds of Newton's method, or at extrema of Schroeder's."""
    converged = Fraction(1, 1 << (jet.number.bits // 2 + 6))  # the error is its square
    zero, near, small = scalars((Fraction(0), _NEAR, converged), jet.number)
    going = np.full(len(extrema), True)  # no last bit depends on neighbours
    for _ in range(_ROUNDS if going.any() else 0):
        value, rate, bend, third = jet.at(marks)
        step = -value / rate
        if extrema.any():
            step[extrema] = (-rate * bend / (bend * bend - rate * third))[extrema]
        step[~(going & (abs(step) < near))] = zero
        marks = jet.moved(marks, step)
        going = abs(step) > small
        if not going.any():
            break
    return marks


def places(jet: Jet, marks: Marks, sense: int, root: Booleans) -> Places:
    """What rounding leaves certain at some marks; ``root``: at which of them a zero was met."""
    ahead = marks.since_start if sense > 0 else -marks.since_start
    count = len(marks.time)
    values, error = (jet.relative(marks), jet.noise(marks)) if count else _NOWHERE
    with np.errstate(all="ignore"):
        value, rate, bend, third = np.abs(values)
        across = 2 * (error + value) / rate
        steep = (2 * bend * across < rate) & (2 * third * across * across < 3 * rate)
        reach = 2 * _half_width(values, error)
        width = 4 * _half_width(values, error + value)
        certain = error / rate / 16
        own, near = value <= OWN / BAND * error, ~(value > error)
    flat = np.flatnonzero(near & ~steep & ~(width < 4 * _FLAT))
    if len(flat):
        width[flat] = _sought(jet, marks.those(flat), error[flat])
    width = np.where(steep, certain, width)
    return Places(marks, ahead, values, error, root, steep, own, near, reach, width)


def _half_width(values: Flat, height: Flat) -> Flat:
    """How far from an extremum or a zero the expression rises so high, by its derivatives."""
    _, rate, bend, third = np.abs(values)
    near: Flat = np.fmin(height / rate, np.sqrt(2 * height / bend))
    far: Flat = np.cbrt(6 * height / third)
    return np.fmin(near, far)


def _sought(jet: Jet, marks: Marks, error: Flat) -> Flat:
    """How far from a place the expression stays within twice its noise, by looking."""
    widths = np.full(len(error), _WIDTHS[-1], dtype=error.dtype)
    open_still = np.ones(len(error), dtype=bool)
    for width in _WIDTHS:
        step: Scalar = array([scalar(Fraction(width), jet.number)] * len(error), jet.number)
        for side in (step, -step):
            value = jet.relative(jet.moved(marks, side))[0]
            out = open_still & (np.abs(value) > 2 * error)
            widths[out] = width
            open_still &= ~out
        if not open_still.any():
            break
    return widths


def joined_places(parts: Sequence[Places]) -> Places:
    """Several lists as one, in this order."""
    parts = [part for part in parts if len(part.ahead)] or parts[:1]
    if len(parts) == 1:
        return parts[0]
    marks = joined_marks([part.marks for part in parts])
    more = [np.concatenate(arrays, axis=-1) for arrays in zip(*(p[1:] for p in parts), strict=True)]
    return Places._make([marks, *more])


def exact_times(times: Scalar, frame: Frame, number: NumberType) -> tuple[Fraction, ...]:
    """Times inside a frame as exact numbers in the scene's unit."""
    return tuple(frame.time_outside(as_fraction(t, number)) for t in times.tolist())


# --- decision -------------------------------------------------------------------------------------
#
# What happens at the zeros and extrema of an expression along a computed motion.
#
# Within its noise, the rounding error of its terms there, an expression is neither positive nor
# negative. A *crossing* changes the side; a *contact* comes that near to zero and leaves on the
# side that it came from. Zeros and extrema witness the sides, and each kind repairs a loss of the
# other.
#
# A zero that may be at the very state of an end, but for the rounding of that state's numbers, is
# at this end: the end of one run has it, and the start of the next, which goes on from there, has
# not.


ULPS = 64  # so near together two zeros of one slope are one, found twice


class End(NamedTuple):
    """The expression at an end of the motion: ``side``, its sign there, and as a polished place.

    At the start the side is that of the exact scene, or 0 where the start may have a zero itself.
    """

    side: int
    place: Places

    @property
    def value(self) -> float:
        """The expression in the unit of its noise."""
        return float(self.place.values[0, 0])

    @property
    def near(self) -> bool:
        """Whether it is within its noise of zero."""
        return bool(self.place.near[0])

    @property
    def own(self) -> bool:
        """Whether a zero may be at this very end."""
        return bool(self.place.own[0])


def at_the_end(place: Places) -> End:
    """An end with the sign that was computed there."""
    value = float(place.values[0, 0])
    return End(int(np.sign(value)) if np.isfinite(value) else 0, place)


class Happening(NamedTuple):
    """A crossing to the side ``sign``, or a contact (0), at place ``at`` or, found otherwise,
    before it at a place of its ``own``.

    ``spread``: from the first to the last place of one event, in time.
    """

    at: int
    sign: int
    spread: float = 0.0
    own: Places | None = None


class Happenings(NamedTuple):
    """Several of them in order, as arrays; ``own``: the places of those found otherwise."""

    at: Indices
    signs: Indices
    spreads: Flat
    own: Mapping[int, Places]

    @classmethod
    def of(cls, few: Sequence[Happening], crossings: Indices, sides: Indices) -> Happenings:
        """Some, and behind them plain ``crossings``, to ``sides``."""
        if not few:
            return cls(crossings, sides, np.zeros(len(crossings)), {})
        at, signs, spreads, own = zip(*few, strict=True)
        return cls(
            np.concatenate([np.array(at, dtype=int), crossings]),
            np.concatenate([np.array(signs, dtype=int), sides]),
            np.concatenate([np.array(spreads, dtype=float), np.zeros(len(crossings))]),
            {k: places for k, places in enumerate(own) if places is not None},
        )

    def those(self, which: Indices) -> Happenings:
        """Some of them."""
        own = self.own
        if own:
            own = {n: own[k] for n, k in enumerate(which.tolist()) if k in own}
        return Happenings(self.at[which], self.signs[which], self.spreads[which], own)

    def located(self, places: Places) -> Places:
        """Where each is, as a polished place; ``places``: those that were decided about."""
        if not self.own:
            return places.those(self.at)
        at = self.at.tolist()
        return joined_places([self.own.get(k) or places.those([i]) for k, i in enumerate(at)])


_NONE = np.empty(0, dtype=int)

#: Looks for the crossing to a side that was lost from one place to another (-1: the start; as many
#: as there are places: the end), and gives its place; None where it has none.
Search: TypeAlias = Callable[[int, int, int], "Places | None"]


def plain_lanes(
    places: Places, lanes: Indices, first: Flat, last: Flat, sense: int
) -> tuple[Booleans, Flat]:
    """The motions whose places, ``lanes`` by ``lanes`` in order of time, are as they must be.

    That is: plain zeros that change the side, and extrema outside of their noise that confirm it,
    from the sides ``first`` to ``last`` of each motion; 0 where that is not certain.  And the side
    after each place.
    """
    sides: Flat = np.sign(np.where(places.root, places.values[1] * sense, places.values[0]))
    before = np.where(np.diff(lanes, prepend=-1) != 0, first[lanes], np.roll(sides, 1))
    after: Flat = first.astype(float)  # a side may be none: nan
    after[lanes] = sides
    plain: Booleans = (first != 0) & (after == last)
    zero = places.steep & places.near & (sides == -before)
    fits = np.where(places.root, zero, ~places.near & (sides == before))
    plain[lanes[~fits]] = False
    return plain, sides


class Decision:
    """One pass over places in order of time, from the start up to an end.

    ``way``: -1 for a run backward in time.  ``alike``: within so many ulps, of this size, two zeros
    of one slope are one.  ``happenings``: what happens; ``complete``: whether nothing is lost.
    Meanwhile, ``side``: where the expression was last for certain; ``since``: the place that
    witnessed it, -1 for the start.  ``starting``: it has not left its noise yet.
    """

    def __init__(
        self,
        places: Places,
        start: End,
        end: End,
        sense: int,
        alike: float,
        search: Search,
    ) -> None:
        self.places, self.start, self.end, self.search = places, start, end, search
        self.way, self.alike = sense, alike
        self.side, self.since, self.starting = start.side, -1, start.near
        self._happened: list[Happening] = []
        self._crossings = self._sides = _NONE  # plain ones, behind all those
        self.inside: list[int] = []  # places within their noise since the last witness
        self.last: int | None = None  # the last plain zero
        self.complete = True
        self._run()
        self.happenings = Happenings.of(self._happened, self._crossings, self._sides)

    def _run(self) -> None:
        places, count = self.places, len(self.places.ahead)
        if not self.starting and self._all_plain(0):
            return
        quick, near = self.starting, places.near
        finite = np.isfinite(places.values[0])
        signs = np.sign(places.values[:2])
        for i in range(count):
            if quick and not self.starting:
                quick = False
                if self._all_plain(i):
                    return
            if not finite[i]:
                continue
            if not near[i]:
                if not places.root[i]:
                    self._witness(i, int(signs[0, i]))
            elif not places.steep[i]:
                self.inside.append(i)
            elif places.root[i]:
                self._zero(i, int(signs[1, i]) * self.way)
        self._end(count)

    def _all_plain(self, i: int) -> bool:
        """Whether from a place on nothing is left to be decided; its zeros are crossings then."""
        rest = self.places.those(slice(i, None)) if i else self.places
        lane = np.zeros(len(rest.ahead), dtype=int)
        last = 0 if self.end.own else self.end.side
        plain, sides = plain_lanes(rest, lane, np.array([self.side]), np.array([last]), self.way)
        if plain[0]:
            roots = np.flatnonzero(rest.root)
            self._crossings, self._sides = i + roots, sides[roots].astype(int)
        return bool(plain[0])

    def _zero(self, i: int, side: int) -> None:
        """A plain zero: on the other side before it, on ``side`` after it."""
        if self._beyond(i, side):
            return
        width = self.places.reach[i]
        ahead = float(self.places.ahead[i])
        if self.starting and not self.inside and ahead <= 2 * width + self._ulps(i):
            if self.side == -side:  # a side for certain, and left soon after the start
                self._happens(i, side)
            self._stands(i, side)
            self.last = i
            return
        if self.side == side:
            if self.last is not None and self._same(self.last, i):
                return
            self._lost(-side, i)
        self._happens(i, side)
        self._stands(i, side)
        self.last = i

    def _witness(self, i: int, side: int) -> None:
        """Somewhere outside of its noise the expression has this side."""
        if self.side and side != self.side:
            if self.inside:
                self._happens_inside(side)
            else:
                self._lost(side, i)
        elif self.side and self.inside and not self.starting:
            self._happens_inside(0)
        self._stands(i, side)

    def _end(self, count: int) -> None:
        if not np.isfinite(self.end.value):
            return
        if not self.end.near:
            self._witness(count, self.end.side)
        elif self.inside and not self.starting:
            self._happens_inside(0)
        elif self.side and self.end.place.steep[0] and not self.starting:
            side = int(np.sign(self.end.place.values[1, 0])) * self.way
            if side == -self.side and (self.end.own or self.end.value * side >= 0):
                self._happens(count, side, own=self.end.place)

    def _stands(self, i: int, side: int) -> None:
        self.side, self.since, self.starting = side, i, False
        self.inside.clear()

    def _happens(self, i: int, sign: int, spread: float = 0.0, own: Places | None = None) -> None:
        self._happened.append(Happening(i, sign, spread, own))

    def _happens_inside(self, sign: int) -> None:
        """One event at the places within their noise, at the extremum if there is one."""
        extrema = [i for i in self.inside if not self.places.root[i]] or self.inside
        ahead = self.places.ahead[self.inside]
        self._happens(extrema[len(extrema) // 2], sign, float(ahead[-1] - ahead[0]))

    def _lost(self, side: int, before: int) -> None:
        """A crossing to a side that was not noted."""
        crossing = self.search(side, self.since, before)
        if crossing is None:
            self.complete = False
        else:
            self._happens(before, side, own=crossing)

    def _beyond(self, i: int, side: int) -> bool:
        """Whether a zero lies behind the end, and the expression does not reach it there."""
        past = self.places.ahead[i] > self.end.place.ahead[0]
        return bool(past) and not self.end.value * side >= 0

    def _same(self, i: int, j: int) -> bool:
        apart = float(self.places.ahead[j] - self.places.ahead[i])
        return apart <= 2 * float(self.places.reach[i] + self.places.reach[j]) + self._ulps(j)

    def _ulps(self, i: int) -> float:
        return ULPS * self.alike * max(1.0, abs(float(self.places.ahead[i])))


def depths(happenings: Happenings, places: Places, start: End, end: End) -> Flat:
    """How far beside each event the expression gets from zero, in the unit of its noise.

    At a contact, how far from zero it is there; beside a crossing the least value at extrema
    outside of the noise, or at the ends of the motion.
    """
    value = np.abs(places.values[0])
    peaks = np.flatnonzero(~places.root & (value > places.noise))
    heights = np.abs(np.concatenate([[start.value], value[peaks], [end.value]]))
    least = np.fmin(heights[:-1], heights[1:])
    at, contact = happenings.at, happenings.signs == 0
    crossing = least[np.searchsorted(peaks, at)]
    inside = value[np.where(contact, at, 0)] if len(value) else crossing
    depth: Flat = np.where(contact, inside, crossing)
    return depth

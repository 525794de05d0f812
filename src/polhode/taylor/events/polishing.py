"""Zeros of an expression and of its rate, all of a run at once, taken to their last digits.

heyoka finds a zero to about the last digit of the time, a multiple one to a root of that.  From the
state there Newton's method takes the rest, along the motion's own Taylor polynomial of third order;
at extrema in the form that converges at multiple zeros, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from polhode.motion.frame import Frame
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Booleans, Flat, Indices
from polhode.numbers.scalars import Scalar
from polhode.taylor.backend.heyoka_numbers import array, as_fraction, scalar
from polhode.taylor.events.jets import Jet, Marks, joined_marks
from polhode.taylor.events.roundoff import BAND, OWN

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
    ``noise``: what rounding makes of the first of them.  ``steep``: where a zero would be one for
    certain.  ``own``: where the expression may be zero at this very state, but for the rounding of
    its numbers.  ``reach``: the half width of the band there, in time; ``width``: how far off the
    time may be.
    """

    marks: Marks
    ahead: Scalar
    values: Flat
    noise: Flat
    root: Booleans
    steep: Booleans
    own: Booleans
    reach: Flat
    width: Flat

    def those(self, which: Booleans | Indices | slice | list[int]) -> Places:
        """Some of them."""
        return Places._make([self.marks.those(which), *(a[..., which] for a in self[1:])])

    @property
    def order(self) -> Indices:
        """Their order in time."""
        order: Indices = np.argsort(self.ahead, kind="stable")
        return order

    @property
    def near(self) -> Booleans:
        """Where the expression is within its noise of zero, or nothing is known of it."""
        near: Booleans = ~(np.abs(self.values[0]) > self.noise)
        return near


def polished(jet: Jet, met: Sequence[Marks], ends: Marks, way: int) -> tuple[Places, Places]:
    """The places that heyoka has met: zeros of the expression, and then zeros of its rate.

    And the same of the motion's ``ends``, as they are.  ``way``: -1 for a run backward in time.
    """
    roots, extrema, others = (len(marks.time) for marks in (*met, ends))
    count = roots + extrema
    root = np.repeat([True, False, True], [roots, extrema, others])
    with np.errstate(all="ignore"):
        marks = _refined(jet.those(np.arange(count)), joined_marks(met), ~root[:count])
        every = places(jet, joined_marks([marks, ends]), way, root)
    return every.those(slice(count)), every.those(slice(count, None))


def _refined(jet: Jet, marks: Marks, extrema: Booleans) -> Marks:
    """The same by some rounds of Newton's method, or at extrema of Schroeder's."""
    converged = Fraction(1, 1 << (jet.number.bits // 2 + 6))  # the error is its square
    zero, near, small = (scalar(x, jet.number) for x in (Fraction(0), _NEAR, converged))
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


def places(jet: Jet, marks: Marks, way: int, root: Booleans) -> Places:
    """What rounding leaves certain at some marks; ``root``: at which of them a zero was met."""
    ahead = marks.since_start if way > 0 else -marks.since_start
    count = len(marks.time)
    values, error = (jet.relative(marks), jet.noise(marks)) if count else _NOWHERE
    with np.errstate(all="ignore"):
        value, rate, bend, third = np.abs(values)
        across = 2 * (error + value) / rate
        steep = (2 * bend * across < rate) & (2 * third * across * across < 3 * rate)
        reach = 2 * _half_width(values, error)
        width = 4 * _half_width(values, error + value)
        certain = error / rate / 16
        own = value <= OWN / BAND * error
    flat = np.flatnonzero(~steep & ~(width < 4 * _FLAT) & ~(value > error))
    if len(flat):
        width[flat] = _sought(jet.those(flat), marks.those(flat), error[flat])
    width = np.where(steep, certain, width)
    return Places(marks, ahead, values, error, root, steep, own, reach, width)


def _half_width(values: Flat, height: Flat) -> Flat:
    """How far from an extremum or a zero the expression rises so high, by its derivatives."""
    _, rate, bend, third = np.abs(values)
    near: Flat = np.fmin(height / rate, np.sqrt(2 * height / bend))
    far: Flat = np.cbrt(6 * height / third)
    least: Flat = np.fmin(near, far)
    return least


def _sought(jet: Jet, marks: Marks, error: Flat) -> Flat:
    """How far from a place the expression stays within twice its noise, by looking."""
    found = np.full(len(error), _WIDTHS[-1], dtype=error.dtype)
    open_still = np.ones(len(error), dtype=bool)
    for width in _WIDTHS:
        step: Scalar = array([scalar(Fraction(width), jet.number)] * len(error), jet.number)
        for side in (step, -step):
            value = jet.relative(jet.moved(marks, side))[0]
            out = open_still & (np.abs(value) > 2 * error)
            found[out] = width
            open_still &= ~out
        if not open_still.any():
            break
    return found


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

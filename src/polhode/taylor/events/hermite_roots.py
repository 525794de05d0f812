"""Where a function crosses zero between knots at which its first derivatives are known.

Between two knots the function is its Hermite interpolant of degree 9, in Bernstein's form: the
coefficients are sums of the derivatives at the ends, and it has no more zeros than their signs
change (Descartes).  So an interval holds no zero, or one that the signs at its ends tell, or it is
halved.  Coefficients near zero count as of either sign, and have to rise or fall: so no shift that
small makes two zeros of one, or of none.  A knot's sign serves both its neighbours: no crossing is
lost or counted twice at a knot.

How far the interpolant is off is told by that over two intervals at the knot between them: the
error falls with the tenth power of the length, so over one it is 1024 times smaller.  That is so
where two intervals are not too long for interpolation; where they are, nothing is gained on them.
"""

from __future__ import annotations

from itertools import pairwise
from math import comb, perm
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from polhode.numbers.number_types import DOUBLE
from polhode.numbers.rows import Doubles
from polhode.taylor.backend.engine import hy
from polhode.taylor.backend.heyoka_numbers import EXPRESSIONS, disk_cache
from polhode.taylor.backend.types import CompiledFunction

Cells: TypeAlias = npt.NDArray[np.intp]

#: Derivatives that are asked for at each knot, the value first.
DERIVATIVES = 5

_DEGREE = 2 * DERIVATIVES - 1
_SAFETY = 64  # of the factor 1024
_WILD = 16  # of the values there: an error as large as that over two intervals makes them too long
_BESIDE = 2  # knots
_BLOCK = 1024  # knots whose arrays fit into a processor's own memory
_HALVINGS = 10
_ROUNDS = 4  # of Newton's method
_KEPT = 2.0**-12  # of an interval: after a step below this a place is right to 2**-20 or so
_ORDERS, _ENDS = range(DERIVATIVES), range(_DEGREE + 1)

#: The coefficients next to a knot from the derivatives there, times powers of the width: those
#: of the interval after it, and of that before it; and a knot's part in the value at the next one,
#: over the two intervals that it is between.
_AFTER = np.array([[float(comb(j, k)) for k in _ORDERS] for j in _ORDERS])
_TURN = np.array([(-1.0) ** k for k in _ORDERS])
_ACROSS = np.array(
    [sum(comb(_DEGREE, j) * comb(j, k) for j in _ORDERS) * 2.0 ** (k - _DEGREE) for k in _ORDERS]
)
_FROM_KNOT = np.vstack([_AFTER, (_AFTER * _TURN)[::-1], _ACROSS, _ACROSS * _TURN])

#: The coefficients of both halves, and those of powers.
_LEFT = np.array([[comb(i, j) / 2.0**i for j in _ENDS] for i in _ENDS])
_HALVES = np.vstack([_LEFT, _LEFT[::-1, ::-1]])
_POWERS = np.array(
    [[comb(_DEGREE, k) * comb(k, j) * (-1.0) ** (k - j) for j in _ENDS] for k in _ENDS]
)


class Crossed(NamedTuple):
    """Zeros between knots: ``cells`` in which they are, and ``places`` there from 0 to 1, in order.

    ``unsure``: the cells in which there may be other zeros or none, or one that only touches;
    ``near``: the knots at which the function may be zero.
    """

    cells: Cells
    places: Doubles
    unsure: npt.NDArray[np.bool_]
    near: npt.NDArray[np.bool_]


class _Open(NamedTuple):
    """Intervals that may hold zeros: in which cells, where they begin there, and coefficients.

    ``error``: how far the interpolants may be off; ``margin``: below which a value may be a zero.
    """

    cells: Cells
    begin: Doubles
    coefficients: Doubles
    error: Doubles
    margin: Doubles

    @classmethod
    def joined(cls, parts: list[_Open]) -> _Open:
        """Several lists in one."""
        return cls(*(np.concatenate(x, axis=-1) for x in zip(*parts, strict=True)))

    def those(self, which: npt.NDArray[np.bool_] | Cells) -> _Open:
        """Some of them."""
        places = np.flatnonzero(which) if which.dtype == bool else which
        cells, others = self.cells.take(places), (part.take(places, axis=-1) for part in self[1:])
        return _Open(cells, *others)

    def halved(self, part: float) -> _Open:
        """The halves of intervals of this part of a cell."""
        halves = _HALVES @ self.coefficients
        left, right = np.split(halves, 2)
        right[0] = left[-1]
        begin = np.concatenate([self.begin, self.begin + part / 2])
        both = np.hstack([left, right])
        return _Open(np.tile(self.cells, 2), begin, both, *(np.tile(x, 2) for x in self[3:]))


def crossed(
    values: Doubles, width: float, contact: float, flat: float, newton: CompiledFunction
) -> Crossed:
    """Zeros of a function from ``values`` (5, knots), itself and its derivatives.

    ``width``: between two knots, negative where time runs backward.  A zero next to an extremum of
    at most ``contact``, or of a slope of at most ``flat``, is unsure.  ``newton``: what
    :func:`newton` compiled.
    """
    count = values.shape[1] - 1
    if count < 2:
        none = np.empty(0)
        return Crossed(none.astype(int), none, np.ones(count, bool), np.ones(count + 1, bool))
    from_knot = _FROM_KNOT * _scales(width)
    near, unsure = np.zeros(count + 1, bool), np.zeros(count, bool)
    edges = [*range(0, max(count - _BLOCK // 2, 1), _BLOCK), count]
    with np.errstate(all="ignore"):
        parts = []
        for first, last in pairwise(edges):
            part, beside = _open(values[:, first : last + 1], from_knot, contact)
            near[first : last + 1] |= beside
            parts.append(part._replace(cells=part.cells + first))
        cells, places = _sorted_out(
            _Open.joined(parts), unsure, flat * abs(width) / _DEGREE, newton
        )
    unsure[cells[np.isnan(places)]] = True
    kept = ~unsure[cells]
    cells, places = cells[kept], places[kept]
    order = np.lexsort((places, cells))
    return Crossed(cells[order], places[order], unsure, near)


def _scales(width: float) -> Doubles:
    return np.array([width**k / perm(_DEGREE, k) for k in _ORDERS])


def error(values: Doubles, width: float) -> float:
    """The largest error of interpolation over two intervals, beside the largest value."""
    with np.errstate(all="ignore"):
        found = _FROM_KNOT[-2:] * _scales(width) @ values
        off = np.abs(found[0, :-2] + found[1, 2:] - values[0, 1:-1]).max()
        return float(off / np.abs(values[0]).max())


def _open(
    values: Doubles, from_knot: Doubles, contact: float
) -> tuple[_Open, npt.NDArray[np.bool_]]:
    """The cells that may hold zeros, and the knots that may be some."""
    found = from_knot @ values
    after, before = found[:DERIVATIVES], found[DERIVATIVES:-2]
    value = np.abs(values[0])
    off = np.abs(found[-2, :-2] + found[-1, 2:] - values[0, 1:-1])
    wild = ~(off <= (value[:-2] + value[1:-1] + value[2:]) / _WILD)
    off /= _SAFETY
    if wild.any():
        off = _guarded(off, wild)
    at = np.concatenate([off[:1], off, off[-1:]])
    near = ~(value > at + contact)
    beside = np.maximum(at[:-1], at[1:])
    error = beside.copy()  # of four knots: at two of them the tenth derivative may vanish
    np.maximum(error[1:], beside[:-1], out=error[1:])
    np.maximum(error[:-1], beside[1:], out=error[:-1])
    margin = error + contact
    sure = np.minimum(after.min(0)[:-1], before.min(0)[1:]) > margin
    sure |= np.maximum(after.max(0)[:-1], before.max(0)[1:]) < -margin
    cells = np.flatnonzero(~sure)
    coefficients = np.vstack([after[:, cells], before[:, cells + 1]])
    coefficients[0], coefficients[-1] = values[0, cells], values[0, cells + 1]
    return _Open(cells, np.zeros(len(cells)), coefficients, error[cells], margin[cells]), near


def _guarded(off: Doubles, wild: npt.NDArray[np.bool_]) -> Doubles:
    """Errors at knots, where intervals are too long and beside: one may be small by accident."""
    spread = np.arange(-_BESIDE, _BESIDE + 1)
    beside = np.unique(np.clip(np.add.outer(np.flatnonzero(wild), spread), 0, len(off) - 1))
    around = np.clip(np.add.outer(beside, spread), 0, len(off) - 1)
    guarded = off.copy()
    guarded[beside] = 2 * _SAFETY * off[around].max(1)
    guarded[np.isnan(guarded)] = np.inf
    return guarded


def _sorted_out(
    left: _Open, unsure: npt.NDArray[np.bool_], flat: float, newton: CompiledFunction
) -> tuple[Cells, Doubles]:
    """Cells and places of zeros; the cells about which nothing is sure are noted."""
    turned, parts, part = [], [], 1.0
    for _ in range(_HALVINGS + 1):
        b = left.coefficients
        negative, small = b < 0, ~(np.abs(b) > left.margin)
        once = (negative[1:] != negative[:-1]).sum(0) <= 1
        doubtful = np.flatnonzero(small.any(0))
        if len(doubtful):
            once[doubtful] = _at_most_one(left.those(doubtful), part, flat)
        turned.append(left.those(once & ((b[0] < 0) != (b[-1] < 0))))
        parts.append(np.full(len(turned[-1].cells), part))
        hopeless = small.all(0) & ~once
        unsure[left.cells[hopeless]] = True
        if np.all(once | hopeless):
            break
        left = left.those(~(once | hopeless)).halved(part)
        part /= 2
        b = left.coefficients
        left = left.those(~((b.min(0) > left.margin) | (b.max(0) < -left.margin)))
    else:
        unsure[left.cells] = True
    found, lengths = _Open.joined(turned), np.concatenate(parts)
    roots = _roots(newton, found.coefficients, lengths * (4 * found.error + flat))
    return found.cells, found.begin + lengths * roots


def _at_most_one(left: _Open, part: float, flat: float) -> npt.NDArray[np.bool_]:
    """Whether coefficients, some of them near zero, rise or fall through zero, never flat there."""
    b, margin = left.coefficients, left.margin
    small = ~(np.abs(b) > margin)
    cut = np.diff(np.minimum(np.maximum(b, -margin), margin), axis=0)
    level = np.abs(np.diff(b, axis=0)) <= part * (4 * left.error + flat)
    found: npt.NDArray[np.bool_] = (cut.min(0) >= 0) | (cut.max(0) <= 0)
    return found & ~(level & (small[1:] | small[:-1])).any(0)


def newton() -> CompiledFunction:
    """From the coefficients of a polynomial's powers and a place: the place after some steps of
    Newton's method, the last step, and the slope there.
    """
    variables = hy.make_vars(*(f"c{k}" for k in _ENDS), "x")
    powers, place = variables[:-1], variables[-1]
    for _ in range(_ROUNDS):
        value, slope = powers[-1], EXPRESSIONS.zero
        for power in powers[-2::-1]:
            slope = slope * place + value
            value = value * place + power
        step = value / slope
        place = place - step
    with disk_cache(DOUBLE):
        return hy.cfunc([place, step, slope], vars=variables)


def _roots(newton: CompiledFunction, coefficients: Doubles, least: Doubles) -> Doubles:
    """The only zeros of polynomials; nan where one is not found, or of a slope below the least.

    Newton's method begins where the polygon of the coefficients crosses zero.
    """
    column = np.arange(coefficients.shape[1])
    after = ((coefficients < 0) != (coefficients[0] < 0)).argmax(0)
    low, high = coefficients[after - 1, column], coefficients[after, column]
    guess = (after - 1 + low / (low - high)) / _DEGREE
    place, step, slope = newton(np.vstack([_POWERS @ coefficients, guess]))
    sure = (np.abs(step) < _KEPT) & (np.abs(slope) > least) & (np.abs(place - 0.5) < 0.5 + _KEPT)
    return np.where(sure, np.clip(place, 0.0, 1.0), np.nan)

"""Where a function crosses zero between knots at which its first derivatives are known.

Between two knots the function is its Hermite interpolant of degree 7, in Bernstein's form: the
coefficients are sums of the derivatives at the ends, the values lie between the smallest and the
largest, and the function is monotone where they are.  So an interval holds no zero, or one that
the signs at its ends tell, or it is halved.  A knot's sign serves both its neighbours: no crossing
is lost or counted twice at a knot.

How far the interpolant is off is told by that over two intervals at the knot between them: the
error falls with the eighth power of the length, so over one it is 256 times smaller.
"""

from __future__ import annotations

from math import comb, perm
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.numbers.scalars import Doubles

#: Derivatives that are asked for at each knot, the value first.
DERIVATIVES = 4

_DEGREE = 2 * DERIVATIVES - 1
_SAFETY = 16  # of the factor 256
_HALVINGS = 10
_ROUNDS = 5  # of Newton's method, from a place between the ends where the polynomial is monotone
_KEPT = 2.0**-20  # of an interval: how near a place is told
_LEFT = np.array([[comb(i, j) / 2.0**i for j in range(_DEGREE + 1)] for i in range(_DEGREE + 1)])
_HALVES = np.vstack([_LEFT, _LEFT[::-1, ::-1]])
_POWERS = np.array(
    [
        [comb(_DEGREE, k) * comb(k, j) * (-1.0) ** (k - j) for j in range(_DEGREE + 1)]
        for k in range(_DEGREE + 1)
    ]
)


class Crossed(NamedTuple):
    """Zeros between knots: ``cells`` in which they are, and ``places`` there from 0 to 1, in order.

    ``unsure``: the cells in which there may be other zeros or none, or one that only touches;
    ``near``: the knots at which the function may be zero.
    """

    cells: npt.NDArray[np.intp]
    places: Doubles
    unsure: npt.NDArray[np.bool_]
    near: npt.NDArray[np.bool_]


def crossed(values: Doubles, width: float, contact: float, flat: float) -> Crossed:
    """Zeros of a function from ``values`` (4, knots), itself and its derivatives.

    ``width``: between two knots, negative where time runs backward.  A zero next to an extremum of
    at most ``contact``, or of a slope of at most ``flat``, is unsure.
    """
    count = values.shape[1] - 1
    if count < 2:
        none = np.empty(0)
        return Crossed(none.astype(int), none, np.ones(count, bool), np.ones(count + 1, bool))
    scales = [width**k / perm(_DEGREE, k) for k in range(DERIVATIVES)]
    scaled = values * np.array(scales)[:, None]
    with np.errstate(all="ignore"):
        error = _errors(scaled)
        margin = error + contact
        ends = np.maximum(np.append(margin, margin[-1]), np.append(margin[:1], margin))
        near = ~(np.abs(values[0]) > ends)
        found, unsure = _sorted_out(_bernstein(scaled), error, margin, flat * abs(width) / _DEGREE)
    cells, places = found
    unsure[cells[np.isnan(places)]] = True
    kept = ~unsure[cells]
    cells, places = cells[kept], places[kept]
    order = np.lexsort((places, cells))
    return Crossed(cells[order], places[order], unsure, near)


def _errors(scaled: Doubles) -> Doubles:
    """How far the interpolants may be off, cell by cell."""
    left, right = scaled[:, :-2], scaled[:, 2:]
    middle = (left[0] + right[0]) / 2
    middle += (77 * (left[1] - right[1]) + 126 * (left[2] + right[2])) / 32
    middle += (left[3] - right[3]) * (70 / 32)
    off = np.abs(middle - scaled[0, 1:-1]) / _SAFETY
    at: Doubles = np.concatenate([off[:1], off, off[-1:]])
    return np.maximum(at[:-1], at[1:])


def _bernstein(scaled: Doubles) -> Doubles:
    """Bernstein's coefficients of the interpolants (8, cells)."""
    found = np.empty((_DEGREE + 1, scaled.shape[1] - 1))
    for side, sign, rows in ((slice(None, -1), 1, (0, 1, 2, 3)), (slice(1, None), -1, (7, 6, 5, 4))):
        value, first, second, third = scaled[:, side]
        first, third = sign * first, sign * third
        found[rows[0]] = value
        found[rows[1]] = value + first
        found[rows[2]] = value + 2 * first + second
        found[rows[3]] = value + 3 * (first + second) + third
    return found


def _sorted_out(
    coefficients: Doubles, error: Doubles, margin: Doubles, flat: float
) -> tuple[tuple[npt.NDArray[np.intp], Doubles], npt.NDArray[np.bool_]]:
    """Cells and places of zeros; and the cells about which nothing is sure."""
    unsure = np.zeros(len(error), bool)
    cell = np.arange(len(error))
    begin, part = np.zeros(len(error)), 1.0
    cells, places = [cell[:0]], [begin[:0]]
    for halving in range(_HALVINGS + 1):
        open_ = ~(coefficients.min(0) > margin) & ~(coefficients.max(0) < -margin)
        coefficients, begin = coefficients[:, open_], begin[open_]
        cell, error, margin = cell[open_], error[open_], margin[open_]
        steps, slack = np.diff(coefficients, axis=0), part * (4 * error + flat)
        monotone = (steps.min(0) > slack) | (steps.max(0) < -slack)
        turned = monotone & ((coefficients[0] < 0) != (coefficients[-1] < 0))
        if turned.any():
            cells.append(cell[turned])
            places.append(begin[turned] + part * _roots(coefficients[:, turned]))
        rest = ~monotone
        if not rest.any():
            break
        if halving == _HALVINGS:
            unsure[cell[rest]] = True
            break
        halves = _HALVES @ coefficients[:, rest]
        left, right = np.split(halves, 2)
        right[0] = left[-1]
        coefficients = np.hstack([left, right])
        part /= 2
        begin = np.concatenate([begin[rest], begin[rest] + part])
        cell, error, margin = (np.tile(x[rest], 2) for x in (cell, error, margin))
    return (np.concatenate(cells), np.concatenate(places)), unsure


def _roots(coefficients: Doubles) -> Doubles:
    """The zeros of monotone polynomials that change their sign; nan where one is not found."""
    powers = _POWERS @ coefficients
    place = coefficients[0] / (coefficients[0] - coefficients[-1])
    for _ in range(_ROUNDS):
        value, slope = powers[-1], np.zeros_like(place)
        for power in powers[-2::-1]:
            slope = slope * place + value
            value = value * place + power
        before, place = place, np.clip(place - value / slope, 0.0, 1.0)
    return np.where(np.abs(place - before) < _KEPT, place, np.nan)

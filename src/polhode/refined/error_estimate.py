"""How far off a refined run is: what each interval adds, carried to the output times.

An error made in interval n reaches the time t times Lambda_{n+1}, the derivative of the state at t
by the state at the interval's end; Lambda_n = Lambda_{n+1} Phi_n, so one pass backwards tells them
all.  Three parts are added: what the last correction left, what collocation neglects, and rounding,
of which only the squares add up.  kappa(t) = |Lambda_0|, largest row sum.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from polhode.numbers.rows import Doubles

#: Of the ends' error to the square of the stages' last Legendre coefficients: measured 1e-6 to
#: 1e-5 over all the motions of the tests.
DISCRETISATION = 1e-4

#: Beyond it the product of the transitions, in double, says nothing any more.
LARGEST_KAPPA = 1e14

_MOST = 32  # outputs that have an estimate of their own


@dataclass(frozen=True, eq=False)
class Stretch:
    """Successive intervals: transitions (K, 6, 6) in the scene's unit of time, errors ``made``
    (K,) in the base's own, in which w is ``scale`` times smaller."""

    transitions: Doubles
    made: Doubles
    scale: float


@dataclass(frozen=True, eq=False)
class Side:
    """The interval to an output time, from the edge of that index, counted over the whole run."""

    edge: int
    transition: Doubles
    made: float
    scale: float


class Estimate(NamedTuple):
    """At each output: the errors of w (scene's unit) and gamma, (C, 2), and kappa, (C,).

    Errors are infinite where kappa is too large for any estimate.
    """

    errors: Doubles
    kappa: Doubles


def made(unfinished: Doubles, tails: Doubles) -> Doubles:
    """The error that an interval adds, but for rounding."""
    return unfinished + DISCRETISATION * tails * tails


def estimate(stretches: Sequence[Stretch], sides: Sequence[Side], rounding: float) -> Estimate:
    """Of at most 32 outputs; another one takes the larger of its neighbours'."""
    count = len(sides)
    chosen = sorted({round(i) for i in np.linspace(0, count - 1, min(count, _MOST))})
    some = _estimate(stretches, [sides[i] for i in chosen], rounding)
    above = np.searchsorted(chosen, np.arange(count))
    exact = np.array(chosen)[above] == np.arange(count)
    below = np.where(exact, above, above - 1)
    return Estimate(
        np.maximum(some.errors[above], some.errors[below]),
        np.maximum(some.kappa[above], some.kappa[below]),
    )


def _estimate(stretches: Sequence[Stretch], sides: Sequence[Side], rounding: float) -> Estimate:
    count = len(sides)
    sums, squares = np.zeros((count, 2)), np.zeros((count, 2))
    carried = np.zeros((count, 6, 6))
    for c, side in enumerate(sides):
        own = _reach(np.eye(6), side.scale)
        sums[c], squares[c] = own * side.made, own * own
    first = sum(len(stretch.made) for stretch in stretches)
    begun = count  # outputs from here on have been met
    begun = _begin(sides, begun, first, carried)
    for stretch in reversed(stretches):
        size = len(stretch.made)
        first -= size
        kept = np.zeros((size, count, 6, 6))  # Lambda at each interval's end
        for n in range(size - 1, -1, -1):
            begun = _begin(sides, begun, first + n + 1, carried)
            kept[n, begun:] = carried[begun:]
            np.matmul(kept[n, begun:], stretch.transitions[n], out=carried[begun:])
        reach = _reach(kept, stretch.scale)
        sums += np.einsum("nci,n->ci", reach, stretch.made)
        squares += (reach * reach).sum(axis=0)
    _begin(sides, begun, 0, carried)
    kappa = np.abs(carried).sum(axis=-1).max(axis=-1)
    errors = sums + rounding * np.sqrt(squares)
    errors[~(kappa < LARGEST_KAPPA)] = np.inf
    return Estimate(errors, kappa)


def _begin(sides: Sequence[Side], begun: int, edge: int, carried: Doubles) -> int:
    """Enter the outputs whose side begins at this edge or later; the first one that is in."""
    while begun and sides[begun - 1].edge >= edge:
        begun -= 1
        carried[begun] = sides[begun].transition
    return begun


def _reach(carried: Doubles, scale: float) -> Doubles:
    """What an error of size 1, in a unit in which w is ``scale`` times smaller, becomes: w, gamma.

    ``carried``: (..., 6, 6); the result (..., 2).
    """
    weights = np.array([scale] * 3 + [1.0] * 3)
    rows = np.abs(carried) @ weights
    return np.stack([rows[..., :3].max(axis=-1), rows[..., 3:].max(axis=-1)], axis=-1)

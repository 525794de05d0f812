"""Drift of the first integrals of all members of a sweep at once.

What :func:`polhode.equations.integrals.drift` is for one trajectory: relative departures from the
exact member's values.  In pairs of doubles (:mod:`polhode.numbers.double_double`), which hold far
more than the states do.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from polhode.equations.integrals import (
    AREA,
    ENERGY,
    KOVALEVSKAYA,
    LENGTH,
    MOMENTUM,
    NEAR_REST,
    SPIN,
    Drift,
    FirstIntegrals,
    coefficients,
    first_integrals,
)
from polhode.motion.frame import Frame
from polhode.numbers.double_double import Pairs, pairs, sqrt
from polhode.numbers.exact import Irrational, sign
from polhode.numbers.rationals import Rationals
from polhode.numbers.rows import Doubles
from polhode.runs.sweep.columns import blocks

if TYPE_CHECKING:
    from polhode.numbers.rows import Stack
    from polhode.scenes.variation.sweep_columns import Block, Column, Vector
    from polhode.scenes.variation.sweep_scenes import Members


def drifts(members: Members, states: Stack, one: Callable[[int], Drift]) -> Doubles:
    """Largest drift of h, f, |gamma|² and the fourth of each member, shape (members, 4).

    nan where there is none, or the member has no state.  ``states``: (members, times, columns);
    ``one``: the drift of a member that the columns do not hold.
    """
    drift = np.full((len(members), 4), np.nan)
    there = states[:, :, 0] == states[:, :, 0]
    for given in blocks(members):
        block, unit = given.exact(), not given.arrays
        here = slice(block.first, block.last)
        columns = states.dtype != object and block.axes.trivial and not _irrational(block)
        alone = block.left.copy() if columns else np.ones(len(block), dtype=bool)
        for which in _alike(block, ~alone) if not alone.all() else []:
            at = block.first + which
            with np.errstate(all="ignore"):
                member = members[block.first + int(which[0])]
                known = first_integrals(Frame.of(member).inside(member))
                try:
                    rows = _block_drifts(known, block, which, states[at], there[at], unit)
                except OverflowError:  # numbers beyond doubles: exactly, one by one
                    alone[which] = True
                    continue
            drift[at, : rows.shape[1]] = rows
        for k in np.flatnonzero(alone & there[here].any(axis=1)):
            told = one(block.first + int(k))
            drift[block.first + k] = [np.nan if x is None else x for x in told]
    if states.shape[2] == 3:  # h and, if there is one, the fourth
        drift[:, 3] = np.where(np.isnan(drift[:, 3]), drift[:, 1], drift[:, 3])
        drift[:, 1] = np.nan
    return drift


def _irrational(block: Block) -> bool:
    """Whether members have an irrational number in common: with columns it has no arithmetic."""
    numbers = (*block.moments, *block.torque, *block.omega, *(block.gamma or ()))
    return any(isinstance(x, Irrational) for x in numbers)


def _alike(block: Block, which: npt.NDArray[np.bool_]) -> list[npt.NDArray[np.int64]]:
    """The members in sets whose bodies are classical tops of one kind and axis, by exact tests."""
    (a, b, c), torque = block.moments, block.torque
    tests = [_is_zero(x) for x in torque]
    for x, y in ((a, b), (b, c), (c, a)):
        tests += [_is_zero(x - y)]
        tests += [_is_zero(n * s - t) for n in (2, 4) for s, t in ((x, y), (y, x))]
    if block.gamma is not None:
        area = [
            i * (w * g) for i, w, g in zip(block.moments, block.omega, block.gamma, strict=True)
        ]
        tests.append(_is_zero(area[0] + area[1] + area[2]))
    bits = np.stack(np.broadcast_arrays(np.zeros(len(block), dtype=bool), *tests), axis=1)
    members = np.flatnonzero(which)
    if not len(members):
        return []
    _, kind = np.unique(np.packbits(bits[members], axis=1), axis=0, return_inverse=True)
    return [members[kind.ravel() == n] for n in range(int(kind.max()) + 1)]


def _is_zero(x: Column) -> npt.NDArray[np.bool_] | bool:
    return (x.sign if isinstance(x, Rationals) else sign(x)) == 0


def _block_drifts(
    known: FirstIntegrals,
    block: Block,
    which: npt.NDArray[np.int64],
    states: Stack,
    there: npt.NDArray[np.bool_],
    unit: bool,
) -> Doubles:
    """The drifts of members that have the same integrals, columns in the integrals' order.

    ``unit``: whether gamma is of length 1; else it is divided by its length, as exact members are.
    """
    moments, torque, omega = (_pairs(x, which) for x in (block.moments, block.torque, block.omega))
    gamma = [] if block.gamma is None else _pairs(block.gamma, which)
    if gamma and not unit:
        length = sqrt(gamma[0] * gamma[0] + gamma[1] * gamma[1] + gamma[2] * gamma[2])
        gamma = [g / length for g in gamma]
    largest = _largest(moments)
    k = coefficients(moments, torque, largest, known.onto[-1], known.order, sqrt)
    start = known.values([*omega, *gamma], k, Pairs(0.0))
    wide = states.astype(np.float64)
    columns = [
        Pairs(wide[:, :, i], (states[:, :, i] - wide[:, :, i]).astype(np.float64))
        for i in range(states.shape[2])
    ]
    values = known.values(columns, k, Pairs(0.0))
    measures = _measures(known, moments, torque, omega, k)
    drift = [
        np.where(there, np.abs((value - target).hi) / measure, -np.inf).max(axis=1)
        for value, target, measure in zip(values, start, measures, strict=True)
    ]
    told = np.stack(drift, axis=1)
    told[~there.any(axis=1)] = np.nan
    return told


def _pairs(vector: Vector, which: npt.NDArray[np.int64]) -> list[Pairs]:
    """Three columns' numbers of some members, shape (members, 1)."""

    def column(x: Column) -> Pairs:
        if not isinstance(x, Rationals):
            return pairs(x)
        some = pairs(x[which])
        return Pairs(some.hi[:, None], some.lo[:, None])

    return [column(x) for x in vector]


def _largest(values: list[Pairs]) -> Pairs:
    best = values[0]
    for x in values[1:]:
        more = (x - best).hi > 0
        best = Pairs(np.where(more, x.hi, best.hi), np.where(more, x.lo, best.lo))
    return best


def _measures(
    known: FirstIntegrals,
    moments: list[Pairs],
    torque: list[Pairs],
    omega: list[Pairs],
    k: dict[str, Pairs],
) -> list[Doubles | float]:
    """What each drift is relative to, see :class:`polhode.equations.integrals.Drift`."""
    inertia, w, moment = ([x.hi for x in vector] for vector in (moments, omega, torque))
    largest = np.maximum.reduce(np.broadcast_arrays(*inertia))
    kinetic = sum(i * x * x for i, x in zip(inertia, w, strict=True)) / 2
    weight = np.sqrt(sum(x * x for x in moment))
    momentum = np.sqrt(sum((i * x) ** 2 for i, x in zip(inertia, w, strict=True)))
    swing = np.sqrt(weight * largest)
    area = np.where(NEAR_REST * momentum < swing, swing, momentum)
    energy = kinetic + weight
    energy, area = (np.where(x == 0, 1.0, x) for x in (energy, area))
    rate = np.sqrt(np.maximum(sum(x * x for x in w), weight / largest))
    whole: dict[str, Doubles | float] = {
        ENERGY: 2 * energy / largest,
        AREA: area / largest,
        LENGTH: 1.0,
    }
    last = known.onto[-1]
    if last == MOMENTUM:
        whole[last] = whole[AREA] ** 2
    elif last not in whole:
        across = (k.get("c0"), k.get("c1"))
        around = rate**2 + np.sqrt(sum(x.hi**2 for x in across if x is not None))
        whole[last] = {SPIN: rate, KOVALEVSKAYA: around**2}.get(last, rate * around)
    return [whole[name] for name in known.onto]

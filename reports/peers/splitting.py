"""A geometric integrator: Lie–Poisson splitting of the heavy top, composed to order 8.

With G = I w and T = Mg r0 the Hamiltonian is a sum of parts whose motions are known:

    H = |G|²/(2 Ik) + (1/Ii - 1/Ik) Gi²/2 + (1/Ij - 1/Ik) Gj²/2 + T·gamma.

The first turns gamma about G, which stays; the next two turn G and gamma about an axis of the body;
the last adds h gamma × T to G.  Axis k is that of the middle moment: a symmetric body has one turn
less, and its free motion is exact.  Every part keeps the Poisson structure and with it |gamma|² and
f = G·gamma; h swings about its value.  McLachlan 1993, Touma & Wisdom 1994, Reich 1994.  A step is
a symmetric composition of leapfrogs: order 8 with fifteen, the weights of Rein & Tamayo's JANUS,
2017.

The step is fixed, at most tol^(1/order) over the larger of |w| at the start and the square root of
|T| over the least moment.
``order compensated``: increments are added to the state with their rounding carried along.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numba
import numpy as np

from peers.field import Array, Run, Top

ORDER = 8
#: Weights of the leapfrogs of a step, up to the middle one.
WEIGHTS = (
    *(0.74167036435061295345, -0.40910082580003159400, 0.19075471029623837995),
    *(-0.57386247111608226666, 0.29906418130365592384, 0.33462491824529818378),
    *(0.31529309239676659663, -0.79688793935291635402),
)


def prepared(present: Sequence[bool], method: str) -> Run:
    """The steps and the loop over the times in compiled functions.

    ``present``: unused, the parts that vanish are left out as the steps are made.
    """
    weights, carry = np.array([*WEIGHTS, *WEIGHTS[-2::-1]]), method == "8 compensated"

    def run(top: Top, start: Array, times: Array, tol: float) -> Array:
        return along(top, start, times, weights, tol ** (1 / ORDER), carry)

    return run


# --- steps ----------------------------------------------------------------------------------------
#
# Compiled by numba, whose disk cache is used.


@numba.njit(cache=True)
def advance(
    y: Array, lost: Array, parts: Array, weights: Array, length: float, count: int, carry: bool
) -> None:
    """Take ``count`` steps of ``length`` from the state y = (G, gamma), which is changed.

    ``parts``: the two axes of the body that are turned about, 1/Ii - 1/Ik of each, 1/Ik, and T.
    ``lost``: what the sums have left out so far, used where ``carry``.
    """
    axes, turns, spin, torque = parts
    heavy = torque[0] != 0.0 or torque[1] != 0.0 or torque[2] != 0.0
    for step in range(count):
        # weight of the leapfrog whose last kick is still to be made
        before = weights[-1] if step > 0 else 0.0
        for weight in weights:
            h = weight * length
            if heavy:
                _kick(y, lost, torque, 0.5 * (before + weight) * length, carry)
            before = weight
            _about_momentum(y, lost, spin * h, carry)
            if turns[0] != 0.0:
                if turns[1] != 0.0:
                    _about_axis(y, lost, axes[0], 0.5 * h * turns[0], carry)
                    _about_axis(y, lost, axes[1], h * turns[1], carry)
                    _about_axis(y, lost, axes[0], 0.5 * h * turns[0], carry)
                else:
                    _about_axis(y, lost, axes[0], h * turns[0], carry)
            elif turns[1] != 0.0:
                _about_axis(y, lost, axes[1], h * turns[1], carry)
    if heavy:
        _kick(y, lost, torque, 0.5 * weights[-1] * length, carry)


@numba.njit(cache=True)
def along(
    top: Top, start: Array, times: Array, weights: Array, fraction: float, carry: bool
) -> Array:
    """States (w, gamma) at the times from a start; ``fraction``: of a radian, the longest step."""
    moments, torque = top.moments, top.torque
    i, k, j = np.argsort(moments)
    turns = np.array([1 / moments[i] - 1 / moments[k], 1 / moments[j] - 1 / moments[k]])
    speed = math.sqrt(start[0] ** 2 + start[1] ** 2 + start[2] ** 2)
    pull = math.sqrt(torque[0] ** 2 + torque[1] ** 2 + torque[2] ** 2)
    step = fraction / max(speed, math.sqrt(pull / moments[i]))
    parts = np.array([i, j]), turns, 1 / moments[k], torque
    lost, y = np.zeros(6), start.copy()
    y[:3] *= moments
    rows = np.empty((len(times), 6))
    now = 0.0
    for n, time in enumerate(times):
        count = math.ceil(abs(time - now) / step)
        if count:
            length = (time - now) / count
            advance(y, lost, parts, weights, length, count, carry)
        rows[n, :3], rows[n, 3:] = y[:3] / moments, y[3:]
        now = time
    return rows


@numba.njit(cache=True)
def _add(y: Array, lost: Array, n: int, increment: float, carry: bool) -> None:
    """y[n] += increment; with ``carry`` the rounding of every sum goes into the next.  Knuth."""
    if not carry:
        y[n] += increment
        return
    more = increment + lost[n]
    total = y[n] + more
    added = total - y[n]
    lost[n] = (y[n] - (total - added)) + (more - added)
    y[n] = total


@numba.njit(cache=True)
def _kick(y: Array, lost: Array, torque: Array, h: float, carry: bool) -> None:
    """G' = gamma × T."""
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        _add(y, lost, i, h * (y[3 + j] * torque[k] - y[3 + k] * torque[j]), carry)


@numba.njit(cache=True)
def _about_axis(y: Array, lost: Array, i: int, h: float, carry: bool) -> None:
    """G' = G × w, gamma' = gamma × w with w = Gi along the axis i, over a time h."""
    j, k = (i + 1) % 3, (i + 2) % 3
    half = 0.5 * h * y[i]
    sine, cosine = math.sin(half), math.cos(half)
    s, v = 2.0 * sine * cosine, -2.0 * sine * sine  # sin, cos - 1 of the angle
    for n in (0, 3):
        b, c = y[n + j], y[n + k]
        _add(y, lost, n + j, s * c + v * b, carry)
        _add(y, lost, n + k, v * c - s * b, carry)


@numba.njit(cache=True)
def _about_momentum(y: Array, lost: Array, h: float, carry: bool) -> None:
    """gamma' = gamma × G over a time h; G stays."""
    square = y[0] * y[0] + y[1] * y[1] + y[2] * y[2]
    if square == 0.0:
        return
    size = math.sqrt(square)
    half = 0.5 * h * size
    sine, cosine = math.sin(half), math.cos(half)
    s, v = 2.0 * sine * cosine / size, 2.0 * sine * sine / square
    a = y[4] * y[2] - y[5] * y[1]
    b = y[5] * y[0] - y[3] * y[2]
    c = y[3] * y[1] - y[4] * y[0]
    _add(y, lost, 3, s * a + v * (b * y[2] - c * y[1]), carry)
    _add(y, lost, 4, s * b + v * (c * y[0] - a * y[2]), carry)
    _add(y, lost, 5, s * c + v * (a * y[1] - b * y[0]), carry)

"""The steps of :mod:`peers.splitting`, compiled by numba; its disk cache is used."""

from __future__ import annotations

import math

import numba
import numpy as np

from peers.field import Array


@numba.njit(cache=True)
def advance(
    y: Array,
    lost: Array,
    axes: Array,
    turns: Array,
    spin: float,
    torque: Array,
    weights: Array,
    length: float,
    count: int,
    carry: bool,
) -> None:
    """Take ``count`` steps of ``length`` from the state y = (G, gamma), which is changed.

    ``axes``, ``turns``: the two axes of the body that are turned about, and 1/Ii - 1/Ik of each;
    ``spin``: 1/Ik.  ``lost``: what the sums have left out so far, used where ``carry``.
    """
    heavy = torque[0] != 0.0 or torque[1] != 0.0 or torque[2] != 0.0
    for step in range(count):
        before = 0.0  # weight of the leapfrog whose last kick is still to be made
        if step > 0:
            before = weights[-1]
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
    start: Array,
    times: Array,
    moments: Array,
    torque: Array,
    weights: Array,
    fraction: float,
    carry: bool,
) -> Array:
    """States (w, gamma) at the times from a start; ``fraction``: of a radian, the longest step."""
    i, k, j = np.argsort(moments)
    turns = np.array([1 / moments[i] - 1 / moments[k], 1 / moments[j] - 1 / moments[k]])
    speed = math.sqrt(start[0] ** 2 + start[1] ** 2 + start[2] ** 2)
    pull = math.sqrt(torque[0] ** 2 + torque[1] ** 2 + torque[2] ** 2)
    step = fraction / max(speed, math.sqrt(pull / moments[i]))
    axes, lost, y = np.array([i, j]), np.zeros(6), start.copy()
    y[:3] *= moments
    rows = np.empty((len(times), 6))
    now = 0.0
    for n, time in enumerate(times):
        count = math.ceil(abs(time - now) / step)
        if count:
            length = (time - now) / count
            advance(*(y, lost, axes, turns, 1 / moments[k], torque, weights, length, count, carry))
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
    taken = total - y[n]
    lost[n] = (y[n] - (total - taken)) + (more - taken)
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

"""Search of homoclinic orbits of a hyperbolic periodic orbit.

Not trusted. Starts on both manifolds, x* + s v with |s| over one factor of the multiplier, are
followed to the maxima of the height of the centre of mass; neighbours on one manifold make
segments there, and two segments of different manifolds that pass through each other
transversally are a guess. It is corrected by Newton's method in log |s_u|, log |s_s| and the
time, and moved towards the orbit by powers of the multiplier.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.enclosures.fixed_point_problem import Motion
from polhode.equations.terms import LAYERS, LEFT, RIGHT, layered
from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import Doubles
from polhode.numbers.vectors import cross

# --- lanes ----------------------------------------------------------------------------------------
#
# Many motions at once in double, by Taylor series: guesses for the search.
#
# Not trusted.  States are (6, n); where a motion is wanted backward, w has its sign changed, which
# turns the time round.


Whole = npt.NDArray[np.intp]

_DEGREE = 20
_SHORTER = 0.15  # of the radius of convergence that the last coefficients tell
_ROUGH, _ROUGHLY = 12, 0.22  # degree and step where guesses are looked for: right to 1e-8
_LONGEST_STEP = 1.0
_HALVED = 24  # times, of half a step in which a maximum lies
_BACK = np.array([-1.0, -1.0, -1.0, 1.0, 1.0, 1.0])[:, None]


class Crossings(NamedTuple):
    """Where lanes met the section: lane, count on it, time, state (6, m)."""

    lane: Whole
    number: Whole
    time: Doubles
    state: Doubles


@dataclass(frozen=True)
class Lanes:
    """A body's motions in the proof's unit of time."""

    constants: tuple[float, ...]
    moments: Doubles
    torque: Doubles

    @classmethod
    def of(cls, motion: Motion) -> Lanes:
        """Those of an exact motion's body."""
        constants = tuple(to_double(x) for x in motion.constants)
        moments, torque = ([to_double(x) for x in row] for row in (motion.moments, motion.torque))
        return cls(constants, np.array(moments), np.array(torque))

    def series(self, states: Doubles, degree: int = _DEGREE) -> Doubles:
        """Taylor coefficients by the time, (degree + 1, 6, n)."""
        of_layers = [layer.coefficients(self.constants) for layer in LAYERS]
        coefficients = [None if c is None else np.array(c)[:, None] for c in of_layers]
        series = np.zeros((degree + 1, *states.shape))
        left = np.zeros((degree + 1, len(LEFT), states.shape[1]))
        right = np.zeros_like(left)
        series[0] = states
        for k in range(degree):
            left[k], right[k] = series[k][LEFT], series[k][RIGHT]
            products = np.einsum("kin,kin->in", left[: k + 1], right[k::-1])
            series[k + 1, :3], series[k + 1, 3:] = layered(products, series[k], coefficients)
            series[k + 1] /= k + 1
        return series

    def field(self, states: Doubles) -> Doubles:
        """The right-hand sides, (6, n)."""
        return np.asarray(self.series(states, 1)[1])

    def gradients(self, state: Doubles) -> Doubles:
        """Those of energy, vertical momentum and |gamma|^2, each a constant times it: (3, 6)."""
        w, gamma = state[:3], state[3:]
        momentum, scale = self.moments * w, max(self.moments)
        energy = np.concatenate([momentum, self.torque]) / scale
        area = np.concatenate([self.moments * gamma, momentum]) / scale
        return np.array([energy, area, [*np.zeros(3), *gamma]])

    def after(self, states: Doubles, times: Doubles) -> Doubles:
        """The states after times of their own, of any sign."""
        signs = np.where(times < 0.0, -1.0, 1.0)
        turn = np.where(signs < 0.0, _BACK, 1.0)
        now, left = states * turn, np.abs(times)
        while np.any(left > 0.0):
            series = self.series(now)
            step = np.minimum(left, _step(series))
            now = _value(series, step)
            left = left - step
        return np.asarray(now * turn)

    def crossings(self, states: Doubles, span: float) -> Crossings:
        """Maxima of the height of the centre of mass within a time."""
        lanes = np.arange(states.shape[1])
        now, time = states.copy(), np.zeros(states.shape[1])
        counts = np.zeros(states.shape[1], dtype=np.intp)
        crossings: list[tuple[Whole, Whole, Doubles, Doubles]] = []
        while np.any(time < span):
            series = self.series(now, _ROUGH)
            step = np.minimum(span - time, _step(series, _ROUGHLY))
            begin = self._rise(now)
            for part in (0.5, 1.0):
                end = self._rise(_value(series, part * step))
                met = np.nonzero((begin > 0.0) & (end <= 0.0))[0]
                begin = end
                if not met.size:
                    continue
                low, high = (part - 0.5) * step[met], part * step[met]
                some = series[:, :, met]
                for _ in range(_HALVED):
                    middle = (low + high) / 2
                    up = self._rise(_value(some, middle)) > 0.0
                    low, high = np.where(up, middle, low), np.where(up, high, middle)
                crossings.append((lanes[met], counts[met], time[met] + low, _value(some, low)))
                counts[met] += 1
            now, time = _value(series, step), time + step
        if not crossings:
            empty = np.zeros(0, dtype=np.intp)
            return Crossings(empty, empty, np.zeros(0), np.zeros((6, 0)))
        return Crossings(
            np.concatenate([row[0] for row in crossings]),
            np.concatenate([row[1] for row in crossings]),
            np.concatenate([row[2] for row in crossings]),
            np.concatenate([row[3] for row in crossings], axis=1),
        )

    def derivative(self, states: Doubles, times: Doubles) -> Doubles:
        """The derivatives of the flow, (n, 6, 6), by central differences."""
        count, off = states.shape[1], 1e-6
        steps = off * np.hstack([np.eye(6), -np.eye(6)])
        many = (states[:, :, None] + steps[:, None, :]).reshape(6, -1)
        ends = self.after(many, np.repeat(times, 12)).reshape(6, count, 12)
        return np.asarray((ends[..., :6] - ends[..., 6:]).transpose(1, 0, 2) / (2 * off))

    def _rise(self, states: Doubles) -> Doubles:
        """The rate of the height."""
        rates = cross(states[3:], states[:3])
        return np.asarray(sum(k * rate for k, rate in zip(self.torque, rates, strict=True)))


def backward(states: Doubles) -> Doubles:
    """The states whose motions are these run backward."""
    return np.asarray(states * _BACK)


def _step(series: Doubles, part: float = _SHORTER) -> Doubles:
    """Lengths of steps, a part of the radius of convergence."""
    last = np.maximum(np.max(np.abs(series[-1]), axis=0), 1e-300)
    before = np.maximum(np.max(np.abs(series[-2]), axis=0), 1e-300)
    degree = series.shape[0] - 1
    radius = np.minimum(last ** (-1.0 / degree), before ** (-1.0 / (degree - 1)))
    return np.asarray(np.minimum(_LONGEST_STEP, part * radius))


def _value(series: Doubles, step: Doubles) -> Doubles:
    total = series[-1]
    for row in series[-2::-1]:
        total = total * step + row
    return np.asarray(total)


# --- homoclinic -----------------------------------------------------------------------------------


LANES = 300  # a branch
_SIZE = 1e-4  # of the manifolds' first starts
_MORE = 3.0  # periods beyond those in which they have grown to 1
_LONGEST = 0.15  # a segment
_SINE = 0.03  # between segments, at least
_CLOSE = 0.05  # guesses that differ by less, in periods and in powers, are one
_APART = 0.15  # points of two segments that meet
_NEWTON = 12
_SINGULAR = 1e-4
_SAME = 1e-3


class Saddle(NamedTuple):
    """A hyperbolic periodic orbit: x*, T, the multiplier |mu| > 1, both directions in the plane."""

    point: Doubles
    period: float
    multiplier: float
    unstable: Doubles
    stable: Doubles
    plane: Doubles


class Homoclinic(NamedTuple):
    """phi_ahead(x* + unstable v_u) = phi_-behind(x* + stable v_s); ``angle``: smallest singular."""

    unstable: float
    stable: float
    ahead: float
    behind: float
    angle: float

    @property
    def time(self) -> float:
        """From the one to the other."""
        return self.ahead + self.behind


def saddle(lanes: Lanes, point: Doubles, period: float) -> Saddle | None:
    """The directions at a hyperbolic orbit; None where double tells none."""
    derivative = lanes.derivative(point[:, None], np.array([period]))[0]
    values, vectors = np.linalg.eig(derivative)
    order = np.argsort(np.abs(values))
    first, last = order[0], order[-1]
    if abs(values[last].imag) > 1e-6 or abs(values[last]) < 1.0 + 1e-3:
        return None
    rates = lanes.field(point[:, None])[:, 0]
    pair = []
    for i in (last, first):
        v = vectors[:, i].real
        v = v - rates * (rates @ v) / (rates @ rates)
        # The largest component is +1: the library of linear algebra chooses no sign.
        pair.append(v / v[np.argmax(np.abs(v))])
    multiplier = float(values[last].real)
    return Saddle(point, period, multiplier, pair[0], pair[1], rates)


def search(lanes: Lanes, at: Saddle) -> Iterator[Homoclinic]:
    """Transversal homoclinic orbits, one of each class, short ones first."""
    guesses: list[Homoclinic] = []
    for guess in sorted(_guesses(lanes, at), key=lambda x: _length(at, x)):
        if not any(_same(at, guess, earlier, _CLOSE) for earlier in guesses):
            guesses.append(guess)
    orbits: list[Homoclinic] = []
    for guess in guesses:
        orbit = corrected(lanes, at, guess)
        if orbit is not None and not any(_same(at, orbit, earlier, _SAME) for earlier in orbits):
            orbits.append(orbit)
            yield orbit


def manifolds(lanes: Lanes, at: Saddle) -> tuple[Crossings, Crossings, Doubles]:
    """Where the unstable and the stable manifold meet the section; the lanes' s.

    States of the stable one are those of the motion run backward.
    """
    factor = abs(at.multiplier)
    grown = at.period * (math.log(1.0 / _SIZE) / math.log(factor) - 1.0)  # to a size of 1
    span = grown + at.period * (2.0 + _MORE)
    sizes = _SIZE * factor ** (np.arange(LANES + 1) / LANES)
    both = np.concatenate([sizes, -sizes])
    out = at.point[:, None] + at.unstable[:, None] * both
    into = backward(at.point[:, None] + at.stable[:, None] * both)
    ahead = lanes.crossings(np.hstack([out, into]), span)
    first, late = ahead.lane < len(both), ahead.time > grown
    return _part(ahead, first & late, 0), _part(ahead, ~first & late, len(both)), both


def _guesses(lanes: Lanes, at: Saddle) -> list[Homoclinic]:
    out, into, both = manifolds(lanes, at)
    u, s = _segments(out, both), _segments(into, both)
    s = _Segments(backward(s.begin), backward(s.end), *s[2:])
    guesses = []
    for i, j, a, b, angle in _meetings(u, s):
        su = u.sizes[0, i] * (u.sizes[1, i] / u.sizes[0, i]) ** a
        ss = s.sizes[0, j] * (s.sizes[1, j] / s.sizes[0, j]) ** b
        tu = u.times[0, i] + a * (u.times[1, i] - u.times[0, i])
        ts = s.times[0, j] + b * (s.times[1, j] - s.times[0, j])
        guesses.append(Homoclinic(float(su), float(ss), float(tu), float(ts), float(angle)))
    return guesses


class _Segments(NamedTuple):
    begin: Doubles
    end: Doubles
    sizes: Doubles
    times: Doubles


def _part(of: Crossings, which: npt.NDArray[np.bool_], first: int) -> Crossings:
    return Crossings(of.lane[which] - first, of.number[which], of.time[which], of.state[:, which])


def _segments(crossings: Crossings, sizes: Doubles) -> _Segments:
    """Of neighbouring lanes, near each other at the same count."""
    order = np.lexsort((crossings.lane, crossings.number))
    lane, count = crossings.lane[order], crossings.number[order]
    time, state = crossings.time[order], crossings.state[:, order]
    size = sizes[lane]
    near = (lane[1:] == lane[:-1] + 1) & (count[1:] == count[:-1]) & (size[1:] * size[:-1] > 0)
    near &= np.max(np.abs(state[:, 1:] - state[:, :-1]), axis=0) < _LONGEST
    k = np.nonzero(near)[0]
    return _Segments(
        state[:, k], state[:, k + 1], size[np.array([k, k + 1])], time[np.array([k, k + 1])]
    )


def _meetings(u: _Segments, s: _Segments) -> Iterator[tuple[int, int, float, float, float]]:
    """Pairs of segments that pass through each other, and where."""
    if not u.begin.size or not s.begin.size:
        return
    cell = _LONGEST
    base = np.array([1, 1 << 20])
    key = np.floor((s.begin[[0, 3]] + s.end[[0, 3]]) / (2 * cell)).astype(np.int64).T @ base
    order = np.argsort(key)
    ranked = key[order]
    middles = np.floor((u.begin[[0, 3]] + u.end[[0, 3]]) / (2 * cell)).astype(np.int64)
    for dx in (-1, 0, 1):
        for dy in (-1, 0, 1):
            places = (middles + np.array([[dx], [dy]])).T @ base
            low = np.searchsorted(ranked, places, "left")
            high = np.searchsorted(ranked, places, "right")
            many = high - low
            i = np.repeat(np.arange(len(many)), many)
            start = np.repeat(low - np.concatenate([[0], np.cumsum(many)[:-1]]), many)
            j = order[start + np.arange(len(i))]
            for k in range(0, len(i), 500_000):
                yield from _through(u, s, *_near(u, s, i[k : k + 500_000], j[k : k + 500_000]))


def _near(u: _Segments, s: _Segments, i: Whole, j: Whole) -> tuple[Whole, Whole]:
    """Those pairs whose other components are near as well."""
    for row in (1, 2, 4, 5):
        near = np.abs(u.begin[row, i] - s.begin[row, j]) < 2 * _APART
        i, j = i[near], j[near]
    return i, j


def _through(
    u: _Segments, s: _Segments, i: Whole, j: Whole
) -> Iterator[tuple[int, int, float, float, float]]:
    p, q = u.end[:, i] - u.begin[:, i], s.end[:, j] - s.begin[:, j]
    gap = s.begin[:, j] - u.begin[:, i]
    pp, qq, pq = (p * p).sum(0), (q * q).sum(0), (p * q).sum(0)
    gp, gq = (gap * p).sum(0), (gap * q).sum(0)
    determinant = pp * qq - pq * pq
    with np.errstate(divide="ignore", invalid="ignore"):
        a = (gp * qq - gq * pq) / determinant
        b = (gp * pq - gq * pp) / determinant
        sine = np.sqrt(np.maximum(0.0, determinant / (pp * qq)))
        off = np.linalg.norm(gap - a * p + b * q, axis=0)
        inside = (a >= 0) & (a <= 1) & (b >= 0) & (b <= 1) & (sine > _SINE)
        inside &= off < 0.1 * (np.sqrt(pp) + np.sqrt(qq))
    for n in np.nonzero(inside)[0]:
        yield int(i[n]), int(j[n]), float(a[n]), float(b[n]), float(sine[n])


def corrected(lanes: Lanes, at: Saddle, near: Homoclinic) -> Homoclinic | None:
    """Newton's method; None where it does not converge to a transversal one."""
    su, ss, tu = near.unstable, near.stable, near.ahead
    off = 1e-5
    last, angle = math.inf, 0.0
    for _ in range(_NEWTON):
        factors = np.array([1.0, 1.0 + off, 1.0 - off])
        starts = np.hstack(
            [
                at.point[:, None] + at.unstable[:, None] * su * factors,
                at.point[:, None] + at.stable[:, None] * ss * factors,
            ]
        )
        ends = lanes.after(starts, np.array([tu] * 3 + [-near.behind] * 3))
        miss = ends[:, 0] - ends[:, 3]
        slope = np.column_stack(
            [
                (ends[:, 1] - ends[:, 2]) / (2 * off),
                -(ends[:, 4] - ends[:, 5]) / (2 * off),
                lanes.field(ends[:, :1])[:, 0],
            ]
        )
        if not np.all(np.isfinite(slope)):
            return None
        sizes = np.linalg.norm(slope, axis=0)
        angle = float(np.linalg.svd(slope / np.maximum(sizes, 1e-300))[1][-1])
        step = np.linalg.lstsq(slope, -miss, rcond=None)[0]
        size = float(np.max(np.abs(step)))
        if size > 1.0:
            return None
        su, ss, tu = su * math.exp(step[0]), ss * math.exp(step[1]), tu + float(step[2])
        if size < 1e-9 or (size < 1e-6 and size > last / 2):
            good = angle > _SINGULAR and float(np.max(np.abs(miss))) < 1e-4
            return Homoclinic(su, ss, tu, near.behind, angle) if good else None
        last = size
    return None


def _length(at: Saddle, x: Homoclinic) -> float:
    """The time of an orbit from unit size to unit size: the same wherever it is begun."""
    rate = math.log(abs(at.multiplier)) / at.period
    return x.time + math.log(abs(x.unstable * x.stable)) / rate


def _same(at: Saddle, first: Homoclinic, second: Homoclinic, near: float) -> bool:
    """Whether two are one orbit, begun elsewhere."""
    if first.unstable * second.unstable < 0 < at.multiplier:
        return False
    shift = math.log(abs(first.unstable / second.unstable)) / math.log(abs(at.multiplier))
    apart = abs(_length(at, first) - _length(at, second))
    return apart < near * at.period and abs(shift - round(shift)) < near


def towards(at: Saddle, orbit: Homoclinic, size: float) -> tuple[Homoclinic, float]:
    """The same orbit begun and ended so near that chains of that size fit; and their size."""
    factor = abs(at.multiplier)
    begin = (1.0 + min(factor, 4.0)) / 2.0
    m = round(math.log(abs(orbit.unstable) / (begin * size)) / math.log(factor))
    m = max(0, m)
    su = orbit.unstable / at.multiplier**m
    rho = abs(su) / begin
    n = max(0, math.ceil(math.log(abs(orbit.stable) / (0.6 * rho)) / math.log(factor)))
    ss = orbit.stable / at.multiplier**n
    ahead, behind = orbit.ahead + m * at.period, orbit.behind + n * at.period
    return Homoclinic(su, ss, ahead, behind, orbit.angle), rho

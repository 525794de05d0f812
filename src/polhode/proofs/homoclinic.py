"""Search of homoclinic orbits of a hyperbolic periodic orbit.

Not trusted. Starts on both manifolds, x* + s v with |s| over one factor of the multiplier, are
followed to the maxima of the height of the centre of mass; neighbours on one manifold make
segments there, and two segments of different manifolds that pass through each other
transversally are a guess. It is corrected by Newton's method in log |s_u|, log |s_s| and the
time, and moved towards the orbit by powers of the multiplier. All in principal axes and the unit of
time of a :class:`~polhode.dynamics.level_body.LevelBody`, whose flow the engine gives.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from polhode.dynamics.level_body import LevelBody
from polhode.equations.section_functions import HEIGHT, SectionZero
from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import Doubles, Indices, double_array
from polhode.scenes.vocabulary import STATE
from polhode.taylor import event_batches
from polhode.taylor.event_batches import SearchJob, Watched
from polhode.taylor.variations import NotFollowed

LANES = 300  # a branch
_SIZE = 1e-4  # of the manifolds' first starts
_MORE = 3.0  # periods beyond those in which they have grown to 1
_MOST = 1000  # crossings of a lane
_STRETCH = 100.0  # of time between two looks at the lanes
_LONGEST = 0.15  # a segment
_SINE = 0.03  # between segments, at least
_CLOSE = 0.05  # guesses that differ by less, in periods and in powers, are one
_APART = 0.15  # points of two segments that meet
_BLOCK = 256  # segments whose neighbours are looked at at once
_NEWTON = 12
_SINGULAR = 1e-4
_SAME = 1e-3


class Crossings(NamedTuple):
    """Where lanes met the section: lane, count on it, time without its sign, state (6, m)."""

    lane: Indices
    number: Indices
    time: Doubles
    state: Doubles


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


def flow_with_derivative(on: LevelBody, start: Doubles, time: float) -> tuple[Doubles, Doubles]:
    """Where the flow leads in a time of any sign, and its derivative; raises NotFollowed."""
    reached = on.flow.after(start, time)
    assert reached.derivative is not None
    return double_array(reached.state), double_array(reached.derivative)


def saddle(on: LevelBody, point: Doubles, period: float) -> Saddle | None:
    """The directions at a hyperbolic orbit; None where double tells none."""
    values, vectors = np.linalg.eig(flow_with_derivative(on, point, period)[1])
    order = np.argsort(np.abs(values))
    first, last = order[0], order[-1]
    if abs(values[last].imag) > 1e-6 or abs(values[last]) < 1.0 + 1e-3:
        return None
    rates = on.rates(point)
    pair = []
    for i in (last, first):
        v = vectors[:, i].real
        v = v - rates * (rates @ v) / (rates @ rates)
        # The largest component is +1: the library of linear algebra chooses no sign.
        pair.append(v / v[np.argmax(np.abs(v))])
    multiplier = float(values[last].real)
    return Saddle(point, period, multiplier, pair[0], pair[1], rates)


def search(on: LevelBody, at: Saddle) -> Iterator[Homoclinic]:
    """Transversal homoclinic orbits, one of each class, short ones first."""
    guesses: list[Homoclinic] = []
    for guess in sorted(_guesses(on, at), key=lambda x: _length(at, x)):
        if not any(_same(at, guess, earlier, _CLOSE) for earlier in guesses):
            guesses.append(guess)
    orbits: list[Homoclinic] = []
    for guess in guesses:
        orbit = connection_near(on, at, guess)
        if orbit is not None and not any(_same(at, orbit, earlier, _SAME) for earlier in orbits):
            orbits.append(orbit)
            yield orbit


def manifolds(on: LevelBody, at: Saddle) -> tuple[Crossings, Crossings, Doubles]:
    """Where the unstable and the stable manifold meet the section; the lanes' s."""
    factor = abs(at.multiplier)
    grown = at.period * (math.log(1.0 / _SIZE) / math.log(factor) - 1.0)  # to a size of 1
    span = grown + at.period * (2.0 + _MORE)
    sizes = _SIZE * factor ** (np.arange(LANES + 1) / LANES)
    both = np.concatenate([sizes, -sizes])
    out = _crossings(on, at.point + np.outer(both, at.unstable), span, grown)
    into = _crossings(on, at.point + np.outer(both, at.stable), -span, grown)
    return out, into, both


def _crossings(on: LevelBody, starts: Doubles, end: float, late: float) -> Crossings:
    """Maxima of the height of the centre of mass, later than some time, to the end."""
    constants = tuple(map(to_double, on.coefficients.values()))
    (a, b, c), (x, y, z) = (v.tolist() for v in on.relative[:2])
    zero = SectionZero(HEIGHT, (a, b, c), (x, y, z))
    watched = Watched((*on.coefficients,), STATE, zero, constants=constants)
    numbers = np.tile(constants, (len(starts), 1))
    crossed = event_batches.solve(SearchJob(watched, -1, _MOST, end, _STRETCH, numbers, starts))
    times = np.abs(crossed.times)
    lane, number = np.nonzero(times > late)  # nan is not
    return Crossings(lane, number, times[lane, number], crossed.states[lane, number].T)


def _guesses(on: LevelBody, at: Saddle) -> list[Homoclinic]:
    out, into, both = manifolds(on, at)
    u, s = _segments(out, both), _segments(into, both)
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
    order = np.argsort(s.begin[0])
    low, high = (
        np.searchsorted(s.begin[0, order], u.begin[0] + side * 2 * _APART) for side in (-1, 1)
    )
    for k in range(0, u.begin.shape[1], _BLOCK):
        first, many = low[k : k + _BLOCK], (high - low)[k : k + _BLOCK]
        i = np.repeat(np.arange(k, k + len(many)), many)
        j = order[np.arange(len(i)) + np.repeat(first - (np.cumsum(many) - many), many)]
        yield from _through(u, s, *_near(u, s, i, j))


def _near(u: _Segments, s: _Segments, i: Indices, j: Indices) -> tuple[Indices, Indices]:
    """Those pairs whose other components are near as well."""
    for row in range(1, 6):
        near = np.abs(u.begin[row, i] - s.begin[row, j]) < 2 * _APART
        i, j = i[near], j[near]
    return i, j


def _through(
    u: _Segments, s: _Segments, i: Indices, j: Indices
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


def connection_near(on: LevelBody, at: Saddle, near: Homoclinic) -> Homoclinic | None:
    """Newton's method; None where it does not converge to a transversal one."""
    su, ss, tu = near.unstable, near.stable, near.ahead
    last, angle = math.inf, 0.0
    for _ in range(_NEWTON):
        try:
            end, ahead = flow_with_derivative(on, at.point + at.unstable * su, tu)
            met, behind = flow_with_derivative(on, at.point + at.stable * ss, -near.behind)
        except NotFollowed:
            return None
        miss = end - met
        slope = np.column_stack([su * ahead @ at.unstable, -ss * behind @ at.stable, on.rates(end)])
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

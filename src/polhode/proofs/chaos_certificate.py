"""A certificate of proved chaos: charts and sets near a homoclinic orbit, what the checker proves.

Nothing here is believed but the body's and the level's numbers: charts and sets are what
derivatives of the flow foretell, in double.
"""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

import numpy as np
from flint import arb

from polhode.certificates import certificate_file, verify
from polhode.certificates.certificate_file import JsonObject
from polhode.dynamics.level_body import LevelBody
from polhode.motion.frame import Frame
from polhode.numbers.flint_context import ctx
from polhode.numbers.number_types import DOUBLE, Doubles, double_array
from polhode.proofs.homoclinic import Homoclinic, Saddle, flow_with_derivative

# --- certificate ----------------------------------------------------------------------------------


_BITS = 48  # of the polynomials: far finer than the sets
_SCALE = 120  # bits of the charts' numbers
_GROWTH = 1.0  # int |A| of a step: the noise is cubic in its exponential
_TIME_BITS = 64


class Chart(NamedTuple):
    """c, E (6, 2), K (6, 4), a, and eta."""

    centre: Doubles
    wide: Doubles
    deep: Doubles
    plane: Doubles
    eta: float


class Rectangle(NamedTuple):
    """The number of a set's chart, and its sizes."""

    chart: int
    middle: float
    width: float
    height: float


class Guess(NamedTuple):
    """What a proof begins with, in the axes and the unit of time of the surface.

    ``sets``: N0, M1, ..., Mk; ``times``: of each to the next one's plane.
    """

    surface: LevelBody
    saddle: Saddle
    charts: list[Chart]
    sets: list[Rectangle]
    times: list[float]


def guesses(guess: Guess) -> JsonObject:
    """A certificate but for its statement, in the scene's axes and units."""
    on, bits, unit = guess.surface, _BITS + verify.COARSE, float(guess.surface.unit)
    turn = double_array(Frame.of(on.scene).matrix(DOUBLE)).T
    place, back = (np.kron(np.diag([x, 1.0]), turn) for x in (1.0 / unit, unit))
    charts = [
        Chart(place @ x.centre, place @ x.wide, place @ x.deep, back @ x.plane, x.eta)
        for x in guess.charts
    ]
    scene = certificate_file.on_level(on.scene.body, on.h, on.f, bits)
    transits: list[JsonObject] = []
    with ctx.workprec(bits + verify.COARSE):
        for source, time in zip(guess.sets, guess.times, strict=True):
            chart, end = charts[source.chart], Fraction(time * unit)
            start = [arb(x) for x in (chart.centre + chart.wide[:, 0] * source.middle).tolist()]
            steps = certificate_file.steps(scene, start, end, _BITS, _TIME_BITS, growth=_GROWTH)
            *grid, _ = steps._asdict().items()
            transits.append(dict(grid))
    sizes = Rectangle._fields[1:]
    return {
        "format": verify.FORMAT,
        "kind": "chaos",
        "scene": scene,
        "bits": _BITS,
        "scale": _SCALE,
        "charts": [_integers(x) for x in charts],
        "sets": [
            {"chart": x.chart} | {word: _nearest(getattr(x, word)) for word in sizes}
            for x in guess.sets
        ],
        "transits": transits,
    }


def _integers(chart: Chart) -> JsonObject:
    """A chart's numbers as the checker reads them, in rows."""
    return {
        name: [[_nearest(x) for x in row] for row in np.reshape(value, shape).tolist()]
        for (name, value), shape in zip(chart._asdict().items(), verify.CHART.values(), strict=True)
    }


def _nearest(x: float) -> int:
    return int(x * 2.0**_SCALE)  # exact, but for what is below 2^-scale


# --- chain ----------------------------------------------------------------------------------------


ETA = 1e-4
_WIDER, _HIGHER = 0.7, 1.5  # of the image: a next set's width, its height
_LEAST_HEIGHT = 0.25  # of N0's: far above what the checker leaves open, which is of second order


def guess_along(on: LevelBody, at: Saddle, orbit: Homoclinic, size: float) -> Guess:
    """Charts and sets along a homoclinic orbit; ``size``: of N0."""
    count = max(2, round(orbit.time / at.period))
    time = orbit.time / count
    first, last = at.point + at.unstable * orbit.unstable, at.point + at.stable * orbit.stable
    states, slopes = [], []
    for k in range(count):
        early = k * time <= orbit.ahead
        start, since = (first, k * time) if early else (last, k * time - orbit.time)
        states.append(double_array(on.plain_flow.after(start, since).state))
        slopes.append(flow_with_derivative(on, states[-1], time)[1])
    out, into = [at.unstable], [at.stable]
    for k in range(1, count):
        out.append(_flat(on, states[k], slopes[k - 1] @ out[-1]))
    for k in range(count - 1, 0, -1):
        into.append(_flat(on, states[k], double_array(np.linalg.solve(slopes[k], into[-1]))))
    charts = [chart_at(on, at.point, at.unstable, at.stable)]
    for k in range(1, count):
        charts.append(chart_at(on, states[k], out[k], into[-k]))
    home = flow_with_derivative(on, at.point, at.period)[1]
    places = [0, *range(count)]
    maps = [
        _section_map(charts[place], charts[after], slope)
        for place, after, slope in zip(places, [*places[1:], 0], [home, *slopes], strict=True)
    ]
    width = min(1.0, 0.3 * (min(abs(at.multiplier), 4.0) - 1.0)) * size
    sets = [Rectangle(0, 0.0, size, size)]
    sets.append(Rectangle(0, orbit.unstable, width, _fitted(maps[0], sets[0], size).height))
    for k in range(1, count):
        sets.append(_fitted(maps[k], sets[-1], size)._replace(chart=k))
    return Guess(on, at, charts, sets, [at.period, *[time] * count])


def _section_map(chart: Chart, target: Chart, slope: Doubles) -> Doubles:
    """The derivative (2, 2) of the map from a chart to the next one's plane."""
    rates = target.deep[:, 3]
    across = np.eye(6) - np.outer(rates, target.plane) / (target.plane @ rates)
    frame = np.linalg.inv(np.hstack([target.wide, target.deep]))
    return np.asarray((frame @ across @ slope @ chart.wide)[:2])


def _fitted(derivative: Doubles, source: Rectangle, size: float) -> Rectangle:
    """A set that the image of another one covers, about its middle."""
    (a, b), (c, d) = np.abs(derivative) * [source.width, source.height]
    wide = min(size, _WIDER * max(a - b, 0.1 * a))
    return Rectangle(0, 0.0, float(wide), float(max(_HIGHER * (c + d), _LEAST_HEIGHT * size)))


def chart_at(on: LevelBody, state: Doubles, out: Doubles, into: Doubles) -> Chart:
    """A chart across the motion, with two directions in the level."""
    rates = on.rates(state)
    wide = np.column_stack([_flat(on, state, v) for v in (out, into)])
    deep = np.column_stack([*on.gradients(state), rates])
    return Chart(state, wide, deep, rates, ETA)


def _flat(on: LevelBody, state: Doubles, v: Doubles) -> Doubles:
    """A direction in the level and in the plane across the motion, of length 1."""
    rates = on.rates(state)
    rows = np.vstack([on.gradients(state), rates])
    v = v - rates * (rates @ v) / (rates @ rates)
    v = v - rows.T @ np.linalg.solve(rows @ rows.T, rows @ v)
    return np.asarray(v / np.max(np.abs(v)))

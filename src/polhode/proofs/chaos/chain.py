"""Charts and sets along a homoclinic orbit, in double: of what derivatives of the flow foretell.

Not trusted: the checker of certificates decides.
"""

from __future__ import annotations

import numpy as np

from polhode.certificates.chaos_certificate import Chart, Rectangle
from polhode.enclosures.fixed_point_problem import Motion
from polhode.numbers.conversion import to_double
from polhode.numbers.rows import Doubles
from polhode.proofs.chaos.homoclinic import Homoclinic, Saddle
from polhode.proofs.chaos.lanes import Lanes

ETA = 1e-4
_WIDER, _HIGHER = 0.7, 1.5  # of the image: a next set's width, its height
_LEAST_HEIGHT = 0.25  # of N0's: far above what the checker leaves open, which is of second order


def along(
    lanes: Lanes, at: Saddle, found: Homoclinic, size: float
) -> tuple[list[Chart], list[Rectangle], list[float]]:
    """Charts, the sets N0, M1, ..., Mk, and the time from each to the next one's plane.

    In principal axes and the lanes' unit of time; ``size``: of N0.
    """
    count = max(2, round(found.time / at.period))
    time = found.time / count
    times = time * np.arange(count)
    first = at.point + at.unstable * found.unstable
    last = at.point + at.stable * found.stable
    early = times <= found.ahead
    starts = np.where(early, first[:, None], last[:, None])
    states = lanes.after(starts, np.where(early, times, times - found.time))
    slopes = lanes.derivative(states, np.full(count, time))
    out, into = [at.unstable], [at.stable]
    for k in range(1, count):
        out.append(_flat(lanes, states[:, k], slopes[k - 1] @ out[-1]))
    for k in range(count - 1, 0, -1):
        into.append(_flat(lanes, states[:, k], np.linalg.solve(slopes[k], into[-1])))
    charts = [_chart(lanes, at.point, at.unstable, at.stable)]
    for k in range(1, count):
        charts.append(_chart(lanes, states[:, k], out[k], into[-k]))
    returned = lanes.derivative(at.point[:, None], np.array([at.period]))
    places = [0, *range(count)]
    maps = [
        _section_map(charts[place], charts[after], slope)
        for place, after, slope in zip(places, [*places[1:], 0], [*returned, *slopes], strict=True)
    ]
    width = min(1.0, 0.3 * (min(abs(at.multiplier), 4.0) - 1.0)) * size
    sets = [Rectangle(0, 0.0, size, size)]
    sets.append(Rectangle(0, found.unstable, width, _fitted(maps[0], sets[0], size).height))
    for k in range(1, count):
        sets.append(_fitted(maps[k], sets[-1], size)._replace(chart=k))
    return charts, sets, [at.period, *[time] * count]


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


def _chart(lanes: Lanes, state: Doubles, out: Doubles, into: Doubles) -> Chart:
    rates = lanes.field(state[:, None])[:, 0]
    wide = np.column_stack([_flat(lanes, state, v) for v in (out, into)])
    deep = np.column_stack([*lanes.gradients(state), rates])
    return Chart(state, wide, deep, rates, ETA)


def _flat(lanes: Lanes, state: Doubles, v: Doubles) -> Doubles:
    """A direction in the level and in the plane across the motion, of length 1."""
    rates = lanes.field(state[:, None])[:, 0]
    rows = np.vstack([lanes.gradients(state), rates])
    v = v - rates * (rates @ v) / (rates @ rates)
    v = v - rows.T @ np.linalg.solve(rows @ rows.T, rows @ v)
    return np.asarray(v / np.max(np.abs(v)))


def in_scene_axes(what: Motion, chart: Chart) -> Chart:
    """A chart of principal axes and a motion's unit of time, in the scene's axes and unit."""
    by = 2.0**what.unit
    turn = np.array([[to_double(x) for x in row] for row in what.scene.body.axes.rows]).T
    place = np.kron(np.diag([1.0 / by, 1.0]), turn)
    back = np.kron(np.diag([by, 1.0]), turn)
    return Chart(
        place @ chart.centre,
        place @ chart.wide,
        place @ chart.deep,
        back @ chart.plane,
        chart.eta,
    )

"""The motion of a whole set from its plane to the next one: image, derivative, time.

Trusted.  The run starts at x0, near the middle of the set; a start is x0 + [first columns] xi with
xi_1, xi_2 in [-1, 1] the coordinates of the rectangle over its sizes, further columns K times the
bound of n, and a box of what rounding leaves.  At t_end it is m + G xi, m exact (``zonotope``).

With S around all that the motions reach within +- delta (``flow_tube.around``), a' f of one sign on
S, |a' f| >= low there and |a'(x_end - c')| <= low delta, each motion meets the plane of the next
chart exactly once within t_end +- delta, at a time analytic in y.  There x' = x_end + d fbar, fbar
a mean of f over S, component by component, and so

    (y', n') = [E' | K']^-1 P (x_end - c'),    P = I - fbar a'/(a' fbar),                     (1)

one ball matrix for all motions, whose columns are applied to the columns of the set one by one.
The derivative of the crossing is P' D (E + K n'(y)), P' with f at the crossing, D the derivative of
the flow at t_end widened by exp(L delta) - 1.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Protocol

import numpy as np
from flint import arb, arb_mat

from polhode.enclosures import fixed_point_problem
from polhode.enclosures.fixed_point_problem import CLOCK, UP, Problem, Refused, upper
from polhode.enclosures.step_bound import TINY, Bounds
from polhode.enclosures.variations.variational_bound import Derivatives
from polhode.enclosures.zonotope import State, Step, advance
from polhode.numbers.flint_context import ctx
from polhode.numbers.rows import Doubles
from polhode.proofs import flow_tube
from polhode.proofs.chaos.h_set import Chart, Disk, HSet, column, disk, matrix, shifted
from polhode.proofs.flow_tube import exactly
from polhode.proofs.level import Level, LevelBalls, largest

_SPARE = 1.5  # of the time within which the crossing is looked for
_BITS = 128  # behind the noise level


class Watch(Protocol):
    """What looks at the windows of a proof."""

    def window(self, known: Bounds, steps: Sequence[Step]) -> None:
        """A window whose steps have been accepted."""

    def finish(self) -> None:
        """The proof is at its end."""


#: Runs a proof: the problem, the times asked for, what watches.
Follow = Callable[[Problem, Sequence[arb], Sequence[Watch]], object]


@dataclass(frozen=True, eq=False)
class Image:
    """What is proved of a set's motion to a plane.

    ``shift``, ``turn``: (y', n') lies in shift + turn xi, |xi| <= 1, xi_1 and xi_2 the coordinates
    of the rectangle over its sizes; ``slope``: balls around dy'/dy, 2 x 2.  ``least``, ``most``:
    of the time, in the proof's unit.
    """

    source: HSet
    chart: Chart
    shift: arb_mat
    turn: arb_mat
    slope: arb_mat
    least: arb
    most: arb


class _Set:
    """The set and the derivative while a proof goes by."""

    def __init__(self, problem: Problem, columns: Doubles, times: Sequence[arb]) -> None:
        self.state = State(0, problem.start, columns)
        self.derivatives = Derivatives(times)

    def window(self, known: Bounds, steps: Sequence[Step]) -> None:
        """A window of the centre's proof; the set has steps of its own."""
        self.state, _, taken = advance(self.state, known, [])
        self.derivatives.window(known, taken)

    def finish(self) -> None:
        """Nothing is left at the end."""


def transit(
    level: Level, source: HSet, chart: Chart, ticks: int, noise: int, follow: Follow
) -> Image:
    """The image of a set near the plane of a chart after ``ticks`` of the grid; raises Refused."""
    if not ticks > 0:
        raise Refused("the time of a transit is not positive")
    fine = source.chart.fine
    with ctx.workprec(noise + _BITS):
        known = level.balls(noise + 100)
        start = disk(known, source)
        middle, columns = _columns(source, start, noise)
        end = [arb((ticks, -CLOCK))]
    problem = exact_start(level, middle, fine, noise)
    watch = _Set(problem, columns, end)
    follow(problem, end, (watch,))
    if watch.state.time != ticks or len(watch.derivatives.found) != 1:
        raise Refused("the enclosure did not reach the next plane")
    with ctx.workprec(noise + _BITS):
        return _image(known, source, start, chart, watch, arb((ticks, -CLOCK)), noise)


def exact_start(level: Level, start: tuple[int, ...], fine: int, noise: int) -> Problem:
    """The exact motion from a state of the grid."""
    state = tuple(Fraction(x, 1 << fine) for x in start)
    found = fixed_point_problem.problem(replace(level.motion, start=state), noise)
    if found.fine != fine or found.start != start or any(found.spread):
        raise Refused("the start is not a state of the grid")
    return found


def _columns(source: HSet, start: Disk, noise: int) -> tuple[tuple[int, ...], Doubles]:
    """x0, and the columns of the starts, in units of 2**-noise."""
    chart = source.chart
    e, k = matrix(chart.wide), matrix(chart.deep)
    depth = column([x.mid() for x in start.depth])
    centre = shifted(chart.point, e * column([arb(source.middle), arb(0)]) + k * depth)
    unit = math.ldexp(1.0, noise)
    sizes = [source.width, source.height, *(upper(x - x.mid()) for x in start.depth)]
    exact = np.hstack([chart.wide, chart.deep]) * np.array(sizes)
    found, box = [], np.zeros(6)
    for i, x in enumerate(centre):
        near = int((x.mid() * arb((1, chart.fine))).floor().unique_fmpz() or 0)
        found.append(near)
        # each column is one product of doubles, off by 2**-53 of itself
        lost = 2.0**-52 * float(np.sum(np.abs(exact[i])))
        box[i] = UP * unit * (upper(x - exactly(near, chart.fine)) + lost) + TINY
    columns = np.hstack([exact * unit, np.diag(box)])
    if not np.all(np.isfinite(columns)):
        raise Refused("a set has no size")
    return tuple(found), columns


def _image(
    known: LevelBalls,
    source: HSet,
    start: Disk,
    chart: Chart,
    watch: _Set,
    time: arb,
    noise: int,
) -> Image:
    columns = watch.state.columns
    if not np.all(np.isfinite(columns)):
        raise Refused("the set has grown too large")
    end = [exactly(x, source.chart.fine) for x in watch.state.centre]
    unit = arb((1, -noise))
    turn = arb_mat([[arb(x) * unit for x in row] for row in columns.tolist()])
    box = [x + arb(0, _total(row)) for x, row in zip(end, turn.tolist(), strict=True)]
    off = column([x - c for x, c in zip(end, chart.point, strict=True)])
    row = chart.row
    far = (abs((row * off)[0, 0]) + _total((row * turn).entries())).upper()
    span, reached = crossing(known, chart, box, far)
    if not time > span:
        raise Refused("the time of a transit may not be positive")
    rates = column(known.field(reached.box))
    project = rates * row / (row * rates)[0, 0]
    try:
        frame = chart.frame.inv()
    except ZeroDivisionError:
        raise Refused("a chart is singular") from None
    to_chart = frame - frame * project  # [E' | K']^-1 P
    d = derivative(known, watch, reached, span)
    into = matrix(source.chart.wide) + matrix(source.chart.deep) * start.slope
    slope = to_chart * d * into
    return Image(
        source,
        chart,
        to_chart * off,
        to_chart * turn,
        arb_mat([[slope[i, j] for j in range(2)] for i in range(2)]),
        (time - span).lower(),
        (time + span).upper(),
    )


def crossing(
    known: LevelBalls, chart: Chart, box: list[arb], far: arb
) -> tuple[arb, flow_tube.Around]:
    """delta, and S with its tests: motions from a box meet a plane once within +- delta.

    ``far``: a bound of |a'(x - c')| on what of the box is meant.
    """
    row = chart.row
    rate = (row * column(known.field(box)))[0, 0]
    if not abs(rate) > 0:
        raise Refused("a plane may touch the motion")
    span = (_SPARE * far / abs(rate).lower()).upper() + arb((1, -60))
    reached = flow_tube.around(box, span, known)
    low = abs((row * column(known.field(reached.box)))[0, 0]).lower()
    if not (low > 0 and far <= low * span):
        raise Refused("a set may miss the next plane")
    return span, reached


def derivative(known: LevelBalls, watch: _Set, reached: flow_tube.Around, span: arb) -> arb_mat:
    """Balls around D at every time of t_end +- delta."""
    wider = flow_tube.spread_of_derivative(reached, span, known)
    centre, radius = watch.derivatives.found[0]
    rows = [
        [arb(x, r) for x, r in zip(*pair, strict=True)]
        for pair in zip(centre.tolist(), radius.tolist(), strict=True)
    ]
    most = [largest([row[j] for row in rows]) for j in range(6)]
    return arb_mat([[row[j] + arb(0, 1) * (wider * most[j]) for j in range(6)] for row in rows])


def _total(values: Sequence[arb]) -> arb:
    found = arb(0)
    for x in values:
        found = found + x.abs_upper()
    return found.upper()

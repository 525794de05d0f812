"""The derivative of the states by the start, as balls in the scene's axes and units.

Trusted.  In the scene's body axes the state is C x, C = diag(s 2**-unit A^T, A^T), x the state in
principal axes and the proof's unit of time, A the principal axes as rows, s the sign of the time;
its derivative is C D C**-1.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from flint import arb, arb_mat

from polhode.common.cached_property import cached_property
from polhode.common.text_tables import counted
from polhode.common.value_semantics import ByValue
from polhode.enclosures.fixed_point_problem import UP, Motion, upper
from polhode.enclosures.polynomial import ball, midpoint
from polhode.enclosures.variations.variational_bound import Derivative
from polhode.numbers import exact
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Exact
from polhode.numbers.flint_context import ctx
from polhode.scenes.scene import Scene

_BITS = 128  # of a norm
_SQUARINGS = 10  # trace(B**1024)**(1/1024) is above the largest eigenvalue by at most 6**(1/1024)


class BallMatrix(NamedTuple):
    """A matrix of balls: exact midpoints, and doubles not below the radii."""

    centres: tuple[tuple[Fraction, ...], ...]
    radii: tuple[tuple[float, ...], ...]


@dataclass(frozen=True, eq=False, repr=False)
class FlowDerivative(ByValue):
    """The derivative of the exact state by the start, enclosed.

    ``matrices``: one for each of ``times``, six rows and columns, w before gamma (three without
    gamma), in the scene's body axes and units: the derivative of the state with respect to all six
    numbers of the start, h, f and |gamma| not kept fixed.  ``unit``: the rate by which w is divided
    in ``amplification`` and ``exponents``.

    >>> import polhode
    >>> found = polhode.certify("euler/separatrix", at=[10], derivatives=True).derivatives
    >>> found
    <FlowDerivative at 1 time: amplification up to 12.7>
    >>> low, high = found.amplification[0]
    >>> low < high < 1.002 * low
    True
    """

    times: tuple[Exact, ...]
    matrices: tuple[BallMatrix, ...]
    unit: float

    @cached_property
    def amplification(self) -> tuple[tuple[float, float], ...]:
        """Lower and upper bounds of max |dx(t)|/|dx(0)|, Euclidean, x = (w/unit, gamma)."""
        return tuple(_norm(matrix, self.unit) for matrix in self.matrices)

    @property
    def exponents(self) -> tuple[tuple[float, float], ...]:
        """Lower and upper bounds of ln(amplification)/|t|, the finite-time Lyapunov exponent."""
        found = []
        for t, (low, high) in zip(self.times, self.amplification, strict=True):
            with ctx.workprec(_BITS):
                time = abs(ball(t, _BITS))
                rates = [arb(x).log() / time if x > 0.0 else arb(0, math.inf) for x in (low, high)]
                found.append((_below(rates[0]), -_below(-rates[1])))
        return tuple(found)

    def __repr__(self) -> str:
        most = max((high for _, high in self.amplification), default=1.0)
        times = counted(len(self.times), "time")
        return f"<FlowDerivative at {times}: amplification up to {most:.3g}>"


def fastest(scene: Scene, states: Sequence[Sequence[Fraction]]) -> float:
    """The largest |w| of states, as a double; the rate of a pendulum, or 1, where w is zero."""
    largest = max((sum(x * x for x in row[:3]) for row in states), default=Fraction(0))
    if largest:
        return to_double(exact.sqrt(largest))
    rate = scene.pendulum_rate_squared
    return to_double(exact.sqrt(rate)) if exact.sign(rate) else 1.0


def matrix_in_scene_axes(what: Motion, found: Derivative, bits: int) -> BallMatrix:
    """A derivative in principal axes and the proof's unit in the scene's axes and unit."""
    scene = what.scene
    with ctx.workprec(bits):
        d = matrix_of(found)
        zero = arb(0)
        axes = [[ball(x, bits) for x in row] for row in scene.body.axes.rows]
        rows = [[zero] * 6 for _ in range(6)]
        for i in range(3):
            for j in range(3):
                rows[i][j] = rows[3 + i][3 + j] = axes[i][j]
        turn = arb_mat(rows)
        turned = d if scene.body.axes.trivial else turn.transpose() * d * turn
        by = arb((-1 if what.backward else 1, -what.unit))
        count = 3 if scene.gamma is None else 6
        centres, radii = [], []
        for i in range(count):
            row = []
            for j in range(count):
                x = turned[i, j]
                row.append(x * by if i < 3 <= j else x / by if j < 3 <= i else x)
            centres.append(tuple(midpoint(x) for x in row))
            radii.append(tuple(upper(x - x.mid()) for x in row))
    return BallMatrix(tuple(centres), tuple(radii))


def matrix_of(found: Derivative) -> arb_mat:
    """The same as balls."""
    pairs = zip(found.centre.tolist(), found.radius.tolist(), strict=True)
    return arb_mat([[arb(x, r) for x, r in zip(*pair, strict=True)] for pair in pairs])


def _norm(matrix: BallMatrix, unit: float) -> tuple[float, float]:
    """Bounds of the spectral norm, w divided by the unit: those of the midpoints, and the radii."""
    count = len(matrix.centres)
    with ctx.workprec(_BITS):
        scales = [arb(unit)] * 3 + [arb(1)] * (count - 3)
        middle = arb_mat(
            [
                [ball(x, _BITS) * scales[j] / scales[i] for j, x in enumerate(row)]
                for i, row in enumerate(matrix.centres)
            ]
        )
        spread = arb(0)
        for i, row in enumerate(matrix.radii):
            for j, x in enumerate(row):
                part = arb(x) * scales[j] / scales[i]
                spread += part * part
        doubles = np.array(
            [[float(middle[i, j].mid()) for j in range(count)] for i in range(count)]
        )
        direction = np.linalg.svd(doubles)[2][0]
        one = arb_mat([[arb(x)] for x in direction.tolist()])
        low = _length(middle * one) / _length(one) - spread.sqrt()
        power = middle.transpose() * middle
        for _ in range(_SQUARINGS):
            power = power * power
        most = power.trace().abs_upper().root(2 << _SQUARINGS) + spread.sqrt()
        return max(0.0, _below(low)), UP * upper(most)


def _length(column: arb_mat) -> arb:
    total = arb(0)
    for x in column.entries():
        total += x * x
    return total.sqrt()


def _below(x: arb) -> float:
    """A double not above any number of a ball."""
    low = float(x.lower())
    return low - abs(low) * 1e-12 - 1e-300

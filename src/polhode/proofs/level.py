"""A level of energy and area in the proof's unit of time: the field, its integrals, in balls.

Trusted.  In principal axes, moments m_i and k = Mg r0 over the largest moment, i, a, b cyclic,

    H = (sum m_i w_i**2 + 2 sum k_i gamma_i, sum m_i w_i gamma_i, sum gamma_i**2)

is conserved for any state, of the level or not; with a tolerance (``fixed_point_problem``) of every
body, over the largest moment of the scene's own.  Balls in, balls out, at the precision that holds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial

from flint import arb

from polhode.enclosures.fixed_point_problem import CYCLE, Motion, sharp
from polhode.enclosures.polynomial import ball
from polhode.numbers import exact
from polhode.numbers.exact import Exact
from polhode.numbers.flint_context import ctx

Balls = Sequence[arb]


@dataclass(frozen=True)
class Level:
    """The body and unit of a motion, and the level (h, f), exact, in the scene's units."""

    motion: Motion
    h: Exact
    f: Exact

    def balls(self, bits: int) -> LevelBalls:
        """The same with every number as a ball of radius below 2**-bits; raises Refused."""
        what = self.motion
        largest, by = max(what.moments), Fraction(2) ** what.unit
        values = [exact.divide(exact.multiply(2 * by * by, self.h), largest)]
        values += [exact.divide(exact.multiply(by, self.f), largest), exact.ONE]
        moments = [exact.divide(m, largest) for m in what.moments]
        torque = [exact.divide(k, largest) for k in what.torque]
        known = [sharp(partial(ball, x), bits) for x in (*values, *moments, *torque)]
        with ctx.workprec(bits + 64):
            body = [what.spread(x) for x in known[3:]]
        return LevelBalls(known[:3], body[:3], body[3:], what.balls(bits))


@dataclass(frozen=True)
class LevelBalls:
    """``values``: c, of H; ``constants``: bend, pull, push of the field."""

    values: Balls
    moments: Balls
    torque: Balls
    constants: Balls

    def integrals(self, x: Balls) -> list[arb]:
        """H over a box."""
        m, k, w, g = self.moments, self.torque, x[:3], x[3:]
        return [
            _total([m[i] * w[i] * w[i] + 2 * k[i] * g[i] for i in range(3)]),
            _total([m[i] * w[i] * g[i] for i in range(3)]),
            _total([g[i] * g[i] for i in range(3)]),
        ]

    def gradients(self, x: Balls) -> list[list[arb]]:
        """DH over a box, three rows of six."""
        m, k, w, g = self.moments, self.torque, x[:3], x[3:]
        momentum = [m[i] * w[i] for i in range(3)]
        return [
            [*(2 * y for y in momentum), *(2 * y for y in k)],
            [*(m[i] * g[i] for i in range(3)), *momentum],
            [arb(0)] * 3 + [2 * y for y in g],
        ]

    def field(self, x: Balls) -> list[arb]:
        """The right-hand sides over a box."""
        bend, pull, push = self.constants[:3], self.constants[3:6], self.constants[6:]
        rows = [
            bend[i] * x[a] * x[b] + pull[i] * x[3 + a] + push[i] * x[3 + b]
            for i, (a, b) in enumerate(CYCLE)
        ]
        return rows + [x[3 + a] * x[b] - x[3 + b] * x[a] for a, b in CYCLE]

    def jacobian(self, x: Balls) -> list[list[arb]]:
        """The derivative of the right-hand sides over a box."""
        bend, pull, push = self.constants[:3], self.constants[3:6], self.constants[6:]
        rows = [[arb(0)] * 6 for _ in range(6)]
        for i, (a, b) in enumerate(CYCLE):
            rows[i][a], rows[i][b] = bend[i] * x[b], bend[i] * x[a]
            rows[i][3 + a], rows[i][3 + b] = pull[i], push[i]
            rows[3 + i][3 + a], rows[3 + i][b] = x[b], x[3 + a]
            rows[3 + i][3 + b], rows[3 + i][a] = -x[a], -x[3 + b]
        return rows


def largest(values: Balls) -> arb:
    """The largest modulus of any number of any of the balls, as a number."""
    found = arb(0)
    for x in values:
        size = x.abs_upper()
        if not size.is_finite():  # no number is the largest, whatever comes after it
            return size
        if size > found:
            found = size
    return found


def row_sum(rows: Sequence[Balls]) -> arb:
    """The largest row sum of a matrix of balls, as a number."""
    return largest([_total([x.abs_upper() for x in row]) for row in rows])


def _total(terms: Balls) -> arb:
    found = arb(0)
    for x in terms:
        found = found + x
    return found

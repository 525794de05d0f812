"""A closed orbit in double carried on to any number of digits.

The chord method: the ten residuals of :mod:`polhode.dynamics.newton_shooting` in a
type wide enough, by the six equations alone, and corrections by the inverse that is known in
double.  A correction gains about ten digits.  How far off the numbers are that are written down is
then told by one more correction, computed from just these decimals in a wider type.  The monodromy
matrix is integrated once at the end; what its exact properties miss tells its digits.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from flint import fmpq_mat

from polhode.dynamics.newton_shooting import (
    Closed,
    NotClosed,
    Surface,
    at_level,
    bordered,
    gradients,
    integrals,
    inverse_of,
)
from polhode.equations.forms import principal
from polhode.numbers import exact, number_types
from polhode.numbers.conversion import to_double
from polhode.numbers.decimals import decimal_string
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import DOUBLE, EXACT, EXTENDED, QUAD, Doubles, NumberType
from polhode.numbers.polynomials import rational
from polhode.taylor.variations import Flow, NotFollowed

SPARE_DIGITS = 2  # written beside those asked for
MOST_TYPES = 3  # tried until the digits are reached
DIGITS_OF_TURNS = 8  # at least: by chance one advance in 3000 is a fraction of a turn to so many
HELD = 15  # digits up to which a monodromy matrix in double is enough

Fractions = Sequence[Fraction]


class Refined(NamedTuple):
    """A start and a period as decimals, in the scene's axes and units, and how good they are.

    ``omega``, ``gamma``, ``period``: decimals of the digits asked for and two more; of a component
    that is smaller than its scale as many as make its place the same.  ``error``: the
    largest of their errors, w relative to its scale, gamma as it is, the period relative to itself.
    ``state``, ``time``: the numbers of ``number`` before they were rounded.
    """

    omega: tuple[str, ...]
    gamma: tuple[str, ...]
    period: str
    error: float
    state: tuple[Fraction, ...]
    time: Fraction
    number: NumberType
    corrections: int


class Monodromy(NamedTuple):
    """The monodromy matrix of a closed orbit: its trace and what its exact properties miss.

    ``determinant``: |det M - 1|.  ``missed``: the largest of |grad F M - grad F| over the three
    integrals F and |M x' - x'|, relative to the gradients and x'.
    """

    trace: Fraction
    determinant: float
    missed: float
    number: NumberType

    @property
    def residue(self) -> Fraction:
        """Greene's residue (6 - tr M)/4."""
        return (6 - self.trace) / 4


def refined(
    on: Surface,
    closed: Closed,
    anchor: Sequence[Exact],
    digits: int,
    tell: Callable[[str], None] | None = None,
) -> Refined:
    """So many digits of a closed orbit; raises NotClosed.

    ``anchor``: a state near the orbit, exact; the orbit's start x is where (x - anchor)·x' = 0 with
    x' the rates at the anchor, so that it is the same to all digits whatever double makes of it.
    """
    near = np.array([to_double(x) for x in anchor])
    rows = at_level(on, near)(closed.state, closed.period)[1]
    matrix = bordered(on, closed.state, closed.state, closed.monodromy, rows)
    chord = Chord(on, closed.state, tuple(anchor), inverse_of(matrix))
    norms = (float(np.linalg.norm(x, 2)) for x in (chord.inverse, closed.monodromy))
    lost = sum(math.log10(max(1.0, norm)) for norm in norms)
    kind = type_for(math.ceil(digits + lost + 0.5))
    for _ in range(MOST_TYPES):
        state, time, count = _solved(chord, kind, closed.period, digits, tell)
        solution = _written(chord, state, time, kind, digits, count)
        if solution.error <= 10.0**-digits:
            return solution
        kind = number_types.wider(kind)
    raise NotClosed(f"in {kind.name} the error is {solution.error:.1e}, not below 1e-{digits}")


class Chord(NamedTuple):
    """What corrections are made of: a state near the orbit, the inverse of the system there.

    ``anchor``: see :func:`refined`.
    """

    on: Surface
    reference: Doubles
    anchor: tuple[Exact, ...]
    inverse: Doubles

    def correction(self, flow: Flow, state: Fractions, time: Fraction) -> list[Fraction]:
        """The step in x and T, its residual computed from numbers of the flow's type."""
        on, bits = self.on, flow.number.bits + 64
        try:
            end = flow.after(state, time).state
        except NotFollowed as fault:
            raise NotClosed(f"its motion could not be followed: {fault}") from None
        moments, torque, level = (
            [_binary(x, bits) for x in v]
            for v in (on.exact_moments, on.exact_torque, (*on.exact_level, Fraction(1)))
        )
        values = integrals(moments, torque, state)
        anchor = [_binary(x, bits) for x in self.anchor]
        numbers = {name: _binary(x, bits) for name, x in on.coefficients.items()}
        rates = principal.field(anchor, numbers, EXACT)
        length = Fraction(math.hypot(*map(float, rates)))
        displacements = zip(rates, state, anchor, strict=True)
        residual = [
            *(a - b for a, b in zip(end, state, strict=True)),
            *(a - b for a, b in zip(values, level, strict=True)),
            sum((a * (x - r) for a, x, r in displacements), Fraction(0)) / length,
        ]
        size = max(map(abs, residual))
        if not size:
            return [Fraction(0)] * 7
        step = -(self.inverse @ np.array([float(x / size) for x in residual]))[:7]
        return [Fraction(x) * size for x in step.tolist()]


def _solved(
    chord: Chord,
    kind: NumberType,
    period: float,
    digits: int,
    tell: Callable[[str], None] | None,
) -> tuple[list[Fraction], Fraction, int]:
    """State and period in one type, and the number of corrections: as many as bring something."""
    flow = Flow(chord.on.coefficients, kind)
    state = [kind.rounded(Fraction(x)) for x in chord.reference.tolist()]
    time, goal = kind.rounded(Fraction(period)), Fraction(1, 10 ** (digits + 1))
    last: Fraction | None = None
    for count in itertools.count(1):
        step = chord.correction(flow, state, time)
        size = max(map(abs, step))
        if last is not None and size > last / 2:  # rounding, or no way to an orbit
            return state, time, count
        state = [kind.rounded(x + d) for x, d in zip(state, step, strict=False)]
        time, last = kind.rounded(time + step[6]), size
        if tell is not None:
            tell(f"correction {count}, {-exact.log10(size) if size else digits:.0f} digits")
        if size < goal:
            break
    return state, time, count


def _written(
    chord: Chord,
    state: Fractions,
    time: Fraction,
    kind: NumberType,
    digits: int,
    count: int,
) -> Refined:
    """As decimals in the scene's axes and units; their error from a correction in a wider type."""
    on = chord.on
    wide = number_types.wider(kind)
    bits = wide.bits + 64
    rows = [[_binary(x, bits) for x in row] for row in on.scene.body.axes.rows]
    unit, written = on.unit, digits + SPARE_DIGITS

    def turned(vector: Fractions) -> list[Fraction]:
        return [sum((rows[i][j] * vector[i] for i in range(3)), Fraction(0)) for j in range(3)]

    scale = Fraction(float(on.scale(chord.reference)[0])) / unit
    omega = [decimal(w / unit, scale, written) for w in turned(state[:3])]
    gamma = [decimal(g, Fraction(1), written) for g in turned(state[3:])]
    period = decimal_string(time * unit, written)
    # the way back from the decimals; gamma of length one, as the scene file has it
    w = [unit * Fraction(x) for x in omega]
    g = [Fraction(x) for x in gamma]
    length = _binary(exact.sqrt(sum((x * x for x in g), Fraction(0))), bits)
    inside = [
        sum((a * b for a, b in zip(row, v, strict=True)), Fraction(0))
        for v in (w, g)
        for row in rows
    ]
    again = [wide.rounded(x / (1 if i < 3 else length)) for i, x in enumerate(inside)]
    own = wide.rounded(Fraction(period) / unit)
    step = chord.correction(Flow(on.coefficients, wide), again, own)
    measures = [*on.scale(chord.reference).tolist(), float(own)]
    error = max(float(abs(d)) / m for d, m in zip(step, measures, strict=True))
    return Refined(tuple(omega), tuple(gamma), period, error, tuple(state), time, kind, count)


def monodromy(on: Surface, state: Fractions, time: Fraction, digits: int) -> Monodromy:
    """The monodromy matrix at a closed orbit's start, for about so many digits of its trace."""
    kind = DOUBLE if digits <= HELD else type_for(digits + SPARE_DIGITS, QUAD.bits)
    flow = Flow(on.coefficients, kind, derivative=True)
    start = [kind.rounded(x) for x in state]
    rounded = [float(x) for x in start] if kind == DOUBLE else start
    matrix = flow.after(rounded, kind.rounded(time)).derivative
    assert matrix is not None
    rows = [[Fraction(x) for x in row] for row in matrix]
    moments, torque = (
        [_binary(x, kind.bits) for x in v] for v in (on.exact_moments, on.exact_torque)
    )
    missed = Fraction(0)
    for row in gradients(moments, torque, start):
        moved = [sum((row[i] * rows[i][j] for i in range(6)), Fraction(0)) for j in range(6)]
        off = max(abs(a - b) for a, b in zip(moved, row, strict=True))
        missed = max(missed, off / max(map(abs, row)))
    off = abs(fmpq_mat([[rational(x) for x in row] for row in rows]).det() - 1)
    determinant = float(Fraction(int(off.p), int(off.q)))
    trace = sum((rows[i][i] for i in range(6)), Fraction(0))
    return Monodromy(trace, determinant, float(missed), kind)


def type_for(digits: int, least_bits: int = 0) -> NumberType:
    """The cheapest type wider than double that holds so many digits."""
    for kind in (EXTENDED, QUAD):
        there = kind != EXTENDED or number_types.extended_here()
        if there and kind.bits >= least_bits and digits <= kind.most_digits - 0.5:
            return kind
    return number_types.mp(digits)


def decimal(x: Fraction, scale: Fraction, digits: int) -> str:
    """x with the decimals that so many digits of a number of size ``scale`` have."""
    if not x:
        return "0"
    fewer = math.floor(exact.log10(abs(x) / scale))
    return decimal_string(x, min(digits, digits + fewer)) if digits + fewer > 0 else "0"


def _binary(x: Exact, bits: int) -> Fraction:
    return exact.binary(*exact.rounded(x, bits)) if x else Fraction(0)

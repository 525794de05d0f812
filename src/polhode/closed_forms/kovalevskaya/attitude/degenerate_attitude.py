"""The attitude of a motion on a degenerate curve, from those of its neighbours.

A neighbour of :mod:`.degenerate` starts with the quaternion q(0) T, where T is the least turn in
the body that takes its gamma to gamma.  Its Cayley-Klein parameters are theta quotients, and the
four quaternions are combined like the states: the cost does not grow with time.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from polhode.closed_forms.functions.jacobi import SeriesFunctions
from polhode.closed_forms.functions.quaternion import Quaternion, product
from polhode.closed_forms.functions.rounding import number
from polhode.closed_forms.kovalevskaya.attitude.cayley_klein import (
    CayleyKlein,
    cayley_klein,
    quaternion,
)
from polhode.closed_forms.kovalevskaya.attitude.theta_turns import TorusTurns
from polhode.closed_forms.kovalevskaya.axes import KovalevskayaStart
from polhode.closed_forms.kovalevskaya.degenerate import Averaged, combined
from polhode.common.cached_property import cached_property
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar

_TRIALS = 6
_MORE = 16  # bits more at each trial, at least


@dataclass(frozen=True)
class AveragedAttitude:
    """The neighbours' Cayley-Klein parameters at one precision."""

    motions: Averaged
    formulas: Sequence[CayleyKlein]  # at eps, -eps, 2 eps, -2 eps
    bits: int  # at which they were made, and are to be asked

    @property
    def defect(self) -> Scalar:
        """The largest of the neighbours."""
        return max(formula.defect for formula in self.formulas)

    def turns(self, which: int, t: Any) -> tuple[Any, Any]:
        """The growth of arg xi and arg eta of a neighbour from 0 to t in the top's units."""
        return self._tori[which].growth(t)

    @cached_property
    def _tori(self) -> list[TorusTurns]:
        return [TorusTurns(formula, self.bits) for formula in self.formulas]

    def certified(self, t: Scalar) -> tuple[list[Scalar], Scalar]:
        """The quaternion in the top's axes at t in its units, and an estimate of its error."""
        rows, miss = [], mpf(0)
        with mpmath.workprec(self.bits):
            for formula in self.formulas:
                xi, eta, missed = formula.certified(t)
                rows.append(quaternion(xi, eta))
                miss = max(miss, missed)
            found, estimate = combined(rows, [mpf(1)] * 4)
        return found, max(miss, estimate)


def averaged_attitude(
    start: KovalevskayaStart, made: Averaged, first: Quaternion, bits: int
) -> AveragedAttitude:
    """The constants at the precision in force; ``first``: q(0) in the top's axes."""
    _, vertical = start.numbers(bits)
    formulas = []
    for moved, motion in zip(made.starts, made.neighbours, strict=True):
        turn = _least_turn([number(x, bits) for x in moved.G], vertical)
        formulas.append(cayley_klein(moved, motion, product(first, turn)))
    return AveragedAttitude(made, formulas, bits)


def _least_turn(one: Sequence[Scalar], other: Sequence[Scalar]) -> Quaternion:
    """The quaternion of the least turn that takes the direction of one vector to the other's."""
    size = mpmath.sqrt(mpmath.fdot(one, one) * mpmath.fdot(other, other))
    (a, b, c), (d, e, f) = one, other
    row = [size + mpmath.fdot(one, other), b * f - c * e, c * d - a * f, a * e - b * d]
    norm = mpmath.sqrt(mpmath.fdot(row, row))
    w, x, y, z = (v / norm for v in row)
    return w, x, y, z


@dataclass(eq=False)
class DegenerateAttitude:
    """The quaternion body -> space of a motion on a degenerate curve as a function of time."""

    #: The constants for a time of the scene and so many bits.
    formula: Callable[[Scalar, int], AveragedAttitude]
    turns: Callable[[Scalar], tuple[Scalar, Scalar]]  # growth of both arguments
    bits: int  # of the answers
    start: Quaternion
    turn: Quaternion  # from the scene's axes to the top's
    exponent: int  # the top's unit of time is 2^-exponent
    speed: Scalar  # a bound of |w|

    def at(self, t: Scalar, fn: SeriesFunctions) -> Quaternion:
        """The attitude at t, continuous in t; ArithmeticError where it has no certificate."""
        del fn
        if not t:
            return self.start
        bits = self.bits
        for _ in range(_TRIALS):
            (w, x, y, z), miss = self.formula(t, bits).certified(mpmath.ldexp(t, self.exponent))
            if miss < mpmath.ldexp(1, -self.bits):
                return product((w, x, y, z), self.turn)
            bits += max(_MORE, self.bits + int(mpmath.mag(miss)))
        raise ArithmeticError("the attitude does not pass its check")

    def arguments(self, t: Any) -> tuple[Any, Any]:
        """The growth of arg(q0 + i q3) and arg(q1 + i q2) from time 0 to t."""
        return self.turns(t) if t else (mpf(0), mpf(0))

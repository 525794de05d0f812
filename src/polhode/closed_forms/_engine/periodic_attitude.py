"""The attitude of a motion whose w and gamma are periodic, at a cost that no time changes.

After a period T the body has turned about the vertical by an angle D, so

    q(t + n T) = (cos n D/2, 0, 0, sin n D/2) q(t):

the attitude is known over one period, and with it the growth of the arguments of

    al = q0 + i q3 = cos(theta/2) exp i(psi + phi)/2,
    bt = q1 + i q2 = sin(theta/2) exp i(psi - phi)/2.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from polhode.closed_forms._winding.winding_number import bisected
from polhode.closed_forms.functions.jacobi import SeriesFunctions
from polhode.closed_forms.functions.quaternion import Quaternion, product
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from polhode.numbers.scalars import Scalar

_STEP = 2  # radians between two marks of the count
_LATER = 0.1237  # of a period: the count of whole periods begins at no special place


@dataclass(eq=False)
class OneOrbit:
    """The quaternion body -> space as a function of time, at one precision.

    ``turn`` is the attitude from 0 to ``period``; ``speed`` a bound of |w| and of sqrt(|w'|).
    """

    start: Quaternion
    turn: Callable[[Scalar], Quaternion]
    speed: Scalar
    period: Scalar
    _marks: dict[int, list[tuple[Any, Any]]] = field(default_factory=dict)
    _loops: dict[int, tuple[Sequence[Any], Sequence[Any]]] = field(default_factory=dict)
    _whole: list[Scalar] = field(default_factory=list)

    def at(self, t: Scalar, fn: SeriesFunctions) -> Quaternion:
        """The attitude at t, continuous in t."""
        del fn
        if not t:
            return self.start
        count = int(mpmath.floor(t / self.period))
        c, s = mpmath.cos_sin(self.advance * count)
        return product((c, mpf(0), mpf(0), s), self.turn(t - count * self.period))

    @property
    def advance(self) -> Scalar:
        """D/2, up to multiples of 2 pi."""
        if not self._whole:
            w, x, y, z = self.start
            after = product(self.turn(self.period), (w, -x, -y, -z))
            self._whole.append(mpmath.atan2(after[3], after[0]))
        return self._whole[0]

    def arguments(self, t: Scalar) -> tuple[Scalar, Scalar]:
        """The growth of arg al and arg bt from time 0 to t."""
        sense = 1 if t > 0 else -1
        first = self.period * _LATER
        if abs(t) <= first:
            return self._counted(mpf(0), t)
        count = int(mpmath.floor((abs(t) - first) / self.period))
        rest = abs(t) - first - count * self.period
        begin, loop = self._turns(sense, first)
        more = self._from(sense, first, rest)
        one, other = (a + count * b + c for a, b, c in zip(begin, loop, more, strict=True))
        return one, other

    def _turns(self, sense: int, first: Scalar) -> tuple[Sequence[Scalar], Sequence[Scalar]]:
        """The growth until ``first`` and over the period after it, counted once."""
        if sense not in self._loops:
            begin = self._counted(mpf(0), sense * first)
            loop = [self._exactly(sense, x) for x in self._from(sense, first, self.period)]
            self._loops[sense] = begin, loop
        return self._loops[sense]

    def _exactly(self, sense: int, counted: Scalar) -> Scalar:
        """The growth over a whole period, of which the count gives the turns."""
        part = sense * self.advance
        return part + 2 * mpmath.pi * mpmath.nint((counted - part) / (2 * mpmath.pi))

    def _from(self, sense: int, first: Scalar, span: Scalar) -> tuple[Scalar, Scalar]:
        """The growth from ``first`` over ``span``, both counted away from 0; marks are kept."""
        marks = self._marks.setdefault(sense, [(mpf(0), mpf(0))])
        length = _STEP / self.speed
        number = int(span / length)
        while len(marks) <= number:
            a = first + (len(marks) - 1) * length
            more = self._counted(sense * a, sense * (a + length))
            marks.append((marks[-1][0] + more[0], marks[-1][1] + more[1]))
        rest = self._counted(sense * (first + number * length), sense * (first + span))
        return marks[number][0] + rest[0], marks[number][1] + rest[1]

    def _counted(self, begin: Scalar, end: Scalar) -> tuple[Scalar, Scalar]:
        def fine(x: Scalar) -> tuple[Scalar, Scalar]:
            return self._parameters(x / self.speed)

        # The second derivative over speed^2 is at most |w|^2/4 + |w'|/2 over it, and
        # |w'| <= |w|^2 + |Mg r0|/(least moment) <= 2 speed^2.
        bend = mpf(5) / 4
        one, other = bisected(fine, begin * self.speed, end * self.speed, bend)
        return mpf(one), mpf(other)

    def _parameters(self, t: Scalar) -> tuple[Scalar, Scalar]:
        q0, q1, q2, q3 = self.at(t, _NONE)
        return mpc(q0, q3), mpc(q1, q2)


_NONE: Any = None

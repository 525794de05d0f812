"""One motion of the Kovalevskaya top, in the top's axes and units, to as many bits as asked for.

The precision is raised until the constants reproduce the start, the answers keep the integrals, and
what ought to be 0 (imaginary parts; the extrapolation's last step) is: an answer that does not pass
is not given.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

from polhode.closed_forms.functions.rounding import log2, number, rounded_up
from polhode.closed_forms.kovalevskaya import regimes
from polhode.closed_forms.kovalevskaya.axes import KovalevskayaStart
from polhode.closed_forms.kovalevskaya.degenerate import Averaged, averaged
from polhode.closed_forms.kovalevskaya.generic import generic
from polhode.closed_forms.kovalevskaya.one_frequency import special
from polhode.closed_forms.kovalevskaya.theta.quadrature import TooManyNodes
from polhode.numbers.exact import Exact
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar

CERTIFIED = 40  # bits by which the start must be reproduced beyond the digits asked for
_SPARE = 8  # bits of the answers beyond the digits asked for
_LOST = 0.01  # an estimate above this says nothing
_FIRST_EXTRA = 24
_MOST_EXTRA = 16_000  # bits that the set-up may lose
_MOST_MORE = 1_200  # bits that the growth of errors may cost


class KovalevskayaMotion(Protocol):
    """One motion at one precision, in the top's axes and units."""

    @property
    def defect(self) -> Scalar:
        """By how much the start is missed."""
        ...

    def at(self, t: Scalar) -> tuple[list[Scalar], Scalar]:
        """p, q, r, G1, G2, G3 at t, and the imaginary rest or another estimate of the error."""
        ...


class Answers:
    """The motion from one start; ``extra`` are the bits that the set-up loses, as met so far."""

    def __init__(self, start: KovalevskayaStart, regime: str) -> None:
        self.start = start
        self.regime = regime
        self.extra = _FIRST_EXTRA
        self._solutions: dict[int, tuple[KovalevskayaMotion, int]] = {}

    @property
    def generic(self) -> bool:
        """Whether the curve is not degenerate, so that two frequencies are known."""
        known = (*regimes.STEADY, *regimes.ONE_FREQUENCY, *regimes.DEGENERATE)
        return self.regime not in known

    def base(self, digits: int) -> int:
        """Bits of the answers: the digits, those that a small motion needs, a few to spare."""
        return math.ceil(digits * math.log2(10) + max(0.0, -self.start.log2_scale)) + _SPARE

    def resolved(
        self, times: Sequence[Exact], base: int
    ) -> tuple[KovalevskayaMotion, int, list[list[Scalar]], mpf]:
        """The constants that answer at these times to ``base`` bits, their precision, the states
        in the top's axes and units, and the estimate of the error.
        """
        start = self.start
        certified = base + CERTIFIED + self.phase(times)
        more = 0  # bits that the motion turned out to need at these times
        while True:
            solution, bits = self.solution(certified + more, base)
            with mpmath.workprec(bits):
                moments = [mpmath.ldexp(number(t, bits), start.exponent) for t in times]
                found, worst = self._states(solution, moments, bits)
                if worst < mpmath.ldexp(1, -base):
                    return solution, bits, found, worst
                lacking = base + int(mpmath.mag(worst)) + 16
                if worst > _LOST and isinstance(solution, Averaged):
                    lacking = self._foreseen(solution, moments, base, bits)
            if more + lacking > _MOST_MORE:
                raise ValueError(
                    f"this motion ({self.regime}) amplifies errors: of the digits asked for at "
                    f"these times {max(0, int(-mpmath.log10(worst)))} are known"
                    + self._reach(solution, times, base, _MOST_MORE - more, lacking)
                )
            more += max(lacking, 16)

    def _states(
        self, solution: KovalevskayaMotion, moments: Sequence[mpf], bits: int
    ) -> tuple[list[list[Scalar]], mpf]:
        """The states at these moments, in the top's units, and the estimate of their error."""
        found, worst = [], mpf(solution.defect)
        for t in moments:
            state, estimate = solution.at(t)
            found.append(state)
            worst = max(worst, estimate, self._missed(state, bits))
        return found, worst

    def _reach(
        self,
        solution: KovalevskayaMotion,
        times: Sequence[Exact],
        base: int,
        left: int,
        lacking: int,
    ) -> str:
        """The time up to which the bits that are left would do, in words."""
        if not isinstance(solution, Averaged):
            return ""
        first = solution.closeness - base / 4
        last = 2.0 ** min(1000.0, max(map(log2, times))) * (first + left) / (first + lacking)
        return f"; all of them are up to about |t| = {last:.2g}"

    def _foreseen(self, solution: Averaged, moments: Sequence[mpf], base: int, bits: int) -> int:
        """How many bits nearer the neighbours must be, from the growth at an earlier moment.

        The estimate is the fourth power of a deviation that started at 2^-closeness.
        """
        t = last = max(moments, key=abs)
        while True:
            t = t / 2
            _, estimate = self._states(solution, [t], bits)
            if estimate < _LOST:
                grown = solution.closeness + int(mpmath.mag(estimate)) / 4
                return math.ceil(float(last / t) * grown + base / 4) - solution.closeness

    def phase(self, times: Sequence[Exact]) -> int:
        """Bits that the phase of the motion needs at these times."""
        last = max((log2(t) for t in times), default=-math.inf)
        if last == -math.inf or self.regime in regimes.STEADY:
            return 0
        return math.ceil(max(0.0, last + self.start.exponent + self.start.log2_speed))

    def solution(self, certified: int, base: int) -> tuple[KovalevskayaMotion, int]:
        """The constants that reproduce the start to ``certified`` bits, and their precision."""
        certified = rounded_up(certified)
        before: tuple[int, int] | None = None  # bits, and how many of them reproduced the start
        while certified not in self._solutions:
            bits = certified + self.extra
            right, wanted = 0, 2 * self.extra + 64
            try:
                with mpmath.workprec(bits):
                    made = self._made(bits, certified, base)
                    defect = made.defect
                right = -int(mpmath.mag(defect)) if defect else bits
                if right >= certified:
                    self._solutions[certified] = made, bits
                    break
                if before is not None and 4 * (right - before[1]) < bits - before[0]:
                    raise ValueError(f"this motion ({self.regime}) does not reproduce its start")
                wanted = self.extra + certified - right + 16
                before = bits, right
            except TooManyNodes:
                wanted = _MOST_EXTRA + 1
            except ArithmeticError:  # points not told apart, a zero divisor
                pass
            if wanted > _MOST_EXTRA:
                raise ValueError(
                    f"this motion ({self.regime}) is too near a degenerate one for "
                    f"{math.floor(base / math.log2(10))} digits"
                )
            self.extra = wanted
        return self._solutions[certified]

    def _made(self, bits: int, certified: int, base: int) -> KovalevskayaMotion:
        if self.regime in regimes.DEGENERATE:
            return averaged(self.start, bits, certified - CERTIFIED - 3 * base // 4)
        if self.generic:
            return generic(self.start, bits)
        return special(self.start, self.regime, bits)

    def _missed(self, state: Sequence[Scalar], bits: int) -> Scalar:
        """By how much a state misses the integrals, relative to their sizes."""
        H, m, a2, k2 = self._integrals(bits)
        p, q, r, G1, G2, G3 = state
        weight = number(self.start.weight, bits)
        speed2 = mpf(2) ** int(2 * self.start.log2_speed)
        xi = mpmath.mpc(p * p - q * q - G1, 2 * p * q - G2)
        return max(
            abs(p * p + q * q + r * r / 2 + G1 - H) / speed2,
            abs(p * G1 + q * G2 + r * G3 / 2 - m) / (mpmath.sqrt(speed2) * weight),
            abs(G1 * G1 + G2 * G2 + G3 * G3 - a2) / weight**2,
            abs(abs(xi) ** 2 - k2) / speed2**2,
        )

    def _integrals(self, bits: int) -> list[Scalar]:
        start = self.start
        return [number(x, bits) for x in (start.H, start.m, start.a2, start.k2)]

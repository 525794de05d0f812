"""The Kovalevskaya top in closed form: states, period, frequencies, and their certificate.

    I w' + w x I w = Mg gamma x r0,    gamma' = gamma x w,    I = diag(2C, 2C, C), r0 = (x0, y0, 0)

(Yehia 3.13-3.17).  w = (p, q, r) and the upward vertical gamma in body axes.  Any start, any time,
any number of digits: generic motion by genus-2 theta functions (Kowalevski, Acta Math. 12 (1889)
177), one-frequency motions by Weierstrass' functions, others on a degenerate curve as the mean of
two neighbours.  Units: any consistent set, angles in radians.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from polhode.closed_forms.attitude.angles import Attitude
from polhode.closed_forms.attitude.axes import RowMatrix, placed
from polhode.closed_forms.attitude.from_attitude import FromAttitude
from polhode.closed_forms.attitude.quaternion import Quaternion, conjugate, of_matrix, product
from polhode.closed_forms.functions.rounding import number, rounded_up, shortened
from polhode.closed_forms.kovalevskaya import regimes
from polhode.closed_forms.kovalevskaya.attitude import MOST_PANELS, KovalevskayaAttitude
from polhode.closed_forms.kovalevskaya.axes import top_axes
from polhode.closed_forms.kovalevskaya.cayley_klein import CayleyKlein, cayley_klein
from polhode.closed_forms.kovalevskaya.certified import CERTIFIED, Answers, KovalevskayaMotion
from polhode.closed_forms.kovalevskaya.curve import KovalevskayaCurve, cubic_roots
from polhode.closed_forms.kovalevskaya.generic import Generic
from polhode.closed_forms.kovalevskaya.one_frequency import special
from polhode.closed_forms.kovalevskaya.theta_attitude import PeriodicAttitude, ThetaAttitude
from polhode.numbers.convert import exactly
from polhode.numbers.exact import Exact
from polhode.numbers.private import mpf, mpmath

_ZERO = Fraction(0)
_MOST_MORE = 2_000  # bits that the set-up of an attitude may lose
_COUNTING = 128  # bits of panels that only count turns
_TURNING = 16  # bits that the sum over the panels may lose beyond the phase


class KovalevskayaTop(FromAttitude):
    """The motion of one Kovalevskaya top from one start.

    ``moments`` are the principal moments and ``torque`` = Mg r0 in principal axes; ``axes[i]`` is
    the unit vector of principal axis i in the scene's body axes (right-handed; None for the same
    axes).  ``omega`` and ``gamma`` are given at t = 0 in the scene's axes, where all answers are
    too.  Raises ValueError for a body that is no Kovalevskaya top
    (:func:`polhode.closed_forms.kovalevskaya.axes.fits`).

    ``regime`` names the kind of motion, of a generic one the type of its curve; it is decided once,
    by exact arithmetic (:func:`polhode.closed_forms.kovalevskaya.regimes.regime`).
    """

    def __init__(
        self,
        moments: tuple[Exact, Exact, Exact],
        torque: tuple[Exact, Exact, Exact],
        omega: tuple[Exact, Exact, Exact],
        gamma: tuple[Exact, Exact, Exact],
        psi: Exact = _ZERO,
        axes: tuple[tuple[Exact, ...], ...] | None = None,
    ) -> None:
        super().__init__(gamma, psi)
        self._axes = top_axes(moments, torque, axes)
        self._start = self._axes.start(omega, gamma)
        self.regime = regimes.regime(self._start)
        self._answers = Answers(self._start, self.regime)
        self._matrices: dict[int, tuple[RowMatrix, mpf]] = {}
        self._attitudes: dict[int, Attitude] = {}
        self._formulas: dict[int, CayleyKlein] = {}
        self._made_panels: dict[int, tuple[KovalevskayaMotion, KovalevskayaAttitude]] = {}
        self._span: tuple[Exact, Exact] = (_ZERO, _ZERO)  # of the times of attitudes so far

    def at(self, times: Sequence[Exact], digits: int) -> list[list[mpf]]:
        """Rows p, q, r, gamma1, gamma2, gamma3, one a time.

        The error is below 10^-digits, of w relative to its largest modulus.  Where an asymptotic
        motion amplifies errors too much for that, ValueError says how many digits are known.
        """
        rows, _ = self._rows(times, self._answers.base(digits))
        return [shortened(row, digits) for row in rows]

    def error(self, digits: int, times: Sequence[Exact] = (_ZERO,)) -> mpf:
        """An estimate of the error of :meth:`at`: of w over its largest modulus, or of gamma.

        The largest of three: the difference between the answers, rounded as they are, and those at
        a higher guard level, by how much the motion misses its start, and its integrals; doubled.
        """
        base = self._answers.base(digits)
        one, worst = self._rows(times, base)
        other, again = self._rows(times, base + 64)
        with mpmath.workprec(base + 128):
            scale = max(abs(x) for row in other for x in row[:3]) or mpf(1)
            worst = max(worst, again)
            for a, b in zip(one, other, strict=True):
                for i, (x, y) in enumerate(zip(shortened(a, digits), b, strict=True)):
                    worst = max(worst, abs(x - y) / (scale if i < 3 else 1))
        return shortened([2 * worst], 15)[0]

    def period(self, digits: int) -> mpf | None:
        """The period of w and gamma, in the scene's unit of time.

        None for a motion of two frequencies, or without any.
        """
        if self.regime not in regimes.ONE_FREQUENCY:
            return None
        bits = rounded_up(self._answers.base(digits) + CERTIFIED)
        with mpmath.workprec(bits):
            period = special(self._start, self.regime, bits).period
            if not mpmath.isfinite(period):
                return None
            period = mpmath.ldexp(period, -self._start.exponent)
        return shortened([period], digits)[0]

    def frequencies(self, digits: int) -> dict[str, mpf]:
        """The motion's frequencies, radians a unit of time.

        Generic motion: "s1" and "s2", the mean rates at which the two separation variables go
        through their cycles; w and gamma repeat when both have made an even number of turns.
        One-frequency motion: "body".  Others: none.
        """
        period = self.period(digits + 5)
        bits = rounded_up(self._answers.base(digits) + CERTIFIED)
        with mpmath.workprec(bits):
            if period is not None:
                return {"body": shortened([2 * mpmath.pi / period], digits)[0]}
            made = self._curve(digits)
            if made is None:
                return {}
            both = [mpmath.ldexp(x, self._start.exponent) for x in made.frequencies]
        return dict(zip(("s1", "s2"), shortened(both, digits), strict=True))

    def curve(self, digits: int) -> dict[str, Any]:
        """H, K^2 = k^2, the points e1, e2, e3 and the period matrix tau, in time units of 1/n.

        n is rounded to a power of two, 2^exponent.  tau is None on a degenerate curve.
        """
        made, bits = self._curve(digits), rounded_up(self._answers.base(digits) + CERTIFIED)
        found: dict[str, Any] = {"exponent": self._start.exponent}
        for name, x in (("H", self._start.H), ("K2", self._start.k2)):
            found[name] = shortened([number(x, bits)], digits)[0]
        found["e"] = shortened(cubic_roots(self._start, bits), digits)
        found["tau"] = None if made is None else shortened(made.periods[2], digits)
        return found

    def _curve(self, digits: int) -> KovalevskayaCurve | None:
        """The curve of a generic motion, as certified by the start."""
        if not self._answers.generic:
            return None
        base = self._answers.base(digits)
        solution, _ = self._answers.solution(base + CERTIFIED, base)
        assert isinstance(solution, Generic)
        return solution.curve

    def _bits(self, times: Sequence[Exact], digits: int) -> int:
        """The precision of an attitude; refuses times that are too far for panels."""
        phase = self._answers.phase(times)
        if self._by_panels and phase > math.log2(MOST_PANELS) + 1:
            raise ValueError(self._too_far())
        self._span = min([self._span[0], *times]), max([self._span[1], *times])
        return rounded_up(self._answers.base(digits) + phase + _TURNING)

    @property
    def _by_panels(self) -> bool:
        """Whether the attitude is integrated step by step over all the time asked for."""
        return not self._answers.generic and self.period(15) is None

    def _too_far(self) -> str:
        limit = 2.0 ** (math.log2(MOST_PANELS) - self._start.log2_speed - self._start.exponent)
        return (
            "the attitude of this motion is integrated step by step, which is possible here "
            f"for |t| up to {limit:.3g}"
        )

    def _attitude(self, bits: int) -> Attitude:
        """The attitude as a function of time, its constants made once a precision."""
        if bits not in self._attitudes or self._by_panels:
            if self._answers.generic:
                self._attitudes[bits] = self._theta_attitude(bits)
            elif (period := self.period(math.ceil(bits / 3.3) + 4)) is not None:
                exact_period = exactly(period)
                panels = self._panels(bits, (-exact_period, exact_period))
                self._attitudes[bits] = PeriodicAttitude(panels, period)
            else:
                self._attitudes[bits] = self._panels(bits, self._span)
        return self._attitudes[bits]

    def _theta_attitude(self, bits: int) -> ThetaAttitude:
        """The attitude of generic motion at ``bits`` bits."""
        with mpmath.workprec(bits):
            rate = mpmath.ldexp(self._start.fastest(bits), self._start.exponent)
        return ThetaAttitude(
            formula=lambda more: self._formula(bits + more),
            bits=bits,
            start=self._first_quaternion(bits),
            turn=self._turn(bits),
            exponent=self._start.exponent,
            rate=rate,
            third=self._axes.third,
            coarse=lambda: self._formula(128),
            panels=self._counting_panels,
        )

    def _formula(self, bits: int) -> CayleyKlein:
        """The Cayley-Klein parameters at ``bits`` bits, with a set-up that certifies so many."""
        if bits not in self._formulas:
            more = 0
            before: int | None = None  # the size of the defect at fewer bits
            while True:
                solution, used = self._answers.solution(bits + CERTIFIED + more, bits)
                assert isinstance(solution, Generic)
                first = self._first_quaternion(used)
                with mpmath.workprec(used):
                    turn = conjugate(self._turn(used))
                    found = cayley_klein(self._start, solution, product(first, turn))
                    missed = found.defect and bits + int(mpmath.mag(found.defect))
                if not found.defect or missed <= 0:
                    self._formulas[bits] = found
                    break
                size = int(mpmath.mag(found.defect))
                if more > _MOST_MORE or (before is not None and size > before - 8):
                    raise ArithmeticError("the attitude's constants do not reproduce the start")
                more, before = more + missed + 16, size
        return self._formulas[bits]

    def _turn(self, bits: int) -> Quaternion:
        """The turn from the scene's axes to the top's."""
        with mpmath.workprec(bits):
            return of_matrix(self._axes.matrix(bits))

    def _counting_panels(self, t: Any) -> KovalevskayaAttitude:
        """Panels up to t, where turns about another axis than the top's must be counted."""
        time = exactly(t)
        if self._answers.phase((time,)) > math.log2(MOST_PANELS) + 1:
            raise ValueError(self._too_far())
        self._span = min(self._span[0], time), max(self._span[1], time)
        return self._panels(rounded_up(_COUNTING), self._span)

    def _panels(self, bits: int, span: tuple[Exact, Exact]) -> KovalevskayaAttitude:
        """The attitude by quadrature over panels, made once a precision."""
        solution, used, _, _ = self._answers.resolved(span, bits)
        known = self._made_panels.get(bits)
        if known is not None and known[0] is solution:
            return known[1]
        exponent = self._start.exponent

        def state(t: Any) -> tuple[Sequence[Any], Sequence[Any]]:
            with mpmath.workprec(used):
                row = self._placed(solution.at(mpmath.ldexp(t, exponent))[0], used)
            return row[:3], row[3:]

        start = self._first_quaternion(bits)
        with mpmath.workprec(bits):
            rate = mpmath.ldexp(self._start.fastest(bits), exponent)
            found = KovalevskayaAttitude(state, start, rate)
        self._made_panels[bits] = solution, found
        return found

    def _rows(self, times: Sequence[Exact], base: int) -> tuple[list[list[mpf]], mpf]:
        """Rows right to ``base`` bits, and the estimate of their error."""
        _, bits, states, worst = self._answers.resolved(times, base)
        return [self._placed(state, bits) for state in states], worst

    def _placed(self, state: Sequence[Any], bits: int) -> list[mpf]:
        """A state in the scene's axes and units."""
        exponent = self._start.exponent
        with mpmath.workprec(bits):
            matrix, weight = self._matrix(bits)
            w = [mpmath.ldexp(x, exponent) for x in state[:3]]
            return placed(matrix, w) + placed(matrix, [x / weight for x in state[3:]])

    def _matrix(self, bits: int) -> tuple[RowMatrix, mpf]:
        """The top's axes in the scene's, and n^2."""
        if bits not in self._matrices:
            matrix = self._axes.matrix(bits)
            self._matrices[bits] = matrix, number(self._start.weight, bits)
        return self._matrices[bits]

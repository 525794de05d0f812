"""The Kovalevskaya top in closed form: states, period, frequencies, and their certificate.

    I w' + w x I w = Mg gamma x r0,    gamma' = gamma x w,    I = diag(2C, 2C, C), r0 = (x0, y0, 0)

(Yehia 3.13-3.17).  w = (p, q, r) and the upward vertical gamma in body axes.  Any start, any time,
any number of digits: generic motion by genus-2 theta functions (Kowalevski, Acta Math. 12 (1889)
177), one-frequency motions by Weierstrass' functions, others on a degenerate curve as the mean of
two neighbours.  Units: any consistent set, angles in radians.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

from polhode.closed_forms._engine.axes import placed
from polhode.closed_forms._engine.closed_form import Rows
from polhode.closed_forms._engine.from_attitude import FromAttitude
from polhode.closed_forms._engine.precision import AtPrecision
from polhode.closed_forms._winding.euler_angles import Attitude
from polhode.closed_forms.functions.rounding import number, rounded_up, shortened
from polhode.closed_forms.kovalevskaya import regimes
from polhode.closed_forms.kovalevskaya.axes import top_axes
from polhode.closed_forms.kovalevskaya.certified_answers import CERTIFIED, Answers
from polhode.closed_forms.kovalevskaya.curve import KovalevskayaCurve, cubic_roots
from polhode.closed_forms.kovalevskaya.generic import Generic
from polhode.closed_forms.kovalevskaya.one_frequency import special
from polhode.common.cached_property import cached_property
from polhode.numbers.exact import Exact
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar
from polhode.scenes.body import Vector

if TYPE_CHECKING:
    from polhode.closed_forms.kovalevskaya.attitude.attitude_choice import Attitudes

_ZERO = Fraction(0)
_TURNING = 16  # bits that the attitude may lose beyond the phase


class KovalevskayaTop(FromAttitude):
    """The motion of one Kovalevskaya top from one start.

    ``regime`` is, of a generic motion, the type of its curve
    (:func:`polhode.closed_forms.kovalevskaya.regimes.regime`).
    """

    def _set_up(self, moments: Vector, torque: Vector, omega: Vector, axes: Rows | None) -> None:
        self._axes = top_axes(moments, torque, axes)
        self._start = self._axes.start(omega, self._gamma)
        self.regime = regimes.regime(self._start)
        self._answers = Answers(self._start, self.regime)
        self._matrix = AtPrecision(
            lambda bits: (self._axes.matrix(bits), number(self._start.weight, bits))
        )

    @cached_property
    def _attitudes(self) -> Attitudes:
        """Imported when first asked: states need none of their many formulas."""
        from polhode.closed_forms.kovalevskaya.attitude.attitude_choice import Attitudes

        return Attitudes(self._answers, self._axes, self._first_quaternion, self._placed)

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
        bits = rounded_up(self._answers.base(digits) + CERTIFIED)
        with mpmath.workprec(bits):
            period = self._period(bits)
        return shortened([period], digits)[0]

    def _period(self, bits: int) -> Scalar | None:
        if self.regime not in regimes.ONE_FREQUENCY:
            return None
        period = special(self._start, self.regime, bits).period
        return mpmath.ldexp(period, -self._start.exponent) if mpmath.isfinite(period) else None

    def frequencies(self, digits: int) -> dict[str, mpf]:
        """The motion's frequencies, radians a unit of time.

        Generic motion: "s1" and "s2", the mean rates at which the two separation variables go
        through their cycles; w and gamma repeat when both have made an even number of turns.
        One-frequency motion: "body".  Others: none.
        """
        made = self._curve(digits)
        if made is None:
            return super().frequencies(digits)
        with mpmath.workprec(rounded_up(self._answers.base(digits) + CERTIFIED)):
            both = [mpmath.ldexp(x, self._start.exponent) for x in made.frequencies]
        return dict(zip(("s1", "s2"), shortened(both, digits), strict=True))

    def curve(self, digits: int) -> dict[str, object]:
        """H, K^2 = k^2, the points e1, e2, e3 and the period matrix tau, in time units of 1/n.

        n is rounded to a power of two, 2^exponent.  tau is None on a degenerate curve.
        """
        made, bits = self._curve(digits), rounded_up(self._answers.base(digits) + CERTIFIED)
        found: dict[str, object] = {"exponent": self._start.exponent}
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
        """The precision of an attitude."""
        return rounded_up(self._answers.base(digits) + self._answers.phase(times) + _TURNING)

    def _turning(self, bits: int) -> Attitude:
        return self._attitudes.at(bits)

    def _rows(self, times: Sequence[Exact], base: int) -> tuple[list[list[mpf]], mpf]:
        """Rows right to ``base`` bits, and the estimate of their error."""
        _, bits, states, worst = self._answers.resolved(times, base)
        return [self._placed(state, bits) for state in states], worst

    def _placed(self, state: Sequence[Scalar], bits: int) -> list[mpf]:
        """A state in the scene's axes and units."""
        exponent = self._start.exponent
        with mpmath.workprec(bits):
            matrix, weight = self._matrix(bits)
            w = [mpmath.ldexp(x, exponent) for x in state[:3]]
            return placed(matrix, w) + placed(matrix, [x / weight for x in state[3:]])

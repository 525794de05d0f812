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
from typing import TYPE_CHECKING, Any

from polhode.closed_forms._engine.axes import RowMatrix, placed
from polhode.closed_forms._engine.from_attitude import FromAttitude
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

if TYPE_CHECKING:
    from polhode.closed_forms.kovalevskaya.attitude.attitude_choice import Attitudes

_ZERO = Fraction(0)
_TURNING = 16  # bits that the attitude may lose beyond the phase


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
        """The precision of an attitude."""
        return rounded_up(self._answers.base(digits) + self._answers.phase(times) + _TURNING)

    def _attitude(self, bits: int) -> Attitude:
        """The attitude as a function of time, its constants made once a precision."""
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

    def _matrix(self, bits: int) -> tuple[RowMatrix, mpf]:
        """The top's axes in the scene's, and n^2."""
        if bits not in self._matrices:
            matrix = self._axes.matrix(bits)
            self._matrices[bits] = matrix, number(self._start.weight, bits)
        return self._matrices[bits]

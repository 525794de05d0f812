"""States, quaternions and angles of a motion that knows its attitude as a function of time."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence

from polhode.closed_forms._engine.closed_form import ClosedForm
from polhode.closed_forms._engine.precision import AtPrecision
from polhode.closed_forms._winding.euler_angles import Attitude, angles
from polhode.closed_forms.functions.jacobi import MP
from polhode.closed_forms.functions.rounding import number, shortened
from polhode.common.cached_property import cached_property
from polhode.numbers.exact import Exact
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar


class FromAttitude(ClosedForm):
    """A closed form whose family gives the attitude at a precision (:meth:`_turning`).

    It begins at :meth:`_first_quaternion`.
    """

    @cached_property
    def _attitude(self) -> AtPrecision[Attitude]:
        """The attitude as a function of time, its constants made once a precision."""
        return AtPrecision(self._turning)

    @abstractmethod
    def _turning(self, bits: int) -> Attitude:
        """The attitude as a function of time, at the precision in force."""

    def attitude(self, times: Sequence[Exact], digits: int) -> list[list[mpf]]:
        bits = self._bits(times, digits)
        found = self._attitude(bits)
        with mpmath.workprec(bits):
            rows = [list(found.at(number(t, bits), MP)) for t in times]
        return [shortened(row, digits) for row in rows]

    def angles(self, times: Sequence[Exact], digits: int) -> list[list[mpf | None]]:
        bits = self._bits(times, digits)
        self._attitude(bits)
        with mpmath.workprec(bits):
            psi = number(self._psi, bits)
            phi = mpmath.atan2(number(self._gamma[0], bits), number(self._gamma[1], bits))

        def moment(t: Exact) -> Callable[[int], mpf]:
            return lambda prec: number(t, prec)

        rows = angles(self._attitude, [moment(t) for t in times], (psi, phi), self._sign, bits)
        return [[shortened([x], digits, absolute=True)[0] for x in row] for row in rows]


class FromMotion(FromAttitude):
    """One whose family gives the state too (:meth:`_state`)."""

    @abstractmethod
    def _state(self, t: Scalar, bits: int) -> list[Scalar]:
        """w and gamma in the scene's axes, at the precision in force."""

    def at(self, times: Sequence[Exact], digits: int) -> list[list[mpf]]:
        bits = self._bits(times, digits)
        with mpmath.workprec(bits):
            rows = [self._state(number(t, bits), bits) for t in times]
        return [shortened(row, digits) for row in rows]

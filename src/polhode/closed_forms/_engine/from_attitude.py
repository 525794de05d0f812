"""Quaternions and Euler angles of a closed form that knows its attitude as a function of time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence

from polhode.closed_forms._engine.initial_attitude import start_quaternion, start_sign
from polhode.closed_forms._winding.euler_angles import Attitude, angles
from polhode.closed_forms.functions.jacobi import MP
from polhode.closed_forms.functions.quaternion import Quaternion
from polhode.closed_forms.functions.rounding import number, shortened
from polhode.common.cached_property import cached_property
from polhode.numbers.exact import Exact
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.scenes.body import Vector


class FromAttitude(ABC):
    """The attitude R (body -> space, z up) of one motion, as quaternions and as angles.

    A family gives the attitude at a precision (:meth:`_attitude`), which begins at
    :meth:`_first_quaternion`, and the precision that times and digits need (:meth:`_bits`).
    ``gamma`` in the scene's axes and ``psi`` are those of t = 0; without ``gamma`` (a torque-free
    body of which only w is asked) the attitude is not known: ValueError.
    """

    def __init__(self, gamma: Vector | None, psi: Exact) -> None:
        self._known_gamma = gamma
        self._psi = psi

    def attitude(self, times: Sequence[Exact], digits: int) -> list[list[mpf]]:
        """Unit quaternions q0, q1, q2, q3 of R, one a time: q0 >= 0 at t = 0, then continuous.

        At t = 0, R = Rz(psi) Rx(theta) Rz(phi) with the psi given and phi = atan2(gamma1, gamma2).
        Where q0 = 0 at t = 0, the first component that is not 0 is positive.  The error is below
        10^-digits.  Raises ValueError without gamma, and where the work would grow beyond a limit
        (that of some motions of a Kovalevskaya top grows with time).
        """
        bits = self._bits(times, digits)
        found = self._attitude(bits)
        with mpmath.workprec(bits):
            rows = [list(found.at(number(t, bits), MP)) for t in times]
        return [shortened(row, digits) for row in rows]

    def angles(self, times: Sequence[Exact], digits: int) -> list[list[mpf | None]]:
        """Rows psi, theta, phi; psi and phi continuous in t, None where gamma is along axis 3.

        They start from the psi given and phi = atan2(gamma1, gamma2).  Passing through a pole, psi
        and phi jump by pi, and one of psi + phi, psi - phi stays continuous.  The error is below
        10^-digits.  Where the turns are not known in closed form they are counted: the work then
        grows with time, and beyond a limit ValueError is raised.
        """
        bits = self._bits(times, digits)
        self._attitude(bits)
        with mpmath.workprec(bits):
            psi = number(self._psi, bits)
            phi = mpmath.atan2(number(self._gamma[0], bits), number(self._gamma[1], bits))

        def moment(t: Exact) -> Callable[[int], mpf]:
            return lambda prec: number(t, prec)

        rows = angles(self._attitude, [moment(t) for t in times], (psi, phi), self._sign, bits)
        return [[shortened([x], digits, absolute=True)[0] for x in row] for row in rows]

    @abstractmethod
    def _attitude(self, bits: int) -> Attitude:
        """The attitude as a function of time, its constants made once a precision."""

    @abstractmethod
    def _bits(self, times: Sequence[Exact], digits: int) -> int:
        """The working precision of an attitude: the digits, what phases cost, a guard."""

    @property
    def _gamma(self) -> Vector:
        """gamma at t = 0 in the scene's axes."""
        if self._known_gamma is None:
            raise ValueError("this motion was given without gamma: only its omega is known")
        return self._known_gamma

    @cached_property
    def _sign(self) -> int:
        """Of the attitude against the Euler angles at t = 0."""
        return start_sign(self._gamma, self._psi)

    def _first_quaternion(self, bits: int) -> Quaternion:
        """The attitude at t = 0."""
        return start_quaternion(self._gamma, self._psi, self._sign, bits)

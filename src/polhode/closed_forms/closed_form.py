"""What every closed form is asked, and what all answer in the same way."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import TypeAlias

from polhode.numbers.exact import ZERO, Exact, Irrational
from polhode.numbers.mpmath_context import mpf
from polhode.numbers.vectors import Vector

#: rows[i] is the unit vector of principal axis i in the scene's axes; None: the same axes.
Rows: TypeAlias = tuple[tuple[Exact, ...], ...]


class ClosedForm(ABC):
    """The motion of one body from one start, in the scene's axes and units, to any digits.

    ``moments`` are the principal moments and ``torque`` is Mg r0 in principal axes; ``axes[i]`` is
    the unit vector of principal axis i in the scene's body axes (right-handed; None for the same
    axes).  ``omega``, ``gamma`` and ``psi`` are given at t = 0 in the scene's axes; ``gamma`` is
    None for a torque-free body of which only omega is asked.  Raises ValueError for a body and
    start that are not of the family.

    ``regime`` names the kind of motion; it is decided once, by exact arithmetic.  ``times`` are
    exact, of either sign and in any order; answers are mpf.  A question that the closed form cannot
    answer (a time beyond what its turns can be counted to, digits lost to an asymptotic motion, an
    attitude without gamma) raises ValueError, numbers that contradict each other ArithmeticError.

    A family gives :meth:`_set_up` and the answers.
    """

    regime: str
    #: Whether theorems and balls prove every digit, or a text that says what else they rest on;
    #: False: the digits are only reproduced, with more bits.
    proven: bool | str = False
    #: Whether a row costs so much that of a table of very many only some are judged.
    is_dear = False
    #: Whether it has the attitude too; else :meth:`attitude` and :meth:`angles` raise ValueError
    #: but at t = 0, and a reference encloses them.
    has_attitude = True

    def __init__(
        self,
        moments: Vector,
        torque: Vector,
        omega: Vector,
        gamma: Vector | None,
        psi: Exact = ZERO,
        axes: Rows | None = None,
    ) -> None:
        self._known_gamma, self._psi = gamma, psi
        self._set_up(moments, torque, omega, axes)

    @abstractmethod
    def _set_up(self, moments: Vector, torque: Vector, omega: Vector, axes: Rows | None) -> None:
        """Put the start into the motion's axes and name its regime; ValueError where it misses."""

    @property
    def held(self) -> tuple[str, ...]:
        """The family's conditions, all of which hold, where the family names them."""
        return ()

    @abstractmethod
    def at(self, times: Sequence[Exact], digits: int) -> list[list[mpf]]:
        """Rows p q r [gamma1 gamma2 gamma3], one a time.

        The error is below 10^-digits: of w relative to its largest modulus, of gamma absolute.
        """

    @abstractmethod
    def attitude(self, times: Sequence[Exact], digits: int) -> list[list[mpf]]:
        """Unit quaternions q0 q1 q2 q3, body -> space (z up), one a time; q0 >= 0 at t = 0.

        At t = 0, R = Rz(psi) Rx(theta) Rz(phi) with the psi given and phi = atan2(gamma1, gamma2).
        Where q0 = 0 at t = 0, the first component that is not 0 is positive; then continuous in
        time.  The error is below 10^-digits.
        """

    @abstractmethod
    def angles(self, times: Sequence[Exact], digits: int) -> list[list[mpf | None]]:
        """Rows psi, theta, phi; psi and phi continuous in t, None where gamma is along axis 3.

        They start from the psi given and phi = atan2(gamma1, gamma2).  Passing through a pole, psi
        and phi jump by pi, and one of psi + phi, psi - phi stays continuous.  The error is below
        10^-digits.  Where the turns are not known in closed form they are counted: the work then
        grows with time, and beyond a limit ValueError is raised.
        """

    @abstractmethod
    def period(self, digits: int) -> mpf | None:
        """The least period of omega in the body, in the scene's unit of time; None without any."""

    @abstractmethod
    def frequencies(self, digits: int) -> dict[str, mpf]:
        """The motion's frequencies by name, radians a unit of time; 2 pi over a period is "body".

        What else there is, a table of the guide's page on closed forms says.
        """

    @abstractmethod
    def error(self, digits: int, times: Sequence[Exact]) -> mpf:
        """A bound of the error of :meth:`at`, or its estimate where nothing is proven."""

    @abstractmethod
    def radii(self, times: Sequence[Exact], digits: int) -> list[list[mpf]] | None:
        """Proven bounds of the errors of :meth:`at`, number by number; None where it has none."""

    @property
    def assumed(self) -> tuple[Irrational, ...]:
        """The numbers that were called 0 by the rule for irrational numbers alone."""
        return ()

    def curve(self, digits: int) -> dict[str, object] | None:
        """The algebraic curve on which the motion is linear, where the family tells it."""
        del digits
        return None

    def approach(self, digits: int) -> mpf | None:
        """The rate at which the motion tends to a periodic one; None where it does not."""
        del digits
        return None

    @property
    def _gamma(self) -> Vector:
        """gamma at t = 0 in the scene's axes."""
        if self._known_gamma is None:
            raise ValueError("this motion was given without gamma: only its omega is known")
        return self._known_gamma

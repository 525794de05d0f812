"""What every closed form is asked, and what all answer in the same way: rows of balls."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Generic, Never, Protocol, TypeVar

from flint import arb

from polhode.closed_forms.balls.angles import Turning, angle_rows
from polhode.closed_forms.balls.core import (
    Kept,
    Refused,
    Row,
    ball,
    error_of,
    number,
    root,
    sure_rows,
    until_sure,
)
from polhode.closed_forms.balls.frames import Frame, Rows, Start, Turn, start_attitude, start_sign
from polhode.closed_forms.membership import PrincipalScene
from polhode.closed_forms.rounding import SPARE
from polhode.common.values import cached_property
from polhode.numbers.exact import ZERO, Exact, Irrational, noted, sign
from polhode.numbers.flint_context import ctx
from polhode.numbers.mpmath_context import mpf
from polhode.numbers.vectors import Vector, cross, dot, minus, momentum

if TYPE_CHECKING:
    from polhode.numbers.double_double import Pairs

#: What :attr:`ClosedForm.proven` says where the attitude has no formula.
ENCLOSED_ATTITUDE = "states are proven by the closed form, the attitude by an enclosure"
_ALONE = "the state has a closed form here, the attitude none: ask for reference.kind = certified"
_ERROR_BITS = 64
_SPARE = 5  # digits of frequencies, of which one may be much smaller than another


class Solution(Protocol):
    """A motion from its start, at one precision."""

    @property
    def speed(self) -> arb:
        """A bound of |w| over all time, and about its size; positive, 1 at rest."""
        ...

    def row(self, t: arb, attitude: bool) -> Sequence[arb]:
        """p q r [gamma1 gamma2 gamma3 [q0 q1 q2 q3]] in the scene's axes.

        gamma is in it wherever the scene has one.  The quaternion, continuous from the start's on,
        may be left out where it costs much and ``attitude`` does not ask for it.
        """
        ...


S = TypeVar("S", bound=Solution)


def no_attitude() -> Never:
    """Refuse the attitude of a motion of which only the state has a formula."""
    raise Refused(_ALONE)


class ClosedForm(Turning, Generic[S]):
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

    ``S`` is the family's own :class:`Solution`.  It gives ``_set_up`` (exact, with ``regime``,
    ``knows_turns`` and ``passes_poles``) and :meth:`_solved`, and what it knows of
    :meth:`_period_ball`, :meth:`_rate_balls` and :meth:`arguments_at`.  ``_solution()`` is what
    ``_solved`` made at the precision in force, ``_start()`` gamma and the quaternion at t = 0.

    ``assumed`` holds what was called 0 by the rule for irrational numbers alone, while the motion
    was made and asked: the digits are proven if those numbers are 0.
    """

    regime: str
    #: Whether theorems and balls prove every digit, or a text that says what else they rest on;
    #: False: the digits are only reproduced, with more bits.
    proven: bool | str = True
    #: Whether a row costs so much that of a table of very many only some are judged.
    is_dear = False
    #: Whether it has the attitude too; else :meth:`attitude` and :meth:`angles` raise ValueError
    #: but at t = 0, and a reference encloses them.
    has_attitude = True
    #: The conditions that body and start meet, where the family names them.
    held: tuple[str, ...] = ()
    _body = "body"  # the name of the frequency of a motion that has a period

    def __init__(
        self,
        moments: Vector,
        torque: Vector,
        omega: Vector,
        gamma: Vector | None,
        psi: Exact = ZERO,
        axes: Rows | None = None,
    ) -> None:
        self._called_zero: dict[int, Irrational] = {}
        self._omega, self._known_gamma, self._psi = omega, gamma, psi
        self._solution: Kept[S] = Kept(self._solved)
        self._start: Kept[Start] = Kept(self._first)
        self._sizes = Kept(self._made_sizes)
        self._last: tuple[list[Exact], int, list[Sequence[arb]]] = [], 0, []
        self._scene_axes = Frame(within=axes)
        with self._noting():
            into = self._scene_axes.into
            up = None if gamma is None else into(gamma)
            self._principal = PrincipalScene(moments, torque, into(omega), up)
            self._set_up(self._principal, axes)

    @abstractmethod
    def _set_up(self, scene: PrincipalScene, axes: Rows | None) -> None:
        """Put the start into the motion's axes and name its regime; ValueError where it misses."""

    @abstractmethod
    def _solved(self) -> S:
        """The motion at the precision in force."""

    @cached_property
    def _sign(self) -> int:
        """Of the attitude against the Euler angles at t = 0."""
        return start_sign(self._gamma, self._psi)

    def _period_ball(self) -> arb | None:
        """The period of omega at the precision in force; None where none is known."""
        return None

    def _rate_balls(self) -> Mapping[str, arb]:
        """The frequencies by name, at the precision in force."""
        period = self._period_ball()
        return {} if period is None else {self._body: 2 * arb.pi() / period}

    @property
    def rates_of(self) -> Mapping[str, str]:
        """Of which axis about which a frequency is, by its name, where the name leaves it open."""
        return {}

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

    def _most_bits(self, digits: int) -> int | None:
        """A cap on the bits of so many digits, in place of the usual one."""
        del digits
        return None

    @property
    def assumed(self) -> tuple[Irrational, ...]:
        """The numbers that were called 0 by the rule for irrational numbers."""
        return tuple(self._called_zero.values())

    def at(self, times: Sequence[Exact], digits: int) -> list[list[mpf]]:
        """Rows p q r [gamma1 gamma2 gamma3], one a time.

        The error is below 10^-digits: of w relative to its largest modulus, of gamma absolute.
        """
        rows = self._rows(times, digits, attitude=False)
        return [[number(x, digits) for x in row[: self._width]] for row in rows]

    def attitude(self, times: Sequence[Exact], digits: int) -> list[list[mpf]]:
        """Unit quaternions q0 q1 q2 q3, body -> space (z up), one a time; q0 >= 0 at t = 0.

        At t = 0, R = Rz(psi) Rx(theta) Rz(phi) with the psi given and phi = atan2(gamma1, gamma2).
        Where q0 = 0 at t = 0, the first component that is not 0 is positive; then continuous in
        time.  The error is below 10^-digits.
        """
        rows = self._rows(times, digits, attitude=True)
        return [[number(x, digits) for x in row[6:]] for row in rows]

    def pairs(self, times: Sequence[Exact], digits: int, *, attitude: bool) -> Pairs:
        """Rows of :meth:`at`, or of :meth:`attitude`, of numbers of two doubles each.

        Right to so many digits, at most :data:`polhode.numbers.double_double.DIGITS`.
        """
        from polhode.numbers.double_double import of_balls

        columns = slice(6, None) if attitude else slice(self._width)
        return of_balls([row[columns] for row in self._rows(times, digits, attitude=attitude)])

    def angles(self, times: Sequence[Exact], digits: int) -> list[list[mpf | None]]:
        """Rows psi, theta, phi; psi and phi continuous in t, None where gamma is along axis 3.

        They start from the psi given and phi = atan2(gamma1, gamma2).  Passing through a pole, psi
        and phi jump by pi, and one of psi + phi, psi - phi stays continuous.  The error is below
        10^-digits.  Where the turns are not known in closed form they are counted: the work then
        grows with time, and beyond a limit ValueError is raised.
        """
        gamma = self._gamma
        with self._noting():
            return angle_rows(self, gamma, self._psi, self._sign, times, digits)

    def radii(self, times: Sequence[Exact], digits: int) -> list[list[mpf]] | None:
        """Bounds of the errors of the numbers that :meth:`at` gives, rounded up.

        None where the balls hold an estimate: no bound is proven.
        """
        if self.proven is False:
            return None
        rows = self._rows(times, digits, attitude=False)
        return [[error_of(x, digits) for x in row[: self._width]] for row in rows]

    def error(self, digits: int, times: Sequence[Exact]) -> mpf:
        """A bound of the error of :meth:`at`, of w over its largest modulus, with the rounding."""
        rows = [row[: self._width] for row in self._rows(times, digits, attitude=False)]
        with ctx.workprec(_ERROR_BITS):
            unit = arb(10) ** -digits / 2**SPARE  # of the last bit that is kept, or more
            speed, worst = arb(0), arb(0)
            for x in (x for row in rows for x in row[:3]):
                speed = speed.max(abs(x).upper())
            for row in rows:
                for i, x in enumerate(row):
                    miss = x.rad() + abs(x).upper() * unit
                    worst = worst.max(miss / speed if i < 3 and speed > 0 else miss)
            return number(worst.mid(), 3)

    def period(self, digits: int) -> mpf | None:
        """The least period of omega in the body, in the scene's unit of time; None without any."""
        return self._one(self._period_ball, digits)

    def frequencies(self, digits: int) -> dict[str, mpf]:
        """The motion's frequencies by name, radians a unit of time; 2 pi over a period is "body".

        What else there is, a table of the guide's page on closed forms says.
        """
        return self._relative(self._rate_balls, digits)

    def row_at(self, t: arb, *, attitude: bool) -> Row:
        """A row and the sizes of its numbers, at the precision in force."""
        solution = self._solution()
        if t.is_zero():
            still = arb(1), arb(0), arb(0), arb(0)
            row = self._start().row([ball(x) for x in self._omega], still)
        else:
            row = solution.row(t, attitude)
        return row, self._sizes()

    def quaternion_at(self, t: arb) -> Turn:
        """The attitude at a time, at the precision in force."""
        q0, q1, q2, q3 = self.row_at(t, attitude=True)[0][6:]
        return q0, q1, q2, q3

    def leaving_side(self, sense: int) -> int:
        """By gamma x w, or gamma x w' where that is 0."""
        p, q, _ = self._omega
        if sign(p) == 0 == sign(q):
            sense, (_, q, _) = 1, self._slope()
        return sense * sign(q)

    def speed_bound(self) -> arb:
        """A bound of |w|, at the precision in force."""
        return self._solution().speed

    def slope_bound(self) -> arb | None:
        """By I w' = T - w x Iw, where w is along the third axis at t = 0."""
        p, q, _ = self._omega
        if sign(p) or sign(q):
            return None
        moments, torque, _, _ = self._principal
        speed = self.speed_bound()
        turning = root(dot(torque, torque)) + ball(max(moments)) * speed * speed
        return turning / ball(min(moments))

    def _rows(self, times: Sequence[Exact], digits: int, *, attitude: bool) -> list[Sequence[arb]]:
        """The rows asked for; those of the last question are kept."""
        if attitude:
            _ = self._gamma  # refuses where it is not known
        known, wanted, rows = self._last
        wide = not attitude or all(len(row) > 6 for row in rows)
        if not (wanted == digits and wide and known == list(times)):
            with self._noting():
                most = self._most_bits(digits)
                rows = sure_rows(lambda t: self.row_at(t, attitude=attitude), times, digits, most)
            self._last = list(times), digits, rows
        return rows

    def _made_sizes(self) -> list[arb]:
        """Those of a row's numbers, as many as it may have."""
        return [self._solution().speed] * 3 + [arb(1)] * 7

    @property
    def _width(self) -> int:
        """Of a row of :meth:`at`."""
        return 3 if self._known_gamma is None else 6

    def _slope(self) -> Vector:
        """w' at t = 0 in the scene's axes, exactly."""
        moments, torque, omega, gamma = self._principal
        assert gamma is not None
        turning = minus(cross(gamma, torque), cross(omega, momentum(moments, omega)))
        return self._scene_axes.out([x / a for x, a in zip(turning, moments, strict=True)])

    def _first(self) -> Start:
        """gamma and the attitude at t = 0, in the scene's axes."""
        if self._known_gamma is None:
            return Start(None, None)
        attitude = start_attitude(self._known_gamma, self._psi, self._sign)
        return Start([ball(x) for x in self._known_gamma], attitude)

    def _one(self, number_at: Callable[[], arb | None], digits: int) -> mpf | None:
        """A number that there may be, to so many digits."""

        def named() -> dict[str, arb]:
            x = number_at()
            return {} if x is None else {"": x}

        return self._relative(named, digits).get("")

    def _relative(self, numbers: Callable[[], Mapping[str, arb]], digits: int) -> dict[str, mpf]:
        """Numbers by name, to so many digits of the largest and some more."""
        names: list[str] = []

        def row() -> Row:
            named = numbers()
            names[:] = named
            largest = arb(0)
            for x in named.values():
                largest = largest.max(abs(x))
            return [*named.values()], [largest if largest > 0 else arb(1)] * len(named)

        with self._noting():
            found = until_sure(row, digits + _SPARE, self._most_bits(digits))
        return {name: number(x, digits) for name, x in zip(names, found, strict=True)}

    @contextmanager
    def _noting(self) -> Iterator[None]:
        """Keep what is called 0 by the rule meanwhile, and say of what a question is refused."""
        with noted() as met:
            try:
                yield
            except Refused as fault:
                raise Refused(f"{self.regime}: {fault}") from None
            finally:
                self._called_zero |= {id(x): x for x in met}

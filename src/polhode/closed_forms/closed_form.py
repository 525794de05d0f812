"""What every closed form is asked, and what all answer in the same way: rows of balls."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from flint import arb

from polhode.closed_forms.balls.angles import Arguments, Turning, angle_rows
from polhode.closed_forms.balls.core import (
    SPARE,
    Kept,
    Refused,
    Row,
    ball,
    enclosed,
    error_of,
    number,
    root,
    sure_rows,
    until_sure,
)
from polhode.closed_forms.balls.frames import (
    Frame,
    Motion,
    Rows,
    Turn,
    start_attitude,
    start_sign,
)
from polhode.closed_forms.balls.one_axis import OneAxis
from polhode.closed_forms.family import Placement
from polhode.closed_forms.membership import PrincipalScene
from polhode.common.values import cached_property
from polhode.numbers.exact import ONE, Exact, Irrational, noted, sign
from polhode.numbers.flint_context import ctx
from polhode.numbers.mpmath_context import mpf
from polhode.numbers.vectors import Vector, cross, dot, minus, momentum, quaternion_product

if TYPE_CHECKING:
    from polhode.numbers.double_double import Pairs

_ERROR_BITS = 64
_SPARE = 5  # digits of frequencies, of which one may be much smaller than another


class ClosedForm(Turning):
    """The motion of one body from one start, in the scene's axes and units, to any digits.

    ``place``: the scene in the axes and units of its family, whose ``solve`` makes the motion.
    ``omega``, ``gamma`` and ``psi`` are given at t = 0 in the scene's axes; ``gamma`` is None for a
    torque-free body of which only omega is asked.  ``axes[i]`` is the unit vector of principal axis
    i in the scene's body axes (right-handed; None for the same axes).  ``called_zero``: what the
    placing called 0 by the rule for irrational numbers.

    ``times`` are exact, of either sign and in any order; answers are mpf.  A question that the
    closed form cannot answer (a time beyond what its turns can be counted to, digits lost to an
    asymptotic motion, an attitude without gamma) raises ValueError, numbers that contradict each
    other ArithmeticError.
    """

    def __init__(
        self,
        place: Placement,
        solve: Callable[[Placement], Motion],
        scene: PrincipalScene,
        start: tuple[Vector, Vector | None, Exact],
        axes: Rows | None = None,
        called_zero: Iterable[Irrational] = (),
    ) -> None:
        self.place = place
        self._called_zero = {id(x): x for x in called_zero}
        self._principal, self._axes = scene, axes
        self._omega, self._known_gamma, self._psi = start
        self._frame = place.frame.seen_from(axes)
        self._has_units = place.unit != 1 or place.vertical is not ONE
        self._motion = Kept(lambda: solve(place))
        self._start = Kept(self._first)
        self._sizes = Kept(self._made_sizes)
        self._unit = Kept(lambda: ball(place.unit))
        self._vertical = Kept(lambda: enclosed(place.vertical))
        self._last: tuple[list[Exact], int, list[Sequence[arb]]] = [], 0, []

    @property
    def regime(self) -> str:
        """The kind of motion in words, decided by exact arithmetic."""
        return str(self.place.regime)

    @cached_property
    def _sign(self) -> int:
        """Of the attitude against the Euler angles at t = 0."""
        return start_sign(self._gamma, self._psi)

    def curve(self, digits: int) -> dict[str, object] | None:
        """The algebraic curve on which the motion is linear, where the family tells it."""
        numbers = self._relative(lambda: self._motion().curve(), digits)
        return self.place.curve_of(numbers) if numbers else None

    def approach(self, digits: int) -> mpf | None:
        """The rate at which the motion tends to a periodic one; None where it does not.

        Differences fall as exp(-rate t).
        """
        return self._one(lambda: self._motion().approach(), digits)

    @property
    def _gamma(self) -> Vector:
        """gamma at t = 0 in the scene's axes."""
        if self._known_gamma is None:
            raise ValueError("this motion was given without gamma: only its omega is known")
        return self._known_gamma

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
        if self.place.proven is False:
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
        return self._one(self._period, digits)

    def frequencies(self, digits: int) -> dict[str, mpf]:
        """The motion's frequencies by name, radians a unit of time; 2 pi over a period is "body".

        What else there is, a table of the guide's page on closed forms says.
        """

        def rates() -> dict[str, arb]:
            unit = abs(self._unit())
            return {name: rate * unit for name, rate in self._motion().rates().items()}

        return self._relative(rates, digits)

    def row_at(self, t: arb, *, attitude: bool) -> Row:
        """A row and the sizes of its numbers, at the precision in force.

        p q r [gamma1 gamma2 gamma3 [q0 q1 q2 q3]]: this alone brings a motion back to the scene's
        axes and units.
        """
        motion, start = self._motion(), self._start()
        if t.is_zero():
            return start, self._sizes()
        frame, now = self._frame, t
        vertical: Sequence[arb]
        if self._has_units:
            unit = self._unit()
            now = t * unit
            state = motion.at(now)
            row = frame.back([x * unit for x in state[:3]])
            vertical = [x / self._vertical() for x in state[3:]]
        else:
            state = motion.at(now)
            row, vertical = frame.back(state[:3]), state[3:]
        if len(start) > 3:
            row += frame.back(vertical)
        if attitude:
            q0, q1, q2, q3 = start[6:]
            row += quaternion_product((q0, q1, q2, q3), frame.turn(motion.turn(now, state)))
        return row, self._sizes()

    def quaternion_at(self, t: arb) -> Turn:
        """The attitude at a time, at the precision in force."""
        q0, q1, q2, q3 = self.row_at(t, attitude=True)[0][6:]
        return q0, q1, q2, q3

    @property
    def knows_turns(self) -> bool:
        """Of a motion about one axis, and about the third where that is the scene's."""
        place = self.place
        return place.axis is not None or (place.turns_about_third and self._own_side != 0)

    @property
    def passes_poles(self) -> bool:
        """Where the family's axis that passes the vertical is the scene's third."""
        passing = self.place.passing
        return passing is not None and self._frame.along_third(passing) != 0

    @cached_property
    def _own_side(self) -> int:
        """1 where the family's third axis is the scene's, -1 where it is its opposite, else 0."""
        return self._frame.along_third(2)

    @cached_property
    def _one_axis(self) -> OneAxis:
        """What is decided of a motion about one axis."""
        assert self.place.axis is not None
        return OneAxis(self._frame.out(self.place.axis), self._gamma)

    def arguments_at(self, t: arb) -> Arguments:
        """By the family's third axis, or the one about which the body turns."""
        motion, now = self._motion(), t * self._unit()
        if self.place.axis is None:
            alpha, beta = motion.arguments(now)
            return (alpha, beta) if self._own_side > 0 else (beta, alpha)
        q0, q1, q2, q3 = self._start()[6:]
        size = root(dot(self.place.axis, self.place.axis))
        along = [ball(x) if size.is_zero() else ball(x) / size for x in self.place.axis]
        x, y, z = self._frame.back(along)
        return self._one_axis.arguments((q0, q1, q2, q3), (x, y, z), motion.swung(now))

    def leaving_side(self, sense: int) -> int:
        """By gamma x w, or gamma x w' where that is 0."""
        p, q, _ = self._omega
        if sign(p) == 0 == sign(q):
            sense, (_, q, _) = 1, self._slope()
        return sense * sign(q)

    def speed_bound(self) -> arb:
        """A bound of |w|, at the precision in force."""
        return self._motion().speed * abs(self._unit())

    def slope_bound(self) -> arb | None:
        """By I w' = T - w x Iw, where w is along the third axis at t = 0."""
        p, q, _ = self._omega
        if sign(p) or sign(q):
            return None
        moments, torque, _, _ = self._principal
        speed = self.speed_bound()
        turning = root(dot(torque, torque)) + ball(max(moments)) * speed * speed
        return turning / ball(min(moments))

    def repeats(self) -> arb | None:
        """The period, where it is that of w and gamma."""
        return self._period() if self.place.repeats else None

    def _period(self) -> arb | None:
        period = self._motion().period
        return None if period is None else period / abs(self._unit())

    def _rows(self, times: Sequence[Exact], digits: int, *, attitude: bool) -> list[Sequence[arb]]:
        """The rows asked for; those of the last question are kept."""
        if attitude:
            _ = self._gamma  # refuses where it is not known
        last_times, last_digits, rows = self._last
        wide = not attitude or all(len(row) > 6 for row in rows)
        if not (last_digits == digits and wide and last_times == list(times)):
            with self._noting():
                most = self.place.most_bits(digits)
                rows = sure_rows(lambda t: self.row_at(t, attitude=attitude), times, digits, most)
            self._last = list(times), digits, rows
        return rows

    def _made_sizes(self) -> list[arb]:
        """Those of a row's numbers, as many as it may have."""
        return [self.speed_bound()] * 3 + [arb(1)] * 7

    @property
    def _width(self) -> int:
        """Of a row of :meth:`at`."""
        return 3 if self._known_gamma is None else 6

    def _slope(self) -> Vector:
        """w' at t = 0 in the scene's axes, exactly."""
        moments, torque, omega, gamma = self._principal
        assert gamma is not None
        turning = minus(cross(gamma, torque), cross(omega, momentum(moments, omega)))
        rates = [x / a for x, a in zip(turning, moments, strict=True)]
        return Frame(within=self._axes).out(rates)

    def _first(self) -> Sequence[arb]:
        """The row at t = 0."""
        row = [ball(x) for x in self._omega]
        if self._known_gamma is not None:
            row += [ball(x) for x in self._known_gamma]
            row += start_attitude(self._known_gamma, self._psi, self._sign)
        return row

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
            sure = until_sure(row, digits + _SPARE, self.place.most_bits(digits))
        return {name: number(x, digits) for name, x in zip(names, sure, strict=True)}

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

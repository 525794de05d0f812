"""What every closed form is asked, and what all answer in the same way: rows of balls."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from flint import arb

from polhode.closed_forms.balls.core import (
    SPARE,
    Kept,
    Refused,
    Row,
    ball,
    enclosed,
    error_of,
    number,
    sure_rows,
    until_sure,
)
from polhode.closed_forms.balls.frames import (
    Motion,
    Rows,
    Turn,
    euler_angles,
    nutation,
    start_attitude,
)
from polhode.closed_forms.family import Placement
from polhode.numbers.exact import EQUAL_BITS, ONE, Exact, Irrational, noted, sign
from polhode.numbers.flint_context import ctx
from polhode.numbers.mpmath_context import mpf
from polhode.numbers.vectors import Vector, quaternion_product

if TYPE_CHECKING:
    from polhode.numbers.double_double import Pairs


class _Constants(NamedTuple):
    """What rows are made with: omega and gamma at t = 0, the sizes of a row's numbers, as many as
    it may have, the unit of rates, and the length of the family's vertical."""

    start: list[arb]
    sizes: Sequence[arb]
    unit: arb
    length: arb


_ERROR_BITS = 64
_SPARE = 5  # digits of frequencies, of which one may be much smaller than another


class ClosedForm:
    """The motion of one body from one start, in the scene's axes and units, to any digits.

    ``place``: the scene in the axes and units of its family, whose ``solve`` makes the motion.
    ``omega``, ``gamma`` and ``psi`` are given at t = 0 in the scene's axes; ``gamma`` is None for a
    torque-free body of which only omega is asked.  ``axes[i]`` is the unit vector of principal axis
    i in the scene's body axes (right-handed; None for the same axes).  ``called_zero``: what the
    placing called 0 by the rule for irrational numbers.

    ``times`` are exact, of either sign and in any order; answers are mpf.  A question that the
    closed form cannot answer (digits lost to an asymptotic motion, an attitude without gamma)
    raises ValueError, numbers that contradict each other ArithmeticError.
    """

    def __init__(
        self,
        place: Placement,
        solve: Callable[[Placement], Motion],
        start: tuple[Vector, Vector | None, Exact],
        axes: Rows | None = None,
        called_zero: Iterable[Irrational] = (),
    ) -> None:
        self.place = place
        self._called_zero = {id(x): x for x in called_zero}
        self._omega, self._known_gamma, self._psi = start
        self._width = 3 if self._known_gamma is None else 6  # of a row of :meth:`at`
        self._frame = place.frame.seen_from(axes)
        self._has_units = place.unit != 1 or place.vertical is not ONE
        self._motion = Kept(partial(solve, place))
        self._constants = Kept(self._constants_now)
        self._first_turn = Kept(lambda: start_attitude(self._gamma, self._psi))
        self._last: tuple[list[Exact], int, list[Sequence[arb]]] = [], 0, []

    @property
    def regime(self) -> str:
        """The kind of motion in words, decided by exact arithmetic."""
        return str(self.place.regime)

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

    def angles(
        self,
        times: Sequence[Exact],
        digits: int,
        near: Sequence[Sequence[float | None]] | None = None,
    ) -> list[list[mpf | None]]:
        """Rows psi, theta, phi; psi and phi up to whole turns, None where gamma is along axis 3.

        ``near``: rows psi, theta, phi of about the motion, whose branches psi and phi then have;
        else they are in (-pi, pi].  The error is below 10^-digits.
        """
        _ = self._gamma  # refuses where it is not known
        rows: list[list[mpf | None]] = []
        with self._noting():
            for n, t in enumerate(times):
                psi, _, phi = (None, None, None) if near is None else near[n]
                rows.append(self._angles(t, digits, psi, phi))
        return rows

    def _angles(
        self, t: Exact, digits: int, psi: float | None, phi: float | None
    ) -> list[mpf | None]:
        """One row of :meth:`angles`."""

        def whole() -> Row:
            if sign(t) == 0:
                g1, g2, g3 = (ball(x) for x in self._gamma)
                if g1.is_zero() and g2.is_zero():
                    raise Refused("at a pole")
                across = (g1 * g1 + g2 * g2).sqrt()
                return (ball(self._psi), arb.atan2(across, g3), arb.atan2(g1, g2)), [arb(1)] * 3
            return euler_angles(self._turn_at(t), psi, phi), [arb(1)] * 3

        def tilt() -> Row:
            turn = self._turn_at(t) if sign(t) else self._first_turn()
            return [nutation(turn)], [arb(1)]

        try:
            row: Sequence[arb | None] = until_sure(whole, digits, EQUAL_BITS + 4 * digits)
        except Refused:  # a pole, or not told from one
            (theta,) = until_sure(tilt, digits)
            row = None, theta, None
        return [None if x is None else number(x, digits, absolute=True) for x in row]

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

        def least() -> arb | None:
            period = self._motion().period
            return None if period is None else period / abs(self._constants().unit)

        return self._one(least, digits)

    def frequencies(self, digits: int) -> dict[str, mpf]:
        """The motion's frequencies by name, radians a unit of time; 2 pi over a period is "body".

        What else there is, a table of the guide's page on closed forms says.
        """

        def rates() -> dict[str, arb]:
            unit = abs(self._constants().unit)
            return {name: rate * unit for name, rate in self._motion().rates().items()}

        return self._relative(rates, digits)

    def row_at(self, t: arb, *, attitude: bool) -> Row:
        """A row and the sizes of its numbers, at the precision in force.

        p q r [gamma1 gamma2 gamma3 [q0 q1 q2 q3]]: this alone brings a motion back to the scene's
        axes and units.
        """
        motion, (start, sizes, unit, length) = self._motion(), self._constants()
        if t.is_zero():
            return [*start, *self._first_turn()] if attitude else start, sizes
        frame, now = self._frame, t
        vertical: Sequence[arb]
        if self._has_units:
            now = t * unit
            state = motion.at(now)
            row = frame.back([x * unit for x in state[:3]])
            vertical = [x / length for x in state[3:]]
        else:
            state = motion.at(now)
            row, vertical = frame.back(state[:3]), state[3:]
        if len(start) > 3:
            row += frame.back(vertical)
        if attitude:
            row += quaternion_product(self._first_turn(), frame.turn(motion.turn(now, state)))
        return row, sizes

    def _turn_at(self, t: Exact) -> Turn:
        """The attitude at a time, at the precision in force."""
        q0, q1, q2, q3 = self.row_at(ball(t), attitude=True)[0][6:]
        return q0, q1, q2, q3

    def _rows(self, times: Sequence[Exact], digits: int, *, attitude: bool) -> list[Sequence[arb]]:
        """The rows asked for; those of the last question are kept."""
        if attitude:
            _ = self._gamma  # refuses where it is not known
        last_times, last_digits, rows = self._last
        wide = not attitude or all(len(row) > 6 for row in rows)
        if not (last_digits == digits and wide and last_times == list(times)):
            with self._noting():
                most = self.place.most_bits(digits)
                rows = sure_rows(partial(self.row_at, attitude=attitude), times, digits, most)
            self._last = list(times), digits, rows
        return rows

    def _constants_now(self) -> _Constants:
        """Those at the precision in force."""
        unit = ball(self.place.unit)
        start = [ball(x) for x in self._omega]
        if self._known_gamma is not None:
            start += [ball(x) for x in self._known_gamma]
        sizes = [self._motion().speed * abs(unit)] * 3 + [arb(1)] * 7
        return _Constants(start, sizes, unit, enclosed(self.place.vertical))

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

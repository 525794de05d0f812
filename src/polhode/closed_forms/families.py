"""The closed form that fits a scene, asked in the scene's own axes.

A closed form shares no code with the integrator: it reads the exact scene and nothing else.
FAMILIES lists polhode's own; :func:`register_family` adds one from outside.  A new one of polhode's
is a file or a folder beside this file, its row in FAMILIES, and one word in
:data:`polhode.scenes.vocabulary.REFERENCES`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from flint import arb

from polhode.closed_forms import euler, goryachev_chaplygin, hess, lagrange, pendulum
from polhode.closed_forms._one_orbit import (
    bobylev_steklov,
    chaplygin,
    goryachev,
    grioli,
    n_kowalewski,
    staude,
    steklov,
)
from polhode.closed_forms._one_orbit.orbits import NormalOrbit, OrbitMotion, orbit_family
from polhode.closed_forms.balls.core import (
    SPARE,
    Kept,
    Refused,
    Row,
    ball,
    enclosed,
    error_of,
    sure_rows,
    until_sure,
)
from polhode.closed_forms.balls.core import number as rounded
from polhode.closed_forms.balls.frames import (
    Rows,
    SolvedMotion,
    Turn,
    euler_angles,
    nutation,
    start_attitude,
)
from polhode.closed_forms.kovalevskaya import motion as kovalevskaya
from polhode.closed_forms.membership import (
    Condition,
    Family,
    Misfit,
    NormalScene,
    Placement,
    PrincipalScene,
    equal,
    in_principal_axes,
    positive,
)
from polhode.common.arguments import of_kind
from polhode.common.errors import BadInput
from polhode.numbers.conversion import to_mpf as number
from polhode.numbers.exact import EQUAL_BITS, ONE, Exact, Irrational, noted, sign
from polhode.numbers.flint_context import ctx
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.vectors import Vector, quaternion_product
from polhode.scenes import vocabulary
from polhode.scenes.scene import Scene

if TYPE_CHECKING:
    from polhode.numbers.double_double import Pairs

__all__ = [
    "FAMILIES",
    "ClosedForm",
    "Condition",
    "Family",
    "Misfit",
    "NormalOrbit",
    "NormalScene",
    "OrbitMotion",
    "PrincipalScene",
    "closed_form",
    "closed_forms",
    "equal",
    "misfit",
    "mpmath",
    "near",
    "number",
    "orbit_family",
    "positive",
    "register_family",
]

#: In the order in which a scene is tried; the first that fits is its reference.  Kovalevskaya's top
#: is the last of those that may fit its body: it has no formula for a pendulum's motions, permanent
#: rotations and Bobylev and Steklov's.  Families after it need not be asked about that body.
FAMILIES: tuple[Family, ...] = (
    euler.FAMILY,
    lagrange.FAMILY,
    pendulum.FAMILY,
    staude.FAMILY,
    bobylev_steklov.FAMILY,
    kovalevskaya.FAMILY,
    grioli.FAMILY,
    goryachev_chaplygin.FAMILY,
    hess.FAMILY,
    steklov.FAMILY,
    goryachev.FAMILY,
    n_kowalewski.FAMILY,
    chaplygin.FAMILY,
)

_NEAR = Fraction(1, 1000)
_ERROR_BITS = 64
_SPARE = 5  # digits of frequencies, of which one may be much smaller than another

# --- closed form ----------------------------------------------------------------------------------
#
# What every closed form is asked, and what all answer in the same way: rows of balls.


class _Constants(NamedTuple):
    """What rows are made with: omega and gamma at t = 0, the sizes of a row's numbers, as many as
    it may have, the unit of rates, and the length of the family's vertical."""

    start: list[arb]
    sizes: Sequence[arb]
    unit: arb
    length: arb


class ClosedForm:
    """The motion of one body from one start, in the scene's axes and units, to any digits.

    ``place``: the scene in the axes and units of its family.  ``start``: omega, gamma and psi at
    t = 0 in the scene's axes; gamma is None for a torque-free body of which only omega is asked.
    ``axes[i]`` is the unit vector of principal axis i in the scene's body axes (right-handed; None
    for the same axes).  ``called_zero``: what the placing called 0 by the rule for irrational
    numbers.

    ``times`` are exact, of either sign and in any order; answers are mpf.  A question that the
    closed form cannot answer (digits lost to an asymptotic motion, an attitude without gamma)
    raises ValueError, numbers that contradict each other ArithmeticError.
    """

    def __init__(
        self,
        place: Placement,
        start: tuple[Vector, Vector | None, Exact],
        axes: Rows | None = None,
        called_zero: Iterable[Irrational] = (),
    ) -> None:
        self.place = place
        #: The kind of motion in words, decided by exact arithmetic.
        self.regime = str(place.regime)
        self._called_zero = {id(x): x for x in called_zero}
        self._omega, self._known_gamma, self._psi = start
        self._width = 3 if self._known_gamma is None else 6  # of a row of :meth:`at`
        self._frame = place.frame.seen_from(axes)
        self._has_units = place.unit != 1 or place.vertical is not ONE
        self._motion = Kept(place.solve)
        self._constants = Kept(self._constants_now)
        self._first_turn = Kept(lambda: start_attitude(self._gamma, self._psi))
        self._last: tuple[list[Exact], int, list[Sequence[arb]]] = [], 0, []

    def curve(self, digits: int) -> dict[str, object] | None:
        """The algebraic curve on which the motion is linear, where the family tells it."""
        curve = self.place.curve
        return None if curve is None else curve(partial(self._numbers, digits))

    def approach(self, digits: int) -> mpf | None:
        """The rate at which the motion tends to a periodic one; None where it does not.

        Differences fall as exp(-rate t).
        """
        return self._numbers(digits, lambda motion: {"approach": motion.approach}).get("approach")

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
        return [[rounded(x, digits) for x in row[: self._width]] for row in rows]

    def attitude(self, times: Sequence[Exact], digits: int) -> list[list[mpf]]:
        """Unit quaternions q0 q1 q2 q3, body -> space (z up), one a time; q0 >= 0 at t = 0.

        At t = 0, R = Rz(psi) Rx(theta) Rz(phi) with the psi given and phi = atan2(gamma1, gamma2).
        Where q0 = 0 at t = 0, the first component that is not 0 is positive; then continuous in
        time.  The error is below 10^-digits.
        """
        rows = self._rows(times, digits, attitude=True)
        return [[rounded(x, digits) for x in row[6:]] for row in rows]

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
        return [None if x is None else rounded(x, digits, absolute=True) for x in row]

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
            return rounded(worst.mid(), 3)

    def period(self, digits: int) -> mpf | None:
        """The least period of omega in the body, in the scene's unit of time; None without any."""
        unit = abs(self.place.unit)

        def least(motion: SolvedMotion) -> Mapping[str, arb | None]:
            return {"period": None if motion.period is None else motion.period / ball(unit)}

        return self._numbers(digits, least).get("period")

    def frequencies(self, digits: int) -> dict[str, mpf]:
        """The motion's frequencies by name, radians a unit of time; 2 pi over a period is "body".

        What else there is, a table of the guide's page on closed forms says.
        """
        unit = abs(self.place.unit)

        def rates(motion: SolvedMotion) -> Mapping[str, arb | None]:
            return {name: rate * ball(unit) for name, rate in motion.rates().items()}

        return self._numbers(digits, rates)

    def row_at(self, t: arb, *, attitude: bool) -> Row:
        """A row and the sizes of its numbers, at the precision in force.

        p q r [gamma1 gamma2 gamma3 [q0 q1 q2 q3]]: this alone brings a motion back to the scene's
        axes and units.
        """
        motion, (start, sizes, unit, length) = self._motion(), self._constants()
        if t.is_zero():
            return [*start, *self._first_turn()] if attitude else start, sizes
        frame, now = self._frame, t * unit
        state = motion.at(now)
        omega, vertical = state[:3], state[3:]
        if self._has_units:  # most have none, and rows are many
            omega, vertical = [x * unit for x in omega], [x / length for x in vertical]
        row = frame.back(omega)
        if len(start) > 3:
            row += frame.back(vertical)
        if attitude:
            row += quaternion_product(self._first_turn(), frame.turn(motion.turn(now)))
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
        wide = not attitude or not rows or len(rows[0]) > 6
        if not (last_digits == digits and wide and last_times == list(times)):
            with self._noting():
                row = partial(self.row_at, attitude=attitude)
                rows = sure_rows(row, times, digits, self._most_bits(digits))
            self._last = list(times), digits, rows
        return rows

    def _most_bits(self, digits: int) -> int | None:
        """A cap on the bits of so many digits, in place of the usual one."""
        cap = self.place.cap
        return None if cap is None else cap[0] * digits + cap[1]

    def _constants_now(self) -> _Constants:
        """Those at the precision in force."""
        unit = ball(self.place.unit)
        start = [ball(x) for x in self._omega]
        if self._known_gamma is not None:
            start += [ball(x) for x in self._known_gamma]
        sizes = [self._motion().speed * abs(unit)] * 3 + [arb(1)] * 7
        return _Constants(start, sizes, unit, enclosed(self.place.vertical))

    def _numbers(
        self, digits: int, numbers: Callable[[SolvedMotion], Mapping[str, arb | None]]
    ) -> dict[str, mpf]:
        """Those of the motion that there are, to so many digits of the largest and some more."""
        names: list[str] = []

        def row() -> Row:
            named = {k: x for k, x in numbers(self._motion()).items() if x is not None}
            names[:] = named
            largest = arb(0)
            for x in named.values():
                largest = largest.max(abs(x))
            return [*named.values()], [largest if largest > 0 else arb(1)] * len(named)

        with self._noting():
            sure = until_sure(row, digits + _SPARE, self._most_bits(digits))
        return {name: rounded(x, digits) for name, x in zip(names, sure, strict=True)}

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


# --- families -------------------------------------------------------------------------------------


def register_family(family: Family) -> None:
    """Add your own family of closed forms to this process.

    It is tried after polhode's own families, and can be chosen by its name in ``reference.kind``.
    A package whose entry points have it in the group ``polhode.families`` provides it to every
    process, including the command line.

    Parameters
    ----------
    family : Family
        Its name, how it places a scene, with what solves the motion, and why another does not
        fit; :func:`orbit_family` makes one of a class of periodic motions.

    Raises
    ------
    BadInput
        Something that is no family, or a name that another family has.

    Notes
    -----
    ``polhode guide closed-forms`` shows an example.  A closed form is a reference: runs are judged
    by it, and only its author's tests check it.

    Examples
    --------
    >>> import polhode
    >>> from polhode.closed_forms.families import FAMILIES
    >>> polhode.register_family(FAMILIES[0])
    Traceback (most recent call last):
    ...
    polhode.common.errors.BadInput: register_family: name = euler: expected one that no family has
    """
    of_kind("register_family", "family", family, Family, "a Family")
    vocabulary.add(family.name, family)


def known_families() -> Iterator[Family]:
    """polhode's own, then those from outside; raises BadInput for what is none."""
    yield from FAMILIES
    for family in vocabulary.added():
        if not isinstance(family, Family):
            raise BadInput(vocabulary.GROUP, "family", repr(family), "a Family")
        yield family


def closed_form(scene: Scene, kind: str = "auto") -> tuple[str, ClosedForm] | None:
    """The name and the closed form of the first family that fits body and start, if any does.

    ``kind`` asks for one family by name.
    """
    return next(closed_forms(scene, kind), None)


def closed_forms(scene: Scene, kind: str = "auto") -> Iterator[tuple[str, ClosedForm]]:
    """Name and closed form of every family that fits body and start, in their order."""
    principal = in_principal_axes(scene)
    start = scene.omega, scene.gamma, scene.psi
    axes = None if scene.body.axes.trivial else scene.body.axes.rows
    for family in known_families():
        if kind in ("auto", family.name):
            form = form_of(family, principal, start, axes)
            if form is not None:
                yield family.name, form


def form_of(
    family: Family,
    principal: PrincipalScene,
    start: tuple[Vector, Vector | None, Exact],
    axes: Rows | None = None,
) -> ClosedForm | None:
    """The closed form of a scene that belongs to the family; None of one that does not.

    ``start``: omega, gamma and psi at t = 0 in the scene's axes; ``axes``: the principal ones in
    them, None where they are the same.
    """
    with noted() as called_zero:
        place = family.place(principal)
    if place is None:
        return None
    return ClosedForm(place, start, axes, called_zero)


def misfit(scene: Scene, kind: str) -> Misfit | None:
    """Why a scene does not belong to the family of that name, where that family can say it."""
    for family in known_families():
        if family.name == kind:
            return family.misfit(in_principal_axes(scene))
    return None


def near(scene: Scene, within: Fraction = _NEAR) -> list[tuple[str, Misfit]]:
    """The families that a scene is near to, each with its Misfit.

    Near: all conditions hold up to ``within``, but not all of them exactly.
    """
    principal = in_principal_axes(scene)
    misfits = ((family.name, family.misfit(principal)) for family in known_families())
    return [(name, miss) for name, miss in misfits if miss is not None and miss.within(within)]

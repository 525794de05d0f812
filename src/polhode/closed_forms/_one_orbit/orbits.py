"""Orbits in balls whose time is an elliptic argument, or an integral over an angle."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from enum import StrEnum
from functools import partial
from typing import ClassVar, NamedTuple, Protocol

from flint import acb, acb_poly, arb
from mpmath import libmp

from polhode.closed_forms.balls.clocks import Factors, Oscillating
from polhode.closed_forms.balls.core import TooFewBits, around, ball, certainly, root, square
from polhode.closed_forms.balls.frames import MotionAxes, SolvedMotion
from polhode.closed_forms.balls.jacobi import Jacobi
from polhode.closed_forms.balls.periodic_attitude import (
    BallEquations,
    PeriodicMotion,
    PeriodicOrbit,
    Strip,
)
from polhode.closed_forms.balls.weierstrass import complex_functions
from polhode.closed_forms.membership import (
    ALL_AXES,
    Condition,
    Family,
    NormalAxes,
    NormalScene,
    Placement,
    PrincipalScene,
    in_usual_units,
    placed_in,
    shortfall,
)
from polhode.numbers.exact import ONE, Exact, noted, sign
from polhode.numbers.flint_context import ctx
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.number_types import Scalar
from polhode.numbers.vectors import Vector

# --- gamma from omega -----------------------------------------------------------------------------
#
# What the families with one orbit per body share: their axes, their orbits, their gamma.
#
#     I w' + w x I w = Mg gamma x r0,    gamma' = gamma x w        (Yehia 3.13-3.17)
#
# A family says in which axes it has its normal form (:mod:`..membership`) and gives w, gamma and
# the turn of the body there.


def orbit_family(name: str, case: type[OrbitCase]) -> Family:
    """A family of that name, of one class of cases."""

    def place(scene: PrincipalScene) -> Placement | None:
        usual, unit = in_usual_units(scene)
        for frame, permuted in case.views(usual):
            with noted():  # what is decided of other axes does not matter
                fitting = placed_in(case.conditions, permuted, case.candidates)
            if fitting is not None:
                axes, normal = fitting
                orbit, side = case(normal), axes.determinant
                return Placement(
                    regime=orbit.regime,
                    solve=orbit.solve,
                    frame=frame.numbered(axes.order, [side * s for s in axes.signs]),
                    unit=unit,
                    vertical=side * ONE,
                    held=orbit.held,
                    proven=case.proven,
                    rates_of=case.rates_of,
                )
        return None

    return Family(name, place, partial(shortfall, case.conditions))


class OrbitCase(ABC):
    """A heavy body and its start, ``normal``, in the axes of a family's normal form.

    They are in units of their own where doubles do not hold them.  A family says its conditions in
    the axes of its normal form, the name of the motion, and the motion there, a periodic one by
    :meth:`_on`.
    """

    #: The axes that may be those of the normal form.
    candidates: Sequence[NormalAxes] = ALL_AXES
    #: The name of the motion, where there is one kind alone.
    name: str
    #: As of a :class:`Placement`.
    proven = True
    rates_of: ClassVar[Mapping[str, str]] = {}

    def __init__(self, normal: NormalScene) -> None:
        self.normal = normal
        self.regime = self._regime()
        #: The conditions that are met.
        self.held = tuple(condition.text for condition in self.conditions(normal))
        # |w|^2 <= 2 (H + P)/I_min with P = |Mg r0|
        self._speed2 = 2 * (normal.energy + normal.weight) / min(normal.moments)
        self._strips: list[Strip] = []

    @classmethod
    def views(cls, scene: PrincipalScene) -> Iterator[tuple[MotionAxes, PrincipalScene]]:
        """The principal axes that are tried, and the scene in them: of a symmetric body any are."""
        yield MotionAxes(), scene

    @staticmethod
    @abstractmethod
    def conditions(scene: NormalScene) -> Iterator[Condition]:
        """What the family asks of a scene in the axes of its normal form, in order."""

    def _regime(self) -> StrEnum | str:
        """The kind of motion; its name, where there is one alone."""
        return self.name

    @abstractmethod
    def solve(self) -> SolvedMotion:
        """The motion in the normal axes, at the precision in force."""

    def _speed(self) -> arb:
        """A bound of |w|; positive, 1 at rest."""
        return root(self._speed2) if sign(self._speed2) else arb(1)

    def _on(self, orbit: PeriodicOrbit) -> SolvedMotion:
        """The motion on an orbit that solves the equations."""
        return PeriodicMotion(orbit, self._speed(), self._equations, self._strips)

    def _equations(self) -> BallEquations | None:
        """The body's, at the precision in force."""
        moments, torque = ([ball(x) for x in v] for v in (self.normal.moments, self.normal.torque))
        return BallEquations(moments, torque)


# --- gamma ----------------------------------------------------------------------------------------
#
# gamma of a motion whose q^2 and r^2 are polynomials in p, the centre of mass on axis 1.
#
# With Mg r0 = (c, 0, 0), q^2 = Q(p), r^2 = R(p), p' = (B - C) q r/A and the energy h, Euler's
# equations give
#
#     c gamma1 = h - (A p^2 + B Q + C R)/2,
#     c gamma2 = q [(A - B) p - C (B - C) R'/2A],
#     c gamma3 = r [(A - C) p + B (B - C) Q'/2A].


def value(polynomial: Sequence[Scalar], x: Scalar) -> Scalar:
    """The value of a polynomial, coefficients from the constant one up (Horner)."""
    total = polynomial[-1]
    for c in reversed(polynomial[:-1]):
        total = total * x + c
    return total


def slope(polynomial: Sequence[Scalar]) -> list[Scalar]:
    """The derivative's coefficients."""
    return [n * c for n, c in enumerate(polynomial)][1:]


class GammaOfOmega(NamedTuple):
    """gamma as polynomials in p, times q and r; any scalars (:func:`gamma_of_omega`)."""

    one: Sequence[Scalar]
    two: Sequence[Scalar]
    three: Sequence[Scalar]
    Q: Sequence[Scalar]
    R: Sequence[Scalar]

    def gamma(self, p: Scalar, q: Scalar, r: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        """gamma1, gamma2, gamma3."""
        return value(self.one, p), q * value(self.two, p), r * value(self.three, p)

    def matching(self, scene: NormalScene) -> Iterator[Condition]:
        """The scene's q^2, r^2 and gamma are these."""
        squares = [value(x, scene.omega[0]) for x in (self.Q, self.R)]
        yield from scene.matching(self.gamma(*scene.omega), squares)

    def mapped(self, convert: Callable[[Exact], Scalar]) -> GammaOfOmega:
        """The same with its numbers converted."""
        rows = (self.one, self.two, self.three, self.Q, self.R)
        return GammaOfOmega(*([convert(x) for x in row] for row in rows))


def gamma_of_omega(
    moments: Vector, c: Exact, h: Exact, Q: Sequence[Exact], R: Sequence[Exact]
) -> GammaOfOmega:
    """The polynomials, exact; the degree of R is not below that of Q, nor below 2."""
    A, B, C = moments
    first = [-C * x / (2 * c) for x in R]
    for n, x in enumerate(Q):
        first[n] = first[n] - B * x / (2 * c)
    first[0], first[2] = first[0] + h / c, first[2] - A / (2 * c)
    second = [-C * (B - C) * x / (2 * A * c) for x in slope(R)]
    third = [B * (B - C) * x / (2 * A * c) for x in slope(Q)]
    second[1] = second[1] + (A - B) / c
    third[1] = third[1] + (A - C) / c
    return GammaOfOmega(first, second, third, Q, R)


# --- orbits ---------------------------------------------------------------------------------------


#: p, q, r, gamma1, gamma2, gamma3 of sn, cn, dn, or of the three numbers of a flow.
Formula = Callable[[acb, acb, acb], Sequence[acb]]

_SPARE = 20  # bits of zeros of polynomials
_FEWER = 24  # bits of the second precision of a family of one's own


class EllipticTime(NamedTuple):
    """sn, cn, dn at t = 0 by the signs of the first two and all their squares, and the rate of v.

    ``m`` and ``m1`` are the parameter and its complement, each exact.
    """

    m: Exact
    m1: Exact
    sides: tuple[int, int]
    squares: tuple[Exact, Exact, Exact]
    rate2: Exact

    def orbit(self, formula: Formula, quarters: int = 4) -> PeriodicOrbit:
        """The orbit, which repeats after so many quarter periods, at the precision in force."""
        functions, rate = Jacobi(ball(self.m), ball(self.m1)), root(self.rate2)
        v0 = self.phase(functions)

        def state(t: acb) -> Sequence[acb]:
            return formula(*complex_functions(functions, v0 + rate * t))

        return PeriodicOrbit(state, quarters * functions.K / rate)

    def phase(self, functions: Jacobi) -> arb:
        """v at t = 0, in (-2K, 2K]."""
        sine, cosine = self.sides
        v = functions.argument(map(ball, self.squares), sine)
        if cosine >= 0:
            return v
        return (2 if sine >= 0 else -2) * functions.K - v


class _Factor:
    """Q or R between z1 and z2, without those of its zeros that they are."""

    def __init__(self, zeros: Sequence[acb], lead: arb, low: arb, high: arb) -> None:
        wide = high - low
        self.roots, self.pairs = [], []
        self._scale, self._linear = abs(lead), list[tuple[acb, acb]]()
        for zero in zeros:
            if not zero.imag.is_zero():
                # 1 at one end: on an ellipse without its zero the principal root is then smooth.
                first = low - zero
                self._scale *= abs(first)
                self._linear.append((acb(1), wide / first))
                if zero.imag > 0:
                    self.pairs.append((zero.real, square(zero.imag)))
                continue
            side = 1 if low > zero.real else -1
            self.roots.append((side, zero.real))
            self._linear.append((acb(side * (low - zero.real)), acb(side * wide)))

    def root(self, y: acb) -> acb:
        """The square root at z1 + (z2 - z1) y."""
        value = acb(self._scale.sqrt())
        for first, slope in self._linear:
            value *= (first + slope * y).sqrt()
        return value


class FlowOrbit(PeriodicOrbit):
    """The state in z, y, w of z' = k y w, y^2 = Q(z), w^2 = R(z), at the precision in force.

    Between two neighbouring zeros of QR, z = z1 + (z2 - z1) sin^2(x/2), and the angle x is the
    phase; y and w have the factors sin(x/2), cos(x/2) of the zeros that are theirs.  ``start``
    is z, y, w at t = 0; coefficients stand from the constant one up.  Numbers are of order 1.
    """

    def __init__(
        self,
        polynomials: tuple[Sequence[Exact], Sequence[Exact]],
        k: arb,
        start: tuple[Exact, Exact, Exact],
        formula: Formula,
    ) -> None:
        self._formula, self._pace = formula, 1 / abs(k)
        z0, (y0, w0) = ball(start[0]), (sign(x) for x in start[1:])
        roots = [zeros(polynomial) for polynomial in polynomials]
        low, high = _ends(roots, polynomials, z0, (y0, w0))
        self._low, self._wide = low.place, high.place - low.place
        self._ends = [(low.which == n, high.which == n) for n in (0, 1)]
        leads = [ball(polynomial[-1]) for polynomial in polynomials]
        self._factors = []
        for row, lead in zip(roots, leads, strict=True):
            rest = [z for z in row if z is not low.zero and z is not high.zero]
            self._factors.append(_Factor(rest, lead, low.place, high.place))
        of_q, of_r = self._factors
        scale = self._pace * abs(leads[0] * leads[1]).rsqrt()
        factors = Factors((*of_q.roots, *of_r.roots), (*of_q.pairs, *of_r.pairs), scale)
        self._clock = Oscillating(low.place, high.place, factors)
        sense = 1 if k > 0 else -1
        side = sense * y0 * w0 or 1  # of sin(x/2); cos(x/2) is not negative
        y_side, w_side = (side if mine else 1 for mine, _ in self._ends)
        first = y0 * y_side or sense * w0 * w_side
        self._sides = first, sense * first
        sine, cosine = (abs(z0 - low.place).sqrt(), abs(high.place - z0).sqrt())
        turns = 1 if any(mine == last for mine, last in self._ends) else 2
        super().__init__(self._state, 2 * turns * self._clock.S[-1])
        self.cycle = 2 * turns * arb.pi()
        self.begin = self._clock.at(2 * arb.atan2(side * sine, cosine)).S

    def phase(self, t: arb) -> arb:
        """x at a time since x = 0."""
        return self._clock.phase(t)

    def pace(self, s: acb) -> acb:
        """dt/dx."""
        sine = (s / 2).sin()
        of_q, of_r = (factor.root(sine * sine) for factor in self._factors)
        return self._pace / (of_q * of_r)

    def _state(self, s: acb) -> Sequence[acb]:
        """p, q, r, gamma1, gamma2, gamma3."""
        sine, cosine = (s / 2).sin(), (s / 2).cos()
        size, y = self._wide.sqrt(), sine * sine
        roots = []
        for side, factor, (low, high) in zip(self._sides, self._factors, self._ends, strict=True):
            value = side * factor.root(y)
            value = value * size * sine if low else value
            roots.append(value * size * cosine if high else value)
        return self._formula(self._low + self._wide * y, *roots)


class _End(NamedTuple):
    """A real zero, of which polynomial it is, and the ball that it was."""

    place: arb
    which: int
    zero: acb


def _ends(
    roots: Sequence[Sequence[acb]],
    polynomials: Sequence[Sequence[Exact]],
    z0: arb,
    sides: Sequence[int],
) -> tuple[_End, _End]:
    """The zeros next to z0, below and above; z0 itself where its root is exactly 0 there."""
    below: list[_End] = []
    above: list[_End] = []
    for which, row in enumerate(roots):
        for zero in row:
            end = _End(zero.real, which, zero)
            if not zero.imag.is_zero():
                continue
            if zero.real < z0:
                below.append(end)
            elif zero.real > z0:
                above.append(end)
            elif sides[which]:
                raise TooFewBits
            else:
                # The motion is on the side on which the polynomial is positive.
                slope = acb_poly([ball(x) for x in polynomials[which]]).derivative()(acb(z0)).real
                certainly(not slope.contains(0))
                (below if slope > 0 else above).append(end._replace(place=z0))
    return _last(below, 1), _last(above, -1)


def _last(ends: Sequence[_End], side: int) -> _End:
    """The one that is proven to be farthest on a side."""
    for candidate in ends:
        if all(candidate is rival or side * (candidate.place - rival.place) > 0 for rival in ends):
            return candidate
    raise TooFewBits


def zeros(polynomial: Sequence[Exact]) -> list[acb]:
    """The zeros of a real polynomial with simple ones; real ones have the imaginary part 0."""
    bits = ctx.prec
    with ctx.workprec(2 * bits + 64):
        try:
            roots = acb_poly([ball(x) for x in polynomial]).roots(tol=arb(2) ** -(bits + _SPARE))
        except ValueError:
            raise TooFewBits from None
    return [_real_or_not(z, roots) for z in roots]


def _real_or_not(z: acb, zeros: Sequence[acb]) -> acb:
    """The conjugate of a zero is one: where no other ball holds it, it is the zero itself."""
    if not z.imag.contains(0):
        return z
    if sum(z.conjugate().overlaps(zero) for zero in zeros) > 1:
        raise TooFewBits
    return acb(z.real)


# --- one's own ------------------------------------------------------------------------------------
#
# A family of one's own, in mpmath's functions: the digits are reproduced, not proven.
#
# The orbit is asked at two precisions, and what they differ by is taken for the error: more bits
# are asked for until it is small.  The attitude of a periodic one comes from a Fourier series of an
# azimuth (:mod:`..balls.periodic_attitude`).


class NormalOrbit(Protocol):
    """The motion in the axes of the normal form, at one precision."""

    @property
    def period(self) -> Scalar | None:
        """Of w and gamma; None where there is none."""
        ...

    def at(self, t: Scalar) -> Sequence[Scalar]:
        """p, q, r, gamma1, gamma2, gamma3."""
        ...


class OrbitMotion(OrbitCase):
    """The motion of one heavy body from one start in a closed form of your own.

    A family says its conditions in the axes of its normal form, the name of the motion
    (``_regime``) and the orbit there (``_orbit``).  An orbit without period has no attitude.
    """

    proven = False

    @abstractmethod
    def _orbit(self, bits: int) -> NormalOrbit:
        """The motion in the normal axes, at a precision of mpmath's that is in force."""

    def solve(self) -> SolvedMotion:
        motion = _Estimated(self._orbit)
        start = (*self.normal.omega, *self.normal.gamma)
        sizes = (*[self._speed()] * 3, *[arb(1)] * 3)
        doubt = arb(2) ** -(ctx.prec // 2)
        for x, y, size in zip(motion.at(arb(0)), start, sizes, strict=True):
            if abs(x - ball(y)) > doubt * size:
                raise ArithmeticError("the closed form does not reproduce the start")
        return self._on(PeriodicOrbit(lambda t: [acb(x) for x in motion.at(t.real)], motion.period))

    def _equations(self) -> None:
        """None: an orbit is known at real times only."""


class _Estimated:
    """An orbit of mpmath's numbers, with their estimated errors."""

    def __init__(self, make: Callable[[int], NormalOrbit]) -> None:
        self._orbits: list[tuple[int, NormalOrbit]] = []
        periods = []
        for bits in (ctx.prec, ctx.prec - _FEWER):
            with mpmath.workprec(bits):
                self._orbits.append((bits, make(bits)))
                periods.append([self._orbits[-1][1].period])
        self.period = None if periods[0][0] is None else _estimates(periods)[0]

    def at(self, t: arb) -> Sequence[arb]:
        """p, q, r, gamma1, gamma2, gamma3; the second one's rounding is far more than t's."""
        moment = mpmath.make_mpf(libmp.from_man_exp(*map(int, t.mid().man_exp())))
        rows = []
        for bits, orbit in self._orbits:
            with mpmath.workprec(bits):
                rows.append(orbit.at(moment))
        return _estimates(rows)


def _estimates(answers: Sequence[Sequence[Scalar]]) -> list[arb]:
    """Those of the first, their errors taken for what the second differs by."""
    rounding = arb(2) ** (_FEWER - ctx.prec)
    rows = [[arb(x) for x in row] for row in answers]
    return [x + around(abs(x - y) + rounding * abs(x)).real for x, y in zip(*rows, strict=True)]

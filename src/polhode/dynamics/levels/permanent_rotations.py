"""Permanent rotations of a body as arcs in the plane of area f and energy h, their types exact.

The critical points of h at fixed f are Staude's rotations: w = om gamma with
om^2 (I - s) gamma = Mg r0 (O. Staude, J. reine angew. Math. 113 (1894) 318).  With T = Mg r0:

*First family*, by s on each interval between moments A_i with T_i != 0:

    v_i = T_i/(A_i - s),    om^2 = |v|,    gamma = v/om^2,
    f = om gamma.I gamma,   h = om^2 gamma.I gamma/2 + T.gamma

*Second family*, at s = A_i where T_i = 0, by om:

    gamma_j = T_j/(om^2 (A_j - A_i)),    gamma_i^2 = 1 - sum gamma_j^2 >= 0.

On every arc dh = om df.  The type is that of the spectrum lam^2 (lam^4 + b lam^2 + d); b, d and the
derivative of f are polynomials in s, or in y = om^-4, times something positive: their roots are
isolated exactly.  om and -om mirror f; here om > 0, f > 0.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

from flint import arb, fmpq_poly

from polhode.closed_forms.rotation_stability import spectrum
from polhode.common.cached_property import cached_property
from polhode.dynamics.levels.rotation_arcs import (
    BITS,
    BRANCH,
    CUSP,
    DEGENERATE,
    FIRST,
    HOPF,
    SECOND,
    Point,
    RationalBody,
    S,
    Segment,
    Special,
    is_root,
    morse_index,
    product,
    segments_of,
    through,
    type_of,
    value_at,
)
from polhode.numbers.flint_context import ctx
from polhode.numbers.polynomials import (
    Polynomial,
    Root,
    rational,
    real_roots,
)


@dataclass(frozen=True)
class FirstArc:
    """The first family between two of its poles, ``low`` and ``high``; None for an infinite end."""

    body: RationalBody
    low: Fraction | None
    high: Fraction | None

    family = FIRST
    axis = None

    @cached_property
    def special(self) -> tuple[Special, ...]:
        """Cusps, Hamiltonian-Hopf points and branches by rising s."""
        with ctx.workprec(BITS):
            return tuple(Special(kind, self.at(ball)) for kind, ball in self._marks())

    @cached_property
    def segments(self) -> tuple[Segment, ...]:
        """By rising s."""
        with ctx.workprec(BITS):
            marks = [ball for _, ball in self._marks()]
            return segments_of(marks, self.low, self.high, self._type)

    def at(self, s: arb) -> Point:
        """Where the arc is at s, in balls of the precision in force."""
        p = _polynomials(self.body)
        pole, q, n, t = (value_at(x, s) for x in (p.pole, p.q, p.n, p.t))
        size = abs(pole)
        root = q.sqrt()
        om = (root / size).sqrt()
        # f = N/Q^(3/4), h = (N/2 + T.v)/Q^(1/2), N = n/pole^2, Q = q/pole^2
        f = n / ((size * root).sqrt() * root)
        return Point(s, om, f, (n / 2 + t * pole) / (size * root))

    def gamma(self, point: Point) -> list[arb]:
        """gamma in principal axes."""
        body, s, square = self.body, point.parameter, point.om * point.om
        return [
            arb(0) if t == 0 else rational(t) / ((rational(a) - s) * square)
            for a, t in zip(body.moments, body.torque, strict=True)
        ]

    def inside(self, s: arb) -> bool:
        """Whether s is on this arc."""
        low, high = self.low, self.high
        after = low is None or bool(s > rational(low))
        return after and (high is None or bool(s < rational(high)))

    def meets(self, f: Fraction, bits: int) -> Iterator[arb]:
        """The s at which the arc has the area f > 0, to so many bits."""
        for root in _first_family_at(self.body, f, bits):
            if self.inside(root.ball):
                yield root.ball

    def _marks(self) -> list[tuple[str, arb]]:
        p = _polynomials(self.body)
        gap = p.b * p.b - 4 * p.d
        found = []
        for root in real_roots(p.d):
            if self.inside(root.ball):
                leaving = [
                    a for a, t in zip(*self.body[:2], strict=True) if t == 0 and is_root(root, a)
                ]
                found.append((BRANCH if leaving else CUSP, root.ball))
        for root in real_roots(gap):
            if root.multiplicity % 2 and self.inside(root.ball):
                found.append((HOPF, root.ball))
        return sorted(found, key=lambda mark: float(mark[1].mid()))

    def _type(self, s: Fraction) -> tuple[str, int | None]:
        p, at = _polynomials(self.body), rational(s)
        b, d = p.b(at), p.d(at)
        q = p.q(at)
        squares = [m(at) ** 2 / q for m in p.m]
        return type_of(b, d), morse_index(self.body, at, squares, d)


@dataclass(frozen=True)
class SecondArc:
    """The second family of the axis ``axis``, by om from where its gamma leaves the others' plane.

    ``circle``: its gammas form circles, one at each om.
    """

    body: RationalBody
    axis: int

    family = SECOND

    @property
    def circle(self) -> bool:
        """Whether another axis has the same moment and no component of Mg r0 either."""
        a, i = self.body.moments, self.axis
        return any(a[j] == a[i] for j in range(3) if j != i)

    @cached_property
    def least(self) -> Fraction:
        """om^4 where the family leaves: sum (T_j/(A_j - A_i))^2."""
        return sum((x * x for x in self._tilts.values()), Fraction(0))

    @cached_property
    def special(self) -> tuple[Special, ...]:
        """Its cusp and Hamiltonian-Hopf points, by rising om."""
        with ctx.workprec(BITS):
            return tuple(Special(kind, self.at(ball)) for kind, ball in self._marks())

    @cached_property
    def segments(self) -> tuple[Segment, ...]:
        """By rising om."""
        with ctx.workprec(BITS):
            first = rational(self.least)
            low = (arb(first).root(4)) if first else arb(0)
            if self.circle:
                return (Segment(low, None, DEGENERATE, None),)
            marks = [ball for _, ball in self._marks()]
            return segments_of(marks, low, None, self._type)

    def at(self, om: arb) -> Point:
        """Where the arc is at om."""
        a, k = rational(self.body.moments[self.axis]), rational(self._excess)
        square = om * om
        return Point(om, om, om * a + k / (om * square), square * a / 2 + 3 * k / (2 * square))

    def gamma(self, point: Point) -> list[arb]:
        """gamma in principal axes, gamma_i > 0; its mirror image is another."""
        square = point.om * point.om
        found = [arb(0)] * 3
        for j, x in self._tilts.items():
            found[j] = rational(x) / square
        found[self.axis] = (1 - rational(self.least) / square**2).sqrt()
        return found

    def inside(self, om: arb) -> bool:
        """Whether om is on this arc, past its beginning."""
        return bool(om > 0) and bool(om**4 > rational(self.least))

    def meets(self, f: Fraction, bits: int) -> Iterator[arb]:
        """The om at which the arc has the area f > 0, to so many bits."""
        a, k = rational(self.body.moments[self.axis]), rational(self._excess)
        with ctx.workprec(bits):
            roots = real_roots(fmpq_poly([k, 0, 0, -rational(f), a]))
        for root in roots:
            if self.inside(root.ball):
                yield root.ball

    @property
    def _tilts(self) -> dict[int, Fraction]:
        """om^2 gamma_j for the other axes."""
        body, i = self.body, self.axis
        return {
            j: t / (a - body.moments[i])
            for j, (a, t) in enumerate(zip(body.moments, body.torque, strict=True))
            if t != 0
        }

    @property
    def _excess(self) -> Fraction:
        """om^4 (gamma.I gamma - A_i) = sum T_j^2/(A_j - A_i)."""
        return sum((self.body.torque[j] * x for j, x in self._tilts.items()), Fraction(0))

    @cached_property
    def _spectrum(self) -> tuple[Polynomial, Polynomial]:
        """b/om^2 and d/om^4 as polynomials in y = om^-4, of degrees 1 and 2.

        From their values at three y for which gamma_i and om^2 are rational: the points
        (2 m, 1 - c m^2)/(1 + c m^2) of the conic c om^-4 + gamma_i^2 = 1, c the least om^4.
        """
        moments = [rational(a) for a in self.body.moments]
        points = []
        for k in (1, 2, 3) if self.least else (1,):
            m = Fraction(k) / (4 * max(map(abs, self._tilts.values()), default=Fraction(1)))
            below = 1 + self.least * m * m
            inverse = 2 * m / below  # om^-2
            gamma = [rational(self._tilts.get(j, Fraction(0)) * inverse) for j in range(3)]
            gamma[self.axis] = rational((1 - self.least * m * m) / below)
            torque = [rational(t * inverse) for t in self.body.torque]
            points.append((rational(inverse * inverse), spectrum(moments, torque, gamma, gamma)))
        b, d = (through([(y, found[k]) for y, found in points]) for k in (0, 1))
        return b, d

    def _marks(self) -> list[tuple[str, arb]]:
        if self.circle or not self.least:
            return []
        b, d = self._spectrum
        last = 1 / rational(self.least)
        found = [
            (CUSP, root.ball)
            for root in real_roots(d)
            if bool(root.ball > 0) and bool(root.ball < last)
        ]
        found += [
            (HOPF, root.ball)
            for root in real_roots(b * b - 4 * d)
            if root.multiplicity % 2 and bool(root.ball > 0) and bool(root.ball < last)
        ]
        oms = [(kind, (1 / y).root(4)) for kind, y in found]
        return sorted(oms, key=lambda mark: float(mark[1].mid()))

    def _type(self, om: Fraction) -> tuple[str, int | None]:
        y = rational(1 / om**4)
        b, d = (x(y) for x in self._spectrum)
        squares = [rational(self._tilts.get(j, Fraction(0))) ** 2 * y for j in range(3)]
        squares[self.axis] = 1 - sum(squares[1:], squares[0])
        return type_of(b, d), morse_index(
            self.body, rational(self.body.moments[self.axis]), squares, d
        )


Arc = FirstArc | SecondArc


def arcs(body: RationalBody) -> tuple[Arc, ...]:
    """Every arc: the first family by rising s, then the second families."""
    poles: list[Fraction] = sorted({a for a, t in zip(*body[:2], strict=True) if t != 0})
    ends: list[Fraction | None] = [None, *poles, None]
    found: list[Arc] = []
    if poles:
        found += [FirstArc(body, low, high) for low, high in pairwise(ends)]
    seen = []
    for i, (a, t) in enumerate(zip(*body[:2], strict=True)):
        others = [(body.moments[j], body.torque[j]) for j in range(3) if j != i]
        if t == 0 and a not in seen and all(x == 0 or b != a for b, x in others):
            found.append(SecondArc(body, i))
            seen.append(a)
    return tuple(found)


@lru_cache(maxsize=4)  # every arc of a body asks for the same
def _first_family_at(body: RationalBody, f: Fraction, bits: int) -> list[Root]:
    """The s of all permanent rotations of the first family with the area f, to so many bits."""
    p, f4 = _polynomials(body), rational(f) ** 4
    with ctx.workprec(bits):
        return real_roots(f4 * p.pole * p.pole * p.q * p.q * p.q - p.n**4)


class _Polynomials(NamedTuple):
    """Of s: m_i = pole v_i, q = |m|^2, n = m.I m, t = T.m; b and d times something positive."""

    pole: Polynomial
    m: tuple[Polynomial, ...]
    q: Polynomial
    n: Polynomial
    t: Polynomial
    b: Polynomial
    d: Polynomial


@lru_cache(maxsize=16)
def _polynomials(body: RationalBody) -> _Polynomials:
    moments, torque = ([rational(x) for x in numbers] for numbers in body[:2])
    poles = {a for a, t in zip(*body[:2], strict=True) if t != 0}
    factors = {a: rational(a) - S for a in poles}
    pole = fmpq_poly([1])
    for factor in factors.values():
        pole = pole * factor
    m = tuple(
        (pole // factors[a]) * t if t != 0 else 0 * S
        for a, t in zip(body.moments, torque, strict=True)
    )
    q, n, t = (
        product(m, by) for by in (m, [a * x for a, x in zip(moments, m, strict=True)], torque)
    )
    b, d = spectrum(moments, [x * pole for x in torque], m, m)
    return _Polynomials(pole, m, q, n, t, b, d)

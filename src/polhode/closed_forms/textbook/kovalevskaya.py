"""Kovalevskaya's top by Abel's two sums: quadratures of mpmath, inverted by Newton's method.

In the top's axes and units (Kowalevski, Acta Math. 12 (1889) 177; Golubev, Lectures on the
Integration of the Equations of Motion of a Rigid Body, ch. V), with pi = p^2 + q^2, sg = 2p,
S(s) = (s + H)(s^2 + b) - 2m^2, whose roots are e_j, and w^2 = -2 (s^2 - k^2) S(s), the separation
variables s1 <= s2 are the roots of q^2 s^2 + (R/2) s + R1/4, and

    ds1/w1 + ds2/w2 = 0,    s1 ds1/w1 + s2 ds2/w2 = dt.

s1 goes from the lowest branch point e to -infinity and back, s1 = e - size tan^2(y/2), and s2
between the two highest, s2 = mean - half cos x.  So y and x grow for ever, and the sums are
integrals of periodic functions of them.  They have one solution at each time: their determinant is
s2 - s1 times what is positive.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from polhode.closed_forms.textbook.quadrature import integral
from polhode.closed_forms.textbook.vectors import Row
from polhode.numbers.mpmath_context import mpc, mpf, mpmath

_MOST = 25  # steps of Newton's method
_ROUGH = 60  # bits of Newton's first steps
_MOMENT, _GAPS = 24, 16  # shares of the bits: of a short time, of a gap that it needs


class Integrals(NamedTuple):
    """H, m, k^2 and b = a^2 - k^2 of a motion."""

    H: mpf
    m: mpf
    k2: mpf
    b: mpf


class Place(NamedTuple):
    """Where the two variables are on their circles."""

    y: mpf
    x: mpf


def motion(
    weight: mpf, omega: Sequence[mpf], gamma: Sequence[mpf], pieces: int
) -> Callable[[mpf], Row]:
    """The state p q r gamma1 gamma2 gamma3 in the top's axes, as a function of time.

    ``weight``: Mg x0/C > 0, C the third moment.  ``omega``, ``gamma``: at t = 0.  ``pieces``: into
    which a period is cut for the quadratures.  The motion is generic: no two branch points are
    equal; next to a double point the quadratures lose digits, which another cut shows.
    """
    unit = mpmath.sqrt(weight)
    top = _Top([*(x / unit for x in omega), *gamma], pieces)

    def state(t: mpf) -> Row:
        row = top.state(unit * t)
        return [unit * x for x in row[:3]] + row[3:]

    return state


class _Top:
    """One generic motion in units where Mg x0 = C, so that G is gamma."""

    def __init__(self, start: Row, pieces: int) -> None:
        self._pieces = pieces
        self._n = n = _integrals(start)
        cubic = [n.H * n.b - 2 * n.m * n.m, n.b, n.H, 1]
        self._e = mpmath.polyroots(cubic, asc=True, maxsteps=400, extraprec=4 * mpmath.prec)
        k = mpmath.sqrt(n.k2)
        every = [*self._e, -k, k]
        points = sorted(mpmath.re(a) for a in every if mpmath.im(a) == 0)
        self._size = max(map(abs, every))
        self._lowest, self._low, high = points[0], points[-2], points[-1]
        self._mean, self._half = (high + self._low) / 2, (high - self._low) / 2
        self._beyond = [a for a in every if a != self._lowest]
        self._others = [a for a in every if a not in (self._low, high)]
        self._start = self._place(start, start)
        later = start
        if self._turns(start):
            # a moment later neither variable turns, but that state is known to few digits
            gaps = [abs(a - c) for k, a in enumerate(every) for c in every[:k]]
            if min(gaps) < mpmath.ldexp(self._size, -(mpmath.prec // _GAPS)):
                raise ArithmeticError("a turning point at t = 0, next to a double point")
            later = _moved(start, mpmath.ldexp(1, -(mpmath.prec // _MOMENT)))
            self._start = self._place(start, later)
        self._signs = self._signs_at(later, self._place(later, later))

    def _turns(self, state: Row) -> bool:
        """Whether a variable turns there, or is at infinity, so that no sign can be read."""
        small = mpmath.ldexp(1, -(mpmath.prec // 4))
        y, x = self._start
        return bool(state[1] == 0 or min(abs(mpmath.sin(y)), abs(mpmath.sin(x))) < small)

    def state(self, t: mpf) -> Row:
        """p q r G1 G2 G3; raises ArithmeticError where Newton's method does not converge."""
        with mpmath.workprec(_ROUGH):
            place = self._solution(self._guess(t), t)
        return self._state(self._solution(place, t))

    def _guess(self, t: mpf) -> Place:
        """By the mean rates: less than a turn from the solution."""
        one, two = (
            integral(rates, mpmath.mpf(0), 2 * mpmath.pi, self._pieces)
            for rates in (self._first, self._second)
        )
        share = 2 * mpmath.pi * t / (two.imag / two.real - one.imag / one.real)
        return Place(self._start.y + share / one.real, self._start.x + share / two.real)

    def _solution(self, place: Place, t: mpf) -> Place:
        """Where Abel's sums are 0 and t, by Newton's method from a place near it.

        From step to step the integrals grow by those over the step alone, which are short.
        """
        enough = mpmath.ldexp(1, -(2 * mpmath.prec) // 3)
        one = integral(self._first, self._start.y, place.y, self._pieces)
        two = integral(self._second, self._start.x, place.x, self._pieces)
        for _ in range(_MOST):
            F, G = two.real - one.real, two.imag - one.imag - t
            first, second = self._first(place.y), self._second(place.x)
            determinant = second.real * first.imag - first.real * second.imag
            dy = (second.real * G - second.imag * F) / determinant
            dx = (first.real * G - first.imag * F) / determinant
            size = max(abs(dy), abs(dx))
            damping = max(1, size)
            before, place = place, Place(place.y + dy / damping, place.x + dx / damping)
            if size < enough:
                return place
            one += integral(self._first, before.y, place.y, self._pieces)
            two += integral(self._second, before.x, place.x, self._pieces)
        raise ArithmeticError("Newton's method does not converge")

    def _place(self, state: Row, later: Row) -> Place:
        """The place of a state; ``later``: one from which the directions are read."""
        w1, w2 = self._w(later)
        s1, s2 = self._variables(state)
        y = 2 * mpmath.atan(mpmath.sqrt(max(0, (self._lowest - s1) / self._size)))
        x = mpmath.acos(min(1, max(-1, (self._mean - s2) / self._half)))
        return Place(y if w1 >= 0 else -y, x if w2 >= 0 else -x)

    def _variables(self, state: Row) -> tuple[mpf, mpf]:
        """s1 and s2, without cancellation; s1 is -infinity where q is 0."""
        p, q, *_ = state
        R, R1 = _polars(p, q, self._n)
        if q == 0:
            return -mpmath.inf, -R1 / (2 * R)
        root = mpmath.sqrt(max(0, R * R / 4 - q * q * R1))
        larger = -(R / 2 + (root if R >= 0 else -root)) / 2
        pair = larger / (q * q), R1 / (4 * larger)
        return min(pair), max(pair)

    def _w(self, state: Row) -> tuple[mpf, mpf]:
        """w1 and w2 with their signs, by Mumford's form."""
        p, q, r, _, _, G3 = state
        if q == 0:
            return mpmath.mpf(1), mpmath.mpf(1)
        rows = (_mumford(p, q, s, self._n) for s in self._variables(state))
        w1, w2 = ((u * r + v * G3) / q**3 for u, v in rows)
        return w1, w2

    def _first(self, y: mpf) -> mpc:
        """ds/w, and s ds/w as its imaginary part, of s1, over dy."""
        cosine, sine = mpmath.cos(y / 2) ** 2, mpmath.sin(y / 2) ** 2
        s = self._lowest * cosine - self._size * sine  # s1 cos^2
        product = mpmath.re(mpmath.fprod(s - a * cosine for a in self._beyond))
        return mpmath.sqrt(self._size / (2 * product)) * mpc(cosine, s)

    def _second(self, x: mpf) -> mpc:
        """ds/w, and s ds/w as its imaginary part, of s2, over dx."""
        s = self._mean - self._half * mpmath.cos(x)
        return mpc(1, s) / mpmath.sqrt(2 * mpmath.re(mpmath.fprod(s - a for a in self._others)))

    def _products(self, place: Place) -> Row:
        """sqrt((s1 - e)(e - s2)) cos(y/2) for each e, up to a sign that never changes."""
        y, x = place
        cosine, sine = mpmath.cos(y / 2), mpmath.sin(y / 2)
        s = self._mean - self._half * mpmath.cos(x)
        found = []
        for e in self._e:
            if e == self._lowest:
                first = mpmath.sqrt(self._size) * sine
            else:
                first = mpmath.sqrt((e - self._lowest) * cosine**2 + self._size * sine**2)
            if e == self._low:
                second = mpmath.sqrt(2 * self._half) * mpmath.sin(x / 2)
            else:
                second = mpmath.sqrt(s - e)
            found.append(first * second)
        return found

    def _signs_at(self, state: Row, place: Place) -> Row:
        """Of the roots, from 2q sqrt((s1 - e)(s2 - e)) = i(f sg - g(pi - e))."""
        p, q, *_ = state
        turn = q / mpmath.cos(place.y / 2)
        found = []
        for e, (f, g), product in zip(self._e, self._factors(), self._products(place), strict=True):
            value = (2 * f * p - g * (p * p + q * q - e)) / (2 * turn * product)
            found.append(mpmath.sign(mpmath.re(value)))
        return found

    def _factors(self) -> list[tuple[Any, Any]]:
        """f and g of each e: f^2 = e^2 + b, g^2 = 2(e + H), f g = 2m; the larger by its root."""
        found = []
        for e in self._e:
            f, g = mpmath.sqrt(e * e + self._n.b), mpmath.sqrt(2 * (e + self._n.H))
            m = 2 * self._n.m
            found.append((f, m / f) if abs(f) >= abs(g) else (m / g, g))
        return found

    def _state(self, place: Place) -> Row:
        """The state there: p and q by Koetter's sums, r and G3 from w1 and w2, the rest by H, m."""
        y, x = place
        e, n = self._e, self._n
        denominator = numerator = mpmath.mpf(0)
        products = self._products(place)
        for j, (f, g) in enumerate(self._factors()):
            slope = mpmath.fprod(e[j] - e[i] for i in range(3) if i != j)
            term = self._signs[j] * products[j] / slope
            numerator += f * term
            denominator += g * term
        p = mpmath.re(numerator / denominator)
        q = mpmath.re(mpmath.cos(y / 2) / denominator)
        tangent = mpmath.tan(y / 2)
        s1 = self._lowest - self._size * tangent**2
        s2 = self._mean - self._half * mpmath.cos(x)
        w1 = tangent * _root(2 * self._size, (s1 - a for a in self._beyond))
        w2 = self._half * mpmath.sin(x) * _root(2, (s2 - a for a in self._others))
        (u1, v1), (u2, v2) = (_mumford(p, q, s, n) for s in (s1, s2))
        determinant = (u1 * v2 - u2 * v1) / q**3
        r, G3 = (w1 * v2 - w2 * v1) / determinant, (u1 * w2 - u2 * w1) / determinant
        G1 = n.H - p * p - q * q - r * r / 2
        return [p, q, r, G1, (n.m - p * G1 - r * G3 / 2) / q, G3]


def _integrals(state: Row) -> Integrals:
    p, q, r, G1, G2, G3 = state
    k2 = (p * p - q * q - G1) ** 2 + (2 * p * q - G2) ** 2
    H, m = p * p + q * q + r * r / 2 + G1, p * G1 + q * G2 + r * G3 / 2
    return Integrals(H, m, k2, G1 * G1 + G2 * G2 + G3 * G3 - k2)


def _polars(p: mpf, q: mpf, n: Integrals) -> tuple[mpf, mpf]:
    """R and R1 of the equation of s1 and s2."""
    sg, pi = 2 * p, p * p + q * q
    R = -pi * pi + 2 * n.H * pi - 2 * n.m * sg + n.b
    R1 = -2 * n.H * pi**2 - n.b * sg**2 + 4 * n.m * pi * sg + 2 * n.H * n.b - 4 * n.m**2
    return R, R1


def _mumford(p: mpf, q: mpf, s: mpf, n: Integrals) -> tuple[mpf, mpf]:
    """What r and G3 have before them in q^3 w(s) = q^3 (T' s - N'), s1 + s2 = T, s1 s2 = N."""
    sg, pi = 2 * p, p * p + q * q
    R, R1 = _polars(p, q, n)
    by_r = 2 * n.m * s + n.b * sg - 2 * n.m * pi
    by_G3 = 2 * (pi - n.H) * s + 2 * n.H * pi - 2 * n.m * sg
    slope = (2 * R * s + R1) / 4
    return q * q * by_r / 2 - p * slope, q * q * by_G3 / 2 + slope


def _moved(state: Row, t: mpf) -> Row:
    """One step of Runge and Kutta: for signs, which need few digits."""

    def rates(x: Row) -> Row:
        p, q, r, G1, G2, G3 = x
        return [
            q * r / 2,
            (G3 - p * r) / 2,
            -G2,
            r * G2 - q * G3,
            p * G3 - r * G1,
            q * G1 - p * G2,
        ]

    def on(share: mpf, slope: Row) -> Row:
        return [x + share * h * k for x, k in zip(state, slope, strict=True)]

    h = t / (1 + max(map(abs, state)))
    half = mpmath.mpf(1) / 2
    a = rates(state)
    b = rates(on(half, a))
    c = rates(on(half, b))
    d = rates(on(mpmath.mpf(1), c))
    return [
        x + h * (k + 2 * m + 2 * n + o) / 6 for x, k, m, n, o in zip(state, a, b, c, d, strict=True)
    ]


def _root(factor: Any, differences: Any) -> mpf:
    return mpmath.sqrt(factor * mpmath.re(mpmath.fprod(differences)))

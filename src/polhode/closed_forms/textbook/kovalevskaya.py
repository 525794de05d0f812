"""Kovalevskaya's top by Abel's two sums, as mpmath's Fourier series, inverted by Newton's method.

In the top's axes and units (Kowalevski, Acta Math. 12 (1889) 177; Golubev, Lectures on the
Integration of the Equations of Motion of a Rigid Body, ch. V), with pi = p^2 + q^2, sg = 2p,
S(s) = (s + H)(s^2 + b) - 2m^2, whose roots are e_j, and w^2 = -2 (s^2 - k^2) S(s), the separation
variables s1 <= s2 are the roots of q^2 s^2 + (R/2) s + R1/4, and

    ds1/w1 + ds2/w2 = 0,    s1 ds1/w1 + s2 ds2/w2 = dt.

s1 goes from the lowest branch point to -infinity and back, s2 between the two highest ones, each
with an angle (:class:`.cycle.Cycle`) that grows for ever, and the sums are integrals of periodic
functions of the angles.  They have one solution at each time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from polhode.closed_forms.textbook.cycle import Cycle, Point
from polhode.numbers.mpmath_context import mpc, mpf, mpmath

_MOST = 60  # steps of Newton's method
#: Where a variable turns at t = 0: a time at which none does, over the size of the state, the bits
#: of the state there, and how close the formulas are to come to it.
_MOMENT, _FEW_BITS, _CLOSE = 2**-6, 53, 1e-10


def motion(
    moments: Any, weight: mpf, omega: Any, gamma: Any, regime: str
) -> Callable[[mpf], list[mpf]]:
    """The state p q r gamma1 gamma2 gamma3 in the top's axes, as a function of time.

    ``moments``, ``omega``, ``gamma``: at t = 0, in these axes.  ``weight``: Mg x0 > 0.  The motion
    is generic: no two branch points are equal.  Raises ArithmeticError where they are too near each
    other, and where Newton's method does not converge.
    """
    del regime
    unit = mpmath.sqrt(weight / moments[2])
    top = _Top([*(x / unit for x in omega), *gamma])

    def state(t: mpf) -> list[mpf]:
        row = top.state(unit * t)
        return [*(unit * x for x in row[:3]), *row[3:]]

    return state


class _Top:
    """One generic motion in units where Mg x0 = C."""

    def __init__(self, start: Sequence[mpf]) -> None:
        p, q, r, G1, G2, G3 = start
        self._H, self._m = p * p + q * q + r * r / 2 + G1, p * G1 + q * G2 + r * G3 / 2
        k2 = (p * p - q * q - G1) ** 2 + (2 * p * q - G2) ** 2
        self._b = G1 * G1 + G2 * G2 + G3 * G3 - k2
        cubic = [self._H * self._b - 2 * self._m**2, self._b, self._H, 1]
        self._e = mpmath.polyroots(cubic, asc=True, maxsteps=400, extraprec=4 * mpmath.prec)
        points = [(a, 1) for a in (*self._e, -mpmath.sqrt(k2), mpmath.sqrt(k2))]
        real = sorted(mpmath.re(a) for a, _ in points if mpmath.im(a) == 0)
        points.append((-1, 0))
        self._cycles = [
            Cycle((real[0], 1), (-1, 0), points),
            Cycle((real[-2], 1), (real[-1], 1), points),
        ]
        self._signs = [mpmath.mpf(1)] * 3
        self._begin = self._angles(start, start)
        moment, later, size = mpmath.mpf(0), start, 1 + max(map(abs, start))
        if min(abs(mpmath.sin(x)) for x in self._begin) < mpmath.ldexp(1, -(mpmath.prec // 4)):
            # a variable turns: signs are read a moment later, and few digits tell them
            moment = mpmath.mpf(_MOMENT) / size
            with mpmath.workprec(_FEW_BITS):
                later = mpmath.odefun(_rates, 0, start)(moment)
            self._begin = self._angles(start, later)
        self._signs = self._signs_at(later, self._angles(later, later))
        off = max(abs(x - y) for x, y in zip(self.state(moment), later, strict=True))
        if not off < _CLOSE * size:
            raise ArithmeticError("signs that cannot be read, next to a double point")

    def state(self, t: mpf) -> list[mpf]:
        """p q r G1 G2 G3 at a time, by Newton's method from where the mean rates lead."""
        goal = mpc(0, t)
        means = [cycle.sums.mean for cycle in self._cycles]
        angles = [x + step for x, step in zip(self._begin, _steps(means, goal), strict=True)]
        sums = [cycle.sums for cycle in self._cycles]
        goal += sum(f.at(x) for f, x in zip(sums, self._begin, strict=True))
        enough = mpmath.ldexp(1, -(2 * mpmath.prec) // 3)
        for _ in range(_MOST):
            miss = goal - sum(f.at(x) for f, x in zip(sums, angles, strict=True))
            rates = [cycle.rate(x) for cycle, x in zip(self._cycles, angles, strict=True)]
            steps = _steps(rates, miss)
            size = max(map(abs, steps))
            angles = [x + step / max(1, size) for x, step in zip(angles, steps, strict=True)]
            if size < enough:
                return self._state_at(angles)
        raise ArithmeticError("Newton's method does not converge")

    def _angles(self, state: Sequence[mpf], later: Sequence[mpf]) -> list[mpf]:
        """Those of a state, on the sides that a state a moment later tells."""
        p, q, r, _, _, G3 = later
        found = []
        for cycle, s, point in zip(
            self._cycles, self._variables(state), self._variables(later), strict=True
        ):
            by_r, by_G3 = self._mumford(p, q, point)
            found.append(cycle.angle(s, (by_r * r + by_G3 * G3) * q))
        return found

    def _variables(self, state: Sequence[mpf]) -> tuple[Point, Point]:
        """s1 and s2, without cancellation; s1 is infinite where q = 0."""
        p, q, *_ = state
        R, R1 = self._polars(p, q)
        size = abs(R) + mpmath.sqrt(max(0, R * R - 4 * q * q * R1))
        side = mpmath.sign(R) or 1
        far, near = (-size * side / 4, q * q), (-R1 * side, size)
        return (near, far) if q and far[0] / far[1] > near[0] / near[1] else (far, near)

    def _polars(self, p: mpf, q: mpf) -> tuple[mpf, mpf]:
        """R and R1 of the equation of s1 and s2."""
        H, m, b, sg, pi = self._H, self._m, self._b, 2 * p, p * p + q * q
        R = -pi * pi + 2 * H * pi - 2 * m * sg + b
        return R, -2 * H * pi**2 - b * sg**2 + 4 * m * pi * sg + 2 * H * b - 4 * m**2

    def _mumford(self, p: mpf, q: mpf, point: Point) -> tuple[mpf, mpf]:
        """What r and G3 have before them in q^3 w z = q^3 (T' s - N' z), s1 + s2 = T, s1 s2 = N."""
        (s, z), H, m, sg, pi = point, self._H, self._m, 2 * p, p * p + q * q
        R, R1 = self._polars(p, q)
        by_r = 2 * m * s + (self._b * sg - 2 * m * pi) * z
        by_G3 = 2 * (pi - H) * s + (2 * H * pi - 2 * m * sg) * z
        slope = (2 * R * s + R1 * z) / 4
        return q * q * by_r / 2 - p * slope, q * q * by_G3 / 2 + slope

    def _roots(self, angles: Sequence[mpf]) -> Iterator[tuple[Any, Any, Any, Any]]:
        """Of each e: e, f, g and the root of (s1 - e)(e - s2), of the sign that never changes.

        f^2 = e^2 + b, g^2 = 2(e + H), f g = 2m: the larger by its root.
        """
        for e, side in zip(self._e, self._signs, strict=True):
            f, g = mpmath.sqrt(e * e + self._b), mpmath.sqrt(2 * (e + self._H))
            f, g = (f, 2 * self._m / f) if abs(f) >= abs(g) else (2 * self._m / g, g)
            one, two = (c.root((e, 1), x) for c, x in zip(self._cycles, angles, strict=True))
            yield e, f, g, side * one * two

    def _unit(self, angles: Sequence[mpf]) -> mpf:
        """What all the roots have before them."""
        one, two = (c.root((-1, 0), x) for c, x in zip(self._cycles, angles, strict=True))
        return one * two

    def _signs_at(self, state: Sequence[mpf], angles: Sequence[mpf]) -> list[mpf]:
        """Of the roots, from 2q sqrt((s1 - e)(s2 - e)) = i(f sg - g(pi - e))."""
        p, q, *_ = state
        turn = 2 * q / self._unit(angles)
        return [
            mpmath.sign(mpmath.re((2 * f * p - g * (p * p + q * q - e)) / (turn * root)))
            for e, f, g, root in self._roots(angles)
        ]

    def _state_at(self, angles: Sequence[mpf]) -> list[mpf]:
        """p and q by Koetter's sums, r and G3 from w1 and w2, the rest by H, m."""
        denominator = numerator = mpmath.mpf(0)
        for e, f, g, root in self._roots(angles):
            slope = mpmath.fprod(e - other for other in self._e if other != e)
            numerator += f * root / slope
            denominator += g * root / slope
        p, q = (mpmath.re(x / denominator) for x in (numerator, self._unit(angles)))
        both = [*zip(self._cycles, angles, strict=True)]
        forms = mpmath.matrix([self._mumford(p, q, cycle.point(x)) for cycle, x in both])
        r, G3 = mpmath.lu_solve(forms / q**3, mpmath.matrix([cycle.w(x) for cycle, x in both]))
        G1 = self._H - p * p - q * q - r * r / 2
        return [p, q, r, G1, (self._m - p * G1 - r * G3 / 2) / q, G3]


def _steps(rates: Sequence[mpc], miss: mpc) -> tuple[mpf, mpf]:
    """The real x and y for which x and y times the two rates add up to the complex number."""
    one, two = rates
    determinant = (one.conjugate() * two).imag
    return -(two.conjugate() * miss).imag / determinant, (one.conjugate() * miss).imag / determinant


def _rates(_: mpf, state: Sequence[mpf]) -> list[mpf]:
    """Euler's and Poisson's equations."""
    p, q, r, G1, G2, G3 = state
    w = q * r / 2, (G3 - p * r) / 2, -G2
    return [*w, r * G2 - q * G3, p * G3 - r * G1, q * G1 - p * G2]

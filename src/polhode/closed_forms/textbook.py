"""The three classical tops by mpmath's own functions, as textbooks have them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeAlias

from polhode.closed_forms.membership import PrincipalScene, in_principal_axes
from polhode.numbers.conversion import to_mpf
from polhode.numbers.exact import Exact
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from polhode.numbers.vectors import cross
from polhode.scenes.body import IDENTITY
from polhode.scenes.scene import Scene

# --- third integral -------------------------------------------------------------------------------
#
# Jacobi's elliptic functions, and Legendre's integral of the third kind by Carlson's R_J.


class Along:
    """``sn``, ``cn`` and ``dn`` at v to the parameter m, and integrals from 0 to there.

    Half periods of sn are counted; at m = 1 there are none.
    """

    def __init__(self, v: mpf, parameter: mpf) -> None:
        self._v, self._parameter = v, parameter
        self._turns, rest = mpmath.mpf(0), v
        if parameter < 1:
            half = 2 * mpmath.ellipk(parameter)
            self._turns = mpmath.nint(v / half)
            rest = v - self._turns * half
        self._sn, self._cn, self.dn = (
            mpmath.ellipfun(kind, rest, m=parameter) for kind in ("sn", "cn", "dn")
        )
        side = -1 if self._turns % 2 else 1
        self.sn, self.cn = side * self._sn, side * self._cn

    def third_integral(self, number: mpf) -> mpf:
        """The integral of dv/(1 - number sn^2 v) (DLMF 19.25.14)."""
        sn2, whole = self._sn**2, mpmath.mpf(0)
        if self._turns:
            whole = 2 * self._turns * mpmath.elliprj(0, 1 - self._parameter, 1, 1 - number)
        if self._sn:
            whole += self._sn**3 * mpmath.elliprj(self._cn**2, self.dn**2, 1, 1 - number * sn2)
        return self._v + number / 3 * whole


# --- periodic -------------------------------------------------------------------------------------
#
# Integrals of even periodic functions by their Fourier series, to the precision in force.


_MOST_SAMPLES = 2048  # samples of a period


class PeriodicIntegral:
    """The integral from 0 of an even function of period 2 pi, analytic where |Im x| < ``strip``.

    The trapezoidal sums for Fourier's coefficients converge like exp(-n strip).  Raises ValueError
    where they take too many samples.
    """

    def __init__(self, function: Callable[[mpf], mpc], strip: mpf) -> None:
        terms = int(mpmath.prec * mpmath.ln2 / strip) + 1
        if 2 * terms > _MOST_SAMPLES:
            raise ValueError("branch points are too near each other")
        count = 2 ** (2 * terms - 1).bit_length()
        half = [function(2 * mpmath.pi * k / count) for k in range(count // 2 + 1)]
        quarter = [mpmath.expjpi(mpmath.mpf(-2 * k) / count) for k in range(max(1, count // 4))]
        roots = [*quarter, *(mpc(z.imag, -z.real) for z in quarter)]  # the other half: -1 of them
        sums = _fourier([*half, *half[-2:0:-1]], roots)
        #: The mean of the function.
        self.mean: mpc = sums[0] / count
        self._waves = [sums[k] / (k * count) for k in range(terms, 0, -1)]

    def at(self, x: mpf) -> mpc:
        """The integral from 0 to x, the sines by Clenshaw's recurrence."""
        cos, sin = mpmath.cos_sin(x)
        twice, here, above = 2 * cos, mpc(0), mpc(0)
        for wave in self._waves:
            here, above = wave + twice * here - above, here
        return self.mean * x + 2 * sin * here


def _fourier(values: Sequence[mpc], roots: Sequence[mpc]) -> list[mpc]:
    """The sums of the values times powers of each root of 1 (Cooley and Tukey 1965).

    ``roots``: the first half of them.
    """
    if len(values) == 1:
        return [*values]
    even, odd = (_fourier(values[k::2], roots[::2]) for k in (0, 1))
    twisted = [x * root for x, root in zip(odd, roots, strict=False)]
    return [x + side * y for side in (1, -1) for x, y in zip(even, twisted, strict=True)]


# --- cycle ----------------------------------------------------------------------------------------
#
# A variable that goes to and fro between two branch points, by an angle that grows for ever.
#
# Points of the line, infinity among them, are s = S/z with [a, b] = S_a z_b - S_b z_a. Between u
# and v, with ka > 0 of which nothing depends,
#
#     (S, z) = cos^2(x/2) u + ka sin^2(x/2) v,    [s, u] = ka sin^2(x/2) [v, u],
#     [s, v] = cos^2(x/2) [u, v],    ds = ka [v, u] sin x dx/2z^2.
#
# So of w^2 = -2 times the product of all [s, a], over z^6, two factors are known, and of ds/w the
# rest remains, which has no zeros.


#: S and z of a point S/z, which may be infinity.
Point: TypeAlias = tuple[Any, Any]


class Cycle:
    """One separation variable between the branch points ``u`` and ``v``, of all those ``points``.

    ds/w has the sign of [v, u] where w > 0 on the way from u to v.
    """

    def __init__(self, u: Point, v: Point, points: Sequence[Point]) -> None:
        self._u, self._v = u, v
        self._others = [a for a in points if a not in (u, v)]
        self._wide = _bracket(v, u)
        ratios = [_bracket(u, a) / _bracket(v, a) for a in self._others]
        sizes = [*map(abs, ratios)]
        # [s, a] = 0 where tan^2(x/2) = -ratio/ka: the nearest of these x is then farthest away
        self._balance = mpmath.sqrt(min(sizes) * max(sizes))
        zeros = [2 * mpmath.atan(mpmath.sqrt(-ratio / self._balance)) for ratio in ratios]
        #: ds/w, and s ds/w as its imaginary part, from x = 0.
        self.sums = PeriodicIntegral(self.rate, min(abs(mpmath.im(x)) for x in zeros))

    def point(self, x: mpf) -> Point:
        """s at an angle."""
        cos2, sin2 = mpmath.cos(x / 2) ** 2, self._balance * mpmath.sin(x / 2) ** 2
        return cos2 * self._u[0] + sin2 * self._v[0], cos2 * self._u[1] + sin2 * self._v[1]

    def rate(self, x: mpf) -> mpc:
        """ds/w, and s ds/w as its imaginary part, over dx."""
        s, z = self.point(x)
        size = mpmath.sqrt(self._balance / (2 * self._rest((s, z))))
        return mpmath.sign(self._wide) * size * mpc(z, s)

    def w(self, x: mpf) -> mpf:
        """w z at an angle."""
        point = self.point(x)
        size = mpmath.sqrt(2 * self._balance * self._rest(point))
        return abs(self._wide) * size * mpmath.sin(x) / (2 * point[1] ** 2)

    def root(self, a: Point, x: mpf) -> Any:
        """A square root of [s, a] or its opposite, without a jump; of either sign at an end."""
        if a == self._u:
            return mpmath.sqrt(self._balance * abs(self._wide)) * mpmath.sin(x / 2)
        if a == self._v:
            return mpmath.sqrt(abs(self._wide)) * mpmath.cos(x / 2)
        return mpmath.sqrt(mpmath.sign(self._wide) * _bracket(self.point(x), a))

    def angle(self, s: Point, side: mpf) -> mpf:
        """The angle of a point; ``side`` has the sign of w there."""
        low, high = (mpmath.sqrt(abs(_bracket(s, end))) for end in (self._u, self._v))
        x = 2 * mpmath.atan2(low, high * mpmath.sqrt(self._balance))
        return x if side >= 0 else -x

    def _rest(self, point: Point) -> mpf:
        """The product of all [s, a] but those of the ends."""
        return mpmath.re(mpmath.fprod(_bracket(point, a) for a in self._others))


def _bracket(a: Point, b: Point) -> Any:
    return a[0] * b[1] - b[0] * a[1]


# --- euler ----------------------------------------------------------------------------------------
#
# Euler's top by Jacobi's functions of mpmath, its precession by Legendre's third integral.
#
# With A < B < C or reversed, so that the polhode circles axis 3 (Whittaker, Analytical Dynamics,
# art. 69; Landau and Lifshitz, Mechanics, section 37), in angles about the angular momentum G:
#
#     w = (a cn, b sn, c dn),    cos th = C r/G,    tan ph = A p/(B q),
#     psi' = G (A p^2 + B q^2)/(A^2 p^2 + B^2 q^2) = G/C + G (2TC - G^2)/(C (G^2 - C^2 r^2)).


_ONE = 2**20  # rounding errors by which the parameter m of a separatrix may differ from 1


def euler_motion(
    moments: Any, weight: mpf, omega: Any, gamma: Any, regime: str
) -> Callable[[mpf], list[mpf]]:
    """The state p q r gamma1 gamma2 gamma3 as a function of time, ``weight`` being 0.

    ``moments``, ``omega``, ``gamma``: at t = 0, along the axes above.  ``regime``: the motion's, by
    exact numbers.  Of a separatrix all precisions agree on a motion next to it, however far that
    leads away: raises ArithmeticError where the numbers tell no difference and the regime does.
    """
    del weight
    (A, B, C), (p, q, r) = moments, omega
    if regime in ("rest", "sphere") or regime.startswith("permanent"):
        spin = mpmath.matrix([[0, r, -q], [-r, 0, p], [q, -p, 0]])  # spin g = g x w
        return lambda t: [*omega, *(mpmath.expm(t * spin) * gamma)]
    twice, squared = A * p * p + B * q * q + C * r * r, (A * p) ** 2 + (B * q) ** 2 + (C * r) ** 2
    below, above = twice * C - squared, squared - twice * A
    parameter = (B - A) * below / ((C - B) * above)
    if regime == "separatrix":
        parameter = mpmath.mpf(1)
    elif 1 - parameter < _ONE * mpmath.eps or below / (C - A) <= 0:
        raise ArithmeticError(f"next to {'a separatrix' if parameter > 0 else 'a rotation'}")
    first, third = (1 if x >= 0 else -1 for x in (p, r))
    a = first * mpmath.sqrt(below / (A * (C - A)))
    b = first * third * mpmath.sign(C - B) * mpmath.sqrt(below / (B * (C - B)))
    c = third * mpmath.sqrt(above / (C * (C - A)))
    begin = q / b * mpmath.elliprf((p / a) ** 2, (r / c) ** 2, 1)
    rate = mpmath.sqrt((C - B) * above / (A * B * C))
    size = mpmath.sqrt(squared)
    # G^2 - C^2 r^2 = A^2 p^2 + B^2 q^2 = (A a)^2 (1 - number sn^2)
    number = 1 - (B * b / (A * a)) ** 2
    factor = size * below / (C * (A * a) ** 2 * rate)
    start = Along(begin, parameter).third_integral(number)
    fixed = _frame(A * p, B * q, C * r) * gamma

    def state(t: mpf) -> list[mpf]:
        at = Along(begin + rate * t, parameter)
        p, q, r = a * at.cn, b * at.sn, c * at.dn
        psi = size / C * t + factor * (at.third_integral(number) - start)
        cos, sin = mpmath.cos(psi), mpmath.sin(psi)
        # fixed in space, so turned back by psi about G against the body's node
        turn = mpmath.matrix([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]])
        return [p, q, r, *(_frame(A * p, B * q, C * r).T * turn * fixed)]

    return state


def _frame(x: mpf, y: mpf, z: mpf) -> Any:
    """Rows: the node of axis 3 about (x, y, z), what makes it right-handed, and (x, y, z)."""
    across, size = mpmath.hypot(x, y), mpmath.norm([x, y, z])
    return mpmath.matrix(
        [
            [y / across, -x / across, 0],
            [x * z / across / size, y * z / across / size, -across / size],
            [x / size, y / size, z / size],
        ]
    )


# --- lagrange -------------------------------------------------------------------------------------
#
# Lagrange's top by Jacobi's functions of mpmath, phi by Legendre's third integral.
#
# Axis 3 is the axis of symmetry, through the centre of mass. With u = cos th = gamma3 (Whittaker,
# Analytical Dynamics, art. 71; Goldstein, Classical Mechanics, section 5.7):
#
#     u'^2 = a(b - u)(1 - u^2) - (F - n u)^2,    u = u1 + (u2 - u1) sn^2,
#     psi' = (F - n u)/(1 - u^2),
#     phi' = r - u psi' = r - n - (F - n)/(2(1 - u)) + (F + n)/(2(1 + u)).


_EQUAL = 2**20  # rounding errors by which two equal roots may differ


def lagrange_motion(
    moments: Any, weight: mpf, omega: Any, gamma: Any, regime: str
) -> Callable[[mpf], list[mpf]]:
    """The state p q r gamma1 gamma2 gamma3 in the top's axes, as a function of time.

    ``moments``, ``omega``, ``gamma``: at t = 0, in these axes.  ``weight``: Mg z0 > 0.  Raises
    ValueError for a motion through a pole, where psi and phi have no rates, ArithmeticError where
    rounding makes a pair of three roots that are nearly equal.
    """
    del regime
    (p, q, r), (g1, g2, u0) = omega, gamma
    a, n = 2 * weight / moments[0], moments[2] * r / moments[0]
    F, b = p * g1 + q * g2 + n * u0, u0 + (p * p + q * q) / a
    near = mpmath.sqrt(mpmath.eps)
    cubic = [a * b - F * F, 2 * F * n - a, -a * b - n * n, a]
    roots = mpmath.polyroots(cubic, asc=True, maxsteps=400, extraprec=4 * mpmath.prec)
    u1, u2, u3 = sorted(mpmath.re(z) for z in roots)
    if max(u2, u0) >= 1 - near or min(u1, u0) <= -1 + near:  # of nearly triple roots u0 knows more
        raise ValueError("a motion through a pole, where psi and phi have no rates")
    if max(abs(mpmath.im(z)) for z in roots) > _EQUAL * near * mpmath.sqrt(1 - u0 * u0):
        raise ArithmeticError("three roots are equal to this precision")
    parameter = (u2 - u1) / (u3 - u1)
    rate = mpmath.sqrt(a * (u3 - u1)) / 2
    steady = u2 - u1 < _EQUAL * mpmath.eps
    sine = 0 if steady else mpmath.sqrt(min(1, max(0, (u0 - u1) / (u2 - u1))))
    direction = -1 if g1 * q - g2 * p < 0 else 1
    begin = direction * mpmath.ellipf(mpmath.asin(sine), parameter)

    def turned(at: Along) -> mpf:
        """phi without its growth at the rate r - n."""
        above = at.third_integral((u2 - u1) / (1 - u1)) * (F - n) / (1 - u1)
        below = at.third_integral((u1 - u2) / (1 + u1)) * (F + n) / (1 + u1)
        return (below - above) / (2 * rate)

    phi0 = mpmath.atan2(g1, g2) - turned(Along(begin, parameter))

    def state(t: mpf) -> list[mpf]:
        at = Along(begin + rate * t, parameter)
        u = u1 + (u2 - u1) * at.sn * at.sn
        phi = phi0 + (r - n) * t + turned(at)
        # Euler's kinematic equations
        sine, c, s = mpmath.sqrt(1 - u * u), mpmath.cos(phi), mpmath.sin(phi)
        tilting = -2 * rate * (u2 - u1) * at.sn * at.cn * at.dn / sine  # theta'
        turning = (F - n * u) / sine  # psi' sin theta
        w = [tilting * c + turning * s, turning * c - tilting * s, r]
        return [*w, sine * s, sine * c, u]

    return state


# --- kovalevskaya ---------------------------------------------------------------------------------
#
# Kovalevskaya's top by Abel's two sums, as mpmath's Fourier series, inverted by Newton's method.
#
# In the top's axes and units (Kowalevski, Acta Math. 12 (1889) 177; Golubev, Lectures on the
# Integration of the Equations of Motion of a Rigid Body), with pi = p^2 + q^2, sg = 2p,
# S(s) = (s + H)(s^2 + b) - 2m^2, whose roots are e_j, and w^2 = -2 (s^2 - k^2) S(s), the
# separation variables s1 <= s2 are the roots of q^2 s^2 + (R/2) s + R1/4, and
#
#     ds1/w1 + ds2/w2 = 0,    s1 ds1/w1 + s2 ds2/w2 = dt.
#
# s1 goes from the lowest branch point to -infinity and back, s2 between the two highest ones,
# each with an angle (:class:`Cycle`) that grows for ever, and the sums are integrals of
# periodic functions of the angles. They have one solution at each time.


_MOST = 60  # steps of Newton's method
#: Where a variable turns at t = 0: a time at which none does, over the size of the state, the bits
#: of the state there, and how close the formulas are to come to it.
_MOMENT, _FEW_BITS, _CLOSE = 2**-6, 53, 1e-10


def kovalevskaya_motion(
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
        angles = []
        for cycle, s, point in zip(
            self._cycles, self._variables(state), self._variables(later), strict=True
        ):
            by_r, by_G3 = self._mumford(p, q, point)
            angles.append(cycle.angle(s, (by_r * r + by_G3 * G3) * q))
        return angles

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
            first, second = (c.root((e, 1), x) for c, x in zip(self._cycles, angles, strict=True))
            yield e, f, g, side * first * second

    def _unit(self, angles: Sequence[mpf]) -> mpf:
        """What all the roots have before them."""
        first, second = (c.root((-1, 0), x) for c, x in zip(self._cycles, angles, strict=True))
        return first * second

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
            slope = mpmath.fprod(e - zero for zero in self._e if zero != e)
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
    by_x, by_y = rates
    determinant = (by_x.conjugate() * by_y).imag
    return -(by_y.conjugate() * miss).imag / determinant, (
        by_x.conjugate() * miss
    ).imag / determinant


def _rates(_: mpf, state: Sequence[mpf]) -> list[mpf]:
    """Euler's and Poisson's equations."""
    p, q, r, G1, G2, G3 = state
    w = q * r / 2, (G3 - p * r) / 2, -G2
    return [*w, r * G2 - q * G3, p * G3 - r * G1, q * G1 - p * G2]


# --- top ------------------------------------------------------------------------------------------
#
# A scene's motion by a textbook's formulas, in the scene's axes: its digits repeat.


_SPARE = 8  # bits kept beyond the digits asked for
_GUARD, _GUARD_OF_SERIES = 15, 10  # digits beyond those asked for
_TRIES = 5
_MOTIONS = {
    "euler": euler_motion,
    "lagrange": lagrange_motion,
    "kovalevskaya": kovalevskaya_motion,
}


def states(
    scene: Scene, family: str, regime: str, times: Sequence[Exact], digits: int
) -> list[list[mpf]]:
    """Rows p q r [gamma1 gamma2 gamma3] in the scene's axes, one a time.

    ``family``: euler, lagrange or kovalevskaya, to which the scene belongs; ``regime``: the name of
    the motion.  The rows are those of two working precisions that agree to 10^-digits, of w
    relative to its largest modulus.

    Raises ValueError for a motion that the formulas do not have, ArithmeticError where no two
    precisions agree.
    """
    principal = in_principal_axes(scene)
    # equal roots, and turning points at t = 0, cost half of the digits; series are dear
    guard, working = _GUARD, 2 * (digits + _GUARD)
    if family == "kovalevskaya":
        guard, working = _GUARD_OF_SERIES, digits + _GUARD_OF_SERIES
    before, why = None, "no two of which agree"
    for more in range(_TRIES):
        with mpmath.workdps(working + guard * (2**more - 1)):
            try:
                rows = _rows(scene, principal, family, regime, times)
            except ArithmeticError as fault:
                before, why = None, str(fault)
                continue
            if before is not None and _agree(before, rows, mpmath.mpf(10) ** -(digits + 1)):
                return [_shortened(row, digits) for row in rows]
            before = rows
    raise ArithmeticError(f"{_TRIES} working precisions, {why}")


def _shortened(row: list[mpf], digits: int) -> list[mpf]:
    """Rounded to the digits after the units' place of the largest and a little more."""
    bits = math.ceil(digits * math.log2(10)) + _SPARE
    with mpmath.workprec(bits + max([0, *(mpmath.mag(x) for x in row if x)])):
        return [+x for x in row]


def _rows(
    scene: Scene, principal: PrincipalScene, family: str, regime: str, times: Sequence[Exact]
) -> list[list[mpf]]:
    """The rows at the precision in force; gamma, where it is not given, is any."""

    def vector(v: Sequence[Exact]) -> Any:
        return mpmath.matrix([to_mpf(x, mpmath.prec) for x in v])

    moments, torque, omega = map(vector, principal[:3])
    gamma = vector(principal.gamma or IDENTITY[2])
    own = _axes(family, moments, torque, omega)
    along = [sum(a * x * x for a, x in zip(moments, row, strict=True)) for row in own.tolist()]
    size = mpmath.norm(torque)
    state = _MOTIONS[family](along, size, own * omega, own * gamma, regime)
    back = (own * mpmath.matrix([[*vector(row)] for row in scene.body.axes.rows])).T
    width = 3 if principal.gamma is None else 6
    rows = []
    for t in vector(times):
        row = state(t)
        w, g = (back * mpmath.matrix(v) for v in (row[:3], row[3:]))
        rows.append([*w, *g][:width])
    return rows


def _axes(family: str, moments: Any, torque: Any, omega: Any) -> Any:
    """Rows of the family's axes in the principal ones.

    Euler's third is the one that the polhode circles, the second that of the middle moment;
    Lagrange's third and Kovalevskaya's first go through the centre of mass, and Kovalevskaya's
    third is that of the smallest moment.
    """
    unit = [mpmath.eye(3)[:, k] for k in range(3)]
    order = sorted(range(3), key=lambda k: moments[k])
    if family == "kovalevskaya":
        first, third = torque, unit[order[0]]
    elif family == "lagrange":
        side = unit[min(range(3), key=lambda k: abs(torque[k]))]
        first, third = mpmath.matrix(cross(side, torque)), torque
    else:
        middle = moments[order[1]]
        excess = sum(a * (a - middle) * x * x for a, x in zip(moments, omega, strict=True))
        first, third = unit[order[0 if excess >= 0 else 2]], unit[order[2 if excess >= 0 else 0]]
    first, third = first / mpmath.norm(first), third / mpmath.norm(third)
    return mpmath.matrix([[*first], [*cross(third, first)], [*third]])


def _agree(rows: list[list[mpf]], others: list[list[mpf]], goal: mpf) -> bool:
    """Whether all differences, of w over its largest modulus in these rows, are below the goal.

    Each is asked: the largest of several would pass over one that is not a number.
    """
    rate = max(mpmath.norm(row[:3]) for row in others) or 1
    pairs = [
        abs(x - y) / (rate if k < 3 else 1)
        for row, row_of_others in zip(rows, others, strict=True)
        for k, (x, y) in enumerate(zip(row, row_of_others, strict=True))
    ]
    return all(x < goal for x in pairs)

"""Motion of one degree of freedom between two simple zeros: z' = k sqrt(Q(z)) sqrt(R(z)).

The square roots y = sqrt(Q), w = sqrt(R) move with z: y^2 = Q, w^2 = R, z' = k y w.  Between
adjacent zeros z1 < z2 of Q R, z = M - D cos x,

    x' = |k| sqrt(Q0 R0),    Q = Q0 (z - z1 if that is its zero)(z2 - z if that is its zero),

R likewise; Q0 and R0 have no zero there, and the time t(x) = integral dx/x' is a Fourier series.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from polhode.closed_forms.functions.fourier import Cosines, cosines
from polhode.closed_forms.functions.gamma_from_omega import value
from polhode.common.cached_property import cached_property
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar

_STEP = 0.5  # of Newton's iteration in doubles, at most
_CLOSE = 1e-12
_MOST_STEPS = 60


@dataclass(frozen=True)
class _Factor:
    """Q or R between the two zeros: its quotient by those of its zeros that are ends."""

    quotient: Sequence[Scalar]
    low: bool
    high: bool

    def root(self, z: Scalar, half: Scalar, sine: Scalar, cosine: Scalar) -> Scalar:
        """The square root, with the signs of sin x/2 and cos x/2; ``half`` = sqrt(2 D)."""
        found = mpmath.sqrt(value(self.quotient, z))
        if self.low:
            found *= half * sine
        return found * half * cosine if self.high else found


@dataclass(frozen=True)
class OneDegree:
    """The motion at the precision in force when it was made (:func:`one_degree`)."""

    factors: tuple[_Factor, _Factor]
    k: Scalar
    M: Scalar
    D: Scalar
    signs: tuple[int, int]
    series: Cosines  # of dt/dx
    x0: Scalar

    @cached_property
    def begin(self) -> Scalar:
        """t(x0)."""
        return self._time(self.x0)

    @property
    def period(self) -> Scalar:
        """Of z, y and w: one of z if both ends are zeros of the same polynomial, else two."""
        both = any(factor.low == factor.high for factor in self.factors)
        return (2 if both else 4) * mpmath.pi * self.series.mean

    @property
    def fastest(self) -> Scalar:
        """The mean rate of x."""
        return 1 / self.series.mean

    def at(self, t: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        """z, y, w."""
        period = self.period
        time = self.begin + t
        return self.along(self._phase(time - period * mpmath.nint(time / period)))

    def clock(self, t: Scalar) -> Scalar:
        """x at t, continuous: from x0 at t = 0."""
        return self._phase(self.begin + t)

    def pace(self, x: Scalar) -> Scalar:
        """dt/dx."""
        return 1 / self._rate(x)

    def along(self, x: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        """z, y, w at x."""
        c, (cosine, sine) = mpmath.cos(x), mpmath.cos_sin(x / 2)
        z, half = self.M - self.D * c, mpmath.sqrt(2 * self.D)
        y, w = (
            sign * factor.root(z, half, sine, cosine)
            for sign, factor in zip(self.signs, self.factors, strict=True)
        )
        return z, y, w

    def _time(self, x: Scalar) -> Scalar:
        return self.series.mean * x + self.series.bounded(x)

    def _phase(self, time: Scalar) -> Scalar:
        """x at a time, by Newton's iteration: from doubles, which leave out whole turns."""
        turn = 2 * mpmath.pi
        turns = turn * mpmath.nint(time / (turn * self.series.mean))
        x = turns + self._coarse(float(time - self.series.mean * turns))
        for _ in range(_MOST_STEPS):
            step = (time - self._time(x)) * self._rate(x)
            x += step
            if abs(step) < mpmath.ldexp(1, -mpmath.prec // 2 - 4):
                return x
        raise ArithmeticError("Newton's iteration for the time does not end")

    def _coarse(self, time: float) -> float:
        """x at a time within a turn, in doubles."""
        mean, terms = self._doubles
        x = time / mean
        for _ in range(_MOST_STEPS):
            turn, first, second = 2 * math.cos(x), 0.0, 0.0
            slope, before = 0.0, 0.0
            for k, term in terms:
                first, second = term + turn * first - second, first
                slope, before = k * term + turn * slope - before, slope
            # The sums of a_k sin(k x)/k and of a_k cos(k x) (Clenshaw 1955).
            step = (time - mean * x - math.sin(x) * first) / (mean + turn * slope / 2 - before)
            x += max(-_STEP, min(_STEP, step))
            if abs(step) < _CLOSE:
                break
        return x

    @cached_property
    def _doubles(self) -> tuple[float, list[tuple[int, float]]]:
        """The mean of the series, and k and a_k/k from the last one down, in doubles."""
        found = self.series.doubles()
        return found.mean, [*enumerate(found.terms, 1)][::-1]

    def _rate(self, x: Scalar) -> Scalar:
        return _rate(self.factors, self.k, self.M - self.D * mpmath.cos(x))


def _rate(factors: Sequence[_Factor], k: Scalar, z: Scalar) -> Scalar:
    """x' at z."""
    one, other = (value(factor.quotient, z) for factor in factors)
    if one * other <= 0:
        raise ArithmeticError("no motion between these zeros")
    return abs(k) * mpmath.sqrt(one * other)


def one_degree(
    Q: Sequence[Scalar], R: Sequence[Scalar], k: Scalar, start: tuple[Scalar, Scalar, Scalar]
) -> OneDegree:
    """The motion from z0, y0, w0 with y0^2 = Q(z0), w0^2 = R(z0), at the precision in force.

    Raises ArithmeticError unless z0 lies between two simple zeros.
    """
    z0, y0, w0 = start
    low, high = _ends(Q, R, start)
    M, D = (low[0] + high[0]) / 2, (high[0] - low[0]) / 2
    factors = []
    for which, polynomial in enumerate((Q, R)):
        quotient = list(polynomial)
        if low[1] == which:
            quotient = _divided(quotient, low[0])
        if high[1] == which:
            quotient = [-c for c in _divided(quotient, high[0])]
        factors.append(_Factor(quotient, low[1] == which, high[1] == which))
    both = factors[0], factors[1]

    (series,) = cosines(lambda x: [1 / _rate(both, k, M - D * mpmath.cos(x))])
    rate = _rate(both, k, z0)
    x0 = mpmath.atan2(k * y0 * w0 / (D * rate), (M - z0) / D)
    cosine, sine = mpmath.cos_sin(x0 / 2)
    half = mpmath.sqrt(2 * D)
    one, other = (factor.root(z0, half, sine, cosine) for factor in both)
    sense = 1 if k > 0 else -1
    if abs(y0) >= abs(w0):
        first = 1 if y0 * one > 0 else -1
        signs = first, sense * first
    else:
        second = 1 if w0 * other > 0 else -1
        signs = sense * second, second
    return OneDegree(both, k, M, D, signs, series, x0)


def _ends(
    Q: Sequence[Scalar], R: Sequence[Scalar], start: tuple[Scalar, Scalar, Scalar]
) -> tuple[tuple[Scalar, int], tuple[Scalar, int]]:
    """The zeros next to z0, each with the polynomial it is of (0: Q, 1: R)."""
    z0, y0, w0 = start
    zeros = []
    for which, (polynomial, root) in enumerate(((Q, y0), (R, w0))):
        found = real_zeros(polynomial)
        if not root and found:  # z0 itself is one of them
            nearest = min(range(len(found)), key=lambda i: abs(found[i] - z0))
            found[nearest] = z0
        zeros += [(z, which) for z in found]
    below = [pair for pair in zeros if pair[0] < z0]
    above = [pair for pair in zeros if pair[0] > z0]
    at = [pair for pair in zeros if pair[0] == z0]
    choices = [(at[0], min(above, default=None)), (max(below, default=None), at[0])] if at else []
    for low, high in choices or [(max(below, default=None), min(above, default=None))]:
        if low is None or high is None:
            continue
        middle = (low[0] + high[0]) / 2
        if value(Q, middle) > 0 and value(R, middle) > 0:
            return low, high
    raise ArithmeticError("the start does not lie between two simple zeros")


def real_zeros(polynomial: Sequence[Scalar]) -> list[Scalar]:
    """The real zeros of a polynomial with simple ones, at the precision in force, ascending."""
    prec = mpmath.prec
    with mpmath.extraprec(prec // 2 + 32):
        roots = mpmath.polyroots([*polynomial], maxsteps=200, extraprec=prec, asc=True)
    scale = max((abs(z) for z in roots), default=mpf(0))
    small = mpmath.ldexp(scale, -prec // 2)
    return sorted(+z.real for z in map(mpmath.mpc, roots) if abs(z.imag) < small)


def _divided(polynomial: Sequence[Scalar], zero: Scalar) -> list[Scalar]:
    """The quotient by (z - zero), the rest left out."""
    found, carry = [], mpf(0)
    for c in reversed(polynomial[1:]):
        carry = c + carry * zero
        found.append(carry)
    return found[::-1]

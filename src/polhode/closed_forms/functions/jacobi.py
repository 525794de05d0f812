"""Jacobi's elliptic functions, always in the smaller nome.

The parameter k^2 and its complement k'^2 come separately, so neither end of 0 <= k <= 1 costs a
digit: k = 0 is the circle (nome 0), k' = 0 the separatrix (complementary nome 0).  Either the nome
q = exp(-pi K'/K) or the complementary one q' = exp(-pi K/K') is at most exp(-pi); all series run in
that one (DLMF 20.2, 20.7(viii), 22.2).  An argument is first reduced, v = 2 K n + v_r, |v_r| <= K.

With z = pi v_r/2K or X = pi v_r/2K', everything is a sum over cos and sin of multiples of z, or
over cosh and sinh of multiples of X.  The sums are written with arithmetic only, so the same lines
take mpmath numbers and numpy arrays; :class:`SeriesFunctions` says whose elementary functions to
use.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from mpmath import libmp

from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.rows import Doubles
from polhode.numbers.scalars import Scalar


@dataclass(frozen=True)
class SeriesFunctions:
    """What the series need of one kind of scalar; of a field's see numbers.scalars.Functions."""

    cos_sin: Callable[[Scalar], tuple[Scalar, Scalar]]
    cosh_sinh: Callable[[Scalar], tuple[Scalar, Scalar]]
    sqrt: Callable[[Scalar], Scalar]
    nint: Callable[[Scalar], Scalar]


def _cosh_sinh(x: Scalar) -> tuple[Scalar, Scalar]:
    cosh, sinh = libmp.mpf_cosh_sinh(x._mpf_, mpmath.prec, "n")
    return mpmath.make_mpf(cosh), mpmath.make_mpf(sinh)


#: Functions of mpmath's numbers, at the precision in force.
MP = SeriesFunctions(mpmath.cos_sin, _cosh_sinh, mpmath.sqrt, lambda x: int(mpmath.nint(x)))


def numpy_functions() -> SeriesFunctions:
    """Functions of numpy's arrays of doubles."""
    import numpy as np

    def cosh_sinh(x: Doubles) -> tuple[Doubles, Doubles]:
        x = np.clip(x, -_SATURATED, _SATURATED)
        return np.cosh(x), np.sinh(x)

    return SeriesFunctions(lambda x: (np.cos(x), np.sin(x)), cosh_sinh, np.sqrt, np.rint)


#: Past this X only a nome below exp(-2X) leads (|X| <= log(1/q')/2): a double is at its limit.
_SATURATED = 80.0


@dataclass(frozen=True)
class Waves:
    """Multiples of one reduced argument: cos or cosh of 0, 2, 4, ...; (cos, sin) or (cosh, sinh)
    of 1, 3, ...

    ``turns`` is the n of v = 2 K n + v_r.
    """

    turns: Scalar
    even_c: Sequence[Scalar]
    odd_c: Sequence[Scalar]
    odd_s: Sequence[Scalar]


@dataclass(frozen=True)
class Jacobi:
    """sn, cn, dn of one modulus, at the precision in force when it was made (:func:`jacobi`)."""

    K: Scalar  # quarter period; infinite on the separatrix
    Kc: Scalar  # K', the quarter period of the complementary modulus; infinite on the circle
    complementary: bool  # True: the series run in q'
    nome: Scalar  # the one in use
    scale: Scalar  # pi/2K or pi/2K'
    theta: Sequence[Scalar]  # coefficients of Theta(v), the common denominator
    sn: Sequence[Scalar]
    cn: Sequence[Scalar]
    dn: Sequence[Scalar]

    def waves(self, v: Scalar, fn: SeriesFunctions) -> Waves:
        """The multiples that every sum at v needs."""
        finite = self.K < _INFINITY
        turns = fn.nint(v / (2 * self.K)) if finite else 0 * fn.nint(v)
        reduced = (v - 2 * self.K * turns if finite else v) * self.scale
        if self.complementary:
            c, s = fn.cosh_sinh(reduced)
        else:
            c, s = fn.cos_sin(reduced)
        c2 = 2 * c * c - 1
        count = len(self.theta)
        return Waves(
            turns,
            _ladder(c2, 1 + 0 * c, c2, count),
            _ladder(c, c, c2, count),
            _ladder(-s, s, c2, count),
        )

    def denominator(self, waves: Waves) -> Scalar:
        """Theta(v_r), to a constant factor."""
        return dot(self.theta, waves.odd_c if self.complementary else waves.even_c)

    def functions(self, waves: Waves) -> tuple[Scalar, Scalar, Scalar]:
        """(sn, cn, dn) at v_r, where cn >= 0; at v, sn and cn carry the sign (-1)^n."""
        up = waves.even_c if self.complementary else waves.odd_c
        over = 1 / self.denominator(waves)
        return (
            dot(self.sn, waves.odd_s) * over,
            dot(self.cn, up) * over,
            dot(self.dn, waves.even_c) * over,
        )

    def floats(self) -> Jacobi:
        """The same with Python floats in place of mpmath's numbers."""
        return Jacobi(
            float(self.K),
            float(self.Kc),
            self.complementary,
            float(self.nome),
            float(self.scale),
            *([float(x) for x in row] for row in (self.theta, self.sn, self.cn, self.dn)),
        )


_INFINITY = float("inf")


def jacobi(k2: Scalar, kc2: Scalar) -> Jacobi:
    """The functions of parameter k2 = k^2 and complement kc2 = k'^2 (sum 1, both >= 0)."""
    pi, inf = mpmath.pi, mpmath.inf
    quarter = pi / (2 * mpmath.agm(1, mpmath.sqrt(kc2))) if kc2 else inf
    other = pi / (2 * mpmath.agm(1, mpmath.sqrt(k2))) if k2 else inf
    complementary = bool(k2 > kc2)
    short, long = (other, quarter) if complementary else (quarter, other)
    nome = mpmath.exp(-pi * long / short) if long < inf else mpf(0)
    count = _terms(nome)
    square = [nome ** (j * j) for j in range(count)]  # q^(j^2)
    oblong = [nome ** (j * (j + 1)) for j in range(count)]  # q^(j(j+1))
    theta3 = [2 * c if j else c for j, c in enumerate(square)]
    theta4 = _alternate(theta3)
    theta2 = [2 * c for c in oblong]  # without its q^(1/4), as theta1
    theta1 = _alternate(theta2)
    two, three, four = (mpmath.fsum(t) for t in (theta2, theta3, theta4))
    numbers = (quarter, other, complementary, nome, pi / (2 * short))
    if complementary:
        return Jacobi(
            *numbers,
            theta=theta2,
            sn=_times(three / four, theta1),
            cn=_times(two / four, theta4),
            dn=_times(two / three, theta3),
        )
    return Jacobi(
        *numbers,
        theta=theta4,
        sn=_times(three / two, theta1),
        cn=_times(four / two, theta2),
        dn=_times(four / three, theta3),
    )


def dot(row: Sequence[Scalar], waves: Sequence[Scalar]) -> Scalar:
    """The sum of products; starts at the first, for a numpy array has no zero to start from."""
    total = row[0] * waves[0]
    for a, b in zip(row[1:], waves[1:], strict=True):
        total = total + a * b
    return total


def _ladder(before: Scalar, first: Scalar, c2: Scalar, count: int) -> list[Scalar]:
    """first, then x_(j+1) = 2 c2 x_j - x_(j-1), with x_(-1) = before."""
    rungs = [first]
    for _ in range(count - 1):
        before, first = first, 2 * c2 * first - before
        rungs.append(first)
    return rungs


def _terms(nome: Scalar) -> int:
    """How many terms reach the precision in force: the worst one left out is nome^(j(j-1))."""
    if nome == 0:
        return 1
    bits = float(-mpmath.log(nome, 2))
    return math.ceil((1 + math.sqrt(1 + 4 * (mpmath.prec + 4) / bits)) / 2)


def _alternate(row: list[Scalar]) -> list[Scalar]:
    return [-x if j % 2 else x for j, x in enumerate(row)]


def _times(factor: Scalar, row: list[Scalar]) -> list[Scalar]:
    return [factor * x for x in row]

"""How the argument of a combination of theta functions grows along a straight line.

    f(z) = sum over N in Z^2 of A_(N mod 2) exp(pi i N.tau N/2 + pi i N.z),

the combination of the th[a,0](z | 2 tau) with coefficients A_a.  On the line z + s d each term E
varies as exp(nu s), nu = pi i N.d.  About s = c, with la the mean of nu weighted with |E|,

    f(c + x) e^(-la x) = f0 + f1 x + rest,    f_j = sum of E (nu - la)^j,
    |rest| <= |f2| h^2/2 + sum of |E| y^3 e^y/6,    y = |nu - la| h,    |x| <= h.

Where f0 + f1 x stays farther from 0 than that, the argument grows as that of e^(la x) (f0 + f1 x),
but for less than pi/2: pieces of the line are halved until that is so.  Doubles do, but for pieces
next to a zero, which are left to the precision in force.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import flint
import numpy as np
import numpy.typing as npt

from polhode.closed_forms.kovalevskaya.theta.balls import Ball, ball, middle, more_bits
from polhode.closed_forms.kovalevskaya.theta.riemann_periods import Pair, SymmetricMatrix
from polhode.closed_forms.kovalevskaya.theta.riemann_theta import whole_parts
from polhode.common.cached_property import cached_property
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from polhode.numbers.scalars import Scalar

_DECAY = 60.0  # terms below e^-this of the largest are left out in doubles
_WIDEST = 300.0  # e^this: the ratio of coefficients up to which the smaller ones are looked after
_LOST = 1e-11  # of the sum of the terms' moduli: more than the errors of doubles
_SHARE = 0.5  # of x and of y (z = x + tau y) that a piece may move to either side
_FIRST = 8  # pieces
_LEVELS = 24  # halvings in doubles
_MOST = 256  # pieces without an end: the line goes along zeros, not past them

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Complexes = npt.NDArray[np.complex128]
Flags = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Piece:
    """A settled piece: its centre, the argument there, and its growth to either end."""

    at: Scalar
    argument: float
    ahead: float
    back: float


@dataclass(frozen=True)
class ThetaSum:
    """One combination; ``coefficients`` for a = (0,0), (0,1), (1,0), (1,1)."""

    tau: SymmetricMatrix
    coefficients: Sequence[Scalar]

    def growth(self, z: Pair, way: Pair) -> float:
        """Of the argument from z to z + way.

        Raises ArithmeticError where f comes too near 0 to be told from it.
        """
        if not (way[0] or way[1]):
            return 0.0
        line = Line(self, z, way)
        pieces = [line.end(mpf(0)), *sorted(line.pieces(), key=lambda x: x.at), line.end(mpf(1))]
        total = 0.0
        for one, other in pairwise(pieces):
            told, found = one.ahead - other.back, other.argument - one.argument
            total += found + 2 * math.pi * round((told - found) / (2 * math.pi))
        return total

    @cached_property
    def doubles(self) -> tuple[Complexes, complex, complex, complex]:
        """The coefficients, over the largest, and tau."""
        size = max(map(abs, self.coefficients))
        values = np.array([complex(x / size) for x in self.coefficients])
        return values, complex(self.tau[0]), complex(self.tau[1]), complex(self.tau[2])

    @cached_property
    def largest(self) -> float:
        """The largest coefficient's modulus."""
        return float(max(map(abs, self.coefficients)))

    @cached_property
    def coarse(self) -> Integers:
        """The N that count in doubles, as seen from the integers nearest to -y."""
        return self.window(_DECAY)

    @cached_property
    def fine(self) -> Integers:
        """Those that count at the precision in force."""
        return self.window(mpmath.prec * math.log(2) + 10)

    @cached_property
    def gaussian(self) -> dict[tuple[int, int], Ball]:
        """Those N with exp(pi i N.tau N/2), as balls of FLINT."""
        t11, t12, t22 = (ball(mpc(t / 2)) for t in self.tau)
        with more_bits():
            return {
                (n1, n2): (t11 * (n1 * n1) + t12 * (2 * n1 * n2) + t22 * (n2 * n2)).exp_pi_i()
                for n1, n2 in self.fine.T.tolist()
            }

    def table(self, odd1: int, odd2: int) -> Ball:
        """Their products with the coefficients of N - k, k modulo 2 as given: a row an N1."""
        if (odd1, odd2) not in self.tables:
            last1, last2 = self.last
            rows = [ball(mpc(A)) for A in self.coefficients]
            with more_bits():
                found = flint.acb_mat(2 * last1 + 1, 2 * last2 + 1)
                for (n1, n2), value in self.gaussian.items():
                    A = rows[2 * ((n1 - odd1) % 2) + (n2 - odd2) % 2]
                    found[n1 + last1, n2 + last2] = value * A
            self.tables[odd1, odd2] = found
        return self.tables[odd1, odd2]

    @cached_property
    def tables(self) -> dict[tuple[int, int], Ball]:
        """Those of :meth:`table` that were asked for."""
        return {}

    @cached_property
    def last(self) -> tuple[int, int]:
        """The largest N1 and N2 of the fine ones."""
        one, other = np.abs(self.fine).max(axis=1)
        return int(one), int(other)

    def window(self, decay: float) -> Integers:
        """The N with terms above e^-decay of the largest, for |y1|, |y2| <= 1/2."""
        sizes = [abs(x) for x in self.coefficients if x]
        spread = float(mpmath.log(max(sizes) / min(sizes)))
        y11, y12, y22 = (float(t.imag) for t in self.tau)
        # |term| = |A| e^(-pi/2 (N+y).Y(N+y)); a corner of the y is as far as it may be.
        corner = math.sqrt(y11 + y22 + 2 * abs(y12)) / 2
        reach = math.sqrt(2 / math.pi * (decay + min(spread, _WIDEST))) + 2 * corner
        det = y11 * y22 - y12 * y12
        last1, last2 = (int(reach * math.sqrt(y / det)) for y in (y22, y11))
        one, other = (
            x.ravel() for x in np.mgrid[-last1 : last1 + 1, -last2 : last2 + 1].astype(np.int64)
        )
        size = y11 * one * one + 2 * y12 * one * other + y22 * other * other
        return np.stack([one, other])[:, size <= reach * reach]


class Line:
    """f along z + s way, 0 <= s <= 1."""

    def __init__(self, f: ThetaSum, z: Pair, way: Pair) -> None:
        self._f, self._z, self._way = f, z, way
        self._begin, self._move = (
            [float(v) for part in whole_parts(f.tau, p) for v in part[0]] for p in (z, way)
        )

    def end(self, s: Scalar) -> Piece:
        """A piece without length."""
        moments, *_ = self._moments(s)
        return Piece(s, float(mpmath.arg(moments[0][0])), 0.0, 0.0)

    def pieces(self) -> Iterator[Piece]:
        """Settled ones that cover the line."""
        count = max(_FIRST, math.ceil(max(map(abs, self._move)) / (2 * _SHARE)))
        half = 0.5 / count
        centres: Floats = (2 * np.arange(count, dtype=np.float64) + 1) * half
        for level in range(_LEVELS):
            good, blind, found = self._tried(centres, half)
            yield from found
            if level == _LEVELS - 1:
                blind = ~good
            for c in centres[blind]:
                yield from self._refined(mpf(float(c)), mpf(half))
            left = centres[~good & ~blind]
            if not len(left):
                return
            if len(left) > _MOST:
                raise ArithmeticError("a path too near zeros everywhere")
            half /= 2
            centres = np.concatenate([left - half, left + half])

    def _tried(self, c: Floats, half: float) -> tuple[Flags, Flags, list[Piece]]:
        """Which pieces are settled in doubles, for which doubles do not do, and the former."""
        terms, rates = self._doubles(c)
        sizes = np.abs(terms)
        total = sizes.sum(axis=1)
        mean = (rates * sizes).sum(axis=1) / total
        rest = rates - mean[:, None]
        f0, f1, f2 = ((terms * rest**j).sum(axis=1) for j in range(3))
        y = np.abs(rest) * half
        with np.errstate(over="ignore", invalid="ignore"):
            bound = np.abs(f2) * half**2 / 2 + _LOST * total
            bound += (sizes * y**3 * np.exp(y)).sum(axis=1) / 6
        near = [_nearest(complex(a), complex(b) * half) for a, b in zip(f0, f1, strict=True)]
        good = np.array(near) > bound
        blind = ~good & (np.abs(f0) < 2 * _LOST * total)
        found = []
        for i in np.flatnonzero(good):
            slope, la = complex(f1[i] / f0[i]) * half, float(mean[i].imag) * half
            argument = float(np.angle(f0[i]))
            found.append(_piece(mpf(float(c[i])), argument, slope, la))
        return good, blind, found

    def _doubles(self, c: Floats) -> tuple[Complexes, Complexes]:
        """The terms, over a positive number, and their nu: a row a centre."""
        values, t11, t12, t22 = self._f.doubles
        x1, x2, y1, y2 = (
            (a + b * c)[:, None] for a, b in zip(self._begin, self._move, strict=True)
        )
        one, other = self._f.coarse
        n1, n2 = one - np.rint(y1).astype(np.int64), other - np.rint(y2).astype(np.int64)
        m1, m2 = n1 + y1, n2 + y2
        turn = (t11.real * n1 * n1 + 2 * t12.real * n1 * n2 + t22.real * n2 * n2) / 2
        turn = turn + n1 * (x1 + t11.real * y1 + t12.real * y2)
        turn = turn + n2 * (x2 + t12.real * y1 + t22.real * y2)
        decay = (t11.imag * m1 * m1 + 2 * t12.imag * m1 * m2 + t22.imag * m2 * m2) / 2
        terms = values[2 * (n1 % 2) + n2 % 2] * np.exp(np.pi * (1j * turn - decay))
        d1, d2 = (complex(z) for z in self._way)
        return terms, 1j * np.pi * (n1 * d1 + n2 * d2)

    def _refined(self, c: Scalar, half: Scalar) -> Iterator[Piece]:
        """The same at the precision in force."""
        pending = [(c, half)]
        d1, d2 = self._way
        for _ in range(_MOST):
            c, half = pending.pop()
            moments, sizes, k = self._moments(c)
            rates = self._rates
            total = sizes.sum()
            mean = complex((rates * sizes).sum() / total)
            # f_j = sum of E (nu - la)^j: nu = pi i M.d but for what is common
            la, e1, e2 = mpc(mean), 1j * mpmath.pi * d1, 1j * mpmath.pi * d2
            f0 = moments[0][0]
            g1 = e1 * moments[1][0] + e2 * moments[0][1]
            g2 = e1 * e1 * moments[2][0] + 2 * e1 * e2 * moments[1][1] + e2 * e2 * moments[0][2]
            f1, f2 = g1 - la * f0, g2 - 2 * la * g1 + la * la * f0
            y = np.abs(rates - mean) * float(half)
            with np.errstate(over="ignore", invalid="ignore"):
                rest = float((sizes * y**3 * np.exp(y)).sum()) / 6
            bound = abs(f2) * half * half / 2 + rest * (1 + _LOST)
            bound += mpmath.ldexp(mpf(float(total)), 16 - mpmath.prec)
            if _nearest(f0, f1 * half) > bound:
                common = e1 * k[0] + e2 * k[1]
                argument, turn = float(mpmath.arg(f0)), float((la - common).imag * half)
                yield _piece(c, argument, complex(f1 / f0 * half), turn)
            else:
                pending += _cut(c, half, f0, f1, bound)
            if not pending:
                return
        raise ArithmeticError("a parameter of the attitude comes too near 0")

    @cached_property
    def _rates(self) -> Complexes:
        """nu of the fine M."""
        one, other = self._f.fine
        d1, d2 = (complex(z) for z in self._way)
        rates: Complexes = 1j * np.pi * (one * d1 + other * d2)
        return rates

    def _moments(self, s: Scalar) -> tuple[list[list[Scalar]], Floats, tuple[int, int]]:
        """Sums of E M1^i M2^j for i + j <= 2, N = M - k; the |E| in doubles; and k.

        The terms are over a positive number.
        """
        t11, t12, t22 = self._f.tau
        z1, z2 = (a + s * b for a, b in zip(self._z, self._way, strict=True))
        _, ((y1, y2), (k1, k2)) = whole_parts(self._f.tau, (z1, z2))
        half = 0.5j * mpmath.pi
        # N = M - k: pi i N.tau N/2 + pi i N.z is that of M and z - tau k, and what is common
        most = (half * (t11 * y1 * y1 + 2 * t12 * y1 * y2 + t22 * y2 * y2)).real
        common = t11 * k1 * k1 + 2 * t12 * k1 * k2 + t22 * k2 * k2 - 2 * (k1 * z1 + k2 * z2)
        factor = mpmath.exp(half * common + most)
        inner, outer = z1 - t11 * k1 - t12 * k2, z2 - t12 * k1 - t22 * k2
        last1, last2 = self._f.last
        with more_bits():
            across = [
                [x * n**j for j in range(3)]
                for n, x in zip(range(-last2, last2 + 1), _powers(outer, last2), strict=True)
            ]
            down = [
                [x * n**i for n, x in zip(range(-last1, last1 + 1), row, strict=True)]
                for row in [_powers(inner, last1)]
                for i in range(3)
            ]
            table = self._f.table(k1 % 2, k2 % 2)
            found = flint.acb_mat(down) * (table * flint.acb_mat(across))
            rows = [[factor * middle(found[i, j]) for j in range(3 - i)] for i in range(3)]
        return rows, self._sizes((float(y1 - k1), float(y2 - k2)), (k1, k2)), (k1, k2)

    def _sizes(self, y: tuple[float, float], k: tuple[int, int]) -> Floats:
        """|E| of the fine M, at z = x + tau (y + k)."""
        values, t11, t12, t22 = self._f.doubles
        one, other = self._f.fine
        m1, m2 = one + y[0], other + y[1]
        decay = (t11.imag * m1 * m1 + 2 * t12.imag * m1 * m2 + t22.imag * m2 * m2) / 2
        A = np.abs(values[2 * ((one - k[0]) % 2) + (other - k[1]) % 2])
        sizes: Floats = A * np.exp(-np.pi * decay) * self._f.largest
        return sizes


def _powers(z: Scalar, last: int) -> list[Ball]:
    """e^(pi i n z) for -last <= n <= last."""
    x = ball(mpc(z)).exp_pi_i()
    over = 1 / x
    ahead, back = [flint.acb(1)], [flint.acb(1)]
    for _ in range(last):
        ahead.append(ahead[-1] * x)
        back.append(back[-1] * over)
    return back[:0:-1] + ahead


def _piece(at: Scalar, argument: float, slope: complex, turn: float) -> Piece:
    """The growth of e^(la x) (1 + slope x/h), ``turn`` being that of e^(la h)."""
    ahead, back = (math.atan2(side * slope.imag, 1 + side * slope.real) for side in (1, -1))
    return Piece(at, argument, ahead + turn, back - turn)


def _cut(
    c: Scalar, half: Scalar, f0: Scalar, f1: Scalar, bound: Scalar
) -> list[tuple[Scalar, Scalar]]:
    """Parts of a piece, as centres and half lengths: halves, or what is next to a zero apart.

    Where f0 + f1 x is 0 at x = x0, the middle part reaches as far as the geometric mean of the
    piece and of the zero's distance from the line: a few cuts come to any zero.
    """
    if f1:
        x0 = -f0 / f1
        reach = mpmath.sqrt(half * (abs(x0.imag) + bound / abs(f1)))
        if abs(x0.real) < half and reach < half / 2:
            marks = [-half, x0.real - reach, x0.real + reach, half]
            marks = [min(max(x, -half), half) for x in marks]
            parts = pairwise(marks)
            return [(c + (a + b) / 2, (b - a) / 2) for a, b in parts if b > a]
    return [(c - half / 2, half / 2), (c + half / 2, half / 2)]


def _nearest(f0: Scalar, step: Scalar) -> Scalar:
    """The distance of 0 from the segment from f0 - step to f0 + step."""
    square = (step * step.conjugate()).real
    if not square:
        return abs(f0)
    share = -(f0 * step.conjugate()).real / square
    return abs(f0 + min(max(share, -1), 1) * step)

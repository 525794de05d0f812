"""Hess's motion with f not 0: one period of an elliptic gamma1, and powers of a matrix.

u = gamma1 obeys u'^2 = 2P(h/P - u)(1 - u^2) - f^2 (units with b = 1), of period t1.  The rest is a
linear equation with that period: over t1 the axes turn by Th about e1, and

    N = diag(e^{-i Th/2}, e^{i Th/2}) [[U, conj V], [V, conj U]](t1),    |U|^2 - |V|^2 = 1,
    (al, conj al) = N^n (1, 1),    U~ = U al + conj(V al),    Z = z e,  Gm = g e,  e = conj(U~)/U~.

|tr N| > 2: the motion tends to a periodic one; < 2: it has two frequencies (Nekrasov 1896 reduced
it to such an equation).  No closed form of N is known.
"""

from __future__ import annotations

from dataclasses import dataclass

from polhode.closed_forms.functions.jacobi import SeriesFunctions
from polhode.closed_forms.functions.quaternion import Quaternion, conjugate, of_matrix, product
from polhode.closed_forms.functions.rounding import number
from polhode.closed_forms.hess.axes import HessStart
from polhode.closed_forms.hess.explicit import SurfacePoint
from polhode.closed_forms.hess.series import Period, period
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from polhode.numbers.scalars import Scalar


@dataclass(frozen=True)
class GeneralMotion:
    """The constants of one motion at one precision."""

    period_of_u: Scalar  # t1
    series: Period
    N: tuple[Scalar, Scalar]  # its first column, U and V
    space: Scalar  # half of the turn about the vertical over a period
    period = None

    def at(self, t: Scalar, fn: SeriesFunctions) -> SurfacePoint:
        """The motion at t."""
        n = int(mpmath.floor(t / self.period_of_u))
        z1, z2, g1, g2, u, U1, U2, V1, V2, *q = self.series.at(t - n * self.period_of_u)
        power = powered(self.N, n)
        al = power[0] + power[1].conjugate()
        inner = mpc(U1, U2) * al + (mpc(V1, V2) * al).conjugate()
        half = inner.conjugate() / abs(inner)
        e = half * half
        Z, g = mpc(z1, z2) * e, mpc(g1, g2) * e
        # The axes of the series, n turns on in space and turned back by e about e1.
        cos, sin = mpmath.cos_sin(n * self.space)
        zero = mpf(0)
        turn = product((q[0], q[1], q[2], q[3]), (half.real, -half.imag, zero, zero))
        frame = product((cos, zero, zero, sin), turn)
        return SurfacePoint((Z.real, Z.imag), (g.real, g.imag), u, frame)

    @property
    def trace(self) -> Scalar:
        """tr N."""
        return 2 * self.N[0].real

    @property
    def rate(self) -> Scalar | None:
        """How fast the motion tends to a periodic one, 2 ln|eigenvalue|/t1; None: it does not."""
        half = abs(self.trace) / 2
        return 2 * mpmath.acosh(half) / self.period_of_u if half > 1 else None

    @property
    def apart(self) -> Scalar:
        """|ln| of the share of one eigenvector over that of the other at the start."""
        root = mpmath.sqrt(self.trace**2 / 4 - 1)
        large = self.trace / 2 + (root if self.trace > 0 else -root)
        after = self.N[0] + self.N[1].conjugate()
        one = (after - 1 / large) / (large - 1 / large)
        return abs(mpmath.log(abs(one) / abs(1 - one)))

    @property
    def frequencies(self) -> tuple[Scalar, Scalar | None]:
        """2 pi/t1, and of two frequencies that of e, modulo the first."""
        first = 2 * mpmath.pi / self.period_of_u
        half = abs(self.trace) / 2
        return first, None if half >= 1 else 2 * mpmath.acos(half) / self.period_of_u


def powered(N: tuple[Scalar, Scalar], n: int) -> tuple[Scalar, Scalar]:
    """The first column of N^n, N = [[A, conj B], [B, conj A]] of determinant 1."""
    A, B = N
    if n < 0:
        A, B, n = A.conjugate(), -B, -n
    one, other = mpc(1), mpc(0)
    while n:
        if n & 1:
            one, other = _joined((A, B), (one, other))
        A, B = _joined((A, B), (A, B))
        n >>= 1
    return one, other


def _joined(a: tuple[Scalar, Scalar], b: tuple[Scalar, Scalar]) -> tuple[Scalar, Scalar]:
    """The first column of a product of two such matrices."""
    return (
        a[0] * b[0] + a[1].conjugate() * b[1],
        a[1] * b[0] + a[0].conjugate() * b[1],
    )


def general(start: HessStart, bits: int) -> GeneralMotion:
    """The constants at the precision in force, that of ``bits`` bits."""
    P, h, f, a12, u = (number(x, bits) for x in (start.P, start.h, start.f, start.a12, start.u))
    z, g = ([number(x, bits) for x in pair] for pair in (start.Z, start.g))
    u1, u2, u3 = _roots(P, h, f)
    rate = mpmath.sqrt(P / 2)
    t1 = mpmath.pi / (rate * mpmath.agm(mpmath.sqrt(u3 - u1), mpmath.sqrt(u3 - u2)))
    first = of_matrix(_upright(u, *g))
    begin = [*z, *g, u, mpf(1), mpf(0), mpf(0), mpf(0), *first]
    series = period(begin, P, a12, t1)
    z1, z2, _, _, _, U1, U2, V1, V2, *q = series.at(t1)
    turned = mpmath.arg(mpc(z1, z2) / mpc(*z))
    c, s = mpmath.cos_sin(turned / 2)
    back = mpc(c, -s)
    N = mpc(U1, U2) * back, mpc(V1, V2) * back.conjugate()
    # q(t1) then a turn by Th about e1 is a turn about the vertical, then q(0).
    zero = mpf(0)
    end: Quaternion = (q[0], q[1], q[2], q[3])
    whole = product(product(end, (c, s, zero, zero)), conjugate(first))
    return GeneralMotion(t1, series, N, mpmath.atan2(whole[3], whole[0]))


def _upright(u: Scalar, x: Scalar, y: Scalar) -> tuple[tuple[Scalar, ...], ...]:
    """A rotation that takes gamma = (u, x, y) to the vertical."""
    i = min(range(3), key=lambda n: abs((u, x, y)[n]))
    gamma = (u, x, y)
    size = mpmath.sqrt(sum(gamma[n] ** 2 for n in range(3) if n != i))
    row = [-gamma[i] * gamma[n] / size if n != i else size for n in range(3)]
    other = (
        x * row[2] - y * row[1],
        y * row[0] - u * row[2],
        u * row[1] - x * row[0],
    )
    return tuple(row), other, gamma


def _roots(P: Scalar, h: Scalar, f: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """u1 <= u2 < 1 < u3 of 2P(h/P - u)(1 - u^2) = f^2, by Viete's formula.

    t1 is symmetric in u1 and u2: where they nearly meet, what their difference loses does not
    enter.
    """
    shift = h / (3 * P)
    # u = x + shift: x^3 - c1 x + c0
    c1 = 1 + 3 * shift * shift
    c0 = 2 * shift - 2 * shift**3 - f * f / (2 * P)
    square = mpmath.sqrt(max(mpf(0), 4 * c1**3 - 27 * c0 * c0))
    angle = mpmath.atan2(square, -c0 * mpmath.sqrt(mpf(27)))
    size = 2 * mpmath.sqrt(c1 / 3)
    one, two, three = (
        shift + size * mpmath.cos((angle + 2 * mpmath.pi * k) / 3) for k in (1, 2, 0)
    )
    return one, two, three

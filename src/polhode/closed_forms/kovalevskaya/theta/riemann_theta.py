"""Riemann's theta functions of genus 2 with half-integer characteristics, and one derivative.

    th[a,b](z) = sum over n in Z^2 of exp(pi i (n+a/2).tau(n+a/2) + 2 pi i (n+a/2).(z+b/2))

(DLMF 21.2.5 with alpha = a/2, beta = b/2; Mumford, Tata Lectures on Theta I, II.1), a and b in
{0,1}^2; odd in z where a.b is odd.  With z = z' + l + tau k,

    th[a,b](z) = exp(-pi i k.tau k - 2 pi i k.z') (-1)^(a.l + b.k) th[a,b](z')      (DLMF 21.3.4)

and since only quotients are wanted, the exponential, common to all sixteen, is left out here.
All points of a half-integer lattice are summed at once: the sixteen functions are sums over the
residues of 2(n+a/2) modulo 4.  The sums run in integers, as fixed-point numbers.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import mul
from typing import Any

from mpmath import libmp

from polhode.closed_forms.kovalevskaya.theta.riemann_periods import Pair, SymmetricMatrix
from polhode.numbers.mpmath_context import mpc, mpmath
from polhode.numbers.scalars import Scalar

#: A characteristic a1, a2, b1, b2 of zeros and ones.
Characteristic = tuple[int, int, int, int]

FLINT_FROM = 448  # bits
_SPARE = 12  # bits beyond the precision in force


def added(*characteristics: Characteristic) -> Characteristic:
    """The sum modulo 2."""
    a, b, c, d = (sum(column) % 2 for column in zip(*characteristics, strict=True))
    return a, b, c, d


def is_odd(characteristic: Characteristic) -> bool:
    """Whether the theta function is odd."""
    a1, a2, b1, b2 = characteristic
    return (a1 * b1 + a2 * b2) % 2 == 1


@dataclass(frozen=True)
class Thetas:
    """The functions of some characteristics for one tau and one direction V.

    ``at(z)`` gives pairs (value, derivative along V), one a characteristic, all to the common
    factor of the module's remark.
    """

    tau: SymmetricMatrix
    direction: Pair
    characteristics: tuple[Characteristic, ...]
    sums: Callable[[Pair, Sequence[Characteristic]], list[tuple[Scalar, Scalar, Scalar]]]

    def at(self, z: Pair) -> list[tuple[Scalar, Scalar]]:
        """Values and derivatives along V at z."""
        (_, l), (_, k) = whole_parts(self.tau, z)
        rest = (
            z[0] - l[0] - self.tau[0] * k[0] - self.tau[1] * k[1],
            z[1] - l[1] - self.tau[1] * k[0] - self.tau[2] * k[1],
        )
        found = []
        v1, v2 = self.direction
        rows = self.sums(rest, self.characteristics)
        for (a1, a2, b1, b2), (value, d1, d2) in zip(self.characteristics, rows, strict=True):
            slope = d1 * v1 + d2 * v2
            if (a1 * l[0] + a2 * l[1] + b1 * k[0] + b2 * k[1]) % 2:
                value, slope = -value, -slope
            found.append((value, slope))
        return found


def whole_parts(tau: SymmetricMatrix, z: Pair) -> tuple[tuple[Pair, Pair], tuple[Pair, Pair]]:
    """(x, l), (y, k): z = x + tau y with real x, y, and the integers l, k nearest to them."""
    y11, y12, y22 = (t.imag for t in tau)
    i1, i2 = z[0].imag, z[1].imag
    det = y11 * y22 - y12 * y12
    y = (y22 * i1 - y12 * i2) / det, (y11 * i2 - y12 * i1) / det
    x = (
        z[0].real - tau[0].real * y[0] - tau[1].real * y[1],
        z[1].real - tau[1].real * y[0] - tau[2].real * y[1],
    )
    l = int(mpmath.nint(x[0])), int(mpmath.nint(x[1]))
    k = int(mpmath.nint(y[0])), int(mpmath.nint(y[1]))
    return (x, l), (y, k)


def thetas(
    tau: SymmetricMatrix,
    direction: Pair,
    characteristics: Sequence[Characteristic],
    backend: str | None = None,
) -> Thetas:
    """The functions at the precision in force, for a tau that is reduced
    (:func:`polhode.closed_forms.kovalevskaya.theta.riemann_periods.reduced`).

    ``backend`` is "mpmath" or "flint"; None takes flint from FLINT_FROM bits on, where python-flint
    is installed: below, the sums in integers are as fast.
    """
    if backend is None:
        backend = "flint" if mpmath.prec >= FLINT_FROM and has_flint() else "mpmath"
    sums = _flint_sums(tau) if backend == "flint" else _fixed_point_sums(tau)
    return Thetas(tau, direction, tuple(characteristics), sums)


def has_flint() -> bool:
    """Whether python-flint is installed, with its theta functions."""
    try:
        from flint import acb_mat  # type: ignore[import-not-found, unused-ignore]
    except ImportError:
        return False
    return hasattr(acb_mat, "theta_jets")


def _fixed_point_sums(
    tau: SymmetricMatrix,
) -> Callable[[Pair, Sequence[Characteristic]], list[tuple[Scalar, Scalar, Scalar]]]:
    """The sums over a half-integer lattice, N = 2n: values, d/dz1 and d/dz2."""
    y11, y12, y22 = (float(t.imag) for t in tau)
    prec = mpmath.prec + _SPARE
    reach = math.sqrt((prec + 10) * math.log(2) / math.pi)
    # The largest |y| of a reduced argument, in the metric of Im tau.
    edge = math.sqrt(y11 + y22 + 2 * abs(y12)) / 2
    radius = reach + edge
    # Terms are products of a small number and a large one, at most exp(2 pi |n||y|).
    fixed = prec + math.ceil(2 * math.pi * radius * edge / math.log(2)) + 8
    rows = _lattice(tau, radius, fixed)
    last1 = max(abs(row[0]) for row in rows)
    last2 = max(max(map(abs, ns)) for _, classes in rows for ns, _, _ in classes if ns)

    def sums(z: Pair, wanted: Sequence[Characteristic]) -> list[tuple[Scalar, Scalar, Scalar]]:
        outer = _powers(z[0], last1, fixed)
        inner = _powers(z[1], last2, fixed)
        ladders = {}
        for n in inner:
            re, im = inner[n]
            ladders[n] = (re, im, n * re, n * im)
        # By residues of N1 and N2 modulo 4: the sum, and those weighted with N1 and N2.
        table = [[[0] * 6 for _ in range(4)] for _ in range(4)]
        for n1, classes in rows:
            ar, ai = outer[n1]
            line = table[n1 % 4]
            for cell, (ns, cr, ci) in zip(line, classes, strict=True):
                if not ns:
                    continue
                ur, ui, vr, vi = zip(*[ladders[n] for n in ns], strict=True)
                re = (sum(map(mul, cr, ur)) - sum(map(mul, ci, ui))) >> fixed
                im = (sum(map(mul, cr, ui)) + sum(map(mul, ci, ur))) >> fixed
                re2 = (sum(map(mul, cr, vr)) - sum(map(mul, ci, vi))) >> fixed
                im2 = (sum(map(mul, cr, vi)) + sum(map(mul, ci, vr))) >> fixed
                sr, si = ar * re - ai * im, ar * im + ai * re
                cell[0] += sr
                cell[1] += si
                cell[2] += n1 * sr
                cell[3] += n1 * si
                cell[4] += ar * re2 - ai * im2
                cell[5] += ar * im2 + ai * re2
        over = 1j * mpmath.pi
        found = []
        for characteristic in wanted:
            value, d1, d2 = (
                mpc(
                    _scaled(total[2 * i], 2 * fixed),
                    _scaled(total[2 * i + 1], 2 * fixed),
                )
                for total in (_joined(table, characteristic),)
                for i in range(3)
            )
            found.append((value, over * d1, over * d2))
        return found

    return sums


def _scaled(mantissa: int, bits: int) -> Scalar:
    """mantissa/2^bits at the precision in force."""
    return mpmath.make_mpf(libmp.from_man_exp(mantissa, -bits, mpmath.prec, "n"))


def _joined(table: list[list[list[int]]], characteristic: Characteristic) -> list[int]:
    """The sum over residues with the phases i^(N.b); six integers, real and imaginary parts."""
    a1, a2, b1, b2 = characteristic
    total = [0] * 6
    for r1 in (a1, a1 + 2):
        for r2 in (a2, a2 + 2):
            cell = table[r1][r2]
            turn = (r1 * b1 + r2 * b2) % 4
            for i in (0, 2, 4):
                re, im = cell[i], cell[i + 1]
                if turn == 0:
                    total[i] += re
                    total[i + 1] += im
                elif turn == 1:
                    total[i] -= im
                    total[i + 1] += re
                elif turn == 2:
                    total[i] -= re
                    total[i + 1] -= im
                else:
                    total[i] += im
                    total[i + 1] -= re
    return total


def _lattice(tau: SymmetricMatrix, radius: float, fixed: int) -> list[tuple[int, list[Any]]]:
    """exp(pi i n.tau n) on n = N/2 with n.Im(tau)n <= radius^2, as integers over 2^fixed.

    One row a N1, in it four classes of N2 modulo 4: the N2, real and imaginary parts.
    """
    y11, y12, y22 = (float(t.imag) for t in tau)
    bound = 4 * radius * radius
    last = int(math.sqrt(bound * y22 / (y11 * y22 - y12 * y12)))
    rows = []
    with mpmath.workprec(fixed + 40):
        quarter = 1j * mpmath.pi / 4
        q11, q22, q12 = (mpmath.exp(quarter * t) for t in (tau[0], tau[2], 2 * tau[1]))
        over = [mpc(1)]  # q11^(N^2)
        step, square = q11, q11 * q11
        for _ in range(last + 1):
            over.append(over[-1] * step)
            step *= square
        twice22 = q22 * q22
        for n1 in range(-last, last + 1):
            room = y22 * (bound - y11 * n1 * n1) + (y12 * n1) ** 2
            if room < 0:
                continue
            high = math.floor((-y12 * n1 + math.sqrt(room)) / y22)
            low = math.ceil((-y12 * n1 - math.sqrt(room)) / y22)
            if high < low:
                continue
            middle = round(-y12 * n1 / y22)  # the largest term: neither way is there a rise
            cross = q12**n1
            top = over[abs(n1)] * q22 ** (middle * middle) * cross**middle
            terms = {middle: top}
            up, down = q22 ** (2 * middle + 1) * cross, q22 ** (1 - 2 * middle) / cross
            term = top
            for n2 in range(middle + 1, high + 1):
                term *= up
                up *= twice22
                terms[n2] = term
            term = top
            for n2 in range(middle - 1, low - 1, -1):
                term *= down
                down *= twice22
                terms[n2] = term
            classes: list[Any] = []
            for residue in range(4):
                ns = [n for n in sorted(terms) if n % 4 == residue]
                classes.append(
                    (
                        ns,
                        [libmp.to_fixed(terms[n].real._mpf_, fixed) for n in ns],
                        [libmp.to_fixed(terms[n].imag._mpf_, fixed) for n in ns],
                    )
                )
            rows.append((n1, classes))
    return rows


def _powers(z: Scalar, last: int, fixed: int) -> dict[int, tuple[int, int]]:
    """exp(pi i z N) for |N| <= last, as integers over 2^fixed."""
    found = {0: (1 << fixed, 0)}
    with mpmath.workprec(fixed + 40):
        u = mpmath.exp(1j * mpmath.pi * z)
        for sense, base in ((1, u), (-1, 1 / u)):
            re, im = (libmp.to_fixed(x._mpf_, fixed) for x in (base.real, base.imag))
            a, b = 1 << fixed, 0
            for n in range(1, last + 1):
                a, b = (a * re - b * im) >> fixed, (a * im + b * re) >> fixed
                found[sense * n] = a, b
    return found


def _flint_sums(
    tau: SymmetricMatrix,
) -> Callable[[Pair, Sequence[Characteristic]], list[tuple[Scalar, Scalar, Scalar]]]:
    """The same by ``acb_theta_jet`` of FLINT."""
    import flint

    from polhode.closed_forms.kovalevskaya.theta.balls import ball, middle
    from polhode.numbers.flint_context import ctx

    prec = mpmath.prec + 2 * _SPARE

    def sums(z: Pair, wanted: Sequence[Characteristic]) -> list[tuple[Scalar, Scalar, Scalar]]:
        with ctx.workprec(prec):
            t = [ball(x) for x in tau]
            matrix = flint.acb_mat([[t[0], t[1]], [t[1], t[2]]])
            column = flint.acb_mat([[ball(x)] for x in z])
            jets: Any = matrix.theta_jets(column, 1)
            rows = []
            for a1, a2, b1, b2 in wanted:
                index = 8 * a1 + 4 * a2 + 2 * b1 + b2
                value, d1, d2 = (middle(jets[index, i]) for i in range(3))
                rows.append((value, d1, d2))
            return rows

    return sums

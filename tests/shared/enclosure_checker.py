"""A slow second opinion of the numbers of a step: exact rationals and balls of 500 bits.

From the stored polynomials X, e, V of a step and the exact constants alone.  Nothing of the
trusted modules is called but to be compared with.
"""

import itertools
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from flint import arb, arb_mat, arb_poly, ctx, fmpq, fmpq_poly, fmpz

from polhode.enclosures.fixed_point_problem import CLOCK, ball
from polhode.enclosures.step_bound import Bounds

BITS = 500
CYCLE = ((1, 2), (2, 0), (0, 1))
_TERMS = 130
_PARTS = 16


def checked(bounds: Bounds, n: int, constants: Sequence[Fraction]) -> dict[str, tuple[Any, float]]:
    """For a step: what was claimed and its exact value, which may not be larger, by name."""
    noise, pieces = bounds.problem.noise, bounds.pieces
    h = fmpq(pieces.times[n + 1] - pieces.times[n], 1 << CLOCK)
    k = [fmpq(x.numerator, x.denominator) for x in constants]
    scale = fmpq(1, fmpz(1) << pieces.level)
    x = [fmpq_poly(row) * scale for row in pieces.polynomials(n)]
    e = [_poly(bounds.correction[n, :, i], fmpq(1, fmpz(1) << noise)) for i in range(6)]
    a = _jacobian(x, k, h)
    residual = []
    for i in range(6):
        row = x[i].derivative() - _rate(x, k, h, i) + e[i].derivative()
        for j in range(6):
            row -= a[i][j] * e[j]
        residual.append(row)
    big = fmpq(fmpz(1) << noise)
    numbers: dict[str, tuple[Any, float]] = {}
    with ctx.workprec(BITS):
        alpha = sum((_norm(a, j) / (j + 1) for j in range(_length(a))), fmpq(0))
        numbers["alpha"] = arb(alpha), bounds.alpha[n]
        numbers["majorant"] = arb(alpha).exp(), bounds.majorant[n]
        log = _logarithmic(a, bounds.problem.weights)
        least = log if bool(log < arb(alpha).exp()) else arb(alpha).exp()
        numbers["growth"] = least, bounds.growth[n]
        delta = _least_integral(residual)
        numbers["delta"] = delta * arb(big), bounds.delta[n]
        sigma = sum(max(abs(row[j]) for row in e) for j in range(max(len(row) for row in e)))
        numbers["sigma"] = arb(sigma * big), bounds.sigma[n]
        v = [[_poly(bounds.matrices[n, :, i, j], fmpq(1)) for j in range(6)] for i in range(6)]
        numbers["matrix residual"] = least * arb(_matrix_residual(a, v)), bounds.rho[n]
        flow = _flow(a)
        sizes = [sum(abs(flow[i, j]) for j in range(6)).lower() for i in range(6)]
        numbers["flow"] = max(sizes), bounds.growth[n]
        miss = max(
            sum(abs(flow[i, j] - arb(float(bounds.ends[n, i, j]))) for j in range(6)).upper()
            for i in range(6)
        )
        numbers["matrix"] = miss, bounds.rho[n]
    return numbers


def _logarithmic(a: Any, weights: Sequence[float]) -> Any:
    """kappa exp(m) of ``logarithmic_norm``, from exact numbers."""
    q = [arb(x) for x in weights]
    m = arb(0)
    for k in range(_length(a)):
        rows = [[arb(a[i][j][k]) * q[i] / q[j] for j in range(6)] for i in range(6)]
        both = [(rows[i][j] + rows[j][i]) / 2 for i in range(6) for j in range(6)]
        m += sum((x * x for x in both), arb(0)).sqrt() / (k + 1)
    least = min(weights)
    return sum((x * x for x in q), arb(0)).sqrt() / arb(least) * m.exp()


def jump(bounds: Bounds, n: int, centre: Sequence[int]) -> list[Fraction]:
    """The jump at the beginning of a step, exactly, in units of 2**-noise."""
    noise, pieces = bounds.problem.noise, bounds.pieces

    def value(step: int, i: int, at: int) -> Fraction:
        x = pieces.polynomials(step)[i]
        whole = Fraction(int(x(at)), 1 << pieces.level) * 2**noise
        coefficients = bounds.correction[step, :, i]
        return whole + sum(map(Fraction, coefficients if at else coefficients[:1]))

    jumps = []
    for i in range(6):
        before = (
            value(n - 1, i, 1)
            if n
            else Fraction(int(centre[i]), 1 << bounds.problem.fine) * 2**noise
        )
        jumps.append(before - value(n, i, 0))
    return jumps


def _least_integral(rows: list[Any]) -> Any:
    """A lower bound of the integral of max_i |r_i| over [0, 1]: its parts' integrals."""
    whole = [arb_poly(row.integral()) for row in rows]
    ends = [[row(arb(k) / _PARTS) for row in whole] for k in range(_PARTS + 1)]
    total = arb(0)
    for before, after in itertools.pairwise(ends):
        parts = [abs(b - a) for a, b in zip(before, after, strict=True)]
        total += max(parts, key=lambda part: float(part.mid()))
    return total


def _poly(values: Any, scale: Any) -> Any:
    return fmpq_poly([fmpq(*float(c).as_integer_ratio()) for c in values]) * scale


def _rate(x: list[Any], k: list[Any], h: Any, i: int) -> Any:
    a, b = CYCLE[i % 3]
    if i < 3:
        rate = x[a] * x[b] * k[i] + x[3 + a] * k[3 + 2 * i] + x[3 + b] * k[4 + 2 * i]
    else:
        rate = x[3 + a] * x[b] - x[3 + b] * x[a]
    return rate * h


def _jacobian(x: list[Any], k: list[Any], h: Any) -> list[list[Any]]:
    zero = fmpq_poly([])
    rows = [[zero] * 6 for _ in range(6)]
    for i, (a, b) in enumerate(CYCLE):
        rows[i][a], rows[i][b] = x[b] * (k[i] * h), x[a] * (k[i] * h)
        rows[i][3 + a], rows[i][3 + b] = (fmpq_poly([k[n] * h]) for n in (3 + 2 * i, 4 + 2 * i))
        rows[3 + i][3 + a], rows[3 + i][b] = x[b] * h, x[3 + a] * h
        rows[3 + i][3 + b], rows[3 + i][a] = -x[a] * h, -x[3 + b] * h
    return rows


def _length(rows: list[list[Any]]) -> int:
    return max(len(entry) for row in rows for entry in row)


def _norm(rows: list[list[Any]], k: int) -> Any:
    return max(sum((abs(entry[k]) for entry in row), fmpq(0)) for row in rows)


def _matrix_residual(a: list[list[Any]], v: list[list[Any]]) -> Any:
    rows = []
    for i in range(6):
        row = []
        for j in range(6):
            entry = -v[i][j].derivative()
            for m in range(6):
                entry += a[i][m] * v[m][j]
            row.append(entry)
        rows.append(row)
    miss = max(sum(abs(v[i][j][0] - (i == j)) for j in range(6)) for i in range(6))
    return miss + sum((_norm(rows, k) / (k + 1) for k in range(_length(rows))), fmpq(0))


def _flow(a: list[list[Any]]) -> Any:
    """Phi(1): the Taylor series of Phi' = A Phi, with a bound of its rest."""
    terms = _length(a)
    coefficients = [
        arb_mat([[arb(a[i][j][k]) for j in range(6)] for i in range(6)]) for k in range(terms)
    ]
    series = [arb_mat([[arb(int(i == j)) for j in range(6)] for i in range(6)])]
    for k in range(_TERMS):
        total = coefficients[0] * series[k]
        for j in range(1, min(k, terms - 1) + 1):
            total = total + coefficients[j] * series[k - j]
        series.append(total * (1 / arb(k + 1)))
    flow = series[0]
    for term in series[1:]:
        flow = flow + term
    # beyond: bounded by the series of the scalar y' = |A| y, whose terms fall at least by halves
    last = max(abs(series[-1][i, j]).upper() for i in range(6) for j in range(6))
    assert last < arb((1, -100))
    return flow


__all__ = ["ball", "checked", "jump"]

"""The theorem of one step, and its numbers from the polynomials as they are.

Trusted.  On a step, tau = (t - t_n)/h in [0, 1], the motion x' = h f(x), f(x) = L x + B(x, x), is
approximated by xhat = x~ + e, x~ an integer polynomial (``taylor_polynomials``), e one with double
coefficients.  With A = h f'(x~), d = x~' - h f(x~) and z = x - xhat, exactly

    z' = A z + h B(e + z, e + z) - (d + e' - A e).                                          (1)

Let alpha >= int |A|, delta >= int |d + e' - A e|, sigma >= sup |e|, eps >= |z(0)|, all on [0, 1] in
the max-norm, |B(v, v)| <= beta |v|**2, and g >= |Phi(t, s)|, 0 <= s <= t <= 1, Phi the exact
transition matrix of A: exp(alpha) is such a number, :func:`logarithm` has another.

Theorem.  If r > 0 satisfies g (eps + delta + h beta (sigma + r)**2) < r, then the exact
motion exists on the whole step, |z| <= r there, and for any polynomial matrix V and all tau

    z(tau) in V(tau) z(0) + [-s, s]**6,
    s = g (delta + h beta (sigma + r)**2) + rho eps,                                        (2)
    rho = g (|I - V(0)| + int |A V - V'|).

Proof.  While |z| <= r, variation of constants in (1) gives |z| < r, so the first time at which
|z| = r cannot lie in the step, and a bounded solution of a polynomial field goes on.  The same
formula, with z(0) apart, gives Phi(tau, 0) z(0) and the first part of s.  U = Phi - V obeys
U' = A U + (A V - V'), U(0) = I - V(0), so |U| <= rho.  In s any bound of |z| on the step may stand
for r, such as sup |V| eps + s: much the smaller where eps is, of a box of starts.

Lemma.  For a diagonal matrix Q of any positive numbers q_i and S = sym(Q A Q^-1) = sum S_k tau**k,

    g = kappa exp(m),    kappa = (sum q_i**2)**(1/2)/min q_i,    m = sum |S_k|_F/(k + 1),

|.|_F Frobenius' norm.  Proof.  y = Q z, z' = A z, obeys (|y|_2**2)' = 2 y.S y <= 2 lambda |y|_2**2,
lambda the largest eigenvalue of S, at most |S|_F <= sum |S_k|_F tau**k: |y|_2 grows by exp(m) at
most.  And |z| <= |y|_2/min q_i, |y|_2 <= (sum q_i**2)**(1/2) |z| in the max-norm.  A turn without
stretching does not occur in S: with q_i near c m_i**(1/2) for w, m_i the moments, and 1 for gamma,
neither does a symmetric top's spin, nor most of gamma's turn with the body.

This module computes alpha, g, delta, sigma, rho of every step of a window.  Norms of polynomials
are sums over the norms of their coefficients (over k + 1 under an integral): bounds for all tau.
gamma(k) = 1.01 k u, u = 2**-53, bounds k roundings in any order.  Small quantities (e, d, delta,
sigma) are in units of 2**-P.

Coefficient k of A V - V' (of d + e' - A e likewise) is found in double.  A row of A has four
entries that are not zero, so that of A V is a sum of at most 4 (k + 1) products; the one or two
additions after it included, off by at most gamma(4 (k + 1) + 4) sum |A_j| |V_(k-j)|.  Under the
integral that is divided by k + 1, and 4 + 4/(k + 1) <= 8: all k together are off by at most
gamma(8) sum |A_j| sum |V_k|.  The other terms pass two roundings, (k + 1) V_(k+1) a product and an
addition, which is gamma(2) sum |V_k| under the integral, and d two additions, beside its own.

An A_k is known to its gap in the max-norm; the error of S_k from that is at most skew 6**(1/2) gap
in Frobenius' norm, skew = max q/min q.  Rounding an entry of Q A Q^-1, and a sum of two, loses
gamma(5) of the moduli, gamma(5) skew 6**(1/2) |A_k| in all.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from polhode.enclosures.fixed_point_problem import UP, Problem, TooImprecise
from polhode.enclosures.taylor_polynomials import Defects, Pieces
from polhode.equations.terms import ROWS, SLOPES, Slope
from polhode.numbers.conversion import rounds_to_nearest

U = 2.0**-53
MOST_ALPHA = 1e4
TINY = 1e-280  # above anything that underflow can have lost
UNDERFLOW = 1e-150  # above what squares can have lost
ROUNDINGS = 8  # of a coefficient of a product, over k + 1; see the module


def _most(which: Callable[[Slope], bool]) -> int:
    """How many parts of the derivative a row has at most, of a kind."""
    return max(sum(which(x) for x in SLOPES if x.row == row) for row in range(len(ROWS)))


#: Parts of a row of the derivative: that another variable enters, those of them whose coefficient
#: is the body's, and those that are constant.
_VARYING = _most(lambda x: x.other is not None)
_OF_THE_BODY = _most(lambda x: x.other is not None and x.term.coefficient is not None)
_CONSTANT = _most(lambda x: x.other is None)


def check_arithmetic() -> None:
    """Raise TooImprecise where doubles are not rounded to the nearest, or small ones are made 0.

    Bits of a thread's state, which any library may set.
    """
    if not rounds_to_nearest() or not np.array([2.0**-1074]) * 1.0 > 0.0:
        raise TooImprecise("doubles are not rounded to the nearest, or small ones are made 0")


def gamma(k: int) -> float:
    """A bound of the relative error of k roundings: 1.01 k u."""
    return 1.01 * k * U


@dataclass(frozen=True)
class Bounds:
    """What (2) needs of every step of a window, and what was bounded.

    ``alpha``, ``majorant`` >= exp(alpha), ``growth``: g, ``delta``, ``sigma``, ``rho``: (W,).
    ``ends``: V(1) as doubles, (W, 6, 6); its own rounding is part of rho.  ``sizes``: sum of
    |V_k|, (W,).
    """

    problem: Problem
    pieces: Pieces
    correction: Any
    matrices: Any
    alpha: Any
    majorant: Any
    growth: Any
    delta: Any
    sigma: Any
    rho: Any
    ends: Any
    sizes: Any


def jacobian(problem: Problem, near: Any, lengths: Any) -> Any:
    """Coefficients of h f'(x~) from doubles near those of x~: (W, p + 1, 6, 6)."""
    steps, count = near.shape[:2]
    slopes = np.zeros((steps, count, 6, 6))
    scaled = near * lengths[:, None, None]
    for row, column, term, factor in SLOPES:
        coefficient = term.of(problem.factors)
        if factor is None:
            slopes[:, 0, row, column] += coefficient * lengths
        else:
            slopes[:, :, row, column] += coefficient * scaled[:, :, factor]
    return slopes


def product(left: Any, right: Any, count: int) -> Any:
    """The first ``count`` coefficients of a product of polynomials of matrices, in each step.

    ``left``: (W, n, 6, 6), ``right``: (W, m, 6, c).  Each coefficient is one matrix product.
    """
    steps, n, m = left.shape[0], left.shape[1], right.shape[1]
    flat = np.ascontiguousarray(left.transpose(0, 2, 1, 3)).reshape(steps, 6, 6 * n)
    reversed_right = np.ascontiguousarray(right[:, ::-1]).reshape(steps, 6 * m, right.shape[3])
    coefficients = np.zeros((steps, count, 6, right.shape[3]))
    for k in range(min(count, n + m - 1)):
        first, last = max(0, k - m + 1), min(k, n - 1) + 1
        low = m - 1 - k
        columns = reversed_right[:, 6 * (low + first) : 6 * (low + last)]
        np.matmul(flat[:, :, 6 * first : 6 * last], columns, out=coefficients[:, k])
    return coefficients


def bounds(problem: Problem, defects: Defects, correction: Any, matrices: Any) -> Bounds:
    """alpha, delta, sigma and rho of every step, from what the untrusted parts have left.

    ``correction``: e, (W, p + 1, 6); ``matrices``: V, (W, m + 1, 6, 6), of any origin, and copied:
    who made them may keep them and change them.  Raises TooImprecise where they do not fit the
    polynomials; numbers that are not finite make bounds that no test accepts.
    """
    pieces = defects.pieces
    steps, count = pieces.near.shape[:2]
    correction, matrices = np.array(correction, dtype=float), np.array(matrices, dtype=float)
    if _adds(problem):
        raise TooImprecise("a derivative whose entries are sums is not bounded")
    fits = matrices.ndim == 4 and matrices.shape[::2] == (steps, 6) == matrices.shape[::3]
    if correction.shape != pieces.near.shape or not (fits and matrices.shape[1]):
        raise TooImprecise("an approximation does not fit")
    lengths = pieces.lengths
    a = jacobian(problem, pieces.near, lengths)
    a_norms = _norms(a)
    a_gaps = _jacobian_gaps(problem, pieces, lengths) + gamma(4) * a_norms
    a_sum = UP * (np.sum(a_norms, axis=1) + np.sum(a_gaps, axis=1))
    weights = 1.0 / np.arange(1, defects.values.shape[1] + 1)
    alpha = UP * np.sum((a_norms + a_gaps) * weights[:count], axis=1)
    majorant = exponential(alpha)
    kappa, m = logarithm(problem.weights, a, a_norms, a_gaps)
    growth = np.minimum(majorant, UP * kappa * exponential(m))
    e_sizes = np.max(np.abs(correction), axis=2)
    sigma = UP * np.sum(e_sizes, axis=1)
    delta = _delta(problem, defects, correction, a, a_sum, np.sum(a_gaps, axis=1), sigma, weights)
    v_norms = _norms(matrices)
    sizes = UP * np.sum(v_norms, axis=1)
    miss = np.sum(np.abs(np.eye(6) - matrices[:, 0]), axis=2).max(axis=1)
    rho = growth * (miss + _matrix_residual(a, a_norms, a_gaps, a_sum, matrices, v_norms, sizes))
    terms = matrices.shape[1]
    rho = UP * (rho + gamma(terms + 2) * sizes) + TINY
    return Bounds(
        problem,
        pieces,
        correction,
        matrices,
        alpha,
        majorant,
        growth,
        delta,
        sigma,
        rho,
        np.sum(matrices, axis=1),
        sizes,
    )


def _adds(problem: Problem) -> bool:
    """Whether two parts of the derivative are added, which rounds once more than is bounded."""
    constants = problem.factors, problem.factor_slack
    places = [(x.row, x.column) for x in SLOPES if any(x.term.of(c) for c in constants)]
    return len({*places}) < len(places)


def _delta(
    problem: Problem,
    defects: Defects,
    correction: Any,
    a: Any,
    a_sum: Any,
    a_gap: Any,
    sigma: Any,
    weights: Any,
) -> Any:
    """int |d + e' - A e|: in double, plus what the doubles and the constants miss."""
    pieces = defects.pieces
    count, width = correction.shape[1], defects.values.shape[1]
    residual = defects.values - product(a, correction[..., None], width)[..., 0]
    residual[:, : count - 1] += correction[:, 1:] * np.arange(1, count)[:, None]
    d_sum = np.sum(np.max(np.abs(defects.values), axis=2) * weights, axis=1)
    total = np.sum(np.max(np.abs(residual), axis=2) * weights, axis=1)
    total = total + gamma(ROUNDINGS) * a_sum * sigma + gamma(2) * sigma
    total = total + gamma(2 + defects.roundings) * d_sum + a_gap * sigma
    largest = np.sum(np.abs(pieces.near) + pieces.gap[:, :, None], axis=1)  # sup |x~_i|
    missed = np.zeros((pieces.count, 3))
    for term in (term for row in ROWS[:3] for term in row):
        part = term.of(problem.slack)
        for n in term.factors:
            part = part * largest[:, n]
        missed[:, term.row] += part
    return UP * (total + pieces.lengths * np.max(missed, axis=1)) + TINY


def _matrix_residual(
    a: Any, a_norms: Any, a_gaps: Any, a_sum: Any, matrices: Any, v_norms: Any, sizes: Any
) -> Any:
    """int |A V - V'|: the coefficients below the degree in double, the others by their norms."""
    terms = matrices.shape[1]
    degree = terms - 1
    residual = product(a, matrices, degree)
    residual -= matrices[:, 1:] * np.arange(1, terms)[:, None, None]
    total = np.sum(_norms(residual) / np.arange(1, terms), axis=1)
    # coefficients from the degree on: the sum over j + l >= degree of |A_j| |V_l| / (degree + 1)
    after = np.zeros((a.shape[0], terms))  # [:, l]: the sum of |A_j| over j >= degree - l
    for j in range(terms):
        after[:, j] = np.sum(a_norms[:, max(0, degree - j) :], axis=1)
    total = total + np.sum(after * v_norms, axis=1) / terms
    total = total + gamma(ROUNDINGS) * a_sum * sizes + gamma(2) * sizes
    return UP * (total + np.sum(a_gaps, axis=1) * sizes)


def _jacobian_gaps(problem: Problem, pieces: Pieces, lengths: Any) -> Any:
    """|A_k - the doubles multiplied exactly|: from the gaps of x~ and of the constants."""
    slack = max(problem.factor_slack)
    steepest = max(abs(x.term.of(problem.factors)) for x in SLOPES if x.other is not None)
    largest = np.max(np.abs(pieces.near), axis=2) + pieces.gap
    gaps = _VARYING * steepest * pieces.gap + _OF_THE_BODY * slack * largest
    gaps[:, 0] += _CONSTANT * slack
    return UP * gaps * lengths[:, None]


def _norms(matrices: Any) -> Any:
    """The largest row sums of matrices."""
    return UP * np.sum(np.abs(matrices), axis=-1).max(axis=-1)


def logarithm(weights: Sequence[float], a: Any, norms: Any, gaps: Any) -> tuple[float, Any]:
    """kappa, and m of every step, (W,); no numbers that are finite where there are none.

    ``weights``: the q_i, of any origin; ``a``: doubles near the A_k, (W, n, 6, 6), ``norms`` their
    norms and ``gaps`` how far the A_k are from them, (W, n).
    """
    q = np.array(weights)
    scaled = a * (q[:, None] / q)
    symmetric = 0.5 * (scaled + scaled.transpose(0, 1, 3, 2))
    sizes = np.sqrt(np.sum(symmetric * symmetric, axis=(2, 3))) + UNDERFLOW
    skew = UP * float(np.max(q) / np.min(q))
    sizes = sizes + 2.45 * skew * (gaps + gamma(5) * norms)  # 6**(1/2) < 2.45
    kappa = UP * float(np.sqrt(np.sum(q * q)) / np.min(q))
    return kappa, UP * np.sum(sizes / np.arange(1, sizes.shape[1] + 1), axis=1)


def exponential(alpha: Any) -> Any:
    """A bound of exp(alpha) without a library's exp: (1 - alpha/N)**-N, N = 2**24.

    1/(1 - x) >= exp(x); the start is off by 2u and 24 squarings make that (2 + 1) N u < 1e-7.
    Infinite beyond MOST_ALPHA and for what is not a number.
    """
    usable = alpha < MOST_ALPHA
    power = 1.0 / (1.0 - np.where(usable, alpha, 0.0) * 2.0**-24)
    with np.errstate(over="ignore"):
        for _ in range(24):
            power = power * power
    return np.where(usable, power * (1.0 + 1e-7), math.inf)

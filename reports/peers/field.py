"""The Euler–Poisson equations as the peers take them, and what a peer is once it is prepared."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeAlias

# --- field ----------------------------------------------------------------------------------------
#
# The Euler–Poisson equations in principal axes (3.29) as the peers take them.
#
# The nine coefficients, in the order of polhode.equations.terms, belong to the terms
#
#     p' = c0 q r + c3 gamma2 + c4 gamma3
#     q' = c1 r p + c5 gamma3 + c6 gamma1
#     r' = c2 p q + c7 gamma1 + c8 gamma2,    gamma' = gamma × w.
#
# A vanishing coefficient's term is left out when the function is made or compiled, as polhode
# leaves it out of its own equations.


#: A number, an expression of heyoka's, an array: whatever a peer's functions are made of.
Scalar: TypeAlias = Any


def of_pattern(present: Sequence[bool]) -> Callable[..., tuple[Scalar, ...]]:
    """Rates of time, six scalars and coefficients of any kind, with the terms that are ``present``.

    For functions made once and called with many bodies: the coefficients are arguments, and only
    which of them vanish is compiled in.
    """
    a0, a1, a2, a3, a4, a5, a6, a7, a8 = map(bool, present)

    def rates(t: Scalar, y: Scalar, c: Scalar) -> tuple[Scalar, ...]:
        p, q, r, g1, g2, g3 = y[0], y[1], y[2], y[3], y[4], y[5]
        dp = c[0] * q * r if a0 else 0.0 * q
        if a3:
            dp = dp + c[3] * g2
        if a4:
            dp = dp + c[4] * g3
        dq = c[1] * r * p if a1 else 0.0 * r
        if a5:
            dq = dq + c[5] * g3
        if a6:
            dq = dq + c[6] * g1
        dr = c[2] * p * q if a2 else 0.0 * p
        if a7:
            dr = dr + c[7] * g1
        if a8:
            dr = dr + c[8] * g2
        return dp, dq, dr, r * g2 - q * g3, p * g3 - r * g1, q * g1 - p * g2

    return rates


# --- prepared -------------------------------------------------------------------------------------
#
# What a program looks like once it is prepared: a function of body, start, times and tolerance.
#
# Each program is made ready once for a pattern of the equations, which says what coefficients are
# not zero, and then called with any body of the pattern and any start: what a loop over many
# starts pays. Its module has a function ``prepared(present, method)`` that returns a :data:`Run`.
# Where a program has a way of its own of many starts, a loop in compiled code at the least, that
# has a third argument ``many``: then it is a Run from starts (N, 6), times 0 and end, to the states
# at the end, (N, 6).


#: numpy's, and in compiled functions numba's or JAX's: they have no type in common.
Array: TypeAlias = Any


class Top(NamedTuple):
    """A body in principal axes: the nine coefficients of its equations, its moments, Mg r0.

    Arrays of doubles; the coefficients in the order of :mod:`peers.field`.
    """

    coefficients: Array
    moments: Array
    torque: Array


#: From a body, a start of shape (6,), n times from 0 on and a tolerance to the states at the times,
#: shape (n, 6).  With two times it may return the last state alone, shape (1, 6).  Raises
#: ArithmeticError where it does not arrive.
Run = Callable[[Top, Array, Array, float], Array]


# --- numba field ----------------------------------------------------------------------------------
#
# Solves that numba compiles, called for one start or, in a loop that is compiled too, for many.


def run_of(solve: Array, many: bool) -> Run:
    """A run of a compiled solve: (coefficients, start, times, tolerance) -> (rows, arrived).

    ``many``: called for each of many starts, in a loop that is compiled, too; the last rows.
    """
    import numba
    import numpy as np

    def loop(coefficients: Array, starts: Array, times: Array, tol: float) -> Array:
        ends, arrived = np.empty_like(starts), True
        for k in range(len(starts)):
            rows, success = solve(coefficients, starts[k], times, tol)
            ends[k] = rows[-1]
            arrived &= success
        return ends, arrived

    compiled = numba.njit(loop) if many else solve

    def run(top: Top, start: Array, times: Array, tol: float) -> Array:
        rows, success = compiled(top.coefficients, start, times, tol)
        if not success:
            raise ArithmeticError("success is False")
        return rows

    return run

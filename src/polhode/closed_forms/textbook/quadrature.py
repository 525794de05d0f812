"""Integrals of functions of an angle by mpmath's quadrature."""

from __future__ import annotations

from collections.abc import Callable

from polhode.numbers.mpmath_context import mpc, mpf, mpmath


def integral(rate: Callable[[mpf], mpc], start: mpf, end: mpf, pieces: int) -> mpc:
    """The integral of a function of period 2 pi; whole turns are counted.

    ``pieces``: of a turn, each a quadrature of its own.
    """
    turn = 2 * mpmath.pi
    turns = mpmath.nint((end - start) / turn)
    rest = end - turns * turn
    few = int(pieces * abs(rest - start) / turn) + 1
    total = _quadrature(rate, start, rest, few)
    if turns:
        total += turns * _quadrature(rate, mpmath.mpf(0), turn, pieces)
    return total


def _quadrature(rate: Callable[[mpf], mpc], start: mpf, end: mpf, pieces: int) -> mpc:
    nodes = mpmath.linspace(start, end, pieces + 1)
    return mpmath.quad(rate, nodes, method="gauss-legendre")

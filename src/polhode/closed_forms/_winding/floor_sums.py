"""How many points of a lattice lie below a straight line, at a cost like the log of its length.

The sum over 0 <= k < n of floor(al k + be) is found as Euclid finds a common divisor (Graham, Knuth
and Patashnik, Concrete Mathematics, 3.5).
"""

from __future__ import annotations

from polhode.closed_forms.functions.fourier import fixed
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.scalars import Scalar


def floor_sum(n: int, m: int, a: int, b: int) -> int:
    """The sum over 0 <= k < n of floor((a k + b)/m), m > 0."""
    total, side = 0, 1
    while n > 0:
        total += side * (n * (n - 1) // 2 * (a // m) + n * (b // m))
        a, b = a % m, b % m
        # What is left counts points under a line from b/m to (a n + b)/m: seen from its other side.
        last = (a * (n - 1) + b) // m
        total += side * last * (n - 1)
        side, n, m, a, b = -side, last, a, m, m - b - 1
    return total


def floors(n: int, al: Scalar, be: Scalar, error: Scalar) -> int:
    """The sum over 0 <= k < n of floor(al k + be), of numbers at the precision in force.

    Raises ArithmeticError where it is not the same for ``be`` less and more by ``error``.
    """
    bits = 2 * mpmath.prec
    slope, low, high = fixed(al, bits), fixed(be - error, bits), fixed(be + error, bits)
    found = floor_sum(n, 1 << bits, slope, low)
    if found != floor_sum(n, 1 << bits, slope, high):
        raise ArithmeticError("a line passes too near a point of the lattice")
    return found

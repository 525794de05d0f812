"""How enclosures combine: the rules of irrational numbers, on intervals of mpmath.libmp.

Functions of a module, so that a number that holds one can be pickled.
"""

from __future__ import annotations

from types import ModuleType
from typing import TypeAlias

#: A binary number of mpmath.libmp: sign, mantissa, exponent, bits of the mantissa.
Raw: TypeAlias = tuple[int, int, int, int]

#: An interval: low and high.
Interval: TypeAlias = tuple[Raw, Raw]


def negative(prec: int, a: Interval) -> Interval:
    """-a."""
    found: Interval = libmp().mpi_neg(a, prec)
    return found


def added(prec: int, a: Interval, b: Interval) -> Interval:
    """a + b."""
    found: Interval = libmp().mpi_add(a, b, prec)
    return found


def product(prec: int, a: Interval, b: Interval) -> Interval:
    """a·b."""
    found: Interval = libmp().mpi_mul(a, b, prec)
    return found


def quotient(prec: int, a: Interval, b: Interval) -> Interval:
    """a/b."""
    # While the divisor's enclosure is still too wide to exclude zero, nothing is known.
    lib = libmp()
    if lib.mpf_sign(b[0]) * lib.mpf_sign(b[1]) <= 0:
        return lib.fninf, lib.finf
    found: Interval = lib.mpi_div(a, b, prec)
    return found


def root(prec: int, a: Interval) -> Interval:
    """The square root."""
    found: Interval = libmp().mpi_sqrt((_not_below_zero(a[0]), a[1]), prec)
    return found


def sine(prec: int, a: Interval) -> Interval:
    """sin a."""
    found: Interval = libmp().mpi_sin(a, prec)
    return found


def cosine(prec: int, a: Interval) -> Interval:
    """cos a."""
    found: Interval = libmp().mpi_cos(a, prec)
    return found


def angle(prec: int, a: Interval, b: Interval) -> Interval:
    """The angle of (b, a), a not below zero."""
    found: Interval = libmp().mpi_atan2((_not_below_zero(a[0]), a[1]), b, prec)
    return found


def pi(prec: int) -> Interval:
    """The number pi."""
    lib = libmp()
    return lib.mpf_pi(prec, "f"), lib.mpf_pi(prec, "c")


def power(prec: int, a: Interval, e: Interval) -> Interval:
    """a to the power e."""
    lib = libmp()
    if lib.mpf_sign(a[0]) <= 0:
        return lib.fzero, lib.finf
    found: Interval = lib.mpi_exp(lib.mpi_mul(e, lib.mpi_log(a, prec), prec), prec)
    return found


def integer_power_of(n: int, prec: int, a: Interval) -> Interval:
    """a to the power n."""
    found: Interval = libmp().mpi_pow_int(a, n, prec)
    return found


def _not_below_zero(low: Raw) -> Raw:
    """The lower end of an enclosure of what cannot be negative."""
    lib = libmp()
    zero: Raw = lib.fzero
    return zero if lib.mpf_sign(low) < 0 else low


def libmp() -> ModuleType:
    """mpmath's own arithmetic; only irrational data pay for this import."""
    from mpmath import libmp as found

    library: ModuleType = found
    return library

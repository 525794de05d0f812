"""How enclosures combine: the rules of irrational numbers, on FLINT's balls.

Each takes balls and computes with the precision in force; what it gives holds all values that the
operation has on them.  Functions of a module, so that a number that holds one can be pickled.
Sums, products, sine and cosine are FLINT's own.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:  # only irrational data pay for this import
    from flint import arb


def quotient(a: arb, b: arb) -> arb:
    """a/b."""
    # While the divisor's enclosure is still too wide to exclude zero, nothing is known.
    return nothing(a) if b.contains(0) else a / b


def root(a: arb) -> arb:
    """The square root of what cannot be negative."""
    return a.sqrt() if a > 0 else _up_to(a.abs_upper().sqrt())


def angle(a: arb, b: arb) -> arb:
    """The angle of (b, a), a not below zero: no branch is cut where a's enclosure is around it."""
    if b > 0:
        return (a / b).atan()
    if b < 0:
        return pi() - (a / -b).atan()
    if a > 0:
        return pi() / 2 - (b / a).atan()
    return _up_to(pi())


def pi() -> arb:
    """The number pi."""
    from flint import arb

    return arb.pi()


def power(a: arb, e: arb) -> arb:
    """a to the power e, for what cannot be negative."""
    return (e * a.log()).exp() if a > 0 else nothing(a)


def integer_power_of(n: int, a: arb) -> arb:
    """a to the power n >= 1, by products: FLINT's power of a ball around 0 is no number."""
    found, square = None, a
    while n:
        if n & 1:
            found = square if found is None else found * square
        n >>= 1
        square = square * square if n else square
    assert found is not None
    return found


def nothing(a: arb) -> arb:
    """A ball that holds all numbers."""
    return type(a)(0, float("inf"))


def middle(known: arb) -> tuple[int, int]:
    """(m, e) with m·2**e the midpoint of a ball; 0 where nothing is known."""
    mantissa, exponent = known.mid().man_exp() if known.is_finite() else (0, 0)
    return int(mantissa), int(exponent)


def ends(known: arb) -> tuple[tuple[int, int], tuple[int, int]]:
    """(m, e) with m·2**e the lower and the upper end of a ball, exactly."""
    (middle, p), (radius, q) = (
        (int(m), int(e)) for m, e in (known.mid().man_exp(), known.rad().man_exp())
    )
    least = min(p, q)
    middle, radius = middle << (p - least), radius << (q - least)
    return (middle - radius, least), (middle + radius, least)


def _up_to(most: arb) -> arb:
    """A ball that holds [0, most]."""
    return type(most)(0).union(most)

"""Exact numbers as balls, more bits until the balls are small, and balls as numbers of mpmath.

A ball is FLINT's ``arb`` (or ``acb``): a middle and a radius that bounds every error so far.  The
contract that all closed forms in balls keep:

* What decides (a sign, which root, whether two numbers are equal) is decided on exact numbers, or
  on balls that prove it; a ball that does not prove it raises :class:`TooFewBits`.
* :func:`sure_rows` and :func:`until_sure` set the precision, in bits, and raise it until every
  number is finite and its radius is below 10^-digits times its size.  Whoever computes inside reads
  no precision and sets none; constants are kept by :class:`Kept`, which makes them anew for each
  precision.
* A question that no precision answers raises :class:`Refused`, and so does the cap on bits.  Any
  other exception is a fault of the code and is left alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from operator import mul
from typing import Any, Generic, TypeAlias, TypeVar

from flint import acb, arb
from mpmath import libmp

from polhode.numbers.exact import ZERO, Exact, Irrational, as_ball, sign
from polhode.numbers.flint_context import ctx
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.polynomials import middle

T = TypeVar("T")

#: Numbers, and the size of each or of more, to which its radius is compared; all are positive.
Row: TypeAlias = tuple[Sequence[arb], Sequence[arb]]

SPARE = 8  # bits kept beyond the digits asked for
GUARD = 40  # bits beyond the digits at first
_SLACK = 16  # bits beyond what the last precision is known to have lacked
_MOST_BITS = 20_000
_ZERO, _HALF, _I = arb(0), arb(0.5), acb(0, 1)
_BITS_A_DIGIT = math.log2(10)


class TooFewBits(ArithmeticError):
    """The balls are too wide to decide: the same is to be done with more bits."""


def certainly(true: object) -> None:
    """Raise TooFewBits unless a comparison of balls is certain."""
    if not true:
        raise TooFewBits


class Refused(ValueError):
    """No precision answers this question; the message says why."""


def ball(x: Exact | int) -> arb:
    """An exact number at the precision in force; the exact 0 where it is 0, by the rule."""
    return arb(0) if isinstance(x, Irrational) and sign(x) == 0 else enclosed(x)


def enclosed(x: Exact | int) -> arb:
    """The same without the question whether it is 0: for factors of sums, which need no answer."""
    return x.enclosure(ctx.prec) if isinstance(x, Irrational) else as_ball(x)


def root(x: Exact | int) -> arb:
    """The square root of an exact number that is not negative."""
    return ball(x).sqrt()


def either_root(z: acb) -> acb:
    """A square root of either sign, of a ball anywhere but around 0."""
    return (-z).sqrt() * _I if z.real.mid() < 0 else z.sqrt()


def square(x: arb) -> arb:
    """x^2; ``x ** 2`` is not a number where a ball has its middle at 0."""
    return x * x


def powers_of(w: acb, count: int) -> list[acb]:
    """w^k for k below ``count``, which is positive.

    As products of halves: a chain of single factors would widen a ball by up to sqrt 2 each.
    """
    powers = [acb(1), w]
    for k in range(2, count):
        powers.append(powers[k // 2] * powers[k - k // 2])
    return powers[:count]


def of_product(a: Sequence[Any], back: Sequence[Any]) -> Any:
    """A coefficient of a product of two series, the second factor in reverse order."""
    return sum(map(mul, a, back), _ZERO)


def around(radius: arb) -> acb:
    """A ball around 0 that holds all complex numbers of at most this modulus."""
    r = radius.abs_upper()
    return acb(arb(0, r), arb(0, r))


def nearest_integer(x: arb) -> int:
    """The integer nearest to the middle: for where any integer near by will do."""
    n = (x.mid() + _HALF).floor().unique_fmpz()
    if n is not None:
        return int(n)
    certainly(x.is_finite())
    return math.floor(middle(x) + Fraction(1, 2))  # the sum was rounded to both sides of an integer


class Kept(Generic[T]):
    """Constants that ``make`` makes, once for each precision."""

    def __init__(self, make: Callable[[], T]) -> None:
        self._make = make
        self._made: dict[int, T] = {}

    def __call__(self) -> T:
        """Those of the precision in force."""
        bits = ctx.prec
        if bits not in self._made:
            self._made[bits] = self._make()
        return self._made[bits]


def until_sure(make: Callable[[], Row], digits: int, most: int | None = None) -> Sequence[arb]:
    """The numbers of ``make`` with every radius below 10^-digits times its size.

    ``most``: a cap on the bits in place of the usual one.  Raises Refused at the cap.
    """
    return sure_rows(lambda _: make(), [ZERO], digits, most)[0]


def sure_rows(
    row: Callable[[arb], Row], times: Sequence[Exact], digits: int, most: int | None = None
) -> list[Sequence[arb]]:
    """Rows of numbers, one for each time, with every radius below 10^-digits times its size.

    ``row`` gives the numbers at a time and their sizes, at the precision in force.  The precision
    only rises from one time to the next: times in order cost least.
    """
    cap = most or _MOST_BITS + 4 * digits
    bits, sure_digits = min(int(3.33 * digits) + GUARD, cap), 0
    rows: list[Sequence[arb]] = []
    sizes: Sequence[arb] | None = None
    while True:
        lost = math.inf
        with ctx.workprec(bits):
            goal = arb(10) ** -digits / 4  # the rest is for rounding the middle
            try:
                for t in times[len(rows) :]:
                    before = sizes
                    numbers, sizes = row(ball(t))
                    if sizes is not before:  # most forms have one list of them at all times
                        most_radii = [goal * size for size in sizes]
                    lost = _lost_bits(numbers, most_radii)
                    if lost:
                        break
                    rows.append(numbers)
                else:
                    return rows
            except TooFewBits:
                lost = math.inf
        if lost < math.inf:
            sure_digits = max(sure_digits, math.floor(digits - lost * math.log10(2)))
        if bits >= cap:
            raise Refused(f"{bits} bits give {sure_digits} of {digits} digits")
        bits = min(cap, 2 * bits if lost == math.inf else bits + int(min(lost, 3 * bits)) + _SLACK)


def _lost_bits(numbers: Sequence[arb], most_radii: Sequence[arb]) -> float:
    """By how many bits radii are too large; 0 where none is, infinite where one is unknown.

    Each number is asked: the largest of several balls would pass over one that is not a number.
    """
    worst = 0.0
    for x, most in zip(numbers, most_radii, strict=False):  # a row may end before its sizes do
        if x.rad() < most and x.is_finite():
            continue
        if not (x.is_finite() and most > 0):
            return math.inf
        excess = float((x.rad() / most).log().mid())
        worst = max(worst, 1.0, excess / math.log(2))
    return worst


def number(x: arb, digits: int, *, absolute: bool = False) -> mpf:
    """The middle of a ball rounded to so many digits and a few bits.

    ``absolute``: digits are counted from the units' place.  Of a ball that holds 0 the middle tells
    no digit: it comes with those few bits alone.  The error is below :func:`error_of`.
    """
    mantissa, exponent = x.mid().man_exp()
    bits = _bits_of(x, digits)
    if absolute:
        bits += max(0, int(mantissa).bit_length() + int(exponent))
    raw = libmp.from_man_exp(int(mantissa), int(exponent), bits, "n")
    return mpmath.make_mpf(raw)


def error_of(x: arb, digits: int) -> mpf:
    """A bound of the error of :func:`number`, rounded up."""
    bound = x.rad() + abs(x.mid()) * arb(2) ** -_bits_of(x, digits)
    return number(bound.upper() * (1 + arb(2) ** -10), 1)


def _bits_of(x: arb, digits: int) -> int:
    return SPARE if x.contains(_ZERO) else math.ceil(digits * _BITS_A_DIGIT) + SPARE

"""Exact real numbers: rationals, and irrationals that any precision can be asked of.

A rational is a :class:`fractions.Fraction`.  Anything else is an :class:`Irrational`: a node that
remembers how it was made and encloses its value in a ball, as tightly as asked.
Both take part in ``+ - * /`` and comparisons, alone or mixed, so the code that decides a regime
reads the same for rational and irrational data.

The rule for *equal*: rationals are compared exactly.  An irrational number is called zero when
its enclosure, every step carried to :data:`EQUAL_BITS` bits, still contains zero; two numbers are
called equal when their difference is called zero.  What is decided so is no theorem: :func:`noted`
tells of it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from fractions import Fraction
from functools import partial
from operator import add as added
from operator import methodcaller, mul, neg
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from flint import arb


EQUAL_BITS = 4096

_LADDER = (128, 512, 2048, EQUAL_BITS)
_LARGEST_ANGLE = 1 << (EQUAL_BITS // 4)  # beyond it too few of those bits are left for sin and cos


class Irrational:
    """A real number known through enclosures.

    ``rule(*balls)`` maps enclosures of the ``parts`` to an enclosure of the number.
    ``square`` is the number's square where that is known more simply (the radicand of a root).
    """

    __slots__ = ("_known", "_parts", "_rule", "square")

    def __init__(
        self, rule: Callable[..., arb], *parts: Exact, square: Exact | None = None
    ) -> None:
        self._rule = rule
        self._parts = parts
        self._known: dict[int, arb] = {}  # by precision: no answer depends on those before
        self.square = square

    def __reduce__(self) -> tuple[object, ...]:
        return _irrational, (self._rule, self._parts, self.square)  # balls cannot be pickled

    def enclosure(self, prec: int) -> arb:
        """A ball around the value, every step carried to ``prec`` bits."""
        if prec in self._known:
            return self._known[prec]
        from polhode.numbers.flint_context import ctx

        with ctx.workprec(prec):
            return self._enclosed(prec)

    def _enclosed(self, prec: int) -> arb:
        """The same where that precision is in force."""
        pending = [self]
        while pending:  # no recursion: a long sum is a deep tree
            node = pending[-1]
            if prec in node._known:
                pending.pop()
                continue
            lacking = [
                part
                for part in node._parts
                if isinstance(part, Irrational) and prec not in part._known
            ]
            if lacking:
                pending.extend(lacking)
                continue
            balls = (
                x._known[prec] if isinstance(x, Irrational) else as_ball(x) for x in node._parts
            )
            node._known[prec] = node._rule(*balls)
            pending.pop()
        return self._known[prec]

    def __add__(self, other: Number) -> Exact:
        b = exact(other)
        return self if isinstance(b, Fraction) and b == 0 else Irrational(added, self, b)

    __radd__ = __add__

    def __sub__(self, other: Number) -> Exact:
        return self + -exact(other)

    def __rsub__(self, other: Number) -> Exact:
        return -self + other

    def __mul__(self, other: Number) -> Exact:
        """The product; the square of a root is its radicand."""
        b = exact(other)
        if b is self:
            return _integer_power(self, 2)
        if not isinstance(b, Fraction):
            return Irrational(mul, self, b)
        if b in (0, 1):
            return self if b else ZERO
        square = b * b * self.square if isinstance(self.square, Fraction) else None
        return Irrational(mul, self, b, square=square)

    __rmul__ = __mul__

    def __truediv__(self, other: Number) -> Exact:
        """The quotient; raises ZeroDivisionError where the divisor is zero by the rule."""
        b = exact(other)
        if sign(b) == 0:
            raise ZeroDivisionError("division by zero")
        return self * (1 / b) if isinstance(b, Fraction) else Irrational(ball_quotient, self, b)

    def __rtruediv__(self, other: Number) -> Exact:
        a = exact(other)
        if sign(self) == 0:
            raise ZeroDivisionError("division by zero")
        if a == 0:
            return ZERO
        square = a * a / self.square if isinstance(self.square, Fraction) else None
        return Irrational(ball_quotient, a, self, square=square)

    def __pow__(self, exponent: Number) -> Exact:
        return power(self, exact(exponent))

    def __neg__(self) -> Irrational:
        return Irrational(neg, self, square=self.square)

    def __abs__(self) -> Exact:
        return -self if sign(self) < 0 else self

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, (int, Fraction, Irrational)):
            return NotImplemented
        return sign(self - other) == 0

    __hash__ = None  # type: ignore[assignment]  # equal by the rule, so no consistent hash exists

    def __lt__(self, other: Number) -> bool:
        return sign(self - other) < 0

    def __le__(self, other: Number) -> bool:
        return sign(self - other) <= 0

    def __gt__(self, other: Number) -> bool:
        return sign(self - other) > 0

    def __ge__(self, other: Number) -> bool:
        return sign(self - other) >= 0

    def __float__(self) -> float:
        return math.ldexp(*rounded(self, 53))

    def __repr__(self) -> str:
        return "Irrational({} * 2**{}...)".format(*rounded(self, 53))


_noted: ContextVar[list[Irrational] | None] = ContextVar("noted", default=None)

Exact: TypeAlias = Fraction | Irrational
Number: TypeAlias = int | Fraction | Irrational

ZERO = Fraction(0)
ONE = Fraction(1)


def exact(value: Number) -> Exact:
    """``value`` as an exact number; an ``int`` becomes a ``Fraction``."""
    return Fraction(value) if isinstance(value, int) else value


def sqrt(x: Exact) -> Exact:
    """The square root, exact where it is rational; raises ValueError below zero."""
    if sign(x) < 0:
        raise ValueError("square root of a negative number")
    if isinstance(x, Fraction):
        top, bottom = math.isqrt(x.numerator), math.isqrt(x.denominator)
        if top * top == x.numerator and bottom * bottom == x.denominator:
            return Fraction(top, bottom)
    elif sign(x) == 0:
        return ZERO
    return Irrational(ball_root, x, square=x)


def sin(x: Exact) -> Exact:
    """The sine of an angle in radians; raises ValueError for one too large to be reduced."""
    return _of_angle("sin", x, ZERO)


def cos(x: Exact) -> Exact:
    """The cosine of an angle in radians; raises ValueError for one too large to be reduced."""
    return _of_angle("cos", x, ONE)


def arctan2(y: Exact, x: Exact) -> Exact:
    """The angle of (x, y) in (-pi, pi]; raises ValueError at the origin."""
    if sign(y) < 0:
        return -arctan2(-y, x)
    if sign(y) == 0 and sign(x) == 0:
        raise ValueError("the angle of a vector of length zero")
    if sign(y) == 0 and sign(x) > 0:
        return ZERO
    return Irrational(ball_angle, y, x)


def pi() -> Irrational:
    """The number pi."""
    return Irrational(ball_pi)


def power(x: Exact, exponent: Exact) -> Exact:
    """x to a rational exponent; raises ValueError for any other and for roots of negatives."""
    if not isinstance(exponent, Fraction):
        raise ValueError("an exponent must be a rational number")
    if exponent.denominator == 1:
        return _integer_power(x, exponent.numerator)
    if exponent.denominator == 2:
        return _integer_power(sqrt(x), exponent.numerator)
    if sign(x) < 0:
        raise ValueError("a root of a negative number")
    if sign(x) == 0:
        if exponent < 0:
            raise ZeroDivisionError("division by zero")
        return ZERO
    return Irrational(ball_power, x, exponent)


def _integer_power(x: Exact, n: int) -> Exact:
    if isinstance(x, Fraction):
        return x**n
    if n == 0:
        return ONE
    if n < 0:
        return ONE / _integer_power(x, -n)
    if n == 1:
        return x
    if n == 2 and x.square is not None:
        return x.square
    return Irrational(partial(ball_integer_power, n), x)


def sign(x: Number) -> int:
    """-1, 0 or 1; for an irrational number zero is decided by the rule for *equal*."""
    if not isinstance(x, Irrational):
        over = x.numerator  # compared as an int, which takes a tenth of the time
        return (over > 0) - (over < 0)
    for prec in _LADDER:
        ball = x.enclosure(prec)
        if ball > 0:
            return 1
        if ball < 0:
            return -1
    if (met := _noted.get()) is not None:
        met.append(x)
    return 0


@contextmanager
def noted() -> Iterator[list[Irrational]]:
    """The numbers that are called zero by the rule inside the block, in this thread."""
    met: list[Irrational] = []
    token = _noted.set(met)
    try:
        yield met
    finally:
        _noted.reset(token)


def rounded(x: Number, bits: int) -> tuple[int, int]:
    """(m, e) with m·2**e the number of ``bits`` significant bits nearest to x (ties to even)."""
    if not isinstance(x, Irrational):
        return _rounded_ratio(x.numerator, x.denominator, bits)
    if sign(x) == 0:
        return 0, 0
    prec = max(bits + 64, _LADDER[0])  # which the sign has asked for
    while True:
        ball = x.enclosure(prec)
        if ball.is_finite():
            low, high = (_rounded_binary(*end, bits) for end in ball_ends(ball))
            if low == high:
                return low
        if prec > 2 * EQUAL_BITS + 8 * bits:  # a tie by the rule: the even neighbour
            middle = ball_middle(ball)
            return _rounded_binary(*_rounded_binary(*middle, bits + 8), bits)
        prec *= 2


def nearest(x: Number, bits: int) -> Fraction:
    """The number of ``bits`` significant bits nearest to x (ties to even)."""
    return binary(*rounded(x, bits))


def log10(x: Number) -> float:
    """log10 |x| as a double, at any magnitude; -inf at zero."""
    mantissa, exponent = rounded(x, 53)
    return math.log10(abs(mantissa)) + exponent * math.log10(2) if mantissa else -math.inf


def exponent_above(x: Number) -> int:
    """The exponent of two just above |x|, rounded to eight bits."""
    mantissa, exponent = rounded(x, 8)
    return exponent + mantissa.bit_length()


def magnitude(x: Irrational) -> int:
    """The exponent of two just above |x|, or 0 where 128 bits do not tell x from zero."""
    ball = x.enclosure(_LADDER[0])
    if ball.contains(0) or not ball.is_finite():
        return 0
    _, (mantissa, exponent) = ball_ends(ball)
    return exponent + mantissa.bit_length()


def as_ball(x: Fraction | int) -> arb:
    """A fraction as a ball at the precision in force; ``polynomials.middle`` is the way back."""
    from flint import arb, fmpq

    return arb(fmpq(x.numerator, x.denominator))


def binary(mantissa: int, exponent: int) -> Fraction:
    """mantissa·2**exponent, exactly."""
    if exponent >= 0:
        return Fraction(mantissa << exponent)
    return Fraction(mantissa, 1 << -exponent)


def _of_angle(function: str, x: Exact, at_zero: Fraction) -> Exact:
    if not -_LARGEST_ANGLE <= x <= _LARGEST_ANGLE:
        raise ValueError("sine or cosine of an angle too large to be reduced")
    return at_zero if isinstance(x, Fraction) and x == 0 else Irrational(methodcaller(function), x)


def _rounded_ratio(over: int, bottom: int, bits: int) -> tuple[int, int]:
    top = abs(over)
    if top == 0:
        return 0, 0
    exponent = top.bit_length() - bottom.bit_length() - bits
    if exponent >= 0:
        bottom <<= exponent
    else:
        top <<= -exponent
    quotient, rest = divmod(top, bottom)
    if quotient.bit_length() > bits:
        exponent, bottom = exponent + 1, 2 * bottom
        quotient, rest = divmod(top, bottom)
    if 2 * rest > bottom or (2 * rest == bottom and quotient & 1):
        quotient += 1
    return (quotient if over > 0 else -quotient), exponent


def _rounded_binary(mantissa: int, exponent: int, bits: int) -> tuple[int, int]:
    """mantissa·2**exponent to so many bits."""
    nearest, by = _rounded_ratio(mantissa, 1, bits)
    return (nearest, by + exponent) if nearest else (0, 0)


def _irrational(
    rule: Callable[..., arb], parts: tuple[Exact, ...], square: Exact | None
) -> Irrational:
    """What was pickled: a partial instead would nest deeper, and Python allows so much of it."""
    return Irrational(rule, *parts, square=square)


# --- ball rules -----------------------------------------------------------------------------------
#
# How enclosures combine: the rules of irrational numbers, on FLINT's balls.
#
# Each takes balls and computes with the precision in force; what it gives holds all values that
# the operation has on them. Functions of a module, so that a number that holds one can be
# pickled. Sums, products, sine and cosine are FLINT's own.


def ball_quotient(a: arb, b: arb) -> arb:
    """a/b."""
    # While the divisor's enclosure is still too wide to exclude zero, nothing is known.
    return ball_nothing(a) if b.contains(0) else a / b


def ball_root(a: arb) -> arb:
    """The square root of what cannot be negative."""
    return a.sqrt() if a > 0 else _up_to(a.abs_upper().sqrt())


def ball_angle(a: arb, b: arb) -> arb:
    """The angle of (b, a), a not below zero: no branch is cut where a's enclosure is around it."""
    if b > 0:
        return (a / b).atan()
    if b < 0:
        return ball_pi() - (a / -b).atan()
    if a > 0:
        return ball_pi() / 2 - (b / a).atan()
    return _up_to(ball_pi())


def ball_pi() -> arb:
    """The number pi."""
    from flint import arb

    return arb.pi()


def ball_power(a: arb, e: arb) -> arb:
    """a to the power e, for what cannot be negative."""
    return (e * a.log()).exp() if a > 0 else ball_nothing(a)


def ball_integer_power(n: int, a: arb) -> arb:
    """a to the power n >= 1, by products: FLINT's power of a ball around 0 is no number."""
    product, square = None, a
    while n:
        if n & 1:
            product = square if product is None else product * square
        n >>= 1
        square = square * square if n else square
    assert product is not None
    return product


def ball_nothing(a: arb) -> arb:
    """A ball that holds all numbers."""
    return type(a)(0, float("inf"))


def ball_middle(ball: arb) -> tuple[int, int]:
    """(m, e) with m·2**e the midpoint of a ball; 0 where nothing is known."""
    mantissa, exponent = ball.mid().man_exp() if ball.is_finite() else (0, 0)
    return int(mantissa), int(exponent)


def ball_ends(ball: arb) -> tuple[tuple[int, int], tuple[int, int]]:
    """(m, e) with m·2**e the lower and the upper end of a ball, exactly."""
    middle, p, radius, q = map(int, (*ball.mid().man_exp(), *ball.rad().man_exp()))
    least = min(p, q)
    middle, radius = middle << (p - least), radius << (q - least)
    return (middle - radius, least), (middle + radius, least)


def _up_to(most: arb) -> arb:
    """A ball that holds [0, most]."""
    return type(most)(0).union(most)

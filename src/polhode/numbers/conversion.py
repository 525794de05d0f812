"""Lossless ways between numbers, and sequences of exact ones: nothing here narrows silently."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from decimal import Decimal
from fractions import Fraction
from operator import index
from typing import Any, TypeVar, cast, overload

from polhode.common.errors import plain
from polhode.common.values import cached_property
from polhode.numbers import exact, expression, number_types
from polhode.numbers.exact import ZERO, Exact, Number, sign
from polhode.numbers.expression import TOO_LARGE, ExpressionError, decimal, number, number_in_text
from polhode.numbers.number_types import Doubles, Flat, Given, Numbers, NumberType, Rows, Scalar

#: Rows of a run's numbers, or numbers in a row.
SameRows = TypeVar("SameRows", Rows, Numbers)

_ONE, _HALF = 1.0, 2.0**-53  # of its last bit


def mpf_row(row: Sequence[Scalar], bits: int) -> list[Scalar]:
    """The binary numbers of so many bits nearest to each of a row; ValueError if not finite."""
    from polhode.numbers.mpmath_context import mpmath

    numbers = []
    for x in row:
        raw = getattr(x, "_mpf_", None)
        is_held = raw is not None and 0 < raw[3] <= bits  # bits of its mantissa
        numbers.append(mpmath.make_mpf(raw) if is_held else to_mpf(exactly(x), bits))
    return numbers


def narrowed(x: Scalar, number_type: NumberType) -> Scalar:
    """A number that was computed in more precision, as a trajectory holds it.

    Raises ValueError where it is not finite, or complex.
    """
    raw = getattr(x, "_mpf_", None)
    if raw is None or raw[1] == 0 or number_type.flat:
        return number_value(exactly(x), number_type)
    from polhode.numbers.mpmath_context import rounded_real

    return rounded_real(raw, number_type.bits)


def number_value(x: Number, number_type: NumberType) -> Scalar:
    """The number nearest to x of the kind that a trajectory holds: float, longdouble or mpf."""
    if number_type.name == "double":
        return to_double(x)
    if number_type.name == "extended":
        return to_extended(x)
    from polhode.numbers.mpmath_context import ordinary

    return ordinary(to_mpf(x, number_type.bits))


def joined(parts: Sequence[SameRows], number_type: NumberType) -> SameRows:
    """Several parts' rows, or numbers, in one: an array, or a list above extended."""
    if not number_type.flat:
        return [row for part in parts for row in part]
    import numpy as np

    if len(parts) == 1:
        return parts[0]
    return np.concatenate([number_types.flat(part) for part in parts])


def to_double(x: Number) -> float:
    """The nearest double; infinite, of its sign, beyond its range."""
    try:
        if isinstance(x, Fraction):  # at half the time that float takes
            over, under = x.as_integer_ratio()
            return over / under
        if isinstance(x, int):
            return float(x)
        return math.ldexp(*exact.rounded(x, 53))
    except OverflowError:
        return math.copysign(math.inf, sign(x))


def doubles(rows: Given) -> Doubles:
    """Rows as doubles, shape (rows, columns); not a number where a cell is None."""
    import numpy as np

    if isinstance(rows, np.ndarray) and rows.dtype.kind == "f":
        return rows.astype(np.float64)
    return np.array(
        [[math.nan if x is None else to_double(exactly(x)) for x in row] for row in rows]
    )


def to_extended(x: Number) -> Scalar:
    """The nearest 80-bit number, as numpy.longdouble."""
    import numpy as np

    mantissa, exponent = exact.rounded(x, 64)
    high, low = divmod(abs(mantissa), 1 << 32)
    value = np.ldexp(np.longdouble(high), exponent + 32) + np.ldexp(np.longdouble(low), exponent)
    return -value if mantissa < 0 else value


def to_mpf(x: Number, bits: int) -> Scalar:
    """The nearest binary number of so many bits, to be computed with: polhode's own mpf."""
    from mpmath import libmp

    from polhode.numbers.mpmath_context import mpmath

    mantissa, exponent = exact.rounded(x, bits)
    return mpmath.make_mpf(libmp.from_man_exp(mantissa, exponent))


def exactly(value: Any) -> Fraction:
    """The exact value of any number that has one; ValueError if not finite."""
    if type(value) is Fraction:
        return value
    if isinstance(value, (int, Fraction)):
        return Fraction(value)
    try:
        if isinstance(value, float):  # numpy.float64 is one
            return Fraction(value)
        raw = getattr(value, "_mpf_", None)
        if hasattr(value, "__index__") and getattr(value, "ndim", 0) == 0:  # numpy's integers
            return Fraction(index(value))
        if raw is not None:
            negative, mantissa, exponent, _ = raw
            if mantissa == 0 and exponent != 0:
                raise ValueError("not a finite number")
            size = int(mantissa) * Fraction(2) ** int(exponent)
            return -size if negative else size
        return Fraction(*value.as_integer_ratio())  # numpy.longdouble, Decimal
    except (AttributeError, OverflowError, TypeError, ValueError):
        raise ValueError("not a finite number") from None


def exact_number(value: object) -> Exact:
    """A number given in Python, taken exactly, a float as the binary number that it is.

    ``value``: int, Fraction, Irrational, float, Decimal, numpy or mpmath number, or a string
    holding an expression such as ``"0.1"`` or ``"sqrt(2)/3"``.  Raises ValueError for anything
    else, and for what is larger than a text may say, before it is made exact.
    """
    if isinstance(value, float):
        return exactly(value)
    x = derived_number(value)
    if isinstance(x, Fraction):
        top, bottom = x.as_integer_ratio()
        if top.bit_length() - bottom.bit_length() > expression.MAX_BITS:  # before its point, to one
            raise ExpressionError(TOO_LARGE)
    return x


def derived_number(value: object) -> Exact:
    """The same of what may be computed from numbers given: a Fraction may be larger."""
    if isinstance(value, Fraction):
        if max(value.numerator.bit_length(), value.denominator.bit_length()) > expression.MOST_BITS:
            raise ExpressionError(TOO_LARGE)
        return value
    if getattr(value, "ndim", None) == 0 and not isinstance(value, (str, bytes)):
        value = value[()]  # type: ignore[index]  # of an array of no dimension
    if isinstance(value, exact.Irrational):
        return value
    if isinstance(value, str):
        return number(value)
    if isinstance(value, Decimal):
        return decimal(str(value))
    if isinstance(value, bool) or not hasattr(value, "__float__"):
        raise ValueError(f"not a number: {plain(value)}")
    if not isinstance(value, float) and _too_large(value):
        raise ExpressionError(TOO_LARGE)
    return exactly(value)


def _too_large(value: object) -> bool:
    """Whether a number has too many bits, found without making it exact."""
    if (raw := getattr(value, "_mpf_", None)) is not None:
        _, mantissa, exponent, bits = raw
        return (
            mantissa != 0
            and not -expression.MOST_BITS < exponent <= exponent + bits <= expression.MAX_BITS
        )
    try:
        return index(value).bit_length() > expression.MAX_BITS  # type: ignore[arg-type]  # if it is whole
    except TypeError:
        return False  # numpy's, none of which is as large; or no number


#: Units of what is given beside a scene.
TIME, ENERGY, AREA = "s", "J", "kg*m**2/s"

_UNITLESS = 'with a unit, and the scene has none; units = "SI" in it says that its numbers are SI'


def reader(units: str, unit: str) -> Callable[[object], Exact]:
    """What reads a number beside a scene of these ``units``, in an option or an argument.

    A scene in SI takes ``"100 ms"`` for a time as a scene file does.  Where a scene's numbers have
    any consistent units, a number with a unit means nothing, but for an angle.  ``unit``: as in
    :func:`polhode.numbers.expression.in_unit`.  It raises ValueError for what is no number, and for
    another dimension.
    """

    def read(value: object) -> Exact:
        return in_text(value, units, unit) if isinstance(value, str) else exact_number(value)

    return read


def in_text(text: str, units: str, unit: str) -> Exact:
    """The number in a text; raises ExpressionError, a ValueError."""
    value, in_si = number_in_text(text, unit)
    if in_si and not units:
        raise ExpressionError(_UNITLESS)
    return value


def rounds_to_nearest() -> bool:
    """Whether this thread's doubles are rounded to the nearest; any library may change that."""
    up, down = _ONE + 1.5 * _HALF, -_ONE - 1.5 * _HALF
    return _ONE + _HALF == _ONE and -_ONE - _HALF == -_ONE and up > _ONE and down < -_ONE


# --- exact sequences ------------------------------------------------------------------------------
#
# Sequences of exact numbers of which none is made before it is asked for: times, and sweeps.
#
# They are equal to any sequence of the same numbers. A run of 10**6 outputs wants its times as an
# array of doubles, correctly rounded; the exact numbers are for those who print or judge.


T = TypeVar("T", covariant=True)

_FEW = 16  # numbers, which take no longer one by one

#: The kind of number that they are.
N = TypeVar("N", bound=Exact, covariant=True)


class LazySequence(Sequence[T], ABC):
    """A sequence whose elements are made when asked for; equal to any other of the same."""

    @abstractmethod
    def at(self, k: int) -> T:
        """The element of a place, 0 or more."""

    @overload
    def __getitem__(self, k: int) -> T: ...
    @overload
    def __getitem__(self, k: slice) -> Sequence[T]: ...
    def __getitem__(self, k: int | slice) -> T | Sequence[T]:
        if isinstance(k, slice):
            return tuple(self.at(i) for i in range(len(self))[k])
        return self.at(range(len(self))[index(k)])  # one of numpy's would overflow in a Fraction

    def __iter__(self) -> Iterator[T]:
        return map(self.at, range(len(self)))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Sequence):
            return NotImplemented
        return len(self) == len(other) and all(a == b for a, b in zip(self, other, strict=True))

    __hash__ = None  # type: ignore[assignment]


class ExactNumbers(LazySequence[N]):
    """Immutable exact numbers: listed ones, evenly spaced ones, or the floats of an array.

    ``listed``: a tuple of them.  ``ends`` and ``size``: so many from the first to the last, both
    included.  ``floats``: an array (n,) that nobody writes to from now on.

    >>> times = spaced(Fraction(0), Fraction(1), 4)
    >>> times[1], times[-1], len(times)
    (Fraction(1, 3), Fraction(1, 1), 4)
    """

    def __init__(
        self,
        listed: tuple[N, ...] | None = None,
        ends: tuple[Exact, Exact] | None = None,
        size: int = 0,
        floats: Flat | None = None,
    ) -> None:
        self.listed, self.ends, self.floats = listed, ends, floats
        self.size = size
        if listed is not None:
            self.size, self.exact = len(listed), listed
        elif floats is not None:
            self.size = len(floats)
            floats.flags.writeable = False

    def __len__(self) -> int:
        return self.size

    def at(self, k: int) -> N:
        """The number of a place."""
        if self.listed is not None:
            return self.listed[k]
        if self.floats is not None:
            return cast(N, exactly(self.floats[k]))
        first, last = cast("tuple[Exact, Exact]", self.ends)
        if k == self.size - 1 > 0:
            return cast(N, last)
        return cast(N, first + (last - first) * Fraction(k, max(1, self.size - 1)))

    @cached_property
    def exact(self) -> tuple[N, ...]:
        """All of them."""
        return tuple(map(self.at, range(self.size)))

    @overload
    def __getitem__(self, k: int) -> N: ...
    @overload
    def __getitem__(self, k: slice) -> ExactNumbers[N]: ...
    def __getitem__(self, k: int | slice) -> N | ExactNumbers[N]:
        if self.listed is not None:
            return ExactNumbers(self.listed[k]) if isinstance(k, slice) else self.listed[k]
        if not isinstance(k, slice):
            return super().__getitem__(k)
        if self.floats is not None:
            return ExactNumbers(floats=self.floats[k])
        return ExactNumbers(tuple(super().__getitem__(k)))

    def __iter__(self) -> Iterator[N]:
        return iter(self.exact)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, ExactNumbers) and self.size == other.size > 0:
            if self.ends and other.ends:
                return (self[0], self[-1]) == (other[0], other[-1])  # of one, the last is not in it
            mine, theirs = self.floats, other.floats
            if mine is not None and theirs is not None and mine.dtype == theirs.dtype:
                return bool((mine == theirs).all())
        if not isinstance(other, Sequence):
            return NotImplemented
        return self.size == len(other) and self.exact == tuple(other)

    def __hash__(self) -> int:  # type: ignore[override]
        return hash(self.exact)

    def __reduce__(self) -> tuple[object, ...]:
        return ExactNumbers, (self.listed, self.ends, self.size, self.floats)

    def __repr__(self) -> str:
        return repr(self.exact)

    def __add__(self, other: Sequence[Exact]) -> tuple[Exact, ...]:
        return (*self.exact, *other)

    def __radd__(self, other: Sequence[Exact]) -> tuple[Exact, ...]:
        return (*other, *self.exact)

    @property
    def summary(self) -> str:
        """A short text that tells them from others: of an array a digest of its numbers."""
        if self.floats is not None:
            from hashlib import sha256

            digest = sha256(self.floats.astype(str).tobytes()).hexdigest()[:16]
            return f"{self.size} floats, {digest}"
        return repr(self.listed) if self.ends is None else f"{self.size} of {self.ends}"

    def misplaced(self) -> int | None:
        """The place of the first that does not lead further away from 0; None where all do.

        They are of one sign, and 0 may be the first.
        """
        if self.size < 2 or (self.ends and self.ends[0] == 0 and sign(self.ends[1]) != 0):
            return None
        if self.floats is not None:
            import numpy as np

            ahead = self.floats if self.floats[-1] > 0 else -self.floats
            if ahead[0] >= 0 and np.all(ahead[1:] > ahead[:-1]):
                return None
        before: Exact = ZERO
        direction = sign(self.exact[-1])
        for k, t in enumerate(self.exact):
            further = sign(t - before) * direction
            if further < 0 or (further == 0 and not (k == 0 and sign(t) == 0)):
                return k
            before = t
        return None

    def doubles(self) -> Doubles:
        """The nearest doubles, correctly rounded.

        Evenly spaced ones from 0 on are k·step: as a longdouble, with the step rounded to one, that
        is wrong by 2**-10 of the gap between doubles at most.  Off a tie by more it is rounded
        right, unless the gap below is narrower; what is left is made one by one.
        """
        import numpy as np

        if self.floats is not None:
            return self.floats.astype(np.float64)
        step = ZERO if self.ends is None else self.ends[1] / max(1, self.size - 1)
        plain = isinstance(step, Fraction) and 2.0**-800 < abs(step) < 2.0**800
        plain = plain and self.ends is not None and self.ends[0] == 0
        if self.size < _FEW or not plain or not number_types.extended_here():
            return np.array([to_double(x) for x in self.exact])
        wide = np.arange(self.size) * to_extended(step)
        near: Doubles = wide.astype(np.float64)
        gap = np.spacing(np.abs(near))
        unsure = np.abs(np.abs(wide - near) - gap / 2) <= gap * 2.0**-9
        unsure |= np.abs(np.frexp(near)[0]) == 0.5
        for k in np.flatnonzero(unsure).tolist():
            near[k] = to_double(step * k)
        return near

    def rounded(self, number_type: NumberType) -> ExactNumbers[Fraction]:
        """The nearest numbers of a type."""
        floats = self._flat(number_type) if number_type.flat and self.size >= _FEW else None
        if floats is None:
            return ExactNumbers(tuple(map(number_type.rounded, self.exact)))
        return ExactNumbers(floats=floats)

    def _flat(self, number_type: NumberType) -> Flat | None:
        """The nearest doubles or longdoubles; None where they are to be rounded one by one."""
        import numpy as np

        if number_type.bits == 53:
            nearest: Flat = self.doubles()
            least, most = 2.0**-900, 2.0**900
        elif self.floats is not None:
            return self.floats.astype(np.longdouble)
        else:
            nearest = np.array([to_extended(t) for t in self.exact])
            least, most = np.ldexp(np.longdouble(1), -16000), np.ldexp(np.longdouble(1), 16000)
        sizes = np.abs(nearest[1:] if sign(self[0]) == 0 else nearest)
        return nearest if np.all((sizes > least) & (sizes < most)) else None


def spaced(first: Exact, last: Exact, size: int) -> ExactNumbers[Exact]:
    """So many numbers from ``first`` to ``last``, evenly spaced, ends included."""
    return ExactNumbers(ends=(first, last), size=size)

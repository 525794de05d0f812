"""Number types, their numbers one by one, and rows of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, SupportsFloat, TypeAlias, cast

from polhode.common.values import cached_property
from polhode.numbers import exact
from polhode.numbers.exact import Number

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt


# --- number types ---------------------------------------------------------------------------------
#
# Number types of a run, and the choice of one by the digits wanted.
#
# A binary number is exact as a Fraction; :func:`polhode.numbers.exact.rounded` is the one place
# that rounds.


LOG10_2 = math.log10(2)
DIGITS_HELD = {"double": 15, "extended": 18, "quad": 33}  # what --digits may ask of each type
NAMES = ("double", "extended", "quad", "mp")
DEFAULT_MP_DIGITS = 50
MAX_DIGITS = 4000  # that --digits may ask for
MOST_ASKED = MAX_DIGITS + 1000  # of a reference: those, and what judging them spares
LEAST_MP_BITS = 64  # what heyoka's integers come in: its states of fewer bits would not take them
_SPARE = 0.5  # digits that an expected loss may fall short


@dataclass(frozen=True)
class NumberType:
    """A binary floating-point type: its name and the bits of its significand.

    >>> import polhode
    >>> quad = polhode.NumberType("quad", 113)
    >>> quad == polhode.integrate("lagrange/nutation", "quad", at=[1]).number
    True
    >>> float(quad.eps), round(quad.most_digits, 1), quad.rounded(quad.eps / 3) < quad.eps
    (1.925929944387236e-34, 34.0, True)
    """

    name: str
    bits: int

    @cached_property
    def flat(self) -> bool:
        """Whether numpy holds its numbers as they are: double and extended; mpmath those above."""
        return self.name in ("double", "extended")

    @cached_property
    def eps(self) -> Fraction:
        """The distance from 1 to the next number."""
        return Fraction(1, 1 << (self.bits - 1))

    @property
    def most_digits(self) -> float:
        """The most correct digits that the type can hold: bits·log10 2."""
        return self.bits * LOG10_2

    @property
    def printed_digits(self) -> int:
        """Significant decimal digits that round-trip: 1 + ceil(bits·log10 2)."""
        return 1 + math.ceil(self.bits * LOG10_2)

    def rounded(self, x: Number) -> Fraction:
        """The number of this type nearest to x."""
        if isinstance(x, Fraction):
            top, bottom = x.as_integer_ratio()
            if bottom & (bottom - 1) == 0 and top.bit_length() <= self.bits:
                return x
            if self.bits == 53 and -960 < top.bit_length() - bottom.bit_length() < 960:
                return Fraction(top / bottom)  # Python rounds the quotient correctly
        return exact.nearest(x, self.bits)


SINGLE = NumberType("single", 24)  # of somebody's arrays; nothing runs in it
DOUBLE = NumberType("double", 53)
EXTENDED = NumberType("extended", 64)
QUAD = NumberType("quad", 113)


def bits_for(digits: float) -> int:
    """Bits of significand that hold so many decimal digits."""
    return math.ceil(digits / LOG10_2) + 1


def mp(digits: float = DEFAULT_MP_DIGITS) -> NumberType:
    """The arbitrary-precision type that holds so many decimal digits, or more where heyoka must."""
    return NumberType("mp", max(LEAST_MP_BITS, bits_for(digits)))


def named(name: str, mp_digits: float = DEFAULT_MP_DIGITS) -> NumberType:
    """The type of that name; ``mp`` holds ``mp_digits``."""
    return {"double": DOUBLE, "extended": EXTENDED, "quad": QUAD}.get(name) or mp(mp_digits)


def is_possible(number_type: NumberType) -> bool:
    """Whether a type has the bits of its name; mp has any."""
    return number_type.name == "mp" or number_type == named(number_type.name)


def for_digits(digits: int, log10_angle: float, lost: float = 0.0) -> NumberType:
    """The cheapest type for so many correct digits after a turn through 10**log10_angle radians.

    Rounding of the start and the coefficients grows like the angle, the phase error of the steps
    like its 3/2 power times a small factor; the guard digits cover both.  ``lost``: the digits that
    this very motion is expected to lose on the way, where they were measured.
    """
    for name, digits_held in DIGITS_HELD.items():
        kind = named(name)
        enough = digits + math.ceil(log10_angle) <= digits_held
        enough = enough and digits + lost + (lost > 0) * _SPARE <= kind.most_digits
        if enough and (name != "extended" or extended_here()):
            return kind
    return mp_for(digits, log10_angle, lost)


def wider(number_type: NumberType) -> NumberType:
    """The next wider type, which sees what rounding in this one does."""
    nexts = {"double": EXTENDED if extended_here() else QUAD, "extended": QUAD}
    return nexts.get(number_type.name) or NumberType("mp", number_type.bits + 40)


@cache
def extended_here() -> bool:
    """Whether this machine's long double is the 80-bit one."""
    import numpy as np

    return bool(np.finfo(np.longdouble).nmant == EXTENDED.bits - 1)


def mp_for(digits: int, log10_angle: float, lost: float = 0.0) -> NumberType:
    """The mp type for so many correct digits, see :func:`for_digits`."""
    return mp(digits + max(math.ceil(1.5 * log10_angle), math.ceil(lost)) + 3)


# --- scalars --------------------------------------------------------------------------------------
#
# What a field needs of its scalars: floats, mpmath numbers and expressions alike.


#: What a formula is written for: int, Fraction, Irrational, float, numpy's longdouble and arrays,
#: mpmath's mpf, heyoka's expressions.  They have arithmetic in common and no type: mpmath and
#: heyoka bring none along.
Scalar: TypeAlias = Any

#: A number as a user may give it: int, Fraction, float, Decimal, numpy's and mpmath's, all taken
#: exactly; or a text that holds an expression.
AnyNumber: TypeAlias = SupportsFloat | str

#: Three of them, or four: any sequence, an array.
AnyVector: TypeAlias = Iterable[AnyNumber]


class Real(Protocol):
    """A number of any precision as a reference gives it: mpmath's mpf, which has no types."""

    def __float__(self) -> float: ...
    def __abs__(self) -> Real: ...
    def __neg__(self) -> Real: ...
    def __add__(self, other: Real | float, /) -> Real: ...
    def __radd__(self, other: Real | float, /) -> Real: ...
    def __sub__(self, other: Real | float, /) -> Real: ...
    def __rsub__(self, other: Real | float, /) -> Real: ...
    def __mul__(self, other: Real | float, /) -> Real: ...
    def __rmul__(self, other: Real | float, /) -> Real: ...
    def __truediv__(self, other: Real | float, /) -> Real: ...
    def __rtruediv__(self, other: Real | float, /) -> Real: ...
    def __pow__(self, other: Real | float, /) -> Real: ...
    def __lt__(self, other: Real | float, /) -> bool: ...
    def __le__(self, other: Real | float, /) -> bool: ...
    def __gt__(self, other: Real | float, /) -> bool: ...
    def __ge__(self, other: Real | float, /) -> bool: ...


def _sum_of_products(pairs: Sequence[tuple[Scalar, Scalar]]) -> Scalar:
    (first, second), *others = pairs
    return sum((a * b for a, b in others), first * second)


class Functions(NamedTuple):
    """What a scalar brings along: its zero, functions, whole powers, sums of products."""

    zero: Scalar
    sin: Callable[[Scalar], Scalar]
    cos: Callable[[Scalar], Scalar]
    sqrt: Callable[[Scalar], Scalar]
    power: Callable[[Scalar, int], Scalar] = pow
    dot: Callable[[Sequence[tuple[Scalar, Scalar]]], Scalar] = _sum_of_products


#: Of exact numbers.
EXACT = Functions(exact.ZERO, exact.sin, exact.cos, exact.sqrt)

#: Of Python's floats.
FLOATS = Functions(0.0, math.sin, math.cos, math.sqrt)


def of_mpmath() -> Functions:
    """Of mpmath's numbers, to the precision at which they are called."""
    from polhode.numbers.mpmath_context import mpmath

    return Functions(mpmath.mpf(0), mpmath.sin, mpmath.cos, mpmath.sqrt, dot=mpmath.fdot)


def of_extended() -> Functions:
    """Of numpy's longdoubles and of arrays of them."""
    import numpy as np

    return Functions(np.longdouble(0), np.sin, np.cos, np.sqrt)


def combination(k: Mapping[str, Scalar], zero: Scalar, *terms: tuple[str, Scalar]) -> Scalar:
    """Sum of k[name]·x over the terms whose coefficient is there; an absent one is exactly zero."""
    present = [k[name] * x for name, x in terms if name in k]
    return sum(present[1:], present[0]) if present else zero


# --- rows -----------------------------------------------------------------------------------------
#
# Rows of numbers, as a trajectory and its makers hold them: their types.


Doubles: TypeAlias = "npt.NDArray[np.float64]"
Extendeds: TypeAlias = "npt.NDArray[np.longdouble]"
Complexes: TypeAlias = "npt.NDArray[np.complex128]"
Integers: TypeAlias = "npt.NDArray[np.integer]"
Booleans: TypeAlias = "npt.NDArray[np.bool_]"
Indices: TypeAlias = "npt.NDArray[np.intp]"
Objects: TypeAlias = "npt.NDArray[np.object_]"

#: What picks elements of an array.
Index: TypeAlias = "int | slice | Integers | Booleans | list[int] | None"
Indexing: TypeAlias = "Index | tuple[Index, ...]"

#: Rows that numpy holds: an array (rows, columns).
Flat: TypeAlias = "Doubles | Extendeds"

#: An array of numbers as heyoka takes them: of its own kinds above extended.
Array: TypeAlias = "Flat | npt.NDArray[np.generic]"

#: One row.
Row: TypeAlias = "Flat | list[Real]"

#: Several rows of one number type: an array, of mpf above extended; lists of mpf on the way.
Rows: TypeAlias = "Flat | Objects | list[list[Real]]"

#: Rows of a trajectory's states: an array, of mpf above extended.
States: TypeAlias = "Flat | Objects"

#: Rows to be read alone, of numbers of any kind.
Given: TypeAlias = "Flat | Objects | Sequence[Sequence[Scalar | None] | Array]"

#: Numbers of one type in a row, heyoka's or exact ones too: an array, or a list.
Numbers: TypeAlias = "Array | list[Scalar]"

#: One row to be read alone.
GivenRow: TypeAlias = "Array | Sequence[Scalar]"

#: Rows of several members of a sweep: an array (members, times, columns), of objects above
#: extended.
Stack: TypeAlias = "Flat | Objects"

#: Rows with gaps: None where there is no number.
Gapped: TypeAlias = "list[list[Real | None]]"

#: Columns that may have gaps: an array where numpy has the type and no row is one.
DerivedRows: TypeAlias = "Flat | Gapped"


#: A row of angles or attitude read once more, or a list of them.
Reread: TypeAlias = "Row | list[Row] | list[Real | None] | Gapped"


def flat(rows: Rows | Numbers) -> Flat:
    """Rows of a type that numpy holds, as the array that they are."""
    assert not isinstance(rows, list)
    assert rows.dtype.kind == "f"
    return cast("Flat", rows)


def read_only(rows: Rows, width: int) -> States:
    """Rows as an array (rows, ``width``) that cannot be written into, of objects above extended."""
    import numpy as np

    if isinstance(rows, list):
        objects = np.empty((len(rows), width), dtype=np.object_)
        for k, row in enumerate(rows):
            objects[k] = row
        rows = objects
    view = rows.view()
    view.flags.writeable = False
    return view


def double_array(rows: Rows | Numbers | list[list[Scalar]]) -> Doubles:
    """Rows of doubles, or doubles in a row, as the array that they are."""
    import numpy as np

    return np.asarray(rows, dtype=np.float64)


def part_of(rows: Rows, columns: slice) -> Rows:
    """Some of the columns."""
    return [row[columns] for row in rows] if isinstance(rows, list) else rows[:, columns]


def kind_of(number_type: NumberType) -> npt.DTypeLike:
    """The kind of numpy's arrays of a number type: objects above extended."""
    import numpy as np

    if number_type.name == "double":
        return np.float64
    return np.longdouble if number_type.name == "extended" else np.object_

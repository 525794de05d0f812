"""Sequences of exact numbers of which none is made before it is asked for: times, and sweeps.

They are equal to any sequence of the same numbers.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from fractions import Fraction
from operator import index
from typing import TYPE_CHECKING, TypeVar, overload

from polhode.numbers.conversion import exactly, to_double, to_extended
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import extended_here

if TYPE_CHECKING:
    from polhode.numbers.rows import Doubles, Flat

T = TypeVar("T")

_FEW = 16  # numbers, which take no longer one by one


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


class Spaced(LazySequence[Exact]):
    """So many numbers from ``first`` to ``last``, evenly spaced, ends included.

    >>> times = Spaced(Fraction(0), Fraction(1), 4)
    >>> times[1], times[-1], len(times)
    (Fraction(1, 3), Fraction(1, 1), 4)
    """

    def __init__(self, first: Exact, last: Exact, size: int) -> None:
        self.first, self.last, self.size = first, last, size

    def __len__(self) -> int:
        return self.size

    def at(self, k: int) -> Exact:
        """The number of a place."""
        if k == self.size - 1 > 0:
            return self.last
        return self.first + (self.last - self.first) * Fraction(k, max(1, self.size - 1))

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Spaced) and self.size == other.size > 0:
            return (self[0], self[-1]) == (other[0], other[-1])  # of one, the last is not in it
        return super().__eq__(other)

    __hash__ = None

    def __repr__(self) -> str:
        return f"Spaced({self.first!r}, {self.last!r}, {self.size})"

    def doubles(self) -> Doubles:
        """The nearest doubles, correctly rounded.

        From 0 on they are k·step: as a longdouble, with the step rounded to one, that is wrong by
        2**-10 of the gap between doubles at most.  Off a tie by more it is rounded right, unless
        the gap below is narrower; what is left is made one by one.
        """
        import numpy as np

        step = (self.last - self.first) / max(1, self.size - 1)
        plain = self.first == 0 and isinstance(step, Fraction) and 2.0**-800 < abs(step) < 2.0**800
        if self.size < _FEW or not plain or not extended_here():
            return np.array([to_double(x) for x in self])
        wide = np.arange(self.size) * to_extended(step)
        near: Doubles = wide.astype(np.float64)
        gap = np.spacing(np.abs(near))
        unsure = np.abs(np.abs(wide - near) - gap / 2) <= gap * 2.0**-9
        unsure |= np.abs(np.frexp(near)[0]) == 0.5
        for k in np.flatnonzero(unsure).tolist():
            near[k] = to_double(step * k)
        return near


class Floats(LazySequence[Fraction]):
    """The floats of an array (n,) that nobody writes to from now on."""

    def __init__(self, values: Flat) -> None:
        self.values = values
        values.flags.writeable = False

    def __len__(self) -> int:
        return len(self.values)

    @overload
    def __getitem__(self, k: int) -> Fraction: ...
    @overload
    def __getitem__(self, k: slice) -> Floats: ...
    def __getitem__(self, k: int | slice) -> Fraction | Floats:
        return Floats(self.values[k]) if isinstance(k, slice) else super().__getitem__(k)

    def at(self, k: int) -> Fraction:
        """The number of a place."""
        return exactly(self.values[k])

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Floats) and self.values.dtype == other.values.dtype:
            return len(self) == len(other) and bool((self.values == other.values).all())
        return super().__eq__(other)

    __hash__ = None

    def __iter__(self) -> Iterator[Fraction]:
        return map(exactly, self.values.tolist())

    def __repr__(self) -> str:
        """With a digest of the numbers: it tells one array from another."""
        from hashlib import sha256

        digest = sha256(self.values.astype(str).tobytes()).hexdigest()[:16]
        return f"Floats({len(self)} numbers, {digest})"

    def doubles(self) -> Doubles:
        """The nearest doubles."""
        import numpy as np

        return self.values.astype(np.float64)

    def texts(self) -> list[str]:
        """The shortest decimals that round to the numbers."""
        import numpy as np

        if self.values.dtype == np.float64:
            return [repr(x) for x in self.values.tolist()]
        return [np.format_float_scientific(x, trim="0") for x in self.values]

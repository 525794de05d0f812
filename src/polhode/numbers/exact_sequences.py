"""Sequences of exact numbers of which none is made before it is asked for: times, and sweeps.

They are equal to any sequence of the same numbers.  A run of 10**6 outputs wants its times as an
array of doubles, correctly rounded; the exact numbers are for those who print or judge.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from fractions import Fraction
from operator import index
from typing import TYPE_CHECKING, TypeVar, cast, overload

from polhode.common.values import cached_property
from polhode.numbers.conversion import exactly, to_double, to_extended
from polhode.numbers.exact import ZERO, Exact, sign
from polhode.numbers.number_types import NumberType, extended_here

if TYPE_CHECKING:
    from polhode.numbers.number_types import Doubles, Flat

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
        if self.size < 2 or self._lead_away():
            return None
        before: Exact = ZERO
        direction = sign(self.exact[-1])
        for k, t in enumerate(self.exact):
            ahead = sign(t - before) * direction
            if ahead < 0 or (ahead == 0 and not (k == 0 and sign(t) == 0)):
                return k
            before = t
        return None

    def _lead_away(self) -> bool:
        """Whether all lead away from 0, as far as that is told all at once."""
        if self.ends is not None:
            return self.ends[0] == 0 and sign(self.ends[1]) != 0
        if self.floats is None:
            return False
        import numpy as np

        ahead = self.floats if self.floats[-1] > 0 else -self.floats
        return bool(ahead[0] >= 0 and np.all(ahead[1:] > ahead[:-1]))

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
        if self.size < _FEW or not plain or not extended_here():
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

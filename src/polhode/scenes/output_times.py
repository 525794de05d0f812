"""Output times, exact, of which no Fraction is made before it is asked for.

A run of 10**6 outputs wants them as an array of doubles, correctly rounded; the exact numbers are
for those who print or judge.
"""

from __future__ import annotations

import sys
from abc import abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from operator import index
from typing import TYPE_CHECKING, TypeVar, overload

from polhode.common.arguments import each
from polhode.common.cached_property import cached_property
from polhode.numbers.conversion import exactly, to_double, to_extended
from polhode.numbers.exact import ZERO, Exact, sign
from polhode.numbers.number_types import NumberType
from polhode.numbers.scalars import AnyNumber
from polhode.scenes.given_numbers import TIME, reader

if TYPE_CHECKING:
    from polhode.numbers.rows import Doubles, Flat


_FEW = 16  # times, which take no longer one by one

#: The kind of number that they are.
Time = TypeVar("Time", bound=Exact, covariant=True)


class OutputTimes(Sequence[Time]):
    """Times as a scene has them: a sequence of exact numbers, immutable, equal to their tuple."""

    @abstractmethod
    def _made(self) -> tuple[Time, ...]: ...

    @abstractmethod
    def __len__(self) -> int: ...

    @abstractmethod
    def __reduce__(self) -> tuple[object, ...]: ...

    @cached_property
    def exact(self) -> tuple[Time, ...]:
        """All of them."""
        return self._made()

    @overload
    def __getitem__(self, k: int) -> Time: ...
    @overload
    def __getitem__(self, k: slice) -> OutputTimes[Time]: ...
    def __getitem__(self, k: int | slice) -> Time | OutputTimes[Time]:
        return ListedTimes(self.exact[k]) if isinstance(k, slice) else self.exact[k]

    def __iter__(self) -> Iterator[Time]:
        return iter(self.exact)

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if isinstance(other, OutputTimes):
            return len(self) == len(other) and self.exact == other.exact
        return self.exact == other if isinstance(other, tuple) else NotImplemented

    def __hash__(self) -> int:
        return hash(self.exact)

    def __repr__(self) -> str:
        return repr(self.exact)

    def __add__(self, other: tuple[Exact, ...] | OutputTimes[Exact]) -> tuple[Exact, ...]:
        return (*self.exact, *other)

    def __radd__(self, other: tuple[Exact, ...]) -> tuple[Exact, ...]:
        return (*other, *self.exact)

    def misplaced(self) -> int | None:
        """The place of the first that does not lead further away from 0; None where all do.

        They are of one sign, and 0 may be the first.
        """
        before: Exact = ZERO
        direction = sign(self.exact[-1]) if self.exact else 0
        for k, t in enumerate(self.exact):
            ahead = sign(t - before) * direction
            if ahead < 0 or (ahead == 0 and not (k == 0 and sign(t) == 0)):
                return k
            before = t
        return None

    def doubles(self) -> Doubles:
        """The nearest doubles."""
        import numpy as np

        return np.array([to_double(t) for t in self.exact])

    def rounded(self, number: NumberType) -> OutputTimes[Fraction]:
        """The nearest numbers of a type."""
        found = self._flat(number) if number.flat and len(self) >= _FEW else None
        if found is None:
            return ListedTimes(tuple(number.rounded(t) for t in self.exact))
        return BinaryTimes(found)

    def _flat(self, number: NumberType) -> Flat | None:
        """The nearest doubles or longdoubles; None where they are to be rounded one by one."""
        import numpy as np

        if number.bits == 53:
            found: Flat = self.doubles()
            least, most = 2.0**-900, 2.0**900
        else:
            found = np.array([to_extended(t) for t in self.exact])
            least, most = np.ldexp(np.longdouble(1), -16000), np.ldexp(np.longdouble(1), 16000)
        sizes = np.abs(found[1:] if sign(self[0]) == 0 else found)
        return found if np.all((sizes > least) & (sizes < most)) else None


class ListedTimes(OutputTimes[Time]):
    """Times given one by one."""

    def __init__(self, values: tuple[Time, ...]) -> None:
        self.__dict__["exact"] = values

    def __len__(self) -> int:
        return len(self.exact)

    def __reduce__(self) -> tuple[object, ...]:
        return ListedTimes, (self.exact,)

    def _made(self) -> tuple[Time, ...]:
        raise AssertionError


class EvenTimes(OutputTimes[Exact]):
    """The times end·k/(samples - 1), 0 and end included.

    >>> times = EvenTimes(Fraction(1), 4)
    >>> times, times[1], len(times)
    ((Fraction(0, 1), Fraction(1, 3), Fraction(2, 3), Fraction(1, 1)), Fraction(1, 3), 4)
    """

    def __init__(self, end: Exact, samples: int) -> None:
        self.end, self.samples = end, samples

    def __len__(self) -> int:
        return self.samples

    def __reduce__(self) -> tuple[object, ...]:
        return EvenTimes, (self.end, self.samples)

    def _made(self) -> tuple[Exact, ...]:
        return tuple(self._at(k) for k in range(self.samples))

    def misplaced(self) -> int | None:
        """None: all lead away from 0."""
        return None

    def _at(self, k: int) -> Exact:
        return self.end * Fraction(k, self.samples - 1)

    @overload
    def __getitem__(self, k: int) -> Exact: ...
    @overload
    def __getitem__(self, k: slice) -> OutputTimes[Exact]: ...
    def __getitem__(self, k: int | slice) -> Exact | OutputTimes[Exact]:
        if isinstance(k, slice) or "exact" in self.__dict__:
            return super().__getitem__(k)
        k = range(self.samples)[index(k)]  # one of numpy's would overflow in the Fraction
        return self.end if k == self.samples - 1 else self._at(k)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, EvenTimes):
            return (self.end, self.samples) == (other.end, other.samples)
        return super().__eq__(other)

    __hash__ = OutputTimes.__hash__

    def doubles(self) -> Doubles:
        """The nearest doubles, correctly rounded all at once.

        k·q for q = end/(samples - 1), taken as a sum of two doubles with an error below 2**-105
        of itself: the product is one, too, with one below 2**-100. Its sum is rounded right unless
        the rest is that near to half a gap, or the gap below is narrower; those are made one by
        one.
        """
        import numpy as np

        from polhode.numbers.double_double import Pairs, pairs

        if self.samples < _FEW:
            return super().doubles()
        step = self.end / (self.samples - 1)
        if not isinstance(step, Fraction) or not 2.0**-800 < abs(step) < 2.0**800:
            return super().doubles()
        found = Pairs(np.arange(float(self.samples))) * pairs(step)
        near: Doubles = found.hi
        gap = np.spacing(np.abs(near))
        close = np.abs(np.abs(found.lo) - gap / 2) <= gap * 2.0**-40
        below = np.abs(np.frexp(near)[0]) == 0.5
        for k in np.flatnonzero(close | below).tolist():
            near[k] = to_double(self._at(k))
        return near


class BinaryTimes(OutputTimes[Fraction]):
    """Times that are doubles or longdoubles, of an array that nobody writes to from now on."""

    exact: tuple[Fraction, ...]

    def __init__(self, values: Flat) -> None:
        self.values = values
        values.flags.writeable = False

    def __len__(self) -> int:
        return len(self.values)

    def __reduce__(self) -> tuple[object, ...]:
        return BinaryTimes, (self.values,)

    def _made(self) -> tuple[Fraction, ...]:
        return tuple(exactly(t) for t in self.values.tolist())

    @overload
    def __getitem__(self, k: int) -> Fraction: ...
    @overload
    def __getitem__(self, k: slice) -> BinaryTimes: ...
    def __getitem__(self, k: int | slice) -> Fraction | BinaryTimes:
        if isinstance(k, slice):
            return BinaryTimes(self.values[k])
        return self.exact[k] if "exact" in self.__dict__ else exactly(self.values[k])

    def __iter__(self) -> Iterator[Fraction]:
        return iter(self.exact)

    def misplaced(self) -> int | None:
        """The place of the first that does not lead further away from 0; None where all do."""
        import numpy as np

        if not len(self):
            return None
        ahead = self.values if self.values[-1] > 0 else -self.values
        right = bool(ahead[0] >= 0 and np.all(ahead[1:] > ahead[:-1]))
        return None if right else super().misplaced()

    def doubles(self) -> Doubles:
        """The nearest doubles."""
        import numpy as np

        return self.values.astype(np.float64)

    def _flat(self, number: NumberType) -> Flat | None:
        import numpy as np

        if number.bits == 64 and self.values.dtype == np.float64:
            return self.values.astype(np.longdouble)
        return super()._flat(number)


def even_times(end: Exact, samples: int) -> OutputTimes[Exact]:
    """The times end·k/(samples - 1), 0 and end included."""
    return EvenTimes(end, samples)


def listed_times(
    source: str, key: str, values: Iterable[AnyNumber], units: str = ""
) -> OutputTimes[Exact]:
    """Times of any kind taken exactly; those of an array of doubles stay one.  Raises BadInput.

    ``units``: the scene's.
    """
    numpy = sys.modules.get("numpy")
    if numpy is not None and isinstance(values, numpy.ndarray):
        bare = type(values) is numpy.ndarray  # no masked one
        flat = bare and values.ndim == 1 and values.dtype == numpy.float64
        if flat and len(values) and bool(numpy.isfinite(values).all()):
            return BinaryTimes(values.copy())
    return ListedTimes(each(source, key, values, reader(units, TIME), "a list of times"))

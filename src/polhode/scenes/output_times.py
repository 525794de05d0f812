"""Output times, exact, of which no Fraction is made before it is asked for.

A run of 10**6 outputs wants them as an array of doubles, correctly rounded; the exact numbers are
for those who print or judge.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, TypeVar, cast, overload

from polhode.common.arguments import each
from polhode.common.cached_property import cached_property
from polhode.numbers.conversion import to_double, to_extended
from polhode.numbers.exact import ZERO, Exact, sign
from polhode.numbers.exact_sequences import Floats, Spaced
from polhode.numbers.number_types import NumberType
from polhode.numbers.scalars import AnyNumber
from polhode.scenes.given_numbers import TIME, reader

if TYPE_CHECKING:
    from polhode.numbers.rows import Doubles, Flat


_FEW = 16  # times, which take no longer one by one

#: The kind of number that they are.
Time = TypeVar("Time", bound=Exact, covariant=True)


class OutputTimes(Sequence[Time]):
    """Times as a scene has them: a sequence of exact numbers, immutable, equal to their tuple.

    ``numbers``: a tuple of them, or where they are made as they are asked for.
    """

    def __init__(self, numbers: tuple[Time, ...] | Spaced | Floats) -> None:
        self.numbers = numbers

    @cached_property
    def exact(self) -> tuple[Time, ...]:
        """All of them."""
        return cast(tuple[Time, ...], tuple(self.numbers))

    def __len__(self) -> int:
        return len(self.numbers)

    def __reduce__(self) -> tuple[object, ...]:
        return OutputTimes, (self.numbers,)

    @overload
    def __getitem__(self, k: int) -> Time: ...
    @overload
    def __getitem__(self, k: slice) -> OutputTimes[Time]: ...
    def __getitem__(self, k: int | slice) -> Time | OutputTimes[Time]:
        if isinstance(k, slice):
            return OutputTimes(cast(tuple[Time, ...] | Floats, self.numbers[k]))
        return cast(Time, self.__dict__.get("exact", self.numbers)[k])

    def __iter__(self) -> Iterator[Time]:
        return iter(self.exact)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, OutputTimes):
            return bool(self.numbers == other.numbers)
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
        if not len(self) or self._lead_away():
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
        if isinstance(self.numbers, Spaced):
            return self.numbers.first == 0 and sign(self.numbers.last) != 0
        if not isinstance(self.numbers, Floats):
            return False
        import numpy as np

        values = self.numbers.values
        ahead = values if values[-1] > 0 else -values
        return bool(ahead[0] >= 0 and np.all(ahead[1:] > ahead[:-1]))

    def doubles(self) -> Doubles:
        """The nearest doubles."""
        import numpy as np

        if isinstance(self.numbers, tuple):
            return np.array([to_double(t) for t in self.numbers])
        return self.numbers.doubles()

    def rounded(self, number: NumberType) -> OutputTimes[Fraction]:
        """The nearest numbers of a type."""
        found = self._flat(number) if number.flat and len(self) >= _FEW else None
        if found is None:
            return OutputTimes(tuple(number.rounded(t) for t in self.exact))
        return OutputTimes(Floats(found))

    def _flat(self, number: NumberType) -> Flat | None:
        """The nearest doubles or longdoubles; None where they are to be rounded one by one."""
        import numpy as np

        floats = self.numbers.values if isinstance(self.numbers, Floats) else None
        if number.bits == 53:
            found: Flat = self.doubles()
            least, most = 2.0**-900, 2.0**900
        elif floats is not None:
            return floats.astype(np.longdouble)
        else:
            found = np.array([to_extended(t) for t in self.exact])
            least, most = np.ldexp(np.longdouble(1), -16000), np.ldexp(np.longdouble(1), 16000)
        sizes = np.abs(found[1:] if sign(self[0]) == 0 else found)
        return found if np.all((sizes > least) & (sizes < most)) else None


def even_times(end: Exact, samples: int) -> OutputTimes[Exact]:
    """The times end·k/(samples - 1), 0 and end included."""
    return OutputTimes(Spaced(ZERO, end, samples))


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
            return OutputTimes(Floats(values.copy()))
    return OutputTimes(each(source, key, values, reader(units, TIME), "a list of times"))

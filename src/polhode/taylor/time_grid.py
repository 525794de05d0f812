"""Output times of a propagator: all at once as doubles or longdoubles."""

from __future__ import annotations

from math import isfinite

from polhode.common.values import cached_property
from polhode.numbers.number_types import Flat
from polhode.taylor.types import HeyokaNumber


class Grid:
    """Times that lead away from 0; immutable.

    ``times``: inside a run's frame, how many they are and the ``end``, the last one.  ``square``:
    of the last one in the scene's unit.
    """

    def __init__(self, times: Flat, square: float) -> None:
        self.times, self.square = times, square
        self.size, self.end = len(times), times.item(-1)

    @cached_property
    def ahead(self) -> list[HeyokaNumber]:
        """The times from 0 on in a list: heyoka reads an array one number after the other, which
        takes longer."""
        times = self.times.tolist()
        return times if times[0] == 0 else [times[0] - times[0], *times]

    @classmethod
    def of(cls, outside: Flat, unit: float) -> Grid | None:
        """Times in the scene's unit, an array (n,), times the ``unit``, a power of two.

        None where they do not lead away from 0, or are not inside what they are outside: too large
        for the type, or too small.
        """
        last, first = outside.item(-1), int(outside.item(0) == 0)
        if not isfinite(last * unit) or first == len(outside):
            return None
        times: Flat = outside * unit
        if times.item(first) / unit != outside.item(first):
            return None
        start, later, earlier = times.item(0), times[1:], times[:-1]
        leads = start >= 0 if last > 0 else start <= 0
        ways = later > earlier if last > 0 else later < earlier
        if not leads or False in ways.tobytes():  # of few that is faster than ways.all()
            return None
        return cls(times, float(last) * float(last))

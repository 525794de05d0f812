"""Other steps along a motion: for a crossing that was lost, and for what never leaves zero."""

from __future__ import annotations

import copy
from fractions import Fraction

import numpy as np

from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Array
from polhode.taylor.backend.heyoka_numbers import array, scalar
from polhode.taylor.backend.types import HeyokaIntegrator, HeyokaNumber
from polhode.taylor.events.jets import Jet, Marks
from polhode.taylor.events.polishing import Places, places

_PROBES = 8  # steps over which an expression that starts at zero must leave it
_OTHER_SEAMS = Fraction(1, 20)  # the longest step of a search, in the run's unit
_MOST_STEPS = 10_000  # of a search


def mark(
    heyoka: HeyokaIntegrator,
    clock: Array,
    width: int,
    number: NumberType,
    ago: HeyokaNumber | None = None,
) -> Marks:
    """Where an integrator stands, or stood so long ago in its last step.

    ``clock``: the time at which its own began, in two parts.  ``width``: how many of its variables
    are of the form.
    """
    high, low = heyoka.dtime
    row = heyoka.state
    if ago is not None:
        heyoka.update_d_output(ago, rel_time=True)
        row, low = heyoka.d_output, low + ago
    parts = [array([x], number) for x in (*clock.tolist(), high, low)]
    return Marks._make([*parts, row[:width, None].copy()])


class Probe:
    """Looks for crossings along steps of its own.

    ``heyoka``: the run's integrator, whose events nobody hears meanwhile; it is left alone.
    """

    def __init__(self, jet: Jet, heyoka: HeyokaIntegrator, width: int) -> None:
        self.jet, self.number, self.heyoka, self.width = jet, jet.number, heyoka, width

    def crossing(
        self,
        known: Places,
        start: Places,
        end: Places,
        way: int,
        side: int,
        since: int,
        before: int,
    ) -> Places | None:
        """The crossing to a side between two places: along other steps, and by bisection.

        ``since``: -1 for the start, ``before``: as many as there are places for the end.  It begins
        where the expression is nearer to zero: where steps are long for it, the motion from there
        on is the one that was seen there.
        """
        first = start if since < 0 else known.those([since])
        last = end if before == len(known.ahead) else known.those([before])
        ways = [(first, last, side, way), (last, first, -side, -way)]
        if abs(last.values[0, 0]) < abs(first.values[0, 0]):
            ways.reverse()
        for begin, stop, wanted, onwards in ways:
            length = abs(stop.ahead[0] - begin.ahead[0])
            found = self._along(begin.marks, length, wanted, onwards)
            if found is not None:
                return places(self.jet, found, way, np.array([True]))
        return None

    def _along(self, begin: Marks, length: HeyokaNumber, wanted: int, way: int) -> Marks | None:
        """Where the expression comes to a side along steps from a place, within some length."""
        probe = copy.deepcopy(self.heyoka)
        clock = array([begin.high[0], begin.low[0]], self.number)
        if self.jet.timed:
            probe.pars[:2] = clock
        (start,) = (begin.time + begin.rest).tolist()
        probe.time = start
        probe.state[: self.width] = begin.columns[:, 0]
        longest = scalar(_OTHER_SEAMS, self.number)
        for _ in range(_MOST_STEPS):
            left = length - abs(probe.time - start)
            if not left > 0:
                break
            probe.step(way * min(longest, left), write_tc=True)
            if self._beyond(mark(probe, clock, self.width, self.number), wanted):
                return self._bisected(probe, clock, wanted)
        return None

    def _bisected(self, probe: HeyokaIntegrator, clock: Array, side: int) -> Marks:
        """Where in a probe's last step the expression comes to a side."""
        low, high = -probe.last_h, probe.last_h - probe.last_h
        for _ in range(self.number.bits + 8):
            middle = (low + high) / 2
            if self._beyond(mark(probe, clock, self.width, self.number, middle), side):
                high = middle
            else:
                low = middle
        return mark(probe, clock, self.width, self.number, high)

    def _beyond(self, marks: Marks, side: int) -> bool:
        return bool(self.jet.at(marks)[0, 0] * side >= 0)


def stays(jet: Jet, heyoka: HeyokaIntegrator, clock: Array, width: int) -> bool:
    """Whether an expression stays within rounding of zero for some steps."""
    probe, longest = copy.deepcopy(heyoka), scalar(Fraction(1), jet.number)
    for _ in range(_PROBES):
        probe.step(longest)
        here = mark(probe, clock, width, jet.number)
        if not places(jet, here, 1, np.array([True])).near[0]:
            return False
    return True

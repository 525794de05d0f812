"""Which motion is in which lane of a batch: where one is over the next takes its place."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from polhode.common.interrupts import Stop


class LaneQueue:
    """Motions 0, 1, ... in the lanes of a batch.

    ``motion``: of each lane; spare ones repeat the last.  ``busy``: the lanes whose motion is not
    over.
    """

    def __init__(self, many: int, places: int) -> None:
        self.motion = np.minimum(np.arange(places), many - 1)
        self.busy = np.arange(places) < many
        self._many, self._ahead = many, min(places, many)

    def follow(
        self,
        begin: Callable[[int], None],
        stretch: Callable[[], Sequence[int] | None],
        stop: Stop | None,
    ) -> None:
        """Follow all motions to their ends, or until ``stop`` says so.

        ``stretch``: goes on by some time, and gives the lanes whose motion is over; None where
        stopped.  ``begin``: a lane's next motion begins, or an idle lane stands at a start.
        """
        while self.busy.any() and not (stop is not None and stop()):
            over = stretch()
            if over is None:
                return
            for lane in over:
                self._next(lane)
                begin(lane)

    def _next(self, lane: int) -> None:
        if self._ahead == self._many:
            self.busy[lane] = False
        else:
            self.motion[lane], self._ahead = self._ahead, self._ahead + 1

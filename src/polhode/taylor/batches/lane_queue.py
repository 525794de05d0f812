"""Which motion is in which lane of a batch: where one is over the next takes its place."""

from __future__ import annotations

import numpy as np


class LaneQueue:
    """Motions 0, 1, ... in the lanes of a batch.

    ``motion``: of each lane; spare ones repeat the last.  ``busy``: the lanes whose motion is not
    over.
    """

    def __init__(self, many: int, places: int) -> None:
        self.motion = np.minimum(np.arange(places), many - 1)
        self.busy = np.arange(places) < many
        self._many, self._ahead = many, min(places, many)

    def next(self, lane: int) -> None:
        """A lane's motion is over: the next one takes it; where none is left it idles."""
        if self._ahead == self._many:
            self.busy[lane] = False
        else:
            self.motion[lane], self._ahead = self._ahead, self._ahead + 1

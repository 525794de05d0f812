"""How the members of a sweep ended, all together."""

from __future__ import annotations

from typing import TYPE_CHECKING

from polhode.common.values import ByValue
from polhode.motion.outcomes import OUTCOMES, Outcome
from polhode.results.result import Result

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt


class SweepResult(Result, ByValue):
    """Members of a sweep, each of which ended in some way.

    ``endings``: how, indices into :data:`polhode.motion.outcomes.OUTCOMES`.
    """

    endings: npt.NDArray[np.uint8]

    def tally(self) -> dict[Outcome, int]:
        """How many members ended how, in the order in which the first of each comes."""
        import numpy as np

        codes, first, counts = np.unique(self.endings, return_index=True, return_counts=True)
        return {OUTCOMES[codes[k]]: int(counts[k]) for k in np.argsort(first)}

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C left members undone."""
        return Outcome.NOT_RUN in self.tally()

    @property
    def complete(self) -> bool:
        """Whether every member reached the end."""
        return all(outcome.done for outcome in self.tally())

    def _reached(self) -> str:
        """How many members reached the end, in words."""
        count = sum(n for outcome, n in self.tally().items() if outcome.done)
        return "all reached the end" if self.complete else f"{count} of them reached the end"

"""What a refinement may meet."""

from __future__ import annotations

from typing import Any

from polhode.motion.outcomes import CannotSolve


class CannotRefine(CannotSolve):
    """A run that cannot be refined; the message says why.  Take heyoka's own steps instead."""


class Stalled(CannotRefine):
    """Sweeps that do not converge; with more limbs, whose noise is less, they may."""


class TooFarOff(Exception):
    """The run in double has drifted too far within a block; ``good``: intervals still near."""

    def __init__(self, good: int) -> None:
        super().__init__(f"only {good} intervals are near")
        self.good = good


class IntervalsTooLong(Exception):
    """Some intervals of a block are too long; ``which``: a mask of its intervals."""

    def __init__(self, which: Any) -> None:
        super().__init__(f"{int(which.sum())} intervals are too long")
        self.which = which

"""Why a scene does not belong to a family of closed forms."""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

from polhode.numbers.decimals import decimal_string
from polhode.numbers.exact import Exact, binary, rounded


class Misfit(NamedTuple):
    """Why a scene does not belong to a family: the condition that fails, and by how much.

    ``condition``: as in "A = 2C".  ``off``: by how much its two sides differ, relative to the
    size of what is compared; None for a condition that holds or does not, with nothing between.
    ``order``: which principal axes (0, 1, 2) are the family's axes 1, 2, 3, where they have other
    names there.  ``worst``: by how much the condition that is off most is, where that is another.
    """

    condition: str
    off: Exact | None = None
    order: tuple[int, int, int] = (0, 1, 2)
    worst: Exact | None = None

    def within(self, share: Fraction) -> bool:
        """Whether all conditions hold up to that share of what is compared."""
        worst = self.off if self.worst is None else self.worst
        return worst is not None and worst <= share

    def __str__(self) -> str:
        if self.off is None:
            return self.condition
        off = decimal_string(binary(*rounded(self.off, 60)), 3)
        names = ""
        if self.order != (0, 1, 2):
            names = f" (its axes 1, 2, 3 are here {', '.join(str(i + 1) for i in self.order)})"
        return f"{self.condition}{names}, off by {off}"

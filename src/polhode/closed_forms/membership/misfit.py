"""Why a scene does not belong to a family of closed forms."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

from polhode.numbers.decimals import decimal_string
from polhode.numbers.exact import Exact, binary, log10, rounded

_ORDERS = 3  # of magnitude by which conditions that fail together may differ


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


def leading(failing: Sequence[tuple[str, Exact]]) -> Misfit | None:
    """Of conditions that fail, the first that is off by about as much as the worst.

    Those that follow from it fail too.  Amounts may have any sign.  None where none fails.
    """
    if not failing:
        return None
    sizes = [log10(abs(off)) for _, off in failing]
    worst = max(range(len(sizes)), key=lambda n: sizes[n])
    condition, off = next(
        row for row, size in zip(failing, sizes, strict=True) if size > sizes[worst] - _ORDERS
    )
    return Misfit(condition, abs(off), worst=abs(failing[worst][1]))

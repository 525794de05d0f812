"""The axis of residues of periodic orbits: linear around elliptic ones, logarithmic far out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LINEAR = 2.0  # up to this size the axis is linear
_DECADES = 6  # ticks on one side, at most


def residue_axis(axes: Axes, residues: Sequence[float]) -> None:
    """Limits that hold 0 and 1 and the residues, plain labels, lines at 0 and 1."""
    from matplotlib.ticker import FixedLocator, NullLocator, StrMethodFormatter

    low, high = (
        end + 0.25 * side if abs(end) < LINEAR else 1.5 * end
        for side, end in ((-1, min([0.0, *residues])), (1, max([1.0, *residues])))
    )
    axes.set_yscale("symlog", linthresh=LINEAR, linscale=1.5)
    axes.set_ylim(low, high)
    axes.yaxis.set_major_locator(
        FixedLocator([-x for x in _decades(-low)] + [0, 1] + _decades(high))
    )
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    for level in (0, 1):
        axes.axhline(level, color="#999999", lw=0.5, ls=":")
    axes.set_ylabel("residue")


def _decades(end: float) -> list[float]:
    """Powers of ten up to an end, from 10 on."""
    found, power = [], 10.0
    while power <= end:
        found.append(power)
        power *= 10
    return found[:: 1 + len(found) // _DECADES]

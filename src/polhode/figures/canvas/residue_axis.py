"""The axis of residues of periodic orbits: linear around elliptic ones, logarithmic far out."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def residue_axis(axes: Axes) -> None:
    """Linear up to 1, lines at 0 and 1, between which orbits are elliptic; plain labels."""
    from matplotlib.ticker import StrMethodFormatter

    axes.set_yscale("symlog", linthresh=1, linscale=1.5)
    axes.locator_params("y", numticks=9)
    axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    for level in (0, 1):
        axes.axhline(level, color="#999999", lw=0.5, ls=":")

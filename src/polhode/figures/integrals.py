"""Figure of the integrals' departures from their exact values over time (3.30)."""

from __future__ import annotations

from typing import Any

from polhode.figures import logarithmic
from polhode.figures.canvas import BODY, REST, SPACE
from polhode.samples import Samples

LABELS = {
    "h": r"$|\Delta h|\,/\,(T_0 + Mg|r_0|)$",
    "f": r"$|\Delta f|\,/\,|G_0|$",
    "gamma": r"$|\gamma^2 - 1|$",
    "fourth": r"$|\Delta K^2|$, relative",
}


def draw(plt: Any, found: Samples) -> Any:
    """One panel an integral."""
    colours = {"h": BODY, "f": SPACE, "gamma": REST}
    return logarithmic.draw(plt, found, LABELS, colours)

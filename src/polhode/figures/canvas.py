"""What all figures share: matplotlib, the same text for the same figure, colours of the types."""

from __future__ import annotations

from io import StringIO
from typing import Any

from polhode.errors import BadInput

COLOURS = {"double": "#0072b2", "extended": "#e69f00", "quad": "#009e73", "mp": "#cc79a7"}
MARKS = {"double": "o", "extended": "s", "quad": "D", "mp": "^"}


def require() -> None:
    """Raise BadInput where matplotlib is missing: before a study runs, not after."""
    pyplot()


def pyplot() -> Any:
    """matplotlib.pyplot, writing SVG that depends on the figure alone."""
    try:
        import matplotlib
    except ImportError:
        expected = "matplotlib, which figures need: pip install polhode[figures]"
        raise BadInput("polhode", "figures", None, expected) from None
    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "polhode"
    from matplotlib import pyplot as plt

    return plt


def as_svg(figure: Any) -> str:
    """A figure as SVG text; the figure is closed."""
    out = StringIO()
    figure.savefig(out, format="svg", metadata={"Date": None})
    pyplot().close(figure)
    return "\n".join(line.rstrip() for line in out.getvalue().splitlines()) + "\n"

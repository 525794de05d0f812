"""Labels beside curves instead of legends, and looks of methods: one colour means one thing."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import wrap
from typing import Any, NamedTuple

from polhode.figures.canvas.canvas import COLOURS, MARKS

WIDTH = 4.4  # inches of a report's figure: text of 8 points is 9 pixels on a page 400 pixels wide
GRID = "#dddddd"
GUIDE = "#777777"


class Look(NamedTuple):
    """How a method is drawn: line and marks, ``size`` points across.

    ``inside``, ``rim``: the colours of a mark's inside and rim where they are others.
    """

    colour: str
    mark: str
    line: str = "-"
    width: float = 1.1
    size: float = 4.0
    inside: str = ""
    rim: str = ""
    rim_width: float = 1.0
    alpha: float = 1.0

    @property
    def marks(self) -> Look:
        """The marks alone."""
        return self._replace(line="")


_SIZE, _ROOM = (
    8,
    0.02,
)  # of names at the ends of curves: points, and the part of the panel beside it
_LEADER = {"arrowstyle": "-", "lw": 0.4, "alpha": 0.6, "relpos": (0, 0.5)}
_LIGHT = "#56b4e9"
_OURS = COLOURS["double"]
#: A hue a program; what differs within one differs by mark and line.
LOOKS = {
    "polhode": Look(_OURS, "o", "-", 2.2),
    "double": Look(_LIGHT, "o", "--"),
    "polhode double": Look(_LIGHT, "o", "--"),
    "polhode double projected": Look(_OURS, "o"),
    "double projected": Look(_OURS, "o"),
    **{f"polhode {x}": Look(COLOURS[x], MARKS[x], "--") for x in ("extended", "quad", "mp")},
    **{f"polhode {x} projected": Look(COLOURS[x], MARKS[x]) for x in ("extended", "quad", "mp")},
    "quad, refined": Look(COLOURS["quad"], "v"),
    "proof": Look("#5d3a1a", "P"),
    "heyoka alone": Look("#000000", "x", ":"),
    "heyoka by hand": Look("#000000", "x", ":"),
    "polhode integrate": Look(_LIGHT, "o", "--"),
    "SciPy DOP853": Look("#999999", "s"),
    "SciPy LSODA": Look("#999999", "v", ":"),
    "CyRK DOP853": Look("#d55e00", "s"),
    "CyRK VERN8": Look("#d55e00", "^", "--"),
    "CyRK LSODA": Look("#d55e00", "v", ":"),
    "numbalsoda dop853": Look("#b8860b", "s"),
    "numbalsoda lsoda": Look("#b8860b", "v", ":"),
    "diffrax Dopri8": Look("#8c2d04", "D"),
    "SciPy DOP853, numba": Look("#999999", "s", "--"),
    "SciPy DOP853, Python": Look("#999999", "s"),
    "SciPy LSODA, numba": Look("#999999", "v", "--"),
    "SciPy LSODA, Python": Look("#999999", "v", ":"),
    "mpmath odefun": Look("#4d4d4d", "P", "--"),
    "splitting 4": Look("#6a3d9a", "s", ":"),
    "splitting 8": Look("#6a3d9a", "D", "--"),
    "splitting 8 compensated": Look("#6a3d9a", "o"),
}


def ink(colour: str) -> str:
    """The colour of a name: darker than its curve, so that small text can be read on white.

    >>> ink("#e69f00")
    '#966700'
    """
    parts = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return "#" + "".join(f"{round(0.65 * part):02x}" for part in parts)


class End(NamedTuple):
    """Where a curve ends, and its name."""

    x: float
    y: float
    text: str
    colour: str


def label_ends(ax: Any, ends: Sequence[End]) -> None:
    """Write each curve's name to the right of the panel, on a thin line that leads to its end.

    The figure must hold all else that it will, on its final scales; its layout makes room.
    """
    if not ends:
        return
    ax.figure.draw_without_rendering()  # settles the panel's place and limits
    place = ax.transAxes.inverted()
    heights = [place.transform(ax.transData.transform((e.x, e.y)))[1] for e in ends]
    inches = ax.get_position().height * ax.figure.get_size_inches()[1]
    least = 1.25 * _SIZE / 72 / max(inches, 0.1)
    order = sorted(range(len(ends)), key=heights.__getitem__)
    levels = _apart([min(max(heights[k], 0.0), 1.0) for k in order], least)
    for k, level in zip(order, levels, strict=True):
        end = ends[k]
        ax.annotate(
            end.text,
            (end.x, end.y),
            xytext=(1 + _ROOM, level),
            textcoords="axes fraction",
            fontsize=_SIZE,
            color=ink(end.colour),
            va="center",
            annotation_clip=False,
            arrowprops={"color": end.colour, **_LEADER},
        )


def _apart(wanted: Sequence[float], least: float) -> list[float]:
    """Rising levels, at least so far apart, near the wanted ones and within 0 to 1 if they fit.

    >>> _apart([0.5, 0.5], 0.25)
    [0.375, 0.625]
    """
    groups: list[tuple[float, int]] = []  # middle and number of labels that stand together
    for x in wanted:
        groups.append((x, 1))
        while len(groups) > 1:
            (a, m), (b, n) = groups[-2:]
            if b - a >= least * (m + n) / 2 - 1e-12:
                break
            groups[-2:] = [((a * m + b * n) / (m + n), m + n)]
    total = least * (len(wanted) - 1)
    levels = [mid + least * (k - (n - 1) / 2) for mid, n in groups for k in range(n)]
    low, high = (0.0, 1.0) if total <= 1 else (0.5 - total / 2, 0.5 + total / 2)
    for k in range(len(levels)):
        levels[k] = max(levels[k], low + least * k)
    for k in range(len(levels)):
        levels[-1 - k] = min(levels[-1 - k], high - least * k)
    return levels


def balanced(text: str, width: int) -> str:
    """The text in as few lines as hold it, of lengths as even as they can be.

    >>> balanced("Through a pole or past it", 23)
    'Through a pole\nor past it'
    """
    lines = len(wrap(text, width))
    return "\n".join(next(x for n in range(1, width + 1) if len(x := wrap(text, n)) <= lines))

"""What all figures share: matplotlib, the same text for the same figure, colours of the types."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from functools import partial
from io import StringIO
from itertools import cycle, groupby, islice
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from polhode.common.errors import BadInput, printable
from polhode.scenes.scene import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes


COLOURS = {"double": "#0072b2", "extended": "#e69f00", "quad": "#009e73", "mp": "#cc79a7"}
#: The variable of the environment from which matplotlib takes the date of a file.
DATE = "SOURCE_DATE_EPOCH"
MARKS = {"double": "o", "extended": "s", "quad": "D", "mp": "^"}


def pyplot(own: bool = True) -> Any:
    """matplotlib.pyplot, writing SVG that depends on the figure alone; else as the user has it.

    Raises BadInput where it is missing, or cannot use a variable of the environment.
    """
    try:
        import matplotlib
    except ImportError:
        expected = "it to be installed: pip install 'polhode[figures]'"
        raise BadInput("figures", "matplotlib", None, expected) from None
    except ValueError:  # it reads this variable while it is imported
        _refuse_variable("MPLBACKEND", "a backend that matplotlib has, such as agg, or none")
        raise
    try:
        datetime.fromtimestamp(int(os.environ.get(DATE) or 0), UTC)
    except (ValueError, OverflowError, OSError):
        _refuse_variable(DATE, "seconds since 1970, a whole number")
    if own:
        matplotlib.use("svg")
        matplotlib.rcParams["svg.hashsalt"] = "polhode"
    from matplotlib import pyplot as plt

    return plt


def _refuse_variable(name: str, expected: str) -> None:
    """Raise BadInput for a variable of the environment, if it is set."""
    if name in os.environ:
        raise BadInput("environment", name, os.environ[name], expected)


def panels(plt: Any, axes: Any, rows: int, columns: int = 1, **how: Any) -> tuple[Any, Any]:
    """A figure and its panels, shape (rows, columns): new ones, or the axes given to draw into."""
    import numpy as np

    if axes is None:
        subplots: tuple[Any, Any] = plt.subplots(
            rows, columns, squeeze=False, layout="constrained", **how
        )
        return subplots
    given_axes = np.ravel(np.asarray(axes, dtype=object))
    if len(given_axes) != rows * columns or not all(hasattr(x, "plot") for x in given_axes):
        expected = f"{rows * columns} matplotlib axes, one for each panel"
        raise BadInput("plot", "axes", f"{len(given_axes)} things", expected)
    return given_axes[0].figure, given_axes.reshape(rows, columns)


def over_time(
    plt: Any,
    t: Any,
    scene: Scene | None,
    rows: Mapping[str, Mapping[str, Any]],
    axes: Any = None,
    **how: Any,
) -> tuple[Any, Any]:
    """A figure and its panels above one another: a label each, and curves over time by name."""
    size = 5.6, 0.6 + (1.5 if len(rows) > 1 else 2.2) * len(rows)
    figure, grid = panels(plt, axes, len(rows), sharex=True, figsize=size, **how)
    for panel, (label, curves) in zip(grid[:, 0], rows.items(), strict=True):
        for (name, values), colour in zip(curves.items(), (*series(3), LAST), strict=False):
            panel.plot(t, values, color=colour, label=label_text(name), gid=name)
        panel.set_ylabel(label_text(label))
        if len(curves) > 1:
            panel.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    grid[-1, 0].set_xlabel(time_label(scene))
    if min(t) < max(t):  # one time alone has a place of its own
        grid[-1, 0].set_xlim(min(t), max(t))
    figure.align_ylabels()
    return figure, grid[:, 0]


def legend_of(figure: Any, axes: Any) -> Any:
    """Makes a legend: beside the panels of a figure of our own, within axes that were given."""
    if axes is None:
        return partial(figure.legend, loc="outside right upper")
    import numpy as np

    return np.ravel(np.asarray(axes, dtype=object))[0].legend


def legend(place: Callable[..., Any], axes: Iterable[Any], **how: Any) -> None:
    """Every name of the panels once; ``place``: makes a legend."""
    handles: dict[str, Any] = {}
    for panel in axes:
        for handle, name in zip(*panel.get_legend_handles_labels(), strict=True):
            handles.setdefault(name, handle)
    place(handles.values(), handles.keys(), **{"frameon": False} | how)


def as_svg(figure: Any, title: str | None = None) -> str:
    """A figure as SVG text; the figure is closed."""
    out = StringIO()
    metadata: dict[str, str | None] = {"Date": None}
    if title is not None:
        metadata["Title"] = printable(title)  # matplotlib refuses a title of None
    figure.savefig(out, format="svg", metadata=metadata)
    pyplot(own=False).close(figure)
    return "\n".join(line.rstrip() for line in out.getvalue().splitlines()) + "\n"


#: The style sheet of printed figures.
STYLE = Path(__file__).parent / "paper.mplstyle"


@contextmanager
def paper() -> Iterator[ModuleType]:
    """Draw printed figures of your own in the style of polhode's, whatever yours is.

    Returns
    -------
    context manager of module
        ``matplotlib.pyplot``, with text that stays text, thin axes, and SVG in which nothing but
        the figure counts: the same figure gives the same file.

    Raises
    ------
    BadInput
        matplotlib is not installed.

    Examples
    --------
    >>> import io, polhode
    >>> with polhode.paper() as plt:
    ...     figure, axes = plt.subplots()
    ...     line = axes.plot([0, 1], [0, 2])
    ...     figure.savefig(out := io.StringIO(), format="svg", metadata={"Date": None})
    >>> out.getvalue()[:5]
    '<?xml'
    """
    plt = pyplot(own=False)
    backend = plt.rcParams.copy()["backend"]  # the user's, which may not be chosen yet
    try:
        with plt.style.context(STYLE):
            yield pyplot()
    finally:
        with suppress(ImportError):  # one that cannot be had here was none before
            plt.switch_backend(backend)


#: Colours of Okabe and Ito's set, told apart by every eye; the same hue, lighter, for what is
#: hidden behind a surface.
BODY, SPACE, REST = "#0072b2", "#d55e00", "#009e73"
#: Of motions, in the order in which they are drawn: dark enough on white, neighbours far apart.
SERIES = (BODY, SPACE, REST, "#cc79a7", "#8c6d00", "#5d3a9b", "#1b9e9e", "#a50f15")
LAST = "#777777"  # of four curves
HIDDEN = {BODY: "#a6cbe3", SPACE: "#f3c6a5", REST: "#a6dccb"}
TIME = "t (units of the scene)"


def series(count: int) -> tuple[str, ...]:
    """So many colours: those of a style that the user chose, else ours."""
    import matplotlib

    chosen = matplotlib.rcParams["axes.prop_cycle"]
    own = chosen == matplotlib.rcParamsDefault["axes.prop_cycle"]
    colours = () if own else chosen.by_key().get("color", ())
    return tuple(islice(cycle(colours or SERIES), count))


def ink() -> str:
    """The colour of what is black on white, in the style that is in use."""
    import matplotlib

    colour: str = matplotlib.rcParams["text.color"]
    return colour


def pale(colour: str) -> str:
    """The same hue, lighter, for what is hidden behind a surface."""
    from matplotlib.colors import to_hex, to_rgb

    red, green, blue = (1 - 0.35 * (1 - x) for x in to_rgb(colour))
    return HIDDEN.get(colour) or to_hex((red, green, blue))


def time_label(scene: Scene | None) -> str:
    """What an axis of time says: seconds where a scene is in SI."""
    return "t (s)" if scene is not None and scene.units == "SI" else TIME


def rate_unit(scene: Scene | None) -> str:
    """The unit of an angular velocity."""
    return "rad/s" if scene is not None and scene.units == "SI" else "rad / unit of time"


def remark(axes: Any, text: str) -> None:
    """Why a panel is empty, in its middle."""
    middle = {"transform": axes.transAxes, "ha": "center", "va": "bottom"}
    axes.text(0.5, 0.55, text, color="#555555", size=8, **middle)
    axes.tick_params(axis="y", left=False, labelleft=False)


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
#: Letters and signs of labels in mathtext, which has fonts of its own for them.
_IN_MATHTEXT = {
    **{"ψ": r"\psi", "θ": r"\theta", "φ": r"\varphi", "ω": r"\omega", "γ": r"\gamma"},
    **{"ξ": r"\xi", "η": r"\eta", "π": r"\pi", "Δ": r"\Delta"},
    **{"·": r"\cdot", "−": "-", "×": r"\times"},
    **{letter: f"_{k}" for k, letter in enumerate("₀₁₂₃")},
    **{letter: f"^{digit}" for digit, letter in zip("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹", strict=True)},
}


_RUNS = re.compile(f"[{''.join(_IN_MATHTEXT)}]+")


def label_text(text: str) -> str:
    """A label as the font in use can print it: with its letters in mathtext where one is lacking.

    Else it is plain text, which can be found and read in an SVG; TeX has mathtext always.
    """
    import matplotlib

    letters = {letter for letter in text if letter in _IN_MATHTEXT}
    if not matplotlib.rcParams["text.usetex"]:
        fonts = _fonts(matplotlib.rcParams["font.family"])
        if all(any(font.get_char_index(ord(x)) for font in fonts) for x in letters):
            return text
    return _RUNS.sub(_as_mathtext, text)


def _as_mathtext(letters: re.Match[str]) -> str:
    """Letters in mathtext, neighbours that are raised in one group."""
    groups = groupby((_IN_MATHTEXT[x] for x in letters[0]), key=lambda mark: mark[0] == "^")
    parts = [
        f"^{{{''.join(mark[1:] for mark in marks)}}}" if raised else " ".join(marks)
        for raised, marks in groups
    ]
    return f"${' '.join(parts)}$"


def _fonts(families: Iterable[str]) -> list[Any]:
    """The fonts of a text of these families, each letter of which the first has that can."""
    from matplotlib.font_manager import FontProperties, findfont, get_font

    paths = []
    for family in families:
        with suppress(ValueError):  # which matplotlib leaves out as well
            paths.append(findfont(FontProperties(family=[family]), fallback_to_default=False))
    return [get_font(path) for path in paths or [findfont("DejaVu Sans")]]


def power_of_ten(exponent: float) -> str:
    """10 with its exponent, a whole number, in letters.

    >>> power_of_ten(-12.0)
    '10⁻¹²'
    """
    return label_text("10" + f"{exponent:.0f}".translate(_RAISED))


# --- residue axis ---------------------------------------------------------------------------------
#
# The axis of residues of periodic orbits: linear around elliptic ones, logarithmic far out.


def residue_axis(axes: Axes) -> None:
    """Linear up to 1, lines at 0 and 1, between which orbits are elliptic; plain labels."""
    from matplotlib.ticker import StrMethodFormatter

    axes.set_yscale("symlog", linthresh=1, linscale=1.5)
    axes.locator_params("y", numticks=9)
    axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    for level in (0, 1):
        axes.axhline(level, color="#999999", lw=0.5, ls=":")


# --- section axes ---------------------------------------------------------------------------------
#
# Axes of the coordinates of a section: an angle about r0, and a cosine to it.


_TURN = ["0", "π/2", "π", "3π/2", "2π"]
_BY_MOMENTUM = "l: azimuth of G about {about} (rad)", "L/G = cos(G, {about})"
_BY_HEIGHT = "azimuth of γ about {about} (rad)", "cos(γ, {about})"


def label(axes: Axes, height: bool = False, torque_free: bool = False) -> None:
    """Limits, ticks and names of l and L/G; of a section by height of γ's azimuth and cosine.

    Without a torque the third axis stands for r0.
    """
    about = "third axis" if torque_free else "r₀"
    labels = _BY_HEIGHT if height else _BY_MOMENTUM
    x, y = (label_text(text.format(about=about)) for text in labels)
    axes.set(xlim=(0, 2 * math.pi), ylim=(-1, 1), xlabel=x, ylabel=y)
    axes.set_xticks([k * math.pi / 2 for k in range(len(_TURN))], [*map(label_text, _TURN)])

"""The figures of each kind of result: one way to draw them, of a result and of its file."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from importlib import import_module
from io import BytesIO
from typing import Any

import numpy as np

from polhode.common.errors import BadInput, nearest, printable
from polhode.figures import canvas
from polhode.figures.samples import Samples
from polhode.results.result import Storable
from polhode.runs.saved import Saved

#: Of motions: where the function is that draws samples of one; the first is the default.
MOTION: Mapping[str, tuple[str, str]] = {
    "angles": ("curves", "angles"),
    "omega": ("curves", "omega"),
    "momentum": ("curves", "momentum"),
    "attitude": ("curves", "attitude"),
    "hodographs": ("curves", "hodographs"),
    "sphere": ("sphere", "draw"),
    "integrals": ("curves", "integrals"),
    "error": ("curves", "error"),
}
_PERIOD = {"omega": ("results", "period")}
_EVENTS = {"intervals": ("results", "intervals")}
#: Of each kind of result its figures, the first is the default.
FIGURES: Mapping[str, Mapping[str, tuple[str, str]]] = {
    "CertifiedEvents": _EVENTS,
    "ChaosMap": {word: ("results", word) for word in ("fli", "megno", "exponent", "verdict")},
    "Enclosure": {"digits": ("results", "proven")},
    "Ensemble": {"members": ("results", "members")},
    "EventTimes": _EVENTS,
    "Frequencies": {"lines": ("results", "lines")},
    "Judgement": {"digits": ("results", "digits")},
    "Levels": {"diagram": ("levels", "draw")},
    "Orbit": _PERIOD,
    "OrbitFamily": {"residue": ("results", "family")},
    "OrbitSearch": {"residue": ("results", "residues")},
    "ProvedChaos": {"chaos-proof": ("proofs", "chaos")},
    "ProvedOrbit": _PERIOD,
    "ProvedStability": {"curves": ("proofs", "stability")},
    "Reductions": {"kept": ("results", "reductions")},
    "ReferenceTable": {"omega": ("results", "reference")},
    "Section": {"crossings": ("results", "crossings")},
    "Trajectory": MOTION,
}
#: Those that show more of a result than its file has; the others are drawn as their files are.
LIVE = ("Frequencies", "Levels", "ProvedChaos")


def kind_of(subject: Storable | Samples) -> str:
    """The kind of a result, by whose name its figures are listed; samples are a run's."""
    if isinstance(subject, Samples):
        return "Trajectory"
    return subject.result if isinstance(subject, Saved) else subject.kind_of_file


def words(kind: str) -> tuple[str, ...]:
    """What may be drawn of a kind of result, the default first; empty where it has no figure."""
    return tuple(FIGURES.get(kind, ()))


def chosen(kind: str, figure: str | None, source: str = "plot") -> str:
    """A word of a kind's figures, unless given the default; raises BadInput for another."""
    figures = words(kind)
    if not figures:
        raise BadInput(source, "result", kind, "one that has a figure")
    if figure is not None and figure not in figures:
        raise BadInput(source, "--what", figure, nearest(figure, [*figures]))
    return figure or figures[0]


def draw(
    plt: Any,
    subject: Storable | Samples,
    axes: Any = None,
    what: str | None = None,
    *,
    title: str = "",
    **given_options: Any,
) -> Any:
    """Draw a result, or samples of a motion; raises BadInput for what it cannot show.

    ``axes``: to draw into.  ``title``: in place of the figure's own.  ``given_options``: of the
    figure; None is as not given.
    """
    kind = kind_of(subject)
    what = chosen(kind, what)
    if not isinstance(subject, (Samples, Saved)) and kind not in LIVE:
        subject = Saved(subject.content())
    module, name = FIGURES[kind][what]
    make: Callable[..., Any] = getattr(import_module(f"polhode.figures.{module}"), name)
    options = {key: value for key, value in given_options.items() if value is not None}
    names = [k for k, x in inspect.signature(make).parameters.items() if x.kind is x.KEYWORD_ONLY]
    for key, value in options.items():
        if key not in names:
            raise BadInput(f"plot {what}", key, value, nearest(key, [*names, "title"]))
    cmap = options.get("cmap")
    if cmap is not None and not hasattr(cmap, "resampled") and cmap not in plt.colormaps():
        expected = nearest(str(cmap), plt.colormaps())
        raise BadInput(f"plot {what}", "cmap", cmap, expected)
    figure = make(plt, subject, axes, **options)
    if title:
        panels = own_panels(figure) if axes is None else np.ravel(np.asarray(axes, dtype=object))
        several = axes is None and len(panels) > 1
        (figure.suptitle if several else panels[0].set_title)(title)
    return figure


def drawn(
    subject: Storable | Samples, suffix: str, of: str, what: str | None = None, **options: Any
) -> bytes:
    """The bytes of a figure as printed, by the ending of its file; they depend on nothing else.

    ``suffix``: .svg, .png or .pdf.  ``of``: whose it is.
    """
    what = chosen(kind_of(subject), what)
    title = printable(f"polhode: {what} of {of}")
    with canvas.paper() as plt:
        figure = draw(plt, subject, what=what, **options)
        if suffix == ".svg":
            return canvas.as_svg(figure, title).encode()
        metadata = {"Title": title} | ({"CreationDate": None} if suffix == ".pdf" else {})
        figure.savefig(out := BytesIO(), format=suffix[1:], dpi=300, metadata=metadata)
        plt.close(figure)
        return out.getvalue()


def own_panels(figure: Any) -> list[Any]:
    """The panels of a figure without its colour bars."""
    return [panel for panel in figure.axes if panel.get_label() != "<colorbar>"]

"""Figures and pages from Python: of a scene, a result, or the file of one."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from polhode.common.errors import BadInput
from polhode.common.texts import Page, together
from polhode.figures import canvas, catalogue, motion_page
from polhode.figures.motion_page import explained
from polhode.figures.samples import ANOTHER, Samples, of_samples
from polhode.figures.source import MOTION, Drawing, Request, Source, drawing_of
from polhode.judging.reference import reference as reference_of
from polhode.numbers.number_types import AnyNumber
from polhode.scenes.vocabulary import Several, Single

if TYPE_CHECKING:
    import numpy.typing as npt
    from matplotlib.axes import Axes

_REQUEST = [x.name for x in fields(Request)]


@overload
def plot(
    what_of: Source, what: Several, ax: object = None, **options: object
) -> npt.NDArray[np.object_]: ...
@overload
def plot(what_of: Source, what: Single, ax: object = None, **options: object) -> Axes: ...
@overload
def plot(
    what_of: Source, what: str | None = None, ax: object = None, **options: object
) -> Axes | npt.NDArray[np.object_]: ...
def plot(
    what_of: Source, what: str | None = None, ax: object = None, **options: object
) -> Axes | npt.NDArray[np.object_]:
    """Draw a figure with matplotlib; the colours of a style that is in use are taken.

    Parameters
    ----------
    what_of : Scene, str, Path or any result
        A scene; a run, whose scene is integrated anew in its number type at as many times as curves
        need; any other result; or the path of the file of one, or of a table as for
        :func:`polhode.compare`.
    what : str, optional
        Of a scene or a run: angles, omega, momentum, attitude, hodographs, sphere, integrals or
        error; of a map: fli, megno, exponent or verdict; any other result has one figure.  Unless
        given the first of these, of a motion omega into one pair of axes.
    ax : matplotlib axes, optional
        As many as the figure has panels, to draw into; new ones unless given.
    **options
        ``title``, in place of the figure's own.  Of a motion: ``end``, the last time drawn, in the
        scene's unit (unless given the scene's own, but no more than 100 radians; of integrals and
        error all), ``number``, ``digits``; of a table also ``scene``, ``read`` and ``columns``.  Of
        a map and an ensemble ``cmap``; of levels ``f_range`` and ``h_range``, two numbers each.

    Returns
    -------
    Axes or ndarray of Axes
        The axes drawn into, an array of them where there are several.

    Raises
    ------
    BadInput
        A figure that there is not, or that the scene cannot have.

    Examples
    --------
    >>> import polhode
    >>> panels = polhode.plot("lagrange/looping", "angles", end=4)
    >>> [panel.get_ylabel() for panel in panels]
    ['ψ (rad)', 'θ (rad)', 'φ (rad)']
    """
    plt = canvas.pyplot(own=False)
    drawn: dict[str, Any] = dict(options)
    request = {name: drawn.pop(name) for name in _REQUEST if name in options}
    usual = "omega" if hasattr(ax, "plot") else "angles"
    drawing = drawing_of(what_of, what, Request(**request), usual=usual)
    figure = catalogue.draw(plt, drawing.subject, ax, drawing.what, **drawn)
    panels = catalogue.own_panels(figure) if ax is None else ax
    several: npt.NDArray[np.object_] = np.ravel(np.asarray(panels, dtype=object))
    if len(several) != 1:
        return several
    only: Axes = several[0]
    return only


def view(
    what_of: Source,
    *others: Source,
    end: AnyNumber | None = None,
    title: str = "",
    text: str = "",
) -> Page:
    """Show a motion, or several, as one page that moves: no network, nothing else needed.

    Parameters
    ----------
    what_of : Scene, Trajectory, str or Path
        A scene, a run, or the file of a run.
    *others
        More of them, one below the other.
    end : number, optional
        The last time shown, as for :func:`polhode.plot`.
    title : str
        A heading above the motions.
    text : str
        Words below the heading, with empty lines between paragraphs.

    Returns
    -------
    Page
        A page of HTML, to be saved or shown in a notebook.

    Raises
    ------
    BadInput
        A scene that cannot be integrated.

    Examples
    --------
    >>> import polhode
    >>> polhode.view("euler/largest-axis").save("motion.html")  # doctest: +SKIP
    """
    every = [drawing_of(source, MOTION, Request(end=end)) for source in (what_of, *others)]
    pages = [Page(drawing.name, page_of(drawing, "polhode.view")) for drawing in every]
    return together(pages, title, text)


def page_of(drawing: Drawing, command: str) -> str:
    """The page of a motion in columns, a run's or a file's."""
    motion = of_samples(samples_of(drawing))
    scene = motion.scene
    origin = "Attitude and omega by heyoka's Taylor method, in double."
    if drawing.measured:
        origin = "Attitude and omega as the file has them."
    reference = reference_of(replace(scene, reference="auto"))
    title, regime = scene.title or scene.name, reference.regime
    words = explained(reference.kind, regime, scene)
    if drawing.measured and not motion.on_level():
        words = regime = ANOTHER
    return motion_page.page(motion, title, regime, words, origin, command)


def samples_of(drawing: Drawing) -> Samples:
    """The samples of a motion that is shown; raises BadInput where that is none."""
    if not isinstance(drawing.subject, Samples):
        raise BadInput(drawing.name, "--what", MOTION, "a scene, a run, or a table of a motion")
    return drawing.subject

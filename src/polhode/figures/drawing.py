"""Figures and pages from Python: of a scene, or of the scene of a run."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, overload

import numpy as np

from polhode.common.errors import BadInput, nearest
from polhode.common.html_page import Page
from polhode.figures import motion_page, results
from polhode.figures.canvas import canvas, curve_sampling, over_time
from polhode.figures.canvas.curve_sampling import Samples
from polhode.figures.explanations import explained
from polhode.figures.sampled_motion import ANOTHER, of_samples
from polhode.judging.references.reference import reference as reference_of
from polhode.numbers.exact import Exact
from polhode.numbers.scalars import AnyNumber
from polhode.results.result import Storable
from polhode.runs.trajectory import Trajectory
from polhode.scenes import library
from polhode.scenes.given_numbers import TIME, reader
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import Several, Single

if TYPE_CHECKING:
    import numpy.typing as npt
    from matplotlib.axes import Axes

#: The kinds of figures, and the outputs that a run for them needs.
OUTPUTS: dict[str, tuple[str, ...]] = {
    "angles": ("angles",),
    "omega": (),
    "momentum": (),
    "attitude": ("attitude",),
    "hodographs": ("attitude", "hodographs"),
    "sphere": ("attitude",),
    "integrals": (),
    "error": (),
}
OVER_TIME = ("integrals", "error")  # of the whole run: not cut to a window
FREE_OF_GAMMA = ("omega", "momentum", *OVER_TIME)


@overload
def plot(
    what_of: Trajectory | Scene | str | Path,
    what: Several = "angles",
    axes: object = None,
    *,
    end: AnyNumber | None = None,
) -> npt.NDArray[np.object_]: ...
@overload
def plot(
    what_of: Trajectory | Scene | str | Path,
    what: Single,
    axes: object = None,
    *,
    end: AnyNumber | None = None,
) -> Axes: ...
@overload
def plot(
    what_of: Storable | Scene | str | Path,
    what: str = "",
    axes: object = None,
    *,
    end: AnyNumber | None = None,
) -> Axes | npt.NDArray[np.object_]: ...
def plot(
    what_of: Storable | Scene | str | Path,
    what: str = "",
    axes: object = None,
    *,
    end: AnyNumber | None = None,
) -> Axes | npt.NDArray[np.object_]:
    """Draw a figure with matplotlib.

    Parameters
    ----------
    what_of : Result, Scene, str or Path
        A scene, or a run, whose scene is integrated anew in its number type at as many times as
        curves need; or any other result, which has one figure.
    what : str
        Of a scene or a run: angles, omega, momentum, attitude, hodographs, sphere, integrals or
        error; unless given angles, or omega into one pair of axes.
    axes : matplotlib axes, optional
        As many as the figure has panels, to draw into.
    end : number, optional
        The last time drawn, in the scene's unit; unless given the scene's own, but no more than 100
        radians (integrals and error: all).

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
    if isinstance(what_of, Storable) and not isinstance(what_of, Trajectory):
        if what or end is not None:
            raise BadInput("plot", "what", what or end, "nothing: such a result has one figure")
        figure = results.draw(plt, what_of, axes)
    else:
        what = what or ("omega" if hasattr(axes, "plot") else "angles")
        if what not in OUTPUTS:
            raise BadInput("plot", "what", what, nearest(what, [*OUTPUTS]))
        found = _samples(what_of, what, end)
        figure = import_module(f"polhode.figures.{what}").draw(plt, found, axes)
    own = [panel for panel in figure.axes if panel.get_label() != "<colorbar>"]
    made = own if axes is None else axes
    several: npt.NDArray[np.object_] = np.ravel(np.asarray(made, dtype=object))
    if len(several) != 1:
        return several
    only: Axes = several[0]
    return only


def view(what_of: Trajectory | Scene | str | Path, *, end: AnyNumber | None = None) -> Page:
    """Show a motion as one page that moves: no network, nothing else needed.

    Parameters
    ----------
    what_of : Trajectory, Scene, str or Path
        A scene, or a run.
    end : number, optional
        The last time shown, as for :func:`polhode.plot`.

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
    found = _samples(what_of, "sphere", end)
    return Page(found.name, page_of(found, "polhode.view"))


def page_of(found: Samples, command: str, measured: bool = False) -> str:
    """The page of a motion in columns; ``measured``: they are a file's, not a run's."""
    motion = of_samples(found)
    scene = motion.scene
    origin = (
        "Attitude and omega as the file has them."
        if measured
        else ("Attitude and omega by heyoka's Taylor method, in double.")
    )
    known = reference_of(replace(scene, reference="auto"))
    title, regime = scene.title or scene.name, known.regime
    words = explained(known.kind, regime, scene)
    if measured and not motion.on_level():
        words = regime = ANOTHER
    return motion_page.page(motion, title, regime, words, origin, command)


def _samples(what_of: Trajectory | Scene | str | Path, what: str, end: AnyNumber | None) -> Samples:
    run = what_of if isinstance(what_of, Trajectory) else None
    scene = run.scene if run is not None else library.load(what_of)  # type: ignore[arg-type]
    last: Exact | None = None
    if end is not None:
        try:
            last = reader(scene.units, TIME)(end)
        except ValueError as fault:
            raise BadInput(scene.name, "end", end, f"a time ({fault})") from None
    if scene.gamma is None and what not in FREE_OF_GAMMA:
        raise BadInput(scene.name, "what", what, "a scene with start.gamma")
    number = None if run is None else run.number
    long = what in OVER_TIME
    times = curve_sampling.shown_times(scene, last, over_time.SAMPLES if long else None)
    project = False if what == "integrals" else None
    found = curve_sampling.run(
        *(scene, times, OUTPUTS[what], number), project=project, interruptible=False
    )
    if not found.outcome.done:
        raise BadInput(scene.name, "end", float(times[-1]), f"an earlier end: {found.cause}")
    if what == "error":
        return over_time.errors_of_run(found, reference_of(scene))
    return over_time.departures_of_run(found) if long else curve_sampling.of_run(found)

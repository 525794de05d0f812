"""What results of lower rooms do by files and figures; each is imported when it is asked for."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes

    from polhode.common.html_page import Page
    from polhode.common.result import Result, ResultPresentation
    from polhode.numbers.rows import Reread
    from polhode.numbers.scalars import AnyNumber
    from polhode.runs.presentation import Reevaluation, RunPresentation
    from polhode.runs.trajectory import Trajectory
    from polhode.scenes.presentation import ScenePresentation
    from polhode.scenes.scene import Scene


class _Scenes:
    def html(self, scene: Scene, /) -> str:
        from polhode.output import notebook

        return notebook.of_scene(scene)


class _Results:
    def html(self, found: Result, /) -> str:
        from polhode.output import notebook

        return notebook.of_result(found)

    def save(self, found: Result, path: str | Path, /) -> None:
        from polhode.output.results import files

        files.save(found, path)

    def plot(self, found: Result, axes: object, /) -> Axes | npt.NDArray[np.object_]:
        from polhode.figures import drawing

        return drawing.plot(found, axes=axes)

    def to_pandas(self, found: Result, /) -> pd.DataFrame:
        from polhode.output.results import files

        return files.to_pandas(found)

    def to_xarray(self, found: Result, /) -> xr.Dataset:
        from polhode.output.results import files

        return files.to_xarray(found)


class _Runs:
    def plot(
        self, run: Trajectory, what: str, axes: object, end: AnyNumber | None, /
    ) -> Axes | npt.NDArray[np.object_]:
        from polhode.figures import drawing

        return drawing.plot(run, what, axes, end=end)

    def view(self, run: Trajectory, end: AnyNumber | None, /) -> Page:
        from polhode.figures import drawing

        return drawing.view(run, end=end)


class _Reevaluation:
    def at_times(self, run: Trajectory, what: str, t: AnyNumber | Iterable[AnyNumber], /) -> Reread:
        from polhode.runs import reevaluate

        return reevaluate.at_times(run, what, t)


SCENES: Final[ScenePresentation[Scene]] = _Scenes()
RESULTS: Final[ResultPresentation] = _Results()
RUNS: Final[RunPresentation[Trajectory]] = _Runs()
REEVALUATION: Final[Reevaluation[Trajectory]] = _Reevaluation()

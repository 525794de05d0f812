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
    from polhode.judging.presentation import JudgementPresentation
    from polhode.judging.score.judgement import Judgement
    from polhode.numbers.rows import Reread
    from polhode.numbers.scalars import AnyNumber
    from polhode.runs.presentation import EnsemblePresentation, Reevaluation, RunPresentation
    from polhode.runs.sweep.ensemble import Ensemble
    from polhode.runs.trajectory import Trajectory
    from polhode.scenes.presentation import ScenePresentation
    from polhode.scenes.scene import Scene


class _Scenes:
    def html(self, scene: Scene, /) -> str:
        from polhode.output import notebook

        return notebook.of_scene(scene)


class _Judgements:
    def html(self, judgement: Judgement, /) -> str:
        from polhode.output import notebook

        return notebook.of_judgement(judgement)


class _Ensembles:
    def html(self, found: Ensemble, /) -> str:
        from polhode.output import notebook

        return notebook.of_ensemble(found)

    def to_pandas(self, found: Ensemble, /) -> pd.DataFrame:
        from polhode.output import frames

        return frames.of_ensemble_pandas(found)

    def to_xarray(self, found: Ensemble, /) -> xr.Dataset:
        from polhode.output import frames

        dataset: xr.Dataset = frames.of_ensemble_xarray(found)
        return dataset


class _Runs:
    def html(self, run: Trajectory, /) -> str:
        from polhode.output import notebook

        return notebook.of_run(run)

    def to_pandas(self, run: Trajectory, /) -> pd.DataFrame:
        from polhode.output import frames

        return frames.of_run_pandas(run)

    def to_xarray(self, run: Trajectory, /) -> xr.Dataset:
        from polhode.output import frames

        dataset: xr.Dataset = frames.of_run_xarray(run)
        return dataset

    def plot(
        self, run: Trajectory, what: str, axes: object, end: AnyNumber | None, /
    ) -> Axes | npt.NDArray[np.object_]:
        from polhode.figures import drawing

        return drawing.plot(run, what, axes, end=end)

    def view(self, run: Trajectory, end: AnyNumber | None, /) -> Page:
        from polhode.figures import drawing

        return drawing.view(run, end=end)

    def save(self, run: Trajectory, path: str | Path, /) -> None:
        from polhode.output import archive

        archive.save(run, path)


class _Reevaluation:
    def at_times(self, run: Trajectory, what: str, t: AnyNumber | Iterable[AnyNumber], /) -> Reread:
        from polhode.runs import reevaluate

        return reevaluate.at_times(run, what, t)


SCENES: Final[ScenePresentation[Scene]] = _Scenes()
JUDGEMENTS: Final[JudgementPresentation[Judgement]] = _Judgements()
ENSEMBLES: Final[EnsemblePresentation[Ensemble]] = _Ensembles()
RUNS: Final[RunPresentation[Trajectory]] = _Runs()
REEVALUATION: Final[Reevaluation[Trajectory]] = _Reevaluation()

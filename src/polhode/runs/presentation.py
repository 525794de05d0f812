"""What higher rooms do for trajectories and ensembles: figures, files, tables."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from polhode.common.presentation import Slot

if TYPE_CHECKING:
    from pathlib import Path

    import numpy as np
    import numpy.typing as npt
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes

    from polhode.common.html_page import Page
    from polhode.numbers.rows import Rows
    from polhode.numbers.scalars import AnyNumber, Value
    from polhode.runs.sweep.ensemble import Ensemble
    from polhode.runs.trajectory import Trajectory


class EnsemblePresentation(Protocol):
    """An ensemble shown, and as tables of other packages."""

    def html(self, found: Ensemble, /) -> str:
        """What a notebook shows of it."""
        ...

    def to_pandas(self, found: Ensemble, /) -> pd.DataFrame:
        """A row a member and time."""
        ...

    def to_xarray(self, found: Ensemble, /) -> xr.Dataset:
        """A variable a column, along member and time."""
        ...


class RunPresentation(Protocol):
    """A trajectory shown, drawn, saved, and as tables of other packages."""

    def html(self, run: Trajectory, /) -> str:
        """What a notebook shows of it."""
        ...

    def to_pandas(self, run: Trajectory, /) -> pd.DataFrame:
        """A row a time."""
        ...

    def to_xarray(self, run: Trajectory, /) -> xr.Dataset:
        """A variable a column, along time."""
        ...

    def plot(
        self, run: Trajectory, what: str, axes: object, end: AnyNumber | None, /
    ) -> Axes | npt.NDArray[np.object_]:
        """Draw a figure of it: the axes drawn into."""
        ...

    def view(self, run: Trajectory, end: AnyNumber | None, /) -> Page:
        """A page on which it moves."""
        ...

    def save(self, run: Trajectory, path: str | Path, /) -> None:
        """Write it to a file that loads again."""
        ...


class Reevaluation(Protocol):
    """A trajectory made once more: what makes one is above it, too."""

    def at_times(self, run: Trajectory, what: str, t: Value, /) -> Rows:
        """Angles or attitude at time t, or rows of them."""
        ...


RUNS: Slot[RunPresentation] = Slot()
ENSEMBLES: Slot[EnsemblePresentation] = Slot()
REEVALUATION: Slot[Reevaluation] = Slot()

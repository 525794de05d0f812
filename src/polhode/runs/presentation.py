"""What higher rooms do for trajectories and ensembles: figures, files, tables."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Protocol, TypeVar

if TYPE_CHECKING:
    from pathlib import Path

    import numpy as np
    import numpy.typing as npt
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes

    from polhode.common.html_page import Page
    from polhode.numbers.rows import Reread
    from polhode.numbers.scalars import AnyNumber

R_contra = TypeVar("R_contra", contravariant=True)


class EnsemblePresentation(Protocol[R_contra]):
    """An ensemble shown, and as tables of other packages."""

    def html(self, found: R_contra, /) -> str:
        """What a notebook shows of it."""
        ...

    def to_pandas(self, found: R_contra, /) -> pd.DataFrame:
        """A row a member and time."""
        ...

    def to_xarray(self, found: R_contra, /) -> xr.Dataset:
        """A variable a column, along member and time."""
        ...


class RunPresentation(Protocol[R_contra]):
    """A trajectory shown, drawn, saved, and as tables of other packages."""

    def html(self, run: R_contra, /) -> str:
        """What a notebook shows of it."""
        ...

    def to_pandas(self, run: R_contra, /) -> pd.DataFrame:
        """A row a time."""
        ...

    def to_xarray(self, run: R_contra, /) -> xr.Dataset:
        """A variable a column, along time."""
        ...

    def plot(
        self, run: R_contra, what: str, axes: object, end: AnyNumber | None, /
    ) -> Axes | npt.NDArray[np.object_]:
        """Draw a figure of it: the axes drawn into."""
        ...

    def view(self, run: R_contra, end: AnyNumber | None, /) -> Page:
        """A page on which it moves."""
        ...

    def save(self, run: R_contra, path: str | Path, /) -> None:
        """Write it to a file that loads again."""
        ...


class Reevaluation(Protocol[R_contra]):
    """A trajectory made once more: what makes one is above it, too."""

    def at_times(self, run: R_contra, what: str, t: AnyNumber | Iterable[AnyNumber], /) -> Reread:
        """Angles or attitude at time t, or rows of them."""
        ...

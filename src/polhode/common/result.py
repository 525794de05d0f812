"""What every result does: it saves itself, draws itself, and becomes a table of other packages.

What does this lies on higher floors: it is imported when it is called, and ``pyproject.toml``
names each of these imports among what the contracts of import-linter ignore.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes


class Result:
    """The base class of results, which are all saved, drawn and tabulated in the same way.

    >>> import os, tempfile, polhode
    >>> found = polhode.reference(polhode.load("euler/largest-axis").at([1, 2]))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     found.save(os.path.join(folder, "lines.csv"))
    ...     again = polhode.load_result(os.path.join(folder, "lines.csv"))
    >>> again == found
    True
    """

    def save(self, path: str | Path) -> None:
        """Write the result to a file, which :func:`polhode.load_result` reads again.

        Parameters
        ----------
        path : str or Path
            Its ending says how: ``.csv``, with a JSON file beside it, ``.json``, ``.npz`` or
            ``.parquet`` (needs pandas and pyarrow).  Written whole or not at all.

        Raises
        ------
        BadInput
            Another ending, a place that cannot be written to, or a file there that is no result of
            this kind: it is not overwritten.
        """
        from polhode.output.results import files

        files.save(self, path)

    def plot(self, ax: object = None) -> Axes | npt.NDArray[np.object_]:
        """Draw the result with matplotlib.

        Parameters
        ----------
        ax : matplotlib axes, optional
            To draw into, as many as the figure has panels; new ones unless given.

        Returns
        -------
        Axes or ndarray of Axes
            The axes drawn into, an array of them where there are several.
        """
        from polhode.figures import drawing

        return drawing.plot(self, axes=ax)

    def to_pandas(self) -> pd.DataFrame:
        """Give the table that a CSV file has as a pandas DataFrame (extra ``polhode[frames]``)."""
        from polhode.output.results import files

        return files.to_pandas(self)

    def to_xarray(self) -> xr.Dataset:
        """Give that table as an xarray Dataset along its index (extra ``polhode[frames]``)."""
        from polhode.output.results import files

        return files.to_xarray(self)

    def _repr_html_(self) -> str:
        from polhode.output import notebook

        return notebook.of_result(self)

"""What every result does: it tells its table and facts, and is saved, drawn and tabulated by them.

What draws lies on a higher floor: a result asks the package for the public function by its name.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from polhode.common.arguments import of_kind
from polhode.common.errors import BadInput, nearest
from polhode.common.files import write_whole
from polhode.common.provenance import __version__
from polhode.results.table import Content, Fact, Table, Value, Values

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes


class Storable:
    """What is saved, drawn and tabulated by its content: results, and what makes one when asked."""

    @property
    def kind_of_file(self) -> str:
        """The kind of the result that a file of it holds."""
        return type(self).__name__

    def content(self) -> Content:
        """What a file of it holds."""
        raise NotImplementedError

    def save(self, path: str | Path) -> None:
        """Write the result to a file, which :func:`polhode.load_result` reads again.

        Parameters
        ----------
        path : str or Path
            Its ending says how: ``.csv``, the table alone, with the facts beside it in a file whose
            name has ``.json`` added; ``.json``, ``.npz`` or ``.parquet`` (needs pyarrow).  Written
            whole or not at all; the same result gives the same bytes.

        Raises
        ------
        BadInput
            Another ending, a place that cannot be written to, or a file there that is no result of
            this kind, or was changed since: it is not replaced.
        """
        from polhode.results import reader, writer

        of_kind("save", "path", path, (str, Path), "the path of a file")
        path, content = Path(path), self.content()
        reader.check_place(path, content.kind)
        write_whole(writer.files(content, path))

    def plot(
        self, what: str | None = None, ax: object = None, **options: object
    ) -> Axes | npt.NDArray[np.object_]:
        """Draw the result with matplotlib, see :func:`polhode.plot`.

        Parameters
        ----------
        what : str, optional
            Which of its figures; the first of its kind unless given.
        ax : matplotlib axes, optional
            To draw into, as many as the figure has panels; new ones unless given.
        **options
            Of the figure, such as ``title``, ``cmap``, and ``end`` of a run.

        Returns
        -------
        Axes or ndarray of Axes
            The axes drawn into, an array of them where there are several.
        """
        import polhode

        return polhode.plot(self, what, ax, **options)

    def to_json(self) -> str:
        """Give the text of a JSON file: facts by name, and columns under ``columns``.

        >>> import json, polhode
        >>> run = polhode.integrate("lagrange/nutation", at=[1, 2])
        >>> told = json.loads(run.to_json())
        >>> told["outcome"], told["columns"]["t"]
        ('reached end', [1.0, 2.0])
        """
        from polhode.common.texts import as_json
        from polhode.results import writer

        return as_json(writer.document(self.content(), columns=True))

    def to_pandas(self) -> pd.DataFrame:
        """Give the table as a pandas DataFrame, the facts as its ``attrs``.

        Needs the extra ``polhode[frames]``.  Columns that tell the rows apart are the index; exact
        numbers are doubles there.
        """
        from polhode.results import writer

        return writer.to_pandas(self.content())

    def to_xarray(self) -> xr.Dataset:
        """Give the table as an xarray Dataset along its index (extra ``polhode[frames]``)."""
        from polhode.results import writer

        return writer.to_xarray(self.content())

    def _repr_html_(self) -> str:
        from polhode.results import cells

        return cells.to_html(repr(self), str(self), getattr(self, "table", None))


class Result(Storable):
    """The base class of results, which are all saved, drawn and tabulated in the same way.

    Every kind tells its :meth:`table` and its :meth:`facts`; files of all endings, JSON, pandas and
    xarray have these columns and facts, by the same names.

    >>> import os, tempfile, polhode
    >>> run = polhode.integrate("lagrange/nutation", at=[1, 2])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run.save(os.path.join(folder, "run.csv"))
    ...     again = polhode.load_result(os.path.join(folder, "run.csv"))
    >>> again == run, run.fact("number")
    (True, 'double')
    """

    def table(self) -> Table:
        """The table of the result: its columns, no rows where there is nothing to list."""
        raise NotImplementedError

    def facts(self) -> Sequence[Fact]:
        """What the result is, number by number: the scene first, the provenance last."""
        raise NotImplementedError

    def content(self) -> Content:
        """What a file of the result holds."""
        from polhode.results.writer import written_facts, written_table

        kind, facts = type(self).__name__, tuple(written_facts(self.facts()))
        return Content(kind, __version__, repr(self), written_table(self.table()), facts)

    def column(self, name: str) -> Values:
        """The values of a column of the table; raises BadInput for another name.

        >>> import polhode
        >>> polhode.integrate("lagrange/nutation", at=[1, 2]).column("t").tolist()
        [1.0, 2.0]
        """
        columns = {x.name: x.values for x in self.table().columns}
        if name not in columns:
            raise BadInput(type(self).__name__, "column", name, nearest(name, [*columns]))
        return columns[name]

    def fact(self, name: str) -> Value:
        """The value of a fact; raises BadInput for another name."""
        facts = {x.name: x.value for x in self.facts()}
        if name not in facts:
            raise BadInput(type(self).__name__, "fact", name, nearest(name, [*facts]))
        return facts[name]

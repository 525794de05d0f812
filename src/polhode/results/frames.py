"""Results as tables of other packages: pandas DataFrames and xarray Datasets."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Irrational
from polhode.results.cells import DOUBLE, doubles, word_of
from polhode.results.packages import needed
from polhode.results.table import Column, Content, Table

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


def to_pandas(content: Content) -> pd.DataFrame:
    """A DataFrame whose index are the labels; exact numbers are doubles there.

    ``attrs`` has the facts that are no tables.
    """
    pandas = needed("pandas")
    table = content.table
    frame = pandas.DataFrame({x.name: _values(x) for x in table.columns})
    if table.labels:
        frame = frame.set_index([x.name for x in table.columns[: table.labels]])
    frame.attrs = {x.name: x.value for x in content.facts if not isinstance(x.value, Table)}
    return frame


def to_xarray(content: Content) -> xr.Dataset:
    """A Dataset along the labels."""
    needed("xarray")
    frame = to_pandas(content)
    dataset: xr.Dataset = frame.to_xarray()
    return dataset.assign_attrs(frame.attrs)


def _values(column: Column) -> Any:
    if word_of(column) == DOUBLE:
        return doubles(column.values)
    values = column.values
    if any(isinstance(x, (Fraction, Irrational)) for x in values):
        return np.array([np.nan if x is None else to_double(x) for x in values])
    return values if isinstance(values, np.ndarray) else list(values)

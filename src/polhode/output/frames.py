"""Results as tables of other packages: pandas DataFrames and xarray Datasets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from polhode.common.errors import BadInput
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Exact
from polhode.numbers.rows import Stack
from polhode.output.sweeps import spread
from polhode.scenes.vocabulary import COLUMNS

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from polhode.runs.sweep.ensemble import Ensemble
    from polhode.runs.trajectory import Trajectory


def columns(run: Trajectory) -> dict[str, Stack]:
    """A run's columns by name: numbers of its type (mpf in arrays of objects), nan undefined."""
    return {name: run[name] for names, _ in run.named for name in names}


def of_run_pandas(run: Trajectory) -> pd.DataFrame:
    """A DataFrame: a row a time, its index t in doubles."""
    pandas = needed("pandas")
    index = pandas.Index(run.t, name="t")
    found = pandas.DataFrame(columns(run), index=index)
    found.attrs.update(_about(run), outcome=run.outcome.value)
    return found


def of_run_xarray(run: Trajectory) -> xr.Dataset:
    """A Dataset: a variable a column along t, in doubles."""
    xarray = needed("xarray")
    data = {name: ("t", values) for name, values in columns(run).items()}
    dataset: xr.Dataset = xarray.Dataset(
        data, {"t": run.t}, _about(run) | {"outcome": run.outcome.value}
    )
    return dataset


def of_ensemble_xarray(found: Ensemble) -> xr.Dataset:
    """A Dataset: a variable a column along member and t; what is varied, outcomes and steps."""
    xarray = needed("xarray")
    parts = [(found.columns, found.states)]
    parts += [(COLUMNS[word].names, rows) for word, rows in found.outputs.items()]
    data: dict[str, Any] = {
        name: (("member", "t"), np.asarray(rows)[..., k])
        for names, rows in parts
        for k, name in enumerate(names)
    }
    values = spread(found.varied, to_double)
    for k, key in enumerate(found.varied.keys):
        data[key] = ("member", values[:, k])
    data["outcome"] = ("member", [outcome.value for outcome in found.outcomes])
    data["steps"] = ("member", list(found.steps))
    t = [to_double(t) for t in found.times]
    coordinates = {"member": np.arange(1, len(found) + 1), "t": t}
    made: xr.Dataset = xarray.Dataset(data, coordinates, _about(found)).set_coords(
        list(found.varied.keys)
    )
    return made


def of_ensemble_pandas(found: Ensemble) -> pd.DataFrame:
    """A DataFrame: a row a member and time, indexed by both; what is varied in columns."""
    dataset = of_ensemble_xarray(found).drop_vars(["outcome", "steps"])
    outputs = [name for word in found.outputs for name in COLUMNS[word].names]
    return dataset.to_dataframe()[[*found.varied.keys, *found.columns, *outputs]]


def of_columns(columns: Mapping[str, Sequence[Any]], labels: int) -> pd.DataFrame:
    """A DataFrame whose first columns are its index; exact numbers are doubles there."""
    pandas = needed("pandas")
    frame = pandas.DataFrame({name: _column(x) for name, x in columns.items()})
    return frame.set_index([*columns][:labels])


def _column(values: Sequence[Any]) -> Any:
    if any(isinstance(x, (Fraction, Exact)) for x in values):
        return [to_double(x) for x in values]
    return np.asarray(values) if not isinstance(values, np.ndarray) else values


def _about(found: Trajectory | Ensemble) -> dict[str, object]:
    return {"scene": found.scene.name, "number": found.number.name, "bits": found.number.bits}


def needed(package: str) -> ModuleType:
    """A package that not everybody has; raises BadInput where it is missing."""
    try:
        return import_module(package)
    except ImportError:
        expected = f"{package}, which this needs: pip install 'polhode[frames]'"
        raise BadInput("polhode", package, None, expected) from None

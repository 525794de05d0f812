"""Results as tables of other packages: pandas DataFrames and xarray Datasets."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from polhode.common.errors import BadInput
from polhode.numbers.conversion import to_double
from polhode.numbers.decimals import Ball
from polhode.numbers.exact import Irrational
from polhode.results.cells import DOUBLE, EXACT, doubles, word_of
from polhode.results.table import Column, Content, Fact, Table, Values

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


# --- packages -------------------------------------------------------------------------------------
#
# Packages that not everybody has.


def needed(package: str, source: str = "tables") -> ModuleType:
    """A package by its name; raises BadInput, for ``source``, where it is missing."""
    try:
        return import_module(package)
    except ImportError:
        name = package.partition(".")[0]
        expected = f"it to be installed: pip install {name}"
        if name in ("pandas", "xarray"):
            expected = "it to be installed: pip install 'polhode[frames]'"
        raise BadInput(source, name, None, expected) from None


# --- frames ---------------------------------------------------------------------------------------


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


# --- ball columns ---------------------------------------------------------------------------------
#
# Balls as two columns or facts: a decimal, and the radius of a ball around it that holds them.


def written_table(table: Table) -> Table:
    """A table with two columns for each of balls: the radii come after all others."""
    columns, radii = [], []
    for column in table.columns:
        if not _is_of_balls(column.values):
            columns.append(column)
            continue
        pairs = [*map(_decimals, column.values)]
        columns.append(column._replace(values=[x for x, _ in pairs], type=EXACT))
        values = [radius for _, radius in pairs]
        name = f"{column.name}_radius"
        radii.append(Column(name, values, "proven bound", column.unit, DOUBLE, digits=0))
    return Table([*columns, *radii], table.labels)


def written_facts(facts: Sequence[Fact]) -> Iterator[Fact]:
    """Facts with two for each ball, and for each list of balls."""
    for fact in facts:
        value = fact.value
        if isinstance(value, Table):
            yield fact._replace(value=written_table(value))
        elif isinstance(value, Ball):
            centre, radius = _decimals(value)
            yield fact._replace(value=centre, type=EXACT)
            yield Fact(f"{fact.name}_radius", radius, "proven bound", fact.unit, DOUBLE)
        else:
            yield fact


def _is_of_balls(values: Values) -> bool:
    return isinstance(values, (list, tuple)) and any(isinstance(x, Ball) for x in values)


def _decimals(ball: Ball | None) -> tuple[Fraction | None, float | None]:
    """The midpoint that is written, and a radius around that very number."""
    if ball is None:
        return None, None
    if not math.isfinite(ball.radius):
        return Fraction(round(ball.centre)), math.inf
    middle, radius = ball.decimals
    return Fraction(middle), float(radius)

"""Balls as two columns or facts: a decimal, and the radius of a ball around it that holds them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction

from polhode.numbers.balls import Ball
from polhode.results.cells import DOUBLE, EXACT
from polhode.results.table import Column, Fact, Table, Values


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

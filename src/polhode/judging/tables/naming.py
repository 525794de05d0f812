"""Columns that were named beside a table: all of them in order, or what single names mean."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

from polhode.common.errors import BadInput, nearest
from polhode.judging.tables.column_aliases import UNKNOWN, Column, columns, readable
from polhode.numbers import expression
from polhode.numbers.expression import ExpressionError


@dataclass(frozen=True)
class Naming:
    """Columns that were named beside a table.

    ``header``: all of them in order, empty where the table has its own.  ``meant``: what single
    names of its header mean.
    """

    header: tuple[str, ...] = ()
    meant: Mapping[str, Column] = field(default_factory=dict)

    def columns(self, header: Sequence[str]) -> list[Column]:
        """What the names of a header mean; a column that was told is no other one of the header."""
        told = {one.name for one in self.meant.values()}
        others = [UNKNOWN if one.name in told else one for one in columns(header)]
        return [self.meant.get(name, one) for name, one in zip(header, others, strict=True)]


PLAIN = Naming()  # nothing was named


def naming(text: str) -> Naming:
    """The columns of ``--columns``: ``t,qw,qx``, or ``time_ms=t*1e-3, Q.W=q0``; raises BadInput."""
    items = [item.strip() for item in text.split(",")]
    if not any("=" in item for item in items):
        return Naming(tuple(items))
    meant = {}
    for item in items:
        name, _, told = (part.strip() for part in item.partition("="))
        ours, _, by = (part.strip() for part in told.partition("*"))
        sign, ours = (-1, ours[1:].strip()) if ours.startswith("-") else (1, ours)
        if not name or ours not in readable():
            expected = f"NAME=COLUMN, of {nearest(ours, readable())}"
            raise BadInput("compare", "--columns", item, expected)
        try:
            factor = sign * (expression.decimal(by) if by else Fraction(1))
        except ExpressionError as fault:
            raise BadInput("compare", "--columns", item, f"NAME=COLUMN*NUMBER ({fault})") from None
        meant[name] = Column(ours, False, factor)
    return Naming((), meant)

"""Tangents along motions of the principal form, whose coefficients are parameters: u' = J(x) u."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import heyoka as hy

from polhode.equations.forms import principal
from polhode.scenes.vocabulary import STATE
from polhode.taylor.backend.heyoka_numbers import EXPRESSIONS
from polhode.taylor.backend.types import Expression

#: Variables and their rates, as heyoka takes them.
Equations: TypeAlias = list[tuple[Expression, Expression]]


def motion(names: Sequence[str]) -> Equations:
    """The equations of the state, the parameters its coefficients of these names."""
    x, k = hy.make_vars(*STATE), {name: hy.par[i] for i, name in enumerate(names)}
    return list(zip(x, principal.field(x, k, EXPRESSIONS), strict=True))


def tangents(of: Equations, names: Sequence[Sequence[str]]) -> Equations:
    """The equations of tangents, a list of names each, by symbolic differentiation."""
    jacobian = [[hy.diff(rate, x) for x, _ in of] for _, rate in of]
    found: Equations = []
    for own in names:
        u = hy.make_vars(*own)
        found += [(x, _product(row, u)) for x, row in zip(u, jacobian, strict=True)]
    return found


def numbered(count: int) -> list[list[str]]:
    """Names for so many tangents."""
    return [[f"{name}_{k}" for name in STATE] for k in range(count)]


def _product(row: Sequence[Expression], u: Sequence[Expression]) -> Expression:
    """A row of the Jacobian times a tangent; an entry that is zero is no term."""
    return hy.sum([a * b for a, b in zip(row, u, strict=True) if a != EXPRESSIONS.zero])

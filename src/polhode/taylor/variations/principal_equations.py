"""Motions of the principal form, coefficients as parameters, and their tangents: u' = J(x) u."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TypeAlias

from polhode.equations.forms import principal
from polhode.numbers.number_types import DOUBLE, NumberType
from polhode.scenes.vocabulary import STATE
from polhode.taylor.backend.engine import hy
from polhode.taylor.backend.heyoka_numbers import (
    EXPRESSIONS,
    array,
    disk_cache,
    scalars,
    type_options,
)
from polhode.taylor.backend.integrator_pool import Kind
from polhode.taylor.backend.types import Expression, HeyokaIntegrator
from polhode.taylor.integrator.prepared import Prepared

#: Variables and their rates, as heyoka takes them.
Equations: TypeAlias = list[tuple[Expression, Expression]]


#: Of all that follow a motion one by one: flows, starts of refinements.
MOTIONS: Kind[HeyokaIntegrator] = Kind(8)


def prepared(names: tuple[str, ...], number: NumberType = DOUBLE, count: int = 0) -> Prepared:
    """An integrator of a motion and so many tangents to it; see :func:`motion`."""
    key = names, number, count
    return Prepared(MOTIONS, key, lambda: _built(*key), number)


def _built(names: tuple[str, ...], number: NumberType, count: int) -> HeyokaIntegrator:
    system = motion(names)
    system += tangents(system, numbered(count))
    state, pars = (
        array(scalars([Fraction(0)] * n, number), number) for n in (len(system), len(names))
    )
    options = type_options(number) | ({"compact_mode": True} if count else {})
    with disk_cache(number):
        return hy.taylor_adaptive(system, state, pars=pars, **options)


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

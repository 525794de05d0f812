"""The equations that compiled code is of, by value, and the one builder of heyoka's integrators.

In the principal form the coefficients of the body are heyoka's parameters, so that one compiled
integrator serves all bodies of a pattern: those of which the same coefficients are exactly zero.
Compiling takes a quarter of a second, being found on the disk some milliseconds; a step takes as
long as with constants.  Coefficients that are equal, 1 or -1 make no pattern of their own.

Variables that the equations keep, such as the spin of a symmetric body, stand in the rates as
parameters, too: what they are multiplied by is then linear in the others, and heyoka need not
multiply two power series.  That takes a tenth off a step in double, a third in quad.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from fractions import Fraction
from typing import Any, TypeAlias, TypeVar

import numpy as np

from polhode.common.values import cached_property
from polhode.equations.forms import principal
from polhode.numbers.number_types import DOUBLE, NumberType
from polhode.taylor.backend.engine import hy
from polhode.taylor.backend.heyoka_numbers import (
    EXPRESSIONS,
    array,
    compact_beyond,
    disk_cache,
    scalar,
    type_options,
)
from polhode.taylor.backend.protocols import Rates, Watcher
from polhode.taylor.backend.types import Expression, HeyokaIntegrator
from polhode.taylor.integrator.angle_variables import slowed
from polhode.taylor.integrator.engine import Engine, lent
from polhode.taylor.integrator.singularities import terminal_event

#: Rates of variables, by the coefficients.
Field: TypeAlias = Callable[[Sequence[Expression], Mapping[str, Expression]], list[Expression]]
E = TypeVar("E", bound=Engine)

#: heyoka's parameters: so many for the time of events and their first step, one for each event,
#: then the coefficients of the pattern, then the variables that are kept.  Without events the
#: coefficients are the first.
CLOCK = 3
#: Added to all that heyoka watches, during the first step of a run.
TINY = 2
#: Before the coefficients among the parameters of a desk's functions: two parts of the time.
DESK = 2

LONG = 500  # operations of a run's events whose code is compiled as loops


@dataclass(frozen=True)
class Equations:
    """What tells compiled code from any other, without its events.

    ``columns``: the variables, ``cyclic`` of the last ones being cyclic, see
    :mod:`polhode.taylor.integrator.angle_variables`.  ``pattern``: the coefficients that are
    parameters.  ``constants``: those of a form whose coefficients are none.  ``still``: no rate but
    zero.  ``lanes``: of a batch, 0 for one motion.  ``tangents``: so many columns u with
    u' = J(x) u follow the state; of the last ``driven`` of them the rate of the state by
    coefficients of their own is added, which stand behind the first ones.
    """

    columns: tuple[str, ...]
    pattern: tuple[str, ...]
    number: NumberType = DOUBLE
    tolerance: Fraction | None = None
    form: str = "principal"
    constants: tuple[tuple[str, Fraction], ...] = ()
    still: bool = False
    cyclic: int = 0
    lanes: int = 0
    tangents: int = 0
    driven: int = 0

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        return hash(tuple(getattr(self, field.name) for field in fields(self)))

    def coefficients(self, first: int) -> dict[str, Expression]:
        """Parameters from a first one on, or constants."""
        named = {name: hy.par[i] for i, name in enumerate(self.pattern, first)}
        for name, x in self.constants:
            named[name] = hy.expression(scalar(x, self.number))
        return named


def principal_engine(equations: Equations, kind: type[E]) -> E:
    """An engine of the principal form, from the pool or built; where it stands is anybody's."""
    return lent(equations, lambda: built(equations, kind))


def built(
    equations: Equations,
    kind: type[E],
    system: Rates | None = None,
    watcher: Watcher | None = None,
) -> E:
    """An engine of equations, ``system``'s where they are not the principal form alone."""
    number, options, desk = equations.number, dict[str, Any](), None
    x = hy.make_vars(*equations.columns)
    first = 0 if watcher is None else CLOCK + len(watcher.damping)
    pattern, k = equations.pattern, equations.coefficients(first)

    def field(state: Sequence[Expression], numbers: Mapping[str, Expression]) -> list[Expression]:
        if system is None:
            rates = principal.field(state, numbers, EXPRESSIONS)
        else:
            rates = system.field(state, numbers, EXPRESSIONS)
        return slowed(rates, equations.cyclic, number)

    rates, kept = field(x, k), tuple[int, ...]()
    stepped = list(zip(x, rates, strict=True))
    if equations.tangents:
        stepped += _tangents(equations, field, x, rates)
        options["compact_mode"] = not equations.lanes or equations.tangents > 1
    else:
        kept = tuple(i for i, rate in enumerate(rates) if rate == EXPRESSIONS.zero)
        inside = list(x)
        for parameter, column in enumerate(kept, first + len(pattern)):
            inside[column] = hy.par[parameter]
        stepped = list(zip(x, field(inside, k) if kept else rates, strict=True))
    if equations.tolerance is not None:
        options["tol"] = scalar(equations.tolerance, number)
    with disk_cache(number):
        if watcher is not None:
            parameters = {name: hy.par[i] for i, name in enumerate(pattern, DESK)}
            events, desk = watcher.attach(x, rates, parameters)
            options["nt_events"] = events
            options |= compact_beyond(LONG, [event.expression for event in events])
        if system is not None:
            form = system.form
            away = form.distance(x[: len(form.variables)], k, EXPRESSIONS)
            if away is not None:
                options["t_events"] = [terminal_event(away, number)]
        heyoka = integrator(stepped, number, equations.lanes, **options)
    count = len(pattern) * (1 + equations.driven)
    return kind(heyoka, number, first, count, kept, desk)


def integrator(
    system: Sequence[tuple[Expression, Expression]],
    number: NumberType = DOUBLE,
    lanes: int = 0,
    **options: Any,
) -> HeyokaIntegrator:
    """heyoka's integrator of variables and their rates, at zero; nothing else makes any."""
    options, equations = type_options(number) | options, list(system)
    with disk_cache(number):
        if lanes:
            return hy.taylor_adaptive_batch(equations, np.zeros((len(equations), lanes)), **options)
        zeros = [scalar(Fraction(0), number)] * len(equations)
        return hy.taylor_adaptive(equations, array(zeros, number), **options)


def _tangents(
    of: Equations, field: Field, x: Sequence[Expression], rates: Sequence[Expression]
) -> list[tuple[Expression, Expression]]:
    """Variables and rates of tangents, by symbolic differentiation."""
    jacobian = [[hy.diff(rate, variable) for variable in x] for rate in rates]
    found = []
    for j in range(of.tangents):
        u = hy.make_vars(*(f"{name}_{j}" for name in of.columns))
        along = [_product(row, u) for row in jacobian]
        drive = j - (of.tangents - of.driven)
        if drive >= 0:
            numbers = of.coefficients((1 + drive) * len(of.pattern))
            driven = field(x, numbers)
            for i in range(len("pqr")):  # gamma' has no coefficients
                along[i] = along[i] + driven[i]
        found += list(zip(u, along, strict=True))
    return found


def _product(row: Sequence[Expression], u: Sequence[Expression]) -> Expression:
    """A row of the Jacobian times a tangent; an entry that is zero is no term."""
    return hy.sum([a * b for a, b in zip(row, u, strict=True) if a != EXPRESSIONS.zero])

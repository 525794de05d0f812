"""What an integrator is built from, and heyoka's integrator of it.

In the principal form the coefficients of the body are heyoka's parameters, so that one compiled
integrator serves all bodies of a pattern: those of which the same coefficients are exactly zero.
Compiling takes a quarter of a second, being found on the disk some milliseconds; a step takes as
long as with constants.  Coefficients that are equal, 1 or -1 make no pattern of their own.

Variables that the equations keep, such as the spin of a symmetric body, stand in the rates as
parameters, too: what they are multiplied by is then linear in the others, and heyoka need not
multiply two power series.  That takes a tenth off a step in double, a third in quad.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias

from polhode.common.cached_property import cached_property
from polhode.numbers.exact import Number
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Array
from polhode.taylor.backend.engine import hy
from polhode.taylor.backend.heyoka_numbers import (
    EXPRESSIONS,
    array,
    compact_beyond,
    disk_cache,
    scalar,
    scalars,
    type_options,
)
from polhode.taylor.backend.types import Expression, HeyokaIntegrator, HeyokaNumber
from polhode.taylor.integrator.angle_variables import Cyclic
from polhode.taylor.integrator.protocols import Desk, Watcher
from polhode.taylor.integrator.singularities import terminal_event

#: Expressions in variables and coefficients: the rates, or a distance.
Field: TypeAlias = Callable[[Sequence[Expression], Mapping[str, Expression]], list[Expression]]
Distance: TypeAlias = Callable[[Sequence[Expression], Mapping[str, Expression]], Expression | None]

#: heyoka's parameters: so many for the time of events and their first step, one for each event,
#: then the coefficients of the pattern, then the variables that are kept.
CLOCK = 3
#: Added to all that heyoka watches, during the first step of a run.
TINY = 2

LONG = 500  # operations of a run's events whose code is compiled as loops


@dataclass(frozen=True)
class Blueprint:
    """What an integrator of one autonomous system is built from, in one number type.  Immutable.

    ``field``: rates from a list of variables and the coefficients.  ``distance``, of the variables
    and the coefficients, ends a run where it falls to
    :func:`polhode.taylor.integrator.singularities.nearest`.
    ``cyclic``: so many of the last variables are cyclic, see
    :mod:`polhode.taylor.integrator.angle_variables`.
    ``equations``: what tells this field from others of the same names of variables and
    coefficients, where it is of the principal form; its coefficients are then parameters, and an
    integrator of the same equations that is idle is taken up again.
    """

    names: Sequence[str]
    field: Field
    coefficients: Mapping[str, Number]
    start: Sequence[Number]
    number: NumberType
    tolerance: Number | None = None
    distance: Distance | None = None
    equations: Hashable = None
    cyclic: int = 0

    @cached_property
    def state(self) -> Array:
        """The start as heyoka's numbers, cyclic variables at zero; raises OutOfRange."""
        first = len(self.start) - self.cyclic
        values = [*self.start[:first], *[Fraction(0)] * self.cyclic]
        return array(scalars(values, self.number), self.number)

    @cached_property
    def constants(self) -> list[HeyokaNumber]:
        """The coefficients as heyoka's numbers; raises OutOfRange."""
        return scalars([*self.coefficients.values()], self.number)

    @property
    def pattern(self) -> tuple[str, ...]:
        """The coefficients that are parameters: those of the principal form that do not vanish."""
        return () if self.equations is None else tuple(self.coefficients)

    @cached_property
    def parameters(self) -> Array:
        """The coefficients as an array of heyoka's numbers, not to be written to."""
        return array(self.constants, self.number)

    @cached_property
    def options(self) -> dict[str, Any]:
        """heyoka's options of an integrator without events."""
        found = type_options(self.number)
        if self.tolerance is not None:
            found["tol"] = scalar(self.tolerance, self.number)
        return found

    @cached_property
    def key(self) -> Hashable:
        """What an idle integrator of these equations is found by; None where none is kept."""
        if self.equations is None:
            return None
        return (self.equations, *self.names, *self.pattern, self.number, self.tolerance)


class Built(NamedTuple):
    """heyoka's integrator, the desk of its events, and what its parameters are.

    ``first``: the first coefficient among the parameters, ``coefficients``: how many there are.
    ``kept``: the columns that the equations keep.  ``again``: whether another run may take it up: a
    terminal event leaves traces in it.
    """

    heyoka: HeyokaIntegrator
    desk: Desk | None
    first: int
    coefficients: int
    kept: tuple[int, ...]
    again: bool


def built(plan: Blueprint, watcher: Watcher | None, cyclic: Cyclic | None) -> Built:
    """heyoka's integrator of a system at its start."""
    variables = hy.make_vars(*plan.names)
    start = CLOCK + (0 if watcher is None else len(watcher.damping))
    first = start + len(plan.pattern)
    k = {name: hy.par[i] for i, name in enumerate(plan.pattern, start)} or _as_constants(plan)
    rates = plan.field(variables, k)
    kept = kept_columns(rates)
    stepped = plan.field(as_parameters(variables, kept, first), k) if kept else rates
    if cyclic is not None:
        rates, stepped = cyclic.slowed(rates), cyclic.slowed(stepped)
    options, desk = dict(plan.options), None
    with disk_cache(plan.number):
        if watcher is not None:
            known = plan.field(variables, _as_constants(plan))
            known = known if cyclic is None else cyclic.slowed(known)
            events, desk = watcher.attach(variables, rates, known)
            options["nt_events"] = events
            options |= compact_beyond(LONG, [event.expression for event in events])
        away = None if plan.distance is None else plan.distance(variables, k)
        if away is not None:
            options["t_events"] = [terminal_event(away, plan.number)]
        equations = list(zip(variables, stepped, strict=True))
        heyoka = hy.taylor_adaptive(equations, plan.state, **options)
    used = max(0, len(heyoka.pars) - start)  # no rate asks for those after
    coefficients = min(used, len(plan.pattern))
    return Built(heyoka, desk, start, coefficients, kept[: used - coefficients], away is None)


def _as_constants(plan: Blueprint) -> dict[str, Expression]:
    named = zip(plan.coefficients, plan.constants, strict=True)
    return {name: hy.expression(x) for name, x in named}


def kept_columns(rates: Sequence[Expression]) -> tuple[int, ...]:
    """Those whose rates are zero whatever the state."""
    return tuple(i for i, rate in enumerate(rates) if rate == EXPRESSIONS.zero)


def as_parameters(
    variables: Sequence[Expression], kept: Sequence[int], first: int
) -> list[Expression]:
    """Variables, with parameters from ``first`` on in the place of those that are kept."""
    found = list(variables)
    for parameter, column in enumerate(kept, first):
        found[column] = hy.par[parameter]
    return found

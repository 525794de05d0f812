"""What a batch search watches: an expression on motions of many bodies, and heyoka's batch."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from polhode.equations import kinematics
from polhode.equations.forms import principal
from polhode.equations.section_functions import SectionZero
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Number
from polhode.numbers.number_types import DOUBLE
from polhode.numbers.rows import Doubles
from polhode.numbers.scalars import Functions, Scalar
from polhode.taylor.backend.engine import hy
from polhode.taylor.backend.heyoka_numbers import EXPRESSIONS, compact_beyond
from polhode.taylor.backend.protocols import Desk
from polhode.taylor.batches.compiled_batch import LANES, CompiledBatch
from polhode.taylor.events.callbacks import Callback
from polhode.taylor.events.functions import TIME, in_columns, rate, typed_constant
from polhode.taylor.events.jets import Formulas, jet_of
from polhode.taylor.events.roundoff import BAND
from polhode.taylor.integrator.specification import DESK, integrator

#: The parameters of a batch, and of its jet: when the stretch began, what the first step adds to
#: the expression (a jet's other part of the time), and the numbers of :meth:`Watched.numbers`.
ORIGIN, TINY = range(DESK)

_LONG = 80  # operations of an expression and its rate whose code is compiled as loops
_DAMPING = 2.0**-64  # of the rate: it takes no part in choosing the steps, however fast it is
_TURN = tuple(f"turn{i}{j}" for i in range(3) for j in range(3))
_UNITS = "1/unit", "unit"
_BAND = BAND * DOUBLE.eps / 2


class Watched(NamedTuple):
    """An expression on motions of bodies with the same coefficients by name.

    ``columns``: of a state.  ``zero``: a section's function, in principal axes; or a text in
    columns and t, in the scene's axes, ``turned`` against those, and units.  ``size``: a power of
    two above its largest value and rate.  ``constants``: the coefficients where all motions are of
    one body; steps are shorter work with them than with parameters.
    """

    names: tuple[str, ...]
    columns: tuple[str, ...]
    zero: SectionZero | str
    size: float = 1.0
    turned: bool = False
    constants: tuple[float, ...] = ()

    @property
    def formulas(self) -> Formulas:
        """The expression and the motion, of parameters."""
        turn = _TURN if self.turned else ()
        named = {n: hy.par[i] for i, n in enumerate((*_UNITS, *self.names, *turn), DESK)}
        return Formulas(self.value, principal.field, lambda _: named)

    def numbers(self, exponent: int, coefficients: Doubles, turns: Doubles | None) -> Doubles:
        """The numbers of motions, a column each: 1 / unit of time, unit, coefficients, turn."""
        unit = np.full((len(coefficients), 1), 2.0**exponent)
        parts = [1 / unit, unit, coefficients]
        return np.hstack([*parts, turns] if turns is not None else parts).T

    def value(
        self,
        state: Sequence[Scalar],
        time: Scalar,
        numbers: Mapping[str, Scalar],
        constant: Callable[[Number], Scalar],
        fn: Functions,
    ) -> Scalar:
        """At a state in principal axes, for any scalar."""
        if isinstance(self.zero, SectionZero):
            return self.zero.value(state, fn, lambda x: constant(Fraction(x)))
        vectors = [
            kinematics.in_scene_axes(state[i : i + 3], numbers, fn.zero)
            for i in range(0, len(self.columns), 3)
        ]
        per_unit, unit = (numbers[name] for name in _UNITS)
        values = [*(per_unit * x for x in vectors[0]), *(x for v in vectors[1:] for x in v)]
        return in_columns(self.zero, self.columns, values, unit * time, constant, fn)


def built(watched: Watched, extrema: bool = False) -> CompiledBatch:
    """A batch that meets the zeros of an expression, and of its rate where it is asked to."""
    variables, section = hy.make_vars(*watched.columns), isinstance(watched.zero, SectionZero)
    constant = _double if section else typed_constant(DOUBLE)
    formulas, desk = watched.formulas, Desk()
    numbers = formulas.numbers(constant)
    value = formulas.value(variables, TIME, numbers, constant, EXPRESSIONS)
    desk.jets.append(jet_of(formulas, variables, DOUBLE, _BAND, constant))
    if watched.constants:
        numbers = dict(zip(watched.names, map(hy.expression, watched.constants), strict=True))
    field = principal.field(variables, numbers, EXPRESSIONS)
    scaled = value if section else value / hy.expression(watched.size)
    met = [scaled]
    if extrema:
        met.append(rate(scaled, variables, field) * hy.expression(_DAMPING))
    clock = {TIME: hy.time + hy.par[ORIGIN]}
    options: dict[str, Any] = compact_beyond(_LONG, met)
    options["nt_events"] = [
        hy.nt_event_batch(hy.subs(f, clock) + hy.par[TINY], Callback(desk, 0, order))
        for order, f in enumerate(met)
        if hy.get_variables([f])  # a constant has no zeros
    ]
    heyoka = integrator(list(zip(variables, field, strict=True)), DOUBLE, LANES, **options)
    return CompiledBatch(heyoka, desk=desk)


def _double(x: Number) -> Scalar:
    """A double as heyoka's constant, however small."""
    return hy.expression(to_double(x))

"""Where a scene's events may be: places found by heyoka along the run in double.

A place is a zero of an event's expression, or an extremum at which it is small: there the run in
double cannot tell a contact from two zeros.  Both ends of the run in double are places too where
the expression is small, so that an event at a seam between two such runs is not lost.  Places are
some 1e-12 off; what they are is decided from refined states, see :mod:`polhode.refined.events`.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from polhode.equations.forms import principal
from polhode.numbers.number_types import DOUBLE
from polhode.numbers.rows import Doubles
from polhode.refined.errors import CannotRefine
from polhode.scenes.scene import Scene
from polhode.taylor.backend import heyoka_numbers
from polhode.taylor.backend.engine import hy
from polhode.taylor.backend.types import HeyokaIntegrator
from polhode.taylor.events.functions import TIME, event_expression
from polhode.taylor.events.magnitudes import size_of
from polhode.taylor.integrator.engine import Engine
from polhode.taylor.integrator.specification import integrator

# the parameters behind the coefficients: of what the run's own variables and clock are
_COEFFICIENTS = len(principal.NAMES)
_SPEED, _RATE, _ORIGIN, _PARAMETERS = range(_COEFFICIENTS, _COEFFICIENTS + 4)

TINY = 2.0**-150  # heyoka loses the next zero of a polynomial without constant term
_DAMPED = 2.0**-26  # so that events take no part in choosing the steps
_SMALL = 1e-6  # of an expression's size: what an extremum and an end are looked at for
_STILL = 1e-12  # of an expression's size: that it is no more than this all along says nothing
_ROUNDS = 3  # of Newton's method in double
_WIDEST = 1e-3  # a step of it, in units of the clock


#: Of one scene and one run: none is kept.


class Place(NamedTuple):
    """By the clock of a run in double; ``event``: its number in the scene; ``extremum``: or an
    end of that run, no zero that it has found.  ``value``: of the expression at an extremum where
    it is so far from zero that the run in double is enough, else 0."""

    clock: float
    event: int
    extremum: bool
    value: float = 0.0


@dataclass(frozen=True, eq=False)
class _Expression:
    """An event in double: value and rate as a compiled function, and how large it can be."""

    both: Any
    size: float


class Candidates:
    """The events of one scene along runs in double, of which one is under way at a time.

    Raises CannotRefine where a double cannot hold an expression's numbers.
    """

    def __init__(self, scene: Scene, backward: bool) -> None:
        self.scene, self.backward = scene, backward
        self.found: list[Place] = []
        try:
            self._ready = Engine(self._built())
        except heyoka_numbers.OutOfRange as fault:
            raise CannotRefine(f"an event: {fault}") from None

    def _built(self) -> HeyokaIntegrator:
        x = hy.make_vars("p", "q", "r", "gamma1", "gamma2", "gamma3")
        names = hy.make_vars(*(f"k{i:02}" for i in range(_PARAMETERS)))
        k = dict(zip(principal.NAMES, names, strict=False))
        rates = principal.field(x, k, heyoka_numbers.EXPRESSIONS)
        columns = 6 if self.scene.gamma is not None else 3
        variables = [*(names[_SPEED] * w for w in x[:3]), *x[3:columns]]
        clock = names[_ORIGIN] + names[_RATE] * hy.time
        inside = {name: hy.par[i] for i, name in enumerate(names)}
        inside |= {TIME: hy.subs(clock, inside)}
        self._expressions, events = [], []
        for number, event in enumerate(self.scene.events):
            value = event_expression(self.scene, event, DOUBLE, variables)
            slope = sum(
                (hy.diff(value, v) * rate for v, rate in zip(x, rates, strict=True)),
                hy.diff(value, TIME) * names[_RATE],
            )
            sizes = size_of(self.scene, event)
            size = min(max(float(sizes.value), 1e-300), 1e300)
            damping = hy.expression(_DAMPED / min(max(size, float(sizes.rate)), 1e300))
            for extremum, f in enumerate((value, slope)):
                if hy.get_variables([f]):  # a constant has no zeros
                    callback = _Callback(self, number, bool(extremum))
                    seen = hy.subs(f, inside) * damping + hy.expression(TINY)
                    events.append(hy.nt_event(seen, callback))
            both = hy.cfunc([value, slope], vars=[*x, *names, TIME])
            self._expressions.append(_Expression(both, size))
        equations = [(v, hy.subs(rate, inside)) for v, rate in zip(x, rates, strict=True)]
        return integrator(equations, nt_events=events)

    def begin(self, unit: int, origin: Fraction) -> Engine:
        """The integrator for a run from ``origin``, its clock faster by 2**unit; nothing found."""
        self.found = []
        way = -1.0 if self.backward else 1.0
        self._clock = [way * 2.0**unit, way * 2.0**-unit, way * float(origin)]
        pars = self._ready.parameters  # without those that no expression asks for
        pars[_COEFFICIENTS:] = self._clock[: len(pars) - _COEFFICIENTS]
        return self._ready

    def places(self, polynomials: Any) -> tuple[Place, ...]:
        """All places of the run just made, zeros polished by Newton's method."""
        end = float(polynomials.times[-1])
        met = [p for p in self.found if 0 <= p.clock <= end]
        kept: list[Place] = []
        for number, expression in enumerate(self._expressions):
            mine = [p for p in met if p.event == number]
            zeros = np.array([p.clock for p in mine if not p.extremum])
            kept += [Place(t, number, False) for t in self._nearer(expression, polynomials, zeros)]
            others = np.array([0.0, end, *(p.clock for p in mine if p.extremum)])
            values, _ = self._at(expression, polynomials, others)
            values[np.abs(values) <= _SMALL * expression.size] = 0.0
            places = zip(others.tolist(), values.tolist(), strict=True)
            kept += [Place(t, number, True, value) for t, value in places]
        return tuple(kept)

    def still(self, polynomials: Any, number: int) -> bool:
        """Whether an event's expression stays within rounding of zero along the run just made."""
        expression = self._expressions[number]
        values, _ = self._at(expression, polynomials, np.array(polynomials.times))
        return bool((np.abs(values) <= _STILL * expression.size).all())

    def _nearer(self, expression: _Expression, polynomials: Any, times: Doubles) -> list[float]:
        last = polynomials.times[-1]
        for _ in range(_ROUNDS if len(times) else 0):
            value, slope = self._at(expression, polynomials, times)
            with np.errstate(all="ignore"):
                step = value / slope
            near = np.abs(step) < _WIDEST
            times = np.clip(np.where(near, times - step, times), 0.0, last)
        return times.tolist() if len(times) else []

    def _at(
        self, expression: _Expression, polynomials: Any, times: Doubles
    ) -> tuple[Doubles, Doubles]:
        """Values and rates at times on the clock."""
        speed, rate, origin = self._clock
        given = np.empty((6 + _PARAMETERS + 1, len(times)))
        given[:6] = polynomials(times).T
        pars = [*self._ready.parameters[:_COEFFICIENTS], speed, rate, origin]
        given[6:-1] = np.array(pars)[:, None]
        given[-1] = origin + rate * times
        value, slope = expression.both(given)
        return value, slope


class _Callback:
    """heyoka's call where a place is met; heyoka copies its callbacks, this one stays one."""

    def __init__(self, candidates: Candidates, event: int, extremum: bool) -> None:
        self.candidates, self.event, self.extremum = candidates, event, extremum

    def __call__(self, ta: Any, t: float, _: int) -> None:
        self.candidates.found.append(Place(float(t), self.event, self.extremum))

    def __deepcopy__(self, _: object) -> _Callback:
        return self

"""Events beside a plain run in double: found at knots at which the run was read.

At each knot an event's expression and three derivatives are evaluated, at all of them at once.
Hermite's interpolation (:mod:`polhode.taylor.events.hermite_roots`) says between which knots it
crosses zero and about when; the state there comes from that at the nearest knot, many in the lanes
of one batch (:mod:`polhode.taylor.batches.short_arcs`), and Newton's method takes the time to its
last digit, as it does where heyoka meets a zero.  Where interpolation leaves anything open - a
contact, two zeros close together, steps too long for it - heyoka looks for events itself, from a
knot to a knot.
"""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.numbers.number_types import DOUBLE
from polhode.numbers.rows import Doubles
from polhode.scenes.scene import Scene
from polhode.taylor.backend.engine import hy
from polhode.taylor.backend.heyoka_numbers import disk_cache, type_options
from polhode.taylor.backend.integrator_pool import Kind
from polhode.taylor.backend.types import CompiledFunction
from polhode.taylor.batches.short_arcs import Hops
from polhode.taylor.events import hermite_roots
from polhode.taylor.events.functions import event_expression, jet
from polhode.taylor.events.stepwise import Watch
from polhode.taylor.events.vectorized_roots import NEAR, Seen, Zeros, crossings, those
from polhode.taylor.integrator.compiled import Compiled
from polhode.taylor.integrator.protocols import Desk
from polhode.taylor.integrator.specification import Blueprint

_HOPS = 3  # towards one crossing
_LONGEST = 32  # cells in a row that heyoka looks at
_FEW = 8  # cells, and a quarter of them all: more are not looked at once more


class Knots(NamedTuple):
    """Where a plain run was read: times ``width`` apart, the states, and where the run ended."""

    times: Doubles
    states: Doubles
    width: float
    reached: float


class Outlook:
    """What a scene's events are sought with, compiled: for one run at a time.

    ``jets``: of each expression its value and derivatives, at columns of states.
    """

    def __init__(self, scene: Scene, plan: Blueprint) -> None:
        variables = hy.make_vars(*plan.names)
        named = zip(plan.coefficients, plan.constants, strict=True)
        rates = plan.field(variables, {name: hy.expression(x) for name, x in named})
        self.jets: list[CompiledFunction] = []
        self.newton = hermite_roots.newton()
        self.desk = Desk()
        options = type_options(DOUBLE)

        with disk_cache(DOUBLE):
            for event in scene.events:
                value = event_expression(scene, event, DOUBLE, variables)
                values = jet([value], variables, rates, hermite_roots.DERIVATIVES - 1)
                compiled = hy.cfunc(values, vars=variables, **options)
                self.jets.append(compiled)
                self.desk.evaluate.append(_first_three(compiled))
                self.desk.with_time.append(False)
            motion = jet(rates, variables, rates, 2)
            self.desk.motion = hy.cfunc(motion, vars=variables, **options)


def _first_three(jet: CompiledFunction) -> CompiledFunction:
    def evaluate(columns: Doubles) -> Doubles:
        found: Doubles = jet(columns)[:3]
        return found

    return evaluate


#: By :attr:`polhode.runs.problem.problem.Problem.event_functions`.
OUTLOOKS: Kind[Outlook] = Kind(16)


class Sightings:
    """The events of one run that is over.

    ``watch``: takes what is found.  ``plan``: what an integrator of the run would be built from.
    """

    def __init__(self, watch: Watch, outlook: Outlook, hops: Hops, plan: Blueprint) -> None:
        self.watch, self.outlook, self.hops, self.plan = watch, outlook, hops, plan
        self._looking: Compiled | None = None
        watch.sit_down(outlook.desk)

    def release(self) -> None:
        """Leave heyoka's integrator to the next run, once the watch has told what it found."""
        if self._looking is not None:
            self._looking.release()

    def find(self, knots: Knots, patient: bool) -> bool:
        """Tell the watch all events; False where too much is open, or nothing moves.

        ``patient``: whether whatever is open is looked at.
        """
        columns = knots.states.T.copy()
        asked: list[tuple[int, list[tuple[int, int]]]] = []
        for k, limits in enumerate(self.watch.limits):
            with np.errstate(all="ignore"):
                values = self.outlook.jets[k](columns)
            if self.watch.start[k] == 0 and np.all(np.abs(values[0, :_FEW]) <= limits.noise):
                return False
            zeros, stretches = self._zeros(k, values, knots)
            if zeros is not None:
                self.watch.known[k].append(zeros)
            lengths = [end - begin for begin, end in stretches]
            wide = max(lengths, default=0) > _LONGEST
            if not patient and (wide or sum(lengths) > max(_FEW, len(knots.times) / 4)):
                return False
            asked.append((k, stretches))
        if any(stretches for _, stretches in asked):
            self._look(knots, asked)
        return True

    def _zeros(
        self, k: int, values: Doubles, knots: Knots
    ) -> tuple[Zeros | None, list[tuple[int, int]]]:
        """Plain crossings of an event; and from which knots to which it is to be looked for."""
        limits = self.watch.limits[k]
        thresholds = float(limits.contact), float(limits.flat)
        found = hermite_roots.crossed(values, knots.width, *thresholds, self.outlook.newton)
        after = found.places > 0.5
        knot = found.cells + after
        ahead = (found.places - after) * knots.width
        seen = self._hop(k, knots, knot, ahead)
        crossed = crossings(seen, *self._functions(k), limits) if len(knot) else None
        plain = crossed.plain if crossed is not None else np.empty(0, bool)
        unsure = np.append(found.unsure, knots.reached != knots.times[-1])
        unsure[found.cells[~plain]] = True
        stretches = _stretches(unsure, found.near)
        for begin, end in stretches:
            plain &= (found.cells < begin) | (found.cells >= end)
        if crossed is None or not plain.any():
            return None, stretches
        return those((seen, crossed), plain), stretches

    def _functions(self, k: int) -> tuple[CompiledFunction, CompiledFunction]:
        return self.watch.desk.evaluate[k], self.watch.desk.motion

    def _hop(self, k: int, knots: Knots, knot: npt.NDArray[np.intp], ahead: Doubles) -> Seen:
        """The states at crossings, brought so near that Newton's method does the rest."""
        rows = np.empty((len(knot), knots.states.shape[1]))
        evaluate, far = self._functions(k)[0], np.arange(len(knot))
        with np.errstate(all="ignore"):
            for _ in range(_HOPS):
                if len(far) == 0:
                    break
                rows[far] = self.hops.along(knots.states[knot[far]], ahead[far])
                value, slope, _ = evaluate(rows[far].T.copy())
                step = -value / slope
                more = (np.abs(step) > NEAR[3]) & (np.abs(step) < abs(knots.width))
                far = far[more]
                ahead[far] += step[more]
        at = knots.times[knot]
        return Seen(at, np.zeros_like(at), ahead, rows)

    def _look(self, knots: Knots, asked: list[tuple[int, list[tuple[int, int]]]]) -> None:
        """Let heyoka look for events from knots to knots."""
        self._looking = looking = Compiled(self.plan, self.watch)
        self.watch.sit_down(looking.desk or Desk())
        ends = np.append(knots.times, knots.reached)
        for k, stretches in asked:
            for begin, end in stretches:
                before, length = self.watch.marks(), float(ends[end] - ends[begin])
                looking.stand(knots.states[begin])
                self.watch.counts_from(Fraction(float(ends[begin])), looking.heyoka)
                looking.heyoka.propagate_until(length)
                self.watch.take_back(before, all_but=k)


def _stretches(unsure: npt.NDArray[np.bool_], near: npt.NDArray[np.bool_]) -> list[tuple[int, int]]:
    """From which knot to which: cells in a row, begun and ended where there is no zero.

    The last cell leads from the last knot to where the run ended.
    """
    found: list[tuple[int, int]] = []
    for cell in np.flatnonzero(unsure).tolist():
        begin, end = cell, cell + 1
        while begin > 0 and near[begin]:
            begin -= 1
        while end < len(near) and near[end]:
            end += 1
        if found and begin <= found[-1][1]:
            begin, end = found[-1][0], max(end, found[-1][1])
            found.pop()
        found.append((begin, end))
    return found

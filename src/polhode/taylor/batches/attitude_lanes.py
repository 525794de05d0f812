"""Attitude and angles along several stretches of one motion at once, one in each SIMD lane.

Beside a state that is known at the stretches' beginnings, the attitude's quaternion and psi and phi
are quadratures: each stretch is integrated for itself, from the quaternion 1 and the angles 0.
Doubles only, as heyoka's batches are.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from polhode.equations.system import System
from polhode.numbers.number_types import DOUBLE
from polhode.numbers.rows import Doubles
from polhode.scenes.vocabulary import ANGLE_VARIABLES, ATTITUDE
from polhode.taylor.backend import defaults
from polhode.taylor.backend.engine import hy
from polhode.taylor.backend.heyoka_numbers import EXPRESSIONS, disk_cache
from polhode.taylor.backend.integrator_pool import Kind
from polhode.taylor.backend.types import HeyokaIntegrator
from polhode.taylor.batches.compiled_batch import CompiledBatch, width
from polhode.taylor.integrator.angle_variables import Cyclic
from polhode.taylor.integrator.specification import Blueprint

TURNING: Kind[HeyokaIntegrator] = Kind(4)

#: Steps of one stretch; more than this is a passage so close to a pole that it does not end.
_MOST_STEPS = 100_000

_PADDING = 2.0**-12  # of a stretch: between the times at which a lane that is done goes on


class Stretch(NamedTuple):
    """A part of a motion: the variables where it begins, and times from there on, monotone."""

    start: Doubles
    times: Doubles


class Turning:
    """The compiled equations of a system with outputs, with its coefficients.

    ``plan``: what an integrator of the system would be built from.  ``seconds``: the time that
    compiling took.
    """

    def __init__(self, system: System, plan: Blueprint) -> None:
        began = time.perf_counter()
        self._first = len(system.form.variables)
        attitude = [1.0] + [0.0] * (len(ATTITUDE) - 1) if "attitude" in system.outputs else []
        self._cyclic = len(ANGLE_VARIABLES) if "angles" in system.outputs else 0
        begin = [0.0] * self._first + attitude + [0.0] * self._cyclic
        key = (system.names, system.outputs, tuple(system.coefficients), plan.tolerance)
        self._batch = CompiledBatch(TURNING, key, lambda: self._built(system, plan))
        self._batch.parameters[:] = np.array(plan.constants)[:, None]
        self._starts = np.repeat(np.array(begin)[:, None], self.places, axis=1)
        self.seconds = time.perf_counter() - began

    @property
    def places(self) -> int:
        """How many stretches are integrated at once."""
        return self._batch.places

    def release(self) -> None:
        """Leave the compiled code to the next run of such equations; the last call of all."""
        self._batch.release()
        del self._batch

    def _built(self, system: System, plan: Blueprint) -> HeyokaIntegrator:
        variables, lanes = hy.make_vars(*system.names), width(DOUBLE)
        k = {name: hy.par[i] for i, name in enumerate(system.coefficients)}
        rates = system.field(variables, k, EXPRESSIONS)
        if self._cyclic:  # that their size takes no part in choosing the steps
            rates = Cyclic([Fraction(0)] * self._cyclic, DOUBLE).slowed(rates)
        state, pars = np.zeros((len(variables), lanes)), np.zeros((len(k), lanes))
        with disk_cache(DOUBLE):
            equations = list(zip(variables, rates, strict=True))
            return hy.taylor_adaptive_batch(equations, state, pars=pars, **plan.options)

    def along(self, stretches: Sequence[Stretch]) -> list[Doubles] | None:
        """Of at most ``places`` stretches, rows at their times: quaternion, psi and phi.

        Counted from the stretch's beginning.  None where one of them was not brought to its end.
        """
        batch, lanes, places = self._batch, len(stretches), self.places
        every = [*stretches, *[stretches[-1]] * (places - lanes)]
        self._starts[: self._first] = np.array([stretch.start for stretch in every]).T
        batch.stand(self._starts)
        count = max(len(stretch.times) for stretch in every)
        if count == 1:  # a state at the end alone needs no dense output
            rows = batch.to([float(s.times[0]) for s in every], _MOST_STEPS)[None]
        else:
            grid = np.zeros((count + 1, places))
            for lane, stretch in enumerate(every):
                done, end = len(stretch.times), stretch.times[-1]
                grid[1 : done + 1, lane] = stretch.times
                grid[done + 1 :, lane] = end + end * _PADDING * np.arange(1, count - done + 1)
            rows = batch.rows(grid, _MOST_STEPS)
        if not batch.arrived:
            return None
        found = rows[:, self._first :].copy()
        if self._cyclic:
            found[:, -self._cyclic :] *= defaults.of(DOUBLE).divisor
        return [found[: len(s.times), :, lane] for lane, s in enumerate(stretches)]

"""heyoka's run of the Euler–Poisson equations in a fast number, asked at any time.

The equations are compiled once for every body: its constants are parameters.  Whoever needs a
trajectory that is only approximately right, such as the enclosures, starts from here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import reduce
from operator import mul
from typing import Any, NamedTuple

import numpy as np

from polhode.equations.terms import NAMES, ROWS
from polhode.motion.outcomes import Outcome
from polhode.numbers.number_types import DOUBLE, EXTENDED, NumberType, extended_here
from polhode.numbers.rows import Doubles
from polhode.numbers.scalars import Scalar
from polhode.scenes.vocabulary import STATE
from polhode.taylor.backend.engine import hy
from polhode.taylor.backend.types import HeyokaOutput
from polhode.taylor.integrator.engine import Engine, lent
from polhode.taylor.integrator.specification import integrator

_MOST_STEPS = 100_000


class Path(NamedTuple):
    """A run from time 0: the ends of heyoka's steps, an estimate of the radius of convergence of
    the motion's Taylor series on each of them, the continuous output and its type of number."""

    ends: Doubles
    convergence: Doubles
    output: HeyokaOutput
    kind: type[np.floating]

    def at(self, times: Doubles) -> Doubles:
        """States at times of the run, (n, 6), as doubles."""
        return np.array(self.output(np.asarray(times, dtype=self.kind))).astype(float)


def path(
    start: Sequence[Scalar], constants: Sequence[Scalar], duration: float, wide: bool
) -> Path | None:
    """A run of so long from six numbers; None where heyoka does not get there.

    ``constants``: the coefficients in the order of ``terms.NAMES``; ``wide``: in long double rather
    than in double, where the machine has it.
    """
    number = EXTENDED if wide and extended_here() else DOUBLE
    kind = np.longdouble if number == EXTENDED else np.float64
    with lent(("any body", number), lambda: _built(number)) as ta:
        ta.stand(np.array(start, dtype=kind), np.array(constants, dtype=kind))
        ended, output = ta.polynomials(kind(duration), _MOST_STEPS)
        order = ta.heyoka.order
    if ended is not Outcome.REACHED_END or output is None:
        return None
    ends = np.array(output.times).astype(float)
    # heyoka's step is this part of the radius of convergence
    part = math.exp(-2.0 - 0.7 / (order - 1))
    taken = np.diff(ends)
    if len(taken) > 1:
        taken[-1] = max(taken[-1], taken[-2])  # the last step is cut at the end
    return Path(ends, taken / part, output, kind)


def _built(number: NumberType) -> Engine:
    """The engine of the equations for any body."""
    x = hy.make_vars(*STATE)
    system = []
    for variable, row in zip(x, ROWS, strict=True):
        values: list[list[Any]] = [[], []]  # of terms that are added, and that are taken away
        for term in row:
            factors = [x[n] for n in term.factors]
            if term.coefficient is not None:
                factors.insert(0, hy.par[term.coefficient])
            values[term.sign < 0].append(reduce(mul, factors))
        added, taken = values
        system.append((variable, hy.sum(added) - hy.sum(taken) if taken else hy.sum(added)))
    return Engine(integrator(system, number), number, coefficients=len(NAMES))

"""heyoka's run of the Euler–Poisson equations in a fast number, asked at any time.

The equations are compiled once for every body: the nine constants are parameters.  Whoever needs a
trajectory that is only approximately right, such as the enclosures, starts from here.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import heyoka as hy
import numpy as np

from polhode.numbers.number_types import extended_here
from polhode.numbers.rows import Doubles
from polhode.numbers.scalars import Scalar
from polhode.taylor.backend.types import HeyokaIntegrator, HeyokaOutput

_CYCLE = ((1, 2), (2, 0), (0, 1))
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

    w_i' = c_i w_a w_b + c_(3+i) gamma_a + c_(6+i) gamma_b, gamma' = gamma x w, with i, a, b cyclic;
    ``wide``: in long double rather than in double, where the machine has it.
    """
    kind = np.longdouble if wide and extended_here() else np.float64
    ta = copy.deepcopy(_compiled(kind))
    ta.pars[:] = np.array(constants, dtype=kind)
    ta.state[:] = np.array(start, dtype=kind)
    ta.time = kind(0)
    found = ta.propagate_until(kind(duration), c_output=True, max_steps=_MOST_STEPS)
    if found[0] != hy.taylor_outcome.time_limit or found[4] is None:
        return None
    ends = np.array(found[4].times).astype(float)
    # heyoka's step is this part of the radius of convergence
    part = math.exp(-2.0 - 0.7 / (ta.order - 1))
    taken = np.diff(ends)
    if len(taken) > 1:
        taken[-1] = max(taken[-1], taken[-2])  # the last step is cut at the end
    return Path(ends, taken / part, found[4], kind)


@cache
def _compiled(kind: type[np.floating]) -> HeyokaIntegrator:
    """An integrator of the equations for any body."""
    w, g = hy.make_vars("p", "q", "r"), hy.make_vars("g1", "g2", "g3")
    system = [
        (w[i], hy.sum([hy.par[i] * w[a] * w[b], hy.par[3 + i] * g[a], hy.par[6 + i] * g[b]]))
        for i, (a, b) in enumerate(_CYCLE)
    ]
    system += [(g[i], g[a] * w[b] - g[b] * w[a]) for i, (a, b) in enumerate(_CYCLE)]
    return hy.taylor_adaptive(
        system, np.zeros(6, dtype=kind), fp_type=kind, pars=np.zeros(9, dtype=kind)
    )

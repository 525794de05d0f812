"""One tangent along each of many motions: batches of doubles of twelve equations.

Beside the state x a tangent u obeys u' = J(x) u, J by symbolic differentiation; the body's numbers
are parameters, so motions of different bodies share the code.  At each look ln|u| is kept and u is
scaled to length one.  Nothing is called back while heyoka steps: threads share the work.
"""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.common.checkpoint import Arrays
from polhode.common.interrupts import Stop
from polhode.numbers.rows import Doubles
from polhode.scenes.vocabulary import STATE
from polhode.taylor.batches.compiled_batch import LANES, CompiledBatch
from polhode.taylor.batches.lane_queue import LaneQueue
from polhode.taylor.integrator.specification import Equations, principal_engine


class TangentJob(NamedTuple):
    """Motions to be followed to ``end`` with ``looks`` looks, evenly spaced.

    ``names``: of the coefficients; ``coefficients`` (n, names), ``starts`` and ``tangents`` (n, 6):
    in principal axes and one unit of time.  ``early``: looks (even ones) at which a motion is left
    where ln|u| has grown by more than ``enough`` since half of that time.
    """

    names: tuple[str, ...]
    coefficients: Doubles
    starts: Doubles
    tangents: Doubles
    end: float
    looks: int
    tolerance: float | None
    early: tuple[int, ...]
    enough: float


class Followed(NamedTuple):
    """``sizes`` (n, looks + 1): ln|u|, nan past the look at which a motion was left or not finite.

    ``last`` (n,): that look.
    """

    sizes: Doubles
    last: npt.NDArray[np.int64]

    @classmethod
    def of(cls, arrays: Arrays) -> Followed:
        """From its arrays by name."""
        sizes = np.asarray(arrays["sizes"], dtype=np.float64)
        return cls(sizes, np.asarray(arrays["last"], dtype=np.int64))


def solve(job: TangentJob, stop: Stop | None = None) -> Followed:
    """Follow a job's tangents, as many at a time as a step advances; the next takes a free lane."""
    n, chunk = len(job.starts), job.end / job.looks
    sizes = np.full((n, job.looks + 1), np.nan)
    sizes[:, 0] = 0.0
    last = np.zeros(n, dtype=int)
    tolerance = None if job.tolerance is None else Fraction(job.tolerance)
    equations = Equations(STATE, job.names, tolerance=tolerance, lanes=LANES, tangents=1)
    with principal_engine(equations, CompiledBatch) as ta:
        lanes = LaneQueue(n, ta.places)

        def begin(lane: int) -> None:
            k = lanes.motion[lane]
            ta.state[:6, lane], ta.state[6:, lane] = job.starts[k], job.tangents[k]
            ta.parameters[:, lane] = job.coefficients[k]

        def stretch() -> list[int] | None:
            ta.begin()
            if ta.in_blocks(np.where(lanes.busy, chunk, 0.0).tolist(), stop=stop).stopped:
                return None
            length, over = np.sqrt((ta.state[6:] ** 2).sum(axis=0)), []
            for lane in np.flatnonzero(lanes.busy).tolist():
                k = int(lanes.motion[lane])
                finite = bool(np.isfinite(ta.state[:, lane]).all()) and length[lane] > 0
                if finite:
                    ta.state[6:, lane] /= length[lane]
                    last[k] += 1
                    look = last[k]
                    sizes[k, look] = sizes[k, look - 1] + np.log(length[lane])
                    grown = sizes[k, look] - sizes[k, look // 2]
                    if look < job.looks and not (look in job.early and grown > job.enough):
                        continue
                over.append(lane)
            return over

        for lane in range(ta.places):
            begin(lane)
        lanes.follow(begin, stretch, stop)
    return Followed(sizes, last)

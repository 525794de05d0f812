"""One tangent along each of many motions: batches of doubles of twelve equations.

Beside the state x a tangent u obeys u' = J(x) u, J by symbolic differentiation; the body's numbers
are parameters, so motions of different bodies share the code.  At each look ln|u| is kept and u is
scaled to length one.  Nothing is called back while heyoka steps: threads share the work.
"""

from __future__ import annotations

import copy
import threading
from functools import lru_cache
from typing import NamedTuple

import heyoka as hy
import numpy as np
import numpy.typing as npt

from polhode.common.checkpoint import Arrays
from polhode.common.locks import Lock, Place
from polhode.common.progress import Stop
from polhode.equations.forms import principal
from polhode.numbers.number_types import DOUBLE
from polhode.numbers.rows import Doubles
from polhode.scenes.vocabulary import STATE
from polhode.taylor.backend.heyoka_numbers import EXPRESSIONS
from polhode.taylor.backend.types import HeyokaIntegrator
from polhode.taylor.batches import step_blocks
from polhode.taylor.batches.batch_integrator import width


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
    size, n = width(DOUBLE), len(job.starts)
    ta = _own(job, size)
    sizes = np.full((n, job.looks + 1), np.nan)
    sizes[:, 0] = 0.0
    last = np.zeros(n, dtype=int)
    orbit = np.minimum(np.arange(size), n - 1)
    busy, ahead = np.arange(size) < n, min(size, n)

    def begin(lane: int, k: int) -> None:
        ta.state[:6, lane], ta.state[6:, lane] = job.starts[k], job.tangents[k]
        ta.pars[:, lane] = job.coefficients[k]
        orbit[lane], last[k] = k, 0

    for lane in range(size):
        begin(lane, int(orbit[lane]))
    chunk = job.end / job.looks
    while busy.any() and not (stop is not None and stop()):
        ta.set_time(0.0)
        if step_blocks.until(ta, np.where(busy, chunk, 0.0).tolist(), stop=stop).stopped:
            break
        length = np.sqrt((ta.state[6:] ** 2).sum(axis=0))
        for lane in np.flatnonzero(busy).tolist():
            k = int(orbit[lane])
            finite = bool(np.isfinite(ta.state[:, lane]).all()) and length[lane] > 0
            if finite:
                ta.state[6:, lane] /= length[lane]
                last[k] += 1
                look = last[k]
                sizes[k, look] = sizes[k, look - 1] + np.log(length[lane])
                grown = sizes[k, look] - sizes[k, look // 2]
                if look < job.looks and not (look in job.early and grown > job.enough):
                    continue
            if ahead < n:
                begin(lane, ahead)
                ahead += 1
            else:
                busy[lane] = False
                ta.state[:6, lane], ta.state[6:, lane] = job.starts[k], job.tangents[k]
    return Followed(sizes, last)


_mine = threading.local()
_compiling = Lock(Place.COMPILING)


def _own(job: TangentJob, size: int) -> HeyokaIntegrator:
    """The integrator of this thread alone; compiled once a process."""
    key = (job.names, size, job.tolerance)
    if getattr(_mine, "key", None) != key:
        with _compiling.held():
            built = _compiled(*key)
        _mine.integrator, _mine.key = copy.copy(built), key
    return _mine.integrator


@lru_cache(maxsize=4)
def _compiled(names: tuple[str, ...], size: int, tolerance: float | None) -> HeyokaIntegrator:
    x = hy.make_vars(*STATE)
    u = hy.make_vars(*(f"d_{name}" for name in STATE))
    field = principal.field(x, {n: hy.par[i] for i, n in enumerate(names)}, EXPRESSIONS)
    system = list(zip(x, field, strict=True))
    for variable, rate in zip(u, field, strict=True):
        parts = [hy.diff(rate, y) * v for y, v in zip(x, u, strict=True)]
        system.append((variable, hy.sum(parts)))
    options = {} if tolerance is None else {"tol": tolerance}
    shapes = np.zeros((12, size)), np.zeros((len(names), size))
    return hy.taylor_adaptive_batch(system, shapes[0], pars=shapes[1], **options)

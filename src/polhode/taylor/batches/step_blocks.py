"""Steps of heyoka's batches in blocks: between two blocks a signal is heard, and who says stop.

Inside one call of heyoka nothing of Python runs, so that a call without a limit may last for ever:
where an event's expression has a pole, steps become zero.  The blocks leave every bit as it is, for
heyoka goes on from where it stands to the same ends.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.common.interrupts import Stop
from polhode.motion.outcomes import Outcome
from polhode.taylor.backend.step_outcomes import ending
from polhode.taylor.backend.types import HeyokaIntegrator

BLOCK = 20_000  # steps of a batch: a tenth of a second, with an event
_THERE = 2.0**-50  # of a lane's end
_EPS = 2.0**-52


class Ended(NamedTuple):
    """How each lane ended, and its steps.  ``stopped``: whether ``stop`` said so."""

    outcomes: list[Outcome]
    steps: npt.NDArray[np.int64]
    stopped: bool = False


def until(
    ta: HeyokaIntegrator,
    ends: Sequence[float],
    most: int | None = None,
    stop: Stop | None = None,
) -> Ended:
    """Advance the lanes of a batch, which stand at time 0, to their ends in at most so many steps.

    A lane ends with REACHED_END; STEP_LIMIT; STEP_UNDERFLOW, its steps are zero or no longer change
    its time, which ends the others, too, with STEP_LIMIT; or NON_FINITE, its state is nan, and the
    others go on.
    """
    ahead, steps = np.array(ends), np.zeros(len(ends), dtype=np.int64)
    lost = np.zeros(len(ends), dtype=bool)
    while True:
        block = BLOCK if most is None else max(1, min(BLOCK, most - int(steps.max())))
        before = [part.copy() for part in ta.dtime]
        ta.propagate_until(ahead.tolist(), max_steps=block)
        results = ta.propagate_res
        taken = np.array([result[3] for result in results], dtype=np.int64)
        steps += taken
        failed = np.array([ending(result[0]) is Outcome.NON_FINITE for result in results])
        if failed.any():
            lost |= failed
            if lost.all():
                break
            if not np.isfinite(ta.time).all():  # of a state that is nan from the start on
                there = np.isfinite(ta.time)
                parts = zip(ta.dtime, before, strict=True)
                ta.set_dtime(*(np.where(there, new, old).tolist() for new, old in parts))
            for values in (ta.state, ta.pars):  # idles where another lane stands
                values[:, lost] = values[:, [int(np.argmin(lost))]]
            ahead[lost] = ta.time[lost]
            continue
        late = ~lost & (np.abs(ahead - ta.time) > _THERE * np.abs(ahead))
        still = np.abs(ta.time - before[0]) <= block * _EPS * np.abs(ta.time)
        zero = late & (still | (taken < block))  # heyoka counts the steps that have a length
        stopped = stop is not None and bool(late.any()) and stop()
        over = most is not None and steps.max() >= most
        if not late.any() or zero.any() or stopped or over:
            outcomes = [
                Outcome.NON_FINITE
                if gone
                else Outcome.STEP_UNDERFLOW
                if underflows
                else Outcome.STEP_LIMIT
                if short
                else Outcome.REACHED_END
                for gone, underflows, short in zip(lost, zero, late, strict=True)
            ]
            ta.state[:, lost] = np.nan
            return Ended(outcomes, steps, stopped)
    ta.state[:] = np.nan
    return Ended([Outcome.NON_FINITE] * len(ends), steps)

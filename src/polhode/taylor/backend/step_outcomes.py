"""How heyoka's steps ended, in polhode's words."""

from __future__ import annotations

from polhode.motion.outcomes import Outcome
from polhode.taylor.backend.engine import constant, hy
from polhode.taylor.backend.types import HeyokaOutcome

TIME_LIMIT = hy.taylor_outcome.time_limit  # of a call that came to its end

_WORDS = constant(
    lambda: {
        int(hy.taylor_outcome.err_nf_state): Outcome.NON_FINITE,
        int(TIME_LIMIT): Outcome.REACHED_END,
        int(hy.taylor_outcome.cb_stop): Outcome.STOPPED_AT_EVENT,  # callbacks ask for nothing else
        -1: Outcome.SINGULAR,  # the first and only terminal event
    }
)


def ending(found: HeyokaOutcome) -> Outcome:
    """The outcome of heyoka's call; STEP_LIMIT where the steps allowed were taken."""
    return _WORDS.get(int(found), Outcome.STEP_LIMIT)

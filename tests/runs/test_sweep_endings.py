"""How many members of a sweep ended how, told from their codes alone."""

import numpy as np

from polhode.motion.outcomes import Outcome, code
from polhode.runs.sweep.endings import Ended

END, EVENT, LIMIT, UNDONE = (
    Outcome.REACHED_END,
    Outcome.STOPPED_AT_EVENT,
    Outcome.STEP_LIMIT,
    Outcome.NOT_RUN,
)


def of(*outcomes):
    found = Ended()
    found.endings = np.array([code(outcome) for outcome in outcomes], dtype=np.uint8)
    return found


def test_outcomes_are_counted_in_the_order_in_which_the_first_of_each_comes():
    found = of(LIMIT, END, UNDONE, END, EVENT, LIMIT, END)
    assert list(found.tally().items()) == [(LIMIT, 2), (END, 3), (UNDONE, 1), (EVENT, 1)]


def test_a_sweep_is_done_where_every_member_did_what_was_asked():
    assert of(END, EVENT).done
    assert not of(END, LIMIT).done
    assert not of(END, UNDONE).done


def test_a_sweep_is_interrupted_where_members_were_not_run():
    assert of(LIMIT, UNDONE).interrupted
    assert not of(END, LIMIT).interrupted


def test_how_many_reached_the_end_in_words():
    assert of(END, EVENT)._reached() == "all reached the end"
    assert of(END, LIMIT, EVENT, END)._reached() == "3 of them reached the end"

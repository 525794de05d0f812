"""The one rule by which a hypothesis about a table is accepted: its edges, from both sides."""

import numpy as np
import pytest

from polhode.judging.tables.hypotheses import Comparison, Evidence, Hypothesis, explains

NONE = np.zeros(4)


def comparison(digits, rival=NONE, goes=True, freedom=3, rows_fitted=0, **hypothesis):
    """Evidence of so many digits a row beside that of the table as it stands."""
    mine = np.broadcast_to(np.asarray(digits, dtype=float), (4,))
    evidence = Evidence(Hypothesis(**hypothesis), mine.copy(), rows_fitted, freedom)
    return Comparison(evidence, Evidence(Hypothesis(), np.array(rival, dtype=float)), goes)


@pytest.mark.parametrize(
    ("gain", "how"),
    [
        (1.5, {}),
        (3.0, {"fitted": 1}),
        (3.5, {"freedom": 1}),
        (9.5, {"freedom": 1, "tries": 10**6}),
        (4.75, {"freedom": 2, "tries": 10**6}),
        (9.5, {"freedom": 2, "tries": 10**6, "fitted": 1}),
    ],
)
def test_so_many_digits_more_are_asked_and_no_more(gain, how):
    assert explains([comparison(gain + 0.01, **how)])
    assert not explains([comparison(gain - 0.01, **how)])


def test_a_part_that_does_not_go_with_the_motion_explains_nothing():
    assert explains([comparison(8)])
    assert not explains([comparison(8, goes=False)])
    assert not explains([comparison(8), comparison(8, goes=False)])


def test_every_part_begins_right():
    """Also one that is no better than it stands."""
    assert explains([comparison(8), comparison(1.6)])
    assert not explains([comparison(8), comparison(1.4)])
    assert not explains([comparison(8), comparison(0)])


def test_all_parts_together_have_more_digits():
    worse = comparison(2, rival=np.full(4, 9.0))
    assert explains([comparison(9.5), worse])
    assert not explains([comparison(6.5), worse])


def test_digits_beyond_twelve_are_no_more_certain():
    assert not explains([comparison(20, rival=np.full(4, 12.0))])
    assert explains([comparison(20, rival=np.full(4, 10.0))])


def test_what_is_wrong_in_the_first_rows_is_wrong():
    """Later rows that are right again do not count, nor do rows that drift after right ones."""
    assert explains([comparison([8, 8, 1, 0])])
    assert not explains([comparison([0, 8, 8, 8])])
    assert not explains([comparison([1.4, 8, 8, 8])])
    assert not explains([comparison([2, 0, 8, 8], freedom=1)])
    assert explains([comparison([4, 0, 8, 8], freedom=1)])


def test_no_row_before_the_better_one_is_worse():
    """By more than digits of good rows differ: 0.3, or 1 where both are near the type's own."""
    for rival, mine in ((6.0, 5.8), (10.0, 9.2)):
        assert explains([comparison([mine, mine, mine, mine], [rival, rival, 0, 0])])
    for rival, mine in ((6.0, 5.6), (10.0, 8.8)):
        assert not explains([comparison([mine, mine, mine, mine], [rival, rival, 0, 0])])


def test_rows_to_which_a_number_was_fitted_say_nothing_one_by_one():
    how = {"fitted": 1, "rows_fitted": 2}
    assert explains([comparison([0, 0, 8, 8], **how)])
    assert not explains([comparison([8, 8, 0, 0], **how)])
    assert not explains([comparison([8, 8, 8, 0], fitted=1, rows_fitted=4)])


@pytest.mark.parametrize(
    ("digits", "moved", "how", "goes"),
    [
        # where the motion has left its first row by a tenth, the table is nearer to it: 0.7 digits
        (1.8, [0, 0.05, 0.11, 1], {}, True),
        (1.6, [0, 0.05, 0.11, 1], {}, False),
        # where it stands still nothing is to follow, unless it must move
        (2, [0, 0, 0, 0.009], {}, True),
        (2, [0, 0, 0, 0.011], {}, False),
        (5, [0, 0, 0, 0], {"must_move": True}, False),
        (2.9, [0, 0, 0, 0.009], {"must_move": True}, True),
        (2.6, [0, 0, 0, 0.009], {"must_move": True}, False),
        # a start to six digits in one convention tells alone, if a half digit is left far away
        ([7, 1, 0.6, 0.6], [0, 0.2, 0.6, 1], {"is_named": True}, True),
        ([7, 1, 0.4, 0.4], [0, 0.2, 0.6, 1], {"is_named": True}, False),
        ([5, 1, 0.6, 0.6], [0, 0.2, 0.2, 0.2], {"is_named": True}, False),
    ],
)
def test_evidence_goes_with_the_motion(digits, moved, how, goes):
    evidence = comparison(digits).evidence
    assert evidence.follows(np.array(moved, dtype=float), **how) is goes


def test_a_fitted_number_follows_a_motion_that_has_gone_twice_as_plainly():
    far = np.array([0, 0.2, 0.6, 1.0])
    for digits, goes in ((1.7, True), (1.5, False)):
        assert comparison(digits, fitted=1).evidence.follows(far) is goes

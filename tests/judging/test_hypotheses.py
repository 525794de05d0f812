"""The one rule by which a hypothesis about a table is accepted: its edges, from both sides."""

import numpy as np
import pytest

from polhode.judging.tables.hypotheses import Evidence, Hypothesis, Trial, explains

NONE = np.zeros(4)


def comparison(digits, rival=NONE, goes=True, freedom=3, rows_fitted=0, **hypothesis):
    """Evidence of so many digits a row beside that of the table as it stands."""
    mine = np.broadcast_to(np.asarray(digits, dtype=float), (4,))
    evidence = Evidence(Hypothesis(**hypothesis), mine.copy(), rows_fitted, freedom)
    return Trial(evidence, Evidence(Hypothesis(), np.array(rival, dtype=float)), goes)


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


LATE = {"fitted": 1, "rows_fitted": 2}
WORSE = comparison(2, rival=np.full(4, 9.0))


def beside(mine, rival):
    """So many digits a row, where the table as it stands is right in its first half."""
    return [comparison([mine] * 4, [rival, rival, 0, 0])]


#: A rule: what it accepts, and what it does not.
RULES = {
    "a part goes with the motion": (
        [[comparison(8)]],
        [[comparison(8, goes=False)], [comparison(8), comparison(8, goes=False)]],
    ),
    "every part begins right, also one that is no better than it stands": (
        [[comparison(8), comparison(1.6)]],
        [[comparison(8), comparison(x)] for x in (1.4, 0)],
    ),
    "all parts together have more digits": (
        [[comparison(9.5), WORSE]],
        [[comparison(6.5), WORSE]],
    ),
    "digits beyond twelve are no more certain": (
        [[comparison(20, rival=np.full(4, 10.4))]],
        [[comparison(20, rival=np.full(4, x))] for x in (10.6, 12.0)],
    ),
    # later rows that are right again do not count, nor do rows that drift after right ones
    "what is wrong in the first rows is wrong": (
        [[comparison([8, 8, 1, 0])], [comparison([4, 0, 8, 8], freedom=1)]],
        [
            *([comparison([x, 8, 8, 8])] for x in (0, 1.4)),
            [comparison([2, 0, 8, 8], freedom=1)],
        ],
    ),
    # by more than digits of good rows differ: 0.3, or 1 where both are near the type's own
    "no row before the better one is worse": (
        [beside(5.8, 6.0), beside(9.2, 10.0)],
        [beside(5.6, 6.0), beside(8.8, 10.0)],
    ),
    "rows to which a number was fitted say nothing one by one": (
        [[comparison([0, 0, 8, 8], **LATE)]],
        [[comparison([8, 8, 0, 0], **LATE)], [comparison([8, 8, 8, 0], fitted=1, rows_fitted=4)]],
    ),
}


@pytest.mark.parametrize("rule", RULES)
def test_a_rule_accepts_and_refuses(rule):
    accepted, refused = RULES[rule]
    assert all(map(explains, accepted))
    assert not any(map(explains, refused))


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

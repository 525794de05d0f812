"""The stability study: every hard case is in it, and its checks can fail."""

from __future__ import annotations

from fractions import Fraction

import pytest

import polhode
from polhode.equations.readout import at_rest
from polhode.judging.correct_digits import worst_digits
from polhode.judging.limits import selected
from polhode.numbers import exact, number_types
from polhode.numbers.conversion import to_mpf
from polhode.numbers.number_types import DOUBLE, EXTENDED, QUAD
from polhode.scenes import library
from polhode.studies.stability import hard_cases, rows, there_and_back
from shared.reports import committed


def test_every_case_tagged_hard_is_in_the_study_once():
    names = hard_cases.names()
    assert len(names) == len(set(names))
    assert set(names) <= set(library.names())
    tagged = {name for name in library.names() if "hard" in polhode.load(name).tags}
    assert tagged <= set(names)
    assert set(hard_cases.QUICK) <= set(names)


@pytest.mark.parametrize(
    ("kind", "holds"),
    [
        ("Flips from next to the middle axis", lambda s: s.omega[0] * s.omega[1] != 0),
        ("Nearly equal moments", lambda s: 0 < s.body.moments[0] - s.body.moments[1] < 2e-12),
        ("Unstable equilibria and permanent rotations", lambda s: at_rest(s)[0]),
        (
            "Units that make the numbers huge or tiny",
            lambda s: abs(exact.log10(s.body.moments[0])) > 28,
        ),
        ("Needle and flat body", lambda s: min(s.body.moments) <= max(s.body.moments) / 2),
        ("A million units of time", lambda s: s.end == 10**6),
    ],
)
def test_the_cases_of_a_kind_are_what_it_says(kind, holds):
    for name in hard_cases.KINDS[kind]:
        assert holds(polhode.load(name)), name


# -- forward and back -------------------------------------------------------------------------


@pytest.mark.parametrize("number", [DOUBLE, EXTENDED, QUAD], ids=lambda n: n.name)
def test_a_regular_motion_comes_back(number):
    scene = polhode.load("euler/largest-axis")
    assert 0 < there_and_back.error(scene, number) < 1e4
    assert there_and_back.error(scene.at((Fraction(1, 8),)), number) < 20


def test_the_way_back_starts_where_the_motion_ended():
    scene = polhode.load("lagrange/nutation")
    end = polhode.reference(scene).at([scene.end], 40)[0]
    back = there_and_back.way_back(scene, scene.end, end)
    last = polhode.reference(back).at(back.times, 30)[-1]
    assert worst_digits([last], [[to_mpf(x, 200) for x in scene.start]], scene, 40) > 26


# -- page ------------------------------------------------------------------------------------------


def test_the_committed_study_names_the_reason_of_every_run_that_stays_behind():
    found = committed("stability")
    for case in found["cases"]:
        for run in case["runs"]:
            assert run["outcome"] == "reached end"
            if run["behind"] is not None and run["behind"] > 0:
                chance = run["behind"] <= selected(run.get("times", 1))
                named = ("method", "rounding", "unknown (steps of so thin a body")
                assert chance or run["limit"].startswith(named)
                assert run["inputs"] is not None
    assert {row["number"] for row in found["back"]} == {*number_types.NAMES[:3]}


@pytest.mark.parametrize(
    ("digits", "least", "behind"), [(10.0, 11.25, 1.25), (12.0, 11.25, -0.75), (10.0, None, None)]
)
def test_a_run_is_behind_by_what_it_lacks_of_the_least_expected(digits, least, behind):
    expected = None if least is None else [least, 12.0, 13.0]
    run = {"correct_digits": digits, "expected": expected, "lost": None}
    assert rows._judged(run)["behind"] == behind

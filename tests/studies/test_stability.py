"""The stability study: every hard case is in it, and its checks can fail."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest

import polhode
from polhode.equations.equilibrium import at_rest
from polhode.judging.diagnosis.error_budget import selected
from polhode.numbers import exact, number_types
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.number_types import DOUBLE, EXTENDED, QUAD
from polhode.scenes import library
from polhode.studies import report
from polhode.studies.accuracy import rows as accuracy
from polhode.studies.stability import hard_cases, limits, page, rows, symmetries


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


# -- powers of two ----------------------------------------------------------------------------


@pytest.mark.sample(3)
@pytest.mark.parametrize("number", [DOUBLE, EXTENDED, QUAD], ids=lambda n: n.name)
@pytest.mark.parametrize("name", ["euler/irrational", "lagrange/turned-axes", "hard/near-cusp"])
def test_powers_of_two_change_no_bit(name, number):
    assert symmetries.changed_by_units(polhode.load(name).at((Fraction(5),)), number) == 0


def test_other_powers_change_bits(monkeypatch):
    """The comparison sees a unit of time that is no power of two."""
    honest = symmetries.in_units
    monkeypatch.setattr(
        symmetries,
        "in_units",
        lambda scene, *exponents: replace(
            honest(scene, *exponents), omega=tuple(w * Fraction(3, 2) for w in scene.omega)
        ),
    )
    scene = polhode.load("euler/largest-axis").at((Fraction(1),))
    assert symmetries.changed_by_units(scene, DOUBLE) > 0


# -- rest -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "rest"),
    [
        ("pendulum/upright", (True, True)),
        ("hard/staude", (True, True)),
        ("euler/permanent-middle", (True, False)),
        ("euler/turned-permanent", (True, False)),
        ("lagrange/steady-slow", (False, False)),
        ("kovalevskaya/bobylev-steklov", (False, False)),
        ("lagrange/sleeping-unstable", (True, True)),
    ],
)
def test_rest_is_told_by_the_exact_equations(name, rest):
    assert at_rest(polhode.load(name)) == rest


def test_a_departure_from_rest_is_measured_in_eps():
    scene = polhode.load("lagrange/sleeping-unstable")
    start = [float(x) for x in scene.start]
    assert symmetries.departure([start], scene, DOUBLE) == 0
    moved = [*start[:5], start[5] - 3 * float(DOUBLE.eps)]
    assert symmetries.departure([start, moved], scene, DOUBLE) == pytest.approx(3)


# -- forward and back -------------------------------------------------------------------------


@pytest.mark.parametrize("number", [DOUBLE, EXTENDED, QUAD], ids=lambda n: n.name)
def test_a_regular_motion_comes_back(number):
    scene = polhode.load("euler/largest-axis")
    assert 0 < symmetries.there_and_back(scene, number) < 1e4
    assert symmetries.there_and_back(scene.at((Fraction(1, 8),)), number) < 20


def test_the_way_back_starts_where_the_motion_ended():
    scene = polhode.load("lagrange/nutation")
    end = polhode.reference(scene).at([scene.end], 40)[0]
    back = symmetries.way_back(scene, scene.end, end)
    last = polhode.reference(back).at(back.times, 30)[-1]
    with mpmath.workdps(40):
        for x, start in zip(last, scene.start, strict=True):
            assert abs(x - mpmath.mpf(start.numerator) / start.denominator) < 1e-27


# -- limits, page -----------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("limit", limits.LIMITS, ids=lambda limit: limit.what)
def test_beyond_each_limit_one_line_says_so(limit):
    row = limits._row(limit)
    assert row["as_expected"], row
    assert row["lines"]
    if limit.code == 2:
        assert len(row["lines"]) == 1
        assert row["lines"][0].startswith("polhode: ")
        assert ": expected " in row["lines"][0]


def test_the_list_of_runs_that_stay_behind_is_computed():
    run = {
        **{"number": "double", "outcome": "reached end", "steps": 7, "lost": "", "drift": {}},
        **{"correct_digits": 9.0, "expected": [12.0, 12.5, 13.0], "limit": "method (rounding)"},
        **{"inputs": 12.5},
    }
    case = {"case": "a/b", "regime": "r", "end": 1.0, "log10_kappa": 3.0, "kappa_note": ""}
    runs = [run | {"behind": 3.0}, run | {"number": "quad", "behind": -0.1}]
    found = {
        **{"units": [], "rest": [], "back": [], "limits": []},
        "kinds": [{"kind": "k", "cases": ["a/b"]}],
        "cases": [case | {"runs": runs}],
    }
    late = page.tables(found)["behind"]
    assert [row[:2] for row in late.rows] == [("a/b", "double")]
    assert late.rows[0][-1] == "method (rounding)"


def test_the_committed_study_names_the_reason_of_every_run_that_stays_behind():
    found = report.results(library.folder().parent / "reports", "stability")
    assert found is not None
    for case in found["cases"]:
        for run in case["runs"]:
            assert run["outcome"] == "reached end"
            if run["behind"] is not None and run["behind"] > 0:
                chance = run["behind"] <= selected(run.get("times", 1))
                named = ("method", "rounding", "unknown (steps of so thin a body")
                assert chance or run["limit"].startswith(named)
                assert run["inputs"] is not None
    assert all(row["changed"] == 0 for row in found["units"])
    assert {row["number"] for row in found["units"]} == {*number_types.NAMES[:3]}


# -- rows of the study of accuracy ------------------------------------------------------------


def test_a_case_is_made_once_in_a_process_the_longest_first_and_told_in_order(monkeypatch):
    made = []

    def case(scene):
        made.append(scene.name)
        return {"case": scene.name}

    monkeypatch.setattr(accuracy, "_made", {})
    monkeypatch.setattr(accuracy, "_case", case)
    names = ["euler/separatrix", "hard/million", "hard/near-cusp"]
    scenes = [library.load(name) for name in names]
    assert [row["case"] for row in accuracy.case_rows(scenes, 1)] == names
    assert sorted(made) == sorted(names)
    assert made[0] == "hard/million"
    accuracy.case_rows([*scenes, library.load("euler/rest")], 1)
    assert made[3:] == ["euler/rest"]


def test_a_run_is_behind_by_what_it_lacks_of_the_least_expected():
    run = {"correct_digits": 10.0, "expected": [11.25, 12.0, 13.0], "lost": None}
    assert rows._judged(run)["behind"] == 1.25
    assert rows._judged(run | {"correct_digits": 12.0})["behind"] == -0.75
    assert rows._judged(run | {"expected": None})["behind"] is None
    assert rows._judged({"outcome": "step limit"}) == {"outcome": "step limit"}

"""The study long-run: starts, growth, exponents, its page and figure."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import long_run
import make
import polhode
from shared.reports import committed, quick_results
from tops import random_scene

TIMES = [100.0, 316.0, 1000.0, 3162.0, 10000.0]


# exponents


@pytest.mark.parametrize("slope", [0.5, 1.0, 1.5])
def test_an_exact_power_law_gives_its_exponent(slope):
    members = [[c * t**slope for t in TIMES] for c in (1e-16, 2e-16, 3e-16)]
    fitted = long_run.exponent(TIMES, members, 100.0)
    assert (fitted["exponent"], fitted["uncertainty"]) == (slope, 0)
    bent = [[x * max(1.0, t / 1000) for x, t in zip(row, TIMES, strict=True)] for row in members]
    assert long_run.exponent(TIMES, bent, 100.0)["last_decade"] == slope + 1


@pytest.mark.slow
def test_the_uncertainty_covers_what_noise_does():
    """Random walks have 1/2: over 40 ensembles the pulls have a spread of about one."""
    dice = np.random.default_rng(5)
    pulls = []
    for _ in range(40):
        walks = np.abs(np.cumsum(dice.normal(size=(16, 10_000)), axis=1))
        members = [[walk[int(t) - 1] for t in TIMES] for walk in walks]
        fitted = long_run.exponent(TIMES, members, 100.0)
        pulls.append((fitted["exponent"] - 0.5) / fitted["uncertainty"])
    assert abs(np.mean(pulls)) < 0.6
    assert 0.5 < np.std(pulls) < 1.8


def test_what_cannot_be_fitted_is_not():
    nothing = dict.fromkeys(long_run.EXPONENTS)
    assert long_run.exponent(TIMES, [[0.0] * 5] * 3, 100.0) == nothing
    assert long_run.exponent(TIMES, [[1.0] * 5] * 3, 3000.0) == nothing


def walks(bias: float, kind: str) -> list[dict]:
    """A kind of top whose departures are random walks of unit steps, and a drift of so much."""
    dice, members = np.random.default_rng(11), []
    for _ in range(16):
        walk = np.cumsum(dice.normal(size=10_000)) + bias * np.arange(1, 10_001)
        departures = {"h": [float(walk[int(t) - 1]) for t in TIMES], "spin": [0.0] * len(TIMES)}
        members.append(long_run.Member({}, departures, None, []))
    rows = long_run._integrals(TIMES, members, 100.0)
    error = {"median": [0.0] * len(TIMES), "largest": [0.0] * len(TIMES), "exponent": None}
    method = {"method": "double", "error": error, "integrals": rows}
    return [{"top": kind, "starts": 16, "times": TIMES, "methods": [method]}]


def pulls_of(tops: list[dict]) -> dict[tuple[str, str], float]:
    """The means in their standard errors, as the page's table has them."""
    results = {"tops": tops, "at": {"t": 100, "tops": [], "not_run": {}}}
    shown = make.tables("long-run", results)["walks"]
    pull = shown.header.index("mean / its error")
    return {(row[0], row[1]): float(row[pull]) for row in shown.rows}


def test_a_bias_is_told_from_a_random_walk():
    """A walk's mean is off by its standard error; a hundredth of a step's bias by ten at 10^4."""
    (fair,) = walks(0.0, "euler")
    h, spin = fair["methods"][0]["integrals"]
    assert abs(h["exponent"] - 0.5) < 3 * h["uncertainty"] < 0.3
    assert abs(h["mean"][-1]) < 3 * h["deviation"][-1] / 4
    assert h["deviation"][-1] == pytest.approx(100, rel=0.5)
    assert spin["exponent"] is None
    pulls = pulls_of([fair])
    assert max(map(abs, pulls.values())) < 4
    (leaning,) = walks(0.02, "euler")
    assert leaning["methods"][0]["integrals"][0]["deviation"] == pytest.approx(h["deviation"])
    assert pulls_of([leaning])["euler", "h"] > 4


def test_mean_and_deviation_are_those_of_a_sample():
    departures = [{"h": row} for row in ([1.0, 5.0], [2.0, 5.0], [6.0, 5.0])]
    members = [long_run.Member({}, row, None, []) for row in departures]
    (h,) = long_run._integrals([100.0, 1000.0], members, 100.0)
    assert h["mean"] == [3.0, 5.0]
    assert h["deviation"] == pytest.approx([7**0.5, 0], abs=0.005)


def test_departures_have_signs():
    """A free body that turns faster by a part in 1e10, or slower, or whose vertical is longer."""
    scene = random_scene("euler", 0, (Fraction(1),))
    rows = np.array([[float(x) for x in scene.start]] * 3)
    rows[:2, :3] *= np.array([[1 + 1e-10], [1 - 1e-10]])
    rows[2, 3:] *= 1 + 1e-10
    relative = polhode.departures(scene, rows)
    for name, sizes in (("h", (2, -2, 0)), ("|G|^2", (2, -2, 0)), ("|gamma|^2", (0, 0, 2))):
        assert np.allclose(np.array(relative[name], float) / 1e-10, sizes, atol=1e-4), name
    assert float(relative["f"][0]) == pytest.approx(-float(relative["f"][1]), rel=1e-4)


# starts


@pytest.mark.parametrize("top", long_run.TOPS)
def test_starts_are_exact_alike_every_time_and_all_different(top):
    scenes, again = (
        [random_scene(top, k, (Fraction(1),)) for k in range(long_run.STARTS)] for _ in range(2)
    )
    assert [s.start for s in scenes] == [s.start for s in again]
    assert len({s.start for s in scenes}) == len({s.body for s in scenes}) == long_run.STARTS >= 16
    inexact = [s for s in scenes if any(float(x) != x for x in s.body.moments)]
    assert len(inexact) > long_run.STARTS / 2
    for scene in scenes:
        assert sum(x * x for x in scene.gamma) == 1
        truth = polhode.reference(scene)
        assert truth.is_closed_form
        assert truth.kind == top


def test_a_projected_member_beside_what_rounding_its_inputs_leaves():
    """Exact inputs leave nothing; the others an error that the run's own is of the size of."""
    scene = random_scene("lagrange", 2, (Fraction(100), Fraction(300)))
    member = long_run.follow(scene)
    assert all(1e-17 < x < 1e-13 for x in member.inputs)
    every = polhode.integrate(scene, "double").projection.every
    left = polhode.conditioning(scene).inputs("double", every)
    assert member.inputs == [10.0**-x for x in left]
    assert left != polhode.conditioning(scene).inputs("double")


# the study


@pytest.mark.slow
def test_a_small_study():
    results = quick_results("long-run")
    top = results["tops"][0]
    assert top["times"] == [10, 32, 100]
    assert top["starts"] == 2
    assert top["reference_error"] < 1e-20
    assert not top["wall"]
    plain = top["methods"][0]
    assert plain["method"] == "double"
    assert [row["integral"] for row in plain["integrals"]] == ["h", "f", "|gamma|^2", "|G|^2"]
    laws = {m["method"]: m["error"]["law"] for m in top["methods"]}
    assert laws == {"double": 1.5, "double projected": 1.0}
    assert plain["drift"]["law"] == 0.5
    assert len(top["methods"][1]["inputs"]["median"]) == 3
    assert len(plain["error"]["median"]) == len(plain["drift"]["largest"]) == 3
    assert all(1e-17 < x < 1e-12 for x in plain["error"]["median"])
    (row,) = results["at"]["tops"]
    (engine,) = row["methods"]
    assert engine["method"] == "heyoka by hand"
    assert engine["reached"] == 2
    assert 1e-17 < engine["median"] <= engine["largest"] < 1e-12


@pytest.mark.parametrize(
    "tops",
    [
        lambda: committed("long-run")["tops"],
    ],
    ids=["committed"],
)
def test_unprojected_runs_obey_brouwers_law(tops):
    for top in tops():
        plain = top["methods"][0]
        for name, law in long_run.BROUWER.items():
            fitted = plain[name]
            assert abs(fitted["exponent"] - law) < 4 * fitted["uncertainty"], (top["top"], name)
            assert fitted["uncertainty"] < 0.2

"""What programs like polhode's own studies take from it: cases, errors, departures, decimals."""

from __future__ import annotations

import io
from fractions import Fraction

import numpy as np
import pytest

import polhode

TOP = "lagrange/nutation"


def test_errors_of_states_are_the_digits_of_compare():
    run = polhode.integrate(TOP, at=[1, 5, 20])
    true = polhode.reference(TOP).at(run.times, 30)
    errors = polhode.state_errors(run.states, true, TOP)
    judgement = polhode.compare(run.states, TOP, at=run.times, as_it_stands=True)
    assert -np.log10(errors) == pytest.approx([*judgement.digits], abs=1e-9)
    moved = run.states.copy()
    moved[1, 4] += 1e-5
    assert polhode.state_errors(moved, true, TOP)[1] == pytest.approx(1e-5, rel=1e-6)
    with pytest.raises(polhode.BadInput, match="states = 2 rows: expected 3"):
        polhode.state_errors(run.states[:2], true, TOP)


def test_departures_are_those_of_the_drift_with_their_signs():
    run = polhode.integrate(TOP, "quad", at=[1, 5, 20], project=False)
    relative = polhode.departures(run.scene, run.states, run.number.bits)
    largest = [float(max(map(abs, column))) for column in relative.values()]
    assert largest == pytest.approx([x for x in run.drift if x is not None], rel=1e-12)
    states = np.array([[float(x) for x in run.scene.start]] * 2)
    states[1] *= [1, 1, 1, 1 + 1e-9, 1 + 1e-9, 1 + 1e-9]
    length = polhode.departures(run.scene, states)["|gamma|^2"]
    assert float(length[1]) == pytest.approx(2e-9, rel=1e-4)


@pytest.mark.parametrize(
    ("x", "digits", "text"),
    [
        (0.1, 3, "0.100"),
        (Fraction(2, 3), 5, "0.66667"),
        ("1/3", 4, "0.3333"),
        ("sqrt(2)", 20, "1.4142135623730950488"),
        (np.longdouble(1) / 3, 22, "0.3333333333333333333424"),
        (-12345, 2, "-1.2e+04"),
        (0, 7, "0"),
    ],
)
def test_a_decimal_is_rounded_once_from_the_exact_value(x, digits, text):
    assert polhode.as_decimal(x, digits) == text


@pytest.mark.parametrize(
    ("x", "digits", "message"),
    [
        (float("nan"), 5, "x = nan: expected a number"),
        ("one", 5, "x = one: expected a number"),
        (1, 0, "digits = 0: expected"),
    ],
)
def test_what_has_no_decimal_is_refused(x, digits, message):
    with pytest.raises(polhode.BadInput, match=message):
        polhode.as_decimal(x, digits)


def test_cases_are_those_that_load():
    names = polhode.cases().column("scene")
    assert len(names) > 150
    assert polhode.load(names[-1]).name == names[-1]
    chaotic = polhode.cases("chaotic")
    assert {*chaotic.column("scene")} < {*names}
    assert all("chaotic" in entry.tags for entry in chaotic.entries.values())
    with pytest.raises(polhode.BadInput, match="chaos"):
        polhode.cases("chaos")


def test_a_printed_figure_is_the_same_each_time_and_leaves_the_style_as_it_was():
    plt = pytest.importorskip("matplotlib.pyplot")
    before = plt.rcParams["font.size"]

    def svg() -> str:
        with polhode.paper() as paper:
            figure, axes = paper.subplots()
            axes.plot([0, 1], [0, 2], label="text")
            axes.legend()
            figure.savefig(out := io.StringIO(), format="svg", metadata={"Date": None})
            paper.close(figure)
        return out.getvalue()

    assert svg() == svg()
    assert ">text</text>" in svg()
    assert plt.rcParams["font.size"] == before

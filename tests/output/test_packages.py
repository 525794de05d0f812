"""polhode among other packages: tables, notebooks, bars, logs, and what studies take from it."""

import io
import logging
import re
import sys
import time
from dataclasses import replace
from fractions import Fraction
from itertools import count

import mpmath
import numpy as np
import pytest

import polhode
from polhode.common.interrupts import bar
from shared.tools import tiers

TOP = "lagrange/nutation"


def a_run(number="double", **how):
    """Events, angles, attitude; fewer times than the case."""
    scene = polhode.load(TOP).at([0, 0.5, 1, 2])
    scene = replace(scene, events=(polhode.Event("nutation"),))
    return polhode.integrate(scene, number, **how)


def test_a_run_that_is_not_found_again_to_the_bit_says_so(tmp_path):
    run = a_run()
    moved = np.array(run.states)
    moved[-1, 0] = np.nextafter(moved[-1, 0], 2)
    replace(run, states=moved).save(tmp_path / "run.npz")
    again = polhode.load_run(tmp_path / "run.npz")
    with pytest.warns(UserWarning, match="differs from the one in the file"):
        again(1.5)


@pytest.mark.parametrize("number", tiers(["double"], ["quad"]))
def test_angles_and_attitude_at_any_time_are_the_closed_forms(number):
    run, exact = a_run(number), polhode.reference(TOP)
    times = [1.75, 0, "1/3", 1.75]
    for own, true in (
        (run.angles_at(times), exact.angles([1.75, 0, mpmath.mpf(1) / 3, 1.75], 40)),
        (run.attitude_at(times), exact.attitude([1.75, 0, mpmath.mpf(1) / 3, 1.75], 40)),
    ):
        off = max(
            abs(mpmath.mpf(x) - y)
            for a, b in zip(own, true, strict=True)
            for x, y in zip(a, b, strict=True)
        )
        assert off < 200 * float(run.number.eps)
    assert run.angles_at(2)[0] == run.angles[-1][0]
    with pytest.raises(polhode.BadInput, match="a time from 0 to 2"):
        run.angles_at(2.5)


def test_angles_past_a_pole_where_they_end_are_refused():
    """The state goes on; psi and phi are integrated no farther."""
    run = polhode.integrate(replace(polhode.load("lagrange/upper-pole"), outputs=()), at=[100])
    assert run.outcome.done
    with pytest.raises(polhode.BadInput) as refused:
        run.angles_at([1, 40])
    assert re.fullmatch(
        r"lagrange/upper-pole: t = 40: expected a time at which there are angles; "
        r"a state or a step became infinite or undefined at t = 1\d\.\d+",
        str(refused.value),
    )


def test_an_interrupt_of_a_run_made_again_goes_on(monkeypatch):
    def interrupted(motion, times, most, rows, *_):
        return rows, polhode.Outcome.INTERRUPTED

    run = a_run()
    monkeypatch.setattr("polhode.taylor.motion.Motion.advance", interrupted)
    for at in (run, run.angles_at):
        with pytest.raises(KeyboardInterrupt):
            at([1.5])


# -- other packages -----------------------------------------------------------------------------


@pytest.mark.slow
def test_a_run_as_a_data_frame_and_a_dataset():
    pytest.importorskip("pandas")
    pytest.importorskip("xarray")
    run = a_run()
    frame, dataset = run.to_pandas(), run.to_xarray()
    names = ["p", "q", "r", "gamma1", "gamma2", "gamma3", "psi", "theta", "phi"]
    assert list(frame.columns) == [*names, "q0", "q1", "q2", "q3"]
    assert frame.index.name == "t"
    assert np.array_equal(frame[names[:6]].to_numpy(), run.states)
    assert np.array_equal(dataset["q2"].sel(t=0.5), run.attitude[1][2])
    assert dataset.attrs["scene"] == TOP
    assert polhode.compare(frame, TOP).digits == polhode.compare(dataset, TOP).digits
    quad = a_run("quad").to_pandas()
    assert quad["p"].iloc[1]._mpf_ == a_run("quad").states[1][0]._mpf_
    pole = polhode.integrate("lagrange/upper-pole", at=[0, 1]).to_pandas()
    assert pole.isna().any().any() == any(
        x is None
        for row in polhode.integrate("lagrange/upper-pole", at=[0, 1]).angles or []
        for x in row
    )


def test_an_ensemble_as_a_dataset_and_a_data_frame():
    pytest.importorskip("pandas")
    pytest.importorskip("xarray")
    varied = {"start.omega[3]": "2:4:3"}
    many = polhode.integrate_many(TOP, varied, at=[0, 1])
    dataset = many.to_xarray()
    assert dict(dataset.sizes) == {"member": 3, "t": 2}
    assert np.array_equal(dataset["gamma2"], many.states[..., 4])
    assert dataset["start.omega[3]"].values.tolist() == [[2, 2], [3, 3], [4, 4]]
    frame = many.to_pandas()
    assert frame.loc[(2, 1.0), "r"] == many.states[1, 1, 2]


@pytest.mark.parametrize("package", ["pandas", "xarray"])
def test_a_package_that_is_missing_is_named_with_its_extra(monkeypatch, package):
    monkeypatch.setitem(sys.modules, package, None)
    run = polhode.integrate(TOP, at=[1])
    with pytest.raises(polhode.BadInput, match=rf"{package}.*pip install 'polhode\[frames\]'"):
        getattr(run, f"to_{package}")()


@pytest.mark.slow
def test_what_a_notebook_shows_is_short_and_escaped():
    run = replace(polhode.integrate(TOP), scene=replace(polhode.load(TOP), title="a < b"))
    many = polhode.integrate_many(TOP, {"start.omega[3]": "2:4:3"}, at=[0, 1])
    for value in (run.scene, run, many, polhode.compare(run), polhode.view(TOP, end=1)):
        text = value._repr_html_()
        assert "<b" not in text.replace("<body", "")
        if not isinstance(value, polhode.Page):
            assert len(text) < 12_000


# -- the terminal -------------------------------------------------------------------------------


def test_a_bar_is_shown_when_it_is_asked_for(capsys):
    pytest.importorskip("tqdm")
    run = polhode.integrate("euler/long", progress=True, max_steps=2000)
    assert "euler/long" in capsys.readouterr().err
    assert run == polhode.integrate("euler/long", progress=False, max_steps=2000)
    polhode.integrate_many(TOP, {"start.omega[3]": "2:4:3"}, at=[0, 1], progress=True)
    assert TOP in capsys.readouterr().err


def test_without_tqdm_a_bar_is_one_line_on_a_terminal(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "tqdm", None)
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    seconds = count(step=2)
    monkeypatch.setattr(time, "monotonic", lambda: next(seconds))
    with bar("euler/long") as tell:
        tell(0.25, 7)
    shown = capsys.readouterr().err
    assert shown == "\r\x1b[Keuler/long: 25.0 %, 7 done\r\x1b[K"


def test_a_run_logs_what_it_did(caplog):
    with caplog.at_level(logging.INFO, logger="polhode"):
        polhode.integrate(TOP, at=[1])
    (record,) = caplog.records
    assert re.match(
        r"lagrange/nutation: double \(53 bits\), reached end after \d+ steps", record.message
    )


# -- What programs like polhode's own studies take from it: cases, errors, departures, decimals ----


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


def test_a_printed_figure_is_the_same_each_time_and_leaves_matplotlib_as_it_was():
    plt = pytest.importorskip("matplotlib.pyplot")
    plt.switch_backend("agg")
    before = plt.rcParams.copy()

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
    assert plt.rcParams == before
    assert plt.get_backend() == "agg"

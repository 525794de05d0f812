"""Frequency analysis: known lines, closed forms, files, and honest errors."""

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.dynamics import naff
from polhode.dynamics.naff import leak
from shared.tables import of_run, through
from shared.tools import tiers


@pytest.mark.slow
def test_which_lines_a_top_has():
    """p + iq: minus proper rotation plus multiples of the nutation; the axis: precession."""
    lines = polhode.frequencies("lagrange/nutation", of=["p+iq", "axis"], end=200).lines
    assert all(line.combination["proper rotation"] == -1 for line in lines["p+iq"])
    assert all(line.combination["precession"] == 1 for line in lines["axis"])
    assert {line.combination.get("nutation", 0) for line in lines["axis"]} == {-2, -1, 0, 1, 2, 3}
    free = polhode.frequencies("euler/attitude", of=["axis"], end=200).lines["axis"]
    assert all(line.combination["precession"] == 1 for line in free)
    assert {line.combination.get("polhode", 0) % 2 for line in free} == {0}


def test_the_axis_of_a_run_that_begins_later_has_the_same_lines():
    """G of the first sample, not of the scene's start."""
    scene = polhode.load("euler/attitude")
    options = replace(scene, outputs=("attitude",), events=())
    analysis = [
        polhode.frequencies(
            polhode.integrate(options, at=[first + k * Fraction(1, 8) for k in range(1601)]),
            of=["axis"],
            lines=3,
        ).lines["axis"]
        for first in (0, Fraction(7, 3))
    ]
    for line, again in zip(*analysis, strict=True):
        assert abs(line.frequency - again.frequency) < 2 * (line.error + again.error)
        assert abs(line.amplitude) == pytest.approx(abs(again.amplitude), rel=1e-9)
        assert dict(line.combination) == dict(again.combination)


@pytest.mark.slow
def test_without_a_closed_form_lines_are_named_by_each_other():
    analysis = polhode.frequencies("general/asymmetric-regular", end=1500, lines=4)
    assert not analysis.closed_form
    assert len(analysis.known) == 2
    named = [line for lines in analysis.lines.values() for line in lines if line.combination]
    assert len(named) >= 5


def test_a_chaotic_motion_has_no_sharp_lines():
    (lines,) = polhode.frequencies(
        "general/asymmetric-chaotic", of=["gamma3"], end=200
    ).lines.values()
    assert not any(line.combination for line in lines)
    assert all(line.error > 1e-5 for line in lines)


def test_a_file_with_other_steps_is_refused(tmp_path):
    path = tmp_path / "x.csv"
    path.write_text("t,r\n" + "".join(f"{k * k},{k}\n" for k in range(80)))
    with pytest.raises(polhode.BadInput, match="equally spaced times"):
        polhode.frequencies(path)
    path.write_text("t,r\n" + "".join(f"{k},{k}\n" for k in range(40)))
    with pytest.raises(polhode.BadInput, match="64 samples or more"):
        polhode.frequencies(path)


ON_THE_WAY = {
    "frequencies": lambda: polhode.frequencies("lagrange/nutation", end=1),
    "plot": lambda: polhode.plot("lagrange/nutation", "omega", end=1),
}


@pytest.mark.parametrize("options", ON_THE_WAY)
def test_ctrl_c_is_not_the_scene_s_fault(options, monkeypatch):
    """The run on the way was interrupted: so is what was asked for, and no key is bad."""

    def pressed(motion, times, most, rows, *_):
        return rows, polhode.Outcome.INTERRUPTED

    monkeypatch.setattr("polhode.taylor.motion.Motion.advance", pressed)
    with pytest.raises(KeyboardInterrupt):
        ON_THE_WAY[options]()


# -- Errors of frequencies: time that falls, closed forms both ways, and estimates that are wrong --

HALVES = {"s1", "s2", "u", "v"}  # of separated variables: the state has twice their period


def against(case: str, of: list[str], end: str, count: int = 4) -> list[tuple[float, float, float]]:
    """(frequency, its true error, the claimed one) of each line that is named."""
    exact = polhode.reference(case).frequencies
    exact |= {f"{name}/2": value / 2 for name, value in exact.items() if name in HALVES}
    analysis = polhode.frequencies(case, of=of, end=end, lines=count)
    rows = []
    for line in (line for lines in analysis.lines.values() for line in lines if line.combination):
        right = sum(k * exact[name] for name, k in line.combination.items())
        rows.append((line.frequency, abs(float(right - line.frequency)), line.error))
    return rows


def lines_of(folder, signal, step, count):
    """The lines of a complex signal, which stands in a file."""
    table = {"t": step * np.arange(len(signal)), "p": signal.real, "q": signal.imag}
    path = through("csv", table, folder)
    return polhode.frequencies(path, of=["p+iq"], lines=count).lines["p+iq"]


def test_lines_of_a_made_up_signal(tmp_path):
    """Frequencies of t, whichever way the samples run; amplitudes at the first of them."""
    t = 0.1 * np.arange(4001)
    results = [(1.2345678901234567, 1.0), (-0.76543210987654321, 0.3j), (2.7182818284590452, -1e-3)]
    for step in (0.1, -0.1):
        signal = sum(a * np.exp(1j * om * t * math.copysign(1, step)) for om, a in results)
        for line, (om, a) in zip(lines_of(tmp_path, signal, step, 3), results, strict=True):
            assert abs(line.frequency - om) < 3e-14
            assert abs(line.frequency - om) <= line.error < 1e-9
            assert abs(line.amplitude - a) < 1e-11 * abs(a) + 1e-13
    assert len(lines_of(tmp_path, signal, -0.1, 50)) < 50  # it ends where the signal does
    assert lines_of(tmp_path, 0 * signal, 0.1, 3) == ()


@pytest.mark.parametrize("end", tiers(["-200"], ["200"]))
def test_an_error_of_a_top_is_covered_and_not_by_much(end):
    """Real and complex signals, both directions in time, windows off any grid."""
    rows = against("lagrange/nutation", ["p+iq", "gamma3", "r", "axis"], end)
    assert all(off <= error for _, off, error in rows)
    factors = [error / max(off, 2**-53 * abs(om)) for om, off, error in rows]
    assert min(off / abs(om) for om, off, _ in rows) < 1e-12
    assert len(rows) >= 5
    assert np.median(factors) < 100


@pytest.mark.slow
def test_a_file_with_falling_times(tmp_path):
    run = polhode.integrate("lagrange/nutation", at=[-k / 10 for k in range(1, 2001)])
    path = through("csv", of_run(run), tmp_path)
    exact = polhode.reference("lagrange/nutation").frequencies
    by_file = polhode.frequencies(path).lines["gamma3"][0]
    assert by_file.combination
    for result in (polhode.frequencies(path), polhode.frequencies(run)):
        line = result.lines["p+iq"][0]
        assert abs(line.frequency + float(exact["proper rotation"])) <= line.error < 1e-11
        (line, *_) = result.lines["gamma3"]
        assert abs(line.frequency - float(exact["nutation"])) <= line.error < 1e-11
        assert abs(line.frequency - by_file.frequency) < 1e-14


def quasi_periodic(rng: np.random.Generator, least: float) -> tuple:
    """Up to four lines at least so many 2 pi/T apart; samples, step, frequencies."""
    n, step = int(rng.integers(1000, 2000)), 0.1
    unit = 2 * np.pi / (step * (n - 1))
    apart = least * unit * (1 + 2 * rng.random(int(rng.integers(1, 5))))
    om = rng.uniform(-3, 0) + np.cumsum(apart)
    a = rng.uniform(0.01, 1, len(om)) * np.exp(2j * np.pi * rng.random(len(om)))
    return np.exp(1j * np.outer(step * np.arange(n), om)) @ a, step, om


@pytest.mark.parametrize(("least", "most"), [(0.3, 100), (7, 300), (30, 100)])
def test_claims_cover_lines_near_and_far(least, most, tmp_path):
    rng, factors, sharp = np.random.default_rng(7), [], []
    for _ in range(6):
        signal, step, om = quasi_periodic(rng, least)
        for line in lines_of(tmp_path, signal, step, len(om)):
            off = float(np.min(np.abs(om - line.frequency)))
            assert off <= line.error
            factors.append(line.error / max(off, 2**-50 * abs(line.frequency)))
            sharp.append(line.error < 1e-5 * 2 * np.pi / (step * (len(signal) - 1)))
    assert np.median(factors) < most
    if least >= 12:
        assert np.mean(sharp) > 0.95


def test_two_lines_within_one_bin_claim_no_digits(tmp_path):
    """Equal ones make a line between them in every window: only what they leave betrays them."""
    t = 0.1 * np.arange(2001)
    unit = 2 * np.pi / t[-1]
    for apart in (0.01, 0.1, 0.5):
        signal = np.exp(1j * t) + np.exp(1j * (1 + apart * unit) * t)
        (line,) = lines_of(tmp_path, signal, 0.1, 1)
        off = min(abs(line.frequency - 1), abs(line.frequency - 1 - apart * unit))
        assert off == pytest.approx(apart * unit / 2, rel=0.1)
        assert off <= line.error < 12 * off


@pytest.mark.parametrize("by", [1, -1, 0.37])
def test_a_wrong_line_cannot_claim_digits(monkeypatch, by):
    """A refinement that ends off by some of 2 pi/T, in every window: the estimate tells."""
    right = naff._refined

    def wrong(weighted, time, start, cell, most):
        return right(weighted, time, start, cell, most) + by * 2 * math.pi / time[-1]

    signal, step, om = quasi_periodic(np.random.default_rng(3), 20)
    monkeypatch.setattr(naff, "_refined", wrong)
    for line in naff.lines(signal, step, len(om)):
        assert np.min(np.abs(om - line.frequency)) <= line.error


def test_a_stuck_refinement_cannot_claim_digits(monkeypatch, tmp_path):
    """The nearest point of the grid, which the second window does not share."""
    stuck = "polhode.dynamics.naff._refined"
    monkeypatch.setattr(stuck, lambda weighted, time, start, cell, most: start)
    signal, step, om = quasi_periodic(np.random.default_rng(4), 20)
    result = lines_of(tmp_path, signal, step, len(om))
    assert any(np.min(np.abs(om - line.frequency)) > 1e-3 for line in result)
    assert all(np.min(np.abs(om - line.frequency)) <= line.error for line in result)


def test_how_far_a_line_shifts_another():
    """Of the maximum of two lines alone: the envelope is reached, and never passed."""
    n = 4001
    window = naff._Window(n, 1.0, 8)
    for bins in (1.6, 4.0, 9.0, 14.0):
        shifts = []
        for phase in np.linspace(0, 2 * np.pi, 24, endpoint=False):
            second = 1e-3 * np.exp(1j * (phase + bins * window.bin * window.time))
            shifts.append(window.line(1 + second, 0.0)[0] / window.bin)
        largest = max(map(abs, shifts)) / 1e-3
        bound = float(leak(np.array([bins]), naff.POWER)[0])
        assert 0.5 * bound < largest < 1.02 * bound

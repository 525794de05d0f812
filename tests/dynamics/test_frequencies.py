"""Frequency analysis: known lines, closed forms, files, and honest errors."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction

import pytest

import polhode
from polhode.cli import main
from polhode.taylor.motion import Motion


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


@pytest.mark.slow
def test_frequencies_verb(tmp_path, capsys):
    assert main(["frequencies", "euler/attitude", "--end", "200", "--of", "r", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["columns"]["combination"][0] == "2 polhode"
    pytest.importorskip("matplotlib")
    figure = tmp_path / "f.svg"
    assert main(["frequencies", "euler/attitude", "--end", "200", "-o", str(figure)]) == 0
    assert main(["frequencies", "euler/attitude", "--end", "200"]) == 0
    output = capsys.readouterr()
    assert "- polhode" in output.out
    assert "closed form: precession" in output.err
    assert "spectrum p+iq" in figure.read_text()


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

    monkeypatch.setattr(Motion, "advance", pressed)
    with pytest.raises(KeyboardInterrupt):
        ON_THE_WAY[options]()

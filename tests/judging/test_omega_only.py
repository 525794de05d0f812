"""gamma of files that hold omega alone."""

from __future__ import annotations

import json
from fractions import Fraction

import pytest

import polhode
from polhode import cli
from polhode.judging.diagnosis.omega_only import SAMPLES, omega_alone
from polhode.numbers.mpmath_context import mpmath

BITS = 150


def found(name: str, spacing: Fraction, change=lambda row: row):
    scene = polhode.load(name)
    times = [spacing * k for k in range(-10, 11)]
    ahead, behind = times[10:], times[9::-1]
    truth = polhode.reference(scene)
    rows = truth.at(behind, 40)[::-1] + truth.at(ahead, 40)
    with mpmath.workprec(BITS):
        omega = [change(row[:3]) for row in rows]
    return omega_alone(scene, times, omega, rows, BITS)


@pytest.mark.parametrize("name", ["kovalevskaya/generic", "lagrange/turned-axes"])
def test_gamma_comes_back_as_the_derivative_does(name):
    """The error of a derivative from nine samples falls like the eighth power of their distance."""
    coarse, fine = found(name, Fraction(1, 10)), found(name, Fraction(1, 40))
    assert 4.5 < coarse.digits < fine.digits - 4
    assert fine.digits < coarse.digits + 6
    for it in (coarse, fine):
        assert it.derivative - 0.5 < it.digits < it.derivative + 5
        assert it.drift.gamma < 100 * 10.0**-it.digits
        assert it.drift.f < 100 * 10.0**-it.digits
        assert it.drift.h < 1e-30


def test_what_is_no_motion_of_the_body_shows_in_the_length_of_gamma():
    """omega of the right motion a thousandth too large: smooth, but no solution."""
    it = found(
        "kovalevskaya/generic", Fraction(1, 40), lambda row: [x * mpmath.mpf("1.001") for x in row]
    )
    assert it.derivative > 9
    assert 1e-4 < it.drift.gamma < 1e-1


def test_where_omega_says_nothing():
    assert found("euler/largest-axis", Fraction(1, 10)) is None  # no torque
    scene = polhode.load("kovalevskaya/generic")
    few = [Fraction(k) for k in range(SAMPLES - 1)]
    assert omega_alone(scene, few, [[1, 0, 0]] * len(few), [[0] * 6] * len(few), BITS) is None
    twice = [Fraction(0)] * SAMPLES
    assert omega_alone(scene, twice, [[1, 0, 0]] * SAMPLES, [[0] * 6] * SAMPLES, BITS) is None


def test_compare_says_it_of_a_file(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    scene = polhode.load("lagrange/nutation")
    run = polhode.integrate(scene.at(tuple(Fraction(k, 20) for k in range(21))))
    pairs = zip(run.times, run.states, strict=True)
    lines = [",".join(repr(float(x)) for x in (t, *row[:3])) for t, row in pairs]
    (tmp_path / "omega.csv").write_text("\n".join(["t,p,q,r", *lines]) + "\n")
    assert cli.main(["compare", "omega.csv", "lagrange/nutation"]) == 0
    told = capsys.readouterr().out
    assert (
        "from omega, its derivative and the energy (Yehia, Rigid Body Dynamics, eq. 3.60)" in told
    )
    assert "digits or more, and so far omega satisfies the body's equations\n" in told
    assert cli.main(["compare", "omega.csv", "lagrange/nutation", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)["omega_alone"]
    assert answer["gamma_digits"] >= answer["derivative_digits"] > 5
    assert float(answer["drift"]["gamma"]) < 1e-4


@pytest.mark.parametrize(("spacing", "factor"), [(Fraction(5), 1), (Fraction(1, 40), 100)])
def test_compare_prints_nothing_where_nothing_is_concluded(spacing, factor):
    """Samples too far apart; omega in another unit.  JSON has the numbers."""
    scene = polhode.load("lagrange/nutation")
    run = polhode.integrate(scene.at(tuple(k * spacing for k in range(21))))
    columns = dict(zip("pqr", factor * run.states[:, :3].T, strict=True))
    judged = polhode.compare({"t": [float(t) for t in run.t]} | columns, scene, as_it_stands=True)
    assert judged.omega_alone is not None
    assert not judged.omega_alone.concludes
    assert "gamma from omega" not in str(judged)


def test_the_sentence_says_what_the_numbers_mean():
    def told(spacing, factor):
        change = mpmath.mpf(factor)
        return str(found("kovalevskaya/generic", spacing, lambda row: [x * change for x in row]))

    assert told(Fraction(1, 40), 1).endswith("and so far omega satisfies the body's equations")
    wrong = told(Fraction(1, 40), "1.001")
    digits = float(wrong.rpartition(" omega satisfies the body's equations to ")[2])
    assert 1 < digits < 4
    assert "3.60" in wrong
    assert "Yehia" in wrong
    assert told(Fraction(5), 1).endswith(
        "the samples are too far apart for derivatives: no conclusion"
    )

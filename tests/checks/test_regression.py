"""The regression itself: it passes, and it fails when anything is corrupted."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction

import pytest

import polhode
from polhode import cli
from polhode.checks import published_figures, regression
from polhode.closed_forms.euler import top
from polhode.closed_forms.families import FAMILIES
from polhode.equations.forms import principal
from polhode.numbers import number_types
from polhode.scenes import library
from polhode.scenes.scene import Published

CHANGE = 1 + Fraction(1, 10**20)  # a relative change far below anything a double shows


def test_every_case_loads_and_expects_something():
    names = library.names()
    assert len(names) >= 45
    for name in names:
        scene = polhode.load(name)
        assert scene.expect, name
        assert scene.title, name
        assert scene.times, name
        if name.startswith("published/"):
            assert scene.published, name
            assert scene.cite, name


def test_every_regime_of_the_euler_top_has_a_case():
    regimes = {polhode.reference(n).regime for n in library.names() if n.startswith("euler/")}
    for wanted in (
        *("rest", "sphere", "separatrix", "largest-moment", "smallest-moment", "middle-moment"),
        *("oblate", "prolate", "polhode", "permanent"),
    ):
        assert any(wanted in regime for regime in regimes), wanted


def test_every_family_and_every_regime_of_the_lagrange_top_and_the_pendulum_has_a_case():
    regimes = set()
    for family in FAMILIES:
        truths = [polhode.reference(name) for name in library.matching([f"{family.name}/*"])]
        assert all(truth.is_closed_form for truth in truths), family.name
        regimes |= {truth.regime for truth in truths if truth.kind in ("lagrange", "pendulum")}
    assert regimes >= {
        *("nutation", "cusped", "looping", "hanging", "homoclinic to the sleeping top"),
        *("steady precession, slow", "steady precession, fast", "spherical pendulum"),
        *("sleeping, stable", "sleeping, unstable", "sleeping, critical spin"),
        *("through the upper pole", "through the lower pole"),
        *("planar pendulum, librating", "planar pendulum, rotating", "planar pendulum, separatrix"),
        *("pendulum, librating", "pendulum, rotating", "pendulum, separatrix"),
        *("rest, hanging", "rest, upright"),
    }


def test_every_type_and_class_of_the_kovalevskaya_top_has_a_case():
    truths = [polhode.reference(n) for n in library.names() if n.startswith("kovalevskaya/")]
    assert {truth.kind for truth in truths} == {"kovalevskaya"}
    assert {truth.regime for truth in truths} >= {
        *("-e+ (complex pair)", "-eee+", "e-+ (complex pair)", "e-ee+", "ee-e+", "eee-+"),
        *("Delaunay", "Appelrot, special motion", "Bobylev-Steklov"),
        *("pendulum about an equatorial axis", "pendulum about the axis of symmetry"),
        *("degenerate curve, quasi-periodic", "degenerate curve, asymptotic"),
        "multiply degenerate curve",
    }


def corrupt(module, function, which, monkeypatch):
    """One of the numbers that a function gives, changed by 1e-20 of itself."""
    honest = getattr(module, function)

    def corrupted(*arguments):
        numbers = honest(*arguments)
        return numbers | {which: numbers[which] * CHANGE}

    monkeypatch.setattr(module, function, corrupted)


@pytest.mark.sample(2)
@pytest.mark.parametrize("which", ["p.qr", "q.rp", "p.gamma2", "q.gamma1"])
def test_a_corrupted_equation_of_the_lagrange_top_fails(which, monkeypatch):
    corrupt(principal, "coefficients", which, monkeypatch)
    report = next(regression.check(["lagrange/nutation"], ["quad"]))
    assert not report.passed


@pytest.mark.campaign
def test_the_whole_library_passes():
    """What ``polhode check`` says, which CI runs: once is enough, for minutes that it takes."""
    found = regression.check(workers=2)
    failed = [report.scene.name for report in found if report.passed is not True]
    assert not failed


@pytest.mark.slow
def test_without_a_band_nothing_passes_or_fails_and_lost_digits_are_words(tmp_path, capsys):
    path = tmp_path / "own.toml"
    text = (library.folder() / "euler" / "separatrix.toml").read_text()
    path.write_text(text.partition("[expect]")[0].replace("end = 30", "end = 400"))
    report = next(regression.check([str(path)], ["double"]))
    assert report.passed is None
    assert cli.main(["check", str(path), "--number", "double"]) == 2
    out, err = capsys.readouterr()
    assert "expected a case with bands of digits ([expect])" in err
    assert "no digits left after t = 100: no band" in out
    assert "0.00" not in out
    assert out.endswith("0 passed, 0 failed, 1 without a band\n")
    assert cli.main(["check", str(path), "--number", "double", "--json"]) == 2
    found = json.loads(capsys.readouterr().out)
    assert found["passed"] is None
    (run,) = found["cases"][0]["runs"]
    assert run["correct_digits"] is run["passed"] is None


@pytest.mark.sample(2, first=2)
@pytest.mark.parametrize("name", ["euler/largest-axis", "published/nasa-brick", "euler/sphere"])
def test_a_case_passes(name):
    assert next(regression.check([name])).passed


@pytest.mark.slow
def test_cases_shared_by_processes_give_the_same_reports():
    names = ["euler/rest", "euler/sphere", "staude/stable"]
    one, two = ([*regression.check(names, ["double"], workers=n)] for n in (1, 2))
    assert [report.scene.name for report in two] == names
    assert [report.lines[0].digits for report in one] == [r.lines[0].digits for r in two]
    assert [report.lines[0].limit for report in one] == [r.lines[0].limit for r in two]


@pytest.mark.sample(1)
@pytest.mark.parametrize("which", ["p.qr", "q.rp", "r.pq"])
def test_a_corrupted_equation_of_motion_fails(which, monkeypatch):
    corrupt(principal, "coefficients", which, monkeypatch)
    report = next(regression.check(["euler/largest-axis"]))
    assert not report.passed
    bad = {line.number for line in report.lines if not line.passed}
    assert bad == {"quad", "mp"}  # 1e-20 is below what a double or an extended can show


NUMBERS = [
    *("G2", "k2", "kc2", "rate2"),
    *(f"{name} {i}" for name in ("moments", "squares", "phase", "shift") for i in range(3)),
]


@pytest.mark.sample(3)
@pytest.mark.parametrize("which", NUMBERS)
def test_each_corrupted_number_of_the_closed_form_fails(which, monkeypatch):
    """Every exact number that the Euler top's closed form uses, changed by 1e-20 of itself."""
    honest, (name, *places) = top.numbers, which.split()

    def corrupted(*arguments):
        right = honest(*arguments)
        value = getattr(right, name)
        if not places:
            return replace(right, **{name: value * CHANGE})
        wrong = [x * CHANGE if str(i) in places else x for i, x in enumerate(value)]
        return replace(right, **{name: tuple(wrong)})

    monkeypatch.setattr(top, "numbers", corrupted)
    report = next(regression.check(["euler/largest-axis"], ["quad"]))
    assert not report.passed


def test_digits_above_the_band_fail_too():
    scene = polhode.load("euler/largest-axis")
    slack = replace(scene, expect={"double": (1.0, 9.0)})
    report = regression.check_scene(slack)
    assert not report.passed
    assert report.lines[0].verdict == "more digits than the case can have"


def test_a_run_that_does_not_reach_its_end_fails(monkeypatch):
    monkeypatch.setattr(regression, "conditioning", lambda *_, **__: None)  # kappa takes long, too
    scene = polhode.load("euler/largest-axis").at((Fraction(10) ** 30,))
    report = regression.check_scene(replace(scene, expect={"double": (1.0, 9.0)}))
    assert not report.passed
    assert report.lines[0].verdict == "step limit"


def test_an_unknown_number_type_is_refused():
    with pytest.raises(polhode.BadInput, match="double"):
        list(regression.check(["euler/sphere"], ["dobule"]))


# -- published figures ------------------------------------------------------------------------


def figure(
    value: str, right: int | None = None, quantity: str = "p"
) -> published_figures.PrintedFigure:
    scene = replace(
        polhode.load("published/orekit"),
        published=(Published(Fraction(20), quantity, value, "by hand", right),),
    )
    return published_figures.figures(scene, polhode.reference(scene))[0]


def test_a_printed_figure_stands_if_rounded_or_cut_off_from_ours():
    """3.3256121802383088253058...: rounded and cut off stand, a unit further does not."""
    assert figure("3.3256121802383088").passed
    assert figure("3.32561218023830882531").passed
    assert figure("3.32561218023830882530").passed
    assert not figure("3.32561218023830882532").passed
    assert not figure("3.32561218023830882529").passed
    assert not figure("3.3256121802383086").passed
    assert figure("3.32561218023830882530588").ours == "3.3256121802383088253058840"


@pytest.mark.parametrize(
    ("value", "right", "passed", "verdict"),
    [
        ("3.3256121999", 7, True, "8 of 11 digits right"),
        ("3.3256121999", 8, True, "8 of 11 digits right"),
        ("3.3256121999", 9, False, "8 of 11 digits right, where 9 are expected: differs by 2.0e"),
        ("3.3256121999", None, False, "8 of 11 digits right, where all are expected: differs by 2"),
        ("3.32561218023", 5, True, "all 12 digits right"),  # cut off: 3.325612180238...
        ("3.32561218023", 13, False, "all 12 digits right, where 13 are expected"),
        ("3.4", 0, True, "1 of 2 digits right"),
        ("3.4", 2, False, "1 of 2 digits right, where 2 are expected: differs by 0.074"),
        ("-3.4", 0, True, "0 of 2 digits right"),
    ],
)
def test_right_is_the_fewest_digits_that_are_right(value, right, passed, verdict):
    found = figure(value, right)
    assert found.passed == passed
    assert found.verdict.startswith(verdict)


def test_a_figure_of_what_is_0_has_all_its_digits_right_or_none():
    assert figure("0", 1, "p - p").verdict == "all 1 digits right"
    assert figure("0.0000", 1, "p - p").passed
    assert figure("1e-30", 1, "p - p").verdict.startswith("0 of 1 digits right")


@pytest.mark.parametrize("name", ["nasa-brick", "detest-b5", "bruels-cardona-arnold"])
def test_the_library_says_how_many_digits_of_its_figures_are_right(name):
    """No fewer than are: ``right`` is the fewest that pass, so a case may say too few."""
    scene = polhode.load(f"published/{name}")
    shown = published_figures.figures(scene, polhode.reference(scene))
    told = [x for x in shown if x.published.right is not None]
    assert told
    assert [x.right for x in told] == [x.published.right for x in told]


def test_quantities_are_expressions_in_the_columns():
    assert figure("11.059696", quantity="p*p").verdict == "all 8 digits right"
    ours = float(figure("1", quantity="sqrt(p**2 + q**2 + r**2)").ours)
    row = polhode.reference("published/orekit").at([20], 20)[0]
    assert abs(ours - float(sum(x * x for x in row[:3]) ** 0.5)) < 0.05


def test_published_digits_need_no_integration_to_the_same_time():
    """The reference is asked at the figure's own time, whatever the run's times are."""
    scene = replace(polhode.load("published/orekit"), times=(Fraction(1),))
    shown = published_figures.figures(scene, polhode.reference(scene))
    assert all(f.passed for f in shown)
    assert number_types.bits_for(20) > 60


def test_bands_are_proposed_that_the_case_then_keeps(tmp_path, capsys):
    source = polhode.load("euler/separatrix").source
    bare, whole = tmp_path / "bare.toml", tmp_path / "whole.toml"
    bare.write_text(source.partition("[expect]")[0])
    assert cli.main(["check", str(bare)]) == 2
    assert "which --propose prints" in capsys.readouterr().err
    assert cli.main(["check", str(bare), "--propose"]) == 0
    printed = capsys.readouterr().out
    table = printed[printed.index("[expect]") :].partition("\n\n")[0]
    whole.write_text(f"{bare.read_text()}\n{table}\n")
    assert {*polhode.load(whole).expect} == {"double", "extended", "quad"}
    for name, (low, high) in polhode.load(whole).expect.items():
        assert high - low == pytest.approx(2)
        known = polhode.load("euler/separatrix").expect[name]
        assert low < sum(known) / 2 < high
    assert cli.main(["check", str(whole)]) == 0
    assert "1 passed, 0 failed" in capsys.readouterr().out

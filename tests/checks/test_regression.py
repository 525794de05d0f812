"""The regression itself: it passes, and it fails when anything is corrupted."""

import json
import pickle
from dataclasses import replace
from fractions import Fraction

import pytest

import polhode
from polhode import Published, cli
from polhode.checks.check_report import CheckReport, check_scene
from polhode.equations.forms import principal
from polhode.scenes import library
from shared.members import motion_table
from shared.tools import tiers

#: Kinds of motion without a case.
BARE = {
    *("rest, hanging", "rest, upright", "permanent rotation"),
    *("permanent rotation about the symmetry axis", "permanent rotation about an equatorial axis"),
    *("steady precession", "spherical pendulum, conical"),
}
MOST_WIDE = 2.15  # digits of a band
CHANGE = 1 + Fraction(1, 10**20)  # a relative change far below anything a double shows


@pytest.fixture
def answer(capsys):
    """What the verb says of cases, as JSON."""

    def of_words(*words, code=0):
        assert cli.main(["check", *map(str, words), "--json"]) == code
        return json.loads(capsys.readouterr().out)

    return of_words


def case_file(path, name, **changes):
    """The file of a case with changes."""
    path.write_text(polhode.as_toml(replace(polhode.load(name), **changes)))
    return path


def test_every_case_loads_and_expects_something():
    names = polhode.cases().column("scene")
    assert len(names) >= 45
    for name in names:
        scene = polhode.load(name)
        assert scene.expect, name
        assert scene.title, name
        assert scene.times, name
        for number, (low, high) in scene.expect.items():
            assert 0 < high - low < MOST_WIDE, (name, number)
        if name.startswith("published/"):
            assert scene.published, name
            assert scene.cite, name


def test_every_kind_of_motion_of_every_family_has_a_case():
    """Of the classical families; the file says the kinds, which the table holds closed forms to."""
    motions = motion_table()
    cases = {*motions["library"].values()}
    for family in ("euler", "lagrange", "pendulum", "kovalevskaya"):
        kinds = {texts[4] for texts in motions[family].values()}
        assert {kind for kind in kinds if f"{family}: {kind}" not in cases} <= BARE


def test_every_case_with_a_closed_form_has_its_line_of_the_table():
    """The line is what its author says of the motion, the catalogue what the program says."""
    told = {
        name: f"{entry.reference}: {entry.regime}"
        for name, entry in polhode.cases().entries.items()
        if entry.reference != "certified"
    }
    assert told == motion_table()["library"]


@pytest.mark.parametrize(
    ("case", "which"), tiers([("euler/largest-axis", "p.qr")], [("lagrange/nutation", "q.rp")])
)
def test_a_corrupted_equation_of_motion_fails(case, which, monkeypatch, answer):
    """By 1e-20 of itself, which is below what a double or an extended can show."""
    honest = principal.coefficients

    def corrupted(*arguments):
        numbers = honest(*arguments)
        return numbers | {which: numbers[which] * CHANGE}

    monkeypatch.setattr(principal, "coefficients", corrupted)
    columns = answer(case, "--number", "double,quad", code=1)["columns"]
    assert columns["number"] == ["double", "quad"]
    assert columns["passed"] == ["true", "false"]


@pytest.mark.slow
def test_without_a_band_nothing_passes_or_fails_and_lost_digits_are_words(tmp_path, capsys):
    path = tmp_path / "own.toml"
    text = polhode.load("euler/separatrix").source
    path.write_text(text.partition("[expect]")[0].replace("end = 30", "end = 400"))
    assert cli.main(["check", str(path), "--number", "double"]) == 3
    out, err = capsys.readouterr()
    assert "expected a case with bands of digits ([expect])" in err
    assert "no digits left after t = 100: no band" in out
    assert "0.00" not in out
    assert out.endswith("0 passed, 0 failed, 1 without a band\n")
    assert cli.main(["check", str(path), "--number", "double", "--json"]) == 3
    answer = json.loads(capsys.readouterr().out)
    assert answer["passed"] is None
    assert answer["columns"]["correct_digits"] == [None]
    assert answer["columns"]["passed"] == [""]


@pytest.mark.slow
def test_cases_are_run_in_mp_as_users_have_it_and_else_by_heyokas_own_steps(answer):
    """Which the bands are of: refined quad has more digits, and mp by steps fewer."""
    assert answer("euler/largest-axis", "--number", "quad,mp")["passed"]


@pytest.mark.slow
def test_what_the_widest_type_asked_of_the_reference_judges_the_narrower_ones(answer, monkeypatch):
    questions = []
    for name in ("at", "pairs"):
        ask = getattr(polhode.Reference, name)

        def ask_and_count(self, *question, ask=ask, **how):
            questions.append(question)
            return ask(self, *question, **how)

        monkeypatch.setattr(polhode.Reference, name, ask_and_count)

    def verdicts_of(numbers):
        questions.clear()
        columns = answer("kovalevskaya/generic", "--number", numbers, "--details")["columns"]
        return len(questions), columns["correct_digits"], columns["limit"]

    (count, digits, limits), wide, narrow = map(verdicts_of, ("quad,double", "quad", "double"))
    assert count == wide[0] > 0 < narrow[0]
    assert digits == pytest.approx(wide[1] + narrow[1], abs=1e-8)
    assert limits == wide[2] + narrow[2]


def test_a_case_passes_and_an_unknown_number_type_is_refused(refusal, capsys):
    assert cli.main(["check", "euler/sphere"]) == 0
    assert capsys.readouterr().out.endswith("1 passed, 0 failed\n")
    assert "double" in refusal("check", "euler/sphere", "--number", "dobule")


@pytest.mark.usefixtures("compiled_as_for_users")
@pytest.mark.slow
def test_cases_shared_by_processes_give_the_same_reports(answer):
    """Eight are shared, four are not."""
    names = ["euler/rest", "euler/sphere", "staude/stable", "grioli/precession"]
    names += ["pendulum/upright", "euler/largest-axis", "euler/flat", "hess/cone"]
    how = "--number", "double", "--details"
    shared, *halves = (answer(*x, *how)["columns"] for x in (names, names[:4], names[4:]))
    assert shared["scene"] == names
    assert shared == {name: halves[0][name] + halves[1][name] for name in shared}


def test_what_a_process_found_is_told_without_the_reference(monkeypatch):
    """Every closed form and enclosure was computed again, for each number type, to be printed."""
    report = pickle.loads(pickle.dumps(check_scene(polhode.load("euler/sphere"))))
    monkeypatch.setattr(polhode.Reference, "at", None)
    report_of_all = CheckReport([report], [])
    assert "rounding" in report_of_all.details()
    assert report_of_all.table().columns
    assert str(report_of_all).endswith("1 passed, 0 failed")


def test_digits_above_the_band_fail_too(tmp_path, capsys):
    text = polhode.load("euler/largest-axis").source.partition("[expect]")[0]
    (path := tmp_path / "slack.toml").write_text(f"{text}[expect]\ndouble = [1, 9]\n")
    assert cli.main(["check", str(path), "--number", "double"]) == 1
    assert "more digits than the case can have" in capsys.readouterr().out


def test_a_run_that_does_not_reach_its_end_fails(tmp_path, answer):
    times, expect = (Fraction(10) ** 30,), {"double": (1.0, 9.0)}
    path = case_file(tmp_path / "far.toml", "euler/largest-axis", times=times, expect=expect)
    assert answer(path, code=1)["columns"]["verdict"] == ["step limit"]


# -- published figures ------------------------------------------------------------------------

#: A figure at t = 20, how many of its digits are right, of what, and what is said of it.
FIGURES = [
    # of 3.3256121802383088253058..., rounded and cut off stand, a unit further does not
    ("3.3256121802383088", None, "p", True, "all 17 digits right"),
    ("3.32561218023830882531", None, "p", True, "all 21 digits right"),
    ("3.32561218023830882530", None, "p", True, "all 21 digits right"),
    ("3.32561218023830882532", None, "p", False, "20 of 21 digits right"),
    ("3.32561218023830882529", None, "p", False, ""),
    ("3.3256121802383086", None, "p", False, ""),
    ("3.3256121999", 7, "p", True, "8 of 11 digits right"),
    ("3.3256121999", 8, "p", True, "8 of 11 digits right"),
    ("3.3256121999", 9, "p", False, "8 of 11 digits right, where 9 are expected: differs by 2"),
    ("3.3256121999", None, "p", False, "8 of 11 digits right, where all are expected: differs"),
    ("3.32561218023", 5, "p", True, "all 12 digits right"),  # cut off: 3.325612180238...
    ("3.32561218023", 13, "p", False, "all 12 digits right, where 13 are expected"),
    ("3.4", 0, "p", True, "1 of 2 digits right"),
    ("3.4", 2, "p", False, "1 of 2 digits right, where 2 are expected: differs by 0.074"),
    ("-3.4", 0, "p", True, "0 of 2 digits right"),
    ("0", 1, "p - p", True, "all 1 digits right"),
    ("0.0000", 1, "p - p", True, ""),
    ("1e-30", 1, "p - p", False, "0 of 1 digits right"),
    ("11.059696", None, "p*p", True, "all 8 digits right"),
]


def test_a_printed_figure_stands_or_says_how_many_digits_are_right(tmp_path, answer):
    """The fewest that pass are told; a figure of what is 0 has all its digits or none.

    The reference is asked at the figure's own time, whatever the run's times are.
    """
    figures = tuple(Published(Fraction(20), x[2], x[0], "by hand", x[1]) for x in FIGURES)
    changes = {"times": (Fraction(1),), "published": figures, "expect": {}}
    path = case_file(tmp_path / "x.toml", "published/orekit", **changes)
    table = answer(path, "--number", "double", code=1)["published"]
    rows = zip(FIGURES, table["passed"], table["verdict"], strict=True)
    for (value, _, _, passed, words), mark, verdict in rows:
        assert (mark, verdict.startswith(words)) == (str(passed).lower(), True), (value, verdict)


@pytest.mark.slow
def test_the_library_says_how_many_digits_of_its_figures_are_right(tmp_path, answer):
    """No fewer than are: the case tells the fewest that pass, so it may say too few."""
    names = [name for name in polhode.cases().column("scene") if name.startswith("published/")]
    scenes = [polhode.load(name) for name in names]
    changes = {"times": (Fraction(1, 1000),), "outputs": (), "events": (), "expect": {}}
    paths = [case_file(tmp_path / f"{k}.toml", x, **changes) for k, x in enumerate(names)]
    table = answer(*paths, "--number", "double")["published"]
    figures = [figure for scene in scenes for figure in scene.published]
    for figure, verdict, passed in zip(figures, table["verdict"], table["passed"], strict=True):
        assert passed == "true"
        assert figure.right is None or verdict.startswith(f"{figure.right} of ")


def test_bands_are_proposed_that_the_case_then_keeps(tmp_path, capsys):
    source = polhode.load("euler/separatrix").source
    bare, whole = tmp_path / "bare.toml", tmp_path / "whole.toml"
    bare.write_text(source.partition("[expect]")[0])
    assert cli.main(["check", str(bare)]) == 3
    assert "which --propose prints" in capsys.readouterr().err
    assert cli.main(["check", str(bare), "--propose"]) == 0
    printed = capsys.readouterr().out
    table = printed[printed.index("[expect]") :].partition("\n\n")[0]
    whole.write_text(f"{bare.read_text()}\n{table}\n")
    assert {*polhode.load(whole).expect} == {"double", "extended", "quad"}
    for name, (low, high) in polhode.load(whole).expect.items():
        assert high - low == pytest.approx(2)
        band = polhode.load("euler/separatrix").expect[name]
        assert low < sum(band) / 2 < high
    assert cli.main(["check", str(whole)]) == 0
    assert "1 passed, 0 failed" in capsys.readouterr().out


def test_a_proposed_band_ends_at_the_most_digits_of_the_type(answer):
    words = "euler/rest", "euler/sphere", "--number", "double,mp", "--propose"
    rows = zip(*answer(*words)["proposed"].values(), strict=True)
    bands = {(scene, number): band for scene, number, *band in rows}
    assert bands["euler/rest", "double"] == [15.0, 16.0]
    assert bands["euler/sphere", "mp"] == [*polhode.load("euler/sphere").expect["mp"]]


def test_check_without_any_case_says_so_in_one_line(tmp_path, monkeypatch, capsys):
    """A ValueError of no workers came instead."""
    monkeypatch.setattr(library, "folder", lambda: tmp_path)
    assert cli.main(["check"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert "no cases are installed" in err

"""Each judged part has its digits at each time; the headline is the worst of all."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import mpmath
import numpy as np
import pytest

import polhode
from polhode import cli
from polhode.judging.certified import NoAnswer
from polhode.judging.reference import Reference
from shared.tables import of_run, right, text
from shared.tools import judged, tiers

CASE = "lagrange/nutation"
TIMES = [Fraction(k, 50) for k in range(151)]


@pytest.fixture
def compared(tmp_path, capsys):
    """What the verb says of a table, as JSON and as the whole text."""

    def changed(table, scene=CASE, *options):
        path = tmp_path / "x.csv"
        path.write_text(text(table))
        command = ["compare", str(path), scene, *options]
        assert cli.main([*command, "--json"]) == 0
        answer = judged(capsys.readouterr().out)
        assert cli.main([*command, "--details"]) == 0
        return answer, capsys.readouterr().out

    return changed


@pytest.mark.slow
def test_a_file_of_the_attitude_alone_is_judged_by_an_enclosure(compared):
    name = "general/asymmetric-regular"
    rows = polhode.Certified(polhode.load(name)).attitude([0, 1], 20)
    columns = zip(*rows, strict=True)
    answer, said = compared({"t": [0, 1]} | {f"q{k}": x for k, x in enumerate(columns)}, name)
    assert min(answer["parts"]["attitude"]) == answer["worst"] > 15
    assert answer["worst_part"] == "attitude"
    assert answer["reference_digits"] > 20
    assert "nan" not in said
    assert said.splitlines()[1] == "t  attitude"
    assert " correct digits at worst (t = " in said.splitlines()[4]


@pytest.mark.slow
def test_a_part_that_goes_wrong_is_the_headline_and_told_from_when(compared):
    """The sign of qz is wrong from t = 0.16 on; omega is right to 8 digits at t = 2."""
    table = right(CASE, TIMES[::2], "at", "attitude")
    before = table["t"] < 0.16
    table["q3"] = np.where(before, table["q3"], -table["q3"])
    table["p"][table["t"] == 2] += 3e-8
    answer, said = compared(table)
    assert [x > 15 for x in answer["parts"]["attitude"]] == [*before]
    assert (answer["worst_part"], answer["worst"]) == ("attitude", 0)
    assert answer["departures"]["part"] == ["attitude"]
    assert answer["departures"]["since"] == ["0.16"]
    assert 7 < min(answer["parts"]["omega"]) < 9
    assert min(answer["parts"]["gamma"]) > 15
    assert "attitude: right until t = 0.1" in said
    assert ", of attitude; of the state 8." in said


def test_a_motion_that_takes_the_digits_itself_is_no_part_that_goes_wrong():
    """The separatrix takes all digits between these times, of any run in double."""
    judgement = polhode.compare(polhode.integrate("euler/separatrix", at=[1, 2, 3, 90, 100]))
    assert judgement.digits[2] > judgement.digits[3] + 5
    assert judgement.departures == {}


def test_the_headline_of_the_state_alone_is_that_of_the_state():
    judgement = polhode.compare(polhode.integrate("euler/largest-axis"))
    assert judgement.worst == min(judgement.digits)
    assert judgement.worst_part == "state"
    assert judgement.part_digits.keys() == {"omega", "gamma"}


@pytest.mark.parametrize(
    ("strict", "off", "exchanged", "least"),
    tiers(
        [(False, 0, False, 14)],
        [(True, 0, False, 14), (False, 0.01, False, 2), (False, 0, True, 0)],
    ),
)
def test_angles_are_judged_up_to_whole_turns(strict, off, exchanged, least):
    """Of a right program, of a rough one; exchanged ones are wrong."""
    table = right(CASE, TIMES[1:], "angles")
    assert max(table["phi"]) > 4
    for name in ("psi", "theta", "phi"):
        table[name] += off
    table["phi"] = np.remainder(table["phi"] + np.pi, 2 * np.pi) - np.pi
    if exchanged:
        table |= {"psi": table["phi"], "phi": table["psi"]}
    judgement = polhode.compare(table, CASE, as_it_stands=strict)
    assert judgement.reading is None
    assert least <= round(judgement.worst, 3) < least + 2


def test_a_run_through_poles_has_its_angles():
    scene = replace(polhode.load("pendulum/rotating"), outputs=("angles",))
    assert polhode.compare(polhode.integrate(scene)).parts["angles"] > 12


def test_near_a_pole_the_attitude_has_the_digits_that_psi_and_phi_lose(monkeypatch):
    """By a reference that is off by as much as the digits that it is asked for allow."""
    answer = Reference.attitude

    def rough(self, times, digits):
        return [[a, b + mpmath.mpf(10) ** -digits, *c] for a, b, *c in answer(self, times, digits)]

    body = {"moments": [1, 1, 2], "centre": [0, 0, 1], "weight": 1}
    top = polhode.top(**body, angles=["1/3", "1e-13", "1/5"], rates=["1/7", 0, 2], end=1)
    rows = [[float(x) for x in row] for row in polhode.reference(top).angles([1], 40)]
    monkeypatch.setattr(Reference, "attitude", rough)
    judgement = polhode.compare(rows, top, at=[1], columns=("psi", "theta", "phi"))
    assert judgement.parts["angles"] > 14.5


@pytest.mark.parametrize(
    "change",
    [
        {"p": "q", "q": "p"},
        {"gamma1": "gamma2", "gamma2": "gamma1", "p": "q", "q": "p"},
        {"p": "gamma1", "gamma3": "q"},
    ],
)
def test_what_is_wrong_in_the_first_digit_has_no_limit(change):
    table = right(CASE, TIMES[::10])
    table |= {name: table[source] for name, source in change.items()}
    judgement = polhode.compare(table, CASE, as_it_stands=True)
    assert judgement.worst < 1
    assert judgement.limit == ""
    assert "limit " not in judgement.details()
    assert str(judgement).splitlines()[-1].endswith("), wrong in the first digit")


@pytest.mark.slow
def test_a_rough_method_is_the_limit_still(compared):
    table = right(CASE, TIMES[::10])
    answer, said = compared(table | {"p": table["p"] + 1e-4})
    assert answer["limit"] == "method (steps of the program)"
    sentence = "fewer than double precision allows: the program's steps, noise, or another motion"
    assert sentence in said
    assert "method" not in said


def test_no_more_digits_are_told_than_the_type_has(compared):
    """The start is exact, and printed with 17 digits."""
    answer, said = compared(right(CASE, TIMES[::10]))
    assert answer["number"] == "double"
    assert answer["correct_digits"][0] == pytest.approx(15.95, abs=0.01)
    assert said.splitlines()[2].split() == ["0", "15.95", "15.95-15.95"]
    for digits, band in (line.split()[1:] for line in said.splitlines()[3:12]):
        least, most = map(float, band.split("-"))
        assert least <= most <= 15.95
        assert float(digits) <= 15.95


def test_a_closed_form_that_has_no_answer_gives_way_to_an_enclosure(monkeypatch):
    """A closed form that refuses stands in for motions whose phases are not found."""

    def refused(self, word, times, digits):
        raise NoAnswer("top", "reference", "euler", "a question that it answers")

    scene = polhode.load("euler/attitude").at([1, 2])
    run = polhode.integrate(replace(scene, outputs=("attitude",)))
    monkeypatch.setattr(Reference, "pairs", refused)
    judgement = polhode.compare(run)
    assert judgement.worst > 14
    assert judgement.parts["attitude"] > 14
    assert judgement.reference.kind == "certified"
    assert "proven to " in judgement.details()


def test_a_long_proof_is_foretold(tmp_path, capsys):
    """t = 20 000 would take half a minute to prove; 200 000 are refused."""
    name, path = "general/asymmetric-regular", tmp_path / "x.csv"
    command = ["compare", str(path), name, "--as-it-stands"]

    def write(end):
        times = [*(Fraction(k, 100) for k in range(1, 20)), end]
        table = of_run(polhode.integrate(name, at=times))
        path.write_text(text(table | {"t": 1000 * table["t"]}))

    write(20)
    assert cli.main([*command, "--max-seconds", "0.2"]) == 3
    out, err = capsys.readouterr()
    forecast, ended = err.splitlines()
    assert out == ""
    assert "the proof that judges will take about " in forecast
    assert forecast.endswith("--max-seconds S or Ctrl-C ends it sooner")
    assert "max_seconds = 0.2: expected seconds in which the motion is proven to t = 20000" in ended
    write(200)
    assert cli.main(command) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert f"{name}: t = " in err


@pytest.mark.slow
def test_a_limit_that_is_not_reached_changes_nothing(compared):
    name = "general/asymmetric-regular"
    table = of_run(polhode.integrate(name, at=[1]))
    plain, _ = compared(table, name)
    limited, _ = compared(table, name, "--max-seconds", "100")
    assert plain == limited
    assert plain["worst"] > 14


@pytest.mark.slow
def test_steps_of_a_needle_are_not_blamed_for_what_they_lose_beyond_the_band():
    judgement = polhode.compare(polhode.integrate("euler/needle"))
    expected = judgement.expected[judgement.digits.index(judgement.worst)]
    assert expected.least - 2 < judgement.worst < expected.least - 0.3
    assert judgement.limit.startswith("unknown (steps of so thin a body")
    assert judgement.chance is None
    loose = polhode.compare(polhode.integrate("euler/needle", tol=1e-7, project=False))
    assert loose.limit.startswith("method")


@pytest.mark.slow
@pytest.mark.parametrize(("short", "by_chance"), [(0.3, True)])
def test_chance_explains_some_of_many_runs(compared, short, by_chance):
    """A run just below what nineteen in twenty have, and one far below."""
    table = right(CASE, TIMES[::15])
    least = polhode.compare(table, CASE, details=True).expected[-1].least
    table["p"][-1] += 4.2 * 10.0 ** -(least - short)  # over the largest |omega|
    answer, said = compared(table, CASE, "--number", "double")
    assert answer["limit"] == "method (steps of the program)"
    assert (1e-3 < answer["chance"] < 0.05) == by_chance
    assert ("or by chance: one run in " in said) == by_chance

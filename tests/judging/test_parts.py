"""Each judged part has its digits at each time; the headline is the worst of all."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import replace
from fractions import Fraction

import pytest

import polhode
from polhode import cli
from polhode.judging.references.reference import Reference
from polhode.scenes.vocabulary import ATTITUDE, STATE

TIMES = [Fraction(k, 50) for k in range(151)]


@pytest.fixture(scope="module")
def nutation():
    """The exact motion of a Lagrange top as columns of floats."""
    exact = polhode.reference("lagrange/nutation")
    columns = {"t": [float(t) for t in TIMES]}
    for names, rows in ((STATE, exact.at(TIMES, 20)), (ATTITUDE, exact.attitude(TIMES, 20))):
        columns |= {
            n: [float(x) for x in c] for n, c in zip(names, zip(*rows, strict=True), strict=True)
        }
    return columns


def written(path, columns, every=1):
    with path.open("w", newline="") as file:
        out = csv.writer(file)
        out.writerow(columns)
        rows = [*zip(*columns.values(), strict=True)]
        out.writerows([repr(x) for x in row] for row in rows[::every])
    return str(path)


def compared(capsys, *arguments):
    """What the verb says, as JSON and as text."""
    assert cli.main(["compare", *arguments, "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert cli.main(["compare", *arguments]) == 0
    return answer, capsys.readouterr().out


def test_a_file_of_the_attitude_alone_is_judged_by_an_enclosure(tmp_path, capsys):
    path = tmp_path / "x.csv"
    scene = polhode.load("general/asymmetric-regular")
    rows = polhode.Certified(scene).attitude([0, 1], 20)
    lines = [
        ",".join([t, *(repr(float(x)) for x in row)]) for t, row in zip("01", rows, strict=True)
    ]
    path.write_text("\n".join(["t,q0,q1,q2,q3", *lines]) + "\n")
    answer, text = compared(capsys, str(path), scene.name)
    assert min(answer["parts"]["attitude"]) == answer["worst"] > 15
    assert answer["worst_part"] == "attitude"
    assert answer["reference_digits"] > 20
    assert "nan" not in text
    assert text.splitlines()[1] == "t  attitude"
    assert " correct digits at t = " in text.splitlines()[4]


@pytest.mark.slow
@pytest.mark.parametrize("every", [1, 2])  # judged in columns, and row by row
def test_a_part_that_goes_wrong_is_the_headline_and_told_from_when(
    tmp_path, capsys, nutation, every
):
    """The sign of qz is wrong from t = 0.16 on; omega is right to 8 digits at t = 2."""
    wrong = [-x if t >= 0.16 else x for t, x in zip(nutation["t"], nutation["q3"], strict=True)]
    p = [x + 3e-8 * (t == 2) for t, x in zip(nutation["t"], nutation["p"], strict=True)]
    path = written(tmp_path / "x.csv", nutation | {"q3": wrong, "p": p}, every)
    answer, text = compared(capsys, path, "lagrange/nutation")
    before = [t < 0.16 for t in map(float, answer["times"])]
    for right, digits in zip(before, answer["parts"]["attitude"], strict=True):
        assert (digits > 15) == right
    assert answer["worst_part"] == "attitude"
    assert answer["worst"] == 0
    assert answer["right_until"]["attitude"]["since"] == "0.16"
    assert answer["right_until"].keys() == {"attitude"}
    assert 7 < min(answer["parts"]["omega"]) < 9
    assert min(answer["parts"]["gamma"]) > 15
    assert "attitude: 0.00 correct digits; right until t = 0.1" in text
    assert ", of attitude; of the state 8." in text
    assert "t" in text.splitlines()[1]
    assert text.splitlines()[1].split()[-1] == "attitude"


def test_a_motion_that_takes_the_digits_itself_is_no_part_that_goes_wrong():
    """The separatrix takes all digits between these times, of any run in double."""
    found = polhode.compare(polhode.integrate("euler/separatrix", at=[1, 2, 3, 90, 100]))
    assert found.digits[2] > found.digits[3] + 5
    assert found.departures == {}


def test_the_headline_of_the_state_alone_is_that_of_the_state():
    found = polhode.compare(polhode.integrate("euler/largest-axis"))
    assert found.worst == min(found.digits)
    assert found.worst_part == "state"
    assert found.part_digits.keys() == {"omega", "gamma"}


@pytest.mark.slow
@pytest.mark.parametrize("every", [1, 2])  # judged in columns, and row by row
def test_wrapped_angles_are_read_up_to_whole_turns(tmp_path, capsys, every):
    rows = polhode.reference("lagrange/nutation").angles(TIMES[1:], 20)
    psi, theta, phi = ([float(x) for x in column] for column in zip(*rows, strict=True))
    assert max(phi) > 4
    wrapped = [math.remainder(x, 2 * math.pi) for x in phi]
    columns = {"t": [float(t) for t in TIMES[1:]], "psi": psi, "theta": theta, "phi": wrapped}
    path = written(tmp_path / "x.csv", columns, every)
    answer, text = compared(capsys, path, "lagrange/nutation")
    assert answer["worst"] == min(answer["parts"]["angles"]) > 14
    assert answer["reading"] == "psi and phi up to whole turns"
    assert "of angles; read as psi and phi up to whole turns" in text
    answer, text = compared(capsys, path, "lagrange/nutation", "--as-it-stands")
    assert answer["worst"] == 0
    assert answer["reading"] is None
    assert "read as" not in text


@pytest.mark.slow
def test_wrapped_angles_of_a_rough_method_are_read_so_too(tmp_path, capsys):
    rows = polhode.reference("lagrange/nutation").angles(TIMES[1:], 20)
    psi, theta, phi = ([float(x) + 0.01 for x in column] for column in zip(*rows, strict=True))
    wrapped = [math.remainder(x, 2 * math.pi) for x in phi]
    columns = {"t": [float(t) for t in TIMES[1:]], "psi": psi, "theta": theta, "phi": wrapped}
    answer, _ = compared(capsys, written(tmp_path / "x.csv", columns), "lagrange/nutation")
    assert answer["worst"] == 2.0
    assert answer["reading"] == "psi and phi up to whole turns"


def test_angles_that_are_wrong_are_not_read_up_to_whole_turns(tmp_path, capsys):
    rows = polhode.reference("lagrange/nutation").angles(TIMES[1:], 20)
    psi, theta, phi = ([float(x) for x in column] for column in zip(*rows, strict=True))
    columns = {"t": [float(t) for t in TIMES[1:]], "psi": phi, "theta": theta, "phi": psi}
    answer, _ = compared(capsys, written(tmp_path / "x.csv", columns), "lagrange/nutation")
    assert answer["worst"] == 0
    assert answer["reading"] is None


def test_a_run_through_poles_has_its_angles_up_to_whole_turns():
    scene = replace(polhode.load("pendulum/rotating"), outputs=("angles",))
    found = polhode.compare(polhode.integrate(scene))
    assert found.parts["angles"] > 12
    assert found.reading == "psi and phi up to whole turns"
    assert polhode.compare(polhode.integrate(scene), as_it_stands=True).worst == 0


@pytest.mark.slow
@pytest.mark.parametrize(
    "change",
    [
        {"p": "q", "q": "p"},
        {"gamma1": "gamma2", "gamma2": "gamma1", "p": "q", "q": "p"},
        {"p": "gamma1", "gamma3": "q"},
    ],
)
def test_what_is_wrong_in_the_first_digit_has_no_limit(tmp_path, capsys, nutation, change):
    names = {name: change.get(name, name) for name in ("t", *STATE)}
    path = written(tmp_path / "x.csv", {name: nutation[of] for name, of in names.items()})
    answer, text = compared(capsys, path, "lagrange/nutation", "--as-it-stands")
    assert answer["worst"] < 1
    assert answer["limit"] is None
    assert "limited by" not in text
    assert "wrong in the first digit, so no limit is named" in text


@pytest.mark.slow
def test_a_rough_method_is_the_limit_still(tmp_path, capsys, nutation):
    p = [x + 1e-4 for x in nutation["p"]]
    path = written(tmp_path / "x.csv", {name: nutation[name] for name in ("t", *STATE)} | {"p": p})
    answer, text = compared(capsys, path, "lagrange/nutation")
    assert answer["limit"] == "method (steps of the program)"
    assert "limited by more than rounding: the program's steps, noise, or another motion" in text
    assert "method" not in text
    assert "limited by more than rounding" in repr(polhode.compare(path, "lagrange/nutation"))


def test_no_more_digits_are_told_than_the_type_has(tmp_path, capsys, nutation):
    """The start is exact, and printed with 17 digits."""
    path = written(tmp_path / "x.csv", {name: nutation[name] for name in ("t", *STATE)}, 10)
    answer, text = compared(capsys, path, "lagrange/nutation")
    assert answer["yardstick"] == "double"
    assert answer["correct_digits"][0] == 15.95
    first = text.splitlines()[2].split()
    assert first == ["0", "15.95", "15.95-15.95"]
    for digits, band in (line.split()[1:] for line in text.splitlines()[3:12]):
        least, most = map(float, band.split("-"))
        assert least <= most <= 15.95
        assert float(digits) <= 15.95


@pytest.mark.slow
def test_amplification_stands_beside_the_digits(capsys, tmp_path):
    path = tmp_path / "x.csv"
    assert cli.main(["run", "euler/separatrix", "--at", "1,20,200", "-o", str(path)]) == 0
    answer, _ = compared(capsys, str(path), "euler/separatrix")
    one, other, none = answer["amplification"]
    assert 1 < one < 5
    assert 100 < other < 1000
    assert none is None
    assert none == answer["correct_digits"][2]
    known = polhode.conditioning("euler/separatrix", [1, 20, 200]).log10_amplification
    assert other == pytest.approx(10 ** known[1], rel=1e-3)


def test_a_closed_form_that_has_no_answer_gives_way_to_an_enclosure(monkeypatch):
    """A closed form that refuses stands in for motions whose phases are not found."""

    def refused(self, times, digits):
        raise polhode.BadInput("top", "reference", "euler", "a question that it answers")

    scene = polhode.load("euler/attitude").at([1, 2])
    run = polhode.integrate(replace(scene, outputs=()))
    monkeypatch.setattr(Reference, "at", refused)
    found = polhode.compare(run)
    assert found.worst > 14
    assert found.reference.kind == "certified"
    assert f"against certified of {scene.name} (" in str(found)
    assert "proven to " in str(found)


def test_an_attitude_that_a_closed_form_does_not_answer_is_enclosed(monkeypatch):
    """So too where the state is answered; a closed form that refuses stands in for a slow one."""

    def refused(self, times, digits):
        raise polhode.BadInput("top", "reference", "euler", "a question that it answers")

    scene = polhode.load("euler/attitude").at([1, 2])
    run = polhode.integrate(scene)
    monkeypatch.setattr(Reference, "attitude", refused)
    assert polhode.compare(run).parts["attitude"] > 14


def test_a_long_proof_is_foretold_with_the_unit_that_t_seems_to_have(tmp_path, capsys):
    """t = 20 000 are twenty seconds, and would take minutes to prove; 200 000 are refused."""
    name = "general/asymmetric-regular"
    for end, told in ((20, ""), (200, "; t seems to be in milliseconds\n")):
        run = polhode.integrate(name, at=[Fraction(k, 100) for k in range(1, 20)] + [end])
        columns = {"t": [1000 * float(t) for t in run.t]}
        columns |= {n: [*map(float, run.states[:, k])] for k, n in enumerate(STATE)}
        written(tmp_path / f"{end}.csv", columns)
        if told:
            assert cli.main(["compare", str(tmp_path / f"{end}.csv"), name, "--as-it-stands"]) == 2
            assert capsys.readouterr().err.endswith(told)
    path = str(tmp_path / "20.csv")
    assert cli.main(["compare", path, name, "--as-it-stands", "--max-seconds", "0.2"]) == 3
    out, err = capsys.readouterr()
    assert out == ""
    told, ended = err.splitlines()
    assert "the proof that judges will take about " in told
    assert told.endswith("its t seems to be in milliseconds")
    assert (
        "max_seconds = 0.2: expected seconds in which the motion is proven to t = 20000," in ended
    )


def test_a_limit_that_is_not_reached_changes_nothing(tmp_path, capsys):
    name = "general/asymmetric-regular"
    run = polhode.integrate(name, at=[1, 2])
    columns = {"t": [*run.t], **{n: [*run.states[:, k]] for k, n in enumerate(STATE)}}
    path = written(tmp_path / "x.csv", {k: [*map(float, x)] for k, x in columns.items()})
    plain, _ = compared(capsys, path, name)
    limited, _ = compared(capsys, path, name, "--max-seconds", "100")
    assert plain == limited
    assert plain["worst"] > 14


@pytest.mark.slow
def test_steps_of_a_needle_are_not_blamed_for_what_they_lose_beyond_the_band():
    found = polhode.compare(polhode.integrate("euler/needle"))
    expected = found.expected[found.digits.index(found.worst)]
    assert expected.least - 2 < found.worst < expected.least - 0.3
    assert found.limit.startswith("unknown (steps of so thin a body")
    assert found.chance is None
    loose = polhode.compare(polhode.integrate("euler/needle", tol=1e-7, project=False))
    assert loose.limit.startswith("method")


@pytest.mark.slow
def test_chance_explains_some_of_many_runs(tmp_path, capsys, nutation):
    """A run just below what nineteen in twenty have, and one far below."""
    columns = {name: nutation[name] for name in ("t", *STATE)}
    clean = polhode.compare(columns, "lagrange/nutation")
    least = clean.expected[-1].least
    for short, by_chance in ((0.3, True), (1.0, False)):
        error = 4.2 * 10.0 ** -(least - short)  # over the largest |omega|
        wrong = [*nutation["p"][:-1], nutation["p"][-1] + error]
        path = written(tmp_path / "x.csv", columns | {"p": wrong})
        answer, text = compared(capsys, path, "lagrange/nutation", "--number", "double")
        assert answer["limit"] == "method (steps of the program)"
        assert (1e-3 < answer["chance"] < 0.05) == by_chance
        assert ("or by chance: one run in " in text) == by_chance

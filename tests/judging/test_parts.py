"""Each judged part has its digits at each time; the headline is the worst of all."""

import json
import math
from dataclasses import replace
from fractions import Fraction

import mpmath
import numpy as np
import pytest

import polhode
from polhode import cli
from polhode.judging.limits import SIGNIFICANCE, are_white
from shared import drifting_files as files
from shared.steady_precession import silent_scene
from shared.tables import ATTITUDE, STATE, of_run, right, text
from shared.tools import exactly, judged, tiers

CASE = "lagrange/nutation"
FINELY = [Fraction(k, 50) for k in range(151)]


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
    rows = polhode.reference(polhode.load(name), "certified").attitude([0, 1], 20)
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
    table = right(CASE, FINELY[::2], "at", "attitude")
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
    table = right(CASE, FINELY[1:], "angles")
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
    answer = polhode.Reference.attitude

    def rough(self, times, digits):
        return [[a, b + mpmath.mpf(10) ** -digits, *c] for a, b, *c in answer(self, times, digits)]

    body = {"moments": [1, 1, 2], "centre": [0, 0, 1], "weight": 1}
    top = polhode.top(**body, angles=["1/3", "1e-13", "1/5"], rates=["1/7", 0, 2], end=1)
    rows = [[float(x) for x in row] for row in polhode.reference(top).angles([1], 40)]
    monkeypatch.setattr(polhode.Reference, "attitude", rough)
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
    table = right(CASE, FINELY[::10])
    table |= {name: table[source] for name, source in change.items()}
    judgement = polhode.compare(table, CASE, as_it_stands=True)
    assert judgement.worst < 1
    assert judgement.limit == ""
    assert "limit " not in judgement.details()
    assert str(judgement).splitlines()[-1].endswith("), wrong in the first digit")


def test_no_more_digits_are_told_than_the_type_has(compared):
    """The start is exact, and printed with 17 digits."""
    answer, said = compared(right(CASE, FINELY[::10]))
    assert answer["number"] == "double"
    assert answer["correct_digits"][0] == pytest.approx(15.95, abs=0.01)
    assert said.splitlines()[2].split() == ["0", "15.95", "15.95-15.95"]
    for digits, band in (line.split()[1:] for line in said.splitlines()[3:12]):
        least, most = map(float, band.split("-"))
        assert least <= most <= 15.95
        assert float(digits) <= 15.95


def test_a_closed_form_that_has_no_answer_gives_way_to_an_enclosure():
    run = polhode.integrate(silent_scene(outputs=("attitude",)), at=[1, 2])
    assert polhode.reference(run.scene).kind == "silent-precession"
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
def test_steps_of_a_needle_are_not_blamed_for_what_they_lose_beyond_the_band():
    judgement = polhode.compare(polhode.integrate("euler/needle"))
    expected = judgement.expected[judgement.digits.index(judgement.worst)]
    assert expected.least - 2 < judgement.worst < expected.least - 0.3
    assert judgement.limit.startswith("unknown (steps of so thin a body")
    assert judgement.chance is None
    loose = polhode.compare(polhode.integrate("euler/needle", tol=1e-7, project=False))
    assert loose.limit.startswith("method")


@pytest.mark.slow
@pytest.mark.parametrize(("short", "by_chance"), [(0.3, True), (2.0, False)])
def test_chance_explains_some_of_many_runs(compared, short, by_chance):
    """A run just below what nineteen in twenty have, and one far below."""
    table = right(CASE, FINELY[::15])
    least = polhode.compare(table, CASE, details=True).expected[-1].least
    table["p"][-1] += 4.2 * 10.0 ** -(least - short)  # over the largest |omega|
    answer, said = compared(table, CASE, "--number", "double")
    assert answer["limit"] == "method (steps of the program)"
    assert (1e-3 < answer["chance"] < 0.05) == by_chance
    assert ("or by chance: one run in " in said) == by_chance


# -- what is left of a table: noise is called white where it is; angles are in degrees -------------


SCENE = "lagrange/nutation"
TIMES = [Fraction(k, 8) for k in range(160)]


def table(*parts):
    return right(SCENE, TIMES, *(parts or ("at",)))


def with_noise(columns, size, seed=3):
    draw = np.random.default_rng(seed)
    noise = {n: size * draw.normal(size=len(x)) for n, x in columns.items() if n != "t"}
    return {n: x + noise.get(n, 0) for n, x in columns.items()}


@pytest.mark.parametrize("size", [1e-2, 1e-5])
def test_white_noise_is_told_with_its_size_and_bias(size):
    """It was called the program's steps, noise, or another motion."""
    columns = with_noise(table(), size)
    columns["q"] += 3 * size
    judgement = polhode.compare(columns, SCENE)
    assert judgement.limit == "noise (white)"
    assert "fewer than double precision allows: noise that is white at this level" in str(judgement)
    assert (judgement.causes, judgement.readings, judgement.chance) == ((), (), None)
    assert [residual.column for residual in judgement.residuals] == list(STATE)
    for residual in judgement.residuals:
        assert residual.rms == pytest.approx(size, rel=0.2)
        assert residual.bias_error == pytest.approx(residual.rms / math.sqrt(len(TIMES)))
        assert abs(residual.bias - 3 * size * (residual.column == "q")) < 4 * residual.bias_error
    document = json.loads(judgement.to_json())["residuals"]
    assert document["rms"] == [residual.rms for residual in judgement.residuals]


def test_a_bias_that_is_more_than_the_noise_limits_the_digits():
    """It was called noise that is white at this level, with digits that the bias alone costs."""
    columns = with_noise(table(), 1e-6)
    columns["r"] -= 1e-3
    judgement = polhode.compare(columns, SCENE)
    assert (judgement.limit, judgement.causes) == ("bias (constant)", ())
    assert "allows: a constant bias, with white noise about it" in str(judgement)
    assert "(-0.001 ± 8e-08), gamma1" in str(judgement)


def test_a_noisy_attitude_has_its_own_limit():
    columns = with_noise(table("attitude"), 1e-3)
    length = np.sqrt(sum(columns[n] ** 2 for n in ATTITUDE))
    judgement = polhode.compare(
        {n: x / length if n != "t" else x for n, x in columns.items()}, SCENE
    )
    assert (judgement.limit, judgement.attitude_limit) == ("", "noise (white)")
    assert "of attitude, fewer than double precision allows: noise that is white" in str(judgement)
    assert [residual.column[:-1] for residual in judgement.residuals] == ["rotation_"] * 3
    most = max(judgement.rotation_angles)
    assert f"attitude off by {most:.3g}° at worst" in str(judgement)
    assert most > 2 * min(judgement.rotation_angles)
    exact = polhode.compare(table("at", "attitude"), SCENE)
    assert (exact.limit, exact.attitude_limit) == ("rounding", "rounding")


@pytest.mark.parametrize(("fewer", "limit"), [(0.9, "conditioning"), (3, "method")])
def test_an_attitude_may_lose_the_digits_of_the_angle_that_was_turned(fewer, limit):
    """At t = 20 that is 1.9 digits: omega's error is the rate at which it goes wrong."""
    columns = table("at", "attitude")
    (least, *_) = polhode.compare(columns, SCENE, details=True).expected[-1]
    half = 10 ** (fewer - least)
    columns["q1"][-1] += columns["q0"][-1] * half
    columns["q0"][-1] -= columns["q1"][-1] * half
    judgement = polhode.compare(columns, SCENE)
    assert judgement.attitude_limit.partition(" ")[0] in (
        limit,
        limit.replace("condition", "round"),
    )
    assert judgement.limit == "rounding"


def growing(columns):
    noise = with_noise({n: 0 * x for n, x in columns.items()}, 1e-3)
    return {n: x + noise[n] * columns["t"] / 20 for n, x in columns.items()}


def slow_sine(columns):
    return {n: x + 1e-3 * np.sin(columns["t"]) * (n != "t") for n, x in columns.items()}


def fast_sine(columns):
    return {n: x + 1e-3 * np.sin(21.7 * columns["t"]) * (n != "t") for n, x in columns.items()}


def walk(columns):
    steps = with_noise({n: 0 * x for n, x in columns.items()}, 1e-4)
    return {n: x + np.cumsum(steps[n]) * (n != "t") for n, x in columns.items()}


def offset(columns):
    return {n: x + 1e-3 * (n == "p") for n, x in columns.items()}


def few(columns):
    return {n: x[:25] for n, x in with_noise(columns, 1e-3).items()}


def sampled(columns):
    """Another motion, seen so seldom that neighbours are far apart."""
    pendulum = polhode.top(
        moments=[1, 1, "0.5"],
        centre=[0, 0, 1],
        weight=1,
        omega=["0.16", "0.32", "4.1"],
        gamma=["0.8", 0, "0.6"],
    )
    states = np.array(polhode.integrate(pendulum, at=[7 * t for t in TIMES[:80]]).states)
    true = right(SCENE, [7 * t for t in TIMES[:80]])
    return {"t": true["t"], **dict(zip(STATE, states.T, strict=True))}


@pytest.mark.parametrize(
    "wrong", tiers([growing, few], [slow_sine, fast_sine, walk, offset, sampled])
)
def test_what_is_no_white_noise_is_not_called_so(wrong):
    judgement = polhode.compare(wrong(table()), SCENE)
    assert judgement.limit.startswith("method") or judgement.limit == ""
    assert "white" not in str(judgement)


def test_noise_is_taken_for_something_else_as_seldom_as_is_said():
    draw = np.random.default_rng(8)
    are_noise = [are_white(draw.normal(size=(100, 6))) for _ in range(400)]
    assert 1 - 4 * SIGNIFICANCE < np.mean(are_noise) < 1
    rows = draw.normal(size=(400, 200, 1))
    coloured = rows[:, 1:] + 0.6 * rows[:, :-1]
    assert np.mean([are_white(x) for x in coloured]) < 0.02


@pytest.mark.parametrize("degrees", [30.0, 1e-3, 1e-9])
@pytest.mark.parametrize("length", [1, -1, 1.0004])
def test_the_angle_of_rotation_is_that_which_was_planted(degrees, length):
    half = math.radians(degrees) / 2
    turn = np.array([math.cos(half), 0, 0.6 * math.sin(half), 0.8 * math.sin(half)])
    columns = table("attitude")
    q = length * files.product(np.array([columns[n] for n in ATTITUDE]).T, turn)
    judgement = polhode.compare(
        {"t": columns["t"], **dict(zip(ATTITUDE, q.T, strict=True))},
        SCENE,
        as_it_stands=True,
        details=True,
    )
    angles = judgement.column("attitude_error")
    assert np.allclose(angles, degrees, rtol=1e-9 + 1e-14 / degrees)
    assert judgement.fact("attitude_error") == pytest.approx(degrees, rel=1e-4)
    if degrees > 1e-4:
        assert f"attitude off by {degrees:.3g}° at worst" in str(judgement)
    assert f"attitude off by {max(angles):.3g}° at worst" in judgement.details()
    assert np.allclose(
        [x.bias for x in judgement.residuals], degrees * np.array([0, 0.6, 0.8]), atol=1e-13
    )


def test_an_angle_beyond_doubles_is_right():
    rows = polhode.reference(SCENE).attitude([1, 2], 60)
    small = Fraction(1, 10**30)
    quaternions = [
        [a - small * b, b + small * a, c + small * d, d - small * c]
        for a, b, c, d in ([exactly(x) for x in row] for row in rows)
    ]
    judgement = polhode.compare(quaternions, SCENE, at=[1, 2], columns=ATTITUDE)
    assert judgement.rotation_angles == pytest.approx([math.degrees(2e-30)] * 2, rel=1e-9)

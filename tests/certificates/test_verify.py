"""Certificates: what is true is proved by code of its own, and what is false never."""

from __future__ import annotations

import ast
import copy
import json
import random
import subprocess
import sys
from fractions import Fraction

import pytest
from flint import arb, arb_mat, ctx, fmpq

import polhode
from polhode.certificates import verify
from polhode.certificates.state_certificate import certificate
from polhode.cli import main
from polhode.common.errors import BadInput


def made(scene, at, digits):
    ball = polhode.certify(scene, at=at, digits=digits)
    return certificate(ball.scene, ball.times, ball.decimals())


@pytest.fixture(scope="module")
def small():
    """An asymmetric body to t = 3, 20 digits."""
    return made("general/asymmetric-regular", [1, 3], 20)


def holds(given):
    """Whether a certificate is proved; it may be damaged, too."""
    before = ctx.prec
    try:
        verify.state(given)
    except (verify.NotProved, verify.Damaged):
        return False
    finally:
        ctx.prec = before
    return True


SCENES = {
    "general/asymmetric-chaotic": ([2, 5], 16),
    "lagrange/turned-axes": ([1], 20),
    "kovalevskaya/generic": ([-1, -4], 30),
    "euler/dzhanibekov": ([5], 16),
    "hard/very-fast-top": (["0.0001"], 16),
}


@pytest.mark.parametrize("name", SCENES)
def test_what_is_certified_is_proved_by_the_file_alone(name, tmp_path):
    at, digits = SCENES[name]
    path = tmp_path / "proof.json"
    polhode.certify(name, at=at, digits=digits).save(path)
    assert polhode.verify(path)
    alone = subprocess.run(
        [sys.executable, "-I", verify.__file__, str(path)], capture_output=True, text=True
    )
    assert alone.returncode == 0, alone.stderr
    assert "proved: at" in alone.stdout


def test_irrational_data_and_units_far_from_one(tmp_path):
    for unit in (Fraction(1), Fraction(10) ** 20, Fraction(1, 10**20)):
        top = polhode.top(
            moments=[2, "sqrt(2)", 1],
            centre=["1/3", 0, "sqrt(3)/2"],
            weight=unit * unit,
            omega=[unit / 7, 0, unit],
            gamma=["3/5", 0, "4/5"],
        )
        path = tmp_path / f"{float(unit)}.json"
        polhode.certify(top, at=[2 / unit], digits=16).save(path)
        assert polhode.verify(path).proved


def test_it_shares_no_code():
    """Nothing but the standard library and python-flint."""
    with open(verify.__file__, encoding="utf-8") as file:
        tree = ast.parse(file.read())
    names = [alias.name for x in ast.walk(tree) if isinstance(x, ast.Import) for alias in x.names]
    names += [x.module or "." for x in ast.walk(tree) if isinstance(x, ast.ImportFrom)]
    assert "flint" in names
    assert {name.partition(".")[0] for name in names} - {"flint"} <= {*sys.stdlib_module_names}


@pytest.mark.parametrize("row", [0, 1])
@pytest.mark.parametrize("column", range(6))
def test_a_ball_that_is_moved_off_is_not_proved(small, row, column):
    given = copy.deepcopy(small)
    middle, radius = given["statement"][row]["balls"][column]
    moved = Fraction(middle) + 2 * Fraction(radius)
    given["statement"][row]["balls"][column] = [str(moved), radius]
    assert not holds(given)


@pytest.mark.parametrize("key", ["moments", "centre", "weight", "omega", "gamma"])
def test_another_scene_is_not_proved(small, key):
    """By one part in 10^20, of balls of 10^-22."""
    given = copy.deepcopy(small)
    scene, more = given["scene"], Fraction(10**20 + 1, 10**20)
    if key == "weight":
        scene[key] = str(Fraction(scene[key]) * more)
    else:
        scene[key][0] = str(Fraction(scene[key][0]) * more)
    assert not holds(given)


@pytest.mark.slow
def test_guesses_prove_nothing_false(small):
    """Whatever they are: the same true statement, or nothing."""
    chance = random.Random(5)
    proved = 0
    for _ in range(12):
        given = copy.deepcopy(small)
        what = chance.choice(["centre", "grid", "bits"])
        if what == "centre":
            row = chance.choice(given["centres"])
            row[chance.randrange(6)] += chance.choice(
                [1, -(2**20), 2**60, 2 ** given["state_bits"]]
            )
        elif what == "grid":
            k = chance.randrange(1, len(given["grid"]) - 1)
            del given["grid"][k], given["centres"][k]
        else:
            given["bits"] = chance.choice([64, given["bits"] - 30, given["bits"] + 100])
        proved += holds(given)
        false = copy.deepcopy(given)
        middle, radius = false["statement"][-1]["balls"][0]
        false["statement"][-1]["balls"][0] = [str(Fraction(middle) + 3 * Fraction(radius)), radius]
        assert not holds(false)
    assert proved > 0


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("format", "another"),
        ("kind", "orbit "),
        ("kind", ["state"]),
        ("scene", {"moments": ["2", "3/2", "1"]}),
        ("scene", None),
        ("time_bits", 10**9),
        ("time_bits", True),
        ("state_bits", "100"),
        ("bits", 10**9),
        ("bits", 10),
        ("grid", [0]),
        ("grid", [1, 2]),
        ("grid", [0, 5, 3]),
        ("grid", [0, 10**30]),
        ("centres", []),
        ("statement", []),
        ("statement", [{"t": "1", "balls": []}]),
        ("statement", [{"t": "nan", "balls": [["0", "1"]] * 6}]),
        ("statement", [{"t": "1", "balls": [["0", "-1"]] * 6}]),
        ("statement", [{"t": "1", "balls": [["0", "1e99999"]] * 6}]),
        ("statement", [{"t": "1000", "balls": [["0", "1"]] * 6}]),
    ],
)
def test_what_is_no_certificate_is_one_line(small, key, value, tmp_path, capsys):
    path = tmp_path / "x.json"
    path.write_text(json.dumps(small | {key: value}))
    assert main(["verify", str(path)]) in (1, 2)
    told = capsys.readouterr()
    assert len((told.out + told.err).splitlines()) == 1
    assert "proved: at" not in told.out


@pytest.mark.parametrize(
    "text",
    ["", "[]", "{", "[" * 100_000, '{"a": 1, "a": 1}', '{"a": 1.5}', '{"a": NaN}', "1" * 10_000],
)
def test_a_damaged_file_is_one_line(text, tmp_path):
    path = tmp_path / "x.json"
    path.write_text(text)
    with pytest.raises(BadInput, match="certificate"):
        polhode.verify(path)


def test_numbers_longer_than_python_reads_are_read(small, tmp_path):
    """4300 digits are Python's own limit; beyond the checker's one line tells."""
    path = tmp_path / "x.json"
    text = json.dumps(small)
    first = json.dumps(small["centres"][0][0])
    path.write_text(text.replace(first, "1" * 5000, 1))
    assert "condition of the step" in polhode.verify(path).text
    path.write_text(text.replace(first, "1" * 30_000, 1))
    with pytest.raises(BadInput, match=r"centres\[0\]\[0\]: .* at most 20000 bits"):
        polhode.verify(path)
    middle, _ = small["statement"][0]["balls"][0]
    longer = middle + "0" * 5000
    path.write_text(text.replace(json.dumps(middle), json.dumps(longer), 1))
    assert polhode.verify(path).proved


def test_a_certificate_from_the_standard_input(small, tmp_path):
    for command in ([verify.__file__, "-"], ["-m", "polhode", "verify", "-"]):
        told = subprocess.run(
            [sys.executable, *command], input=json.dumps(small), capture_output=True, text=True
        )
        assert told.returncode == 0, told.stderr
        assert "proved: at 2 times" in told.stdout


def test_a_certificate_on_stdout_is_alone(capsys):
    command = ["reference", "lagrange/nutation", "--at", "1", "--digits", "10", "--certified"]
    assert main([*command, "-o", "-"]) == 0
    told = capsys.readouterr()
    assert json.loads(told.out)["kind"] == "state"
    assert "every digit is proven" in told.err


def test_work_that_would_take_hours_is_refused_at_once(small):
    given = small | {"bits": 4000}
    given["grid"] = [*range(10_000)]
    given["centres"] = [small["centres"][0]] * 9_999
    with pytest.raises(verify.Damaged, match="are too many"):
        verify.state(given)


def test_progress_is_told(small):
    seen = []
    verify.verify(json.dumps(small).encode(), lambda part, steps: seen.append((part, steps)))
    assert seen[0] == (0.0, 0)
    assert [steps for _, steps in seen] == list(range(len(small["centres"])))
    assert all(0 <= part < 1 for part, _ in seen)


def test_a_key_of_the_scene_that_is_not_known_is_refused(small):
    given = copy.deepcopy(small)
    given["scene"]["damping"] = "0"
    with pytest.raises(verify.Damaged, match="nothing else"):
        verify.state(given)


def enclosed(given, monkeypatch):
    """The balls that the checker finds at the statement's last time, whatever that states."""
    found = {}
    monkeypatch.setattr(verify, "_check", lambda names, _, there: found.update({names: there}))
    verify.state(given)
    return found


def worst(given, monkeypatch, names=verify.NAMES, key="balls"):
    """How far the truth lies from the middle of the checker's balls, in their radii."""
    balls = enclosed(given, monkeypatch)[names]
    ctx.prec = 300
    truth = [Fraction(middle) for middle, _ in given["statement"][-1][key]]
    return max(
        float(abs(x.mid() - arb(fmpq(y.numerator, y.denominator))).mid() / x.rad())
        for x, y in zip(balls, truth, strict=True)
    )


FAULTS = ["taylor", "taylor's start", "transition", "no transition", "rough centres"]
#: The term that has to hold each fault, made 0.
TERMS = {
    "taylor": ("delta",),
    "transition": ("rho",),
    "no transition": ("rho",),
    "rough centres": ("beta",),
}


def faulty(fault, given, monkeypatch):
    """A certificate or a checker with guesses that are far from the truth."""
    taylor, transition = verify.taylor, verify.transition

    def altered(body, centre, h, bits):
        rows = taylor(body, centre, h, bits)
        rows[2][3 if fault == "taylor" else 0] += arb("1e-12").mid()
        return rows

    def bent(a, fine):
        v = transition(a, fine)
        if fault == "no transition":
            return [v[0], arb_mat(6, 6)]
        v[1] = (v[1] * arb("1.001")).mid()
        return v

    if fault.startswith("taylor"):
        monkeypatch.setattr(verify, "taylor", altered)
    elif "transition" in fault:
        monkeypatch.setattr(verify, "transition", bent)
        off = 2**40 if fault == "transition" else 2**20
        given["centres"] = [[x + off for x in row] for row in given["centres"]]
    else:
        cut = given["state_bits"] - 18
        given["centres"] = [[x >> cut for x in row] for row in given["centres"]]
        given["state_bits"] = 18


@pytest.mark.parametrize("fault", FAULTS)
def test_faulty_guesses_are_contained(fault, small, monkeypatch):
    given = copy.deepcopy(small)
    given["statement"] = given["statement"][:1]
    faulty(fault, given, monkeypatch)
    ratio = worst(given, monkeypatch)
    assert ratio < 1
    if fault in TERMS:  # a bound that is far too wide would tell nothing
        assert ratio > 1e-7


@pytest.mark.parametrize("fault", TERMS)
def test_a_term_that_is_dropped_is_noticed(fault, small, monkeypatch):
    given = copy.deepcopy(small)
    given["statement"] = given["statement"][:1]
    faulty(fault, given, monkeypatch)
    begin = verify.Step.__init__

    def without(self, *arguments):
        begin(self, *arguments)
        for term in TERMS[fault]:
            setattr(self, term, arb(0))

    monkeypatch.setattr(verify.Step, "__init__", without)
    assert worst(given, monkeypatch) > 1


@pytest.mark.parametrize("digits", [16, 40])
def test_the_command_line(digits, tmp_path, capsys):
    path = tmp_path / "proof.json"
    scene = "general/asymmetric-regular"
    command = ["reference", scene, "--certified", "--at", "2", "--digits", str(digits)]
    assert main([*command, "-o", str(path)]) == 0
    assert main(["verify", str(path), "--json"]) == 0
    out = capsys.readouterr().out
    assert json.loads(out[out.index("{") :])["proved"] is True
    given = json.loads(path.read_text())
    given["statement"][0]["balls"][0][0] = "0.5"
    path.write_text(json.dumps(given))
    assert main(["verify", str(path)]) == 1
    assert "p at t = 2 is not shown to lie in its ball" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("scene", "at", "said"),
    [
        ("euler/largest-axis", [0], "a time other than 0"),
        ("lagrange/nutation", [-1, 1], "times of one sign"),
        ("lagrange/nutation", ["sqrt(2)"], "rational times"),
    ],
)
def test_what_has_no_certificate_is_refused(scene, at, said, tmp_path):
    ball = polhode.certify(scene, at=at, digits=10)
    with pytest.raises(BadInput, match=said):
        ball.save(tmp_path / "x.json")
    assert not (tmp_path / "x.json").exists()

"""`polhode sweep`: what it prints, writes, refuses, and how it exits."""

from __future__ import annotations

import json
import re
import signal

import numpy as np
import pytest

import polhode
from polhode import cli
from polhode.verbs import terminal
from shared.motions import heavy_file

HEAVY = heavy_file(samples=3)


@pytest.fixture
def scene(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "heavy.toml").write_text(HEAVY)
    return "heavy.toml"


def run(capsys, *arguments):
    code = cli.main(["sweep", *arguments])
    told = capsys.readouterr()
    return code, told.out, told.err


def test_every_combination_as_json(scene, capsys):
    varied = ["--vary", "start.omega[1]=0.1:0.3:3", "--vary", "body.weight=1,sqrt(2)"]
    code, out, err = run(capsys, scene, *varied, "--json")
    answer = json.loads(out)
    assert (code, err) == (0, "")
    assert answer["varied"] == ["start.omega[1]", "body.weight"]
    assert answer["projected"] is False
    assert answer["interrupted"] is False
    assert answer["times"] == ["0", "10", "20"]
    values = [member["values"] for member in answer["members"]]
    assert values[:3] == [["0.1", "1"], ["0.1", "1.4142135623730950"], ["0.2", "1"]]
    member = answer["members"][4]
    single = polhode.integrate(
        polhode.integrate_many(scene, {"start.omega[1]": ["0.3"], "body.weight": [1]})[0].scene
    )
    assert np.allclose(
        np.array(member["states"], dtype=float), single.states, rtol=0, atol=128 * 2.0**-52
    )
    assert set(member) == {"values", "outcome", "reached", "steps", "drift", "states"}
    assert set(member["drift"]) == {"h", "f", "gamma", "fourth"}


def test_a_table_on_stdout_and_a_note_on_stderr(scene, capsys):
    code, out, err = run(capsys, scene, "--vary", "body.weight=0:1:3")
    lines = out.splitlines()
    assert code == 0
    assert lines[0].split()[:5] == ["member", "body.weight", "outcome", "steps", "t"]
    assert len(lines) == 4
    assert err == ("heavy.toml: 3 members, double (53 bits), not projected; 3 reached end\n")


@pytest.mark.parametrize("number", ["double", "extended", "quad"])
def test_npz(scene, capsys, tmp_path, number):
    varied = ["--vary", "body.weight=0:1:2"]
    code, out, _ = run(capsys, scene, *varied, "--number", number, "-o", "x.npz")
    assert (code, out) == (0, "")
    many = polhode.integrate_many(scene, {"body.weight": [0, 1]}, number=number)
    with np.load(tmp_path / "x.npz", allow_pickle=False) as held:
        if number == "quad":
            assert held["states"][1].tolist() == many[1].state_strings()
        else:
            assert np.array_equal(held["states"], many.states)
        assert held["states"].shape == (2, 3, 6)
        assert held["values"].tolist() == [[0], [1]]
        assert held["varied"].tolist() == ["body.weight"]
        assert held["outcomes"].tolist() == ["reached end"] * 2
        about = json.loads(str(held["about"]))
    assert (about["number"], about["projected"]) == (number, False)
    assert {p.name for p in tmp_path.iterdir()} == {"heavy.toml", "x.npz"}


def test_csv(scene, capsys, tmp_path):
    code, out, _ = run(capsys, scene, "--vary", "start.omega[2]=1/3,1", "-o", "x.csv")
    assert (code, out) == (0, "")
    lines = (tmp_path / "x.csv").read_text().splitlines()
    assert lines[0] == "member,start.omega[2],t,p,q,r,gamma1,gamma2,gamma3"
    assert len(lines) == 1 + 2 * 3
    assert lines[1].startswith("1,1/3,0,0.2999")
    beside = json.loads((tmp_path / "x.json").read_text())
    assert [m["outcome"] for m in beside["members"]] == ["reached end"] * 2
    assert "states" not in beside["members"][0]


def test_a_member_that_fails_is_told_and_written(scene, capsys, tmp_path):
    varied = ["--vary", "body.weight=1,1e6", "--max-steps", "300", "-o", "x.npz"]
    code, _, err = run(capsys, scene, *varied)
    assert code == 3
    assert "1 reached end, 1 step limit" in err
    assert "member 2 (body.weight = 1000000): the end needs more steps than the limit" in err
    with np.load(tmp_path / "x.npz", allow_pickle=False) as held:
        assert held["outcomes"].tolist() == ["reached end", "step limit"]
        assert np.isnan(held["states"][1, -1]).all()


def test_outputs_are_left_out_and_that_is_said(scene, capsys, tmp_path):
    (tmp_path / "heavy.toml").write_text(HEAVY + 'outputs = ["angles"]\n')
    code, _, err = run(capsys, scene, "--vary", "body.weight=1")
    assert code == 0
    assert "not projected; angles left out; 1 reached end" in err


TOLD = r"\d+\.\d %, \d+ members(, \d+ s left)?"


def test_ctrl_c_writes_what_is_finished(scene, tmp_path, capsys, monkeypatch):
    """A sweep of seconds, interrupted: a whole file, its unfinished members marked."""
    told = []

    def say(_, text):
        told.append(text)
        if len(told) == 2:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(terminal.ProgressLine, "say", say)
    varied = ["--vary", "start.omega[3]=0.5:1:400"]
    code, _, err = run(capsys, scene, "--at", "2000", *varied, "-o", "x.npz")
    assert code == 130
    with np.load(tmp_path / "x.npz", allow_pickle=False) as held:
        outcomes = held["outcomes"].tolist()
        assert json.loads(str(held["about"]))["interrupted"] is True
    reached = outcomes.count("reached end")
    assert 0 < reached < 400
    assert f"; {400 - reached} not run, {reached} reached end\n" in err
    assert set(outcomes) == {"reached end", "not run"}
    assert all(re.fullmatch(TOLD, text) for text in told)


# -- numbers kept instead of states ---------------------------------------------------------------

KEEP = ["--vary", "body.weight=0:1:2", "--keep", "largest theta", "--keep", "first nutation"]


def test_numbers_of_each_member(scene, capsys, tmp_path):
    """The same numbers as a table, JSON, CSV and NPZ, and as Python has them."""
    found = polhode.reduce_many(scene, {"body.weight": [0, 1]}, ["largest theta", "first nutation"])
    code, out, err = run(capsys, scene, *KEEP)
    header, *lines = out.splitlines()
    assert code == 0
    assert header.split()[:4] == ["member", "body.weight", "outcome", "steps"]
    assert len(lines) == 2
    assert err == "heavy.toml: 2 members, double (53 bits), not projected; 2 reached end\n"
    answer = json.loads(run(capsys, scene, *KEEP, "--json")[1])
    assert answer["keep"] == ["largest theta", "first nutation"]
    assert set(answer["members"][0]) == {"values", "outcome", "steps", "numbers"}
    for k, member in enumerate(answer["members"]):
        assert list(member["numbers"]) == list(found.names)
        assert [float(x) for x in member["numbers"].values()] == [found[n][k] for n in found.names]
    assert run(capsys, scene, *KEEP, "-o", "x.csv")[:2] == (0, "")
    rows = [line.split(",") for line in (tmp_path / "x.csv").read_text().splitlines()]
    assert rows[0] == ["member", "body.weight", "outcome", "steps", *found.names]
    assert [float(x) for x in rows[2][4:]] == [found[n][1] for n in found.names]
    assert json.loads((tmp_path / "x.json").read_text())["keep"] == answer["keep"]
    assert run(capsys, scene, *KEEP, "-o", "x.npz")[:2] == (0, "")
    with np.load(tmp_path / "x.npz", allow_pickle=False) as held:
        assert held["names"].tolist() == list(found.names)
        assert np.array_equal(held["largest theta"], found["largest theta"])
        assert held["values"].tolist() == [[0], [1]]
        assert held["outcomes"].tolist() == ["reached end"] * 2
    assert {p.name for p in tmp_path.iterdir()} == {"heavy.toml", "x.csv", "x.json", "x.npz"}


def test_a_number_that_is_not_there_is_null(scene, capsys):
    varied = ["--vary", "body.weight=1,1e6", "--max-steps", "300", "--keep", "final"]
    code, out, err = run(capsys, scene, *varied, "--json")
    first, last = json.loads(out)["members"]
    assert code == 3
    assert first["numbers"]["final p"] is not None
    assert set(last["numbers"].values()) == {None}
    assert "member 2 (body.weight = 1000000): the end needs more steps than the limit" in err


# -- starts in a file -----------------------------------------------------------------------------

ROWS = np.array([[0.1, 0.5, k, 0, 0.6, 0.8] for k in range(12)])
NAMES = ["p", "q", "r", "gamma1", "gamma2", "gamma3"]


def csv_of(rows, names=()) -> str:
    head = [",".join(names)] if names else []
    return "\n".join([*head, *(",".join(repr(float(x)) for x in row) for row in rows)]) + "\n"


def test_starts_of_a_csv_or_npy_file(scene, capsys, tmp_path):
    """With a header in any order, or without; the same numbers as the array's, and kept as such."""
    many = polhode.integrate_many(scene, starts=ROWS)
    order = [5, 0, 4, 1, 3, 2]
    header = [NAMES[i] for i in order]
    np.save(tmp_path / "rows.npy", ROWS)
    (tmp_path / "plain.csv").write_text(csv_of(ROWS))
    (tmp_path / "named.csv").write_text("\ufeff" + csv_of(ROWS[:, order], header) + "\n\n")
    for file in ("rows.npy", "plain.csv", "named.csv"):
        code, out, err = run(capsys, scene, "--starts", file, "-o", "x.npz")
        assert (code, out) == (0, "")
        assert err.startswith("heavy.toml: 12 members, double (53 bits)")
        with np.load("x.npz", allow_pickle=False) as held:
            assert np.array_equal(held["states"], many.states)
            assert np.array_equal(held["values"], ROWS)
            assert "values_exact" not in held.files
            assert held["varied"].tolist()[-1] == "start.gamma[3]"
    code, out, _ = run(capsys, scene, "--starts", "rows.npy", "--json")
    values = [member["values"] for member in json.loads(out)["members"]]
    assert np.array_equal(np.array(values, float), ROWS)
    code, out, _ = run(capsys, scene, "--starts", "rows.npy", "--keep", "final", "-o", "x.csv")
    assert code == 0
    assert (tmp_path / "x.csv").read_text().count("\n") == 13


def test_no_starts_are_no_members(scene, capsys, tmp_path):
    (tmp_path / "none.csv").write_text(",".join(NAMES) + "\n")
    code, out, err = run(capsys, scene, "--starts", "none.csv")
    assert (code, out.count("\n")) == (0, 1)
    assert err.startswith("heavy.toml: 0 members")


def test_starts_in_extended_are_read_in_extended(scene, capsys, tmp_path):
    line = "0.1,0.5,1,0,0.6,0.79999999999999999999\n"
    (tmp_path / "rows.csv").write_text(line)
    options = ["--starts", "rows.csv", "--number", "extended", "--at", "0", "-o", "x.npz"]
    code, _, _ = run(capsys, scene, *options)
    assert code == 0
    with np.load("x.npz", allow_pickle=False) as held:
        assert held["values"][0, 0] == np.longdouble("0.1") != 0.1


NO_STARTS = [
    (["--starts", "rows.csv", "--vary", "body.weight=1"], "--vary = body.weight=1: expected"),
    ([], "--vary: expected numbers to vary or --starts FILE, one of them"),
    (["--starts", "rows.txt"], "rows.txt: --starts = .txt: expected a file .csv or .npy"),
    (["--starts", "none.npy"], "none.npy: file: expected a readable file of starts (No such file"),
    (["--starts", "text.npy"], "text.npy: file: expected an array that NumPy wrote"),
    (["--starts", "objects.npy"], "objects.npy: file: expected an array that NumPy wrote"),
    (["--starts", "short.npy"], "short.npy: file: expected an array that NumPy wrote (it is not"),
    (["--starts", "two.npy"], "two.npy: file: expected an array that NumPy wrote (it is not as lo"),
    (["--starts", "three.npy"], "starts = an array of shape (2, 3): expected shape (N, 6)"),
    (["--starts", "wide.csv"], "wide.csv: line 1 = 1,2,3,4,5,6,7: expected 6 numbers p,q,r,gamma1"),
    (["--starts", "names.csv"], "names.csv: line 1 = p,q,r,gamma1,gamma2,t: expected 6 numbers"),
    (["--starts", "word.csv"], "word.csv: line 3 = 1,2,3,0,0,one: expected 6 numbers"),
    (["--starts", "grouped.csv"], "grouped.csv: line 1 = 1_0,2,3,0,0,1: expected 6 numbers"),
    (["--starts", "tiny.csv"], "tiny.csv: line 2 = 1e-320,2,3,0,0,1: expected 6 numbers"),
    (["--starts", "none.csv"], "none.csv: line 1 = 1e-400,2,3,0,0,1: expected 6 numbers"),
    (["--starts", "other.csv"], "other.csv: line 1 = \u0661,2,3,0,0,1: expected 6 numbers"),
    (["--starts", "nan.csv"], "starts, row 2 = [nan, 2.0, 3.0, 0.0, 0.0, 1.0]: expected finite nu"),
    (["--starts", "long.csv"], "start.gamma, row 2 = [0.0, 0.0, 2.0]: expected gamma of length 1"),
    (["--starts", "rows.csv", "--number", "quad"], "number = quad: expected double or extended"),
    (["--starts", "rows.csv", "-o", "rows.csv"], "-o: expected another file than the one"),
]  # fmt: skip


@pytest.mark.parametrize(("options", "said"), NO_STARTS, ids=range(len(NO_STARTS)))
def test_what_holds_no_starts_is_refused_in_one_line(scene, refusal, tmp_path, options, said):
    good = "1,2,3,0,0,1\n"
    np.save("three.npy", ROWS[:2, :3])
    np.save("objects.npy", np.array([{}]), allow_pickle=True)
    texts = {
        "rows.csv": good,
        "rows.txt": good,
        "text.npy": good,
        "wide.csv": "1,2,3,4,5,6,7\n",
        "names.csv": "p,q,r,gamma1,gamma2,t\n" + good,
        "word.csv": good + "\n" + "1,2,3,0,0,one\n",
        "grouped.csv": "1_0,2,3,0,0,1\n",
        "tiny.csv": "0.0e-400,2,3,0,0,1\n1e-320,2,3,0,0,1\n",
        "none.csv": "1e-400,2,3,0,0,1\n",
        "other.csv": "\u0661,2,3,0,0,1\n",
        "nan.csv": good + "nan,2,3,0,0,1\n",
        "long.csv": good + "1,2,3,0,0,2\n",
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text, "utf-8")
    (tmp_path / "two.npy").write_bytes(2 * (tmp_path / "three.npy").read_bytes())
    (tmp_path / "short.npy").write_bytes((tmp_path / "three.npy").read_bytes()[:-8])
    assert said in refusal("sweep", scene, *options)

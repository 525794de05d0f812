"""`polhode sweep`: what it prints, writes, refuses, and how it exits."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

import polhode
from polhode import cli
from shared.motions import heavy_file
from shared.tools import press_ctrl_c

HEAVY = heavy_file(samples=3)


@pytest.fixture
def scene(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "heavy.toml").write_text(HEAVY)
    return "heavy.toml"


def run(capsys, *arguments):
    code = cli.main(["sweep", *arguments])
    output = capsys.readouterr()
    return code, output.out, output.err


def test_a_table_on_stdout_and_a_note_on_stderr(scene, capsys):
    code, out, err = run(capsys, scene, "--vary", "body.weight=0:1:3")
    lines = out.splitlines()
    assert code == 0
    assert lines[0].split()[:5] == ["member", "body.weight", "outcome", "steps", "t"]
    assert len(lines) == 4
    assert err == ("heavy.toml: 3 members, double (53 bits), not projected; 3 reached end\n")


def test_a_member_that_fails_is_told_and_written(scene, capsys, tmp_path):
    varied = ["--vary", "body.weight=1,1e6", "--max-steps", "300", "-o", "x.npz"]
    code, _, err = run(capsys, scene, *varied)
    assert code == 3
    assert "1 reached end, 1 step limit" in err
    assert "member 2 (body.weight = 1000000): the end needs more steps than the limit" in err
    with np.load(tmp_path / "x.npz", allow_pickle=False) as arrays:
        assert arrays["members.outcome"].tolist() == ["reached end", "step limit"]
        assert 3 < len(arrays["member"]) < 6  # rows that were reached


def test_outputs_are_left_out_and_that_is_said(scene, capsys, tmp_path):
    (tmp_path / "heavy.toml").write_text(HEAVY + 'outputs = ["angles"]\n')
    code, _, err = run(capsys, scene, "--vary", "body.weight=1")
    assert code == 0
    assert "not projected; angles left out; 1 reached end" in err


TOLD = r"\d+\.\d %, \d+ members(, \d+ s left)?"


@pytest.mark.slow
def test_what_is_finished_at_ctrl_c_is_kept_and_the_same_command_goes_on(
    scene, tmp_path, capsys, monkeypatch
):
    """A sweep of seconds, interrupted: no file yet, its finished members in a folder."""
    words = ["--at", "2000", "--vary", "start.omega[3]=0.5:1:200"]
    with monkeypatch.context() as patch:
        sentences = press_ctrl_c(patch, 2)
        code, _, err = run(capsys, scene, *words, "-o", "x.npz")
    assert code == 130
    not_run, reached = map(int, re.search(r"; (\d+) not run, (\d+) reached end\n", err).groups())
    assert not_run + reached == 200
    assert min(not_run, reached) > 0
    assert "polhode: the same command continues from x.npz.parts\n" in err
    assert all(re.fullmatch(TOLD, text) for text in sentences)
    assert {p.name for p in tmp_path.iterdir()} == {"heavy.toml", "x.npz.parts"}
    assert run(capsys, scene, *words, "-o", "x.npz")[0] == 0
    assert {p.name for p in tmp_path.iterdir()} == {"heavy.toml", "x.npz"}
    again = polhode.load_result("x.npz")
    assert again.fact("complete")
    assert again.to_json() == polhode.integrate_many(scene, [words[3]], at=[2000]).to_json()


# -- numbers kept instead of states ---------------------------------------------------------------


def test_a_number_that_is_not_there_is_null(scene, capsys):
    varied = ["--vary", "body.weight=1,1e6", "--max-steps", "300", "--keep", "final"]
    code, out, err = run(capsys, scene, *varied, "--json")
    columns = json.loads(out)["columns"]
    assert code == 3
    assert columns["final p"][0] is not None
    assert {columns[name][1] for name in columns if name.startswith("final")} == {None}
    assert "member 2 (body.weight = 1000000): the end needs more steps than the limit" in err


# -- starts in a file -----------------------------------------------------------------------------

ROWS = np.array([[0.1, 0.5, k, 0, 0.6, 0.8] for k in range(12)])
NAMES = ["p", "q", "r", "gamma1", "gamma2", "gamma3"]
STARTED = [f"start.{word}[{k}]" for word in ("omega", "gamma") for k in (1, 2, 3)]


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
    odd = csv_of(ROWS).replace(",", ";").replace(".", ",")
    (tmp_path / "commas.csv").write_text(f"# of a spreadsheet\n{odd}", "utf-16")
    np.savetxt(tmp_path / "noted.csv", ROWS[:, order], header=" ".join(header))  # after "# "
    for file in ("rows.npy", "plain.csv", "named.csv", "commas.csv", "noted.csv"):
        code, out, err = run(capsys, scene, "--starts", file, "-o", "x.npz")
        assert (code, out) == (0, "")
        assert err.startswith("heavy.toml: 12 members, double (53 bits)")
        with np.load("x.npz", allow_pickle=False) as arrays:
            states = np.stack([arrays[name] for name in NAMES], axis=-1)
            assert np.array_equal(states, many.states.reshape(-1, 6))
            starts = np.stack([arrays[f"members.{key}"] for key in STARTED], axis=-1)
            assert np.array_equal(starts, ROWS)
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
    with np.load("x.npz", allow_pickle=False) as arrays:
        assert np.longdouble(arrays["members.start.omega[1]"][0]) == np.longdouble("0.1") != 0.1


@pytest.mark.parametrize("ending", [".csv", ".json", ".npz"])
@pytest.mark.parametrize("number", ["double", "extended"])
def test_starts_of_a_result_are_its_states(scene, capsys, refusal, ending, number):
    states = polhode.integrate(scene, number, at=[1, 2])
    states.save(f"run{ending}")
    options = ["--starts", f"run{ending}", "--number", number, "--at", "0", "-o", "x.npz"]
    code, _, _ = run(capsys, scene, *options)
    assert code == 0
    with np.load("x.npz", allow_pickle=False) as arrays:
        starts = [arrays[f"members.{key}"].astype(states.states.dtype) for key in STARTED]
    assert np.stack(starts, axis=-1).tolist() == states.states.tolist()
    polhode.levels("lagrange/nutation").save(f"levels{ending}")
    message = refusal("sweep", scene, "--starts", f"levels{ending}")
    assert "expected columns p,q,r,gamma1,gamma2,gamma3" in message


GOOD = "1,2,3,0,0,1\n"
NO_ARRAY = "file: expected an array that NumPy wrote"
NONE = "file: expected a readable file of starts (No such file"
#: Files of starts, their contents, and what is said of them.
NO_STARTS = [
    ("rows.txt", GOOD, "rows.txt: --starts = .txt: expected a file .csv or .npy"),
    ("none.npy", None, NONE),
    ("none.npz", None, NONE),
    ("text.npy", GOOD, NO_ARRAY),
    ("objects.npy", np.array([{}]), NO_ARRAY),
    ("three.npy", ROWS[:2, :3], "starts = an array of shape (2, 3): expected shape (N, 6)"),
    ("wide.csv", "1,2,3,4,5,6,7\n", "line 1 = 1,2,3,4,5,6,7: expected 6 numbers p,q,r,gamma1"),
    (
        "x.csv",
        "p,q,r,gamma1,gamma2,t\n" + GOOD,
        "x.csv: line 1 = p,q,r,gamma1,gamma2,t: expected 6",
    ),
    ("x.csv", "# wx,wy,wz,gx,gy,gz\n" + GOOD, "line 1 = wx,wy,wz,gx,gy,gz: expected 6 numbers"),
    ("x.csv", GOOD + "\n1,2,3,0,0,one\n", "line 3 = 1,2,3,0,0,one: expected 6 numbers"),
    ("x.csv", "1_0,2,3,0,0,1\n", "line 1 = 1_0,2,3,0,0,1: expected 6 numbers"),
    ("x.csv", "0.0e-400,2,3,0,0,1\n1e-320,2,3,0,0,1\n", "line 2 = 1e-320,2,3,0,0,1: expected 6"),
    ("x.csv", "1e-400,2,3,0,0,1\n", "line 1 = 1e-400,2,3,0,0,1: expected 6 numbers"),
    ("x.csv", "\u0661,2,3,0,0,1\n", "line 1 = \u0661,2,3,0,0,1: expected 6 numbers"),
    (
        "x.csv",
        GOOD + "nan,2,3,0,0,1\n",
        "line 2 = ,2,3,0,0,1: expected 6 numbers p,q,r,gamma1,gamm",
    ),
    (
        "x.csv",
        GOOD + "inf,2,3,0,0,1\n",
        "starts, row 2 = [inf, 2.0, 3.0, 0.0, 0.0, 1.0]: expected f",
    ),
    (
        "x.csv",
        GOOD + "1,2,3,0,0,2\n",
        "start.gamma, row 2 = [0.0, 0.0, 2.0]: expected gamma of lengt",
    ),
]


@pytest.mark.parametrize(("file", "content", "message"), NO_STARTS, ids=range(len(NO_STARTS)))
def test_what_holds_no_starts_is_refused_in_one_line(scene, refusal, file, content, message):
    if isinstance(content, str):
        Path(file).write_text(content, "utf-8")
    elif content is not None:
        np.save(file, content, allow_pickle=True)
    assert message in refusal("sweep", scene, "--starts", file)


@pytest.mark.parametrize("change", [lambda data: data[:-8], lambda data: 2 * data])
def test_an_array_of_another_length_than_it_says_is_refused(scene, refusal, change):
    np.save("x.npy", ROWS)
    Path("x.npy").write_bytes(change(Path("x.npy").read_bytes()))
    assert NO_ARRAY + " (it is not" in refusal("sweep", scene, "--starts", "x.npy")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("", "--vary: expected numbers to vary or --starts FILE, one of them"),
        ("--starts x.csv --vary body.weight=1", "--vary = body.weight=1: expected"),
        ("--starts x.csv --number quad", "number = quad: expected double or extended"),
        ("--starts x.csv -o x.csv", "-o: expected another file than the one"),
    ],
)
def test_options_that_starts_do_not_go_with_are_refused(scene, refusal, options, message):
    Path("x.csv").write_text(GOOD)
    assert message in refusal("sweep", scene, *options.split())

"""The command line: exit codes and streams, what is written and what is not, files of others."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import pytest

from polhode import cli
from polhode.numbers.expression import decimal
from polhode.scenes.vocabulary import STATE
from shared.motions import free_file

DONE, BAD_INPUT, NOT_REACHED = 0, 2, 3
CASE = "euler/flat"  # cheap; gamma, a closed form, times 0 to 100

SCENE = free_file('end = 2\nsamples = 3\noutputs = ["angles", "attitude"]')


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder to work in, with one scene file."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "top.toml").write_text(SCENE)
    return tmp_path


def run(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    code = cli.main(arguments)
    out, err = capsys.readouterr()
    return code, out, err


def left(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*")} - {"top.toml"}


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["rum"], "did you mean 'run'?"),
        (["run"], "SCENE"),
        (["run", CASE, "--frob"], "--frob"),
        (["run", CASE, "a\nb"], "a b"),
        (["run", "euler/separatrx"], "did you mean 'euler/separatrix'"),
        (["run", "nosuch.toml"], "a path"),
        (["run", "x\0y"], "a path"),
        (["run", "no\nsuch"], "no such"),
        (["run", "."], "directory"),
        (["run", CASE, "--number", "duoble"], "did you mean 'double'"),
        (["run", CASE, "--digits", "0"], "digits = 0"),
        (["run", CASE, "--digits", "1.5"], "whole number"),
        (["run", CASE, "--digits", "9" * 5000], "whole number"),
        (["run", CASE, "--digits", "30", "--number", "double"], "quad"),
        (["run", CASE, "--tol", "1e-30"], "tol = 1e-30: expected between eps"),
        (["run", CASE, "--tol", "-1e-3"], "tol = -1e-3"),
        (["run", CASE, "--tol", "soon"], "tol = soon"),
        (["run", CASE, "--max-steps", "0"], "1 or more"),
        (["run", CASE, "--max-steps", "many"], "whole number"),
        (["run", CASE, "--at", ""], "--at"),
        (["run", CASE, "--at", "1,,2"], "--at"),
        (["run", CASE, "--at", "1,soon"], "--at = soon"),
        (["run", CASE, "--at", "2,1"], "run.at[2] = 1"),
        (["run", CASE, "--at", "-1,1"], "one sign"),
        (["run", CASE, "--at", "1,1.00000000000000000001"], "differ when rounded to double"),
        (["run", CASE, "--at", "1e400"], "wider range"),
        (["run", CASE, "--form", "principle"], "did you mean 'principal'"),
        (["run", CASE, "--outputs", "angels"], "did you mean 'angles'"),
        (["run", CASE, "-o", "nofolder/x.csv"], "existing folder"),
        (["run", CASE, "-o", "."], "not a folder"),
        (["run", CASE, "-o", ""], "-o = : expected a name"),
        (["run", CASE, "-o", "x.json"], "a name that ends in .csv"),
        (["run", CASE, "-o", "no\nfolder/x.csv"], "no folder/x.csv"),
        (["reference", CASE, "--digits", "0"], "digits = 0"),
        (["reference", "general/asymmetric-regular", "--at", "1"], "closed form"),
        (["check", "nosuch"], "a path"),
        (["check", CASE, "--number", "flaot"], "number = flaot"),
        (["compare", "none.csv", CASE], "none.csv"),
        (["compare", "top.toml", CASE], "a column t"),
    ],
    ids=lambda x: " ".join(x)[:40] if isinstance(x, list) else "",
)
def test_bad_input_is_one_line_on_stderr(
    capsys: pytest.CaptureFixture[str], folder: Path, arguments: list[str], said: str
) -> None:
    code, out, err = run(capsys, *arguments)
    assert (code, out) == (BAD_INPUT, "")
    assert err.startswith("polhode: ")
    assert err.endswith("\n")
    assert err[:-1].isprintable()
    assert said in err
    assert left(folder) == set()


def test_a_run_that_cannot_reach_its_end_writes_nothing_and_says_what_to_do(
    capsys: pytest.CaptureFixture[str], folder: Path
) -> None:
    code, out, err = run(capsys, "run", CASE, "--max-steps", "5", "-o", "x.csv", "--json")
    assert code == NOT_REACHED
    assert json.loads(out)["outcome"] == "step limit"
    assert json.loads(out)["steps"] == 5
    for part in ("of 100", "--max-steps", "x.csv was not written"):
        assert part in err
    assert left(folder) == set()


def test_the_json_of_a_run_keeps_the_contract(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "run", "top.toml", "--json", "--at", "0.1,1/3,pi")
    found = json.loads(out)
    assert (code, err) == (DONE, "")
    keys = "scene number bits form regime columns times states angles attitude drift outcome steps"
    assert {*keys.split(), "provenance"} <= found.keys()
    assert (found["number"], found["bits"], found["form"]) == ("double", 53, "principal")
    assert found["columns"] == [*STATE]
    assert [len(row) for row in found["states"]] == [6, 6, 6]
    assert [len(row) for row in found["angles"]] == [3, 3, 3]
    assert [len(row) for row in found["attitude"]] == [4, 4, 4]
    assert all(isinstance(x, str) for row in found["states"] for x in row)
    assert {"h", "f", "gamma"} <= found["drift"].keys()
    assert all(isinstance(x, str) for x in found["drift"].values())
    assert found["outcome"] == "reached end"
    assert decimal(found["times"][0]) == Fraction(0.1)  # the double, in full
    assert decimal(found["times"][1]) == Fraction(1 / 3)


@pytest.mark.parametrize(("number", "bits"), [("double", 53), ("extended", 64), ("quad", 113)])
def test_a_csv_round_trips_and_compare_judges_it(
    capsys: pytest.CaptureFixture[str], folder: Path, number: str, bits: int
) -> None:
    code, out, _ = run(capsys, "run", "top.toml", "--number", number, "-o", "x.csv")
    assert (code, out) == (DONE, "")
    assert left(folder) == {"x.csv", "x.json"}
    written = json.loads((folder / "x.json").read_text())
    assert (written["number"], written["bits"], written["scene"]) == (number, bits, "top.toml")
    header = (folder / "x.csv").read_text().splitlines()[0]
    assert header == "t,p,q,r,gamma1,gamma2,gamma3,psi,theta,phi,q0,q1,q2,q3"
    _, out, _ = run(capsys, "run", "top.toml", "--number", number, "--json")
    answer = json.loads(out)
    rows = [line.split(",") for line in (folder / "x.csv").read_text().splitlines()[1:]]
    assert [row[0] for row in rows] == answer["times"]
    assert [row[1:7] for row in rows] == answer["states"]
    for flags in ([], ["--number", number]):
        code, out, err = run(capsys, "compare", "x.csv", "top.toml", "--json", *flags)
        verdict = json.loads(out)
        assert (code, err) == (DONE, "")
        assert verdict["judged"] == [*STATE, "angles", "attitude"]
        assert verdict["not_judged"] == []
        digits_of_type = bits * math.log10(2)
        assert digits_of_type - 2 < verdict["worst"] < digits_of_type + 2
        assert {"omega", "gamma", "angles", "attitude"} == {*verdict["parts"]}
        assert all(digits_of_type - 2 < min(d) for d in verdict["parts"].values())


def test_a_quaternion_may_have_the_other_sign_but_one_for_the_whole_file(
    capsys: pytest.CaptureFixture[str], folder: Path
) -> None:
    """q and -q are the same attitude; a sign that changes on the way is no continuous motion."""
    run(capsys, "run", "top.toml", "-o", "x.csv")
    head, *rows = [line.split(",") for line in (folder / "x.csv").read_text().splitlines()]
    whole = math.log10(2) * 53
    for changed, least, most in (
        ((), whole - 2, whole + 2),
        (range(3), whole - 2, whole + 2),
        ((1,), 0, 1),
    ):
        signed = [
            [*row[:-4], *(str(-float(x)) for x in row[-4:])] if k in changed else row
            for k, row in enumerate(rows)
        ]
        lines = "".join(",".join(row) + "\n" for row in [head, *signed])
        verdict = judged(capsys, lines)
        assert verdict["judged"] == [*STATE, "angles", "attitude"]
        assert least <= min(verdict["parts"]["attitude"]) <= most
        assert min(verdict["parts"]["angles"]) > whole - 2


HEAD = "t,p,q,r,gamma1,gamma2,gamma3\n"
START = "0,0.3,-0.4,1.1,0.6,0,0.8\n"


def judged(capsys: pytest.CaptureFixture[str], content: str | bytes, *flags: str) -> dict:
    """The verdict on a foreign file."""
    raw = content.encode() if isinstance(content, str) else content
    Path("foreign.csv").write_bytes(raw)
    code, out, err = run(capsys, "compare", "foreign.csv", "top.toml", "--json", *flags)
    assert (code, err) == (DONE, "")
    return json.loads(out)


@pytest.mark.parametrize(
    "content",
    [
        HEAD + START,
        "\ufeff" + HEAD + START,
        (HEAD + START).replace("\n", "\r\n"),
        (HEAD + START).replace(",", " , "),
        "# a comment\n\n" + HEAD + '#,"an open quote\n' + START + "\n\n",
        '"t","p","q","r","gamma1","gamma2","gamma3"\n' + START,
        HEAD + "0e5,3E-1,-.4,+1.10,6e-1,-0,0." + "8" + "0" * 60 + "\n",
        HEAD + START.rstrip("\n"),
    ],
    ids=["plain", "bom", "crlf", "spaces", "comments", "quotes", "notation", "no last newline"],
)
def test_the_usual_shapes_of_csv_are_read(capsys: pytest.CaptureFixture[str], content: str) -> None:
    verdict = judged(capsys, content)
    assert verdict["judged"] == [*STATE]
    assert verdict["times"] == ["0"]
    assert verdict["worst"] == pytest.approx(verdict["correct_digits"][0])
    assert verdict["worst"] >= 3  # every digit that is there
    assert float(verdict["drift"]["h"]) < 10 ** -verdict["worst"]


def test_drift_of_a_projected_file_is_no_evidence(capsys: pytest.CaptureFixture[str]) -> None:
    for options, notes in (((), 1), (("--no-project",), 0)):
        arguments = ["run", "kovalevskaya/generic", "--at", "500", "-o", "x.csv", *options]
        assert cli.main(arguments) == 0
        capsys.readouterr()
        assert cli.main(["compare", "x.csv", "kovalevskaya/generic", "--number", "double"]) == 0
        out = capsys.readouterr().out
        assert out.count("they were projected") == notes
        assert ("drift h" in out) == (not notes)


def test_a_subset_of_the_columns_in_any_order_is_judged(
    capsys: pytest.CaptureFixture[str],
) -> None:
    verdict = judged(capsys, "q2,gamma3,note,t,p\n,0.8,hello,0,0.3\n")
    assert verdict["judged"] == ["p", "gamma3"]
    assert "attitude was not judged: none of it has a value" in verdict["not_judged"]
    assert any("note" in line for line in verdict["not_judged"])
    assert any("column q is not in the file" in line for line in verdict["not_judged"])
    assert verdict["drift"] is None


def test_an_empty_cell_is_not_judged_and_said_so(capsys: pytest.CaptureFixture[str]) -> None:
    verdict = judged(capsys, HEAD + "0,0.3,,1.1,0.6,0,0.8\n")
    assert verdict["worst"] >= 3
    assert "empty cells were not judged" in verdict["not_judged"]


def test_times_may_be_negative_unsorted_and_repeated(capsys: pytest.CaptureFixture[str]) -> None:
    times = ["1", "-2", "0", "1", "-0.5", "1e-400"]
    _, out, _ = run(capsys, "reference", "top.toml", "--at", "0,1", "--digits", "20", "--json")
    _, backward, _ = run(capsys, "reference", "top.toml", "--at", "-0.5,-2", "--json")
    states = json.loads(out)["states"] + json.loads(backward)["states"]
    by_time = dict(zip(["0", "1", "-0.5", "-2"], states, strict=True))
    by_time["1e-400"] = by_time["0"]
    content = HEAD + "".join(",".join([t, *by_time[t]]) + "\n" for t in times)
    verdict = judged(capsys, content)
    assert [Fraction(t) for t in verdict["times"]] == [decimal(t) for t in times]
    assert verdict["worst"] >= 20


@pytest.mark.parametrize("flags", [[], ["--number", "double"]])
def test_a_foreign_number_is_exact_unless_its_type_is_named(
    capsys: pytest.CaptureFixture[str], flags: list[str]
) -> None:
    third = "0.3" + "0" * 30 + "1"
    verdict = judged(capsys, HEAD + START.replace("0.3", third), *flags)
    expected = 53 * math.log10(2) if flags else 32
    assert verdict["worst"] == pytest.approx(expected, abs=0.5)


def test_a_wrong_number_is_judged_wrong(capsys: pytest.CaptureFixture[str]) -> None:
    assert judged(capsys, HEAD + START.replace("0.3", "0.30121"))["worst"] == pytest.approx(
        3, abs=0.1
    )
    assert judged(capsys, HEAD + START.replace("0.3", "1e4000"))["worst"] == 0
    assert judged(capsys, HEAD + START.replace("0.3", "-0.3"))["worst"] < 1


def test_digits_of_the_times_are_not_digits_of_the_states(
    capsys: pytest.CaptureFixture[str],
) -> None:
    verdict = judged(capsys, HEAD + START.replace("0,", "0." + "0" * 60 + "1,", 1))
    assert verdict["worst"] < 10


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("", "a header line"),
        ("\n\n# nothing\n", "a header line"),
        (HEAD, "at least one line of numbers"),
        ("p,q\n1,2\n", "a column t"),
        (START, "a column t"),
        ("t,p,p\n1,2,3\n", "header = p: expected each column once"),
        ("t,t\n1,2\n", "header = t: expected each column once"),
        ("t,p\n0,1\n\n# x\n1,abc\n", "foreign.csv:5: p = abc: expected a finite decimal"),
        ("t,p\n0,inf\n", "foreign.csv:2: p = inf"),
        ("t,p\n0,1/3\n", "foreign.csv:2: p = 1/3"),
        ("t,p\n0,1d5\n", "foreign.csv:2: p = 1d5"),
        ("t,p\n0,_1\n", "foreign.csv:2: p = _1"),
        ("t,p\n0,1e99999\n", "foreign.csv:2: p = 1e99999"),
        ("t,p\n,1\n", "foreign.csv:2: t"),
        ("t,p\n0,1,2\n", "foreign.csv:2: line = 0,1,2: expected 2 values"),
        ("t,p\n0\n", "foreign.csv:2: line = 0"),
        ("x;p\n0;1\n", "a column t"),
        ("t;p\n0;1,5\n1;2.5\n", "foreign.csv:2: p = 1,5"),
        (b"\xff\xfe\x00", "readable CSV"),
        (b"t,p\n\x00,1\n", "foreign.csv"),
        ("x" * 3_000_000, "foreign.csv"),
        ("t,p\n" + "1," * 300_000 + "\n", "expected 2 values"),
        ("t,p\n0,'" + '"' * 999 + "\n", "foreign.csv"),
    ],
    ids=lambda x: repr(x[:20]) if len(x) > 20 else repr(x),
)
def test_a_foreign_file_that_cannot_be_read_is_refused_with_its_line(
    capsys: pytest.CaptureFixture[str], content: str | bytes, said: str
) -> None:
    Path("foreign.csv").write_bytes(content if isinstance(content, bytes) else content.encode())
    code, out, err = run(capsys, "compare", "foreign.csv", "top.toml")
    assert (code, out) == (BAD_INPUT, "")
    assert said in err
    assert err[:-1].isprintable()


def test_a_file_that_is_there_stays_when_it_cannot_be_replaced(
    capsys: pytest.CaptureFixture[str], folder: Path
) -> None:
    (folder / "x.csv").write_text("mine")
    (folder / "x.json").mkdir()
    code, _, err = run(capsys, "run", "top.toml", "-o", "x.csv")
    assert code == BAD_INPUT
    assert "x.json: file: expected a file, not a folder" in err
    assert (folder / "x.csv").read_text() == "mine"
    assert left(folder) == {"x.csv", "x.json"}


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_cannot_be_written_to_is_refused(
    capsys: pytest.CaptureFixture[str], folder: Path
) -> None:
    (folder / "closed").mkdir(mode=0o500)
    code, out, err = run(capsys, "run", "top.toml", "-o", "closed/x.csv")
    assert (code, out) == (BAD_INPUT, "")
    assert "can be written" in err


def polhode(*arguments: str, **options: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "polhode", *arguments]
    return subprocess.run(command, text=True, check=False, timeout=60, **options)  # type: ignore[call-overload, no-any-return]


def test_the_module_is_the_program() -> None:
    done = polhode("about", "--json", capture_output=True)
    assert (done.returncode, done.stderr) == (DONE, "")
    assert json.loads(done.stdout)["number_types"]["quad"]["bits"] == 113
    refused = polhode("show", "nosuch", capture_output=True)
    assert (refused.returncode, refused.stdout) == (BAD_INPUT, "")
    assert refused.stderr.count("\n") == 1


@pytest.mark.skipif(os.name != "posix", reason="pipes of a POSIX shell")
def test_a_reader_that_goes_away_is_no_error() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    done = polhode("run", CASE, "--json", stdout=writer, stderr=subprocess.PIPE)
    os.close(writer)
    assert (done.returncode, done.stderr) == (DONE, "")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_full_disk_is_one_line() -> None:
    with Path("/dev/full").open("w") as full:
        done = polhode("about", stdout=full, stderr=subprocess.PIPE)
    assert done.returncode == BAD_INPUT
    assert done.stderr.startswith("polhode: stdout: expected")
    assert done.stderr.count("\n") == 1


def test_a_negative_end_may_have_an_exponent(tmp_path: Path) -> None:
    for end in ("-1e1", "-10", "-1,2"):
        path = tmp_path / f"x{end}.html"
        code = cli.main(["view", "euler/largest-axis", "--end", end, "-o", str(path)])
        assert (code, path.exists()) == ((2, False) if "," in end else (0, True))


def test_a_certificate_does_not_replace_the_file_beside_a_table(tmp_path, capsys):
    """Nor a table's file a certificate: both orders are refused before the work."""
    ask = ["reference", "lagrange/nutation", "--at", "1", "--digits", "15", "--certified", "-o"]
    table, certificate = tmp_path / "ref.csv", tmp_path / "ref.json"
    assert cli.main([*ask, str(table)]) == 0
    kept = certificate.read_bytes()
    assert cli.main([*ask, str(certificate)]) == 2
    assert "a new file, or a certificate's" in capsys.readouterr().err
    assert certificate.read_bytes() == kept
    assert cli.main([*ask, str(tmp_path / "own.json")]) == 0
    assert cli.main([*ask, str(tmp_path / "own.json")]) == 0  # one certificate in place of another
    capsys.readouterr()
    assert cli.main([*ask, str(tmp_path / "own.csv")]) == 2
    assert "perhaps a certificate" in capsys.readouterr().err
    assert not (tmp_path / "own.csv").exists()

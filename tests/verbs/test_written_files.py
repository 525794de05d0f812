"""What verbs write, what they read again, and what stays as it was."""

import io
import json
import math
import os
import pickle
import re
import signal
import sys
import threading
from dataclasses import replace
from fractions import Fraction
from html import unescape
from pathlib import Path

import pytest

import polhode
from polhode import BadInput, cli
from polhode.common import files
from shared.motions import free_file
from shared.tools import ANGLES, ATTITUDE, STATE, tiers

TOP = free_file("at = [0, 1]")
WATCHED = free_file('end = 2\nsamples = 3\noutputs = ["angles", "attitude"]')
DIGITS_OF_DOUBLE = 53 * math.log10(2)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("top.toml").write_text(TOP)
    Path("watched.toml").write_text(WATCHED)
    return tmp_path


def ran(capsys, *words: str, code: int = 0) -> tuple[str, str]:
    """What a command prints on both streams."""
    assert cli.main([*words]) == code, capsys.readouterr().err
    return capsys.readouterr()


def answered(capsys, *words: str, code: int = 0) -> dict:
    """What a command says as JSON."""
    return json.loads(ran(capsys, *words, "--json", code=code)[0])


def left() -> set[str]:
    return {path.name for path in Path().iterdir()} - {"top.toml", "watched.toml"}


# -- runs and their tables -------------------------------------------------------------------------


@pytest.mark.parametrize("outputs", [[], ["--outputs", "hodographs"]])
def test_a_run_that_cannot_reach_its_end_writes_what_it_has_and_says_what_to_do(capsys, outputs):
    words = ["run", "euler/flat", "--max-steps", "5", "-o", "x.csv", "--json", *outputs]
    out, err = ran(capsys, *words, code=3)
    answer = json.loads(out)
    assert (answer["outcome"], answer["steps"]) == ("step limit", 5)
    for part in ("of 100", "--max-steps"):
        assert part in err
    assert left() == {"x.csv", "x.csv.json"}
    assert polhode.load_result("x.csv").to_json() == out


def test_a_run_that_reaches_no_output_time_tells_no_drift(capsys):
    words = ["run", "lagrange/nutation", "--at", "1000", "--max-steps", "2"]
    _, err = ran(capsys, *words, code=3)
    assert "step limit, 2 steps; no output time was reached" in err
    assert "drift" not in err


def test_the_json_of_a_run_keeps_the_contract(capsys):
    answer = answered(capsys, "run", "watched.toml", "--at", "0.1,1/3,pi")
    keys = "scene scene_text number bits digits form method outcome reached steps tolerance"
    assert {*keys.split(), "drift_h", "drift_f", "drift_gamma", "provenance"} <= answer.keys()
    assert (answer["number"], answer["bits"], answer["form"]) == ("double", 53, "principal")
    columns = ["t", *STATE, *ANGLES, *ATTITUDE]
    assert [*answer["columns"]] == columns == [*answer["about"]["columns"]]
    assert all(len(answer["columns"][name]) == 3 for name in columns)
    assert all(isinstance(x, float) for x in answer["columns"]["p"])
    assert answer["outcome"] == "reached end"
    assert answer["columns"]["t"] == [0.1, 1 / 3, math.pi]


@pytest.mark.parametrize(("number", "bits"), [("double", 53), ("extended", 64), ("quad", 113)])
def test_a_csv_round_trips_and_compare_judges_it(capsys, number, bits):
    run = ["run", "watched.toml", "--number", number]
    assert ran(capsys, *run, "-o", "x.csv")[0] == ""
    assert left() == {"x.csv", "x.csv.json"}
    written = json.loads(Path("x.csv.json").read_text())
    assert (written["number"], written["bits"], written["scene"]) == (number, bits, "watched.toml")
    header, *lines = Path("x.csv").read_text().splitlines()
    assert header == "t,p,q,r,gamma1,gamma2,gamma3,psi,theta,phi,q0,q1,q2,q3"
    columns = answered(capsys, *run)["columns"]
    shown = [map(str, values) for values in columns.values()]
    assert [line.split(",") for line in lines] == [list(row) for row in zip(*shown, strict=True)]
    digits = bits * math.log10(2)
    for flags in ([], ["--number", number]):
        verdict = answered(capsys, "compare", "x.csv", "watched.toml", *flags)
        assert verdict["judged"] == [*STATE, "angles", "attitude"]
        assert verdict["not_judged"] == []
        assert digits - 2 < verdict["worst"] < digits + 2
        for name in ("omega", "gamma", "angles", "attitude"):
            part = verdict["columns"][f"correct_digits_{name}"]
            assert all(digits - 2 < x < digits + 2 for x in part)


@pytest.mark.parametrize("t", tiers(["1e-400"], ["1e400"]))
def test_times_beyond_the_range_of_a_double(capsys, t):
    large = t == "1e400"
    ran(capsys, "run", "top.toml", "--number", "mp", "--at", t, code=3 if large else 0)
    Path("x.csv").write_text(f"t,p\n{t},0.3\n")
    ran(capsys, "compare", "x.csv", "top.toml", code=2 if large else 0)
    words = ["plot", "top.toml", "--what", "angles", "-o", "x.svg", "--end", t]
    assert cli.main(words) in (2, 3)
    assert capsys.readouterr().err.count("\n") == 1


# -- tables of others ------------------------------------------------------------------------------

HEAD = "t,p,q,r,gamma1,gamma2,gamma3\n"
START = "0,0.3,-0.4,1.1,0.6,0,0.8\n"


def judged(capsys, content: str, *flags: str) -> dict:
    """The verdict on a foreign file."""
    Path("foreign.csv").write_bytes(content.encode())
    return answered(capsys, "compare", "foreign.csv", "top.toml", *flags)


THIRD = "0.3" + "0" * 30 + "1"


@pytest.mark.parametrize(
    ("old", "new", "flags", "least", "most"),
    [
        ("0.3", THIRD, [], 31.5, 32.5),  # exact, unless its type is named
        ("0.3", THIRD, ["--number", "double"], DIGITS_OF_DOUBLE - 0.5, DIGITS_OF_DOUBLE + 0.5),
        ("0.3", "0.30121", [], 2.9, 3.1),
        ("0.3", "1e4000", [], 0, 0),
        ("0.3", "-0.3", [], 0, 1),
        ("0,0.3", f"0.{'0' * 60}1,0.3", [], 0, 10),  # digits of a time are none of the states
    ],
)
def test_a_number_is_judged_for_what_it_is(capsys, old, new, flags, least, most):
    assert least <= judged(capsys, HEAD + START.replace(old, new, 1), *flags)["worst"] <= most


def test_what_is_not_in_a_table_is_told_and_not_judged(capsys):
    verdict = judged(capsys, "q2,gamma3,note,t,p\n,0.8,hello,0,0.3\n")
    assert verdict["judged"] == ["p", "gamma3"]
    assert "drift_h" not in verdict
    sentences = "\n".join(verdict["not_judged"])
    for part in ("attitude was not judged: none", "note", "columns q r gamma1 gamma2 are not in"):
        assert part in sentences
    verdict = judged(capsys, HEAD + "0,0.3,,1.1,0.6,0,0.8\n")
    assert verdict["worst"] >= 3
    assert "empty cells were not judged" in verdict["not_judged"]


def test_times_may_be_negative_unsorted_and_repeated(capsys):
    rows = {}
    for at in ("0,1", "-0.5,-2"):
        answer = answered(capsys, "reference", "top.toml", f"--at={at}", "--digits", "20")
        states = zip(*(answer["columns"][name] for name in STATE), strict=True)
        rows |= dict(zip(at.split(","), states, strict=True))
    rows["1e-400"] = rows["0"]
    times = ["1", "-2", "0", "1", "-0.5", "1e-400"]
    verdict = judged(capsys, HEAD + "".join(",".join([t, *rows[t]]) + "\n" for t in times))
    assert [Fraction(t) for t in verdict["columns"]["t"]] == [Fraction(t) for t in times]
    assert verdict["worst"] >= 20


# -- where files are written -----------------------------------------------------------------------


def test_a_file_stays_what_it_is(capsys):
    """Links are followed and stay links, permissions stay, a device is a device, a pipe a pipe."""
    Path("deep").mkdir()
    Path("link.csv").symlink_to("deep/y.csv")
    Path("mine.csv").touch(0o640)
    os.chmod("mine.csv", 0o640)
    os.mkfifo("pipe.csv")
    heard: list[str] = []
    reader = threading.Thread(target=lambda: heard.append(Path("pipe.csv").read_text()))
    reader.start()
    for name in ("link.csv", "mine.csv", "pipe.csv", os.devnull):
        ran(capsys, "run", "top.toml", "-o", name)
    reader.join(10)
    assert Path("link.csv").is_symlink()
    assert Path("deep/y.csv").read_text().startswith("t,p,q,r")
    assert json.loads(Path("link.csv.json").read_text())["number"] == "double"
    assert os.stat("mine.csv").st_mode & 0o777 == 0o640
    assert heard[0].startswith("t,p,q,r")
    assert Path("pipe.csv").is_fifo()
    assert not Path(os.devnull).is_file()


def test_a_file_that_is_there_stays_when_it_cannot_be_replaced(capsys):
    Path("x.csv.json").mkdir()
    _, err = ran(capsys, "run", "top.toml", "-o", "x.csv", code=2)
    assert "x.csv.json: file: expected a file, not a folder" in err
    Path("y.csv").write_text("mine")
    _, err = ran(capsys, "run", "top.toml", "-o", "y.csv", code=2)
    assert "y.csv: file: expected another name: polhode did not write it" in err
    assert Path("y.csv").read_text() == "mine"
    assert left() == {"x.csv.json", "y.csv"}


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_cannot_be_written_to_is_refused(capsys):
    Path("closed").mkdir(mode=0o500)
    out, err = ran(capsys, "run", "top.toml", "-o", "closed/x.csv", code=2)
    assert out == ""
    assert "can be written" in err


def test_a_certificate_replaces_a_certificate_alone(capsys):
    """Refused before the work."""
    ask = ["certify", "lagrange/nutation", "--at", "1", "--digits", "15", "-o"]
    ran(capsys, *ask, "ref.csv")
    before = Path("ref.csv.json").read_bytes()
    assert "a new file, or a certificate's" in ran(capsys, *ask, "ref.csv.json", code=2)[1]
    assert Path("ref.csv.json").read_bytes() == before
    for _ in range(2):  # one certificate in place of another
        ran(capsys, *ask, "own.json")
    run = ["run", "lagrange/nutation", "--at", "1", "-o", "own.json"]
    assert "another name: polhode did not write it" in ran(capsys, *run, code=2)[1]


@pytest.mark.parametrize("words", ["show pipe", "compare pipe top.toml"])
@pytest.mark.parametrize("silent", [False, True])
def test_a_pipe_from_which_nothing_comes_is_refused(capsys, monkeypatch, words, silent):
    monkeypatch.setattr(files, "PATIENCE", 0.2)
    os.mkfifo("pipe")
    handle = os.open("pipe", os.O_RDWR) if silent else None
    assert "nothing came for 0.2 seconds" in ran(capsys, *words.split(), code=2)[1]
    if handle is not None:
        os.close(handle)


def test_a_scene_from_a_pipe_is_read_once(capsys):
    """Its rows were printed, and a note asked the pipe for the scene again."""
    os.mkfifo("pipe")
    writer = threading.Thread(target=Path("pipe").write_text, args=(WATCHED,))
    writer.start()
    words = "reference pipe --at 1 --digits 20 --backend mpmath"
    assert "without angles, attitude: mpmath has" in ran(capsys, *words.split())[1]
    writer.join(10)


def test_bytes_go_to_a_stream_of_text_as_text(capsys, monkeypatch):
    """It was an AttributeError, as of a stdout that is closed: neither has what takes bytes."""
    words = ["reference", "euler/flat", "--at", "1", "-o", "-"]
    table, _ = ran(capsys, *words)
    text = io.StringIO()
    with monkeypatch.context() as patch:
        patch.setattr(sys, "stdout", text)
        assert cli.main(words) == 0
        assert text.getvalue() == table != ""
        with pytest.raises(BadInput, match="a standard output that takes bytes"):
            files.write_stdout(b"\xff")
    monkeypatch.setattr(sys, "stdout", None)
    assert cli.main(words) == 2
    said = "polhode: cannot write to standard output: Bad file descriptor\n"
    assert capsys.readouterr().err.endswith(said)


def test_two_names_of_one_place_leave_nothing_hidden(folder):
    Path("s").mkdir()
    files.write_whole({Path("x.txt"): "first", Path("s/../x.txt"): "second"})
    assert left() == {"s", "x.txt"}
    assert Path("x.txt").read_text() == "second"


def test_a_fault_of_the_system_is_not_blamed_on_stdout(capsys, monkeypatch):
    from polhode.scenes import library

    def fail(_, takes=None):
        raise OSError(24, "Too many open files", "cases")

    monkeypatch.setattr(library, "load", fail)
    said = "polhode: cases: expected to be usable (Too many open files)\n"
    assert ran(capsys, "show", "top.toml", code=2) == ("", said)


class Full:
    """A stream on a full disk."""

    def write(self, text: str) -> int:
        raise OSError(28, "No space left on device")

    def flush(self) -> None:
        self.write("")

    def isatty(self) -> bool:
        return False


@pytest.mark.parametrize(("words", "code"), [("run nosuch", 2), ("run top.toml -o x.csv", 0)])
def test_notes_that_nobody_hears_change_no_exit_code(words, code, monkeypatch):
    monkeypatch.setattr(sys, "stderr", Full())
    assert cli.main(words.split()) == code
    assert Path("x.csv").exists() == (code == 0)


# -- names and titles ------------------------------------------------------------------------------


@pytest.mark.slow
def test_results_hold_no_folder_that_the_scene_was_read_from(capsys, tmp_path):
    scene = str(tmp_path / "watched.toml")
    ran(capsys, "run", scene, "-o", "x.csv")
    ran(capsys, "plot", scene, "--what", "angles", "-o", "x.svg")
    ran(capsys, "view", scene, "-o", "x.html")
    for words in (
        *(["run", scene], ["show", scene], ["reference", scene]),
        ["compare", str(tmp_path / "x.csv"), scene],
        ["frequencies", scene, "--of", "p", "--lines", "1"],
    ):
        Path(f"{words[0]}.json").write_text(json.dumps(answered(capsys, *words)))
    written = [path for path in Path().iterdir() if path.suffix in (".json", ".svg", ".html")]
    assert len(written) == 8
    for path in written:
        assert str(tmp_path) not in path.read_text(), path.name
        assert "watched.toml" in path.read_text(), path.name
    assert json.loads(Path("compare.json").read_text())["file"] == "x.csv"


def test_a_fault_of_a_library_call_names_the_path_wherever_the_scene_went(tmp_path):
    scene = pickle.loads(pickle.dumps(polhode.load(str(tmp_path / "top.toml"))))
    assert scene.name == "top.toml"
    with pytest.raises(BadInput) as fault:
        polhode.integrate(scene, max_steps=0)
    assert fault.value.source == str(tmp_path / "top.toml")


#: A name, and a title, that would command a terminal, begin a line of their own and turn it around.
ODD = "a\x1b[31m\nz\u202e!"
SHOWN = "a?[31m z?!"


@pytest.mark.slow
def test_names_of_any_kind_are_one_line_that_commands_no_terminal(capsys):
    word = json.dumps(ODD)
    words = f"title = {word}\ntags = [{word}]\ncite = [{word}]"
    Path(f"{ODD}.toml").write_text(TOP.replace("schema = 1", f"schema = 1\n{words}"))
    scene = polhode.load(f"{ODD}.toml")
    renamed = replace(scene, name=ODD)
    assert (scene.title, scene.name, renamed.name) == (ODD, f"{SHOWN}.toml", SHOWN)
    run = polhode.integrate(scene)
    run.save(f"{ODD}.csv")
    results = [scene, renamed, run, polhode.reference(scene), polhode.conditioning(scene)]
    results += [polhode.compare(run), polhode.view(scene), polhode.compare(f"{ODD}.csv", scene)]
    for result in results:
        assert repr(result).isprintable()
        assert SHOWN in repr(result) or result is results[-1]
    for verb in (["show"], ["run"], ["reference"], ["new", "new.toml", "--like"]):
        assert not re.search("\x1b|\nz|\u202e", "".join(ran(capsys, *verb, f"{ODD}.toml")))
    ran(capsys, "plot", f"{ODD}.toml", "--what", "angles", "-o", "x.svg")
    pages = [polhode.view(scene, end=1)._repr_html_(), scene._repr_html_()]
    for page in [*pages, Path("x.svg").read_text()]:
        assert not re.search("\x1b|\u202e", page)


def test_a_callers_handlers_of_signals_are_put_back(capsys):
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    ran(capsys, "about")
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == before


def test_a_callers_alarm_is_put_back(capsys):
    """The time limit of what show tells of frequencies switched it off."""
    signal.setitimer(signal.ITIMER_REAL, 100, 50)
    try:
        ran(capsys, "show", "lagrange/nutation")
    finally:
        rest, interval = signal.setitimer(signal.ITIMER_REAL, 0)
    assert 50 < rest < 100
    assert interval == 50


# -- Several files of one command, several motions on one page -------------------------------------


def test_a_page_of_several_motions_has_each_one_s_page(capsys):
    words = "One & two.\n\nThree <four>.\n"
    polhode.integrate("lagrange/looping", at=[0, 1]).save("run.csv")
    tops = ["euler/dzhanibekov", "run.csv"]
    command = ["view", *tops, "--end", "1", "--title", "A <lesson>", "--text", words]
    ran(capsys, *command, "-o", "x.html")
    text = Path("x.html").read_text()
    assert "<h1>A &lt;lesson&gt;</h1>" in text
    assert "<p>One &amp; two.</p>\n<p>Three &lt;four&gt;.</p>" in text
    assert text.endswith("</html>\n")
    assert 'document.addEventListener("load"' in text  # the load of a frame reaches no window
    assert "new ResizeObserver(fit)" in text  # a frame was 46rem high, with a scrollbar of its own
    command = re.compile(r"<code>polhode view [^<]*</code>")
    pages = [unescape(x) for x in re.findall(r'srcdoc="([^"]*)"', text)]
    for page, top in zip(pages, tops, strict=True):
        ran(capsys, "view", top, "--end", "1", "-o", "alone.html")
        assert command.sub("", page) == command.sub("", Path("alone.html").read_text())
    assert polhode.view(*tops, end=1, title="A <lesson>", text=words).name == "A <lesson>"


# -- Output times on the command line: the same options, read alike, of every verb that has them ---

CASE = "lagrange/nutation"  # 81 times to t = 40
PART = Fraction(1, 3)
TIMES = {
    "--at 1,2.5": [1, Fraction(5, 2)],
    "--at 0:1:3,5": [0, Fraction(1, 2), 1, 5],
    "--at -1/3": [-PART],
    "--at 2:2:1": [2],
    "--at 0:-1:4,-2:-3:2": [0, -PART, -2 * PART, -1, -2, -3],
    "--end 1 --samples 3": [0, Fraction(1, 2), 1],
    "--end -1 --samples 2": [0, -1],
    "--samples 3": [0, 20, 40],
    "--end 8": [Fraction(k, 10) for k in range(81)],
    "--every 16": [0, 16, 32],
    "--end 1 --every 1/3": [0, PART, 2 * PART, 1],
    "--end 1 --every 0.1": [Fraction(k, 10) for k in range(11)],
    "--end -1 --every 0.3": [-Fraction(3 * k, 10) for k in range(4)],
    "--end 1.9999999999999999999 --every 1": [0, 1],
    "--end 5 --every 5": [0, 5],
}


@pytest.mark.parametrize(
    ("verb", "options"),
    [("run", options) for options in TIMES]
    + [(verb, options) for verb in ("reference", "sweep") for options in [*TIMES][1::4]],
)
def test_times_are_those_asked_for(verb, options, capsys):
    """In double, but for the last digit printed."""
    more = ["--vary", "start.omega[1]=0"] if verb == "sweep" else []
    times = answered(capsys, verb, CASE, *more, *options.split())["columns"]["t"]
    for time, right in zip(times, TIMES[options], strict=True):
        assert abs(Fraction(time) - right) <= abs(right) * Fraction(2) ** -52

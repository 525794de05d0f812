"""Streams that are full, links that lead nowhere, words out of place, names that are none."""

from __future__ import annotations

import json
import pickle
import re
import resource
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

import polhode
from polhode import cli
from polhode.common import checkpoint
from polhode.common.checkpoint import JobCheckpoint
from polhode.common.errors import BadInput
from polhode.common.files import called
from polhode.studies import report
from polhode.verbs import terminal
from shared.motions import free_file

COMMAND = [sys.executable, "-m", "polhode"]
FULL = pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("top.toml").write_text(free_file("at = [0, 1]"))


def refusal(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """What a command says that is refused in one line."""
    code = cli.main([*arguments])
    out, err = capsys.readouterr()
    assert (code, out, err.count("\n")) == (2, "", 1)
    return err


# -- streams that take no more -------------------------------------------------------------------


@FULL
@pytest.mark.parametrize("words", [["--help"], ["run", "--help"], ["--version"]])
def test_help_that_gets_lost_is_no_success(words: list[str]) -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run([*COMMAND, *words], stdout=full, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 2
    assert done.stderr.startswith("polhode: stdout: expected a place to write to")


class Full:
    """A stream on a full disk."""

    def write(self, text: str) -> int:
        raise OSError(28, "No space left on device")

    def flush(self) -> None:
        self.write("")

    def isatty(self) -> bool:
        return False


@pytest.mark.parametrize(
    ("words", "code"), [(["run", "nosuch"], 2), (["run", "top.toml", "-o", "x.csv"], 0)]
)
def test_notes_that_nobody_hears_change_no_exit_code(
    words: list[str], code: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "stderr", Full())
    assert cli.main(words) == code
    assert Path("x.csv").exists() == (code == 0)


# -- names and words -----------------------------------------------------------------------------


def test_a_link_that_leads_nowhere_is_named_with_its_end(capsys) -> None:
    Path("x.csv").symlink_to("nowhere/y.csv")
    told = refusal(capsys, "run", "top.toml", "-o", "x.csv")
    assert "nowhere, where this link leads" in told
    assert "folder .\n" not in told


@pytest.mark.parametrize(
    "words",
    [
        ["--", "run", "top.toml"],
        ["run", "--", "--digits", "20", "top.toml"],
        ["run", "top.toml", "--", "--digits", "20"],
    ],
)
def test_options_after_two_dashes_are_told_by_the_dashes(capsys, words: list[str]) -> None:
    assert "argument = --: expected the verb and its options before it" in refusal(capsys, *words)


def test_a_file_whose_name_begins_with_a_dash_is_read(capsys) -> None:
    Path("-top.toml").write_text(free_file("at = [0, 1]"))
    assert cli.main(["run", "--at", "1", "--", "-top.toml"]) == 0


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--digits", "9" * 20], f"--digits = {'9' * 20}: expected a whole number of at most 18"),
        (["--digits", "1" * 17], f"digits = {'1' * 17}: expected a whole number, 1 to 4000"),
        (["--digits", "many"], "--digits = many: expected a whole number\n"),
        (["--max-steps", "0"], "--max-steps = 0: expected 1 or more\n"),
    ],
)
def test_a_number_is_refused_for_what_it_is(capsys, words: list[str], told: str) -> None:
    assert told in refusal(capsys, "run", "top.toml", *words)


@pytest.mark.parametrize(
    "words",
    [
        ["run", ""],
        ["run", "top.toml", "-o", ""],
        ["compare", "", "top.toml"],
        ["compare", "x.csv", ""],
        ["plot", "", "--what", "angles", "-o", "x.svg"],
        ["plot", "top.toml", "--what", "angles", "-o", ""],
        ["check", ""],
        ["section", "general/asymmetric-regular", "--starts", ""],
    ],
)
def test_an_empty_name_is_told_as_one(capsys, words: list[str]) -> None:
    """It was the current folder, and "Is a directory"."""
    assert refusal(capsys, *words).endswith(" = : expected a name\n")


def test_an_empty_section_is_no_default(capsys) -> None:
    assert "by = : expected momentum, height" in refusal(
        capsys, *["section", "general/asymmetric-regular", "--by", "", "--grid", "2x2"]
    )
    with pytest.raises(BadInput, match="'': SCENE: expected a path"):
        polhode.load("")


# -- disks that fill -----------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    "words",
    [
        ["section", "general/asymmetric-regular", "--grid", "2x2", "--crossings", "2"],
        ["map", "lagrange/nutation", "--grid", "2x2", "--end", "20"],
    ],
)
def test_a_full_disk_leaves_no_folder_of_parts(words: list[str]) -> None:
    (Path("out")).mkdir()

    def full() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))

    ended = subprocess.run(
        [*COMMAND, *words, "-o", "x.npz"],
        cwd="out",
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        preexec_fn=full,
        text=True,
    )
    assert ended.returncode == 2, ended.stderr
    assert "File too large" in ended.stderr
    assert not [*Path("out").iterdir()]


def test_a_full_disk_leaves_all_files_of_a_study_or_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """The results stood alone, without page and figure."""
    made: list[set[str]] = []

    def fail(texts: dict[Path, str]) -> None:
        made.append({path.suffix for path in texts})
        raise BadInput("x", "file", None, "a place to write to (No space left on device)")

    committed = Path(__file__).parents[2] / "reports/events.json"
    monkeypatch.setattr(report, "_run", lambda *_: committed.read_text())
    monkeypatch.setattr(report, "figures", lambda _: {"events": "<?xml"})
    monkeypatch.setattr(report, "write_whole", fail)
    with pytest.raises(BadInput, match="No space left"):
        report.write_study("events", Path("out"), quick=True)
    assert made == [{".json", ".md", ".svg"}]


def test_a_first_piece_that_cannot_be_kept_leaves_no_folder(monkeypatch) -> None:
    write = checkpoint.write_whole

    def fail(texts: dict[Path, bytes]) -> None:
        if any(path.suffix == ".npz" for path in texts):
            raise BadInput("x", "file", None, "a place to write to (No space left on device)")
        write(texts)

    kept = JobCheckpoint(Path("x.parts"), "section", "key")
    with monkeypatch.context() as patch:
        patch.setattr(checkpoint, "write_whole", fail)
        with pytest.raises(BadInput, match="No space left"):
            kept.save(0, {"a": [1.0]})
        assert not Path("x.parts").exists()
    kept.save(0, {"a": [1.0]})
    with monkeypatch.context() as patch:
        patch.setattr(checkpoint, "write_whole", fail)
        with pytest.raises(BadInput, match="No space left"):
            kept.save(1, {"a": [2.0]})
    assert kept.load(0)["a"].tolist() == [1.0]  # what is finished stays
    assert kept.load(1) is None


# -- what results hold ---------------------------------------------------------------------------

TURNED = "evil \u202etitle"


def test_results_hold_no_folder_that_the_scene_was_read_from(capsys, tmp_path: Path) -> None:
    Path("top.toml").write_text(free_file("end = 2\nsamples = 3"))
    scene = str(tmp_path / "top.toml")
    assert cli.main(["run", scene, "-o", "x.csv"]) == 0
    assert cli.main(["plot", scene, "--what", "angles", "-o", "x.svg"]) == 0
    assert cli.main(["view", scene, "-o", "x.html"]) == 0
    for words in (
        ["run", scene],
        ["show", scene],
        ["reference", scene],
        ["compare", str(tmp_path / "x.csv"), scene],
        ["frequencies", scene, "--of", "p", "--lines", "1"],
    ):
        capsys.readouterr()
        assert cli.main([*words, "--json"]) == 0
        Path(f"{words[0]}.json").write_text(capsys.readouterr().out)
    written = [path for path in Path().iterdir() if path.suffix in (".json", ".svg", ".html")]
    assert len(written) == 8
    for path in written:
        assert str(tmp_path) not in path.read_text(), path.name
        assert "top.toml" in path.read_text(), path.name
    assert json.loads(Path("compare.json").read_text())["file"] == "x.csv"


def test_a_file_that_cannot_be_read_is_named_with_its_folder(capsys, tmp_path: Path) -> None:
    Path("top.toml").write_text("schema = 3")
    assert str(tmp_path / "top.toml") in refusal(capsys, "run", str(tmp_path / "top.toml"))


@pytest.mark.parametrize(
    "words",
    [
        ["run", "{top}", "--at", "x"],
        ["reference", "{top}", "--digits", "99999"],
        ["show", "{level}"],
        ["levels", "{free}"],
        ["orbit", "{top}", "--period", "-1"],
        ["map", "{top}", "--tol", "2"],
        ["frequencies", "{top}", "--of", "x"],
        ["sweep", "{top}", "--vary", "start.omega[3]=1:2:3", "--keep", "x", "-o", "x.npz"],
        ["sweep", "{top}", "--vary", "body.moments[1]=1,-1", "-o", "x.npz"],
        ["plot", "{top}", "--what", "omega", "--end", "0", "-o", "x.svg"],
        ["compare", "{table}", "{free}"],
    ],
    ids=" ".join,
)
def test_a_fault_names_a_file_as_it_was_given(capsys, tmp_path: Path, words: list[str]) -> None:
    """Its folder, too, which results leave out."""
    Path("free.toml").write_text(free_file("at = [0, 1]").replace("gamma", "#gamma"))
    Path("level.toml").write_text(free_file("at = [0, -1, 0]"))
    Path("table.csv").write_text("t,psi\n0,1\n")
    names = {"top": "top.toml", "free": "free.toml", "level": "level.toml", "table": "table.csv"}
    paths = {word: str(tmp_path / name) for word, name in names.items()}
    said = refusal(capsys, *(word.format_map(paths) for word in words))
    assert any(said.startswith(f"polhode: {path}") for path in paths.values()), said


def test_a_fault_of_a_library_call_names_the_path_wherever_the_scene_went(tmp_path: Path) -> None:
    scene = pickle.loads(pickle.dumps(polhode.load(str(tmp_path / "top.toml"))))
    assert scene.name == "top.toml"
    with pytest.raises(BadInput) as fault:
        polhode.integrate(scene, max_steps=0)
    assert fault.value.source == str(tmp_path / "top.toml")


def test_a_relative_path_stays_as_it_was_given() -> None:
    assert called(Path("tops/a.toml")) == "tops/a.toml"
    assert called(Path("/home/somebody/tops/a.toml")) == "a.toml"
    assert called(Path("/")) == "/"


def test_a_title_turns_no_line_around() -> None:
    text = free_file("at = [0, 1]").replace("schema = 1", f'schema = 1\ntitle = "{TURNED}"')
    assert TURNED in text
    Path(f"{TURNED}.toml").write_text(text)
    scene = polhode.load(f"{TURNED}.toml")
    assert scene.title == TURNED
    pages = [polhode.view(scene, end=1)._repr_html_(), scene._repr_html_()]
    assert cli.main(["plot", f"{TURNED}.toml", "--what", "angles", "-o", "x.svg"]) == 0
    for page in [*pages, Path("x.svg").read_text()]:
        assert "\u202e" not in page
        assert "evil ?title" in page


#: A name, and a title, that would command a terminal and begin a line of their own.
ODD = "a\x1b[31m\nz!"


def test_names_of_any_kind_are_one_line_that_commands_no_terminal(capsys) -> None:
    text = free_file("at = [0, 1]")
    word = json.dumps(ODD)
    words = f"title = {word}\ntags = [{word}]\ncite = [{word}]"
    Path(f"{ODD}.toml").write_text(text.replace("schema = 1", f"schema = 1\n{words}"))
    scene = polhode.load(f"{ODD}.toml")
    given = replace(scene, name=ODD)
    assert (scene.title, scene.name, given.name) == (ODD, "a?[31m z!.toml", "a?[31m z!")
    run = polhode.integrate(scene)
    run.save(f"{ODD}.csv")
    results = [scene, given, run, polhode.reference(scene), polhode.conditioning(scene)]
    results += [polhode.compare(run), polhode.view(scene), polhode.compare(f"{ODD}.csv", scene)]
    for found in results[:-1]:
        assert "a?[31m z!" in repr(found)
    for found in results:
        assert repr(found).isprintable()
    capsys.readouterr()
    for verb in (["show"], ["run"], ["reference"], ["new", "new.toml", "--like"]):
        assert cli.main([*verb, f"{ODD}.toml"]) == 0
        out, err = capsys.readouterr()
        assert not re.search("\x1b|\nz!", out + err)


def test_a_name_of_an_event_is_text_of_one_line(capsys) -> None:
    event = '\n[[events]]\nname = "a\\nb"\nzero = "p"\n'
    Path("event.toml").write_text(free_file("at = [0, 1]") + event)
    expected = "event.toml: events[1].name = a b: expected text of one line that can be printed"
    assert expected in refusal(capsys, "run", "event.toml")
    with pytest.raises(BadInput, match="of one line"):
        replace(polhode.load("top.toml"), events=(polhode.Event("\x1b[31m", "p"),))


def test_a_tab_and_a_line_end_are_no_commands() -> None:
    assert terminal.printable("a\nb") == "a\nb"
    assert terminal.printable("a\x1b[31m\u202eb") == "a?[31m?b"


def test_a_callers_handlers_of_signals_are_put_back(capsys):
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    assert cli.main(["about"]) == 0
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == before

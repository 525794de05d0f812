"""Programs of their own: streams that are full, closed or pipes, and what a terminal is shown."""

import io
import os
import re
import resource
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from polhode.common.interrupts import ProgressLine
from shared.motions import free_file
from shared.tools import python

TOP = free_file("at = [0, 1]")
PATH = f"{Path(sys.executable).parent}:{os.environ['PATH']}"


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("top.toml").write_text(TOP)


def ended(*words: str, stdout: object = subprocess.PIPE, **how: object) -> Any:
    """A command carried out by a process of its own; both its streams, unless said otherwise."""
    streams = {"capture_output": False, "stdout": stdout, "stderr": subprocess.PIPE}
    return python("-m", "polhode", *words, **streams | how)


def shell(line: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PATH": PATH}
    return subprocess.run(["bash", "-c", line], capture_output=True, text=True, env=environment)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
@pytest.mark.parametrize("words", ["list", "run --help", "--version"])
def test_what_gets_lost_on_a_full_disk_is_no_success(words):
    with Path("/dev/full").open("w") as full:
        process = ended(*words.split(), stdout=full)
    full = "polhode: cannot write to standard output: No space left on device\n"
    assert (process.returncode, process.stderr) == (2, full)


@pytest.mark.slow
def test_a_full_disk_is_one_line_and_leaves_nothing(monkeypatch):
    """As a limit on the size of files, which the system meets with the same kind of fault."""
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")  # cut off, it would stay for all that follow

    def full() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))

    before = {*Path().iterdir()}
    words = "reference euler/flat --at 1 -o x.csv"
    process = ended(*words.split(), preexec_fn=full)
    assert process.returncode == 2, process.stderr
    assert process.stderr.splitlines()[-1].startswith("polhode: x.")
    assert "File too large" in process.stderr
    assert "Traceback" not in process.stderr
    assert {*Path().iterdir()} == before


def test_a_reader_that_goes_away_is_no_error():
    reader, writer = os.pipe()
    os.close(reader)
    process = ended("reference", "euler/flat", "--at", "1", "--json", stdout=writer)
    os.close(writer)
    assert (process.returncode, process.stderr) == (0, "")


@pytest.mark.slow
def test_a_closed_stdout_is_a_place_that_cannot_be_written_to():
    process = shell("polhode reference euler/flat --at 1 >&-")
    assert process.returncode == 2
    expected = "polhode: cannot write to standard output: Bad file descriptor"
    assert process.stderr.splitlines()[-1] == expected
    assert shell("polhode reference euler/flat --at 1 -o x.csv >&- 2>&-").returncode == 0
    assert Path("x.csv").exists()


@pytest.mark.slow
def test_a_scene_and_a_table_may_come_through_pipes():
    line = "polhode run <(cat top.toml) -o - | polhode compare /dev/stdin <(cat top.toml)"
    process = shell(line)
    assert process.returncode == 0, process.stderr
    assert "correct digits" in process.stdout
    assert [*Path().iterdir()] == [Path("top.toml")]
    shown = shell("polhode reference top.toml --at 0,1 -o /dev/stdout").stdout
    assert len(shown.splitlines()) == 3


@pytest.mark.slow
def test_a_title_takes_any_character_and_commands_no_terminal():
    title = 'title = "Grüße \\u001b[31m\\u0007 τ"\n'
    Path("odd.toml").write_text(TOP.replace("[body]", title + "[body]"), encoding="utf-8")
    environment = {**os.environ, "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"}
    process = ended("show", "odd.toml", env=environment, text=False)
    assert process.returncode == 0, process.stderr
    assert b"\x1b" not in process.stdout
    assert b"\x07" not in process.stdout
    assert b"Gr\\xfc\\xdfe ?[31m?" in process.stdout


@pytest.mark.slow
def test_a_backend_that_matplotlib_has_not_is_refused():
    """It reads the variable while it is imported."""
    words = ["plot", "lagrange/nutation", "--what", "angles", "-o", "x.svg"]
    process = ended(*words, env={**os.environ, "MPLBACKEND": "nonsense"})
    expected = "a backend that matplotlib has, such as agg, or none"
    said = f"polhode: environment: MPLBACKEND = nonsense: expected {expected}\n"
    assert (process.returncode, process.stderr) == (2, said)


# -- where heyoka is not installed -----------------------------------------------------------------

HIDDEN = "import sys; sys.modules['heyoka'] = None; "
WITHOUT = [
    *("list", "about", "show lagrange/nutation", "levels lagrange/nutation", "guide scene"),
    *("new x.toml", "reference lagrange/first-axis --at 0,1,2 --digits 20 -o table.csv"),
    "compare table.csv lagrange/first-axis --as-it-stands",
    "plot table.csv --what omega -o x.png",
    "view table.csv --scene lagrange/first-axis -o x.html",
]


@pytest.mark.slow
def test_without_heyoka_all_works_but_what_integrates_says_how_to_get_it():
    """Also every public name, whose examples others run."""
    commands = [words.split() for words in WITHOUT]
    program = f"{HIDDEN}import polhode\nfrom polhode.cli import main\n"
    program += f"for words in {commands!r}: assert main(words) == 0, words\n"
    program += "for name in polhode.__all__: getattr(polhode, name)\n"
    program += "try: polhode.integrate('lagrange/nutation')\n"
    program += "except ImportError as fault: print(fault, file=sys.stderr)\n"
    program += "assert main(['section', 'general/asymmetric-regular']) == 2\n"
    program += "assert main(['reference', 'lagrange/nutation', '--at', '1']) == 2  # its angles\n"
    process = python("-c", program)
    assert process.returncode == 0, process.stderr
    assert "not judged: what limits the digits was not computed: heyoka is not in" in process.stdout
    digits = re.search(r"(\S+) correct digits at worst", process.stdout)
    assert 20 < float(digits[1]) < 27  # some guards
    in_python, *of_verbs = process.stderr.splitlines()[-3:]
    assert in_python.startswith("heyoka: expected to be installed")
    assert of_verbs == 2 * [f"polhode: {in_python}"]
    assert min(Path(name).stat().st_size for name in ("x.png", "x.html")) > 1000


def test_a_run_where_heyoka_is_missing_is_refused():
    program = f"{HIDDEN}from polhode.cli import command; command()"
    process = python("-c", program, "run", "lagrange/nutation")
    assert (process.returncode, process.stdout, process.stderr.count("\n")) == (2, "", 1)
    assert process.stderr.startswith("polhode: heyoka: expected to be installed")


# -- The line of progress on a terminal as narrow as it may be -------------------------------------


class Terminal(io.StringIO):
    """A terminal in place of stderr."""

    def isatty(self) -> bool:
        return True

    def fileno(self) -> int:
        return 2


@pytest.mark.parametrize("columns", [40, 80, 0])
def test_the_line_never_wraps(monkeypatch, columns):
    """What wraps is not wiped: only the last of its lines would be."""
    monkeypatch.setattr(os, "get_terminal_size", lambda _: os.terminal_size((columns, 24)))
    monkeypatch.setattr(sys, "stderr", Terminal())
    with ProgressLine("compare") as progress:
        progress.began -= 10
        progress.say("rows of the reference")
        progress.show(0.125, 10800, "rows of the closed form")
        progress.say("x" * 300)
    *lines, rest = sys.stderr.getvalue().split("\r\x1b[K")[1:]
    assert rest == ""
    assert [len(line) < (columns or 80) for line in lines] == [True] * 3
    assert lines[1].startswith("compare: 12.5 %, 10800 rows")
    assert len(lines[2]) == (columns or 80) - 1


def test_nothing_is_shown_of_what_takes_no_time(monkeypatch):
    monkeypatch.setattr(sys, "stderr", Terminal())
    with ProgressLine("compare") as progress:
        progress.began += 3600
        progress.say("quick")
    assert sys.stderr.getvalue() == ""

"""What a hostile user may do with files, streams, times and titles."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from polhode import cli
from polhode.common import files
from shared.motions import free_file

TOP = free_file("at = [0, 1]")
COMMAND = [sys.executable, "-m", "polhode"]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("top.toml").write_text(TOP)


def ran(capsys, *arguments: str) -> tuple[int, str, str]:
    code = cli.main([*arguments])
    out, err = capsys.readouterr()
    return code, out, err


def refused(capsys, *arguments: str) -> str:
    before = {p: p.read_bytes() for p in Path().iterdir() if p.is_file()}
    code, out, err = ran(capsys, *arguments)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert {p: p.read_bytes() for p in Path().iterdir() if p.is_file()} == before
    return err


# -- files that are written ----------------------------------------------------------------------


@pytest.mark.parametrize(
    "arguments",
    [
        ["run", "scene.json", "-o", "scene.csv"],
        ["run", "scene.toml", "-o", "link.csv"],
        ["sweep", "scene.json", "--vary", "start.omega[1]=1,2", "-o", "scene.csv"],
    ],
)
def test_no_input_is_ever_replaced(capsys, arguments):
    Path("scene.toml").write_text(TOP)
    Path("scene.json").write_text(TOP)
    Path("link.csv").symlink_to("scene.toml")
    assert "another file than the one that is read" in refused(capsys, *arguments)


def test_a_plot_never_replaces_its_table(capsys):
    assert ran(capsys, "run", "top.toml", "-o", "x.csv")[0] == 0
    Path("x.svg").symlink_to("x.csv")
    arguments = ["plot", "x.csv", "--what", "error", "--scene", "top.toml", "-o", "x.svg"]
    assert "another file than the one that is read" in refused(capsys, *arguments)


@pytest.mark.parametrize("name", ["x.txt", "x", "x.json", "x.toml", "x.csv.gz"])
def test_a_name_that_says_another_kind_is_refused(capsys, name):
    assert "expected a name that ends in .csv" in refused(capsys, "run", "top.toml", "-o", name)


def test_links_are_followed_and_stay_links(capsys):
    Path("deep").mkdir()
    Path("x.csv").symlink_to("deep/y.csv")
    assert ran(capsys, "run", "top.toml", "-o", "x.csv")[0] == 0
    assert Path("x.csv").is_symlink()
    assert Path("deep/y.csv").read_text().startswith("t,p,q,r")
    assert json.loads(Path("x.json").read_text())["number"] == "double"


def test_a_file_keeps_its_permissions(capsys):
    Path("x.csv").touch()
    os.chmod("x.csv", 0o640)
    assert ran(capsys, "run", "top.toml", "-o", "x.csv")[0] == 0
    assert os.stat("x.csv").st_mode & 0o777 == 0o640


@pytest.mark.parametrize("name", ["-", "/dev/stdout"])
def test_standard_output_is_a_place_to_write_to(name):
    done = subprocess.run(
        [*COMMAND, "run", "top.toml", "-o", name], capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[0] == "t,p,q,r,gamma1,gamma2,gamma3"
    assert len(done.stdout.splitlines()) == 3
    assert sorted(p.name for p in Path().iterdir()) == ["top.toml"]


def test_standard_output_holds_one_thing_only(capsys):
    assert "the results as JSON go to stdout" in refused(
        capsys, "run", "top.toml", "-o", "-", "--json"
    )


def test_a_device_stays_a_device(capsys):
    assert ran(capsys, "run", "top.toml", "-o", os.devnull)[0] == 0
    assert not Path(os.devnull).is_file()


def test_a_fifo_is_written_to_and_stays_one(capsys):
    os.mkfifo("pipe.csv")
    held: list[str] = []
    reader = threading.Thread(target=lambda: held.append(Path("pipe.csv").read_text()))
    reader.start()
    assert ran(capsys, "run", "top.toml", "-o", "pipe.csv")[0] == 0
    reader.join(10)
    assert held[0].startswith("t,p,q,r")
    assert Path("pipe.csv").is_fifo()


# -- files that are read -------------------------------------------------------------------------


@pytest.mark.parametrize("arguments", [["show", "pipe"], ["compare", "pipe", "top.toml"]])
def test_a_pipe_that_nobody_writes_to_is_refused(capsys, monkeypatch, arguments):
    monkeypatch.setattr(files, "PATIENCE", 0.2)
    os.mkfifo("pipe")
    assert "nothing came for 0.2 seconds" in refused(capsys, *arguments)


def test_a_pipe_that_stays_silent_is_refused(capsys, monkeypatch):
    monkeypatch.setattr(files, "PATIENCE", 0.2)
    os.mkfifo("pipe")
    handle = os.open("pipe", os.O_RDWR)
    try:
        assert "nothing came for 0.2 seconds" in refused(capsys, "show", "pipe")
    finally:
        os.close(handle)


@pytest.mark.slow
def test_a_scene_and_a_table_may_come_through_pipes():
    shell = "polhode run <(cat top.toml) -o - | polhode compare /dev/stdin <(cat top.toml)"
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    done = subprocess.run(
        ["bash", "-c", shell], capture_output=True, text=True, env={**os.environ, "PATH": path}
    )
    assert done.returncode == 0, done.stderr
    assert "correct digits" in done.stdout


def test_a_file_without_end_is_refused(capsys):
    assert "at most 100000 bytes" in refused(capsys, "show", "/dev/zero")


# -- streams -------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_closed_stdout_is_a_place_that_cannot_be_written_to():
    shell = f"{sys.executable} -m polhode run top.toml >&-"
    done = subprocess.run(["bash", "-c", shell], capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1] == (
        "polhode: stdout: expected a place to write to (Bad file descriptor)"
    )
    shell = f"{sys.executable} -m polhode run top.toml -o x.csv >&- 2>&-"
    assert subprocess.run(["bash", "-c", shell]).returncode == 0
    assert Path("x.csv").exists()


@pytest.mark.slow
def test_a_full_disk_is_said_of_the_stream_that_is_full():
    with open("/dev/full", "w") as full:
        done = subprocess.run([*COMMAND, "list"], stdout=full, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 2
    assert (
        done.stderr == "polhode: stdout: expected a place to write to (No space left on device)\n"
    )


def test_a_fault_of_the_system_is_not_blamed_on_stdout(capsys, monkeypatch):
    from polhode.scenes import library

    def fail(_):
        raise OSError(24, "Too many open files", "cases")

    monkeypatch.setattr(library, "load", fail)
    code, out, err = ran(capsys, "show", "top.toml")
    assert (code, out) == (2, "")
    assert err == "polhode: cases: expected to be usable (Too many open files)\n"


@pytest.mark.slow
def test_a_title_takes_any_character_and_commands_no_terminal():
    title = 'title = "Grüße \\u001b[31m\\u0007 τ"\n'
    Path("odd.toml").write_text(TOP.replace("[body]", title + "[body]"), encoding="utf-8")
    for encoding in ("ascii", "utf-8"):
        done = subprocess.run(
            [*COMMAND, "show", "odd.toml"],
            capture_output=True,
            env={**os.environ, "PYTHONIOENCODING": encoding, "PYTHONUTF8": "0"},
        )
        assert done.returncode == 0, done.stderr
        assert b"\x1b" not in done.stdout
        assert b"\x07" not in done.stdout
        assert "Grüße ?[31m? τ" in done.stdout.decode() or b"Gr\\xfc\\xdfe ?[31m?" in done.stdout


# -- numbers beyond a double ---------------------------------------------------------------------


@pytest.mark.parametrize("t", ["1e400", "1e-400"])
def test_times_beyond_the_range_of_a_double(capsys, t):
    code, _, err = ran(capsys, "run", "top.toml", "--number", "mp", "--at", t)
    assert code == (3 if t == "1e400" else 0), err
    assert "Traceback" not in err
    Path("x.csv").write_text(f"t,p\n{t},0.3\n")
    code, _, err = ran(capsys, "compare", "x.csv", "top.toml")
    assert code == (2 if t == "1e400" else 0), err
    code, _, err = ran(capsys, "plot", "top.toml", "--what", "angles", "-o", "x.svg", "--end", t)
    assert code in (2, 3), err
    assert err.count("\n") == 1


def test_a_fraction_of_thousands_of_digits_is_shown(capsys):
    Path("sum.toml").write_text(TOP.replace("[0.3", '["(1/3)**2500"'))
    code, out, err = ran(capsys, "show", "sum.toml")
    assert code == 0, err
    assert "integrals" in out


# -- poles and ends that are not reached ---------------------------------------------------------


def test_angles_at_a_pole_are_null(capsys):
    code, out, err = ran(
        capsys, "run", "lagrange/sleeping-stable", "--at", "1", "--outputs", "angles", "--json"
    )
    assert code == 0, err
    psi, theta, phi = json.loads(out)["angles"][0]
    assert (psi, phi) == (None, None)
    assert float(theta) == 0


@pytest.mark.sample(1, first=1)
@pytest.mark.parametrize("outputs", ["hodographs", "angles", "attitude", "angles,attitude"])
def test_a_run_that_gets_nowhere_says_so(capsys, outputs):
    arguments = ["run", "euler/largest-axis", "--at", "1e6", "--max-steps", "3"]
    for more in ([], ["--json"]):
        code, _, err = ran(capsys, *arguments, "--outputs", outputs, *more)
        assert code == 3
        assert "raise the limit" in err


@pytest.mark.parametrize(
    "arguments",
    [
        ["orbit", "general/asymmetric-regular", "--h", "1e400"],
        ["orbit", "general/asymmetric-regular", "--h", "-1e400"],
        ["prove", "orbit", "general/asymmetric-regular", "--h", "1e400"],
        ["frequencies", "general/asymmetric-regular", "--end", "1e308"],
        ["frequencies", "general/asymmetric-regular", "--end", "-1e400"],
        ["guide", "1" * 5000],
    ],
)
def test_what_doubles_and_file_names_have_no_room_for_is_refused_in_one_line(capsys, arguments):
    assert refused(capsys, *arguments).startswith("polhode: g")  # of the scene, or the guide


@pytest.mark.slow
def test_a_sweep_over_numbers_beyond_doubles_is_written(capsys):
    sweep = ["sweep", "lagrange/nutation", "--at", "1", "--vary", "body.weight=1e400,2e400"]
    code, _, err = ran(capsys, *sweep, "-o", "out.csv")
    assert code == 3
    assert "raise the limit (--max-steps)" in err
    members = json.loads(Path("out.json").read_text())["members"]
    assert [member["outcome"] for member in members] == ["step limit", "step limit"]

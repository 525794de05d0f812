"""Every command obeys SIGINT and SIGTERM within seconds.

Many signals, and commands that are killed and given again: ``tests/campaigns/signals_met.py``.
"""

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import polhode
from fuzz import signals
from polhode import BadInput, cli
from polhode.runs import integrate_many
from shared.tools import python

linux = pytest.mark.skipif(sys.platform != "linux", reason="processor time is read from /proc")


@pytest.mark.slow
@linux
@pytest.mark.parametrize("work", ["run", "report"])
def test_a_signal_is_obeyed(work):
    _, faults = signals.met_at_random(work, 1, 1, longest=3)
    assert not faults


def test_every_verb_is_met(capsys):
    with pytest.raises(SystemExit):
        cli.main(["--help"])
    verbs = {*re.findall(r"^    ([a-z]+)\b", capsys.readouterr().out, re.MULTILINE)}
    assert {x.split()[0] for x in signals.WORKS.values()} == verbs - {"about", "new", "verify"}


# -- faults that were found ------------------------------------------------------------------------


def interrupt(by: int = signal.SIGINT) -> None:
    os.kill(os.getpid(), by)


def fault_of_numpy() -> None:
    """While it is loaded: "Importing the numpy C-extensions failed", and a traceback."""
    try:
        interrupt()
    except KeyboardInterrupt:
        raise ImportError("no datetime") from None


def fault_of_c() -> None:
    try:
        interrupt()
    except KeyboardInterrupt:
        raise SystemError("error return") from None


def fault_of_matplotlib() -> None:
    """A library that is said to lack, as it was being loaded."""
    try:
        try:
            interrupt(signal.SIGTERM)
        except KeyboardInterrupt:
            raise ImportError("partly initialized") from None
    except ImportError:
        raise BadInput("polhode", "plot", None, "matplotlib") from None


@pytest.mark.parametrize("work", [fault_of_numpy, fault_of_c, fault_of_matplotlib])
def test_a_library_that_makes_another_exception_of_a_signal(monkeypatch, capsys, work):
    monkeypatch.setattr(json, "dumps", lambda *_, **__: work())
    assert cli.main(["about", "--json"]) == 130
    assert capsys.readouterr().err == "polhode: interrupted\n"


def test_other_faults_stay_what_they_are(monkeypatch):
    def fail(*_, **__):
        raise SystemError("an error of its own")

    monkeypatch.setattr(json, "dumps", fail)
    with pytest.raises(SystemError, match="an error of its own"):
        cli.main(["about", "--json"])


def test_a_signal_after_all_is_said_is_not_heard():
    """It made a traceback while Python was taken down."""
    program = (
        "import atexit, os, signal, sys; from polhode import cli; "
        "atexit.register(lambda: os.kill(os.getpid(), signal.SIGINT)); "
        "sys.argv[1:] = []; cli.command()"
    )
    ended = python("-c", program)
    assert (ended.returncode, ended.stderr) == (0, "")


#: ``polhode``, to which a signal comes when a module is looked for.
LOADED = """
import os, sys
module, by = sys.argv[1:]
class Met:
    def find_spec(name, path=None, target=None):
        if name == module:
            os.kill(os.getpid(), int(by))
sys.meta_path.insert(0, Met)
from polhode.__main__ import command
sys.argv[1:] = ["list"]
command()
"""


@pytest.mark.parametrize(
    ("module", "by"),
    [
        ("argparse", signal.SIGTERM),
        ("polhode.verbs.terminal", signal.SIGINT),
        ("polhode.output.cases", signal.SIGTERM),
    ],
)
def test_a_signal_while_polhode_is_loaded_is_obeyed(module, by):
    """Its code was -2, and a traceback was printed."""
    ended = python("-c", LOADED, module, str(int(by)))
    assert (ended.returncode, ended.stderr) == (130, "polhode: interrupted\n")


def test_ctrl_c_waits_until_files_are_whole(monkeypatch, tmp_path):
    replaced = os.replace

    def interrupted(*names):
        if str(names[1]).endswith("a.csv"):
            interrupt()
        replaced(*names)

    monkeypatch.setattr(os, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        polhode.integrate("euler/sphere", at=[0]).save(tmp_path / "a.csv")
    assert {path.name for path in tmp_path.iterdir()} == {"a.csv", "a.csv.json"}


def test_ctrl_c_while_a_sweep_is_read_out_loses_nothing(monkeypatch):
    put_together = integrate_many.put_together

    def interrupted(*arguments):
        interrupt()
        return put_together(*arguments)

    monkeypatch.setattr(integrate_many, "put_together", interrupted)
    many = polhode.integrate_many("euler/sphere", {"start.omega[1]": [1, "1.1"]}, at=[0])
    assert many.complete


@linux
def test_a_worker_ends_with_what_started_it():
    worker = "from peers.process import end_with_parent as e; e(); import time; "
    worker += "print(1, flush=True); time.sleep(60)"
    parent = f"import subprocess, sys; p = subprocess.Popen([sys.executable, '-c', {worker!r}], "
    parent += "stdout=subprocess.PIPE); p.stdout.readline(); print(p.pid, flush=True); p.wait()"
    started = subprocess.Popen([sys.executable, "-c", parent], stdout=subprocess.PIPE)
    status = Path(f"/proc/{int(started.stdout.readline())}/status")
    started.kill()
    started.wait()
    started.stdout.close()
    until = time.monotonic() + 10
    while status.exists() and "\nState:\tZ" not in status.read_text():
        assert time.monotonic() < until, "the worker lived on"
        time.sleep(0.1)

"""Every command obeys SIGINT and SIGTERM within seconds, from any point."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import pytest

from fuzz import interrupts
from polhode import cli
from polhode.common.errors import BadInput
from polhode.common.interrupts import heard
from polhode.verbs import guide

WORKS = [*interrupts.WORKS]


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="processor time is read from /proc")
@pytest.mark.parametrize("work", ["run", "sweep", "section", "map", "levels", "study"])
def test_a_signal_is_obeyed(work):
    _, faults = interrupts.sampled(work, 1, 1)
    assert not faults


@pytest.mark.parametrize("name", ["x.svg", "x.png", "x.gif", "x.html", "x.npz"])
def test_half_a_file_may_not_stay(tmp_path, name):
    path = tmp_path / name
    what = {".html": "view {}", ".npz": "levels {}", ".gif": "plot {} --what motion --end 1"}
    command = what.get(path.suffix, "plot {} --what angles").format("lagrange/looping")
    assert cli.main([*command.split(), "-o", str(path)]) == 0
    assert interrupts.whole(path)
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    assert not interrupts.whole(path)


@pytest.mark.campaign
@pytest.mark.skipif(sys.platform != "linux", reason="processor time is read from /proc")
@pytest.mark.parametrize("work", WORKS)
def test_signals_at_many_moments_are_obeyed(work):
    counts, faults = interrupts.sampled(work, 50, 2)
    assert not faults
    if work not in ("show", "list", "guide"):
        assert counts["130"] > 5  # the work was under way


def test_every_verb_is_met():
    words = {command.split()[0] for command in interrupts.WORKS.values()}
    short = {"about", "new", "verify"}
    assert words == {*cli.VERBS} - short - {"report"}  # a study after the other


@pytest.mark.parametrize("fault", [ImportError("no datetime"), SystemError("error return")])
def test_a_library_that_makes_another_exception_of_a_signal(monkeypatch, capsys, fault):
    """numpy, while it is loaded: "Importing the numpy C-extensions failed", and a traceback."""

    def met(_):
        try:
            os.kill(os.getpid(), signal.SIGINT)
        except KeyboardInterrupt:
            raise fault from None

    monkeypatch.setattr(guide, "main", met)
    assert cli.main(["guide"]) == 130
    assert capsys.readouterr().err == "polhode: interrupted\n"


def test_a_library_that_is_said_to_lack_for_a_signal(monkeypatch, capsys):
    def met(_):
        try:
            try:
                os.kill(os.getpid(), signal.SIGTERM)
            except KeyboardInterrupt:
                raise ImportError("partly initialized") from None
        except ImportError:
            raise BadInput("polhode", "plot", None, "matplotlib") from None

    monkeypatch.setattr(guide, "main", met)
    before = signal.signal(signal.SIGTERM, heard)
    try:
        assert cli.main(["guide"]) == 130
    finally:
        signal.signal(signal.SIGTERM, before)
    assert capsys.readouterr().err == "polhode: interrupted\n"


def test_other_faults_stay_what_they_are(monkeypatch):
    def met(_):
        raise SystemError("an error of its own")

    monkeypatch.setattr(guide, "main", met)
    with pytest.raises(SystemError, match="an error of its own"):
        cli.main(["guide"])


def test_a_signal_after_all_is_said_is_not_heard():
    """It made a traceback while Python was taken down."""
    program = (
        "import atexit, os, signal, sys; from polhode import cli; "
        "atexit.register(lambda: os.kill(os.getpid(), signal.SIGINT)); "
        "sys.argv[1:] = []; cli.command()"
    )
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
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


@pytest.mark.parametrize("by", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("module", ["argparse", "polhode.verbs.terminal", "polhode.verbs.list"])
def test_a_signal_while_polhode_is_loaded_is_obeyed(module, by):
    """Its code was -2, and a traceback was printed."""
    program = [sys.executable, "-c", LOADED, module, str(int(by))]
    ended = subprocess.run(program, capture_output=True, text=True)
    assert (ended.returncode, ended.stderr) == (130, "polhode: interrupted\n")

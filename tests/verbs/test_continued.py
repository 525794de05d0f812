"""What Ctrl-C ended goes on from its kept parts: the same command, the same bytes in the end."""

from __future__ import annotations

import json
import shlex
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from polhode.common.checkpoint import MANIFEST, Checkpoint

#: Commands, and of a piece's arrays one whose numbers stand in the result, by which column.
COMMANDS = {
    "map general/asymmetric-chaotic --grid 48x48 --end 400 --h 3 --f 1/2 --workers 1": "fli",
    "section general/asymmetric-chaotic --grid 16x16 --crossings 60 --workers 1 --no-accuracy": "l",
    "sweep general/asymmetric-regular --vary start.omega[3]=1:2:3000 --end 400 --samples 9": "p",
}


def started(command: str, folder: Path) -> subprocess.Popen[str]:
    words = [sys.executable, "-m", "polhode", *shlex.split(command), "-o", "x.npz"]
    return subprocess.Popen(words, cwd=folder, stderr=subprocess.PIPE, text=True)


def ended(command: str, folder: Path) -> tuple[int, str]:
    with started(command, folder) as process:
        said = process.communicate(timeout=300)[1]
    return process.returncode, said


def changed(parts: Path) -> None:
    """Every number of one piece is another, and its sum is right: whoever takes it shows it."""
    manifest = json.loads((parts / MANIFEST).read_text())
    del manifest["versions"]
    with Checkpoint(parts, manifest, ("jobs", "command")) as checkpoint:
        place = checkpoint.pieces()[0]
        arrays = checkpoint.read(place)
        assert arrays is not None
        moved = {k: x * 1.5 if x.dtype.kind == "f" else x for k, x in arrays.items()}
        checkpoint.write(place.name, moved)


@pytest.mark.slow
@pytest.mark.parametrize(
    "command",
    ["section general/asymmetric-chaotic --grid 16x16 --crossings 60 --workers 1 --no-accuracy"],
)
def test_a_command_that_was_interrupted_goes_on(command: str, tmp_path: Path) -> None:
    stopped, whole = tmp_path / "stopped", tmp_path / "whole"
    stopped.mkdir()
    whole.mkdir()
    parts = stopped / "x.npz.parts"
    with started(command, stopped) as process:
        while process.poll() is None and not [*parts.glob("*-*.npz")]:
            time.sleep(0.01)
        assert process.poll() is None  # it is not done yet
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=60)[1]
    assert process.returncode == 130
    assert said.endswith("polhode: the same command continues from x.npz.parts\n")
    assert not (stopped / "x.npz").exists()
    shutil.copytree(stopped, tmp_path / "other")
    assert ended(command, stopped)[0] == 0
    assert not parts.exists()
    assert ended(command, whole)[0] == 0
    assert (stopped / "x.npz").read_bytes() == (whole / "x.npz").read_bytes()
    changed(tmp_path / "other" / "x.npz.parts")
    assert ended(command, tmp_path / "other")[0] == 0
    with (
        np.load(tmp_path / "other" / "x.npz") as continued,
        np.load(whole / "x.npz") as uninterrupted,
    ):
        differs = continued[COMMANDS[command]] != uninterrupted[COMMANDS[command]]
    assert 0 < differs.sum() < len(differs)

"""A sweep that was interrupted or killed goes on from what it had done, to the bit."""

from __future__ import annotations

import itertools
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import polhode
from polhode.common import checkpoint
from polhode.common.value_semantics import same
from polhode.motion.outcomes import Outcome
from polhode.runs.sweep import sweep_checkpoint
from polhode.taylor.batches import batch_integrator
from polhode.taylor.batches import jobs as batch_jobs

VARY = {"start.omega[3]": "1:4:12", "body.weight": ["1", "sqrt(2)"]}


@pytest.fixture(autouse=True)
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sweep_checkpoint, "EVERY", 0.0)


def swept(folder: Path | None, number: str = "double", **other: Any) -> polhode.Ensemble:
    return polhode.integrate_many(
        "lagrange/nutation",
        VARY,
        at=["0", "0.3", 1],
        number=number,
        workers=1,
        parts=folder,
        **other,
    )


def interrupted_sweep(folder: Path, jobs: int, number: str = "double") -> polhode.Ensemble:
    """A sweep that Ctrl-C ends once so many jobs are done."""
    begun, done, solve = itertools.count(1), itertools.count(1), batch_integrator.solve

    def hanging(job: Any, stop: Any) -> Any:
        if next(begun) <= jobs:
            return solve(job, stop)
        while not stop():
            time.sleep(0.001)
        return batch_jobs.Solved.none_of(job)

    def progress(*_: Any) -> None:
        if next(done) == jobs:
            raise KeyboardInterrupt

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(batch_integrator, "solve", hanging)
        return swept(folder, number, progress=progress)


def alike(one: polhode.Ensemble, other: polhode.Ensemble) -> bool:
    return one == other and same(one.states, other.states)


@pytest.mark.parametrize("number", ["double", "extended", "quad", "mp"])
def test_an_interrupted_sweep_goes_on_and_ends_as_an_undisturbed_one(number, tmp_path, monkeypatch):
    folder = tmp_path / "parts"
    whole = swept(None, number)
    first = interrupted_sweep(folder, 2, number)
    assert first.interrupted
    missing = first.outcomes.count(Outcome.NOT_RUN)
    assert 0 < missing < len(whole)
    done = [path.name for path in sorted(folder.iterdir())]
    assert done[0] == "manifest.json"
    assert done[1] == "part-00000.npz"
    solved: list[int] = []
    solve = batch_integrator.solve

    def counted(job: Any, stop: Any = None) -> Any:
        solved.append(job.lanes.many)
        return solve(job, stop)

    monkeypatch.setattr(batch_integrator, "solve", counted)
    again = swept(folder, number)
    assert sum(solved) == missing
    assert alike(again, whole)
    again.parts.remove()
    assert not folder.exists()


def test_what_a_resumed_sweep_adds_is_kept_though_it_was_quick(tmp_path, monkeypatch):
    """It ends before a part is due: what it did goes into a last one, beside those there."""
    folder = tmp_path / "parts"
    assert interrupted_sweep(folder, 2).interrupted
    monkeypatch.setattr(sweep_checkpoint, "EVERY", 1e9)
    whole = swept(folder)
    monkeypatch.setattr(batch_integrator, "solve", None)  # nothing is left to do
    assert alike(swept(folder), whole)


def test_several_interruptions_are_one_sweep(tmp_path):
    whole, folder = swept(None), tmp_path / "parts"
    for _ in range(2):
        assert interrupted_sweep(folder, 1).interrupted
    assert alike(swept(folder), whole)


def test_the_parts_of_another_sweep_are_refused_and_stay(tmp_path):
    folder = tmp_path / "parts"
    interrupted_sweep(folder, 1)
    held = {path.name: path.read_bytes() for path in folder.iterdir()}
    with pytest.raises(polhode.BadInput, match=r"parts: expected the parts of the same sweep"):
        polhode.integrate_many("lagrange/nutation", VARY, at=["0", "0.3", 2], parts=folder)
    with pytest.raises(polhode.BadInput, match=r"remove the folder to start again"):
        swept(folder, tol="1e-10")
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == held


def test_a_folder_of_other_things_is_refused(tmp_path):
    (tmp_path / "mine.txt").write_text("x")
    with pytest.raises(polhode.BadInput, match="parts of the same sweep"):
        swept(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


@pytest.mark.parametrize("damage", [b"", b"PK\x03\x04", b"nonsense" * 100])
def test_a_damaged_part_is_made_again(damage, tmp_path):
    whole, folder = swept(None), tmp_path / "parts"
    interrupted_sweep(folder, 3)
    (folder / "part-00000.npz").write_bytes(damage)
    assert alike(swept(folder), whole)


def changed(path: Path, **arrays: Any) -> None:
    with np.load(path) as file:
        held = {name: file[name] for name in file.files}
    np.savez(path, **held | arrays)


@pytest.mark.parametrize(
    "arrays",
    [
        {"members": np.array([[0]])},
        {"members": np.array([10**6])},
        {"states": np.zeros((1, 3, 6))},
        {"states": np.zeros(3)},
        {"outcomes": np.array(["arrived"])},
        {"reached": np.array(["1/0"])},
        {"errors": np.array(["[" * 100_000])},
        {"steps": np.array([1.5])},
        {"checksum": np.array("0")},
    ],
    ids=lambda arrays: "-".join(arrays),
)
def test_a_part_that_somebody_changed_is_made_again(arrays, tmp_path):
    """It gave tracebacks, or its numbers went into the result."""
    folder = tmp_path / "x.parts"
    interrupted_sweep(folder, 2)
    first, *_ = sorted(folder.glob("part-*"))
    changed(first, **arrays)
    assert same(swept(folder).states, swept(None).states)


def test_a_part_under_another_name_is_made_again(tmp_path):
    folder = tmp_path / "x.parts"
    interrupted_sweep(folder, 2)
    first, second, *_ = sorted(folder.glob("part-*"))
    second.write_bytes(first.read_bytes())
    assert same(swept(folder).states, swept(None).states)


def test_a_manifest_of_brackets_is_refused(tmp_path):
    interrupted_sweep(tmp_path / "x.parts", 1)
    (tmp_path / "x.parts/manifest.json").write_text("[" * 100_000)
    with pytest.raises(polhode.BadInput, match="remove the folder to start again"):
        swept(tmp_path / "x.parts")


def test_a_part_cut_short_is_made_again(tmp_path):
    whole, folder = swept(None), tmp_path / "parts"
    interrupted_sweep(folder, 3)
    part = folder / "part-00000.npz"
    part.write_bytes(part.read_bytes()[:-300])
    assert alike(swept(folder), whole)


@pytest.mark.skipif(sys.platform == "win32", reason="a system without such locks")
def test_two_sweeps_do_not_share_a_folder(tmp_path):
    folder = tmp_path / "parts"
    interrupted_sweep(folder, 1)
    tried: list[str] = []

    def progress(*_: Any) -> None:
        if not tried:
            with pytest.raises(polhode.BadInput) as refusal:
                swept(folder)
            tried.append(str(refusal.value))

    assert swept(folder, progress=progress).done
    assert "no other sweep running in this folder" in tried[0]


def test_a_disk_that_fills_ends_the_sweep_and_keeps_what_was_written(tmp_path, monkeypatch):
    folder, whole, write = tmp_path / "parts", swept(None), checkpoint.write_whole

    def full(texts: Any) -> None:
        if any(path.name == "part-00001.npz" for path in texts):
            raise polhode.BadInput("part", "file", None, "a place to write to (No space left)")
        write(texts)

    monkeypatch.setattr(checkpoint, "write_whole", full)
    with pytest.raises(polhode.BadInput, match="No space left"):
        swept(folder)
    assert [path.name for path in sorted(folder.iterdir())] == ["manifest.json", "part-00000.npz"]
    monkeypatch.setattr(checkpoint, "write_whole", write)
    assert alike(swept(folder), whole)


ARGUMENTS = ["sweep", "lagrange/nutation", "--vary", "start.omega[3]=1:4:400", "--at", "0,100"]
ARGUMENTS += ["--workers", "1", "-o", "x.npz"]
EAGER = (
    "from polhode import cli; from polhode.runs.sweep import sweep_checkpoint; "
    "sweep_checkpoint.EVERY = 0.0; "
)
COMMAND = [sys.executable, "-c", f"{EAGER}raise SystemExit(cli.main({ARGUMENTS}))"]


def arrays(path: Path) -> dict[str, Any]:
    with np.load(path) as held:
        return {name: held[name].tolist() for name in held.files if name != "about"}


@pytest.mark.slow
def test_a_killed_command_goes_on(tmp_path):
    cold, killed = tmp_path / "cold", tmp_path / "killed"
    cold.mkdir()
    killed.mkdir()
    subprocess.run(COMMAND, cwd=cold, check=True, capture_output=True)
    with subprocess.Popen(COMMAND, cwd=killed, stderr=subprocess.DEVNULL) as sweep:
        folder = killed / "x.npz.parts"
        while not list(folder.glob("part-*.npz")) and sweep.poll() is None:
            time.sleep(0.02)
        sweep.kill()
    assert not (killed / "x.npz").exists()
    kept = len(list(folder.glob("part-*.npz")))
    assert kept
    subprocess.run(COMMAND, cwd=killed, check=True, capture_output=True)
    assert arrays(killed / "x.npz") == arrays(cold / "x.npz")
    assert [path.name for path in killed.iterdir()] == ["x.npz"]

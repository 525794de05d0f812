"""How sweeps end: members that fail, Ctrl-C, executors that fail, and what goes on afterwards."""

import errno
import json
import os
import shutil
import signal
import sys
import warnings
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import polhode
from polhode import Outcome
from shared.motions import heavy
from shared.tools import tiers

GIVEN = {"start.omega[3]": "0.5:1.5:40", "body.weight": [0, 1]}


# -- members that fail ----------------------------------------------------------------------------


@pytest.mark.parametrize(("end", "steps"), [("20", 400), ("600", 9000)])
def test_a_member_that_fails_carries_its_outcome_and_harms_no_neighbour(end, steps):
    weights = [1, 2, "1e7", *range(3, 12)]
    many = polhode.integrate_many(heavy(end), {"body.weight": weights}, max_steps=steps)
    ended = [Outcome.REACHED_END] * 2 + [Outcome.STEP_LIMIT] + [Outcome.REACHED_END] * 9
    assert list(many.outcomes) == ended
    assert (many.complete, many.interrupted) == (False, False)
    assert "11 of them reached the end" in repr(many)
    assert list(many.tally().items()) == [(Outcome.REACHED_END, 11), (Outcome.STEP_LIMIT, 1)]
    free = polhode.integrate_many(heavy(end), {"body.weight": weights[:2] + weights[3:]})
    assert np.array_equal(np.delete(many.states, 2, axis=0), free.states)
    assert np.isnan(many.states[2, 1:]).all()
    assert many[2].times == (0,)
    assert many[-10].outcome is Outcome.STEP_LIMIT
    with pytest.raises(TypeError, match="'slice' object cannot be interpreted as an integer"):
        many[:2]
    assert many[2].reached < 20


@pytest.mark.parametrize(("end", "limit"), [("60", 50), ("600", 400), ("1e30", 10**4)])
def test_the_outcome_of_a_single_run_with_the_same_limit(end, limit):
    """A hopeless end is an outcome, not a hang; steps are counted over all that a member takes."""
    many = polhode.integrate_many(heavy(end), {"body.weight": [1, 2]}, max_steps=limit)
    single = polhode.integrate(many[0].scene, max_steps=limit)
    assert many.outcomes[0] is single.outcome is Outcome.STEP_LIMIT
    assert len(many[0].times) == len(single.times)
    assert end == "1e30" or [*many.counts] == [limit, limit]


def test_progress_counts_members():
    seen = []
    given = {"body.weight": "0:1:20"}
    polhode.integrate_many(heavy(), given, progress=lambda *told: seen.append(told))
    assert seen[-1] == (1, 20)
    assert [done for _, done in seen] == sorted(done for _, done in seen)


@pytest.mark.parametrize(("number", "end"), tiers([("double", "1000")], [("quad", "20")]))
def test_ctrl_c_keeps_what_is_finished(number, end):
    """The keyboard interrupts after the fifth job: its members stay, the rest are marked."""
    seen = []

    def progress(_, done):
        seen.append(done)
        if len(seen) == 5:
            signal.raise_signal(signal.SIGINT)

    given = {"start.omega[3]": "0.5:9:400"}
    options = {"number": number, "progress": progress, "workers": 2}
    many = polhode.integrate_many(heavy(end), given, **options)
    assert (many.interrupted, many.complete) == (True, False)
    finished = [k for k, outcome in enumerate(many.outcomes) if outcome.done]
    assert seen[4] <= len(finished) < 400
    assert not np.any([x != x for k in finished for x in many.states[k].ravel().tolist()])
    alone = polhode.integrate(many[finished[0]].scene, number)
    error = np.abs(np.array(many[finished[0]].states[1] - alone.states[1], float)).max()
    assert error < 2**30 * float(many.number.eps)
    undone = many.outcomes.index(Outcome.NOT_RUN)
    assert (many[undone].times, many.steps[undone]) == ((), 0)
    assert np.isnan(many.drift[undone]).all()


# -- executors ------------------------------------------------------------------------------------


def die_once(mark, solve, job):
    """Take the worker's process down with the first job that is tried."""
    if not Path(mark).exists():
        Path(mark).touch()
        os._exit(1)
    return solve(job)


class Deadly(Executor):
    """An executor one of whose workers dies."""

    def __init__(self, pool: Executor, mark: Path) -> None:
        self.pool, self.mark = pool, str(mark)

    def submit(self, fn, /, *args, **kwargs):
        return self.pool.submit(die_once, self.mark, fn, *args, **kwargs)


@pytest.mark.usefixtures("compiled_as_for_users")
@pytest.mark.slow
def test_a_process_pool_gives_the_same_bits_though_a_worker_dies(tmp_path):
    here = polhode.integrate_many(heavy(), GIVEN)
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            there = polhode.integrate_many(heavy(), GIVEN, executor=pool)
            wide = polhode.integrate_many(
                heavy("2"), {"body.weight": [1]}, number="mp", executor=pool
            )
        deadly = Deadly(pool, tmp_path / "died")
        with pytest.warns(RuntimeWarning, match=r"jobs were lost \(BrokenProcessPool"):
            again = polhode.integrate_many(heavy(), GIVEN, executor=deadly)
    assert (tmp_path / "died").exists()
    assert here == there == again
    alone = polhode.integrate(wide[0].scene, "mp", project=False)
    assert np.abs(wide[0].states - alone.states).max() < 16 * float(wide.number.eps)


@pytest.mark.usefixtures("compiled_as_for_users")
@pytest.mark.slow
def test_a_dask_cluster_gives_the_same_bits_though_a_worker_dies(tmp_path):
    distributed = pytest.importorskip("dask.distributed")
    here = polhode.integrate_many(heavy(), GIVEN)
    options = {"n_workers": 1, "threads_per_worker": 1, "dashboard_address": None}
    with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster) as client:
        deadly = Deadly(client.get_executor(), tmp_path / "died")
        assert polhode.integrate_many(heavy(), GIVEN, executor=deadly) == here
    assert (tmp_path / "died").exists()


def test_an_executor_that_is_shut_down_costs_no_result():
    pool = ThreadPoolExecutor(1)
    pool.shutdown()
    with pytest.warns(RuntimeWarning, match="1 of 1 jobs were lost"):
        many = polhode.integrate_many(heavy(), {"body.weight": [1]}, executor=pool)
    assert many.complete


def test_one_thread_is_interrupted_between_two_jobs():
    def interrupt(part: float, members: int) -> None:
        signal.raise_signal(signal.SIGINT)

    asked = {"at": ["0.1"], "number": "quad", "workers": 1}
    vary = {"start.omega[3]": "1:3:4"}
    many = polhode.integrate_many("lagrange/nutation", vary, progress=interrupt, **asked)
    assert many.interrupted
    assert [x.done for x in many.outcomes] == [True, False, False, False]


def test_a_fault_of_ours_is_not_hidden(monkeypatch):
    def broken(job, stop=None):
        raise ZeroDivisionError("ours")

    monkeypatch.setattr("polhode.taylor.batches.solve", broken)
    with pytest.raises(ZeroDivisionError):
        polhode.integrate_many(heavy(), {"body.weight": [1]})


# -- a sweep that goes on -------------------------------------------------------------------------

VARY = {"start.omega[3]": "1:4:100", "body.weight": ["1", "sqrt(2)"]}


def swept(folder: Path | None, number: str = "double", **other: Any) -> polhode.Ensemble:
    end = 20 if number == "quad" else 1  # quad members are refined, and have errors
    vary = VARY if number == "double" else VARY | {"start.omega[3]": "1:4:9"}
    options = {"vary": vary, "at": ["0", "0.3", end], "number": number, "workers": 1} | other
    return polhode.integrate_many("lagrange/nutation", parts=folder, **options)


class First(Executor):
    """An executor that does the first jobs at once, and the others never."""

    def __init__(self, jobs: int) -> None:
        self.left = jobs

    def submit(self, fn, /, *args, **kwargs):
        future: Future[object] = Future()
        if self.left:
            self.left -= 1
            future.set_result(fn(*args, **kwargs))
        return future


def interrupted(folder: Path, number: str = "double", **other: Any) -> polhode.Ensemble:
    """A sweep that Ctrl-C ends once two jobs are done."""
    seen: list[int] = []

    def progress(_: float, done: int) -> None:
        seen.append(done)
        if len(seen) == 2:
            raise KeyboardInterrupt

    options = {"progress": progress, "executor": First(2), "workers": None}
    return swept(folder, number, **options, **other)


@pytest.mark.parametrize("keep", [None, "first x"])
def test_the_parts_of_a_scene_are_no_parts_of_a_changed_one(tmp_path, parts_at_once, keep):
    """It has the text of the first still, and was given the first one's numbers."""
    first = polhode.load("lagrange/nutation")
    changed = [replace(first, omega=(0, 0, 9)), replace(first, source="", omega=("sqrt(2)", 0, 9))]
    scenes, folder, vary = [first, *changed], tmp_path / "parts", {"body.weight": [1, 2]}
    if keep is not None:
        scenes = [replace(x, events=(polhode.Event("x", zero),)) for x in scenes for zero in "pq"]

    def swept_parts(scene: polhode.Scene) -> object:
        if keep is None:
            return polhode.integrate_many(scene, vary, at=[1], parts=folder)
        return polhode.reduce_many(scene, vary, keep, at=[1], parts=folder)

    swept_parts(scenes[0])
    for other in scenes[1:]:
        with pytest.raises(polhode.BadInput, match="parts"):
            swept_parts(other)


@pytest.mark.parametrize("number", tiers(["double"], ["extended", "quad"]))
def test_an_interrupted_sweep_goes_on_and_ends_as_an_undisturbed_one(number, tmp_path):
    """However often it was interrupted, what was done is not done again; it is kept when whole."""
    whole, folder, seen = swept(None, number), tmp_path / "parts", []
    for _ in range(2):
        first = interrupted(folder, number)
        assert first.interrupted
        assert 0 < first.outcomes.count(Outcome.NOT_RUN) < len(whole)
    assert (folder / "manifest.json").is_file()
    again = swept(folder, number, progress=lambda _, done: seen.append(done))
    assert again == whole
    assert seen[0] > len(whole) - first.outcomes.count(Outcome.NOT_RUN)
    seen.clear()
    kept = swept(folder, number, progress=lambda _, done: seen.append(done))
    assert kept == whole
    assert {*seen} <= {len(whole)}
    kept.kept.remove()
    assert not folder.exists()


def test_a_sweep_over_arrays_goes_on_to_the_same_bits(tmp_path):
    rows = np.tile([0.5, 0.25, 2, 0, 0.6, 0.8], (200, 1))
    rows[:, 0] = np.linspace(1, 3, 200)
    arrays = {"vary": {"start.psi": np.zeros((200, 1))}, "starts": rows, "at": [0, 1]}
    first = interrupted(tmp_path / "parts", **arrays | {"starts": rows.copy()})
    assert 0 < first.outcomes.count(Outcome.NOT_RUN) < 200
    assert swept(tmp_path / "parts", **arrays) == swept(None, **arrays)
    moved = rows.copy()
    moved[199, 1] += 2.0**-50
    for change in ({"starts": moved}, {"vary": {"start.psi": np.ones((200, 1))}}):
        with pytest.raises(polhode.BadInput, match="same command"):
            swept(tmp_path / "parts", **arrays | change)


#: What becomes of the first part: other bytes, or other arrays in it.
DAMAGES = {
    "empty": lambda part: b"",
    "a zip's beginning": lambda part: b"PK\x03\x04",
    "nonsense": lambda part: b"nonsense" * 100,
    "cut short": lambda part: part.read_bytes()[:-300],
    "another one's": lambda part: max(part.parent.glob("job-*")).read_bytes(),
    "an array more": {"more": np.array([10**6])},
    "states": {"states": np.zeros((1, 3, 6))},
    "flat states": {"states": np.zeros(3)},
    "outcomes": {"outcomes": np.array(["arrived"])},
    "reached": {"reached": np.array(["1/0"])},
    "errors": {"errors": np.array(["[" * 100_000])},
    "steps": {"steps": np.array([1.5])},
    "checksum": {"checksum": np.array("0")},
}


@pytest.fixture(scope="module")
def four_jobs(tmp_path_factory):
    """A folder of four parts of a sweep, and the whole sweep."""
    folder = tmp_path_factory.mktemp("sweep") / "x.parts"
    interrupted(folder)
    interrupted(folder)
    return folder, swept(None)


@pytest.mark.parametrize("damage", tiers([*DAMAGES][-3:], [*DAMAGES][:-3]))
def test_a_part_that_somebody_damaged_is_made_again(damage, four_jobs, tmp_path):
    """It gave tracebacks, or its numbers went into the result."""
    parts, whole = four_jobs
    folder = shutil.copytree(parts, tmp_path / "x.parts")
    part, change = min(folder.glob("job-*")), DAMAGES[damage]
    if callable(change):
        part.write_bytes(change(part))
    else:
        with np.load(part) as file:
            np.savez(part, **{**file, **change})
    assert swept(folder) == whole


def test_a_folder_of_anything_else_is_refused_and_stays(tmp_path):
    """Of another sweep, of other things, with a manifest of brackets; or one in use."""
    folder = tmp_path / "parts"
    interrupted(folder)
    held = {path.name: path.read_bytes() for path in folder.iterdir()}
    for other in ({"at": ["0", "0.3", 2]}, {"tol": "1e-10"}):
        with pytest.raises(polhode.BadInput, match=r"same command.*remove the folder to st"):
            swept(folder, **other)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == held
    (folder / "manifest.json").write_text("[" * 100_000)
    with pytest.raises(polhode.BadInput, match="remove the folder to start again"):
        swept(folder)
    older = {"parts of": "polhode sweep", "sweep": "0" * 64, "versions": {}}  # of sweeps before
    (folder / "manifest.json").write_text(json.dumps(older))
    with pytest.raises(polhode.BadInput, match="remove the folder to start again") as refusal:
        swept(folder)
    assert "\n" not in str(refusal.value)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/mine.txt").write_text("x")
    with pytest.raises(polhode.BadInput, match="jobs of the same command"):
        swept(tmp_path / "mine")
    assert [path.name for path in (tmp_path / "mine").iterdir()] == ["mine.txt"]


@pytest.mark.skipif(sys.platform == "win32", reason="a system without such locks")
def test_two_sweeps_do_not_share_a_folder(tmp_path):
    folder = tmp_path / "parts"
    interrupted(folder)
    tried: list[str] = []

    def progress(*_: Any) -> None:
        if not tried:
            with pytest.raises(polhode.BadInput) as refusal:
                swept(folder)
            tried.append(str(refusal.value))

    assert swept(folder, progress=progress).complete
    assert "no other command running in this folder" in tried[0]


@pytest.mark.parametrize("first", [0, 1])
@pytest.mark.usefixtures("parts_at_once")
def test_a_disk_that_fills_ends_the_sweep_and_keeps_what_was_written(first, tmp_path, monkeypatch):
    """Where nothing was written there is no folder."""
    folder, whole, replaced = tmp_path / "parts", swept(None), os.replace

    def full(begun: Any, path: Any) -> None:
        if Path(path).name == f"job-{first:05d}.npz":
            raise OSError(errno.ENOSPC, "No space left")
        replaced(begun, path)

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(polhode.BadInput, match="No space left"):
        swept(folder)
    assert folder.exists() == bool(first)
    left = ["job-00000.npz", "manifest.json"][: 2 * first]
    assert [path.name for path in sorted(folder.glob("*"))] == left
    monkeypatch.setattr(os, "replace", replaced)
    assert swept(folder) == whole

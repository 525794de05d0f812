"""Jobs shared by processes: results in order, dead workers, callers that go, callers' scripts."""

import os
import pickle
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import polhode
from polhode.common.processes import in_order
from runs import jobs
from shared.tools import python, tiers

linux = pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="a system without /proc")


@pytest.mark.parametrize("workers", [1, 2])
def test_results_come_in_the_order_of_the_jobs_and_a_fault_is_the_caller_s(workers):
    begun = []
    squares = in_order(jobs.squared, range(5), workers, begun.append)
    assert [next(squares) for _ in range(3)] == [0, 1, 4]
    with pytest.raises(ValueError, match="no 3"):
        next(squares)
    assert begun[:4] == [0, 1, 2, 3]


@pytest.mark.slow
def test_faults_and_results_that_cannot_travel_are_told():
    with pytest.raises(RuntimeError, match="odd 0"):
        list(in_order(jobs.odd, range(2), 2))
    unspeakable = (AttributeError, pickle.PicklingError)  # as of Python 3.14 the second
    with pytest.raises(unspeakable, match=r"pickle|get local object"):
        list(in_order(jobs.unspeakable, range(2), 2))


@pytest.mark.slow
def test_what_a_job_prints_is_no_answer_and_stdin_is_not_its():
    assert list(in_order(jobs.noisy, range(3), 2)) == [("", 0), ("", 1), ("", 2)]


def section(**how):
    """Of four jobs."""
    level = {"h": 3, "f": "1/2", "grid": (16, 16), "crossings": 2, "accuracy": False}
    return polhode.section("general/asymmetric-chaotic", "q - 1/10", **level, **how)


def children():
    """The processes that this one has begun."""
    lists = Path("/proc/self/task").glob("*/children")
    return {int(pid) for path in lists for pid in path.read_text().split()}


@linux
@pytest.mark.usefixtures("compiled_as_for_users")
@pytest.mark.parametrize("by", tiers([signal.SIGKILL], [signal.SIGINT, None]))
def test_the_work_of_processes_comes_to_its_end_whatever_becomes_of_them(by):
    """Of one that is killed the job is done here; Ctrl-C of a terminal is the caller's alone."""
    before, begun, left = children(), set(), set()

    def strike(*_):
        left.clear()
        left.update(pid for pid in begun if alive(pid))
        if not begun:
            begun.update(children() - before)
            if by is None:
                raise KeyboardInterrupt
            for pid in begun:
                os.kill(pid, by)

    part = section(workers=3, progress=strike)
    assert len(begun) == 3
    assert left == begun or by is not signal.SIGINT
    assert part.interrupted == (by is None)
    if by is not None:
        assert np.array_equal(part.states, section(workers=1).states, equal_nan=True)
    assert not {pid for pid in begun if alive(pid)}
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, ())  # of this thread


LIGHT = """\
print("begun", flush=True)
from polhode.common.processes import in_order
print([*in_order(abs, [-1, 2, -3], 2)])
"""


@pytest.mark.parametrize(
    "words", tiers([["script.py"]], [["-c", LIGHT], ["-"], ["-m", "script"]]), ids=lambda x: x[0]
)
def test_no_process_runs_the_caller_s_script_again(words, tmp_path):
    """It has no guard: once it ran thrice, and what came on stdin was looked for as a file."""
    (tmp_path / "script.py").write_text(LIGHT)
    stdin = LIGHT if words == ["-"] else "kept for the script"
    ended = python(*words, cwd=tmp_path, input=stdin)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "begun\n[1, 2, 3]\n", "")


def test_nothing_in_the_caller_s_folder_is_taken_for_a_library(tmp_path):
    for name in ("json", "pickle", "signal", "polhode"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('the wrong one')")
    code = "import os; os.chdir(os.environ['THERE'])\n" + LIGHT
    ended = python("-P", "-c", code, env={**os.environ, "THERE": str(tmp_path)})
    assert (ended.stdout, ended.stderr) == ("begun\n[1, 2, 3]\n", "")


CLOSED = """\
import os
os.closerange(0, 2)
from polhode.common.processes import Process
os._exit(Process().do(abs, -7))
"""


def test_a_caller_whose_stdin_and_stdout_are_closed_has_processes():
    """The way to a process then has their numbers, which once were its own: it died at once."""
    ended = python("-c", CLOSED)
    assert (ended.returncode, ended.stderr) == (7, "")


ORPHANS = """\
import time
from polhode.common import processes
from polhode.common.processes import in_order
made, make = [], processes.Process
processes.Process = lambda: made.append(make()) or made[-1]
found = in_order(time.sleep, [0, 600, 600], 2)
next(found)
print(*(x._process.pid for x in made), flush=True)
next(found)
"""


@linux
def test_processes_end_with_their_caller_however_it_ends():
    """Killed, it can tell them nothing: they notice, in the middle of their jobs."""
    caller = subprocess.Popen([sys.executable, "-c", ORPHANS], stdout=subprocess.PIPE, text=True)
    pids = [int(pid) for pid in caller.stdout.readline().split()]
    caller.kill()
    caller.communicate()
    until = time.monotonic() + 60
    left = set(pids)
    while left and time.monotonic() < until:
        left = {pid for pid in left if alive(pid)}
        time.sleep(0.01)
    assert (len(pids), left) == (2, set())


def alive(pid):
    """Whether a process is there; one that has ended and waits to be noticed is not."""
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False

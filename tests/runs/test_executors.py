"""Jobs shared by processes: results in order, dead workers, callers that go, callers' scripts."""

import os
import pickle
import signal
import subprocess
import sys
import time

import pytest

from polhode.common import processes
from polhode.common.processes import in_order
from runs import jobs
from shared.tools import python, tiers


@pytest.mark.parametrize("workers", [1, 2])
def test_results_come_in_the_order_of_the_jobs_and_a_fault_is_the_caller_s(workers):
    begun = []
    squares = in_order(jobs.squared, range(5), workers, begun.append)
    assert [next(squares) for _ in range(3)] == [0, 1, 4]
    with pytest.raises(ValueError, match="no 3"):
        next(squares)
    assert begun[:4] == [0, 1, 2, 3]


def test_the_jobs_of_a_process_that_died_are_done_here(monkeypatch, tmp_path):
    monkeypatch.setenv(jobs.PARENT, str(os.getpid()))
    monkeypatch.setenv(jobs.MARK, str(tmp_path / "died"))
    assert [*in_order(jobs.deadly, range(3), 2)] == [0, -1, -2]
    assert (tmp_path / "died").exists()


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


@pytest.mark.slow
def test_where_the_caller_goes_the_processes_end(monkeypatch):
    made, make = [], processes.Process
    monkeypatch.setattr(processes, "Process", lambda: made.append(make()) or made[-1])
    found = in_order(jobs.long, range(3), 2)
    assert next(found) == 0
    assert [x._process.poll() for x in made] == [None, None]
    found.close()
    assert [x._process.poll() for x in made] == [-signal.SIGKILL] * 2


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


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="signals of POSIX")
def test_ctrl_c_of_a_terminal_does_not_reach_them(monkeypatch):
    """From their first moment on, while Python starts, too: the caller ends them."""
    made, make = [], processes.Process
    monkeypatch.setattr(processes, "Process", lambda: made.append(make()) or made[-1])
    found = in_order(jobs.squared, range(2), 2)
    assert next(found) == 0
    for process in made:
        os.kill(process._process.pid, signal.SIGINT)
    assert [*found] == [1]
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ())
    assert signal.SIGINT not in before  # of this thread


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


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="a system without /proc")
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

"""All verbs at once in threads, in pools, and after Ctrl-C at any moment: the same answers."""

import functools
import multiprocessing
import os
import random
import signal
import threading
import time
from concurrent.futures import ThreadPoolExecutor, wait
from itertools import cycle

import heyoka
import pytest

from polhode import BadInput
from shared.results import MAKERS

THREADS = 16
PATIENCE = 600.0  # seconds, for what ends in a few if at all
#: One small question to each verb, by the kind of its result.
VERBS = (
    *("Trajectory", "Trajectory in quad", "EventTimes", "ReferenceTable", "Certified", "Enclosure"),
    *("Judgement", "Levels", "Section", "ChaosMap", "Orbit", "Frequencies", "Ensemble"),
    *("Reductions", "Lyapunov", "Conditioning", "Description"),
)


def answer(name: str) -> str:
    """All that a result says, every number with all its digits."""
    return MAKERS[name]().to_json()


alone = functools.cache(answer)


def answer_as_alone(names: list[str]) -> None:
    """Asked in many threads: each answer is that of one thread, and none waits for another."""
    expected = {name: alone(name) for name in names}
    pool = ThreadPoolExecutor(THREADS)
    jobs = {pool.submit(answer, name): name for name in names}
    _, late = wait(jobs, PATIENCE)
    assert not late, f"{len(late)} threads wait for each other"
    pool.shutdown()
    assert {name for job, name in jobs.items() if job.result() != expected[name]} == set()


#: Locks of two kinds, integrators compiled by both, and settings of the process.
SOME = [("Levels", "Orbit"), ("Ensemble", "Enclosure")]


@pytest.mark.slow
@pytest.mark.parametrize("pair", SOME, ids="-".join)
def test_pairs_of_verbs_in_threads_answer_as_alone(pair, quick_changes):
    """Levels and an orbit waited for each other for ever, in one try of four."""
    answer_as_alone([*pair] * 6)


@pytest.mark.slow
def test_all_verbs_in_threads_at_once_answer_as_alone(quick_changes):
    answer_as_alone([*VERBS] * 2)


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="a system without fork")
def test_a_forked_pool_answers_as_one_process():
    """All that is compiled and kept goes along into a fork."""
    expected = [alone(name) for name in VERBS]
    with multiprocessing.get_context("fork").Pool(2) as pool:
        assert pool.map_async(answer, VERBS, chunksize=1).get(PATIENCE) == expected


def interrupted(name: str, after: float) -> BaseException | None:
    """Ask, and press Ctrl-C so many seconds later; what was heard, which keeps its frames alive.

    A run that it ended before its first row is no traceback of Ctrl-C, and cannot be judged.
    """
    came = None
    timer = threading.Timer(after, lambda: os.kill(os.getpid(), signal.SIGINT))
    try:
        try:
            timer.start()
            MAKERS[name]()
        finally:
            timer.cancel()
            timer.join()
    except KeyboardInterrupt as fault:
        came = fault
    except BadInput as fault:
        if "the run was interrupted" not in str(fault):
            raise
        came = fault
    return came


#: An interrupt may come in hypothesis's hook of the collector, which loses it with a warning.
LOST = pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")


@LOST
@pytest.mark.slow
def test_the_next_answer_after_any_of_many_interrupts_is_the_same():
    """Verbs are interrupted in turn, at a moment within what each takes."""
    names, count = [*VERBS], 10
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    before = heyoka.get_nthreads(), heyoka.llvm_state.get_diskcache_enabled()
    lasts = {}
    for name in names:
        alone(name)
        start = time.perf_counter()
        answer(name)
        lasts[name] = time.perf_counter() - start
    chance, came = random.Random(25), 0
    for k, name in enumerate(cycle(names)):
        heard = interrupted(name, chance.uniform(0, lasts[name]))
        assert answer(name) == alone(name), (name, k, heard)
        came += heard is not None
        if came == count:
            break
        assert k < 10 * count, f"{came} of {k} interrupts came while a verb was at work"
    answer_as_alone(names)  # other threads find no lock that is held
    assert (heyoka.get_nthreads(), heyoka.llvm_state.get_diskcache_enabled()) == before

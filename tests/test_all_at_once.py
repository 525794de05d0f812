"""All verbs at once in threads, in pools, and after Ctrl-C at any moment: the same to the bit."""

from __future__ import annotations

import functools
import multiprocessing
import os
import random
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import combinations_with_replacement, cycle
from typing import Any

import heyoka
import pytest

from polhode.common import interrupts
from shared.verbs import VERBS, answer

THREADS = 16
PATIENCE = 600.0  # seconds, for what ends in a few if at all

alone = functools.cache(answer)

#: Locks of two kinds, integrators compiled by both, and settings of the process.
SOME = [("levels", "orbit"), ("integrate_many", "certify"), ("quad", "reduce_many")]


@pytest.fixture
def quick_changes() -> Iterator[None]:
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    yield
    sys.setswitchinterval(interval)


def together(names: Sequence[str], jobs: int) -> set[str]:
    """Ask so many times in threads; the verbs whose answers differ from those of one thread."""
    waiting, wrong = deque(list(names) * (jobs // len(names))), set()

    def work() -> None:
        while True:
            try:
                name = waiting.popleft()
            except IndexError:
                return
            try:
                if answer(name) != alone(name):
                    wrong.add(name)
            except BaseException as fault:
                wrong.add(f"{name}: {fault!r}")

    for name in names:
        alone(name)
    threads = [threading.Thread(target=work, daemon=True) for _ in range(THREADS)]
    for thread in threads:
        thread.start()
    until = time.monotonic() + PATIENCE
    for thread in threads:
        thread.join(max(0.0, until - time.monotonic()))
    left = sum(thread.is_alive() for thread in threads)
    assert left == 0, f"{left} threads wait for each other: {names}"
    return wrong


@pytest.mark.sample(0, slow=2)
@pytest.mark.parametrize("pair", SOME, ids="-".join)
def test_pairs_of_verbs_in_threads_answer_as_alone(pair, quick_changes):
    """Levels and an orbit waited for each other for ever, in one try of four."""
    assert together(pair, 12) == set()


@pytest.mark.campaign
@pytest.mark.parametrize("first", VERBS)
def test_all_pairs_of_verbs_in_threads_answer_as_alone(first, quick_changes):
    names = list(VERBS)
    pairs = [p for p in combinations_with_replacement(names, 2) if p[0] == first]
    assert {name for pair in pairs for name in together(sorted({*pair}), 40)} == set()


@pytest.mark.slow
def test_all_verbs_in_threads_at_once_answer_as_alone(quick_changes):
    assert together([*VERBS] * 3, 3 * len(VERBS)) == set()


def in_pool(start: str, names: Sequence[str]) -> list[Any]:
    if start not in multiprocessing.get_all_start_methods():
        pytest.skip(f"a system without {start}")
    with multiprocessing.get_context(start).Pool(2) as pool:
        return pool.map_async(answer, names, chunksize=1).get(PATIENCE)


@pytest.mark.sample(0, slow=1)
@pytest.mark.parametrize(
    ("start", "names"),
    [
        ("fork", [*VERBS] * 2),
        ("spawn", ["integrate", "events", "reference", "integrate_many"]),  # all is compiled anew
        ("forkserver", [*VERBS] * 2),
    ],
)
def test_a_pool_answers_as_one_process(start, names):
    for name in VERBS:
        alone(name)  # all that is compiled and kept goes along into a fork
    assert in_pool(start, names) == [alone(name) for name in names]


def free(lock: interrupts.Lock) -> bool:
    """Whether a thread other than this one could take it."""

    def tried() -> bool:
        taken = lock.bare.acquire(timeout=60)
        if taken:
            lock.bare.release()
        return taken

    with ThreadPoolExecutor(1) as pool:
        return pool.submit(tried).result()


def interrupted(name: str, after: float) -> KeyboardInterrupt | None:
    """Ask, and press Ctrl-C so many seconds later; what was heard, which keeps its frames alive."""
    came = None
    timer = threading.Timer(after, lambda: os.kill(os.getpid(), signal.SIGINT))
    try:
        try:
            timer.start()
            VERBS[name]()
        finally:
            timer.cancel()
            timer.join()
    except KeyboardInterrupt as fault:
        came = fault
    return came


#: An interrupt may come in hypothesis's hook of the collector, which loses it with a warning.
LOST = pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")


@pytest.mark.slow
@LOST
def test_the_next_answer_after_an_interrupt_is_the_same():
    after_interrupts(["levels", "quad", "integrate_many", "reference"], 4)


@LOST
@pytest.mark.slow
def test_the_next_answer_after_any_of_many_interrupts_is_the_same():
    after_interrupts([*VERBS], 16)


def after_interrupts(names: Sequence[str], wanted: int) -> None:
    """Interrupt verbs in turn, at a moment within what each takes, until so many were heard."""
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
        if came == wanted:
            break
        assert k < 10 * wanted, f"{came} of {k} interrupts came while a verb was at work"
    assert all(map(free, list(interrupts._ALL)))
    assert (heyoka.get_nthreads(), heyoka.llvm_state.get_diskcache_enabled()) == before

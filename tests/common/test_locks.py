"""One order of all locks: a thread that takes them in another one is told, alone or not."""

from __future__ import annotations

import os
import signal
import threading
from concurrent.futures import ThreadPoolExecutor
from itertools import product

import numpy as np
import pytest

from polhode.common.locks import Lock, Place


def free(lock: Lock) -> bool:
    """Whether another thread could take it."""

    def tried() -> bool:
        if taken := lock.bare.acquire(blocking=False):
            lock.bare.release()
        return taken

    with ThreadPoolExecutor(1) as pool:
        return pool.submit(tried).result()


@pytest.mark.parametrize(("first", "second"), [*product(Place, Place)])
def test_a_later_place_after_an_earlier_one_and_no_other(first, second):
    one, other = Lock(first), Lock(second)
    with one.held():
        if second > first:
            with other.held():
                assert not free(one)
                assert not free(other)
        elif second is not first or first is not Place.PRECISION:
            with pytest.raises(AssertionError), other.held():
                pass
            assert free(other)
    assert free(one)
    with other.held():
        assert not free(other)  # nothing is remembered


def test_a_precision_is_taken_again_by_its_holder():
    one = Lock(Place.PRECISION)
    with one.held(), one.held():
        pass
    with one.held(), pytest.raises(AssertionError), Lock(Place.COMPILING).held():
        pass


def test_what_another_thread_holds_is_its_own_matter():
    store, precision, found = Lock(Place.STORE), Lock(Place.PRECISION), []

    def take() -> None:
        with precision.held():
            found.append(store.bare.acquire(blocking=False))

    with store.held():
        other = threading.Thread(target=take)
        other.start()
        other.join()
    assert found == [False]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="a system without fork")
def test_in_a_forked_child_nobody_holds_a_lock():
    locks = [Lock(place) for place in Place]
    ready, done = threading.Event(), threading.Event()

    def hold() -> None:
        with locks[0].held(), locks[1].held(), locks[2].held():
            ready.set()
            done.wait(60)

    holder = threading.Thread(target=hold)
    holder.start()
    ready.wait(60)
    child = os.fork()
    if child == 0:
        free = all(lock.bare.acquire(blocking=False) for lock in locks)
        os._exit(0 if free else 1)
    done.set()
    holder.join()
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


def test_an_interrupt_at_the_end_of_a_block_gives_back_what_it_held():
    """Heard where the block is left, after a step of C; the exception is kept, as consoles do."""
    lock, large = Lock(Place.STORE), np.ones((700, 700), dtype=int)
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.05)
        with pytest.raises(KeyboardInterrupt) as kept, lock.held():
            large = large @ large  # half a second in which no signal is heard
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert free(lock)
    assert kept.traceback

"""One order of all locks: a thread that takes them in another one is told, alone or not."""

import contextlib
import gc
import json
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import product

import flint
import numpy as np
import pytest

from polhode.common.interrupts import Lock, LockPlace
from polhode.common.values import cached_property
from polhode.numbers.flint_context import ctx
from polhode.numbers.mpmath_context import mpmath
from polhode.taylor.heyoka import Meanwhile


def free(lock: Lock) -> bool:
    """Whether another thread could take it."""

    def tried() -> bool:
        if acquired := lock.bare.acquire(blocking=False):
            lock.bare.release()
        return acquired

    with ThreadPoolExecutor(1) as pool:
        return pool.submit(tried).result()


@pytest.mark.parametrize(("first", "second"), [*product(LockPlace, LockPlace)])
def test_a_later_place_after_an_earlier_one_and_no_other(first, second):
    lock, inner = Lock(first), Lock(second)
    with lock.held():
        if second > first:
            with inner.held():
                assert not free(lock)
                assert not free(inner)
        elif second is not first or first is not LockPlace.PRECISION:
            with pytest.raises(AssertionError), inner.held():
                pass
            assert free(inner)
    assert free(lock)
    with inner.held():
        assert not free(inner)  # nothing is remembered


def test_a_precision_is_taken_again_by_its_holder():
    lock = Lock(LockPlace.PRECISION)
    with lock.held(), lock.held():
        pass
    with lock.held(), pytest.raises(AssertionError), Lock(LockPlace.COMPILING).held():
        pass


def test_what_another_thread_holds_is_its_own_matter():
    store, precision, answers = Lock(LockPlace.STORE), Lock(LockPlace.PRECISION), []

    def take() -> None:
        with precision.held():
            answers.append(store.bare.acquire(blocking=False))

    with store.held():
        thread = threading.Thread(target=take)
        thread.start()
        thread.join()
    assert answers == [False]


@contextlib.contextmanager
def another_thread(work: Callable[[Callable[[], object]], None]) -> Iterator[None]:
    """Another thread is in the middle of its work, where it calls what it is given."""
    ready, end = threading.Event(), threading.Event()

    def stay() -> None:
        ready.set()
        end.wait(60)

    thread = threading.Thread(target=work, args=(stay,))
    thread.start()
    assert ready.wait(60)
    try:
        yield
    finally:
        end.set()
        thread.join()


def in_a_child(answer: Callable[[], list[int]]) -> list[int]:
    """What a forked child says."""
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.write(write, json.dumps(answer()).encode())
        finally:
            os._exit(0)
    os.waitpid(child, 0)
    os.close(write)
    with open(read) as pipe:
        return json.load(pipe)


def precisions() -> list[int]:
    return [flint.ctx.prec, mpmath.prec, mpmath.dps]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="a system without fork")
def test_a_forked_child_has_no_precision_of_another_thread():
    """Of a thread that computes in the parent; that of the one that forks stays."""
    before = precisions()

    def compute(middle: Callable[[], object]) -> None:
        with ctx.workprec(777), ctx.workprec(888), mpmath.workprec(1000):
            middle()

    with another_thread(compute):
        assert in_a_child(precisions) == before
    compute(lambda: before.append(in_a_child(precisions)[:2]))
    assert before.pop() == [888, 1000]
    assert precisions() == before


@pytest.mark.skipif(not hasattr(os, "fork"), reason="a system without fork")
def test_in_a_forked_child_nobody_holds_a_lock():
    locks = [Lock(place) for place in LockPlace]

    def hold(middle: Callable[[], object]) -> None:
        with locks[0].held(), locks[1].held(), locks[2].held():
            middle()

    with another_thread(hold):
        acquired = in_a_child(lambda: [lock.bare.acquire(blocking=False) for lock in locks])
    assert acquired == [True] * len(locks)


def test_an_interrupt_at_the_end_of_a_block_gives_back_what_it_held():
    """Heard where the block is left, after a step of C; the exception is kept, as consoles do."""
    lock, large = Lock(LockPlace.STORE), np.ones((700, 700), dtype=int)
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.05)
        with pytest.raises(KeyboardInterrupt) as fault, lock.held():
            large = large @ large  # half a second in which no signal is heard
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert free(lock)
    assert fault.traceback


class Setting:
    """One for the whole process."""

    value = 5

    def meanwhile(self) -> Meanwhile[int]:
        return Meanwhile(lambda: self.value, self.write, 1)

    def write(self, value: int) -> None:
        self.value = value


def abandon(setting: Setting, changed: Meanwhile[int]) -> None:
    """A block whose end nobody reaches, in a circle that a garbage collection finds."""
    block = changed()
    block.__enter__()
    circle = [block]
    circle.append(circle)
    del block
    assert setting.value == 1


@pytest.mark.filterwarnings("error::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize(
    "place",
    [
        LockPlace.COMPILING,
        pytest.param(LockPlace.PRECISION, marks=pytest.mark.slow),
        pytest.param(LockPlace.STORE, marks=pytest.mark.slow),
    ],
)
def test_a_setting_is_put_back_by_a_garbage_collection_under_any_lock(place):
    setting = Setting()
    changed = setting.meanwhile()
    gc.disable()
    try:
        abandon(setting, changed)
        with Lock(place).held():
            gc.collect()
    finally:
        gc.enable()
    assert setting.value == 5


@pytest.mark.slow
def test_a_setting_is_put_back_by_who_collects_while_it_is_written():
    """The lock of the setting itself is held then: whoever holds it looks again."""
    setting = Setting()
    changed = setting.meanwhile()
    write = setting.write

    def collecting(value: int) -> None:
        write(value)
        gc.collect()

    gc.disable()
    try:
        setting.write = collecting
        changed = setting.meanwhile()
        abandon(setting, changed)
        with changed():
            assert setting.value == 1
    finally:
        gc.enable()
    assert setting.value == 5


# -- a property computed once an instance, that holds no lock meanwhile --------------------------


@dataclass(frozen=True)
class Counting:
    """Counts how often a value is computed; threads meet while they compute it."""

    counted: list[int]
    met: threading.Barrier | None = None

    @cached_property
    def value(self) -> list[int]:
        """What it is."""
        self.counted.append(1)
        if self.met is not None:
            self.met.wait(60)
        if len(self.counted) == 1:
            raise ZeroDivisionError
        return [7]


def test_it_is_computed_once_and_is_no_field_but_what_raised_again():
    counting = Counting([])
    with pytest.raises(ZeroDivisionError):
        _ = counting.value
    assert counting.value is counting.value
    assert counting.counted == [1, 1]
    assert counting.value is not Counting([1, 1]).value
    assert counting == Counting([1, 1])
    assert Counting.value.__doc__ == "What it is."


def test_threads_compute_at_once_and_are_given_the_same():
    """With a lock the first would wait at the barrier for the others for ever."""
    counting = Counting([1, 1], threading.Barrier(4))
    with ThreadPoolExecutor(4) as pool:
        values = list(pool.map(lambda _: counting.value, range(4)))
    assert len(counting.counted) == 6
    assert all(x is values[0] is counting.value for x in values)

"""Settings of libraries for the whole process, changed while any thread is in need of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from functools import cache
from typing import Generic, TypeVar
from weakref import WeakSet

from polhode.common.interrupts import Lock, Place
from polhode.taylor.backend.engine import hy

T = TypeVar("T")


class _Block:
    """One thread inside."""


class Meanwhile(Generic[T]):
    """``with meanwhile():`` a setting has this value; the last to leave puts back what was there.

    However a block is ended, by Ctrl-C at its very end too: who is inside is known by what lives
    as long as the block does, not by counting.  Its end may come in a garbage collection, below any
    lock of the thread that collects, so it waits for none: who holds this one looks again.
    """

    def __init__(self, read: Callable[[], T], write: Callable[[T], object], value: T) -> None:
        self._read, self._write, self._value = read, write, value
        self._before: T | None = None
        self._inside: WeakSet[_Block] = WeakSet()
        self._lock = Lock(Place.STORE)

    @contextmanager
    def __call__(self) -> Iterator[None]:
        """The block."""
        block = _Block()
        try:
            with self._lock.held():
                if self._before is None:
                    self._before = self._read()
                self._inside.add(block)
                self._write(self._value)
            yield
        finally:
            del block
            self._put_back()

    def _put_back(self) -> None:
        """What was there before, if nobody is inside."""
        bare = self._lock.bare
        while self._before is not None and not self._inside and bare.acquire(blocking=False):
            try:
                if self._before is not None and not self._inside:
                    self._write(self._before)
                    self._before = None
            finally:
                bare.release()


#: heyoka's compiled functions run on the caller's thread alone.
one_thread = Meanwhile(hy.get_nthreads, hy.set_nthreads, 1)

#: Code is neither looked for in heyoka's cache on the disk nor kept there.
uncached = Meanwhile(
    hy.llvm_state.get_diskcache_enabled, hy.llvm_state.set_diskcache_enabled, False
)


def one_blas_thread() -> AbstractContextManager[None]:
    """A block in which numpy's linear algebra runs on the caller's thread alone.

    With matrices of 6 x 6 a second thread has nothing to do and spins: a refined run then takes
    twice the processor time of its wall clock, and on a busy machine many times that.
    """
    return _blas()()


@cache
def _blas() -> Meanwhile[tuple[int, ...]]:
    from threadpoolctl import ThreadpoolController

    libraries = ThreadpoolController().select(user_api="blas").lib_controllers

    def read() -> tuple[int, ...]:
        return tuple(library.get_num_threads() for library in libraries)

    def write(threads: tuple[int, ...]) -> None:
        for library, count in zip(libraries, threads, strict=True):
            library.set_num_threads(count)

    return Meanwhile(read, write, (1,) * len(libraries))

"""heyoka's settings for the whole process, changed while any thread is in need of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Generic, TypeVar
from weakref import WeakSet

import heyoka as hy

from polhode.common.locks import Lock, Place

T = TypeVar("T")


class _Block:
    """One thread inside."""


class Meanwhile(Generic[T]):
    """``with meanwhile():`` a setting has this value; the last to leave puts back what was there.

    However a block is ended, by Ctrl-C at its very end too: who is inside is known by what lives
    as long as the block does, not by counting.
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
            with self._lock.held():
                if self._before is not None and not self._inside:
                    self._write(self._before)
                    self._before = None


#: heyoka's compiled functions run on the caller's thread alone.
one_thread = Meanwhile(hy.get_nthreads, hy.set_nthreads, 1)

#: Code is neither looked for in heyoka's cache on the disk nor kept there.
uncached = Meanwhile(
    hy.llvm_state.get_diskcache_enabled, hy.llvm_state.set_diskcache_enabled, False
)

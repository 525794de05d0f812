"""The locks of polhode, all of them, and the one order in which a thread may take them.

Two threads that take the same two locks in different orders wait for each other for ever.  So each
lock has a place in an order, and a thread that holds one takes only those of later places: whoever
compiles may need a precision, whoever holds a precision may look into a store, and nobody the other
way.  Every taking is checked, so that any test that takes them in a wrong order fails at once, with
one thread or many.

Nothing else that holds a lock while it computes belongs in polhode: properties are kept by
:mod:`polhode.common.cached_property`, and ``functools.lru_cache`` holds none.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Generator
from enum import IntEnum
from functools import partial
from weakref import ReferenceType, WeakSet, ref


class Place(IntEnum):
    """What a lock guards, in the order of taking."""

    COMPILING = 1  # an integrator that all threads wait for, rather than each compile its own
    PRECISION = 2  # of mpmath's private context and of FLINT; may be taken again by its holder
    STORE = 3  # a few steps on plain containers, which call nothing


class Held:
    """``with Held(steps):`` runs a generator to its one yield, and on to its end afterwards.

    Ctrl-C or an alarm may raise between any two steps of Python.  What the generator holds it
    gives back however it ends: by an exception inside, or because nobody knows it any more.  An
    exception at the entry of what leaves the block keeps that frame alive with its traceback, as
    long as somebody keeps the exception: so the frame must not know the generator.
    """

    __slots__ = ("_steps",)

    def __init__(self, steps: Generator[None, None, None]) -> None:
        self._steps = steps

    def __enter__(self) -> None:
        try:
            next(self._steps)
        except BaseException:
            self._steps.close()
            raise

    @property
    def __exit__(self) -> Callable[..., None]:
        """What leaves the block: ``with`` looks it up before the block and drops it with it."""
        return _Leave(self._steps)


class _Leave(partial[None]):
    """Ends a generator that its own call refers to weakly; it is alive as long as this is."""

    __slots__ = ("steps",)
    steps: Generator[None, None, None]

    def __new__(cls, steps: Generator[None, None, None]) -> _Leave:
        leave = super().__new__(cls, _leave, ref(steps))
        leave.steps = steps
        return leave


def _leave(known: ReferenceType[Generator[None, None, None]], *fault: object) -> None:
    steps = known()
    if steps is not None:
        steps.close()


class Lock:
    """A lock with a place in the order; a forked child, where nobody holds it, gets a new one."""

    __slots__ = ("__weakref__", "bare", "place")

    def __init__(self, place: Place) -> None:
        self.place = place
        self.renew()
        _ALL.add(self)

    def renew(self) -> None:
        """A lock that nobody holds."""
        again = self.place is Place.PRECISION
        self.bare = threading.RLock() if again else threading.Lock()

    def held(self) -> Held:
        """``with lock.held():`` it is this thread's to the end of the block."""
        return Held(self._holding())

    def _holding(self) -> Generator[None, None, None]:
        places, place = _mine.places, self.place
        latest = places[-1] if places else 0
        assert place > latest or place is latest is Place.PRECISION, f"{place!r} after {latest!r}"
        with self.bare:
            before = len(places)
            try:
                places.append(place)
                yield
            finally:
                del places[before:]


class _Mine(threading.local):
    """The places of the locks that this thread holds, the last one taken last."""

    def __init__(self) -> None:
        self.places: list[Place] = []


_mine = _Mine()
_ALL: WeakSet[Lock] = WeakSet()


def _renew() -> None:
    for lock in _ALL:
        lock.renew()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_renew)

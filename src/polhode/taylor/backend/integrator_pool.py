"""Compiled integrators that nobody uses at the moment, for the next run of the same equations.

Building one takes milliseconds even when its code is found on the disk, and so does freeing it: as
long as a short run itself.  A run takes an integrator out, so that no two runs share one, and puts
it back when it has ended well.  There is one pool for all of them, by kind and by what they
integrate.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Generic, TypeVar, cast

from polhode.common.locks import Lock, Place

#: heyoka's integrator, with what belongs to its events where it looks for any.
C = TypeVar("C")


class Kind(Generic[C]):
    """What kind of integrators they are; at most so many are kept while nobody uses them.

    Each takes a few hundred kilobytes.
    """

    def __init__(self, most: int) -> None:
        self.most = most


class Pool:
    """Integrators by kind and by what they integrate; those not asked for longest go first.

    What they integrate is their key; nothing is kept where that is None.
    """

    def __init__(self) -> None:
        self._kept: dict[object, OrderedDict[Hashable, list[object]]] = {}
        self._lock, self._compiling = Lock(Place.STORE), Lock(Place.COMPILING)

    def take(self, kind: Kind[C], key: Hashable) -> C | None:
        """One that integrates this, from now on the caller's; None where there is none."""
        try:  # no lock: no two threads are given the same
            return cast(C, self._kept[kind][key].pop())
        except (KeyError, IndexError):
            return None

    def taken_or_built(self, kind: Kind[C], key: Hashable, build: Callable[[], C]) -> C:
        """The same, built where there is none.

        One thread at a time builds, since the code that heyoka has compiled serves the others.
        """
        found = self.take(kind, key)
        if found is None:
            with self._compiling.held():
                found = self.take(kind, key) or build()
        return found

    def put(self, kind: Kind[C], key: Hashable, integrator: C) -> None:
        """Keep one for whoever asks next."""
        if key is None:
            return
        with self._lock.held():
            of_kind = self._kept.setdefault(kind, OrderedDict())
            of_kind.setdefault(key, []).append(integrator)
            of_kind.move_to_end(key)
            while max(len(of_kind), sum(map(len, of_kind.values()))) > kind.most:
                idle = of_kind[first := next(iter(of_kind))]
                del idle[:1]  # nothing, where another thread has just taken it
                if not idle:
                    del of_kind[first]


#: The one of this process.
POOL = Pool()

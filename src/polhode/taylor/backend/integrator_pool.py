"""Compiled integrators that no run uses at the moment, for the next run of the same equations.

Building one takes milliseconds even when its code is found on the disk, and so does freeing it: as
long as a short run itself.  A run takes an integrator out, so that no two runs share one, and puts
it back when it has ended well.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Hashable
from typing import Generic, TypeVar

from polhode.common.locks import Lock, Place

#: heyoka's integrator, with what belongs to its events where it looks for any.
C = TypeVar("C")

MOST = 16  # of a few hundred kilobytes each


class Idle(Generic[C]):
    """Integrators by what they integrate; those not asked for longest go first."""

    def __init__(self, most: int = MOST) -> None:
        self._most = most
        self._kept: OrderedDict[Hashable, list[C]] = OrderedDict()
        self._lock = Lock(Place.STORE)

    def take(self, key: Hashable) -> C | None:
        """One that integrates this, from now on the caller's; None where there is none."""
        with self._lock.held():
            kept = self._kept.get(key)
            if kept is None:
                return None
            found = kept.pop()
            if not kept:
                del self._kept[key]
            return found

    def put(self, key: Hashable, integrator: C) -> None:
        """Keep one for whoever asks next."""
        with self._lock.held():
            self._kept.setdefault(key, []).append(integrator)
            self._kept.move_to_end(key)
            while sum(map(len, self._kept.values())) > self._most:
                first = next(iter(self._kept))
                self._kept[first].pop()
                if not self._kept[first]:
                    del self._kept[first]

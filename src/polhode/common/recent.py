"""What was made of an object, for as long as that object lives."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Generic, TypeVar
from weakref import WeakKeyDictionary

from polhode.common.locks import Lock, Place

T = TypeVar("T")


class Recent(Generic[T]):
    """The last ``most`` values made of each owner, by key.

    They go when the owner does: so no value may refer to its owner.  A look at what is there takes
    no lock: that would cost a short run a tenth of its time.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._kept: WeakKeyDictionary[object, dict[Hashable, T]] = WeakKeyDictionary()
        self._lock = Lock(Place.STORE)

    def get(self, owner: object, key: Hashable, make: Callable[[], T]) -> T:
        """The owner's value of a key, made where there is none."""
        kept = self._kept.get(owner)
        found = None if kept is None else kept.get(key)
        if found is not None:
            return found
        made = make()
        with self._lock.held():
            kept = self._kept.setdefault(owner, {})
            found = kept.setdefault(key, made)  # another thread's may be there
            if len(kept) > self._most:
                del kept[next(iter(kept))]
            return found

"""A property that is computed once an instance, without a lock.

Python 3.11's ``functools.cached_property`` holds one lock a property, for all instances, while the
value is computed.  Where that computation takes another lock, two threads can wait for each other
for ever.  Python 3.12's has no lock, and neither has this one.  Threads that ask at the same time
may compute the value several times; the first to come is kept, and all of them are given that one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # the same to a type checker
    from functools import cached_property as cached_property
else:
    _NOTHING = object()

    class cached_property:  # noqa: N801
        """Like ``functools.cached_property``: the value stands in the instance's ``__dict__``."""

        def __init__(self, func: Callable[[object], object]) -> None:
            self.func = func
            self.__doc__ = func.__doc__

        def __set_name__(self, owner: type, name: str) -> None:
            self._name = name

        def __get__(self, instance: object, owner: type | None = None) -> object:
            if instance is None:
                return self
            kept = instance.__dict__
            found = kept.get(self._name, _NOTHING)
            if found is _NOTHING:  # by now another thread's may be there
                found = kept.setdefault(self._name, self.func(instance))
            return found

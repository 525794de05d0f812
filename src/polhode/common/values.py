"""Immutable values: equality, cached properties, a few kept last, memory."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar, cast
from weakref import WeakKeyDictionary

from polhode.common.errors import BadInput
from polhode.common.interrupts import Lock, Place

# --- value semantics ------------------------------------------------------------------------------
#
# Results as values: compared by what they hold, arrays included, and pickled as that alone.


T = TypeVar("T")


class ByValue:
    """A frozen dataclass (``eq=False``) that is compared field by field, arrays by their elements.

    Fields marked ``compare=False`` are left out.  Such values are not hashable: what they hold may
    be arrays.
    """

    __hash__: ClassVar[None]  # type: ignore[assignment]

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        names = [f.name for f in fields(self) if f.compare]  # type: ignore[arg-type]
        return all(same(getattr(self, name), getattr(other, name)) for name in names)

    def __getstate__(self) -> dict[str, object]:
        """The fields alone: what was computed from them is computed again."""
        return {f.name: getattr(self, f.name) for f in fields(self)}  # type: ignore[arg-type]

    def __setstate__(self, state: Mapping[str, object]) -> None:
        for name, value in state.items():
            object.__setattr__(self, name, value)


def same(one: object, other: object) -> bool:
    """Whether two values are equal; arrays, lists and mappings by their elements, nan as itself."""
    if one is other:
        return True
    if isinstance(one, float) and isinstance(other, float):  # numpy's doubles are floats, too
        return one == other or (one != one and other != other)
    if hasattr(one, "dtype") or hasattr(other, "dtype"):
        return _same_arrays(one, other)
    if isinstance(one, (list, tuple)) and isinstance(other, (list, tuple)):
        alike = type(one) is type(other) and len(one) == len(other)
        return alike and all(map(same, one, other))
    if isinstance(one, Mapping):
        if not isinstance(other, Mapping) or one.keys() != other.keys():
            return False
        return all(same(one[key], other[key]) for key in one)
    return bool(one == other) or (one != one and other != other)


def may_wait(name: str) -> Callable[[type[T]], type[T]]:
    """Let a field of a dataclass be given as a function, called when it is first asked for."""

    def decorated(cls: type[T]) -> type[T]:
        setattr(cls, name, _Waiting(f"_{name}"))
        return cls

    return decorated


def waiting(make: Callable[[], T]) -> T:
    """A function as the value of a field that may wait; to the field's type it is what it makes."""
    return cast(T, make)


class _Waiting:
    """A field that is a value, or a function without arguments that makes it."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __get__(self, instance: object, _: type | None = None) -> object:
        if instance is None:
            return self
        value = vars(instance)[self._name]
        if callable(value):  # threads that ask at once may each make it
            vars(instance)[self._name] = value = value()
        return value

    def __set__(self, instance: object, value: object) -> None:
        vars(instance)[self._name] = value


def _same_arrays(one: Any, other: Any) -> bool:
    import numpy as np

    both = hasattr(one, "dtype") and hasattr(other, "dtype")
    if not both or one.dtype != other.dtype or one.shape != other.shape:
        return False
    if one.dtype == object:
        return all(map(same, one.ravel().tolist(), other.ravel().tolist()))
    return bool(np.array_equal(one, other, equal_nan=one.dtype.kind == "f"))


# --- cached property ------------------------------------------------------------------------------
#
# A property that is computed once an instance, without a lock.
#
# Python 3.11's ``functools.cached_property`` holds one lock a property, for all instances, while
# the value is computed. Where that computation takes another lock, two threads can wait for each
# other for ever. Python 3.12's has no lock, and neither has this one. Threads that ask at the
# same time may compute the value several times; the first to come is kept, and all of them are
# given that one.


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


# --- recent ---------------------------------------------------------------------------------------
#
# What was made of an object, for as long as that object lives.


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


# --- memory ---------------------------------------------------------------------------------------
#
# What a computation will hold, told before it begins.


MOST_BYTES = 4 * 10**9


def refuse_too_much(
    source: str, key: str, value: object, count: int, size: int, words: str
) -> None:
    """Raise BadInput where ``count`` things of so many bytes, while they are made, are too much.

    ``words``: what they are, and what to do.
    """
    most = MOST_BYTES // size
    if count > most:
        raise BadInput(source, key, value, f"at most {most} {words}")

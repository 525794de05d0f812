"""Immutable values: equality, cached properties, a few kept last, memory."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar, cast
from weakref import WeakKeyDictionary

from polhode.common.errors import BadInput
from polhode.common.interrupts import Lock, LockPlace

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


def same(first: object, second: object) -> bool:
    """Whether two values are equal; arrays, lists and mappings by their elements, nan as itself."""
    if first is second:
        return True
    if isinstance(first, float) and isinstance(second, float):  # numpy's doubles are floats, too
        return first == second or (first != first and second != second)
    if hasattr(first, "dtype") or hasattr(second, "dtype"):
        return _same_arrays(first, second)
    if isinstance(first, (list, tuple)) and isinstance(second, (list, tuple)):
        alike = type(first) is type(second) and len(first) == len(second)
        return alike and all(map(same, first, second))
    if isinstance(first, Mapping):
        if not isinstance(second, Mapping) or first.keys() != second.keys():
            return False
        return all(same(first[key], second[key]) for key in first)
    return bool(first == second) or (first != first and second != second)


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


def _same_arrays(first: Any, second: Any) -> bool:
    import numpy as np

    both = hasattr(first, "dtype") and hasattr(second, "dtype")
    if not both or first.dtype != second.dtype or first.shape != second.shape:
        return False
    if first.dtype == object:
        return all(map(same, first.ravel().tolist(), second.ravel().tolist()))
    return bool(np.array_equal(first, second, equal_nan=first.dtype.kind == "f"))


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
            values = instance.__dict__
            value = values.get(self._name, _NOTHING)
            if value is _NOTHING:  # by now another thread's may be there
                value = values.setdefault(self._name, self.func(instance))
            return value


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
        self._lock = Lock(LockPlace.STORE)

    def get(self, owner: object, key: Hashable, make: Callable[[], T]) -> T:
        """The owner's value of a key, made where there is none."""
        values = self._kept.get(owner)
        value = None if values is None else values.get(key)
        if value is not None:
            return value
        new = make()
        with self._lock.held():
            values = self._kept.setdefault(owner, {})
            value = values.setdefault(key, new)  # another thread's may be there
            if len(values) > self._most:
                del values[next(iter(values))]
            return value


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

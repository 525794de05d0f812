"""Results as values: compared by what they hold, arrays included, and pickled as that alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import Any, ClassVar, TypeVar, cast

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

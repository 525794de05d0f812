"""A function of the package with one piece of its text replaced, for as long as a test lasts; and a
certificate with one value replaced."""

from __future__ import annotations

import copy
import inspect
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


@contextmanager
def without(module: Any, name: str, old: str, new: str) -> Iterator[None]:
    """``module.name``, or ``module.Class.name``, with ``old``, found there once, as ``new``."""
    owner, _, attribute = name.rpartition(".")
    home = getattr(module, owner) if owner else module
    kept = getattr(home, attribute)
    source = textwrap.dedent(inspect.getsource(kept))
    assert source.count(old) == 1, f"{name} no longer says {old!r} once"
    local: dict[str, Any] = {}
    exec(compile(source.replace(old, new), f"<{name}>", "exec"), module.__dict__, local)
    setattr(home, attribute, local[attribute])
    try:
        yield
    finally:
        setattr(home, attribute, kept)


def altered(given: Any, place: str, value: Any) -> Any:
    """A JSON value with another one at a place, or made of the one there.

    ``place``: keys and numbers, as ``statement start 0``.
    """
    found = parent = copy.deepcopy(given)
    *path, last = (int(key) if key.isdigit() else key for key in place.split())
    for key in path:
        parent = parent[key]
    parent[last] = value(parent[last]) if callable(value) else value
    return found

"""A function of the package with one piece of its text replaced, for as long as a test lasts."""

from __future__ import annotations

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

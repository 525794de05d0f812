"""A function of the package with one piece of its text replaced, for as long as a test lasts; and a
certificate with one value replaced."""

from __future__ import annotations

import copy
import inspect
import json
import tempfile
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import polhode


@contextmanager
def without(module: Any, name: str, old: str, new: str) -> Iterator[None]:
    """``module.name``, or ``module.Class.name``, with ``old``, found there once, as ``new``."""
    owner, _, attribute = name.rpartition(".")
    home = getattr(module, owner) if owner else module
    honest = getattr(home, attribute)
    source = textwrap.dedent(inspect.getsource(honest))
    assert source.count(old) == 1, f"{name} no longer says {old!r} once"
    local: dict[str, Any] = {}
    exec(compile(source.replace(old, new), f"<{name}>", "exec"), module.__dict__, local)
    setattr(home, attribute, local[attribute])
    try:
        yield
    finally:
        setattr(home, attribute, honest)


def altered(certificate: Any, place: str, value: Any) -> Any:
    """A JSON value with another one at a place, or made of the one there.

    ``place``: keys and numbers, as ``statement start 0``.
    """
    changed = parent = copy.deepcopy(certificate)
    *path, last = (int(key) if key.isdigit() else key for key in place.split())
    for key in path:
        parent = parent[key]
    parent[last] = value(parent[last]) if callable(value) else value
    return changed


def leaves(value: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Where the numbers and words of a JSON value stand."""
    if isinstance(value, (dict, list)):
        for key in value if isinstance(value, dict) else range(len(value)):
            yield from leaves(value[key], (*at, key))
    else:
        yield at


def answer(certificate: Any) -> str:
    """What is proved of it; or "refused: " and why nothing is."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "certificate.json"
        path.write_text(json.dumps(certificate))
        try:
            verdict = polhode.verify(path)
        except polhode.BadInput as fault:
            return f"refused: {fault}"
    return verdict.text if verdict.proved else f"refused: {verdict.text}"

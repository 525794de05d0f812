"""What a result does by rooms above its own: figures, files, tables of other packages.

A trajectory lies on a lower floor than what draws and writes it, and imports none of that.  Its
room says in a protocol what it asks for, and holds a slot for it; the package itself, which Python
imports before any room of it, fills the slots (``polhode/__init__.py``), and mypy checks that what
is put in keeps the protocol.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

P = TypeVar("P")


class Slot(Generic[P]):
    """A place for an object of a higher room, which is loaded when it is asked for."""

    def __init__(self) -> None:
        self._load: Callable[[], P] | None = None

    def provide(self, load: Callable[[], P]) -> None:
        """Say where the object comes from; nothing is imported yet."""
        self._load = load

    def get(self) -> P:
        """The object; raises RuntimeError where nobody provided it."""
        if self._load is None:
            raise RuntimeError("nothing was provided here: import polhode first")
        return self._load()

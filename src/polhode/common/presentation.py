"""What a result does by rooms above its own: figures, files, tables of other packages.

A trajectory lies on a lower floor than what draws and writes it, and imports none of that.  Its
room says in a protocol what it asks for, and has a slot for it, by a word; the package itself,
which Python imports before any room of it, says where each word's object comes from
(``polhode/__init__.py``), and ``output/presentation.py`` declares each as keeping the protocol.
"""

from __future__ import annotations

import sys
from typing import Generic, TypeVar

P = TypeVar("P")


class Slot(Generic[P]):
    """A place for an object of a higher room, which is loaded when it is asked for."""

    def __init__(self, word: str) -> None:
        self.word = word

    def get(self) -> P:
        """The object."""
        found: P = sys.modules["polhode"]._PRESENTATIONS[self.word]()
        return found

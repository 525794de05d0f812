"""What a result does by rooms above its own: figures, files, tables of other packages.

A trajectory lies on a lower floor than what draws and writes it, and imports none of that: its
methods name such a function, which is looked up here when it is called, and nowhere else.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any


def call(function: str, *arguments: Any, **named: Any) -> Any:
    """Call ``module:name`` below this package."""
    module, _, name = function.partition(":")
    return getattr(import_module(f"polhode.{module}"), name)(*arguments, **named)

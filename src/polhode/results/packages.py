"""Packages that not everybody has."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

from polhode.common.errors import BadInput


def needed(package: str, source: str = "tables") -> ModuleType:
    """A package by its name; raises BadInput, for ``source``, where it is missing."""
    try:
        return import_module(package)
    except ImportError:
        name = package.partition(".")[0]
        expected = f"it to be installed: pip install {name}"
        if name in ("pandas", "xarray"):
            expected = "it to be installed: pip install 'polhode[frames]'"
        raise BadInput(source, name, None, expected) from None

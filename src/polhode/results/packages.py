"""Packages that not everybody has."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

from polhode.common.errors import BadInput


def needed(package: str) -> ModuleType:
    """A package by its name; raises BadInput where it is missing."""
    try:
        return import_module(package)
    except ImportError:
        expected = "it to be installed: pip install 'polhode[frames]'"
        raise BadInput("tables", package, None, expected) from None

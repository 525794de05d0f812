"""Where a result comes from: versions, machine, the exact input."""

from __future__ import annotations

import hashlib
import platform
from functools import cache
from importlib import metadata
from typing import Any


def version() -> str:
    """polhode's version."""
    try:
        return metadata.version("polhode")
    except metadata.PackageNotFoundError:
        return "not installed"


@cache
def versions() -> dict[str, str]:
    """Versions of polhode, Python and the numerical libraries."""
    found = {"polhode": version(), "python": platform.python_version()}
    for package in ("heyoka", "numpy", "mpmath"):
        found[package] = metadata.version(package)
    return found


@cache
def cpu() -> str:
    """The processor's name, as the system tells it."""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            for line in lines:
                if line.startswith("model name"):
                    return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def digest(text: str) -> str:
    """A short fingerprint of a text: the first 16 hexadecimal digits of its SHA-256."""
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def provenance(source: str) -> dict[str, Any]:
    """Versions, processor and the fingerprint of the scene's text."""
    return {"versions": versions(), "cpu": cpu(), "case": digest(source)}

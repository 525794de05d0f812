"""What made a result, and how polhode is cited."""

from __future__ import annotations

import hashlib
import os
import platform
import sys
from functools import cache, lru_cache

# --- provenance -----------------------------------------------------------------------------------
#
# Where a result comes from: versions, machine, the exact input.


__version__ = "0.4.0"


@cache
def versions() -> dict[str, str]:
    """Versions of polhode, Python and the numerical libraries."""
    numbers = {"polhode": __version__, "python": platform.python_version()}
    for package in ("heyoka", "numpy", "mpmath", "python-flint"):
        loaded = sys.modules.get(package)  # its own word costs nothing; the metadata 3 ms each
        numbers[package] = getattr(loaded, "__version__", None) or _installed(package)
    return numbers


def _installed(package: str) -> str:
    # The name of its folder says it; importing metadata takes as long as a short run.
    stem = f"{package.replace('-', '_')}-"
    for place in sys.path:
        try:
            names = os.listdir(place or ".")
        except OSError:
            continue
        for name in names:
            if name.startswith(stem) and name.endswith(".dist-info"):
                return name.removeprefix(stem).removesuffix(".dist-info")
    from importlib import metadata

    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"


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


@lru_cache(maxsize=64)
def digest(text: str) -> str:
    """A short fingerprint of a text: the first 16 hexadecimal digits of its SHA-256."""
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def provenance(source: str) -> dict[str, object]:
    """Versions, processor and the fingerprint of the scene's text."""
    return {"versions": dict(versions()), "cpu": cpu(), "case": digest(source)}


# --- citation -------------------------------------------------------------------------------------
#
# How polhode is cited: ``polhode about --cite``; CITATION.cff says the same.


TITLE = "polhode: the heavy rigid body about a fixed point, with proven digits"
AUTHORS = "The polhode founders"
RELEASED = "2026-11-29"


def bibtex() -> str:
    """Entries for a bibliography: polhode, and heyoka, which it integrates with."""
    year = RELEASED[:4]
    return f"""\
@software{{polhode,
  author  = {{{{{AUTHORS}}}}},
  title   = {{{TITLE}}},
  version = {{{__version__}}},
  date    = {{{RELEASED}}},
  year    = {{{year}}}
}}

@article{{heyoka,
  author  = {{Biscani, Francesco and Izzo, Dario}},
  title   = {{Revisiting high-order Taylor methods for astrodynamics and celestial mechanics}},
  journal = {{Monthly Notices of the Royal Astronomical Society}},
  volume  = {{504}},
  number  = {{2}},
  pages   = {{2614--2628}},
  year    = {{2021}},
  doi     = {{10.1093/mnras/stab1032}}
}}
"""

"""polhode: the heavy rigid body about a fixed point, with proven digits.

>>> import polhode
>>> scene = polhode.load("euler/largest-axis")
>>> run = polhode.integrate(scene)
>>> run
<Trajectory of euler/largest-axis: double, 101 times to t = 100, reached end>
>>> 13 < polhode.compare(run).worst < 16
True
"""

from __future__ import annotations

from os import path as _path


def _homes() -> dict[str, str]:
    """The module of each public name, as ``__init__.pyi`` lists them."""
    with open(_path.join(_path.dirname(__file__), "__init__.pyi"), encoding="utf-8") as stub:
        lines = [line.split() for line in stub if line.startswith("from polhode.")]
    return {name: module for _, module, _, name, *_ in lines}


_HOMES = _homes()
__all__ = [*_HOMES]


def __getattr__(name: str) -> object:
    """Import on first use: a verb pays only for what it needs."""
    from importlib import import_module

    if name == "testing":
        return import_module("polhode.testing")
    if name not in _HOMES:
        raise AttributeError(f"module 'polhode' has no attribute {name!r}")
    found: object = getattr(import_module(_HOMES[name]), name)
    globals()[name] = found  # the next time it is found without this
    return found


def __dir__() -> list[str]:
    """What there is to use, and nothing else."""
    return sorted(__all__)

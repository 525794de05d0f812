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
#: Deprecated names, gone in 0.5: kinds of references, by the backend that makes them.
_BACKENDS = {"Certified": "certified", "Textbook": "mpmath"}


def __getattr__(name: str) -> object:
    """Import on first use: a verb pays only for what it needs."""
    from importlib import import_module

    if name == "testing":
        return import_module("polhode.testing")
    if name in _BACKENDS:
        from functools import partial
        from warnings import warn

        backend = _BACKENDS[name]
        words = f"polhode.{name}(scene) is polhode.reference(scene, {backend!r})"
        warn(words, DeprecationWarning, stacklevel=2)
        return partial(import_module("polhode.judging.reference").reference, backend=backend)
    if name not in _HOMES:
        raise AttributeError(f"module 'polhode' has no attribute {name!r}")
    value: object = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value  # the next time it is found without this
    return value


def __dir__() -> list[str]:
    """What there is to use, and nothing else."""
    return sorted(__all__)

"""polhode: the heavy rigid body about a fixed point, with proven digits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from polhode.body import Body
    from polhode.chaos import Lyapunov, lyapunov
    from polhode.conditioning import Conditioning, conditioning_of
    from polhode.ensemble import Ensemble, integrate_many
    from polhode.errors import BadInput
    from polhode.integration import integrate
    from polhode.judging import Judgement, compare
    from polhode.library import load
    from polhode.scene import Scene
    from polhode.trajectory import Outcome, Trajectory
    from polhode.truth import reference

_HOMES = {
    "Body": "body",
    "BadInput": "errors",
    "Conditioning": "conditioning",
    "Ensemble": "ensemble",
    "Judgement": "judging",
    "Lyapunov": "chaos",
    "Outcome": "trajectory",
    "Scene": "scene",
    "Trajectory": "trajectory",
    "__version__": "provenance",
    "compare": "judging",
    "conditioning_of": "conditioning",
    "integrate": "integration",
    "integrate_many": "ensemble",
    "load": "library",
    "lyapunov": "chaos",
    "reference": "truth",
}

__all__ = [*_HOMES]


def __getattr__(name: str) -> Any:
    """Import on first use: a verb pays only for what it needs."""
    from importlib import import_module

    if name not in _HOMES:
        raise AttributeError(f"module 'polhode' has no attribute {name!r}")
    return getattr(import_module(f"polhode.{_HOMES[name]}"), name)

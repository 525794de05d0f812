"""polhode: the heavy rigid body about a fixed point, with proven digits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from polhode.common.errors import BadInput
    from polhode.judging.conditioning import Conditioning, conditioning_of
    from polhode.judging.judgement import Judgement, compare
    from polhode.judging.lyapunov import Lyapunov, lyapunov
    from polhode.judging.reference import reference
    from polhode.runs.integrate import integrate
    from polhode.runs.sweep import Ensemble, integrate_many
    from polhode.runs.trajectory import Trajectory
    from polhode.scenes.body import Body
    from polhode.scenes.library import load
    from polhode.scenes.scene import Scene
    from polhode.taylor.outcomes import Outcome

_HOMES = {
    "BadInput": "common.errors",
    "Body": "scenes.body",
    "Conditioning": "judging.conditioning",
    "Ensemble": "runs.sweep",
    "Judgement": "judging.judgement",
    "Lyapunov": "judging.lyapunov",
    "Outcome": "taylor.outcomes",
    "Scene": "scenes.scene",
    "Trajectory": "runs.trajectory",
    "__version__": "common.provenance",
    "compare": "judging.judgement",
    "conditioning_of": "judging.conditioning",
    "integrate": "runs.integrate",
    "integrate_many": "runs.sweep",
    "load": "scenes.library",
    "lyapunov": "judging.lyapunov",
    "reference": "judging.reference",
}

__all__ = [*_HOMES]


def __getattr__(name: str) -> Any:
    """Import on first use: a verb pays only for what it needs."""
    from importlib import import_module

    if name not in _HOMES:
        raise AttributeError(f"module 'polhode' has no attribute {name!r}")
    return getattr(import_module(f"polhode.{_HOMES[name]}"), name)

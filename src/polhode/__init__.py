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

from typing import TYPE_CHECKING as _TYPE_CHECKING

if _TYPE_CHECKING:
    from polhode.common.errors import BadInput
    from polhode.common.provenance import __version__
    from polhode.dynamics.chaos_maps import ChaosMap, chaos_map
    from polhode.dynamics.frequencies import Frequencies, frequencies
    from polhode.dynamics.levels import Levels, levels
    from polhode.dynamics.sections import Section, section
    from polhode.enclosures.certify import certify
    from polhode.enclosures.events import CertifiedEvents, certify_events
    from polhode.enclosures.result import Enclosure
    from polhode.equations.plain import field
    from polhode.figures.drawing import Page, plot, view
    from polhode.judging.assured import integrate
    from polhode.judging.certified import Certified
    from polhode.judging.comparison import compare
    from polhode.judging.conditioning import Conditioning, conditioning
    from polhode.judging.judgement import Judgement
    from polhode.judging.lyapunov import Lyapunov, lyapunov
    from polhode.judging.reference import Reference, TwoPrecisions, reference
    from polhode.judging.rolling import Rolling, rolling
    from polhode.output.archive import load_run
    from polhode.runs.sweep import Ensemble, integrate_many
    from polhode.runs.trajectory import Trajectory
    from polhode.scenes.body import Body
    from polhode.scenes.from_numbers import top
    from polhode.scenes.library import load
    from polhode.scenes.scene import Event, Published, Scene, SectionPlan
    from polhode.scenes.scene_text import toml as as_toml
    from polhode.scenes.shapes import Part
    from polhode.taylor.outcomes import EventTimes, Outcome, Projection

_HOMES = {
    "BadInput": "common.errors",
    "Body": "scenes.body",
    "ChaosMap": "dynamics.chaos_maps",
    "CertifiedEvents": "enclosures.events",
    "Certified": "judging.certified",
    "Conditioning": "judging.conditioning",
    "Enclosure": "enclosures.result",
    "Ensemble": "runs.sweep",
    "Event": "scenes.scene",
    "EventTimes": "taylor.outcomes",
    "Frequencies": "dynamics.frequencies",
    "Judgement": "judging.judgement",
    "Levels": "dynamics.levels",
    "Lyapunov": "judging.lyapunov",
    "Outcome": "taylor.outcomes",
    "Page": "figures.drawing",
    "Part": "scenes.shapes",
    "Projection": "taylor.outcomes",
    "Published": "scenes.scene",
    "Reference": "judging.reference",
    "Rolling": "judging.rolling",
    "Scene": "scenes.scene",
    "Section": "dynamics.sections",
    "SectionPlan": "scenes.scene",
    "Trajectory": "runs.trajectory",
    "TwoPrecisions": "judging.reference",
    "__version__": "common.provenance",
    "as_toml": "scenes.scene_text:toml",
    "certify": "enclosures.certify",
    "certify_events": "enclosures.events",
    "chaos_map": "dynamics.chaos_maps",
    "compare": "judging.comparison",
    "conditioning": "judging.conditioning",
    "field": "equations.plain",
    "frequencies": "dynamics.frequencies",
    "integrate": "judging.assured",
    "integrate_many": "runs.sweep",
    "levels": "dynamics.levels",
    "load": "scenes.library",
    "load_run": "output.archive",
    "lyapunov": "judging.lyapunov",
    "plot": "figures.drawing",
    "reference": "judging.reference",
    "rolling": "judging.rolling",
    "top": "scenes.from_numbers",
    "view": "figures.drawing",
    "section": "dynamics.sections",
}

__all__ = [*_HOMES]


def __getattr__(name: str) -> object:
    """Import on first use: a verb pays only for what it needs."""
    from importlib import import_module

    if name not in _HOMES:
        raise AttributeError(f"module 'polhode' has no attribute {name!r}")
    home, _, own = _HOMES[name].partition(":")
    return getattr(import_module(f"polhode.{home}"), own or name)


def __dir__() -> list[str]:
    """What there is to use, and nothing else."""
    return sorted(__all__)

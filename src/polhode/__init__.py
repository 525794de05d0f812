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
    # `as`: mypy and pyright take these names, and no others, for exported
    from polhode.common.errors import BadInput as BadInput
    from polhode.common.page import Page as Page
    from polhode.common.provenance import __version__ as __version__
    from polhode.dynamics.chaos_maps import ChaosMap as ChaosMap
    from polhode.dynamics.chaos_maps import chaos_map as chaos_map
    from polhode.dynamics.frequencies import Frequencies as Frequencies
    from polhode.dynamics.frequencies import frequencies as frequencies
    from polhode.dynamics.levels import Levels as Levels
    from polhode.dynamics.levels import levels as levels
    from polhode.dynamics.orbit_families import OrbitFamily as OrbitFamily
    from polhode.dynamics.orbit_families import orbit_family as orbit_family
    from polhode.dynamics.orbit_search import OrbitSearch as OrbitSearch
    from polhode.dynamics.orbit_search import orbit_search as orbit_search
    from polhode.dynamics.orbits import Orbit as Orbit
    from polhode.dynamics.orbits import orbit as orbit
    from polhode.dynamics.reduce_many import Reductions as Reductions
    from polhode.dynamics.reduce_many import reduce_many as reduce_many
    from polhode.dynamics.sections import Section as Section
    from polhode.dynamics.sections import section as section
    from polhode.enclosures.certify import certify as certify
    from polhode.enclosures.events import CertifiedEvents as CertifiedEvents
    from polhode.enclosures.events import certify_events as certify_events
    from polhode.enclosures.result import Enclosure as Enclosure
    from polhode.equations.plain import field as field
    from polhode.figures.drawing import plot as plot
    from polhode.figures.drawing import view as view
    from polhode.judging.assured import integrate as integrate
    from polhode.judging.certified import Certified as Certified
    from polhode.judging.comparison import compare as compare
    from polhode.judging.conditioning import Conditioning as Conditioning
    from polhode.judging.conditioning import conditioning as conditioning
    from polhode.judging.judgement import Judgement as Judgement
    from polhode.judging.lyapunov import Lyapunov as Lyapunov
    from polhode.judging.lyapunov import lyapunov as lyapunov
    from polhode.judging.reference import Reference as Reference
    from polhode.judging.reference import reference as reference
    from polhode.judging.rolling import Rolling as Rolling
    from polhode.judging.rolling import rolling as rolling
    from polhode.judging.two_precisions import TwoPrecisions as TwoPrecisions
    from polhode.output.archive import load_run as load_run
    from polhode.runs.ensemble import Ensemble as Ensemble
    from polhode.runs.sweep import integrate_many as integrate_many
    from polhode.runs.trajectory import Trajectory as Trajectory
    from polhode.scenes.body import Body as Body
    from polhode.scenes.event import Event as Event
    from polhode.scenes.from_numbers import top as top
    from polhode.scenes.library import load as load
    from polhode.scenes.scene import Published as Published
    from polhode.scenes.scene import Scene as Scene
    from polhode.scenes.scene import SectionPlan as SectionPlan
    from polhode.scenes.scene_text import toml as as_toml
    from polhode.scenes.shapes import Part as Part
    from polhode.taylor.outcomes import EventTimes as EventTimes
    from polhode.taylor.outcomes import Outcome as Outcome
    from polhode.taylor.outcomes import Projection as Projection

_HOMES = {
    "BadInput": "common.errors",
    "Body": "scenes.body",
    "ChaosMap": "dynamics.chaos_maps",
    "CertifiedEvents": "enclosures.events",
    "Certified": "judging.certified",
    "Conditioning": "judging.conditioning",
    "Enclosure": "enclosures.result",
    "Ensemble": "runs.ensemble",
    "Event": "scenes.event",
    "EventTimes": "taylor.outcomes",
    "Frequencies": "dynamics.frequencies",
    "Judgement": "judging.judgement",
    "Levels": "dynamics.levels",
    "Lyapunov": "judging.lyapunov",
    "Orbit": "dynamics.orbits",
    "OrbitFamily": "dynamics.orbit_families",
    "OrbitSearch": "dynamics.orbit_search",
    "Outcome": "taylor.outcomes",
    "Page": "common.page",
    "Part": "scenes.shapes",
    "Projection": "taylor.outcomes",
    "Published": "scenes.scene",
    "Reductions": "dynamics.reduce_many",
    "Reference": "judging.reference",
    "Rolling": "judging.rolling",
    "Scene": "scenes.scene",
    "Section": "dynamics.sections",
    "SectionPlan": "scenes.scene",
    "Trajectory": "runs.trajectory",
    "TwoPrecisions": "judging.two_precisions",
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
    "orbit": "dynamics.orbits",
    "orbit_family": "dynamics.orbit_families",
    "orbit_search": "dynamics.orbit_search",
    "plot": "figures.drawing",
    "reduce_many": "dynamics.reduce_many",
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
    found: object = getattr(import_module(f"polhode.{home}"), own or name)
    globals()[name] = found  # the next time it is found without this
    return found


def __dir__() -> list[str]:
    """What there is to use, and nothing else."""
    return sorted(__all__)

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

TYPE_CHECKING = False  # typing's, which takes longer to import than all that is needed here

if TYPE_CHECKING:
    from collections.abc import Callable as _Callable

    from polhode import testing as testing

    # `as`: mypy and pyright take these names, and no others, for exported
    from polhode.certificates.verdict import Verdict as Verdict
    from polhode.certificates.verdict import verify as verify
    from polhode.closed_forms.families import register_family as register_family
    from polhode.common.errors import BadInput as BadInput
    from polhode.common.html_page import Page as Page
    from polhode.common.provenance import __version__ as __version__
    from polhode.common.result import Result as Result
    from polhode.dynamics.chaos.chaos_map import ChaosMap as ChaosMap
    from polhode.dynamics.chaos.chaos_map import chaos_map as chaos_map
    from polhode.dynamics.frequencies.frequencies import Frequencies as Frequencies
    from polhode.dynamics.frequencies.frequencies import frequencies as frequencies
    from polhode.dynamics.levels.levels import Levels as Levels
    from polhode.dynamics.levels.levels import levels as levels
    from polhode.dynamics.observables.reduce_many import Reductions as Reductions
    from polhode.dynamics.observables.reduce_many import reduce_many as reduce_many
    from polhode.dynamics.periodic_orbits.families import OrbitFamily as OrbitFamily
    from polhode.dynamics.periodic_orbits.families import orbit_family as orbit_family
    from polhode.dynamics.periodic_orbits.orbit import Orbit as Orbit
    from polhode.dynamics.periodic_orbits.orbit import orbit as orbit
    from polhode.dynamics.periodic_orbits.search import OrbitSearch as OrbitSearch
    from polhode.dynamics.periodic_orbits.search import orbit_search as orbit_search
    from polhode.dynamics.sections.section import Section as Section
    from polhode.dynamics.sections.section import section as section
    from polhode.enclosures.certify import certify as certify
    from polhode.enclosures.events import CertifiedEvents as CertifiedEvents
    from polhode.enclosures.events import certify_events as certify_events
    from polhode.enclosures.result import Enclosure as Enclosure
    from polhode.enclosures.variations.flow_derivative import FlowDerivative as FlowDerivative
    from polhode.equations.plain_field import field as field
    from polhode.figures.drawing import plot as plot
    from polhode.figures.drawing import view as view
    from polhode.judging.adaptive_precision import integrate as integrate
    from polhode.judging.conditioning.conditioning import Conditioning as Conditioning
    from polhode.judging.conditioning.conditioning import conditioning as conditioning
    from polhode.judging.conditioning.lyapunov import Lyapunov as Lyapunov
    from polhode.judging.conditioning.lyapunov import lyapunov as lyapunov
    from polhode.judging.references.certified import Certified as Certified
    from polhode.judging.references.reference import Reference as Reference
    from polhode.judging.references.reference import reference as reference
    from polhode.judging.references.two_precisions import TwoPrecisions as TwoPrecisions
    from polhode.judging.rolling_cones import Rolling as Rolling
    from polhode.judging.rolling_cones import rolling as rolling
    from polhode.judging.score.compare import compare as compare
    from polhode.judging.score.judgement import Judgement as Judgement
    from polhode.motion.outcomes import EventTimes as EventTimes
    from polhode.motion.outcomes import Outcome as Outcome
    from polhode.motion.outcomes import Projection as Projection
    from polhode.output.archive import load_run as load_run
    from polhode.output.results.files import load_result as load_result
    from polhode.proofs.chaos.prove_chaos import prove_chaos as prove_chaos
    from polhode.proofs.prove_orbit import prove_orbit as prove_orbit
    from polhode.proofs.proved_orbit import ProvedOrbit as ProvedOrbit
    from polhode.proofs.refusals import NotProved as NotProved
    from polhode.runs.propagator import Propagator as Propagator
    from polhode.runs.propagator import propagator as propagator
    from polhode.runs.sweep.ensemble import Ensemble as Ensemble
    from polhode.runs.sweep.integrate_many import integrate_many as integrate_many
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

_HOMES = {
    "BadInput": "common.errors",
    "Body": "scenes.body",
    "ChaosMap": "dynamics.chaos.chaos_map",
    "CertifiedEvents": "enclosures.events",
    "Certified": "judging.references.certified",
    "Conditioning": "judging.conditioning.conditioning",
    "Enclosure": "enclosures.result",
    "Ensemble": "runs.sweep.ensemble",
    "Event": "scenes.event",
    "EventTimes": "motion.outcomes",
    "FlowDerivative": "enclosures.variations.flow_derivative",
    "Frequencies": "dynamics.frequencies.frequencies",
    "Judgement": "judging.score.judgement",
    "Levels": "dynamics.levels.levels",
    "Lyapunov": "judging.conditioning.lyapunov",
    "NotProved": "proofs.refusals",
    "Orbit": "dynamics.periodic_orbits.orbit",
    "OrbitFamily": "dynamics.periodic_orbits.families",
    "OrbitSearch": "dynamics.periodic_orbits.search",
    "Outcome": "motion.outcomes",
    "Page": "common.html_page",
    "Part": "scenes.shapes",
    "Projection": "motion.outcomes",
    "Propagator": "runs.propagator",
    "ProvedOrbit": "proofs.proved_orbit",
    "Published": "scenes.scene",
    "Reductions": "dynamics.observables.reduce_many",
    "Reference": "judging.references.reference",
    "Rolling": "judging.rolling_cones",
    "Result": "common.result",
    "Scene": "scenes.scene",
    "Section": "dynamics.sections.section",
    "SectionPlan": "scenes.scene",
    "Trajectory": "runs.trajectory",
    "TwoPrecisions": "judging.references.two_precisions",
    "Verdict": "certificates.verdict",
    "__version__": "common.provenance",
    "as_toml": "scenes.scene_text:toml",
    "certify": "enclosures.certify",
    "certify_events": "enclosures.events",
    "chaos_map": "dynamics.chaos.chaos_map",
    "compare": "judging.score.compare",
    "conditioning": "judging.conditioning.conditioning",
    "field": "equations.plain_field",
    "frequencies": "dynamics.frequencies.frequencies",
    "integrate": "judging.adaptive_precision",
    "integrate_many": "runs.sweep.integrate_many",
    "levels": "dynamics.levels.levels",
    "load": "scenes.library",
    "load_result": "output.results.files",
    "load_run": "output.archive",
    "lyapunov": "judging.conditioning.lyapunov",
    "orbit": "dynamics.periodic_orbits.orbit",
    "orbit_family": "dynamics.periodic_orbits.families",
    "orbit_search": "dynamics.periodic_orbits.search",
    "plot": "figures.drawing",
    "prove_chaos": "proofs.chaos.prove_chaos",
    "prove_orbit": "proofs.prove_orbit",
    "propagator": "runs.propagator",
    "reduce_many": "dynamics.observables.reduce_many",
    "reference": "judging.references.reference",
    "register_family": "closed_forms.families",
    "rolling": "judging.rolling_cones",
    "top": "scenes.from_numbers",
    "verify": "certificates.verdict",
    "view": "figures.drawing",
    "section": "dynamics.sections.section",
}

__all__ = [*_HOMES]


def _presentation(name: str) -> _Callable[[], object]:
    """Loads what results of lower rooms do by higher ones, see polhode.common.presentation."""

    def load() -> object:
        from polhode.output import presentation

        return getattr(presentation, name)

    return load


#: Where common.presentation finds what results of lower rooms do by higher ones, by its words.
_PRESENTATIONS = {
    "scenes": _presentation("SCENES"),
    "runs": _presentation("RUNS"),
    "reevaluation": _presentation("REEVALUATION"),
    "results": _presentation("RESULTS"),
}


def __getattr__(name: str) -> object:
    """Import on first use: a verb pays only for what it needs."""
    from importlib import import_module

    if name == "testing":
        return import_module("polhode.testing")
    if name not in _HOMES:
        raise AttributeError(f"module 'polhode' has no attribute {name!r}")
    home, _, own = _HOMES[name].partition(":")
    found: object = getattr(import_module(f"polhode.{home}"), own or name)
    globals()[name] = found  # the next time it is found without this
    return found


def __dir__() -> list[str]:
    """What there is to use, and nothing else."""
    return sorted(__all__)

"""One result of every kind, each made once."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction

import polhode
from polhode.checks.check_report import check_cases
from polhode.judging.convergence_order import ObservedOrder
from polhode.output.about import about
from polhode.output.cases import cases
from polhode.output.description import describe
from polhode.results.result import Storable

TOP = "lagrange/nutation"


def watched() -> polhode.Scene:
    """With an event."""
    return replace(polhode.load(TOP), events=(polhode.Event("nutation"),))


MAKERS: dict[str, Callable[[], Storable]] = {
    "About": about,
    "Cases": lambda: cases("euler"),
    "Description": lambda: describe("kovalevskaya/delaunay"),
    "Description in other axes": lambda: describe("euler/turned-axes"),
    "CheckReport": lambda: check_cases(["euler/rest", "published/orekit"], number=["double"]),
    "CheckReport of bands": lambda: check_cases(["euler/sphere"], propose=True),
    "Trajectory": lambda: polhode.integrate(TOP, at=[1, 2]),
    "Trajectory in quad": lambda: polhode.integrate(TOP, at=[1], number="quad"),
    "Reference": lambda: polhode.reference(polhode.load("euler/largest-axis").at((1, 2))),
    "Certified": lambda: polhode.reference(polhode.load("general/asymmetric-regular").at((1,))),
    "ReferenceTable": lambda: polhode.reference_table("euler/largest-axis", at=[1, "7/3"]),
    "Textbook": lambda: polhode.reference(polhode.load(TOP).at((1,)), backend="mpmath"),
    "Conditioning": lambda: polhode.conditioning("euler/separatrix", [10, 120]),
    "Enclosure": lambda: polhode.certify("euler/largest-axis", at=[1, 2], digits=20),
    "CertifiedEvents": lambda: polhode.certify_events(watched(), end=2)[0],
    "EventTimes": lambda: polhode.integrate(watched(), at=[10], number="extended").events[0],
    "Judgement": lambda: polhode.compare(polhode.integrate("euler/separatrix", at=[1, 20])),
    "Ensemble": lambda: polhode.integrate_many(TOP, {"start.omega[3]": "2:4:3"}, at=[0, 1]),
    "Ensemble of arrays": lambda: polhode.integrate_many(TOP, starts=[[1, 0, 2, 0, 0, 1]], at=[1]),
    "Reductions": lambda: polhode.reduce_many(
        TOP, {"start.omega[3]": "2:4:3"}, keep=["final"], number="extended"
    ),
    "Reductions of events": lambda: polhode.reduce_many(
        watched(), {"start.omega[1]": "0.5:1:2"}, keep=["first nutation"], at=[2]
    ),
    "Section": lambda: polhode.section(TOP, starts=[[1, 0.2]], crossings=6),
    "ChaosMap": lambda: polhode.chaos_map(TOP, grid=(3, 3), end=20),
    "ChaosMap of starts": lambda: polhode.chaos_map(
        TOP, starts=[[1, 0, 2, 0, 0, 1], [1, 0, 3, 0, 0, 1]], end=20
    ),
    "Levels": lambda: polhode.levels("general/asymmetric-chaotic"),
    "Frequencies": lambda: polhode.frequencies(TOP, of=["gamma3"], end=100),
    "OrbitSearch": lambda: polhode.orbit_search("general/asymmetric-regular", (4, 4), crossings=1),
    "Orbit to 5 digits": lambda: polhode.orbit("grioli/precession", digits=5),
    "Orbit": lambda: polhode.orbit("grioli/precession", digits=20),
    "ProvedOrbit": lambda: polhode.prove_orbit("grioli/precession"),
    "ProvedOrbits": lambda: polhode.prove_orbits("general/asymmetric-regular", (4, 4), crossings=1),
    "ProvedStability": lambda: polhode.prove_stability("general/asymmetric-regular"),
    "ProvedChaos": lambda: polhode.prove_chaos("general/asymmetric-chaotic"),
    "Verdict": lambda: polhode.Verdict(False, "not proved: the condition of the step"),
    "Lyapunov": lambda: polhode.lyapunov("euler/largest-axis", 200),
    "Lyapunov of all": lambda: polhode.lyapunov("euler/largest-axis", 20, spectrum=True),
    "ObservedOrder": lambda: ObservedOrder(
        (4.0, 2.0, 1.0), (Fraction(1, 3), Fraction(2)), ((4.0, 3.0), (5.2, 4.1), (6.4, 5.2)), 12.0
    ),
    "Report": lambda: polhode.report(TOP, at=[1, 2], number="double"),
    "OrbitFamily": lambda: polhode.orbit_family("grioli/precession", "h", "0.752"),
}
#: Whose JSON is its certificate.
CERTIFIED = ("Certified", "Enclosure", "ProvedChaos", "ProvedOrbit", "ProvedStability")


@functools.cache
def result_of_kind(name: str) -> Storable:
    """That of MAKERS."""
    return MAKERS[name]()

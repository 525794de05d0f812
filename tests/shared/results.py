"""One result of every kind, each made once."""

import functools
import shlex
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import polhode
from polhode.checks.check_report import check_cases
from polhode.cli import main
from polhode.judging.convergence_order import ObservedOrder, order_between
from polhode.output.about import about
from polhode.output.cases import cases
from polhode.output.description import describe
from polhode.proofs.proved_chaos import ProvedChaos
from polhode.results.result import Storable
from polhode.verbs.catalogue import ROWS, VERBS, Verb

TOP = "lagrange/nutation"
GENERAL = "general/asymmetric-regular"
GRIOLI = "grioli/precession"


def watched() -> polhode.Scene:
    """With an event."""
    return replace(polhode.load(TOP), events=(polhode.Event("nutation"),))


def proved_chaos() -> ProvedChaos:
    """As a proof of minutes gives it, of numbers that nobody proved."""
    orbit = result_of_kind("ProvedOrbit")
    numbers = {"short": 3.0, "long": 4.0, "entropy": 0.1, "tries": 1, "seconds": 1.0, "size": 1e-3}
    numbers |= {"coverings": 20, "sets": 19, "stretch": 1.5, "height": 0.5, "cone": 0.25}
    names = ("scene", "h", "f", "certificate", "provenance")
    numbers |= {name: getattr(orbit, name) for name in names}
    return ProvedChaos(orbit=orbit, **numbers, guess=None, images=())


MAKERS: dict[str, Callable[[], Storable]] = {
    "About": lambda: about(cite=True),
    "Cases": lambda: cases("chaotic"),
    "Description": lambda: describe(TOP),
    "Description in other axes": lambda: describe("euler/turned-axes"),
    "CheckReport": lambda: check_cases(["euler/rest"]),
    "CheckReport of bands": lambda: check_cases(["euler/sphere"], propose=True),
    "Trajectory": lambda: polhode.integrate(TOP, at=[1, 2]),
    "Trajectory in quad": lambda: polhode.integrate(TOP, at=[1], number="quad"),
    "Reference": lambda: polhode.reference(polhode.load("euler/largest-axis").at((1, 2))),
    "Certified": lambda: polhode.reference(polhode.load(GENERAL).at((1,))),
    "ReferenceTable": lambda: polhode.reference_table("euler/separatrix", at=[1], digits=40),
    "Textbook": lambda: polhode.reference(
        polhode.load("euler/largest-axis").at((1,)), backend="mpmath"
    ),
    "Conditioning": lambda: polhode.conditioning("euler/separatrix", [10, 120]),
    "Enclosure": lambda: polhode.certify(polhode.load(GENERAL).at([1]), digits=20),
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
    "Section": lambda: polhode.section(GENERAL, grid=(2, 2), crossings=3),
    "ChaosMap": lambda: polhode.chaos_map(GENERAL, (2, 2), end=20),
    "ChaosMap of starts": lambda: polhode.chaos_map(
        TOP, starts=[[1, 0, 2, 0, 0, 1], [1, 0, 3, 0, 0, 1]], end=20
    ),
    "Levels": lambda: polhode.levels(GENERAL),
    "Frequencies": lambda: polhode.frequencies(TOP, ["gamma3"], 50),
    "OrbitSearch": lambda: polhode.orbit_search(GENERAL, (4, 4), crossings=1),
    "Orbit to 5 digits": lambda: polhode.orbit(GRIOLI, digits=5),
    "Orbit": lambda: polhode.orbit(GRIOLI, digits=20),
    "ProvedOrbit": lambda: polhode.prove_orbit(GRIOLI),
    "ProvedOrbits": lambda: polhode.prove_orbits(GENERAL, (4, 4), crossings=1),
    "ProvedStability": lambda: polhode.prove_stability(GENERAL),
    "ProvedChaos": proved_chaos,
    "FieldComparison": lambda: polhode.compare_field(polhode.field(TOP), TOP),
    "Verdict": lambda: polhode.Verdict(False, "not proved: the condition of the step"),
    "Lyapunov": lambda: polhode.lyapunov("euler/largest-axis", 200),
    "Lyapunov of all": lambda: polhode.lyapunov("euler/largest-axis", 20, spectrum=True),
    "ObservedOrder": lambda: ObservedOrder(
        *((4.0, 2.0, 1.0), (Fraction(1, 3), Fraction(2)), ((4.0, 3.0), (5.2, 4.1), (6.4, 5.2))),
        ((False, False),) * 3,
    ),
    "Report": lambda: polhode.report(TOP, at=[1, 2], number="double"),
    "OrbitFamily": lambda: polhode.orbit_family(GRIOLI, "h", "0.84"),
}
#: Whose JSON is its certificate.
CERTIFIED = ("Certified", "Enclosure", "ProvedChaos", "ProvedOrbit", "ProvedStability")


@functools.cache
def result_of_kind(name: str) -> Storable:
    """That of MAKERS."""
    return MAKERS[name]()


# -- the examples of all verbs, which --help prints, and the files that they read

#: Whose answer is a result.
WITH_RESULT = {verb.name for verb in ROWS if verb.kind}
EXAMPLES = {verb.name: verb.command.removeprefix("polhode ") for verb in ROWS}


def order_of(names: Sequence[str], steps: Sequence[str]) -> ObservedOrder:
    """The order of convergence that tables of a motion with such steps show."""
    return order_between([polhode.compare(Path(name), TOP) for name in names], steps)


def verb_of(command: str) -> Verb:
    """The row of a command's verb, of two words if there is one."""
    first, second = f"{command} ".split(" ")[:2]
    return VERBS.get(f"{first} {second}") or VERBS[first]


def without_files(command: str) -> str:
    """A command without its -o."""
    return command.partition(" -o ")[0]


def prepare(command: str) -> None:
    """Make the files that a command reads, in the current folder: those that other examples write,
    and two tables of another program."""
    words = shlex.split(without_files(command))
    for verb in ("new", "run", "certify"):
        *_, name = shlex.split(EXAMPLES[verb]) if verb != "new" else [EXAMPLES[verb].split()[1]]
        if name in words and verb_of(command).name != verb and not Path(name).exists():
            prepare(EXAMPLES[verb])
            assert main(shlex.split(EXAMPLES[verb])) == 0
    for name, digits in (("coarse.csv", 3), ("fine.csv", 5)):
        if name in words:
            run = polhode.integrate(TOP, at=[1, 2, 3])
            cells = [[repr(float(x) + 10.0**-digits) for x in row] for row in run.states]
            rows = [f"{t},{','.join(row)}" for t, row in zip("123", cells, strict=True)]
            Path(name).write_text("\n".join(["t,p,q,r,gamma1,gamma2,gamma3", *rows, ""]))

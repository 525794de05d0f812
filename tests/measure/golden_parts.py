"""The parts of the golden comparison: what is computed, by the doors that a user has.

Nothing here names a module inside polhode: the same file runs on the code before a change and after
it.  An entry is a function without arguments that gives a record; what it is refused with is part
of it.
"""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import tempfile
import zlib
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

from golden_record import told

import polhode

TOP = Path(__file__).parents[2]
CASES = sorted(
    p.relative_to(TOP / "cases").with_suffix("").as_posix() for p in (TOP / "cases").rglob("*.toml")
)

Entry = Callable[[], Any]
Entries = Iterator[tuple[str, Entry]]

#: By what a run's end is a multiple of the time of about a radian: below all of the lengths from
#: which on attitude, angles and events are had beside the run; above that of angles; above all.
LENGTHS = {"short": 12, "middle": 180, "long": 1800}
OUTPUTS: dict[str, tuple[str, ...]] = {
    "plain": (),
    "attitude": ("attitude",),
    "angles": ("angles",),
    "both": ("attitude", "angles", "hodographs"),
    "events": (),
}
#: Of each kind that is found in its own way: quiet ones, one that ends the run, one that tells the
#: time, those known by name.
EVENTS = (
    (polhode.Event("level", "gamma3 - p/10"), polhode.Event("nutation")),
    (polhode.Event("first", "q - r/3", "rising", stop=True),),
    (polhode.Event("late", "gamma1/(2 + gamma2) - t/100", "falling"),),
    (polhode.Event("equator"), polhode.Event("section:q"), polhode.Event("flip")),
)
MAX_STEPS = 20_000
WIDE = 30  # cases in quad and mp
WIDE_LENGTH = {"auto": 180, "taylor": 12}


def recorded(entry: Entry) -> Any:
    """What an entry gives, or the class and message of its refusal."""
    try:
        return told(entry())
    except Exception as fault:
        if isinstance(fault, Broken):
            raise
        return {"refused": [type(fault).__name__, str(fault)]}


class Broken(Exception):
    """The comparison itself did not do what it is for."""


def taken(value: Any, names: str) -> dict[str, Any] | None:
    """Some attributes of a value by name."""
    return None if value is None else {name: getattr(value, name) for name in names.split()}


def mark(name: str) -> int:
    """A number that depends on the name alone, so that a new case moves no other one."""
    return zlib.crc32(name.encode())


# --- single runs


def unit(scene: polhode.Scene) -> Fraction:
    """The time of about a radian of the start's fastest rate, a power of two."""
    try:
        torque = abs(float(scene.body.weight)) * math.hypot(*map(float, scene.body.centre))
        rate = max(
            math.hypot(*map(float, scene.omega)),
            math.sqrt(torque / max(map(float, scene.body.moments))),
        )
    except OverflowError:
        rate = 1.0
    return Fraction(2) ** -round(math.log2(rate)) if 0 < rate < math.inf else Fraction(1)


def times(scene: polhode.Scene, length: int, backward: bool) -> list[Fraction]:
    """Three times, a third of which no binary number is."""
    end = unit(scene) * (-length if backward else length)
    return [end * Fraction(3, 8), end * Fraction(2, 3), end]


def of_run(run: polhode.Trajectory) -> dict[str, Any]:
    """All that a trajectory holds but who made it, and how long that took."""
    return {
        "bits": run.number.bits,
        **taken(run, "times states attitude angles hodographs outcome steps reached tolerance"),
        **taken(run, "method errors digits correct_digits checked_by drift"),
        "projection": taken(run.projection, "onto every count largest sum"),
        "events": [taken(one, "name times states grazing complete") for one in run.events],
    }


def asked(case: str, outputs: str) -> polhode.Scene:
    """A case with other outputs and events."""
    scene, events = polhode.load(case), ()
    if outputs == "events":
        events = EVENTS[mark(case) % len(EVENTS)]
        a, b, c = scene.body.moments
        if a == b or b == c or c == a:  # no middle axis
            events = tuple(event for event in events if event.name != "flip")
    return replace(scene, outputs=OUTPUTS[outputs], events=events)


def run(case: str, outputs: str, project: bool, number: str) -> dict[str, Any]:
    """A case at three lengths; one of them backward in some cases."""
    scene = asked(case, outputs)
    backward = {2: "short", 3: "middle", 4: "long"}.get(mark(case) // 7 % 8)
    found = {}
    for name, length in LENGTHS.items():
        at = times(scene, length, name == backward)
        found[name] = recorded(partial(one_run, scene, at, number, project))
    return found


def one_run(scene: polhode.Scene, at: list[Fraction], number: str, project: bool) -> dict[str, Any]:
    made = polhode.integrate(scene, number, at=at, project=project, max_steps=MAX_STEPS)
    found = of_run(made)
    if made.outcome.done and len(made.times) == len(at):  # what is made again, between the times
        found["between"] = recorded(lambda: made([at[0] / 3, at[2] - at[1] / 7]))
    return found


def wide_run(case: str, outputs: str, number: str, method: str) -> dict[str, Any]:
    scene = asked(case, outputs)
    at = times(scene, WIDE_LENGTH[method], mark(case) % 5 == 0)
    made = polhode.integrate(scene, number, at=at, method=method, max_steps=MAX_STEPS)
    return of_run(made) | {"between": recorded(lambda: made(at[1] / 3))}


def runs(number: str) -> Entries:
    for case in CASES:
        for outputs in OUTPUTS:
            for project in (False, True):
                key = f"{case} {outputs}{' project' * project}"
                yield key, partial(run, case, outputs, project, number)


def wide_runs(number: str) -> Entries:
    words = list(OUTPUTS)
    for k in range(WIDE):
        case, outputs = CASES[len(CASES) * k // WIDE], words[k % len(words)]
        method = "taylor" if k % 3 == 2 else "auto"
        yield f"{case} {outputs} {method}", partial(wide_run, case, outputs, number, method)


def again() -> Entries:
    """Attitude and angles at other times, expected digits, and runs of so many digits."""
    for case in CASES[::12]:
        scene = asked(case, "plain")
        for name in ("short", "long"):
            at = times(scene, LENGTHS[name], False)

            def later(scene: polhode.Scene = scene, at: list[Fraction] = at) -> dict[str, Any]:
                made = polhode.integrate(scene, at=at, max_steps=MAX_STEPS)
                return {
                    "attitude": recorded(lambda: made.attitude_at(at[1] / 3)),
                    "angles": recorded(lambda: made.angles_at([at[1] / 3, at[0]])),
                    "expected": recorded(lambda: made.expected),
                }

            yield f"{case} {name}", later
    for case, digits in (
        ("euler/attitude", 20),
        ("general/asymmetric-chaotic", 12),
        ("hess/turned-axes", 40),
    ):
        yield f"{case} {digits} digits", partial(of_digits, case, digits)


def of_digits(case: str, digits: int) -> dict[str, Any]:
    return of_run(polhode.integrate(case, digits=digits, at=[1, "7/3", 10]))


# --- closed forms


def closed_form(case: str) -> dict[str, Any]:
    """At 30 digits, at times from one to a thousand million."""
    exact = polhode.reference(case)
    found: dict[str, Any] = taken(exact, "kind regime") or {}
    if not exact.is_closed_form:
        return found
    for t in (1, 1000, 10**9):
        found[f"t = {t}"] = {
            "states": recorded(lambda t=t: exact.at([t], 30)),
            "attitude": recorded(lambda t=t: exact.attitude([t], 30)),
            "angles": recorded(lambda t=t: exact.angles([t], 30)),
        }
    for name in ("period", "frequencies"):
        found[name] = recorded(partial(getattr, exact, name))
    return found | {"bits": 100}


def closed_forms() -> Entries:
    for case in CASES:
        yield case, partial(closed_form, case)


# --- sweeps


GRID = {"start.omega[3]": "2:4:5", "body.weight": [1, "3/2", 0.1]}
SPUN = {"start.omega[1]": "0.1:0.9:40", "start.omega[2]": ["0", "0.3"]}
LISTED = [{"start.omega[1]": "0.3"}, {"start.omega[1]": 1}, {"start.omega[1]": 0.7}]
SWEEPS: dict[str, tuple[str, Any, dict[str, Any]]] = {
    "a grid": ("lagrange/nutation", GRID, {"at": [0, 1, 40]}),
    "many long ones": ("general/asymmetric-regular", SPUN, {"at": [7, 500]}),
    "backward, listed": ("kovalevskaya/generic", LISTED, {"at": [-1, "-31/3"]}),
    "a tolerance": ("euler/largest-axis", LISTED, {"at": [10], "tol": "1e-9"}),
    "a step limit": ("lagrange/nutation", GRID, {"at": [1, 5, 40], "max_steps": 40}),
    "extended": ("general/asymmetric-regular", LISTED, {"at": [1, 50], "number": "extended"}),
    "quad, refined": ("general/asymmetric-regular", LISTED, {"at": [1, 200], "number": "quad"}),
    "quad": ("grioli/precession", LISTED, {"at": [1, 9], "number": "quad", "method": "taylor"}),
    "40 digits": ("lagrange/nutation", GRID, {"at": [1, 2], "digits": 40}),
    "no such key": ("lagrange/nutation", {"start.omga[3]": "2:4:3"}, {}),
}
KEPT: dict[str, tuple[list[str], dict[str, Any]]] = {
    "kept numbers": (["largest theta", "smallest gamma3", "final"], {"at": range(1, 60)}),
    "kept events": (["first nutation", "first equator"], {"at": [30]}),
    "kept exponents": (["lyapunov"], {"at": [100, 200]}),
}
LONG = {"start.omega[1]": "0.1:0.9:300"}


def of_sweep(many: polhode.Ensemble) -> dict[str, Any]:
    return {
        "bits": many.number.bits,
        "members": len(many),
        **taken(many, "times states outcomes steps reached errors drift"),
    }


def sweep(name: str) -> dict[str, Any]:
    case, varied, options = SWEEPS[name]
    return of_sweep(polhode.integrate_many(case, varied, workers=1, **options))


def kept(name: str) -> dict[str, Any]:
    keep, options = KEPT[name]
    found = polhode.reduce_many("lagrange/nutation", GRID, keep, workers=1, **options)
    return {
        "numbers": {one: found[one] for one in found.names},
        **taken(found, "endings counts"),
    }


def long_sweep(folder: Path, progress: Callable[[float, int], None] | None) -> dict[str, Any]:
    """One that takes a few seconds, so that something is kept on the way."""
    case, at = "general/asymmetric-regular", [100, 4000]
    return of_sweep(
        polhode.integrate_many(
            case, LONG, at=at, number="extended", workers=1, parts=folder, progress=progress
        )
    )


def killed_sweep() -> dict[str, Any]:
    """The same sweep, killed on its way in another process and continued in this one."""
    with tempfile.TemporaryDirectory() as above:
        folder = Path(above) / "parts"
        done = subprocess.run([sys.executable, __file__, str(folder)], check=False)
        if done.returncode != -signal.SIGKILL:
            raise Broken(f"the sweep that is to be killed ended by itself: {done.returncode}")
        return long_sweep(folder, None)


def die_early(folder: Path) -> None:
    """Kill this process once the sweep has kept members, and before it ends."""

    def tell(done: float, _: int) -> None:
        size = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
        if done < 0.9 and size > 5000:
            os.kill(os.getpid(), signal.SIGKILL)

    long_sweep(folder, tell)


def sweeps() -> Entries:
    for name in SWEEPS:
        yield name, partial(sweep, name)
    for name in KEPT:
        yield name, partial(kept, name)
    yield "killed and continued", killed_sweep


# --- the top as a dynamical system


SECTIONS: dict[str, dict[str, Any]] = {
    "momentum": {"grid": (3, 3), "h": 3, "f": "1/2"},
    "height, least": {"by": "height", "extremum": "min", "grid": (2, 3), "h": 3, "f": "1/2"},
    "an expression": {"by": "q", "grid": (2, 2), "h": 2, "f": "0.3"},
    "its own start": {"starts": "scene"},
    "no such level": {"grid": (2, 2), "h": -100},
}
OF_SECTION = (
    "starts start_states states times rests l ratio counts outcomes drift digits none_left_from"
)
OF_MAP = "keys shape at cell verdict fli megno growth exponent until end counts"
OF_ORBIT = (
    "h f digits period error residue residue_error determinant psi psi_whole moved corrections"
    " kind multipliers turns"
)


def sections() -> Entries:
    for name, options in SECTIONS.items():

        def cut(options: dict[str, Any] = options) -> Any:
            case = "general/asymmetric-chaotic"
            return taken(polhode.section(case, crossings=20, workers=1, **options), OF_SECTION)

        yield name, cut


def maps() -> Entries:
    def of_grid() -> Any:
        case = "general/asymmetric-chaotic"
        return taken(polhode.chaos_map(case, (5, 4), h=3, f="1/2", workers=1), OF_MAP)

    def of_varied() -> Any:
        case, varied = "lagrange/nutation", {"start.omega[3]": "1:3:4", "body.weight": "1:2:3"}
        return taken(polhode.chaos_map(case, varied=varied, end=500, workers=1), OF_MAP)

    yield "a grid", of_grid
    yield "two numbers varied", of_varied


def of_orbit(found: polhode.Orbit) -> dict[str, Any]:
    start = {"omega": found.scene.omega, "gamma": found.scene.gamma}
    return {"start": start, **taken(found, OF_ORBIT), "bits": 100}


def orbits() -> Entries:
    yield "grioli", lambda: of_orbit(polhode.orbit("grioli/precession", 25))
    yield "no orbit", lambda: of_orbit(polhode.orbit("general/asymmetric-chaotic", returns=2))
    yield (
        "search",
        lambda: taken(
            polhode.orbit_search("general/asymmetric-regular", (8, 8), 2), "orbits guesses"
        ),
    )
    yield (
        "family",
        lambda: taken(
            polhode.orbit_family("grioli/precession", "h", "0.7"), "points bifurcations ended"
        ),
    )


def of_levels(case: str) -> dict[str, Any]:
    found = polhode.levels(case)
    return {
        **taken(found, "curves marks here exact"),
        "regions": {f: recorded(lambda f=f: found.regions(f)) for f in ("0", "1/2", "3")},
    }


def levels() -> Entries:
    for case in (*CASES[::20], "general/asymmetric-regular", "kovalevskaya/delaunay"):
        yield case, partial(of_levels, case)


def of_frequencies(case: str, options: dict[str, Any]) -> Any:
    return taken(polhode.frequencies(case, **options), "end samples lines known closed_form step")


def frequencies() -> Entries:
    for case in ("lagrange/nutation", "euler/attitude", "general/asymmetric-regular"):
        for options in ({"lines": 3, "end": 200}, {"of": ["gamma3", "axis"], "lines": 2}):
            yield f"{case} {options}", partial(of_frequencies, case, options)


# --- proofs and judgements


CERTIFIED: tuple[tuple[str, list[Any], int], ...] = (
    ("general/asymmetric-regular", [1, 10], 30),
    ("general/asymmetric-chaotic", [5, "-7/3"], 15),
    ("euler/largest-axis", [100], 20),
    ("lagrange/nutation", [1, 2, 40], 12),
    ("hard/near-pole", [3], 15),
    ("published/nasa-brick", [30], 15),
    ("general/asymmetric-chaotic", [1000], 15),
)
OF_PROOF = "times centres radii digits asked noise steps tries outcome"


def proof(case: str, at: list[Any], digits: int) -> dict[str, Any]:
    scene = replace(polhode.load(case), outputs=("attitude", "angles"))
    found = polhode.certify(scene, at=at, digits=digits)
    beside = {name: taken(getattr(found, name), "centres radii") for name in ("angles", "attitude")}
    return {**taken(found, OF_PROOF), **beside}


def proven_events(case: str) -> Any:
    scene = replace(polhode.load(case), events=EVENTS[0])
    return [taken(one, "name times undecided") for one in polhode.certify_events(scene, end=9)]


def proofs() -> Entries:
    for case, at, digits in CERTIFIED:
        yield f"{case} {at} {digits}", partial(proof, case, at, digits)
    for case in ("general/asymmetric-regular", "lagrange/nutation"):
        yield f"{case} events", partial(proven_events, case)


def judged(case: str) -> dict[str, Any]:
    scene = asked(case, "plain")
    at = times(scene, 60, False)
    made = polhode.integrate(scene, at=at, max_steps=MAX_STEPS)
    grown = "log10_kappa log10_amplification lost_after"
    return {
        "compare": recorded(lambda: min(polhode.compare(made).digits)),
        "conditioning": recorded(lambda: taken(polhode.conditioning(scene, at), grown)),
        "lyapunov": recorded(
            lambda: taken(polhode.lyapunov(scene, at[2]), "exponent uncertainty growth verdict")
        ),
        "rolling": recorded(lambda: polhode.rolling(rolled(case))),
    }


def rolled(case: str) -> polhode.Trajectory:
    scene = replace(polhode.load(case), outputs=("hodographs",))
    end = unit(scene) * 30
    return polhode.integrate(scene, at=[end * k / 60 for k in range(61)])


def judgements() -> Entries:
    for case in CASES[5::25]:
        yield case, partial(judged, case)


#: The longest first, so that the last processes end together.
PARTS: dict[str, Callable[[], Entries]] = {
    "double": partial(runs, "double"),
    "extended": partial(runs, "extended"),
    "mp": partial(wide_runs, "mp"),
    "quad": partial(wide_runs, "quad"),
    "closed forms": closed_forms,
    "sweeps": sweeps,
    "again": again,
    "sections": sections,
    "maps": maps,
    "orbits": orbits,
    "levels": levels,
    "frequencies": frequencies,
    "proofs": proofs,
    "judgements": judgements,
}


if __name__ == "__main__":
    die_early(Path(sys.argv[1]))

"""Study ``speed``: work against precision, polhode beside heyoka alone and beside other programs."""

from __future__ import annotations

import math
import statistics
import tempfile
from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

from polhode.correct_digits import digits_of, errors, rate_scale
from polhode.precision import DOUBLE, bits_for, named
from polhode.scene import Scene, even_times
from polhode.studies.processes import Curve, Method, Task, Tick, plain_scene, run_all
from polhode.studies.work_precision import Against, Mark, against, wall
from polhode.truth import reference

NAME = "speed"
QUESTION = (
    "How many correct digits does a second buy: polhode in each number type, with and without "
    "projection, beside heyoka written by hand and beside other programs?"
)
SAMPLES = 11
SPARE_DIGITS = 6
LOOSEST = 6.0  # digits from which curves are compared
DEFAULT = "polhode double projected"
ENGINE = "heyoka alone"


class Motion(NamedTuple):
    """A case of the library to its own end; ``kind``: regular, chaotic, or short for slow peers."""

    name: str
    case: str
    end: int
    kind: str


MOTIONS = (
    Motion("Euler top", "euler/largest-axis", 1000, "regular"),
    Motion("Lagrange top", "lagrange/nutation", 1000, "regular"),
    Motion("Kovalevskaya top", "kovalevskaya/generic", 1000, "regular"),
    Motion("asymmetric body", "general/asymmetric-regular", 1000, "regular"),
    Motion("asymmetric body, chaotic", "general/asymmetric-chaotic", 100, "chaotic"),
    Motion("asymmetric body, short", "general/asymmetric-regular", 2, "short"),
)

_OWN = "polhode.studies.own_process"
_TOLERANCES = (1e-6, 1e-8, 1e-10, 1e-12, 1e-14)
_FINE = {
    "double": (*_TOLERANCES, 2.0**-52),
    "extended": (1e-12, 1e-15, 2.0**-63),
    "quad": (1e-20, 1e-28, 2.0**-112),
    "mp": (1e-40, float(named("mp").eps)),
}


def _own(number: str, tolerances: tuple[float, ...]) -> tuple[Method, Method]:
    return tuple(  # type: ignore[return-value]
        Method(f"polhode {word}", _OWN, word, tolerances, number, 120.0)
        for word in (number, f"{number} projected")
    )


def _peer(name: str, module: str, method: str = "", limit: float = 60.0) -> Method:
    return Method(name, f"polhode.peers.{module}", method, _TOLERANCES, limit=limit)


OURS = tuple(method for number, fine in _FINE.items() for method in _own(number, fine))
HEYOKA = Method(ENGINE, "polhode.peers.bare_heyoka", "", _FINE["double"])
PEERS = (
    _peer("SciPy DOP853, Python", "scipy_python", "DOP853"),
    _peer("SciPy LSODA, Python", "scipy_python", "LSODA"),
    _peer("SciPy DOP853, numba", "scipy_numba", "DOP853"),
    _peer("SciPy LSODA, numba", "scipy_numba", "LSODA"),
    _peer("numbalsoda dop853", "numbalsoda_cfunc", "dop853"),
    _peer("numbalsoda lsoda", "numbalsoda_cfunc", "lsoda"),
    _peer("CyRK DOP853", "cyrk", "DOP853"),
    _peer("CyRK VERN8", "cyrk", "VERN8"),
    _peer("CyRK LSODA", "cyrk", "LSODA"),
    _peer("diffrax Dopri8", "diffrax_dopri8", "Dopri8"),
)
SLOW_PEERS = (_peer("mpmath odefun", "mpmath_odefun"),)

QUICK_MOTIONS = ("Kovalevskaya top", "asymmetric body, short")
QUICK_TYPES = ("double", "extended")
QUICK_PEERS = ("scipy_python", "mpmath_odefun")  # what needs no compiler
QUICK_TOLERANCES = (1e-8, 1e-12, 2.0**-52, 2.0**-63, 1e-14)


def rows(quick: bool = False, tick: Tick | None = None) -> dict[str, Any]:
    """The study's results as a JSON object; seconds vary from run to run, digits do not."""
    motions = [m for m in MOTIONS if not quick or m.name in QUICK_MOTIONS]
    asked = {motion: methods(motion, quick) for motion in motions}
    scenes = {motion: scene_of(motion) for motion in motions}
    tasks = [Task(method, scenes[motion]) for motion in motions for method in asked[motion]]
    with tempfile.TemporaryDirectory() as cache:
        repeats, patience = (2, 0.1) if quick else (3, 0.25)
        curves = run_all(tasks, Path(cache), repeats, patience, _named(tick))
    found = []
    for motion in motions:
        if tick is not None:
            tick(f"{NAME}: reference of the {motion.name}")
        mine, curves = curves[: len(asked[motion])], curves[len(asked[motion]) :]
        judged = dict(zip(asked[motion], mine, strict=True))
        found.append(motion_row(motion, scenes[motion], judged))
    return {"study": NAME, "question": QUESTION, "quick": quick, "motions": found}


def methods(motion: Motion, quick: bool) -> list[Method]:
    """The methods that run a motion: slow peers on the short one, all others on the rest."""
    chosen = [*OURS, HEYOKA, *(SLOW_PEERS if motion.kind == "short" else PEERS)]
    if not quick:
        return chosen
    return [
        method._replace(tolerances=tuple(t for t in method.tolerances if t in QUICK_TOLERANCES))
        for method in chosen
        if (method in OURS and method.number in QUICK_TYPES)
        or method is HEYOKA
        or method.module.rpartition(".")[2] in QUICK_PEERS
    ]


def scene_of(motion: Motion) -> Scene:
    """The motion's scene at its output times, which every method takes as doubles."""
    times = [DOUBLE.rounded(t) for t in even_times(Fraction(motion.end), SAMPLES)]
    return plain_scene(motion.case, times)


def motion_row(motion: Motion, scene: Scene, curves: Mapping[Method, Curve]) -> dict[str, Any]:
    """What all methods gave on one motion, judged, and the verdicts."""
    most = max(named(method.number).most_digits for method in curves)
    wanted = math.ceil(most) + SPARE_DIGITS
    truth = reference(scene).at(scene.times, wanted)
    digits = {
        method: {
            tol: _digits(point.rows, truth, scene, named(method.number).most_digits)
            for tol, point in curve.points.items()
            if point.rows is not None
        }
        for method, curve in curves.items()
    }
    found: dict[str, Any] = {
        "motion": motion.name,
        "case": motion.case,
        "end": motion.end,
        "kind": motion.kind,
        "methods": [_method_row(method, curve, digits[method]) for method, curve in curves.items()],
        "wall": wall([(method.number, [*digits[method].items()]) for method in curves]),
    }
    kappa, possible = _limits(scene)
    if kappa is not None and possible is not None:
        floor = possible - math.log10(3)
        found |= {"kappa": float(f"{kappa:.2e}"), "digits_possible": round(possible, 2)}
        found["verdict"] = verdict(found["methods"], floor)
    return found


def verdict(found: Sequence[Mapping[str, Any]], floor: float) -> dict[str, Any]:
    """polhode's double curve against each peer's from 1e-6 down to ``floor`` digits.

    heyoka is our engine: against it, the overhead at equal tolerance and what projection gains.
    """
    marks = {method["method"]: _marks(method["points"]) for method in found}
    ours = marks.get(DEFAULT) or marks["polhode double"]
    peers = [m for m in found if m["number"] == "double" and _is_peer(m["method"])]
    compared = {
        m["method"]: against(ours, marks[m["method"]], LOOSEST, floor)
        for m in peers
        if marks[m["method"]]
    }
    reach = max((mark.digits for mark in ours), default=0.0)
    return {
        "from_digits": LOOSEST,
        "to_digits": round(floor, 2),
        "reach": round(reach, 2),
        "reaches_floor": reach >= floor,
        "ahead_of_all": all(x.ahead for x in compared.values()),
        "peers": [_against_row(name, x) for name, x in compared.items()],
        "engine": _engine(found, marks),
    }


def _engine(
    found: Sequence[Mapping[str, Any]], marks: Mapping[str, Sequence[Mark]]
) -> dict[str, Any]:
    """Seconds over heyoka's at equal tolerance, and digits gained over heyoka's best."""
    by_tol = {
        m["method"]: {p["tol"]: p["seconds_min"] for p in m["points"] if "digits" in p}
        for m in found
    }
    row: dict[str, Any] = {}
    best = max((mark.digits for mark in marks.get(ENGINE, ())), default=None)
    for name in ("polhode double", DEFAULT):
        shared = by_tol.get(name, {}).keys() & by_tol.get(ENGINE, {}).keys()
        if not shared or best is None:
            continue
        ratios = {tol: by_tol[name][tol] / by_tol[ENGINE][tol] for tol in shared}
        row[name] = {
            "overhead_least": round(min(ratios.values()), 3),
            "overhead_most": round(max(ratios.values()), 3),
            "overhead_tightest": round(ratios[min(shared)], 3),
            "digits_gained": round(max(mark.digits for mark in marks[name]) - best, 2),
        }
    return row


def _against_row(name: str, found: Against) -> dict[str, Any]:
    return {
        "method": name,
        "ahead": found.ahead,
        "least_factor": None if found.factor is None else float(f"{found.factor:.3g}"),
        "at_digits": None if found.at is None else round(found.at, 2),
        "reach": round(found.reach, 2),
        "short": round(found.short, 2),
    }


def _method_row(method: Method, curve: Curve, digits: Mapping[float, float]) -> dict[str, Any]:
    points = []
    for tol, point in curve.points.items():
        row: dict[str, Any] = {"tol": tol}
        if tol in digits:
            row["digits"] = round(digits[tol], 2)
        if point.seconds:
            row |= {
                "seconds_min": _short(min(point.seconds)),
                "seconds_median": _short(statistics.median(point.seconds)),
                "cpu": _short(min(point.cpu)),
                "runs": len(point.seconds),
                "steps": point.steps,
            }
        if point.fault:
            row |= {"status": "stale" if point.stale else "failed", "reason": point.fault}
        points.append(row)
    cold, cached = (*curve.compiling, None, None)[:2]
    return {
        "method": method.name,
        "number": method.number,
        "status": curve.status,
        "reason": curve.reason,
        "version": curve.version,
        "import": _short(curve.importing),
        "compile_cold": _short(cold),
        "compile_cached": _short(cached),
        "points": points,
    }


def _digits(rows: Any, truth: Any, scene: Scene, cap: float) -> float:
    bits = bits_for(cap + SPARE_DIGITS) + 64
    scale = rate_scale(truth, scene, bits)
    return min(digits_of(error, cap) for error in errors(rows, truth, scale, bits))


def _limits(scene: Scene) -> tuple[float | None, float | None]:
    """kappa at the end, and the fewest digits possible in double over the run."""
    try:
        from polhode.conditioning import conditioning
    except ImportError:
        return None, None
    found = conditioning(scene)
    possible = [x for x in found.digits_possible(DOUBLE) if x is not None]
    return found.kappa[-1], min(possible, default=None)


def _marks(points: Sequence[Mapping[str, Any]]) -> list[Mark]:
    return [Mark(p["digits"], p["seconds_min"]) for p in points if "digits" in p]


def _is_peer(name: str) -> bool:
    return not name.startswith("polhode") and name != ENGINE


def _short(x: float | None) -> float | None:
    return None if x is None else float(f"{x:.4g}")


def _named(tick: Tick | None) -> Tick | None:
    return None if tick is None else lambda what: tick(f"{NAME}: {what}")

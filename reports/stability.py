"""Study ``stability``: the hard cases in every number type, and the way back from their ends."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from textwrap import fill
from typing import Any

import kit
import polhode
from accuracy import case_rows
from polhode.equations.readout import Readout
from polhode.numbers.conversion import ExactNumbers, exactly, number_value
from polhode.numbers.decimals import significant
from polhode.taylor.motion import Motion
from polhode.taylor.system import system

#: The number types of the way back, and the most radians one way.
LONGEST = {"double": 1e4, "extended": 1e4, "quad": 200.0}
SPARE_DIGITS = 40  # of the states from which kappa of the way back is computed
QUARTERS = 4  # of the way, each of whose ends is one of those states


def rows(quick: bool, say: kit.Say, only: kit.Only) -> dict[str, Any]:
    """The study's rows; no figure in them depends on the clock."""
    scenes = [polhode.load(name) for name in hard_names(quick) if only(name)]
    cases = [
        row | {"end": float(scene.end), "runs": [*map(_judged, row["runs"])]}
        for scene, row in zip(scenes, case_rows(scenes, quick, say), strict=True)
    ]
    names = [scene.name for scene in scenes]
    longest_first = sorted(scenes, key=lambda scene: -scene.log10_angle)
    ways = kit.rows_by_part({"back": (_back, longest_first)}, quick, say)["back"]
    return {
        "kinds": [
            {"kind": kind, "cases": [name for name in cases if name in names]}
            for kind, cases in KINDS.items()
        ],
        "cases": cases,
        "back": sorted((row for way in ways for row in way), key=lambda x: names.index(x["case"])),
    }


def _judged(run: dict[str, Any]) -> dict[str, Any]:
    """A run of the study of accuracy, with how far it is behind what was expected."""
    if "correct_digits" not in run:
        return run
    expected = run["expected"]
    behind = None if expected is None else round(expected[0] - run["correct_digits"], 2)
    return run | {"behind": behind, "lost": run["lost"] or ""}


def _back(scene: polhode.Scene) -> list[dict[str, Any]]:
    """Errors of a run to the end and back to 0, beside what kappa of either way allows."""
    numbers = [name for name, longest in LONGEST.items() if 10**scene.log10_angle <= longest]
    if not numbers:
        return []
    there = _kappa(scene)
    times = [scene.end * Fraction(k, QUARTERS) for k in range(1, QUARTERS + 1)]
    states = polhode.reference(scene).at(times, SPARE_DIGITS)
    backs = [_kappa(way_back(scene, t, x)) for t, x in zip(times, states, strict=True)]
    back = max((x for x in backs if x is not None), default=None)
    kappa = None if there is None or back is None else max(there, back)
    errors = {name: error(scene, kit.TYPES[name]) for name in numbers}
    return [
        {
            "case": scene.name,
            "number": name,
            "log10_kappa": None if there is None else round(there, 2),
            "log10_kappa_back": None if back is None else round(back, 2),
            "error_eps": significant(eps, 3),
            "times_kappa": None if kappa is None else significant(eps / 10**kappa, 2),
            "within": None if kappa is None else eps <= 10**kappa,
        }
        for name, eps in errors.items()
    ]


def _kappa(scene: polhode.Scene) -> float | None:
    """log10 of the kappa of a scene's end."""
    return polhode.conditioning(scene, number="quad").log10_kappa[-1]


# --- hard cases -----------------------------------------------------------------------------------
#
# The hard cases by what is hard about them: names of cases that ship.


_HARD = tomllib.loads((kit.HERE / "hard-cases.toml").read_text(encoding="utf-8"))
KINDS: Mapping[str, Sequence[str]] = _HARD["kinds"]
QUICK: Sequence[str] = _HARD["quick"]


def hard_names(quick: bool = False) -> list[str]:
    """All hard cases, or the few of a quick study."""
    return [name for cases in KINDS.values() for name in cases if not quick or name in QUICK]


# --- there and back -------------------------------------------------------------------------------
#
# A run to a scene's end and back to its start, and the motion from its end back.


def error(scene: polhode.Scene, number: polhode.NumberType) -> float:
    """The error of the state, in eps, of a run to the scene's end and back to 0.

    Relative as in *correct digits*, to |w| at 0; against the start as the type rounds it.
    """
    plain = replace(scene, outputs=(), events=())
    equations, read = system(plain, number=number), Readout(plain, number)
    motion = Motion(equations)
    motion.begin(equations)
    unit = equations.frame.unit
    there = number.rounded(number.rounded(scene.end) / unit)
    row: Any = [motion.advance(ExactNumbers((t,)), 10**8)[0][0] for t in (there, Fraction(0))][-1]
    start = [number_value(number.rounded(x), number) for x in equations.start]
    (apart,) = polhode.state_errors(read.states([row]), read.states([start]), plain)
    return float(apart / number.eps)


def way_back(scene: polhode.Scene, t: Any, state: Sequence[Any]) -> polhode.Scene:
    """The motion from the scene's state at time t back to 0; ``state``: p q r [gamma], as mpf.

    gamma is brought to length 1.
    """
    p, q, r, *gamma = map(exactly, state)
    start: dict[str, Any] = {"omega": (p, q, r), "gamma": gamma or None, "normalise": True}
    return replace(scene, **start, times=(-t,), outputs=(), events=())


# --- page -----------------------------------------------------------------------------------------
#
# Rows of the tables and facts of the stability study's page.


def _pair(run: kit.JsonObject | None) -> float | str | None:
    """The digits of a run and those expected; in words where it has none."""
    right = kit.digits(run)
    if run is None or right is None or isinstance(right, str):
        return right
    return f"{right:.1f} / {kit.formatted(run['band'], '')}"


def tables(results: kit.JsonObject) -> dict[str, Iterable[kit.JsonObject]]:
    """The rows of the page's tables from the study's JSON object."""
    cases = {case["case"]: kit.by_number(case, _pair) for case in results["cases"]}
    runs = kit.inner_rows(results["cases"], "runs")
    unjudged = [run for run in runs if run.get("behind") is None]
    late = [run for run in runs if (run.get("behind") or 0) > 0]
    late.sort(key=lambda run: -float(run["behind"]))
    return {
        "cases": ({**cases[x], **kind} for kind in results["kinds"] for x in kind["cases"]),
        "behind": ({**run, "band": kit.expected(run["expected"])} for run in late),
        "unjudged": ({**run, "why": run.get("limit") or run["outcome"]} for run in unjudged),
        "back": results["back"],
    }


def facts(results: kit.JsonObject) -> dict[str, object]:
    """Counts and ranges of the rows."""
    behind = [run.get("behind") for run in kit.inner_rows(results["cases"], "runs")]
    judged = [row for row in results["back"] if row["within"] is not None]
    return {
        "enough": kit.share(x <= 0 for x in behind if x is not None),
        "motions": len(results["cases"]),
        "within": kit.share(row["within"] for row in judged),
        "times_kappa": max((row["times_kappa"] for row in judged), default=0),
    }


# --- figure ---------------------------------------------------------------------------------------
#
# Figure of the stability study: correct digits of the hard cases, a strip a difficulty.


_WIDTH = 24  # letters of a line of a strip's name


def svgs(results: kit.JsonObject) -> dict[str, str]:
    """One strip per kind of difficulty; rings have fewer digits than expected."""
    runs = kit.groups((run["case"], run) for run in kit.inner_rows(results["cases"], "runs"))
    groups = kit.groups(
        (fill(kind["kind"], _WIDTH), run)
        for kind in results["kinds"]
        for name in kind["cases"]
        for run in runs.get(name, ())
        if "correct_digits" in run
    )
    return {"stability": kit.strips(groups)}

"""Study ``speed``: seconds against digits, in every number type and beside other programs."""

from __future__ import annotations

import math
import os
import tempfile
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import contest
import kit
import polhode
import tops
from contest import WorkPoint, frontier
from peers.process import ask
from polhode.numbers.decimals import significant
from polhode.numbers.number_types import QUAD, mp
from programs import BY_NAME, ENGINE, OURS, PROGRAMS, RUN, Program

QUICK_PROGRAMS = (OURS, RUN, ENGINE)  # what needs no compiler


def rows(quick: bool, say: kit.Say, only: kit.Only) -> dict[str, Any]:
    """The study's rows; seconds vary from run to run, digits do not."""
    wanted_cells, ways_of = contest.wanted_cells(quick, only), motions(quick, only)
    refined = [x for x in REFINED if x.quick >= quick and only(f"refined: {x.name} t={x.end}")]
    programs = [p for p in PROGRAMS if p.is_there and (not quick or p.name in QUICK_PROGRAMS)]
    firsts = programs if only("first result") else []
    row_of = partial(row, ways_of, quick=quick)
    others: kit.Parts = {"motions": (row_of, [*ways_of]), "refined": (_refined, refined)}
    return {
        "once_above": PATIENCE,
        "programs": [program.name for program in programs],
        # alone: clocks run
        **kit.rows_by_part({"first": (partial(first_row, quick=quick), firsts)}, True, say),
        "cells": contest.rows(wanted_cells, [p for p in programs if p.last], quick, say),
        **kit.rows_by_part(others, True, say),
    }


def versions() -> dict[str, str]:
    """Of the programs that are there."""
    needs = {need for program in PROGRAMS if program.is_there for need in program.needs}
    return {name: version(name) for name in sorted(needs)}


# --- first result ---------------------------------------------------------------------------------
#
# The time to a first result in a new process: imports, compilation, one run.


KIND, END, OUTPUTS, TOLERANCE = "kovalevskaya", 10, 101, 1e-9
FIRST_REPEATS, ENOUGH = 3, 8.0  # times; none more once a program's processes took so many seconds
_FIRST_LIMIT = 120.0


def first_row(program: Program, quick: bool) -> dict[str, Any]:
    """Wall and processor seconds, with empty caches of compiled code and after that."""
    job = program.job(tops.present(KIND), [tops.draw(KIND, 0, END, OUTPUTS).run(TOLERANCE)])
    clocks: dict[str, list[dict[str, float]]] = {"cold": [], "warm": []}
    began = time.perf_counter()
    for _ in range(1 if quick else FIRST_REPEATS):
        with tempfile.TemporaryDirectory() as cache:
            for clock in clocks.values():  # of a process from its start to its end
                before, start = sum(os.times()[2:4]), time.perf_counter()  # children's
                answers, fault = ask(job, _FIRST_LIMIT, Path(cache))
                wall, spent = time.perf_counter() - start, sum(os.times()[2:4]) - before
                if fault or "failed" in answers[0]:
                    return {"program": program.name, "fault": fault or answers[0]["failed"]}
                clock.append({"wall": round(wall, 3), "processor": round(spent, 3)})
        if time.perf_counter() - began > ENOUGH:
            break
    least = {word: min(x, key=lambda clock: [*clock.values()]) for word, x in clocks.items()}
    return {"program": program.name, **least, "fault": ""}


# --- number types ---------------------------------------------------------------------------------
#
# polhode in every number type: error against seconds, on a motion of each kind.


SAMPLES = 11
SPARE_DIGITS = 6
TYPES_SHOWN = "Kovalevskaya top"  # the motion on which wide types are projected, too
REPEATS, PATIENCE = 6, 0.1  # timed runs a tolerance; longer runs are made once
QUICK_REPEATS = 2
_FEW = {"double": 200, "extended": 200}  # steps that warm up, past the first projection; else 2


class LibraryMotion(NamedTuple):
    """A case of the library to an end; ``kind``: regular or chaotic.

    ``digits``, ``outputs``: of runs that are refined, quad unless digits are asked for.
    """

    name: str
    case: str
    end: int
    kind: str = "regular"
    digits: int | None = None
    outputs: tuple[str, ...] = ()
    quick: bool = False

    def scene(self, times: Sequence[Fraction]) -> polhode.Scene:
        """Its scene at other times."""
        plain = replace(polhode.load(self.case), events=(), published=())
        return replace(plain, times=tuple(times), outputs=self.outputs)


_REGULAR, _CHAOTIC = "general/asymmetric-regular", "general/asymmetric-chaotic"

MOTIONS = (
    LibraryMotion("Euler top", "euler/largest-axis", 1000),
    LibraryMotion("Lagrange top", "lagrange/nutation", 1000),
    LibraryMotion("Kovalevskaya top", "kovalevskaya/generic", 1000, quick=True),
    LibraryMotion("asymmetric body", _REGULAR, 1000),
    LibraryMotion("asymmetric body, chaotic", _CHAOTIC, 100, "chaotic"),
)
QUICK_TYPES = ("double", "extended")


class Way(NamedTuple):
    """A curve: a number type, whether the state is put back on its integrals, tolerances."""

    number: str
    project: bool
    tolerances: tuple[float, ...]

    @property
    def name(self) -> str:
        """In the study's rows."""
        return f"polhode {self.number}{' projected' if self.project else ''}"


_FINE = {
    "double": (1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 2.0**-52),
    "extended": (1e-12, 1e-15, 2.0**-63),
    "quad": (1e-20, 2.0**-112),
    "mp": (float(kit.TYPES["mp"].eps),),
}


def ways(motion: LibraryMotion, quick: bool) -> Iterator[Way]:
    """The ways of a motion, each type as it is and projected.

    Steps in quad and mp that are projected take 3 to 15 seconds to t = 1000, and nothing is
    projected in these types unless it is asked to be: one motion shows them, at their own eps.
    """
    for number in QUICK_TYPES if quick else _FINE:
        yield Way(number, False, _FINE[number])
        if number in QUICK_TYPES:
            yield Way(number, True, _FINE[number])
        elif motion.name == TYPES_SHOWN:
            yield Way(number, True, _FINE[number][-1:])


def motions(quick: bool, only: kit.Only) -> dict[LibraryMotion, list[Way]]:
    """The motions asked for, each with the ways that are."""
    return kit.groups(
        (motion, way)
        for motion in MOTIONS
        if motion.quick >= quick
        for way in ways(motion, quick)
        if only(motion.name, motion.case, "every motion", way.name)
    )


def row(
    ways_of: Mapping[LibraryMotion, Sequence[Way]], motion: LibraryMotion, quick: bool
) -> dict[str, Any]:
    """What its ways give on one motion, judged against its exact scene."""
    scene, ways = motion.scene(tops.times(motion.end, SAMPLES)), ways_of[motion]
    most = max(kit.TYPES[curve.number].most_digits for curve in ways)
    true = polhode.reference(scene).at(scene.times, math.ceil(most) + SPARE_DIGITS)
    return {
        **{"name": motion.name, "case": motion.case, "end": motion.end, "kind": motion.kind},
        "motion": motion.name,
        "methods": [
            {
                **{"method": curve.name, "number": curve.number},
                "points": [_point(curve, scene, tol, true, quick) for tol in curve.tolerances],
            }
            for curve in ways
        ],
    }


def _point(curve: Way, scene: polhode.Scene, tol: float, true: Any, quick: bool) -> dict[str, Any]:
    """Digits and the least seconds at one tolerance, or why there are none."""
    number = kit.TYPES[curve.number]
    tolerance = None if tol <= float(number.eps) else tol
    call = partial(polhode.integrate, scene, number, tol=tolerance, project=curve.project)
    call(max_steps=_FEW.get(curve.number, 2))
    (timed,) = kit.timed([call], QUICK_REPEATS if quick else REPEATS, PATIENCE)
    run = timed.answer
    if not run.outcome.done:
        return {"tol": tol, "reason": run.outcome.cause}
    digits = kit.fewest_digits(run.states, true, scene, number.most_digits)
    return {
        "tol": tol,
        "digits": round(digits, 2),
        "seconds_min": significant(timed.seconds, 4),
        "runs": timed.calls,
        "steps": run.steps,
    }


# --- refined --------------------------------------------------------------------------------------
#
# Refined runs beside heyoka's own steps in the same number type, in one process.


_REPEATS, _PATIENCE = 3, 1.0  # timed runs; longer ones are made once
_SPARE = 12  # digits more that the reference has
_OUTPUTS = ("angles", "attitude")


REFINED = (
    LibraryMotion("brick, w3 = 3", _REGULAR, 10, quick=True),
    LibraryMotion("brick, w3 = 3", _REGULAR, 100, quick=True),
    LibraryMotion("brick, w3 = 3", _REGULAR, 1000),
    LibraryMotion("brick, w3 = 3, angles and attitude", _REGULAR, 100, outputs=_OUTPUTS),
    LibraryMotion("brick, w3 = 3, 50 digits", _REGULAR, 100, digits=kit.MP_DIGITS),
    LibraryMotion("chaotic brick, w3 = 1.1", _CHAOTIC, 100, quick=True),
    LibraryMotion("Kovalevskaya top", "kovalevskaya/generic", 1000),
)


def _refined(motion: LibraryMotion) -> dict[str, Any]:
    """CPU seconds and correct digits both ways, digits to which both agree, and what refinement
    estimated."""
    scene = motion.scene([Fraction(motion.end)])
    number = QUAD if motion.digits is None else kit.TYPES["mp"]
    wide = math.ceil(number.most_digits) + _SPARE
    truth = polhode.reference(scene)
    true: Any
    if truth.is_closed_form:
        true, by = truth.at(scene.times, wide), "closed form"
    else:  # a method of its own, and more digits
        steps = polhode.integrate(replace(scene, outputs=()), mp(wide), method="taylor")
        true, by = steps.states, "steps in more digits"
    row: dict[str, Any] = {"motion": motion.name, "end": motion.end, "bits": number.bits, "by": by}
    calls = [partial(polhode.integrate, number=number, method=x) for x in ("refined", "taylor")]
    for call in calls:
        call(scene.at([min(10, scene.end)]))  # loads what is compiled
    runs = kit.timed([partial(call, scene) for call in calls], _REPEATS, _PATIENCE)
    for call, (run, seconds, count) in zip(calls, runs, strict=True):
        row[call.keywords["method"]] = {
            "cpu": significant(seconds, 3),
            "digits": round(kit.fewest_digits(run.states, true, scene, wide), 2),
            "method": run.method,
            "runs": count,
        }
        if run.errors is not None and run.errors[-1] is not None:
            row["estimate"] = significant(run.errors[-1], 2)
    refined, taylor = runs
    agreement = kit.fewest_digits(taylor.answer.states, refined.answer.states, scene, wide)
    row["agreement"] = round(agreement, 2)
    row["gain"] = significant(row["taylor"]["cpu"] / row["refined"]["cpu"], 3)
    return row


# --- page -----------------------------------------------------------------------------------------
#
# Rows of the tables and facts of the speed study's page: polhode beside other programs, and alone.


_NEVER = {"wall": math.inf}
SUMMARY_ENDS = (1, 10, 100, 1000)
WORDS = ("ahead", "even", "behind", "alone", "not run", "not reached")
ALONE = {"alone": "polhode alone", "not run": "others not run"}


def tables(results: kit.JsonObject) -> dict[str, Iterable[kit.JsonObject]]:
    """The rows of the page's tables from the study's JSON object."""
    lengths = by_length(results["cells"])
    return {
        "summary": summary(lengths),
        "first": sorted(results["first"], key=lambda row: row.get("cold", _NEVER)["wall"]),
        "single": [row for row in lengths if not row["starts"]],
        "many": [row for row in lengths if row["starts"]],
        "faults": _faults(results),
        "types": _best(results["motions"]),
        "refined": results["refined"],
    }


def by_length(cells: Sequence[kit.JsonObject]) -> list[kit.JsonObject]:
    """A row a number of starts or outputs, a length, and a level of digits, over the kinds."""
    levels = kit.groups(
        ((cell["starts"], cell["outputs"], cell["end"], level["digits"]), level)
        for cell in cells
        for level in cell["levels"]
    )
    return [_over_kinds(*key, every) for key, every in sorted(levels.items())]


def _over_kinds(
    starts: int, outputs: int, end: int, digits: float, levels: Sequence[kit.JsonObject]
) -> kit.JsonObject:
    """What a row says of one length and level of digits."""
    unit = 1e6 / starts if starts else 1e3
    verdicts = [level["verdict"] for level in levels]
    stands = Counter(verdict["stands"] for verdict in verdicts)
    met = [verdict for verdict in verdicts if "best" in verdict]
    best = [name for name, _ in Counter(sorted(x["best"] for x in met)).most_common(2)]
    ratios = [verdict["ratio"][0] for verdict in met]
    programs = kit.groups((p["program"], p) for level in levels for p in level["programs"])
    seconds = [unit * p["seconds"] for p in programs.get(OURS, ()) if p["seconds"]]
    often = "" if len(met) == len(levels) else f" (in {len(met)} of {len(levels)})"
    alone = next((text for word, text in ALONE.items() if stands[word]), "not reached")
    return {
        "starts": starts,
        "end": end,
        "run": f"t = {end}, " + (f"{starts} starts" if starts else f"{outputs} outputs"),
        "cells": f"t={end} " + (f"starts={starts}" if starts else f"outputs={outputs}"),
        "digits": digits,
        "own": kit.median(seconds, ".3g"),
        "stands": kit.counted({word: stands[word] for word in WORDS}),
        "best": ", ".join(best) or kit.DASH,
        "ratio": kit.spread(ratios, ".2f"),
        **{
            name: kit.spread([p["ratio"][0] for p in programs.get(name, ()) if p["ratio"]], ".2f")
            for name in (ENGINE, RUN)
        },
        "summary": f"{_bold(kit.median(ratios, '.2f'))} {best[0]}{often}" if met else alone,
    }


def _bold(ratio: str) -> str:
    return f"**{ratio}**" if float(ratio) > 1 else ratio


def summary(lengths: Iterable[kit.JsonObject]) -> list[kit.JsonObject]:
    """The time of the best other program over the propagator's: runs down, digits across.

    Medians over the kinds of motion, and the program that is best in most of them; above 1 in bold.
    The last rows are of many starts at once.
    """
    runs = kit.groups((row["run"], row) for row in lengths if row["end"] in SUMMARY_ENDS)
    return [
        {"run": run, "cells": {f"{row['digits']:g}": row["summary"] for row in own}}
        for run, own in runs.items()
    ]


def facts(results: kit.JsonObject) -> dict[str, object]:
    """Counts and ranges of the rows."""
    refined, cells = results["refined"], results["cells"]
    arrays = Counter((cell["starts"], cell["end"]) for cell in cells if cell.get("starts"))
    better = [row["refined"]["digits"] - row["taylor"]["digits"] for row in refined]
    return {
        "draws": cells[0]["draws"] if cells else kit.DASH,
        "kinds": ", ".join(dict.fromkeys(cell["kind"] for cell in cells)) or kit.DASH,
        "without": ", ".join(x for x in BY_NAME if x not in results["programs"]) or "none",
        "many_kinds": " or ".join(map(str, sorted({*arrays.values()}))),
        "once_above": f"{results['once_above']:g}",
        "refined_time": kit.between([1 / row["gain"] for row in refined], ".3f"),
        "refined_digits": kit.between(better, "+.1f"),
    }


def _best(motions: Sequence[kit.JsonObject]) -> Iterator[kit.JsonObject]:
    """Each number type at its tightest tolerance on each motion."""
    for method in kit.inner_rows(motions, "methods"):
        points = [p for p in method["points"] if "digits" in p]
        if points:
            to = f"{method['motion']}, t = {method['end']}"
            yield {**method, **min(points, key=lambda p: p["tol"]), "to": to}


def _faults(results: kit.JsonObject) -> list[kit.JsonObject]:
    """What failed or was missing, each once."""
    causes = [fault for cell in results["cells"] for fault in cell["faults"].items()]
    causes += [(row["program"], row["fault"]) for row in results["first"] if row["fault"]]
    causes += [
        (point["method"], f"at tolerance {point['tol']:.2g}: {point['reason']}")
        for point in kit.inner_rows(kit.inner_rows(results["motions"], "methods"), "points")
        if "reason" in point
    ]
    return [{"program": program, "fault": fault} for program, fault in dict.fromkeys(causes)]


# --- figure ---------------------------------------------------------------------------------------
#
# Figures of the study speed: error against time, of all programs and of polhode's number types.


#: Curves of a panel by their names: points (seconds, error).
Curves = Mapping[str, Sequence[tuple[float, float]]]


def svgs(results: kit.JsonObject) -> dict[str, str]:
    """The study's figures by name, from its JSON object."""
    drawn = {
        "speed": {_panel(x): lines(x["curves"]) for x in results["cells"] if "curves" in x},
        "types": {
            f"{x['motion'].capitalize()}, t = {x['end']}": _types(x) for x in results["motions"]
        },
    }
    return {name: work_precision(panels) for name, panels in drawn.items() if panels}


def lines(curves: Mapping[str, Sequence[Sequence[float]]]) -> Curves:
    """The lines of a panel from the programs' digits and seconds: what no other point beats.

    Of a package with several methods that is the fastest to each error; a program that is not known
    here, as one of an earlier version is, has a line by its own name.
    """
    in_order = {**dict.fromkeys(BY_NAME, ()), **curves}
    marks = kit.groups(
        (BY_NAME[name].line if name in BY_NAME else name, WorkPoint(*point))
        for name, points in in_order.items()
        for point in points
    )
    return {
        line: [(mark.seconds, 10.0**-mark.digits) for mark in frontier(every)]
        for line, every in marks.items()
        if line
    }


def work_precision(panels: dict[str, Curves]) -> str:
    """Error against seconds, one panel per motion; lower left is better."""

    def draw(axes: kit.Axes, curves: Curves) -> None:
        for name, points in curves.items():
            look = kit.LOOKS.get(name, kit.OTHER_LOOK)
            axes.plot(*zip(*points, strict=True), label=name, **look)
        axes.set(xscale="log", yscale="log")

    x, y = "processor seconds of a run", "error"
    return kit.side_by_side(panels, draw, 1.9, x, y, names=3, sharey=True)


def _panel(cell: kit.JsonObject) -> str:
    """The title of a cell's panel."""
    name = f"{cell['starts']} starts" if cell.get("starts") else cell["kind"].capitalize()
    return f"{name}, t = {cell['end']}"


def _types(motion: kit.JsonObject) -> Curves:
    """polhode in all number types on one motion."""
    return kit.groups(
        (point["method"].removeprefix("polhode "), (point["seconds_min"], 10.0 ** -point["digits"]))
        for point in kit.inner_rows(motion["methods"], "points")
        if point.get("digits")
    )

"""Tables and facts of the speed study's page: polhode beside other programs, and alone."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TypeAlias

from polhode.common.texts import JsonObject
from polhode.studies.page.tables import DIGITS, Column, PageTable, table
from polhode.studies.page.words import DASH, between, counted, listed, median, spread
from polhode.studies.speed.programs import BY_NAME, ENGINE, OURS, RUN

#: Levels of digits, each with its cell.
Levels: TypeAlias = Sequence[tuple[JsonObject, JsonObject]]

LONG = 1000  # from this end on a run is told as a long one
SUMMARY_ENDS, SUMMARY_OUTPUTS = (1, 10, 100, 1000), 101
WORDS = ("ahead", "even", "behind", "alone", "not run", "not reached")

_MOTION = Column("motion", "motion")
_BEST = (
    _MOTION,
    Column("method", "method", "", "the number type, and whether the run is projected"),
    Column("to", lambda row: f"{row['motion']}, t = {row['end']}"),
    Column("tol", "tol", ".1e", "the tolerance of the steps, the tightest of several"),
    DIGITS,
    Column("least s", "seconds_min", ".3g", "processor seconds of a run, the least of several"),
)
_REFINED = (
    _MOTION,
    Column("t", "end", "d"),
    Column("bits", "bits", "d", "bits of the number type"),
    Column("steps, s", "taylor.cpu", ".3g", "CPU seconds of heyoka's steps in that type"),
    Column("steps, digits", "taylor.digits", ".1f", "their correct digits at the end"),
    Column("refined, s", "refined.cpu", ".3g", "CPU seconds of the refined run"),
    Column("refined, digits", "refined.digits", ".1f", "its correct digits at the end"),
    Column("agreement", "agreement", ".1f", "digits to which the two agree"),
    Column("estimate", "estimate", ".3g", "the refined run's own estimate of its error"),
    Column("gain", "gain", ".1f", "seconds of the steps over those of the refined run"),
)
_FAULTS = (
    Column("program", "program"),
    Column("fault", "fault", "", "counted as not reached, or missing"),
)


def _first_column(header: str, way: str, clock: str) -> Column:
    """Seconds of one way by one clock; why there are none, where a program failed."""

    def value(row: JsonObject) -> object:
        return row[way][clock] if way in row else row["fault"] or None

    return Column(header, value, ".2f")


_FIRST = (
    Column("program", "program"),
    _first_column("cold, s", "cold", "wall"),
    _first_column("cold, processor s", "cold", "processor"),
    _first_column("warm, s", "warm", "wall"),
    _first_column("warm, processor s", "warm", "processor"),
)
_RATIO = "the time of that program over the propagator's, likewise"
_CELLS = (
    Column("cells", "cells", "", "the last time, and the number of output times"),
    Column("digits", "digits", "g", "correct digits that are asked for"),
    Column("propagator, ms", "own", ">", "a polhode propagator, the median over the kinds"),
    Column("stands", "stands", "", "how the propagator stands against the best of the others"),
    Column("best other", "best", "", "the other programs that are fastest in most kinds"),
    Column(
        *("its ratio", "ratio", ">"),
        "the time of the best other over the propagator's: median over the kinds (least, most)",
    ),
    Column(ENGINE, ENGINE, ">", _RATIO),
    Column(RUN, RUN, ">", _RATIO),
)


_STANDING = (
    Column("run", "run"),
    Column("ahead", "ahead", "d", "cells in which a polhode propagator is faster"),
    Column("even", "even", "d", "the 95 % interval of the median ratio contains 1"),
    Column("behind", "behind", "d", "it is slower"),
    Column("alone", "alone", "d", "no other program run there reaches the digits"),
    Column("not run", "not run", "d", "no other program was run there"),
    Column("not reached", "not reached", "d", "it does not reach them from 7 of 8 draws itself"),
    Column(
        *("where behind", "lost", ">"),
        "the time of the best other program over the propagator's: median (least, most)",
    ),
    Column("which is", "best"),
    Column(
        *("over heyoka", "engine", ">"),
        "the propagator's time over that of heyoka written by hand: median (least, most)",
    ),
)
_MANY = (
    Column("cells", "cells", "", "the last time, and the number of starts of each body"),
    Column("digits", "digits", "g", "correct digits that are asked for, the median over starts"),
    Column("arrays, µs", "own", ">", "a start of an array that a propagator is given, the median"),
    *_CELLS[3:6],
    Column(f"{ENGINE}, in batches", ENGINE, ">", _RATIO),
    Column("polhode integrate_many", RUN, ">", _RATIO),
)


def tables(found: JsonObject) -> dict[str, PageTable]:
    """The page's tables from the study's JSON object."""
    first = sorted(found["first"], key=lambda row: row.get("cold", {}).get("wall", 1e9))
    many, single = _parted(found["cells"])
    short = [cell for cell in single if cell["end"] < LONG]
    long = [cell for cell in single if cell["end"] >= LONG]
    cells = "polhode study speed --only '{0}'"
    types = "polhode study speed --only '{0}' --only '{1}'"
    refined = "polhode study speed --only 'refined: {0} t={1}'"
    return {
        "summary": summary(found["cells"], _not_run(found)),
        "standing": standing(found["cells"]),
        "first": table(first, _FIRST, "polhode study speed --only 'first result'"),
        "short": table(_by_length(short), _CELLS, cells),
        "long": table(_by_length(long), _CELLS, cells),
        "many": table(_by_length(many), _MANY, cells),
        "faults": table(_faults(found), _FAULTS),
        "types": table(_best(found["motions"]), _BEST, types),
        "refined": table(found.get("refined", ()), _REFINED, refined),
    }


def summary(cells: Sequence[JsonObject], not_run: str = "not run") -> PageTable:
    """The time of the best other program over the propagator's: lengths down, digits across.

    Medians over the kinds of motion, and the program that is best in most of them; above 1 in bold.
    The last row is of many starts at once.  ``not_run``: what stands where no other program was.
    """
    digits = dict.fromkeys(level["digits"] for cell in cells for level in cell["levels"])
    columns = [Column("run", "run"), *(Column(f"{x:g} digits", f"{x:g}") for x in digits)]
    many, single = _parted(cells)
    usual = [cell for cell in single if cell["outputs"] == SUMMARY_OUTPUTS]
    shown = {f"t = {end}": [c for c in usual if c["end"] == end] for end in SUMMARY_ENDS}
    most = max((cell["starts"] for cell in many), default=0)
    largest = [cell for cell in many if cell["starts"] == most]
    ends = " and ".join(str(end) for end in sorted({cell["end"] for cell in largest}))
    shown[f"{most} starts at once, t = {ends}"] = largest
    return table(
        (
            {"run": run, **{f"{x:g}": _best_other(here, x, not_run) for x in digits}}
            for run, here in shown.items()
            if here
        ),
        columns,
    )


def _best_other(cells: Sequence[JsonObject], digits: float, not_run: str) -> str:
    """The best other program's time over the propagator's in cells, and which it is in most."""
    verdicts = [x["verdict"] for _, x in levels(cells) if x["digits"] == digits]
    ratios = [verdict["ratio"][0] for verdict in verdicts if "best" in verdict]
    if not ratios:
        told = {verdict["stands"] for verdict in verdicts}
        words = {"alone": "polhode alone", "not run": not_run}
        return next((text for word, text in words.items() if word in told), "not reached")
    ratio = median(ratios, ".2f")
    names = [verdict["best"] for verdict in verdicts if "best" in verdict]
    often = max(sorted(set(names)), key=names.count)
    part = "" if len(ratios) == len(verdicts) else f" (in {len(ratios)} of {len(verdicts)})"
    return f"{f'**{ratio}**' if float(ratio) > 1 else ratio} {often}{part}"


def standing(cells: Sequence[JsonObject]) -> PageTable:
    """How often polhode is ahead of the others, and how far it is from heyoka: a row a length."""
    rows = [*_standings(cells)]
    every_run = not any(row["not run"] for row in rows)
    return table(rows, [x for x in _STANDING if not (every_run and x.header == "not run")])


def _standings(cells: Sequence[JsonObject]) -> Iterator[JsonObject]:
    for (starts, end), here in _groups(cells, "starts", "end").items():
        found = levels(here)
        lost = [x["verdict"] for _, x in found if x["verdict"]["stands"] == "behind"]
        ratios = [verdict["ratio"][0] for verdict in lost]
        own = [1 / ratio for ratio in ratios_of(found, ENGINE)]
        yield {
            "run": f"t = {end}" + f", {starts} starts" * (starts > 0),
            **stands(found),
            "lost": spread(ratios, ".2f"),
            "best": listed(verdict["best"] for verdict in lost),
            "engine": spread(own, ".2f"),
        }


def facts(found: JsonObject) -> dict[str, object]:
    """Counts and ranges of the rows."""
    refined = found.get("refined", ())
    _, cells = _parted(found["cells"])
    better = [row["refined"]["digits"] - row["taylor"]["digits"] for row in refined]
    return {
        "draws": cells[0]["draws"] if cells else DASH,
        "kinds": ", ".join(dict.fromkeys(cell["kind"] for cell in cells)) or DASH,
        "without": _without(found),
        "once_above": f"{found['once_above']:g}",
        "refined_time": between([1 / row["gain"] for row in refined], ".3f"),
        "refined_digits": between(better, "+.1f"),
    }


def _not_run(found: JsonObject) -> str:
    """What a cell says where no other program was run."""
    if found.get("quick"):
        return "others not run by --quick"
    extras = _extras(found) or ["polhode[peers]"]
    return f"others not run: install {', '.join(extras)}"


def _without(found: JsonObject) -> str:
    """The programs that were not run at all, and how they can be."""
    if found.get("quick"):
        return "all others (--quick runs what needs no compiler)"
    names, extras = ", ".join(found["without"]), _extras(found)
    return f"{names} (install {', '.join(extras)})" if extras else names or "none"


def _extras(found: JsonObject) -> list[str]:
    """What installs the programs that are missing."""
    absent = [BY_NAME[name].needs for name in found["without"] if name in BY_NAME]
    extras = {f"polhode[peers{'-fortran' * ('numbalsoda' in needs)}]" for needs in absent}
    return sorted(extras, reverse=True)


def _parted(cells: Sequence[JsonObject]) -> tuple[list[JsonObject], list[JsonObject]]:
    """The cells of many starts at once, and the others."""
    many = [cell for cell in cells if cell.get("starts")]
    return many, [cell for cell in cells if not cell.get("starts")]


def _groups(cells: Sequence[JsonObject], *names: str) -> dict[tuple[int, ...], list[JsonObject]]:
    """The cells by their numbers of these names, in order."""
    found: dict[tuple[int, ...], list[JsonObject]] = {}
    for cell in cells:
        found.setdefault(tuple(cell.get(name, 0) for name in names), []).append(cell)
    return dict(sorted(found.items()))


def levels(cells: Iterable[JsonObject]) -> Levels:
    """The cells and their levels."""
    return [(cell, level) for cell in cells for level in cell["levels"]]


def stands(found: Levels) -> dict[str, int]:
    """How often polhode is ahead, even, behind, alone, or does not reach the digits itself."""
    words = [level["verdict"]["stands"] for _, level in found]
    return {word: words.count(word) for word in WORDS}


def ratios_of(found: Levels, name: str) -> list[float]:
    """The ratios of a program, where it has one."""
    programs = [program for _, level in found for program in level["programs"]]
    named = [program["ratio"] for program in programs if program["program"] == name]
    return [ratio[0] for ratio in named if ratio is not None]


def _by_length(cells: Sequence[JsonObject]) -> Iterator[JsonObject]:
    """A row a length, number of outputs or of starts, and level, over the kinds."""
    for (end, outputs, starts), here in _groups(cells, "end", "outputs", "starts").items():
        name = f"t={end} " + (f"starts={starts}" if starts else f"outputs={outputs}")
        unit = 1e6 / starts if starts else 1e3
        for digits in [level["digits"] for level in here[0]["levels"]]:
            found = [(cell, level) for cell, level in levels(here) if level["digits"] == digits]
            yield {"cells": name, "digits": digits, **_over_kinds(found, unit)}


def _over_kinds(found: Levels, unit: float) -> JsonObject:
    """What a row says of one length and level, seconds times a unit."""
    own = [p["seconds"] for _, x in found for p in x["programs"] if p["program"] == OURS]
    met = [x["verdict"] for _, x in found if "best" in x["verdict"]]
    names = [verdict["best"] for verdict in met]
    first = sorted(set(names), key=lambda name: (-names.count(name), name))[:2]
    return {
        "own": median([unit * seconds for seconds in own if seconds], ".3g"),
        "stands": counted(stands(found)),
        "best": ", ".join(first) or DASH,
        "ratio": spread([verdict["ratio"][0] for verdict in met], ".2f"),
        **{name: spread(ratios_of(found, name), ".2f") for name in (ENGINE, RUN)},
    }


def _best(motions: Sequence[JsonObject]) -> Iterator[JsonObject]:
    """Each number type at its tightest tolerance on each motion."""
    for motion in motions:
        for method in motion["methods"]:
            points = [p for p in method["points"] if "digits" in p]
            if points:
                yield {**motion, **method, **min(points, key=lambda p: p["tol"])}


def _faults(found: JsonObject) -> list[JsonObject]:
    """What failed or was missing, each once."""
    told = {
        (name, fault): None for cell in found["cells"] for name, fault in cell["faults"].items()
    }
    told |= {
        (method["method"], f"at tolerance {point['tol']:.2g}: {point['reason']}"): None
        for motion in found["motions"]
        for method in motion["methods"]
        for point in method["points"]
        if "reason" in point
    }
    return [{"program": program, "fault": fault} for program, fault in told]

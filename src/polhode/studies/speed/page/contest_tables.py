"""Part of the page of speed: polhode beside other programs, in three tables."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from polhode.studies.page.blocks import Block, Figure, Heading, Items, Text
from polhode.studies.page.columns import Column, table
from polhode.studies.page.words import DASH, counted, median, spread
from polhode.studies.speed.page import contest
from polhode.studies.speed.page.contest import LONG, SHOWN_OUTPUTS, Levels, Told
from polhode.studies.speed.programs import ENGINE, OURS, RUN


def _first_column(header: str, way: str, clock: str) -> Column:
    """Seconds of one way by one clock; why there are none, where a program failed."""

    def value(row: Told) -> object:
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


def blocks(found: Told) -> Iterator[Block]:
    """Rules, figure and tables."""
    cells = found["cells"]
    if found["first"]:
        yield Heading("The first result in a new process")
        yield Text(
            "Seconds from the start of Python to the last state of one run (Kovalevskaya's top, t "
            "= 10, 101 outputs, tolerance 1e-9), the least of several processes: with empty "
            "caches of compiled code (cold), and with those that the first process left (warm). "
            "What numba compiles for CyRK and numbalsoda cannot be kept on disk."
        )
        rows = sorted(found["first"], key=lambda row: row.get("cold", {}).get("wall", 1e9))
        yield table(rows, _FIRST, "polhode study speed --only 'first result'")
    if not cells:
        return
    short = [cell for cell in cells if cell["end"] < LONG]
    long = [cell for cell in cells if cell["end"] >= LONG]
    yield Figure(
        "lengths",
        "The time of each program over that of a polhode propagator, to the same digits, with "
        f"{SHOWN_OUTPUTS} outputs (2 for a program that was not run with more): the median over "
        "the kinds of motion. Above 1 polhode is faster. No mark: in every kind fewer than 7 of 8 "
        "draws reach the digits, or the program was not run to that time.",
    )
    for title, here in (("A new start of a prepared body", short), ("Long runs", long)):
        if here:
            yield Heading(title)
            yield table(_by_length(here), _CELLS, "polhode study speed --only '{0}'")
    yield Text(
        "The column *stands* counts kinds of motion. *ahead*, *even*, *behind*: a polhode "
        "propagator is faster than the best of the others, ties with it (the 95 % interval of the "
        "median ratio contains 1), or is slower; *alone*: no other program reaches the digits; "
        "*not reached*: polhode itself does not reach them from 7 of 8 draws."
    )
    faults = {f"{name}: {fault}": None for cell in cells for name, fault in cell["faults"].items()}
    if faults:
        yield Text("What failed, and was counted as not reached:")
        yield Items(tuple(faults)[:20])


def _by_length(cells: Sequence[Told]) -> Iterator[Told]:
    """A row a length, number of outputs and level, over the kinds."""
    places = {(cell["end"], cell["outputs"]) for cell in cells}
    for end, outputs in sorted(places):
        here = [cell for cell in cells if (cell["end"], cell["outputs"]) == (end, outputs)]
        for digits in [level["digits"] for level in here[0]["levels"]]:
            there = [(c, x) for c in here for x in c["levels"] if x["digits"] == digits]
            yield {"cells": f"t={end} outputs={outputs}", "digits": digits, **_over_kinds(there)}


def _over_kinds(found: Levels) -> Told:
    """What a row says of one length and level."""
    own = [p["seconds"] for _, x in found for p in x["programs"] if p["program"] == OURS]
    met = [x["verdict"] for _, x in found if "best" in x["verdict"]]
    names = [verdict["best"] for verdict in met]
    first = sorted(set(names), key=lambda name: (-names.count(name), name))[:2]
    return {
        "own": median([1000 * seconds for seconds in own if seconds], ".3g"),
        "stands": counted(contest.counted(found)),
        "best": ", ".join(first) or DASH,
        "ratio": spread([verdict["ratio"][0] for verdict in met], ".2f"),
        **{name: spread(contest.ratios_of(found, name), ".2f") for name in (ENGINE, RUN)},
    }

"""Part of the page of speed: polhode beside other programs, in sentences and three tables."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, TypeAlias

from polhode.studies.page.blocks import Block, Figure, Heading, Items, Number, PageTable, Text
from polhode.studies.speed.programs import ENGINE, OURS, RUN

#: Part of the study's JSON object: the whole, a cell, a level of it.
Told: TypeAlias = dict[str, Any]

LONG = 1000  # from this end on a run is told as a long one
SHOWN_OUTPUTS = 101  # of the figure
_UNCOUNTED = "Cells in which it does not reach the digits itself are not among them."
WORDS = ("ahead", "even", "behind", "alone", "not reached")


def finding(found: Told) -> str:
    """What the cells and the first results say, in sentences made of them."""
    cells = found["cells"]
    if not cells:
        return str(found["question"])
    told = [_conditions(found)]
    told += [
        _stands(
            cells, "From t = 100 on, to 9 and 12 digits,", lambda c, d: c["end"] >= 100 and d > 6
        ),
        _stands(cells, "from t = 1000 on, to 6,", lambda c, d: c["end"] >= LONG and d == 6),
        _stands(cells, "at t = 1 and 10, to 6,", lambda c, d: c["end"] <= 10 and d == 6),
        _stands(cells, "and there to 9 and 12", lambda c, d: c["end"] <= 10 and d > 6),
    ]
    sentences = [told[0], "; ".join(text for text in told[1:] if text) + ".", _UNCOUNTED]
    sentences += [_losses(cells), _engine(cells), _trajectories(cells), _compensated(cells)]
    sentences += [_first(found["first"]), _absent(found)]
    return " ".join(text for text in sentences if text)


def brief(found: Told) -> str:
    """The same in a sentence."""
    cells = found["cells"]
    told = [
        _stands(cells, "to 6, 9 and 12 digits from t = 100 on", lambda c, _: c["end"] >= 100),
        _stands(cells, "at t = 1 and 10", lambda c, _: c["end"] <= 10),
    ]
    return "; ".join(text for text in told if text).capitalize() + "."


def headline(found: Told) -> Number | None:
    """How often a propagator is ahead, in long runs and in short ones."""
    cells = found["cells"]
    long, short = (
        _ahead(cells, wanted)
        for wanted in (lambda c, _: c["end"] >= 100, lambda c, _: c["end"] <= 10)
    )
    if not long[1]:
        return None
    words = (
        "cells of the speed study from t = 100 on, to 6, 9 and 12 digits, in which a polhode "
        f"propagator is ahead of every other program; at t = 1 and 10 {short[0]} of {short[1]}"
    )
    return Number(f"{long[0]} of {long[1]}", words)


def short(found: Told) -> str:
    """The same in a paragraph: where polhode is ahead, where it is not, beside its own engine."""
    cells = found["cells"]
    told = [
        _stands(cells, "from t = 100 on", lambda c, _: c["end"] >= 100),
        _stands(cells, "at t = 1 and 10", lambda c, _: c["end"] <= 10),
    ]
    sentences = [
        "Every program prepared once and given a new start each time, to 6, 9 and 12 digits,",
        "; ".join(text for text in told if text) + ".",
        *(_losses(cells), _engine(cells), _absent(found)),
    ]
    return " ".join(text for text in sentences if text)


def blocks(found: Told) -> Iterator[Block]:
    """Rules, figure and tables."""
    cells = found["cells"]
    if found["first"]:
        yield Heading("The first result in a new process")
        yield Text(
            "Seconds from the start of Python to the last state of one run (Kovalevskaya's top, "
            "t = 10, 101 outputs, tolerance 1e-9), the least of several processes: with empty "
            "caches of compiled code (cold), and with those that the first process left (warm). "
            "What numba compiles round CyRK and numbalsoda cannot be kept on disk."
        )
        yield _first_table(found["first"])
    if not cells:
        return
    short = [cell for cell in cells if cell["end"] < LONG]
    long = [cell for cell in cells if cell["end"] >= LONG]
    yield Figure(
        "lengths",
        "The time of each program over that of a polhode propagator, to the same digits, with "
        f"{SHOWN_OUTPUTS} outputs (2 where a program was not run with more): the median over the "
        "kinds of motion; above 1 polhode is faster. No mark: fewer than 7 of 8 draws reach the "
        "digits in every kind, or the program was not run so far.",
    )
    for title, here in (("A new start of a prepared body", short), ("Long runs", long)):
        if here:
            yield Heading(title)
            yield _table(here)
    yield Text(
        "*ahead*, *even*, *behind*: of the kinds of motion in which polhode reaches the digits, "
        "how many a propagator wins, ties (the 95 % interval of the median ratio holds 1) or loses "
        "against the best of the others; *alone*: no other reaches them. A kind in which polhode "
        "itself does not reach them from 7 of 8 draws counts as *not reached*. Ratios are times "
        "over the propagator's, the median over the kinds, and the least and most."
    )
    faults = {f"{name}: {fault}": None for cell in cells for name, fault in cell["faults"].items()}
    if faults:
        yield Text("What failed, and was counted as not reached:")
        yield Items(tuple(faults)[:20])


def _conditions(found: Told) -> str:
    kinds = list(dict.fromkeys(cell["kind"] for cell in found["cells"]))
    draws = found["cells"][0]["draws"]
    return (
        f"Every program is prepared once and called with a new start each time, {draws} bodies of "
        f"each of {len(kinds)} kinds ({', '.join(kinds)}); ratios are of processor time to the "
        "same digits, side by side in one process."
    )


def levels(cells: Iterable[Told], wanted: Callable[[Told, float], bool]) -> list[tuple[Told, Told]]:
    """The cells and their levels that are wanted."""
    return [(c, x) for c in cells for x in c["levels"] if wanted(c, x["digits"])]


def counted(found: Sequence[tuple[Told, Told]]) -> dict[str, int]:
    """How often polhode is ahead, even, behind, alone, or does not reach the digits itself."""
    stands = [level["verdict"]["stands"] for _, level in found]
    return {word: stands.count(word) for word in WORDS}


def _stands(cells: Sequence[Told], where: str, wanted: Callable[[Told, float], bool]) -> str:
    """In how many of the cells a propagator is ahead of all others, where it reaches the digits."""
    count = counted(levels(cells, wanted))
    ahead, reached = _ahead(cells, wanted)
    if not reached:
        return ""
    text = f"{where} a polhode propagator is ahead of every other program in {ahead} of "
    text += f"{reached} cells"
    more = [f"{count[word]} {word}" for word in ("even", "behind") if count[word]]
    return f"{text} ({', '.join(more)})" if more else text


def _ahead(cells: Sequence[Told], wanted: Callable[[Told, float], bool]) -> tuple[int, int]:
    """In how many cells it is ahead, of how many in which it reaches the digits."""
    here = levels(cells, wanted)
    count = counted(here)
    return count["ahead"] + count["alone"], len(here) - count["not reached"]


def _losses(cells: Sequence[Told]) -> str:
    """Where it is behind: by whom, and by how much."""
    lost = [
        (cell, level["verdict"])
        for cell, level in levels(cells, lambda c, d: True)
        if level["verdict"]["stands"] == "behind"
    ]
    if not lost:
        return ""
    told = []
    for end in sorted({cell["end"] for cell, _ in lost}):
        here = [verdict for cell, verdict in lost if cell["end"] == end]
        worst = min(here, key=lambda verdict: verdict["ratio"][0])
        middle = statistics.median(verdict["ratio"][0] for verdict in here)
        told.append(f"{middle:.2f} at t = {end} ({worst['best']} {worst['ratio'][0]:.2f})")
    return (
        f"Where it is behind, the best takes, in the median and at the least, {', '.join(told)} of "
        "its time."
    )


def _engine(cells: Sequence[Told]) -> str:
    """polhode beside heyoka written by hand."""
    told = []
    for end in sorted({cell["end"] for cell in cells}):
        ratios = [
            1 / program["ratio"][0]
            for cell in cells
            if cell["end"] == end
            for level in cell["levels"]
            for program in level["programs"]
            if program["program"] == ENGINE and program["ratio"] is not None
        ]
        if ratios:
            told.append(f"{statistics.median(ratios):.2f} (at most {max(ratios):.2f}) at t = {end}")
    if not told:
        return ""
    text = "heyoka written by hand is polhode's own engine; a propagator takes "
    return f"{text}{', '.join(told)} of its time."


def _trajectories(cells: Sequence[Told]) -> str:
    """What a trajectory of ``integrate`` costs more than a propagator's states."""
    more = {}
    for end in sorted({cell["end"] for cell in cells}):
        found = [
            1000 * (run["seconds"] - ours["seconds"])
            for cell in cells
            if cell["end"] == end and cell["outputs"] == 2
            for level in cell["levels"]
            for ours, run in [_both(level)]
            if ours["seconds"] and run["seconds"]
        ]
        if found and end <= 100:
            more[end] = statistics.median(found)
    if not more:
        return ""
    told = f"{min(more.values()):.2f} to {max(more.values()):.2f}"
    return (
        f"`polhode.integrate`, which makes a trajectory with its checks, costs {told} ms a run "
        "more with a new start."
    )


def _both(level: Told) -> tuple[Told, Told]:
    by_name = {program["program"]: program for program in level["programs"]}
    nothing = {"seconds": None}
    return by_name.get(OURS, nothing), by_name.get(RUN, nothing)


def _compensated(cells: Sequence[Told]) -> str:
    """The program that keeps digits where others lose them."""
    name = "splitting 8 compensated"
    met = [
        (cell, program)
        for cell, level in levels(cells, lambda c, d: c["end"] >= LONG and d == 12)
        for program in level["programs"]
        if program["program"] == name
    ]
    if not met:
        return ""
    reached, asked = sum(p["reached"] for _, p in met), sum(cell["draws"] for cell, _ in met)
    ratios = [program["ratio"][0] for _, program in met if program["ratio"] is not None]
    text = f"To 12 digits from t = {LONG} on {name} arrives in {reached} of {asked} runs"
    if ratios:
        text += f", in {statistics.median(ratios):.2g} times polhode's time where both do"
    return f"{text}."


def _first(rows: Sequence[Told]) -> str:
    """The first result of each program, from the fastest on."""
    there = sorted((row["cold"]["wall"], row["program"]) for row in rows if "cold" in row)
    told = ", ".join(f"{name} {seconds:.2g}" for seconds, name in there)
    return (
        f"The first result in a new process, in seconds with nothing compiled before: {told}."
        * bool(told)
    )


def _absent(found: Told) -> str:
    return f"Not run: {', '.join(found['without'])}." if found["without"] else ""


def _first_table(rows: Sequence[Told]) -> PageTable:
    """Wall and processor seconds, cold and warm."""
    made = [
        (
            row["program"],
            *(
                f"{row[word][clock]:.2f}" if word in row else row["fault"] or "–"
                for word in ("cold", "warm")
                for clock in ("wall", "processor")
            ),
        )
        for row in sorted(rows, key=lambda row: row.get("cold", {}).get("wall", 1e9))
    ]
    header = ("program", "cold, s", "processor", "warm, s", "processor")
    return PageTable(header, tuple(made), "lrrrr", "polhode study speed --only 'first result'")


def _table(cells: Sequence[Told]) -> PageTable:
    """A row a length, number of outputs and level, over the kinds."""
    rows = []
    places = list(dict.fromkeys((cell["end"], cell["outputs"]) for cell in cells))
    for end, outputs in sorted(places):
        here = [cell for cell in cells if (cell["end"], cell["outputs"]) == (end, outputs)]
        for digits in [level["digits"] for level in here[0]["levels"]]:
            there = [(c, x) for c in here for x in c["levels"] if x["digits"] == digits]
            rows.append((f"t={end} outputs={outputs}", f"{digits:g}", *_cells(there)))
    header = ("cells", "digits", "propagator, ms", "stands", "best other", "its ratio", ENGINE, RUN)
    return PageTable(header, tuple(rows), "lrrllrrr", "polhode study speed --only '{0}'")


def _cells(found: Sequence[tuple[Told, Told]]) -> Iterator[str]:
    """What a row says of one length and level."""
    own = [p["seconds"] for _, x in found for p in x["programs"] if p["program"] == OURS]
    there = [1000 * seconds for seconds in own if seconds]
    yield f"{statistics.median(there):.3g}" if there else "–"
    count = counted(found)
    yield ", ".join(f"{n} {word}" for word, n in count.items() if n)
    met = [x["verdict"] for _, x in found if "best" in x["verdict"]]
    names = [verdict["best"] for verdict in met]
    yield ", ".join(sorted(set(names), key=lambda name: (-names.count(name), name))[:2]) or "–"
    yield _spread([verdict["ratio"][0] for verdict in met])
    for name in (ENGINE, RUN):
        yield _spread(
            [
                p["ratio"][0]
                for _, x in found
                for p in x["programs"]
                if p["program"] == name and p["ratio"] is not None
            ]
        )


def _spread(ratios: Sequence[float]) -> str:
    if not ratios:
        return "–"
    if len(ratios) == 1:
        return f"{ratios[0]:.2f}"
    return f"{statistics.median(ratios):.2f} ({min(ratios):.2f}–{max(ratios):.2f})"

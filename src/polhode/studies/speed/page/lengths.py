"""Part of the page of speed: work against precision over run length and number of outputs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from polhode.studies.page.blocks import Block, Figure, Heading, PageTable, Text
from polhode.studies.speed.page import caveats

OURS, ENGINE = "polhode", "heyoka alone"
SHOWN = 9.0  # digits of the figure
LONG, ACCURATE = 1000, 9.0  # the runs on which the rows decide who is ahead
NEARLY_ALL = 7 / 8  # of the starts


class Closest(NamedTuple):
    """The peer that comes closest to polhode in a cell, or is furthest ahead of it."""

    factor: float
    least: float
    most: float
    method: str


def blocks(cells: Sequence[caveats.Told]) -> Iterator[Block]:
    """Heading, claims, figure and tables; nothing where no cell was run."""
    if not cells:
        return
    starts = max(cell["starts"] for cell in cells)
    above = max(cell.get("once_above", 0.0) for cell in cells)
    once = f"; a run of more than {above:g} seconds is made once, whoever makes it" if above else ""
    yield Heading("Over run length and number of outputs")
    yield Text(
        f"One random body of each kind from {starts} random starts, all numbers decimals of two "
        "places. Every method runs at several tolerances; the seconds for so many digits are read "
        "from each start's own curve (below its first point, the first point's), and divided by "
        "polhode's on the same start. Runs are judged at eleven even times, those with two outputs "
        f"at the end; integrators are made before, and a scene's first run does not count{once}."
    )
    if _peers(cells):
        yield Text(others(cells))
        yield Figure(
            "lengths",
            f"Seconds to {SHOWN:g} digits over the length of a run with eleven outputs: median and "
            "a bar over the starts; no mark: not every start reaches them, or the method was not "
            f"run so far. {caveats.CYRK_DRAWN}",
        )
    yield _every(cells)
    told = {f"{name}: {fault}": None for cell in cells for name, fault in cell["faults"].items()}
    if told:
        yield Text("Not all runs came back: " + "; ".join(told) + ".")


def others(cells: Sequence[caveats.Told]) -> str:
    """Which programs polhode is compared with, and how far each was run."""
    ran: dict[str, list[caveats.Told]] = {}
    for cell in cells:
        for method in cell["levels"][0]["methods"]:
            ran.setdefault(method["method"], []).append(cell)
    told = []
    for name, here in ran.items():
        if _is_peer(name):
            outputs = sorted({cell["outputs"] for cell in here})
            all_of_them = outputs == sorted({cell["outputs"] for cell in cells})
            some = "" if all_of_them else f" with {', '.join(map(str, outputs))} outputs"
            told.append(f"{name} to t = {max(cell['end'] for cell in here)}{some}")
    text = f"The other programs here: {'; '.join(told)}."
    if ENGINE in ran:
        text += (
            " heyoka written by hand, polhode's own engine, is none of them; its factors are in "
            "the table."
        )
    return text


def stands(cells: Sequence[caveats.Told]) -> str:
    """Where polhode is ahead of every peer, of what the rows can decide: long, accurate runs.

    A cell counts where polhode itself arrives from nearly every start; a peer wherever it arrives
    from one.
    """
    found = [
        closest(cell, level)
        for cell in cells
        for level in _levels([cell])
        if cell["end"] >= LONG and level >= ACCURATE and _raced(cell, level)
    ]
    if not found:
        return "No run here is long and accurate enough to compare."
    won = sum(map(ahead, found))
    where = "in every cell where" if won == len(found) else f"in {won} of {len(found)} cells where"
    text = (
        f"From t = {LONG} on and to {ACCURATE:g} digits and more polhode is ahead of every program "
        f"tried but heyoka, its own engine, {where} it arrives itself from nearly every start"
    )
    if met := [x for x in found if x is not None]:
        best = min(met)
        text += f": {best.method}, the closest, takes {best.factor:.2g} times as long"
    return f"{text}. {caveats.SMALLER}"


def beside_engine(cells: Sequence[caveats.Told]) -> str:
    """polhode's time over that of heyoka written by hand, medians, by length of the run."""
    told: list[str] = []
    for end in sorted({cell["end"] for cell in cells}):
        here = [
            1 / m["factor"][0]
            for cell in cells
            for level in _levels([cell])
            for m in _methods(cell, level)
            if cell["end"] == end and cell["outputs"] > 2 and _is_engine(m)
        ]
        if here:
            long = " times as long" * (not told)
            told.append(f"{min(here):.2g} to {max(here):.2g}{long} at t = {end}")
    if not told:
        return ""
    text = "Beside heyoka written by hand polhode takes, to the same digits and with more than two "
    return (
        f"{text}outputs, {', '.join(told)}: a short run pays most for what surrounds the steps. "
        f"{caveats.BUILDS} {caveats.TWO_OUTPUTS}; those cells are left out."
    )


def closest(cell: caveats.Told, level: float) -> Closest | None:
    """The fastest peer at a level, by the median over the starts; None where none reaches it."""
    rows = [m for m in _methods(cell, level) if _is_peer(m["method"]) and m["factor"] is not None]
    found = ((*m["factor"], m["method"]) for m in rows)
    return min((Closest(*parts) for parts in found), default=None)


def ahead(peer: Closest | None) -> bool:
    """Whether polhode is faster than the fastest peer of a cell."""
    return peer is None or peer.factor > 1


def _raced(cell: caveats.Told, level: float) -> bool:
    """Whether polhode nearly always reaches the level and a peer was here, arriving or not."""
    methods = _methods(cell, level)
    most = NEARLY_ALL * cell["starts"]
    ours = any(m["method"] == OURS and m["reached"] >= most for m in methods)
    return ours and any(_is_peer(m["method"]) for m in methods)


def _every(cells: Sequence[caveats.Told]) -> PageTable:
    """Milliseconds of every method in every cell: median, and least to most over the starts."""
    names = list(dict.fromkeys(m["method"] for c in cells for m in c["levels"][0]["methods"]))
    rows = []
    for cell in cells:
        for level in cell["levels"]:
            found = {m["method"]: m for m in level["methods"]}
            label = f"{cell['kind']} t={cell['end']} outputs={cell['outputs']}"
            shown = (_cell(found.get(name), cell["starts"]) for name in names)
            rows.append((label, f"{level['digits']:g}", *shown))
    header = ("row", "digits", *(f"{name}, ms" for name in names))
    again = "polhode study speed --only '{0}'"
    return PageTable(header, tuple(rows), "lr" + "r" * len(names), again)


def _cell(method: caveats.Told | None, starts: int) -> str:
    if method is None:
        return "–"
    if method["seconds"] is None:
        return "not reached"
    middle, least, most = (1000 * x for x in method["seconds"])
    told = f"{middle:.3g} ({least:.3g}–{most:.3g})"
    if method["factor"] is not None:
        told += f" ×{method['factor'][0]:.2f}"
    return told if method["reached"] == starts else f"{told}, {method['reached']} starts"


def _levels(cells: Sequence[caveats.Told]) -> list[float]:
    return [level["digits"] for level in cells[0]["levels"]]


def _methods(cell: caveats.Told, level: float) -> list[caveats.Told]:
    found: list[caveats.Told]
    (found,) = (x["methods"] for x in cell["levels"] if x["digits"] == level)
    return found


def _peers(cells: Sequence[caveats.Told]) -> bool:
    return any(_is_peer(m["method"]) for c in cells for m in c["levels"][0]["methods"])


def _is_engine(method: caveats.Told) -> bool:
    return method["method"] == ENGINE and method["factor"] is not None


def _is_peer(name: str) -> bool:
    return name not in (OURS, ENGINE)

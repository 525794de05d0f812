"""Part of the page of speed: work against precision over run length and number of outputs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from polhode.studies.page.blocks import Block, Figure, Heading, PageTable, Text

OURS, ENGINE = "polhode", "heyoka alone"
SHOWN = 9.0  # digits of the figure
LEVELS = (6.0, 9.0, 12.0)  # digits of the finding and the README's sentences


class Closest(NamedTuple):
    """The peer that comes closest to polhode in a cell, or is furthest ahead of it."""

    factor: float
    least: float
    most: float
    method: str


def blocks(cells: Sequence[dict[str, Any]]) -> Iterator[Block]:
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
        for level in _levels(cells):
            yield Text(claim(cells, level))
        yield _overview(cells)
        yield Figure(
            "lengths",
            f"Seconds to {SHOWN:g} digits over the length of a run with eleven outputs: median and "
            "a bar over the starts; no mark: not every start reaches them, or the method was not "
            "run so far",
        )
    yield _every(cells)
    told = {f"{name}: {fault}": None for cell in cells for name, fault in cell["faults"].items()}
    if told:
        yield Text("Not all runs came back: " + "; ".join(told) + ".")


def others(cells: Sequence[dict[str, Any]]) -> str:
    """Which programs polhode is compared with, and how far each was run."""
    ran: dict[str, list[dict[str, Any]]] = {}
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


def claim(cells: Sequence[dict[str, Any]], level: float) -> str:
    """At one level, in how many cells of each length polhode's median is ahead of every peer."""
    told: list[str] = []
    behind: list[Closest] = []
    alone = 0
    for end in sorted({cell["end"] for cell in cells}):
        found = race([cell for cell in cells if cell["end"] == end], level)
        if found:
            cells_here = f"{sum(map(ahead, found))} of {len(found)}"
            cells_here += " cells of body and outputs" * (not told)
            told.append(f"{cells_here} at t = {end}")
        behind += [x for x in found if x is not None and not ahead(x)]
        alone += found.count(None)
    if not told:
        return f"At {level:g} digits no other program was here to compare with."
    text = f"At {level:g} digits polhode's median is ahead of every other program run in "
    text += ", ".join(told)
    if behind:
        names = ", ".join(sorted({x.method for x in behind}))
        least, most = min(x.factor for x in behind), max(x.factor for x in behind)
        between = f"{least:.2f}" if least == most else f"{least:.2f} to {most:.2f}"
        text += f"; in the others the fastest ({names}) takes {between} of its time"
    if alone:
        text += f"; in {alone} of these cells no other program reaches so many digits"
    return text + "."


def finding(cells: Sequence[dict[str, Any]]) -> str:
    """At every level, in how many cells polhode's median is ahead; where heyoka alone is, too."""
    told = []
    for level in LEVELS:
        found = race(cells, level)
        if found:
            none = found.count(None)
            alone = f" (in {none} no other reaches them)" if none else ""
            told.append(f"{sum(map(ahead, found))} of {len(found)} at {level:g} digits{alone}")
    if not told:
        return "No other program was here to compare with."
    text = "Polhode's median is ahead of every other program run in so many cells of body, length "
    text += f"and number of outputs: {', '.join(told)}"
    return f"{text}. {beside_engine(cells)}".strip()


def beside_engine(cells: Sequence[dict[str, Any]]) -> str:
    """polhode's time over that of heyoka written by hand, medians, by length of the run."""
    told: list[str] = []
    for end in sorted({cell["end"] for cell in cells}):
        here = [
            1 / m["factor"][0]
            for cell in cells
            for level in _levels([cell])
            for m in _methods(cell, level)
            if cell["end"] == end and m["method"] == ENGINE and m["factor"] is not None
        ]
        if here:
            long = " times as long" * (not told)
            told.append(f"{min(here):.2g} to {max(here):.2g}{long} at t = {end}")
    if not told:
        return ""
    text = "Beside heyoka written by hand polhode takes, to the same digits, "
    return f"{text}{', '.join(told)}: a short run pays most for what surrounds the steps."


def closest(cell: dict[str, Any], level: float) -> Closest | None:
    """The fastest peer at a level, by the median over the starts; None where none reaches it."""
    rows = [m for m in _methods(cell, level) if _is_peer(m["method"]) and m["factor"] is not None]
    found = ((*m["factor"], m["method"]) for m in rows)
    return min((Closest(*parts) for parts in found), default=None)


def race(cells: Sequence[dict[str, Any]], level: float) -> list[Closest | None]:
    """Of each cell in which polhode and another program ran, the fastest peer."""
    return [closest(cell, level) for cell in cells if _raced(cell, level)]


def ahead(peer: Closest | None) -> bool:
    """Whether polhode is faster than the fastest peer of a cell."""
    return peer is None or peer.factor > 1


def _raced(cell: dict[str, Any], level: float) -> bool:
    """Whether polhode reaches the level and a peer was here, whether or not that one did."""
    methods = _methods(cell, level)
    ours = any(m["method"] == OURS and m["seconds"] is not None for m in methods)
    return ours and any(_is_peer(m["method"]) for m in methods)


def _overview(cells: Sequence[dict[str, Any]]) -> PageTable:
    """For each length and number of outputs how many bodies polhode is ahead on, at each level."""
    lengths = sorted({(cell["end"], cell["outputs"]) for cell in cells})
    levels = _levels(cells)
    rows = []
    for end, outputs in lengths:
        here = [c for c in cells if (c["end"], c["outputs"]) == (end, outputs)]
        rows.append((str(end), str(outputs), *(_race(here, level) for level in levels)))
    header = ("t", "outputs", *(f"{level:g} digits" for level in levels))
    again = "polhode study speed --only 't={0} outputs={1}'"
    return PageTable(header, tuple(rows), "rr" + "l" * len(levels), again)


def _race(cells: Sequence[dict[str, Any]], level: float) -> str:
    found = race(cells, level)
    if not found:
        return "–"
    told = f"ahead on {sum(map(ahead, found))} of {len(found)} bodies"
    best = min((x for x in found if x is not None), default=None)
    return told if best is None else f"{told}; {best.method} ×{best.factor:.2f}"


def _every(cells: Sequence[dict[str, Any]]) -> PageTable:
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


def _cell(method: dict[str, Any] | None, starts: int) -> str:
    if method is None:
        return "–"
    if method["seconds"] is None:
        return "not reached"
    middle, least, most = (1000 * x for x in method["seconds"])
    told = f"{middle:.3g} ({least:.3g}–{most:.3g})"
    if method["factor"] is not None:
        told += f" ×{method['factor'][0]:.2f}"
    return told if method["reached"] == starts else f"{told}, {method['reached']} starts"


def _levels(cells: Sequence[dict[str, Any]]) -> list[float]:
    return [level["digits"] for level in cells[0]["levels"]]


def _methods(cell: dict[str, Any], level: float) -> list[dict[str, Any]]:
    found: list[dict[str, Any]]
    (found,) = (x["methods"] for x in cell["levels"] if x["digits"] == level)
    return found


def _peers(cells: Sequence[dict[str, Any]]) -> bool:
    return any(_is_peer(m["method"]) for c in cells for m in c["levels"][0]["methods"])


def _is_peer(name: str) -> bool:
    return name not in (OURS, ENGINE)

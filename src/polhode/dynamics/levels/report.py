"""The levels of a body for people: special points, branches, and where the scene lies."""

from __future__ import annotations

from typing import Any

from polhode.common.errors import aligned
from polhode.numbers.decimals import shown


def report(levels: Any, topology: str) -> str:
    """Two tables, and lines about the scene, of levels; ``topology``: of the scene's."""
    lines: list[str] = []
    rows = [
        [mark.kind, mark.family, *(f"{float(x):.12g}" for x in (mark.parameter, mark.f, mark.h))]
        for mark in levels.marks
    ]
    if rows:
        lines += aligned(["special point", "family", "s or om", "f", "h"], rows)
    rows = [
        [
            curve.family + ("" if curve.axis is None else f" (axis {curve.axis + 1})"),
            curve.type + (", Liapunov stable" if curve.morse == 0 else ""),
            "-inf" if curve.first is None else f"{float(curve.first):.6g}",
            "inf" if curve.last is None else f"{float(curve.last):.6g}",
        ]
        for curve in levels.curves
    ]
    lines += aligned(["permanent rotations", "type", "from s or om", "to"], rows)
    here = levels.here
    edges = "" if here.region is None else f": edges {', '.join(map(str, here.region))}"
    least = f"least h at this f {here.least:.12g}"
    lines.append(f"scene  f = {shown(here.f)}, h = {shown(here.h)}, {least}")
    lines.append(f"level  {topology}{edges}{here.remark and f' ({here.remark})'}")
    if here.fourth is not None:
        lines.append(f"fourth integral  {here.fourth.name} = {here.fourth.value:.12g}; critical:")
        lines += (f"  {value.value:<20.12g}{value.what}" for value in here.fourth.critical)
    if not levels.exact:
        lines.append("irrational numbers of the body, or h and f, were rounded to 1024 bits")
    return "\n".join(lines)

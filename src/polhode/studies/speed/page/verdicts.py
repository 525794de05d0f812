"""Part of the page of speed: polhode's double curve against every other program's, and heyoka's."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from polhode.studies.page.blocks import Block, Heading, Items, PageTable, Text, or_dash
from polhode.studies.speed.page import caveats


def blocks(found: dict[str, Any]) -> Iterator[Block]:
    """Who is ahead, at what factor, and what polhode's runs cost beside heyoka's."""
    yield from _target(found)
    yield from _verdicts(found["motions"])
    yield from _engine(found["motions"])


def _target(found: dict[str, Any]) -> Iterator[Block]:
    """Where a peer is ahead as it was called, and where polhode ends above its floor."""
    target = found["target"]
    if target["ahead"] is None:
        return
    yield Heading("From 1e-6 down to three times kappa·eps")
    if target["behind"]:
        yield Text("On the regular motions another is ahead of polhode's double curve here:")
        yield Items(tuple(behind(found)))
    if not target["reaches_floor"]:
        short = [
            f"{m['motion']} {m['verdict']['reach']:.1f} of {m['verdict']['to_digits']:.1f}"
            for m in found["motions"]
            if m["kind"] == "regular" and "verdict" in m and not m["verdict"]["reaches_floor"]
        ]
        yield Text("It ends above three times kappa·eps on (digits): " + ", ".join(short) + ".")


def behind(found: dict[str, Any]) -> list[str]:
    """Where it is not, a line a motion and peer."""
    return [_behind(row) for row in found["target"]["behind"]]


def _behind(row: dict[str, Any]) -> str:
    if row["least_factor"] is not None and row["least_factor"] <= 1:
        return (
            f"{row['motion']}, {row['method']}: it takes {row['least_factor']:.3g} of our time at "
            f"{row['at_digits']:.1f} digits"
        )
    return f"{row['motion']}, {row['method']}: it reaches {row['short']:.2f} digits more"


def _verdicts(motions: list[dict[str, Any]]) -> Iterator[Block]:
    """The peers' seconds over ours at equal digits, where they are closest to ours."""
    judged = [m for m in motions if "verdict" in m]
    if not judged:
        return
    names = list(dict.fromkeys(row["method"] for m in judged for row in m["verdict"]["peers"]))
    rows = []
    for name in names:
        cells = []
        for motion in judged:
            row = next((r for r in motion["verdict"]["peers"] if r["method"] == name), None)
            cells.append(_factor(row))
        rows.append((name, *cells))
    yield Text(
        "Seconds of each peer over those of polhode's double curve at equal digits, at the level "
        "where the peer is closest (in brackets); *not reached*: it has fewer than six digits. "
        f"{caveats.CYRK_DRAWN}."
    )
    header = ("peer", *(m["motion"] for m in judged))
    again = "polhode study speed --only 'every motion' --only '{0}'"
    yield PageTable(header, tuple(rows), "l" + "r" * len(judged), again)


def _factor(row: dict[str, Any] | None) -> str:
    if row is None:
        return "–"
    if row["least_factor"] is None:
        return "not reached"
    return f"{row['least_factor']:.3g} ({row['at_digits']:.1f})"


def _engine(motions: list[dict[str, Any]]) -> Iterator[Block]:
    rows = []
    for motion in motions:
        for name, row in motion.get("verdict", {}).get("engine", {}).items():
            rows.append(
                (
                    motion["motion"],
                    name,
                    f"{row['overhead_least']:.2f}",
                    f"{row['overhead_most']:.2f}",
                    f"{row['overhead_tightest']:.2f}",
                    or_dash(row["seconds_more"], ".3g"),
                    or_dash(row.get("steps_tightest"), ".2f"),
                    f"{row['digits_gained']:+.1f}",
                )
            )
    if rows:
        yield Heading("Against heyoka alone")
        yield Text(
            "Seconds over those of heyoka written by hand at equal tolerance: least and most over "
            "all tolerances, at eps, and the least difference, which is what a run costs however "
            "short it is; its steps at eps, over heyoka's: polhode measures time in a unit in "
            "which w is of the size of gamma, and steps are as accurate as the largest variable "
            f"asks; digits gained over heyoka's best. {caveats.BUILDS}"
        )
        header = ("motion", "method", "least", "most", "at eps", "s more", "steps", "digits gained")
        again = "polhode study speed --only '{0}' --only 'heyoka alone'"
        yield PageTable(header, tuple(rows), "llrrrrrr", again)

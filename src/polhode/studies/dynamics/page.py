"""Page of the study of dynamics."""

from __future__ import annotations

from collections.abc import Iterator

from polhode.output.json_object import JsonObject
from polhode.studies.page.blocks import Block, Figure, Heading, Text
from polhode.studies.page.columns import CASE, END, OUTCOME, Column, F, H, table
from polhode.studies.page.words import DASH, sentence

TITLE = "Dynamics: levels, sections, chaos"

_OURS = "polhode, batches"
_LEVELS = (
    Column("body", "what"),
    CASE,
    Column("pieces", "arcs", "d", "arcs of permanent rotations, each of one type"),
    Column("stable", "stable", "d", "pieces whose rotations are stable by Liapunov"),
    Column("cusps", "cusps", "d", "cusps of the curves"),
    Column("Hamiltonian-Hopf", "hopf", "d", "points where two frequencies of a rotation meet"),
    Column("branches", "branches", "d", "points where a second family leaves the first"),
    F._replace(header="case's f"),
    H,
    Column("its level", "topology", meaning="the topology of the level with the case's f and h"),
    Column("fourth integral", "fourth", meaning="the body's fourth integral, where there is one"),
    Column(
        "critical values",
        lambda row: ", ".join(f"{x:.4g}" for x in row["critical"]) or DASH,
        meaning="the fourth integral's critical values on that level",
    ),
    Column("seconds", "seconds", ".2f"),
)
_SECTIONS = (
    Column("top", "what"),
    CASE,
    F,
    H,
    Column("integral", "integral", meaning="the fourth integral"),
    Column("orbits", "orbits", "d"),
    Column("crossings each", "crossings", "d"),
    END,
    Column("spread", "spread", ".1e", "largest difference of the integral along one orbit"),
    Column("in eps", "spread_in_eps", ".2f", "the same in eps of the integral's largest value"),
    Column("fewest digits", "digits.0", ".1f", "fewest correct digits stated of a crossing"),
    Column("median of the last", "digits.1", ".1f", "the median at the orbits' last crossings"),
)
_MAP = (
    Column("C", "C", ">", "the third principal moment"),
    Column("integrable body", "what"),
    Column("motions", "motions", "d", "starts with different spins"),
    Column("regular", "counts.0", "d"),
    Column("undecided", "counts.1", "d"),
    Column("chaotic", "counts.2", "d"),
)
_COST = (
    Column("program", "program"),
    Column("orbits", "orbits", "d"),
    Column("crossings", "crossings", "d"),
    Column("µs a crossing", "microseconds", ".3g", "processor time"),
    Column("beside polhode's batches", "ratio", ".3g", "that time over that of the batches"),
    Column(
        "error of the last time",
        "error",
        ".1e",
        "of the last crossing's time, beside a run in quad",
    ),
    Column("digits, µs a crossing", "digits_microseconds", ".3g", "added by stating the digits"),
    OUTCOME,
)


def blocks(found: JsonObject) -> Iterator[Block]:
    """The study's page from its JSON object."""
    if found["levels"]:
        yield from _levels(found["levels"])
    if found["sections"]:
        yield from _sections(found["sections"])
    for row in found["maps"]:
        yield from _map(row)
    if found["cost"]:
        yield from _cost(found["cost"])


def finding(found: JsonObject) -> str:
    """The study in a sentence."""
    told = []
    if found["sections"]:
        worst = max(found["sections"], key=lambda row: row["spread_in_eps"])
        told.append(
            f"on sections of {len(found['sections'])} integrable tops the fourth integral varies "
            f"along no orbit by more than {worst['spread_in_eps']:.1f} eps of its largest value, "
            f"in {worst['crossings']} crossings"
        )
    for row in found["maps"]:
        chaotic = sum(column["counts"][2] for column in row["columns"])
        motions = sum(column["motions"] for column in row["columns"])
        told.append(
            f"of {motions} motions of integrable bodies {chaotic} are found chaotic, and of all "
            f"{sum(row['counts'].values())} motions on a map across these bodies "
            f"{row['counts']['chaotic']}"
        )
    rows = {row["program"]: row for row in _beside_ours(found["cost"]) if "ratio" in row}
    ours = rows.pop(_OURS, None)
    if ours is not None and rows:
        alone = sorted((row["microseconds"], name) for name, row in rows.items())
        told.append(
            "a crossing of one orbit takes, in µs, "
            + ", ".join(f"{microseconds:.0f} ({name})" for microseconds, name in alone)
            + f"; in batches of {ours['orbits']} orbits polhode takes {ours['microseconds']:.3g}"
        )
    text = "; ".join(told)
    return f"{sentence(text)}." if text else ""


def _levels(rows: list[JsonObject]) -> Iterator[Block]:
    yield Heading("Levels of energy and area")
    yield Text(
        "The curves are permanent rotations, thick where they are stable by Liapunov. They divide "
        "the plane of f and h into regions; all levels of a region have the same topology. Types, "
        "cusps and Hamiltonian-Hopf points are decided by exact arithmetic, without integration. "
        "The dot is the level of the case."
    )
    shown = f"The plane of f and h of {len(rows)} bodies, regions by topology"
    yield Figure("dynamics-levels", shown)
    yield table(rows, _LEVELS, "polhode study dynamics --only 'levels {0}'")


def _sections(rows: list[JsonObject]) -> Iterator[Block]:
    yield Heading("Sections of integrable tops, beside their exact curves")
    yield Text(
        "Crossings at the maxima of |G|, in Andoyer's l and L/G. The thin curves beneath them "
        "need no run: on them the fourth integral has its value at the first crossing. Rounding "
        "the states alone makes it differ along an orbit by an eps or a few of its largest value."
    )
    yield Figure("dynamics-sections", "Crossings on the exact curves of integrable tops")
    yield table(rows, _SECTIONS, "polhode study dynamics --only 'section {0}'")


def _map(row: JsonObject) -> Iterator[Block]:
    yield Heading("A map across integrable bodies")
    told = ", ".join(f"{count} {verdict}" for verdict, count in row["counts"].items())
    yield Text(
        "Bodies with A = B = 2 and Mg r0 = (1, 0, 0) start at gamma = (3/5, 4/5, 0), w = (4/5, "
        f"-3/5, r), so that f = 0. Each motion is followed to t = {row['end']:g}. Of "
        f"{sum(row['counts'].values())} motions: {told}, in {row['seconds']:.1f} s of processor "
        "time. For three values of C the body is integrable. *Regular* means regular up to that "
        "time."
    )
    yield Figure("dynamics-map", "Verdicts over the third moment and the spin at the start")
    yield table(row["columns"], _MAP, "polhode study dynamics --only 'map across'")


def _cost(rows: list[JsonObject]) -> Iterator[Block]:
    yield Heading("What a crossing costs")
    yield Text(
        f"Crossings at maxima of |G| along one regular orbit of `{rows[0]['case']}`. All programs "
        "run in one process; the times are the least processor times of several runs, without "
        "compilation. The other programs have a tolerance of 1e-13. SciPy's right-hand side and "
        "event are Python functions. CyRK's right-hand side is compiled by numba, and its "
        "crossings are found on its dense output in numpy, all at once. Batches hold other orbits "
        "of the same level, too."
    )
    yield table(_beside_ours(rows), _COST, "polhode study dynamics --only 'cost {0}'")


def _beside_ours(rows: list[JsonObject]) -> list[JsonObject]:
    """The rows, each with its time over that of polhode's batches, where both have one."""
    times = {row["program"]: row["microseconds"] for row in rows if "microseconds" in row}
    ours = times.get(_OURS)
    return [
        row
        if ours is None or row["program"] not in times
        else {**row, "ratio": row["microseconds"] / ours}
        for row in rows
    ]

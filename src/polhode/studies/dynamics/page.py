"""Page of the study of dynamics."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from polhode.studies.page.blocks import Block, Figure, Heading, PageTable, Text, or_dash

TITLE = "Dynamics: levels, sections, chaos"


def blocks(found: dict[str, Any]) -> Iterator[Block]:
    """The study's page from its JSON object."""
    if found["levels"]:
        yield from _levels(found["levels"])
    if found["sections"]:
        yield from _sections(found["sections"])
    for row in found["maps"]:
        yield from _map(row)
    if found["cost"]:
        yield from _cost(found["cost"])


def finding(found: dict[str, Any]) -> str:
    """The study in a sentence."""
    told = []
    if found["sections"]:
        worst = max(found["sections"], key=lambda row: row["spread_in_eps"])
        told.append(
            f"on sections of {len(found['sections'])} integrable tops no orbit leaves its curve by "
            f"more than {worst['spread_in_eps']:.1f} eps of the integral's size in "
            f"{worst['crossings']} crossings"
        )
    for row in found["maps"]:
        chaotic = sum(column["counts"][2] for column in row["columns"])
        motions = sum(column["motions"] for column in row["columns"])
        told.append(
            f"{chaotic} of {motions} motions of integrable bodies are called chaotic, and "
            f"{row['counts']['chaotic']} of all {sum(row['counts'].values())} on a map across them"
        )
    rows = {row["program"]: row for row in found["cost"] if "microseconds" in row}
    ours = rows.pop("polhode, batches", None)
    if ours is not None and rows:
        ratios = [
            f"{row['microseconds'] / ours['microseconds']:.3g} ({name})"
            for name, row in rows.items()
        ]
        told.append(
            f"in batches of {ours['orbits']} orbits a crossing takes {ours['microseconds']:.3g} µs"
            f"; one orbit alone takes so many times as long a crossing: {', '.join(ratios)}"
        )
    text = "; ".join(told)
    return f"{text[0].upper()}{text[1:]}." if text else str(found["question"])


def _levels(rows: list[dict[str, Any]]) -> Iterator[Block]:
    yield Heading("Levels of energy and area")
    yield Text(
        "Lines are permanent rotations, thick ones stable by Liapunov; they divide the plane of "
        "f and h into regions whose levels have one topology. Types, cusps and Hamiltonian-Hopf "
        "points are decided exactly; nothing is integrated. The dot is the case's own level."
    )
    shown = f"The plane of f and h of {len(rows)} bodies, regions by topology"
    yield Figure("dynamics-levels", shown)
    yield PageTable(
        (
            *("body", "case", "pieces", "stable", "cusps", "Hamiltonian-Hopf", "branches"),
            *("case's f", "h", "its level", "fourth integral", "critical values", "seconds"),
        ),
        tuple(
            (
                row["what"],
                row["case"],
                *(str(row[key]) for key in ("arcs", "stable", "cusps", "hopf", "branches")),
                f"{row['f']:.4g}",
                f"{row['h']:.4g}",
                row["topology"],
                row["fourth"] or "–",
                ", ".join(f"{value:.4g}" for value in row["critical"]) or "–",
                f"{row['seconds']:.2f}",
            )
            for row in rows
        ),
        "llrrrrrrrlllr",
        "polhode study dynamics --only 'levels {0}'",
    )


def _sections(rows: list[dict[str, Any]]) -> Iterator[Block]:
    yield Heading("Sections of integrable tops, beside their exact curves")
    yield Text(
        "Crossings at the maxima of |G| in Andoyer's l and L/G, and beneath them, thin, the curves "
        "on which the fourth integral has the first crossing's value, which need no run. *Spread* "
        "is the largest difference of the integral along an orbit, in eps of its largest "
        "value: rounding the states alone makes an eps or a few. *Digits* are those told of a "
        "crossing: the fewest, and the median of the last ones."
    )
    yield Figure("dynamics-sections", "Crossings on the exact curves of integrable tops")
    yield PageTable(
        (
            *("top", "case", "f", "h", "integral", "orbits", "crossings each", "to t"),
            *("spread", "in eps", "fewest digits", "median of the last"),
        ),
        tuple(
            (
                row["what"],
                row["case"],
                f"{row['f']:.4g}",
                f"{row['h']:.4g}",
                row["integral"],
                str(row["orbits"]),
                str(row["crossings"]),
                f"{row['end']:g}",
                f"{row['spread']:.1e}",
                f"{row['spread_in_eps']:.2f}",
                f"{row['digits'][0]:.1f}",
                f"{row['digits'][1]:.1f}",
            )
            for row in rows
        ),
        "llrrlrrrrrrr",
        "polhode study dynamics --only 'section {0}'",
    )


def _map(row: dict[str, Any]) -> Iterator[Block]:
    yield Heading("A map across integrable bodies")
    told = ", ".join(f"{n} {name}" for name, n in row["counts"].items())
    yield Text(
        "Bodies A = B = 2, Mg r0 = (1, 0, 0), started at gamma = (3/5, 4/5, 0), "
        f"w = (4/5, -3/5, r), so that f = 0, each followed to t = {row['end']:g}: {told} of "
        f"{sum(row['counts'].values())}, in {row['seconds']:.1f} s of processor time. Three "
        "values of C are integrable; regular means up to that time."
    )
    yield Figure("dynamics-map", "Verdicts over the third moment and the spin at the start")
    yield PageTable(
        ("C", "integrable body", "motions", "regular", "undecided", "chaotic"),
        tuple(
            (c["C"], c["what"], str(c["motions"]), *(str(n) for n in c["counts"]))
            for c in row["columns"]
        ),
        "rlrrrr",
        "polhode study dynamics --only 'map across'",
    )


def _cost(rows: list[dict[str, Any]]) -> Iterator[Block]:
    yield Heading("What a crossing costs")
    ours = next((r for r in rows if r["program"] == "polhode, batches"), None)
    yield Text(
        f"Crossings at maxima of |G| of `{rows[0]['case']}`, a regular orbit, all programs in one "
        "process, least processor time of several runs, compiling apart; the others at a tolerance "
        "of 1e-13. The error is that of the last crossing's time beside a run in quad. SciPy's "
        "right-hand side and event are Python; CyRK's is compiled by numba, and crossings are "
        "found on its dense output in numpy, all at once. Batches are other orbits of the same "
        "level, too. *Digits* is what telling them takes on top."
    )
    yield PageTable(
        (
            *("program", "orbits", "crossings", "µs a crossing", "beside polhode's batches"),
            *("error of the last time", "digits, µs a crossing", "outcome"),
        ),
        tuple(
            (
                row["program"],
                str(row.get("orbits", "–")),
                str(row.get("crossings", "–")),
                or_dash(row.get("microseconds"), ".3g"),
                or_dash(
                    row["microseconds"] / ours["microseconds"]
                    if ours is not None and "microseconds" in row
                    else None,
                    ".3g",
                ),
                or_dash(row.get("error"), ".1e"),
                or_dash(row.get("digits_microseconds"), ".3g"),
                row["outcome"],
            )
            for row in rows
        ),
        "lrrrrrrl",
        "polhode study dynamics --only 'cost {0}'",
    )

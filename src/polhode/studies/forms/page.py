"""Page of the study of the forms."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from polhode.studies.page.blocks import Block, Figure, Heading, PageTable, Text

TITLE = "Forms: which form of the equations to take"

_TAKE = {
    "general": "a body given by its inertia matrix, where its own axes are to be kept",
    "inertia-axes": "formulas in the source's special axes; nothing is gained in a run",
    "principal": "by default",
    "momentum": "questions about G; as cheap as principal in principal axes",
    "gyration-axes": "formulas in Kharlamov's axes; nothing is gained in a run",
    "lagrangian": "comparison with codes in angles, away from the poles",
    "hamiltonian": "canonical variables, away from the poles",
    "routhian": "angles with the fewest variables, away from the poles",
    "omega-only": "a motion known through omega alone, with a weight",
    "momentum-only": "a motion known through G alone, with a weight",
    "quaternion": "attitude wanted all along; its norm is held",
}

_SHOWN = (
    "Correct digits and time of every form for every motion; no mark: the form refuses the motion "
    "or ends at its singular set"
)


def blocks(found: dict[str, Any]) -> Iterator[Block]:
    """The study's page from its JSON object."""
    yield Text(
        "Correct digits are the fewest of ten times up to the end, against the case's reference. "
        "*Lost* digits are those of the principal form less those of the form itself. Time is the "
        "least of several runs, building apart. A form in angles ends where sin theta falls below "
        "about eps^(1/4), the forms in omega or G alone where Iw is so near to the direction of "
        "r0: a passage at a distance d costs about log10(1/d) digits, so what is returned has lost "
        "at most about a quarter of the type's digits to the singular set. Angles among the "
        "variables grow without bounds, and heyoka's steps are as accurate as the largest variable "
        "asks: the further a form in angles runs, the fewer and the looser its steps."
    )
    yield Figure("forms", _SHOWN)
    yield Heading("Which form to take")
    yield _advice(found)
    for motion in found["motions"]:
        yield Heading(f"{motion['what']}: `{motion['case']}`")
        axes = motion["axes"] and f" Axes in the order {motion['axes']}."
        yield Text(
            f"To t = {motion['end']} (quad to a tenth), judged by {motion['reference']}."
            + (axes or "")
        )
        yield _table(motion["runs"], f"polhode study forms --only {motion['case']}")


def finding(found: dict[str, Any]) -> str:
    """The study in a sentence."""
    runs = [r for m in found["motions"] for r in m["runs"] if r["number"] == "double"]
    done = [r for r in runs if "correct_digits" in r and r["form"] != "principal"]
    if not done:
        return str(found["question"])
    slowest = max(done, key=lambda r: r["time_against_principal"])
    worst = max(done, key=lambda r: r["lost_digits"])
    ahead = sum(r["lost_digits"] < 0 for r in done)
    faster = sum(r["time_against_principal"] < 1 for r in done)
    return (
        f"In double the other forms take up to {slowest['time_against_principal']:.1f} times as "
        f"long as the principal one ({slowest['form']}) and lose up to {worst['lost_digits']:.1f} "
        f"digits ({worst['form']}); {faster} of {len(done)} runs in them are faster, {ahead} are "
        "right to more digits."
    )


def _advice(found: dict[str, Any]) -> PageTable:
    rows = []
    for form, place in found["sources"].items():
        runs = [r for m in found["motions"] for r in m["runs"] if r["form"] == form]
        runs = [r for r in runs if r["number"] == "double"]
        done = [r for r in runs if "correct_digits" in r]
        ratios = [r["time_against_principal"] for r in done]
        others = sorted({r["outcome"] for r in runs if "correct_digits" not in r})
        rows.append(
            (
                form,
                place,
                f"{len(done)} of {len(runs)}",
                f"{min(ratios):.1f}–{max(ratios):.1f}" if ratios else "–",
                f"{max(r['lost_digits'] for r in done):.1f}" if done else "–",
                ", ".join(others) or "–",
                _TAKE[form],
            )
        )
    header = ("form", "source", "motions", "time / principal", "most digits lost", "else")
    return PageTable((*header, "take it for"), tuple(rows), "lllrrll", "polhode study forms -o DIR")


def _table(runs: list[dict[str, Any]], again: str) -> PageTable:
    header = ("form", "number", "steps", "run, ms", "build, ms", "time / principal")
    rows = [
        (
            r["form"],
            r["number"],
            str(r.get("steps", "–")),
            f"{1e3 * r['seconds']['run']:.2f}" if "seconds" in r else "–",
            f"{1e3 * r['seconds']['build']:.0f}" if "seconds" in r else "–",
            f"{r['time_against_principal']:.2f}" if "seconds" in r else "–",
            f"{r['correct_digits']:.1f}" if "correct_digits" in r else "–",
            f"{r['lost_digits']:.1f}" if "lost_digits" in r else "–",
            r["outcome"] + (f": {r['reason']}" if "reason" in r else ""),
        )
        for r in runs
    ]
    return PageTable((*header, "digits", "lost", "outcome"), tuple(rows), "llrrrrrrl", again)

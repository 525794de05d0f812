"""Page of the study of certified digits."""

from __future__ import annotations

import statistics
from collections.abc import Iterator
from typing import Any

from polhode.studies.page.blocks import Block, Figure, Heading, Items, PageTable, Text

TITLE = "Certified digits: what is proven, how far, and at what price"
_NEAR = 0.5  # digits

#: What is read of others, and where; nothing here was measured.
READ = (
    "CAPD (C++): rigorous solvers in interval arithmetic on doubles, and with the header "
    "mpcapdlib.h on floating numbers of any precision (its manual, "
    "https://capd.sourceforge.net/capdDynSys/docs/html/a05200.html).",
    "VNODE-LP (C++): a validated solver for initial value problems (N. S. Nedialkov, Technical "
    "Report CAS-06-06-NN, McMaster University 2006, "
    "https://www.cas.mcmaster.ca/~nedialk/vnodelp/).",
)

_SHOWN = (
    "Digits lost over time, and the price of a proof beside runs; no mark: the type does not hold "
    "so many digits, or building it takes too long to tell"
)

_AGAIN = "polhode study certified --only {0}"


def blocks(found: dict[str, Any]) -> Iterator[Block]:
    """The study's page from its JSON object."""
    yield Text(
        "An enclosure is a ball a number: midpoint and radius, proven to contain the exact motion "
        "of the exact scene, whatever heyoka did (see `polhode.certify`). Proven digits = -log10 "
        "of the larger of the radius of w over the largest |w| and the radius of gamma."
    )
    yield Figure("certified", _SHOWN)
    for part, told in (
        ("contained", _containment),
        ("growth", _over_time),
        ("cost", _price),
        ("judged", _judged),
    ):
        if found[part]:  # a part of a study may have none
            yield from told(found[part])
    yield Heading("Others: read, not measured")
    yield Items(READ)


def finding(found: dict[str, Any]) -> str:
    """The study in a sentence."""
    rows = found["contained"]
    inside = sum(row["inside"] for row in rows)
    told = f"{inside} of {len(rows)} closed forms lie in their proven enclosures"
    if ratios := _over_mp(found["cost"]):
        told += (
            f"; a proof takes {min(ratios):.1f} to {max(ratios):.1f} times a run of as many bits "
            "that proves nothing"
        )
    return told + "."


def _mp(row: dict[str, Any]) -> str:
    """The name of heyoka's run at the proof's own precision; "mp" where it has no seconds."""
    return next((name for name in row["seconds"] if name.startswith("mp")), "mp")


def _over_mp(rows: list[dict[str, Any]]) -> list[float]:
    """What proofs take, in runs of as many bits."""
    timed = [(row["seconds"], _mp(row)) for row in rows]
    return [seconds["proof"] / seconds[mp] for seconds, mp in timed if mp in seconds]


def _containment(rows: list[dict[str, Any]]) -> Iterator[Block]:
    outside = [row["case"] for row in rows if not row["inside"]]
    ratios = [row["ratio"] for row in rows]
    yield Heading("Every closed form in its enclosure")
    told = (
        f"All {len(rows)} closed forms lie in their enclosures"
        if not outside
        else f"{len(outside)} of {len(rows)} closed forms lie OUTSIDE: {', '.join(outside)}"
    )
    first = sum(row["tries"] == 1 for row in rows)
    yield Text(
        f"{told}. *Worst* is the largest |closed form - midpoint| over the radius at three times, "
        f"in any component; its median is {statistics.median(ratios):.1g}. 16 digits were asked "
        f"for; in {first} of {len(rows)} the first choice of precision was enough."
    )
    yield PageTable(
        ("case", "closed form", "to t", "proven digits", "worst", "inside"),
        tuple(
            (
                row["case"],
                row["reference"],
                f"{row['end']:g}",
                f"{row['digits']:.1f}",
                f"{row['ratio']:.2g}",
                "yes" if row["inside"] else "NO",
            )
            for row in rows
        ),
        "llrrrl",
        _AGAIN,
    )


def _over_time(rows: list[dict[str, Any]]) -> Iterator[Block]:
    yield Heading("Digits lost over time, with and without the integrals")
    gains = [row["lost_without"][-1] - row["lost"][-1] for row in rows]
    told = (
        f"At the last time they spare between {min(gains):.1f} and {max(gains):.1f} digits."
        if min(gains) > _NEAR
        else f"At the last time they spare up to {max(gains):.1f} digits, in some nearly none."
    )
    yield Text(
        "Digits that the proof has lost at a time since its noise level 2^-P: with h, f, |gamma|² "
        "and, where there is one, a fourth integral shrinking the set after every window, and (in "
        f"brackets) without. {told}"
    )
    times = rows[0]["times"]
    yield PageTable(
        ("case", "P", *(f"t = {t}" for t in times)),
        tuple(
            (
                row["case"],
                str(row["noise"]),
                *(
                    f"{x:.1f} ({y:.1f})"
                    for x, y in zip(row["lost"], row["lost_without"], strict=True)
                ),
            )
            for row in rows
        ),
        "lr" + "r" * len(times),
        _AGAIN,
    )


def _price(rows: list[dict[str, Any]]) -> Iterator[Block]:
    yield Heading("The price of a proof")
    trials = sorted({row["trials"] for row in rows})
    times = " to ".join(str(n) for n in dict.fromkeys((trials[0], trials[-1])))
    told = (
        f"CPU seconds to one time, the median of {times} in turn in one process: of a proof "
        "with the pilot run and every try; of a run after that of a run to a thousandth of the "
        "time is taken off, which is for building it (a dash: building takes too long to tell). "
        "Beside it runs that prove nothing: heyoka in MPFR at the proof's own "
        "precision (mp), in double and in quad, and a refined run in quad."
    )
    if ratios := _over_mp(rows):
        told += f" A proof takes {min(ratios):.1f} to {max(ratios):.1f} times the mp run."
    yield Text(told)
    yield PageTable(
        (
            *("case", "to t", "asked", "proven", "P", "tries", "proof, s", "mp, s", "quad, s"),
            *("refined, s", "double, s", "proof/mp", "proof/quad"),
        ),
        tuple(
            (
                row["case"],
                f"{row['end']:g}",
                str(row["digits"]),
                f"{row['proven']:.1f}",
                str(row["noise"]),
                str(row["tries"]),
                f"{row['seconds']['proof']:.3g}",
                _seconds(row, _mp(row)),
                *(_seconds(row, name) for name in ("quad", "quad, refined", "double")),
                _ratio(row, _mp(row)),
                _ratio(row, "quad"),
            )
            for row in rows
        ),
        "l" + "r" * 12,
        _AGAIN + " --only '{2} digits'",
    )


def _judged(rows: list[dict[str, Any]]) -> Iterator[Block]:
    yield Heading("Runs in double, judged with proof")
    yield Text(
        "The largest error of a run in double, in any component, and the radius that it is "
        "uncertain by: proven, not estimated."
    )
    yield PageTable(
        ("case", "t", "component", "error", "uncertain by"),
        tuple(
            (row["case"], f"{row['t']:g}", row["column"], row["error"], row["uncertainty"])
            for row in rows
        ),
        "lrlrr",
        _AGAIN,
    )


def _seconds(row: dict[str, Any], name: str) -> str:
    return f"{row['seconds'][name]:.3g}" if name in row["seconds"] else "–"


def _ratio(row: dict[str, Any], name: str) -> str:
    seconds = row["seconds"]
    return f"{seconds['proof'] / seconds[name]:.2f}" if name in seconds else "–"

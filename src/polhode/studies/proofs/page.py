"""Page of the study of proofs."""

from __future__ import annotations

import statistics
from collections import Counter
from collections.abc import Iterator

from polhode.output.json_object import JsonObject
from polhode.studies.page.blocks import Block, Figure, Heading, Number, PageTable, Text

TITLE = "Proofs: periodic orbits and chaos that exist"


def blocks(found: JsonObject) -> Iterator[Block]:
    """The study's page from its JSON object."""
    n, m = found["grid"]
    yield Text(
        "A proof is a theorem about the exact numbers of a scene on its own exact level of energy "
        "and vertical momentum: `polhode guide theorems` says what it claims and what it does not. "
        "Each is written as a certificate, and proved again from that by a file that imports "
        "nothing of polhode (`polhode guide proofs`); *checked* counts those. Seconds are of one "
        "processor, the second column those of that check."
    )
    if found["orbits"]:
        yield Heading("Periodic orbits")
        yield Text(
            f"All orbits that a search from {n} x {m} cells of the level's section finds, with at "
            f"most {found['crossings']} crossings a period, each to {found['digits']} digits. The "
            "period is proved to be the least one. An orbit of a resonant torus is no isolated "
            "one, and none is proved."
        )
        yield Figure(
            "proofs",
            "Every orbit found, its residue over its period: hyperbolic ones below 0, elliptic "
            "ones between 0 and 1, inverse hyperbolic ones above; crosses are those not proved.",
        )
        yield _orbits(found["orbits"])
        causes = [
            (one["what"], row)
            for one in found["orbits"]
            for row in one["orbits"]
            if not row["proved"]
        ]
        if causes:
            yield Text("What was not proved, and why:")
            yield _refused(causes)
    if found["chaos"]:
        yield Heading("Chaos")
        yield Text(
            "A transversal homoclinic orbit of an unstable periodic orbit, by covering relations "
            "with cone conditions; the entropy is a lower bound of the flow's topological entropy "
            "on the level, per unit of time. Margins: the least stretch must be above 1, the "
            "largest height below 1."
        )
        for row in found["chaos"]:
            if "drawn" in row:
                yield Figure(
                    "manifolds",
                    f"Chaos of the top *{row['what']}*: maxima of the height of its centre of mass "
                    "on the stable (blue) and the unstable manifold (orange) of the proved orbit, "
                    "as they were guessed in double, and the sets of the proof, which lie in "
                    "planes of their own.",
                )
        yield _chaos(found["chaos"])


def headline(found: JsonObject) -> Number | None:
    """How many periodic orbits were proved, and in what time."""
    orbits = [row for one in found["orbits"] for row in one["orbits"]]
    proved = [row["seconds"] for row in orbits if row["proved"]]
    if not proved:
        return None
    words = (
        f"periodic orbits that a search found of {len(found['orbits'])} tops are proved to exist, "
        f"in {statistics.median(proved):.2g} s each (median); the others are refused with cause"
    )
    return Number(f"{len(proved)} of {len(orbits)}", words)


def finding(found: JsonObject) -> str:
    """The study in a few sentences."""
    orbits = [row for one in found["orbits"] for row in one["orbits"]]
    told = []
    if orbits:
        proved = [row for row in orbits if row["proved"]]
        kinds = Counter(row["kind"] for row in proved)
        named = ", ".join(f"{kinds[kind]} {kind}" for kind in sorted(kinds))
        told.append(
            f"{len(proved)} of {len(orbits)} periodic orbits of {len(found['orbits'])} tops are "
            f"proved ({named})"
        )
        if proved:
            told[-1] += (
                f", in {statistics.median(row['seconds'] for row in proved):.2g} s of processor "
                f"time each (median), {sum(row['verified'] for row in proved)} of them proved "
                "again by the checker that shares no code"
            )
        told[-1] += "."
    if found["chaos"]:
        proved = [row for row in found["chaos"] if row["proved"]]
        text = f"Chaos is proved of {len(proved)} of {len(found['chaos'])} tops"
        if proved:
            seconds = [row["seconds"] for row in proved]
            text += f", in {min(seconds):.2g} to {max(seconds):.2g} s"
            text += f", {sum(row['verified'] for row in proved)} checked so"
        told.append(f"{text}.")
    return " ".join(told) or str(found["question"])


def _orbits(tops: list[JsonObject]) -> PageTable:
    rows = []
    for one in tops:
        proved = [row for row in one["orbits"] if row["proved"]]
        kinds = Counter(row["kind"] for row in proved)
        periods = [row["period"] for row in proved]
        rows.append(
            (
                f"orbits: {one['what']}",
                f"h = {one['h']}, f = {one['f']}",
                f"{len(proved)} of {len(one['orbits'])}",
                ", ".join(f"{n} {kind}" for kind, n in sorted(kinds.items())) or "–",
                f"{min(periods):.3g}–{max(periods):.3g}" if periods else "–",
                f"{min(row['digits'] for row in proved):.1f}" if proved else "–",
                f"{statistics.median(row['seconds'] for row in proved):.2f}" if proved else "–",
                f"{sum(row['verified'] for row in proved)}",
                _middle([row["verify_seconds"] for row in proved if row["verified"]]),
            )
        )
    header = ("top", "level", "proved", "kinds", "periods", "fewest digits", "s", "checked", "s")
    return PageTable(header, tuple(rows), "lllllrrrr", "polhode study proofs --only '{0}'")


def _refused(causes: list[tuple[str, JsonObject]]) -> PageTable:
    """A row for all orbits of a top that have about one period and the same cause."""
    found: dict[tuple[str, str, str], list[JsonObject]] = {}
    for what, row in causes:
        cause = row["cause"].partition(":")[0]
        found.setdefault((what, f"{row['period']:.5g}", cause), []).append(row)
    rows = [
        (f"orbits: {what}", period, f"{len(same)}", _between(same), cause)
        for (what, period, cause), same in found.items()
    ]
    header = ("top", "period", "orbits", "residue", "cause")
    return PageTable(header, tuple(rows), "lrrrl", "polhode study proofs --only '{0}'")


def _between(rows: list[JsonObject]) -> str:
    found = sorted(row["residue"] for row in rows)
    return f"{found[0]:.1e}" if len(found) == 1 else f"{found[0]:.1e} to {found[-1]:.1e}"


def _chaos(found: list[JsonObject]) -> PageTable:
    rows = []
    for row in found:
        if not row["proved"]:
            rows.append((f"chaos: {row['what']}", "–", row["cause"], *["–"] * 6))
            continue
        rows.append(
            (
                f"chaos: {row['what']}",
                f"h = {row['h']}, f = {row['f']}",
                f"{row['kind']}, period {float(row['period']):.6g}",
                f"{row['coverings']}",
                f"{row['stretch']:.2f}, {row['height']:.2f}",
                f"{row['entropy']:.2g}",
                f"{row['seconds']:.1f}",
                "yes" if row["verified"] else "no",
                f"{row['verify_seconds']:.1f}" if row["verified"] else "–",
            )
        )
    header = ("top", "level", "orbit", "coverings", "stretch, height", "entropy", "s", "checked")
    return PageTable((*header, "s"), tuple(rows), "lllrrrrlr", "polhode study proofs --only '{0}'")


def _middle(seconds: list[float]) -> str:
    return f"{statistics.median(seconds):.2f}" if seconds else "–"

"""Page of the study of proofs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from polhode.output.json_object import JsonObject
from polhode.studies.page.blocks import Block, Figure, Heading, Text
from polhode.studies.page.columns import Column, table, yes
from polhode.studies.page.words import DASH, between, counted, median, share

TITLE = "Proofs: periodic orbits and chaos that exist"


_AGAIN = "polhode study proofs --only '{0}'"
_ORBITS = (
    Column("top", "top"),
    Column("level", lambda one: f"h = {one['h']}, f = {one['f']}"),
    Column("proved", "share", meaning="orbits proved to exist, of those that the search found"),
    Column("kinds", "kinds"),
    Column("periods", "periods", meaning="least and largest period of the proved orbits"),
    Column("fewest digits", "digits", ".1f", "the fewest proven digits of an orbit"),
    Column("s", "seconds", ">", "processor seconds of a proof, the median"),
    Column(
        "checked",
        "checked",
        "d",
        "proofs that the checker, which imports nothing of polhode, proves again from their "
        "certificates",
    ),
    Column("check, s", "verify_seconds", ">", "processor seconds of such a check, the median"),
)
_REFUSED = (
    Column("top", "top"),
    Column("period", "period", ">", "about that of all these orbits"),
    Column("orbits", "orbits", "d"),
    Column("residue", "residue", ">", "Greene's residue, 0 on a resonant torus"),
    Column("cause", "cause", "", "why the proof was refused"),
)
_CHAOS = (
    Column("top", lambda row: f"chaos: {row['what']}"),
    Column("level", lambda row: _if_proved(row, "h = {h}, f = {f}")),
    Column(
        "orbit",
        lambda row: _orbit(row) if row["proved"] else row["cause"],
        meaning="the unstable periodic orbit whose manifolds meet",
    ),
    Column("coverings", "coverings", "d", "covering relations that the proof consists of"),
    Column(
        "stretch, height",
        lambda row: _if_proved(row, "{stretch:.2f}, {height:.2f}"),
        ">",
        "margins of these relations: the least stretch must be above 1, the largest height below 1",
    ),
    Column(
        "entropy",
        "entropy",
        ".2g",
        "proven lower bound of the topological entropy, per unit of time",
    ),
    Column("s", lambda row: _if_proved(row, "{seconds:.1f}"), ">", "processor seconds"),
    Column(
        "checked",
        yes("verified"),
        meaning=(
            "whether the checker, which imports nothing of polhode, proves it again from its "
            "certificate"
        ),
    ),
    Column(
        "check, s",
        lambda row: row["verify_seconds"] if row.get("verified") else None,
        *(".1f", "processor seconds of that check"),
    ),
)


def _orbit(row: JsonObject) -> str:
    return f"{row['kind']}, period {float(row['period']):.6g}"


def _if_proved(row: JsonObject, form: str) -> str | None:
    """What is said of a proof of chaos; None where it is refused."""
    return form.format(**row) if row["proved"] else None


def blocks(found: JsonObject) -> Iterator[Block]:
    """The study's page from its JSON object."""
    n, m = found["grid"]
    yield Text(
        "A proof is a theorem about the exact numbers of a scene, on its own exact level of "
        "energy and vertical momentum. `polhode guide theorems` says what it claims and what it "
        "does not. Each proof is written as a certificate. A checker that imports nothing of "
        "polhode proves it again from the certificate (`polhode guide proofs`)."
    )
    if found["orbits"]:
        yield Heading("Periodic orbits")
        yield Text(
            f"All orbits that a search from {n} x {m} cells of the level's section finds with at "
            f"most {found['crossings']} crossings in a period, each to {found['digits']} digits. "
            "The period is proved to be the least one. An orbit on a resonant torus is not "
            "isolated, and none is proved."
        )
        yield Figure(
            "proofs",
            "The residue of every orbit found, over its period: hyperbolic ones below 0, elliptic "
            "ones between 0 and 1, inverse hyperbolic ones above 1. Crosses: not proved.",
        )
        yield table(map(_proved, found["orbits"]), _ORBITS, _AGAIN)
        if refused := _refused(found["orbits"]):
            yield Text("What was not proved, and why:")
            yield table(refused, _REFUSED, _AGAIN)
    if found["chaos"]:
        yield Heading("Chaos")
        yield Text(
            "What is proved is a transversal homoclinic orbit of an unstable periodic orbit, by "
            "covering relations with cone conditions."
        )
        for row in found["chaos"]:
            if "drawn" in row:
                yield Figure(
                    "manifolds",
                    f"Chaos of the top *{row['what']}*: maxima of the height of its centre of mass "
                    "on the stable (blue) and the unstable manifold (orange) of the proved orbit, "
                    "as computed in double, and the sets of the proof, which lie in planes of "
                    "their own.",
                )
        yield table(found["chaos"], _CHAOS, _AGAIN)


def finding(found: JsonObject) -> str:
    """The study in a few sentences."""
    orbits = [row for one in found["orbits"] for row in one["orbits"]]
    told = []
    if orbits:
        proved = [row for row in orbits if row["proved"]]
        text = (
            f"{share(row['proved'] for row in orbits)} periodic orbits of {len(found['orbits'])} "
            f"tops are proved ({_kinds(proved)})"
        )
        if proved:
            text += (
                f", in {median([row['seconds'] for row in proved], '.2g')} s of processor time "
                f"each (median), and {sum(row['verified'] for row in proved)} of them are proved "
                "again by the checker, which shares no code"
            )
        told.append(f"{text}.")
    if found["chaos"]:
        proved = [row for row in found["chaos"] if row["proved"]]
        text = f"Chaos is proved for {share(row['proved'] for row in found['chaos'])} tops"
        if proved:
            text += f", in {between([row['seconds'] for row in proved], '.2g')} s"
            text += (
                f", {sum(row['verified'] for row in proved)} of them proved again by the checker"
            )
        told.append(f"{text}.")
    return " ".join(told)


def _kinds(proved: list[JsonObject]) -> str:
    """How many orbits of each kind."""
    return counted(dict(sorted(Counter(row["kind"] for row in proved).items())))


def _proved(one: JsonObject) -> JsonObject:
    """A row of all orbits that were found of a top."""
    proved = [row for row in one["orbits"] if row["proved"]]
    checked = [row["verify_seconds"] for row in proved if row["verified"]]
    return {
        **one,
        "top": f"orbits: {one['what']}",
        "share": share(row["proved"] for row in one["orbits"]),
        "kinds": _kinds(proved) or None,
        "periods": between([row["period"] for row in proved], ".3g", DASH),
        "digits": min((row["digits"] for row in proved), default=None),
        "seconds": median([row["seconds"] for row in proved], ".2f"),
        "checked": sum(row["verified"] for row in proved),
        "verify_seconds": median(checked, ".2f"),
    }


def _refused(tops: list[JsonObject]) -> list[JsonObject]:
    """A row for all orbits of a top that have about one period and the same cause."""
    found: dict[tuple[str, str, str], list[float]] = {}
    for one in tops:
        for row in one["orbits"]:
            if not row["proved"]:
                cause = row["cause"].partition(":")[0]
                same = (f"orbits: {one['what']}", f"{row['period']:.5g}", cause)
                found.setdefault(same, []).append(row["residue"])
    return [
        {
            **{"top": top, "period": period, "orbits": len(residues), "cause": cause},
            "residue": between(residues, ".1e") if len(residues) > 1 else f"{residues[0]:.1e}",
        }
        for (top, period, cause), residues in found.items()
    ]

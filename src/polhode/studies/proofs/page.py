"""Tables and facts of the proofs study's page."""

from __future__ import annotations

from collections import Counter

from polhode.common.texts import JsonObject
from polhode.studies.page.tables import Column, PageTable, table, yes
from polhode.studies.page.words import DASH, between, counted, median, share

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
_STABLE = Column(
    "stable",
    "stable",
    meaning="elliptic orbits that are stable for all time by J. Moser's theorem, of those proved",
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
    Column("h", "h"),
    Column("f", "f"),
    Column(
        "orbit",
        lambda row: row["kind"] if row["proved"] else row["cause"],
        meaning="the unstable periodic orbit whose manifolds meet, or why the proof was refused",
    ),
    Column("period", lambda row: float(row["period"]) if row["proved"] else None, ".6g"),
    Column("coverings", "coverings", "d", "covering relations that the proof consists of"),
    Column("stretch", "stretch", ".2f", "their least stretch, which must be above 1"),
    Column("height", "height", ".2f", "their largest height, which must be below 1"),
    Column(
        "entropy",
        "entropy",
        ".2g",
        "proven lower bound of the topological entropy, per unit of time",
    ),
    Column("s", "seconds", ".1f", "processor seconds"),
    Column(
        "checked",
        yes("verified"),
        meaning=(
            "whether the checker, which imports nothing of polhode, proves it again from its "
            "certificate"
        ),
    ),
    Column("check, s", "verify_seconds", ".1f", "processor seconds of that check"),
)


#: Of the proof that is drawn, where it is proved.
_PICTURE = """![Manifolds of the proved orbit, and the sets of the proof](manifolds.svg)

Chaos of the top *{what}*: maxima of the height of its centre of mass on the stable (blue) and the
unstable manifold (orange) of the proved orbit, as computed in double, and the sets of the proof,
which lie in planes of their own."""


def tables(found: JsonObject) -> dict[str, PageTable]:
    """The page's tables from the study's JSON object, of 0.3 too, which tells of no stability."""
    proved = [*map(_proved, found["orbits"])]
    stable = [_STABLE] if any(row["stable"] for row in proved) else []
    return {
        "orbits": table(proved, [*_ORBITS[:4], *stable, *_ORBITS[4:]], _AGAIN),
        "refused": table(_refused(found["orbits"]), _REFUSED, _AGAIN),
        "chaos": table(found["chaos"], _CHAOS, _AGAIN),
    }


def facts(found: JsonObject) -> dict[str, object]:
    """Counts and ranges of the rows."""
    orbits = [row for one in found["orbits"] for row in one["orbits"]]
    proved = [row for row in orbits if row["proved"]]
    chaos = [row for row in found["chaos"] if row["proved"]]
    return {
        "grid": " x ".join(map(str, found["grid"])),
        "crossings": found["crossings"],
        "digits": found["digits"],
        "proved": share(row["proved"] for row in orbits),
        "tops": len(found["orbits"]),
        "kinds": _kinds(proved) or DASH,
        "seconds": median([row["seconds"] for row in proved], ".2g"),
        "verified": sum(row["verified"] for row in proved),
        "proved_chaos": share(row["proved"] for row in found["chaos"]),
        "chaos_seconds": between([row["seconds"] for row in chaos], ".2g"),
        "verified_chaos": sum(row["verified"] for row in chaos),
        "picture": "".join(_PICTURE.format(**row) for row in chaos if "drawn" in row),
    }


def _kinds(proved: list[JsonObject]) -> str:
    """How many orbits of each kind."""
    return counted(dict(sorted(Counter(row["kind"] for row in proved).items())))


def _proved(one: JsonObject) -> JsonObject:
    """A row of all orbits that were found of a top."""
    proved = [row for row in one["orbits"] if row["proved"]]
    stable = [row["stable"] for row in proved if "stable" in row]
    checked = [row["verify_seconds"] for row in proved if row["verified"]]
    return {
        **one,
        "top": f"orbits: {one['what']}",
        "share": share(row["proved"] for row in one["orbits"]),
        "kinds": _kinds(proved) or None,
        "stable": share(stable) if stable else None,
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

"""Study ``proofs``: periodic orbits of seven tops, their stability, and chaos of five tops.

Each proof is made by the checker of certificates, which imports nothing of polhode, and is read
again by it from the certificate that was written.
"""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Callable, Iterable
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import kit
import polhode

TOPS = {
    "asymmetric, chaotic": "general/asymmetric-chaotic",
    "asymmetric, regular": "general/asymmetric-regular",
    "asymmetric, of a section": "general/section",
    "asymmetric, near upright": "general/near-upright",
    "Hairer and Vilmart's body": "published/hairer-vilmart",
    "Kovalevskaya's top": "kovalevskaya/generic",
    "Goryachev–Chaplygin top": "goryachev-chaplygin/two-frequencies",
    "next to Lagrange's top": None,  # but for a moment that is a fiftieth larger
}
CHAOS = [*TOPS][:5]
ORBITS = [name for name in TOPS if name != "asymmetric, near upright"]
DRAWN = "asymmetric, chaotic"  # the proof of chaos that has a figure
GRID, CROSSINGS, DIGITS = (16, 16), 3, 20
_QUICK_GRID, _QUICK_CROSSINGS = (4, 4), 1
_QUICK = ("asymmetric, regular",)


def rows(quick: bool, say: kit.Say, only: kit.Only) -> kit.JsonObject:
    """The study's rows."""
    grid, crossings = (_QUICK_GRID, _QUICK_CROSSINGS) if quick else (GRID, CROSSINGS)
    chaos = [name for name in ([] if quick else CHAOS) if only(f"chaos: {name}")]
    orbits = [name for name in (_QUICK if quick else ORBITS) if only(f"orbits: {name}")]
    orbits_row = partial(_orbits, grid=grid, crossings=crossings)
    parts: kit.Parts = {"chaos": (_chaos, chaos), "orbits": (orbits_row, orbits)}
    searched = {"grid": list(grid), "crossings": crossings, "digits": DIGITS}
    return searched | kit.rows_by_part(parts, quick, say)


def scene_of(top_name: str) -> polhode.Scene:
    """The scene of a top."""
    if (name := TOPS[top_name]) is not None:
        return polhode.load(name)
    body: dict[str, Any] = {"moments": [2, Fraction(51, 25), 1], "centre": [0, 0, 1], "weight": 1}
    omega, gamma = [Fraction(1, 2), Fraction(1, 4), 2], [Fraction(3, 5), 0, Fraction(4, 5)]
    return polhode.top(**body, omega=omega, gamma=gamma, end=1, name=top_name)


def _orbits(name: str, grid: tuple[int, int], crossings: int) -> kit.JsonObject:
    """All orbits of a search on the scene's own level."""
    every = polhode.prove_orbits(scene_of(name), grid, crossings, digits=DIGITS)
    search, rows = every.search, []
    for orbit, proof in zip(search.orbits, every.proofs, strict=True):
        row: kit.JsonObject = {"period": float(orbit.period), "residue": float(orbit.residue)}
        if isinstance(proof, polhode.NotProved):
            rows.append(row | {"proved": False, "cause": _cause(proof)})
            continue
        period, radius = proof.period.decimals
        row |= {"proved": True, "kind": proof.kind, "least_period": period, "within": radius}
        row |= {"digits": round(proof.digits, 1), "seconds": round(proof.seconds, 3)}
        rows.append(row | _checked(proof) | _stable(proof))
    return {
        "what": name,
        "scene": TOPS[name],
        "h": f"{float(search.surface.h):g}",
        "f": f"{float(search.surface.f):g}",
        "orbits": sorted(rows, key=lambda row: row["period"]),
    }


def _stable(proof: polhode.ProvedOrbit) -> kit.JsonObject:
    """Whether an elliptic orbit is proved to be stable for all time, and how long that takes."""
    if proof.kind != "elliptic":
        return {}
    stable, seconds = kit.clocked(partial(_proof, polhode.prove_stability, proof))
    if isinstance(stable, polhode.NotProved):
        return {"stable": False, "why_not_stable": _cause(stable)}
    return {"stable": True, "twist": str(stable.twist), "stability_seconds": round(seconds, 2)}


def _proof(prove: Callable[[Any], Any], subject: Any) -> Any:
    """A proof, or why there is none."""
    try:
        return prove(subject)
    except polhode.NotProved as why:
        return why


def _cause(why: polhode.NotProved) -> str:
    return str(why).partition(": ")[2]


def _chaos(name: str) -> kit.JsonObject:
    """A proof of chaos on the scene's own level."""
    proof, seconds = kit.clocked(partial(_proof, polhode.prove_chaos, scene_of(name)))
    failed = isinstance(proof, polhode.NotProved)
    row: kit.JsonObject = {"what": name, "scene": TOPS[name], "proved": not failed}
    row |= {"seconds": round(seconds, 1)}
    if failed:
        return row | {"cause": _cause(proof)}
    row |= {"period": proof.orbit.period.decimals[0]}
    row |= {"kind": proof.orbit.kind, "coverings": proof.coverings, "tries": proof.tries}
    row |= {"entropy": proof.entropy, "short": proof.short, "long": proof.long}
    row |= {"stretch": proof.stretch, "height": proof.height, "cone": proof.cone}
    row |= {"h": f"{float(proof.h):g}", "f": f"{float(proof.f):g}"}
    if name == DRAWN:
        panels: Any = polhode.plot(proof)
        row["drawn"] = {
            line.get_gid().partition(" ")[0]: [
                [round(float(x), 3) for x in axis] for axis in line.get_data()
            ]
            for line in panels[0].lines
        }
    return row | _checked(proof)


def _checked(proof: polhode.ProvedOrbit | Any) -> kit.JsonObject:
    """Whether the checker proves the proof's certificate, and how long that takes."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "proof.json"
        try:
            proof.save(path)
        except polhode.BadInput as why:
            return {"verified": False, "why": why.expected}
        verdict, seconds = kit.clocked(partial(polhode.verify, path))
    return {"verified": verdict.proved, "verify_seconds": round(seconds, 2)}


# --- page -----------------------------------------------------------------------------------------
#
# Rows of the tables and facts of the proofs study's page.


def tables(results: kit.JsonObject) -> dict[str, Iterable[kit.JsonObject]]:
    """The rows of the page's tables from the study's JSON object."""
    return {
        "orbits": map(_proved, results["orbits"]),
        "refused": _refused(results["orbits"]),
        "chaos": map(_proved_chaos, results["chaos"]),
    }


def facts(results: kit.JsonObject) -> dict[str, object]:
    """Counts and ranges of the rows."""
    orbits = kit.inner_rows(results["orbits"], "orbits")
    proved = [row for row in orbits if row["proved"]]
    chaos = [row for row in results["chaos"] if row["proved"]]
    return {
        "grid": " x ".join(map(str, results["grid"])),
        "crossings": results["crossings"],
        "digits": results["digits"],
        "proved": kit.share(row["proved"] for row in orbits),
        "tops": len(results["orbits"]),
        "kinds": _kinds(proved) or kit.DASH,
        "seconds": kit.median([row["seconds"] for row in proved], ".2g"),
        "verified": sum(row["verified"] for row in proved),
        "chaos_proved": kit.share(row["proved"] for row in results["chaos"]),
        "chaos_seconds": kit.between([row["seconds"] for row in chaos], ".2g"),
        "chaos_verified": sum(row["verified"] for row in chaos),
        "drawn": DRAWN,
    }


def _kinds(proved: list[kit.JsonObject]) -> str:
    """How many orbits of each kind."""
    return kit.counted(dict(sorted(Counter(row["kind"] for row in proved).items())))


def _proved(top: kit.JsonObject) -> kit.JsonObject:
    """A row of all orbits that were found of a top."""
    proved = [row for row in top["orbits"] if row["proved"]]
    stable = [row["stable"] for row in proved if "stable" in row]
    checked = [row["verify_seconds"] for row in proved if row["verified"]]
    return {
        **top,
        "top": f"orbits: {top['what']}",
        "level": f"h = {top['h']}, f = {top['f']}",
        "share": kit.share(row["proved"] for row in top["orbits"]),
        "kinds": _kinds(proved) or None,
        "stability": {"stable": kit.share(stable)} if stable else {},
        "periods": kit.between([row["period"] for row in proved], ".3g", kit.DASH),
        "digits": min((row["digits"] for row in proved), default=None),
        "seconds": kit.median([row["seconds"] for row in proved], ".2f"),
        "checked": sum(row["verified"] for row in proved),
        "verify_seconds": kit.median(checked, ".2f"),
    }


def _proved_chaos(row: kit.JsonObject) -> kit.JsonObject:
    """A row of a top whose chaos was to be proved."""
    orbit = row["kind"] if row["proved"] else row["cause"]
    period = float(row["period"]) if row["proved"] else None
    return {**row, "top": f"chaos: {row['what']}", "orbit": orbit, "period": period}


def _refused(tops: list[kit.JsonObject]) -> list[kit.JsonObject]:
    """A row for all orbits of a top that have about one period and the same cause."""
    residues_of = kit.groups(
        ((row["what"], f"{row['period']:.5g}", row["cause"].partition(":")[0]), row["residue"])
        for row in kit.inner_rows(tops, "orbits")
        if not row["proved"]
    )
    return [
        {
            **{"top": f"orbits: {name}", "period": period, "orbits": len(residues), "cause": cause},
            "residue": kit.between(residues, ".1e") if len(residues) > 1 else f"{residues[0]:.1e}",
        }
        for (name, period, cause), residues in residues_of.items()
    ]


# --- figure ---------------------------------------------------------------------------------------
#
# Figures of the study of proofs: residues over periods; manifolds that cross.


_NOT_PROVED = "not proved"
_LOOKS = {
    "elliptic": (kit.BLUE, "o"),
    "hyperbolic": (kit.ORANGE, "o"),
    "inverse hyperbolic": (kit.GREEN, "o"),
    _NOT_PROVED: ("#555555", "x"),
}
_DOTS_PER_INCH = 200  # of the manifolds, which are pixels


def svgs(results: kit.JsonObject) -> dict[str, str]:
    """The study's figures by name, from its JSON object."""
    drawn = {"proofs": residues(results["orbits"])} if results["orbits"] else {}
    for row in results["chaos"]:
        if "drawn" in row:
            drawn["manifolds"] = manifolds(row["drawn"])
    return drawn


def manifolds(drawn: kit.JsonObject) -> str:
    """The manifolds of an unstable orbit on a section, and the sets of the proof."""

    def draw(axes: kit.Axes) -> None:
        for name, colour in (("unstable", kit.ORANGE), ("stable", kit.BLUE)):
            axes.plot(*drawn[name], ".", ms=1.4, mew=0, color=colour, rasterized=True)
            axes.plot([], [], ".", ms=6, mew=0, color=colour, label=f"{name} manifold")
        axes.plot(*drawn["sets"], "+", ms=5, color="#222222", label="sets, each in its own plane")
        axes.set(xlabel="azimuth of γ about r₀ (rad)", ylabel="cos(γ, r₀)")
        axes.set(xlim=(-0.1, 2 * np.pi + 0.1), ylim=(-1.1, 1.1))  # marks at the edges whole
        axes.set_xticks(np.pi * np.arange(5) / 2, ["0", "π/2", "π", "3π/2", "2π"])

    return kit.drawn(draw, 4.4, names=2, dpi=_DOTS_PER_INCH)


def residues(tops: list[kit.JsonObject]) -> str:
    """One panel per top: the residue of every orbit over its period."""
    panels, residue = {top["what"]: top for top in tops}, "residue (shaded: elliptic, 0 to 1)"
    return kit.side_by_side(panels, _draw_top, 1.6, "period", residue)


def _draw_top(axes: kit.Axes, top: kit.JsonObject) -> None:
    axes.axhspan(0, 1, color=kit.SHADE, lw=0)
    for kind, (colour, mark) in _LOOKS.items():
        rows = [row for row in top["orbits"] if row.get("kind", _NOT_PROVED) == kind]
        at = [row["period"] for row in rows], [row["residue"] for row in rows]
        axes.plot(*at, mark, color=colour, ms=4, label=kind)
    axes.set_yscale("symlog", linthresh=1, linscale=1.5)
    axes.locator_params("y", numticks=9)
    axes.yaxis.set_major_formatter("{x:g}")

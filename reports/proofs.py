"""Study ``proofs``: periodic orbits of seven tops, their stability, and chaos of five tops.

Each proof is made by the checker of certificates, which imports nothing of polhode, and is read
again by it from the certificate that was written.
"""

from __future__ import annotations

import tempfile
import time
from collections import Counter
from copy import copy
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

import kit
import polhode
from polhode.figures.canvas import residue_axis
from polhode.figures.proofs import SectionCrossings, crossings, draw_crossings

if TYPE_CHECKING:
    from matplotlib.axes import Axes


QUESTION = (
    "Which periodic orbits of a level can be proved to exist, of which tops is chaos proved, at "
    "what cost, and do the certificates hold when they are read again?"
)
ORBITS = {
    "asymmetric, chaotic": "general/asymmetric-chaotic",
    "asymmetric, regular": "general/asymmetric-regular",
    "asymmetric, of a section": "general/section",
    "Hairer and Vilmart's body": "published/hairer-vilmart",
    "Kovalevskaya's top": "kovalevskaya/generic",
    "Goryachev–Chaplygin top": "goryachev-chaplygin/two-frequencies",
    "next to Lagrange's top": None,
}
CHAOS = {
    "asymmetric, chaotic": "general/asymmetric-chaotic",
    "asymmetric, regular": "general/asymmetric-regular",
    "asymmetric, of a section": "general/section",
    "asymmetric, near upright": "general/near-upright",
    "Hairer and Vilmart's body": "published/hairer-vilmart",
}
DRAWN = "asymmetric, chaotic"  # the proof of chaos that has a figure
GRID, CROSSINGS, DIGITS = (16, 16), 3, 20
_QUICK_GRID = (6, 6)
_QUICK = ("asymmetric, regular",)

Row: TypeAlias = kit.JsonObject
#: What is proved, of which top, and the cells of a search.
Job: TypeAlias = tuple[str, str, tuple[int, int]]


def rows(quick: bool, say: kit.Say, only: kit.Only) -> kit.JsonObject:
    """The study's rows."""
    grid = _QUICK_GRID if quick else GRID
    jobs = [("chaos", name, grid) for name in ([] if quick else CHAOS) if only(f"chaos: {name}")]
    jobs += [
        ("orbits", name, grid) for name in (_QUICK if quick else ORBITS) if only(f"orbits: {name}")
    ]

    def tell(job: Job) -> None:
        say(f"{job[0]} of {job[1]}")

    workers = 1 if quick or len(jobs) < 2 else kit.cores()
    answers = [*kit.in_order(_answer, jobs, workers, tell)]
    return {
        "grid": list(grid),
        "crossings": CROSSINGS,
        "digits": DIGITS,
        "orbits": [
            answer for (kind, *_), answer in zip(jobs, answers, strict=True) if kind == "orbits"
        ],
        "chaos": [
            answer for (kind, *_), answer in zip(jobs, answers, strict=True) if kind == "chaos"
        ],
    }


def scene_of(top_name: str) -> polhode.Scene:
    """The scene of a top."""
    name = ORBITS.get(top_name, CHAOS.get(top_name))
    if name is not None:
        return polhode.load(name)
    # Lagrange's top but for a moment that is a fiftieth larger
    return polhode.top(
        moments=[2, Fraction(51, 25), 1],
        centre=[0, 0, 1],
        weight=1,
        omega=[Fraction(1, 2), Fraction(1, 4), 2],
        gamma=[Fraction(3, 5), 0, Fraction(4, 5)],
        end=1,
        name="next to Lagrange's top",
    )


def _answer(job: Job) -> Row:
    kind, name, grid = job
    return _orbits(name, grid) if kind == "orbits" else _chaos(name)


def _orbits(name: str, grid: tuple[int, int]) -> Row:
    """All orbits of a search on the scene's own level."""
    scene = scene_of(name)
    every = polhode.prove_orbits(scene, grid, CROSSINGS, digits=DIGITS)
    search, rows = every.search, []
    for orbit, proof in zip(search.orbits, every.proofs, strict=True):
        row: Row = {"period": float(orbit.period), "residue": float(orbit.residue)}
        if isinstance(proof, polhode.NotProved):
            rows.append(row | {"proved": False, "cause": str(proof).partition(": ")[2]})
            continue
        period, radius = proof.period.decimals
        row |= {"proved": True, "kind": proof.kind, "least_period": period, "within": radius}
        row |= {"digits": round(proof.digits, 1), "seconds": round(proof.seconds, 3)}
        rows.append(row | _checked(proof) | _stable(proof))
    return {
        "what": name,
        "scene": None if ORBITS[name] is None else scene.name,
        "h": f"{float(search.surface.h):g}",
        "f": f"{float(search.surface.f):g}",
        "orbits": sorted(rows, key=lambda row: row["period"]),
    }


def _stable(proof: polhode.ProvedOrbit) -> Row:
    """Whether an elliptic orbit is proved to be stable for all time, and how long that takes."""
    if proof.kind != "elliptic":
        return {}
    began = time.process_time()
    try:
        twist = str(polhode.prove_stability(proof).twist)
    except polhode.NotProved as why:
        return {"stable": False, "why_not_stable": str(why).partition(": ")[2]}
    return {
        "stable": True,
        "twist": twist,
        "stability_seconds": round(time.process_time() - began, 2),
    }


def _chaos(top_name: str) -> Row:
    """A proof of chaos on the scene's own level."""
    scene = scene_of(top_name)
    began = time.process_time()
    try:
        proof = polhode.prove_chaos(scene)
    except polhode.NotProved as why:
        seconds = round(time.process_time() - began, 1)
        cause = str(why).partition(": ")[2]
        return {"what": top_name, "scene": scene.name, "proved": False, "cause": cause} | {
            "seconds": seconds
        }
    period, _ = proof.orbit.period.decimals
    row: Row = {"what": top_name, "scene": scene.name, "proved": True, "period": period}
    row |= {"kind": proof.orbit.kind, "coverings": proof.coverings, "tries": proof.tries}
    row |= {"entropy": proof.entropy, "short": proof.short, "long": proof.long}
    row |= {"stretch": proof.stretch, "height": proof.height, "cone": proof.cone}
    row |= {"h": f"{float(proof.h):g}", "f": f"{float(proof.f):g}"}
    if top_name == DRAWN:
        row["drawn"] = {
            name: [[round(float(x), 3) for x in axis] for axis in points]
            for name, points in crossings(proof)._asdict().items()
        }
    return row | {"seconds": round(time.process_time() - began, 1)} | _checked(proof)


def _checked(proof: polhode.ProvedOrbit | Any) -> Row:
    """Whether the checker proves the proof's certificate, and how long that takes."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "proof.json"
        try:
            proof.save(path)
        except polhode.BadInput as why:
            return {"verified": False, "why": why.expected}
        began = time.process_time()
        verdict = polhode.verify(path)
    seconds = round(time.process_time() - began, 2)
    return {"verified": verdict.proved, "verify_seconds": seconds}


# --- page -----------------------------------------------------------------------------------------
#
# Tables and facts of the proofs study's page.


_AGAIN = "python reports/make.py proofs --only '{0}'"
_ORBITS = (
    kit.Column("top", "top"),
    kit.Column("level", lambda top: f"h = {top['h']}, f = {top['f']}"),
    kit.Column("proved", "share", meaning="orbits proved to exist, of those that the search found"),
    kit.Column("kinds", "kinds"),
    kit.Column("periods", "periods", meaning="least and largest period of the proved orbits"),
    kit.Column("fewest digits", "digits", ".1f", "the fewest proven digits of an orbit"),
    kit.Column("s", "seconds", ">", "processor seconds of a proof, the median"),
    kit.Column(
        "checked",
        "checked",
        "d",
        "proofs that the checker, which imports nothing of polhode, proves again from their "
        "certificates",
    ),
    kit.Column("check, s", "verify_seconds", ">", "processor seconds of such a check, the median"),
)
_STABLE = kit.Column(
    "stable",
    "stable",
    meaning="elliptic orbits that are stable for all time by J. Moser's theorem, of those proved",
)
_REFUSED = (
    kit.Column("top", "top"),
    kit.Column("period", "period", ">", "about that of all these orbits"),
    kit.Column("orbits", "orbits", "d"),
    kit.Column("residue", "residue", ">", "Greene's residue, 0 on a resonant torus"),
    kit.Column("cause", "cause", "", "why the proof was refused"),
)
_CHAOS = (
    kit.Column("top", lambda row: f"chaos: {row['what']}"),
    kit.Column("h", "h"),
    kit.Column("f", "f"),
    kit.Column(
        "orbit",
        lambda row: row["kind"] if row["proved"] else row["cause"],
        meaning="the unstable periodic orbit whose manifolds meet, or why the proof was refused",
    ),
    kit.Column("period", lambda row: float(row["period"]) if row["proved"] else None, ".6g"),
    kit.Column("coverings", "coverings", "d", "covering relations that the proof consists of"),
    kit.Column("stretch", "stretch", ".2f", "their least stretch, which must be above 1"),
    kit.Column("height", "height", ".2f", "their largest height, which must be below 1"),
    kit.Column(
        "entropy",
        "entropy",
        ".2g",
        "proven lower bound of the topological entropy, per unit of time",
    ),
    kit.Column("s", "seconds", ".1f", "processor seconds"),
    kit.Column(
        "checked",
        kit.yes("verified"),
        meaning=(
            "whether the checker, which imports nothing of polhode, proves it again from its "
            "certificate"
        ),
    ),
    kit.Column("check, s", "verify_seconds", ".1f", "processor seconds of that check"),
)


#: Of the proof that is drawn, where it is proved.
_PICTURE = """![Manifolds of the proved orbit, and the sets of the proof](manifolds.svg)

Chaos of the top *{what}*: maxima of the height of its centre of mass on the stable (blue) and the
unstable manifold (orange) of the proved orbit, as computed in double, and the sets of the proof,
which lie in planes of their own."""


def tables(results: kit.JsonObject) -> dict[str, kit.PageTable]:
    """The page's tables from the study's JSON object, of 0.3 too, which tells of no stability."""
    proved = [*map(_proved, results["orbits"])]
    stable = [_STABLE] if any(row["stable"] for row in proved) else []
    return {
        "orbits": kit.table(proved, [*_ORBITS[:4], *stable, *_ORBITS[4:]], _AGAIN),
        "refused": kit.table(_refused(results["orbits"]), _REFUSED, _AGAIN),
        "chaos": kit.table(results["chaos"], _CHAOS, _AGAIN),
    }


def facts(results: kit.JsonObject) -> dict[str, object]:
    """Counts and ranges of the rows."""
    orbits = [row for top in results["orbits"] for row in top["orbits"]]
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
        "proved_chaos": kit.share(row["proved"] for row in results["chaos"]),
        "chaos_seconds": kit.between([row["seconds"] for row in chaos], ".2g"),
        "verified_chaos": sum(row["verified"] for row in chaos),
        "picture": "".join(_PICTURE.format(**row) for row in chaos if "drawn" in row),
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
        "share": kit.share(row["proved"] for row in top["orbits"]),
        "kinds": _kinds(proved) or None,
        "stable": kit.share(stable) if stable else None,
        "periods": kit.between([row["period"] for row in proved], ".3g", kit.DASH),
        "digits": min((row["digits"] for row in proved), default=None),
        "seconds": kit.median([row["seconds"] for row in proved], ".2f"),
        "checked": sum(row["verified"] for row in proved),
        "verify_seconds": kit.median(checked, ".2f"),
    }


def _refused(tops: list[kit.JsonObject]) -> list[kit.JsonObject]:
    """A row for all orbits of a top that have about one period and the same cause."""
    residues_of: dict[tuple[str, str, str], list[float]] = {}
    for top in tops:
        for row in top["orbits"]:
            if not row["proved"]:
                cause = row["cause"].partition(":")[0]
                same = (f"orbits: {top['what']}", f"{row['period']:.5g}", cause)
                residues_of.setdefault(same, []).append(row["residue"])
    return [
        {
            **{"top": name, "period": period, "orbits": len(residues), "cause": cause},
            "residue": kit.between(residues, ".1e") if len(residues) > 1 else f"{residues[0]:.1e}",
        }
        for (name, period, cause), residues in residues_of.items()
    ]


# --- figure ---------------------------------------------------------------------------------------
#
# Figures of the study of proofs: residues over periods; manifolds that cross.


_COLOURS = {"elliptic": kit.BLUE, "hyperbolic": kit.ORANGE, "inverse hyperbolic": kit.GREEN}
_COLUMNS = 2
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
    with polhode.paper() as plt:
        size = kit.WIDTH, 4.4
        figure, axes = plt.subplots(figsize=size, layout="constrained", dpi=_DOTS_PER_INCH)
        points = (np.array(drawn[key]) for key in SectionCrossings._fields)
        draw_crossings(axes, SectionCrossings(*((x, y) for x, y in points)))
        place = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "ncols": 2}
        handles, names = axes.get_legend_handles_labels()
        shown = [copy(handle) for handle in handles]
        for handle in shown[:2]:
            handle.set_markersize(6)
        axes.legend(shown, names, **place)
        return kit.as_svg(figure)


def residues(tops: list[kit.JsonObject]) -> str:
    """One panel per top: the residue of every orbit over its period."""
    lines = -(-len(tops) // _COLUMNS)
    with polhode.paper() as plt:
        size = kit.WIDTH, 0.6 + 1.6 * lines
        figure, panels = plt.subplots(
            lines, _COLUMNS, figsize=size, layout="constrained", squeeze=False
        )
        for axes in panels.flat[len(tops) :]:
            axes.set_axis_off()
        for axes, top in zip(panels.flat, tops, strict=False):
            _draw_top(axes, top)
        figure.supxlabel("period", size=9)
        figure.supylabel("residue (shaded: elliptic, 0 to 1)", size=9)
        kit.legend(figure, 4)
        return kit.as_svg(figure)


def _draw_top(axes: Axes, top: kit.JsonObject) -> None:
    axes.axhspan(0, 1, color=kit.SHADE, lw=0)
    orbits = top["orbits"]
    kinds = [
        (kind, colour, "o", [row for row in orbits if row.get("kind") == kind])
        for kind, colour in _COLOURS.items()
    ]
    kinds.append(("not proved", "#555555", "x", [row for row in orbits if not row["proved"]]))
    for name, colour, mark, rows in kinds:
        at = [row["period"] for row in rows], [row["residue"] for row in rows]
        axes.plot(*at, mark, color=colour, ms=4, label=name)
    residue_axis(axes)
    axes.set_title(top["what"], size=9, loc="left")
    kit.plain(axes)

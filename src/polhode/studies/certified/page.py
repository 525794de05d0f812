"""Page of the study of certified digits."""

from __future__ import annotations

from collections.abc import Iterator

from polhode.output.json_object import JsonObject
from polhode.studies.page.blocks import Block, Figure, Heading, Items, Text
from polhode.studies.page.columns import CASE, END, Column, T, at_times, table, yes
from polhode.studies.page.words import between, median, share

TITLE = "Certified digits: what is proven, how far, and at what cost"
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
    "Digits lost over time, and the cost of a proof beside runs. No mark: the type does not hold "
    "so many digits, or the time of the run is lost in that of building it."
)

_AGAIN = "polhode study certified --only {0}"

_NOISE = Column("P", "noise", "d", "the proof's noise level is 2^-P, of states of order 1")
_CONTAINED = (
    CASE,
    Column("closed form", "reference"),
    END,
    Column("proven digits", "digits", ".1f"),
    Column(
        "worst", "ratio", ".2g", "largest |closed form - midpoint| over the radius, at three times"
    ),
    Column("inside", yes("inside", "NO"), meaning="whether the closed form lies in every ball"),
)
_COST = (
    CASE,
    END,
    Column("asked", "digits", "d", "digits that were asked for"),
    Column("proven", "proven", ".1f", "digits that were proved"),
    _NOISE,
    Column("tries", "tries", "d", "proofs begun, with more bits each, until one gave the digits"),
    Column("proof, s", "seconds.proof", ".3g", "CPU seconds of the proof with every try"),
    Column(
        "mp, s",
        lambda row: row["seconds"].get(_mp(row)),
        ".3g",
        "CPU seconds of heyoka's run in MPFR with as many bits, which proves nothing",
    ),
    Column("quad, s", "seconds.quad", ".3g"),
    Column("refined, s", "seconds.quad, refined", ".3g", "CPU seconds of a refined run in quad"),
    Column("double, s", "seconds.double", ".3g"),
    Column("proof/mp", lambda row: _over(row, _mp(row)), ".2f"),
    Column("proof/quad", lambda row: _over(row, "quad"), ".2f"),
)
_JUDGED = (
    CASE,
    T,
    Column("component", "column", meaning="the component of the state with the largest error"),
    Column("error", "error", ">", "the error of the run in double at that time"),
    Column("uncertain by", "uncertainty", ">", "radius of the enclosure, proven"),
)


def blocks(found: JsonObject) -> Iterator[Block]:
    """The study's page from its JSON object."""
    yield Text(
        "An enclosure gives a ball for each number, a midpoint and a radius. It is proven to "
        "contain the exact motion of the exact scene, whatever heyoka computed (see "
        "`polhode.certify`). Proven digits are -log10 of the larger of the radius of w, over the "
        "largest |w|, and the radius of gamma."
    )
    yield Figure("certified", _SHOWN)
    for part, told in (
        ("contained", _containment),
        ("growth", _over_time),
        ("cost", _cost_of_proofs),
        ("judged", _judged),
    ):
        if found[part]:  # a part of a study may have none
            yield from told(found[part])
    yield Heading("Other programs: read about, not measured")
    yield Items(READ)


def finding(found: JsonObject) -> str:
    """The study in a sentence."""
    rows = found["contained"]
    inside = share(row["inside"] for row in rows)
    told = f"{inside} closed forms lie in their proven enclosures"
    if ratios := _over_mp(found["cost"]):
        times = between(ratios, ".1f")
        told += (
            f"; a proof takes {times} times as long as a run with as many bits that proves nothing"
        )
    return told + "."


def _mp(row: JsonObject) -> str:
    """The name of heyoka's run at the proof's own precision; "mp" where it has no seconds."""
    return next((name for name in row["seconds"] if name.startswith("mp")), "mp")


def _over_mp(rows: list[JsonObject]) -> list[float]:
    """What proofs take, in runs of as many bits."""
    return [ratio for row in rows if (ratio := _over(row, _mp(row))) is not None]


def _over(row: JsonObject, name: str) -> float | None:
    """What a proof takes, in runs of a name; None where these have no seconds."""
    seconds: dict[str, float] = row["seconds"]
    return seconds["proof"] / seconds[name] if name in seconds else None


def _containment(rows: list[JsonObject]) -> Iterator[Block]:
    outside = [row["case"] for row in rows if not row["inside"]]
    yield Heading("Every closed form in its enclosure")
    told = (
        f"All {len(rows)} closed forms lie in their enclosures"
        if not outside
        else f"{len(outside)} of {len(rows)} closed forms lie OUTSIDE: {', '.join(outside)}"
    )
    first = share(row["tries"] == 1 for row in rows)
    middle = median([row["ratio"] for row in rows], ".1g")
    yield Text(
        f"{told}. The median of *worst* is {middle}. 16 digits were asked "
        f"for; in {first} the first choice of precision was enough."
    )
    yield table(rows, _CONTAINED, _AGAIN)


def _over_time(rows: list[JsonObject]) -> Iterator[Block]:
    yield Heading("Digits lost over time, with and without the integrals")
    gains = [row["lost_without"][-1] - row["lost"][-1] for row in rows]
    told = (
        f"At the last time they save between {between(gains, '.1f', ' and ')} digits."
        if min(gains) > _NEAR
        else (
            f"At the last time they save up to {max(gains):.1f} digits, in some cases almost none."
        )
    )
    yield Text(
        "Digits that the proof has lost up to each time, counted from its noise level 2^-P. After "
        "every window the integrals (h, f, |gamma|² and, where there is one, a fourth) shrink the "
        f"set; the number in brackets is without them. {told}"
    )
    lost = at_times(
        rows[0]["times"],
        lambda row, k: f"{row['lost'][k]:.1f} ({row['lost_without'][k]:.1f})",
        "digits lost up to that time with the integrals, and in brackets without",
    )
    yield table(rows, (CASE, _NOISE, *lost), _AGAIN)


def _cost_of_proofs(rows: list[JsonObject]) -> Iterator[Block]:
    yield Heading("The cost of a proof")
    trials = sorted({row["trials"] for row in rows})
    times = " to ".join(str(n) for n in dict.fromkeys((trials[0], trials[-1])))
    told = (
        f"CPU seconds up to one time, the median of {times} measurements that alternate in one "
        "process. A proof includes its pilot run and every try. From the time of a run that of a "
        "run to a thousandth of the time is subtracted, which is the time of building it (a dash: "
        "the rest is too small to measure). These runs prove nothing: heyoka in MPFR at the "
        "proof's own precision (mp), in double and in quad, and a refined run in quad."
    )
    if ratios := _over_mp(rows):
        told += f" A proof takes {between(ratios, '.1f')} times as long as the mp run."
    yield Text(told)
    yield table(rows, _COST, _AGAIN + " --only '{2} digits'")


def _judged(rows: list[JsonObject]) -> Iterator[Block]:
    yield Heading("Runs in double, judged by proof")
    yield Text(
        "The largest error of a run in double in any component, and the radius by which it is "
        "uncertain. Both are proven."
    )
    yield table(rows, _JUDGED, _AGAIN)

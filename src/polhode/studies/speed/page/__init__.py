"""Page of the study speed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from polhode.studies.page.blocks import Block, Figure, Heading, Items, PageTable, Text
from polhode.studies.speed.page import caveats, lengths, verdicts

TITLE = "Speed: work against precision"


def blocks(found: dict[str, Any]) -> Iterator[Block]:
    """The study's page from its JSON object."""
    yield Text(
        "Error is the larger of the error of w over the largest |w| and the error of gamma, worst "
        "of eleven output times, against the exact scene: rounding the inputs is part of it. Every "
        "method runs in a process of its own on the same inputs and output times, twice round: "
        "first with empty caches of compiled code, then with those the first round left. Seconds "
        "are the least of all timed runs after one that warms up; a run of more than "
        f"{found.get('once_above', 0.25):g} seconds is made once. Import "
        "and compilation stand in columns of their own; for polhode compilation is the making of "
        "its integrator, which later runs of the same equations take up again; the second and "
        "later bodies of a process may find code that an earlier one left."
        f"{_left_out(found['motions'])}"
    )
    yield Text("Left of and below is better. The dotted line is three times kappa·eps of a double.")
    yield Text(finding(found))
    yield Figure("speed", _shown(found["motions"]))
    yield from caveats.blocks(found)
    yield from lengths.blocks(found.get("cells", ()))
    yield from verdicts.blocks(found)
    yield from _refined(found.get("refined", []))
    yield from _start_up(found["motions"])
    for motion in found["motions"]:
        yield Heading(f"{motion['motion']} to t = {motion['end']}")
        yield Text(_limits(motion))
        yield _points(motion)
    yield from _absent(found["motions"])
    yield from _elsewhere(found.get("elsewhere", ()))


def _left_out(motions: Sequence[dict[str, Any]]) -> str:
    """Which methods ran on some of the long motions alone: they take seconds."""
    long = [m for m in motions if m["kind"] == "regular"]
    ran: dict[str, list[str]] = {}
    for motion in long:
        for method in motion["methods"]:
            ran.setdefault(method["method"], []).append(motion["motion"])
    some: dict[tuple[str, ...], list[str]] = {}
    for name, on in ran.items():
        if len(on) < len(long):
            some.setdefault(tuple(on), []).append(name)
    told = (f"{', '.join(names)} ran on {' and '.join(on)} alone" for on, names in some.items())
    text = "; ".join(told)
    return f" To t = {long[0]['end']} {text}: they take seconds." if text else ""


def _elsewhere(rows: Sequence[dict[str, str]]) -> Iterator[Block]:
    """What was read of programs that are not run here."""
    if not rows:
        return
    yield Heading("Read elsewhere, not measured here")
    yield Text(
        "Programs that are not among the peers, most of them not written for Python, with what "
        "their own tests, pages or authors say of a rigid body. Each was read in the place named, "
        "none was measured for this report: machines, problems and measures of error differ, and "
        "nothing here can be set beside the tables above."
    )
    columns = ("program", "language", "problem", "figure", "source")
    header = ("program", "written in", "problem", "figure (read)", "read where")
    table = tuple(tuple(row[name] for name in columns) for row in rows)
    yield PageTable(header, table, "lllll")


def _shown(motions: list[dict[str, Any]]) -> str:
    """What the figure shows, and what it cannot."""
    told = f"Error against seconds on every motion. {caveats.CYRK_DRAWN}"
    left_out = [f"{status}: {', '.join(names)}" for status, names in _by_status(motions).items()]
    return f"{told}. Not drawn: {'; '.join(left_out)}" if left_out else told


def _by_status(motions: list[dict[str, Any]]) -> dict[str, list[str]]:
    """The methods that are missing, failed or stale somewhere."""
    found: dict[str, list[str]] = {}
    for motion in motions:
        for method in motion["methods"]:
            names = found.setdefault(method["status"], [])
            if method["method"] not in names:
                names.append(method["method"])
    return {status: names for status, names in found.items() if status != "ok"}


def finding(found: dict[str, Any]) -> str:
    """The study in a few sentences: what stands."""
    return f"{lengths.stands(found.get('cells', ()))} {caveats.SHORT}"


def _refined(rows: list[dict[str, Any]]) -> Iterator[Block]:
    """Refined runs beside heyoka's own steps."""
    if not rows:
        return
    yield Heading("Refined runs")
    gains = [row["gain"] for row in rows]
    better = [row["refined"]["digits"] - row["taylor"]["digits"] for row in rows]
    yield Text(
        "A run in double corrected by exact arithmetic, beside heyoka's own steps in the same "
        "number type: CPU seconds in one process, what is compiled being loaded, the least of "
        "several refined runs and one of steps. Correct digits at the end are by the closed form, "
        "or by heyoka's steps in 12 digits more; here they are not held to what the type can "
        f"hold. Refinement takes {1 / max(gains):.3f} to {1 / min(gains):.3f} of the time and "
        f"gives {min(better):+.1f} to {max(better):+.1f} digits more. The two share only a first "
        "guess; *agreement*: the digits to which they agree."
    )
    yield PageTable(
        (
            *("motion", "t", "bits", "steps s", "digits", "refined s", "digits"),
            *("agreement", "estimate", "gain"),
        ),
        tuple(
            (
                row["motion"],
                str(row["end"]),
                str(row["bits"]),
                _seconds(row["taylor"]["cpu"]),
                f"{row['taylor']['digits']:.1f}",
                _seconds(row["refined"]["cpu"]),
                f"{row['refined']['digits']:.1f}",
                f"{row['agreement']:.1f}",
                _seconds(row.get("estimate")),
                f"{row['gain']:.1f}",
            )
            for row in rows
        ),
        "lrrrrrrrrr",
        "polhode study speed --only 'refined: {0} t={1}'",
    )


def _start_up(motions: list[dict[str, Any]]) -> Iterator[Block]:
    """Import and compilation, of the first motion that a method ran."""
    first: dict[str, tuple[str, dict[str, Any]]] = {}
    for motion in motions:
        for method in motion["methods"]:
            first.setdefault(method["method"], (motion["motion"], method))
    yield Heading("Import and compilation")
    yield Text("Seconds, for the first motion that a method is given.")
    yield PageTable(
        ("method", "motion", "import", "cold compile", "cached compile", "version"),
        tuple(
            (
                name,
                motion,
                _seconds(m["import"]),
                _seconds(m["compile_cold"]),
                _seconds(m["compile_cached"]),
                m["version"] or m["status"],
            )
            for name, (motion, m) in first.items()
        ),
        "llrrrl",
        "polhode study speed --only '{0}' --only '{1}'",
    )


def _limits(motion: dict[str, Any]) -> str:
    told = [f"Case `{motion['case']}`, {motion['kind']}."]
    if "kappa" in motion:
        told.append(
            f"kappa = {motion['kappa']:.1e}; its bound leaves a double "
            f"{motion['digits_bound']:.1f} digits."
        )
    if motion["wall"] is None:
        told.append("No wall: the curves do not flatten together.")
    else:
        told.append(
            f"Wall: the curves flatten at {motion['wall']:.1f} digits in more than one number "
            "type; the reference is to blame."
        )
    return " ".join(told)


def _points(motion: dict[str, Any]) -> PageTable:
    rows = []
    for method in motion["methods"]:
        if not method["points"]:
            rows.append((method["method"], "–", method["status"], "–", "–", "–", "–", "–"))
        for p in method["points"]:
            rows.append(
                (
                    method["method"],
                    f"{p['tol']:.1e}",
                    f"{p['digits']:.1f}" if "digits" in p else p.get("status", "–"),
                    _seconds(p.get("seconds_min")),
                    _seconds(p.get("seconds_median")),
                    _seconds(p.get("cpu")),
                    str(p.get("runs", "–")),
                    "–" if p.get("steps") is None else str(p["steps"]),
                )
            )
    header = ("method", "tol", "digits", "least s", "median s", "cpu s", "runs", "steps")
    again = f"polhode study speed --only '{motion['motion']}' --only '{{0}}'"
    return PageTable(header, tuple(rows), "lrrrrrrr", again)


def _absent(motions: list[dict[str, Any]]) -> Iterator[Block]:
    """Each method that is missing, failed or stale, and why, once."""
    told = {
        f"{m['method']}: {m['status']} ({m['reason']})": None
        for motion in motions
        for m in motion["methods"]
        if m["status"] != "ok"
    }
    if told:
        yield Heading("Missing, failed, stale")
        yield Items(tuple(told))


def _seconds(x: float | None) -> str:
    return "–" if x is None else f"{x:.3g}"

"""Part of the page of speed: polhode beside other programs, in sentences."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterable, Sequence
from typing import TypeAlias

from polhode.output.json_object import JsonObject
from polhode.studies.page.words import between, median
from polhode.studies.page.words import counted as in_words
from polhode.studies.speed.programs import ENGINE, OURS, RUN

#: Part of the study's JSON object: the whole, a cell, a level of it.
Told: TypeAlias = JsonObject
#: Levels of digits, each with its cell.
Levels: TypeAlias = Sequence[tuple[Told, Told]]

LONG = 1000  # from this end on a run is told as a long one
SHOWN_OUTPUTS = 101  # of the figure
_COUNTED = (
    "Counted are cells in which the propagator and another program reach the digits; of the others "
    "it is said how many there are. Not every program was run in every cell."
)
WORDS = ("ahead", "even", "behind", "alone", "not reached")


def _far(cell: Told, _: float) -> bool:
    return bool(cell["end"] >= 100)


def _near(cell: Told, _: float) -> bool:
    return bool(cell["end"] <= 10)


def finding(found: Told) -> str:
    """What the cells and the first results say, in sentences made of them."""
    return " ".join(points(found))


def points(found: Told) -> list[str]:
    """The same point by point, the conditions first; none where there are no cells."""
    cells = found["cells"]
    if not cells:
        return []
    stands = [
        _stands(cells, "from t = 100 on, to 9 and 12 digits,", lambda c, d: _far(c, d) and d > 6),
        _stands(cells, "from t = 1000 on, to 6 digits,", lambda c, d: c["end"] >= LONG and d == 6),
        _stands(cells, "at t = 100, to 6 digits,", lambda c, d: 100 <= c["end"] < LONG and d == 6),
        _stands(cells, "at t = 1 and 10, to 6 digits,", lambda c, d: _near(c, d) and d == 6),
        _stands(cells, "and there to 9 and 12 digits", lambda c, d: _near(c, d) and d > 6),
    ]
    told = [_conditions(found), f"{_ahead_of_all(stands)} {_COUNTED}", _losses(cells)]
    told += [_engine(cells), _trajectories(cells), _compensated(cells)]
    told += [_first(found["first"]), _absent(found)]
    return [text for text in told if text]


def short(found: Told) -> str:
    """The same in a paragraph: where polhode is ahead, where it is not, beside its own engine."""
    cells = found["cells"]
    sentences = [
        "Every program is prepared once and given a new start each time.",
        _ahead_of_all(_far_and_near(cells)),
        *(_losses(cells), _engine(cells), _absent(found)),
    ]
    return " ".join(filter(None, sentences))


def _ahead_of_all(stands: Sequence[str]) -> str:
    """In how many cells a propagator is ahead of all others, in a sentence."""
    told = "; ".join(filter(None, stands))
    first = "A polhode propagator is ahead of every other program, heyoka itself apart,"
    return f"{first} {told}." if told else ""


def _conditions(found: Told) -> str:
    kinds = list(dict.fromkeys(cell["kind"] for cell in found["cells"]))
    draws = found["cells"][0]["draws"]
    return (
        f"Every program is prepared once and called with a new start each time, for {draws} bodies "
        f"of each of {len(kinds)} kinds ({', '.join(kinds)}). Ratios are of processor time to the "
        "same digits, measured side by side in one process."
    )


def levels(
    cells: Iterable[Told], wanted: Callable[[Told, float], bool] = lambda *_: True
) -> Levels:
    """The cells and their levels that are wanted."""
    return [(c, x) for c in cells for x in c["levels"] if wanted(c, x["digits"])]


def counted(found: Levels) -> dict[str, int]:
    """How often polhode is ahead, even, behind, alone, or does not reach the digits itself."""
    stands = [level["verdict"]["stands"] for _, level in found]
    return {word: stands.count(word) for word in WORDS}


def _stands(cells: Sequence[Told], where: str, wanted: Callable[[Told, float], bool]) -> str:
    """In how many of the cells a propagator is ahead of all others, where both reach the digits."""
    count = counted(levels(cells, wanted))
    ahead, compared = _ahead(cells, wanted)
    if not compared and not count["alone"]:
        return ""
    more = [in_words({word: count[word] for word in ("even", "behind")})]
    if count["alone"]:
        more.append(f"{count['alone']} more that no other program run there reaches")
    if count["not reached"]:
        more.append(f"{count['not reached']} that it does not reach")
    told = "; ".join(filter(None, more))
    return f"{where} in {ahead} of {compared} cells" + (f" ({told})" if told else "")


def _ahead(cells: Sequence[Told], wanted: Callable[[Told, float], bool]) -> tuple[int, int]:
    """In how many cells it is ahead, of how many in which it and another reach the digits."""
    here = levels(cells, wanted)
    count = counted(here)
    return count["ahead"], len(here) - count["not reached"] - count["alone"]


def _far_and_near(cells: Sequence[Told]) -> list[str]:
    """In how many cells of long and of short runs it is ahead."""
    return [
        _stands(cells, "to 6, 9 and 12 digits from t = 100 on", _far),
        _stands(cells, "at t = 1 and 10", _near),
    ]


def _by_end(cells: Sequence[Told]) -> dict[float, Levels]:
    """All cells and their levels by the length of the runs, from the shortest on."""
    ends = sorted({cell["end"] for cell in cells})
    return {end: levels([cell for cell in cells if cell["end"] == end]) for end in ends}


def _losses(cells: Sequence[Told]) -> str:
    """Where it is behind: by whom, and by how much."""
    told = []
    for end, here in _by_end(cells).items():
        verdicts = [level["verdict"] for _, level in here]
        lost = [verdict for verdict in verdicts if verdict["stands"] == "behind"]
        if lost:
            worst = min(lost, key=lambda verdict: float(verdict["ratio"][0]))
            middle = median([verdict["ratio"][0] for verdict in lost], ".2f")
            told.append(f"{middle} at t = {end} ({worst['best']} {worst['ratio'][0]:.2f})")
    if not told:
        return ""
    return (
        "Where it is behind, the best program takes less time, by these factors in the median "
        f"(and at the least): {', '.join(told)}."
    )


def _engine(cells: Sequence[Told]) -> str:
    """polhode beside heyoka written by hand."""
    told = []
    for end, here in _by_end(cells).items():
        ratios = [1 / ratio for ratio in ratios_of(here, ENGINE)]
        if ratios:
            told.append(f"{median(ratios, '.2f')} (at most {max(ratios):.2f}) at t = {end}")
    if not told:
        return ""
    return (
        "polhode integrates with heyoka. The time of a propagator over that of the same "
        f"integration written by hand in heyoka is {', '.join(told)}."
    )


def _trajectories(cells: Sequence[Told]) -> str:
    """What a trajectory of ``integrate`` costs more than a propagator's states."""
    medians = []
    for end, here in _by_end(cells).items():
        pairs = [_both(level) for cell, level in here if cell["outputs"] == 2]
        more = [1000 * (run - ours) for ours, run in pairs if ours and run]
        if more and end <= 100:
            medians.append(statistics.median(more))
    if not medians:
        return ""
    return (
        "`polhode.integrate`, which makes a trajectory with its checks, costs "
        f"{between(medians, '.2f')} ms more for each run with a new start and 2 outputs, up to t = "
        "100."
    )


def _both(level: Told) -> tuple[float | None, float | None]:
    """Seconds of a propagator and of ``integrate``."""
    seconds = {program["program"]: program["seconds"] for program in level["programs"]}
    return seconds.get(OURS), seconds.get(RUN)


def _compensated(cells: Sequence[Told]) -> str:
    """The program that keeps digits where others lose them."""
    name = "splitting 8 compensated"
    here = levels(cells, lambda c, d: c["end"] >= LONG and d == 12)
    met = [(c, p) for c, x in here for p in x["programs"] if p["program"] == name]
    if not met:
        return ""
    reached, asked = sum(p["reached"] for _, p in met), sum(cell["draws"] for cell, _ in met)
    text = (
        f"To 12 digits from t = {LONG} on, {name} reaches the digits in {reached} of {asked} runs"
    )
    if ratios := ratios_of(here, name):
        text += f", and takes {median(ratios, '.2g')} times as long as a propagator where both do"
    return f"{text}."


def _first(rows: Sequence[Told]) -> str:
    """The first result of each program, from the fastest on."""
    there = sorted((row["cold"]["wall"], row["program"]) for row in rows if "cold" in row)
    told = ", ".join(f"{name} {seconds:.2g}" for seconds, name in there)
    return (
        f"The first result in a new process, in seconds with nothing compiled before: {told}."
        * bool(told)
    )


def _absent(found: Told) -> str:
    return f"Not run: {', '.join(found['without'])}." if found["without"] else ""


def ratios_of(found: Levels, name: str) -> list[float]:
    """The ratios of a program, where it has one."""
    programs = [program for _, level in found for program in level["programs"]]
    named = [program["ratio"] for program in programs if program["program"] == name]
    return [ratio[0] for ratio in named if ratio is not None]

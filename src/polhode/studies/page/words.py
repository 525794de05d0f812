"""Numbers and counts of rows in words, as they stand in cells and sentences."""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Mapping, Sequence

DASH = "–"


def formatted(value: object, form: str) -> str:
    """A value in a form of columns (see ``Column``); a dash where there is none."""
    if value is None or value == "":
        return DASH
    if form == "code":
        return f"`{value}`"
    return value if isinstance(value, str) else format(value, form)


def median(values: Sequence[float], form: str) -> str:
    """Their median; a dash where there is none."""
    return format(statistics.median(values), form) if values else DASH


def between(values: Sequence[float], form: str, to: str = " to ") -> str:
    """From the least to the largest; a dash where there is none."""
    return f"{min(values):{form}}{to}{max(values):{form}}" if values else DASH


def spread(values: Sequence[float], form: str) -> str:
    """The median, and in brackets the least and the largest of several."""
    middle = median(values, form)
    return f"{middle} ({between(values, form, DASH)})" if len(values) > 1 else middle


def share(flags: Iterable[bool]) -> str:
    """How many of all are true: "3 of 5"."""
    every = [*flags]
    return f"{sum(every)} of {len(every)}"


def counted(counts: Mapping[str, int]) -> str:
    """How many of each, those of which there are some: "3 elliptic, 2 hyperbolic"."""
    return ", ".join(f"{count} {word}" for word, count in counts.items() if count)


def listed(words: Iterable[str]) -> str:
    """Each of the words once, in order; a dash where there is none."""
    return ", ".join(sorted(set(words))) or DASH

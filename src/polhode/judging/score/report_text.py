"""A judgement in words: its table of digits, its notes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

from polhode.common.text_tables import aligned, few
from polhode.judging.conditioning.rounding_errors import Band
from polhode.judging.diagnosis.error_budget import shown_digits
from polhode.numbers.decimals import decimal_string, in_full, shortest
from polhode.numbers.number_types import NumberType

SHOWN = 11  # times that are printed
#: What a note says of one column, and of several.
_OF_COLUMNS = {
    " is not in the file": " are not in the file",
    " is not known and was not judged": " are not known and were not judged",
}
_SHORT = 24  # characters of a time that is printed with all its digits


def table(
    times: Sequence[Fraction],
    digits: Sequence[float | None],
    expected: Sequence[Band | None],
    number: NumberType,
    parts: Mapping[str, Sequence[float | None]],
) -> list[str]:
    """The lines of the digits at a few of the times, beside those that are expected.

    ``digits``: of the state, empty where it was not judged, None where it has no number;
    ``parts``: of others.
    """
    shown = few(len(times), SHOWN)
    columns = {"t": [_time(times[k], number) for k in shown]}
    if digits:
        columns["correct digits"] = [shown_digits(digits[k], expected[k]) for k in shown]
        bands = ["unknown" if (b := expected[k]) is None else b.shown(number) for k in shown]
        columns[f"expected in {number.name}"] = bands
    for name, of_part in parts.items():
        columns[name] = ["-" if (d := of_part[k]) is None else f"{d:.2f}" for k in shown]
    lines = aligned([*columns], [*zip(*columns.values(), strict=True)])
    if len(shown) < len(times):
        lines.append(f"({len(shown)} of {len(times)} times; all of them with --json)")
    return lines


def together(notes: Sequence[str]) -> list[str]:
    """Notes that say the same of several columns as one, in the first one's place."""
    told = list(notes)
    for one, many in _OF_COLUMNS.items():
        same = [k for k, note in enumerate(told) if note.endswith(one)]
        if len(same) > 1:
            names = " ".join(told[k].removeprefix("column ").removesuffix(one) for k in same)
            told[same[0]] = f"columns {names}{many}"
            told = [note for k, note in enumerate(told) if k not in same[1:]]
    return told


def _time(t: Fraction, number: NumberType) -> str:
    """Every digit of a time, where they are few; of a number of the type as few as tell it."""
    text = shortest(t, number) if number.rounded(t) == t else in_full(t)
    return text if len(text) <= _SHORT else decimal_string(t, 17)

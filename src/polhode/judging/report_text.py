"""A judgement in words: its table of digits, what its limit means."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from fractions import Fraction

from polhode.common.errors import aligned, few
from polhode.judging.conditioning import Band
from polhode.judging.limits import Limit, shown_digits
from polhode.judging.residuals import Residual
from polhode.judging.score import SHOWN
from polhode.numbers.decimals import brief, in_full, shortest
from polhode.numbers.number_types import NumberType

_SHORT = 24  # characters of a time that is printed with all its digits

#: What a limit says of the digits, by its name; ``how``: its words in brackets.
LIMITS = {
    "rounding": "as many as {number} precision allows for this motion",
    "conditioning": "as many as {number} precision allows for this motion",
    "inputs": "as many as the scene's numbers, rounded to {number}, allow",
    "reference": "as many as the reference can tell",
    "method": "fewer than {number} precision allows: {how}",
    "noise": "fewer than {number} precision allows: noise that is {how} at this level",
    "bias": "fewer than {number} precision allows: a {how} bias, with white noise about it",
    "unknown": "{how}",
}
ROUNDED = "as many as rounding {how} leaves"
FOREIGN = "the program's steps, noise, or another motion"
BY_CHANCE = "; or by chance: one run in {runs:.0f} has so few"
EXPLAINED = "another number explains the error"
ELSEWHERE = "another convention gives more digits"
WRONG_AT_ONCE = "wrong in the first digit"
NOTHING = "nothing was judged"
OWN_EQUATIONS = (
    "of a program's own equations polhode.compare_field(f, {scene!r}) names the terms that differ"
)


def meaning(limit: Limit, number: NumberType, foreign: bool) -> str:
    """What a limit says of digits; ``foreign``: of those of a table of another program."""
    how = FOREIGN if limit.name == "method" and foreign else limit.detail
    words = ROUNDED if limit.name == "rounding" and how else LIMITS[limit.name]
    return words.format(number=number.name, how=how)


def without_numbers(
    gaps: Mapping[str, Sequence[int]], parts: Collection[str], times: Sequence[Fraction]
) -> str:
    """In which rows which of the parts have no numbers; empty where all have them everywhere."""
    alike: dict[tuple[int, ...], list[str]] = {}
    for part, rows in gaps.items():
        alike.setdefault(tuple(rows), []).append(part)
    told = []
    for rows, names in alike.items():
        of = "" if len(names) == len(parts) else f" of {' and '.join(names)}"
        count, share, first = len(times), f"{len(rows)} of {len(times)} rows", brief(times[rows[0]])
        if len(rows) == count:
            where = "in any row"
        elif len(rows) == 1:
            where = f"at t = {first} ({share})"
        elif rows == (*range(rows[0], count),):
            where = f"from t = {first} on ({share})"
        else:
            where = f"in {share}, the first at t = {first}"
        told.append(f"no numbers{of} {where}")
    return ", ".join(told)


def residual_text(left: Sequence[Residual]) -> str:
    """Residuals in words: of each column the root mean square and the bias."""
    told = [f"{x.column} {x.rms:.2g} ({x.bias:+.1g} ± {x.bias_error:.1g})" for x in left]
    return f"noise, rms (and bias): {', '.join(told)}"


def table(
    times: Sequence[Fraction],
    digits: Sequence[float | None],
    expected: Sequence[Band | None],
    number: NumberType,
    parts: Mapping[str, Sequence[float | None]],
    worst: int | None,
) -> list[str]:
    """The lines of the digits at a few of the times.

    ``digits``: of the state, empty where it was not judged, None where it has no number;
    ``parts``: of others.  ``worst``: the row that is shown beside the first and the last; None for
    more rows, and those beside the digits that are expected.
    """
    count = len(times)
    shown = few(count, SHOWN) if worst is None else sorted({0, worst, count - 1})
    columns = {"t": [_time(times[k], number) for k in shown]}
    if digits:
        columns["correct digits"] = [shown_digits(digits[k], expected[k]) for k in shown]
    if digits and worst is None:
        bands = ["unknown" if (b := expected[k]) is None else b.shown(number) for k in shown]
        columns[f"expected in {number.name}"] = bands
    for name, of_part in parts.items():
        columns[name] = ["-" if (d := of_part[k]) is None else f"{d:.2f}" for k in shown]
    lines = aligned([*columns], [*zip(*columns.values(), strict=True)])
    if worst is None and len(shown) < count:
        lines.append(f"({len(shown)} of {count} times; all of them with --json)")
    return lines


def _time(t: Fraction, number: NumberType) -> str:
    """Every digit of a time, where they are few; of a number of the type as few as tell it.

    Sixty times a double of minutes may be 0.99999999999999994, which is 1 here.
    """
    text = shortest(t, number) if number.rounded(t) == t else in_full(t)
    near = brief(t, 14)
    return near if len(text) > _SHORT or len(near) + 2 < len(text) else text

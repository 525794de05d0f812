"""Other times at which the rows of a table may hold, and the words for them.

A program's t may be a row late, run backward, begin at its first row, or have another unit.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

from polhode.judging.tables.reading import TimeChange
from polhode.judging.tables.table import Table
from polhode.numbers.conversion import to_double
from polhode.numbers.decimals import brief
from polhode.scenes.scene import Scene

#: Units of time by name, in the scene's.
UNITS: Mapping[str, Fraction] = {
    "milliseconds": Fraction(1, 1000),
    "microseconds": Fraction(1, 1_000_000),
    "nanoseconds": Fraction(1, 1_000_000_000),
    "minutes": Fraction(60),
    "hours": Fraction(3600),
    "days": Fraction(86400),
}
_FAR = 1e5  # radians: few programs go so far, and none begins there


def other_times(times: Sequence[Fraction]) -> dict[str, TimeChange]:
    """Times at which rows may hold instead, by what they are called, the plainest first.

    >>> [*other_times([Fraction(0), Fraction(1, 4)])]
    ['one step late', 'one step early', 'of the other sense', \
'of the other sense, from its last row on (0.25)', 'milliseconds', 'microseconds', 'nanoseconds', \
'minutes', 'hours', 'days']
    """
    first, *later = sorted({*times})
    last = max(times)
    begun, back = {}, {"of the other sense": TimeChange(sign=-1)}
    units = {name: TimeChange(unit=length) for name, length in UNITS.items()}
    if first:
        words = f"from its first row on ({brief(first)})"
        begun[words] = TimeChange(shift=first)
        back[f"of the other sense, {words}"] = TimeChange(-1, shift=-first)
        for name, length in UNITS.items():
            units[f"{name}, {words}"] = TimeChange(unit=length, shift=length * first)
    if last not in (first, 0):  # a program that counts down
        words = f"of the other sense, from its last row on ({brief(last)})"
        back[words] = TimeChange(-1, shift=-last)
    steps = {
        f"one step {word}": TimeChange(shift=sign * (second - first))
        for second in later[:1]
        for sign, word in ((1, "late"), (-1, "early"))
    }
    return begun | steps | back | units


def clock_remark(subject: Table, scene: Scene) -> tuple[str, ...]:
    """That times that are far and close together look like a clock's, in words."""
    first, last = (to_double(end(subject.times)) for end in (min, max))
    nearest = min(abs(first), abs(last))
    if nearest * 10.0**scene.log10_rate < _FAR or last - first > nearest / 10:
        return ()
    began = brief(min(subject.times), 12)
    return (
        f"t looks like a clock's ({began} to {last - first:.3g} later): the first row is not the "
        "scene's start",
    )

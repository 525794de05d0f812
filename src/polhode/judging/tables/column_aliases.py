"""Names that other programs give to the columns of a trajectory."""

from __future__ import annotations

import re
from typing import NamedTuple

from polhode.equations.column import column as derived_column
from polhode.equations.column import derived_words
from polhode.scenes.vocabulary import ANGLES, ATTITUDE, COLUMNS, STATE, column_names

_OTHERS = {
    "time": "t",
    "seconds": "t",
    **{f"w{axis}": name for axis, name in zip("xyz", STATE, strict=False)},
    **{f"w_{axis}": name for axis, name in zip("xyz", STATE, strict=False)},
    **{f"g{axis}": name for axis, name in zip("xyz", STATE[3:], strict=False)},
    **{f"gamma_{axis}": name for axis, name in zip("xyz", STATE[3:], strict=False)},
    **{f"g{n}": name for n, name in zip("123", STATE[3:], strict=False)},
    **{f"q{axis}": name for axis, name in zip("wxyz", ATTITUDE, strict=False)},
    **{f"q_{axis}": name for axis, name in zip("wxyz", ATTITUDE, strict=False)},
    "q4": "q0",  # of q1 q2 q3 q4, whose last one mostly is the scalar
    "precession": "psi",
    "nutation": "theta",
    "spin": "phi",
    # Of another sequence: wrong as they stand, and the judgement says how they would be right.
    **dict(zip(("yaw", "pitch", "roll"), ANGLES, strict=True)),
}
#: A unit at the end of a name: ``psi_deg``, ``wx [deg/s]``, ``p (rad/s)``, ``time [s]``.
_UNIT = re.compile(r"[\s_]*[\[(]?(deg|degrees|rad|radians|s|sec)(?:[/_ ]s)?[\])]?$", re.I)


def known() -> list[str]:
    """The names of all columns of a trajectory."""
    return ["t", *STATE, *column_names()]


def not_judged() -> dict[str, str]:
    """Names of columns that are known and not judged, and why."""
    return {
        name: why
        for word in derived_words()
        if (why := derived_column(word).not_judged)
        for name in COLUMNS[word].names
    }


class Column(NamedTuple):
    """The column that a header names, None where it is unknown; whether it is in degrees."""

    name: str | None
    degrees: bool = False


def column(header: str) -> Column:
    """What a header of a table means.

    >>> column("qw"), column("wx [deg/s]"), column("psi_deg"), column("note")
    (Column(name='q0', degrees=False), Column(name='p', degrees=True), \
Column(name='psi', degrees=True), Column(name=None, degrees=False))
    """
    names = known()
    if header in names:
        return Column(header)
    unit = _UNIT.search(header)
    bare = header[: unit.start()] if unit and unit.start() else header
    name = bare if bare in names else _OTHERS.get(bare.lower())
    if name is None:
        return Column(None)
    degrees = unit is not None and bare != header and unit.group(1).lower().startswith("deg")
    return Column(name, degrees)

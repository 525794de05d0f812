"""Names that other programs give to the columns of a trajectory."""

from __future__ import annotations

import re
from collections.abc import Iterable
from fractions import Fraction
from typing import NamedTuple

from polhode.equations.column import column as derived_column
from polhode.equations.column import derived_words
from polhode.scenes.vocabulary import ANGLES, ATTITUDE, COLUMNS, STATE, column_names

_OTHERS = {
    "time": "t",
    "seconds": "t",
    "timestamp": "t",
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
#: Of ROS, Unity and Blender: ``orientation.w``, ``Rotation_X``, ``rotation_quaternion[0]``; of
#: MuJoCo's ball joint ``qpos0``, ``qvel[2]``, whose rates are along body axes.
_QUATERNION = re.compile(
    r"(?:.*[./])?(?:orientation|rotation|quaternion|quat|attitude|rotation_quaternion)"
    r"[._ ]?(?:\[?(?:quat_)?([wxyz0-3])\]?)$"
)
_RATE = re.compile(r"(?:.*[./])?(?:angular_?velocity|ang_?vel|gyro)[._ ]?\[?([xyz0-2])\]?$")
_BALL = re.compile(r"(qpos|qvel)[_.]?\[?([0-3])\]?$")
#: A unit at the end of a name: ``psi_deg``, ``wx [deg/s]``, ``p (rad/s)``, ``time [s]``.
_UNIT = re.compile(
    r"[\s_]*[\[(]?(deg|degrees|rad|radians|rpm|ms|us|ns|s|sec)(?:[/_ ]s)?[\])]?$", re.I
)
#: The whole seconds and the nanoseconds of one time, as ROS writes it.
_STAMP = re.compile(r"(?:.*[./])?stamp[._](?:(secs?)|nano?secs?|nsecs?)$")
_TIMES = {"ms": Fraction(1, 1000), "us": Fraction(1, 10**6), "ns": Fraction(1, 10**9)}


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
    """The column that a header names, None where it is unknown; whether it is in degrees.

    ``factor``: what its numbers are multiplied by, of another unit.  ``part``: whether columns of
    that name are added up.
    """

    name: str | None
    degrees: bool = False
    factor: Fraction = Fraction(1)
    part: bool = False


def column(header: str) -> Column:
    """What a header of a table means.

    >>> column("qw").name, column("wx [deg/s]")[:2], column("psi_deg")[:2], column("note").name
    ('q0', ('p', True), ('psi', True), None)
    >>> column("time_ms").name, column("time_ms").factor, column("pose.orientation.w").name
    ('t', Fraction(1, 1000), 'q0')
    """
    names = known()
    if header in names:
        return Column(header)
    if header == "%time":
        return Column("t", False, _TIMES["ns"])
    if stamp := _STAMP.match(header.lower()):
        return Column("t", False, Fraction(1) if stamp[1] else _TIMES["ns"], True)
    unit = _UNIT.search(header)
    bare = header[: unit.start()] if unit and unit.start() else header
    name = bare if bare in names else _OTHERS.get(bare.lower()) or _exported(bare.lower())
    if name is None:
        return Column(None)
    word = unit.group(1).lower() if unit is not None and bare != header else ""
    if word in _TIMES:
        return Column(name, False, _TIMES[word]) if name == "t" else Column(None)
    if word == "rpm":
        return Column(name, True, Fraction(6)) if name in STATE[:3] else Column(None)
    return Column(name, word.startswith("deg"))


def twice(named: Iterable[Column]) -> str | None:
    """A name that two columns have which are no parts of one; None where there is none."""
    held = [*named]
    for name in known():
        same = [found for found in held if found.name == name]
        if len(same) > 1 and not (all(x.part for x in same) and len({*same}) == len(same)):
            return name
    return None


def _exported(name: str) -> str | None:
    """The column of a name as engines export it; None of another."""
    if found := _QUATERNION.match(name):
        return ATTITUDE["wxyz0123".index(found[1]) % 4]
    if found := _RATE.match(name):
        return STATE["xyz012".index(found[1]) % 3]
    if found := _BALL.match(name):
        place = int(found[2])
        return ATTITUDE[place] if found[1] == "qpos" else None if place > 2 else STATE[place]
    return None

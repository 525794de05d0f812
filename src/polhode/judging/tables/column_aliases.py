"""Names that other programs give to the columns of a trajectory, and those that somebody tells.

A name is a stem and an axis, ``gyro`` and ``x``, after a path and before a unit: ``imu/gyro_x
[deg/s]``. What it means may depend on the others: whether axes are counted from 0 or from 1,
and whether ``gx`` is a component of gamma or a rate.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from fractions import Fraction
from functools import cache, partial
from typing import NamedTuple, TypeAlias

from polhode.common.errors import BadInput, nearest
from polhode.equations.columns import FORMULAS, derived_words
from polhode.numbers import exact, expression
from polhode.numbers.conversion import exactly, to_double
from polhode.numbers.expression import ExpressionError
from polhode.numbers.number_types import Given, GivenRow
from polhode.numbers.vectors import quaternion_products
from polhode.scenes.vocabulary import (
    ANGLES,
    ATTITUDE,
    COLUMNS,
    MATRIX,
    RODRIGUES,
    STATE,
    column_names,
)

# --- attitude forms -------------------------------------------------------------------------------
#
# Other forms of an attitude as quaternions: rotation matrices, Rodrigues parameters, vectors.
#
# All of them belong to the rotation R from the body's axes to those of space, v_space = R v_body:
# the matrix ``R11 ... R33``, row by row; the vector theta n of ROTATION_VECTOR, n the axis and
# theta the angle in radians; and the modified Rodrigues parameters n tan(theta/4).  The quaternion
# is (cos(theta/2), n sin(theta/2)).  Where a file's are those of the rotation from space to body, a
# judgement's readings say so.
#
# None of these forms tells the sign of the quaternion, and parameters may leap to those of the same
# rotation by 2 pi - theta: each row has the sign that is nearer to the row before, so that curves
# of them have no leaps.


GUARD = 64  # bits beyond those of the cells
_OFF = 1e-3  # of 1: a length that is another, and no error of a method

#: Exact numbers of a column as they were written, None where there is none.
Cells: TypeAlias = "tuple[float | Decimal | Fraction | None, ...]"
Quaternion: TypeAlias = "list[Fraction]"


def with_quaternions(columns: Mapping[str, Cells], bits: int) -> dict[str, Cells]:
    """Columns with a quaternion instead of another form of the attitude, if they have one.

    ``bits``: of the cells.  A row with an empty cell, or with numbers of no rotation, has none.
    """
    readers: dict[tuple[str, ...], Callable[[Sequence[Fraction]], Quaternion | None]] = {
        MATRIX: partial(_of_matrix, bits=bits + GUARD),
        RODRIGUES: _of_parameters,
        ROTATION_VECTOR: partial(_of_vector, bits=bits + GUARD),
    }
    for names, read in readers.items():
        if {*names} <= columns.keys():
            rows = zip(*(columns[name] for name in names), strict=True)
            cells = zip(*_steady(rows, read), strict=True)
            others = {name: x for name, x in columns.items() if name not in names}
            return others | dict(zip(ATTITUDE, cells, strict=True))
    return dict(columns)


def lengths(rows: Given) -> tuple[float, float] | None:
    """The least and the largest length of quaternions, if one is not nearly 1; None if all are."""
    there = [[to_double(exactly(x)) for x in row if x is not None] for row in rows]
    sizes = [math.hypot(*row) for row in there if len(row) == len(ATTITUDE)]
    least, most = min(sizes, default=1.0), max(sizes, default=1.0)
    return None if max(1 - least, most - 1) < _OFF else (least, most)


def of_length_one(row: GivenRow, bits: int) -> list[Fraction | None]:
    """A quaternion over its length, as it is where it has none."""
    there = [exactly(x) for x in row if x is not None]
    length = root(sum((x * x for x in there), Fraction(0)), bits + GUARD)
    if length == 0 or len(there) < len(row):
        return [None if x is None else exactly(x) for x in row]
    return [x / length for x in there]


def _steady(
    rows: Iterable[Cells], read: Callable[[Sequence[Fraction]], Quaternion | None]
) -> list[Sequence[Fraction | None]]:
    steady: list[Sequence[Fraction | None]] = []
    before = None
    for row in rows:
        there = [exactly(x) for x in row if x is not None]
        q = read(there) if len(there) == len(row) else None
        if q is None:
            steady.append((None,) * 4)
            continue
        if before is not None and sum(x * y for x, y in zip(q, before, strict=True)) < 0:
            q = [-x for x in q]
        steady.append(q)
        before = [Fraction(float(x)) for x in q]
    return steady


def _of_matrix(r: Sequence[Fraction], bits: int) -> Quaternion | None:
    """From the component that is the largest, by 4 q0^2 = 1 + R11 + R22 + R33 and its like."""
    products = quaternion_products(r)
    k = max(range(4), key=lambda k: products[k][k])
    if products[k][k] <= 0:
        return None
    twice = root(products[k][k], bits)
    return [value / (2 * twice) for value in products[k]]


def _of_parameters(sigma: Sequence[Fraction]) -> Quaternion:
    square = sum((x * x for x in sigma), Fraction(0))
    return [(1 - square) / (1 + square), *(2 * x / (1 + square) for x in sigma)]


def _of_vector(vector: Sequence[Fraction], bits: int) -> Quaternion:
    angle = root(sum((x * x for x in vector), Fraction(0)), bits)
    if angle == 0:
        return [Fraction(1), *(x / 2 for x in vector)]
    cosine, sine = (exact.nearest(f(angle / 2), bits) for f in (exact.cos, exact.sin))
    return [cosine, *(x / angle * sine for x in vector)]


def root(square: Fraction, bits: int) -> Fraction:
    """The square root to so many bits."""
    return exact.nearest(exact.sqrt(square), bits)


# --- column aliases -------------------------------------------------------------------------------


_BITS = 3700  # of a degree: far more than any table prints

#: Another form of the attitude, which becomes a quaternion: see :func:`with_quaternions`.
ROTATION_VECTOR = ("rotvec1", "rotvec2", "rotvec3")

_WORDS = {
    **dict.fromkeys(("time", "seconds", "timestamp", "elapsed", "seconds_elapsed"), "t"),
    **dict.fromkeys(("elapsed_time", "sim_time", "simulation_time"), "t"),
    "precession": "psi",
    "nutation": "theta",
    "spin": "phi",
    # Of another sequence: wrong as they stand, and the judgement says how they would be right.
    **dict(zip(("yaw", "pitch", "roll"), ANGLES, strict=True)),
    **{name: name for name in (*STATE, *ANGLES, *ATTITUDE)},
}
_GREEK = str.maketrans({"ω": "w", "γ": "gamma", "ψ": "psi", "θ": "theta", "φ": "phi", "ϕ": "phi"})
_GREEK |= str.maketrans({"Ω": "w", "σ": "sigma", "°": "deg", "µ": "u", "μ": "u", "·": " "})

_S = r"[._/ -]?"
_BEFORE = r"(?:.*[./:])?(?:(?:imu|body|sensor|motion|device|vehicle)[_ -])*"
_TURNING = rf"(?:ang(?:ular)?|rot(?:ation(?:al)?)?|body){_S}(?:vel(?:ocity)?|rates?|speed)"
#: Stems by what they are stems of.  ``w_a`` is Modelica's, ``qvel`` MuJoCo's (of a ball joint),
#: ``sigma_BN`` and ``omega_BN_B`` Basilisk's, ``q_RS`` and ``w_RS_S`` those of EuRoC's data sets;
#: ``orientation``, ``rotation`` ROS, Unity and Blender have.  All rates are along body axes.
_STEMS = {
    "omega": rf"(?:w|omega|gyro(?:scope)?|gyr|rates?|gyro{_S}rotation|{_TURNING}|qvel)"
    rf"(?:{_S}(?:a|b|body|bn{_S}b|rs{_S}s|rad|xyz))?",
    "gamma": "gamma|g",
    "acceleration": rf"(?:lin(?:ear)?{_S})?a(?:cc(?:el(?:eration|erometer)?)?)?",
    "quaternion": r"q|quat|(?:orientation|rotation|quaternion|quat|attitude|rotation_quaternion)"
    rf"(?:{_S}(?:quat|q))?|qpos|q{_S}rs",
    "rodrigues": rf"(?:sigma|mrp)s?(?:{_S}(?:bn|bi|b))?",
    "vector": rf"rot(?:ation)?{_S}vec(?:tor)?|rv",
    "matrix": rf"(?:[rmtc]|dcm|rot(?:m|mat)?|rotation|(?:rot(?:ation)?{_S})?matrix)"
    rf"(?:{_S}(?:t|bn|nb|bi|ib))?",
}
_BARE_QUATERNION = frozenset("wxyz")  # all of them: x y z alone may be a place
_AXES = {"matrix": r"([xyz]{2}|\d{2}|\d\D{1,2}\d)", "quaternion": r"([wxyzrsijk0-4])"}
#: What may follow: of an acceleration, which is not read, a unit of any kind.
_AFTER = {"acceleration": r"(?:[\s_,(\[].*)?"}
_NAMES = {
    kind: re.compile(
        rf"{_BEFORE}({stems}){_S}[\[(]?{_AXES.get(kind, '([xyz0-3])')}[\])]?{_AFTER.get(kind, '')}$"
    )
    for kind, stems in _STEMS.items()
}
_COMPONENTS = {
    "omega": STATE[:3],
    "gamma": STATE[3:],
    "quaternion": ATTITUDE,
    "rodrigues": RODRIGUES,
    "vector": ROTATION_VECTOR,
    "matrix": MATRIX,
}
_NOTHING = re.compile(r"\s*(?:\[\s*\]|\(\s*\))$")  # a unit that is none
#: Parts of a time, after what they are parts of: ``header.stamp.sec`` and ``header.stamp.nanosec``.
_STAMP = re.compile(r"(.*?)(n(?:ano)?)?sec(?:ond)?s?$", re.I)
_MICRO, _NANO = Fraction(1, 10**6), Fraction(1, 10**9)
_OF_PX4 = frozenset(("timestamp_sample", "delta_q_reset[0]", "quat_reset_counter"))
_OF_EARLIER_PX4 = frozenset(("rollspeed", "q[0]"))
_ROLL = re.compile(rf"{_BEFORE}(roll|pitch|yaw){_S}(?:rate|speed|vel(?:ocity)?)$")

#: A unit at the end of a name: ``psi_deg``, ``wx [deg/s]``, ``p (rad/s)``, ``time [s]``.
_PER = r"(?:(?:/| ?per |_| )s(?:ec(?:ond)?)?|ps| ?s(?:\^?-1|⁻¹))"
_UNIT = re.compile(
    rf"[\s_,]*[\[(]?(?:(m?deg(?:rees?)?|m?rad(?:ians?)?)({_PER})?|(m?dps|rpm|rps|rev{_PER}|hz)"
    r"|(ms|us|ns|s|sec|seconds?|min|minutes?)|(-))[\])]?$",
    re.I,
)
_TIMES = {"ms": Fraction(1, 1000), "us": Fraction(1, 10**6), "ns": Fraction(1, 10**9)}
_TIMES |= {"min": Fraction(60), "minute": Fraction(60), "minutes": Fraction(60)}
_TURNS = {"rpm": Fraction(6), "dps": Fraction(1), "mdps": Fraction(1, 1000)}  # in degrees


@cache
def degree() -> Fraction:
    """A degree in radians."""
    return exact.nearest(exact.pi() / 180, _BITS)


def known() -> list[str]:
    """The names of all columns of a trajectory."""
    return ["t", *STATE, *column_names()]


def readable() -> list[str]:
    """The names of all columns that a table may have: those, and another form of the attitude."""
    return [*known(), *ROTATION_VECTOR]


def not_judged() -> dict[str, str]:
    """Names of columns that are known and not judged, and why."""
    return {
        name: why
        for word in derived_words()
        if (why := FORMULAS[word].not_judged)
        for name in COLUMNS[word].names
    }


def are_attitude(headers: Sequence[str]) -> list[bool]:
    """Which of headers that were left aside are a whole form of the attitude, beside another."""
    forms = {*MATRIX, *RODRIGUES, *ROTATION_VECTOR}
    return [column.name in forms for column in columns(headers)]


class AbsentColumn(BadInput):
    """That a table has no column of a name that was told: ``value``."""


class NamedColumn(NamedTuple):
    """The column that a header names, None where it is unknown.

    ``factor``: what its numbers are multiplied by, of another unit.
    """

    name: str | None
    factor: Fraction = Fraction(1)


UNKNOWN = NamedColumn(None)


class _Unit(NamedTuple):
    """A unit: of an ``angle``, a ``rate`` or a ``time``, empty for none of these."""

    kind: str
    factor: Fraction = Fraction(1)


class _Component(NamedTuple):
    """A header as a component: of what, by which stem, along which axis or axes."""

    kind: str
    stem: str
    axis: str
    unit: _Unit


def columns(headers: Sequence[str]) -> list[NamedColumn]:
    """What the headers of a table mean, all together.

    >>> [found.name for found in columns(["t", "gx", "gy", "gz"])]
    ['t', 'gamma1', 'gamma2', 'gamma3']
    >>> [found.name for found in columns(["t", "ax", "ay", "az", "gx", "gy", "gz"])]
    ['t', None, None, None, 'p', 'q', 'r']
    >>> [found.name for found in columns(["body.w_a[1]", "body.w_a[2]", "Gyroscope z (rad/s)"])]
    ['p', 'q', 'r']
    >>> [found.name for found in columns(["t", "x", "y", "z", "w"])]
    ['t', 'q1', 'q2', 'q3', 'q0']
    >>> [found.name for found in columns(["time_ms", "psi_deg"])]
    ['t', 'psi']
    """
    bare = {header for header in headers if header.lower() in _BARE_QUATERNION}
    if len(bare) == len(_BARE_QUATERNION):
        headers = [f"q{header}" if header in bare else header for header in headers]
    if "xyz_derivative[0]" in headers:  # else PX4's xyz may be accelerations as well
        headers = [re.sub(r"^xyz\[", "gyro[", header) for header in headers]
    alone = [_alone(header) for header in headers]
    parts = [column if isinstance(column, _Component) else None for column in alone]
    from_zero = {part[:2] for part in parts if part is not None and "0" in part.axis}

    def first(part: _Component) -> int:
        return 0 if part[:2] in from_zero else 1

    meant = [x if isinstance(x, NamedColumn) else _component(x, first(x)) for x in alone]
    names = {column.name for column in meant}
    gyro = _g_is_a_rate(parts, meant)
    for k, part in enumerate(parts):
        if part is None:
            continue
        if part.stem == "g" and (gyro or part.unit.kind == "rate"):
            meant[k] = _component(part._replace(kind="omega"), first(part))
        elif part.kind in ("matrix", "rodrigues", "vector"):
            whole = {*_COMPONENTS[part.kind]} <= names
            meant[k] = meant[k] if whole and not {*ATTITUDE} <= names else UNKNOWN
    return meant


def by_clock(
    headers: Sequence[str], named: Sequence[NamedColumn]
) -> tuple[list[NamedColumn], tuple[str, ...]]:
    """Columns whose ``timestamp`` of whole numbers counts what its neighbours tell, and that it
    does: nanoseconds in EuRoC's data sets, microseconds in PX4's logs.

    >>> named, told = by_clock(header := ["timestamp", "timestamp_sample", "q[0]"], columns(header))
    >>> named[0].factor, *told
    (Fraction(1, 1000000), "read as: timestamp in microseconds, as in PX4's logs")
    """
    clock = next(k for k, column in enumerate(named) if column.name == "t")
    there = {*headers}
    if headers[clock].lower() != "timestamp" or named[clock] != NamedColumn("t"):
        return [*named], ()
    if any("_RS_" in header for header in headers):
        factor, words = _NANO, "nanoseconds, as in EuRoC's data sets"
    elif there & _OF_PX4 or there >= _OF_EARLIER_PX4:
        factor, words = _MICRO, "microseconds, as in PX4's logs"
    else:
        return [*named], ()
    counted = [NamedColumn("t", factor) if k == clock else x for k, x in enumerate(named)]
    return counted, (f"read as: {headers[clock]} in {words}",)


def _g_is_a_rate(parts: Sequence[_Component | None], meant: Sequence[NamedColumn]) -> bool:
    """Whether ``gx gy gz`` are rates, where no others are there: beside accelerations or gamma."""
    others = {
        column.name
        for part, column in zip(parts, meant, strict=True)
        if not part or part.stem != "g"
    }
    accelerated = any(part is not None and part.kind == "acceleration" for part in parts)
    return (accelerated or bool({*STATE[3:]} & others)) and not {*STATE[:3]} & others


def _alone(header: str) -> NamedColumn | _Component:
    """What a header means by itself, or the component that it is."""
    if header in known() and header not in (*MATRIX, *RODRIGUES):  # of which all are needed
        return NamedColumn(header)
    if header == "%time":
        return NamedColumn("t", _TIMES["ns"])
    plain = _NOTHING.sub("", header.translate(_GREEK).strip())
    split = _UNIT.search(plain)
    for name, unit in ((plain, None), (plain[: split.start()] if split else "", split)):
        word = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name.strip()).lower()
        units = _unit(unit)
        column = "t" if name.strip() == "t" else _WORDS.get(word) or _WORDS.get(name.lower())
        if turn := _ROLL.match(word):
            column = column or STATE[("roll", "pitch", "yaw").index(turn[1])]
        if column is not None:
            return _in_unit(column, units)
        for kind, pattern in _NAMES.items():
            for text in dict.fromkeys((word, name.lower())):
                if part := pattern.match(text):
                    return _Component(kind, part[1], part[2], units)
    return UNKNOWN


def _unit(match: re.Match[str] | None) -> _Unit:
    """The unit at the end of a header."""
    if match is None or match[5]:
        return _Unit("")
    angle, per, rate, time = (x.lower() if x else "" for x in match.groups()[:4])
    if time:
        return _Unit("time", _TIMES.get(time, Fraction(1)))
    if rate:
        return _Unit("rate", _TURNS.get(rate, Fraction(360)) * degree())
    factor = Fraction(1, 1000 if angle.startswith("m") else 1)
    return _Unit("rate" if per else "angle", factor * degree() if "deg" in angle else factor)


def _in_unit(name: str, unit: _Unit) -> NamedColumn:
    """A column in a unit; unknown where it has no such unit."""
    kinds = ("time",) if name == "t" else ("angle", "rate") if name in STATE[:3] else ()
    kinds = ("angle",) if name in (*ANGLES, *ROTATION_VECTOR) else kinds
    if unit.kind and unit.kind not in kinds:
        return UNKNOWN
    return NamedColumn(name, unit.factor)


def _component(part: _Component, first: int) -> NamedColumn:
    """The column of a component whose axes are counted from ``first``."""
    names, axis = _COMPONENTS.get(part.kind, ()), part.axis
    if part.kind == "matrix":
        row, column = (_place(x, first) for x in (axis[0], axis[-1]))
        return _in_unit(names[3 * row + column], part.unit) if max(row, column) < 3 else UNKNOWN
    if part.kind == "quaternion":  # of 1 2 3 4 the last one mostly is the scalar
        place = "wxyz0123rijk4s".index(axis) % 4 if axis not in "4s" else 0
        return _in_unit(names[place], part.unit)
    place = _place(axis, 0 if part.stem == "qvel" else first)
    return _in_unit(names[place], part.unit) if place < len(names) else UNKNOWN


def _place(axis: str, first: int) -> int:
    """The place of an axis among three; 3 or more of another."""
    return "xyz".index(axis) if axis in "xyz" else (int(axis) - first) % 10


@dataclass(frozen=True)
class Naming:
    """Columns that were named beside a table.

    ``header``: all of them in order, empty where the table has its own.  ``meant``: what single
    names of its header mean.
    """

    header: tuple[str, ...] = ()
    meant: Mapping[str, NamedColumn] = field(default_factory=dict)

    def columns(self, header: Sequence[str]) -> list[NamedColumn]:
        """What the names of a header mean; a column that was told is no other one of the header."""
        names = {column.name for name, column in self.meant.items() if name in header}
        others = [UNKNOWN if column.name in names else column for column in columns(header)]
        return [self.meant.get(name, column) for name, column in zip(header, others, strict=True)]

    def refuse_absent(self, source: str, header: Sequence[str]) -> None:
        """Raise AbsentColumn for a name that is none of a header."""
        for name in self.meant:
            if name not in header:
                expected = f"a name of its header: {nearest(name, [*header])}"
                raise AbsentColumn(source, "--columns", name, expected)

    def stamp(self, header: Sequence[str]) -> tuple[int, int] | None:
        """The places of a time's whole seconds and of its nanoseconds, as ROS writes them, where no
        column has the time.

        >>> PLAIN.stamp(["seq", "header.stamp.sec", "header.stamp.nanosec", "qw"])
        (1, 2)
        """
        if any(column.name == "t" for column in self.columns(header)):
            return None
        parts = [_STAMP.match(name) for name in header]
        places = {(part[1], bool(part[2])): k for k, part in enumerate(parts) if part}
        whole = [
            (k, places[stem, True])
            for (stem, is_rest), k in places.items()
            if not is_rest and (stem, True) in places
        ]
        return whole[0] if len(whole) == 1 else None


PLAIN = Naming()  # nothing was named


def naming(text: str) -> Naming:
    """The columns of ``--columns``: ``t,qw,qx``, or ``time_ms=t*1e-3, Q.W=q0``; raises BadInput."""
    items = [item.strip() for item in text.split(",")]
    if not any("=" in item for item in items):
        return Naming(tuple(items))
    meant = {}
    for item in items:
        name, _, meaning = (part.strip() for part in item.partition("="))
        ours, _, by = (part.strip() for part in meaning.partition("*"))
        sign, ours = (-1, ours[1:].strip()) if ours.startswith("-") else (1, ours)
        if not name or ours not in readable():
            expected = f"NAME=COLUMN, of {nearest(ours, readable())}"
            raise BadInput("compare", "--columns", item, expected)
        try:
            factor = sign * (expression.decimal(by) if by else Fraction(1))
        except ExpressionError as fault:
            raise BadInput("compare", "--columns", item, f"NAME=COLUMN*NUMBER ({fault})") from None
        if name in meant:
            raise BadInput("compare", "--columns", item, f"each name once ({name!r} is there)")
        meant[name] = NamedColumn(ours, factor)
    return Naming((), meant)

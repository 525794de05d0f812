"""The words of scenes: columns, events, families, and the keys of their files."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias

from polhode.common.errors import BadInput
from polhode.numbers import expression
from polhode.numbers.conversion import to_mpf
from polhode.numbers.expression import Algebra

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint


# --- vocabulary -----------------------------------------------------------------------------------
#
# The words that a scene file may use, and the names of columns.


#: What ``reference.kind`` may ask for: the first that fits, a closed form by the name of its family
#: (polhode.closed_forms.families), or a proven enclosure.
REFERENCES = (
    *("auto", "euler", "lagrange", "pendulum", "staude", "bobylev-steklov", "kovalevskaya"),
    *("grioli", "goryachev-chaplygin", "hess", "steklov", "goryachev", "n-kowalewski"),
    *("chaplygin", "certified"),
)
#: What earlier versions took for ``reference.kind``, and what to write instead.
FORMER_REFERENCES = {"two-precisions": "auto, or certified for a proven enclosure"}


#: The forms of the equations (polhode.equations.forms), in the order of the source.
FORMS = (
    *("general", "inertia-axes", "principal", "momentum", "gyration-axes"),
    *("lagrangian", "hamiltonian", "routhian", "omega-only", "momentum-only", "quaternion"),
)


#: What a scene may ask for beyond its motion in the principal form; most doors need not know it.
REQUESTS = ("form", "outputs", "events")


STATE = ("p", "q", "r", "gamma1", "gamma2", "gamma3")


ANGLES = ("psi", "theta", "phi")


ATTITUDE = ("q0", "q1", "q2", "q3")


MATRIX = tuple(f"R{i}{j}" for i in "123" for j in "123")  # body to space, row by row


RODRIGUES = ("sigma1", "sigma2", "sigma3")  # modified: the axis times tan(angle / 4)


INTEGRALS = ("h", "f", "drift_h", "drift_f", "drift_gamma", "drift_fourth")


SPACE = ("omega_x", "omega_y", "omega_z")  # omega along the axes of space, z up


class ColumnWord(NamedTuple):
    """What a word of ``run.outputs`` adds to a trajectory.

    ``names``: of its columns, in CSV files and frames.  ``needs``: what it is made of: "state", or
    integrated words.  ``how``: integrated beside the state, or derived from what it needs, by the
    formula in polhode.equations.columns.  ``meaning``: for the guide.
    """

    names: tuple[str, ...]
    needs: tuple[str, ...]
    how: Literal["integrated", "derived"]
    meaning: str


#: The words of ``run.outputs``, in the order of a trajectory's columns.
COLUMNS: Mapping[str, ColumnWord] = {
    "angles": ColumnWord(
        ANGLES,
        ("state",),
        "integrated",
        "in radians, continuous in time; empty at a pole, where psi and phi have no meaning",
    ),
    "attitude": ColumnWord(
        ATTITUDE,
        ("state",),
        "integrated",
        "unit quaternion, body to space, scalar first; at the start the first component that is "
        "not 0 is positive, then continuous",
    ),
    "hodographs": ColumnWord(
        SPACE, ("state", "attitude"), "derived", "omega along the axes of space, z up"
    ),
    "matrix": ColumnWord(
        MATRIX, ("attitude",), "derived", "the rotation matrix, body to space, row by row"
    ),
    "mrp": ColumnWord(
        RODRIGUES,
        ("attitude",),
        "derived",
        "modified Rodrigues parameters, the axis times tan(angle/4), of the quaternion with its "
        "sign: continuous, empty where it is -1",
    ),
    "integrals": ColumnWord(
        INTEGRALS,
        ("state",),
        "derived",
        "energy and vertical momentum, and how far they, the length of gamma and a fourth integral "
        "are from the start's, relative; without a fourth integral the last one is empty",
    ),
}


def column_names() -> list[str]:
    """The names of all columns beside t and the state."""
    return [name for word in COLUMNS.values() for name in word.names]


ANGLE_VARIABLES = ("psi", "phi")  # of the angles, those that are integrated along


#: Events known by name: theta' = 0, the third axis horizontal, w along the middle principal axis
#: changing sign (no expression in scene axes), and a Poincaré section, followed by its expression.
FLIP, SECTION = "flip", "section:"


#: Sections that every orbit crosses, and which of their extrema are taken.
SECTIONS, EXTREMA = ("momentum", "height"), ("max", "min")


READY_MADE = {"nutation": "p*gamma2 - q*gamma1", "equator": "gamma3", FLIP: None}

#: In which direction an event's expression passes zero, as t grows, and the sign of its rate.
DIRECTIONS = {"rising": 1, "falling": -1, "any": 0}

#: What moments of inertia may be about.
FIXED_POINT, CENTRE = "fixed point", "centre"

#: Systems of units that a scene may say its numbers are in; "": any consistent one.
UNITS = ("", "SI")

#: Which of the two spins on a level of h and f.
SIGNS = ("+", "-")


#: Figures of several panels, and of one.
Several: TypeAlias = Literal["angles", "hodographs", "sphere", "integrals", "error"]
Single: TypeAlias = Literal["omega", "momentum", "attitude"]


# --- keys -----------------------------------------------------------------------------------------
#
# Every key of a scene file, as keys.md lists them: for the reader, its refusals, and the guide.


NUMBER, VECTOR, WORD, WORDS = "number", "three numbers", "text", "list of texts"
WHOLE, TRUTH, TABLE, TABLES = "whole number", "true or false", "table", "tables"

_INDEX = re.compile(r"\[[0-9]+\]")
_TOP = "the top level"


class Key(NamedTuple):
    """A key of a section: its kind, the unit of its numbers, an example and default, its meaning.

    Example and default are TOML.
    """

    name: str
    kind: str
    unit: str
    example: str
    default: str
    meaning: str


def _listed(words: re.Match[str]) -> str:
    """What a name in the table stands for."""
    from polhode.scenes.shapes import AXES, SHAPES  # which no list of cases needs

    namespace = globals() | {"SHAPES": SHAPES, "AXES": AXES}
    values = namespace[words[1]]
    return values if isinstance(values, str) else ", ".join(f"`{word}`" for word in values)


def _read() -> dict[str, tuple[Key, ...]]:
    """The sections by name, "" the file's top level."""
    text = Path(__file__).with_name("keys.md").read_text("utf-8")
    sections: dict[str, tuple[Key, ...]] = {}
    for section in text.split("\n## ")[1:]:
        name, *lines = re.sub("<([A-Z_]+)>", _listed, section).splitlines()
        rows = [line for line in lines if line.startswith("| ")][1:]  # below the heads
        cells = ([cell.strip() for cell in row[1:-1].split("|")] for row in rows)
        sections["" if name == _TOP else name] = tuple(Key(*row) for row in cells)
    return sections


KEYS = _read()

#: Keys of a start by which others may mean what ours have other names for.
OF_OTHERS = {
    "p_psi": "f, the momentum about the vertical, or p_phi, which is Goldstein's p_psi",
    "p_theta": "momentum, or h with f and p_phi",
    "E": "h, the energy",
}

_OF_TABLES = ("body.parts", "events", "published")
HEADS = {x: f"[[{x}]]" if x in _OF_TABLES else f"[{x}]" for x in KEYS} | {"": _TOP}

#: The same keys, of each section by name.
BY_NAME = {section: {key.name: key for key in keys} for section, keys in KEYS.items()}


def unit(full: str) -> str:
    """The unit of a key's numbers; ``full``: the key as ``body.parts[1].size``; "" for none."""
    section, _, name = _INDEX.sub("", full).rpartition(".")
    key = BY_NAME.get(section, {}).get(name)
    return "" if key is None else key.unit


@cache
def default(section: str, name: str) -> Any:
    """What leaving out a key means; None where it has no default."""
    text = BY_NAME[section][name].default
    return tomllib.loads(f"x = {text}")["x"] if text else None


# --- column expressions ---------------------------------------------------------------------------
#
# Expressions in the columns of a state: events and published figures.


def check(text: str, names: tuple[str, ...]) -> None:
    """Raise ExpressionError unless ``text`` reads as an expression in these names."""
    functions = dict.fromkeys(expression.FUNCTIONS, lambda _: math.nan)
    expression.evaluate(
        text, dict.fromkeys(names, math.nan), Algebra(lambda _: math.nan, functions)
    )


def value(text: str, columns: Mapping[str, Any], bits: int) -> Any:
    """The value of an expression at one instant, its columns given as mpf, to so many bits."""
    from polhode.numbers.mpmath_context import mpmath, own

    functions = {"sqrt": mpmath.sqrt, "sin": mpmath.sin, "cos": mpmath.cos}
    numbers = {name: own(x) for name, x in columns.items()}
    with mpmath.workprec(bits):
        result = expression.evaluate(
            text, numbers, Algebra(lambda x: to_mpf(x, bits + 8), functions)
        )
        return result if isinstance(result, mpmath.mpf) else to_mpf(result, bits)


# --- added families -------------------------------------------------------------------------------
#
# Families of closed forms from outside polhode, by name: of this process, or of a package.
#
# A package names them in the group ``polhode.families`` of its entry points, which every process
# finds; ``polhode.register_family`` adds one to this process alone. What a family is, only
# :mod:`polhode.closed_forms.families` knows.


GROUP = "polhode.families"
_OF_PROCESS: dict[str, object] = {}


def add(name: str, family: object) -> None:
    """Add one to this process; raises BadInput where the name is taken."""
    if name in (*REFERENCES, *_installed()) or _OF_PROCESS.get(name, family) is not family:
        raise BadInput("register_family", "name", name, "one that no family has")
    _OF_PROCESS[name] = family


def added_names() -> tuple[str, ...]:
    """Of all that were added."""
    return (*_OF_PROCESS, *_installed())


def added() -> list[object]:
    """The families; raises BadInput where a package's cannot be imported."""
    words_added = [*_OF_PROCESS.values()]
    for point in _installed().values():
        try:
            words_added.append(point.load())
        except Exception as fault:  # whatever a package's own code raises
            expected = f"a family to import ({type(fault).__name__}: {fault})"
            raise BadInput(GROUP, point.name, point.value, expected) from fault
    return words_added


@cache
def _installed() -> dict[str, EntryPoint]:
    """The entry points; of a name that polhode has its own is meant."""
    from importlib.metadata import entry_points  # which takes a seventh of the time of polhode list

    return {p.name: p for p in entry_points(group=GROUP) if p.name not in REFERENCES}

"""Every key of a scene file, once: what the reader knows, refuses, and the guide prints.

A key's ``default`` is the text that a file may give it and that means the same as leaving it out;
empty where the key must be given, or where leaving it out has a meaning of its own, which
``meaning`` then says.  A key's ``example`` is what may stand behind ``key =``.  A key's ``unit``
is what its numbers are multiples of where they are written with units
(:mod:`polhode.numbers.quantity`); empty where they have none.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from functools import cache
from typing import Any, NamedTuple

from polhode.numbers.number_types import NAMES
from polhode.scenes.shapes import AXES, SHAPES
from polhode.scenes.vocabulary import (
    CENTRE,
    COLUMNS,
    DIRECTIONS,
    EXTREMA,
    FIXED_POINT,
    FORMS,
    READY_MADE,
    REFERENCES,
    SECTION,
    SECTIONS,
    SIGNS,
)

NUMBER, VECTOR, WORD, WORDS = "number", "three numbers", "text", "list of texts"
WHOLE, TRUTH, TABLE, TABLES = "whole number", "true or false", "table", "tables"

_INDEX = re.compile(r"\[[0-9]+\]")


class Key(NamedTuple):
    """A key of a section: its kind, meaning, default and an example, as TOML text; its unit."""

    name: str
    kind: str
    meaning: str
    example: str = ""
    default: str = ""
    unit: str = ""


def _listed(words: Any) -> str:
    return ", ".join(f"`{word}`" for word in words)


#: The sections by name, "" the file's top level; of [[events]] and [[published]] one of them each.
KEYS: dict[str, tuple[Key, ...]] = {
    "": (
        Key("schema", WHOLE, "version of the format: 1", "1"),
        Key("title", WORD, "name in lists and figures", '"My top"', '""'),
        Key("tags", WORDS, "for `polhode list --tag`", '["fast"]', "[]"),
        Key("cite", WORDS, "where the scene comes from", '["Euler 1758"]', "[]"),
        Key(
            "units",
            WORD,
            "`SI`: numbers without a unit are in m, kg, s and rad; implied where any number has a "
            "unit, as `5 cm`, an angle's aside; left out otherwise: any consistent units",
            '"SI"',
            '""',
        ),
        Key("body", TABLE, "the body"),
        Key("start", TABLE, "its state at t = 0"),
        Key("run", TABLE, "what is asked for", default="{}"),
        Key("events", TABLES, "zeros to find along the motion", default="[]"),
        Key("published", TABLES, "published values", default="[]"),
        Key("reference", TABLE, "what a run is judged against", default="{}"),
        Key("section", TABLE, "the section of its level, for `polhode section`", default="{}"),
        Key("expect", TABLE, "least and most correct digits by number type", default="{}"),
    ),
    "body": (
        Key("moments", VECTOR, "principal moments of inertia A, B, C", "[2, 2, 1]", unit="kg*m**2"),
        Key(
            "inertia",
            "3 x 3 matrix",
            "or the inertia matrix in any body axes; off its diagonal stand minus the products of "
            "inertia, Ixy = -∫ x y dm, as in URDF",
            '[[2, "1/2", 0], ["1/2", 2, 0], [0, 0, 3]]',
            unit="kg*m**2",
        ),
        Key("parts", TABLES, "or the solids that the body is made of: `[[body.parts]]`"),
        Key(
            "about",
            WORD,
            "the point that moments or inertia are about: `fixed point`, or `centre`, the centre "
            "of mass, from which Huygens and Steiner's theorem carries them, with `mass`",
            f'"{CENTRE}"',
            f'"{FIXED_POINT}"',
        ),
        Key(
            "centre",
            VECTOR,
            "centre of mass from the fixed point; required if there is a weight",
            "[0, 0, 1]",
            unit="m",
        ),
        Key("weight", NUMBER, "Mg; 0: no torque; negative: hanging", "1", "0", unit="N"),
        Key("mass", NUMBER, "mass, with `g` instead of a weight", "0.25", unit="kg"),
        Key(
            "g", NUMBER, "acceleration of gravity, with `mass` or `parts`", "9.80665", unit="m/s**2"
        ),
    ),
    "body.parts": (
        Key("shape", WORD, f"one of {_listed(SHAPES)}, homogeneous", '"cone"'),
        Key("mass", NUMBER, "its mass", "0.1", unit="kg"),
        Key("size", VECTOR, "edges of a box along the body's axes", "[3, 2, 1]", unit="m"),
        Key("semi_axes", VECTOR, "of an ellipsoid, along the body's axes", "[3, 2, 1]", unit="m"),
        Key("radius", NUMBER, "of a cylinder, disc, cone or sphere", "0.03", unit="m"),
        Key("height", NUMBER, "of a cylinder, cone or rod, along its axis", "0.05", unit="m"),
        Key(
            "inner",
            NUMBER,
            "inner radius of a hollow cylinder, disc or sphere",
            "0.02",
            "0",
            unit="m",
        ),
        Key(
            "at",
            VECTOR,
            "its centre, of a cone its tip, from the fixed point",
            "[0, 0, 1]",
            "[0, 0, 0]",
            unit="m",
        ),
        Key(
            "axis",
            WORD,
            f"axis of a round part, one of {_listed(AXES)}; a cone opens along it",
            '"x"',
            '"z"',
        ),
    ),
    "start": (
        Key(
            "omega",
            VECTOR,
            "angular velocity p, q, r in body axes",
            '["0.3", 0.2, 1.1]',
            unit="rad/s",
        ),
        Key(
            "momentum",
            VECTOR,
            "or angular momentum P, Q, R in body axes",
            "[2, 9, 1]",
            unit="kg*m**2/s",
        ),
        Key(
            "gamma",
            VECTOR,
            "upward vertical in body axes, of length 1; a torque-free scene may leave out the "
            "orientation",
            '["3/5", 0, "4/5"]',
        ),
        Key(
            "h",
            NUMBER,
            "or the energy h, with `f`: omega is on that level, in the given orientation",
            '"9/4"',
            unit="J",
        ),
        Key("f", NUMBER, "area integral I w . gamma, with `h`", "1", unit="kg*m**2/s"),
        Key(
            "sign",
            WORD,
            f"which of the two omegas on the level, one of {_listed(SIGNS)}",
            f'"{SIGNS[1]}"',
            f'"{SIGNS[0]}"',
        ),
        Key("psi", NUMBER, "precession angle, with gamma", '"pi/3"', "0", unit="rad"),
        Key(
            "angles",
            VECTOR,
            "or psi, theta, phi: R = Rz(psi) Rx(theta) Rz(phi), body to space",
            '[0, "pi/6", 0]',
            unit="rad",
        ),
        Key(
            "rates",
            VECTOR,
            "or the rates psi', theta', phi', with `angles`",
            "[0, 0, 30]",
            unit="rad/s",
        ),
        Key(
            "quaternion",
            "four numbers",
            "or the quaternion of R, scalar first, of length 1",
            "[1, 0, 0, 0]",
        ),
        Key(
            "normalise",
            TRUTH,
            "bring gamma or the quaternion to length 1",
            "true",
            "false",
        ),
    ),
    "run": (
        Key("end", NUMBER, "last time; may be negative", "200", unit="s"),
        Key(
            "samples",
            WHOLE,
            "number of evenly spaced times from 0 to end, both included",
            "401",
            "2",
        ),
        Key(
            "at",
            "list of numbers",
            "or the times themselves, in order away from 0",
            "[1, 10]",
            unit="s",
        ),
        Key("form", WORD, f"form of the equations: {_listed(FORMS)}", '"principal"', '"principal"'),
        Key("outputs", WORDS, f"besides omega and gamma: {_listed(COLUMNS)}", '["angles"]', "[]"),
    ),
    "events": (
        Key(
            "name",
            WORD,
            f"any name; {_listed(READY_MADE)} and `{SECTION}…` need no `zero`",
            '"level"',
        ),
        Key(
            "zero",
            WORD,
            "the expression whose zeros are found, in p q r gamma1 gamma2 gamma3 t",
            '"gamma3 - 1/2"',
        ),
        Key("direction", WORD, f"one of {_listed(DIRECTIONS)}, as t grows", '"rising"', '"any"'),
        Key("stop", TRUTH, "whether the run ends at the first one", "true", "false"),
    ),
    "published": (
        Key("t", NUMBER, "time", "30", unit="s"),
        Key("quantity", WORD, "an expression in the columns", '"180/pi*p"'),
        Key("value", WORD, "the value, digit for digit as printed", '"12.6183907758"'),
        Key("cite", WORD, "who printed it", '"NASA/TM-2015-218675"'),
        Key("right", WHOLE, "the fewest digits that are right, if not all are", "7"),
    ),
    "reference": (Key("kind", WORD, f"one of {_listed(REFERENCES)}", '"euler"', '"auto"'),),
    "section": (
        Key(
            "by",
            WORD,
            f"{_listed(SECTIONS)}, or an expression that vanishes",
            '"height"',
            '"momentum"',
        ),
        Key("extremum", WORD, f"for the first two, one of {_listed(EXTREMA)}", '"min"', '"max"'),
        Key("crossings", WHOLE, "number of crossings of each orbit", "100", "500"),
        Key("starts", "rows of numbers", "starts in the section's coordinates", "[[1, 0.5]]", "[]"),
    ),
    "expect": tuple(
        Key(name, "two numbers", f"band of correct digits in {name}", "[11.0, 14.5]")
        for name in NAMES
    ),
}


_OF_TABLES = ("body.parts", "events", "published")
_HEADS = {x: f"[[{x}]]" if x in _OF_TABLES else f"[{x}]" for x in KEYS} | {"": "the top level"}


def names(section: str) -> list[str]:
    """The keys that a section may have."""
    return [key.name for key in KEYS[section]]


def homes(name: str) -> str:
    """The sections that have a key of this name, as they are written; "" for none."""
    return " or ".join(_HEADS[section] for section in KEYS if name in names(section))


def words(section: str) -> set[str]:
    """The keys of a section that hold no number, and so cannot be varied."""
    return {key.name for key in KEYS[section] if key.kind in (WORD, WORDS, TRUTH, WHOLE)}


def unit(key: str) -> str:
    """The unit of a key's numbers; ``key`` in full, as ``body.parts[1].size``; "" for none."""
    section, _, name = _INDEX.sub("", key).rpartition(".")
    return next((x.unit for x in KEYS.get(section, ()) if x.name == name), "")


def given(section: str, table: Mapping[str, Any], name: str) -> Any:
    """What a table holds under a key, or the key's default."""
    return table[name] if name in table else _default(section, name)


@cache
def _default(section: str, name: str) -> Any:
    (key,) = (key for key in KEYS[section] if key.name == name)
    return tomllib.loads(f"x = {key.default}")["x"]

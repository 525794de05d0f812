"""Texts of new scene files, with a comment on every key: from a case, or from a shape."""

from __future__ import annotations

import json
import re
import textwrap
from collections.abc import Sequence
from typing import NamedTuple

from polhode.common.errors import BadInput
from polhode.scenes import scene_file, vocabulary

_HEADER = re.compile(r"\[{1,2}([\w.]+)\]{1,2}\s*$")
_KEY = re.compile(r"([\w.]+)\s*=")
_WIDTH = 96


class Shape(NamedTuple):
    """A body of one solid on its tip or stem: what is asked of it, and its parts as TOML."""

    meaning: str
    numbers: tuple[str, ...]
    parts: str


#: The bodies that a new scene may have, by name; their numbers in this order.
SHAPES = {
    "cone": Shape(
        "a solid cone on its tip",
        ("radius", "height", "mass"),
        'shape  = "cone"\nradius = {0}\nheight = {1}\nmass   = {2}',
    ),
    "disc": Shape(
        "a thin disc on a stem without mass",
        ("radius", "stem", "mass"),
        'shape  = "disc"\nradius = {0}\nat     = [0, 0, {1}]\nmass   = {2}',
    ),
    "sphere": Shape(
        "a solid sphere on a stem without mass",
        ("radius", "stem", "mass"),
        'shape  = "sphere"\nradius = {0}\nat     = [0, 0, {1}]\nmass   = {2}',
    ),
}

_TOP = """\
schema = 1
title = {title}

[body]
g = "9.80665 m/s**2"

[[body.parts]]
{parts}

[start]
angles = [0, {tilt}, 0]
rates  = [0, 0, {spin}]

[run]
end     = {end}
samples = 201
outputs = ["angles"]
"""


def of_shape(
    shape_name: str, numbers: Sequence[str], tilt: str, spin: str, end: str, name: str
) -> str:
    """The commented text of a scene of a spinning solid; numbers as texts, with units or without.

    ``name``: of the scene, for faults.  Raises BadInput.
    """
    shape = SHAPES[shape_name]
    if len(numbers) != len(shape.numbers):
        raise BadInput("new", f"--{shape_name}", ",".join(numbers), ",".join(shape.numbers).upper())
    title = f"{shape.meaning[0].upper()}{shape.meaning[1:]}"
    parts = shape.parts.format(*map(_quoted, numbers))
    texts = {"tilt": _quoted(tilt), "spin": _quoted(spin), "end": _quoted(end)}
    return commented(_TOP.format(title=json.dumps(title), parts=parts, **texts), name)


def commented(text: str, name: str = "scene") -> str:
    """A scene file's text with a comment before every key that it gives.

    What stands in the text stays as it is.  Raises BadInput for a text that is no scene.
    """
    scene_file.parse(text, name)
    lines: list[str] = []
    section, open_brackets = "", 0
    for line in text.splitlines():
        header, key = _HEADER.match(line), _KEY.match(line)
        if header and not open_brackets:
            section = header[1]
        elif key and not open_brackets:
            lines += _comment(section, key[1])
        bare = re.sub(r'"[^"]*"|#.*', "", line)
        open_brackets += bare.count("[") - bare.count("]") if key or open_brackets else 0
        lines.append(line)
    return "\n".join(lines) + "\n"


def _comment(section: str, name: str) -> list[str]:
    place, _, last = f"{section}.{name}".strip(".").rpartition(".")
    for key in vocabulary.KEYS.get(place, ()):
        if key.name == last and key.meaning:
            meaning = key.meaning.replace("`", "").removeprefix("or ")
            return [f"# {line}" for line in textwrap.wrap(f"{last}: {meaning}", _WIDTH - 2)]
    return []


def _quoted(text: str) -> str:
    """A number as TOML: a decimal as it is, an expression or a number with its unit as text."""
    plain = text.strip()
    decimal = re.fullmatch(r"[-+]?(0|[1-9][0-9]*)(\.[0-9]+)?([eE][-+]?[0-9]+)?", plain)
    return plain if decimal else json.dumps(plain)

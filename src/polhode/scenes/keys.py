"""Every key of a scene file, as keys.md lists them: for the reader, its refusals, and the guide."""

from __future__ import annotations

import re
import tomllib
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from polhode.scenes import vocabulary
from polhode.scenes.shapes import AXES, SHAPES

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
    known = vars(vocabulary) | {"SHAPES": SHAPES, "AXES": AXES}
    found = known[words[1]]
    return found if isinstance(found, str) else ", ".join(f"`{word}`" for word in found)


def _read() -> dict[str, tuple[Key, ...]]:
    """The sections by name, "" the file's top level."""
    text = Path(__file__).with_suffix(".md").read_text("utf-8")
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
_HEADS = {x: f"[[{x}]]" if x in _OF_TABLES else f"[{x}]" for x in KEYS} | {"": _TOP}


def names(section: str) -> list[str]:
    """The keys that a section may have."""
    return [key.name for key in KEYS[section]]


def ours(section: str, name: str) -> str:
    """What a section calls a key of that name in other books; "" for nothing."""
    return OF_OTHERS.get(name, "") if section == "start" else ""


def homes(name: str) -> str:
    """The sections that have a key of this name, as they are written; "" for none."""
    return " or ".join(_HEADS[section] for section in KEYS if name in names(section))


def words(section: str) -> set[str]:
    """The keys of a section that hold no number, and so cannot be varied."""
    return {key.name for key in KEYS[section] if key.kind in (WORD, WORDS, TRUTH, WHOLE)}


def unit(full: str) -> str:
    """The unit of a key's numbers; ``full``: the key as ``body.parts[1].size``; "" for none."""
    section, _, name = _INDEX.sub("", full).rpartition(".")
    return key(section, name).unit if section in KEYS and name in names(section) else ""


@cache
def key(section: str, name: str) -> Key:
    """A key by its name."""
    return next(x for x in KEYS[section] if x.name == name)


@cache
def default(section: str, name: str) -> Any:
    """What leaving out a key means; None where it has no default."""
    return tomllib.loads(f"x = {text}")["x"] if (text := key(section, name).default) else None

"""Families of closed forms from outside polhode, by name: of this process, or of a package.

A package names them in the group ``polhode.families`` of its entry points, which every process
finds; ``polhode.register_family`` adds one to this process alone.  What a family is, only
:mod:`polhode.closed_forms.families` knows.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

from polhode.common.errors import BadInput
from polhode.scenes.vocabulary import REFERENCES

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

GROUP = "polhode.families"
_OF_PROCESS: dict[str, object] = {}


def add(name: str, family: object) -> None:
    """Add one to this process; raises BadInput where the name is taken."""
    if name in (*REFERENCES, *_installed()) or _OF_PROCESS.get(name, family) is not family:
        raise BadInput("register_family", "name", name, "one that no family has")
    _OF_PROCESS[name] = family


def names() -> tuple[str, ...]:
    """Of all that were added."""
    return (*_OF_PROCESS, *_installed())


def added() -> list[object]:
    """The families; raises BadInput where a package's cannot be imported."""
    found = [*_OF_PROCESS.values()]
    for point in _installed().values():
        try:
            found.append(point.load())
        except Exception as fault:  # whatever a package's own code raises
            expected = f"a family to import ({type(fault).__name__}: {fault})"
            raise BadInput(GROUP, point.name, point.value, expected) from fault
    return found


@cache
def _installed() -> dict[str, EntryPoint]:
    """The entry points; of a name that polhode has its own is meant."""
    from importlib.metadata import entry_points  # which takes a seventh of the time of polhode list

    return {p.name: p for p in entry_points(group=GROUP) if p.name not in REFERENCES}

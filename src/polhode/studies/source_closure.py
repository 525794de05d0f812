"""The files of polhode that a file imports, and those that these import: all that it rests on.

Imports are read from the text, those inside functions too, and those by name: a string that is the
name of a module, or begins with that of a package, counts as importing it, or all of the package.
Imports for a type checker alone do not count.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from functools import cache
from itertools import pairwise
from pathlib import Path

TOP = Path(__file__).parents[1]
_NAME = re.compile(r"polhode((?:\.\w+)+\.?)")

#: Files whose own imports are not followed, and what is followed in their place.
INSTEAD: dict[str, tuple[str, ...]] = {
    # the front door loads any room that a user names; rooms import each other by their own names
    "__init__": ("common/presentation",),
    # runs studies one by one and makes pages of their results: no row rests on it
    "studies/report": (),
}
#: What a file imports beside that in a way that its text does not tell.
BESIDE: dict[str, tuple[str, ...]] = {
    # asks by a slot of common/presentation, which output/presentation fills with this
    "runs/trajectory": ("runs/reevaluate",),
    # modules that its rows name, in strings of their own
    "studies/speed/programs": (),
    # the module that a job names: one of the programs
    "studies/speed/first_result": ("studies/speed/programs",),
    # classes of results, from a table of their places
    "output/results/kinds": (
        *("dynamics", "enclosures", "judging", "motion", "numbers", "proofs", "runs", "scenes"),
    ),
    # packages of others
    "output/frames": (),
}
#: Files that are read as data, by the file that reads them; cases have a place of their own.
DATA = {
    "figures/motion_page": "figures/page",
    "output/guide": "guide",
    "benchmark/folder": "benchmark/checkers",
}


def closure(names: Iterable[str]) -> tuple[str, ...]:
    """The files, all that they import, and so on, and the packages that these lie in; sorted.

    A file is named by its path below polhode, without its suffix.
    """
    found: set[str] = set()
    waiting = [*names]
    while waiting:
        name = waiting.pop()
        if name in found:
            continue
        found.add(name)
        waiting += INSTEAD[name] if name in INSTEAD else imported(name)
        waiting += (x for part in BESIDE.get(name, ()) for x in _files(part))
        waiting += (f"{folder.as_posix()}/__init__" for folder in [*Path(name).parents][:-1])
        waiting.append("__init__")
    return tuple(sorted(found))


def sources(names: Iterable[str]) -> Iterator[Path]:
    """The files of a closure as paths, and those that they read as data."""
    for name in closure(names):
        yield TOP / f"{name}.py"
        if name in DATA:
            yield from sorted(path for path in (TOP / DATA[name]).rglob("*") if path.is_file())


@cache
def imported(name: str) -> frozenset[str]:
    """The files of polhode that a file imports."""
    found: set[str] = set()
    for node in _nodes(name):
        if isinstance(node, ast.Import):
            found.update(file for alias in node.names for file in _named(alias.name))
        elif isinstance(node, ast.ImportFrom):
            for alias in node.names:
                found.update(_named(f"{node.module}.{alias.name}") or _named(f"{node.module}"))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            found.update(_named(node.value, whole=True))
        elif isinstance(node, ast.List | ast.Tuple):
            words = [x.value for x in node.elts if isinstance(x, ast.Constant)]
            if ("-m", "polhode") in pairwise(words):
                found.add("__main__")
    return frozenset(found)


def unread(name: str) -> list[str]:
    """Calls of ``import_module`` in a file whose argument's text does not tell what is meant."""
    calls = [node for node in _nodes(name) if isinstance(node, ast.Call) and node.args]
    ways = ("import_module", "__import__")
    asked = [call.args[0] for call in calls if ast.unparse(call.func).endswith(ways)]
    return [ast.unparse(x) for x in asked if not any(map(_names_a_module, ast.walk(x)))]


def _names_a_module(node: ast.AST) -> bool:
    if not isinstance(node, ast.Constant):
        return False
    return node.value == "polhode" or bool(_named(str(node.value), whole=True))


def _nodes(name: str) -> Iterator[ast.AST]:
    """All nodes of a file's tree, but for what only a type checker reads."""
    waiting: list[ast.AST] = [ast.parse((TOP / f"{name}.py").read_text(encoding="utf-8"))]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING"):
            waiting += node.orelse
            continue
        waiting += ast.iter_child_nodes(node)
        yield node


def _named(module: str, whole: bool = False) -> tuple[str, ...]:
    """The file of a module by its dotted name; of a package its first file, or all (``whole``)."""
    if module == "polhode":
        return () if whole else ("__init__",)
    match = _NAME.fullmatch(module)
    if match is None:
        return ()
    place = match[1].strip(".").replace(".", "/")
    if whole:
        return _files(place)
    if (TOP / f"{place}.py").is_file():
        return (place,)
    return (f"{place}/__init__",) if (TOP / place / "__init__.py").is_file() else ()


def _files(place: str) -> tuple[str, ...]:
    """A file, or all files of a package and of those in it; none where there is no such place."""
    if (TOP / f"{place}.py").is_file():
        return (place,)
    below = sorted((TOP / place).rglob("*.py"))
    return tuple(path.relative_to(TOP).with_suffix("").as_posix() for path in below)

"""Who is named in the code as a source stands in the guide's bibliography, and the other way."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import polhode

SOURCE = Path(polhode.__file__).parent
ROOMS = ("closed_forms", "certificates", "proofs", "enclosures", "dynamics")
#: A year as it ends a citation: "Hess, Math. Ann. 37 (1890) 153", "(Kowalevski 1889, section 4)".
YEAR = re.compile(r"\b(18[5-9]\d|19\d\d|20[0-2]\d)\b(?=[);,]|: | for | has | reduced)")
BEFORE = 240  # characters in which the name stands
BOOKS = re.compile(r"\b(DLMF|Mumford|Whittaker|Yehia|Golubev|Goldstein|Cohen|Klein|Landau)\b")


def words_of(path: Path) -> str:
    """Docstrings and comments, each in one line."""
    text = path.read_text(encoding="utf-8")
    parts = [
        ast.get_docstring(node) or ""
        for node in ast.walk(ast.parse(text))
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef))
    ]
    comments = (line.partition("#")[2] for line in text.split("\n"))
    parts.append(" ".join(comment.lstrip(": ") for comment in comments))
    lines = (line for part in parts for line in part.split("\n") if ">>>" not in line)
    return " ".join(" ".join(lines).split())


def keys() -> set[str]:
    page = (SOURCE / "guide" / "bibliography.md").read_text(encoding="utf-8")
    return {*re.findall(r"^\| ([A-Z][\w ]+?) \|", page, re.M)}


def test_every_source_has_its_key_and_every_key_is_used():
    listed = keys()
    assert len(listed) > 30
    used = set()
    for room in ROOMS:
        for path in (SOURCE / room).rglob("*.py"):
            text = words_of(path)
            for year in YEAR.finditer(text):
                near = text[max(0, year.start() - BEFORE) : year.end()]
                cited = {key for key in listed if all(word in near for word in key.split())}
                assert any(year[0] in key for key in cited), (path.name, near)
                used |= cited
            books = {*BOOKS.findall(text)}
            cited = {key for key in listed if books & {*key.split()}}
            assert len(cited) >= len(books), (path.name, books)
            used |= cited
    assert used == listed, listed - used

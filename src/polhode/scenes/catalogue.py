"""What ``polhode list`` shows of the cases that ship, found once and kept beside their files.

Regime and reference of a case follow from its file alone, but finding them takes some milliseconds
of exact arithmetic each.  ``cases/catalogue.json`` holds them by the fingerprint of the file, so
that an entry is never that of another text; ``tests/measure/catalogue.py`` writes it.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import NamedTuple

from polhode.common.provenance import digest
from polhode.scenes import library

FILE = "catalogue.json"


class Entry(NamedTuple):
    """A case as it is listed."""

    title: str
    tags: tuple[str, ...]
    regime: str
    reference: str


def known() -> Mapping[str, Entry]:
    """The entries of the cases whose files are as they were when the catalogue was made."""
    top, found = library.folder(), {}
    try:
        held = json.loads((top / FILE).read_bytes())
        for name, (fingerprint, title, tags, regime, reference) in held.items():
            path = top / f"{name}.toml"
            if path.is_file() and digest(path.read_text("utf-8")) == fingerprint:
                found[name] = Entry(title, tuple(tags), regime, reference)
    except (AttributeError, OSError, TypeError, ValueError):
        return {}  # gone or broken: then every case is read
    return found


def written(entries: Mapping[str, Entry]) -> str:
    """The text of the catalogue's file."""
    top, rows = library.folder(), {}
    for name, entry in sorted(entries.items()):
        rows[name] = [digest((top / f"{name}.toml").read_text("utf-8")), *entry]
    lines = [f"{json.dumps(name)}: {json.dumps(row)}" for name, row in rows.items()]
    return "{\n" + ",\n".join(lines) + "\n}\n"

"""Whether a result may take the place of a file: one rule for ``.save`` and ``-o``."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from polhode.common.errors import BadInput
from polhode.common.files import check_writable, is_stream
from polhode.results.frames import needed
from polhode.results.reader import kind_at
from polhode.results.writer import ENDINGS, beside


def check_place(path: Path, kind: str, inputs: Iterable[Path | None] = ()) -> None:
    """Refuse a path that a result of this kind cannot be written to, or must not; raises BadInput.

    A file is replaced where it is empty, or of the same kind of result as polhode wrote it.
    ``inputs``: files that are read.
    """
    places = [path, beside(path)] if path.suffix.lower() == ".csv" else [path]
    for place in places:
        check_writable(place, ENDINGS, inputs)
    refuse_facts(path)
    if path.suffix.lower() == ".parquet":
        needed("pyarrow", str(path))
    if is_stream(path):
        return
    for place in places:
        if place.exists() and place.stat().st_size:
            _check_kind(path, place, kind)


def refuse_facts(path: Path) -> None:
    """Raise BadInput for the name of the facts of a CSV file, which are written with its table."""
    table = path.with_suffix("")
    if table.suffix.lower() == ".csv" and path.name == beside(table).name:
        expected = f"another name: this is of the facts of {table.name}"
        raise BadInput(str(path), "file", None, expected)


def _check_kind(path: Path, place: Path, kind: str) -> None:
    try:
        there = kind_at(path)
    except ValueError as fault:
        raise BadInput(str(place), "file", None, f"another name: {fault}") from None
    if there != kind:
        raise BadInput(str(place), "file", None, f"another name: it holds a result {there}")

"""Trajectory files that are drawn: which names are files, and how they are read."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from polhode.common.errors import BadInput
from polhode.scenes import library

if TYPE_CHECKING:
    from polhode.judging.tables.table import Table
    from polhode.numbers.number_types import NumberType
    from polhode.scenes.scene import Scene


def options(parser: ArgumentParser) -> None:
    """The options by which a file is read, as ``compare`` has them."""
    parser.add_argument(
        "--read",
        metavar="WORDS",
        help="for a FILE: the conventions to read it in, as for compare: 'degrees, scalar-last'",
    )
    parser.add_argument(
        "--columns",
        metavar="NAMES",
        help="for a FILE: its columns in order, t,qw,qx,...; or some: 'time_ms=t*1e-3, Q.W=q0'",
    )


def is_file(name: str) -> bool:
    """Whether a trajectory file is meant: by its ending, or an existing path that is no scene."""
    from polhode.judging.tables.array_file import ENDINGS

    suffix = Path(name).suffix.lower()
    return suffix in (".csv", *ENDINGS) or (
        suffix != ".toml" and not library.ships(name) and Path(name).is_file()
    )


def refuse_for_scene(options: Namespace, name: str) -> None:
    """Raise BadInput for an option that is for a file."""
    for key in ("scene", "read", "columns"):
        if (value := getattr(options, key)) is not None:
            raise BadInput(name, f"--{key}", value, f"no --{key}: it is for a FILE")


def table(options: Namespace, scene: Scene | None, number: NumberType | None) -> Table:
    """The table of a file, in the conventions that were told."""
    from polhode.judging.diagnosis.told_conventions import table_as_told
    from polhode.judging.references.reference import reference
    from polhode.judging.tables.array_file import ENDINGS, read_arrays
    from polhode.judging.tables.csv_file import read_table
    from polhode.judging.tables.csv_layout import naming

    path = Path(options.what_of)
    names = None if options.columns is None else naming(options.columns)
    read = read_arrays if path.suffix.lower() in ENDINGS else read_table
    found = read(path, number, names)
    if options.read is None:
        return found
    if scene is None:
        raise BadInput(str(path), "--read", options.read, "a --scene whose conventions are meant")
    return table_as_told(found, reference(scene), options.read)

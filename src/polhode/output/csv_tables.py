"""A trajectory as a table in a CSV file, with what is not in it as JSON beside; a contract, too."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from pathlib import Path

from polhode.common.files import check_writable, is_stream, write_whole
from polhode.common.json_text import JsonObject, as_json
from polhode.numbers.decimals import shortest
from polhode.numbers.number_types import NumberType
from polhode.output.json_results import rows_of_column
from polhode.scenes.vocabulary import COLUMNS


def sidecar(path: Path) -> Path:
    """The JSON file beside a trajectory's CSV."""
    return path.with_suffix(".json")


def check_paths(path: Path, inputs: Sequence[Path | None] = ()) -> None:
    """Refuse a table's path that cannot be written, before any work; ``inputs``: files read."""
    check_writable(path, [".csv"], inputs)
    if not is_stream(path):
        check_writable(sidecar(path), [".json"], inputs)


def write_trajectory(path: Path, answer: JsonObject) -> None:
    """A trajectory as CSV, number type, bits, scene and provenance in a JSON file beside it.

    There ``t_bits`` tells to how many bits the decimals of t are to be rounded, which are as short
    as that allows.  A stream has no file beside it: its times have every digit.
    """
    header, rows = rows_of(answer, short=not is_stream(path))
    write_table(path, (header, *rows), beside(answer))


def beside(answer: JsonObject) -> JsonObject:
    """What the JSON file beside a trajectory's table has: all that is not in the table."""
    table = ("times", "states", *COLUMNS)
    return {"t_bits": answer["bits"]} | {k: v for k, v in answer.items() if k not in table}


def write_table(path: Path, rows: Iterable[Sequence[str]], beside: JsonObject) -> None:
    """Rows as CSV and what is not in them as JSON beside it; a stream has nothing beside it."""
    texts = {path: "".join(",".join(row) + "\n" for row in rows)}
    write_whole(texts if is_stream(path) else texts | {sidecar(path): as_json(beside)})


def rows_of(answer: JsonObject, *, short: bool = False) -> tuple[list[str], list[list[str]]]:
    """Header and rows of a trajectory's table, strings as printed; empty where undefined.

    ``short``: of a run; each t is the shortest decimal that rounds to it in the run's type.
    """
    header = ["t", *answer["columns"]]
    parts = [answer["states"]]
    for word, column in COLUMNS.items():
        if word in answer:
            header += column.names
            parts.append(rows_of_column(word, answer[word]))
    times = answer["times"]
    if short:
        number = NumberType(answer["number"], answer["bits"])
        times = [shortest(Fraction(t), number) for t in times]
    return header, [
        [t, *("" if x is None else x for row in rows for x in row)]
        for t, *rows in zip(times, *parts, strict=True)
    ]

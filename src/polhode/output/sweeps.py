"""An ensemble as a JSON object, a CSV file or an NPZ file; names and shapes are a contract."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

from polhode.common.files import check_writable, is_stream, npz, write_whole
from polhode.common.interrupts import Delay
from polhode.common.json_text import JsonObject, as_json
from polhode.equations.integrals import Drift
from polhode.motion.outcomes import OUTCOMES
from polhode.numbers import decimals
from polhode.numbers.decimals import in_full, shortest, shown, strings
from polhode.numbers.exact import Exact
from polhode.numbers.rows import Stack
from polhode.output import csv_tables, json_results
from polhode.scenes.vocabulary import COLUMNS

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from polhode.numbers.exact_sequences import Floats
    from polhode.runs.sweep.ensemble import Ensemble
    from polhode.scenes.variation.vary import Grid


def of_ensemble(found: Ensemble, states: bool = True) -> JsonObject:
    """The object that ``sweep --json`` prints; a member's states end where it ended."""
    return {
        **_common(found),
        "columns": list(found.columns),
        "times": [in_full(t) for t in found.times],
        "members": list(_members(found, states)),
        "provenance": dict(found.provenance),
    }


def _members(found: Ensemble, states: bool) -> Iterator[JsonObject]:
    each = zip(values(found.varied), found.outcomes, found.arrived, found.steps, strict=True)
    reached: dict[Fraction, str] = {}
    for k, (varied, outcome, t, steps) in enumerate(each):
        if t not in reached:
            reached[t] = in_full(t)
        drift = (None if x != x else x for x in found.drift[k].tolist())
        member: JsonObject = {
            "values": varied,
            "outcome": outcome.value,
            "reached": reached[t],
            "steps": steps,
            "drift": json_results.of_drift(Drift(*drift)),
        }
        if states:
            member["states"] = strings(found.rows(k), found.number)
            for word in found.outputs:
                rows = strings(found.output(word, k), found.number)
                member[word] = json_results.of_column(word, member["states"], rows)
        yield member


def check_path(path: Path, inputs: Sequence[Path | None] = ()) -> None:
    """Refuse a path that cannot be written, before anything is integrated; raises BadInput."""
    if path.suffix.lower() == ".csv":
        csv_tables.check_paths(path, inputs)
    else:
        check_writable(path, [".npz", ".csv"], inputs)


def write(path: Path, found: Ensemble) -> None:
    """Write an ensemble whole, by the path's ending; raises BadInput.

    ``.csv``: a row for each member and time, what the members have in common and how each ended in
    a JSON file beside it.  ``.npz``: arrays, see :func:`arrays`.  Ctrl-C waits for it.
    """
    if is_stream(path):
        _write(path, found)
        return
    with Delay():
        _write(path, found)


def _write(path: Path, found: Ensemble) -> None:
    if path.suffix.lower() == ".npz":
        write_whole({path: npz(arrays(found))})
        return
    short = not is_stream(path)
    beside = ({"t_bits": found.number.bits} if short else {}) | of_ensemble(found, states=False)
    csv_tables.write_table(path, rows(found, short), beside)


def arrays(found: Ensemble) -> JsonObject:
    """The arrays of an NPZ file, none of which needs pickle.

    ``times`` and ``states`` (members, times, columns) are decimal strings above extended;
    ``values`` (members, keys) are doubles, ``values_exact`` text, which is left out where arrays
    were given: ``values`` are those; ``about`` is JSON.
    """
    import numpy as np

    flat = found.number.flat
    kind = found.states.dtype.type if flat else str
    times = [kind(in_full(t)) for t in found.times]

    def held(rows: Stack) -> npt.NDArray[np.generic]:
        if flat:
            return rows
        written = [
            strings([row], found.number)[0] if row[0] == row[0] else ["nan"] * len(row)
            for row in rows.reshape(-1, rows.shape[-1]).tolist()
        ]
        return np.array(written).reshape(rows.shape)

    about = {**_common(found), "provenance": dict(found.provenance)}
    return {
        "columns": np.array(found.columns),
        "times": np.array(times),
        "states": held(found.states),
        **{word: held(rows) for word, rows in found.outputs.items()},
        "varied": np.array(found.varied.keys),
        **values_of(found.varied),
        "outcomes": np.array([outcome.value for outcome in OUTCOMES])[found.endings],
        "reached": _texts(found.arrived),
        "steps": found.counts,
        "drift": found.drift,
        "about": np.array(as_json(about)),
    }


def table(found: Ensemble) -> tuple[list[str], list[list[str]]]:
    """Header and a line for each member: what is varied, how it ended, its last state."""
    header = ["member", *found.varied.keys, "outcome", "steps", "t", *_columns(found)]
    lines = []
    for k, varied in enumerate(values(found.varied)):
        states = found.rows(k)
        last = _written(found, k)[-1:]
        t = [shortest(found.times[len(states) - 1], found.number)] if len(states) else [""]
        state = last[0] if last else [""] * len(_columns(found))
        outcome = found.outcome(k).value
        lines.append([str(k + 1), *varied, outcome, str(found.counts[k]), *t, *state])
    return header, lines


def _common(found: Ensemble) -> JsonObject:
    answer: JsonObject = {
        "scene": found.scene.name,
        "number": found.number.name,
        "bits": found.number.bits,
    }
    if found.digits is not None:
        answer["digits"] = found.digits
    return answer | {
        "form": found.scene.form,
        "varied": list(found.varied.keys),
        "projected": found.projected,
        "interrupted": found.interrupted,
    }


def values(varied: Grid) -> Iterator[list[str]]:
    """Of each member what is varied, as text."""
    rows = varied.rows
    arrays = array_columns(varied)
    if arrays:
        yield from map(list, zip(*(column.texts() for column in arrays), strict=True))
        return
    if not rows.product:
        yield from ([value_text(x) for x in row] for row in rows)
        return
    yield from map(list, itertools.product(*([value_text(x) for x in c] for c in rows.columns)))


def array_columns(varied: Grid) -> list[Floats]:
    """The columns, where the members are the rows of arrays; else none of them."""
    from polhode.numbers.exact_sequences import Floats

    found = [column for column in varied.rows.columns if isinstance(column, Floats)]
    return found if len(found) == len(varied.keys) else []


def values_of(varied: Grid) -> JsonObject:
    """What is varied as the arrays of a file."""
    import numpy as np

    arrays = array_columns(varied)
    if arrays:
        return {"values": np.stack([column.values for column in arrays], axis=1)}
    values, exact = spread(varied, lambda x: float(x)), spread(varied, value_text)
    return {"values": values, "values_exact": exact}


def spread(varied: Grid, read: Callable[[Exact], object]) -> npt.NDArray[np.generic]:
    """What is varied as an array (members, keys), each different value read once."""
    import numpy as np

    rows, member = varied.rows, np.arange(len(varied.rows))
    return np.stack(
        [
            np.array([read(x) for x in column])[member // repeat % len(column)]
            for column, repeat in zip(rows.columns, rows.repeats, strict=True)
        ],
        axis=1,
    )


def _texts(times: Stack) -> npt.NDArray[np.generic]:
    """Times with all digits, each different one written once."""
    import numpy as np

    known = {id(t): t for t in times.tolist()}  # members of a job share theirs
    texts = {key: in_full(t) for key, t in known.items()}
    return np.array([texts[id(t)] for t in times.tolist()])


def value_text(x: Exact) -> str:
    """A varied value: every digit of a decimal, else a fraction; an irrational to 17 digits."""
    return decimals.in_full(x) if isinstance(x, Fraction) else shown(x)


def rows(found: Ensemble, short: bool = True) -> Iterable[list[str]]:
    """Header and a row for each member and time."""
    yield ["member", *found.varied.keys, "t", *_columns(found)]
    times = [shortest(t, found.number) if short else in_full(t) for t in found.times]
    for k, varied in enumerate(values(found.varied)):
        for t, state in zip(times, _written(found, k), strict=False):
            yield [str(k + 1), *varied, t, *state]


def _columns(found: Ensemble) -> list[str]:
    """The names of all columns."""
    return [*found.columns, *(name for word in found.outputs for name in COLUMNS[word].names)]


def _written(found: Ensemble, k: int) -> list[list[str]]:
    """All columns of a member as far as it came, empty where there is no number."""
    parts: list[Sequence[Sequence[str | None]]] = [strings(found.rows(k), found.number)]
    parts += [strings(found.output(word, k), found.number) for word in found.outputs]
    return [[x or "" for row in rows for x in row] for rows in zip(*parts, strict=True)]

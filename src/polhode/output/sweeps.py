"""An ensemble as a JSON object, a CSV file or an NPZ file; names and shapes are a contract."""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from polhode.common.files import check_writable, is_stream, write_whole
from polhode.common.interrupts import delayed
from polhode.equations.integrals import Drift
from polhode.numbers import decimals
from polhode.numbers.decimals import decimal_in_full, shown, strings
from polhode.numbers.exact import Exact
from polhode.output import results

if TYPE_CHECKING:
    from polhode.runs.sweep import Ensemble


def of_ensemble(found: Ensemble) -> dict[str, Any]:
    """The object that ``sweep --json`` prints; a member's states end where it ended."""
    return {
        **_common(found),
        "columns": list(found.columns),
        "times": [decimal_in_full(t) for t in found.times],
        "members": [
            {
                "values": values,
                "outcome": found.outcomes[k].value,
                "reached": decimal_in_full(found.reached[k]),
                "steps": found.steps[k],
                "drift": results.of_drift(Drift(*found[k].drift)),
                "states": strings(found[k].states, found.number),
            }
            for k, values in enumerate(_values(found))
        ],
        "provenance": dict(found.provenance),
    }


def check_path(path: Path, inputs: Sequence[Path | None] = ()) -> None:
    """Refuse a path that cannot be written, before anything is integrated; raises BadInput."""
    if path.suffix.lower() == ".csv":
        results.check_paths(path, inputs)
    else:
        check_writable(path, [".npz", ".csv"], inputs)


def parts_of(path: Path) -> Path | None:
    """The folder beside an output in which a sweep keeps what is done; None beside a stream."""
    return None if is_stream(path) else path.with_name(path.name + ".parts")


def write(path: Path, found: Ensemble) -> None:
    """Write an ensemble whole, by the path's ending; raises BadInput.

    ``.csv``: a row for each member and time, what the members have in common and how each ended in
    a JSON file beside it.  ``.npz``: arrays, see :func:`arrays`.  Ctrl-C waits for it.
    """
    if is_stream(path):
        _write(path, found)
        return
    with delayed():
        _write(path, found)


def _write(path: Path, found: Ensemble) -> None:
    if path.suffix.lower() == ".npz":
        import numpy as np

        held = io.BytesIO()
        np.savez(held, **arrays(found))
        write_whole({path: held.getvalue()})
        return
    beside = of_ensemble(found)
    for member in beside["members"]:
        del member["states"]
    results.write_table(path, _rows(found), beside)


def arrays(found: Ensemble) -> dict[str, Any]:
    """The arrays of an NPZ file, none of which needs pickle.

    ``times`` and ``states`` (members, times, columns) are decimal strings above extended;
    ``values`` (members, keys) are doubles, ``values_exact`` text; ``about`` is JSON.
    """
    import numpy as np

    values = _values(found)
    flat = found.number.flat
    times: Any = [decimal_in_full(t) for t in found.times]
    states = found.states
    if flat:
        kind = states.dtype.type
        times = [kind(t) for t in times]
    else:
        rows = states.reshape(-1, states.shape[-1])
        written = [
            strings([row], found.number)[0] if row[0] == row[0] else ["nan"] * len(row)
            for row in rows
        ]
        states = np.array(written).reshape(states.shape)
    about = {**_common(found), "provenance": dict(found.provenance)}
    return {
        "columns": np.array(found.columns),
        "times": np.array(times),
        "states": states,
        "varied": np.array(found.varied.keys),
        "values": np.array([[float(x) for x in row] for row in found.varied.rows]),
        "values_exact": np.array(values),
        "outcomes": np.array([outcome.value for outcome in found.outcomes]),
        "reached": np.array([decimal_in_full(t) for t in found.reached]),
        "steps": np.array(found.steps),
        "drift": found.drift,
        "about": np.array(results.as_json(about)),
    }


def table(found: Ensemble) -> tuple[list[str], list[list[str]]]:
    """Header and a line for each member: what is varied, how it ended, its last state."""
    header = ["member", *found.varied.keys, "outcome", "steps", "t", *found.columns]
    lines = []
    for k, values in enumerate(_values(found)):
        one = found[k]
        last = strings(one.states[-1:], found.number)
        t = [decimal_in_full(one.times[-1])] if one.times else [""]
        state = last[0] if last else [""] * len(found.columns)
        outcome = found.outcomes[k].value
        lines.append([str(k + 1), *values, outcome, str(found.steps[k]), *t, *state])
    return header, lines


def _common(found: Ensemble) -> dict[str, Any]:
    answer: dict[str, Any] = {
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


def _values(found: Ensemble) -> list[list[str]]:
    return [[_value(x) for x in row] for row in found.varied.rows]


def _value(x: Exact) -> str:
    """A varied value: every digit of a decimal, else a fraction; an irrational to 17 digits."""
    return decimals.in_full(x) if isinstance(x, Fraction) else shown(x)


def _rows(found: Ensemble) -> Iterable[list[str]]:
    yield ["member", *found.varied.keys, "t", *found.columns]
    times = [decimal_in_full(t) for t in found.times]
    for k, values in enumerate(_values(found)):
        for t, state in zip(times, strings(found[k].states, found.number), strict=False):
            yield [str(k + 1), *values, t, *state]

"""Right tables of motions, and the doors through which a table comes to be judged."""

from fractions import Fraction
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import polhode

STATE = ("p", "q", "r", "gamma1", "gamma2", "gamma3")
ATTITUDE = ("q0", "q1", "q2", "q3")
ANGLES = ("psi", "theta", "phi")
NAMES = {"at": STATE, "attitude": ATTITUDE, "angles": ANGLES}


@cache
def _column(case, times, part):
    rows = getattr(polhode.reference(case), part)(times, 20)
    return np.array([[np.nan if x is None else float(x) for x in row] for row in rows]).T


def right(case, times, *parts):
    """Columns of the exact motion, rounded to doubles: of the state, or of the parts named."""
    times = tuple(map(Fraction, times))
    table = {"t": np.array([float(t) for t in times])}
    for part in parts or ("at",):
        table |= {n: x.copy() for n, x in zip(NAMES[part], _column(case, times, part), strict=True)}
    return table


def of_run(run):
    """The state of a run in double by name, with its times."""
    return {"t": np.array(run.t), **dict(zip(run.columns, np.array(run.states).T, strict=True))}


def text(table, separator=",", header=True, empty=""):
    """The table as a text: the shortest decimals of doubles, ``empty`` for no number."""
    cells = [[empty if x != x else repr(float(x)) for x in column] for column in table.values()]
    lines = [[*table]] if header else []
    lines += zip(*cells, strict=True)
    return "".join(separator.join(line) + "\n" for line in lines)


def _frame(table):
    return pytest.importorskip("pandas").DataFrame(table)


def _rounded(table, path, form):
    cells = np.column_stack([*table.values()])
    np.savetxt(path, cells, fmt=form, delimiter=",", header=",".join(table), comments="")


_FILES = {
    "csv": lambda table, path: path.write_text(text(table)),
    "npz": lambda table, path: np.savez(path, **table),
    "npy": lambda table, path: np.save(path, np.rec.fromarrays([*table.values()], names=[*table])),
    "frame.csv": lambda table, path: _frame(table).to_csv(path, index=False),
    "parquet": lambda table, path: _frame(table).to_parquet(path),
}
DOORS = ("mapping", "frame", *_FILES)


def through(door: str, table, folder: Path):
    """The same table through a door: as it is, a frame, a file, a CSV in a format of C."""
    if door == "mapping":
        return table
    if door == "frame":
        return _frame(table)
    if door == "parquet":
        pytest.importorskip("pyarrow")
    path = folder / f"x.{'csv' if '%' in door else door}"
    if "%" in door:
        _rounded(table, path, door)
    else:
        _FILES[door](table, path)
    return path


# -- methods of fixed steps whose order is known, of f(t, y) without t


def euler(f, y, h):
    return y + h * f(0, y)


def midpoint(f, y, h):
    return y + h * f(0, y + h / 2 * f(0, y))


def rk4(f, y, h, last=6.0):
    a = f(0, y)
    b = f(0, y + h / 2 * a)
    c = f(0, y + h / 2 * b)
    return y + h / last * (a + 2 * b + 2 * c + f(0, y + h * c))

"""Correct digits of a trajectory of the heavy top benchmark.

    python check.py TOP.csv MINE.csv [AT_LEAST]

TOP.csv is a file of the benchmark; MINE.csv has the columns t, p, q, r, gamma1, gamma2, gamma3 in
any order, and q0, q1, q2, q3 where the attitude is to be judged.  Decimals are taken exactly.
Digits are -log10 of the larger of the error of omega, relative to the largest |omega| of TOP.csv,
and the error of gamma; of the attitude -log10 of its error, of q or -q.  Errors are the largest of
a component.  Exit code 0; 1 with fewer digits than AT_LEAST or a missing time; 2 for bad input.
"""

from __future__ import annotations

import csv
import math
import sys
from collections.abc import Sequence
from fractions import Fraction

OMEGA, GAMMA = ["p", "q", "r"], ["gamma1", "gamma2", "gamma3"]
ATTITUDE = ["q0", "q1", "q2", "q3"]
Row = dict[str, Fraction]


def read(path: str) -> list[Row]:
    """The rows of a file, as exact numbers by the names of its columns."""
    with open(path, newline="") as file:
        rows = csv.DictReader(file, skipinitialspace=True)
        if missing := {"t", *OMEGA, *GAMMA} - {*(rows.fieldnames or ())}:
            raise ValueError(f"{path}: expected the columns {', '.join(sorted(missing))}")
        return [{name: Fraction(x) for name, x in row.items()} for row in rows]


def error(mine: Row, true: Row, names: Sequence[str], sign: int = 1) -> float:
    """The largest error of some columns."""
    return float(max(abs(sign * mine[name] - true[name]) for name in names))


def digits(off: float) -> float:
    """From an error: 50 at most, which the benchmark has."""
    return min(50.0, max(0.0, -math.log10(off))) if off else 50.0


def main(arguments: Sequence[str]) -> int:
    """Print the digits at each time, and the worst."""
    tops, rows = read(arguments[0]), read(arguments[1])
    scale = max(math.hypot(*(float(row[name]) for name in OMEGA)) for row in tops)
    found: list[list[float]] = []
    print("t  state  attitude")
    for true in tops:
        t = true["t"]
        near = [row for row in rows if abs(row["t"] - t) <= abs(t) / 10**9]
        if not near:
            if t:
                print(f"{float(t):g}  missing")
                found.append([0.0])
            continue
        mine = near[0]
        here = [digits(max(error(mine, true, OMEGA) / scale, error(mine, true, GAMMA)))]
        if set(ATTITUDE) <= set(mine):
            here.append(digits(min(error(mine, true, ATTITUDE, sign) for sign in (1, -1))))
        print(f"{float(t):g}  " + "  ".join(f"{x:.2f}" for x in here))
        found.append(here)
    worst = min(map(min, found))
    print(f"worst {worst:.2f} correct digits")
    return int(len(arguments) > 2 and worst < float(arguments[2]))


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except (IndexError, KeyError, OSError, TypeError, ValueError, ZeroDivisionError) as fault:
        print(f"check.py TOP.csv MINE.csv [AT_LEAST]: {fault!r}", file=sys.stderr)
        sys.exit(2)

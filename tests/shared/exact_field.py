"""The compiled field and the products by levels beside integers, to the bit.

Only these two, and the arithmetic of limbs, decide which digits of a refined run come out; a fault
in what corrects the stages would show as sweeps that do not converge.  A compiler that contracts or
reassociates, a damaged cache of compiled code, a BLAS of fewer digits: all would show here.
"""

from __future__ import annotations

import random
from fractions import Fraction

import numpy as np

from polhode.numbers.number_types import Doubles
from polhode.refined.collocation_tables import LARGEST_FIELD, Tables
from polhode.refined.compiled_field import COEFFICIENTS, FIELD_SHIFT, VARIABLES, Kernels, Limbs

NODES = 8  # that the field is tried at
LONGEST = 16  # H
_COLUMNS = 2


def field_error(compiled: Kernels, limbs: Limbs) -> float:
    """The largest error of H f, over max(1, H), at random states; all in integers beside it."""
    draw = random.Random(1)
    unit = 1 << limbs.finest
    k = [[draw.randint(-unit, unit) for _ in range(NODES)] for _ in range(COEFFICIENTS)]
    x = [[draw.randint(-unit, unit) for _ in range(NODES)] for _ in range(VARIABLES)]
    lengths, exact = [], []
    for n in range(NODES):
        rates = field([row[n] for row in x], [row[n] for row in k], unit)
        largest = max(1, *map(abs, rates))
        most = int(LARGEST_FIELD) * unit**4 // largest
        length = min(draw.randint(0, LONGEST * unit), most)
        lengths.append(length)
        exact.append([rate * length for rate in rates])
    columns = _columns(limbs, x)
    parameters = _columns(limbs, [*k, lengths])
    outputs = np.empty((VARIABLES * limbs.count, NODES))
    compiled.field(columns, pars=parameters, outputs=outputs)
    if not np.isfinite(outputs).all():
        return float("inf")
    worst = Fraction(0)
    for n in range(NODES):
        for v in range(VARIABLES):
            value = limbs.value(outputs[v * limbs.count : (v + 1) * limbs.count, n])
            error = abs(value - Fraction(exact[n][v], unit**4))
            worst = max(worst, error / max(Fraction(1), Fraction(lengths[n], unit)))
    return float(worst)


def field(x: list[int], k: list[int], unit: int) -> list[int]:
    """The rates (3.29) in integers: x and k in units of 1/one, the rates in units of 1/one³."""
    w, g = x[:3], x[3:]
    values = []
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        weight = k[3 + 2 * a] * g[b] + k[4 + 2 * a] * g[c]
        values.append(k[a] * w[b] * w[c] + unit * weight)
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        values.append(unit * (g[b] * w[c] - g[c] * w[b]))
    return values


def _columns(limbs: Limbs, rows: list[list[int]]) -> Doubles:
    """Integers in units of 2**-finest as limbs, the limbs of a row one below the other."""
    split = np.array([[limbs.split_integer(x) for x in row] for row in rows])
    return np.ascontiguousarray(split.transpose(0, 2, 1).reshape(-1, len(rows[0])))


def products_are_exact(table: Tables, limbs: Limbs) -> bool:
    """Whether the levels of A·F equal integer arithmetic, bit for bit, for fields up to 4."""
    kind = limbs.shifted(FIELD_SHIFT)
    most = int(LARGEST_FIELD) << kind.finest
    draw = random.Random(1)
    shape = (VARIABLES, len(table.nodes), _COLUMNS, limbs.count)
    numbers = [kind.split_integer(draw.randint(-most, most)) for _ in range(np.prod(shape[:3]))]
    fields = np.ascontiguousarray(np.array(numbers).reshape(shape).transpose(0, 3, 1, 2))
    levels = table.integrated(fields)[:-1]
    row = int(np.abs(table.levels[-1]).sum(axis=1).argmax())
    return all(
        level[0, row, 0] * 2.0 ** limbs.place(i + 2)
        == exact_product(rows[row], fields[0, :, :, 0], limbs)
        for i, (level, rows) in enumerate(zip(levels, table.levels, strict=True))
    )


def exact_product(row: Doubles, field: Doubles, limbs: Limbs) -> int:
    """A row of ``Tables.levels`` times the limbs (L, M) of a field, in units of its level."""
    nodes = field.shape[1]
    top = len(row) // nodes  # limbs A_top ... A_1 against F_1 ... F_top
    table, kind = limbs.shifted(-FIELD_SHIFT), limbs.shifted(FIELD_SHIFT)
    total = 0
    for j in range(1, top + 1):
        part = row[(j - 1) * nodes : j * nodes] * 2.0 ** table.place(top + 1 - j)
        factor = field[j - 1] * 2.0 ** kind.place(j)
        total += sum(int(a) * int(f) for a, f in zip(part.tolist(), factor.tolist(), strict=True))
    return total

"""Krawczyk's test: exactly one zero of a map in a box, and a smaller box that holds it.

Trusted.  F: R^n -> R^n, a box Y with the centre y* and radii rho, a ball matrix that holds every
DF(y), y in Y, and C any matrix.  If every component of

    K - y* = -C F(y*) + (I - C DF(Y)) [-rho, rho]

is below its rho in modulus, F has exactly one zero in Y, and that lies in K.  (R. Krawczyk 1969.)
Each matrix of DF(Y) is then regular, C too.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from flint import arb, arb_mat

from polhode.numbers.rows import Doubles


class Contraction(NamedTuple):
    """``moved``: K - y*, balls; ``newton``: the middles of -C F(y*); ``ratios``: |K - y*|/rho."""

    moved: list[arb]
    newton: list[arb]
    ratios: list[float]
    passed: bool


def contraction(
    value: Sequence[arb], slope: arb_mat, inverse: Doubles, radii: Sequence[arb]
) -> Contraction:
    """``value``: F(y*); ``slope``: DF(Y); ``inverse``: C; ``radii``: exact, rho."""
    count = len(radii)
    c = arb_mat([[arb(x) for x in row] for row in inverse.tolist()])
    newton = (c * arb_mat([[x] for x in value])).entries()
    left = c * slope
    moved, ratios, passed = [], [], True
    for i in range(count):
        size = arb(0)
        for j in range(count):
            part = (1 - left[i, j]) if i == j else -left[i, j]
            size = size + part.abs_upper() * radii[j]
        found = -newton[i] + arb(0, 1) * size.abs_upper()
        moved.append(found)
        most = found.abs_upper()
        passed = passed and bool(radii[i] > 0) and bool(most < radii[i])
        ratios.append(float((most / radii[i]).abs_upper()))
    return Contraction(moved, [-x.mid() for x in newton], ratios, passed)

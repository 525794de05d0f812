"""DF(Y), entry by entry, against DF at corners of Y; and each of its terms dropped is noticed."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import pytest

from polhode.enclosures.variations import variational_bound
from polhode.proofs import flow_tube, periodic_orbit
from shared import orbit_newton
from shared import orbit_proofs as proofs
from shared.mutation import without

FAT = 20  # boxes of 2**-FAT
THIN = 90
_TRUTHS: dict[tuple[object, ...], list[list[Fraction]]] = {}


def truth(corner, start, period):
    """DF's first seven columns but for the row of a, at a corner of boxes 2**-start, 2**-period."""
    if (corner, start, period) not in _TRUTHS:
        made = proofs.sharp(proofs.ELLIPTIC)
        by = Fraction(1, 1 << start)
        x = [Fraction(n, 1 << 122) + s * by for n, s in zip(made.start, corner, strict=False)]
        time = Fraction(made.period, 1 << 122) + Fraction(4 * corner[6], 1 << period)
        body = proofs.MOMENTS, proofs.TORQUE
        d = orbit_newton.derivative(*body, x, time)
        speed = orbit_newton.rates(*body, orbit_newton.flow(*body, x, time))
        rows = [[d[i][j] - (i == j) for j in range(6)] + [speed[i]] for i in range(6)]
        w, g = x[:3], x[3:]
        # H as it is scaled: moments and torque over the largest moment, 2 h
        m, k = ([a / 2 for a in v] for v in body)
        momentum = [a * b for a, b in zip(m, w, strict=True)]
        rows.append([*(2 * a for a in momentum), *(2 * a for a in k)])
        rows.append([*(a * b for a, b in zip(m, g, strict=True)), *momentum])
        rows.append([Fraction(0)] * 3 + [2 * a for a in g])
        _TRUTHS[corner, start, period] = rows
    return _TRUTHS[corner, start, period]


def worst(corner, start, period):
    """The largest |truth - middle|/radius over the entries, those of H where the boxes agree."""
    made = replace(proofs.sharp(proofs.ELLIPTIC), bits=period)
    balls = proofs.followed(made, start_box=start).slope
    rows = range(6) if start != period else [*range(6), 7, 8, 9]
    found = [0.0]
    for i, row in zip(rows, truth(corner, start, period), strict=False):
        for j, x in enumerate(row):
            middle, radius = balls[i][j]
            # finite differences are right to about thirty digits
            off = max(Fraction(0), abs(x - middle) - Fraction(1, 10**26))
            found.append(float(off / radius) if radius else math.inf if off else 0.0)
    return max(found)


CORNERS = [(1, -1, 1, 1, -1, 1, 1), (-1, -1, -1, -1, -1, -1, -1), (1, 1, 1, 1, 1, 1, 1)]
#: Boxes of starts and of periods: both fat, one of them thin.
BOTH, STARTS, PERIODS = (FAT, FAT), (FAT, THIN), (THIN, FAT)


@pytest.mark.slow
@pytest.mark.parametrize("boxes", [BOTH, STARTS, PERIODS])
@pytest.mark.parametrize("corner", CORNERS)
def test_the_matrix_holds_the_derivative_at_corners(corner, boxes):
    assert 0 < worst(corner, *boxes) <= 1 + 1e-9  # H is linear and its balls are sharp


#: The term, the boxes that show it, and how the term is dropped.
DROPPED = {
    "nu": (
        STARTS,
        (variational_bound, "missed", "float(known.majorant[n]) * (nu + nu * nu)", "0.0"),
    ),
    "the box in nu": (STARTS, (variational_bound, "missed", " + step.r", " + 0.0")),
    "the box in the set": (STARTS, (flow_tube, "Tube.__init__", "+ radius", "+ 0.0 * radius")),
    "the period's box in D": (
        PERIODS,
        (periodic_orbit, "slope", "(wider * columns[j])", "(0 * columns[j])"),
    ),
    "the period's box in f": (
        PERIODS,
        (periodic_orbit, "slope", "known.field(reached.box)", "known.field(tube.rows[-1])"),
    ),
    "H over the box": (
        BOTH,
        (
            periodic_orbit,
            "slope",
            "known.gradients(box)",
            "known.gradients([x.mid() for x in box])",
        ),
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("term", DROPPED)
def test_a_dropped_term_is_noticed(term):
    boxes, change = DROPPED[term]
    with without(*change):
        assert worst(CORNERS[0], *boxes) > 1.001

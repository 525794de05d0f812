"""DF(Y), the motion and H over boxes of starts, periods and bodies, beside the truth at corners."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from functools import cache

import pytest

from polhode.enclosures import fixed_point_problem, step_bound
from polhode.enclosures.variations import variational_bound
from polhode.numbers.flint_context import ctx
from polhode.proofs import flow_tube, periodic_orbit
from polhode.proofs import level as levels
from shared import orbit_newton
from shared import orbit_proofs as proofs
from shared.mutation import without

FINE = 122  # bits of a candidate's numbers
FAT, THIN = 20, 90  # boxes of 2**-FAT
TOLERANCE = Fraction(1, 10**6)
NEAR = Fraction(1, 10**26)  # finite differences are right to about thirty digits

#: What is not known exactly: boxes of the start and of the period, relative sizes of the body.
BOTH, STARTS, PERIODS = (FAT, FAT, 0), (FAT, THIN, 0), (THIN, FAT, 0)
BODIES = (THIN, THIN, TOLERANCE)
CORNERS = [(1, -1, 1, 1, -1, 1, 1), (-1, 1, -1, 1, -1, 1, 1), (1, 1, 1, 1, 1, 1, 1)]


def candidate(boxes):
    """The elliptic orbit; of bodies for a short time, which hides the least."""
    made = replace(proofs.sharp(proofs.ELLIPTIC), bits=boxes[1])
    return replace(made, period=1 << (FINE - 12)) if boxes[2] else made


@cache
def truth(corner, boxes):
    """DF's first seven columns but for the row of a, the end and H, at a corner."""
    start, period, tolerance = boxes
    made = candidate(boxes)
    x = [Fraction(n, 1 << FINE) for n in made.start]
    numbers = [*proofs.MOMENTS, *proofs.TORQUE]
    time = Fraction(made.period, 1 << FINE)
    if tolerance:
        numbers = [n * (1 + s * tolerance) for n, s in zip(numbers, corner, strict=False)]
    else:
        x = [n + s * Fraction(1, 1 << start) for n, s in zip(x, corner, strict=False)]
        time += Fraction(4 * corner[6], 1 << period)
    body = numbers[:3], numbers[3:]
    end = orbit_newton.flow(*body, x, time)
    d, speed = orbit_newton.derivative(*body, x, time), orbit_newton.rates(*body, end)
    rows = [[d[i][j] - (i == j) for j in range(6)] + [speed[i]] for i in range(6)]
    # H as it is scaled: moments and torque over the largest moment, 2 h
    m, k = ([a / 2 for a in v] for v in body)
    w, g = x[:3], x[3:]
    momentum = [a * b for a, b in zip(m, w, strict=True)]
    gradients = [
        [*(2 * a for a in momentum), *(2 * a for a in k)],
        [*(a * b for a, b in zip(m, g, strict=True)), *momentum],
        [Fraction(0)] * 3 + [2 * a for a in g],
    ]
    energy = sum(a * b for a, b in zip(momentum, w, strict=True))
    return rows, gradients, end, energy + 2 * sum(a * b for a, b in zip(k, g, strict=True))


def worst(corner, boxes):
    """The largest |truth - middle|/radius."""
    on, made = proofs.level(), candidate(boxes)
    on = replace(on, motion=replace(on.motion, tolerance=boxes[2]))
    tube, slope = proofs.followed(made, on, boxes[0])
    rows, gradients, end, energy = truth(corner, boxes)
    pairs = [(x, y) for i, row in enumerate(rows) for x, y in zip(row, slope[i], strict=False)]
    if boxes[0] == boxes[1]:  # DH is over the box of the period's size
        both = zip(gradients, slope[7:], strict=True)
        pairs += [(x, y) for row, balls in both for x, y in zip(row, balls, strict=False)]
    if boxes[2]:
        with ctx.workprec(300):
            known = on.balls(210).integrals([levels.arb((n, -FINE)) for n in made.start])
            balls = zip([*end, energy], [*tube.rows[-1], known[0]], strict=True)
            pairs += [(x, (proofs.middle_of(y), proofs.middle_of(y.rad()))) for x, y in balls]
    return max(ratio(value, *ball) for value, ball in pairs)


def ratio(value, middle, radius):
    off = max(Fraction(0), abs(value - middle) - NEAR)
    return float(off / radius) if radius else math.inf if off else 0.0


def widest(boxes):
    """At one corner, or at those of the bodies."""
    return max(worst(corner, boxes) for corner in (CORNERS if boxes[2] else CORNERS[:1]))


@pytest.mark.slow
@pytest.mark.parametrize("boxes", [BOTH, STARTS, PERIODS, BODIES])
def test_the_truth_at_corners_is_held(boxes):
    assert 1e-3 < widest(boxes) <= 1 + 1e-9  # H is linear and its balls are sharp


#: The boxes that show a term, and how the term is dropped.
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
    "the constants of the defect": (
        BODIES,
        (
            fixed_point_problem,
            "_whole",
            "slack[k] = upper(abs(balls[k] - ball(x, 4 * noise + 64)) * arb((1, noise)))",
            "pass",
        ),
    ),
    "the constants of the derivative": (
        BODIES,
        (step_bound, "_jacobian_gaps", "max(problem.factor_slack)", "1e-17"),
    ),
    "the body of the level": (BODIES, (levels, "Level.balls", "what.spread(x)", "x")),
    "the field of the level": (
        BODIES,
        (
            levels,
            "Level.balls",
            "what.balls(bits)",
            "[ball(x, bits + 64) for x in what.constants]",
        ),
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("term", DROPPED)
def test_a_dropped_term_is_noticed(term):
    boxes, change = DROPPED[term]
    with without(*change):
        assert widest(boxes) > 1.001

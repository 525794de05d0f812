"""A periodic orbit near a candidate exists, and is the only one there: the theorems.

Trusted.  Of a level c = (h, f, 1) of H, x* and T* exact, W (6 x 3) and a (6) any doubles, here near
DH(x*)^T and f(x*), phi the flow,

    F(x, T, lam) = (phi_T(x) - x - W lam, a·(x - x*), H(x) - c),     ten equations, ten unknowns.

Theorem A.  Y = (|x - x*| <= r) x (|T - T*| <= 4 r) x (|lam| <= 4 r), max-norm, T* > 4 r.  If
Krawczyk's test holds on Y, and the 3 x 3 ball matrix DH(X + W Lam) W has a determinant without 0,
then F has exactly one zero in Y; there lam = 0, phi_T(x) = x, H(x) = c: a periodic orbit of the
level, the only one through that piece of the plane a·(x - x*) = 0 with a period in the interval.

Proof.  H(phi_T(x)) = H(x), so 0 = H(x + W lam) - H(x) = [int_0^1 DH(x + s W lam) ds] W lam.  The
matrix lies in the ball matrix, is regular, and lam = 0.  An equilibrium is no zero: at f = 0 the
column of T in DF vanishes, and DF is regular.

    DF = [[D - I, f(phi_T(x)), -W], [a, 0, 0], [DH(x), 0, 0]],

D over all starts of the box from ``flow_tube`` at T*, widened column by column by exp(4 r L) - 1.

Theorem B.  At the orbit D fixes the three covectors DH and the vector f, and det D = 1, since
div f = 0: the trace is 4 + mu + 1/mu.  R = (6 - tr D)/4 below 0: hyperbolic, between 0 and 1
elliptic, above 1 inverse hyperbolic; linearly, on its level.

Uniqueness among all motions of the level: with a·f >= m > 0 and |f| <= v on the box, one that
passes within r/(1 + v |a|_1/m) of x* meets the plane inside the box.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Protocol

import numpy as np
from flint import arb, arb_mat

from polhode.enclosures import fixed_point_problem
from polhode.enclosures.fixed_point_problem import Problem, Refused
from polhode.numbers.flint_context import ctx
from polhode.numbers.rows import Doubles
from polhode.proofs import flow_tube, krawczyk, least_period
from polhode.proofs.flow_tube import Tube
from polhode.proofs.krawczyk import Contraction
from polhode.proofs.level import Level, LevelBalls, largest
from polhode.proofs.refusals import NotContracted, Unproved

SPAN = 4  # times r: the radius of T and of lam
ELLIPTIC, HYPERBOLIC, INVERSE = "elliptic", "hyperbolic", "inverse hyperbolic"


class Reached(Protocol):
    """What is used of a proof's run."""

    @property
    def rows(self) -> list[list[arb]]:
        """Boxes at the times asked for."""


def _inverse(matrix: Doubles) -> Doubles:
    return np.asarray(np.linalg.inv(matrix), dtype=np.float64)


#: Runs a proof: the problem, the times asked for, what watches.
Follow = Callable[[Problem, Sequence[arb], Sequence[Tube]], Reached]


@dataclass(frozen=True)
class Candidate:
    """x* and T*, integers times 2**-fine, fine that of the noise level; r = 2**-bits.

    ``w``, ``a``: W and a; ``inverse``: makes C of the middle of DF.  ``parts``: primes by which T
    is divided to look for a shorter period.  Nothing of this is believed.
    """

    noise: int
    start: tuple[int, ...]
    period: int
    bits: int
    w: Doubles
    a: Doubles
    inverse: Callable[[Doubles], Doubles] = _inverse
    parts: tuple[int, ...] = ()


@dataclass(frozen=True)
class Theorem:
    """What is proved, in the proof's unit of time, as balls.

    ``near``: r' of the last paragraph of the module, ``beside``: 4 r.  ``open``: the primes p for
    which T/p is not excluded as a period; none: T is the least one.
    """

    start: list[arb]
    period: arb
    residue: arb
    kind: str
    near: arb
    beside: arb
    open: tuple[int, ...]
    contraction: Contraction


def prove(level: Level, candidate: Candidate, follow: Follow) -> Theorem:
    """Theorems A and B of one candidate; raises Refused and its kinds."""
    problem = _problem(level, candidate)
    fine = problem.fine
    parts = tuple(sorted(candidate.parts, reverse=True))
    times = [flow_tube.part(candidate.period, fine, p) for p in (*parts, 1)]
    radius = 2.0 ** (candidate.noise - candidate.bits)
    tube = Tube(problem, radius, times)
    ends = follow(problem, times[-1:], (tube,)).rows
    if len(ends) != 1:
        raise Refused("the enclosure did not reach the period")
    with ctx.workprec(candidate.noise + 128):
        known = level.balls(candidate.noise + 100)
        r = arb((1, -candidate.bits))
        span = SPAN * r
        centre = [flow_tube.exactly(x, fine) for x in candidate.start]
        period = flow_tube.exactly(candidate.period, fine)
        if not period > span:
            raise Refused("the period is no longer than its box")
        matrix = slope(known, candidate, tube)
        tested = _tested(known, candidate, centre, ends[0], matrix)
        if not tested.passed:
            raise NotContracted(tested, _condition(matrix))
        box = [x + arb(0, 1) * r for x in centre]
        _independent(known, candidate, box, span)
        moved = tested.moved
        trace = sum((matrix[i, i] + 1 for i in range(6)), arb(0))
        residue = (6 - trace) / 4
        return Theorem(
            [x + d for x, d in zip(centre, moved, strict=False)],
            period + moved[6],
            residue,
            _kind(residue),
            _unique(known, candidate, box, r, moved),
            (span - moved[6].abs_upper()).lower(),
            least_period.undecided(
                least_period.Claim(period, span, tube.steepness, parts), box, tube.rows, known
            ),
            tested,
        )


def _problem(level: Level, candidate: Candidate) -> Problem:
    """The exact motion from x*."""
    fine = max(candidate.noise + 12, fixed_point_problem.LEAST_FINE)
    start = tuple(Fraction(x, 1 << fine) for x in candidate.start)
    found = fixed_point_problem.problem(replace(level.motion, start=start), candidate.noise)
    if found.fine != fine or found.start != candidate.start or any(found.spread):
        raise Refused("the start is not a state of the grid")
    return found


def slope(known: LevelBalls, candidate: Candidate, tube: Tube) -> arb_mat:
    """DF(Y), at the precision that holds."""
    r, fine = arb((1, -candidate.bits)), tube.fine
    span = SPAN * r
    box = [flow_tube.exactly(x, fine) + arb(0, 1) * r for x in candidate.start]
    reached = flow_tube.around(tube.rows[-1], span, known)
    wider = flow_tube.spread_of_derivative(reached, span, known)
    d, columns = tube.derivative()
    rates, zero = known.field(reached.box), [arb(0)] * 4
    rows = []
    for i, w in enumerate(candidate.w.tolist()):
        row = [d[i][j] + arb(0, 1) * (wider * columns[j]) for j in range(6)]
        row[i] = row[i] - 1
        rows.append([*row, rates[i], *(arb(-x) for x in w)])
    rows.append([*(arb(x) for x in candidate.a.tolist()), *zero])
    rows += [[*row, *zero] for row in known.gradients(box)]
    return arb_mat(rows)


def _tested(
    known: LevelBalls, candidate: Candidate, centre: list[arb], end: list[arb], matrix: arb_mat
) -> Contraction:
    """Krawczyk's test on Y."""
    value = [x - y for x, y in zip(end, centre, strict=True)] + [arb(0)]
    value += [x - c for x, c in zip(known.integrals(centre), known.values, strict=True)]
    try:
        inverse = candidate.inverse(_middle(matrix))
    except np.linalg.LinAlgError:
        raise Unproved("the ten equations are singular: a further multiplier is 1") from None
    if inverse.shape != (10, 10) or not np.all(np.isfinite(inverse)):
        raise Unproved("the approximate inverse is no matrix of numbers")
    r = arb((1, -candidate.bits))
    return krawczyk.contraction(value, matrix, inverse, [r] * 6 + [SPAN * r] * 4)


def _middle(matrix: arb_mat) -> Doubles:
    return np.array([float(x.mid()) for x in matrix.entries()]).reshape(10, 10)


def _independent(known: LevelBalls, candidate: Candidate, box: list[arb], span: arb) -> None:
    """det DH(X + W Lam) W without 0; raises Unproved."""
    w = candidate.w.tolist()
    hull = []
    for x, row in zip(box, w, strict=True):
        reach = sum((abs(arb(y)) for y in row), arb(0)) * span
        hull.append(x + arb(0, 1) * reach.abs_upper())
    determinant = (arb_mat(known.gradients(hull)) * arb_mat([[arb(y) for y in r] for r in w])).det()
    if not abs(determinant) > 0:
        raise Unproved(f"the gradients of h, f, |gamma|^2 may be dependent: det = {determinant}")


def _kind(residue: arb) -> str:
    if residue < 0:
        return HYPERBOLIC
    if residue > 1:
        return INVERSE
    if residue > 0 and residue < 1:
        return ELLIPTIC
    raise Unproved(f"the residue {residue.str(6)} may be 0 or 1: a multiplier may be 1 or -1")


def _unique(
    known: LevelBalls, candidate: Candidate, box: list[arb], r: arb, moved: list[arb]
) -> arb:
    """How near to any point of K a motion may pass and be this one; raises Unproved."""
    rates = known.field(box)
    a = [arb(x) for x in candidate.a.tolist()]
    along = sum((x * y for x, y in zip(a, rates, strict=True)), arb(0))
    if not along > 0:
        raise Unproved("the plane of the start may touch the motion")
    length = sum((abs(x) for x in a), arb(0))
    near = r / (1 + largest(rates) * length / along.lower())
    return (near - largest(moved[:6])).lower()


def _condition(matrix: arb_mat) -> float:
    """About the condition number of the ten equations, for a message."""
    middle = _middle(matrix)
    sizes = np.linalg.svd(middle)[1] if np.all(np.isfinite(middle)) else np.array([1.0, 0.0])
    return float(sizes[0] / sizes[-1]) if sizes[-1] else float("inf")

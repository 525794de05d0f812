"""How the body turns over each interval: the attitude quaternion's equation, solved as the state's.

Along an interval T' = ½ T ⊗ (0, w), T = 1 at its start, w the refined stages: a linear equation,
whose collocation solution is found as that of the state is
(:mod:`polhode.refined.deferred_correction`), from exact defects

    r = 1 + ½ A H (T ⊗ w) - T

and corrections in double.  All intervals are independent.  The ends are good to the square of what
the stages neglect, and Gauss collocation keeps |T| = 1.  With a correction E of the stages that is
not made any more, the end's is r_end + ½ sum_j b_j H (r_j ⊗ w_j) ⊗ T_j^-1 ⊗ T_end.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from polhode.numbers.rows import Doubles, GivenRow
from polhode.numbers.scalars import Scalar
from polhode.numbers.vectors import quaternion_product
from polhode.refined.collocation_tables import Tables
from polhode.refined.compiled_field import FIELD_SHIFT
from polhode.refined.deferred_correction import Constants, iterated
from polhode.refined.errors import CannotRefine, TooLong
from polhode.refined.expansions import Levels, Limbs, product

QUATERNION = 4
_GUESS = 1e-14  # to which the first T is iterated
_STAGES = 1e-11  # to which a correction is, relative
_ENDS = 1e-12  # relative error of the ends' last correction, at most


class Turns(NamedTuple):
    """T of N intervals.  ``ends``: four integers times 2**-finest each; ``path``: T at the nodes,
    in double, (4, M, N)."""

    ends: list[list[int]]
    path: Doubles


def turns(constants: Constants, stages: Doubles, lengths: Doubles, largest_tail: float) -> Turns:
    """T along N intervals: stages (6, L, M, N) and lengths (L, N) in limbs.

    Raises TooLong for intervals with too few nodes for it, or CannotRefine.
    """
    limbs, tables = constants.limbs, constants.tables
    nodes, n = stages.shape[2:]
    omega = stages[:3].sum(axis=1) * (0.5 * lengths.sum(axis=0))
    t = np.zeros((QUATERNION, nodes, n))
    t[0] = 1.0

    def turn() -> None:
        np.matmul(tables.integrals, spun(t, omega), out=t)
        t[0] += 1.0

    iterated(turn, t[:, -2:], _GUESS)
    end = tables.weights @ spun(t, omega)
    end[0] += 1.0
    split = limbs.split_doubles(t).swapaxes(0, 1).copy()
    ends = limbs.split_doubles(end).swapaxes(0, 1).copy()
    for count in range(constants.sweeps):
        r, r_end, tails = _defects(limbs, tables, split, ends, stages[:3], lengths)
        forced = spun(r, omega)
        delta = r_end + times(tables.weights @ times(forced, conjugate(t)), end)
        limbs.adjust(ends.swapaxes(0, 1), delta)
        size = float(np.abs(r).max())
        if count and size * _ENDS < constants.target:
            if (tails > largest_tail).any():  # told by the last sweep, which no guess disturbs
                raise TooLong(tails > largest_tail)
            whole = ends.transpose(2, 0, 1).tolist()
            return Turns([[limbs.integer(x) for x in row] for row in whole], t)
        rest = np.zeros_like(t)

        def correct(r: Doubles = r, rest: Doubles = rest) -> None:
            np.matmul(tables.integrals, spun(r + rest, omega), out=rest)

        iterated(correct, rest[:, -2:], _STAGES * size)
        limbs.adjust(split.swapaxes(0, 1), r + rest)
    raise CannotRefine("the attitude does not converge")


def _defects(
    limbs: Limbs, tables: Tables, t: Doubles, end: Doubles, omega: Doubles, lengths: Doubles
) -> tuple[Doubles, Doubles, Doubles]:
    """r at the nodes (4, M, N) and at the ends (4, N), and the last Legendre coefficients (N,)."""
    levels = tables.integrated(_field(limbs, t, omega, lengths))
    nodes = t.shape[2]
    r, r_end = -t[:, 0], -end[:, 0]
    r[0] += 1.0
    r_end[0] += 1.0
    for i, level in enumerate(levels):
        if i:
            r -= t[:, i]
            r_end -= end[:, i]
        r += 0.5 * level[:, :nodes]  # half of a double is exact
        r_end += 0.5 * level[:, nodes]
    return r, r_end, tables.last_coefficients(levels)


def _field(kind: Limbs, t: Doubles, omega: Doubles, lengths: Doubles) -> Doubles:
    """H T ⊗ w in limbs (4, L, M, N); |T|, |w| <= 1 and H |w| <= 4, as the kernels' field has it."""
    q, w = ([list(x) for x in part] for part in (t, omega))
    minus = [-x for x in q[1]], [-x for x in q[2]], [-x for x in q[3]]
    rates: list[Levels] = [
        product(minus[0], w[0]) + product(minus[1], w[1]) + product(minus[2], w[2]),
        product(q[0], w[0]) + product(q[2], w[2]) + product(minus[2], w[1]),
        product(q[0], w[1]) + product(q[3], w[0]) + product(minus[0], w[2]),
        product(q[0], w[2]) + product(q[1], w[1]) + product(minus[1], w[0]),
    ]
    length = list(lengths)
    shifted = kind.shifted(FIELD_SHIFT)
    return np.array([product(length, rate.limbs(kind)).limbs(shifted) for rate in rates])


def spun(q: Doubles, omega: Doubles) -> Doubles:
    """q ⊗ (0, w)."""
    p, y, r = omega
    found = np.empty_like(q)
    found[0] = -(q[1] * p) - q[2] * y - q[3] * r
    found[1] = q[0] * p + q[2] * r - q[3] * y
    found[2] = q[0] * y + q[3] * p - q[1] * r
    found[3] = q[0] * r + q[1] * y - q[2] * p
    return found


def times(a: GivenRow, b: GivenRow) -> Scalar:
    """The product of quaternions, of arrays of them, or of lists of integers."""
    found = quaternion_product(a, b)
    return np.array(found) if isinstance(a, np.ndarray) else found


def conjugate(q: Doubles) -> Doubles:
    """The inverse of a unit quaternion."""
    return np.concatenate([q[:1], -q[1:]])

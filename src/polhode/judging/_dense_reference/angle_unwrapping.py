"""psi, theta and phi at very many times, from quaternions there and the panels that told them.

With al = q0 + i q3 and bt = q1 + i q2

    psi = arg al + arg bt,    theta = 2 atan2(|bt|, |al|),    phi = arg al - arg bt.

The arguments are known from the closed form at one row of each stretch of time in which their
growth can be followed (:mod:`polhode.judging._dense_reference.winding`).  It is asked too for rows
that are too near a pole to be told so; where these are many, as of a motion that ends at a pole, it
is left to others whether to ask.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from polhode.judging._dense_reference.taylor_panels import Booleans, NotSo
from polhode.judging._dense_reference.winding import Followed
from polhode.numbers import exact
from polhode.numbers.double_double import Pairs, arctan2, hypot, of_exact, pairs
from polhode.numbers.rows import Doubles

SPARE = 6  # digits that the quaternions have beyond those asked of angles
_NEAR = 10.0**-SPARE  # of 0: there an angle has so many digits less
_FEW = 20  # one row in so many, at most, is asked of the closed form
_OFF = 1e-3  # half turns: more than arguments are off that were followed rightly


class Angles(NamedTuple):
    """psi, theta, phi of rows: not numbers where the closed form has none, or where ``untold``."""

    columns: list[Pairs] | None
    untold: list[int]  # rows of which only theta is known


def angles(
    q: Sequence[Pairs], followed: Followed, before: Doubles, ask: Callable[[list[int]], list[Any]]
) -> Angles:
    """The angles of rows.

    ``q``: the rows' quaternions; ``before``: the growth of arg al and arg bt over periods that were
    taken away from the times, shape (2, rows); ``ask``: the closed form's angles of some rows.
    Raises NotSo where stretches of time are too many, or where angles do not fit each other.
    """
    sizes = hypot(q[0], q[3]), hypot(q[1], q[2])
    nearest = np.minimum(sizes[0].hi, sizes[1].hi)
    alone = (followed.stretch < 0) | ~(nearest > _NEAR)
    order = np.lexsort((-nearest, np.where(alone, -1, followed.stretch)))
    there, first = np.unique(np.where(alone, -1, followed.stretch)[order], return_index=True)
    chosen = order[first[there >= 0]]
    most = len(nearest) / _FEW
    if len(chosen) > most:
        raise NotSo
    untold = np.nonzero(alone)[0].tolist()
    near = untold if len(chosen) + len(untold) <= most else []
    asked = [*chosen.tolist(), *near]
    rows = dict(zip(asked, ask(asked), strict=True))

    begun = np.zeros((2, int(followed.stretch.max(initial=0)) + 1))
    for k in chosen.tolist():
        psi, _, phi = rows[k]
        args = float((psi + phi) / 2), float((psi - phi) / 2)
        begun[:, followed.stretch[k]] = args - followed.grown[:, k] - before[:, k]
    about = begun[:, followed.stretch] + followed.grown + before
    with np.errstate(all="ignore"):  # at a pole itself one of them is no number
        one = _near(arctan2(q[3], q[0]), about[0], alone)
        other = _near(arctan2(q[2], q[1]), about[1], alone)
        found = [one + other, 2 * arctan2(sizes[1], sizes[0]), one - other]
    for k in near:
        for column, x in zip(found, rows[k], strict=True):
            value = Pairs(math.nan) if x is None else pairs(x)
            column.hi[k], column.lo[k] = value.hi, value.lo
    if not near:
        found[0].hi[alone] = found[2].hi[alone] = math.nan
    return Angles(found, [] if near else untold)


def _near(arg: Pairs, about: Doubles, alone: Booleans) -> Pairs:
    """Arguments up to halves of a turn, as near as can be to what they are about.

    q and -q are one attitude, so that both arguments may be off by pi.
    """
    halves = (about - arg.hi) / math.pi
    whole: Doubles = np.rint(halves)
    if np.any((np.abs(halves - whole) > _OFF) & ~alone):
        raise NotSo
    return arg + Pairs(whole) * of_exact(exact.pi())

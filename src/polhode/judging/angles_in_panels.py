"""psi, theta and phi at very many times, from quaternions there and the panels that told them.

With al = q0 + i q3 and bt = q1 + i q2

    psi = arg al + arg bt,    theta = 2 atan2(|bt|, |al|),    phi = arg al - arg bt.

The arguments are followed along points of the panels.  Between two points a step h apart al and bt
stay within max |z''| h^2/8 of their chord, where |z''| is at most |w'|/2 + |w|^2/4: if 0 is twice as
far from it, the argument grows by the principal difference, up to any time between them too.  Points
are laid closer where that cannot be said; where they would have to be closer still, as at a pole, a
new stretch begins.  In each stretch the closed form tells the angles of one row; it is asked too
for rows that are too near a pole to be told so.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from polhode.closed_forms.attitude.quaternion import product
from polhode.judging.carried import Attitudes
from polhode.judging.panels import Booleans, NotSo, Numbers, Panels
from polhode.judging.series import Doubles
from polhode.numbers import exact
from polhode.numbers.pairs import Pairs, arctan2, hypot, of_exact, pairs

_STEPS = (32, 512, 4096)  # from a panel's begin to its end
_AT_ONCE = 1 << 19  # points
SPARE = 6  # digits that the quaternions have beyond those asked of angles
_NEAR = 10.0**-SPARE  # of 0: there an angle has so many digits less
_FEW = 20  # one row in so many, at most, is asked of the closed form
_DOUBT = 1e-12  # more than the error of a double
_OFF = 1e-3  # half turns: more than arguments are off that were followed rightly

Complexes: TypeAlias = npt.NDArray[np.complex128]


class Followed(NamedTuple):
    """How far arg al and arg bt of rows grew since their stretch began.

    ``grown``: shape (2, rows); ``stretch``: its number, -1 for a row in no stretch.
    """

    grown: Doubles
    stretch: Numbers


def angles(
    q: Sequence[Pairs], followed: Followed, before: Doubles, ask: Callable[[list[int]], list[Any]]
) -> list[Pairs]:
    """psi, theta, phi of rows; not numbers where the closed form has none.

    ``q``: the rows' quaternions; ``before``: the growth of arg al and arg bt over periods that were
    taken away from the times, shape (2, rows); ``ask``: the closed form's angles of some rows.
    Raises NotSo where too many rows are to be asked for, or where angles do not fit each other.
    """
    sizes = hypot(q[0], q[3]), hypot(q[1], q[2])
    nearest = np.minimum(sizes[0].hi, sizes[1].hi)
    alone = (followed.stretch < 0) | ~(nearest > _NEAR)
    order = np.lexsort((-nearest, np.where(alone, -1, followed.stretch)))
    there, first = np.unique(np.where(alone, -1, followed.stretch)[order], return_index=True)
    chosen = order[first[there >= 0]]
    asked = [*chosen.tolist(), *np.nonzero(alone)[0].tolist()]
    if len(asked) > len(nearest) / _FEW:
        raise NotSo
    rows = dict(zip(asked, ask(asked), strict=True))

    begun = np.zeros((2, int(followed.stretch.max()) + 1))
    for k in chosen.tolist():
        psi, _, phi = rows[k]
        args = float((psi + phi) / 2), float((psi - phi) / 2)
        begun[:, followed.stretch[k]] = args - followed.grown[:, k] - before[:, k]
    about = begun[:, followed.stretch] + followed.grown + before
    one = _near(arctan2(q[3], q[0]), about[0], alone)
    other = _near(arctan2(q[2], q[1]), about[1], alone)
    found = [one + other, 2 * arctan2(sizes[1], sizes[0]), one - other]
    for k in np.nonzero(alone)[0].tolist():
        for column, x in zip(found, rows[k], strict=True):
            value = Pairs(math.nan) if x is None else pairs(x)
            column.hi[k], column.lo[k] = value.hi, value.lo
    return found


def _near(arg: Pairs, about: Doubles, alone: Booleans) -> Pairs:
    """Arguments up to halves of a turn, as near as can be to what they are about.

    q and -q are one attitude, so that both arguments may be off by pi.
    """
    halves = (about - arg.hi) / math.pi
    whole: Doubles = np.rint(halves)
    if np.any((np.abs(halves - whole) > _OFF) & ~alone):
        raise NotSo
    return arg + Pairs(whole) * of_exact(exact.pi())


def follow(panels: Panels, attitudes: Attitudes, q: Sequence[Pairs], here: Doubles) -> Followed:
    """The arguments of rows, given their quaternions and times, along the panels."""
    low, high = panels.used(here)
    parts: dict[int, tuple[Complexes, Booleans]] = {}
    left = np.arange(len(low))
    for steps in _STEPS:
        for some in np.array_split(left, 1 + len(left) * steps // _AT_ONCE):
            z, certain = _laid(panels, attitudes, some, low[some], high[some], steps)
            for k, i in enumerate(some.tolist()):
                parts[i] = z[:, k], certain[k]
        left = np.array([i for i in left.tolist() if not parts[i][1].all()], dtype=np.int64)
    laid = [parts[i] for i in range(len(low))]
    _, touch = panels.joints
    z = np.concatenate([part for part, _ in laid], axis=1)
    links = [x for part, on in zip(laid, [*touch, False], strict=True) for x in (part[1], [on])]
    certain = np.concatenate(links).astype(bool)[:-1]
    certain &= (np.maximum(np.abs(z[:, 1:]), np.abs(z[:, :-1])) > _DOUBT).all(axis=0)
    grown = np.zeros(z.shape)
    grown[:, 1:] = np.cumsum(np.where(certain, np.angle(z[:, 1:] * z[:, :-1].conj()), 0.0), axis=1)
    stretch = np.concatenate([[0], np.cumsum(~certain)])

    of = panels.of(here)
    steps_of = np.array([len(on) for _, on in laid])
    start = np.concatenate([[0], np.cumsum(steps_of + 1)[:-1]])
    with np.errstate(all="ignore"):
        part = (here - low[of]) / (high - low)[of] * steps_of[of]
    at = start[of] + np.clip(np.nan_to_num(part), 0, steps_of[of] - 1).astype(np.int64)
    rows = np.array([q[0].hi + 1j * q[3].hi, q[1].hi + 1j * q[2].hi])
    found = []
    for own, points, args in zip(rows, z, grown, strict=True):
        ref = np.where(np.abs(points[at]) > np.abs(points[at + 1]), at, at + 1)
        found.append(args[ref] + np.angle(own * points[ref].conj()))
    return Followed(np.array(found), np.where(certain[at], stretch[at], -1))


def _laid(
    panels: Panels, attitudes: Attitudes, some: Numbers, low: Doubles, high: Doubles, steps: int
) -> tuple[Complexes, Booleans]:
    """al and bt at points of panels, shape (2, panels, points), and which steps are certain."""
    times = low[:, None] + (high - low)[:, None] * (np.arange(steps + 1) / steps)
    turn, speed, change = panels.roughly(some, times)
    c = attitudes.begun[:, some].hi[:, :, None]
    q0, q1, q2, q3 = product((c[0], c[1], c[2], c[3]), (turn[0], turn[1], turn[2], turn[3]))
    z = np.array([q0 + 1j * q3, q1 + 1j * q2])
    step = (high - low) / steps
    away = (change / 2 + speed**2 / 4) * step**2 / 4 + _DOUBT
    return z, (_from_chords(z) > away[:, None]).all(axis=0)


def _from_chords(z: Complexes) -> Doubles:
    """The distance of 0 from the chord between each point and the next."""
    p, way = z[..., :-1], np.diff(z)
    square = np.abs(way) ** 2
    along = np.clip(-(p * way.conj()).real / np.where(square > 0, square, 1), 0, 1)
    found: Doubles = np.abs(p + along * way)
    return found

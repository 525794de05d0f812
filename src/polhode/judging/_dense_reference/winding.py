"""How arg al and arg bt of a moving body grow, al = q0 + i q3 and bt = q1 + i q2.

They are followed along points of panels.  Between two points a step h apart al and bt stay within
max |z''| h^2/8 of their chord, and |z''| is at most |w'|/2 + |w|^2/4: if 0 is twice as far from it,
the argument grows by the principal difference, up to any time between them too.  Points are laid
closer where that cannot be said.  Where they would have to be closer still, as near a pole, 0 is
passed at a distance that Newton's method tells in pairs of doubles, and so the side.  Where that is
no distance, as at a pole itself, a new stretch of time begins.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from polhode.closed_forms.functions.quaternion import product
from polhode.judging._dense_reference.attitude_propagation import Attitudes
from polhode.judging._dense_reference.taylor_panels import Booleans, Numbers, Panels
from polhode.numbers.double_double import Pairs
from polhode.numbers.rows import Doubles

_STEPS = (32, 512, 4096)  # from a panel's begin to its end
_AT_ONCE = 1 << 19  # points
_DOUBT = 1e-12  # more than the error of a double
_MOST = 4  # steps in which 0 is passed
_NEWTON = 4  # steps of Newton's method, from a distance of a thousandth
_OPPOSITE = 1e-3  # radians by which a growth of pi is not taken for one
_NONE = 1e-21  # from 0, or not to be told from it: more than errors of q

Complexes: TypeAlias = npt.NDArray[np.complex128]


class Followed(NamedTuple):
    """How far arg al and arg bt of rows grew since their stretch of time began.

    ``grown``: shape (2, rows); ``stretch``: its number, -1 for a row in no stretch.
    """

    grown: Doubles
    stretch: Numbers


@dataclass(frozen=True)
class _Laid:
    """Points of panels one after the other: where they are, al and bt, and which steps are certain.

    ``first``, ``steps``: of each panel, its first point and how many steps it has.
    """

    times: Doubles
    z: Complexes  # shape (2, points)
    certain: Booleans  # one fewer
    first: Numbers
    steps: Numbers


def follow(panels: Panels, attitudes: Attitudes, q: Sequence[Pairs], here: Doubles) -> Followed:
    """The arguments of rows, given their quaternions and times, along the panels."""
    low, high = panels.used(here)
    laid = _laid_out(panels, attitudes, low, high)
    step: Doubles = np.angle(laid.z[:, 1:] * laid.z[:, :-1].conj())
    step[:, ~laid.certain] = 0.0
    known = laid.certain.copy()
    for begin, end, over in _passages(panels, attitudes, laid):
        known[begin:end], step[:, begin] = True, over
    grown = np.concatenate([np.zeros((2, 1)), np.cumsum(step, axis=1)], axis=1)
    stretch = np.concatenate([[0], np.cumsum(~known)])

    of = panels.of(here)
    with np.errstate(all="ignore"):
        part = (here - low[of]) / (high - low)[of] * laid.steps[of]
    at = laid.first[of] + np.clip(np.nan_to_num(part), 0, laid.steps[of] - 1).astype(np.int64)
    rows = np.array([q[0].hi + 1j * q[3].hi, q[1].hi + 1j * q[2].hi])
    found = []
    for own, points, args in zip(rows, laid.z, grown, strict=True):
        ref = np.where(np.abs(points[at]) > np.abs(points[at + 1]), at, at + 1)
        found.append(args[ref] + np.angle(own * points[ref].conj()))
    return Followed(np.array(found), np.where(laid.certain[at], stretch[at], -1))


def _laid_out(panels: Panels, attitudes: Attitudes, low: Doubles, high: Doubles) -> _Laid:
    """Points between where panels are used, as close as it takes."""
    parts: dict[int, tuple[Doubles, Complexes, Booleans]] = {}
    left = np.arange(len(low))
    for steps in _STEPS:
        for some in np.array_split(left, 1 + len(left) * steps // _AT_ONCE):
            times, z, certain = _laid(panels, attitudes, some, low[some], high[some], steps)
            for k, i in enumerate(some.tolist()):
                parts[i] = times[k], z[:, k], certain[k]
        left = np.array([i for i in left.tolist() if not parts[i][2].all()], dtype=np.int64)
    _, touch = panels.joints
    found = [parts[i] for i in range(len(low))]
    z = np.concatenate([z for _, z, _ in found], axis=1)
    links = [x for (*_, on), to in zip(found, [*touch, False], strict=True) for x in (on, [to])]
    certain = np.concatenate(links).astype(bool)[:-1]
    steps_of = np.array([len(on) for *_, on in found])
    first = np.concatenate([[0], np.cumsum(steps_of + 1)[:-1]])
    return _Laid(np.concatenate([t for t, *_ in found]), z, certain, first, steps_of)


def _laid(
    panels: Panels, attitudes: Attitudes, some: Numbers, low: Doubles, high: Doubles, steps: int
) -> tuple[Doubles, Complexes, Booleans]:
    """Points of panels, al and bt there, shape (2, panels, points), and which steps are certain."""
    times = low[:, None] + (high - low)[:, None] * (np.arange(steps + 1) / steps)
    turn, speed, change = panels.roughly(some, times)
    c = attitudes.begun[:, some].hi[:, :, None]
    q0, q1, q2, q3 = product((c[0], c[1], c[2], c[3]), (turn[0], turn[1], turn[2], turn[3]))
    z = np.array([q0 + 1j * q3, q1 + 1j * q2])
    step = (high - low) / steps
    away = (change / 2 + speed**2 / 4) * step**2 / 4 + _DOUBT
    certain: Booleans = np.all(_from_chords(z) > away[:, None], axis=0)
    return times, z, certain


def _from_chords(z: Complexes) -> Doubles:
    """The distance of 0 from the chord between each point and the next."""
    p, way = z[..., :-1], np.diff(z)
    square = np.abs(way) ** 2
    along = np.clip(-(p * way.conj()).real / np.where(square > 0, square, 1), 0, 1)
    found: Doubles = np.abs(p + along * way)
    return found


def _passages(
    panels: Panels, attitudes: Attitudes, laid: _Laid
) -> list[tuple[int, int, tuple[float, float]]]:
    """Where 0 is passed in a few steps, from which point to which, and the growth of both."""
    doubtful = np.concatenate([[False], ~laid.certain, [False]])
    begins = np.nonzero(doubtful[1:] & ~doubtful[:-1])[0]
    ends = np.nonzero(~doubtful[1:] & doubtful[:-1])[0]
    gaps = np.zeros(len(laid.times), dtype=np.int64)  # panels before a point that do not touch
    gaps[laid.first[1:]] = ~panels.joints[1]
    gaps = np.cumsum(gaps)
    short = (ends - begins <= _MOST) & (gaps[begins] == gaps[ends])
    begins, ends = begins[short], ends[short]
    p, end = laid.z[:, begins], laid.z[:, ends]
    nearer = np.argmin(np.minimum(np.abs(p), np.abs(end)), axis=0)
    start = (laid.times[begins] + laid.times[ends]) / 2
    distance, when = _nearest(panels, attitudes, start, nearer)
    step = np.angle(end * p.conj())
    found = []
    for k in range(len(begins)):
        growth, which = step[:, k].copy(), int(nearer[k])
        if not laid.times[begins[k]] <= when[k] <= laid.times[ends[k]]:
            continue
        if math.pi - abs(growth[which]) < _OPPOSITE:
            if abs(distance[k]) < _NONE:
                continue
            growth[which] = -math.copysign(growth[which], distance[k])
        found.append((int(begins[k]), int(ends[k]), (float(growth[0]), float(growth[1]))))
    return found


def _nearest(
    panels: Panels, attitudes: Attitudes, times: Doubles, which: Numbers
) -> tuple[Doubles, Doubles]:
    """How far to the left of its way 0 is passed by al (0) or bt (1), and when.

    ``times``: near that.
    """
    at = Pairs(times, np.zeros_like(times))
    for _ in range(_NEWTON):
        of = panels.of(at.hi)
        summed = panels.summed(of, at)
        q = attitudes.at(of, summed)
        rates = _rates(q, summed[:3])
        x, y, dx, dy = (
            Pairs(np.where(which == 0, al.hi, bt.hi), np.where(which == 0, al.lo, bt.lo))
            for al, bt in ((q[0], q[1]), (q[3], q[2]), (rates[0], rates[1]), (rates[3], rates[2]))
        )
        square = dx * dx + dy * dy
        with np.errstate(all="ignore"):
            at, off = at - (x * dx + y * dy) / square, (y * dx - x * dy).hi / np.sqrt(square.hi)
    return off, at.hi


def _rates(q: Pairs, w: Pairs) -> list[Pairs]:
    """q' = ½ q ⊗ (0, w)."""
    zero = Pairs(np.zeros_like(w.hi[0]), np.zeros_like(w.hi[0]))
    return [0.5 * x for x in product((q[0], q[1], q[2], q[3]), (zero, w[0], w[1], w[2]))]

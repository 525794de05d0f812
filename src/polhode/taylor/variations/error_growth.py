"""How much a motion multiplies errors on the way: one tangent, by the variational equations.

    G(t) = max over s <= t of |v(t)| / |v(s)|,    v' = J(x) v,    lost(t) = log10(G(t) sqrt(n(t)))

v along no special direction, w measured by the largest |w|, gamma as it is; n the Taylor steps so
far, each of which rounds the state once.  A run whose numbers hold so many digits is expected to
have lost so many of them at t.  Components that the equations keep at exactly zero take no
rounding, and none is given to them here.

Where a run is put back, once in m steps, on as many integrals as fix its torus, its frequencies
walk at random for m steps at most.  What each walk shifts is another number at random, so that

    lost(t) = log10 max(G, sqrt(n), G m/sqrt(n)),    n > m,

the first for the rounded inputs, which no projection puts right.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from polhode.equations.equilibrium import at_rest
from polhode.motion.frame import Frame
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Exact
from polhode.scenes.scene import Scene
from polhode.taylor.corrections.integral_projection import kept_at_zero
from polhode.taylor.integrator.system import principal_system
from polhode.taylor.variations.equations import Variations
from polhode.taylor.variations.reference_trajectory import Leader, pendulum, six

MOST_STEPS = 50_000  # of 4 µs
STRIDE = 8.0  # of the scene's own unit of time between two looks where the motion is led
MOST_LOOKS, LONGEST = 64, 256.0  # otherwise: about so many looks, none so far from the last
LED_FROM = 10.0  # log10 of G up to which a motion in double is the scene's to six digits
TRUSTED = 14.0  # log10 of G beyond which a motion in double says nothing of the scene's
_LATEST = 2.0**900  # of the scene's own unit of time; whatever a law says of later times
_EXPONENTIAL = 6.0  # ln of G in the second half of the time: no power of time grows so much
_DIRECTION = (0.6, -0.5, 0.4, 0.3, 0.2, -0.3)  # along no axis


class Growth(NamedTuple):
    """Decimal digits lost, at moments from 0 on; between two of them log10 is linear in time.

    ``times``: in the scene's own unit 2**unit, |t| increasing.  ``lost``: see the module; at least
    0.  ``followed``: the last time to which the tangent was followed; later values continue its
    law.  ``steps``: Taylor steps in double to the end, about.
    """

    times: tuple[float, ...]
    lost: tuple[float, ...]
    followed: float
    steps: int
    unit: int

    def at(self, t: Exact) -> float:
        """The digits lost at a time."""
        here = to_double(abs(t) / Fraction(2) ** self.unit)
        return float(np.interp(here, np.abs(self.times), self.lost))

    def reaches(self, lost: float) -> float | None:
        """The first time at which so many digits are lost; None where they never are."""
        found = self._reaches(lost)
        return None if found is None else to_double(Fraction(found) * Fraction(2) ** self.unit)

    def _reaches(self, lost: float) -> float | None:
        before, height = 0.0, 0.0
        for t, here in zip(self.times, self.lost, strict=True):
            if here >= lost:
                part = (lost - height) / (here - height) if here > height else 1.0
                return before + min(1.0, max(0.0, part)) * (t - before)
            before, height = t, here
        return None


def growth(
    scene: Scene,
    limit: float = math.inf,
    max_steps: int = MOST_STEPS,
    led: bool = False,
    trusted: float = TRUSTED,
    every: int = 0,
) -> Growth:
    """The digits lost from 0 to the scene's end, followed until ``limit`` of them are.

    ``max_steps``: of the tangent; beyond them its law is continued: exponential where it was so in
    the second half of the time, else in proportion to time.  ``led``: whether an integration of
    wider type, which may cost as much as the run itself, keeps the motion the scene's own once G
    has passed 1e10.  Unled, the law is continued from where G passes 10**trusted; up to there, or
    everywhere with inf, the tangent may be that of a neighbour's motion.  ``every``: the steps
    between two projections of an integrable top onto all its integrals, 0 without.
    """
    frame = Frame.of(scene)
    inside, principal = frame.inside(scene), scene.form == "principal"
    end = max(-_LATEST, min(_LATEST, to_double(frame.time(scene.end))))
    if end == 0 or (principal and at_rest(inside).state):  # nothing is rounded on the way
        return Growth((0.0,), (0.0,), end, 0, frame.exponent)
    plain = principal_system(inside)
    start = six(plain.start)
    tangent = np.array(_DIRECTION)
    tangent[:3] *= float(np.linalg.norm(start[:3])) or 1.0
    if principal:
        tangent[list(kept_at_zero(inside))] = 0
    tangent[len(plain.start) :] = 0
    flow = Variations(plain.coefficients, start, tangent[:, None])
    leader = Leader(plain) if led else None
    looks = [_look(flow)]
    for t in _moments(end, led):
        arrived = flow.to(t, max_steps - flow.steps)
        if not flow.finite:
            break
        flow.rescale()
        looks.append(_look(flow))
        passed = _grown(looks, inside)[-1]
        if not arrived or passed > limit * math.log(10):
            break
        if leader is None and passed > trusted * math.log(10):
            break
        if leader is not None and passed > LED_FROM * math.log(10):
            flow.state = leader.at(t, passed / math.log(10))
    flow.release()
    return _continued(looks, _grown(looks, inside), end, frame.exponent, every)


class _Look(NamedTuple):
    """One moment, in the scene's own unit of time."""

    time: float
    steps: int
    speed: float  # |w|
    sizes: tuple[float, float]  # ln |v|: its part of w, its part of gamma


def _look(flow: Variations) -> _Look:
    v, more = flow.tangents[:, 0], flow.exponent * math.log(2)
    sizes = [_ln(float(np.linalg.norm(part))) + more for part in (v[:3], v[3:])]
    return _Look(flow.time, flow.steps, float(np.linalg.norm(flow.state[:3])), (sizes[0], sizes[1]))


def _grown(looks: list[_Look], scene: Scene) -> list[float]:
    """ln of G at each look."""
    scale = _ln(max(look.speed for look in looks) or pendulum(scene))
    least, found = math.inf, []
    for look in looks:
        size = max(look.sizes[0] - scale, look.sizes[1])
        least = min(least, size)
        found.append(size - least)
    return found


def _continued(looks: list[_Look], grown: list[float], end: float, unit: int, every: int) -> Growth:
    """Growth from what was seen, its law continued to the end."""
    times, last = [look.time for look in looks], looks[-1].time
    added = [0.5 * math.log(max(1, look.steps)) for look in looks]  # ln of sqrt(n)
    whole = [*grown]
    if abs(last) < abs(end):
        half = float(np.interp(abs(last) / 2, np.abs(times), grown))
        ahead = np.geomspace(abs(last) or 1e-3 * abs(end), abs(end), 16)[1:]
        per_time = (grown[-1] - half) / (abs(last) / 2 or 1.0)
        exponential = grown[-1] - half > _EXPONENTIAL
        for t in ahead:
            ratio = float(t) / (abs(last) or float(t))
            more = per_time * (float(t) - abs(last)) if exponential else math.log(ratio)
            times.append(math.copysign(float(t), end))
            whole.append(grown[-1] + more)
            added.append(added[len(looks) - 1] + 0.5 * math.log(ratio))
    lost = [_lost(g, n, every) / math.log(10) for g, n in zip(whole, added, strict=True)]
    steps = math.ceil(looks[-1].steps * abs(end / last)) if last else looks[-1].steps
    return Growth(tuple(times), tuple(lost), last, steps, unit)


def _lost(grown: float, root: float, every: int) -> float:
    """ln of what a rounding has become: by ln of G and of sqrt(n), see the module."""
    if every == 0 or 2 * root <= math.log(every):
        return grown + root
    return max(grown, root, grown + math.log(every) - root)


def _moments(end: float, led: bool) -> Iterator[float]:
    """Moments from 0 to the end, without 0."""
    stride = STRIDE if led else min(LONGEST, max(STRIDE, abs(end) / MOST_LOOKS))
    count = math.ceil(abs(end) / stride)
    for k in range(1, count):
        yield math.copysign(k * stride, end)
    yield end


def _ln(x: float) -> float:
    return math.log(x) if x > 0 else -math.inf

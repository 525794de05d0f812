"""How many digits a crossing has: what the motion makes of a rounding on the way to it.

One tangent u along each orbit, across the flow and the gradients of h, f and |gamma|^2, on whose
values the orbit is kept:

    G(t) = max over s <= t' <= t of |u(t')| / |u(s)|,    digits(t) = -log10(eps G(t))

from 0 to those of a double: what one rounding on the way is multiplied by.  Where the orbit grazes
the section, an error across it moves the crossing along the orbit by |x'| |grad z|/|z'| of itself,
z the section's function; G is multiplied by what of that exceeds STRAIGHT.  A run makes many, and
the tangent has one direction of two: found were from two digits fewer to one more, of the state at
the crossing.  On a chaotic orbit G grows exponentially, and from some crossing on no digit is left:
later ones are those of a neighbour, right for pictures and statistics and not this orbit's.  w
counts in radians of the inner unit of time, gamma as it is; G is taken at looks, each crossing's
at the next one.
"""

from __future__ import annotations

import math

import numpy as np

from polhode.dynamics.sections.initial_tangents import tangents_of
from polhode.equations.forms import principal
from polhode.equations.section_functions import SectionZero
from polhode.motion.frame import Frame
from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import DOUBLE
from polhode.numbers.rows import Doubles, Integers
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene

EPS = 2.0**-52
LOOK = 8.0  # units of the inner time between two looks at the tangent
LANES = 64  # orbits of a job, in the order of their lengths
STRAIGHT = 10.0  # so much more does the scatter of errors hide
LOST = math.log(1 / EPS)  # of ln G


def digits(
    scene: Scene, starts: Doubles, times: Doubles, slants: Doubles, workers: int | None = None
) -> Doubles:
    """Correct digits to be expected of each crossing, nan where there is none: (n, m).

    ``starts`` (n, 6): states in principal axes and the run's unit of time; ``times`` (n, m): of the
    crossings in that unit, nan past an orbit's last one.  ``slants`` (n, m): see :func:`slant`.
    ``workers``: threads.
    """
    from polhode.common.processes import run_jobs
    from polhode.taylor import variations

    digits_left: Doubles = np.full(times.shape, np.nan)
    is_crossing = np.isfinite(times)
    grazing = np.log(np.maximum(slants / STRAIGHT, 1.0))
    last = np.where(is_crossing, times, 0.0).max(axis=1, initial=0.0)
    orbits = np.argsort(last, kind="stable")
    orbits = orbits[last[orbits] > 0]
    if len(orbits) == 0:
        return digits_left
    frame = Frame.of(scene)
    moments, torque = _numbers_of(frame.inside(scene).body)
    slower = _slowness(starts, torque, moments)
    starts, times = starts * np.repeat([2.0**slower, 1.0], 3), times * 2.0**-slower
    last *= 2.0**-slower
    body = frame.slower(slower).inside(scene).body
    moments, torque = _numbers_of(body)
    k = {n: to_double(x) for n, x in principal.coefficients(body).items()}
    groups = [orbits[first : first + LANES] for first in range(0, len(orbits), LANES)]
    jobs, spans = [], []
    for group in groups:
        # no further than the last crossing: on a high level a whole look holds millions of turns
        span = min(LOOK, float(last[group].max()))
        spans.append(span)
        many, looks = (len(group), 1), math.ceil(last[group].max() / span)
        bodies = np.tile(moments, many), np.tile(torque, many)
        first = tangents_of(starts[group], *bodies, alike=True)
        coefficients = np.tile(np.array([*k.values()]), many)
        end, early = looks * span, tuple(range(2, looks, 2))
        jobs.append(
            variations.TangentJob(
                tuple(k), coefficients, starts[group], first, end, looks, None, early, LOST
            )
        )
    sizes = [len(group) for group in groups]
    finished = run_jobs(variations.solve, jobs, sizes, workers)
    if finished.interrupted:
        raise KeyboardInterrupt
    for group, span, result in zip(groups, spans, finished.done, strict=True):
        least = np.minimum.accumulate(np.where(np.isfinite(result.sizes), result.sizes, np.inf), 1)
        grown = np.where(np.isfinite(result.sizes), result.sizes - least, LOST)
        grown = np.maximum.accumulate(grown, axis=1)
        looks = np.ceil(np.where(is_crossing[group], times[group], 0.0) / span).astype(int)
        at = np.take_along_axis(grown, looks, axis=1)
        right = np.clip((LOST - at - grazing[group]) / math.log(10), 0.0, DOUBLE.most_digits)
        digits_left[group] = np.where(is_crossing[group], right, np.nan)
    return digits_left


def slant(scene: Scene, zero: SectionZero, states: Doubles, fastest: float) -> Doubles:
    """|x'| |grad z|/|z'| of states (n, m, 6) in principal axes and the run's unit of time.

    ``fastest``: what w is measured by.
    """
    from polhode.taylor.projection import ARRAYS, TINY

    body = Frame.of(scene).inside(scene).body
    k = {n: to_double(x) for n, x in principal.coefficients(body).items()}
    scales = np.array([fastest or 1.0] * 3 + [1.0] * 3)
    x = np.moveaxis(states, -1, 0)
    steps = TINY * 1j * np.diag(scales)[:, :, None, None]
    across = slope = speed = 0.0 * x[0]
    with np.errstate(all="ignore"):
        rates = principal.field([*x], k, ARRAYS)
        for step, rate, scale in zip(steps, rates, scales, strict=True):
            gradient = np.imag(zero.value([*(x + step)], ARRAYS)) / TINY
            across = across + gradient**2
            slope = slope + gradient * rate / scale
            speed = speed + (rate / scale) ** 2
        slants: Doubles = np.sqrt(across * speed) / np.abs(slope)
    return slants


def _numbers_of(body: Body) -> tuple[Doubles, Doubles]:
    """Moments and Mg r0 of a body inside its frame."""
    moments, torque = (np.array([to_double(x) for x in v]) for v in (body.moments, body.torque))
    return moments, torque


def _slowness(starts: Doubles, torque: Doubles, moments: Doubles) -> int:
    """The power of two by which a level is slower than the unit of time, if by far, else 0.

    The unit is the scene's, which may be on another level.
    """
    spin = float(np.linalg.norm(starts[:, :3], axis=1).max())
    speed = max(spin, math.sqrt(float(np.linalg.norm(torque)) / float(moments.min())))
    return max(0, -4 - math.floor(math.log2(speed)))


def none_left_from(digits: Doubles) -> Integers:
    """The number, from 1 on, of the first crossing with less than one digit; 0: all have one."""
    gone = digits < 1
    first: Integers = np.where(gone.any(axis=1), gone.argmax(axis=1) + 1, 0)
    return first

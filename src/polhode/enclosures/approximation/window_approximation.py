"""An approximation of a window of steps: heyoka's run, a grid of times, Taylor coefficients.

Not trusted: whatever it gives is bounded afterwards.  The steps are at most theta times the radius
of convergence, theta**p = 2**-(P + 8), and short enough for exp(int |A|) to stay small.  Where the
latter decides, fewer terms than p are enough.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from polhode.common.interrupts import NONE, Deadline
from polhode.enclosures.fixed_point_problem import CLOCK, Motion, Problem
from polhode.enclosures.step_bound import jacobian
from polhode.enclosures.zonotope import State
from polhode.equations.terms import LAYERS, LEFT, RIGHT, layered
from polhode.motion.frame import Frame
from polhode.numbers.conversion import to_double
from polhode.taylor import variations
from polhode.taylor.system import principal_system
from polhode.taylor.variations import Variations

MOST_TURN = 5.0  # h |f'(x)| of a step: the majorant alpha is then about twice that
_COARSE, _LESS = 64, 0.35  # less below this noise level, where exp(2 alpha) soon is too much
_LEAST_DEGREE = 40
_DOUBLE = 84  # up to this noise level one correction mends a run in double
_LOOKS = 256
_MOST_STEPS = 3_000_000


class Window(NamedTuple):
    """Times of the grid, W + 1 integers times 2**-CLOCK, and coefficients, (W, p + 1, 6)."""

    times: tuple[int, ...]
    series: Any


def degree(noise: int) -> int:
    """The largest degree of the polynomials for a noise level."""
    return max(_LEAST_DEGREE, math.ceil((0.6 if noise <= 150 else 0.5) * noise))


def window(
    problem: Problem, state: State, end: int, steps: int, pace: float, turn: float = MOST_TURN
) -> Window | None:
    """Up to so many steps from a state towards the time ``end``; None where heyoka fails.

    ``pace``: the length of a step that is expected, to know how far to run.  ``turn``: h |f'(x)| of
    a step, at most.
    """
    wide = [np.longdouble(x >> max(0, problem.fine - 80)) for x in state.centre]
    start = list(np.ldexp(np.array(wide), -min(problem.fine, 80)))
    left = math.ldexp(end - state.time, -CLOCK)
    long = problem.noise > _DOUBLE
    run = variations.path(start, problem.factors, min(1.05 * pace * steps + 1e-3, left), long)
    if run is None:
        return None
    times, terms = _grid(problem, run, state.time, end, steps, turn)
    offsets = np.ldexp(np.array(times) - state.time, -CLOCK).astype(float)
    states = run.at(offsets[:-1])
    if not np.all(np.isfinite(states)):
        return None
    return Window(tuple(times), _series(problem, states, np.diff(offsets), terms))


def _grid(
    problem: Problem,
    run: variations.Path,
    begin: int,
    end: int,
    steps: int,
    turn: float,
) -> tuple[list[int], int]:
    """The times of the steps, as far as heyoka's run goes, and the degree that they need."""
    p, bits = degree(problem.noise), problem.noise + 8
    theta = 2.0 ** (-bits / p)
    speeds = _speeds(problem, run.at(run.ends))
    fastest = np.maximum(speeds[:-1], speeds[1:])
    most = turn * (_LESS if problem.noise < _COARSE else 1.0)
    longest = np.minimum(theta * run.convergence, most / np.maximum(fastest, 1e-300))
    ticks = np.maximum(1, np.floor(np.ldexp(np.minimum(longest, 2.0**15), CLOCK))).astype(int)
    ends = run.ends
    reach = begin + math.floor(math.ldexp(float(ends[-1]), CLOCK))
    times, k = [begin], 0
    while len(times) <= steps and times[-1] < end:
        now = math.ldexp(times[-1] - begin, -CLOCK)
        while k + 1 < len(ticks) and ends[k + 1] <= now:
            k += 1
        ahead = times[-1] + int(ticks[k])
        if ahead > reach and len(times) > 1 and reach < end:
            break
        times.append(min(ahead, end))
    widest = float(np.max(np.ldexp(ticks.astype(float), -CLOCK) / run.convergence))
    needed = math.ceil(bits / -math.log2(widest)) if widest < theta else p
    return times, min(p, max(_LEAST_DEGREE, needed))


def _speeds(problem: Problem, states: Any) -> Any:
    """The largest row sums of |f'(x)| at states, (n,), in the norm in which motions hardly stretch.

    Powers of f' are what series are made of: scales of w and gamma are no part of them.
    """
    slopes = jacobian(problem, states[:, None], np.ones(len(states)))[:, 0]
    weights = np.array(problem.weights)
    return np.max(np.sum(np.abs(slopes) * (weights[:, None] / weights), axis=2), axis=1)


def _series(problem: Problem, states: Any, lengths: Any, count: int) -> Any:
    """Taylor coefficients in tau of the motions through the states, to degree ``count``."""
    of_layers = [layer.coefficients(problem.factors) for layer in LAYERS]
    coefficients = [None if c is None else np.array(c)[:, None] for c in of_layers]
    found = np.zeros((len(states), count + 1, 6))
    found[:, 0] = states
    h = lengths[:, None]
    for k in range(count):
        products = np.einsum(
            "wki,wki->wi", found[:, : k + 1][:, :, LEFT], found[:, k::-1][:, :, RIGHT]
        )
        omega, gamma = layered(products.T, found[:, k].T, coefficients)
        found[:, k + 1, :3], found[:, k + 1, 3:] = omega.T, gamma.T
        found[:, k + 1] *= h / (k + 1)
    return found


def tangents(
    what: Motion, last: float, deadline: Deadline = NONE
) -> tuple[list[float], float, float]:
    """log2 of a tangent's length along the motion, at even times, the largest |w|, and the steps.

    The list is short where double fails, or at the deadline; |w| is in the proof's unit of time;
    the steps are those of double to the last time, if it goes on as it went.
    """
    scene = what.scene
    plain = principal_system(scene)
    values = [to_double(x) for x in plain.start]
    start = np.array(values + [0.0] * (6 - len(values)))
    tangent = np.linspace(0.6, 1.4, 6)[:, None]
    if scene.gamma is None:
        tangent[3:] = 0.0
    flow = Variations(plain.coefficients, start, tangent)
    frame = Frame.of(scene)
    end = last / float(frame.unit)
    logs = [math.log2(float(np.max(np.abs(tangent))))]
    fastest = float(np.linalg.norm(start[:3]))
    for k in range(1, _LOOKS + 1):
        if deadline.passed or not (
            flow.to(end * k / _LOOKS, _MOST_STEPS - flow.steps) and flow.finite
        ):
            break
        flow.rescale()
        logs.append(flow.exponent + math.log2(float(np.max(np.abs(flow.tangents)))))
        fastest = max(fastest, float(np.linalg.norm(flow.state[:3])))
    flow.release()
    steps = flow.steps * _LOOKS / max(1, len(logs) - 1)
    if steps < 2 * _LOOKS:  # looks cut them short
        straight = Variations(plain.coefficients, start, tangent)
        straight.to(end, _MOST_STEPS)
        steps = max(1, straight.steps)
        straight.release()
    return logs, fastest * 2.0 ** (what.unit - frame.exponent), steps

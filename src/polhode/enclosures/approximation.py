"""Guesses that guide a proof and are not trusted: approximate motions, corrections, costs."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from polhode.enclosures.fixed_point_problem import CLOCK, ExactMotion, Problem, TooImprecise
from polhode.enclosures.step_bound import jacobian
from polhode.enclosures.zonotope import ProofState
from polhode.equations.terms import LAYERS, LEFT, RIGHT, layered
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import Doubles
from polhode.taylor import variations
from polhode.taylor.error_growth import growth

# --- newton correction ----------------------------------------------------------------------------
#
# Newton's corrections of a window's polynomials, and the matrices of its linear flow.
#
# Not trusted: what it finds wrong costs digits or a refusal. All steps are treated at once.


LEAST_TERM = 2.0**-48  # the last coefficient of a matrix V is smaller, if the degree allows
_FEWEST = 8


def matrices(a: Doubles) -> Doubles:
    """V with V' = A V, V(0) = I, to the degree at which it ends, at most that of A.

    ``a``: (W, p + 1, 6, 6).  Returns (W, m + 1, 6, 6).
    """
    return _series_solution(a, np.eye(6), least=LEAST_TERM)


def correction(a: Doubles, defects: Doubles, v: Doubles, gaps: Doubles) -> Doubles:
    """e with e' = A e - d on every step, and without jumps from step to step.

    ``defects``: (W, K, 6); ``gaps``: the jumps of the polynomials, (W, 6).  Returns (W, p + 1, 6).
    """
    steps = a.shape[0]
    corrections = forced(a, defects, np.zeros(6))
    ends, flows = np.sum(corrections, axis=1), np.sum(v, axis=1)
    starts = np.zeros((steps, 6))
    starts[0] = gaps[0]
    for n in range(1, steps):
        starts[n] = flows[n - 1] @ starts[n - 1] + ends[n - 1] + gaps[n]
    corrections[:, : v.shape[1]] += np.einsum("wkij,wj->wki", v, starts)
    return corrections


def forced(a: Doubles, defects: Doubles, start: Doubles) -> Doubles:
    """e with e' = A e - d and e(0) = ``start`` on every step, each by itself: (W, p + 1, n).

    ``a``: (W, p + 1, n, n); ``defects``: (W, K, n), zero from K on.
    """
    return _series_solution(a, start[:, None], defects[..., None])[..., 0]


def _series_solution(
    a: Doubles, start: Doubles, defects: Doubles | None = None, least: float = 0.0
) -> Doubles:
    """Y with Y' = A Y - D and Y(0) = ``start``, (n, c), up to a term below ``least``."""
    steps, count, rows = a.shape[:3]
    flat = np.ascontiguousarray(a.transpose(0, 2, 1, 3)).reshape(steps, rows, rows * count)
    reversed_rows = np.zeros((steps, rows * count, start.shape[1]))  # Y_k in reversed order
    reversed_rows[:, rows * (count - 1) :] = start
    degree = count - 1
    for k in range(count - 1):
        low = rows * (count - 1 - k)
        term = np.matmul(flat[:, :, : rows * (k + 1)], reversed_rows[:, low:])
        if defects is not None and k < defects.shape[1]:
            term = term - defects[:, k]
        term = term / (k + 1)
        reversed_rows[:, low - rows : low] = term
        if least and k + 1 >= _FEWEST and float(np.max(np.abs(term))) < least:
            degree = k + 1
            break
    terms = reversed_rows.reshape(steps, count, rows, -1)[:, ::-1]
    return np.ascontiguousarray(terms[:, : degree + 1])


# --- window approximation -------------------------------------------------------------------------
#
# An approximation of a window of steps: heyoka's run, a grid of times, Taylor coefficients.
#
# Not trusted: whatever it gives is bounded afterwards. The steps are at most theta times the
# radius of convergence, theta**p = 2**-(P + 8), and short enough for exp(int |A|) to stay small.
# Where the latter decides, fewer terms than p are enough.


MOST_TURN = 5.0  # h |f'(x)| of a step: the majorant alpha is then about twice that
_COARSE, _LESS = 64, 0.35  # less below this noise level, where exp(2 alpha) soon is too much
_LEAST_DEGREE = 40
_DOUBLE = 84  # up to this noise level one correction mends a run in double


class Window(NamedTuple):
    """Times of the grid, W + 1 integers times 2**-CLOCK, and coefficients, (W, p + 1, 6)."""

    times: tuple[int, ...]
    series: Any


def degree(noise: int) -> int:
    """The largest degree of the polynomials for a noise level."""
    return max(_LEAST_DEGREE, math.ceil((0.6 if noise <= 150 else 0.5) * noise))


def window(
    problem: Problem, state: ProofState, end: int, steps: int, pace: float, turn: float = MOST_TURN
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
    series = np.zeros((len(states), count + 1, 6))
    series[:, 0] = states
    h = lengths[:, None]
    for k in range(count):
        products = np.einsum(
            "wki,wki->wi", series[:, : k + 1][:, :, LEFT], series[:, k::-1][:, :, RIGHT]
        )
        omega, gamma = layered(products.T, series[:, k].T, coefficients)
        series[:, k + 1, :3], series[:, k + 1, 3:] = omega.T, gamma.T
        series[:, k + 1] *= h / (k + 1)
    return series


# --- precision choice -----------------------------------------------------------------------------
#
# What a motion does to a small error, told roughly before the proof: the choice of precision.
#
# Not trusted, and nothing depends on it but cost: one run in double with one tangent vector.  An
# error of each step grows by its G at most (:mod:`polhode.taylor.error_growth`), in any direction.


BITS_A_DIGIT = math.log2(10)
_STEPS_A_UNIT = 3.0  # of the proof, in its unit of time
_OF_DOUBLES_STEPS = 0.55  # so many the proof takes, of those of a run in double with a tangent
_OF_ALL_STEPS = 0.1  # of those of a unit of time, at least: where a run in double takes hardly any
_SECONDS_A_STEP = 4e-4, 2.6e-8, 5.9e-13  # and over the noise level's square and fourth power
_FAR = 0.1  # of the way: from there on the growth tells of the rest
_AHEAD, _SURE = 1.25, 8  # times the growth that is left, and bits: less than a try more
_OF_OUTPUTS = {"attitude": 6.0, "angles": 9.0}  # the same of a turn, and of angles near a pole


class Forecast(NamedTuple):
    """What a proof needs, roughly.

    ``bits``: those of the digits, ``grown``: those that the motion takes; their sum is the noise
    level P to try.  ``steps``: of the proof.
    """

    bits: float
    grown: float
    steps: float

    def seconds(self, noise: int, outputs: bool) -> float:
        """About how long the proof takes at a noise level; longer with angles or attitude."""
        constant, square, fourth = _SECONDS_A_STEP
        step = constant + (square + fourth * noise * noise) * noise * noise
        return (2.0 if outputs else 1.0) * step * self.steps


def forecast(motion: ExactMotion, last: Exact, digits: float) -> Forecast:
    """What the digits need at the time ``last``."""
    scene, count = motion.scene, max(1.0, steps(motion, last))
    errors = growth(scene, in_all=True, end=last)
    fastest = math.ldexp(errors.fastest, motion.unit - errors.unit)
    slow = max(0.0, -math.log2(fastest)) if fastest > 0.0 else 0.0  # digits of w are relative
    bits = digits * BITS_A_DIGIT + slow
    more = max((_OF_OUTPUTS.get(name, 0.0) for name in scene.modelled), default=0.0)
    if more:  # they add up what the state is off on the way
        bits += more + math.log2(1.0 + count)
    grown = BITS_A_DIGIT * max(errors.lost) + 0.5 * math.log2(count)  # all steps, not their root
    steps_taken = max(_OF_ALL_STEPS * count, _OF_DOUBLES_STEPS * errors.steps)
    return Forecast(bits, grown, min(count, steps_taken))


def raised(noise: int, bits: float, why: TooImprecise) -> int:
    """The noise level to try after a refusal, by what the radius had grown to on the way.

    ``bits``: those that the digits need.  The growth is taken to go on as it went: that of a
    chaotic motion does, while a run in double follows another orbit by then.  Where the proof came
    not far nothing is known of it.
    """
    if why.reached < _FAR:
        return math.ceil(1.25 * noise) + 20
    ahead = why.grown * (1.0 / why.reached - 1.0)
    return max(noise + 20, math.ceil(bits + why.grown + _AHEAD * ahead) + _SURE)


def steps(motion: ExactMotion, last: Exact) -> float:
    """About how many steps lead to a time; infinite beyond the range of double."""
    return _STEPS_A_UNIT * abs(to_double(last / Fraction(2) ** motion.unit))

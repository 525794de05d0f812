"""Random tops for the tests of the enclosures, and where their motions truly go.

Truth is a run at many more bits than the proof has: heyoka's, in MPFR, whose own error is below
2**-40 of the radii that it judges; closed forms judge the same enclosures elsewhere.
"""

import itertools
import random
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from flint import arb, ctx

from polhode.enclosures import (
    approximation,
    fixed_point_problem,
    integral_contraction,
    step_bound,
    taylor_polynomials,
    zonotope,
)
from polhode.enclosures.fixed_point_problem import CLOCK, ExactMotion, Problem
from polhode.enclosures.task import Untrusted, run
from polhode.judging.adaptive_precision import integrate
from polhode.numbers import exact
from polhode.numbers.conversion import exactly
from polhode.numbers.number_types import NumberType
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene
from shared.motions import asymmetric

KINDS = (
    *("generic", "fast", "slow", "needle", "disc", "nearly symmetric", "free", "hanging", "zeros"),
    *("sphere", "kovalevskaya"),
)


def number(rng: random.Random, low: float, high: float, bits: int = 12) -> Fraction:
    """A fraction between two numbers, of a prime denominator half of the time."""
    bottom = rng.choice((1 << bits, 997))
    return Fraction(round(rng.uniform(low, high) * bottom), bottom)


def unit_vector(rng: random.Random) -> tuple[Fraction, Fraction, Fraction]:
    """A rational unit vector: the stereographic image of a rational point."""
    s, t = number(rng, -2, 2, 6), number(rng, -2, 2, 6)
    bottom = 1 + s * s + t * t
    return 2 * s / bottom, 2 * t / bottom, (bottom - 2) / bottom


def random_scene(rng: random.Random, kind: str) -> Scene:
    """A top of a kind, with a random start."""
    b, c = number(rng, 1, 2), number(rng, 1, 2)
    a = number(rng, float(abs(b - c)) + 0.1, float(b + c) - 0.1)
    centre = [number(rng, -1, 1) for _ in range(3)]
    omega = [number(rng, -1.5, 1.5) for _ in range(3)]
    weight = Fraction(1)
    if kind == "fast":
        omega[2] = number(rng, 20, 40)
    elif kind == "slow":
        omega = [x / 1000 for x in omega]
    elif kind == "needle":
        a, b = Fraction(1, 50), c
        b = c + number(rng, -0.015, 0.015)
    elif kind == "disc":
        a, b, c = b, c, b + c
    elif kind == "nearly symmetric":
        a = b + Fraction(1, 10**20)
    elif kind == "free":
        weight = Fraction(0)
    elif kind == "hanging":
        weight = Fraction(-2)
    elif kind == "zeros":
        centre[rng.randrange(3)] = omega[rng.randrange(3)] = Fraction(0)
    elif kind == "sphere":
        a = b = c
    elif kind == "kovalevskaya":
        a = b = 2 * c
        centre[2] = Fraction(0)
    moments = [a, b, c]
    if kind not in ("kovalevskaya",):
        rng.shuffle(moments)
    body = Body.of_moments(moments, centre, weight)
    return Scene(body, tuple(omega), unit_vector(rng), name=kind)


def truth(scene: Scene, times: Sequence[Any], bits: int) -> list[list[Fraction]]:
    """States in the scene's axes at times away from 0 in order, exact values of MPFR numbers."""
    timed = scene.at(tuple(exact.exact(t) for t in times))
    run = integrate(timed, NumberType("mp", bits), max_steps=10**6)
    assert run.outcome.done
    return [[exactly(x) for x in row] for row in run.states]


class Trial(NamedTuple):
    """A motion, times in its unit, and the true states there in its unit and axes."""

    motion: ExactMotion
    times: list[Fraction]
    states: list[list[Fraction]]
    bits: int


def trial(scene: Scene, times: Sequence[Fraction], bits: int) -> Trial:
    """The true states of a scene given in principal axes, ready for proofs of any noise level."""
    motion = fixed_point_problem.motion(scene)
    by = Fraction(2) ** motion.unit
    inside = [t * by for t in times]
    rows = truth(replace(scene, outputs=()), inside, bits)
    return Trial(motion, list(times), [[*(by * x for x in r[:3]), *r[3:]] for r in rows], bits)


def times_inside(trial: Trial, problem: Problem) -> list[Any]:
    """The times of a trial as balls."""
    return [fixed_point_problem.ball(t, problem.noise + 200) for t in trial.times]


def ratios(balls: Sequence[Sequence[Any]], states: Sequence[Sequence[Any]]) -> list[float]:
    """|truth - midpoint|/radius of every component; at most 1 where the truth is inside."""
    numbers = []
    with ctx.workprec(2000):
        for row, true in zip(balls, states, strict=True):
            for x, y in zip(row, true, strict=True):
                off = abs(fixed_point_problem.ball(y, 2000) - x.mid())
                if x.rad() == 0:
                    numbers.append(0.0 if off == 0 else float("inf"))
                else:
                    numbers.append(float((off / arb(x.rad())).mid()))
    return numbers


# -- motions that show one term of the bound of a step, each by a ratio

NOISE = 79


def sphere(rate: str = "1", gamma: Any = None) -> Scene:
    """A free sphere: w stays as it is."""
    return Scene(Body.of_moments((1, 1, 1)), (Fraction(rate), Fraction(0), Fraction(0)), gamma)


def generic() -> Scene:
    """An asymmetric heavy top."""
    return asymmetric("0.9")


def short_steps(*arguments: Any) -> Any:
    """An honest approximation on steps so short that exp(alpha) is near 1."""
    from polhode.enclosures import approximation

    return approximation.window(*arguments, turn=0.05)


def of_faulty(scene: Scene, untrusted: Untrusted, **changes: Any) -> list[float]:
    """The ratios of w in a proof whose untrusted parts are these, at t = 5 of its unit."""
    trial_of_it = trial(scene, [Fraction(5)], 300)
    problem = replace(fixed_point_problem.problem(trial_of_it.motion, NOISE), **changes)
    proof = run(
        problem, [fixed_point_problem.ball(t, 300) for t in trial_of_it.times], (), untrusted
    )
    return ratios([row[:3] for row in proof.rows], [row[:3] for row in trial_of_it.states])


def residual() -> list[float]:
    """int |d + e' - A e|: the correction drifts away from the motion without a jump."""

    def drifting(a: Any, defects: Any, v: Any, gaps: Any) -> Any:
        values = approximation.correction(a, defects, v, gaps)
        values[:, 0, 0] += 1e6 * np.arange(len(values))
        values[:, 1, 0] += 1e6
        return values

    return of_faulty(sphere(), Untrusted(window=short_steps, correction=drifting))


def jumps() -> list[float]:
    """|J_n|: the correction moves away in jumps; what is constant leaves no residual."""

    def jumping(a: Any, defects: Any, v: Any, gaps: Any) -> Any:
        values = approximation.correction(a, defects, v, gaps)
        values[:, 0, 0] += 1e6 * np.arange(1, len(values) + 1)
        return values

    return of_faulty(sphere(), Untrusted(window=short_steps, correction=jumping))


def start_box() -> list[float]:
    """The start's radii: the truth at a corner of the box."""
    worst: list[float] = []
    truth = trial(generic(), [Fraction(5)], 300)
    for signs in itertools.product((-1, 1), repeat=3):
        problem = fixed_point_problem.problem(truth.motion, 96)
        ticks = (1 << 20) << (problem.fine - problem.noise)
        corner = [*signs, 1, -1, 1]
        start = tuple(x + s * ticks for x, s in zip(problem.start, corner, strict=True))
        spread = tuple(2.0**20 * (1 + 1e-12) + r for r in problem.spread)
        problem = replace(problem, start=start, spread=spread)
        proof = run(problem, [fixed_point_problem.ball(t, 300) for t in truth.times])
        worst.append(max(ratios(proof.rows, truth.states)))
    return worst


def one_step(problem: Problem, length: int, moved: Any) -> tuple[Any, Any]:
    """A state after one step whose polynomial is wrong by ``moved`` (6,), corrected once."""
    from polhode.enclosures import approximation

    state = zonotope.beginning(problem)
    centre = tuple(
        x + (int(by * 2.0**40) << (problem.fine - 40))
        for x, by in zip(state.centre, moved, strict=True)
    )
    false = replace(state, centre=centre)
    window = approximation.window(problem, false, length, 1, 1.0)
    shape = taylor_polynomials.of_doubles(window.times, window.series)
    a = step_bound.jacobian(problem, shape.near, shape.lengths)
    matrices = approximation.matrices(a)
    defects = taylor_polynomials.defects(problem, shape)
    gaps = taylor_polynomials.gaps(problem, shape, state.centre)
    e = approximation.correction(a, defects.values, matrices, gaps)
    bounds = step_bound.bounds(problem, defects, e, matrices)
    end = arb((length, -CLOCK))
    after, rows, _ = zonotope.advance(state, bounds, [end])
    return after, rows


def quadratic() -> list[float]:
    """h beta sigma**2: a polynomial wrong by 1e-6, whose correction is as large and linear."""
    worst = []
    length = 1 << (CLOCK - 2)
    truth = trial(generic(), [Fraction(1, 4)], 300)
    for signs in ((1, 1, 1, 1, 1, 1), (1, -1, 1, 1, 1, -1), (-1, 1, 1, -1, 1, 1)):
        problem = fixed_point_problem.problem(truth.motion, 60)
        _, rows = one_step(problem, length, [s * 2.0**-20 for s in signs])
        worst.append(max(ratios(rows, truth.states)))
    return worst


def rounding() -> list[float]:
    """What is left where the next start is rounded: a correction that drifts by half a tick."""

    def single(problem: Any, state: Any, end: int, steps: int, pace: float) -> Any:
        return short_steps(problem, state, end, 1, pace)

    def drifting(a: Any, defects: Any, v: Any, gaps: Any) -> Any:
        values = approximation.correction(a, defects, v, gaps)
        values[:, 1, 0] += 0.51 * 2.0**-12  # a tick is 2**-(P + 12)
        return values

    return of_faulty(sphere(), Untrusted(window=single, correction=drifting))


def integrals() -> list[float]:
    """w of the first integrals: |gamma|**2 is curved, with the truth at the corners of a box."""
    worst = []
    truth = (*[Fraction(0)] * 3, Fraction(2, 15), Fraction(5, 15), Fraction(14, 15))
    motion = fixed_point_problem.motion(Scene(Body.of_moments((1, 1, 1)), truth[:3], truth[3:]))
    problem = fixed_point_problem.problem(motion, 96)
    prepared = [i for i in integral_contraction.prepared(motion, 400) if i.name == "|gamma|^2"]
    radius = 2.0 ** (problem.noise - 20)
    for signs in itertools.product((-1, 1), repeat=3):
        centre = list(problem.start)
        for k, s in enumerate(signs):
            centre[3 + k] += s * (1 << (problem.fine - 20))
        columns = np.diag([1.0, 1.0, 1.0, *(radius + r for r in problem.spread[3:])])
        state = zonotope.ProofState(0, tuple(centre), columns)
        after = integral_contraction.shrunk(problem, state, prepared)
        assert after is not state
        for x, y, r in zip(truth[3:], after.centre[3:], after.radii[3:], strict=True):
            off = abs(x - Fraction(y, 1 << problem.fine)) * 2**problem.noise
            worst.append(float(off / Fraction(float(r))))
    return worst


# -- faults put into the parts that nothing rests on

#: Ways of writing into an array.
WRITES: tuple[Callable[[Any], Any], ...] = (
    lambda x: np.multiply(x, 0, out=x),
    lambda x: np.negative(x, out=x),
    lambda x: np.multiply(x, 1.0 + 1e-9, out=x, casting="unsafe"),
    lambda x: x.flat.__setitem__(0, 1000),
)


def arrays(thing: Any) -> list[Any]:
    """All arrays in a value, and in what it is made of."""
    if isinstance(thing, np.ndarray):
        return [thing]
    if isinstance(thing, (list, tuple)):
        return [x for part in thing for x in arrays(part)]
    return arrays(list(vars(thing).values())) if hasattr(thing, "__dataclass_fields__") else []


class Hoard:
    """Arrays that a faulty part was given or has returned, written into at any later call."""

    def __init__(self, rng: random.Random, often: float = 0.3) -> None:
        self.rng, self.often = rng, often
        self.kept: list[Any] = []

    def around(self, honest: Callable[..., Any]) -> Callable[..., Any]:
        """The same part, which writes into what is kept and keeps all that it comes to see."""

        def faulty(*arguments: Any) -> Any:
            self.write(self.kept)
            values = honest(*arguments)
            self.write(arrays(arguments))
            self.kept = [*arrays(arguments), *arrays(values), *self.kept][:40]
            return values

        return faulty

    def write(self, into: Sequence[Any]) -> None:
        """Some of them overwritten."""
        for array in into:
            if array.flags.writeable and array.size and self.rng.random() < self.often:
                self.rng.choice(WRITES)(array)


def hoarder(rng: random.Random) -> Untrusted:
    """Parts that are right, write into their arguments, keep their results and change them."""
    hoard = Hoard(rng, rng.choice((0.03, 0.3)))
    honest = Untrusted()
    return Untrusted(*map(hoard.around, (honest.window, honest.matrices, honest.correction)))


#: How large an alteration is, relative to what is altered.
SIZES = (1e-15, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2, 0.5, 3.0)


def random_fault(rng: random.Random) -> tuple[str, Untrusted]:
    """A fault in one of the untrusted parts, in every window or in some, and its name."""
    if rng.random() < 0.2:
        return "all: hoards and writes", hoarder(rng)
    part, name, fault = rng.choice(FAULTS)
    often = rng.choice((1.0, 0.3))
    honest = getattr(Untrusted(), part)

    def faulty(*arguments: Any) -> Any:
        if rng.random() > often:
            return honest(*arguments)
        return fault(rng, honest, *arguments)

    return f"{part}: {name}", replace(Untrusted(), **{part: faulty})


def _somewhere(rng: random.Random, values: Any) -> tuple[int, ...]:
    return tuple(rng.randrange(n) for n in values.shape)


def _altered(rng: random.Random, values: Any) -> Any:
    """One number altered by a part of the largest of its step, or by a part of itself."""
    place, by = _somewhere(rng, values), rng.choice(SIZES) * rng.choice((-1, 1))
    changed = values.copy()
    own = rng.random() < 0.5
    changed[place] += by * (changed[place] if own else np.max(np.abs(values[place[0]])))
    return changed


def _with(values: Any, place: Any, value: float) -> Any:
    changed = values.copy()
    changed[place] = value
    return changed


def _normal(rng: random.Random, shape: tuple[int, ...]) -> Any:
    return np.random.default_rng(rng.randrange(2**32)).standard_normal(shape)


def _not_a_number(rng: random.Random, values: Any) -> Any:
    return _with(values, _somewhere(rng, values), rng.choice((np.nan, np.inf, -np.inf, 1e300)))


def _start(rng: random.Random, values: Any) -> Any:
    """The constant terms alone: a start, a V(0)."""
    changed = values.copy()
    place = _somewhere(rng, values[:, 0])
    changed[place[0], 0][place[1:]] += rng.choice(SIZES)
    return changed


CHANGES = {
    "one number": _altered,
    "a step zeroed": lambda rng, x: _with(x, rng.randrange(len(x)), 0.0),
    "all scaled": lambda rng, x: x * rng.choice((0.0, 0.5, 1.0 + 1e-6, 2.0, -1.0)),
    "noise": lambda rng, x: x * (1.0 + rng.choice(SIZES) * _normal(rng, x.shape)),
    "not a number": _not_a_number,
    "coefficients reversed": lambda _, x: x[:, ::-1].copy(),
    "steps reversed": lambda _, x: x[::-1].copy(),
    "a constant term": _start,
}


def _of_result(change: Callable[..., Any]) -> Callable[..., Any]:
    return lambda rng, honest, *arguments: change(rng, honest(*arguments))


def _of_series(change: Callable[..., Any]) -> Callable[..., Any]:
    def fault(rng: random.Random, honest: Any, *arguments: Any) -> Any:
        values = honest(*arguments)
        return None if values is None else values._replace(series=change(rng, values.series))

    return fault


def _wrong_body(rng: random.Random, honest: Any, problem: Any, *arguments: Any) -> Any:
    """heyoka's run and the series with one constant wrong."""
    factors = list(problem.factors)
    factors[rng.randrange(9)] += rng.choice(SIZES)
    return honest(replace(problem, factors=tuple(factors)), *arguments)


def _wrong_start(rng: random.Random, honest: Any, problem: Any, state: Any, *arguments: Any) -> Any:
    """heyoka's run from another state."""
    centre = list(state.centre)
    centre[rng.randrange(6)] += int(rng.choice(SIZES) * 2.0**50) << (problem.fine - 50)
    return honest(problem, replace(state, centre=tuple(centre)), *arguments)


def _odd_grid(rng: random.Random, honest: Any, *arguments: Any) -> Any:
    """The times of the grid moved, the series as they were: right for other times."""
    window = honest(*arguments)
    if window is None or len(window.times) < 3:
        return window
    times = list(window.times)
    n = rng.randrange(1, len(times) - 1)
    times[n] = (times[n - 1] + times[n + 1]) // 2
    return window._replace(times=tuple(times))


def _long_steps(rng: random.Random, honest: Any, *arguments: Any) -> Any:
    turn = approximation.MOST_TURN
    approximation.MOST_TURN = rng.choice((0.1, 8.0, 20.0))
    try:
        return honest(*arguments)
    finally:
        approximation.MOST_TURN = turn


def _few_terms(rng: random.Random, honest: Any, *arguments: Any) -> Any:
    least = approximation.LEAST_TERM
    approximation.LEAST_TERM = rng.choice((1e-2, 1e-5, 1e-9))
    try:
        return honest(*arguments)
    finally:
        approximation.LEAST_TERM = least


FAULTS: list[tuple[str, str, Callable[..., Any]]] = [
    *(("matrices", name, _of_result(change)) for name, change in CHANGES.items()),
    *(("correction", name, _of_result(change)) for name, change in CHANGES.items()),
    *(("window", name, _of_series(change)) for name, change in CHANGES.items()),
    ("window", "wrong constant", _wrong_body),
    ("window", "wrong start", _wrong_start),
    ("window", "odd grid", _odd_grid),
    ("window", "steps of another length", _long_steps),
    ("matrices", "too few terms", _few_terms),
]

"""The run in double that is to be refined, and the intervals into which its steps are grouped."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from polhode.common.errors import BadInput
from polhode.equations.form import equations
from polhode.equations.terms import COEFFICIENTS, NAMES, TIMES
from polhode.motion.outcomes import Outcome
from polhode.numbers import exact
from polhode.numbers.number_types import Doubles
from polhode.numbers.polynomials import fraction_near
from polhode.refined.collocation_tables import LARGEST_FIELD
from polhode.refined.compiled_field import CannotRefine, rounded
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import STATE
from polhode.taylor.engine import Engine, Equations, lent

# --- scaled problem -------------------------------------------------------------------------------
#
# The exact system: coefficients, start, and the unit of time in which all of it is small.


_SLACK = 1.1  # |w| times this is below 1 in the unit of time chosen
_LEAST = -64  # of units; the scene's own is near 1 but for bodies almost at rest


@dataclass(frozen=True)
class RationalSystem:
    """Rationals near the scene's numbers: coefficients (order of NAMES) and the state.

    ``state``: w1 w2 w3 g1 g2 g3, gamma zero where the scene leaves it out.  All of it is inside the
    scene's frame, and time runs forward: a motion backwards in time is the one with -w forwards.
    """

    coefficients: tuple[Fraction, ...]
    state: tuple[Fraction, ...]

    def coefficients_in(self, unit: int) -> list[Fraction]:
        """The coefficients with time in units of 2**-unit of the frame's."""
        factors = {power: Fraction(2) ** (-unit * power) for power in set(TIMES)}
        pairs = zip(COEFFICIENTS, self.coefficients, strict=True)
        return [x * factors[kind.power] for kind, x in pairs]

    def rate(self, unit: int = 0) -> float:
        """The largest rate that the coefficients make by themselves, in units of 2**-unit."""
        pairs = zip(COEFFICIENTS, map(float, self.coefficients_in(unit)), strict=True)
        return float(max(abs(x) ** (1 / kind.power) for kind, x in pairs if kind.power))

    def unit(self, fastest: float) -> int:
        """The least unit in which the coefficients and the fastest |w| are below 1."""
        needed = max(self.rate(), _SLACK * fastest)
        return max(_LEAST, min(1000, math.frexp(needed)[1])) if needed else 0


def with_rates(state: Sequence[Fraction], exponent: int) -> tuple[Fraction, ...]:
    """A state whose rates are multiplied by 2**exponent: time in a unit that is as long."""
    scale = Fraction(2) ** exponent
    p, q, r, *gamma = state
    return (p * scale, q * scale, r * scale, *gamma)


def rational_system(scene: Scene, bits: int, backward: bool) -> RationalSystem:
    """The system of a scene in the principal form, irrational numbers to so many bits.

    Raises BadInput for another form.
    """
    if scene.form != "principal":
        raise BadInput(scene.name, "form", scene.form, "principal: no other form can be refined")
    form = equations(scene)
    numbers = [fraction_near(form.coefficients.get(name, exact.ZERO), bits)[0] for name in NAMES]
    state = [fraction_near(x, bits)[0] for x in form.start]
    state += [Fraction(0)] * (6 - len(state))
    if backward:  # time and w change sign, and coefficients with an odd power of time
        state[:3] = [-x for x in state[:3]]
        pairs = zip(COEFFICIENTS, numbers, strict=True)
        numbers = [-x if kind.power % 2 else x for kind, x in pairs]
    return RationalSystem(tuple(numbers), tuple(state))


# --- double run -----------------------------------------------------------------------------------


_EQUATIONS = Equations(STATE, NAMES)
STEPS = 8000  # of a base; its polynomials take a kilobyte a step
_LOOKS, _PER_LOOK = 24, 20  # at the first steps, to guess the unit of time
_LONGEST = 2.0**16  # of a base, in its own unit
_GRID = 36  # edges are multiples of 2**-36 below 2**17: they and their differences are doubles
_LONGEST_INTERVAL = 16.0
_STRETCH = 1.15  # an interval may be that much longer than its shortest step would have it
_NEIGHBOUR = 1.5  # and a step that much longer than the shortest of a neighbouring group


@dataclass(frozen=True, eq=False)
class Base:
    """A run in double from an exact state at an exact time.

    Its clock starts at 0 and ticks in units of 2**-unit of the frame's; ``origin`` is its
    start by the frame's.  ``edges``: of the intervals, doubles, the first one 0.
    ``polynomials``: the states at any time passed, as heyoka gives them.  ``final``: it reaches
    the end of the whole run; the last edge is then left out, what follows it is for outputs alone.
    """

    unit: int
    origin: Fraction
    edges: Doubles
    final: bool
    polynomials: Any
    steps: int

    def states(self, times: Doubles) -> Doubles:
        """States (6, ...) at an array of times."""
        flat = self.polynomials(times.reshape(-1))
        return np.ascontiguousarray(flat.T).reshape(6, *times.shape)

    def clock(self, t: Fraction) -> Fraction:
        """A time inside the frame by this clock."""
        return (t - self.origin) * Fraction(2) ** self.unit

    def time(self, clock: float) -> Fraction:
        """The time inside the frame that the clock shows."""
        return self.origin + Fraction(clock) / Fraction(2) ** self.unit


def base(
    system: RationalSystem,
    state: tuple[Fraction, ...],
    origin: Fraction,
    end: Fraction,
    m: int,
    most: int = STEPS,
) -> Base:
    """Run in double from ``state`` at ``origin`` towards ``end``, m steps a group.

    ``most``: steps to take.  Raises CannotRefine where the run does not succeed.
    """
    ready = lent(_EQUATIONS)
    unit = _first_guess(ready, system, state, end - origin)
    for _ in range(4):
        run, fastest = _run(ready, system, state, origin, end, unit, m, most)
        fit = system.unit(fastest * 2.0**unit)
        if unit - 1 <= fit <= unit:
            ready.release()
            return run
        unit = fit
    raise CannotRefine("no unit of time suits the motion")


def _begin(ta: Engine, system: RationalSystem, state: tuple[Fraction, ...], unit: int) -> None:
    ta.state[:] = [*map(float, with_rates(state, -unit))]
    ta.begin([*map(float, system.coefficients_in(unit))])


def _first_guess(
    ta: Engine, system: RationalSystem, state: tuple[Fraction, ...], span: Fraction
) -> int:
    """The unit of time that the fastest |w| of the first steps asks for."""
    fastest = math.hypot(*map(float, state[:3]))
    unit = system.unit(fastest)
    _begin(ta, system, state, unit)
    end = float(min(span * Fraction(2) ** unit, Fraction(_LONGEST)))
    for _ in range(_LOOKS):
        ta.until(end, _PER_LOOK, _PER_LOOK)
        fastest = max(fastest, 2.0**unit * math.hypot(*ta.state[:3]))
    return system.unit(fastest) if math.isfinite(fastest) else unit


def _run(
    ta: Engine,
    system: RationalSystem,
    state: tuple[Fraction, ...],
    origin: Fraction,
    end: Fraction,
    unit: int,
    m: int,
    most: int,
) -> tuple[Base, float]:
    """One run in one unit of time, and the largest |w| in it."""
    _begin(ta, system, state, unit)
    last = float(min((end - origin) * Fraction(2) ** unit, Fraction(_LONGEST)))
    outcome, polynomials = ta.polynomials(last, most)
    whole = outcome is Outcome.REACHED_END
    if not whole and outcome is not Outcome.STEP_LIMIT:
        raise CannotRefine("the run in double failed")
    times = polynomials.times
    speeds = np.linalg.norm(polynomials.tcs[:, :3, 0], axis=1)
    speeds = np.append(speeds, math.hypot(*ta.state[:3]))
    if not np.isfinite(speeds).all():
        raise CannotRefine("the run in double failed")
    edges = intervals(times, speeds, system.rate(unit), m, whole)
    final = whole and last < _LONGEST
    if final:
        edges = edges[: max(1, len(edges) - 1)]
    return Base(unit, origin, edges, final, polynomials, len(times) - 1), float(speeds.max())


def intervals(times: Doubles, speeds: Doubles, weight: float, m: int, cut: bool) -> Doubles:
    """Edges of intervals of about m steps each, from the steps' times and |w| there.

    An interval holds no more than its shortest step allows, nor than keeps |H f| below 4.
    ``weight``: the root of the weight's largest coefficient, a rate that stays where w is small.
    ``cut``: the last step was cut short and says nothing.
    """
    steps = np.diff(times)
    if cut:
        steps[-1] = math.inf
    first = np.arange(0, len(steps), m)
    shortest = np.minimum.reduceat(steps, first)
    padded = np.concatenate([[math.inf], shortest, [math.inf]])
    shortest = np.minimum(shortest, _NEIGHBOUR * np.minimum(padded[:-2], padded[2:]))
    last = np.minimum(first + m, len(steps))
    fastest = np.maximum(np.maximum.reduceat(speeds[:-1], first), speeds[last])
    lengths = times[last] - times[first]
    parts = np.maximum(lengths / (_STRETCH * m * shortest), lengths / _LONGEST_INTERVAL)
    parts = np.maximum(parts, lengths * np.maximum(fastest, weight) / LARGEST_FIELD)
    count = np.maximum(np.ceil(parts), 1).astype(int)
    group = np.repeat(np.arange(len(first)), count)
    within = np.arange(len(group)) - np.repeat(np.cumsum(count) - count, count)
    edges = times[first][group] + lengths[group] * (within / count[group])
    return np.unique(on_grid(np.append(edges, times[-1])))


def on_grid(times: Doubles) -> Doubles:
    """Times as multiples of 2**-36, exact in double and in two limbs."""
    multiples: Doubles = rounded(times, _GRID)
    return multiples

"""Charts and sets along a homoclinic orbit; each next set is fitted to the image just proved.

Not trusted: ``theorem`` decides.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
from flint import arb

from polhode.enclosures import proof_loop
from polhode.enclosures.approximation import window_approximation
from polhode.enclosures.fixed_point_problem import CLOCK, LEAST_FINE, Problem, Refused
from polhode.enclosures.proof_loop import Proof, Untrusted, Watcher
from polhode.motion.outcomes import Outcome
from polhode.numbers.rows import Doubles
from polhode.proofs.chaos.h_set import Chart, HSet
from polhode.proofs.chaos.homoclinic import Homoclinic, Saddle
from polhode.proofs.chaos.lanes import Lanes
from polhode.proofs.chaos.theorem import Chain
from polhode.proofs.chaos.transit import Image, transit
from polhode.proofs.level import Level

NOISE = 80
ETA = 1e-4
_WIDER, _HIGHER = 0.7, 1.3  # of the image: a next set's width, its height
#: exp(int |A|) of a step multiplies the set's bounds.
SHORTER_STEPS = Untrusted(window=partial(window_approximation.window, turn=0.2))


def fine_of(noise: int) -> int:
    """The grid of states of a noise level."""
    return max(noise + 12, LEAST_FINE)


def charts(
    lanes: Lanes, level: Level, at: Saddle, found: Homoclinic, point: tuple[int, ...]
) -> tuple[list[Chart], list[int]]:
    """Those of N0 and of M2, ..., Mk, and the times of all transits, N0's first."""
    count = max(2, round(found.time / at.period))
    ticks = [round(found.time / count * 2**CLOCK)] * (count - 1)
    ticks.append(round(found.time * 2**CLOCK) - sum(ticks))
    times = np.ldexp(np.cumsum([0, *ticks[:-1]]).astype(float), -CLOCK)
    first = at.point + at.unstable * found.unstable
    last = at.point + at.stable * found.stable
    early = times <= found.ahead
    starts = np.where(early, first[:, None], last[:, None])
    states = lanes.after(starts, np.where(early, times, times - found.time))
    steps = lanes.derivative(states, np.ldexp(np.array(ticks, dtype=float), -CLOCK))
    rates = lanes.field(states)
    out, into = [at.unstable], [at.stable]
    for k in range(count - 1):
        out.append(_flat(level, states[:, k + 1], rates[:, k + 1], steps[k] @ out[-1]))
    for k in range(count - 1, 0, -1):
        back = np.linalg.solve(steps[k], into[0])
        into.insert(0, _flat(level, states[:, k], rates[:, k], back))
    made = [_chart(level, point, at.plane, at.unstable, at.stable, at.point)]
    for k in range(1, count):
        centre = tuple(round(x * 2 ** fine_of(NOISE)) for x in states[:, k].tolist())
        made.append(_chart(level, centre, rates[:, k], out[k], into[k], states[:, k]))
    return made, [round(at.period * 2**CLOCK), *ticks]


def chain(
    level: Level,
    made: list[Chart],
    ticks: list[int],
    size: float,
    first: float,
    multiplier: float,
) -> Chain:
    """A chain of sets, fitted; raises Refused where one does not reach the next.

    ``size``: of N0; ``first``: where M1 is in N0's chart.
    """
    home = HSet(made[0], 0.0, size, size)
    images = [transit(level, home, made[0], ticks[0], NOISE, follow)]
    high = max(_high(images[0]) * _HIGHER, 1e-3 * size)
    width = 0.3 * (min(abs(multiplier), 4.0) - 1.0) * size
    sets = [HSet(made[0], first, min(width, size), high)]
    for k in range(1, len(ticks)):
        target = made[k] if k < len(made) else made[0]
        images.append(transit(level, sets[-1], target, ticks[k], NOISE, follow))
        if k < len(made):
            high = max(_high(images[-1]) * _HIGHER, 1e-3 * size)
            wide = min(size, _WIDER * _reach(images[-1]))
            if not (wide > 0.0 and high < 1e3 * size):
                raise Refused(f"set {k} of the chain is lost: its image is as wide as its noise")
            sets.append(HSet(target, 0.0, wide, high))
    return Chain(home, tuple(sets), tuple(images))


def follow(problem: Problem, times: Sequence[arb], watchers: Sequence[Watcher]) -> Proof:
    """A run of the proof with short steps, which an interrupt ends."""
    found = proof_loop.run(problem, times, untrusted=SHORTER_STEPS, watchers=watchers)
    if found.outcome is Outcome.INTERRUPTED:
        raise KeyboardInterrupt
    return found


def _flat(level: Level, state: Doubles, rates: Doubles, v: Doubles) -> Doubles:
    """A direction in the level and in the plane, of length 1."""
    gradients = _gradients(level, state)
    rows = np.vstack([gradients, rates])
    v = v - rates * (rates @ v) / (rates @ rates)
    v = v - rows.T @ np.linalg.solve(rows @ rows.T, rows @ v)
    return np.asarray(v / np.max(np.abs(v)))


def _gradients(level: Level, state: Doubles) -> Doubles:
    known = level.balls(64).gradients([arb(x) for x in state.tolist()])
    return np.array([[float(x.mid()) for x in row] for row in known])


def _chart(
    level: Level,
    centre: tuple[int, ...],
    rates: Doubles,
    out: Doubles,
    into: Doubles,
    state: Doubles,
) -> Chart:
    pair = [_flat(level, state, rates, v) for v in (out, into)]
    deep = np.column_stack([*_gradients(level, state), rates])
    return Chart(fine_of(NOISE), centre, np.column_stack(pair), deep, rates, ETA)


def _high(image: Image) -> float:
    row = [float(x.abs_upper()) for x in image.turn.tolist()[1]]
    return float(image.shift[1, 0].abs_upper()) + sum(row)


def _reach(image: Image) -> float:
    """How far both edges reach beyond the middle."""
    row = [float(x.abs_upper()) for x in image.turn.tolist()[0]]
    edge = float(abs(image.turn[0, 0]).lower())
    return edge - sum(row[1:]) - float(image.shift[0, 0].abs_upper())

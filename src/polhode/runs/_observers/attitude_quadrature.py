"""Attitude and angles of a run in extended, from its states at more times than those asked for.

The state is integrated alone, to the bit as in a run without these outputs, and read at the nodes
of panels of a few steps each.  What a panel turns by is a quadrature over its nodes
(:mod:`polhode.equations.attitude_phase`); a panel that is not settled by them is split and
integrated once more, from the run's own states.  One state more costs a tenth of a step; in double
it would be a fifth, and lanes are cheaper (:mod:`polhode.runs._observers.attitude_lanes`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import ClassVar, NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.common.progress import Progress
from polhode.equations.attitude_phase import Panels, Turned
from polhode.motion.outcomes import Outcome
from polhode.motion.protocols import Motion
from polhode.numbers.conversion import exactly, to_double, to_extended
from polhode.numbers.gauss_lobatto import Lobatto, enough, lobatto
from polhode.numbers.number_types import EXTENDED
from polhode.numbers.rows import Extendeds, beside, flat
from polhode.runs._observers import attitude_assembly
from polhode.runs._observers.panel_splitting import Halves
from polhode.runs._observers.protocol import Observed
from polhode.runs.problem.problem import Problem
from polhode.scenes.scene import Scene
from polhode.taylor.backend.time_grid import Times, exact_sum

#: Taylor steps: a shorter run's cost less than what is added here.
SHORTEST_RUN = 40

#: Nodes of all panels; more states than these are not kept at a time.
MOST_NODES = 1_000_000

#: Nodes a step at most; with more, as outputs are that close, one system is cheaper.  In plain
#: runs it takes 2.0 with attitude, with angles 1.8 to 8 (of 20 tops 3.8 in the median; past a close
#: pole 20 and more).  Panels take 1.4 to 1.9 with 6 nodes a step, 1.8 to 2.6 with 9, 2.5 to 3.5
#: with 16; past close poles, where they are split, one more.
MOST_A_STEP, MOST_WITH_ANGLES = 8, 16

#: How many times the other rates the spin about the third axis may be: psi is what is left of the
#: whole rotation without phi, and has fewer digits, the more of it phi is.
MOST_SPIN = 256.0

#: Taylor steps of a panel at most, by the mean of so many first ones: the first number with which
#: most panels among those are settled.
STEPS, PILOT = (8.0, 6.0, 4.0, 2.0), 128

_MOSTLY = 0.9

#: In Taylor steps: panels up to these lengths have as many nodes as the longest; the first two.
_LENGTHS = (1e-6, 1e-3, 0.03, 0.2, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0)
_TOGETHER = 512  # panels, so that their arrays stay in a processor's cache


class Group(NamedTuple):
    """Panels with one rule: the indices of their nodes among the times, and by what those are late.

    ``begin`` and ``length``: of the panels.
    """

    rule: Lobatto
    nodes: npt.NDArray[np.intp]
    begin: Extendeds
    length: Extendeds
    shift: Extendeds | None


def fits(problem: Problem) -> bool:
    """Whether the states are as right as extended can have them, and psi as right as those."""
    scene = problem.scene
    of_spin = "angles" in scene.modelled and _spins(scene)
    return problem.number.name == "extended" and problem.full and not of_spin


def planned(problem: Problem, times: Times) -> Quadrature | None:
    """The way, for outputs at these times; None where one system is better."""
    grid = flat(times.grid)
    if grid[-1] == 0:  # the start alone
        return None
    found = _first_steps(problem, grid[-1])
    if found is None:
        return None
    step, steps = found
    knots = grid if grid[0] == 0 else np.concatenate([grid[:1] * 0, grid])
    gaps = np.diff(knots)
    parts = np.maximum(np.ceil(np.abs(gaps) / (steps * step)), 1).astype(np.intp)
    if parts.sum() * enough(steps, _digits(problem)) + len(knots) > MOST_NODES:
        return None
    which = np.repeat(np.arange(len(gaps)), parts)
    inner = np.arange(len(which)) - np.repeat(np.cumsum(parts) - parts, parts)
    begin = knots[which] + gaps[which] * (inner / parts[which].astype(grid.dtype))
    length = np.diff(np.concatenate([begin, knots[-1:]]))
    size = np.searchsorted(np.array(_LENGTHS[:-1]), (np.abs(gaps) / parts / step).astype(float))
    counts = np.array([enough(x, _digits(problem)) if x > _LENGTHS[0] else 2 for x in _LENGTHS])
    count = counts[size][which]
    most = MOST_WITH_ANGLES if "angles" in problem.scene.modelled else MOST_A_STEP
    if (count - 1).sum() - len(grid) > most * abs(grid[-1]) / step:
        return None
    first = np.cumsum(count - 1) - (count - 1)
    every = np.empty(first[-1] + count[-1], dtype=grid.dtype)
    every[-1] = knots[-1]
    stretches = []
    for k in range(0, len(count), _TOGETHER):
        part, groups = count[k : k + _TOGETHER], []
        for n in sorted(set(part.tolist())):
            rule, chosen = lobatto(n), k + np.flatnonzero(part == n)
            nodes = first[chosen][:, None] + np.arange(n)
            b, long = begin[chosen], length[chosen]
            at, rest = exact_sum(b[:, None], long[:, None] * rule.nodes.astype(grid.dtype))
            every[nodes[:, :-1]] = at[:, :-1]
            rest[:, -1] = 0
            groups.append(Group(rule, nodes, b, long, -rest if rest.any() else None))
        stretches.append(tuple(groups))
    if not (np.diff(np.abs(every)) > 0).all():
        return None
    outputs = first[np.cumsum(parts) - parts]
    outputs = np.append(outputs, len(every) - 1)[len(knots) - len(grid) :]
    return Quadrature(Times.of_grid(every, problem.number), every, outputs, tuple(stretches))


def _digits(problem: Problem) -> float:
    return problem.number.bits * math.log10(2) + 0.5


def _spins(scene: Scene) -> bool:
    """Whether phi grows so much faster than psi that their sum has fewer digits than psi."""
    p, q, r = map(to_double, scene.omega)
    swing = math.sqrt(to_double(scene.pendulum_rate_squared))
    return abs(r) > MOST_SPIN * max(math.hypot(p, q), swing)


def _first_steps(problem: Problem, end: np.longdouble) -> tuple[np.longdouble, float] | None:
    """The mean of a run's first Taylor steps, and how many of them a panel holds.

    None for a run that is too short.
    """
    from polhode.taylor.integrator.compiled import Compiled

    leading = Compiled(problem.prepared().blueprint)
    start, zero = leading.state.copy(), end * 0
    count = leading.heyoka.propagate_until(end, max_steps=PILOT)[3]
    reached = leading.heyoka.time
    step = abs(reached) / count
    if abs(end) < SHORTEST_RUN * step:
        leading.release()
        return None
    halves = Halves(problem)
    for steps in STEPS:
        parts = math.ceil(count / steps)
        rule = lobatto(enough(steps, _digits(problem)))
        length = np.full(parts, reached / parts)
        begin = np.arange(parts) * length
        times = (begin[:, None] + length[:, None] * rule.nodes.astype(end.dtype)).ravel()
        every, index = np.unique(np.abs(np.append(times, zero)), return_inverse=True)
        leading.stand(start)
        found = leading.grid(np.copysign(every, end))
        at = found[index[:-1]].T.reshape(6, parts, -1)
        if halves.enough(Panels(begin, length, at[:3], at[3:], None), rule) >= _MOSTLY:
            break
    leading.release()
    return step, steps


@dataclass(frozen=True, eq=False)
class Quadrature:
    """Panels between the outputs.

    ``times``: of the outputs and of the panels' nodes, in the run's unit; ``grid``: the same.
    ``outputs``: which of them were asked for.  ``stretches``: consecutive panels, by rule.
    """

    times: Times
    grid: Extendeds
    outputs: npt.NDArray[np.intp]
    stretches: tuple[tuple[Group, ...], ...]
    share: ClassVar[float] = 0.9

    def observe(
        self, problem: Problem, motion: Motion, found: Observed, progress: Progress | None
    ) -> Observed:
        """Rows with quaternion, psi and phi; raises CannotObserve next to a pole."""
        outcome, reached = found.outcome, found.reached
        states, end = flat(found.rows), 0
        turned: list[Turned] = []
        columns: Extendeds = np.ascontiguousarray(states.T)
        late, halves = _late(motion.begun, self.grid), Halves(problem)
        try:
            for stretch in self.stretches:
                parts: list[Turned] = []
                done = end
                for group in stretch:
                    nodes = group.nodes[group.nodes[:, -1] < len(states)]
                    if len(nodes):
                        parts += halves.settled(_panels(group, nodes, columns, late), group.rule)
                        done = max(done, int(nodes[-1, -1]))
                turned += parts
                end = done
                if progress is not None:
                    progress(self.share + (1 - self.share) * (end + 1) / len(states), motion.steps)
        except KeyboardInterrupt:
            outcome = Outcome.INTERRUPTED
            reached = exactly(self.grid[end]) * problem.unit
        kept = self.outputs[self.outputs <= end] if len(states) else self.outputs[:0]
        if end:
            times = np.abs(self.grid[kept])
            more = attitude_assembly.rows(problem, turned, states[kept], times)
        else:  # the start, or nothing
            first = problem.prepared(problem.scene.modelled).first
            more = flat(first)[: len(kept), states.shape[1] :]
        return found._replace(rows=beside(states[kept], more), outcome=outcome, reached=reached)


def _panels(
    group: Group, nodes: npt.NDArray[np.intp], columns: Extendeds, late: Extendeds | None
) -> Panels:
    """A group's panels as far as the run came."""
    at, some = columns[:, nodes], slice(len(nodes))
    shift = None if group.shift is None else group.shift[some]
    if late is not None:
        shift = late[nodes] + (0 if shift is None else shift)
    return Panels(group.begin[some], group.length[some], at[:3], at[3:], shift)


def _late(begun: Sequence[Fraction], grid: Extendeds) -> Extendeds | None:
    """By how much states are later than their times, which are rounded anew in later chunks."""
    offsets = [offset for offset in begun if offset]
    if not offsets:
        return None
    found, kind = np.zeros_like(grid), grid.dtype.type
    for offset in offsets:
        high = to_extended(offset) if kind is np.longdouble else kind(offset)
        low = kind(offset - exactly(high))
        first = np.searchsorted(np.abs(grid), abs(high), side="right")
        times = grid[first:]
        near, rest = exact_sum(times, -high)
        since = Times.of_grid(times, EXTENDED).since(offset)
        found[first:] = (since - near) - rest + low
    return found

"""The front: a scene's states at exact times, to any number of digits, with their errors.

A run in double goes ahead, block by block its intervals are refined, and each block starts from
the exact state in which the one before ended. The cost is linear in time, and what is held at a
time is one run in double of some thousand steps, one block, and 300 bytes an interval for the
error estimate.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from polhode.common.interrupts import Progress
from polhode.motion.outcomes import Outcome
from polhode.numbers.number_types import Doubles, Integers
from polhode.refined import double_run
from polhode.refined.attitude import Following, RefinedAttitude, turns
from polhode.refined.collocation_tables import tables
from polhode.refined.compiled_field import CannotRefine, IntervalsTooLong, Limbs, TooFarOff, kernels
from polhode.refined.deferred_correction import BlockConstants, Intervals, SolvedBlock, solve
from polhode.refined.double_run import STEPS, Base, RationalSystem, base, on_grid, with_rates
from polhode.scenes.scene import Scene
from polhode.taylor.heyoka import one_blas_thread, one_thread

# --- error estimate -------------------------------------------------------------------------------
#
# How far off a refined run is: what each interval adds, carried to the output times.
#
# An error made in interval n reaches the time t times Lambda_{n+1}, the derivative of the state at
# t by the state at the interval's end; Lambda_n = Lambda_{n+1} Phi_n, so one pass backwards tells
# them all.  Three parts are added: what the last correction left, what collocation neglects, and
# rounding, of which only the squares add up.  kappa(t) = |Lambda_0|, largest row sum.


#: Of the ends' error to the square of the stages' last Legendre coefficients: measured 1e-6 to
#: 1e-5 over all the motions of the tests.
DISCRETISATION = 1e-4

#: Beyond it the product of the transitions, in double, says nothing any more.
LARGEST_KAPPA = 1e14

_MOST = 32  # outputs that have an estimate of their own


@dataclass(frozen=True, eq=False)
class ChainStretch:
    """Successive intervals: transitions (K, 6, 6) in the scene's unit of time, ``errors``
    (K,) in the base's own, in which w is ``scale`` times smaller."""

    transitions: Doubles
    errors: Doubles
    scale: float


@dataclass(frozen=True, eq=False)
class OutputSide:
    """The interval to an output time, from the edge of that index, counted over the whole run."""

    edge: int
    transition: Doubles
    error: float
    scale: float


class Estimate(NamedTuple):
    """At each output: the errors of w (scene's unit) and gamma, (C, 2), and kappa, (C,).

    Errors are infinite where kappa is too large for any estimate.
    """

    errors: Doubles
    kappa: Doubles


def errors_made(unfinished: Doubles, tails: Doubles) -> Doubles:
    """The error that an interval adds, but for rounding."""
    return unfinished + DISCRETISATION * tails * tails


def estimate(
    stretches: Sequence[ChainStretch], sides: Sequence[OutputSide], rounding: float
) -> Estimate:
    """Of at most 32 outputs; another one takes the larger of its neighbours'."""
    count = len(sides)
    chosen = sorted({round(i) for i in np.linspace(0, count - 1, min(count, _MOST))})
    some = _estimate(stretches, [sides[i] for i in chosen], rounding)
    above = np.searchsorted(chosen, np.arange(count))
    exact = np.array(chosen)[above] == np.arange(count)
    below = np.where(exact, above, above - 1)
    return Estimate(
        np.maximum(some.errors[above], some.errors[below]),
        np.maximum(some.kappa[above], some.kappa[below]),
    )


def _estimate(
    stretches: Sequence[ChainStretch], sides: Sequence[OutputSide], rounding: float
) -> Estimate:
    count = len(sides)
    sums, squares = np.zeros((count, 2)), np.zeros((count, 2))
    carried = np.zeros((count, 6, 6))
    for c, side in enumerate(sides):
        own = _reach(np.eye(6), side.scale)
        sums[c], squares[c] = own * side.error, own * own
    first = sum(len(stretch.errors) for stretch in stretches)
    first_met = count  # outputs from here on have been met
    first_met = _first_inside(sides, first_met, first, carried)
    for stretch in reversed(stretches):
        size = len(stretch.errors)
        first -= size
        carried_to = np.zeros((size, count, 6, 6))  # Lambda at each interval's end
        for n in range(size - 1, -1, -1):
            first_met = _first_inside(sides, first_met, first + n + 1, carried)
            carried_to[n, first_met:] = carried[first_met:]
            np.matmul(carried_to[n, first_met:], stretch.transitions[n], out=carried[first_met:])
        reach = _reach(carried_to, stretch.scale)
        sums += np.einsum("nci,n->ci", reach, stretch.errors)
        squares += (reach * reach).sum(axis=0)
    _first_inside(sides, first_met, 0, carried)
    kappa = np.abs(carried).sum(axis=-1).max(axis=-1)
    errors = sums + rounding * np.sqrt(squares)
    errors[~(kappa < LARGEST_KAPPA)] = np.inf
    return Estimate(errors, kappa)


def _first_inside(sides: Sequence[OutputSide], first_met: int, edge: int, carried: Doubles) -> int:
    """Enter the outputs whose side begins at this edge or later; the first one that is in."""
    while first_met and sides[first_met - 1].edge >= edge:
        first_met -= 1
        carried[first_met] = sides[first_met].transition
    return first_met


def _reach(carried: Doubles, scale: float) -> Doubles:
    """What an error of size 1, in a unit in which w is ``scale`` times smaller, becomes: w, gamma.

    ``carried``: (..., 6, 6); the result (..., 2).
    """
    weights = np.array([scale] * 3 + [1.0] * 3)
    rows = np.abs(carried) @ weights
    return np.stack([rows[..., :3].max(axis=-1), rows[..., 3:].max(axis=-1)], axis=-1)


# --- interval blocks ------------------------------------------------------------------------------
#
# Blocks: successive intervals of a run in double, and the output times that lie in them.


WIDTH = 160  # intervals of a chain; the arrays of more would leave the cache
_ROOM = 2 * WIDTH  # intervals of a block, those that lead to outputs included


@dataclass(frozen=True, eq=False)
class RefinedBlock:
    """A chain between ``edges``, and an interval of its own from an edge to each output time.

    ``clocks``: the output times by the base's clock, exact; ``parents``: the edges before them,
    counted from the block's first.  ``state``: limbs (6, L) of the exact state at the first edge.
    """

    base: Base
    edges: Doubles
    clocks: tuple[Fraction, ...]
    parents: Integers
    state: Doubles
    limbs: Limbs

    @property
    def chain(self) -> int:
        """Intervals of the chain."""
        return len(self.edges) - 1

    def intervals(self, nodes: Doubles) -> Intervals:
        """All intervals with the guesses of the run in double; ``nodes``: c_j."""
        limbs, chain = self.limbs, self.chain
        starts = np.concatenate([np.arange(chain), self.parents])
        begin = self.edges[starts]
        chained = limbs.split_doubles(np.diff(self.edges))  # exact: edges lie on a grid
        sides = [
            limbs.split(t - Fraction(start))
            for t, start in zip(self.clocks, begin[chain:].tolist(), strict=True)
        ]
        lengths = np.concatenate([chained, np.array(sides).reshape(-1, limbs.count).T], axis=1)
        times = begin + nodes[:, None] * lengths.sum(axis=0)
        outputs = np.array([float(t) for t in self.clocks])
        ends = self.base.states(np.concatenate([self.edges[1:], outputs]))
        states = np.empty((6, limbs.count, 1 + ends.shape[1]))
        states[:, :, 0] = self.state
        states[:, :, 1:] = limbs.split_doubles(ends).swapaxes(0, 1)
        return Intervals(states, 1, starts, chain, self.base.states(times), lengths)

    def halves(self, which: Any, first: int) -> tuple[Any, Any]:
        """Where to insert which edges, ``first`` being the index of the block's first one.

        ``which``: of the intervals those that are too long.  One that leads to an output has
        the interval halved in which the output lies.
        """
        chain = self.chain
        long = {*np.flatnonzero(which[:chain]).tolist(), *self.parents[which[chain:]].tolist()}
        ends = [*self.edges.tolist(), float(self.clocks[-1]) if self.clocks else 0.0]
        places = sorted(long)
        middles = on_grid(np.array([(ends[i] + ends[i + 1]) / 2 for i in places]))
        return np.array([first + i + 1 for i in places]), middles


def cut(
    base: Base,
    edges: Doubles,
    at: int,
    width: int,
    clocks: Sequence[Fraction],
    state: Doubles,
    limbs: Limbs,
) -> RefinedBlock:
    """The block from the edge ``at``, of so many intervals or as many as the outputs leave room.

    ``clocks``: the output times ahead.  Behind the last edge of a final run they belong to it.
    """
    window = edges[at : at + width + 1]
    ahead = np.array([float(t) for t in clocks[:_ROOM]])
    before = np.searchsorted(ahead, window, side="left")  # outputs before each edge
    before[0] = 0
    chain = int(np.flatnonzero(np.arange(len(window)) + before <= _ROOM)[-1])
    count = int(before[chain])
    at_last_edge = base.final and at + chain == len(edges) - 1
    if at_last_edge or chain == 0:
        count = min(len(ahead), _ROOM - chain)
        if chain == 0 and not at_last_edge:  # a crowd of outputs before the next edge
            count = min(count, int(np.searchsorted(ahead, window[1], side="left")))
    window = window[: chain + 1]
    parents = np.maximum(np.searchsorted(window, ahead[:count], side="right") - 1, 0)
    return RefinedBlock(base, window, tuple(clocks[:count]), parents, state, limbs)


# --- refinement -----------------------------------------------------------------------------------


STEPS_AN_INTERVAL = 6
_DRIFT = 2e-11  # of the double run at a block's end, beyond which it restarts there
_REDOS = 40  # of one block
_RARE = 0.02  # of a block's intervals: so few are halved, of more the nodes are increased
_MORE_NODES = 2


@dataclass(frozen=True)
class Accuracy:
    """What is asked of each interval: the error ``target`` of its end, in numbers of ``limbs``."""

    target: float
    limbs: Limbs
    sweeps: int

    def nodes(self, m: int) -> int:
        """Gauss nodes on an interval of m steps.

        Legendre coefficients of the field fall by exp(2 asinh(15/m)) from one to the next in their
        square: measured over bodies of all kinds.
        """
        return math.ceil(-math.log(self.target / 100) / (2 * math.asinh(15 / m))) + 3

    @property
    def tail(self) -> float:
        """The last Legendre coefficient that may stand."""
        return 2 * math.sqrt(1e4 * self.target)


#: Limbs for the digits wanted; few kinds, because each has a field of its own to compile.
_KINDS = (
    *(Limbs(4, 24), Limbs(5, 23), Limbs(6, 23), Limbs(7, 23), Limbs(8, 23)),
    *(Limbs(10, 22), Limbs(12, 22), Limbs(15, 22), Limbs(19, 22)),
)
_GUARD_BITS = 3
MOST_DIGITS = int((_KINDS[-1].bits - _GUARD_BITS) / math.log2(10))


def accuracy(digits: int) -> Accuracy:
    """Enough for so many digits on each interval, 34 for quad; raises CannotRefine above 130."""
    bits = digits * math.log2(10) + _GUARD_BITS
    for limbs in _KINDS:
        if limbs.bits >= bits:
            return Accuracy(10.0**-digits, limbs, 3 + math.ceil(digits / 10))
    raise CannotRefine(f"{digits} digits are more than {MOST_DIGITS}")


QUAD = accuracy(34)


@dataclass(frozen=True)
class RefinedStates:
    """States at the times asked for, in the form's axes and the scene's own unit of time.

    ``states``: a row (w1 w2 w3 g1 g2 g3) a time, integers times 2**-``bits``; fewer than the times
    asked for where the run was ``stopped`` at the time ``reached``.  ``estimate``: their errors
    and the condition kappa.  ``steps``: of the run in double.  ``attitudes``: at the
    times, where they were asked for.
    """

    times: tuple[Fraction, ...]
    states: list[list[int]]
    bits: int
    estimate: Estimate
    steps: int
    intervals: int
    reached: Fraction
    stopped: Outcome | None
    attitudes: list[RefinedAttitude] | None

    def exactly(self, i: int) -> list[Fraction]:
        """The i-th state as rationals."""
        return [Fraction(x, 1 << self.bits) for x in self.states[i]]


def refine(
    scene: Scene,
    times: Sequence[Fraction],
    goal: Accuracy = QUAD,
    m: int = STEPS_AN_INTERVAL,
    progress: Progress | None = None,
    max_steps: int | None = None,
    following: Following | None = None,
) -> RefinedStates:
    """The motion of a scene at times (inside its frame), of one sign, away from 0, exact rationals.

    ``m``: steps of the run in double to an interval; another one gives a run to compare with.
    ``max_steps``: of the run in double.  ``following``: the attitude at the start.  Ctrl-C stops
    the run at the block it is at.  Raises CannotRefine where the motion cannot be refined, BadInput
    for another form than the principal one.
    """
    backward = times[-1] < 0
    exact = double_run.rational_system(scene, goal.limbs.finest + 64, backward)
    run = _Run(exact, [*map(abs, times)], goal, m, following, -1 if backward else 1)
    with one_thread(), one_blas_thread():
        stopped = run.to_the_end(progress, max_steps)
    reached = run.origin if stopped else abs(times[-1])
    whole = min(len(run.states), len(run.sides))  # an interrupt may have come between the two
    return RefinedStates(
        times=tuple(times[:whole]),
        states=run.states[:whole],
        bits=goal.limbs.finest,
        estimate=estimate(run.stretches, run.sides[:whole], 2.0**-goal.limbs.bits),
        steps=run.steps,
        intervals=sum(len(stretch.errors) for stretch in run.stretches) + whole,
        reached=-reached if backward else reached,
        stopped=stopped,
        attitudes=None if following is None else run.attitudes[:whole],
    )


class _Run:
    """A refinement under way: an exact state at an edge of the present run in double.

    ``sense``: -1 of a motion that runs backward in time, which is the one with -w forwards.
    """

    def __init__(
        self,
        exact: RationalSystem,
        times: Sequence[Fraction],
        goal: Accuracy,
        m: int,
        following: Following | None = None,
        sense: int = 1,
    ) -> None:
        self.sense = sense
        self.following, self.attitudes = following, list[RefinedAttitude]()
        self.system, self.wanted, self.m = exact, goal, m
        self.times = times
        self.states: list[list[int]] = []
        self.stretches: list[ChainStretch] = []
        self.sides: list[OutputSide] = []
        self.steps = 0
        self.origin = Fraction(0)
        self._state = exact.state
        self._width = WIDTH
        self._edges_passed = 0
        self._nodes = goal.nodes(m)

    def to_the_end(self, progress: Progress | None, max_steps: int | None) -> Outcome | None:
        """Base after base, until every output is there; else why not."""
        try:
            while len(self.states) < len(self.times):
                if max_steps is not None and self.steps >= max_steps:
                    return Outcome.STEP_LIMIT
                most = min(STEPS, STEPS if max_steps is None else max_steps - self.steps)
                now = base(self.system, self._state, self.origin, self.times[-1], self.m, most)
                self.steps += now.steps
                self._constants = self._constants_in(now.unit)
                self._through(now, progress)
        except KeyboardInterrupt:
            return Outcome.INTERRUPTED
        return None

    def _constants_in(self, unit: int) -> BlockConstants:
        limbs = self.wanted.limbs
        split = np.array([limbs.split(k) for k in self.system.coefficients_in(unit)])
        return BlockConstants(
            limbs,
            kernels(limbs),
            tables(limbs, self._nodes),
            split,
            self.wanted.target,
            self.wanted.sweeps,
        )

    def _through(self, now: Base, progress: Progress | None) -> None:
        """The blocks of one base, until its end or until it has drifted too far."""
        limbs = self.wanted.limbs
        state = np.array([limbs.split(x) for x in with_rates(self._state, -now.unit)])
        clocks = [now.clock(t) for t in self.times[len(self.states) :]]
        edges, at, redos = now.edges, 0, 0
        while clocks:
            block = cut(now, edges, at, self._width, clocks, state, limbs)
            try:
                work = block.intervals(self._constants.tables.nodes)
                solved = solve(self._constants, work, self.following is not None)
                self._check_tails(solved)
                self._turn(work, solved)
            except TooFarOff as far:
                if far.good < 1:
                    raise CannotRefine("the run in double drifts within one interval") from None
                self._width = far.good
            except IntervalsTooLong as long:
                edges = np.insert(edges, *block.halves(long.which, at))
            except _TooFewNodes:
                self._nodes += _MORE_NODES
                self._constants = self._constants_in(now.unit)
            else:
                redos = -1
                self._keep(block, solved, now.unit)
                clocks = clocks[len(block.clocks) :]
                at += block.chain
                state = limbs.renormalised(solved.states[:, :, block.chain])
                self._state = with_rates([limbs.value(x) for x in state], now.unit)
                self.origin = now.time(float(edges[at]))
                self._width = min(2 * self._width, WIDTH)
                if progress is not None:
                    end = self.times[-1]  # 0 where the start alone is asked for
                    progress(float(self.origin / end) if end else 1.0, self.steps)
                drifted = block.chain and solved.drift[block.chain - 1] > _DRIFT
                if drifted or (at == len(edges) - 1 and not now.final):
                    return
            redos += 1
            if redos > _REDOS:
                raise CannotRefine("a block cannot be refined")

    def _turn(self, work: Intervals, solved: SolvedBlock) -> None:
        """The attitude over a block, where it is asked for."""
        if self.following is None:
            return
        assert solved.stages is not None
        turn = turns(self._constants, solved.stages, work.lengths, self.wanted.tail)
        nodes, lengths = self._constants.tables.nodes, work.lengths.sum(axis=0)
        self.attitudes += self.following.advance(turn, work.chain, work.starts, nodes, lengths)

    def _check_tails(self, solved: SolvedBlock) -> None:
        """Raise TooLong or _TooFewNodes where the nodes do not resolve the motion."""
        large = solved.tails > self.wanted.tail
        if large.mean() > _RARE:
            raise _TooFewNodes
        if large.any():
            raise IntervalsTooLong(large)

    def _keep(self, block: RefinedBlock, solved: SolvedBlock, unit: int) -> None:
        """Outputs and error estimate of a block."""
        limbs, chain, scale = self.wanted.limbs, block.chain, 2.0**unit
        ends = solved.states[:, :, block.chain + 1 :]
        for row in ends.transpose(2, 0, 1).tolist():
            whole = [limbs.integer(x) for x in row]
            rates = [self.sense * _shifted(x, unit) for x in whole[:3]]
            self.states.append(rates + whole[3:])
        ratio = np.array([scale] * 3 + [1.0] * 3)
        transitions = solved.transitions * (ratio[:, None] / ratio)
        errors = errors_made(solved.unfinished, solved.tails)
        if chain:
            self.stretches.append(ChainStretch(transitions[:chain], errors[:chain], scale))
        for i, parent in enumerate(block.parents, start=chain):
            edge = self._edges_passed + int(parent)
            self.sides.append(OutputSide(edge, transitions[i], float(errors[i]), scale))
        self._edges_passed += chain


class _TooFewNodes(Exception):
    """Many intervals of a block need more nodes."""


def _shifted(x: int, by: int) -> int:
    return x << by if by >= 0 else x >> -by

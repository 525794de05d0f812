"""The front: a scene's states at exact times, to any number of digits, with their errors.

A run in double goes ahead, block by block its intervals are refined, and each block starts from
the exact state in which the one before ended.  The cost is linear in time, and what is held at a
time is one run in double of some thousand steps, one block, and 300 bytes an interval for the
error estimate.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from polhode.common.interrupts import Progress
from polhode.numbers.rows import Doubles
from polhode.refined.attitude import Attitude, Following
from polhode.refined.attitude_correction import turns
from polhode.refined.collocation_tables import tables
from polhode.refined.compiled_field import kernels
from polhode.refined.deferred_correction import Constants, Intervals, Solved, solve
from polhode.refined.double_run import STEPS, Base, base
from polhode.refined.error_estimate import Estimate, Side, Stretch, estimate, made
from polhode.refined.errors import CannotRefine, TooFarOff, TooLong
from polhode.refined.expansions import Limbs
from polhode.refined.interval_blocks import WIDTH, Block, cut
from polhode.refined.scaled_problem import RationalSystem, rational_system, with_rates
from polhode.scenes.scene import Scene
from polhode.taylor.heyoka import one_blas_thread, one_thread

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

INTERRUPTED, STEP_LIMIT = "interrupted", "step limit"


@dataclass(frozen=True)
class Motion:
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
    stopped: str | None
    attitudes: list[Attitude] | None

    def exactly(self, i: int) -> list[Fraction]:
        """The i-th state as rationals."""
        return [Fraction(x, 1 << self.bits) for x in self.states[i]]


def refine(
    scene: Scene,
    times: Sequence[Fraction],
    wanted: Accuracy = QUAD,
    m: int = STEPS_AN_INTERVAL,
    progress: Progress | None = None,
    max_steps: int | None = None,
    following: Following | None = None,
) -> Motion:
    """The motion of a scene at times (inside its frame), of one sign, away from 0, exact rationals.

    ``m``: steps of the run in double to an interval; another one gives a run to compare with.
    ``max_steps``: of the run in double.  ``following``: the attitude at the start.  Ctrl-C stops
    the run at the block it is at.  Raises CannotRefine where the motion cannot be refined, BadInput
    for another form than the principal one.
    """
    backward = times[-1] < 0
    exact = rational_system(scene, wanted.limbs.finest + 64, backward)
    run = _Run(exact, [abs(t) for t in times], wanted, m, following)
    with one_thread(), one_blas_thread():
        stopped = run.to_the_end(progress, max_steps)
    reached = run.origin if stopped else abs(times[-1])
    whole = min(len(run.found), len(run.sides))  # an interrupt may have come between the two
    return Motion(
        times=tuple(times[:whole]),
        states=[_turned(row, backward) for row in run.found[:whole]],
        bits=wanted.limbs.finest,
        estimate=estimate(run.stretches, run.sides[:whole], 2.0**-wanted.limbs.bits),
        steps=run.steps,
        intervals=sum(len(stretch.made) for stretch in run.stretches) + whole,
        reached=-reached if backward else reached,
        stopped=stopped,
        attitudes=None if following is None else run.attitudes[:whole],
    )


def _turned(row: list[int], backward: bool) -> list[int]:
    """A state of the motion that runs forward as one of the scene's."""
    return [-x for x in row[:3]] + row[3:] if backward else row


class _Run:
    """A refinement under way: an exact state at an edge of the present run in double."""

    def __init__(
        self,
        exact: RationalSystem,
        times: Sequence[Fraction],
        wanted: Accuracy,
        m: int,
        following: Following | None = None,
    ) -> None:
        self.following, self.attitudes = following, list[Attitude]()
        self.system, self.wanted, self.m = exact, wanted, m
        self.times = list(times)
        self.found: list[list[int]] = []
        self.stretches: list[Stretch] = []
        self.sides: list[Side] = []
        self.steps = 0
        self.origin = Fraction(0)
        self._state = exact.state
        self._width = WIDTH
        self._edges_passed = 0
        self._nodes = wanted.nodes(m)

    def to_the_end(self, progress: Progress | None, max_steps: int | None) -> str | None:
        """Base after base, until every output is there; else why not."""
        try:
            while len(self.found) < len(self.times):
                if max_steps is not None and self.steps >= max_steps:
                    return STEP_LIMIT
                most = min(STEPS, STEPS if max_steps is None else max_steps - self.steps)
                end = self.times[-1]
                now = base(self.system, self._state, self.origin, end, self.m, most)
                self.steps += now.steps
                self._constants = self._constants_in(now.unit)
                self._through(now, progress)
        except KeyboardInterrupt:
            return INTERRUPTED
        return None

    def _constants_in(self, unit: int) -> Constants:
        limbs = self.wanted.limbs
        split = np.array([limbs.split(k) for k in self.system.coefficients_in(unit)])
        return Constants(
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
        clocks = [now.clock(t) for t in self.times[len(self.found) :]]
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
            except TooLong as long:
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
                self._advance(now, float(edges[at]), state)
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

    def _advance(self, now: Base, clock: float, state: Doubles) -> None:
        """Go on from an exact state at a time of the base's clock."""
        limbs = self.wanted.limbs
        self._state = with_rates([limbs.value(x) for x in state], now.unit)
        self.origin = now.time(clock)

    def _turn(self, work: Intervals, solved: Solved) -> None:
        """The attitude over a block, where it is asked for."""
        if self.following is None:
            return
        assert solved.stages is not None
        found = turns(self._constants, solved.stages, work.lengths, self.wanted.tail)
        nodes, lengths = self._constants.tables.nodes, work.lengths.sum(axis=0)
        self.attitudes += self.following.advance(found, work.chain, work.starts, nodes, lengths)

    def _check_tails(self, solved: Solved) -> None:
        """Raise TooLong or _TooFewNodes where the nodes do not resolve the motion."""
        large = solved.tails > self.wanted.tail
        if large.mean() > _RARE:
            raise _TooFewNodes
        if large.any():
            raise TooLong(large)

    def _keep(self, block: Block, solved: Solved, unit: int) -> None:
        """Outputs and error estimate of a block."""
        limbs, chain, scale = self.wanted.limbs, block.chain, 2.0**unit
        ends = solved.states[:, :, block.chain + 1 :]
        for row in ends.transpose(2, 0, 1).tolist():
            whole = [limbs.integer(x) for x in row]
            self.found.append([_shifted(x, unit) for x in whole[:3]] + whole[3:])
        ratio = np.array([scale] * 3 + [1.0] * 3)
        transitions = solved.transitions * (ratio[:, None] / ratio)
        errors = made(solved.unfinished, solved.tails)
        if chain:
            self.stretches.append(Stretch(transitions[:chain], errors[:chain], scale))
        for i, parent in enumerate(block.parents, start=chain):
            edge = self._edges_passed + int(parent)
            self.sides.append(Side(edge, transitions[i], float(errors[i]), scale))
        self._edges_passed += chain


class _TooFewNodes(Exception):
    """Many intervals of a block need more nodes."""


def _shifted(x: int, by: int) -> int:
    return x << by if by >= 0 else x >> -by

"""The sweeps over a block of intervals: exact defects, corrections in double.

On every interval, S the state at its start, the stages X_j and the end X satisfy

    X_j = S + sum_i A_ji H f(X_i),    X = S + sum_i b_i H f(X_i),

Gauss collocation, whose ends are good to the square of what the stages neglect. Of the present
x, the defect r = S + A H f(x) - x is computed in limbs; the correction E of x, e of S then
solves

    E = e + r + A (H J E),    e' = e + r_end + b (H J E),

in double, to first order. The transition of an interval follows from Y(t), the inverse of the
state's derivative by the state at the middle, Y' = -Y J: with it e' = Phi e + delta without any
iteration, Phi = Y(1)^-1 Y(0), delta = r_end + Y(1)^-1 sum_j b_j Y_j H J r_j.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from polhode.numbers.number_types import Doubles, Integers
from polhode.refined.collocation_tables import LARGEST_FIELD, Tables
from polhode.refined.compiled_field import (
    COEFFICIENTS,
    VARIABLES,
    CannotRefine,
    IntervalsTooLong,
    Kernels,
    Limbs,
    Stalled,
    TooFarOff,
)

# --- linear recursion -----------------------------------------------------------------------------
#
# The recursion e_{n+1} = Phi_n e_n + delta_n over a block: the one thing in sequence.


class LinearChain:
    """The transition matrices of successive intervals, (K, 6, 6), cut into about sqrt(K) chunks.

    All chunks advance together; then their ends are joined, one after the other.
    """

    def __init__(self, transitions: Doubles) -> None:
        count, n, _ = transitions.shape
        self._count = count
        self._long = max(1, math.isqrt(count))
        self._chunks = -(-count // self._long)
        padded = np.broadcast_to(np.eye(n), (self._chunks * self._long, n, n)).copy()
        padded[:count] = transitions
        self._steps = padded.reshape(self._chunks, self._long, n, n)
        self._products = np.empty_like(self._steps)
        self._products[:, 0] = self._steps[:, 0]
        for i in range(1, self._long):
            np.matmul(self._steps[:, i], self._products[:, i - 1], out=self._products[:, i])

    def solve(self, sources: Doubles) -> Doubles:
        """e_1 ... e_K, (K, 6), from e_0 = 0 and delta_0 ... delta_{K-1}, (K, 6)."""
        n = sources.shape[1]
        delta = np.zeros((self._chunks * self._long, n, 1))
        delta[: self._count, :, 0] = sources
        errors = delta.reshape(self._chunks, self._long, n, 1)
        for i in range(1, self._long):
            errors[:, i] += self._steps[:, i] @ errors[:, i - 1]
        begin = np.zeros((self._chunks, n, 1))
        for c in range(1, self._chunks):
            begin[c] = self._products[c - 1, -1] @ begin[c - 1] + errors[c - 1, -1]
        errors = errors + self._products @ begin[:, None]
        return errors.reshape(-1, n)[: self._count]


# --- deferred correction --------------------------------------------------------------------------


_TURNS = 60  # of an iteration
_TRANSITIONS = 3e-12  # to which the transition matrices are iterated
_STAGES = 1e-11  # to which corrections of the stages are at best, relative to the largest
_COARSE = 1e-4  # and at least
_FAR, _NEAR = 3e-9, 1e-9  # drift of the run in double that is not put up with, and that is
_SLOWEST = 10.0  # a sweep must reduce defect and correction by as much
_RELATIVE = 1e-12  # error of a correction, relative, beside what is known of it
_GUESS = 1e-12  # how far off the guess is, about
_NEARLY = 100.0  # times the target: the sweep may be the last one
_LOOK = 3  # turns between two looks at an iteration's change


@dataclass(frozen=True, eq=False)
class BlockConstants:
    """What all blocks of a run share: the numbers' kind, compiled functions, tables, the body's
    coefficients as limbs (9, L), the error wanted on each interval, the sweeps allowed."""

    limbs: Limbs
    kernels: Kernels
    tables: Tables
    coefficients: Doubles
    target: float
    sweeps: int


@dataclass(frozen=True, eq=False)
class Intervals:
    """N intervals: a chain of K, one after the other, and others that nothing depends on.

    ``states``: limbs (6, L, slots) of the states at ends; the first ``known`` are final, the
    others guesses.  Interval i starts at slot ``starts[i]`` and ends at slot known + i; the first
    K of them are a chain.  ``guess``: stages (6, M, N) in double; ``lengths``: limbs (L, N) of H.
    """

    states: Doubles
    known: int
    starts: Integers
    chain: int
    guess: Doubles
    lengths: Doubles


@dataclass(frozen=True, eq=False)
class SolvedBlock:
    """A block's final states, and what its error estimate is made of; arrays over the intervals.

    ``drift``: how far the guess was off, at each end (N,).  ``unfinished``: error left of the
    last correction.  ``tails``: last Legendre coefficients of H f.  ``transitions``: (N, 6, 6).
    ``stages``: limbs (6, L, M, N), where they were asked for.
    """

    states: Doubles
    drift: Doubles
    unfinished: Doubles
    tails: Doubles
    transitions: Doubles
    stages: Doubles | None = None


def solve(constants: BlockConstants, work: Intervals, with_stages: bool = False) -> SolvedBlock:
    """Sweep until the error left is below the target.

    ``with_stages``: the last correction of the stages is made, too, and they are given back.

    Raises TooFarOff, TooLong or CannotRefine.
    """
    sweep = _Sweep(constants, work)
    first: float | None = None
    drift: Doubles = np.empty(0)
    before, enough = _GUESS, 1.0
    for count in range(1, constants.sweeps + 1):
        levels = _levels(constants, before, before * min(1.0, enough + sweep.change) * _RELATIVE)
        defect, end_defect, tails = sweep.defects(levels)
        e = sweep.ends(defect, end_defect)
        errors = np.abs(e).max(axis=0)
        if first is None:
            _check_drift(errors, work)
            drift = errors[work.known :].copy()
        constants.limbs.adjust(sweep.states.swapaxes(0, 1), e)
        size = np.abs(defect).max(axis=(0, 1))
        largest = max(size.max(initial=0.0), errors.max(initial=0.0))
        if not np.isfinite(largest) or (count > 1 and largest > before / _SLOWEST):
            raise Stalled("the sweeps do not converge")
        if first is None:
            first = largest
        relative = sweep.change + first + _RELATIVE
        whole = levels == constants.limbs.count
        if whole and count >= 2 and largest * relative < constants.target:
            unfinished = np.maximum(size, errors[work.starts]) * relative
            if with_stages:
                sweep.move_stages(defect, e, _STAGES)
            stages = sweep.stages if with_stages else None
            return SolvedBlock(sweep.states, drift, unfinished, tails, sweep.transitions, stages)
        enough = _enough(largest, relative, constants.target)
        sweep.move_stages(defect, e, enough)
        before = largest
    raise Stalled("the sweeps do not converge")


def _levels(constants: BlockConstants, before: float, left: float) -> int:
    """How many levels of the products this sweep can make use of, the tail counted.

    The defect, no larger than ``before``, can be reduced no further than its 1e-24 part; where the
    error ``left`` may be the one wanted, all of them are.
    """
    count, width = constants.limbs.count, constants.limbs.width
    if left < _NEARLY * constants.target:
        return count
    return min(count, 2 + math.ceil(-math.log2(before * _RELATIVE**2) / width))


def _enough(largest: float, relative: float, target: float) -> float:
    """How well to solve for the stages: the defect left, times ``relative``, should be below the
    target, after as few more sweeps as possible, all of them solved equally well."""
    needed = 0.1 * target / (largest * relative) if largest else 1.0
    sweeps = 1
    while math.pow(needed, 1 / sweeps) < _STAGES:
        sweeps += 1
    return min(_COARSE, math.pow(needed, 1 / sweeps))


def _check_drift(errors: Doubles, work: Intervals) -> None:
    far = errors[work.known : work.known + work.chain]
    if not np.isfinite(errors).all() or errors.max(initial=0.0) > _FAR:
        off = ~(far < _NEAR)
        raise TooFarOff(int(off.argmax()) if off.any() else work.chain)


class _Sweep:
    """The arrays of a block under way: states at ends and stages, and the transitions."""

    def __init__(self, constants: BlockConstants, work: Intervals) -> None:
        self.constants, self.work = constants, work
        self.states = work.states.copy()
        guess = work.guess
        _, self.nodes, self.count = guess.shape
        size = self.nodes * self.count
        self.stages = np.ascontiguousarray(constants.limbs.split_doubles(guess).swapaxes(0, 1))
        # the kernels' inputs are filled in place: x, and after it what they act on
        self._push = np.empty((3 * VARIABLES, size))
        self._push[:VARIABLES] = guess.reshape(VARIABLES, size)
        self._gather = np.empty((2 * VARIABLES + VARIABLES**2, size))
        self._gather[:VARIABLES] = self._push[:VARIABLES]
        self._fill_parameters()
        self._transitions(guess)

    def _fill_parameters(self) -> None:
        limbs, coefficients = self.constants.limbs, self.constants.coefficients
        shape = (COEFFICIENTS + 1, limbs.count, self.nodes, self.count)
        exact = np.empty(shape)
        exact[:COEFFICIENTS] = coefficients[:, :, None, None]
        exact[COEFFICIENTS] = self.work.lengths[:, None, :]
        self._exact = exact.reshape(shape[0] * shape[1], -1)
        self.lengths = self.work.lengths.sum(axis=0)
        plain = np.empty((COEFFICIENTS + 1, self.nodes, self.count))
        plain[:COEFFICIENTS] = coefficients.sum(axis=1)[:, None, None]
        plain[COEFFICIENTS] = self.lengths
        self._plain = plain.reshape(COEFFICIENTS + 1, -1)

    def _transitions(self, guess: Doubles) -> None:
        """Y - 1 on the coarse nodes by Picard's iteration, then everywhere."""
        tables, n = self.constants.tables, self.count
        coarse, costate = len(tables.coarse), self.constants.kernels.costate
        inputs = np.zeros((VARIABLES + VARIABLES**2, coarse * n))
        np.matmul(tables.thinned, guess, out=inputs[:VARIABLES].reshape(VARIABLES, coarse, n))
        y = inputs[VARIABLES:].reshape(VARIABLES**2, coarse, n)
        parameters = self._plain.reshape(COEFFICIENTS + 1, self.nodes, n)[:, :coarse]
        parameters = np.ascontiguousarray(parameters).reshape(COEFFICIENTS + 1, -1)
        pushed = np.empty((VARIABLES**2, coarse * n))
        rates = pushed.reshape(VARIABLES**2, coarse, n)

        def turn() -> None:
            costate(inputs, pars=parameters, outputs=pushed)
            np.matmul(tables.coarse, rates, out=y)

        self.change = iterated(turn, y[:, :: coarse - 1], _TRANSITIONS)
        costate(inputs, pars=parameters, outputs=pushed)
        inner = self._gather[2 * VARIABLES :].reshape(VARIABLES**2, self.nodes, n)
        np.matmul(tables.fine[: self.nodes], rates, out=inner)
        ends = np.matmul(tables.fine[self.nodes :], rates)  # (36, 2, N)
        start, end = (
            np.eye(VARIABLES) + ends[:, i].T.reshape(n, VARIABLES, VARIABLES) for i in (0, 1)
        )
        self._back = np.linalg.inv(end)
        self.transitions = self._back @ start
        self._chain = LinearChain(self.transitions[: self.work.chain])

    def defects(self, count: int) -> tuple[Doubles, Doubles, Doubles]:
        """r at the stages (6, M, N), at the ends (6, N), and the last Legendre coefficients (N,).

        The large parts cancel first: each partial sum is as short as what is left of it.
        ``count``: levels of the products that are made.
        """
        limbs, tables = self.constants.limbs, self.constants.tables
        field = np.empty((VARIABLES, limbs.count, self.nodes, self.count))
        self.constants.kernels.field(
            self.stages.reshape(VARIABLES * limbs.count, -1),
            pars=self._exact,
            outputs=field.reshape(VARIABLES * limbs.count, -1),
        )
        largest = np.abs(field[:, 0]).max(axis=(0, 1))
        if not (largest <= LARGEST_FIELD).all():
            if not np.isfinite(largest).all():
                raise CannotRefine("a stage became infinite")
            raise IntervalsTooLong(largest > LARGEST_FIELD)
        levels = tables.integrated(field, count)
        start = self.states[:, :, self.work.starts]
        end = self.states[:, :, self.work.known :]
        m = self.nodes
        r = (start[:, 0, None] - self.stages[:, 0]) + levels[0][:, :m]
        r_end = (start[:, 0] - end[:, 0]) + levels[0][:, m]
        for i in range(1, limbs.count):
            r += start[:, i, None] - self.stages[:, i]
            r_end += start[:, i] - end[:, i]
            if i < len(levels):
                r += levels[i][:, :m]
                r_end += levels[i][:, m]
        return r, r_end, tables.last_coefficients(levels)

    def ends(self, defect: Doubles, end_defect: Doubles) -> Doubles:
        """e at every slot, (6, slots)."""
        gather = self._gather
        gather[VARIABLES : 2 * VARIABLES] = defect.reshape(VARIABLES, -1)
        gathered = np.empty((VARIABLES, self.nodes * self.count))
        self.constants.kernels.gather(gather, pars=self._plain, outputs=gathered)
        sums = self.constants.tables.weights @ gathered.reshape(VARIABLES, self.nodes, self.count)
        delta = end_defect.T + np.matmul(self._back, sums.T[:, :, None])[:, :, 0]  # (N, 6)
        work, chain = self.work, self.work.chain
        e = np.zeros((work.known + self.count, VARIABLES))
        if chain:
            e[work.known : work.known + chain] = self._chain.solve(delta[:chain])
        begin = e[work.starts[chain:], :, None]
        e[work.known + chain :] = (self.transitions[chain:] @ begin)[:, :, 0] + delta[chain:]
        return e.T

    def move_stages(self, defect: Doubles, e: Doubles, enough: float) -> None:
        """Add the corrections E to the stages, by Picard's iteration of E - (r + e) from 0."""
        shape = (VARIABLES, self.nodes, self.count)
        source = self._push[VARIABLES : 2 * VARIABLES].reshape(shape)
        np.add(defect, e[:, None, self.work.starts], out=source)
        rest = self._push[2 * VARIABLES :].reshape(shape)
        rest[:] = 0.0
        pushed = np.empty((VARIABLES, self.nodes * self.count))

        def turn() -> None:
            self.constants.kernels.push(self._push, pars=self._plain, outputs=pushed)
            np.matmul(self.constants.tables.integrals, pushed.reshape(shape), out=rest)

        iterated(turn, rest[:, -2:], enough * float(np.abs(source).max(initial=0.0)))
        self.constants.limbs.adjust(self.stages.swapaxes(0, 1), source + rest)


def iterated(turn: Callable[[], None], values: Doubles, enough: float) -> float:
    """Take turns until one changes ``values`` by no more than that; its change.

    ``values``: where changes are largest, farthest from where the integrals begin.
    """
    for _ in range(0, _TURNS, _LOOK):
        for _ in range(_LOOK - 1):
            turn()
        before = values.copy()
        turn()
        before -= values
        change = max(float(before.max(initial=0.0)), -float(before.min(initial=0.0)))
        if change <= enough:
            return change
        if not np.isfinite(change):
            break
    raise CannotRefine("an iteration does not converge")

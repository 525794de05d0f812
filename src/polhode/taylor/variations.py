"""Variational equations: small changes along a motion."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import reduce
from operator import mul
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.common.checkpoint import JobArrays
from polhode.common.interrupts import StopRequest
from polhode.equations.terms import NAMES, ROWS
from polhode.motion.outcomes import Outcome
from polhode.numbers import exact, number_types
from polhode.numbers.conversion import ExactNumbers, doubles, to_double
from polhode.numbers.exact import Exact, Number, sign
from polhode.numbers.number_types import DOUBLE, EXTENDED, Doubles, GivenRow, NumberType, Scalar
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import STATE
from polhode.taylor import defaults
from polhode.taylor.batches import LANES, LaneQueue, until
from polhode.taylor.engine import Engine, Equations, integrator, lent
from polhode.taylor.heyoka import HeyokaNumber, HeyokaOutput, array, as_fraction, hy, scalars
from polhode.taylor.motion import Motion
from polhode.taylor.system import System

# --- equations ------------------------------------------------------------------------------------
#
# Variational equations of the Euler–Poisson equations (3.29), by heyoka, in double.
#
# Beside the state x, tangents v obey v' = J(x) v, J by symbolic differentiation. The equations
# are compiled once for any body: their numbers are parameters. Tangents are linear, so they may
# be scaled at any time.


_BLOCK = 50_000  # steps, a fifth of a second, between which a signal is heard


class Variations:
    """A state in principal axes and tangents to it, marched together.

    ``coefficients``: of :mod:`polhode.equations.forms.principal`; ``start``: six doubles;
    ``tangents``: shape (6, n).  ``exponent``: the tangents are 2**exponent times what is kept.
    """

    def __init__(
        self, coefficients: Mapping[str, Number], start: Doubles, tangents: Doubles
    ) -> None:
        self._ready = lent(Equations(STATE, NAMES, tangents=tangents.shape[1]))
        numbers = np.array([to_double(coefficients.get(name, 0)) for name in NAMES])
        self.exponent = self.steps = 0
        self._ready.state[:] = np.concatenate([start, tangents.T.ravel()])
        self._ready.begin(numbers)

    def release(self) -> None:
        """Leave the compiled code to the next motion; the last call of all."""
        self._ready.release()

    @property
    def time(self) -> float:
        """The time reached."""
        return float(self._ready.heyoka.time)

    @property
    def state(self) -> Doubles:
        """The six components of the state."""
        state: Doubles = self._ready.state[:6]
        return state

    @state.setter
    def state(self, values: Doubles) -> None:
        self._ready.state[:6] = values

    @property
    def finite(self) -> bool:
        """Whether state and tangents are."""
        return bool(np.all(np.isfinite(self._ready.state)))

    @property
    def tangents(self) -> Doubles:
        """The tangents as kept, shape (6, n), a view."""
        tangents: Doubles = self._ready.state[6:].reshape(-1, 6).T
        return tangents

    def to(self, time: float, steps: int) -> bool:
        """March to a time in at most so many steps; whether it was reached with finite numbers."""
        ended, steps_taken = self._ready.until(time, steps, _BLOCK)
        self.steps += steps_taken
        return ended is Outcome.REACHED_END

    def rescale(self) -> None:
        """Bring the largest tangent to about 1: tangents that lead would take digits of the step.

        By a power of two, so that nothing is rounded.
        """
        tangents = self.tangents
        largest = float(np.max(np.abs(tangents), initial=0.0))
        if largest == 0:
            return
        by = math.frexp(largest)[1]
        tangents[:] = np.ldexp(tangents, -by)
        self.exponent += by


# --- flow map -------------------------------------------------------------------------------------
#
# The flow of the Euler–Poisson equations and its derivative, from any start over any time.
#
# Beside the state x the six columns of a matrix V obey V' = J(x) V, V = 1 at the start, J by
# symbolic differentiation: V is then the derivative of the flow by the start, over a period the
# monodromy matrix. The body's numbers are parameters, so that bodies share the code.


MAX_STEPS = 1_000_000


class NotFollowed(ArithmeticError):
    """A motion that could not be followed over the time asked: too many steps, or no numbers."""


class Reached(NamedTuple):
    """A state and the flow's derivative there, rows by component, as numbers of one type.

    Doubles in arrays; exact Fractions in lists in any other type.  ``derivative``: None unless
    asked for.
    """

    state: Doubles | list[Fraction]
    derivative: Doubles | list[list[Scalar]] | None


class Flow:
    """The flow of one body in principal axes, in one number type.

    ``coefficients``: of :mod:`polhode.equations.forms.principal`, exact.  ``derivative``: whether
    that is integrated too.  Raises OutOfRange for numbers that the type cannot hold.
    """

    def __init__(
        self, coefficients: Mapping[str, Number], number: NumberType, derivative: bool = False
    ) -> None:
        self.number, self.derivative = number, derivative
        self._names = tuple(coefficients)
        self._pars = array(scalars([*coefficients.values()], number), number)

    def after(self, start: GivenRow, time: float | Fraction) -> Reached:
        """Where the flow leads from a start in a time, both rounded to the type.

        Raises NotFollowed.  Ctrl-C is heard every few steps.
        """
        ta = self._at(start)
        end, chunk = self._number(time), defaults.of(self.number).chunk
        ended, _ = ta.until(end, MAX_STEPS, chunk)
        values = ta.state.copy()
        ta.release()
        if ended is not Outcome.REACHED_END:
            raise NotFollowed(ended.value)
        if self.number.name == "double":
            if not np.isfinite(values).all():
                raise NotFollowed(Outcome.NON_FINITE.value)
            return Reached(values[:6], values[6:].reshape(6, 6).T if self.derivative else None)
        exact = [as_fraction(x, self.number) for x in values.tolist()]
        columns = [exact[6 * k : 6 * k + 6] for k in range(1, 7)] if self.derivative else None
        rows = None if columns is None else [list(row) for row in zip(*columns, strict=True)]
        return Reached(exact[:6], rows)

    def along(self, start: Doubles, times: Doubles) -> Doubles:
        """In double, the states (n, 6) at ascending times from 0 on; raises NotFollowed."""
        ta = self._at(start)
        rows = np.asarray(ta.heyoka.propagate_grid(times)[-1])[:, :6]
        ta.release()
        if len(rows) < len(times) or not np.isfinite(rows).all():
            raise NotFollowed(Outcome.NON_FINITE.value)
        return rows

    def _at(self, start: GivenRow) -> Engine:
        """An integrator that stands there."""
        tangents = len(STATE) if self.derivative else 0
        ta = lent(Equations(STATE, self._names, self.number, tangents=tangents))
        ones = scalars([Fraction(0), Fraction(1)], self.number)
        unit = [ones[k % 7 == 0] for k in range(36)] if self.derivative else []
        ta.state[:] = array([*map(self._number, start), *unit], self.number)
        ta.begin(self._pars)
        return ta

    def _number(self, x: Scalar) -> HeyokaNumber:
        return float(x) if self.number.name == "double" else scalars([Fraction(x)], self.number)[0]


# --- reference trajectory -------------------------------------------------------------------------
#
# The motion that tangents in double are taken along, also where a double does not follow it.


_DOUBLES_TRUE = 8.0  # log10 of the growth up to which a run in double is the motion to 7 digits
_SPARE_DIGITS = 10  # of wider types: of a state as doubles, and of what is lost until the next one


class Leader:
    """The motion in a type wide enough for what it has multiplied errors by, at growing times."""

    def __init__(self, plain: System) -> None:
        self._plain = plain
        self._number: NumberType | None = None

    def holds(self, log10_growth: float) -> bool:
        """Whether the type at work is wide enough for a motion that multiplies errors so."""
        return self._number is not None and _is_enough(self._number, log10_growth)

    def rows(self, times: Sequence[float], log10_growth: float) -> Doubles:
        """The six components of the state at times, as doubles; nan where it does not get there.

        From time 0 on in a wider type, where the one at work does not hold the growth.
        """
        if self._number is None or not self.holds(log10_growth):
            self.release()
            ready = [
                DOUBLE,
                *([EXTENDED] if number_types.extended_here() else []),
                number_types.QUAD,
            ]
            enough = (kind for kind in ready if _is_enough(kind, log10_growth))
            wide = number_types.mp(2 * (log10_growth + _SPARE_DIGITS))
            self._number = next(enough, wide)
            self._run = Motion(replace(self._plain, number=self._number))
            self._run.begin(self._run.system)
        ahead = ExactNumbers(tuple(Fraction(t) for t in times))
        reached, outcome = self._run.advance(ahead, math.inf)
        if outcome is Outcome.INTERRUPTED:
            raise KeyboardInterrupt
        rows = np.full((len(times), 6), np.nan)
        if len(reached):
            rows[: len(reached)] = 0.0  # gamma, where there is none
            rows[: len(reached), : len(self._plain.start)] = doubles(reached)
        return rows

    def at(self, time: float, log10_growth: float) -> Doubles:
        """The same at one time."""
        state: Doubles = self.rows([time], log10_growth)[0]
        return state

    def release(self) -> None:
        """Leave the compiled code to the next motion; the last call of all."""
        if self._number is not None:
            self._run.release()
            self._number = None


def _is_enough(number: NumberType, log10_growth: float) -> bool:
    if number == DOUBLE:
        return log10_growth <= _DOUBLES_TRUE
    return log10_growth + _SPARE_DIGITS <= number.most_digits


def six(state: Sequence[Exact]) -> Doubles:
    """A state as six doubles, gamma zero where there is none."""
    return np.array([*(to_double(x) for x in state), *[0.0] * (6 - len(state))])


def pendulum(scene: Scene) -> float:
    """The scale of w for a body at rest; of a scene inside its frame."""
    square = scene.pendulum_rate_squared
    return to_double(exact.sqrt(square)) if sign(square) else 1.0


# --- double trajectory ----------------------------------------------------------------------------
#
# heyoka's run of the Euler–Poisson equations in a fast number, asked at any time.
#
# The equations are compiled once for every body: its constants are parameters. Whoever needs a
# trajectory that is only approximately right, such as the enclosures, starts from here.


_MOST_STEPS = 100_000


class Path(NamedTuple):
    """A run from time 0: the ends of heyoka's steps, an estimate of the radius of convergence of
    the motion's Taylor series on each of them, the continuous output and its type of number."""

    ends: Doubles
    convergence: Doubles
    output: HeyokaOutput
    kind: type[np.floating]

    def at(self, times: Doubles) -> Doubles:
        """States at times of the run, (n, 6), as doubles."""
        return np.array(self.output(np.asarray(times, dtype=self.kind))).astype(float)


def path(
    start: Sequence[Scalar], constants: Sequence[Scalar], duration: float, wide: bool
) -> Path | None:
    """A run of so long from six numbers; None where heyoka does not get there.

    ``constants``: the coefficients in the order of ``terms.NAMES``; ``wide``: in long double rather
    than in double, where the machine has it.
    """
    number = EXTENDED if wide and number_types.extended_here() else DOUBLE
    kind = np.longdouble if number == EXTENDED else np.float64
    ta = lent(("any body", number), lambda: _built(number))
    ta.state[:] = np.array(start, dtype=kind)
    ta.begin(np.array(constants, dtype=kind))
    ended, output = ta.polynomials(kind(duration), _MOST_STEPS)
    order = ta.heyoka.order
    ta.release()
    if ended is not Outcome.REACHED_END or output is None:
        return None
    ends = np.array(output.times).astype(float)
    # heyoka's step is this part of the radius of convergence
    part = math.exp(-2.0 - 0.7 / (order - 1))
    steps = np.diff(ends)
    if len(steps) > 1:
        steps[-1] = max(steps[-1], steps[-2])  # the last step is cut at the end
    return Path(ends, steps / part, output, kind)


def _built(number: NumberType) -> Engine:
    """The engine of the equations for any body."""
    x = hy.make_vars(*STATE)
    system = []
    for variable, row in zip(x, ROWS, strict=True):
        values: list[list[Any]] = [[], []]  # of terms that are added, and that are taken away
        for term in row:
            factors = [x[n] for n in term.factors]
            if term.coefficient is not None:
                factors.insert(0, hy.par[term.coefficient])
            values[term.sign < 0].append(reduce(mul, factors))
        added, minus = values
        system.append((variable, hy.sum(added) - hy.sum(minus) if minus else hy.sum(added)))
    return Engine(integrator(system, number), number, coefficients=len(NAMES))


# --- tangent batches ------------------------------------------------------------------------------
#
# One tangent along each of many motions: batches of doubles of twelve equations.
#
# Beside the state x a tangent u obeys u' = J(x) u, J by symbolic differentiation; the body's
# numbers are parameters, so motions of different bodies share the code. At each look ln|u| is
# kept and u is scaled to length one. Nothing is called back while heyoka steps: threads share the
# work.


class TangentJob(NamedTuple):
    """Motions to be followed to ``end`` with ``looks`` looks, evenly spaced.

    ``names``: of the coefficients; ``coefficients`` (n, names), ``starts`` and ``tangents`` (n, 6):
    in principal axes and one unit of time.  ``early``: looks (even ones) at which a motion is left
    where ln|u| has grown by more than ``enough`` since half of that time.
    """

    names: tuple[str, ...]
    coefficients: Doubles
    starts: Doubles
    tangents: Doubles
    end: float
    looks: int
    tolerance: float | None
    early: tuple[int, ...]
    enough: float


class TangentSizes(NamedTuple):
    """``sizes`` (n, looks + 1): ln|u|, nan past the look at which a motion was left or not finite.

    ``last`` (n,): that look.
    """

    sizes: Doubles
    last: npt.NDArray[np.int64]

    @classmethod
    def of(cls, arrays: JobArrays) -> TangentSizes:
        """From its arrays by name."""
        sizes = np.asarray(arrays["sizes"], dtype=np.float64)
        return cls(sizes, np.asarray(arrays["last"], dtype=np.int64))


def solve(job: TangentJob, stop: StopRequest | None = None) -> TangentSizes:
    """Follow a job's tangents, as many at a time as a step advances; the next takes a free lane."""
    n, chunk = len(job.starts), job.end / job.looks
    sizes = np.full((n, job.looks + 1), np.nan)
    sizes[:, 0] = 0.0
    last = np.zeros(n, dtype=int)
    tolerance = None if job.tolerance is None else Fraction(job.tolerance)
    ta = lent(Equations(STATE, job.names, tolerance=tolerance, lanes=LANES, tangents=1))
    lanes = LaneQueue(n)

    def begin(lane: int) -> None:
        k = lanes.motion[lane]
        ta.state[:6, lane], ta.state[6:, lane] = job.starts[k], job.tangents[k]
        ta.parameters[:, lane] = job.coefficients[k]

    def stretch() -> list[int] | None:
        ta.begin()
        if until(ta.heyoka, np.where(lanes.busy, chunk, 0.0).tolist(), stop=stop).stopped:
            return None
        length, over = np.sqrt((ta.state[6:] ** 2).sum(axis=0)), []
        for lane in np.flatnonzero(lanes.busy).tolist():
            k = int(lanes.motion[lane])
            if np.isfinite(ta.state[:, lane]).all() and length[lane] > 0:
                ta.state[6:, lane] /= length[lane]
                last[k] += 1
                look = last[k]
                sizes[k, look] = sizes[k, look - 1] + np.log(length[lane])
                grown = sizes[k, look] - sizes[k, look // 2]
                if look < job.looks and not (look in job.early and grown > job.enough):
                    continue
            over.append(lane)
        return over

    for lane in range(LANES):
        begin(lane)
    lanes.follow(begin, stretch, stop)
    ta.release()
    return TangentSizes(sizes, last)

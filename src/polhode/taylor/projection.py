"""Projection of the running state onto its first integrals, its level, and unit quaternions."""

from __future__ import annotations

import copy
import time
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from polhode.common.values import cached_property
from polhode.equations.forms import principal
from polhode.equations.integrals import CHAPLYGIN, FirstIntegrals, exact_values, first_integrals
from polhode.equations.section_functions import SectionZero
from polhode.motion.frame import Frame
from polhode.motion.outcomes import Projection
from polhode.numbers import number_types
from polhode.numbers.conversion import exactly, to_mpf
from polhode.numbers.exact import ZERO, Exact, Number, sign
from polhode.numbers.number_types import Array, Doubles, Flat, GivenRow, Indices, NumberType, Scalar
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene
from polhode.taylor import defaults, heyoka
from polhode.taylor.engine import EventWatcher
from polhode.taylor.heyoka import CompiledFunction, Expression, HeyokaNumber, hy, scalar, wider

# --- integral projection --------------------------------------------------------------------------
#
# Projection onto the first integrals: the running state put back on the exact scene's values.
#
# Rounding makes the integrals of a run wander, and the phase error follows at t^1.5. Every so
# many steps the state x is therefore moved by the least-norm Newton step
#
#     dx = J^T (J J^T + lambda D)^-1 (I* - I(x)),    D = diag(J J^T),
#
# I the integrals (polhode.equations.integrals), J their Jacobian, I* the exact scene's values.
# One compiled function does all of it in the next wider number type, and x + dx is rounded once.
#
# Components that the equations keep at exactly zero stay there: off an unstable plane or axis no
# motion comes back.
#
# It steps aside by itself. Where gradients are parallel or vanish (permanent rotations, steady
# precession, degenerate motions) lambda takes the step to zero along what the integrals do not
# determine: a residual is known to the wider type's rounding, so directions in which it would be
# magnified to a rounding of x itself are left alone. A step that is not finite, or too large to
# be rounding, is not made. Next to an event's zero the step waits: no correction carries an
# event's expression over zero, nor more than a quarter of the way there.


#: Steps that a correction waits for an event beside it to pass, before it is given up.
_MOST_WAITS = 16


class Target:
    """The integrals of one exact scene, and the way back onto them in a number type.  Immutable."""

    def __init__(self, scene: Scene, number: NumberType) -> None:
        self.scene, self.number = scene, number
        self.columns = len(scene.columns)
        self.limit = 2.0 ** -(number.bits * 2 // 3)

    @cached_property
    def integrals(self) -> FirstIntegrals:
        """The exact scene's first integrals."""
        return first_integrals(self.scene)

    @cached_property
    def conversions(self) -> heyoka.Conversions:
        """Ways between the number type and the wider one."""
        return heyoka.conversions(self.number, wider(self.number))

    @cached_property
    def step(self) -> CompiledFunction:
        """The correction, compiled: of a state and :attr:`constants`."""
        integrals, fixed = self.integrals, frozenset(self.held)
        return _newton_step(
            self.scene.columns,
            integrals.onto,
            integrals.order,
            tuple(sorted(integrals.coefficients)),
            fixed,
            self.number,
        )

    @cached_property
    def constants(self) -> Sequence[HeyokaNumber]:
        """The integrals' coefficients and this scene's values of them, in the wider type."""
        k = self.integrals.coefficients
        return [*(heyoka.scalar(k[name], wider(self.number)) for name in sorted(k)), *self.values]

    @cached_property
    def values(self) -> Sequence[HeyokaNumber]:
        """This scene's values of the integrals, in the wider type."""
        values = exact_values(self.scene, self.integrals)
        return [heyoka.scalar(x, wider(self.number)) for x in values]

    @cached_property
    def held(self) -> set[int]:
        """The components that stay zero."""
        return kept_at_zero(self.scene)

    @cached_property
    def still(self) -> Sequence[int]:
        """The columns that the equations keep."""
        return constant_columns(self.scene)

    def arrays(self) -> tuple[Array, Array]:
        """For a correction, the caller's: room for a state and :attr:`constants`, which it is
        given; and for what it gives, a state and how far that was moved."""
        wide = wider(self.number)
        zero = heyoka.scalar(ZERO, wide)
        room = [zero] * self.columns
        return heyoka.array([*room, *self.constants], wide), heyoka.array([*room, zero], wide)


class StartTarget(Target):
    """The integrals of another start of a scene's body, a row of the run's own numbers.

    Not Goryachev and Chaplygin's, which is one where f is exactly zero.
    """

    def __init__(self, own: Target, start: Flat) -> None:
        super().__init__(own.scene, own.number)
        self.own, self.start = own, start

    @cached_property
    def integrals(self) -> FirstIntegrals:
        """The first integrals that every motion of the body has."""
        integrals = self.own.integrals
        return replace(integrals, onto=tuple(x for x in integrals.onto if x != CHAPLYGIN))

    @cached_property
    def values(self) -> Sequence[HeyokaNumber]:
        """The values at the start, in the wider type."""
        wide, integrals = wider(self.number), self.integrals
        k = {name: heyoka.scalar(x, wide) for name, x in integrals.coefficients.items()}
        row = [self.conversions[2](x) for x in self.start]
        return integrals.values(row, k, heyoka.scalar(ZERO, wide))

    @cached_property
    def held(self) -> set[int]:
        """The components that stay zero."""
        return staying_zero(self.scene.body, [exactly(x) for x in self.start])


class Corrector(ABC):
    """Corrections of a run's state, every so many steps: how many there were and how large.

    ``seconds``: the time spent on compiling.
    """

    every: int
    count = 0
    largest = sum = seconds = 0.0

    @abstractmethod
    def correct(self, state: Array) -> bool:
        """Correct a state, heyoka's numbers, where it stands; False: try again a step later."""

    @property
    @abstractmethod
    def projection(self) -> Projection:
        """What was corrected so far."""

    def note(self, size: float) -> None:
        """Note a correction of this size."""
        self.count += 1
        self.sum += size
        self.largest = max(self.largest, size)


class Projector(Corrector):
    """The corrections of one run onto a target, compiled when the first one is made.

    ``watcher``: what looks for events in the run and shall not be disturbed.
    """

    def __init__(self, onto: Target, every: int, watcher: EventWatcher | None = None) -> None:
        self.every, self.target, self.watcher, self.waits = every, onto, watcher, 0
        self._step: CompiledFunction | None = None
        #: what was rounded off components that stand still
        self._rests: dict[int, HeyokaNumber] = {}

    @property
    def projection(self) -> Projection:
        """What was corrected so far."""
        target = self.target  # a short run need not know its integrals
        return Projection(
            lambda: target.integrals.onto,  # type: ignore[arg-type]  # which may wait
            *(self.every, self.count, self.largest, self.sum),
        )

    def correct(self, state: Array) -> bool:
        """Correct a state where it stands; False where it would disturb an event."""
        step = self._step or self._begin()
        here, after = state[: self.target.columns], self._moved
        self._load(self._entry, here)
        step(self._before, self._after)
        size = float(self._after[-1])
        if not size < self.target.limit:  # not finite, or no rounding: not to be mended like this
            return True
        for i, rest in self._rests.items():
            after[i] += rest
        moved = self._rounded(after)
        if self.watcher is not None and self.watcher.disturbed(state, moved):
            self.waits = (self.waits + 1) % _MOST_WAITS
            return self.waits == 0
        for i in self._rests:
            self._rests[i] = after[i] - self._widened(moved[i])
        here[:] = moved
        self.waits = 0
        self.note(size)
        return True

    def _begin(self) -> CompiledFunction:
        began, target = time.perf_counter(), self.target
        self._step = step = target.step
        self._load, self._rounded, self._widened = target.conversions
        self._before, self._after = target.arrays()
        self._entry, self._moved = self._before[: target.columns], self._after[:-1]
        self._rests = {i: heyoka.scalar(ZERO, wider(target.number)) for i in target.still}
        self.seconds += time.perf_counter() - began
        return step


@lru_cache(maxsize=64)
def _newton_step(
    columns: tuple[str, ...],
    onto: tuple[str, ...],
    order: tuple[int, int, int],
    names: tuple[str, ...],
    fixed: frozenset[int],
    number: NumberType,
) -> CompiledFunction:
    """The state after a correction and the size of that, compiled.

    Beside the state it takes the integrals' coefficients of these names and the exact scene's
    values, as variables, for heyoka takes longer to be given parameters than to evaluate all this.
    So one function serves all scenes that have the same integrals.
    """
    wide = wider(number)
    variables = hy.make_vars(*columns)
    numbers = [hy.expression(f"k{i}") for i in range(len(names) + len(onto))]
    k = dict(zip(names, numbers, strict=False))
    values = FirstIntegrals(onto, order, {}).values(variables, k, heyoka.EXPRESSIONS.zero)
    residuals = [
        target - value for target, value in zip(numbers[len(names) :], values, strict=True)
    ]

    def constant(x: Number) -> Expression:
        return hy.expression(heyoka.scalar(x, wide))

    none = constant(ZERO)
    jacobian = [
        [none if i in fixed else hy.diff(value, x) for i, x in enumerate(variables)]
        for value in values
    ]
    damping = constant(1 + Fraction(2) ** (-2 * (wide.bits - number.bits - 2)))
    floor = constant(Fraction(2) ** (-4 * wide.bits))
    step = least_norm(jacobian, residuals, damping, floor, none)
    size = hy.sqrt(sum((d * d for d in step[1:]), step[0] * step[0]))
    moved = [x + d for x, d in zip(variables, step, strict=True)]
    with heyoka.disk_cache(wide):
        return hy.cfunc([*moved, size], vars=[*variables, *numbers], **heyoka.type_options(wide))


def least_norm(
    jacobian: Sequence[GivenRow],
    residuals: Sequence[Scalar],
    damping: Scalar,
    floor: Scalar,
    zero: Scalar,
) -> list[Scalar]:
    """dx = J^T y with (J J^T + (damping - 1) D + floor) y = residuals, by L D L^T, any scalar."""
    n = len(residuals)
    gram = [
        [_sum((a * b for a, b in zip(u, v, strict=True)), zero) for v in jacobian] for u in jacobian
    ]
    lower: list[list[Scalar]] = [[] for _ in range(n)]
    pivots: list[Scalar] = []
    y: list[Scalar] = []
    for i in range(n):
        for j in range(i):
            inner = _sum((lower[i][k] * lower[j][k] * pivots[k] for k in range(j)), zero)
            lower[i].append((gram[i][j] - inner) / pivots[j])
        inner = _sum((lower[i][k] * lower[i][k] * pivots[k] for k in range(i)), zero)
        pivots.append(gram[i][i] * damping + floor - inner)
        y.append(residuals[i] - _sum((lower[i][k] * y[k] for k in range(i)), zero))
    y = [value / pivot for value, pivot in zip(y, pivots, strict=True)]
    for i in reversed(range(n)):
        y[i] = y[i] - _sum((lower[k][i] * y[k] for k in range(i + 1, n)), zero)
    return [_sum((jacobian[i][k] * y[i] for i in range(n)), zero) for k in range(len(jacobian[0]))]


def _sum(terms: Iterable[Scalar], zero: Scalar) -> Scalar:
    """A sum that does not start from 0 unless it is empty."""
    first, *rest = terms if (terms := [*terms]) else [zero]
    return sum(rest, first)


def kept_at_zero(scene: Scene) -> set[int]:
    """Components of a scene's start that vanish and stay zero, inside its frame."""
    inside = Frame.of(scene).inside(scene)
    return staying_zero(inside.body, inside.start)


def staying_zero(body: Body, state: Sequence[Exact]) -> set[int]:
    """Components of a start that vanish, and whose rates vanish as long as they do.

    ``state``: in principal axes.  Of the coordinate planes through the start that the motion never
    leaves, the smallest.
    """
    zeros = {i for i, x in enumerate(state) if sign(x) == 0}
    names = [*principal.coefficients(body)]
    numbers = [Fraction(n) for n in _primes(len(names) + len(state))]  # generic ones
    k, others = dict(zip(names, numbers, strict=False)), numbers[len(names) :]
    while zeros:
        point = [ZERO if i in zeros else x for i, x in enumerate(others)]
        rates = principal.field(point, k, number_types.EXACT)
        if not (leaving := {i for i in zeros if rates[i] != 0}):
            break
        zeros -= leaving
    return zeros


def _primes(count: int) -> list[int]:
    """The first prime numbers, among which nothing cancels by accident."""
    primes: list[int] = []
    n = 2
    while len(primes) < count:
        if all(n % prime for prime in primes):
            primes.append(n)
        n += 1
    return primes


def constant_columns(scene: Scene) -> list[int]:
    """The components of w that the equations themselves keep: the spin of a symmetric body.

    Nothing else rounds them, so their own rounding would act in one direction all along the run.
    What a correction rounds off is added to the next one instead: on average they are exact.
    """
    moving = {name[0] for name in principal.coefficients(scene.body)}
    return [i for i, name in enumerate("pqr") if name not in moving]


# --- level projection -----------------------------------------------------------------------------
#
# Columns of states put back on the first integrals of their level, in numpy.


ARRAYS = number_types.Functions(0.0, np.sin, np.cos, np.sqrt)
TINY = 1e-30  # of a complex step

_NO_ROUNDING = 1e-8  # a step as large as that is none of rounding's, and is not made
_DAMPING, _FLOOR = 1 + 2.0**-18, 2.0**-256  # as of :func:`least_norm`


class Level(NamedTuple):
    """The integrals to which states are put back, with their coefficients as longdoubles.

    ``targets``: of h, f and |gamma|^2 (shared); the fourth is each orbit's own.
    """

    integrals: FirstIntegrals
    coefficients: Mapping[str, np.longdouble]
    targets: tuple[np.longdouble, ...]


class Put:
    """Puts columns of states back on their level by one least-norm step of Newton's method.

    Residuals are longdoubles, the step is of doubles.  ``drift``: the largest residual met so far
    of h, f and |gamma|^2, relative.
    """

    def __init__(self, level: Level, starts: Doubles) -> None:
        self.level = level
        self.drift = 0.0
        self._plain = {name: float(x) for name, x in level.coefficients.items()}
        own = self._values(starts.astype(np.longdouble))
        shared = len(level.targets)
        self.targets = np.array([x + 0 * own[0] for x in level.targets] + own[shared:])
        h, f = np.abs(self.targets[:2].astype(float))
        around = np.abs(np.array(own[:1], dtype=float))[0]
        energy = np.maximum(h, around) + 1e-300
        self.scales = np.array([energy, np.maximum(f, np.sqrt(energy)), 1 + 0 * energy])

    def begin(self, lanes: list[int], starts: Doubles) -> None:
        """Other orbits begin in some lanes."""
        fresh = Put(self.level, starts)
        self.targets[:, lanes], self.scales[:, lanes] = fresh.targets, fresh.scales

    def of(self, orbits: Indices) -> Put:
        """The same for these orbits, one a column."""
        part = copy.copy(self)
        part.targets, part.scales = self.targets[:, orbits], self.scales[:, orbits]
        return part

    def back(self, state: Doubles) -> Doubles:
        """The states put back; as they are where the step is no rounding."""
        residuals = self._residuals(state)
        off = np.abs(residuals[:3]) / self.scales
        self.drift = max(self.drift, float(np.max(off, initial=0.0, where=np.isfinite(off))))
        return self._stepped(state, self._gradients(_moved(state)), [*residuals])

    def within(self, zero: SectionZero, state: Doubles) -> Doubles:
        """The states put back on level and section at once, so that they leave neither."""
        moved = _moved(state)
        with np.errstate(all="ignore"):
            across = np.imag(zero.value(list(moved), ARRAYS)) / TINY
            value = np.real(zero.value(list(state), ARRAYS))
        rows = [*self._gradients(moved), across]
        return self._stepped(state, rows, [*self._residuals(state), -value])

    def _residuals(self, state: Doubles) -> Doubles:
        values = self._values(state.astype(np.longdouble))
        residuals: Doubles = (self.targets - np.array(values)).astype(float)
        return residuals

    def _gradients(self, moved: number_types.Complexes) -> list[Doubles]:
        """Of the integrals, from complex steps along each component."""
        values = self.level.integrals.values(list(moved), self._plain, 0 * moved[0])
        return [np.imag(value) / TINY for value in values]

    def _stepped(
        self, state: Doubles, rows: Sequence[Doubles], residuals: Sequence[Doubles]
    ) -> Doubles:
        with np.errstate(all="ignore"):
            step = np.array(least_norm(rows, residuals, _DAMPING, _FLOOR, 0.0))
            size = np.sqrt((step * step).sum(axis=0))
        return np.where(size < _NO_ROUNDING, state + step, state)

    def _values(self, state: Flat) -> list[Scalar]:
        return self.level.integrals.values(list(state), self.level.coefficients, 0 * state[0])


def _moved(state: Doubles) -> number_types.Complexes:
    """Each column six times, a component of each beside itself by a complex step."""
    return state[:, None, :] + TINY * 1j * np.eye(6)[:, :, None]


# --- quaternion norm ------------------------------------------------------------------------------
#
# A vector among the variables whose length one is held by projection: a quaternion's.
#
# Its length is an integral of the equations, of which rounding makes the run drift. Every so many
# steps the vector is divided by its length, which is computed in more precision than the vector
# has; what was corrected is recorded.


_GUARD_BITS = 32


class UnitNorm(Corrector):
    """The corrections of one run; ``which`` of its variables form the vector."""

    def __init__(self, which: slice, number: NumberType) -> None:
        self.which, self.number, self.every = which, number, defaults.of(number).unit_norm_every

    @property
    def projection(self) -> Projection:
        """What was corrected so far."""
        return Projection(("|q|",), self.every, self.count, self.largest, self.sum)

    def correct(self, state: Array) -> bool:
        """Correct a state where it stands, in heyoka's numbers."""
        from polhode.numbers.mpmath_context import mpmath

        bits = self.number.bits + _GUARD_BITS
        places = range(*self.which.indices(len(state)))
        with mpmath.workprec(bits):
            vector = [to_mpf(heyoka.as_fraction(state[i], self.number), bits) for i in places]
            length = mpmath.sqrt(mpmath.fdot(vector, vector))
            for i, x in zip(places, vector, strict=True):
                state[i] = scalar(exactly(x / length), self.number)
            size = abs(float(length - 1))
        self.note(size)
        return True

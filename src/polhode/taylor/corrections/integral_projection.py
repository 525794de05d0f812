"""Projection onto the first integrals: the running state put back on the exact scene's values.

Rounding makes the integrals of a run wander, and the phase error follows at t^1.5.  Every so many
steps the state x is therefore moved by the least-norm Newton step

    dx = J^T (J J^T + lambda D)^-1 (I* - I(x)),    D = diag(J J^T),

I the integrals (polhode.equations.integrals), J their Jacobian, I* the exact scene's values.  One
compiled function does all of it in the next wider number type, and x + dx is rounded once.

Components that the equations keep at exactly zero stay there: off an unstable plane or axis
no motion comes back.

It steps aside by itself.  Where gradients are parallel or vanish (permanent rotations, steady
precession, degenerate motions) lambda takes the step to zero along what the integrals do not
determine: a residual is known to the wider type's rounding, so directions in which it would be
magnified to a rounding of x itself are left alone.  A step that is not finite, or too large to be
rounding, is not made.  Next to an event's zero the step waits: no correction carries an event's
expression over zero, nor more than a quarter of the way there.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache

from polhode.common.values import cached_property
from polhode.equations.forms import principal
from polhode.equations.integrals import CHAPLYGIN, FirstIntegrals, exact_values, first_integrals
from polhode.motion.frame import Frame
from polhode.motion.outcomes import Projection
from polhode.numbers.conversion import exactly
from polhode.numbers.exact import ZERO, Exact, Number, sign
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Array, Flat, GivenRow
from polhode.numbers.scalars import EXACT, Scalar
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene
from polhode.taylor.backend import heyoka_numbers
from polhode.taylor.backend.engine import hy
from polhode.taylor.backend.protocols import Watcher
from polhode.taylor.backend.types import CompiledFunction, Expression, HeyokaNumber
from polhode.taylor.backend.wider_type import Conversions, conversions, wider

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
    def conversions(self) -> Conversions:
        """Ways between the number type and the wider one."""
        return conversions(self.number, wider(self.number))

    @cached_property
    def step(self) -> CompiledFunction:
        """The correction, compiled: of a state and :attr:`constants`."""
        known, held = self.integrals, frozenset(self.held)
        return _newton_step(
            self.scene.columns, known.onto, known.order, self._names, held, self.number
        )

    @cached_property
    def constants(self) -> Sequence[HeyokaNumber]:
        """The integrals' coefficients and this scene's values of them, in the wider type."""
        known = self.integrals
        found = [known.coefficients[name] for name in self._names]
        return [*(heyoka_numbers.scalar(x, wider(self.number)) for x in found), *self.values]

    @cached_property
    def values(self) -> Sequence[HeyokaNumber]:
        """This scene's values of the integrals, in the wider type."""
        found = exact_values(self.scene, self.integrals)
        return [heyoka_numbers.scalar(x, wider(self.number)) for x in found]

    @cached_property
    def held(self) -> set[int]:
        """The components that stay zero."""
        return kept_at_zero(self.scene)

    @cached_property
    def _names(self) -> tuple[str, ...]:
        return tuple(sorted(self.integrals.coefficients))

    @cached_property
    def unrested(self) -> Mapping[int, HeyokaNumber]:
        """The columns that the equations keep, with nothing rounded off yet."""
        return dict.fromkeys(constant_columns(self.scene), self._zero)

    def inputs(self) -> Array:
        """What the correction is given: room for a state, and :attr:`constants`; the caller's."""
        return self._inputs.copy() if self.number.name == "double" else self._made(self.constants)

    def outputs(self) -> Array:
        """Room for what it gives: a state, and how far that was moved; the caller's."""
        return self._made([self._zero])

    @cached_property
    def _inputs(self) -> Array:
        return self._made(self.constants)

    def _made(self, last: Sequence[HeyokaNumber]) -> Array:
        """An array of zeros for a state, and these after it."""
        return heyoka_numbers.array([self._zero] * self.columns + [*last], wider(self.number))

    @cached_property
    def _zero(self) -> HeyokaNumber:
        return heyoka_numbers.scalar(ZERO, wider(self.number))


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
        found = self.own.integrals
        return replace(found, onto=tuple(x for x in found.onto if x != CHAPLYGIN))

    @cached_property
    def values(self) -> Sequence[HeyokaNumber]:
        """The values at the start, in the wider type."""
        wide, known = wider(self.number), self.integrals
        k = {name: heyoka_numbers.scalar(x, wide) for name, x in known.coefficients.items()}
        row = [self.conversions[2](x) for x in self.start]
        return known.values(row, k, self._zero)

    @cached_property
    def held(self) -> set[int]:
        """The components that stay zero."""
        return staying_zero(self.scene.body, [exactly(x) for x in self.start])


class Projector:
    """The corrections of one run, compiled when the first one is made.

    ``watcher``: what looks for events in the run and shall not be disturbed.
    ``seconds``: the time spent on compiling.
    """

    def __init__(self, onto: Target, every: int, watcher: Watcher | None = None) -> None:
        self.every, self.watcher = every, watcher
        self.target = onto
        self.count = self.waits = 0
        self.largest = self.sum = self.seconds = 0.0
        self._step: CompiledFunction | None = None
        self._rests: dict[
            int, HeyokaNumber
        ] = {}  # what was rounded off components that stand still

    def found(self) -> Projection:
        """What was corrected so far."""
        target = self.target  # a short run need not know its integrals
        return Projection(
            lambda: target.integrals.onto,  # type: ignore[arg-type]  # which may wait
            *(self.every, self.count, self.largest, self.sum),
        )

    def correct(self, state: Array) -> bool:
        """Correct a state where it stands, in heyoka's numbers; False: try again a step later."""
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
        self.count += 1
        self.sum += size
        self.largest = max(self.largest, size)
        return True

    def _begin(self) -> CompiledFunction:
        began, target = time.perf_counter(), self.target
        self._step = found = target.step
        self._load, self._rounded, self._widened = target.conversions
        self._before, self._after = target.inputs(), target.outputs()
        self._entry, self._moved = self._before[: target.columns], self._after[:-1]
        self._rests = dict(target.unrested)
        self.seconds += time.perf_counter() - began
        return found


@lru_cache(maxsize=64)
def _newton_step(
    columns: tuple[str, ...],
    onto: tuple[str, ...],
    order: tuple[int, int, int],
    names: tuple[str, ...],
    held: frozenset[int],
    number: NumberType,
) -> CompiledFunction:
    """The state after a correction and the size of that, compiled.

    Beside the state it takes the integrals' coefficients of these names and the exact scene's
    values, as variables, for heyoka takes longer to be given parameters than to evaluate all this.
    So one function serves all scenes that have the same integrals.
    """
    wide = wider(number)
    variables = hy.make_vars(*columns)
    known = [hy.expression(f"k{i}") for i in range(len(names) + len(onto))]
    k = dict(zip(names, known, strict=False))
    values = FirstIntegrals(onto, order, {}).values(variables, k, heyoka_numbers.EXPRESSIONS.zero)
    residuals = [target - value for target, value in zip(known[len(names) :], values, strict=True)]

    def constant(x: Number) -> Expression:
        return hy.expression(heyoka_numbers.scalar(x, wide))

    none = constant(ZERO)
    jacobian = [
        [none if i in held else hy.diff(value, x) for i, x in enumerate(variables)]
        for value in values
    ]
    damping = constant(1 + Fraction(2) ** (-2 * (wide.bits - number.bits - 2)))
    floor = constant(Fraction(2) ** (-4 * wide.bits))
    step = least_norm(jacobian, residuals, damping, floor, none)
    size = hy.sqrt(sum((d * d for d in step[1:]), step[0] * step[0]))
    moved = [x + d for x, d in zip(variables, step, strict=True)]
    with heyoka_numbers.disk_cache(wide):
        return hy.cfunc(
            [*moved, size], vars=[*variables, *known], **heyoka_numbers.type_options(wide)
        )


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
    held = {i for i, x in enumerate(state) if sign(x) == 0}
    names = [*principal.coefficients(body)]
    numbers = [Fraction(n) for n in _primes(len(names) + len(state))]  # generic ones
    k, others = dict(zip(names, numbers, strict=False)), numbers[len(names) :]
    while held:
        point = [ZERO if i in held else x for i, x in enumerate(others)]
        rates = principal.field(point, k, EXACT)
        if not (leaving := {i for i in held if rates[i] != 0}):
            break
        held -= leaving
    return held


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

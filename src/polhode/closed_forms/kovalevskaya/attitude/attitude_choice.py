"""Which attitude a motion of the Kovalevskaya top has: at any time at a cost that does not grow.

A generic motion has theta quotients, one on a degenerate curve those of its neighbours.  A periodic
one has panels over one period, one that tends to a permanent rotation as far as it has not.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from functools import partial
from typing import TypeVar

from polhode.closed_forms._winding.counted_turns import Counted
from polhode.closed_forms._winding.euler_angles import Attitude
from polhode.closed_forms.functions.quaternion import Quaternion, conjugate, of_matrix, product
from polhode.closed_forms.kovalevskaya import regimes
from polhode.closed_forms.kovalevskaya.attitude.asymptotic_attitude import (
    SettledAttitude,
    edge,
    rate_of,
)
from polhode.closed_forms.kovalevskaya.attitude.attitude_panels import (
    BEND,
    KovalevskayaAttitude,
    MovingState,
)
from polhode.closed_forms.kovalevskaya.attitude.axis_turns import AxisTurns
from polhode.closed_forms.kovalevskaya.attitude.cayley_klein import CayleyKlein, cayley_klein
from polhode.closed_forms.kovalevskaya.attitude.degenerate_attitude import (
    AveragedAttitude,
    DegenerateAttitude,
    averaged_attitude,
)
from polhode.closed_forms.kovalevskaya.attitude.theta_attitude import (
    TRACKING,
    PeriodicAttitude,
    ThetaAttitude,
)
from polhode.closed_forms.kovalevskaya.axes import KovalevskayaAxes
from polhode.closed_forms.kovalevskaya.certified_answers import CERTIFIED, Answers
from polhode.closed_forms.kovalevskaya.degenerate import Averaged, averaged
from polhode.closed_forms.kovalevskaya.generic import Generic
from polhode.closed_forms.kovalevskaya.one_frequency import special
from polhode.numbers.conversion import exactly
from polhode.numbers.exact import ZERO, Exact
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar

_FEW = 200  # radians up to which turns about another axis are sooner counted
_ALIKE = 1e-3  # radians: neighbours on the same side of all poles turn alike
_MOST_MORE = 2_000  # bits that the set-up of an attitude may lose


class Attitudes:
    """The attitudes of one motion, each made once a precision.

    ``first``: the quaternion at t = 0; ``placed``: a state in the scene's axes and units.
    """

    def __init__(
        self,
        answers: Answers,
        axes: KovalevskayaAxes,
        first: Callable[[int], Quaternion],
        placed: Callable[[Sequence[Scalar], int], list[mpf]],
    ) -> None:
        self._answers, self._axes, self._first, self._placed = answers, axes, first, placed
        self._start = answers.start
        self._known: dict[int, Attitude] = {}
        self._formulas: dict[int, CayleyKlein] = {}
        self._neighbours: dict[tuple[int, int, int], AveragedAttitude] = {}
        self._counts: dict[tuple[Scalar, Scalar], Counted] = {}

    def at(self, bits: int) -> Attitude:
        """The attitude of answers of ``bits`` bits."""
        if bits not in self._known:
            self._known[bits] = self._made(bits)
        return self._known[bits]

    def _made(self, bits: int) -> Attitude:
        regime = self._answers.regime
        if self._answers.generic:
            return self._theta(bits)
        if regime in regimes.DEGENERATE:
            return self._degenerate(bits)
        if regime in regimes.STEADY:
            return self._settled(bits)
        with mpmath.workprec(bits):
            period = special(self._start, regime, bits).period
            if not mpmath.isfinite(period):
                return self._settled(bits)
            period = mpmath.ldexp(period, -self._start.exponent)
            far = exactly(period)
        return PeriodicAttitude(self.panels(bits, (-far, far)), period)

    def panels(self, bits: int, span: tuple[Exact, Exact]) -> KovalevskayaAttitude:
        """The attitude by quadrature, for times within a span."""
        state = self._state(bits, span)
        with mpmath.workprec(bits):
            return KovalevskayaAttitude(state, self._first(bits), self._rate(bits))

    def _state(self, bits: int, span: tuple[Exact, Exact]) -> MovingState:
        """w and gamma in the scene's axes, within a span of times."""
        solution, used, _, _ = self._answers.resolved(span, bits)

        def state(t: Scalar) -> tuple[Sequence[Scalar], Sequence[Scalar]]:
            with mpmath.workprec(used):
                found = solution.at(mpmath.ldexp(t, self._start.exponent))[0]
                row = self._placed(found, used)
            return row[:3], row[3:]

        return state

    def _settled(self, bits: int) -> SettledAttitude:
        """A permanent rotation, or a motion that tends to one."""
        with mpmath.workprec(bits):
            state = self._state(bits, (ZERO, ZERO))
            edges = mpf(0), mpf(0)
            if self._answers.regime not in regimes.STEADY:
                unit = 1 / self._rate(bits)
                edges = edge(state, -unit), edge(state, unit)
            rates = rate_of(*state(edges[0])), rate_of(*state(edges[1]))
            span = exactly(edges[0]), exactly(edges[1])
        return SettledAttitude(self.panels(bits, span), edges, rates)

    def _theta(self, bits: int) -> ThetaAttitude:
        """Generic motion."""
        return ThetaAttitude(
            formula=lambda more: self._formula(bits + more),
            bits=bits,
            start=self._first(bits),
            turn=self._turn(bits),
            exponent=self._start.exponent,
            speed=self._rate(bits),
            third=self._axes.third,
            coarse=lambda: self._formula(TRACKING),
            axis_turns=lambda made, used, begin: AxisTurns(
                self._start, made, self._turn(used), used, begin
            ),
        )

    def _formula(self, bits: int) -> CayleyKlein:
        """The Cayley-Klein parameters at ``bits`` bits, with a set-up that certifies so many."""

        def make(more: int) -> CayleyKlein:
            solution, used = self._answers.solution(bits + CERTIFIED + more, bits)
            assert isinstance(solution, Generic)
            with mpmath.workprec(used):
                return cayley_klein(self._start, solution, self._begin(used))

        if bits not in self._formulas:
            self._formulas[bits] = _certified(make, bits)
        return self._formulas[bits]

    def _degenerate(self, bits: int) -> DegenerateAttitude:
        """A motion on a degenerate curve."""
        return DegenerateAttitude(
            formula=self.neighbours,
            turns=partial(self._turns, bits),
            bits=bits,
            start=self._first(bits),
            turn=self._turn(bits),
            exponent=self._start.exponent,
            speed=self._rate(bits),
        )

    def neighbours(self, t: Scalar, bits: int) -> AveragedAttitude:
        """The neighbours' Cayley-Klein parameters, as near as the time asks for."""
        solution, used, _, _ = self._answers.resolved((exactly(t),), bits)
        assert isinstance(solution, Averaged)

        def make(more: int) -> AveragedAttitude:
            with mpmath.workprec(used + more):
                near = solution
                if more:
                    near = averaged(self._start, used + more, solution.closeness)
                return averaged_attitude(self._start, near, self._begin(used + more), used + more)

        key = solution.closeness, used, bits
        if key not in self._neighbours:
            self._neighbours[key] = _certified(make, bits)
        return self._neighbours[key]

    def _turns(self, bits: int, t: Scalar) -> tuple[Scalar, Scalar]:
        """The growth of both arguments from 0 to t.

        A neighbour is nearer than 2^-(bits/4) all the way: it turns as the motion does, unless that
        passes poles.  There two neighbours pass on either side (:func:`regimes.side`), at all poles
        of one kind on the same one: half turns are counted upwards, so the larger growth is meant.
        """
        if not self._axes.third and abs(t) * self._rate(bits) > _FEW:
            with contextlib.suppress(ArithmeticError):
                return self.about_axis(self.neighbours(t, bits), t)
        elif self._axes.third:
            with contextlib.suppress(ArithmeticError):
                xi, eta = self._neighbours_turns(self.neighbours(t, bits), bits, t)
                return (eta, xi) if self._axes.third > 0 else (xi, eta)
        return self.tallied(t)

    def about_axis(self, made: AveragedAttitude, t: Scalar) -> tuple[Scalar, Scalar]:
        """The growth about another axis; ArithmeticError where neighbours differ.

        They do where the motion passes the vertical itself: one on either side.
        """
        with mpmath.workprec(made.bits):
            time = mpmath.ldexp(t, self._start.exponent)
            turn = self._turn(made.bits)
            grown = []
            for start, formula in zip(made.motions.starts[:2], made.formulas, strict=False):
                found = AxisTurns(start, formula, turn, made.bits, mpf(0))
                grown.append(found.growth(time))
            if any(abs(x - y) > _ALIKE for x, y in zip(*grown, strict=True)):
                raise ArithmeticError("nearby motions turn differently")
            return grown[0]

    def _neighbours_turns(
        self, made: AveragedAttitude, bits: int, t: Scalar
    ) -> tuple[Scalar, Scalar]:
        """The growth of arg xi and arg eta; ArithmeticError where neighbours do not tell it."""
        both = range(1)
        if regimes.passes_poles(self._start):
            if sorted(map(regimes.side, made.motions.starts[:2])) != [-1, 1]:
                raise ArithmeticError("nearby motions on one side only")
            both = range(2)
        with mpmath.workprec(made.bits):
            time = mpmath.ldexp(t, self._start.exponent)
            grown = [made.turns(i, time) for i in both]
            w, x, y, z = self._first(bits)
            if not (w or z) or not (x or y):  # from a pole: from where the motion leaves it
                soon = mpmath.sign(t) / self._start.fastest(bits)
                soon = mpmath.ldexp(soon, -made.motions.closeness // 2)
                begun = [made.turns(i, soon) for i in both]
                grown = [(a - c, b - d) for (a, b), (c, d) in zip(grown, begun, strict=True)]
            xi, eta = (max(row) for row in zip(*grown, strict=True))
        return xi, eta

    def tallied(self, t: Scalar) -> tuple[Scalar, Scalar]:
        """The same, counted along the motion."""
        side, far = mpmath.sign(t), mpmath.ldexp(1, int(mpmath.mag(t)))
        if (side, far) not in self._counts:
            with mpmath.workprec(TRACKING):
                made = self.neighbours(side * far, TRACKING)
                along = partial(self._along, made)
                self._counts[side, far] = Counted(along, self._rate(TRACKING), BEND)
        with mpmath.workprec(TRACKING):
            return self._counts[side, far].arguments(t)

    def _along(self, made: AveragedAttitude, t: Scalar) -> Quaternion:
        """The attitude at a time not beyond that of the constants."""
        if not t:
            return self._first(TRACKING)
        (w, x, y, z), _ = made.certified(mpmath.ldexp(t, self._start.exponent))
        return product((w, x, y, z), self._turn(TRACKING))

    def _begin(self, bits: int) -> Quaternion:
        """The quaternion at t = 0 in the top's axes."""
        with mpmath.workprec(bits):
            return product(self._first(bits), conjugate(self._turn(bits)))

    def _turn(self, bits: int) -> Quaternion:
        """The turn from the scene's axes to the top's."""
        with mpmath.workprec(bits):
            return of_matrix(self._axes.matrix(bits))

    def _rate(self, bits: int) -> Scalar:
        """A bound of |w|."""
        with mpmath.workprec(bits):
            return mpmath.ldexp(self._start.fastest(bits), self._start.exponent)


#: What has a defect.
C = TypeVar("C", CayleyKlein, AveragedAttitude)


def _certified(make: Callable[[int], C], bits: int) -> C:
    """What ``make`` gives with as many bits more as its ``defect`` needs to be below 2^-bits."""
    more = 0
    before: int | None = None  # the size of the defect at fewer bits
    while True:
        found = make(more)
        if not found.defect:
            return found
        size = int(mpmath.mag(found.defect))
        if bits + size <= 0:
            return found
        if more > _MOST_MORE or (before is not None and size > before - 8):
            raise ArithmeticError("the attitude's constants do not reproduce the start")
        more, before = more + bits + size + 16, size

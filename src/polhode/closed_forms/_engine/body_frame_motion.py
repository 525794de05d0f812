"""The attitude of a motion whose own axes move in a known way, in the scene's axes.

A family gives a smooth quaternion F(t) of its own axes, up to a turn about the vertical by an angle
chi(t); with q_M the constant turn from the scene's axes to its own,

    q(t) = L Rz(chi(t)) F(t) q_M,    L = q(0) conj(F(0) q_M),    chi(0) = 0.

Quaternions are scalar first; al = q0 + i q3 and bt = q1 + i q2 both turn by chi/2, so the turns of
psi and phi are those of F, counted, and of chi, known.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from polhode.closed_forms._winding.asymptotic_period import Repeating, Settled
from polhode.closed_forms._winding.winding_number import (
    coarse_parameters,
    fine_parameters,
    growth,
    longest,
    too_far,
)
from polhode.closed_forms.functions.jacobi import MP, SeriesFunctions, numpy_functions
from polhode.closed_forms.functions.quaternion import Quaternion, conjugate, of_matrix, product
from polhode.common.cached_property import cached_property
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.rows import Complexes, Doubles
from polhode.numbers.scalars import Scalar

#: Growth of arg al and arg bt from one time to another; ArithmeticError where it cannot be told.
Between = Callable[[Scalar, Scalar], tuple[Scalar, Scalar]]


_NEAR = 40  # radians of F up to which its turns are counted anyway


class MomentumFrame(Protocol):
    """F as a function of time."""

    def at(self, t: Scalar, fn: SeriesFunctions) -> Quaternion:
        """The quaternion at t, continuous in t."""
        ...

    def floats(self, speed: Scalar) -> MomentumFrame:
        """The same in doubles for arrays, time in units of 1/speed."""
        ...


@dataclass(frozen=True)
class Moving:
    """The attitude in the scene's axes, as its Euler angles need it."""

    frame: MomentumFrame
    chi: Callable[[Scalar], Scalar] | None  # None: it is always 0
    start: Quaternion
    left: Quaternion
    right: Quaternion
    speed: Scalar  # a bound of |w|
    quickest: Scalar  # a bound of the rate of F
    period: Scalar | None = None  # after which F repeats up to its sign
    between: Between | None = None  # how the arguments of F grow, where it is not to be counted
    settled: Settled | None = None

    def at(self, t: Scalar, fn: SeriesFunctions) -> Quaternion:
        """The attitude at t, continuous in t."""
        frame = self._framed(t, fn)
        if self.chi is None:
            return frame
        cos, sin = fn.cos_sin(self.chi(t) / 2)
        a, b, c, d = frame  # (cos, 0, 0, sin) times it; L too is a turn about the vertical
        return a * cos - d * sin, b * cos - c * sin, b * sin + c * cos, a * sin + d * cos

    def _framed(self, t: Scalar, fn: SeriesFunctions) -> Quaternion:
        return product(product(self.left, self.frame.at(t, fn)), self.right)

    def floats(self, speed: Scalar) -> Moving:
        """F in the scene's axes in doubles, time in units of 1/speed."""
        left, right, start = (_doubles(q) for q in (self.left, self.right, self.start))
        frame = self.frame.floats(speed)
        return replace(self, frame=frame, chi=None, start=start, left=left, right=right)

    def arguments(self, t: Scalar) -> tuple[Scalar, Scalar]:
        """The growth of arg al and arg bt from 0 to t.

        Counted over less than a period where there is one or will be, known where
        :attr:`between` tells it, else counted over all the time; ValueError is raised where that is
        too long.
        """
        turned = self.chi(t) / 2 if self.chi is not None else mpf(0)
        one, other = self._framed_growth(t)
        return one + turned, other + turned

    def _framed_growth(self, t: Scalar) -> tuple[Scalar, Scalar]:
        """The growth of the two arguments of F."""
        if self.between is not None and abs(t) * self.quickest > _NEAR:
            first = mpmath.sign(t) * mpf(_NEAR) / self.quickest
            with contextlib.suppress(ArithmeticError):
                counted, known = self._grown(first), self.between(first, t)
                return counted[0] + known[0], counted[1] + known[1]
        if self.settled is not None and self.settled.reached(t):
            return self._repeating.growth(t)
        side, rest, n = (1 if t >= 0 else -1), t, 0
        al, bt = mpmath.mpc(self.start[0], self.start[3]), mpmath.mpc(*self.start[1:3])
        if self.period is not None and al and bt:
            n = int(mpmath.floor(abs(t) / self.period))
            rest = side * (abs(t) - n * self.period)
        counted = self._grown(rest)
        if n:
            once = self._once[side]
            counted = counted[0] + n * once[0], counted[1] + n * once[1]
        return counted[0], counted[1]

    @cached_property
    def _once(self) -> dict[int, tuple[float, float]]:
        assert self.period is not None
        return {side: self._grown(side * self.period) for side in (1, -1)}

    @cached_property
    def _repeating(self) -> Repeating:
        assert self.settled is not None
        return Repeating(self._counted, self.settled)

    def _grown(self, t: Scalar) -> tuple[float, float]:
        """Growth of the two arguments of F in the scene's axes, from 0 to t, counted."""
        return self._counted(mpf(0), t)

    def _counted(self, since: Scalar, t: Scalar) -> tuple[float, float]:
        """The same from one time to another farther from 0."""
        if t == since:
            return 0.0, 0.0
        speed = self.quickest
        if abs(t) * speed > longest():
            raise too_far(longest() / speed)
        coarse, fn = self.floats(speed), numpy_functions()

        def fine(time: Scalar) -> tuple[Scalar, Scalar]:
            return fine_parameters(self._framed(time / speed, MP))

        def many(time: Doubles) -> tuple[Complexes, Complexes]:
            return coarse_parameters(coarse.at(time, fn))

        (found,) = growth(fine, many, [t * speed], since=since * speed)
        return found


def moving(
    frame: MomentumFrame,
    chi: Callable[[Scalar], Scalar] | None,
    start: Quaternion,
    matrix: Sequence[Sequence[Scalar]],
    bounds: tuple[Scalar, Scalar],
    period: Scalar | None = None,
    between: Between | None = None,
    settled: Settled | None = None,
) -> Moving:
    """The attitude; ``matrix``: row i is axis i of F in the scene's; ``bounds``: of |w|, of F."""
    right = of_matrix(matrix)
    begin = product(frame.at(mpf(0), MP), right)
    left = product(start, conjugate(begin))
    return Moving(frame, chi, start, left, right, *bounds, period, between, settled)


def _doubles(q: Quaternion) -> Quaternion:
    a, b, c, d = q
    return float(a), float(b), float(c), float(d)

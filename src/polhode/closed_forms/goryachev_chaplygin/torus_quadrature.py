"""Two separation variables at time t: S(x) - S~(y) = const, U(x) + V(y) = t + const.

Each of S, S~, U, V is linear but for a bounded part.  The linear equations give the mean phases,
unreduced; what is left is bounded, and Newton's method finds it in doubles first.

On the line S(x) - S~(y) = const both phases grow with sigma = S(x), dt/dsigma = u + v.  Where the
body is near rest u + v is nearly 0, and a double tells the time but not sigma.  As
|d ln(u + v)/dsigma| <= a, a step of Newton's method in sigma that is cut to 1/a comes nearer
whatever the curve, and t is as right as it can be where (u + v) step^2 is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from polhode.closed_forms.functions.jacobi import MP, SeriesFunctions, numpy_functions
from polhode.closed_forms.goryachev_chaplygin.abel_integrals import Clock, Halves
from polhode.common.cached_property import cached_property
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.scalars import Scalar

_STEPS = 200
_LARGEST = 0.5  # a step of Newton's method in doubles
_CLOSE = 1e-11
_DOUBLE = 1e-15  # of a time, about what rounding leaves of it


@dataclass(frozen=True)
class Torus:
    """The phases of u and v as functions of time."""

    u: Clock
    v: Clock
    start: tuple[Scalar, Scalar]
    a: Scalar  # a bound of |d ln(u + v)/dsigma|

    @cached_property
    def constants(self) -> tuple[Scalar, Scalar]:
        """S(x) - S~(y) and U(x) + V(y) at time 0."""
        (s0, u0), (t0, v0) = self.u.means, self.v.means
        x, y = self.start
        (s, u), (t, v) = self.u.bounded(x), self.v.bounded(y)
        return s0 * x + s - t0 * y - t, u0 * x + u + v0 * y + v

    @cached_property
    def rates(self) -> tuple[Scalar, Scalar]:
        """The mean rates of the two phases."""
        (s0, u0), (t0, v0) = self.u.means, self.v.means
        delta = u0 * t0 + v0 * s0
        return t0 / delta, s0 / delta

    def mean(self, t: Scalar) -> tuple[Scalar, Scalar]:
        """The phases at time t but for what is bounded."""
        (s0, u0), (t0, v0) = self.u.means, self.v.means
        first, second = self.constants[0], self.constants[1] + t
        delta = u0 * t0 + v0 * s0
        return (v0 * first + t0 * second) / delta, (s0 * second - u0 * first) / delta

    def moment(self, x: Scalar, y: Scalar) -> Scalar:
        """The time at which the phases are x and y, if there is one."""
        (_, u0), (_, v0) = self.u.means, self.v.means
        return u0 * x + self.u.bounded(x)[1] + v0 * y + self.v.bounded(y)[1] - self.constants[1]

    def phases(self, t: Scalar) -> tuple[Scalar, Scalar]:
        """The phases of u and v at time t."""
        mean = self.mean(t)
        rest, small = self._guess(mean, t), mpmath.ldexp(1, -mpmath.prec - 16)
        for _ in range(_STEPS):
            step = _step(self, mean, rest, MP)
            along = min(max(step.along, -1 / self.a), 1 / self.a)
            dx, dy = step.phases(along)
            rest = rest[0] - dx, rest[1] - dy
            if along * along * step.speed < small and step.across * step.across < small:
                return mean[0] + rest[0], mean[1] + rest[1]
        raise ArithmeticError("the phases of the motion were not found")

    def _guess(self, mean: tuple[Scalar, Scalar], t: Scalar) -> tuple[Scalar, Scalar]:
        """What is nearly to be added to mean phases: as doubles tell it, or as at time 0."""
        if not t:
            begin = self.start
            return begin[0] - mean[0], begin[1] - mean[1]
        (x, y), turn = mean, 4 * mpmath.pi
        n, m = mpmath.nint(x / turn), mpmath.nint(y / turn) if self.v.periodic else 0
        found = self.doubles.nearly(float(x - n * turn), float(y - m * turn))
        dx, dy = (mpmath.mpf(float(z)) for z in found)
        return dx, dy

    def at(self, t: Scalar) -> tuple[tuple[Scalar, Scalar], Halves, Halves]:
        """The phases and the two variables at time t."""
        x, y = self.phases(t)
        return (x, y), self.u.at(x, MP), self.v.at(y, MP)

    @cached_property
    def doubles(self) -> DoubleTorus:
        """The same in doubles."""
        return DoubleTorus(self.u.floats(), self.v.floats())


@dataclass(frozen=True)
class DoubleTorus:
    """The torus in doubles, for arrays of times."""

    u: Clock
    v: Clock

    def corrections(self, mean_x: Scalar, mean_y: Scalar) -> tuple[Scalar, Scalar]:
        """What is to be added to mean phases (arrays or doubles); ArithmeticError near rest."""
        import numpy as np

        rest, size = self._iterated(mean_x, mean_y)
        if np.all(size < _CLOSE):
            return rest
        raise ArithmeticError("the phases of the motion were not found")

    def nearly(self, mean_x: float, mean_y: float) -> tuple[Scalar, Scalar]:
        """The same as far as doubles tell it: not at all where they do not part two roots."""
        dx, dy = self._iterated(mean_x, mean_y)[0]
        return (dx, dy) if math.isfinite(dx) and math.isfinite(dy) else (0.0, 0.0)

    def _iterated(self, mean_x: Scalar, mean_y: Scalar) -> tuple[tuple[Scalar, Scalar], Scalar]:
        """What is to be added, and the size of the last step."""
        import numpy as np

        fn = numpy_functions()
        rest, size = (np.zeros_like(mean_x), np.zeros_like(mean_y)), np.ones_like(mean_x)
        for _ in range(_STEPS):
            with np.errstate(all="ignore"):
                step = _step(self, (mean_x, mean_y), rest, fn)
            one, other = step.phases(step.along)
            size = np.maximum(np.abs(one), np.abs(other))
            share = np.where(size > _LARGEST, _LARGEST / np.maximum(size, _LARGEST), 1)
            rest = rest[0] - share * one, rest[1] - share * other
            if np.all((size < _CLOSE) | (np.abs(step.along) * step.speed < _DOUBLE)):
                break
        return rest, size


class _Step(NamedTuple):
    """Newton's step: in sigma, which ``across`` leaves as it is, and of both phases."""

    along: Scalar
    across: Scalar  # by how much S(x) - S~(y) is missed
    speed: Scalar  # u + v
    shares: tuple[Scalar, Scalar]  # v/(u + v), u/(u + v)
    slopes: tuple[Scalar, Scalar]  # S', S~'

    def phases(self, along: Scalar) -> tuple[Scalar, Scalar]:
        """The step of the phases of u and v with that part in sigma."""
        (one, other), (a, b) = self.shares, self.slopes
        return (along + one * self.across) / a, (along - other * self.across) / b


def _step(
    torus: Torus | DoubleTorus,
    mean: tuple[Scalar, Scalar],
    rest: tuple[Scalar, Scalar],
    fn: SeriesFunctions,
) -> _Step:
    """Newton's step in what is left of the phases."""
    (dx, dy), (x, y) = rest, (mean[0] + rest[0], mean[1] + rest[1])
    (s0, u0), (t0, v0) = torus.u.means, torus.v.means
    (s, u), (t, v) = torus.u.bounded(x), torus.v.bounded(y)
    one, other = torus.u.at(x, fn), torus.v.at(y, fn)
    speed = one.z + other.z
    return _Step(
        along=(u0 * dx + u + v0 * dy + v) / speed,
        across=s0 * dx + s - t0 * dy - t,
        speed=speed,
        shares=(other.z / speed, one.z / speed),
        slopes=(one.slope, other.slope),
    )

"""Two separation variables at time t: S(x) - S~(y) = const, U(x) + V(y) = t + const.

Each of S, S~, U, V is linear but for a bounded part.  The linear equations give the mean phases,
unreduced; what is left is bounded, and Newton's method finds it in doubles first.
"""

from __future__ import annotations

from dataclasses import dataclass

from polhode.closed_forms.functions.jacobi import MP, SeriesFunctions, numpy_functions
from polhode.closed_forms.goryachev_chaplygin.abel_integrals import Clock, Halves
from polhode.common.cached_property import cached_property
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.scalars import Scalar

_STEPS = 200
_LARGEST = 0.5  # a step of Newton's method in doubles
_CLOSE = 1e-11


@dataclass(frozen=True)
class Torus:
    """The phases of u and v as functions of time."""

    u: Clock
    v: Clock
    start: tuple[Scalar, Scalar]

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
        x, y = self.mean(t)
        turn = 4 * mpmath.pi
        n, m = mpmath.nint(x / turn), mpmath.nint(y / turn) if self.v.periodic else 0
        near = float(x - n * turn), float(y - m * turn)
        dx, dy = (mpmath.mpf(float(z)) for z in self.doubles.corrections(*near))
        for _ in range(_STEPS):
            step = _step(self, (x, y), (dx, dy), MP)
            dx, dy = dx - step[0], dy - step[1]
            if max(abs(step[0]), abs(step[1])) < mpmath.ldexp(1, -mpmath.prec // 2 - 8):
                return x + dx, y + dy
        raise ArithmeticError("the phases of the motion were not found")

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
        """What is to be added to mean phases (arrays or doubles)."""
        import numpy as np

        fn = numpy_functions()
        dx, dy = np.zeros_like(mean_x), np.zeros_like(mean_y)
        for _ in range(_STEPS):
            one, other = _step(self, (mean_x, mean_y), (dx, dy), fn)
            size = np.maximum(np.abs(one), np.abs(other))
            share = np.where(size > _LARGEST, _LARGEST / np.maximum(size, _LARGEST), 1)
            dx, dy = dx - share * one, dy - share * other
            if np.all(size < _CLOSE):
                return dx, dy
        raise ArithmeticError("the phases of the motion were not found")


def _step(
    torus: Torus | DoubleTorus,
    mean: tuple[Scalar, Scalar],
    rest: tuple[Scalar, Scalar],
    fn: SeriesFunctions,
) -> tuple[Scalar, Scalar]:
    """Newton's step in what is left of the phases."""
    (dx, dy), (x, y) = rest, (mean[0] + rest[0], mean[1] + rest[1])
    (s0, u0), (t0, v0) = torus.u.means, torus.v.means
    (s, u), (t, v) = torus.u.bounded(x), torus.v.bounded(y)
    one, other = torus.u.at(x, fn), torus.v.at(y, fn)
    first, second = s0 * dx + s - t0 * dy - t, u0 * dx + u + v0 * dy + v
    a, b = one.slope, other.slope  # S' and S~'
    delta = a * b * (one.z + other.z)
    return b * (other.z * first + second) / delta, a * (second - one.z * first) / delta

"""Hess's general motion in doubles, for arrays of times: what the counting of turns asks."""

from __future__ import annotations

import numpy as np

from polhode.closed_forms.functions.jacobi import SeriesFunctions
from polhode.closed_forms.functions.quaternion import product
from polhode.closed_forms.hess.explicit import SurfacePoint
from polhode.closed_forms.hess.general import GeneralMotion, powered
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.rows import Complexes, Doubles

_TERMS = 40  # of a step's series: they fall by e^-2


class DoubleGeneral:
    """The motion at arrays of times, in units of 1/speed."""

    def __init__(self, motion: GeneralMotion) -> None:
        self._motion = motion
        steps, bits = motion.series.steps, motion.series.bits
        self._begins = np.array([float(step.begin) for step in steps])
        self._lengths = np.array([float(step.length) for step in steps])
        self._rows = np.array(
            [
                [[float(mpmath.ldexp(x, -bits)) for x in row[:_TERMS]] for row in step.rows]
                for step in steps
            ]
        )

    def at(self, t: Doubles, fn: SeriesFunctions) -> SurfacePoint:
        """The points."""
        t1 = float(self._motion.period_of_u)
        n = np.floor(t / t1)
        numbers, index = np.unique(n, return_inverse=True)
        found = [self._turned(int(number)) for number in numbers]
        al = np.array([x for x, _ in found])[index]
        turn = np.array([x for _, x in found])[index]
        point = self.within(t - n * t1, al)
        zero = np.zeros_like(turn.real)
        return point._replace(frame=product((turn.real, zero, zero, turn.imag), point.frame))

    def within(self, rest: Doubles, al: Complexes | complex) -> SurfacePoint:
        """The points at times in the first period, where al begins with that direction."""
        which = np.clip(np.searchsorted(self._begins, rest, side="right") - 1, 0, None)
        s = (rest - self._begins[which]) / self._lengths[which]
        rows = np.zeros((self._rows.shape[1], len(rest)))
        for k in reversed(range(self._rows.shape[2])):
            rows = rows * s + self._rows[which, :, k].T
        z1, z2, g1, g2, u, U1, U2, V1, V2, *q = rows
        inner = (U1 + 1j * U2) * al + np.conj((V1 + 1j * V2) * al)
        half = np.conj(inner) / np.abs(inner)
        Z, g = (z1 + 1j * z2) * half**2, (g1 + 1j * g2) * half**2
        zero = np.zeros_like(rest)
        frame = product((q[0], q[1], q[2], q[3]), (half.real, -half.imag, zero, zero))
        return SurfacePoint((Z.real, Z.imag), (g.real, g.imag), u, frame)

    def _turned(self, n: int) -> tuple[complex, complex]:
        """The direction of al after n periods, and the half turn in space."""
        one, other = powered(self._motion.N, n)
        al = one + other.conjugate()
        c, s = mpmath.cos_sin(mpf(n) * self._motion.space)
        return complex(al / abs(al)), complex(c, s)

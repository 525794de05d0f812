"""N. Kowalewski's motions: q^2 quadratic and r^2 cubic in p, time a hyperelliptic integral.

Mg r0 = (c, 0, 0), c > 0, A (10B - 9C) = 18 C (B - C); x = B/C, D = 10x - 9, c3 > 0 a scale

    q^2 = b0 + b1 p + b2 p^2,    r^2 = c0 + c1 p + c2 p^2 + c3 p^3,    p' = (B - C) q r/A

(N. Kowalewski, Math. Ann. 65 (1908) 528), the coefficients in :func:`.conditions.frame_of`.  Time
is a Fourier series in an angle between two zeros of Q R (:mod:`..functions.one_degree`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from polhode.closed_forms._engine.orbit_motion import Orbit, OrbitMotion
from polhode.closed_forms.functions.gamma_from_omega import Frame
from polhode.closed_forms.functions.quadrature_1dof import OneDegree, one_degree
from polhode.closed_forms.functions.rounding import number
from polhode.closed_forms.n_kowalewski.conditions import conditions, frame_of

REGIME = "N. Kowalewski"


@dataclass(frozen=True)
class _Motion:
    """The orbit at one precision."""

    flow: OneDegree
    frame: Frame

    @property
    def period(self) -> Any:
        """Of w and gamma."""
        return self.flow.period

    @property
    def fastest(self) -> Any:
        """The rate of the phase."""
        return self.flow.fastest

    def at(self, t: Any) -> tuple[Any, ...]:
        """p, q, r, gamma1, gamma2, gamma3."""
        return self._state(*self.flow.at(t))

    def clock(self, t: Any) -> Any:
        """The angle x of the flow."""
        return self.flow.clock(t)

    def along(self, s: Any) -> tuple[Sequence[Any], Any]:
        """The state at the angle, and dt/dx."""
        return self._state(*self.flow.along(s)), self.flow.pace(s)

    def _state(self, p: Any, q: Any, r: Any) -> tuple[Any, ...]:
        return p, q, r, *self.frame.gamma(p, q, r)


class NKowalewski(OrbitMotion):
    """One motion of N. Kowalewski; :class:`OrbitMotion` says what it is asked."""

    conditions = staticmethod(conditions)

    def _regime(self) -> str:
        return REGIME

    def _orbit(self, bits: int) -> Orbit:
        A, B, C = self.normal.moments
        p, q, r = (number(x, bits) for x in self.normal.omega)
        frame = frame_of(self.normal).mapped(lambda x: number(x, bits))
        return _Motion(one_degree(frame.Q, frame.R, number((B - C) / A, bits), (p, q, r)), frame)

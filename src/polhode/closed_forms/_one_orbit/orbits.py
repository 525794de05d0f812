"""Orbits whose time is an elliptic argument, or a Fourier series in an angle."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from polhode.closed_forms.functions.elliptic import Elliptic
from polhode.closed_forms.functions.quadrature_1dof import OneDegree
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.scalars import Scalar

#: p, q, r, gamma1, gamma2, gamma3 of sn, cn, dn, or of the three numbers of a flow.
Formula = Callable[[Scalar, Scalar, Scalar], Sequence[Scalar]]


@dataclass(frozen=True)
class EllipticOrbit:
    """The state in sn, cn and dn of v = v0 + nu t; ``quarters``: periods K after which it repeats.

    Without period where the modulus is 1.
    """

    elliptic: Elliptic
    v0: Scalar
    nu: Scalar
    formula: Formula
    quarters: int = 4

    @property
    def period(self) -> Scalar | None:
        """Of w and gamma."""
        if not mpmath.isfinite(self.elliptic.K):
            return None
        return self.quarters * self.elliptic.K / self.nu

    @property
    def fastest(self) -> Scalar:
        """The rate of the phase."""
        return self.nu

    def at(self, t: Scalar) -> Sequence[Scalar]:
        """p, q, r, gamma1, gamma2, gamma3."""
        return self.formula(*self.elliptic.at(self.v0 + self.nu * t))


@dataclass(frozen=True)
class FlowOrbit:
    """The state in the three numbers of a flow with one degree of freedom."""

    flow: OneDegree
    formula: Formula

    @property
    def period(self) -> Scalar:
        """Of w and gamma."""
        return self.flow.period

    @property
    def fastest(self) -> Scalar:
        """The rate of the phase."""
        return self.flow.fastest

    def at(self, t: Scalar) -> Sequence[Scalar]:
        """p, q, r, gamma1, gamma2, gamma3."""
        return self.formula(*self.flow.at(t))

    def clock(self, t: Scalar) -> Scalar:
        """The angle x of the flow."""
        return self.flow.clock(t)

    def along(self, s: Scalar) -> tuple[Sequence[Scalar], Scalar]:
        """The state at the angle, and dt/dx."""
        return self.formula(*self.flow.along(s)), self.flow.pace(s)

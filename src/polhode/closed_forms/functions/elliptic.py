"""sn, cn, dn of a phase that grows uniformly, and the phase of a given start.

Parameter m and complement m1 = 1 - m come separately, each with all its digits.
"""

from __future__ import annotations

from dataclasses import dataclass

from polhode.closed_forms.functions.jacobi import MP, Jacobi, jacobi
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.scalars import Scalar


@dataclass(frozen=True)
class Elliptic:
    """Jacobi's functions of one modulus at the precision in force when it was made."""

    jacobi: Jacobi

    @property
    def K(self) -> Scalar:  # noqa: N802
        """The quarter period; infinite where m1 = 0."""
        return self.jacobi.K

    def at(self, v: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        """sn, cn, dn at v."""
        waves = self.jacobi.waves(v, MP)
        sn, cn, dn = self.jacobi.functions(waves)
        return (-sn, -cn, dn) if waves.turns % 2 else (sn, cn, dn)

    def phase(self, sn: Scalar, cn: Scalar, dn: Scalar) -> Scalar:
        """The v in (-2K, 2K] with these values, dn >= 0 (Carlson 1979; DLMF 22.15, 19.25)."""
        v = sn * mpmath.elliprf(cn * cn, dn * dn, 1)
        if cn < 0:
            return 2 * self.K - v if sn >= 0 else -2 * self.K - v
        return v


def elliptic(m: Scalar, m1: Scalar) -> Elliptic:
    """The functions of parameter m and complement m1, both >= 0."""
    return Elliptic(jacobi(m, m1))

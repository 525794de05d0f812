"""The separation variables of the Kovalevskaya top at a state, for any scalars.

With sg = 2p and pi = p^2 + q^2, s1 and s2 are the roots of q^2 s^2 + (R/2) s + R1/4,

    R = -pi^2 + 2H pi - 2m sg + b,    R1 = -2H pi^2 - b sg^2 + 4m pi sg + 2Hb - 4m^2,

and w_i = T' s_i - N', T = s1 + s2, N = s1 s2, sg' = q r, pi' = q G3, 2q' = -p r + G3 (Kowalevski
1889; Mumford's form of the divisor).  Where q = 0, s1 is infinite, s2 = -R1/2R, and s2 has no first
and no second derivative; the third one of the quadratic equation tells w2.
"""

from __future__ import annotations

from typing import NamedTuple

from polhode.numbers.number_types import Scalar


class State(NamedTuple):
    """What the separation variables take of a state and of its integrals, exact or in balls."""

    p: Scalar
    q: Scalar
    r: Scalar
    G2: Scalar
    G3: Scalar
    H: Scalar
    m: Scalar
    b: Scalar

    @property
    def pi(self) -> Scalar:
        """p^2 + q^2."""
        return self.p * self.p + self.q * self.q

    @property
    def slope(self) -> Scalar:
        """q'."""
        return (self.G3 - self.p * self.r) / 2

    def polars(self) -> tuple[Scalar, Scalar]:
        """R and R1."""
        H, m, b, sg, pi = self.H, self.m, self.b, 2 * self.p, self.pi
        R = -pi * pi + 2 * H * pi - 2 * m * sg + b
        return R, -2 * H * pi * pi - b * sg * sg + 4 * m * pi * sg + 2 * H * b - 4 * m * m

    def halves(self) -> tuple[Scalar, Scalar]:
        """R/2 and R1/4."""
        R, R1 = self.polars()
        return R / 2, R1 / 4

    def rates(self) -> tuple[Scalar, Scalar]:
        """T' and N', where q is not 0."""
        H, m, b, q, q1, sg, pi = self.H, self.m, self.b, self.q, self.slope, 2 * self.p, self.pi
        R, R1 = self.polars()
        sg1, pi1 = q * self.r, q * self.G3
        R_1 = 2 * (H - pi) * pi1 - 2 * m * sg1
        R1_1 = -4 * H * pi * pi1 - 2 * b * sg * sg1 + 4 * m * (pi1 * sg + pi * sg1)
        return (R * q1 / q - R_1 / 2) / (q * q), (R1_1 / 4 - R1 * q1 / (2 * q)) / (q * q)

    def finite_point(self) -> tuple[Scalar, Scalar]:
        """s2 and w2, where q is 0."""
        R, R1 = self.polars()
        p, H, m, b, s = self.p, self.H, self.m, self.b, -R1 / (2 * R)
        return s, -self.G2 * (
            (m - p * (H - p * p)) * s + p * (p * (H * p - 3 * m) + b)
        ) / self.slope

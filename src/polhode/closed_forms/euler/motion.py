"""The torque-free rotation in balls: angular velocity and turn, in the moments' own axes.

I w' + w x I w = 0 in principal axes numbered for the motion (:func:`.regimes.numbered`): the
polhode circles axis 3, which belongs to the largest or the smallest moment, and axis 2 to the
middle one.  With 2h = w.Iw and G = |Iw| (Whittaker, Analytical Dynamics, art. 69; van Zon and
Schofield, J. Comput. Phys. 225 (2007) 145, section 3)

    P = 2h I3 - G^2,  R = G^2 - 2h I1,  k^2 = (I2-I1)P/((I3-I2)R),  rate^2 = (I3-I2)R/(I1 I2 I3),
    w = (s1 p_m cn v, s2 q_m sn v, s3 r_m dn v),  v = v0 + rate t.

In space axes of which the third is along G, Iw/G = (s1 sin th cos chi, -s1 sin th sin chi, cos th)
has the angles z-y-z of the attitude.  Half of each is linear in time, but for the root of a number
in the right half plane, whose principal value is continuous.

The third body axis has the projection -s1 sin th exp(i psi) on the plane across G, a quotient of
theta functions times a uniform turn (Jacobi), and the vertical gamma one that stays.  So with
Z = Iw/G their product H, the second conjugated, is such a quotient; it and gamma.Z = u give

    H = u Z3 - gamma3 + i (gamma1 Z2 - gamma2 Z1),    gamma3 = u Z3 - Re H,
    (gamma1, gamma2) = u (Z1, Z2) + (Re H Z3 (Z1, Z2) + Im H (Z2, -Z1))/(Z1^2 + Z2^2).
"""

from __future__ import annotations

from collections.abc import Sequence

from flint import acb, arb

from polhode.closed_forms.balls.core import ball, root
from polhode.closed_forms.balls.frames import Frame, Start, Turn, conjugate, quaternion
from polhode.closed_forms.balls.jacobi import Jacobi, Place, Shift
from polhode.closed_forms.euler.regimes import Numbers
from polhode.numbers.vectors import quaternion_product

_I = acb(0, 1)
_QUARTERS = (acb(1), _I, acb(-1), -_I)


class Polhode:
    """The general motion; k = 0 (two equal moments) and k' = 0 (the separatrix) included."""

    def __init__(
        self, numbers: Numbers, frame: Frame, start: Start, vertical: Sequence[arb] | None
    ) -> None:
        n = numbers
        self._frame, self._start = frame, start
        self.elliptic = Jacobi(ball(n.k2), ball(n.kc2))
        self.rate, momentum = root(n.rate2), root(n.G2)
        self._sense, (self._s1, s2, self._s3) = n.sense, n.signs
        amplitudes = [s * root(x) for s, x in zip(n.signs, n.squares, strict=True)]
        self.speed = root(n.squares[0] + n.squares[1] + n.squares[2])
        self._forward = self._s1 * s2 < 0  # the sense of chi
        sn2, cn2, dn2 = (ball(x) for x in n.phase)
        self._v0 = self.elliptic.phase(n.side * sn2.sqrt(), cn2, dn2)
        shift = self.elliptic.shift(*(ball(x) for x in n.shift))
        self._shift = Shift(self.elliptic, shift, half=False)
        turning = self._sense * self._shift.rate * self.rate
        #: The mean rate of the third axis about G.
        self.precession = momentum / ball(n.moments[2]) + turning
        self._rates = [momentum / ball(m) for m in n.moments]  # w over Iw/G
        self._momentum = [x / rate for x, rate in zip(amplitudes, self._rates, strict=True)]
        self._g = tuple(map(abs, self._momentum))
        begin = self.elliptic.at(self._v0)
        self._begin = conjugate(self._place(begin, arb(0)))
        if vertical is not None:
            self._along, across = _projections(self._direction(begin), vertical)
            self._across = across / self._turned(begin, arb(0))

    def row(self, t: arb, attitude: bool) -> Sequence[arb]:
        """The row at a time."""
        at = self.elliptic.at(self._v0 + self.rate * t)
        direction = self._direction(at)
        row = self._frame.back([x * rate for x, rate in zip(direction, self._rates, strict=True)])
        if self._start.attitude is None:
            return row
        row += self._frame.back(self._vertical(direction, at, t))
        if attitude:
            turn = self._frame.turn(quaternion_product(self._begin, self._place(at, t)))
            row += quaternion_product(self._start.attitude, turn)
        return row

    def _direction(self, at: Place) -> tuple[arb, arb, arb]:
        """Iw/G."""
        a, b, c = self._momentum
        return at.side * (a * at.cn), at.side * (b * at.sn), c * at.dn

    def _turned(self, at: Place, t: arb) -> acb:
        """The projection of the third axis across G, but for a factor that stays."""
        theta = self._shift.at(at)
        sine, cosine = (self.precession * t).sin_cos()
        return (theta if self._sense > 0 else theta.conjugate()) * acb(cosine, sine)

    def _vertical(self, direction: tuple[arb, arb, arb], at: Place, t: arb) -> tuple[arb, arb, arb]:
        """gamma."""
        z1, z2, z3 = direction
        across = self._across * self._turned(at, t)
        one, other, along = across.real, across.imag, self._along
        square = z1 * z1 + z2 * z2
        same, turned = along + one * z3 / square, other / square
        return z1 * same + z2 * turned, z2 * same - z1 * turned, along * z3 - one

    def _place(self, at: Place, t: arb) -> Turn:
        """The quaternion body -> space in axes of space of which the third is along G."""
        g1, g2, g3 = self._g
        x, y = g1 * at.cn, g2 * at.sn
        near = ((1 + g3 * at.dn) / 2).sqrt()
        far = (x * x + y * y).sqrt() / (2 * near)
        cos, sin = (near, far) if self._s3 > 0 else (far, near)
        theta = self._shift.at(at)
        psi = _half_argument(theta if self._sense > 0 else theta.conjugate())
        psi *= (_I * (self.precession * t / 2)).exp()
        chi = _half_argument(acb(x, y)) * _QUARTERS[at.n % 4]
        if not self._forward:
            chi = chi.conjugate()
        return quaternion(psi * chi * cos, psi * chi.conjugate() * (-self._s1 * sin) * _I)


def _projections(z: Sequence[arb], gamma: Sequence[arb]) -> tuple[arb, acb]:
    """u and H of the vertical; H of its part across z3, which may be all that is not small."""
    (z1, z2, z3), (g1, g2, g3) = z, gamma
    level = z1 * g1 + z2 * g2
    across = acb(z3 * level - g3 * (z1 * z1 + z2 * z2), g1 * z2 - g2 * z1)
    return level + z3 * g3, across


def _half_argument(z: acb) -> acb:
    """exp of i/2 times the argument of z, whose real part is positive."""
    return (z / abs(z)).sqrt()

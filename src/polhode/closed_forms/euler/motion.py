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
"""

from __future__ import annotations

from collections.abc import Sequence

from flint import acb, arb

from polhode.closed_forms.balls.core import ball, root
from polhode.closed_forms.balls.frames import Frame, Start, Turn, conjugate, quaternion
from polhode.closed_forms.balls.jacobi import Jacobi
from polhode.closed_forms.euler.regimes import Numbers
from polhode.numbers.vectors import quaternion_product

_I = acb(0, 1)
_QUARTERS = (acb(1), _I, acb(-1), -_I)


class Polhode:
    """The general motion; k = 0 (two equal moments) and k' = 0 (the separatrix) included."""

    def __init__(self, numbers: Numbers, frame: Frame, start: Start) -> None:
        n = numbers
        self._frame, self._start = frame, start
        self.elliptic = Jacobi(ball(n.k2), ball(n.kc2))
        self.rate, momentum = root(n.rate2), root(n.G2)
        self._sense, (self._s1, s2, self._s3) = n.sense, n.signs
        self._amplitudes = [s * root(x) for s, x in zip(n.signs, n.squares, strict=True)]
        self.speed = root(n.squares[0] + n.squares[1] + n.squares[2])
        g1, g2, g3 = (
            ball(m) * x / momentum for m, x in zip(n.moments, self._amplitudes, strict=True)
        )
        self._g = abs(g1), abs(g2), abs(g3)
        self._forward = self._s1 * s2 < 0  # the sense of chi
        sn2, cn2, dn2 = (ball(x) for x in n.phase)
        self._v0 = self.elliptic.phase(n.side * sn2.sqrt(), cn2, dn2)
        self._shift = self.elliptic.shift(*(ball(x) for x in n.shift))
        turning = self._sense * self.elliptic.rate(self._shift, half=False) * self.rate
        #: The mean rate of the third axis about G.
        self.precession = momentum / ball(n.moments[2]) + turning
        self._begin = conjugate(self._place(arb(0))[1])

    def row(self, t: arb, attitude: bool) -> Sequence[arb]:
        """The row at a time."""
        del attitude
        omega, place = self._place(t)
        turn = self._frame.turn(quaternion_product(self._begin, place))
        return self._start.row(self._frame.back(omega), turn)

    def _place(self, t: arb) -> tuple[list[arb], Turn]:
        """w, and the quaternion body -> space in axes of space of which the third is along G."""
        at = self.elliptic.at(self._v0 + self.rate * t)
        (a, b, c), (g1, g2, g3) = self._amplitudes, self._g
        omega = [at.side * a * at.cn, at.side * b * at.sn, c * at.dn]
        x, y = g1 * at.cn, g2 * at.sn
        near = ((1 + g3 * at.dn) / 2).sqrt()
        far = (x * x + y * y).sqrt() / (2 * near)
        cos, sin = (near, far) if self._s3 > 0 else (far, near)
        theta = at.quotient(self._shift, half=False)
        psi = _half_argument(theta if self._sense > 0 else theta.conjugate())
        psi *= (_I * (self.precession * t / 2)).exp()
        chi = _half_argument(acb(x, y)) * _QUARTERS[at.n % 4]
        if not self._forward:
            chi = chi.conjugate()
        return omega, quaternion(psi * chi * cos, psi * chi.conjugate() * (-self._s1 * sin) * _I)


def _half_argument(z: acb) -> acb:
    """exp of i/2 times the argument of z, whose real part is positive."""
    return (z / abs(z)).sqrt()

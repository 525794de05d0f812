"""The attitude of Bobylev and Steklov's asymptotic motion, in elementary functions.

Ga = 1, r = 2 s nu sech v, s = +-1, k = p^2 + nu^2.  The Cayley-Klein parameters of the axes 2, 3, 1
(axis 1 as the third) are, up to a turn of the space axes about the vertical,

    al = (p + i nu tanh v) exp(i p t/2)/sqrt(k),    bt = s nu sech v exp(i p t/2)/sqrt(k),

which follows from psi' (Yehia 3.33, the axes renamed) = k p cosh^2 v/(k sinh^2 v + p^2) and
gamma2 + i gamma3 = 2i conj(al) bt.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from polhode.closed_forms._winding.winding_number import bisected
from polhode.closed_forms.functions.jacobi import SeriesFunctions
from polhode.closed_forms.functions.quaternion import Quaternion, product
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from polhode.numbers.scalars import Scalar


@dataclass(frozen=True)
class Asymptotic:
    """The quaternion body -> space as a function of time, at one precision.

    ``placed`` takes an axial vector from the normal axes to the scene's.
    """

    start: Quaternion
    placed: Callable[[Scalar], list[Scalar]]
    determinant: int
    p: Scalar
    nu: Scalar
    v0: Scalar
    positive: bool  # s = 1

    def at(self, t: Scalar, fn: SeriesFunctions) -> Quaternion:
        """The attitude at t, continuous in t."""
        del fn
        return self._seen(self.v0 + self.nu * t, self.p * t / 2) if t else self.start

    def _seen(self, v: Scalar, turned: Scalar) -> Quaternion:
        """The attitude at v, with ``turned`` in place of p t/2."""
        w, x, y, z = self._place(self.v0, mpf(0))
        c, *axis = product((w, -x, -y, -z), self._place(v, turned))
        second, third, first = axis
        x, y, z = self.placed((first, second, third))
        return product(self.start, (c, x, y, z))

    def _place(self, v: Scalar, turned: Scalar) -> Quaternion:
        root = mpmath.sqrt(self.p**2 + self.nu**2)
        phase = mpmath.expj(turned) / root
        al = mpc(self.p, self.nu * mpmath.tanh(v)) * phase
        bt = self.nu * mpmath.sech(v) * phase
        if not self.positive:
            bt = -bt
        return al.real, bt.real, bt.imag, al.imag

    def arguments(self, t: Scalar) -> tuple[Scalar, Scalar]:
        """The growth of arg(q0 + i q3) and arg(q1 + i q2) from time 0 to t.

        Without their common turn about the vertical the two parameters move at most at sqrt(2) in
        x = atan(sinh v), dx = sech v dv; from |v| = ``last`` on their directions stay.
        """
        last = mpmath.prec * mpmath.ln2 / 3

        def moved(v: Scalar) -> Scalar:
            return 3 * mpmath.atan(mpmath.sinh(min(max(v, -last), last)))

        def fine(x: Scalar) -> tuple[Scalar, Scalar]:
            q0, q1, q2, q3 = self._seen(mpmath.asinh(mpmath.tan(x / 3)), mpf(0))
            return mpc(q0, q3), mpc(q1, q2)

        turned = self.determinant * self.p * t / 2
        one, other = bisected(fine, moved(self.v0), moved(self.v0 + self.nu * t))
        return turned + one, turned + other

    @property
    def speed(self) -> Any:
        """An upper bound of |w|."""
        return abs(self.p) + 2 * self.nu

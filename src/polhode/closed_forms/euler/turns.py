"""Turns of psi and phi of a torque-free body about any vertical, at a cost that no time changes.

Seen from G the numbered axes have Cayley-Klein parameters al', bt' whose moduli have the period 4K
of the polhode's phase u and whose arguments are known for all time; so are those of

    al* = la al' - conj(mu) bt',    bt* = mu al' + conj(la) bt'

for the scene's axes (la, mu of the turn between them) but for turns over one period.  With a, b
of the turn from the space axes along G to those along the vertical,

    al = a al* - b conj(bt*),    bt = a bt* + b conj(al*),

each the sum of two terms of known arguments (:mod:`polhode.closed_forms._winding.argument_of_sum`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

from polhode.closed_forms._winding.argument_of_sum import Polar, Sum, Terms, Turning
from polhode.closed_forms.euler.crossings import crossings
from polhode.closed_forms.euler.motion import Polhode
from polhode.closed_forms.functions.jacobi import MP
from polhode.closed_forms.functions.quaternion import AnyVector, Quaternion
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from polhode.numbers.scalars import Scalar


class PolhodeTurns:
    """Growth of arg al and arg bt of one motion, at the precision in force.

    ``left`` and ``right``: q(t) = left q'(t) right, q' the quaternion of the numbered axes in the
    space axes along G (:meth:`Polhode.place`).  ``axis`` is the scene's third axis in the numbered
    axes, ``cosine`` that of the angle between the vertical and G; their zeros are exact.
    """

    def __init__(
        self, motion: Polhode, left: Quaternion, right: Quaternion, axis: AnyVector, cosine: Scalar
    ) -> None:
        self._motion = motion
        # The same as a function of u, without what turns evenly in time.
        self._own = replace(motion, rate=mpf(1), v0=mpf(0), precession=mpf(0))
        a, b = _parameters(left)
        la, mu = _parameters(right)
        about_third = motion.jump, -motion.sense * mpmath.pi  # half of psi and of phi, in 4K
        begun = about_third[0] + about_third[1], about_third[0] - about_third[1]
        third, along = axis[2], (mpf(0), mpf(0), motion.momentum[2])
        numbered = lru_cache(maxsize=4)(self._numbered)  # asked four times for each of two times
        one = self._sum((la, -mpmath.conj(mu)), begun, numbered, along, -third)
        two = self._sum((mu, mpmath.conj(la)), begun, numbered, along, third)
        if (not a or not b) and (one.vanishes() or two.vanishes()):
            raise ArithmeticError("the third axis passes through the vertical")

        def ahead(u: Scalar) -> Terms:
            return one.at(u), two.at(u).conjugate()

        def behind(u: Scalar) -> Terms:
            return two.at(u), one.at(u).conjugate()

        # (cn, sn, dn) times the row is the cosine of the angle between the axis and G.
        row = tuple(x * z for x, z in zip(axis, motion.momentum, strict=True))
        back = tuple(-x for x in row)
        advances = (one.advance, -two.advance), (two.advance, -one.advance)
        spins = motion.precession / 2, -motion.precession / 2
        al = self._sum((a, -b), advances[0], ahead, row, -cosine)
        bt = self._sum((a, b), advances[1], behind, back, -cosine)
        self._parts = Turning(al, motion, spins), Turning(bt, motion, spins)

    def growth(self, first: Scalar, last: Scalar) -> tuple[Scalar, Scalar]:
        """Of both arguments between two times."""
        al, bt = self._parts
        return al.growth(first, last), bt.growth(first, last)

    def _numbered(self, u: Scalar) -> Terms:
        """al' and bt' without the even turning."""
        q0, q1, q2, q3 = self._own.place(u, MP)[1]
        psi, phi = self._own.angles(u)
        side = -1 if self._own.momentum[0] > 0 else 1
        return (
            Polar(mpmath.hypot(q0, q3), (psi + phi) / 2),
            Polar(mpmath.hypot(q1, q2), (psi - phi + side * mpmath.pi) / 2),
        )

    def _sum(
        self,
        factors: tuple[Scalar, Scalar],
        advances: tuple[Scalar, Scalar],
        terms: Callable[[Scalar], Terms],
        row: tuple[Scalar, Scalar, Scalar],
        value: Scalar,
    ) -> Sum:
        """The sum of two terms with factors; the first leads where row.(cn, sn, dn) > value."""

        def scaled(u: Scalar) -> Terms:
            one, two = terms(u)
            return one.times(factors[0]), two.times(factors[1])

        begins, places = crossings(self._motion.elliptic, row, value)
        return Sum(scaled, advances, 0 if begins else 1, places)


def _parameters(q: Quaternion) -> tuple[Scalar, Scalar]:
    """al and bt, either 0 where it is but for rounding."""
    tiny = mpmath.ldexp(1, -mpmath.prec // 2)
    al, bt = mpc(q[0], q[3]), mpc(q[1], q[2])
    return (al if abs(al) > tiny else mpc(0)), (bt if abs(bt) > tiny else mpc(0))

"""Turns about an axis that is fixed in the body and in space, and psi and phi at any angle.

After a turn by 2x about the unit vector n the attitude is q cos x + q (0, n) sin x, so that each of
al = q0 + i q3 and bt = q1 + i q2 runs on an ellipse z0 cos x + z1 sin x, anticlockwise, clockwise
or to and fro through 0 as Im(conj(z0) z1) is positive, negative or 0.  With the vertical g,

    2 Im(conj(al0) al1) = n.g + n3,    2 Im(conj(bt0) bt1) = n.g - n3,

and al1, bt1 are those of the half turn about n, which takes g to 2(n.g) n - g.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from flint import acb, arb

from polhode.closed_forms.balls.angles import Arguments
from polhode.closed_forms.balls.core import TooFewBits, nearest_integer
from polhode.closed_forms.balls.frames import Motion, Turn, turned_back
from polhode.numbers.exact import sign
from polhode.numbers.vectors import Vector, cross, dot, is_zero, minus, quaternion_product, scaled


class OneAxis:
    """What is decided exactly of the turns about ``n``, of any length, from the vertical ``g``."""

    def __init__(self, n: Vector, g: Vector) -> None:
        along = dot(n, g)
        self._senses = sign(along + n[2]), sign(along - n[2])
        self._begins = _present(g)
        self._crosses = _present(minus(scaled(2 * along, n), scaled(dot(n, n), g)))
        self._upright = all(self._begins) and is_zero(cross(n, g))
        self._up = sign(along)

    def arguments(self, start: Turn, n: tuple[arb, arb, arb], x: arb) -> Arguments:
        """The growth of arg al and arg bt over a turn by 2x from ``start``, ``n`` a unit vector.

        Through 0 an argument grows by pi wherever the turn leads away from the start, and falls by
        it where the turn comes back.
        """
        if self._upright:  # both by half of psi
            return self._up * x, self._up * x
        across = quaternion_product(start, (arb(0), *n))
        al, bt = (
            _grown(
                acb(start[i], start[j]) if begins else None,
                acb(across[i], across[j]) if crosses else None,
                sense,
                x,
            )
            for (i, j), begins, crosses, sense in zip(
                ((0, 3), (1, 2)), self._begins, self._crosses, self._senses, strict=True
            )
        )
        return al, bt


class PermanentRotation(Motion):
    """w constant: the body turns uniformly about it (Rodrigues' formula), or rests.

    ``half``: |w|/2, the exact 0 at rest; ``vertical``: at t = 0, None where it is not known;
    ``stays``: whether it is along w, or the body rests; ``precession``: the frequency to be told.
    """

    def __init__(
        self,
        omega: Sequence[arb],
        half: arb,
        vertical: Sequence[arb] | None,
        *,
        stays: bool = False,
        precession: arb | None = None,
    ) -> None:
        self._omega, self._half, self._vertical, self._stays = omega, half, vertical, stays
        self._precession = precession
        self.speed = arb(1) if half.is_zero() else 2 * half

    def at(self, t: arb) -> Sequence[arb]:
        """The same w, and the vertical turned back."""
        if self._vertical is None:
            return self._omega
        if self._stays:
            return *self._omega, *self._vertical
        return *self._omega, *turned_back(self.turn(t, ()), self._vertical)

    def turn(self, t: arb, state: Sequence[arb]) -> Turn:
        """The turn about w by |w| t."""
        del state
        sin, cos = self.swung(t).sin_cos()
        x, y, z = (sin * w / self.speed for w in self._omega)
        return cos, x, y, z

    def swung(self, t: arb) -> arb:
        """Half the angle turned since t = 0."""
        return self._half * t

    def rates(self) -> Mapping[str, arb]:
        """ "precession", where it is to be told."""
        return {} if self._precession is None else {"precession": self._precession}


def _present(g: Vector) -> tuple[bool, bool]:
    """Whether al, and bt, of a vertical is not 0; a vertical without length has neither."""
    tilted = sign(g[0]) != 0 or sign(g[1]) != 0
    side: int = sign(g[2])
    return tilted or side > 0, tilted or side < 0


def _grown(cosine: acb | None, sine: acb | None, sense: int, x: arb) -> arb | None:
    """The growth of the argument of one cos x + other sin x from 0; None where it is always 0."""
    if cosine is None and sine is None:
        return None
    if sense and cosine is not None:
        n = nearest_integer(x / arb.pi())
        rest = x - n * arb.pi()
        z = cosine if sine is None else cosine * rest.cos() + sine * rest.sin()
        return sense * n * arb.pi() + (z / cosine).arg()
    if cosine is None:
        return _whole(abs(x) / arb.pi()) * arb.pi()
    beta = arb(0) if sine is None else (sine / cosine).real.atan()
    return abs(_whole((x - beta) / arb.pi() + arb(1) / 2)) * arb.pi()


def _whole(x: arb) -> int:
    """The integer part, rounded down."""
    n = x.floor().unique_fmpz()
    if n is None:
        raise TooFewBits
    return int(n)

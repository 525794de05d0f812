"""Turns about an axis that is fixed in the body and in space, and psi and phi at any angle.

After a turn by 2x about the unit vector n the attitude is q cos x + q (0, n) sin x, so that each of
al = q0 + i q3 and bt = q1 + i q2 runs on an ellipse z0 cos x + z1 sin x, anticlockwise, clockwise
or to and fro through 0 as Im(conj(z0) z1) is positive, negative or 0.  With the vertical g,

    2 Im(conj(al0) al1) = n.g + n3,    2 Im(conj(bt0) bt1) = n.g - n3,

and al1, bt1 are those of the half turn about n, which takes g to 2(n.g) n - g.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flint import acb, arb

from polhode.closed_forms.balls.angles import Arguments
from polhode.closed_forms.balls.core import TooFewBits, nearest_integer
from polhode.closed_forms.balls.frames import Start, Turn
from polhode.numbers.exact import sign
from polhode.numbers.vectors import Vector, dot, minus, quaternion_product, scaled


class OneAxis:
    """What is decided exactly of the turns about ``n``, of any length, from the vertical ``g``."""

    def __init__(self, n: Vector, g: Vector) -> None:
        along = dot(n, g)
        self._senses = sign(along + n[2]), sign(along - n[2])
        self._begins = _present(g)
        self._crosses = _present(minus(scaled(2 * along, n), scaled(dot(n, n), g)))

    def arguments(self, start: Turn, n: tuple[arb, arb, arb], x: arb) -> Arguments:
        """The growth of arg al and arg bt over a turn by 2x from ``start``, ``n`` a unit vector.

        Through 0 an argument grows by pi wherever the turn leads away from the start, and falls by
        it where the turn comes back.
        """
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


@dataclass(frozen=True)
class PermanentRotation:
    """w constant, whatever the vertical: the body turns uniformly about it (Rodrigues' formula)."""

    omega: Sequence[arb]  # in the scene's axes, as what follows
    half: arb  # |w|/2, the exact 0 at rest
    start: Start

    @property
    def speed(self) -> arb:
        """|w|, or 1 at rest."""
        return arb(1) if self.half.is_zero() else 2 * self.half

    @property
    def axis(self) -> tuple[arb, arb, arb]:
        """w/|w|, or w = 0."""
        x, y, z = (w / self.speed for w in self.omega)
        return x, y, z

    def swung(self, t: arb) -> arb:
        """Half the angle turned since t = 0."""
        return self.half * t

    def row(self, t: arb, attitude: bool) -> Sequence[arb]:
        """The row at a time."""
        del attitude
        sin, cos = self.swung(t).sin_cos()
        x, y, z = self.axis
        return self.start.row(self.omega, (cos, sin * x, sin * y, sin * z))


class Permanent:
    """A state that stays: rest, or a rotation about an axis that is vertical."""

    def __init__(self, state: Sequence[arb]) -> None:
        self._state = state
        p, q, r = state[:3]
        self._still = all(x.is_zero() for x in state[:3])
        #: |w|, 1 at rest.
        self.speed = arb(1) if self._still else (p * p + q * q + r * r).sqrt()
        self.period = None

    def at(self, t: arb) -> Sequence[arb]:
        """The same at all times."""
        del t
        return self._state

    def turn(self, t: arb, state: Sequence[arb]) -> Turn:
        """The turn about w by |w| t."""
        if self._still:
            return arb(1), arb(0), arb(0), arb(0)
        sin, cos = (self.speed * t / 2).sin_cos()
        x, y, z = (sin * w / self.speed for w in state[:3])
        return cos, x, y, z


def _present(g: Vector) -> tuple[bool, bool]:
    """Whether al, and bt, of a vertical is not 0; a vertical without length has neither."""
    tilted = sign(g[0]) != 0 or sign(g[1]) != 0
    side: int = sign(g[2])
    return tilted or side > 0, tilted or side < 0


def _grown(one: acb | None, other: acb | None, sense: int, x: arb) -> arb | None:
    """The growth of the argument of one cos x + other sin x from 0; None where it is always 0."""
    if one is None and other is None:
        return None
    if sense and one is not None:
        n = nearest_integer(x / arb.pi())
        rest = x - n * arb.pi()
        z = one if other is None else one * rest.cos() + other * rest.sin()
        return sense * n * arb.pi() + (z / one).arg()
    if one is None:
        return _whole(abs(x) / arb.pi()) * arb.pi()
    beta = arb(0) if other is None else (other / one).real.atan()
    return abs(_whole((x - beta) / arb.pi() + arb(1) / 2)) * arb.pi()


def _whole(x: arb) -> int:
    """The integer part, rounded down."""
    n = x.floor().unique_fmpz()
    if n is None:
        raise TooFewBits
    return int(n)

"""The body, the level and three orbits that tests prove, and their proofs."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import cache

import polhode
from polhode import ProvedOrbit

#: The body and the level of the examples; the orbits as a search in double found them.
MOMENTS = [Fraction(2), Fraction(3, 2), Fraction(1)]
TORQUE = [Fraction(3, 10), Fraction(1, 5), Fraction(1, 2)]
H, F = Fraction(261, 200), Fraction(31, 25)
BODY = polhode.top(
    moments=MOMENTS, centre=TORQUE, weight=1, omega=["3/10", "1/5", 1], gamma=["3/5", 0, "4/5"]
)
ELLIPTIC = (
    *(0.24648456378902078, 0.3484822174895774, -1.880218379593652),
    *(-0.4532503649457642, -0.26342557792225096, -0.8515697690576267),
    3.221902062960887,
)
HYPERBOLIC = (
    *(0.39248732502901934, -1.4931034249442232, -0.3812431760503589),
    *(-0.304878314545795, -0.5252810140625632, -0.7944363219195862),
    4.265751022846151,
)
INVERSE = (
    *(-0.2570580570985149, -0.22188153703552527, 1.623437027381608),
    *(-0.7715547273133809, -0.4761773622001807, 0.4218511852400707),
    5.625116696318105,
)


def near(point: Sequence[float], rate: int = 1) -> polhode.Scene:
    """A scene that ends after about one period; of the same motion, so many times as fast."""
    p, q, r, *gamma, period = map(Fraction, point)
    return polhode.top(
        moments=MOMENTS,
        centre=TORQUE,
        weight=rate**2,
        omega=[rate * x for x in (p, q, r)],
        gamma=gamma,
        normalise=True,
        end=period / rate,
    )


@cache
def proved(point: tuple[float, ...], digits: int = 30) -> ProvedOrbit:
    """The proof of an orbit of the level."""
    scene = near(point)
    return polhode.prove_orbit(scene, scene, digits=digits, h=H, f=F)

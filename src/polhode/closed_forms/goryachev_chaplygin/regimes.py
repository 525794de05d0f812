"""The kinds of motion of Goryachev and Chaplygin's case, decided by exact arithmetic.

u oscillates between the roots of the two cubics u^3 - (H -+ 2a)u - 4G, v between those of
v^3 - (H +- 2a)v + 4G; two roots of the latter meet where D+- = (H +- 2a)^3 - 108 G^2 = 0.
"""

from __future__ import annotations

from polhode.closed_forms.goryachev_chaplygin.axes import GoryachevStart
from polhode.numbers.exact import Exact, sign, sqrt

GENERIC_WHOLE = "two frequencies, v between the roots of one cubic"
GENERIC_LOW = "two frequencies, v between the smaller roots of two cubics"
GENERIC_HIGH = "two frequencies, v between the larger roots of two cubics"
CONSTANT_ZERO = "v constant, eta = 0"
CONSTANT_PI = "v constant, eta = pi"
ASYMPTOTIC_LOW = "v asymptotic from below"
ASYMPTOTIC_HIGH = "v asymptotic from above"
LIBRATING = "G = 0, |H| < 2a"
ROTATING = "G = 0, H > 2a"
SEPARATRIX = "G = 0, H = 2a: tends to rest upright"

TWO_FREQUENCIES = (GENERIC_WHOLE, GENERIC_LOW, GENERIC_HIGH)
ASYMPTOTIC = (ASYMPTOTIC_LOW, ASYMPTOTIC_HIGH)
EXPLICIT = (LIBRATING, ROTATING, SEPARATRIX)


def discriminants(start: GoryachevStart) -> tuple[Exact, Exact]:
    """D+ and D-."""
    a, H, G = start.a, start.H, start.G
    above, below = H + 2 * a, H - 2 * a
    return above * above * above - 108 * G * G, below * below * below - 108 * G * G


def smaller(start: GoryachevStart) -> Exact:
    """v = (S - r)/2 at the start, S^2 = r^2 + 16(p^2 + q^2)."""
    p, q, r = start.omega
    flat = 16 * (p * p + q * q)
    root = sqrt(r * r + flat)
    if sign(r) <= 0:
        return (root - r) / 2
    return flat / (2 * (root + r))


def regime(start: GoryachevStart) -> str:
    """The kind of motion, by its name."""
    a, H, G = start.a, start.H, start.G
    if sign(G) == 0:
        return {-1: LIBRATING, 0: SEPARATRIX, 1: ROTATING}[sign(H - 2 * a)]
    plus, minus = discriminants(start)
    if sign(plus) == 0:
        return CONSTANT_ZERO
    if sign(H - 2 * a) <= 0 or sign(minus) < 0:
        return GENERIC_WHOLE
    middle = (H - 2 * a) / 3  # the square of the point where N is least
    side = sign(smaller(start) - sqrt(middle))
    if sign(minus) > 0:
        return GENERIC_LOW if side < 0 else GENERIC_HIGH
    return {-1: ASYMPTOTIC_LOW, 0: CONSTANT_PI, 1: ASYMPTOTIC_HIGH}[side]

"""Ensembles: random bodies of each kind with random starts, found again by their names.

All numbers are decimals of two places, which no double holds as a rule, so that rounding the inputs
is part of every error.  A scene is named by its kind and number, ``euler start 3``, or where its
body is that of another start, ``euler body 1 start 3``.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from fractions import Fraction

import polhode
from polhode.numbers.exact import Exact

SEED = 20


def hundredths(dice: random.Random, least: float, most: float) -> Fraction:
    """A random decimal of two places, not a double's as a rule."""
    return Fraction(dice.randint(round(100 * least), round(100 * most)), 100)


def free(dice: random.Random) -> polhode.Body:
    """A free body of any moments, in any order."""
    moments = _moments(dice)
    dice.shuffle(moments)
    return polhode.Body.of_moments(moments)


def symmetric(dice: random.Random) -> polhode.Body:
    """A symmetric top, disc or needle, its centre on the axis."""
    a = hundredths(dice, 0.7, 2)
    c = hundredths(dice, 0.2, 1.8 * float(a))
    return polhode.Body.of_moments((a, a, c), (0, 0, hundredths(dice, 0.3, 1.5)), 1)


def kovalevskayas(dice: random.Random) -> polhode.Body:
    """A = B = 2C, the centre anywhere in the equator."""
    c = hundredths(dice, 0.5, 1.5)
    x, y = hundredths(dice, -1.2, 1.2), hundredths(dice, 0.2, 1.2)
    return polhode.Body.of_moments((2 * c, 2 * c, c), (x, y, 0), 1)


def asymmetric(dice: random.Random) -> polhode.Body:
    """Any moments, C the largest, the centre anywhere near."""
    moments = sorted(_moments(dice))
    return polhode.Body.of_moments(moments, [hundredths(dice, 0.1, 0.5) for _ in range(3)], 1)


#: The kinds of body that have closed forms in every motion.
TOPS = {"euler": free, "lagrange": symmetric, "kovalevskaya": kovalevskayas}
KINDS = {**TOPS, "asymmetric": asymmetric}
#: With two that are asymmetric bodies started otherwise.
STARTED = {**KINDS, "chaotic": asymmetric, "fast": asymmetric}
#: Of the kind "chaotic", whose bodies start without much spin: those that ``polhode.lyapunov`` to
#: t = 3000 calls so.
CHAOTIC = (0, 1, 3, 4, 7, 8, 9, 13)


def random_scene(kind: str, index: int, times: Sequence[Exact] = ()) -> polhode.Scene:
    """The exact scene: any body of the kind, |components| of w at most 1, any gamma.

    An asymmetric body spins with 2.5 to 3.5 about z, where its motion is regular as a rule, a fast
    one with 20 to 40.
    """
    dice = random.Random(f"{SEED} {kind} {index}")
    body = STARTED[kind](dice)
    p, q, r = (Fraction(dice.randint(-100, 100), 100) for _ in range(3))
    if kind == "asymmetric":
        r = 3 + r / 2
    elif kind == "fast":
        r = 30 + 10 * r
    u, v = (Fraction(dice.randint(-20, 20), 10) for _ in range(2))
    square = u * u + v * v
    gamma = (2 * u / (1 + square), 2 * v / (1 + square), (1 - square) / (1 + square))
    return polhode.Scene(
        body, (p, q, r), gamma, times=tuple(times), name=f"{kind} start {index + 1}"
    )


def _moments(dice: random.Random) -> list[Fraction]:
    """Three moments of a body."""
    a, b = hundredths(dice, 1, 3), hundredths(dice, 1, 3)
    return [a, b, hundredths(dice, float(abs(a - b)) + 0.1, float(a + b) - 0.1)]

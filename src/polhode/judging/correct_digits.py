"""Correct digits of rows of states against reference rows: the definition, and nothing else.

Correct digits = -log10 of the larger of (max-norm error of w over the largest |w| that the
reference reaches at the output times; if that is 0, over sqrt(Mg|r0|/largest moment), else over 1)
and (max-norm error of gamma).
"""

from __future__ import annotations

import math

from polhode.numbers import exact
from polhode.numbers.conversion import exactly, to_mpf
from polhode.numbers.exact import sign
from polhode.numbers.rows import Given
from polhode.numbers.scalars import Scalar
from polhode.scenes.scene import Scene


def rate_scale(rows: Given, scene: Scene, bits: int) -> Scalar:
    """What errors of w are relative to: the largest |w| of the reference, as mpf."""
    from polhode.numbers.mpmath_context import mpmath

    with mpmath.workprec(bits):
        largest = max((mpmath.hypot(mpmath.hypot(r[0], r[1]), r[2]) for r in rows), default=0)
        if largest > 0:
            return largest
        fallback = scene.pendulum_rate_squared
        return to_mpf(exact.sqrt(fallback), bits) if sign(fallback) else mpmath.mpf(1)


def errors(states: Given, reference: Given, scale: Scalar, bits: int) -> list[Scalar]:
    """For each time the larger of the scaled errors of w and of gamma, as mpf.

    ``states``: rows as long as those of ``reference``; an entry None is not judged.
    """
    from polhode.numbers.mpmath_context import mpmath

    with mpmath.workprec(bits):
        found = []
        for row, true in zip(states, reference, strict=True):
            worst = mpmath.mpf(0)
            for column, (x, y) in enumerate(zip(row, true, strict=True)):
                if x is None:
                    continue
                error = abs(to_mpf(exactly(x), bits) - y)
                worst = max(worst, error / scale if column < 3 else error)
            found.append(worst)
        return found


def digits_of(error: Scalar, cap: float) -> float:
    """-log10 of an error, never more than ``cap`` and never less than 0."""
    from polhode.numbers.mpmath_context import mpmath

    if not mpmath.isfinite(error):
        return 0.0
    if error == 0:
        return cap
    with mpmath.workprec(53):
        return min(cap, max(0.0, -float(mpmath.log10(error))))


def worst_digits(states: Given, reference: Given, scene: Scene, cap: float) -> float:
    """The fewest correct digits over all rows."""
    bits = math.ceil(cap * math.log2(10)) + 64
    scale = rate_scale(reference, scene, bits)
    return min((digits_of(e, cap) for e in errors(states, reference, scale, bits)), default=cap)

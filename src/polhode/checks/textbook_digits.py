"""Closed forms beside mpmath's: a second witness of the classical tops."""

from __future__ import annotations

import math
from fractions import Fraction

from polhode.common.errors import BadInput
from polhode.judging.certified import Certified
from polhode.judging.correct_digits import worst_digits
from polhode.judging.reference import Reference
from polhode.judging.textbook import FAMILIES, Textbook
from polhode.numbers.exact import Exact
from polhode.scenes.scene import Scene

WANTED = 30  # digits
_MOST_LOG10_ANGLE = 2  # radians turned up to the time of the comparison


def textbook_digits(ours: Reference | Certified) -> float | None:
    """The digits to which a reference and mpmath's closed form agree at one time, at most WANTED.

    At the end of a short run, at a time on the way of a long one.  None of another family, and of
    motions that the textbook's formulas do not have.
    """
    if not isinstance(ours, Reference) or ours.kind not in FAMILIES:
        return None
    scene = ours.scene
    t = time_of(scene)
    try:
        rows = Textbook(scene).at([t], digits=WANTED)
    except BadInput:
        return None
    return min(
        float(WANTED), worst_digits(rows, ours.at([t], digits=WANTED + 5), scene, WANTED + 5)
    )


def time_of(scene: Scene) -> Exact:
    """The end of a run that turns by at most 100 radians; of a longer one, a time on its way."""
    excess = scene.log10_angle - _MOST_LOG10_ANGLE
    return scene.end if excess <= 0 else scene.end / Fraction(2) ** math.ceil(4 * excess)

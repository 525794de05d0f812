"""How far psi advances while omega and gamma come round: whether the motion in space closes.

After a period gamma is what it was, so the attitude has turned about the vertical alone:
R(T) = Rz(D) R(0).  The attitude tells D up to whole turns at any motion; psi itself tells those,
too, where the third axis does not pass through the vertical.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from polhode.numbers.conversion import exactly, to_mpf
from polhode.numbers.exact import ZERO
from polhode.numbers.mpmath_context import mpmath, ordinary
from polhode.numbers.number_types import NumberType
from polhode.numbers.scalars import Real
from polhode.runs.options import Options
from polhode.runs.solve import solve
from polhode.scenes.scene import Scene


class Advance(NamedTuple):
    """psi's advance as an mpf, None where it cannot be had; ``whole``: with its whole turns."""

    psi: Real | None
    whole: bool


def advance(scene: Scene, number: NumberType) -> Advance:
    """Of a scene that ends after one period, by one run from 0 to there."""
    period = replace(scene, outputs=("angles", "attitude"), events=(), times=(ZERO, scene.end))
    options = Options(project=False)
    run = solve(period, number, options, interruptible=False)
    if run.outcome.done and run.angles is not None:
        try:
            first, last = (exactly(row[0]) for row in run.angles)
            return Advance(ordinary(to_mpf(last - first, number.bits)), True)
        except ValueError:  # no number: the third axis is vertical
            pass
    alone = replace(period, outputs=("attitude",))
    run = solve(alone, number, options, interruptible=False)
    if not run.outcome.done or run.attitude is None:
        return Advance(None, False)
    with mpmath.workprec(number.bits):
        (a, b, c, d), (p, q, r, s) = (
            [to_mpf(exactly(x), number.bits) for x in row] for row in run.attitude
        )
        along, across = a * p + b * q + c * r + d * s, a * s - d * p + c * q - b * r
        return Advance(ordinary(2 * mpmath.atan2(across, along)), False)

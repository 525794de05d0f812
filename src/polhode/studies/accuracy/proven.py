"""Part of the study ``accuracy``: every closed form against a proven enclosure of the motion."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from typing import Any

from polhode.closed_forms.families import closed_form
from polhode.enclosures import approximation, fixed_point_problem
from polhode.enclosures.certify import certify
from polhode.judging.reference import reference as reference_of
from polhode.numbers.conversion import exactly
from polhode.numbers.exact import Exact
from polhode.scenes.scene import Scene

STEPS = 60  # of a proof: how far each closed form is followed
DIGITS = 16


def provable(scene: Scene) -> Scene | None:
    """The scene as it is enclosed, the state alone; None where it has no closed form or times."""
    alone = replace(scene, reference="auto", outputs=())
    return alone if scene.times and closed_form(alone) is not None else None


def proven_times(scene: Scene) -> list[Exact]:
    """Three times, the last at most so many steps away."""
    away = approximation.steps(fixed_point_problem.motion(scene), scene.end)
    last = scene.end * min(Fraction(1), Fraction(STEPS) / Fraction(math.ceil(away) + 1))
    return [last * Fraction(k, 3) for k in (1, 2, 3)]


def proven_case(scene: Scene) -> dict[str, Any]:
    """A closed form against its enclosure: |closed form - midpoint| over the radius, the worst."""
    times = proven_times(scene)
    found = certify(scene, times, digits=DIGITS)
    exact = reference_of(scene)
    true = exact.at(times, 2 * DIGITS + 20)
    ratios = [
        float(abs(exactly(x) - middle) / Fraction(radius))
        for row, middles, radii in zip(true, found.centres, found.radii, strict=True)
        for x, middle, radius in zip(row, middles, radii, strict=True)
    ]
    return {
        "case": scene.name,
        "reference": exact.kind,
        "end": float(f"{float(times[-1]):.4g}"),
        "ratio": float(f"{max(ratios):.2g}"),
        "inside": max(ratios) <= 1.0,
        "digits": round(found.proven, 2),
        "tries": found.tries,
    }

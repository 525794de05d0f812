"""What a motion does to a small error, told roughly before the proof: the choice of precision.

Not trusted, and nothing depends on it but cost: one run in double with one tangent vector.
"""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np

from polhode.conditioning import six
from polhode.enclosures.fixed import LEAST_NOISE, Motion
from polhode.exact import Exact
from polhode.precision import to_double
from polhode.run import system
from polhode.variations import Variations

BITS_A_DIGIT = math.log2(10)
_LOOKS = 256
_STEPS_A_UNIT = 3.0  # of the proof, in its unit of time
_LOST_A_STEP = 12.0  # log2 of what the bounds of one step claim too much
_MOST_STEPS = 3_000_000


def noise(what: Motion, last: Exact, digits: float) -> int:
    """The noise level P at which the radii at the time ``last`` should leave so many digits."""
    bits = digits * BITS_A_DIGIT + _LOST_A_STEP + max(0.0, growth(what, last))
    return max(LEAST_NOISE, math.ceil(bits))


def growth(what: Motion, last: Exact) -> float:
    """log2 of the sum over the steps of what an error made there is at the end."""
    duration = abs(to_double(last / Fraction(2) ** what.unit))
    steps = max(1.0, _STEPS_A_UNIT * duration)
    logs = _tangents(what, to_double(last))
    if len(logs) < 2:
        return 2.0 * math.log2(1.0 + steps)
    ahead = max(logs)  # an error is no smaller later than where the tangent is short by chance
    exponents = np.maximum(ahead - np.array(logs), 0.0)
    largest = float(np.max(exponents))
    mean = float(np.mean(np.exp2(exponents - largest)))
    return largest + math.log2(mean) + math.log2(steps)


def _tangents(what: Motion, last: float) -> list[float]:
    """log2 of a tangent's length along the motion, at even times; short where double fails."""
    scene = what.scene
    plain = system(replace(scene, form="principal", events=(), outputs=()), ())
    start = six(plain.start)
    tangent = np.linspace(0.6, 1.4, 6)[:, None]
    if scene.gamma is None:
        tangent[3:] = 0.0
    flow = Variations(plain.coefficients, start, tangent)
    end = last / 2.0**scene.time_unit
    logs = [math.log2(float(np.max(np.abs(tangent))))]
    for k in range(1, _LOOKS + 1):
        if not (flow.to(end * k / _LOOKS, _MOST_STEPS - flow.steps) and flow.finite):
            break
        flow.rescale()
        logs.append(flow.exponent + math.log2(float(np.max(np.abs(flow.tangents)))))
    return logs

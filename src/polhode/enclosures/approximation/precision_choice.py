"""What a motion does to a small error, told roughly before the proof: the choice of precision.

Not trusted, and nothing depends on it but cost: one run in double with one tangent vector.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from polhode.common.interrupts import NONE, Deadline
from polhode.enclosures.approximation import window_approximation
from polhode.enclosures.fixed_point_problem import Motion, Refused
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Exact

BITS_A_DIGIT = math.log2(10)
_STEPS_A_UNIT = 3.0  # of the proof, in its unit of time
_OF_DOUBLES_STEPS = 0.55  # so many the proof takes, of those of a run in double with a tangent
_OF_ALL_STEPS = 0.1  # of those of a unit of time, at least: where a run in double takes hardly any
_SECONDS_A_STEP = 4e-4, 2.6e-8, 5.9e-13  # and over the noise level's square and fourth power
_MARGIN = 1.0  # bits
_FAR = 0.1  # of the way: from there on the growth tells of the rest
_AHEAD, _SURE = 1.25, 8  # times the growth that is left, and bits: less than a try more
_OF_OUTPUTS = {"attitude": 6.0, "angles": 9.0}  # the same of a turn, and of angles near a pole


class Forecast(NamedTuple):
    """What a proof needs, roughly.

    ``bits``: those of the digits, ``grown``: those that the motion takes; their sum is the noise
    level P to try.  ``steps``: of the proof.
    """

    bits: float
    grown: float
    steps: float

    def seconds(self, noise: int, outputs: bool) -> float:
        """About how long the proof takes at a noise level; longer with angles or attitude."""
        constant, square, fourth = _SECONDS_A_STEP
        step = constant + (square + fourth * noise * noise) * noise * noise
        return (2.0 if outputs else 1.0) * step * self.steps


def forecast(what: Motion, last: Exact, digits: float, deadline: Deadline = NONE) -> Forecast:
    """What the digits need at the time ``last``; at the deadline from what is known then."""
    grown, fastest, taken = growth(what, last, deadline)
    slow = max(0.0, -math.log2(fastest)) if fastest > 0.0 else 0.0  # digits of w are relative
    bits = digits * BITS_A_DIGIT + _MARGIN + slow
    more = max((_OF_OUTPUTS.get(name, 0.0) for name in what.scene.modelled), default=0.0)
    if more:  # they add up what the state is off on the way
        bits += more + math.log2(1.0 + steps(what, last))
    return Forecast(bits, max(0.0, grown), taken)


def raised(noise: int, bits: float, why: Refused) -> int:
    """The noise level to try after a refusal, by what the radius had grown to on the way.

    ``bits``: those that the digits need.  The growth is taken to go on as it went: that of a
    chaotic motion does, while a run in double follows another orbit by then.  Where the proof came
    not far nothing is known of it.
    """
    if why.reached < _FAR:
        return math.ceil(1.25 * noise) + 20
    ahead = why.grown * (1.0 / why.reached - 1.0)
    return max(noise + 20, math.ceil(bits + why.grown + _AHEAD * ahead) + _SURE)


def steps(what: Motion, last: Exact) -> float:
    """About how many steps lead to a time; infinite beyond the range of double."""
    return _STEPS_A_UNIT * abs(to_double(last / Fraction(2) ** what.unit))


def growth(what: Motion, last: Exact, deadline: Deadline = NONE) -> tuple[float, float, float]:
    """log2 of the sum over the steps of what an error made there is at the end; |w|; the steps.

    |w| at its largest, in the proof's unit of time.
    """
    count = max(1.0, steps(what, last))
    logs, fastest, taken = window_approximation.tangents(what, to_double(last), deadline)
    if len(logs) < 2:
        return 2.0 * math.log2(1.0 + count), fastest, count
    ahead = max(logs)  # an error is no smaller later than where the tangent is short by chance
    exponents = np.maximum(ahead - np.array(logs), 0.0)
    largest = float(np.max(exponents))
    mean = float(np.mean(np.exp2(exponents - largest)))
    return (
        largest + math.log2(mean) + math.log2(count),
        fastest,
        min(count, max(_OF_ALL_STEPS * count, _OF_DOUBLES_STEPS * taken)),
    )

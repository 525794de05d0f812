"""A periodic orbit of every body within a tolerance: the theorem of one orbit, of all of them.

Not trusted, but for what ``periodic_orbit.prove`` gives.  The box is to hold the orbits of all
bodies, on the one level, and Krawczyk's test fails for a box that is too small as for one that is
too large: it grows until the test passes, or the enclosure cannot follow it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

from polhode.enclosures.fixed_point_problem import LEAST_NOISE, Refused
from polhode.numbers.conversion import to_double
from polhode.numbers.decimals import brief
from polhode.proofs.level import Level
from polhode.proofs.orbit_candidate import Found, candidate_of_bits, centre
from polhode.proofs.periodic_orbit import Follow, prove
from polhode.proofs.refusals import NotContracted, Unproved

_FINER = 12  # bits by which the proof's noise lies below the tolerance
_WIDEST, _TRIES = 20, 16  # of boxes: bits above the tolerance, and how many are tried
_NARROWEST = 16  # decimals of the last tolerance that is looked at


def of_bodies(
    level: Level, found: Found, tolerance: Fraction, follow: Follow
) -> tuple[Level, Found]:
    """The theorem of all bodies; raises Unproved, with the widest tolerance that works."""
    try:
        return _of_bodies(level, found, tolerance, follow)
    except Refused as why:
        cause = str(why)
    for narrower in _below(tolerance):
        try:
            _of_bodies(level, found, narrower, follow)
        except Refused:
            continue
        known = f"the largest power of 10 that works is {brief(narrower)}"
        break
    else:
        known = f"none down to 1e-{_NARROWEST} works"
    raise Unproved(f"no proof for all bodies within {brief(tolerance)} ({cause}): {known}")


def _of_bodies(
    level: Level, found: Found, tolerance: Fraction, follow: Follow
) -> tuple[Level, Found]:
    """The theorem in the first box that is large enough; raises Refused."""
    wide = replace(level, motion=replace(level.motion, tolerance=tolerance))
    bits = math.floor(-math.log2(to_double(tolerance)))
    noise = max(LEAST_NOISE, bits + _FINER)
    point = centre(found.theorem)
    last: Refused = Unproved("no box is large enough")
    for more in range(_WIDEST - _TRIES, _WIDEST):
        made = candidate_of_bits(wide, point, noise, bits - more, found.candidate.parts)
        try:
            theorem = prove(wide, made, follow)
        except NotContracted as why:  # the box does not hold the orbits of all
            last = why
            continue
        # a box about a centre that is off by its own size tells of no neighbourhood
        if theorem.near > 0 and not theorem.open:
            return wide, Found(theorem, made, found.runs + 1)
    raise last


def _below(tolerance: Fraction) -> Iterator[Fraction]:
    """Powers of 10 below a tolerance, downwards."""
    powers = (Fraction(1, 10**k) for k in range(1, _NARROWEST + 1))
    return (narrower for narrower in powers if narrower < tolerance)

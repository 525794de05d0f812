"""A chain of sets along one homoclinic orbit of the example, for tests of chaos."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from polhode import ProvedOrbit
from polhode.certificates import chaos_certificate, verify
from polhode.certificates.chaos_certificate import Chain
from polhode.enclosures.fixed_point_problem import motion
from polhode.proofs.chaos import chain, homoclinic
from polhode.proofs.chaos.homoclinic import Homoclinic
from polhode.proofs.chaos.lanes import Lanes
from polhode.proofs.chaos.proved_chaos import Guess
from shared import orbit_proofs as proofs

#: As the search finds it.
NEAR = Homoclinic(0.000179164892, -0.000465148702, 23.4075408124, 24.4302533376, 0.17)


class Example(NamedTuple):
    """A proof and what it began with, in principal axes, which are the scene's."""

    orbit: ProvedOrbit
    guess: Guess
    chain: Chain
    made: dict[str, Any]
    proof: verify.Horseshoe


@cache
def guess() -> tuple[ProvedOrbit, Guess]:
    """The chain at h = 261/200, f = 31/25, time in the scene's unit."""
    orbit = proofs.proved(proofs.HYPERBOLIC)
    lanes = Lanes.of(motion(proofs.BODY, unit=0))
    at = homoclinic.saddle(lanes, np.array(start_of(orbit)), float(orbit.period))
    moved, size = homoclinic.towards(at, NEAR, 1e-6)
    found = homoclinic.corrected(lanes, at, moved)
    return orbit, Guess(lanes, at, *chain.along(lanes, at, found, size))


@cache
def example() -> Example:
    """The proof of it."""
    orbit, begun = guess()
    what = Chain(proofs.BODY.body, proofs.H, proofs.F, begun.charts, begun.sets, begun.times)
    made = chaos_certificate.guesses(what)
    return Example(orbit, begun, what, made, chaos_certificate.proved(made))


def start_of(orbit: ProvedOrbit) -> Sequence[float]:
    """A point of a proved orbit."""
    return [float(x) for x in (*orbit.omega, *orbit.gamma)]

"""A chain of sets along one homoclinic orbit of the example, for tests of chaos."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from flint import arb

from polhode.numbers.flint_context import ctx
from polhode.proofs.chaos import chain_candidate, homoclinic, theorem
from polhode.proofs.chaos.h_set import Chart
from polhode.proofs.chaos.homoclinic import Homoclinic, Saddle
from polhode.proofs.chaos.lanes import Lanes
from polhode.proofs.chaos.prove_chaos import OrbitBalls, balls_on
from polhode.proofs.chaos.theorem import Chain, Horseshoe
from shared import orbit_proofs as proofs

#: As the search finds it.
NEAR = Homoclinic(0.000179164892, -0.000465148702, 23.4075408124, 24.4302533376, 0.17)
NOISE = chain_candidate.NOISE


class Example(NamedTuple):
    """What a proof is made of."""

    orbit: OrbitBalls
    lanes: Lanes
    saddle: Saddle
    size: float
    found: Homoclinic
    charts: list[Chart]
    ticks: list[int]
    chain: Chain
    proof: Horseshoe


@cache
def example() -> Example:
    """The proof at h = 261/200, f = 31/25."""
    level = proofs.level()
    orbit = balls_on(level, proofs.proved(proofs.HYPERBOLIC))
    lanes = Lanes.of(level.motion)
    point = np.array([float(x.mid()) for x in orbit.start])
    at = homoclinic.saddle(lanes, point, float(orbit.period.mid()))
    moved, size = homoclinic.towards(at, NEAR, 1e-6)
    found = homoclinic.corrected(lanes, at, moved)
    with ctx.workprec(NOISE + 128):
        unit = arb((1, chain_candidate.fine_of(NOISE)))
        centre = tuple(int((x.mid() * unit).floor().unique_fmpz()) for x in orbit.start)
    charts, ticks = chain_candidate.charts(lanes, level, at, found, centre)
    chain = made(charts, ticks, size, found.unstable)
    proof = theorem.horseshoe(chain)
    return Example(orbit, lanes, at, size, found, charts, ticks, chain, proof)


def made(charts: list[Chart], ticks: list[int], size: float, first: float) -> Chain:
    """A chain of charts, fitted to its images."""
    return chain_candidate.chain(proofs.level(), charts, ticks, size, first, 5.95)

"""A short elliptic orbit that tests prove to be stable, and its certificate."""

from __future__ import annotations

import json
from fractions import Fraction
from functools import cache
from typing import Any

import polhode
from polhode import ProvedOrbit, ProvedStability

NAME = "general/asymmetric-regular"
START = (
    *(0.12824297888944370, 0.16218517053029624, -3.3992382255227273),
    *(-0.42077601050440881, -0.27781263962028001, -0.86357841928293117),
)
PERIOD = 1.81463648378177924


def near(start: tuple[float, ...] = START, period: float = PERIOD) -> polhode.Scene:
    """A scene that ends after about one period."""
    scene = polhode.load(NAME)
    p, q, r, *gamma = map(Fraction, start)
    body: dict[str, Any] = {"moments": scene.body.moments, "centre": scene.body.centre}
    return polhode.top(
        **body,
        weight=scene.body.weight,
        omega=[p, q, r],
        gamma=gamma,
        normalise=True,
        end=Fraction(period),
    )


@cache
def orbit() -> ProvedOrbit:
    """The proved orbit."""
    return polhode.prove_orbit(NAME, near())


@cache
def stability() -> ProvedStability:
    """Its proved stability."""
    return polhode.prove_stability(orbit())


def certificate() -> dict[str, Any]:
    """The certificate, of which everyone may change a copy."""
    held: dict[str, Any] = json.loads(stability().certificate)
    return held

"""Other units of mass, length and time that are powers of two change no bit of a run."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest

import polhode
from polhode import Body
from polhode.numbers.vectors import scaled
from shared.tools import exactly


def in_units(scene, mass, length, time):
    """The same motion with mass, length and time multiplied by powers of two."""
    m, x, t = (Fraction(2) ** n for n in (mass, length, time))
    body = scene.body
    a, b, c = (scaled(m * x * x, row) for row in body.inertia)
    return replace(
        scene,
        body=Body((a, b, c), scaled(x, body.centre), body.weight * m * x / (t * t)),
        omega=scaled(1 / t, scene.omega),
        times=tuple(t * s for s in scene.times),
        outputs=(),
    )


def exact_states(scene, number, rate=1):
    states = polhode.integrate(scene, number=number, method="taylor").states
    return [[exactly(x) * (rate if k < 3 else 1) for k, x in enumerate(row)] for row in states]


@pytest.mark.parametrize("units", [(7, -3, 5), (-40, 33, -61)], ids=str)
@pytest.mark.parametrize(
    ("name", "number"),
    [("euler/irrational", "double"), ("hard/near-cusp", "extended"), ("hard/near-cusp", "quad")],
)
def test_powers_of_two_change_no_bit(name, number, units):
    scene = replace(polhode.load(name).at((Fraction(5),)), outputs=())
    scaled = in_units(scene, *units)
    assert exact_states(scaled, number, Fraction(2) ** units[2]) == exact_states(scene, number)

"""What a run must keep exactly, or nearly so: powers of two, rest, and the way back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

from polhode.equations.equilibrium import at_rest
from polhode.equations.readout import Readout
from polhode.equations.system import system
from polhode.judging.adaptive_precision import integrate
from polhode.judging.correct_digits import log10_errors, log10_rate
from polhode.numbers import exact
from polhode.numbers.conversion import exactly, number_value, to_double, to_mpf
from polhode.numbers.number_types import NumberType, bits_for
from polhode.numbers.rows import Given, Row, Rows
from polhode.scenes.body import Body, dot, scaled
from polhode.scenes.scene import Scene
from polhode.taylor.integrator.stepping import Integrator

#: Exponents of two by which mass, length and time are measured anew.
UNITS = ((7, -3, 5), (-40, 33, -61))


def in_units(scene: Scene, mass: int, length: int, time: int) -> Scene:
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


def changed_by_units(scene: Scene, number: NumberType) -> int:
    """How many numbers of a run's states change when the units change by powers of two."""
    plain = integrate(replace(scene, outputs=()), number, method="taylor").states
    changed = 0
    for mass, length, time in UNITS:
        other = integrate(in_units(scene, mass, length, time), number, method="taylor").states
        rate = Fraction(2) ** time
        for row, turned in zip(plain, other, strict=True):
            for k, (x, y) in enumerate(zip(row, turned, strict=True)):
                changed += exactly(x) != exactly(y) * (rate if k < 3 else 1)
    return changed


def departure(states: Given, scene: Scene, number: NumberType) -> float:
    """How far w strays from its start (with gamma where that rests too), in eps of the type."""
    columns = slice(None) if at_rest(scene).state else slice(0, 3)
    bits = bits_for(2 * number.most_digits)
    start = [to_mpf(x, bits) for x in scene.start[columns]]
    rate = log10_rate([start], scene)
    rounded = [number.rounded(x) for x in scene.start[columns]]
    found = log10_errors([row[columns] for row in states], [start] * len(states), rate)
    (least,) = 10 ** log10_errors([rounded], [start], rate)  # what rounding the start costs
    return float((max(10 ** max(found), least) - least) / to_double(number.eps))


def there_and_back(scene: Scene, number: NumberType) -> float:
    """The error of the state, in eps, of a run to the scene's end and back to 0.

    Relative as in *correct digits*, to |w| at 0; against the start as the type rounds it.
    """
    from polhode.taylor.integrator.prepared_system import PreparedSystem

    plain = replace(scene, outputs=(), events=())
    what = system(plain, ())
    integrator = Integrator(PreparedSystem(what, number))
    unit = Fraction(2) ** scene.time_unit
    row: Any = None
    for t in (number.rounded(number.rounded(scene.end) / unit), Fraction(0)):
        row = _led(integrator, t)
    rounded = [number.rounded(x) for x in what.start]
    read = Readout(plain, number)
    back = read.states([row])[0]
    bits = 2 * number.bits + 64
    start = [
        to_mpf(exactly(x), bits)
        for x in read.states([[number_value(x, number) for x in rounded]])[0]
    ]
    (error,) = 10 ** log10_errors([back], [start], log10_rate([start], scene))
    return float(error / to_double(number.eps))


def way_back(scene: Scene, t: Any, state: Sequence[Any]) -> Scene:
    """The motion from the scene's state at time t back to 0; ``state``: p q r [gamma], as mpf.

    gamma is brought to length 1.
    """
    state = [exactly(x) for x in state]
    gamma = None
    if scene.gamma is not None:
        x, y, z = state[3:]
        gamma = scaled(1 / exact.sqrt(dot((x, y, z), (x, y, z))), (x, y, z))
    p, q, r = state[:3]
    return replace(scene, omega=(p, q, r), gamma=gamma, times=(-t,), outputs=(), events=())


def _led(integrator: Integrator, t: Fraction) -> Row:
    """The row of an integrator led to a time."""
    rows: Rows = []
    while len(rows) == 0:
        rows, _ = integrator.chunk([t], 10**5)
    return rows[0]

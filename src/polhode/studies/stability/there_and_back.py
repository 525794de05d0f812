"""A run to a scene's end and back to its start, and the motion from its end back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

from polhode.equations.readout import Readout
from polhode.judging.correct_digits import log10_errors, log10_rate
from polhode.numbers import exact
from polhode.numbers.conversion import exactly, number_value, to_double, to_mpf
from polhode.numbers.number_types import NumberType, Row, Rows
from polhode.numbers.vectors import dot, scaled
from polhode.scenes.scene import Scene
from polhode.taylor.stepping import Integrator
from polhode.taylor.system import system


def error(scene: Scene, number: NumberType) -> float:
    """The error of the state, in eps, of a run to the scene's end and back to 0.

    Relative as in *correct digits*, to |w| at 0; against the start as the type rounds it.
    """
    plain = replace(scene, outputs=(), events=())
    what = system(plain, number=number)
    integrator = Integrator(what)
    unit = what.frame.unit
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
    (apart,) = 10 ** log10_errors([back], [start], log10_rate([start], scene))
    return float(apart / to_double(number.eps))


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

"""The exact system: coefficients, start, and the unit of time in which all of it is small."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from polhode.common.errors import BadInput
from polhode.equations.form import equations
from polhode.equations.forms.principal import NAMES
from polhode.numbers import exact
from polhode.numbers.exact import Exact
from polhode.scenes.scene import Scene

GYROSCOPIC = 3  # of the coefficients; the others are the weight's and scale like 1/time²

_ROOM = 1.1  # |w| times this is below 1 in the unit of time chosen
_LEAST = -64  # of units; the scene's own is near 1 but for bodies almost at rest


@dataclass(frozen=True)
class RationalSystem:
    """Rationals near the scene's numbers: coefficients k1 ... k9 (order of NAMES) and the state.

    ``state``: w1 w2 w3 g1 g2 g3, gamma zero where the scene leaves it out.  All of it is inside the
    scene's frame, and time runs forward: a motion backwards in time is the one with -w forwards.
    """

    coefficients: tuple[Fraction, ...]
    state: tuple[Fraction, ...]

    def coefficients_in(self, unit: int) -> list[Fraction]:
        """The coefficients with time in units of 2**-unit of the frame's."""
        scale = Fraction(4) ** -unit
        weight = [x * scale for x in self.coefficients[GYROSCOPIC:]]
        return [*self.coefficients[:GYROSCOPIC], *weight]

    def unit(self, fastest: float) -> int:
        """The least unit in which the coefficients and the fastest |w| are below 1."""
        largest = max(abs(float(x)) for x in self.coefficients[GYROSCOPIC:]) ** 0.5
        needed = max(largest, _ROOM * fastest)
        unit = _LEAST
        while unit < 1000 and 2.0**unit <= needed:
            unit += 1
        return unit if needed else 0


def with_rates(state: Sequence[Fraction], exponent: int) -> tuple[Fraction, ...]:
    """A state whose rates are multiplied by 2**exponent: time in a unit that is as long."""
    scale = Fraction(2) ** exponent
    return (*(x * scale for x in state[:3]), *state[3:])


def rational_system(scene: Scene, bits: int, backward: bool) -> RationalSystem:
    """The system of a scene in the principal form, irrational numbers to so many bits.

    Raises BadInput for another form.
    """
    if scene.form != "principal":
        raise BadInput(scene.name, "form", scene.form, "principal: no other form can be refined")
    form = equations(scene)
    numbers = [rational(form.coefficients.get(name, exact.ZERO), bits) for name in NAMES]
    state = [rational(x, bits) for x in form.start]
    state += [Fraction(0)] * (6 - len(state))
    if backward:
        state[:3] = [-x for x in state[:3]]
    return RationalSystem(tuple(numbers), tuple(state))


def rational(x: Exact, bits: int) -> Fraction:
    """A rational as it is; an irrational to an error below 2**-bits of itself."""
    return x if isinstance(x, Fraction) else exact.binary(*exact.rounded(x, bits))

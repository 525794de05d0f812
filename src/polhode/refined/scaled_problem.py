"""The exact system: coefficients, start, and the unit of time in which all of it is small."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from polhode.common.errors import BadInput
from polhode.equations.form import equations
from polhode.equations.terms import COEFFICIENTS, NAMES
from polhode.numbers import exact
from polhode.numbers.exact import Exact
from polhode.scenes.scene import Scene

_ROOM = 1.1  # |w| times this is below 1 in the unit of time chosen
_LEAST = -64  # of units; the scene's own is near 1 but for bodies almost at rest


@dataclass(frozen=True)
class RationalSystem:
    """Rationals near the scene's numbers: coefficients (order of NAMES) and the state.

    ``state``: w1 w2 w3 g1 g2 g3, gamma zero where the scene leaves it out.  All of it is inside the
    scene's frame, and time runs forward: a motion backwards in time is the one with -w forwards.
    """

    coefficients: tuple[Fraction, ...]
    state: tuple[Fraction, ...]

    def coefficients_in(self, unit: int) -> list[Fraction]:
        """The coefficients with time in units of 2**-unit of the frame's."""
        pairs = zip(COEFFICIENTS, self.coefficients, strict=True)
        return [x * Fraction(2) ** (-unit * kind.power) for kind, x in pairs]

    def rate(self, unit: int = 0) -> float:
        """The largest rate that the coefficients make by themselves, in units of 2**-unit."""
        pairs = zip(COEFFICIENTS, map(float, self.coefficients_in(unit)), strict=True)
        return float(max(abs(x) ** (1 / kind.power) for kind, x in pairs if kind.power))

    def unit(self, fastest: float) -> int:
        """The least unit in which the coefficients and the fastest |w| are below 1."""
        needed = max(self.rate(), _ROOM * fastest)
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
    if backward:  # time and w change sign, and coefficients with an odd power of time
        state[:3] = [-x for x in state[:3]]
        pairs = zip(COEFFICIENTS, numbers, strict=True)
        numbers = [-x if kind.power % 2 else x for kind, x in pairs]
    return RationalSystem(tuple(numbers), tuple(state))


def rational(x: Exact, bits: int) -> Fraction:
    """A rational as it is; an irrational to an error below 2**-bits of itself."""
    return x if isinstance(x, Fraction) else exact.binary(*exact.rounded(x, bits))

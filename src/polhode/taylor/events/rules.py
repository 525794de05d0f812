"""What the events of a scene are looked for by: made once for a scene."""

from __future__ import annotations

from fractions import Fraction

from polhode.numbers import exact
from polhode.numbers.conversion import exactly
from polhode.numbers.exact import ZERO
from polhode.numbers.number_types import NumberType
from polhode.scenes.scene import Scene
from polhode.taylor.events.magnitudes import sign_at_start, size_of
from polhode.taylor.events.roundoff import BAND


class Rules:
    """What a run's watch goes by: made once for a scene, number type and tolerance.  Immutable.

    ``start``: the exact signs of the expressions at t = 0.  ``asked``: whether heyoka asks after
    each step.  ``damping``: powers of two by which heyoka sees the expressions smaller.  ``band``:
    a rounding error of 1, times BAND.  ``still``: the state never changes, and the events do choose
    the steps.
    """

    def __init__(
        self, scene: Scene, number: NumberType, tolerance: Fraction | None, still: bool
    ) -> None:
        self.still = still
        self.start = [sign_at_start(scene, k) for k in range(len(scene.events))]
        eps = max(number.eps, tolerance or ZERO)
        self.band = BAND * eps / 2
        small = Fraction(1)
        if not still:
            small = Fraction(2) ** -(((1 / eps).numerator.bit_length() - 1) // 2)
        self.damping: list[Fraction] = []
        sizes = [size_of(scene, event) for event in scene.events]
        self.asked = any(e.stop for e in scene.events) or not all(x.entire for x in sizes)
        for size in sizes:
            value, rate = exactly(size.value) or Fraction(1), exactly(size.rate) or Fraction(1)
            self.damping.append(small * Fraction(2) ** -_exponent(max(value, rate)))


def _exponent(x: Fraction) -> int:
    mantissa, exponent = exact.rounded(x, 8)
    return exponent + mantissa.bit_length()

"""What the events of a scene are looked for by: made once for a scene.

Among it, for each event, what counts as steep, as a contact, as converged.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from polhode.numbers import exact
from polhode.numbers.conversion import exactly
from polhode.numbers.exact import ZERO
from polhode.numbers.number_types import NumberType
from polhode.numbers.scalars import Scalar
from polhode.scenes.scene import Scene
from polhode.taylor.backend import heyoka_numbers
from polhode.taylor.backend.types import HeyokaNumber
from polhode.taylor.events.callbacks import is_entire
from polhode.taylor.events.magnitudes import Size, sign_at_start, size_of


class Rules:
    """What a run's watch goes by: made once for a scene, number type and tolerance.  Immutable.

    ``start``: the exact signs of the expressions at t = 0.  ``asked``: whether heyoka asks after
    each step.
    """

    def __init__(
        self, scene: Scene, number: NumberType, tolerance: Fraction | None, steering: bool
    ) -> None:
        self.start = [sign_at_start(scene, k) for k in range(len(scene.events))]
        self.asked = any(e.stop or not is_entire(scene, e) for e in scene.events)
        eps = max(number.eps, tolerance or ZERO)
        self.limits = [
            Limits(size_of(scene, event), number, eps, steering) for event in scene.events
        ]


class Limits:
    """Thresholds of one event as numbers of the run's type; times in the run's unit.

    From the sizes S of the expression and S' of its rate: a contact is a value below 16 eps S at an
    extremum; a slope below S'/256 is looked at twice.  ``typed``: makes the numbers, heyoka's
    unless given.
    """

    def __init__(
        self,
        found: Size,
        number: NumberType,
        eps: Fraction,
        steering: bool,
        typed: Callable[[Fraction], Scalar] | None = None,
    ) -> None:
        value, rate = exactly(found.value) or Fraction(1), exactly(found.rate) or Fraction(1)
        half = Fraction(2) ** -(((1 / eps).numerator.bit_length() - 1) // 2)

        def of_heyoka(x: Fraction) -> HeyokaNumber:
            return heyoka_numbers.scalar(x, number)

        typed = typed or of_heyoka
        noise = 256 * number.eps * value
        self.zero = typed(ZERO)
        self.noise = typed(noise)
        self.steep = typed(rate / 256)
        self.flat = typed(16 * eps * rate)
        self.contact = typed(16 * eps * value)
        small = Fraction(1) if steering else half
        self.damping = typed(small * Fraction(2) ** -_exponent(max(value, rate)))
        self.converged = typed(Fraction(2) ** -(number.bits // 2 + 6))
        self.nearby = typed(Fraction(2) ** -(number.bits // 3))
        self.widest = typed(Fraction(1, 16))


def _exponent(x: Fraction) -> int:
    mantissa, exponent = exact.rounded(x, 8)
    return exponent + mantissa.bit_length()

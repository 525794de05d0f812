"""What the events of a scene are looked for by: made once for a scene."""

from __future__ import annotations

from fractions import Fraction

from polhode.numbers.exact import ZERO
from polhode.numbers.number_types import NumberType
from polhode.scenes.scene import Scene
from polhode.taylor.events.callbacks import is_entire
from polhode.taylor.events.magnitudes import sign_at_start, size_of
from polhode.taylor.events.thresholds import Limits


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

"""A proven enclosure as the reference of a scene, where no closed form is known."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from polhode.common.errors import BadInput
from polhode.numbers.convert import exact_number
from polhode.numbers.exact import Exact
from polhode.scenes.scene import Scene
from polhode.scenes.tops import kind_of_body

if TYPE_CHECKING:
    from polhode.enclosures.result import Enclosure


class Certified:
    """The reference of any scene: balls that contain the exact motion, and their midpoints.

    ``agreement`` holds the digits proven for the last request, at its worst time.

    >>> import polhode
    >>> proven = polhode.Certified(polhode.load("general/asymmetric-regular"))
    >>> rows = proven.at([1], digits=20)
    >>> 20 <= proven.agreement < 30
    True
    """

    is_closed_form = False
    is_proven = True
    kind = "certified"
    period = None
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.regime = kind_of_body(scene.body)
        self.agreement = math.nan
        self.frequencies: dict[str, Any] = {}
        self._known: dict[tuple[tuple[Exact, ...], int], Enclosure] = {}

    def __eq__(self, other: object) -> bool:
        return self.scene == other.scene if isinstance(other, Certified) else NotImplemented

    def __reduce__(self) -> tuple[Any, ...]:
        return Certified, (self.scene,)

    def __repr__(self) -> str:
        return f"<Certified of {self.scene.name}: {self.regime}>"

    def at(self, times: Sequence[Any], digits: int = 50) -> list[list[Any]]:
        """Rows p q r [gamma1 gamma2 gamma3] as mpf, proven to so many digits.

        Raises BadInput where so many cannot be proven.
        """
        found = self.enclosure(times, digits)
        return [list(row) for row in found.midpoints]

    def enclosure(self, times: Sequence[Any], digits: int = 50) -> Enclosure:
        """The balls themselves; the last request is also told in ``agreement``."""
        from polhode.enclosures.certify import MOST_DIGITS, certify  # a closed form needs no heyoka

        key = (tuple(exact_number(t) for t in times), digits)
        if key not in self._known:
            if digits > MOST_DIGITS:
                expected = f"at most {MOST_DIGITS} digits, or reference.kind = two-precisions"
                raise BadInput(self.scene.name, "reference digits", digits, expected)
            self._known[key] = certify(self.scene, key[0], digits)
        self.agreement = self._known[key].proven
        return self._known[key]

    def attitude(self, times: Sequence[Any], digits: int = 50) -> list[list[Any]]:
        """Not made: the enclosure is of the state alone."""
        raise BadInput(self.scene.name, "reference", None, "a closed form for the attitude")

    angles = attitude

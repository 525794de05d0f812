"""An event of a scene: what vanishes, in which direction, and whether the run ends there."""

from __future__ import annotations

import re
from typing import NamedTuple

from polhode.common.arguments import of_kind
from polhode.common.errors import BadInput, nearest
from polhode.scenes.column_expressions import check
from polhode.scenes.vocabulary import DIRECTIONS, READY_MADE, SECTION, STATE


class Event(NamedTuple):
    """An event: the zeros of an expression in p q r gamma1 gamma2 gamma3 t, in the scene's units.

    >>> from dataclasses import replace
    >>> import polhode
    >>> event = polhode.Event("level", "gamma3 - 1/2", "rising", stop=True)
    >>> scene = replace(polhode.load("lagrange/nutation"), events=(event,))
    >>> polhode.integrate(scene).outcome.value
    'stopped at event'

    ``zero``: the expression; empty for a name that is known, such as "nutation".  ``direction``:
    rising, falling or any, as t grows, in backward runs too.  ``stop``: the run ends at the first
    one.
    """

    name: str
    zero: str = ""
    direction: str = "any"
    stop: bool = False

    @property
    def table(self) -> dict[str, object]:
        """Its keys in a scene file; None for a zero that its name says."""
        return self._asdict() | {"zero": self.zero or None}

    @property
    def expression(self) -> str | None:
        """What vanishes, as text; None for w along the middle principal axis."""
        if self.zero:
            return self.zero
        if self.name.startswith(SECTION):
            return self.name.removeprefix(SECTION)
        return READY_MADE.get(self.name, "")

    @property
    def timed(self) -> bool:
        """Whether the time enters what vanishes."""
        return "t" in re.findall(r"\w+", self.expression or "")

    @property
    def needs_zero(self) -> bool:
        """Whether the name alone does not say what vanishes."""
        return self.name not in READY_MADE and not self.name.startswith(SECTION)

    def counts(self, slope: int) -> bool:
        """Whether a zero of that slope is one asked for; a grazing contact (0) always is."""
        return slope == 0 or self.direction in ("any", "rising" if slope > 0 else "falling")


def check_event(event: Event, scene: str, key: str) -> None:
    """Refuse what no event can be; raises BadInput in the name of a scene and a key of it."""
    for word in ("name", "zero", "direction"):
        of_kind(scene, f"{key}.{word}", getattr(event, word), str, "text")
    if not event.name.isprintable():  # it is the name of a row, a column and a key
        raise BadInput(scene, f"{key}.name", event.name, "text of one line that can be printed")
    of_kind(scene, f"{key}.stop", event.stop, bool, "True or False")
    if event.direction not in DIRECTIONS:
        expected = nearest(event.direction, [*DIRECTIONS])
        raise BadInput(scene, f"{key}.direction", event.direction, expected)
    if event.expression is not None:
        names = (*STATE, "t")
        try:
            check(event.expression, names)
        except ValueError as fault:
            expected = f"an expression in {' '.join(names)} ({fault})"
            word = "zero" if event.zero or event.needs_zero else "name"
            raise BadInput(scene, f"{key}.{word}", event.expression, expected) from None

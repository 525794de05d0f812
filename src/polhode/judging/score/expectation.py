"""What rounding leaves of a motion's digits at the times that are judged."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from polhode.common.cached_property import cached_property
from polhode.common.text_tables import few
from polhode.judging.conditioning.conditioning import Conditioning, conditioning
from polhode.judging.conditioning.rounding_errors import Band
from polhode.judging.diagnosis.error_budget import between
from polhode.judging.references.reference import by_sign
from polhode.judging.score.report_text import SHOWN
from polhode.judging.tables.table import Table
from polhode.numbers.exact import Exact
from polhode.scenes.scene import Scene
from polhode.taylor.backend import engine

FOLLOWED = 400  # times at which what rounding does to the motion is followed


@dataclass(frozen=True, eq=False)
class Expectation:
    """The digits to expect of a subject at its times, and what an error grows by.

    Followed at ``FOLLOWED`` times or so; of more times, linear between those.  ``also``: a row that
    is followed in any case.  ``known``: the conditioning at the scene's times, if it is known.
    """

    scene: Scene
    subject: Table
    also: int | None = None
    known: Conditioning | None = None

    @cached_property
    def conditionings(self) -> tuple[Conditioning, ...]:
        """Kappa at the times judged: from t = 0 ahead, and from t = 0 back."""
        if self.known is not None:
            return (self.known,)
        if not engine.installed:
            return ()
        times = self.subject.times
        count = len(times)
        kept = {*few(count, FOLLOWED), *few(count, SHOWN)}
        kept |= set() if self.also is None else {self.also}
        parts = by_sign([times[k] for k in sorted(kept)])
        return tuple(conditioning(self.scene, part, self.subject.number) for part in parts)

    @cached_property
    def bands(self) -> tuple[Band | None, ...]:
        """The digits of runs that round once a step of the subject's type."""
        return self._told(lambda known: known.expected(self.subject.number, self.every))

    @cached_property
    def inputs(self) -> tuple[float | None, ...]:
        """The digits that rounding the scene's numbers to the subject's type leaves."""
        return self._told(lambda known: known.inputs(self.subject.number, self.every))

    @cached_property
    def amplification(self) -> tuple[float | None, ...]:
        """What a change of the state on the way is multiplied by at most; inf beyond doubles."""
        found = self._told(lambda known: known.log10_amplification)
        return tuple(None if x is None else 10.0**x if x < 308 else math.inf for x in found)

    @property
    def every(self) -> int:
        """Steps between two projections of the run; 0 where there are none."""
        run = self.subject.run
        return 0 if run is None or run.projection is None else run.projection.every

    def _told(self, what: Callable[[Conditioning], tuple[Any, ...]]) -> tuple[Any, ...]:
        """What is known of the times judged."""
        times = self.subject.times
        if self.known is not None:
            return what(self.known)[: len(times)]
        if not self.conditionings:
            return (None,) * len(times)
        found: dict[Exact, Any] = {}
        for part in self.conditionings:
            found |= dict(zip(part.times, what(part), strict=True))
        return between(found, times)

"""What rounding leaves of a motion's digits at the times that are judged."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from polhode.common.errors import few
from polhode.common.values import cached_property
from polhode.judging.conditioning.conditioning import Conditioning, conditioning
from polhode.judging.conditioning.rounding_errors import Band
from polhode.judging.diagnosis.error_budget import between
from polhode.judging.references.reference import by_sign
from polhode.judging.score.report_text import SHOWN
from polhode.judging.tables.table import Table
from polhode.numbers.exact import Exact
from polhode.scenes.scene import Scene
from polhode.taylor import heyoka

FOLLOWED = 400  # times at which what rounding does to the motion is followed


@dataclass(frozen=True, eq=False)
class Expectation:
    """The digits to expect of a subject at its times.

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
        if not heyoka.installed:
            return ()
        parts = by_sign([self.subject.times[k] for k in self._rows])
        return tuple(conditioning(self.scene, part, self.subject.number) for part in parts)

    @cached_property
    def _rows(self) -> list[int]:
        """Those that are followed."""
        count = len(self.subject.times)
        also = set() if self.also is None else {self.also}
        return sorted({*few(count, FOLLOWED), *few(count, SHOWN)} | also)

    @cached_property
    def bands(self) -> tuple[Band | None, ...]:
        """The digits of runs that round once a step of the subject's type."""
        return self._told(lambda known: known.expected(self.subject.number, self.every))

    @cached_property
    def inputs(self) -> tuple[float | None, ...]:
        """The digits that rounding the scene's numbers to the subject's type leaves."""
        return self._told(lambda known: known.inputs(self.subject.number, self.every))

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
        return between({k: found[times[k]] for k in self._rows}, times)

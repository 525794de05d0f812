"""What higher rooms do for judgements."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from polhode.common.presentation import Slot

if TYPE_CHECKING:
    from polhode.judging.score.judgement import Judgement


class JudgementPresentation(Protocol):
    """A judgement shown."""

    def html(self, judgement: Judgement, /) -> str:
        """What a notebook shows of it."""
        ...


JUDGEMENTS: Slot[JudgementPresentation] = Slot()

"""What higher rooms do for judgements."""

from __future__ import annotations

from typing import Protocol, TypeVar

J_contra = TypeVar("J_contra", contravariant=True)


class JudgementPresentation(Protocol[J_contra]):
    """A judgement shown."""

    def html(self, judgement: J_contra, /) -> str:
        """What a notebook shows of it."""
        ...

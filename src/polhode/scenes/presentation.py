"""What higher rooms do for scenes."""

from __future__ import annotations

from typing import Protocol, TypeVar

S_contra = TypeVar("S_contra", contravariant=True)


class ScenePresentation(Protocol[S_contra]):
    """A scene shown."""

    def html(self, scene: S_contra, /) -> str:
        """What a notebook shows of it."""
        ...

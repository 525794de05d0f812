"""What higher rooms do for scenes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from polhode.common.presentation import Slot

if TYPE_CHECKING:
    from polhode.scenes.scene import Scene


class ScenePresentation(Protocol):
    """A scene shown."""

    def html(self, scene: Scene, /) -> str:
        """What a notebook shows of it."""
        ...


SCENES: Slot[ScenePresentation] = Slot()

"""Starts of many members in one array: what is varied, in the keys of a scene file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from polhode.common.arguments import rows_of
from polhode.common.errors import BadInput
from polhode.scenes.scene import Scene
from polhode.scenes.variation import vary
from polhode.scenes.variation.sweep_scenes import tables_of

if TYPE_CHECKING:
    import numpy.typing as npt


def from_starts(
    scene: Scene, starts: npt.ArrayLike, others: vary.Vary | None = None
) -> tuple[Scene, dict[str, Any]]:
    """A scene whose start is omega and gamma, and what is varied of it; raises BadInput.

    ``starts``: (N, 6), or (N, 3) of a scene without gamma.  ``others``: arrays of the body's
    numbers.
    """
    rows = rows_of(scene.name, "starts", starts, len(scene.columns))
    varied: dict[str, Any] = {"start.omega": rows[:, :3]}
    if scene.gamma is not None:
        varied["start.gamma"] = rows[:, 3:]
    if others is not None and not isinstance(others, Mapping):
        raise BadInput(scene.name, "vary", "a list", "arrays of the body's numbers, beside starts")
    for key, given in (others or {}).items():
        if key.startswith("start.") and key != "start.psi":
            raise BadInput(scene.name, "vary", key, "numbers of the body, beside starts")
        varied[key] = given
    own = tables_of(scene)["start"]
    if "omega" not in own or ("gamma" in own) != (scene.gamma is not None):  # angles, a level
        scene = replace(scene, source="")
    return scene, varied


def varied_of(
    scene: Scene, starts: npt.ArrayLike | None, others: vary.Vary | None
) -> tuple[Scene, vary.Vary]:
    """The scene of a sweep and what is varied of it, by keys or by starts; raises BadInput."""
    if starts is not None:
        return from_starts(scene, starts, others)
    if others is None:
        raise BadInput(scene.name, "vary", None, "numbers to vary, or starts")
    return scene, others

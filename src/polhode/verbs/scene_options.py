"""Options that change a scene before a verb takes it: output times, form, outputs."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from polhode.scenes.vocabulary import COLUMNS
from polhode.verbs.options import whole

if TYPE_CHECKING:
    from polhode.scenes.scene import Scene

TIMES, FORM, OUTPUTS = "times", "form", "outputs"


def add(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Add the options of some of the words TIMES, FORM, OUTPUTS."""
    if TIMES in words:
        _add_times(parser)
    if FORM in words:
        parser.add_argument("--form", metavar="F", help="form of the equations")
    if OUTPUTS in words:
        parser.add_argument("--outputs", metavar="O,O", help=", ".join(COLUMNS))


def applied(options: Namespace, scene: Scene, words: Sequence[str]) -> Scene:
    """The scene with what the options of these words say; raises BadInput."""
    if TIMES in words:
        from polhode.verbs.given_times import times_of

        scene = scene.at(times_of(options, scene))
    if FORM in words and options.form is not None:
        scene = replace(scene, form=options.form)
    if OUTPUTS in words and options.outputs is not None:
        scene = replace(scene, outputs=tuple(o for o in options.outputs.split(",") if o))
    return scene


def _add_times(parser: ArgumentParser) -> None:
    at = "output times instead of the scene's; one of them may be FROM:TO:N, for N evenly spaced"
    parser.add_argument("--at", metavar="T,T...", help=at)
    parser.add_argument("--end", metavar="T", help="last time instead of the scene's")
    spacing = parser.add_mutually_exclusive_group()
    spacing.add_argument(
        "--samples",
        type=whole,
        metavar="N",
        help="N evenly spaced times from 0 to the end, both included (as many as the scene's)",
    )
    spacing.add_argument(
        "--every", metavar="DT", help="the times 0, DT, 2 DT, ... that are not beyond the end"
    )

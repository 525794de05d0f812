"""What a method of integration is: a module that tells when it serves, and begins a motion."""

from __future__ import annotations

from typing import Protocol

from polhode.motion.protocols import Motion
from polhode.numbers.number_types import NumberType
from polhode.runs.problem.options import Options
from polhode.runs.problem.problem import Problem
from polhode.scenes.scene import Scene


class Method(Protocol):
    """A method by its name among those of :class:`polhode.runs.problem.options.Options`."""

    NAME: str

    def hindrance(self, scene: Scene, number: NumberType, options: Options) -> str | None:
        """What would have to be otherwise for the method to serve; None where it does."""

    def worth_it(self, scene: Scene, number: NumberType) -> bool:
        """Whether it is the faster way."""

    def motion(
        self,
        problem: Problem,
        scene: Scene,
        variables: tuple[str, ...],
        watched: bool,
        options: Options,
    ) -> Motion:
        """A motion at its start.

        ``scene``: the problem's own, with the times of this run.  ``variables``: integrated beside
        the state.  ``watched``: whether the scene's events are looked for on the way.
        """

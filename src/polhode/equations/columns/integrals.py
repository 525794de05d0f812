"""The first integrals and how far they have gone from the start's, relative as in Drift."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from polhode.equations.column import Column
from polhode.equations.integrals import AREA, ENERGY, along
from polhode.motion.frame import Frame
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import Functions, Scalar
from polhode.numbers.row_formulas import RowFormula
from polhode.scenes.scene import Scene


def _of_scene(scene: Scene) -> tuple[RowFormula, Mapping[str, Exact]]:
    formula, coefficients = along(scene)
    largest, unit = max(scene.body.moments), Frame.of(scene).unit
    units = {ENERGY: largest / (2 * unit * unit), AREA: largest / unit}

    def values(x: Sequence[Scalar], k: Mapping[str, Scalar], fn: Functions) -> list[Scalar]:
        found, departures = formula(x, k, fn.zero)
        return [found[0] * k["unit of h"], found[1] * k["unit of f"], *departures]

    return values, {**coefficients, **{f"unit of {name}": x for name, x in units.items()}}


COLUMN: Final = Column(of_scene=_of_scene, not_judged="p q r and gamma are")

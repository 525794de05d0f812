"""Derived columns of proven balls: the formula of a run's, evaluated in ball arithmetic."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from flint import arb

from polhode.enclosures.polynomial import ball
from polhode.equations.columns import FORMULAS
from polhode.numbers.flint_context import ctx
from polhode.numbers.number_types import Functions
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import COLUMNS


def derived_balls(
    word: str, scene: Scene, balls_by_word: Mapping[str, Sequence[Sequence[Any]]], bits: int
) -> list[list[Any]]:
    """Rows of balls that contain the column: of rows of balls of all that it needs, by name.

    A row is None throughout where a number that it needs is, or where no ball is finite.
    """
    width = len(COLUMNS[word].names)
    rows = []
    with ctx.workprec(bits):
        formula, coefficients = FORMULAS[word].of(scene)
        k = {name: ball(x, bits) for name, x in coefficients.items()}
        fn = Functions(arb(0), arb.sin, arb.cos, arb.sqrt)
        for parts in zip(*(balls_by_word[need] for need in COLUMNS[word].needs), strict=True):
            row = [x for part in parts for x in part]
            balls = [] if any(x is None for x in row) else [arb(x) for x in formula(row, k, fn)]
            finite = balls if all(x.is_finite() for x in balls) else []
            rows.append([*finite, *[None] * (width - len(finite))])
    return rows

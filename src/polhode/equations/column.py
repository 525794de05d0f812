"""Derived columns of a trajectory: one file each, a formula written once for any scalar.

What a scene may ask for is in :data:`polhode.scenes.vocabulary.COLUMNS`; the formula of a word that
is derived is found by the word, as a form of the equations is by its name.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING

from polhode.numbers.row_formulas import RowFormula, mapped, mapped_stack
from polhode.scenes.vocabulary import COLUMNS

if TYPE_CHECKING:
    from polhode.numbers.exact import Exact
    from polhode.numbers.number_types import Columns, Given, NumberType, Stack
    from polhode.scenes.scene import Scene


@dataclass(frozen=True)
class Column:
    """A derived column.

    ``values``: of a row of what it needs, one after the other (the state is p q r gamma1 gamma2
    gamma3), of coefficients and of the scalar's functions.  ``of_scene``: in its place a scene's
    formula and exact coefficients by name.  ``not_judged``: why a file's column is not held against
    a reference, where it is not.
    """

    values: RowFormula | None = None
    of_scene: Callable[[Scene], tuple[RowFormula, Mapping[str, Exact]]] | None = None
    not_judged: str = ""

    def of(self, scene: Scene) -> tuple[RowFormula, Mapping[str, Exact]]:
        """The formula of a scene, and its coefficients."""
        if self.of_scene is not None:
            return self.of_scene(scene)
        assert self.values is not None
        return self.values, {}


def column(word: str) -> Column:
    """A derived column by its word, imported when it is asked for."""
    found: Column = import_module(f"polhode.equations.columns.{word.replace('-', '_')}").COLUMN
    return found


def derived_words() -> list[str]:
    """The words of the columns that are derived."""
    return [word for word, found in COLUMNS.items() if found.how == "derived"]


def of_state_alone() -> list[str]:
    """The words of the columns that need the state and nothing else."""
    return [word for word in derived_words() if COLUMNS[word].needs == ("state",)]


def derived_stack(word: str, scenes: Sequence[Scene], states: Stack, number: NumberType) -> Stack:
    """A column of states alone, (members, times, columns); not a number where there is none."""
    found, width = column(word), len(COLUMNS[word].names)
    made: Stack = states[:, :, :1].repeat(width, axis=2)
    for k, scene in enumerate(scenes):
        formula, coefficients = found.of(scene)
        made[k] = mapped_stack(formula, states[k : k + 1], coefficients, number, width)[0]
    return made


def derived(word: str, scene: Scene, parts: Sequence[Given], number: NumberType) -> Columns:
    """A derived column of rows of all that it needs, in the order of its ``needs``."""
    formula, coefficients = column(word).of(scene)
    return mapped(formula, parts, coefficients, number, len(COLUMNS[word].names))

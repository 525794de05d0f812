"""Derived columns of a trajectory: a row each, a formula written once for any scalar.

What a scene may ask for is in :data:`polhode.scenes.vocabulary.COLUMNS`; the formula of a word that
is derived stands in :data:`FORMULAS`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Final, NamedTuple

from polhode.equations.integrals import AREA, ENERGY, along
from polhode.equations.kinematics import turned
from polhode.motion.frame import Frame
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import DerivedRows, Functions, Given, NumberType, Scalar, Stack
from polhode.numbers.row_formulas import RowFormula, RowMap
from polhode.numbers.vectors import rotation
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import COLUMNS, STATE


class DerivedColumn(NamedTuple):
    """A derived column.

    ``of``: a scene's formula, and its exact coefficients by name; of a row of what it needs, one
    after the other (the state is p q r gamma1 gamma2 gamma3), of coefficients and of the scalar's
    functions.  ``not_judged``: what of a file is held against a reference in its place.
    """

    of: Callable[[Scene], tuple[RowFormula, Mapping[str, Exact]]]
    not_judged: str


def of_rows(formula: RowFormula) -> Callable[[Scene], tuple[RowFormula, Mapping[str, Exact]]]:
    """A formula that is the same of every scene, and has no coefficients."""
    return lambda scene: (formula, {})


def _in_space(x: Sequence[Scalar], k: Mapping[str, Scalar], fn: Functions) -> list[Scalar]:
    """omega along the axes of space, z up: R(q) omega (3.34)."""
    return turned(x[len(STATE) :], x[:3])


def _matrix(x: Sequence[Scalar], k: Mapping[str, Scalar], fn: Functions) -> Sequence[Scalar]:
    """The rotation matrix, body to space, row by row: R(q) of (3.34)."""
    return rotation(x)


def _mrp(x: Sequence[Scalar], k: Mapping[str, Scalar], fn: Functions) -> list[Scalar]:
    """Modified Rodrigues parameters of the attitude: the axis times tan(angle/4)."""
    return [part / (x[0] + 1) for part in x[1:]]


def _integrals(scene: Scene) -> tuple[RowFormula, Mapping[str, Exact]]:
    """The first integrals and how far they have gone from the start's, relative as in Drift."""
    formula, coefficients = along(scene)
    largest, unit = max(scene.body.moments), Frame.of(scene).unit
    units = {ENERGY: largest / (2 * unit * unit), AREA: largest / unit}

    def values(x: Sequence[Scalar], k: Mapping[str, Scalar], fn: Functions) -> list[Scalar]:
        present, departures = formula(x, k, fn.zero)
        return [present[0] * k["unit of h"], present[1] * k["unit of f"], *departures]

    return values, {**coefficients, **{f"unit of {name}": x for name, x in units.items()}}


#: By the words of :data:`polhode.scenes.vocabulary.COLUMNS`.
FORMULAS: Final[dict[str, DerivedColumn]] = {
    "hodographs": DerivedColumn(of_rows(_in_space), "p q r are"),
    "matrix": DerivedColumn(of_rows(_matrix), "the quaternion is"),
    "mrp": DerivedColumn(of_rows(_mrp), "the quaternion is"),
    "integrals": DerivedColumn(_integrals, "p q r and gamma are"),
}


def derived_words() -> list[str]:
    """The words of the columns that are derived."""
    return [word for word, entry in COLUMNS.items() if entry.how == "derived"]


def of_state_alone() -> list[str]:
    """The words of the columns that need the state and nothing else."""
    return [word for word in derived_words() if COLUMNS[word].needs == ("state",)]


def derived_stack(
    word: str, scenes: Sequence[Scene], states: Stack, number_type: NumberType
) -> Stack:
    """A column of states alone, (members, times, columns); not a number where there is none."""
    width = len(COLUMNS[word].names)
    columns: Stack = states[:, :, :1].repeat(width, axis=2)
    for k, scene in enumerate(scenes):
        formula, coefficients = FORMULAS[word].of(scene)
        row_map = RowMap(formula, coefficients, number_type, width)
        columns[k] = row_map.of_stack(states[k : k + 1])[0]
    return columns


def derived(
    word: str, scene: Scene, parts: Sequence[Given], number_type: NumberType
) -> DerivedRows:
    """A derived column of rows of all that it needs, in the order of its ``needs``."""
    formula, coefficients = FORMULAS[word].of(scene)
    return RowMap(formula, coefficients, number_type, len(COLUMNS[word].names))(*parts)

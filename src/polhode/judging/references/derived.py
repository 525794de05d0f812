"""Columns of a reference, those that are derived too."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from polhode.common.errors import BadInput, nearest
from polhode.equations.column import derived
from polhode.numbers import number_types
from polhode.numbers.scalars import AnyNumber, Real
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import COLUMNS

#: A reference's answer to a question by its name: rows at times, to so many digits.
Asked = Callable[[str], Callable[..., list[list[Real | None]]]]


def column_of(
    asked: Asked, scene: Scene, word: str, times: Iterable[AnyNumber], digits: int
) -> list[list[Real | None]]:
    """Rows of an output at the times; raises BadInput.

    A derived one is the formula of the reference's own rows: those of the state to so many digits,
    others to one more, and the formula to more than either.
    """
    if word not in COLUMNS:
        raise BadInput(scene.name, "outputs", word, nearest(word, [*COLUMNS]))
    times = list(times)
    if COLUMNS[word].how == "integrated":
        return asked(word)(times, digits)
    parts = [
        asked("at")(times, digits) if need == "state" else asked(need)(times, digits + 1)
        for need in COLUMNS[word].needs
    ]
    rows = derived(word, scene, parts, number_types.mp(digits + 1))
    return [list(row) for row in rows]

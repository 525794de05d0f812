"""What became of the members of a sweep: put together, and as arrays that a file keeps."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

from polhode.common.checkpoint import Arrays
from polhode.motion.outcomes import OUTCOMES, Outcome, code
from polhode.numbers.conversion import number_value
from polhode.numbers.decimals import strings
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Stack, flat, kind_of
from polhode.runs.sweep.plan import Plan

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from polhode.taylor.batches import Solved


def no_states(number: NumberType, shape: tuple[int, ...]) -> Stack:
    """States of this shape, none of them a number."""
    import numpy as np

    if number.flat:
        return flat(np.full(shape, np.nan, kind_of(number)))
    from polhode.numbers.mpmath_context import mpmath, ordinary

    return np.full(shape, ordinary(mpmath.nan), dtype=object)


def none_of(number: NumberType, members: int, times: int, columns: int) -> Solved:
    """Nothing done yet."""
    from polhode.taylor.batches import Solved

    return Solved.undone(no_states(number, (members, times, columns)))


def put_together(
    plan: Plan, groups: Sequence[npt.NDArray[np.int64]], found: Sequence[Solved | None]
) -> tuple[Solved, dict[int, tuple[float | None, ...]]]:
    """The results of all members in their order, and the errors of those that have any."""
    columns = len(plan.members.scene.columns)
    whole = none_of(plan.number, len(plan.members), len(plan.times), columns)
    errors: dict[int, tuple[float | None, ...]] = {}
    for group, some in zip(groups, found, strict=True):
        if some is not None:
            whole.put(group, some)
            told = zip(group.tolist(), some.errors or (), strict=False)
            errors |= {k: error for k, error in told if error is not None}
    return whole, errors


def packed(found: Solved, number: NumberType) -> Mapping[str, npt.ArrayLike]:
    """A job's result as arrays that need no pickle; states above extended as decimals."""
    import numpy as np

    states: npt.NDArray[np.generic] = found.states
    if not number.flat:
        text = [
            strings([row], number)[0] if row[0] == row[0] else ["nan"] * len(row)
            for row in states.reshape(-1, states.shape[-1]).tolist()
        ]
        states = np.array(text).reshape(states.shape)
    return {
        "states": states,
        "outcomes": np.array([outcome.value for outcome in OUTCOMES])[found.outcomes],
        "steps": found.steps,
        "reached": np.array([str(t) for t in found.reached]),
        "errors": np.array(json.dumps(found.errors)),
    }


def unpacked(held: Arrays, number: NumberType) -> Solved:
    """The same back."""
    import numpy as np

    from polhode.taylor.batches import Solved

    told = json.loads(str(held["errors"]))
    return Solved(
        flat(held["states"]) if number.flat else _numbers(held["states"], number),
        np.array([code(Outcome(text)) for text in held["outcomes"].tolist()], dtype=np.uint8),
        np.asarray(held["steps"], dtype=np.int64),
        np.array([Fraction(text) for text in held["reached"].tolist()], dtype=object),
        None if told is None else [None if x is None else tuple(x) for x in told],
    )


def _numbers(texts: npt.NDArray[np.generic], number: NumberType) -> Stack:
    import numpy as np

    found = no_states(number, texts.shape)
    for index in np.argwhere(texts != "nan"):
        found[tuple(index)] = number_value(Fraction(str(texts[tuple(index)])), number)
    return found

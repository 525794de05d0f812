"""What became of the members of a sweep: read in the scene's axes, kept in files, put together."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, NamedTuple, TypeVar

from polhode.common.checkpoint import Arrays
from polhode.common.progress import Stop
from polhode.equations.readout import Readout
from polhode.motion.outcomes import OUTCOMES, Outcome, code
from polhode.numbers.conversion import number_value
from polhode.numbers.decimals import strings
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Stack, flat, kind_of
from polhode.runs.sweep.plan import Plan
from polhode.scenes.scene import Scene

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from polhode.taylor.batches.jobs import BatchJob, Solved

K = TypeVar("K", bound="np.generic")


@dataclass(frozen=True, eq=False)
class Reader:
    """Reads rows of some members in scene axes and units: plain data, to be sent anywhere.

    ``bodies``: members that have principal axes in common, with a scene of such; none where axes
    need no turn.  ``unit``: the exponent of the unit of time that all of them have.
    """

    number: NumberType
    unit: int
    bodies: tuple[tuple[npt.NDArray[np.int64], Scene], ...]

    def states(self, rows: Stack) -> Stack:
        """States, not a number where a member did not come; of flat types.

        ``rows``: (members, times, columns) in principal axes and the run's units.
        """
        import numpy as np

        states = flat(rows).copy()
        for alike, one in self.bodies:  # one readout reads all of them
            at = np.zeros(rows.shape[:2], dtype=bool)
            at[alike] = ~np.isnan(rows[alike, :, 0])
            if at.any():
                read = flat(Readout(one, self.number).states(flat(rows[at])))
                read[:, :3] = np.ldexp(read[:, :3], one.time_unit)
                states[at] = read
        states[:, :, :3] = np.ldexp(states[:, :, :3], -self.unit)
        return states


def reader(plan: Plan, members: npt.NDArray[np.int64]) -> Reader:
    """What reads the rows of some members of a sweep that have a unit of time in common."""
    import numpy as np

    unit, base = int(plan.time_units[members[0]]), plan.members.scene
    if not plan.members.axes_stay:
        _, first, alike = np.unique(
            np.stack(plan.bodies(members), axis=1), axis=0, return_index=True, return_inverse=True
        )
        own = [plan.members[int(members[k])] for k in first]
        sets = [(np.flatnonzero(alike == n), one) for n, one in enumerate(own)]
    else:  # a reading knows the axes alone
        sets = [] if base.body.axes.trivial else [(np.arange(len(members)), base)]
    bodies = tuple((these, replace(one, form="principal")) for these, one in sets)
    return Reader(plan.number, unit, bodies)


class StepJob(NamedTuple):
    """Members of a flat type that have a unit of time in common, and what reads their rows."""

    steps: BatchJob
    read: Reader


def solve(job: StepJob, stop: Stop | None = None) -> Solved:
    """What became of the members, in the scene's axes and units; ``stop`` ends it on the way."""
    from polhode.taylor.batches import batch_integrator

    solved = batch_integrator.solve(job.steps, stop)
    return replace(solved, states=job.read.states(solved.states))


def prepare(job: StepJob) -> None:
    """Compile what the members share: once, before threads ask for it."""
    from polhode.taylor.batches import batch_integrator

    batch_integrator.prepare(job.steps)


def no_states(number: NumberType, shape: tuple[int, ...]) -> Stack:
    """States of this shape, none of them a number."""
    import numpy as np

    if number.flat:
        return flat(np.full(shape, np.nan, kind_of(number)))
    from polhode.numbers.mpmath_context import mpmath, ordinary

    return np.full(shape, ordinary(mpmath.nan), dtype=object)


def put_together(
    plan: Plan, groups: Sequence[npt.NDArray[np.int64]], found: Sequence[Solved | None]
) -> tuple[Solved, dict[int, tuple[float | None, ...]]]:
    """The results of all members in their order, and the errors of those that have any."""
    import numpy as np

    from polhode.taylor.batches.jobs import Solved

    count = len(plan.members)
    whole = Solved(
        no_states(plan.number, (count, len(plan.times), len(plan.members.scene.columns))),
        np.full(count, code(Outcome.NOT_RUN), dtype=np.uint8),
        np.zeros(count, dtype=np.int64),
        np.full(count, Fraction(0), dtype=object),
    )
    errors: dict[int, tuple[float | None, ...]] = {}
    for group, some in zip(groups, found, strict=True):
        if some is not None:
            whole.states[group], whole.outcomes[group] = some.states, some.outcomes
            whole.steps[group], whole.reached[group] = some.steps, some.reached
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

    from polhode.taylor.batches.jobs import Solved

    told = json.loads(str(held["errors"]))
    return Solved(
        flat(held["states"]) if number.flat else _numbers(held["states"], number),
        _looked_up(held["outcomes"], lambda text: code(Outcome(text)), np.uint8),
        np.asarray(held["steps"], dtype=np.int64),
        _looked_up(held["reached"], Fraction, np.object_),
        None if told is None else [None if x is None else tuple(x) for x in told],
    )


def _numbers(texts: npt.NDArray[np.generic], number: NumberType) -> Stack:
    import numpy as np

    found = no_states(number, texts.shape)
    for index in np.argwhere(texts != "nan"):
        found[tuple(index)] = number_value(Fraction(str(texts[tuple(index)])), number)
    return found


def _looked_up(
    texts: npt.NDArray[np.generic], read: Callable[[str], object], kind: type[K]
) -> npt.NDArray[K]:
    """An array of texts, of which there are few different ones, read."""
    import numpy as np

    different, which = np.unique(texts, return_inverse=True)
    known = np.empty(len(different), dtype=kind)
    for k, text in enumerate(different.tolist()):
        known[k] = read(text)
    return known[which]

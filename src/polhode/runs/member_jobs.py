"""Members of a sweep, run by the batch or one by one."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.common.checkpoint import Arrays
from polhode.common.interrupts import Stop
from polhode.equations.readout import Readout
from polhode.motion.frame import Frame
from polhode.motion.outcomes import OUTCOMES, Outcome, code
from polhode.numbers.conversion import number_value
from polhode.numbers.decimals import strings
from polhode.numbers.number_types import NumberType, Stack, flat, kind_of
from polhode.runs.members import Plan, exact_numbers, refuse_out_of_range
from polhode.runs.options import Options, hindrance_to_refinement
from polhode.runs.solve import solve
from polhode.scenes.scene import Scene
from polhode.taylor import batches
from polhode.taylor.batches import BatchJob, Solved

# --- results --------------------------------------------------------------------------------------
#
# What became of the members of a sweep: put together, and as arrays that a file keeps.


def no_states(number: NumberType, shape: tuple[int, ...]) -> Stack:
    """States of this shape, none of them a number."""
    if number.flat:
        return flat(np.full(shape, np.nan, kind_of(number)))
    from polhode.numbers.mpmath_context import mpmath, ordinary

    return np.full(shape, ordinary(mpmath.nan), dtype=object)


def none_of(number: NumberType, members: int, times: int, columns: int) -> Solved:
    """Nothing done yet."""
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
    told = json.loads(str(held["errors"]))
    return Solved(
        flat(held["states"]) if number.flat else _numbers(held["states"], number),
        np.array([code(Outcome(text)) for text in held["outcomes"].tolist()], dtype=np.uint8),
        np.asarray(held["steps"], dtype=np.int64),
        np.array([Fraction(text) for text in held["reached"].tolist()], dtype=object),
        None if told is None else [None if x is None else tuple(x) for x in told],
    )


def _numbers(texts: npt.NDArray[np.generic], number: NumberType) -> Stack:
    found = no_states(number, texts.shape)
    for index in np.argwhere(texts != "nan"):
        found[tuple(index)] = number_value(Fraction(str(texts[tuple(index)])), number)
    return found


# --- flat members ---------------------------------------------------------------------------------
#
# Members of a sweep in double or extended: steps of many at a time, read in the scene's axes.


@dataclass(frozen=True, eq=False)
class Reader:
    """Reads rows of some members in scene axes and units: plain data, to be sent anywhere.

    ``bodies``: members that have principal axes and a unit of time in common, with a scene of such
    axes; none where axes need no turn.  ``exponents``: of their units of time.
    """

    number: NumberType
    exponents: npt.NDArray[np.int64]
    bodies: tuple[tuple[npt.NDArray[np.int64], Scene], ...]

    def states(self, rows: Stack) -> Stack:
        """States, not a number where a member did not come; of flat types, where rows were.

        ``rows``: (members, times, columns) inside the members' frames.
        """
        states = flat(rows)
        for alike, one in self.bodies:  # one readout reads all of them
            frame = Frame(one.body.axes, int(self.exponents[alike[0]]))
            at = np.zeros(rows.shape[:2], dtype=bool)
            at[alike] = ~np.isnan(rows[alike, :, 0])
            if at.any():
                states[at] = flat(Readout(one, self.number, frame).states(flat(rows[at])))
        if not self.bodies and self.exponents.any():
            states[:, :, :3] = np.ldexp(states[:, :, :3], -self.exponents[:, None, None])
        return states


def reader(plan: Plan, members: npt.NDArray[np.int64]) -> Reader:
    """What reads the rows of some members of a sweep."""
    exponents, base = plan.tables.exponents[members], plan.members.scene
    stay = plan.members.axes_stay
    if stay and base.body.axes.trivial:  # a reading knows the axes alone
        return Reader(plan.number, exponents, ())
    which = [exponents, *([] if stay else plan.bodies(members))]
    _, first, alike = np.unique(
        np.stack(which, axis=1), axis=0, return_index=True, return_inverse=True
    )
    own = [base if stay else plan.members[int(members[k])] for k in first]
    bodies = tuple(
        (np.flatnonzero(alike.ravel() == n), replace(one, form="principal"))
        for n, one in enumerate(own)
    )
    return Reader(plan.number, exponents, bodies)


class FlatJob(NamedTuple):
    """Members, and what reads their rows."""

    steps: BatchJob
    read: Reader

    def solved(self, stop: Stop | None = None) -> Solved:
        """What became of the members, in the scene's axes and units; ``stop`` ends it sooner."""
        solved = batches.solve(self.steps, stop)
        return replace(solved, states=self.read.states(solved.states))


def flat_job(plan: Plan, group: npt.NDArray[np.int64]) -> FlatJob:
    """The job of some members, which have a unit of time in common or are sure to arrive."""
    return FlatJob(plan.job(group), reader(plan, group))


# --- wide members ---------------------------------------------------------------------------------
#
# Members of a sweep in quad or mp: each by itself, as a single run is solved.


class WideJob(NamedTuple):
    """Members with their times, to be integrated one after the other."""

    members: tuple[Scene, ...]
    number: NumberType
    options: Options

    def solved(self, stop: Stop | None = None) -> Solved:
        """What became of the members, in the scene's axes and units; ``stop`` ends it sooner."""

        def heard(*_: object) -> None:
            if stop is not None and stop():
                raise KeyboardInterrupt  # the run's own way to be stopped

        number, (first, *_) = self.number, self.members
        found = none_of(number, len(self.members), len(first.times), len(first.columns))
        errors = found.errors = [None] * len(self.members)
        for k, member in enumerate(self.members):
            if stop is not None and stop():
                break
            method = _method(member, number, self.options)
            run = solve(member, number, self.options._replace(method=method), heard)
            if run.outcome is Outcome.INTERRUPTED:
                break
            found.states[k, : len(run.states)] = run.states
            found.outcomes[k], found.steps[k] = code(run.outcome), run.steps
            found.reached[k], errors[k] = run.reached, run.errors
        return found


def wide_job(plan: Plan, group: npt.NDArray[np.int64], method: str) -> WideJob:
    """The job of some members; raises BadInput for one that the number type cannot hold."""

    def ready(index: int) -> Scene:
        member = plan.members[index]
        start, coefficients = exact_numbers(member)
        refuse_out_of_range(plan.members, index, plan.number, [*start, *coefficients.values()])
        return replace(member, times=plan.asked, form="principal")

    options = Options(method, plan.max_steps, False, plan.tolerance)
    return WideJob(tuple(map(ready, group.tolist())), plan.number, options)


def _method(member: Scene, number: NumberType, options: Options) -> str:
    """The method of a member: that which was named, where it serves."""
    named = options.method == "refined"
    return (
        "taylor" if named and hindrance_to_refinement(member, number, options) else options.method
    )

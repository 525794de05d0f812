"""State, attitude and angles of a run at any time: its own rows, or rows made when asked for."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

from polhode.common.errors import BadInput, plain
from polhode.motion.outcomes import Outcome
from polhode.motion.protocols import Interpolant, RowReader
from polhode.numbers.decimals import shown
from polhode.numbers.exact import sign
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Given, GivenRow, Reread, Row
from polhode.numbers.scalars import AnyNumber, numbers_given
from polhode.runs.methods.taylor import TaylorMotion, system_of
from polhode.runs.problem.options import Options
from polhode.runs.solve import solve
from polhode.runs.trajectory import Trajectory
from polhode.scenes.given_numbers import TIME, reader
from polhode.scenes.scene import Scene
from polhode.taylor import defaults
from polhode.taylor.heyoka import OutOfRange


def at_times(run: Trajectory, what: str, t: AnyNumber | Iterable[AnyNumber]) -> Reread:
    """States, attitude or angles at time t, or rows of them; raises BadInput beyond what was
    reached.

    At a time of the run's outputs they are that row.  psi and phi count whole turns from the start
    on, so they are integrated from there.
    """
    scene = run.scene
    if what != "states" and scene.gamma is None:
        raise BadInput(scene.name, "start.gamma", None, f"a unit vector, for {what}")
    given, several = numbers_given(t)
    asked = [_time(run, x) for x in given]
    own: Given | None = getattr(run, what)
    rows: dict[Fraction, Any] = {}
    if own is not None:
        rows |= {x: own[k] for x in asked if (k := _place(run, x)) is not None}
    others = sorted({x for x in asked if x not in rows}, key=abs)
    if others:
        rows |= zip(others, _rows(run, what, others), strict=True)
    found = [rows[x] for x in asked]
    return found if several else found[0]


def made_again(run: Trajectory, scene: Scene, *, interruptible: bool = True) -> Trajectory:
    """A run of its own scene, or of that with other outputs, as it was made."""
    return solve(scene, run.number, _options(run), interruptible=interruptible)


def _options(run: Trajectory) -> Options:
    """How a run was made; one that steps did not bring to the end ends soon after it did."""
    every = None if run.projection is None else run.projection.every
    tolerance = None if run.at_full_tolerance else Fraction(run.tolerance)
    most = None
    if run.method == "taylor" and run.outcome in (Outcome.STEP_LIMIT, Outcome.INTERRUPTED):
        most = run.steps + defaults.of(run.number).chunk  # the last may have gone uncounted
    return Options(run.method, most, every or False, tolerance, None, run.digits)


def _rows(run: Trajectory, what: str, times: list[Fraction]) -> Sequence[GivenRow]:
    """Rows at times of which none is one of the run's own, in the order of the motion."""
    rows: Sequence[GivenRow]
    if what != "states" and run.method == "refined":
        again = made_again(run, _asked(run, what, times), interruptible=False)
        rows, outcome, reached = getattr(again, what), again.outcome, again.reached
    else:
        motion = _motion(run, what)
        try:
            raw, outcome, reached = motion.at(times)
        except OutOfRange as fault:
            told = f"a time that {run.number.name} holds ({fault})"
            raise BadInput(run.scene.name, "t", shown(times[0]), told) from None
        rows = [_read(motion.read, what, row) for row in raw]
    if len(rows) < len(times):  # angles are singular where the state is not
        expected = f"a time at which there are {what}; {outcome.cause} at t = {shown(reached)}"
        raise BadInput(run.scene.name, "t", shown(times[len(rows)]), expected)
    return rows


def _read(read: RowReader, what: str, row: Row) -> GivenRow:
    """A motion's row as states, attitude or angles."""
    states = read.states([row])
    if what == "states":
        return states[0]
    found = read.attitude([row], states) if what == "attitude" else read.angles([row], states)
    assert found is not None
    return found[0]


def _motion(run: Trajectory, what: str) -> Interpolant:
    """What tells rows of this kind: the run's own motion, or one with it to the same time."""
    if what == "states" or (run.dense is not None and what in run.scene.modelled):
        if run.dense is None:
            raise ValueError("states at the output times only: nothing was integrated here")
        return run.dense
    if what not in run.others:
        scene, options = _asked(run, what, run.times), _options(run)
        system = system_of(scene, run.number, options.tolerance)
        motion = TaylorMotion(system, scene, options)
        motion.reached = run.reached
        run.others[what] = motion
    return run.others[what]


def _asked(run: Trajectory, what: str, times: Sequence[Fraction]) -> Scene:
    """The scene of a run with one output, without events."""
    return replace(run.scene, outputs=(what,), events=(), times=tuple(times))


def _place(run: Trajectory, t: Fraction) -> int | None:
    """The place of a time among the run's own."""
    k = bisect_left(run.times, abs(t), key=abs)
    return k if k < len(run.times) and run.times[k] == t else None


def _time(run: Trajectory, t: object) -> Fraction:
    """A time that was reached, exact, or to far more bits than a row has."""
    reach = f"a time from 0 to {shown(run.reached)}, what the run reached"
    try:
        exact = reader(run.scene.units, TIME)(t)
    except ValueError:
        raise BadInput(run.scene.name, "t", plain(t), reach) from None
    if sign(exact) * sign(run.reached) < 0 or sign(abs(exact) - abs(run.reached)) > 0:
        raise BadInput(run.scene.name, "t", shown(exact), reach)
    if isinstance(exact, Fraction):
        return exact
    return NumberType("mp", 2 * run.number.bits + 128).rounded(exact)

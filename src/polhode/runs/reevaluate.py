"""Angles and attitude of a run at other times: the run made once more, asked at those."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction

from polhode.common.errors import BadInput, plain
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact, binary, rounded, sign
from polhode.numbers.rows import Reread
from polhode.numbers.scalars import AnyNumber, numbers_given
from polhode.runs.problem.options import Options
from polhode.runs.solve import solve
from polhode.runs.trajectory import Trajectory
from polhode.scenes.given_numbers import TIME, reader
from polhode.scenes.scene import Scene

NEAR = 400  # bits to which times are told apart


def at_times(run: Trajectory, what: str, t: AnyNumber | Iterable[AnyNumber]) -> Reread:
    """Angles or attitude at time t, or rows of them; raises BadInput beyond what was reached.

    psi and phi count whole turns from the start on, so they are integrated from there.
    """
    scene = run.scene
    if scene.gamma is None:
        raise BadInput(scene.name, "start.gamma", None, f"a unit vector, for {what}")
    given, several = numbers_given(t)
    asked = [_time(run, x) for x in given]
    if not asked:
        return []
    near = [abs(binary(*rounded(x, NEAR))) for x in asked]
    distinct = dict(sorted(zip(near, asked, strict=True), key=lambda pair: pair[0]))
    events = tuple(event for event in scene.events if event.stop)
    times = tuple(distinct.values())
    changed = replace(scene, outputs=(what,), events=events, times=times)
    again = made_again(run, changed, interruptible=False)
    if len(again.times) < len(times):  # angles are singular where the state is not
        expected = f"a time at which there are {what}; {again.outcome.cause}"
        at = f"t = {shown(again.reached)}"
        raise BadInput(scene.name, "t", shown(times[len(again.times)]), f"{expected} at {at}")
    rows = dict(zip(distinct, getattr(again, what), strict=True))
    found = [rows[x] for x in near]
    return found if several else found[0]


def made_again(run: Trajectory, scene: Scene, *, interruptible: bool = True) -> Trajectory:
    """A run of its own scene, or of that with other outputs, as it was made."""
    every = None if run.projection is None else run.projection.every
    tolerance = None if run.at_full_tolerance else Fraction(run.tolerance)
    options = Options(run.method, None, every or False, tolerance, None, run.digits)
    return solve(scene, run.number, options, interruptible=interruptible)


def _time(run: Trajectory, t: object) -> Exact:
    reach = f"a time from 0 to {shown(run.reached)}, what the run reached"
    try:
        exact = reader(run.scene.units, TIME)(t)
    except ValueError:
        raise BadInput(run.scene.name, "t", plain(t), reach) from None
    if sign(exact) * sign(run.reached) < 0 or abs(exact) > abs(run.reached):
        raise BadInput(run.scene.name, "t", shown(exact), reach)
    return exact

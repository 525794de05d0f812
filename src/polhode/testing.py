"""For test suites of other programs: correct digits, and orders of convergence."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from polhode.common.arguments import each, of_kind
from polhode.common.errors import BadInput
from polhode.judging.compare import compare, refuse_incomplete
from polhode.judging.convergence_order import ObservedOrder, observed_order
from polhode.judging.judgement import Judgement
from polhode.numbers.conversion import exact_number, to_double
from polhode.numbers.decimals import brief
from polhode.numbers.number_types import AnyNumber, AnyVector
from polhode.runs.trajectory import Trajectory
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import REQUESTS

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


def assert_digits(
    mine: Trajectory
    | str
    | Path
    | Iterable[AnyVector]
    | Mapping[str, AnyVector]
    | pd.DataFrame
    | xr.Dataset
    | Callable[[float], AnyVector],
    scene: Scene | str | Path,
    at_least: float,
    *,
    at: Iterable[AnyNumber] | None = None,
    number: str | None = None,
    columns: Sequence[str] | None = None,
    as_it_stands: bool = True,
    told: Callable[[Judgement], None] | None = None,
) -> Judgement:
    """Judge a trajectory, and fail if it has fewer correct digits than ``at_least``.

    Parameters
    ----------
    mine : Trajectory, str, Path, mapping, DataFrame, Dataset, rows or callable
        What :func:`polhode.compare` judges; or a function from t to a row of numbers, which is
        called at the times ``at``.  States are p q r gamma1 gamma2 gamma3 in the scene's body axes
        and units.
    scene : Scene, str or Path
        A scene, a path, or the name of a case.
    at_least : float
        The correct digits that every part must have at every time.
    at : iterable of numbers, optional
        The times of rows or of a function, in the scene's unit; of a function by default the
        scene's.
    number : str, optional
        The number type to which the numbers were rounded.
    columns : sequence of str, optional
        The columns of rows; by default those of the scene.
    as_it_stands : bool
        False: other conventions than the scene's are allowed.
    told : callable, optional
        Called with the judgement before digits are demanded of it.

    Returns
    -------
    Judgement
        The digits of each part at each time.

    Raises
    ------
    AssertionError
        Too few digits: the message shows the first such time, and the judgement.
    BadInput
        Input that cannot be judged, or in which a number that is to be judged is missing: a cell
        that is empty or not a number, or a component of a vector.

    Examples
    --------

    >>> run = polhode.integrate("lagrange/nutation")
    >>> polhode.testing.assert_digits(run, "lagrange/nutation", at_least=12).worst > 12
    True
    >>> polhode.testing.assert_digits(lambda t: run(t) + 1e-6, "lagrange/nutation", 9, at=[1, 2])
    Traceback (most recent call last):
    ...
    AssertionError: 6.00 correct digits at t = 1, where at least 9 are wanted
    ...
    """
    __tracebackhide__ = True  # pytest shows the user's line, not this function's
    of_kind("assert_digits", "at_least", at_least, (int, float), "a number of digits")
    at_least = float(at_least) if isinstance(at_least, float) else to_double(at_least)
    if math.isnan(at_least):
        raise BadInput("assert_digits", "at_least", at_least, "a number of digits")
    scene = library.load(scene, takes=REQUESTS)
    if callable(mine) and not isinstance(mine, Trajectory):
        times = scene.times if at is None else at
        moments = each("assert_digits", "at", times, exact_number, "a list of times")
        if not moments:
            raise BadInput(scene.name, "at", None, "times at which the function is called")
        held = [*map(to_double, moments)]
        mine, at = [mine(t) for t in held], held
    try:
        judgement = compare(
            mine, scene, number=number, at=at, columns=columns, as_it_stands=as_it_stands
        )
        refuse_incomplete(judgement)
    except BadInput as fault:
        raise fault.with_traceback(None) from None
    if told is not None:
        told(judgement)
    rows = [d for d in judgement.part_digits.values() if d]
    for k, t in enumerate(judgement.times):
        here = min((x for d in rows if (x := d[k]) is not None), default=at_least)
        if not here >= at_least:  # nor where that is nan
            few = f"{here:.2f} correct digits at t = {brief(t)}, where at least {at_least:g}"
            raise AssertionError(f"{few} are wanted\n{judgement}")
    return judgement


def order_of(
    mine: Callable[[float], Iterable[AnyVector]],
    scene: Scene | str | Path,
    steps: Sequence[AnyNumber] | None = None,
    *,
    at: Iterable[AnyNumber] | None = None,
    columns: Sequence[str] | None = None,
) -> ObservedOrder:
    """Measure the order at which an integrator converges to the exact motion.

    Parameters
    ----------
    mine : callable
        A function from a step size to rows of numbers, one for each of the times ``at``: p q r
        gamma1 gamma2 gamma3 in the scene's body axes and units.
    scene : Scene, str or Path
        A scene, a path, or the name of a case.
    steps : sequence of numbers, optional
        Three or more step sizes; by default from 1/32 to 1/2048 of the time.
    at : iterable of numbers, optional
        The times, in the scene's unit; by default the scene's last.
    columns : sequence of str, optional
        The columns of the rows; by default those of the scene.

    Returns
    -------
    ObservedOrder
        The order, and the digits at each step.  Steps with a wrong first digit, or at which
        rounding dominates, do not count: ``left_out`` has the latter.

    Raises
    ------
    BadInput
        Fewer than three steps that count, or two where rounding limits the others.

    Examples
    --------

    >>> f = polhode.field("kovalevskaya/generic")
    >>> def midpoint(h):
    ...     y = f.start
    ...     for _ in range(round(1 / h)):
    ...         y = y + h * f(0, y + h / 2 * f(0, y))
    ...     return [y]
    >>> found = polhode.testing.order_of(midpoint, "kovalevskaya/generic", at=[1])
    >>> 1.9 < found.least <= found.order <= found.most < 2.1
    True
    """
    if not callable(mine):
        raise BadInput("order_of", "mine", mine, "a function from a step to rows")
    return observed_order(mine, library.load(scene, takes=REQUESTS), steps, at, columns)

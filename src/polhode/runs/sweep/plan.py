"""A sweep, checked before anything is integrated: its members in numbers of one type."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from polhode.common.arguments import unit_rows
from polhode.common.errors import BadInput
from polhode.common.values import cached_property, refuse_too_much
from polhode.numbers.conversion import number_value
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Flat, kind_of
from polhode.numbers.scalars import AnyNumber
from polhode.runs.problem.options import (
    choose_number,
    refuse_other_rounding,
    rounded_tolerance,
)
from polhode.runs.sweep.columns import Fastest, columns_of
from polhode.scenes.scene import Scene
from polhode.scenes.variation import vary
from polhode.scenes.variation.sweep_scenes import Members
from polhode.taylor import defaults
from polhode.taylor.time_grid import rounded_times

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from polhode.taylor.batches import Columns

_BYTES = 40  # of a number of the states, while they are gathered and written


@dataclass(frozen=True, eq=False)
class Plan:
    """A sweep, checked: what there is to integrate.

    ``motions``: the members in numbers, none above extended.  ``exponents``: of each
    member's unit of time, a power of two; ``rates``: its fastest rate at most, radians for each
    unit of the scene's time; both 0 above extended.
    """

    varied: vary.Grid
    members: Members
    number: NumberType
    tolerance: Fraction | None
    max_steps: int
    times: tuple[Fraction, ...]
    asked: Sequence[Exact]
    names: tuple[str, ...]
    motions: Columns
    exponents: npt.NDArray[np.int64]
    rates: npt.NDArray[np.float64]

    @cached_property
    def grid(self) -> Flat:
        """The times as numbers of the type, of one that numpy holds."""
        import numpy as np

        times = [number_value(t, self.number) for t in self.times]
        return np.array(times, dtype=kind_of(self.number))

    def bodies(self, members: npt.NDArray[np.int64]) -> list[npt.NDArray[np.int64]]:
        """Of some members which value of each of the body's keys they have: arrays, one a key."""
        rows = self.varied.rows
        each = zip(self.varied.keys, rows.columns, rows.repeats, strict=True)
        return [members // n % len(x) for key, x, n in each if key.startswith("body.")]

    def groups(self, size: int, most: int) -> Iterator[npt.NDArray[np.int64]]:
        """The members in groups of one unit of time and about the same rate.

        Each is a multiple of ``size`` members but the last of a unit; about ``most`` groups.
        """
        import numpy as np

        size *= max(1, -(-len(self.rates) // (size * most)))
        order = np.lexsort((-self.rates, self.exponents))
        ends = np.flatnonzero(np.diff(self.exponents[order])) + 1
        for alike in np.split(order, ends):
            yield from (alike[i : i + size] for i in range(0, len(alike), size))


def planned(
    scene: Scene,
    given: vary.Vary,
    number: str | NumberType | None,
    digits: int | None,
    tol: AnyNumber | None,
    max_steps: int | None,
    kept: bool = True,
) -> Plan:
    """The plan of a sweep, see :func:`polhode.integrate_many`; raises BadInput.

    ``kept``: whether the states of all members are held at once.
    """
    import numpy as np

    from polhode.taylor.batches import Columns

    refuse_other_rounding(scene)
    if scene.events:
        expected = "none in a sweep: a step size of its own for each event; run members singly"
        raise BadInput(scene.name, "events", scene.events[0].name, expected)
    varied = vary.grid(given, scene.name, scene.units)
    numbers = (len(varied.rows) if kept else 1) * len(scene.times) * len(scene.columns)
    what = f"{len(varied.rows)} members at {len(scene.times)} times"
    words = "numbers of states; fewer samples, or split the sweep"
    refuse_too_much(scene.name, "vary", what, numbers, _BYTES, words)
    members = Members(scene, varied)
    _ = members.tables  # a key that is none is refused before anything else
    chosen = choose_number(scene, number, None)
    if digits is not None and len(members):
        chosen = choose_number(Fastest(members).scene.at(scene.times), number, digits)
    _check_arrays(scene.name, varied, chosen)
    times = tuple(rounded_times(scene, chosen))
    tolerance = rounded_tolerance(scene, chosen, tol)

    if chosen.flat:
        names, motions, units, rates = columns_of(members, times, chosen)
    else:
        names, motions = (), Columns(np.empty((0, 0)), np.empty((0, 0)))
        units, rates = np.zeros(len(members), dtype=np.int64), np.zeros(len(members))
    limit = max_steps if max_steps is not None else defaults.of(chosen).max_steps
    return Plan(
        varied, members, chosen, tolerance, limit, times, scene.times, names, motions, units, rates
    )


def _check_arrays(name: str, varied: vary.Grid, number: NumberType) -> None:
    """Refuse arrays that are not of the run's number type; raises BadInput.

    Gamma is of length 1 to 8 eps of it.
    """
    import numpy as np

    each = zip(varied.keys, varied.rows.columns, strict=True)
    arrays = {key: column.floats for key, column in each if column.floats is not None}
    if not arrays:
        return
    if not number.flat:
        expected = "double or extended with arrays; other values, or members one by one, are exact"
        raise BadInput(name, "number", number.name, expected)
    for key, values in arrays.items():
        if number.name == "double" and values.dtype.itemsize > 8:
            raise BadInput(name, key, f"numbers of {values.dtype}", "float64, or number = extended")
    gamma = [arrays[key] for key in arrays if key.startswith("start.gamma")]
    if len(gamma) == 3:
        unit_rows(name, "start.gamma", np.stack(gamma, axis=1), number.eps)

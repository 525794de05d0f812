"""A sweep, checked before anything is integrated: its members in numbers of one type."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from polhode.common.errors import BadInput
from polhode.equations.forms import principal
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import NumberType
from polhode.runs.request import choose_number, rounded_times, rounded_tolerance
from polhode.scenes import vary
from polhode.scenes.scene import Scene
from polhode.taylor import policy

if TYPE_CHECKING:
    from polhode.taylor.batches import Lane

MAX_NUMBERS = 10**8  # in all states together: 0.8 GB of doubles


@dataclass(frozen=True)
class Plan:
    """A sweep, checked: what there is to integrate."""

    varied: vary.Grid
    members: tuple[Scene, ...]
    number: NumberType
    tolerance: Fraction | None
    max_steps: int
    times: tuple[Fraction, ...]
    asked: tuple[Exact, ...]
    names: tuple[str, ...]
    lanes: tuple[Lane, ...]


def planned(
    scene: Scene,
    given: vary.Vary,
    number: str | NumberType | None,
    digits: int | None,
    tol: Any,
    max_steps: int | None,
) -> Plan:
    """The plan of a sweep, see :func:`polhode.integrate_many`; raises BadInput."""
    if scene.events:
        expected = "none in a sweep: a step size of its own for each event; run members singly"
        raise BadInput(scene.name, "events", scene.events[0].name, expected)
    varied = vary.grid(given, scene.name)
    numbers = len(varied.rows) * len(scene.times) * len(scene.columns)
    if numbers > MAX_NUMBERS:
        what = f"{len(varied.rows)} members at {len(scene.times)} times"
        expected = f"at most {MAX_NUMBERS} numbers of states; fewer samples, or split the sweep"
        raise BadInput(scene.name, "vary", what, expected)
    members = vary.members(scene, varied)
    chosen = choose_number(scene, number, None)
    if digits is not None:
        fastest = max(members, key=lambda member: member.log10_rate)
        chosen = choose_number(fastest.at(scene.times), number, digits)
    times = tuple(rounded_times(scene, chosen))
    tolerance = rounded_tolerance(scene, chosen, tol)

    names, lanes = _lanes(members, times[-1], chosen)
    limit = max_steps if max_steps is not None else policy.of(chosen).max_steps
    return Plan(varied, members, chosen, tolerance, limit, times, scene.times, names, lanes)


def _lanes(
    members: Sequence[Scene], end: Fraction, number: NumberType
) -> tuple[tuple[str, ...], tuple[Lane, ...]]:
    """The names of all coefficients that any member has, and each member in numbers of a type."""
    from polhode.taylor import batches, heyoka_numbers

    bodies: dict[tuple[int, int], dict[str, Exact]] = {}
    for member in members:
        key = id(member.body), member.time_unit  # members share their bodies
        if key not in bodies:
            bodies[key] = principal.coefficients(member.body, member.time_unit)
    names = tuple(sorted(set().union(*bodies.values())))
    known: dict[int, tuple[Exact, Fraction]] = {}  # they share most of their numbers, too

    def typed(x: Exact) -> Fraction:
        if id(x) not in known:
            heyoka_numbers.scalar(x, number)
            known[id(x)] = x, number.rounded(x)
        return known[id(x)][1]

    lanes = []
    for member in members:
        unit, axes = Fraction(2) ** member.time_unit, member.body.axes
        k = bodies[id(member.body), member.time_unit]
        try:
            heyoka_numbers.scalar(end / unit, number)
            start = [typed(unit * w) for w in axes.components(member.omega)]
            if member.gamma is not None:
                start += [typed(g) for g in axes.components(member.gamma)]
            coefficients = [typed(k[name]) if name in k else Fraction(0) for name in names]
        except heyoka_numbers.OutOfRange as fault:
            expected = f"a type of wider range ({fault})"
            raise BadInput(member.name, "number", number.name, expected) from None
        lanes.append(batches.Lane(tuple(coefficients), tuple(start), member.time_unit))
    return names, tuple(lanes)

"""The members of a sweep, as columns of numbers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from polhode.common.arguments import unit_rows
from polhode.common.errors import BadInput
from polhode.common.values import Recent, cached_property, refuse_too_much
from polhode.equations.forms import principal
from polhode.equations.terms import NAMES, coefficients_of
from polhode.motion.frame import Frame
from polhode.numbers.conversion import number_value, to_double
from polhode.numbers.double_double import Pairs, pairs
from polhode.numbers.exact import ZERO, Exact
from polhode.numbers.number_types import (
    AnyNumber,
    Booleans,
    Doubles,
    Flat,
    NumberType,
    Scalar,
    kind_of,
)
from polhode.numbers.row_formulas import Rationals
from polhode.numbers.vectors import scaled
from polhode.runs.options import choose_number, refuse_other_rounding, rounded_tolerance
from polhode.scenes import vary
from polhode.scenes.body import PrincipalAxes
from polhode.scenes.members import Members
from polhode.scenes.scene import Scene
from polhode.taylor import defaults, lanes
from polhode.taylor.time_grid import rounded_times

if TYPE_CHECKING:
    from polhode.scenes.members import Block, Vector
    from polhode.taylor.batches import BatchJob, Columns


# --- plan -----------------------------------------------------------------------------------------
#
# A sweep, checked before anything is integrated: its members in numbers of one type.


_BYTES = 40  # of a number of the states, while they are gathered and written


@dataclass(frozen=True, eq=False)
class Plan:
    """A sweep, checked: what there is to integrate.

    ``motions``: the members in numbers, none above extended.  ``exponents``: of each
    member's unit of time, a power of two; ``rates``: its fastest rate at most, radians for each
    unit of the scene's time; both 0 above extended.
    """

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
    def steps(self) -> BatchJob:
        """The job of all members, of a type that numpy holds."""
        from polhode.taylor import lanes
        from polhode.taylor.batches import BatchJob

        grid = np.array([number_value(t, self.number) for t in self.times], kind_of(self.number))
        how = self.names, self.number, self.tolerance, self.max_steps, grid, Fraction(1)
        job = BatchJob(*how, self.motions, exponents=self.exponents)
        return job._replace(sure=lanes.surely(job, float(self.rates.max(initial=0.0))))

    def bodies(self, members: npt.NDArray[np.int64]) -> list[npt.NDArray[np.int64]]:
        """Of some members which value of each of the body's keys they have: arrays, one a key."""
        varied = self.members.varied
        rows = varied.rows
        each = zip(varied.keys, rows.columns, rows.repeats, strict=True)
        return [members // n % len(x) for key, x, n in each if key.startswith("body.")]

    def groups(self, size: int, most: int, mixed: bool = False) -> Iterator[npt.NDArray[np.int64]]:
        """The members in groups of about the same rate, and of one unit of time if not ``mixed``.

        Each is a multiple of ``size`` members but the last of a unit; about ``most`` groups.
        """
        size *= max(1, -(-len(self.rates) // (size * most)))
        units = self.exponents
        if mixed or (len(units) and (units == units[0]).all()):
            order = (-self.rates).argsort(kind="stable")
            alike = [order]
        else:
            order = np.lexsort((-self.rates, units))
            alike = np.split(order, np.flatnonzero(np.diff(units[order])) + 1)
        for members in alike:
            yield from (members[i : i + size] for i in range(0, len(members), size))


def planned(
    scene: Scene,
    varied: vary.Grid,
    number: str | NumberType | None,
    digits: int | None,
    tol: AnyNumber | None,
    max_steps: int | None,
    kept: bool = True,
) -> Plan:
    """The plan of a sweep, see :func:`polhode.integrate_many`; raises BadInput.

    ``kept``: whether the states of all members are held at once.
    """
    from polhode.taylor.batches import Columns

    refuse_other_rounding(scene)
    if scene.events:
        expected = "none in a sweep: a step size of its own for each event; run members singly"
        raise BadInput(scene.name, "events", scene.events[0].name, expected)
    members = Members(scene, varied)
    count = len(members)
    numbers = (count if kept else 1) * len(scene.times) * len(scene.columns)
    what = f"{count} members at {len(scene.times)} times"
    words = "numbers of states; fewer samples, or split the sweep"
    refuse_too_much(scene.name, "vary", what, numbers, _BYTES, words)
    _ = members.tables  # a key that is none is refused before anything else
    chosen = choose_number(scene, number, None)
    if digits is not None and count:
        chosen = choose_number(fastest(members).at(scene.times), number, digits)
    if members.arrays:
        _check_arrays(members, chosen)
    times = tuple(rounded_times(scene, chosen))
    tolerance = rounded_tolerance(scene, chosen, tol)

    if chosen.flat:
        names, motions, units, rates = columns_of(members, times, chosen)
    else:
        names, motions = (), Columns(np.empty((0, 0)), np.empty((0, 0)))
        units, rates = np.zeros(count, dtype=np.int64), np.zeros(count)
    limit = max_steps if max_steps is not None else defaults.of(chosen).max_steps
    return Plan(members, chosen, tolerance, limit, times, scene.times, names, motions, units, rates)


def _check_arrays(members: Members, number: NumberType) -> None:
    """Refuse arrays that are not of the run's number type; raises BadInput.

    Gamma is of length 1 to 8 eps of it.
    """
    name, arrays = members.scene.name, members.arrays
    if not number.flat:
        expected = "double or extended with arrays; other values, or members one by one, are exact"
        raise BadInput(name, "number", number.name, expected)
    for key, values in arrays.items():
        if number.name == "double" and values.dtype.itemsize > 8:
            raise BadInput(name, key, f"numbers of {values.dtype}", "float64, or number = extended")
    if members.given_as_array("start.gamma"):
        gamma = np.array([arrays[f"start.gamma[{i}]"] for i in (1, 2, 3)])
        unit_rows(name, "start.gamma", gamma.T, number.eps)


# --- columns --------------------------------------------------------------------------------------
#
# The members of a sweep as the integrator takes them: starts, coefficients, units of time.
#
# In columns (:mod:`polhode.scenes.members`) where they can be, else member by
# member. Starts that are given as arrays go as they are. Other numbers are rounded once, from
# exact ones or from pairs of doubles: to a hundred bits a number tells which one of the type is
# the nearest, but for one in 2**40.


#: Numbers of all members, pairs too, or one that they have in common.
Numbers: TypeAlias = Scalar

_NEXT_POWER = 1 - 2.0**-9  # from this part of a power of two on, eight bits round to it
_UNSURE = 1e-9  # of that, in doubles
_SMALLEST, _LARGEST = 2.0**-1022, 2.0**1023
_LEAST, _MOST = 2.0**-400, 2.0**400  # between these pairs, and their quotients, hold all bits
_SIZES = 2.0**-1000, 2.0**1000  # of a rate
_CANCELLED = 2.0**-20  # of a sum's terms: what is less has lost bits


def columns_of(
    members: Members, times: Sequence[Fraction], number: NumberType
) -> tuple[tuple[str, ...], Columns, npt.NDArray[np.int64], npt.NDArray[np.float64]]:
    """Coefficients' names, columns, units of time (exponents of two) and rates of all members.

    The rates are bounds, by the members' energy, in radians for each unit of the scene's time.
    ``times``: away from 0.  ``number``: double or extended.  Raises BadInput for a member, or a
    time in a member's unit, that it cannot hold.
    """
    from polhode.taylor.batches import Columns

    tables = _Tables(members, number)
    for block in members.blocks():
        left = tables.fill(block)
        if left.any():
            tables.alike = False
            for k in np.flatnonzero(left):
                tables.put(block, int(k))
    exponents = tables.exponents
    ends = [*[t for t in times if t][:1], times[-1]]  # the least and the largest that are not 0
    extremes = [(exponents.min(initial=0), exponents.max(initial=0))]
    with np.errstate(all="ignore"):
        sizes = np.ldexp([[to_double(t)] for t in ends], -np.array(extremes))
    if _out_of_range(sizes).any():
        for exponent, first in zip(*np.unique(exponents, return_index=True), strict=True):
            own = [t / Fraction(2) ** int(exponent) for t in ends]
            refuse_out_of_range(members, int(first), number, own)
    coefficients = tables.coefficients
    if tables.alike and extremes[0][0] == extremes[0][1]:  # one row serves all
        coefficients = coefficients[:1]
    present = np.flatnonzero((coefficients != 0).any(axis=0)).tolist()
    present.sort(key=NAMES.__getitem__)
    columns = Columns(coefficients.take(present, axis=1), tables.starts)
    return tuple(NAMES[i] for i in present), columns, exponents, tables.rates


def fastest(members: Members) -> Scene:
    """The member of a sweep that turns fastest at the start."""
    rate, scene = -1.0, members[0]
    for block in members.blocks():
        with np.errstate(all="ignore"):
            fourth = _fourth(block)
        left = block.left | ~np.isfinite(fourth)  # doubles do not tell
        fourth = np.where(left, -1.0, fourth)
        k = int(np.argmax(fourth))
        others = [block.first + int(i) for i in np.flatnonzero(left)]
        for index in [block.first + k] * bool(fourth[k] >= 0) + others:
            member = members[index]
            if member.log10_rate > rate or index == 0:
                rate, scene = member.log10_rate, member
    return scene


class _Body(NamedTuple):
    """The body that all members have: its coefficients, and what bounds their rates."""

    coefficients: Flat
    bound: lanes.Bound

    @classmethod
    def of(cls, scene: Scene, number: NumberType) -> _Body:
        """The body of a scene, in the scene's unit of time."""
        body = scene.body
        torque = body.axes.components(body.torque)
        exact = coefficients_of([*body.moments, *torque])
        coefficients = np.array([number_value(x, number) for x in exact], kind_of(number))
        return cls(coefficients, _bound(body.moments, torque))


_bodies: Recent[_Body] = Recent(4)


class _Tables:
    """Starts, coefficients, units of time and rates of all members, filled block by block.

    ``alike``: whether all members have the coefficients of the scene, but for their units of time.
    """

    def __init__(self, members: Members, number: NumberType) -> None:
        count, kind = len(members), kind_of(number)
        self.members, self.number, self.alike = members, number, members.same_body
        self.coefficients: Flat = np.zeros((count, len(NAMES)), kind, order="F")
        self.starts: Flat = np.zeros((count, len(members.scene.columns)), kind)
        self.exponents = np.zeros(count, dtype=np.int64)
        self.rates = np.zeros(count)

    def fill(self, block: Block) -> npt.NDArray[np.bool_]:
        """Put a block of members in; which of them are left."""
        here = slice(block.first, block.last)
        starts, coefficients = self.starts[here], self.coefficients[here]
        with np.errstate(all="ignore"):
            try:
                exponents, unsure = _exponents(block)
                torque, *start = (
                    _along(vector, block.axes, unsure)
                    for vector in (block.torque, block.omega, block.gamma)
                    if vector is not None
                )
                self._put(starts, [x for vector in start for x in vector])
                if self.members.same_body:
                    scene, number = self.members.scene, self.number
                    body = _bodies.get(scene.identity, number, lambda: _Body.of(scene, number))
                    coefficients[:], bound = body
                else:
                    self._put(coefficients, _coefficients(block.moments, torque, unsure))
                    bound = _bound(block.moments, torque)
                self.rates[here] = lanes.rates(starts, bound)
            except (OverflowError, ZeroDivisionError):  # beyond doubles, here or on the way
                return np.ones(len(block), dtype=bool)
            if exponents.any():
                starts[:, :3] = np.ldexp(starts[:, :3], exponents[:, None])
                coefficients[:, 3:] = np.ldexp(coefficients[:, 3:], 2 * exponents[:, None])
            left: npt.NDArray[np.bool_] = block.left | unsure
            for table in (starts, coefficients):
                left |= _out_of_range(table)
        self.exponents[here] = exponents
        return left

    def _put(self, table: Flat, columns: Sequence[Numbers]) -> None:
        """Columns into a table, each number rounded once."""
        for i, column in enumerate(columns):
            if isinstance(column, Exact):
                table[:, i] = number_value(column, self.number)
            elif isinstance(column, np.ndarray):
                table[:, i] = column
            elif isinstance(column, Pairs) or self.number.name != "double":
                near = pairs(column)
                table[:, i] = near.hi
                table[:, i] += near.lo
            else:
                table[:, i] = column.doubles()

    def put(self, block: Block, k: int) -> None:
        """Put a member in by its scene, and by what arrays say of its start."""
        index = block.first + k
        member = self.members[index]
        start, coefficients = exact_numbers(member, block.given_gamma(k))
        refuse_out_of_range(self.members, index, self.number, [*start, *coefficients.values()])
        self.exponents[index] = Frame.of(member).exponent
        self.starts[index] = [number_value(x, self.number) for x in start]
        self.rates[index] = _rate(member, self.starts[index])
        self.coefficients[index] = [
            number_value(coefficients.get(name, ZERO), self.number) for name in NAMES
        ]


def exact_numbers(
    member: Scene, gamma: tuple[Exact, Exact, Exact] | None = None
) -> tuple[list[Exact], dict[str, Exact]]:
    """Start and coefficients of a member inside its frame; ``gamma``: in the place of its own."""
    frame = Frame.of(member)
    inside = frame.inside(member)
    start = [*inside.start]
    if gamma is not None:
        start[3:] = frame.axes.components(gamma)
    return start, principal.coefficients(inside.body)


def refuse_out_of_range(
    members: Members, index: int, number: NumberType, values: Iterable[Exact]
) -> None:
    """Refuse a member's numbers that the type cannot hold; raises BadInput."""
    from polhode.taylor import heyoka

    try:
        for x in values:
            heyoka.scalar(x, number)
    except heyoka.OutOfRange as fault:
        raise fault.refusal(members[index].name, number) from None


def _along(vector: Vector, axes: PrincipalAxes, unsure: Booleans) -> Sequence[Numbers]:
    """Components along principal axes; exact ones where all members have the vector in common.

    ``unsure``: where pairs do not tell them is noted there.
    """
    fixed = [x for x in vector if isinstance(x, Exact)]
    if axes.trivial:
        return vector
    if len(fixed) == 3:
        return axes.components((fixed[0], fixed[1], fixed[2]))
    given = [pairs(_parted(x)) for x in vector]
    found: list[Numbers] = []
    for row in axes.rows:
        a, b, c = (pairs(r) * x for r, x in zip(row, given, strict=True))
        found.append(a + b + c)
        size = np.abs(a.hi) + np.abs(b.hi) + np.abs(c.hi)
        _note(unsure, size, np.abs(found[-1].hi) < _CANCELLED * size)
    return found


def _coefficients(
    moments: Vector, torque: Sequence[Numbers], unsure: Booleans
) -> Sequence[Numbers]:
    """All coefficients; of moments that are floats in pairs, and where those do not tell noted."""
    if not any(isinstance(x, np.ndarray) for x in moments):
        return coefficients_of([*moments, *torque])
    own, arms = ([pairs(_parted(x)) for x in vector] for vector in (moments, torque))
    for x, y in zip(own, (*own[1:], own[0]), strict=True):
        gap = np.abs((x - y).hi)
        _note(unsure, np.abs(x.hi), (gap < _CANCELLED * np.abs(x.hi)) & (gap != 0))
    for x in arms:
        _note(unsure, np.abs(x.hi))
    return coefficients_of([*own, *arms])


def _parted(x: Numbers) -> Numbers:
    """An array's longdoubles as pairs."""
    if not isinstance(x, np.ndarray) or x.dtype == np.float64:
        return x
    high = x.astype(np.float64)
    return Pairs(high, (x - high).astype(np.float64))


def _note(unsure: Booleans, size: Doubles, lost: Booleans | bool = False) -> None:
    """Note where numbers of such sizes are too large or too small for pairs, or have lost bits."""
    unsure |= (size != 0) & (~((size > _LEAST) & (size < _MOST)) | lost)


def _out_of_range(table: Flat) -> Booleans:
    """Which rows have a number that is not 0 and not between a double's limits, or nearly so."""
    sizes = np.abs(table)
    wrong = (sizes < _SMALLEST) & (sizes != 0) | ~(sizes <= _LARGEST)
    rows: Booleans = wrong.any(axis=1)
    return rows


def _bound(moments: Vector, torque: Sequence[Numbers]) -> lanes.Bound:
    """What bounds the rates of members, in the scene's unit of time."""
    inertia, weight = (
        np.stack(np.broadcast_arrays(*map(_doubles, vector)), axis=-1)
        for vector in (moments, torque)
    )
    largest = inertia.max(axis=-1, keepdims=True)
    return lanes.Bound.of(inertia / largest, weight / largest)


def _rate(member: Scene, start: Flat) -> float:
    """A bound of a member's rate by its scene: from its start in its own unit of time.

    One that doubles cannot hold in the scene's is the least or the largest of _SIZES.
    """
    frame = Frame.of(member)
    body = frame.inside(member).body
    part = 1 / max(body.moments)
    inertia, moment = (
        np.array([to_double(x) for x in scaled(part, vector)])
        for vector in (body.moments, body.torque)
    )
    with np.errstate(all="ignore"):
        rate = np.ldexp(lanes.rates(start[None], lanes.Bound.of(inertia, moment)), -frame.exponent)
        least, largest = _SIZES
        return float(np.fmin(np.maximum(rate, least), largest)[0])


def _doubles(x: Numbers) -> Doubles:
    """The doubles next to numbers of all members, or next to one that they have in common."""
    if isinstance(x, np.ndarray):
        return x.astype(np.float64, copy=False)
    if isinstance(x, Rationals):
        return x.doubles()
    return np.asarray(x.hi if isinstance(x, Pairs) else to_double(x))


def _fourth(block: Block) -> Doubles:
    """The fastest rate at the start to the fourth power, as :attr:`Scene.time_unit` means it."""
    vectors = block.omega, block.torque, block.moments
    (p, q, r), (x, y, z), (a, b, c) = (map(_doubles, vector) for vector in vectors)
    square, largest = p**2 + q**2 + r**2, np.maximum(np.maximum(a, b), c)
    fourth = np.maximum(square * square, (x**2 + y**2 + z**2) / (largest * largest))
    return np.broadcast_to(fourth, len(block)) if np.ndim(fourth) == 0 else fourth


def _exponents(block: Block) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.bool_]]:
    """The exponents of :attr:`Scene.time_unit`, and where doubles do not tell them."""
    fourth = _fourth(block)
    part, exponent = np.frexp(fourth)
    unsure = ~((fourth > 1e-290) & (fourth < 1e290)) | (np.abs(part - _NEXT_POWER) < _UNSURE)
    above = exponent.astype(np.int64) - 1 + (part >= _NEXT_POWER)
    return -(above // 4), unsure

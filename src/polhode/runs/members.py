"""The plan of a sweep: its members as the engine takes them, in principal axes and own units."""

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
from polhode.equations.terms import COEFFICIENTS, NAMES, coefficients_of
from polhode.motion.frame import Frame
from polhode.numbers.conversion import number_value, to_double
from polhode.numbers.double_double import Pairs, pairs
from polhode.numbers.exact import ZERO, Exact
from polhode.numbers.number_types import (
    AnyNumber,
    Booleans,
    Doubles,
    Flat,
    Indices,
    NumberType,
    Scalar,
    kind_of,
)
from polhode.numbers.row_formulas import Rationals
from polhode.numbers.vectors import scaled
from polhode.runs.options import choose_number, rounded_tolerance
from polhode.scenes import vary
from polhode.scenes.body import PrincipalAxes
from polhode.scenes.members import Members
from polhode.scenes.scene import Scene
from polhode.taylor import defaults, heyoka, lanes
from polhode.taylor.batches import BatchJob, Columns
from polhode.taylor.system import refuse_other_rounding, rounded_times

if TYPE_CHECKING:
    from polhode.scenes.members import Block, Vector


# --- plan -----------------------------------------------------------------------------------------
#
# A sweep, checked before anything is integrated: its members in numbers of one type.


_BYTES = 40  # of a number of the states, while they are gathered and written


class Tables(NamedTuple):
    """The members in numbers, none of them above extended.

    ``coefficients``: of these ``names``, a row for each member in its own unit of time; one row in
    the scene's where all have its body, which 2**(unit ``powers``) brings into a member's.
    ``starts``: (members, columns) in principal axes and each member's unit.  ``exponents``: of
    these units, powers of two; ``rates``: the fastest rate at most, radians for each unit of the
    scene's time; both 0 above extended.
    """

    names: tuple[str, ...]
    coefficients: Flat
    powers: Indices
    starts: Flat
    exponents: Indices
    rates: Doubles

    @classmethod
    def without_numbers(cls, count: int) -> Tables:
        """Those of members above extended."""
        nothing, zeros = np.empty((0, 0)), np.zeros(count)
        exponents = zeros.astype(np.int64)
        return cls((), nothing, exponents[:0], nothing, exponents, zeros)

    def motions(self, members: Indices) -> Columns:
        """Some members, each in its own unit of time."""
        own = self.coefficients
        if len(own) == 1:
            units = self.exponents[members]
            if not (units != units[0]).any():
                units = units[:1]
            own = np.ldexp(own, self.powers * units[:, None])
        else:
            own = own.take(members, axis=0)
        return Columns(own, self.starts.take(members, axis=0))


@dataclass(frozen=True, eq=False)
class Plan:
    """A sweep, checked: what there is to integrate."""

    members: Members
    number: NumberType
    tolerance: Fraction | None
    max_steps: int
    times: tuple[Fraction, ...]
    exact_times: Sequence[Exact]
    tables: Tables

    @cached_property
    def shared(self) -> BatchJob:
        """What the jobs of members have in common, of a type that numpy holds."""
        tables, number = self.tables, self.number
        grid = np.array([number_value(t, number) for t in self.times], kind_of(number))
        how = tables.names, number, self.tolerance, self.max_steps, grid, Fraction(1)
        job = BatchJob(*how, Columns(tables.coefficients, tables.starts[:0]))
        job = job._replace(exponents=tables.exponents)
        return job._replace(sure=lanes.surely(job, float(tables.rates.max(initial=0.0))))

    def job(self, members: Indices) -> BatchJob:
        """The job of some members, which have a unit of time in common or are sure to arrive."""
        tables = self.tables
        job = self.shared.of(tables.motions(members), tables.exponents[members])
        if not job.sure:
            with np.errstate(over="ignore"):  # of a rate that is only known to be so small
                rate = np.ldexp(tables.rates[members].max(), tables.exponents[members[0]])
            job = job._replace(sure=lanes.surely(job, float(rate)))
        return job

    def bodies(self, members: Indices) -> list[Indices]:
        """Of some members which value of each of the body's keys they have: arrays, one a key."""
        varied = self.members.varied
        rows = varied.rows
        each = zip(varied.keys, rows.columns, rows.repeats, strict=True)
        return [members // n % len(x) for key, x, n in each if key.startswith("body.")]

    def groups(self, size: int, most: int, mixed: bool = False) -> Iterator[Indices]:
        """The members in groups of about the same rate, and of one unit of time if not ``mixed``.

        Each is a multiple of ``size`` members but the last of a unit; about ``most`` groups.
        """
        units, rates = self.tables.exponents, self.tables.rates
        size *= max(1, -(-len(rates) // (size * most)))
        if mixed or (len(units) and (units == units[0]).all()):
            alike = [(-rates).argsort(kind="stable")]
        else:
            order = np.lexsort((-rates, units))
            alike = np.split(order, np.flatnonzero(np.diff(units[order])) + 1)
        for members in alike:
            yield from (members[i : i + size] for i in range(0, len(members), size))


def planned(
    scene: Scene,
    varied: vary.Variation,
    number: str | NumberType | None,
    digits: int | None,
    tol: AnyNumber | None,
    max_steps: int | None,
    kept: bool = True,
) -> Plan:
    """The plan of a sweep, see :func:`polhode.integrate_many`; raises BadInput.

    ``kept``: whether the states of all members are held at once.
    """
    refuse_other_rounding(scene)
    if scene.events:
        expected = "none in a sweep: a step size of its own for each event; run members singly"
        raise BadInput(scene.name, "events", scene.events[0].name, expected)
    members = Members(scene, varied)
    count = len(members)
    numbers = (count if kept else 1) * len(scene.times) * len(scene.columns)
    amount = f"{count} members at {len(scene.times)} times"
    words = "numbers of states; fewer samples, or split the sweep"
    refuse_too_much(scene.name, "vary", amount, numbers, _BYTES, words)
    _ = members.tables  # a key that is none is refused before anything else
    chosen = choose_number(scene, number, None)
    if digits is not None and count:
        chosen = choose_number(fastest(members).at(scene.times), number, digits)
    if members.arrays:
        _check_arrays(members, chosen)
    times = tuple(rounded_times(scene, chosen))
    tolerance = rounded_tolerance(scene, chosen, tol)

    tables = tables_of(members, times, chosen) if chosen.flat else Tables.without_numbers(count)
    limit = max_steps if max_steps is not None else defaults.of(chosen).max_steps
    return Plan(members, chosen, tolerance, limit, times, scene.times, tables)


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
_POWERS = np.array([coefficient.power for coefficient in COEFFICIENTS])  # of 1/time
_SIZES = 2.0**-1000, 2.0**1000  # of a rate
_CANCELLED = 2.0**-20  # of a sum's terms: what is less has lost bits


def tables_of(members: Members, times: Sequence[Fraction], number: NumberType) -> Tables:
    """All members in numbers of a type, double or extended; ``times``: away from 0.

    Raises BadInput for a member, or a time in a member's unit, that the type cannot hold.
    """
    making = _Making(members, number)
    for block in members.blocks():
        left = making.fill(block)
        for k in np.flatnonzero(left):
            making.put(block, int(k))
    exponents = making.exponents
    ends = [*[t for t in times if t][:1], times[-1]]  # the least and the largest that are not 0
    extremes = exponents.min(initial=0), exponents.max(initial=0)
    with np.errstate(all="ignore"):
        sizes = np.ldexp([[to_double(t)] for t in ends], -np.array([extremes]))
    if _out_of_range(sizes).any():
        for exponent, first in zip(*np.unique(exponents, return_index=True), strict=True):
            own = [t / Fraction(2) ** int(exponent) for t in ends]
            refuse_out_of_range(members, int(first), number, own)
    coefficients = making.coefficients
    powers = np.zeros_like(_POWERS) if making.alike is None else _POWERS
    present = np.flatnonzero((coefficients != 0).any(axis=0)).tolist()
    present.sort(key=NAMES.__getitem__)
    names = tuple(NAMES[i] for i in present)
    columns = coefficients.take(present, axis=1), powers.take(present)
    return Tables(names, *columns, making.starts, exponents, making.rates)


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
    """The body that all members have: a row of its coefficients, and what bounds their rates."""

    coefficients: Flat
    bound: lanes.Bound

    @classmethod
    def of(cls, scene: Scene, number: NumberType) -> _Body:
        """The body of a scene, in the scene's unit of time."""
        body = scene.body
        torque = body.axes.components(body.torque)
        exact = coefficients_of([*body.moments, *torque])
        coefficients = np.array([[number_value(x, number) for x in exact]], kind_of(number))
        return cls(coefficients, _bound(body.moments, torque))

    def rows(self, exponents: npt.ArrayLike) -> Flat:
        """Its coefficients in units of time."""
        units = np.asarray(exponents)[:, None]
        rows: Flat = np.ldexp(self.coefficients, _POWERS * units)
        return rows


_bodies: Recent[_Body] = Recent(4)


class _Making:
    """The numbers of all members, filled block by block.

    ``alike``: the body of all members, as long as they have one and none has been put in by its
    scene: ``coefficients`` are then its row in the scene's unit of time, else a row for each.
    """

    def __init__(self, members: Members, number: NumberType) -> None:
        count, kind, scene = len(members), kind_of(number), members.scene
        self.members, self.number = members, number
        self.starts: Flat = np.zeros((count, len(scene.columns)), kind)
        self.exponents = np.zeros(count, dtype=np.int64)
        self.rates = np.zeros(count)
        self.alike: _Body | None = None
        if members.same_body:
            self.alike = _bodies.get(scene.identity, number, lambda: _Body.of(scene, number))
            self.coefficients = self.alike.coefficients
        else:
            self.coefficients = np.zeros((count, len(NAMES)), kind, order="F")

    def fill(self, block: Block) -> Booleans:
        """Put a block of members in; which of them are left."""
        here = slice(block.first, block.last)
        starts, alike = self.starts[here], self.alike
        with np.errstate(all="ignore"):
            try:
                exponents, unsure = _exponents(block)
                torque, *start = (
                    _along(vector, block.axes, unsure)
                    for vector in (block.torque, block.omega, block.gamma)
                    if vector is not None
                )
                self._put(starts, [x for vector in start for x in vector])
                if alike is None:
                    numbers = _coefficients(block.moments, torque, unsure)
                    self._put(self.coefficients[here], numbers)
                bound = _bound(block.moments, torque) if alike is None else alike.bound
                self.rates[here] = lanes.rates(starts, bound)
            except (OverflowError, ZeroDivisionError):  # beyond doubles, here or on the way
                return np.ones(len(block), dtype=bool)
            if exponents.any():
                starts[:, :3] = np.ldexp(starts[:, :3], exponents[:, None])
            left: Booleans = block.left | unsure | _out_of_range(starts)
            if alike is None:
                rows = self.coefficients[here]
                rows[:] = np.ldexp(rows, _POWERS * exponents[:, None])
                left |= _out_of_range(rows)
            elif _out_of_range(alike.rows([exponents.min(), exponents.max()])).any():
                left |= _out_of_range(alike.rows(exponents))
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
        if self.alike is not None:
            self.coefficients, self.alike = self.alike.rows(self.exponents), None
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
    numbers = [pairs(_parted(x)) for x in vector]
    components: list[Numbers] = []
    for row in axes.rows:
        a, b, c = (pairs(r) * x for r, x in zip(row, numbers, strict=True))
        components.append(a + b + c)
        size = np.abs(a.hi) + np.abs(b.hi) + np.abs(c.hi)
        _note(unsure, size, np.abs(components[-1].hi) < _CANCELLED * size)
    return components


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


def _exponents(block: Block) -> tuple[Indices, Booleans]:
    """The exponents of :attr:`Scene.time_unit`, and where doubles do not tell them."""
    fourth = _fourth(block)
    part, exponent = np.frexp(fourth)
    unsure = ~((fourth > 1e-290) & (fourth < 1e290)) | (np.abs(part - _NEXT_POWER) < _UNSURE)
    above = exponent.astype(np.int64) - 1 + (part >= _NEXT_POWER)
    return -(above // 4), unsure

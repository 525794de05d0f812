"""The members of a sweep: scenes, made when asked for, and columns of numbers inside their frames.

Every member is checked as its scene is when it is made.  What columns do not tell (an irrational
value, a start in angles, a body that is nearly none, inertia that varies beside principal axes
that are not the body's own) is in doubt: it is left to the members' scenes, and so are the words of
a fault.
"""

from __future__ import annotations

import re
import threading
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias, cast

import numpy as np

from polhode.common.errors import BadInput, FileName, nearest, say_change
from polhode.common.values import Recent, cached_property
from polhode.equations.forms import principal
from polhode.equations.terms import COEFFICIENTS, NAMES, coefficients_of
from polhode.motion.frame import Frame
from polhode.numbers.conversion import ExactNumbers, LazySequence, exactly, number_value, to_double
from polhode.numbers.decimals import shown
from polhode.numbers.double_double import Pairs, of_fractions, of_quotients, pairs
from polhode.numbers.exact import ONE, ZERO, Exact, sign
from polhode.numbers.number_types import Booleans, Doubles, Flat, Indices, NumberType, kind_of
from polhode.numbers.vectors import scaled
from polhode.scenes import scene_file, vocabulary
from polhode.scenes.body import Body, PrincipalAxes
from polhode.scenes.scene import Scene
from polhode.scenes.vary import Variation
from polhode.scenes.vocabulary import CENTRE
from polhode.taylor import heyoka, lanes
from polhode.taylor.batches import BatchMotions

BLOCK = 1 << 16  # members that are read at once: a bound on what planning holds
_BODIES = 1024  # that are remembered
_LOOKED_AT = 64  # members, for notes
_OF_BODY = {"body.moments", "body.inertia"}  # of what a member's rounding may be taken off
_OF_START = {"start.gamma", "start.quaternion"}

_SECTIONS = ("body", "start")
_KEY = re.compile(r"(body|start)\.[a-z_]+(\[[1-9]\d*\](\.[a-z_]+)?)*")
#: Where a number of the tables stands: in which table or list, and under which key or index.
Slot: TypeAlias = tuple[Any, Any]

#: Keys that hold no number, and so cannot be varied.
_WORDS = {
    key.name
    for section in ("body", "body.parts", "start")
    for key in vocabulary.KEYS[section]
    if key.kind in (vocabulary.WORD, vocabulary.TRUTH)
}

#: What may vary in columns, and what a scene's tables may hold then.
_KEYS = {
    *("body.moments", "body.centre", "body.weight"),
    *("start.omega", "start.gamma", "start.psi"),
}
_BODY = {"moments", "inertia", "centre", "weight"}
_START = {"omega", "gamma", "psi", "normalise"}
#: The keys of the numbers of a vector.
_OF_VECTOR = {
    name: tuple(f"{name}[{i}]" for i in (1, 2, 3))
    for name in ("body.moments", "body.centre", "start.omega", "start.gamma")
}


class Members(LazySequence[Scene]):
    """The members of a sweep: as scenes without output times, made when asked, and in columns."""

    def __init__(self, scene: Scene, varied: Variation) -> None:
        self.scene, self.varied = scene, varied
        self._mine = threading.local()  # one reads by writing into tables
        #: the keys of which numbers vary, without the places of these in them; those of the body
        self.vectors = frozenset(key.partition("[")[0] for key in varied.keys)
        self.of_body = frozenset(key for key in self.vectors if key.startswith("body."))

    def __len__(self) -> int:
        return len(self.varied.rows)

    def at(self, k: int) -> Scene:
        """The scene of a member."""
        reading: _Reading | None = getattr(self._mine, "reading", None)
        if reading is None:
            reading = self._mine.reading = _Reading(self.scene, self.varied, self.same_body)
        return reading.member(k)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Members):
            return NotImplemented
        return self.scene == other.scene and self.varied == other.varied

    __hash__ = None

    def __reduce__(self) -> tuple[type, tuple[Scene, Variation]]:
        return Members, (self.scene, self.varied)

    @cached_property
    def arrays(self) -> dict[str, Flat]:
        """The columns that were given as floats, by key."""
        each = zip(self.varied.keys, self.varied.rows.columns, strict=True)
        return {key: column.floats for key, column in each if column.floats is not None}

    @cached_property
    def gammas(self) -> Flat | None:
        """Rows of gamma where arrays give all of it, of length 1 but for rounding; else None."""
        a, b, c = map(self.arrays.get, _OF_VECTOR["start.gamma"])
        if a is None or b is None or c is None:
            return None
        return cast("Flat", np.stack([a, b, c], axis=1))

    @property
    def same_body(self) -> bool:
        """Whether all members have the body of the scene."""
        return not self.of_body

    @cached_property
    def axes_stay(self) -> bool:
        """Whether all members have the principal axes of the scene.

        A body of parts, or one whose inertia is given about its centre of mass, turns its axes with
        nearly every number.  Two equal moments leave a choice, which the centre of mass makes.
        """
        varied = self.of_body - {"body.weight", "body.g"}
        if not varied:
            return True
        body, axes = self.tables["body"], self.scene.body.axes
        if "parts" in body or body.get("about") == CENTRE:
            return False
        if not varied <= {"body.moments", "body.mass", "body.centre"}:
            return False
        a, b, c = self.scene.body.moments
        return axes.trivial or "body.centre" not in varied or not (a == b or b == c or c == a)

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """The notes of the scene, and what was changed of the first members, as of one of them."""
        of_body, of_start = self.vectors & _OF_BODY, self.vectors & _OF_START
        as_is = any(key.startswith("start.") for key in self.arrays)
        starts = bool(of_start) and not as_is  # else members begin at the numbers of the arrays
        if not of_body and not starts:
            return self.scene.notes
        few = self._block(0, min(len(self), _LOOKED_AT))
        members = (self[int(k)] for k in np.flatnonzero(few.doubt | starts))
        of_members = ([*filter(None, [x.body.change])] if as_is else x.changes for x in members)
        changes = next(filter(None, of_members), ())
        return (*self.scene.notes, *(f"members: {text}" for text in changes))

    def speak(self) -> None:
        """Say the members' own notes on stderr, as :meth:`Scene.speak` does a scene's."""
        for text in self.notes[len(self.scene.notes) :]:
            say_change(self.scene.name, text)

    def provenance(self) -> dict[str, object]:
        """Where a result comes from, see :meth:`Scene.provenance`, and the members' notes."""
        facts = self.scene.provenance()
        return facts | {"notes": list(self.notes)} if self.notes else facts

    @cached_property
    def tables(self) -> dict[str, Any]:
        """The tables that are varied, as they were before; not to be written to.

        Raises BadInput for a key that is none of them.
        """
        tables, homes = numbers_of(self.scene)
        _places(homes, self.varied.keys, self.scene.name)
        return tables

    # -- in columns -----------------------------------------------------------------------------

    def blocks(self) -> Iterator[Block]:
        """The members in columns, some at a time."""
        for first in range(0, len(self), BLOCK):
            yield self._block(first, min(first + BLOCK, len(self)))

    @cached_property
    def _columns(self) -> list[tuple[MemberColumn, Booleans | None]]:
        """The numbers of each key, and which of them are in doubt."""
        return [*map(_column, self.varied.keys, self.varied.rows.columns)]

    @cached_property
    def readable(self) -> bool:
        """Whether such a scene can be read in columns."""
        scene, start, body = self.scene, self.tables["start"], self.tables["body"]
        plain = "omega" in start and start.keys() <= _START and body.keys() <= _BODY
        if not (self.vectors <= _KEYS and plain and self.axes_stay):
            return False
        if "start.gamma" in self.vectors and self.gammas is None:  # each is exactly of length 1
            return False
        return _in_range.get(scene.identity, "", lambda: _all_in_range(scene))

    @np.errstate(all="ignore")
    def _block(self, first: int, last: int) -> Block:
        scene, body, rows = self.scene, self.scene.body, self.varied.rows
        doubt = np.zeros(last - first, dtype=bool)
        if not self.readable:
            return Block(first, ~doubt, body.moments, body.torque, scene.omega, scene.gamma)
        columns: dict[str, MemberColumn] = {}
        for key, (column, in_doubt), size, repeat in zip(
            self.varied.keys, self._columns, rows.sizes, rows.repeats, strict=True
        ):
            at: Any = slice(first, last)
            if repeat > 1 or size < len(self):
                at = np.arange(first, last) // repeat % size
            columns[key] = column[at]
            if in_doubt is not None:
                doubt |= in_doubt[at]

        def along(name: str, vector: ColumnVector) -> ColumnVector:
            return _along(body.axes, _vector(columns, name, vector), doubt)

        moments = _vector(columns, "body.moments", body.moments)
        if "body.moments" in self.vectors:
            doubt |= _unphysical(moments)
        if self.vectors.isdisjoint(("body.weight", "body.centre")):
            torque: ColumnVector = body.axes.components(body.torque)
        else:
            weight = columns.get("body.weight", body.weight)
            if scene.gamma is None or "centre" not in self.tables["body"]:
                doubt |= doubles(weight) != 0  # of no use: its scene says so
            x, y, z = along("body.centre", body.centre)
            torque = _product(weight, x), _product(weight, y), _product(weight, z)
        omega = along("start.omega", scene.omega)
        gamma = None if scene.gamma is None else along("start.gamma", scene.gamma)
        return Block(first, doubt, moments, torque, omega, gamma)


class _Reading:
    """A scene's tables in which a member's values are put before it is read."""

    def __init__(self, scene: Scene, varied: Variation, same_body: bool) -> None:
        self.scene, self.varied, self.same_body = scene, varied, same_body
        self.data, leaves = _new_numbers(scene)
        for key, (table, at) in leaves.items():  # read once for all members
            table[at] = scene_file.exact_value(table[at], key, scene.name)
        self.places = _places(leaves, varied.keys, scene.name)
        bare = replace(scene, times=(), published=(), expect={}, source="", outputs=())
        self.bare = replace(bare, change="", doubt="")
        self.bodies: dict[tuple[Any, ...], Body] = {}

    def member(self, index: int) -> Scene:
        row = self.varied.rows[index]
        name = label(self.scene.name, self.varied, index)
        for spots, value in zip(self.places, row, strict=True):
            for table, at in spots:
                table[at] = value
        body = self.scene.body if self.same_body else self._body(row, name)
        body, omega, gamma, psi, change = scene_file.body_and_start(self.data, name, body)
        scene = replace(self.bare, body=body, omega=omega, gamma=gamma, psi=psi, name=name)
        return replace(scene, change=change) if change else scene

    def _body(self, row: tuple[Exact, ...], name: str) -> Body:
        """The body that the tables hold now: one for all members that have the same."""
        of_body = tuple(
            x if isinstance(x, Fraction) else (id(x),)
            for key, x in zip(self.varied.keys, row, strict=True)
            if key.startswith("body.")
        )
        if of_body not in self.bodies:
            if len(self.bodies) >= _BODIES:
                self.bodies.clear()
            self.bodies[of_body] = scene_file.body_and_start(self.data, name)[0]
        return self.bodies[of_body]


def label(name: str, varied: Variation, index: int) -> str:
    """How a member is called in messages."""
    row = zip(varied.keys, varied.rows[index], strict=True)
    more = f" member {index + 1} ({', '.join(f'{key} = {shown(x)}' for key, x in row)})"
    return name.with_more(more) if isinstance(name, FileName) else name + more


def _places(homes: Mapping[str, Slot], varied: Sequence[str], name: str) -> list[list[Slot]]:
    """For each key the places of its number among those known; an inertia's mirror image with it.

    Raises BadInput.
    """
    places, keys = [], set()
    for key in varied:
        if key not in homes or not _KEY.fullmatch(key):
            raise BadInput(name, "vary", key, f"a number of the scene: {nearest(key, [*homes])}")
        spots = [homes[key]]
        if key.startswith("body.inertia"):
            row, column = key[13], key[16]
            mirror = f"body.inertia[{column}][{row}]"
            if mirror != key:
                spots.append(homes[mirror])
            if mirror in keys:
                raise BadInput(name, "vary", key, f"not {mirror} too: they are one number")
        keys.add(key)
        places.append(spots)
    return places


#: The tables of a scene, and by key where each number of theirs stands.
TableNumbers: TypeAlias = tuple[dict[str, Any], Mapping[str, Slot]]
_tables: Recent[TableNumbers] = Recent(1)


def numbers_of(scene: Scene) -> TableNumbers:
    """The tables of body and start and their numbers, read once; not to be written to."""
    return _tables.get(scene.identity, "", lambda: _new_numbers(scene))


def _new_numbers(scene: Scene) -> TableNumbers:
    data = scene_file.tables_of(scene)
    return data, dict(_leaves(data))


def _leaves(data: dict[str, Any]) -> Iterator[tuple[str, Slot]]:
    """Every number of the tables: its key, and where it stands, also of those left out."""
    body, start = data["body"], data["start"]
    if "centre" in body and "g" not in body:
        body.setdefault("weight", 0)
    if "gamma" in start:
        start.setdefault("psi", 0)
    pending: list[tuple[str, Any, Any]] = [
        (f"{section}.{key}", data[section], key) for section in _SECTIONS for key in data[section]
    ]
    for key, table, at in pending:
        value = table[at]
        if isinstance(value, list):
            table[at] = value = list(value)  # the caller's tables stay as they are
            pending += [(f"{key}[{i + 1}]", value, i) for i in range(len(value))]
        elif isinstance(value, dict):  # one of [[body.parts]]
            table[at] = value = dict(value)
            pending += [(f"{key}.{name}", value, name) for name in value]
        elif not isinstance(value, bool) and at not in _WORDS:
            yield key, (table, at)


# --- columns --------------------------------------------------------------------------------------
#
# Floats of arrays as they were given, other numbers as pairs of doubles.  Those hold a number to a
# hundred bits, and with that tell which one of a type is the nearest, but for one in 2**40.


#: A number that all members have in common (Exact), or one for each: Pairs, or the floats of an
#: array.
MemberColumn: TypeAlias = Any
ColumnVector: TypeAlias = tuple[MemberColumn, MemberColumn, MemberColumn]

_LEAST, _MOST = 2.0**-200, 2.0**200  # between these products and quotients are in doubles' range
_CANCELLED = 2.0**-20  # of a sum's terms: what is less has lost bits
_NEXT_POWER = 1 - 2.0**-9  # from this part of a power of two on, eight bits round to it
_NEAR_POWER = 1e-9  # of that, in doubles
_NOT_FLAT = 1 - 2.0**-50  # of the moments' sum
_NO_RATE = 1e-290  # to the fourth power


@dataclass(frozen=True)
class Block:
    """Members from ``first`` on in columns, in principal axes; ``doubt``: which are not in them.

    ``torque``: Mg r0.  ``omega``, ``gamma``: at t = 0.
    """

    first: int
    doubt: Booleans
    moments: ColumnVector
    torque: ColumnVector
    omega: ColumnVector
    gamma: ColumnVector | None


def _vector(columns: Mapping[str, MemberColumn], name: str, fixed: ColumnVector) -> ColumnVector:
    """A vector, of which some numbers may vary."""
    a, b, c = map(columns.get, _OF_VECTOR[name], fixed)
    return a, b, c


def paired(x: MemberColumn) -> Pairs:
    """A column, or what all members have in common, as pairs of doubles."""
    if not isinstance(x, np.ndarray):
        return pairs(x)
    high = x.astype(np.float64, copy=False)
    return Pairs(high, (x - high).astype(np.float64))


def _product(x: MemberColumn, y: MemberColumn) -> MemberColumn:
    """The product of two columns; what is zero for all stays so."""
    return ZERO if isinstance(y, Fraction) and y == 0 else paired(x) * paired(y)


def doubles(x: MemberColumn) -> Doubles:
    """The doubles next to the numbers of a column, or next to one that members have in common."""
    if isinstance(x, np.ndarray):
        return x.astype(np.float64, copy=False)
    return np.asarray(x.hi if isinstance(x, Pairs) else to_double(x))


def _column(key: str, numbers: ExactNumbers[Exact]) -> tuple[MemberColumn, Booleans | None]:
    """Numbers of a key as a column, and which of them it does not hold, if any."""
    column: MemberColumn = numbers.floats
    if column is not None and key.startswith("start."):  # which are looked at all together
        return column, None
    if column is None:
        try:
            column = _pairs_of(numbers)
        except OverflowError:  # beyond doubles, if only one of them
            column = np.ones(len(numbers))
            return column, column != 0
    doubt = _out_of_range(doubles(column))
    if numbers.floats is None:
        for k in np.flatnonzero(doubles(column) == 0).tolist():  # or too small for doubles
            doubt[k] = sign(numbers[k]) != 0
    return column, doubt if doubt.any() else None


def _pairs_of(numbers: ExactNumbers[Exact]) -> Pairs:
    """Rationals as pairs, not a number where there is an irrational one."""
    if numbers.ends is not None:
        first, last = numbers.ends
        if isinstance(first, Fraction) and isinstance(last, Fraction):
            step = (last - first) / max(1, len(numbers) - 1)
            top = step.numerator * first.denominator * np.arange(len(numbers)).astype(object)
            top = top + first.numerator * step.denominator
            return of_quotients(top, first.denominator * step.denominator)
    column = of_fractions([x if isinstance(x, Fraction) else ONE for x in numbers])
    column.hi[[not isinstance(x, Fraction) for x in numbers]] = np.nan
    return column


_in_range: Recent[bool] = Recent(1)


def _all_in_range(scene: Scene) -> bool:
    """Whether nothing is lost of any number of a scene."""
    body = scene.body
    shared = (*body.moments, body.weight, *body.centre, *body.torque, *scene.omega)
    return not _out_of_range(np.array([*map(to_double, shared)])).any()


def _out_of_range(sizes: Flat) -> Booleans:
    """Which numbers are neither 0 nor of a size at which nothing is lost."""
    sizes = np.abs(sizes)
    out: Booleans = ~((sizes > _LEAST) & (sizes < _MOST) | (sizes == 0))
    return out


def _unphysical(moments: ColumnVector) -> Booleans:
    """Where no body has such moments, or rounding might hide it."""
    a, b, c = map(doubles, moments)
    twice = 2 * np.maximum(np.maximum(a, b), c)
    nearly: Booleans = (a + b + c) * _NOT_FLAT <= twice
    return nearly | (np.minimum(np.minimum(a, b), c) <= 0)


def _along(axes: PrincipalAxes, vector: ColumnVector, doubt: Booleans) -> ColumnVector:
    """Components along principal axes; ``doubt``: where pairs do not tell them is noted there."""
    if axes.trivial:
        return vector
    if all(isinstance(x, Exact) for x in vector):
        return axes.components(vector)
    numbers, components = [paired(x) for x in vector], list[MemberColumn]()
    for row in axes.rows:
        a, b, c = (pairs(r) * x for r, x in zip(row, numbers, strict=True))
        components.append(a + b + c)
        size = np.abs(a.hi) + np.abs(b.hi) + np.abs(c.hi)
        doubt |= np.abs(components[-1].hi) < _CANCELLED * size
    a, b, c = components
    return a, b, c


def _coefficients(block: Block, doubt: Booleans) -> Sequence[MemberColumn]:
    """All coefficients of the bodies; where pairs do not tell them is noted."""
    every = (*block.moments, *block.torque)
    numbers = [x if isinstance(x, Fraction) else paired(x) for x in every]
    a, b, c = numbers[:3]
    for x, y in ((a, b), (b, c), (c, a)):
        if not isinstance(x - y, Fraction):
            gap = np.abs(doubles(x - y))
            doubt |= (gap < _CANCELLED * doubles(x)) & (gap != 0)
    return coefficients_of(numbers)


def _fourth(block: Block) -> Doubles:
    """The fastest rate at the start to the fourth power, as :attr:`Scene.time_unit` means it."""
    p, q, r = map(doubles, block.omega)
    x, y, z = map(doubles, block.torque)
    a, b, c = map(doubles, block.moments)
    square, largest = p**2 + q**2 + r**2, np.maximum(np.maximum(a, b), c)
    fourth = np.maximum(square * square, (x**2 + y**2 + z**2) / (largest * largest))
    return np.broadcast_to(fourth, len(block.doubt))


def _exponents(block: Block) -> tuple[Indices, Booleans]:
    """The exponents of :attr:`Scene.time_unit`, and which members are in doubt, by these, too."""
    fourth = _fourth(block)
    part, exponent = np.frexp(fourth)
    doubt = block.doubt | ~(fourth > _NO_RATE) | (np.abs(part - _NEXT_POWER) < _NEAR_POWER)
    above = exponent.astype(np.int64) - 1 + (part >= _NEXT_POWER)
    return -(above // 4), doubt


@np.errstate(all="ignore")
def fastest(members: Members) -> Scene:
    """The member of a sweep that turns fastest at the start."""
    candidates: list[int] = []
    for block in members.blocks():
        fourth = np.where(block.doubt, -1.0, _fourth(block))
        few = [int(np.argmax(fourth)), *np.flatnonzero(block.doubt).tolist()]
        candidates += [block.first + k for k in few]
    return max((members[k] for k in candidates), key=lambda member: member.log10_rate)


# --- numbers --------------------------------------------------------------------------------------
#
# The members as the integrator takes them, inside their frames: starts, coefficients, units of
# time.  Starts that are given as arrays go as they are, all else is rounded once.


_POWERS = np.array([coefficient.power for coefficient in COEFFICIENTS])  # of 1/time
_SIZES = 2.0**-1000, 2.0**1000  # of a rate
_SMALLEST, _LARGEST = 2.0**-1022, 2.0**1023


class _Body(NamedTuple):
    """The body that all members have: a row of its coefficients, and what bounds their rates."""

    coefficients: Flat
    bound: lanes.Bound

    @classmethod
    def of(cls, body: Body, number: NumberType) -> _Body:
        """That of a body, in its scene's unit of time."""
        torque = body.axes.components(body.torque)
        exact = coefficients_of([*body.moments, *torque])
        row: Flat = np.array([[number_value(x, number) for x in exact]], kind_of(number))
        return cls(row, _bound(body.moments, torque))


_bodies: Recent[_Body] = Recent(4)


class SweepNumbers:
    """The members in numbers of a type, double or extended.

    ``coefficients``: of these ``names``, a row for each member in its own unit of time; one row in
    the scene's where all have its body, which 2**(unit ``powers``) brings into a member's.
    ``starts``: (members, columns) in principal axes and each member's unit.  ``exponents``: of
    these units, powers of two; ``rates``: the fastest rate at most, radians for each unit of the
    scene's time; both 0 above extended.  Raises BadInput for a member that the type cannot hold.
    """

    def __init__(self, members: Members, number: NumberType) -> None:
        count, scene = len(members), members.scene
        kind = kind_of(number) if number.flat else np.float64
        self.members, self.number = members, number
        self.starts: Flat = np.zeros((count, len(scene.columns)), kind)
        self.exponents, self.rates = np.zeros(count, dtype=np.int64), np.zeros(count)
        self.coefficients: Flat = np.zeros((count, len(NAMES)), kind, order="F")
        self.powers, self._body = np.zeros_like(_POWERS), cast("_Body | None", None)
        if not number.flat:
            return
        if members.same_body and members.readable:
            self._body = _bodies.get(scene.identity, number, lambda: _Body.of(scene.body, number))
            self.coefficients, self.powers = self._body.coefficients, _POWERS
        for block in members.blocks():
            for k in self._fill(block):
                self._put(block.first + int(k))
        present = np.flatnonzero((self.coefficients != 0).any(axis=0)).tolist()
        present.sort(key=NAMES.__getitem__)
        self.names = tuple(map(NAMES.__getitem__, present))
        self.coefficients = self.coefficients.take(present, axis=1)
        self.powers = self.powers.take(present)

    def motions(self, members: Indices) -> BatchMotions:
        """Some members, each in its own unit of time."""
        own = self.coefficients
        if self._body is None:
            own = own.take(members, axis=0)
        else:
            units = self.exponents[members]
            if not (units != units[0]).any():
                units = units[:1]
            own = np.ldexp(own, self.powers * units[:, None])
        return BatchMotions(own, self.starts.take(members, axis=0))

    def check(self, times: Sequence[Fraction]) -> None:
        """Refuse times, away from 0, that the type cannot hold in a member's unit.

        Nor in the scene's, in which jobs have them: numbers that would be infinite.
        """
        if abs(times[-1]) > 1:
            _refuse_out_of_range(self.members.scene, self.number, times[-1:])
        exponents = self.exponents
        ends = times[0] or times[:2][-1], times[-1]  # the least and the largest that are not 0
        extremes = np.array([[exponents.min(initial=0)], [exponents.max(initial=0)]])
        with np.errstate(all="ignore"):
            sizes = np.abs(np.ldexp([*map(to_double, ends)], -extremes))
        if ((sizes < _SMALLEST) & (sizes != 0) | ~(sizes <= _LARGEST)).any():
            for exponent, first in zip(*np.unique(exponents, return_index=True), strict=True):
                own = [t / Fraction(2) ** int(exponent) for t in ends]
                _refuse_out_of_range(self.members[int(first)], self.number, own)

    @np.errstate(all="ignore")
    def _fill(self, block: Block) -> Indices:
        """Put a block of members in; which of them are in doubt."""
        here = slice(block.first, block.first + len(block.doubt))
        starts = self.starts[here]
        exponents, doubt = _exponents(block)
        self._round((*block.omega, *(block.gamma or ())), starts)
        if self._body is None:
            rows, bound = self.coefficients[here], _bound(block.moments, block.torque)
            self._round(_coefficients(block, doubt), rows)
            rows[:] = np.ldexp(rows, _POWERS * exponents[:, None])
        else:
            bound = self._body.bound
        doubt |= _out_of_range(starts).any(axis=1)
        self.rates[here] = lanes.rates(starts, bound)
        if exponents.any():
            starts[:, :3] = np.ldexp(starts[:, :3], exponents[:, None])
        self.exponents[here] = exponents
        return np.flatnonzero(doubt)

    def _round(self, columns: Sequence[MemberColumn], table: Flat) -> None:
        """Put columns into a table, each number rounded once."""
        for i, column in enumerate(columns):
            if isinstance(column, Pairs):
                table[:, i] = column.hi
                table[:, i] += column.lo
            elif isinstance(column, np.ndarray):
                table[:, i] = column
            else:
                table[:, i] = number_value(column, self.number)

    def _put(self, index: int) -> None:
        """Put a member in by its scene, and by what arrays say of its start."""
        frame, body, start, coefficients = inside(self.members, index, self.number)
        self.exponents[index] = frame.exponent
        self.starts[index] = [number_value(x, self.number) for x in start]
        if self._body is None:
            self.coefficients[index] = [
                number_value(coefficients.get(name, ZERO), self.number) for name in NAMES
            ]
        part = 1 / max(body.moments)
        bound = _bound(scaled(part, body.moments), scaled(part, body.torque))
        least, largest = _SIZES  # of what doubles cannot hold in the scene's unit
        with np.errstate(all="ignore"):
            rate = np.ldexp(lanes.rates(self.starts[index : index + 1], bound), -frame.exponent)
            self.rates[index] = np.fmin(np.maximum(rate, least), largest)[0]


def inside(
    members: Members, index: int, number: NumberType
) -> tuple[Frame, Body, list[Exact], dict[str, Exact]]:
    """A member inside its frame: body, start (gamma as arrays give it), and coefficients.

    Raises BadInput for numbers that the type cannot hold.
    """
    member, gammas = members[index], members.gammas
    frame = Frame.of(member)
    scene = frame.inside(member)
    start, coefficients = [*scene.start], principal.coefficients(scene.body)
    if gammas is not None:
        a, b, c = map(exactly, gammas[index])
        start[3:] = frame.axes.components((a, b, c))
    _refuse_out_of_range(member, number, [*start, *coefficients.values()])
    return frame, scene.body, start, coefficients


def _refuse_out_of_range(member: Scene, number: NumberType, values: Sequence[Exact]) -> None:
    """Refuse a member's numbers that the type cannot hold; raises BadInput."""
    try:
        heyoka.scalars(values, number)
    except heyoka.OutOfRange as fault:
        raise fault.refusal(member.name, number) from None


def _bound(moments: ColumnVector, torque: ColumnVector) -> lanes.Bound:
    """What bounds the rates of members, in the unit of time of these."""
    inertia, weight = (
        np.stack(np.broadcast_arrays(*map(doubles, vector)), axis=-1)
        for vector in (moments, torque)
    )
    largest = inertia.max(axis=-1, keepdims=True)
    return lanes.Bound.of(inertia / largest, weight / largest)

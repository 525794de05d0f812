"""The members of a sweep in the scene's axes and units: scenes, and columns of exact numbers."""

from __future__ import annotations

import re
import threading
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np

from polhode.common.errors import BadInput, FileName, nearest, say_change
from polhode.common.values import Recent, cached_property
from polhode.numbers.conversion import ExactNumbers, LazySequence, exactly
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact, sign
from polhode.numbers.number_types import Booleans, Flat, Scalar
from polhode.numbers.row_formulas import Rationals, of_floats, of_fractions
from polhode.scenes import scene_file, vocabulary
from polhode.scenes.body import OWN_AXES, Body, PrincipalAxes
from polhode.scenes.scene import Scene
from polhode.scenes.vary import Variation
from polhode.scenes.vocabulary import CENTRE

# --- sweep members --------------------------------------------------------------------------------
#
# The members of a sweep are columns of numbers by key; the scene of one, exact and checked, is made
# when it is asked for.


BLOCK = 1 << 16  # members that are read at once: a bound on what planning holds
_BODIES = 1024  # that are remembered
_LOOKED_AT = 64  # members, for notes
_NOT_FLAT = 1 - Fraction(1, 1 << 40)
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


class Members(LazySequence[Scene]):
    """The members of a sweep: in columns, and as scenes without output times, made when asked."""

    def __init__(self, scene: Scene, varied: Variation) -> None:
        self.scene, self.varied = scene, varied
        self._mine = threading.local()  # one reads by writing into tables

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
    def vectors(self) -> frozenset[str]:
        """The keys of which numbers vary, without the places of the numbers in them."""
        return frozenset(key.partition("[")[0] for key in self.varied.keys)

    @cached_property
    def arrays(self) -> dict[str, Flat]:
        """The columns that were given as floats, by key."""
        each = zip(self.varied.keys, self.varied.rows.columns, strict=True)
        return {key: column.floats for key, column in each if column.floats is not None}

    @cached_property
    def same_body(self) -> bool:
        """Whether all members have the body of the scene."""
        return not any(key.startswith("body.") for key in self.vectors)

    @cached_property
    def axes_stay(self) -> bool:
        """Whether all members have the principal axes of the scene.

        A body of parts, or one whose inertia is given about its centre of mass, turns its axes with
        nearly every number.  Two equal moments leave a choice, which the centre of mass makes.
        """
        if self.same_body:
            return True
        varied = {key for key in self.vectors if key.startswith("body.")}
        varied -= {"body.weight", "body.g"}
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
        few = range(min(len(self), _LOOKED_AT))
        members = (self[k] for k in few if starts or self._body_may_be_changed(k))
        of_members = ([*filter(None, [x.body.change])] if as_is else x.changes for x in members)
        changes = next(filter(None, of_members), ())
        return (*self.scene.notes, *(f"members: {text}" for text in changes))

    def _body_may_be_changed(self, index: int) -> bool:
        """Not where three moments vary and are far from those of a flat body."""
        rows, moments = self.varied.rows, []
        for key, column, repeat in zip(self.varied.keys, rows.columns, rows.repeats, strict=True):
            if key.startswith("body.moments"):
                given = column if column.floats is None else column.floats
                moments.append(given[index // repeat % len(column)])
        return len(moments) < 3 or bool(sum(x / max(moments) for x in moments) * _NOT_FLAT < 2)

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
        """The members in columns, some at a time; raises BadInput for an impossible one."""
        count = len(self)
        for first in range(0, count, BLOCK):
            yield self._block(first, min(first + BLOCK, count))

    @cached_property
    def _columns(self) -> dict[str, tuple[Rationals | Flat, Booleans | None]]:
        """By key its numbers, and where these columns have not got them."""
        each = zip(self.varied.keys, self.varied.rows.columns, strict=True)
        return {key: _parts(column, key.startswith(_ARRAYS)) for key, column in each}

    @cached_property
    def _readable(self) -> bool:
        """Whether such a scene can be read in columns."""
        scene, start, body = self.scene, self.tables["start"], self.tables["body"]
        plain = "omega" in start and start.keys() <= _START and body.keys() <= _BODY
        if not (self.vectors <= _KEYS and plain and self.axes_stay):
            return False
        if not self.same_body:
            own = scene.body.moments if scene.body.axes.trivial else ()
            numbers = (scene.body.weight, *own, *scene.body.centre)
            if not all(isinstance(x, Fraction) for x in numbers):
                return False
        if "start.gamma" not in self.vectors or self.given_as_array("start.gamma"):
            return True
        gamma = (scene_file.exact_value(x, "start.gamma", scene.name) for x in start["gamma"])
        return not start.get("normalise") and all(isinstance(x, Fraction) for x in gamma)

    def given_as_array(self, vector: str) -> bool:
        """Whether all of a vector is."""
        return self.arrays.keys() >= {f"{vector}[1]", f"{vector}[2]", f"{vector}[3]"}

    def _block(self, first: int, last: int) -> Block:
        count, scene, rows = last - first, self.scene, self.varied.rows
        if not self._readable:
            return Block(first, last, np.ones(count, bool), _NONE, _NONE, _NONE, None)
        left = np.zeros(count, dtype=bool)
        columns: dict[str, Column] = {}
        for (key, (column, odd)), size, repeat in zip(
            self._columns.items(), rows.sizes, rows.repeats, strict=True
        ):
            at: Any = slice(first, last)
            if repeat > 1 or size < len(self):
                at = np.arange(first, last) // repeat % size
            columns[key] = column[at]
            if odd is not None:
                left |= odd[at]

        def vector(name: str, fixed: Vector) -> Vector:
            if name not in self.vectors:
                return fixed
            a, b, c = (columns.get(f"{name}[{i + 1}]", x) for i, x in enumerate(fixed))
            return a, b, c

        body, vectors = scene.body, self.vectors
        moments, torque = vector("body.moments", body.moments), body.torque
        weight, bad = columns.get("body.weight", body.weight), np.zeros(count, dtype=bool)
        if "body.weight" in vectors or "body.centre" in vectors:
            x, y, z = (weight * c for c in vector("body.centre", body.centre))
            torque = x, y, z
        omega = vector("start.omega", scene.omega)
        gamma = None if scene.gamma is None else vector("start.gamma", scene.gamma)
        if "body.moments" in vectors:
            bad |= _unphysical(moments)
        exact_gamma = "start.gamma" in vectors and not self.given_as_array("start.gamma")
        if gamma is not None and exact_gamma:
            square = sum((g * g for g in gamma), Rationals(0, 1)) - 1
            bad |= np.asarray(_sign(square) != 0)
        if torque is not body.torque and (gamma is None or "centre" not in self.tables["body"]):
            for x in (weight, *torque):
                bad |= np.asarray(_sign(x) != 0)
        if bad.any():
            for k in np.flatnonzero(bad & ~left):
                _ = self[first + int(k)]  # says what is wrong, if it is
                left[k] = True
        return Block(first, last, left, moments, torque, omega, gamma, body.axes)


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
Numbers: TypeAlias = tuple[dict[str, Any], Mapping[str, Slot]]
_numbers: Recent[Numbers] = Recent(1)


def numbers_of(scene: Scene) -> Numbers:
    """The tables of body and start and their numbers, read once; not to be written to."""
    return _numbers.get(scene.identity, "", lambda: _new_numbers(scene))


def _new_numbers(scene: Scene) -> Numbers:
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


# --- sweep columns --------------------------------------------------------------------------------
#
# The members of a sweep as columns of exact numbers: many at once, and without an object each.
#
# Every member is checked as its scene is when it is made. What these columns cannot tell (an
# irrational value, a start in angles, inertia that varies beside principal axes that are not the
# body's own) they leave to the member's scene, and the words of a fault too. Starts and moments
# that were given as arrays stay the arrays that they are.


#: A number that all members have in common (Exact), or one for each: Rationals, or the floats of
#: an array.  They have arithmetic in common.
Column: TypeAlias = Scalar
Vector: TypeAlias = tuple[Column, Column, Column]

#: What may be varied here, and what a scene's tables may hold.
_KEYS = {
    *("body.moments", "body.centre", "body.weight"),
    *("start.omega", "start.gamma", "start.psi"),
}
_BODY = {"moments", "inertia", "centre", "weight"}
_START = {"omega", "gamma", "psi", "normalise"}

#: Of what the columns stay arrays.
_ARRAYS = ("start.omega", "start.gamma", "body.moments")

_NONE: Vector = (Fraction(0), Fraction(0), Fraction(0))


@dataclass(frozen=True)
class Block:
    """Members ``first`` to ``last`` (not included) in columns; ``left``: those that are not in it.

    ``moments``: the principal ones.  ``torque`` (Mg r0), ``omega`` and ``gamma`` at t = 0 in body
    axes, which are principal axes where ``axes`` is trivial.
    """

    first: int
    last: int
    left: Booleans
    moments: Vector
    torque: Vector
    omega: Vector
    gamma: Vector | None
    axes: PrincipalAxes = OWN_AXES

    def __len__(self) -> int:
        return self.last - self.first

    @property
    def arrays(self) -> bool:
        """Whether numbers of the starts are floats of an array."""
        return any(isinstance(x, np.ndarray) for x in (*self.omega, *(self.gamma or ())))

    def given_gamma(self, k: int) -> tuple[Exact, Exact, Exact] | None:
        """Gamma of one member as an array gives it, of length 1 but for rounding; else None."""
        if self.gamma is None or not all(isinstance(x, np.ndarray) for x in self.gamma):
            return None
        a, b, c = (exactly(x[k]) for x in self.gamma)
        return a, b, c

    def exact(self) -> Block:
        """The same with rationals in the place of arrays."""

        def vector(of: Vector) -> Vector:
            a, b, c = (of_floats(x) if isinstance(x, np.ndarray) else x for x in of)
            return a, b, c

        gamma = None if self.gamma is None else vector(self.gamma)
        return replace(self, moments=vector(self.moments), omega=vector(self.omega), gamma=gamma)


def _sign(x: Column) -> Any:
    return x.sign if isinstance(x, Rationals) else sign(x)


def _unphysical(moments: Vector) -> Booleans:
    """Where no body has such moments; of arrays where rounding might hide it, too."""
    a, b, c = moments
    if any(isinstance(x, np.ndarray) for x in moments):
        a, b, c = np.broadcast_arrays(*(np.asarray(_near(x), np.float64) for x in moments))
        slack = 2.0**-50 * (np.abs(a) + np.abs(b) + np.abs(c))
        sums = (b + c - a, c + a - b, a + b - c)
        hidden: Booleans = np.minimum.reduce([a, b, c, *(x - slack for x in sums)]) <= 0
        return hidden
    signs = [_sign(x) <= 0 for x in moments]
    signs += [_sign(x + y - z) < 0 for x, y, z in ((a, b, c), (b, c, a), (c, a, b))]
    anywhere: Booleans = np.logical_or.reduce(np.broadcast_arrays(*signs))
    return anywhere


def _near(x: Column) -> Flat | float:
    return x.doubles() if isinstance(x, Rationals) else x if isinstance(x, np.ndarray) else float(x)


def _parts(column: ExactNumbers[Exact], array: bool) -> tuple[Rationals | Flat, Booleans | None]:
    """A column's rationals, and where there is another number in it (1 in its place).

    ``array``: whether an array stays one.
    """
    if column.floats is not None:
        return column.floats if array else of_floats(column.floats), None
    if column.ends is not None:
        first, last = column.ends
        if isinstance(first, Fraction) and isinstance(last, Fraction):
            step = (last - first) / max(1, len(column) - 1)
            top = step.numerator * first.denominator * np.arange(len(column)).astype(object)
            top = top + first.numerator * step.denominator
            return Rationals(top, first.denominator * step.denominator), None
    odd = np.array([not isinstance(x, Fraction) for x in column])
    rationals = of_fractions([x if isinstance(x, Fraction) else Fraction(1) for x in column])
    return rationals, odd if odd.any() else None

"""What a batch search watches: an expression on motions of many bodies, and heyoka's batch.

And what its crossings are: which of them are some, where exactly, and what rounding leaves.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from polhode.equations import kinematics
from polhode.equations.forms import principal
from polhode.equations.section_functions import SectionZero
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Number
from polhode.numbers.number_types import DOUBLE
from polhode.numbers.rows import Booleans, Doubles, Indices
from polhode.numbers.scalars import Functions, Scalar
from polhode.taylor.backend.engine import hy
from polhode.taylor.backend.heyoka_numbers import EXPRESSIONS, compact_beyond
from polhode.taylor.backend.types import HeyokaIntegrator
from polhode.taylor.batches.compiled_batch import LANES
from polhode.taylor.events.functions import TIME, in_columns, typed_constant
from polhode.taylor.events.jets import Formulas, Jet, Marks, jet_of
from polhode.taylor.events.polishing import MULTIPLE, ZEROS, Places, places, refined
from polhode.taylor.events.roundoff import BAND
from polhode.taylor.integrator.specification import DESK, integrator

#: The parameters of a batch, and of its jet: when the stretch began, what the first step adds to
#: the expression (a jet's other part of the time), and the numbers of :meth:`Watched.numbers`.
ORIGIN, TINY = range(DESK)

_LONG = 80  # operations of an expression whose code is compiled as loops
_TURN = tuple(f"turn{i}{j}" for i in range(3) for j in range(3))
_UNITS = "1/unit", "unit"
_BAND = BAND * DOUBLE.eps / 2

_CERTAIN = 2.0**-20  # of a section's function: extrema further from zero are no contacts
_SMALL = 1e-9  # of an expression's size: above it nothing is within rounding of zero
_TWICE = 2.0**-46  # times max(1, t): so near together two crossings are one, told twice


class Watched(NamedTuple):
    """An expression on motions of bodies with the same coefficients by name.

    ``columns``: of a state.  ``zero``: a section's function, in principal axes; or a text in
    columns and t, in the scene's axes, ``turned`` against those, and units.  ``size``: a power of
    two above its largest value and rate.  ``constants``: the coefficients where all motions are of
    one body; steps are shorter work with them than with parameters.
    """

    names: tuple[str, ...]
    columns: tuple[str, ...]
    zero: SectionZero | str
    size: float = 1.0
    turned: bool = False
    constants: tuple[float, ...] = ()

    @property
    def formulas(self) -> Formulas:
        """The expression and the motion, of parameters."""
        turn = _TURN if self.turned else ()
        named = {n: hy.par[i] for i, n in enumerate((*_UNITS, *self.names, *turn), DESK)}
        return Formulas(self.value, principal.field, lambda _: named)

    def numbers(self, time_unit: int, coefficients: Doubles, turns: Doubles | None) -> Doubles:
        """The numbers of motions, a column each: 1 / unit of time, unit, coefficients, turn."""
        unit = np.full((len(coefficients), 1), 2.0**time_unit)
        parts = [1 / unit, unit, coefficients]
        return np.hstack([*parts, turns] if turns is not None else parts).T

    def value(
        self,
        state: Sequence[Scalar],
        time: Scalar,
        numbers: Mapping[str, Scalar],
        constant: Callable[[Number], Scalar],
        fn: Functions,
    ) -> Scalar:
        """At a state in principal axes, for any scalar."""
        if isinstance(self.zero, SectionZero):
            return self.zero.value(state, fn, lambda x: constant(Fraction(x)))
        vectors = [
            kinematics.in_scene_axes(state[i : i + 3], numbers, fn.zero)
            for i in range(0, len(self.columns), 3)
        ]
        per_unit, unit = (numbers[name] for name in _UNITS)
        values = [*(per_unit * x for x in vectors[0]), *(x for v in vectors[1:] for x in v)]
        return in_columns(self.zero, self.columns, values, unit * time, constant, fn)


class Crossings(NamedTuple):
    """Crossings: in which lanes, when since their stretch began, slopes' signs, states (n, …).

    ``steps``: in which step of the batch.
    """

    lanes: Indices
    times: Doubles
    signs: Doubles
    states: Doubles
    steps: Indices

    def those(self, which: Booleans | Indices) -> Crossings:
        """Some of them."""
        return Crossings._make([array[which] for array in self])


def crossings_of(rows: Sequence[tuple[int, float, int, Doubles, int]], columns: int) -> Crossings:
    """Crossings from a row of each."""
    if not rows:
        none, nowhere = np.empty(0), np.empty(0, dtype=int)
        return Crossings(nowhere, none, none, np.empty((0, columns)), nowhere)
    return Crossings._make(map(np.array, zip(*rows, strict=True)))


def joined_crossings(parts: Sequence[Crossings]) -> Crossings:
    """Several as one, in this order."""
    return Crossings._make(map(np.concatenate, zip(*parts, strict=True)))


class Met:
    """heyoka's callbacks: the crossings of a stretch, and where its steps ended, as they come by.

    ``jet``: of the expression.  ``muted``: whether nothing is noted.
    """

    def __init__(self, jet: Jet) -> None:
        self.jet, self.muted = jet, False
        self._met: list[tuple[int, float, int, Doubles, int]] = []
        self._ends: list[tuple[Doubles, Doubles]] = []
        # views of the integrator's memory
        self._time: Doubles
        self._state: Doubles
        self._dense: Doubles

    def begin(self, ta: HeyokaIntegrator) -> None:
        """Forget all: a stretch begins here."""
        self._met.clear()
        self._ends.clear()
        self._time, self._state, self._dense = ta.time, ta.state, ta.d_output
        self.after_step(ta)

    def after_step(self, ta: HeyokaIntegrator) -> bool:
        """Note where a step ended."""
        self._ends.append((self._time.copy(), self._state.copy()))
        return True

    def __call__(self, ta: HeyokaIntegrator, time: float, sign: int, lane: int) -> None:
        """Note a crossing."""
        if not self.muted:
            ta.update_d_output(time)
            row = self._dense[:, lane].copy()
            self._met.append((lane, time, sign, row, len(self._ends) - 1))

    def found(self) -> Crossings:
        """The crossings."""
        return crossings_of(self._met, len(self._ends[0][1]))

    def ends(self) -> tuple[Doubles, Doubles]:
        """Times (steps + 1, lanes) and states (steps + 1, columns, lanes), from the begin on."""
        times, states = zip(*self._ends, strict=True)
        return np.array(times), np.array(states)

    def __deepcopy__(self, _: object) -> Met:
        return self  # heyoka copies its callbacks; each integrator has one


def built(watched: Watched) -> HeyokaIntegrator:
    """A batch whose callback, a :class:`Met`, is told the zeros of an expression."""
    variables, section = hy.make_vars(*watched.columns), isinstance(watched.zero, SectionZero)
    constant = _double if section else typed_constant(DOUBLE)
    formulas = watched.formulas
    numbers = formulas.numbers(constant)
    value = formulas.value(variables, TIME, numbers, constant, EXPRESSIONS)
    met = Met(jet_of(formulas, variables, DOUBLE, _BAND, constant))
    if watched.constants:
        numbers = dict(zip(watched.names, map(hy.expression, watched.constants), strict=True))
    field = principal.field(variables, numbers, EXPRESSIONS)
    scaled = value if section else value / hy.expression(watched.size)
    seen = hy.subs(scaled, {TIME: hy.time + hy.par[ORIGIN]}) + hy.par[TINY]
    event = hy.nt_event_batch(seen, met)
    options = {"nt_events": [event], **compact_beyond(_LONG, [value])}
    return integrator(list(zip(variables, field, strict=True)), DOUBLE, LANES, **options)


def _double(x: Number) -> Scalar:
    """A double as heyoka's constant, however small."""
    return hy.expression(to_double(x))


class Judge:
    """What crossings of an expression are, on motions that have ``numbers``, a column each."""

    def __init__(self, watched: Watched, jet: Jet, numbers: Doubles) -> None:
        self.watched, self._jet, self.numbers = watched, jet, numbers

    def jet(self, which: Indices) -> Jet:
        """The expression's jet on some motions."""
        return self._jet._replace(numbers=self.numbers[:, which])

    def near(self, which: Indices, values: Doubles, marks: Marks) -> Booleans:
        """Where the expression is within its rounding error of zero, on some motions."""
        near: Booleans = np.abs(values) < _SMALL * self.watched.size
        at = np.flatnonzero(near)
        if len(at):
            noise = self.jet(which[at]).noise(marks.those(at))
            near[at] = ~(np.abs(values[at]) > float(_BAND) * noise)
        return near

    def placed(self, which: Indices, marks: Marks, way: int) -> tuple[Places, Booleans]:
        """Polished crossings, and which of them are some for certain."""
        with np.errstate(all="ignore"):
            place = places(self.jet(which), marks, way, np.full(len(marks.time), True))
            return place, place.steep & (np.abs(place.values[0]) <= place.noise)

    def polished(self, which: Indices, marks: Marks, kind: int = ZEROS) -> Marks:
        """Crossings on some motions taken to their last digits."""
        with np.errstate(all="ignore"):
            return refined(self.jet(which), marks, np.full(len(marks.time), kind))

    def each_once(self, which: Indices, marks: Marks, met: Crossings) -> Crossings:
        """Crossings of a stretch in order, each once and without contacts.

        Of those without a certain slope the signs are put right.
        """
        if len(which) == 0:
            return met
        width = self._width(which, marks, met.signs)
        order = np.lexsort((np.abs(met.times), met.lanes))
        order = order[width[order] < np.inf]
        met, width = met.those(order), width[order]
        times = np.abs(met.times)
        apart = np.fmax(width[1:], width[:-1]) + _TWICE * np.fmax(1.0, times[1:])
        twice = (met.lanes[1:] == met.lanes[:-1]) & (np.diff(times) <= apart)
        return met.those(np.flatnonzero(np.insert(~twice, 0, True)[: len(width)]))

    def _width(self, which: Indices, marks: Marks, signs: Doubles) -> Doubles:
        """How wide crossings are, 0 with a certain slope, infinite for a contact."""
        width = np.zeros(len(which))
        with np.errstate(all="ignore"):
            _, slopes, bends, _ = self.jet(which).at(marks)
        small = np.flatnonzero(~(slopes * slopes > _CERTAIN * self.watched.size * np.abs(bends)))
        if len(small) == 0:
            return width
        which = which[small]
        marks = self.polished(which, marks.those(small))
        _, certain = self.placed(which, marks, 1)
        flat = self.polished(which, marks, MULTIPLE)
        place, _ = self.placed(which, flat, 1)
        jet = self.jet(which)
        with np.errstate(all="ignore"):
            apart = np.fmax(2 * place.width, _TWICE * np.fmax(1.0, np.abs(flat.since_start)))
            sides = [jet.relative(jet.moved(flat, way * apart))[0] for way in (-1, 1)]
        before, after = sides
        crosses = (np.minimum(np.abs(before), np.abs(after)) > place.noise) & (before * after < 0)
        width[small] = np.where(certain, 0.0, np.where(crosses, 4 * place.width, np.inf))
        signs[small] = np.where(certain, signs[small], np.sign(after))
        return width

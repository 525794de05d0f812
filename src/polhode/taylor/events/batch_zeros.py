"""What a batch search watches: an expression on motions of many bodies, and heyoka's batch."""

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
from polhode.taylor.events.jets import Formulas, Jet, Marks, jet_of, joined_marks
from polhode.taylor.events.roundoff import BAND
from polhode.taylor.integrator.specification import DESK, integrator

#: The parameters of a batch, and of its jet: when the stretch began, what the first step adds to
#: the expression (a jet's other part of the time), and the numbers of :meth:`Watched.numbers`.
ORIGIN, TINY = range(DESK)

_LONG = 80  # operations of an expression whose code is compiled as loops
_TURN = tuple(f"turn{i}{j}" for i in range(3) for j in range(3))
_UNITS = "1/unit", "unit"
_BAND = BAND * DOUBLE.eps / 2


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


class Notes(NamedTuple):
    """Places of motions in lanes: zeros of an expression as heyoka met them (``root``), and others.

    ``sides``: of the expression there, of a zero after it; 0 where that is not asked yet.
    """

    lanes: Indices
    marks: Marks
    root: Booleans
    sides: Doubles

    def those(self, which: Booleans | Indices | slice | list[int]) -> Notes:
        """Some of them."""
        marks = self.marks.those(which)
        return Notes(self.lanes[which], marks, self.root[which], self.sides[which])


def joined_notes(parts: Sequence[Notes]) -> Notes:
    """Several as one, in this order."""
    marks = joined_marks([part.marks for part in parts])
    lanes, root, sides = (np.concatenate([part[i] for part in parts]) for i in (0, 2, 3))
    return Notes(lanes, marks, root, sides)


class Met:
    """heyoka's callbacks: the zeros of a stretch as they come by, and where its steps ended.

    ``jet``: of the expression.
    """

    def __init__(self, jet: Jet) -> None:
        self.jet = jet
        self._zeros: list[tuple[int, float, Doubles, int]] = []  # the last: in which step
        self._ends: list[tuple[Doubles, Doubles]] = []
        # views of the integrator's memory
        self._time: Doubles
        self._state: Doubles
        self._dense: Doubles

    def begin(self, ta: HeyokaIntegrator) -> None:
        """Forget all: a stretch begins here."""
        self._zeros.clear()
        self._ends.clear()
        self._time, self._state, self._dense = ta.time, ta.state, ta.d_output
        self.after_step(ta)

    def after_step(self, _: HeyokaIntegrator) -> bool:
        """Note where a step ended."""
        self._ends.append((self._time.copy(), self._state.copy()))
        return True

    def __call__(self, ta: HeyokaIntegrator, time: float, _: int, lane: int) -> None:
        """Note a zero."""
        ta.update_d_output(time)
        self._zeros.append((lane, time, self._dense[:, lane].copy(), len(self._ends) - 1))

    def notes(
        self,
        lanes: Booleans,
        begun: Booleans,
        origin: Doubles,
        spared: Doubles,
        value: Callable[[Marks], Doubles],
    ) -> Notes:
        """All zeros of some lanes, where the stretch ended, and where those that ``begun`` began.

        Where the expression's ``value`` at a step's ends does not fit the zeros in it, the ends of
        all steps of that lane.  ``origin``: when the stretch began, in each lane; nothing up to
        ``spared`` after it.
        """
        times, states = (np.array(parts) for parts in zip(*self._ends, strict=True))
        moved = np.diff(times, axis=0, prepend=0.0) != 0
        ended = moved.copy()
        ended[0] = begun
        ended &= lanes & np.isfinite(times) & ~(np.abs(times) <= spared)
        every, count = np.zeros(times.size), times.size // len(times)
        columns = states.transpose(1, 0, 2).reshape(states.shape[1], -1)
        marks = Marks(np.tile(origin, len(times)), every, times.ravel(), every, columns)
        sides = np.sign(value(marks)).reshape(times.shape)
        places = [step * count + lane for lane, _, _, step in self._zeros]
        crossed = np.bincount(places, minlength=every.size).reshape(times.shape)[:-1] % 2 == 1
        lost = (moved[1:] & ((sides[1:] != sides[:-1]) != crossed)).any(axis=0)
        last = np.cumsum(ended[::-1], axis=0)[::-1] == 1
        last[0] |= begun
        ended &= lost | last
        step, lane = np.nonzero(ended)
        zeros = [z for z in self._zeros if lanes[z[0]] and not abs(z[1]) <= spared[z[0]]]
        root = np.repeat([True, False], [len(zeros), len(lane)])
        which = np.concatenate([np.array([z[0] for z in zeros], dtype=int), lane])
        time = np.concatenate([[z[1] for z in zeros], times[step, lane]])
        rows = np.array([z[2] for z in zeros]).reshape(len(zeros), states.shape[1])
        columns = np.concatenate([rows, states[step, :, lane]])
        none = np.zeros(len(time))
        marks = Marks(origin[which], none, time, none, columns.T)
        return Notes(which, marks, root, none.copy())

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

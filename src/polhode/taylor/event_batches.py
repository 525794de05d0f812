"""Events of many motions at once: zeros of an expression in a batch, and the search for them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from polhode.common.checkpoint import JobArrays
from polhode.common.interrupts import StopRequest
from polhode.equations import kinematics
from polhode.equations.forms import principal
from polhode.equations.section_functions import UNSURE, SectionZero, in_columns
from polhode.motion.outcomes import Outcome
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Number
from polhode.numbers.number_types import DOUBLE, Booleans, Doubles, Functions, Indices, Scalar
from polhode.taylor import event_decision, event_functions
from polhode.taylor.batches import LANES, Ended, LaneQueue, until
from polhode.taylor.defaults import first_step_offset
from polhode.taylor.engine import DESK, CompiledBatch, Desk, Engine, Equations, integrator, lent
from polhode.taylor.event_decision import Decision, End, Places, at_the_end, plain_lanes, polished
from polhode.taylor.event_functions import BAND, TIME, Formulas, Jet, Marks, jet_of, marks_at, rate
from polhode.taylor.event_watch import Callback, Probe
from polhode.taylor.heyoka import EXPRESSIONS, HeyokaIntegrator, compact_beyond, hy
from polhode.taylor.projection import Level, Put

# --- batch zeros ----------------------------------------------------------------------------------
#
# What a batch search watches: an expression on motions of many bodies, and heyoka's batch.


#: The parameters of a batch, and of its jet: when the stretch began, what the first step adds to
#: the expression (a jet's other part of the time), and the numbers of :meth:`Watched.numbers`.
ORIGIN, TINY = range(DESK)

_LONG = 80  # operations of an expression and its rate whose code is compiled as loops
_DAMPING = 2.0**-64  # of the rate: it takes no part in choosing the steps, however fast it is
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

    def numbers(self, exponent: int, coefficients: Doubles, turns: Doubles | None) -> Doubles:
        """The numbers of motions, a column each: 1 / unit of time, unit, coefficients, turn."""
        unit = np.full((len(coefficients), 1), 2.0**exponent)
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


def built(watched: Watched, extrema: bool = False) -> CompiledBatch:
    """A batch that meets the zeros of an expression, and of its rate where it is asked to."""
    variables, section = hy.make_vars(*watched.columns), isinstance(watched.zero, SectionZero)
    constant = _double if section else event_functions.typed_constant(DOUBLE)
    formulas, desk = watched.formulas, Desk()
    numbers = formulas.numbers(constant)
    value = formulas.value(variables, TIME, numbers, constant, EXPRESSIONS)
    desk.jets.append(jet_of(formulas, variables, DOUBLE, _BAND, constant))
    if watched.constants:
        numbers = dict(zip(watched.names, map(hy.expression, watched.constants), strict=True))
    field = principal.field(variables, numbers, EXPRESSIONS)
    scaled = value if section else value / hy.expression(watched.size)
    met = [scaled]
    if extrema:
        met.append(rate(scaled, variables, field) * hy.expression(_DAMPING))
    clock = {TIME: hy.time + hy.par[ORIGIN]}
    options: dict[str, Any] = compact_beyond(_LONG, met)
    options["nt_events"] = [
        hy.nt_event_batch(hy.subs(f, clock) + hy.par[TINY], Callback(desk, 0, order))
        for order, f in enumerate(met)
        if hy.get_variables([f])  # a constant has no zeros
    ]
    heyoka = integrator(list(zip(variables, field, strict=True)), DOUBLE, LANES, **options)
    return CompiledBatch(heyoka, desk=desk)


def _double(x: Number) -> Scalar:
    """A double as heyoka's constant, however small."""
    return hy.expression(to_double(x))


# --- batch search ---------------------------------------------------------------------------------
#
# Zeros of an expression along many motions at once: batches of doubles, stretch after stretch.
#
# heyoka's batch integrator tells the zeros of a stretch of time: for a section all of them in a
# direction, for a first zero the earliest. Where all are plain and fit the sides at the stretch's
# ends, they are crossings. Any other lane goes through the stretch once more, the extrema told,
# too, and the rule of runs decides (:mod:`polhode.taylor.event_decision`); what is noted after
# its last witness is decided about with the next stretch. The clock starts again from 0 at each
# stretch, so that a time is the stretch's start and a small rest; states of a section are put
# back on the first integrals there.
#
# A motion is *unsure* if a crossing was lost, or if its first zero is asked for and doubles do
# not tell the side on which it begins. Of two multiple zeros in one step heyoka may tell neither:
# whoever asks hands over the odd part of an expression
# (:func:`polhode.numbers.expression.odd_part`), which has such zeros only where a factor is
# squared or a product is multiplied out. What a lane gives does not depend on its neighbours.


DONE, NONE_LEFT, NON_FINITE = "all crossings", "no more crossings", "not finite"
STOPPED = "stopped"

_BLOCK = 2048  # crossings whose arrays fit into a processor's own memory


class Singular(ArithmeticError):
    """A section's function is not finite, or not real, on an orbit: ``start`` (6), at ``time``."""

    def __init__(self, start: tuple[float, ...], time: float) -> None:
        self.start, self.time = start, time
        super().__init__(start, time)


class SearchJob(NamedTuple):
    """Motions to be followed to so many zeros of what is ``watched``, or to ``end``.

    ``direction``: -1 falling, 1 rising, 0 any.  ``stretch``: the longest time between two looks;
    ``patience``: stretches without a zero until a motion is given up; ``max_steps``: of each.
    ``level``: for a section, on which the starts lie: the states are put back on these integrals.
    ``coefficients`` (n, names) and ``starts`` (n, columns) in principal axes and the unit of time
    2**``exponent``, which times are in.  ``turns``: (n, 9), from principal axes to the scene's,
    row by row; None where there is no turn.
    """

    watched: Watched
    direction: int
    most: int
    end: float
    stretch: float
    coefficients: Doubles
    starts: Doubles
    exponent: int = 0
    turns: Doubles | None = None
    patience: float = math.inf
    max_steps: int | None = None
    level: Level | None = None


class Crossed(NamedTuple):
    """Of each motion the crossings found, in order: nan where there are none.

    ``states`` (n, most, columns), ``times`` and ``rests`` (n, most): a time is their sum.
    ``found``: how many a motion has, ``steps`` taken.  ``outcomes``: how each ended; those UNSURE
    are to be done otherwise.
    ``drift``: the largest residual of an integral met, relative.
    """

    states: Doubles
    times: Doubles
    rests: Doubles
    found: npt.NDArray[np.int64]
    steps: npt.NDArray[np.int64]
    outcomes: tuple[str, ...]
    drift: float

    @classmethod
    def of(cls, arrays: JobArrays) -> Crossed:
        """From its arrays by name."""
        *numbers, outcomes, drift = arrays.values()
        return cls._make([*numbers, tuple(outcomes.tolist()), drift.item()])


def solve(job: SearchJob, stop: StopRequest | None = None) -> Crossed:
    """Follow a job's motions, as many at a time as a step advances; the next takes a free lane.

    Raises Singular for a section.
    """
    batch = lent(("zeros", job.watched), partial(built, job.watched))
    crossings = _Search(job, batch).run(stop)
    batch.release()
    return crossings


def joined(parts: Sequence[Crossed]) -> Crossed:
    """The results of several jobs as one."""
    arrays = [np.concatenate(array) for array in zip(*(part[:5] for part in parts), strict=True)]
    outcomes = tuple(outcome for part in parts for outcome in part.outcomes)
    return Crossed._make([*arrays, outcomes, max((part.drift for part in parts), default=0.0)])


#: A zero of the expression or of its rate: in which lane, when, and the state there.
_Note: TypeAlias = tuple[int, float, Doubles]


class _Stretch(NamedTuple):
    """What lanes met in a stretch of time: ``places`` in ``lanes``, in order.

    ``starts``, ``ends``: of the stretch, a place for each lane; ``done``: which came to its end,
    in so many ``steps``.
    """

    places: Places
    lanes: Indices
    starts: Places
    ends: Places
    done: Booleans
    steps: npt.NDArray[np.int64]


class _Search:
    """A job's motions in the lanes of a batch."""

    def __init__(self, job: SearchJob, batch: Engine) -> None:
        self.job, self.batch, n = job, batch, len(job.starts)
        self.numbers = job.watched.numbers(job.exponent, job.coefficients, job.turns)
        stretches = max(1.0, np.ceil(abs(job.end) / job.stretch))
        self.length = job.stretch if stretches == math.inf else job.end / stretches
        self.way = 1 if self.length > 0 else -1
        self.last = stretches
        self.lanes = LaneQueue(n)
        self.parameters = np.zeros((DESK + len(self.numbers), LANES))
        self.state = job.starts[self.lanes.motion].T.copy()
        self.put = None if job.level is None else Put(job.level, self.state)
        self.parts, self.counts, self.quiet = np.zeros((3, LANES), dtype=int)
        # of each lane: when its stretch began, and the expression's side at the last witness
        self.origin, self.side = np.zeros((2, LANES))
        # zeros and extrema of a stretch as heyoka meets them, in lanes that are heard
        self.notes = list[_Note](), list[_Note]()
        self.heard, self.dense = self.lanes.busy, batch.heyoka.d_output
        # of lanes with no witness at the last stretch's end: the one before, and the places since
        self.since: dict[int, tuple[End, list[Places]]] = {}
        self.crossings: list[tuple[Indices, Marks]] = []  # and whose they are
        self.steps = np.zeros(n, dtype=np.int64)
        self.outcomes = [STOPPED] * n
        for lane in range(LANES):
            self._begin(lane)

    def run(self, stop: StopRequest | None) -> Crossed:
        """All of them."""
        self.lanes.follow(self._begin, lambda: self._stretch(stop), stop)
        return self._crossed()

    def met(self, lane: int, order: int, ta: HeyokaIntegrator, t: float) -> None:
        """heyoka met a zero of the expression (0) or of its rate (1) in the step just taken."""
        if self.heard[lane]:
            ta.update_d_output(t)
            self.notes[order].append((lane, t, self.dense[:, lane].copy()))

    def _begin(self, lane: int) -> None:
        k = self.lanes.motion[lane]
        self.state[:, lane] = self.job.starts[k]
        self.parts[lane] = self.counts[lane] = self.quiet[lane] = 0
        self.since.pop(lane, None)
        self.parameters[DESK:, lane] = self.numbers[:, k]
        if self.put is not None and self.lanes.busy[lane]:
            self.put.begin([lane], self.state[:, [lane]])

    # -- a stretch of time ----------------------------------------------------------------------

    def _stretch(self, stop: StopRequest | None) -> list[int] | None:
        """Go on by a stretch of time: the lanes whose motions are over; None where stopped."""
        busy, starts, unsure = self.lanes.busy, self.state, np.zeros(LANES, dtype=bool)
        self.origin = self.parts * self.length
        met = self._followed(self.batch, busy, starts, stop)
        if met is None:
            return None
        self.quiet += 1
        rest, steps = busy & ~self._plain(met), met.steps
        if rest.any():
            others = self.state
            watched = self.job.watched
            batch = lent(("extrema", watched), partial(built, watched, extrema=True))
            met = self._followed(batch, rest, starts, stop)
            batch.release()
            if met is None:
                return None
            self.state = np.where(rest, self.state, others)
            for lane in np.flatnonzero(rest).tolist():
                unsure[lane] = not self._decided(lane, met)
        self.parts += 1
        self.steps[self.lanes.motion[busy]] += steps[busy]
        if self.put is not None:
            self.state = self.put.back(self.state)
        return self._over(unsure)

    def _over(self, unsure: Booleans) -> list[int]:
        """The lanes whose motions are over."""
        lost: Booleans = ~np.all(np.isfinite(self.state), axis=0)
        done, ended = self.counts >= self.job.most, self.parts >= self.last
        over = unsure | lost | done | ended | (self.quiet >= self.job.patience)
        lanes: list[int] = np.flatnonzero(self.lanes.busy & over).tolist()
        for lane in lanes:
            outcome = NON_FINITE if lost[lane] else DONE if done[lane] else NONE_LEFT
            self.outcomes[self.lanes.motion[lane]] = UNSURE if unsure[lane] else outcome
        return lanes

    def _followed(
        self, batch: Engine, which: Booleans, starts: Doubles, stop: StopRequest | None
    ) -> _Stretch | None:
        """What some lanes of a batch meet in the stretch; None where stopped.  Raises Singular."""
        self.parameters[ORIGIN] = self.origin
        batch.parameters[:] = self.parameters[: len(batch.parameters)]  # those that it asks for
        batch.state[:] = starts
        batch.begin()
        assert batch.desk is not None
        batch.desk.watch, self.heard, self.dense = self, which, batch.heyoka.d_output
        for notes in self.notes:
            notes.clear()
        ended = self._onwards(batch, which, stop)
        if ended is None:
            return None
        self.state = batch.state.copy()
        every = np.arange(len(which))
        begun = self._marks(every, np.zeros(len(which)), starts)
        known = event_functions.joined_marks(
            [begun, self._marks(every, batch.heyoka.time, self.state)]
        )
        zeros, extrema = self._met(0), self._met(1)
        lanes, jet = np.concatenate([zeros[0], extrema[0]]), batch.desk.jets[0]
        places, seen = polished(jet, [zeros[1], extrema[1]], known, self.way)
        first, last = seen.those(slice(len(which))), seen.those(slice(len(which), None))
        spared = self._begun(which & (self.parts == 0), first)
        order = np.lexsort((places.ahead, lanes))
        order = order[~(places.ahead <= spared[lanes])[order]]
        done = np.array([outcome is Outcome.REACHED_END for outcome in ended.outcomes])
        return _Stretch(places.those(order), lanes[order], first, last, done, ended.steps)

    def _begun(self, new: Booleans, starts: Places) -> Doubles:
        """Note the sides on which motions begin, 0 where that is not certain.

        Of each lane up to when a zero is the start itself.
        """
        value, slope = starts.values[:2]
        own = new & starts.own
        sides = np.where(own, np.sign(slope) * self.way, np.sign(value))
        sides[starts.near & ~(own & starts.steep) | np.isnan(sides)] = 0.0
        self.side = np.where(new, sides, self.side)
        return np.where(
            own, 2 * starts.reach.astype(np.float64) + event_decision.ULPS * float(DOUBLE.eps), -1.0
        )

    def _onwards(self, batch: Engine, which: Booleans, stop: StopRequest | None) -> Ended | None:
        """Some lanes brought to the stretch's end; None where stopped.  Raises Singular."""
        most, running = self.job.max_steps, self.lanes.motion[self.lanes.busy]
        left = None if most is None else max(1, most - int(self.steps[running].max()))
        first, taken = which & (self.parts == 0), np.zeros(len(which), dtype=np.int64)
        ends = np.where(which, self.length, 0.0).tolist()
        if first.any():
            batch.parameters[TINY] = float(first_step_offset(DOUBLE)) * first
            taken = until(batch.heyoka, ends, 1, stop).steps
            batch.parameters[TINY] = 0.0
            left = None if left is None else max(1, left - 1)
        ended = until(batch.heyoka, ends, left, stop)
        if self.put is not None and Outcome.STEP_UNDERFLOW in ended.outcomes:
            lane = ended.outcomes.index(Outcome.STEP_UNDERFLOW)
            start = tuple(self.job.starts[self.lanes.motion[lane]].tolist())
            raise Singular(start, float(self.origin[lane] + batch.heyoka.time[lane]))
        return None if ended.stopped else ended._replace(steps=taken + ended.steps)

    # -- crossings ------------------------------------------------------------------------------

    def _plain(self, met: _Stretch) -> Booleans:
        """The lanes with plain zeros alone that fit the sides at both ends: these are crossings."""
        places, lanes = met.places, met.lanes
        last = np.where(met.ends.near | ~met.done, 0.0, np.sign(met.ends.values[0]))
        plain, sides = plain_lanes(places, lanes, self.side, last, self.way)
        plain[list(self.since)] = False
        crossed = plain[lanes] & (sides * self.way * self.job.direction >= 0)
        self._keep(lanes[crossed], places.marks.those(crossed))
        self.side = np.where(plain, last, self.side)
        return plain

    def _decided(self, lane: int, met: _Stretch) -> bool:
        """Decide about a lane up to its last witness by the rule of runs; whether for certain."""
        begun = met.starts.those(slice(lane, lane + 1))
        start, parts = self.since.pop(lane, (End(int(self.side[lane]), begun), []))
        parts.append(met.places.those(slice(*np.searchsorted(met.lanes, [lane, lane + 1]))))
        end = at_the_end(met.ends.those(slice(lane, lane + 1)))
        sure = bool(met.done[lane]) or self.put is not None
        if end.near and self.parts[lane] + 1 < self.last and np.isfinite(end.value):
            self.since[lane] = start, parts
            return sure
        k, places = int(self.lanes.motion[lane]), event_decision.joined_places(parts)
        places = places.those(places.order)
        search = partial(self._found_again, k, places, start, end)
        decision = Decision(places, start, end, self.way, float(DOUBLE.eps), search)
        wanted = self.way * self.job.direction
        signs = decision.happenings.signs
        crossings = decision.happenings.those(np.flatnonzero((signs != 0) & (signs * wanted >= 0)))
        self._keep(np.full(len(crossings.at), lane), crossings.located(places).marks)
        sure &= start.side != 0 or self.put is not None
        self.side[lane] = end.side
        return sure and decision.complete

    def _keep(self, lanes: Indices, marks: Marks) -> None:
        """Keep crossings in lanes, as many as their motions still need."""
        nth = np.arange(len(lanes)) - np.searchsorted(lanes, lanes)
        kept = nth < self.job.most - self.counts[lanes]
        if kept.any():
            marks = marks._replace(parameters=marks.parameters[:2])  # only the time is asked for
            self.crossings.append((self.lanes.motion[lanes[kept]], marks.those(kept)))
        self.counts += np.bincount(lanes[kept], minlength=len(self.counts))
        self.quiet[lanes] = 0

    def _found_again(
        self, k: int, places: Places, start: End, end: End, side: int, since: int, before: int
    ) -> Places | None:
        """A crossing of motion k that heyoka lost: along steps of its own, without the others."""
        job = self.job
        assert self.batch.desk is not None
        jet: Jet = self.batch.desk.jets[0]._replace(timed=False)
        ta = lent(Equations(job.watched.columns, job.watched.names))
        ta.state[:] = job.starts[k]
        ta.begin(job.coefficients[k])
        probe, span = Probe(jet, ta.heyoka, len(job.watched.columns)), (start.place, end.place)
        crossing = probe.crossing(places, *span, self.way, side, since, before)
        ta.release()
        return crossing

    def _met(self, order: int) -> tuple[Indices, Marks]:
        """What heyoka met in the stretch, and in which lanes."""
        notes = self.notes[order]
        lanes = np.array([lane for lane, _, _ in notes], dtype=int)
        rows = np.array([row for _, _, row in notes]).reshape(len(notes), len(self.state))
        return lanes, self._marks(lanes, np.array([t for _, t, _ in notes]), rows.T)

    def _marks(self, lanes: Indices, time: Doubles, columns: Doubles) -> Marks:
        """Places of the stretch, by heyoka's time."""
        clocks = np.stack([self.origin[lanes], np.zeros(len(lanes))])
        numbers = self.numbers[:, self.lanes.motion[lanes]]
        return marks_at(time, columns, np.concatenate([clocks, numbers]))

    def _crossed(self) -> Crossed:
        """All crossings in order, those of a section put on it."""
        job, (n, columns) = self.job, self.job.starts.shape
        states = np.full((n, job.most, columns), np.nan)
        times, rests = (np.full((n, job.most), np.nan) for _ in range(2))
        counts = np.zeros(n, dtype=int)
        if self.crossings:
            motions = np.concatenate([which for which, _ in self.crossings])
            marks = event_functions.joined_marks([marks for _, marks in self.crossings])
            order = np.lexsort((np.abs(marks.since_start), motions))
            motions, marks = motions[order], marks.those(order)
            blocks = [slice(k, k + _BLOCK) for k in range(0, len(motions), _BLOCK)]
            parts = [self._put_on(motions[some], marks.columns[:, some]) for some in blocks]
            rows = np.concatenate(parts, axis=1)
            taus = marks.time + marks.rest
            origins = marks.parameters[0]
            time = origins + taus
            kept = np.abs(time) <= abs(job.end)
            nth = np.arange(len(motions)) - np.searchsorted(motions, motions)
            where = motions[kept], nth[kept]
            times[where], rests[where] = time[kept], (taus - (time - origins))[kept]
            states[where] = rows[:, kept].T
            counts = np.bincount(motions[kept], minlength=n)
        drift = 0.0 if self.put is None else self.put.drift
        return Crossed(*(states, times, rests, counts, self.steps), tuple(self.outcomes), drift)

    def _put_on(self, which: Indices, states: Doubles) -> Doubles:
        """States of crossings of motions, those of a section put on it and its level."""
        if self.put is None:
            return states
        assert isinstance(self.job.watched.zero, SectionZero)
        whole = Put(self.put.level, self.job.starts.T).of(which)
        return whole.within(self.job.watched.zero, states)

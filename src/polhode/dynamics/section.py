"""Sections of a level: where many orbits of one body cross it, and in which coordinates."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

import numpy as np

from polhode.common.arguments import whole, with_progress
from polhode.common.checkpoint import JobCheckpoint
from polhode.common.errors import BadInput, counted, plain
from polhode.common.interrupts import Progress
from polhode.common.processes import cores, run_jobs
from polhode.common.values import ByValue, cached_property, refuse_too_much
from polhode.dynamics.level_body import LevelBody, tangents_of
from polhode.dynamics.starts import (
    Cut,
    cell_centres,
    coordinates,
    cut_of,
    height_coordinates,
    momentum_states,
    starts_of,
)
from polhode.equations.forms import principal
from polhode.equations.integrals import CHAPLYGIN, FirstIntegrals, first_integrals
from polhode.equations.section_functions import HEIGHT, MOMENTUM, UNSURE, SectionZero
from polhode.numbers.conversion import to_extended
from polhode.numbers.exact import Exact
from polhode.numbers.expression import odd_part
from polhode.numbers.number_types import DOUBLE, AnyNumber, AnyVector, Doubles, Integers
from polhode.results.cells import TEXT
from polhode.results.result import Result
from polhode.results.table import Column, Fact, Table
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import provenance_fact, row_columns, scene_facts, time_column
from polhode.scenes.vocabulary import REQUESTS, STATE
from polhode.taylor import event_batches, variations
from polhode.taylor.event_batches import SearchJob, Singular, Watched
from polhode.taylor.projection import ARRAYS, TINY, Level
from polhode.taylor.system import refuse_other_rounding

# --- jobs -----------------------------------------------------------------------------------------
#
# The jobs of a section: orbits and the level they keep to, plain data to be sent anywhere.


LANES = 64  # orbits of a job: where one is over the next takes its lane
CHUNK = 160.0  # radians of the fastest rate between two projections
WORTH_A_PROCESS = 200_000  # crossings, of two seconds
PATIENCE = 1000.0  # the level's units of time without a crossing until an orbit is given up


def jobs_of(
    on: LevelBody, zero: SectionZero, direction: int, count: int, states: Doubles
) -> list[SearchJob]:
    """The jobs of orbits from ``states``, LANES of them each.

    What is a step, and what rounding adds up to in it, is measured by the unit of time.
    """
    constants = tuple(on.numbers.values())
    watched = Watched((*on.numbers,), STATE, zero, constants=constants)
    own = np.tile(constants, (len(states), 1))
    chunk = 2.0 ** round(np.log2(CHUNK / (on.fastest or 1.0)))
    patience, level = int(-(-PATIENCE // chunk)), integrals_of(on)
    return [
        SearchJob(
            *(watched, direction, count, np.inf, chunk, own[first : first + LANES]),
            states[first : first + LANES],
            patience=patience,
            level=level,
        )
        for first in range(0, len(states), LANES)
    ]


def integrals_of(on: LevelBody) -> Level:
    """The integrals that orbits are put back to: those of a scene on the level."""
    conserved = first_integrals(on.inside)
    if CHAPLYGIN in conserved.onto and on.f != 0:
        conserved = FirstIntegrals(conserved.onto[:-1], conserved.order, conserved.coefficients)
    h, f = on.exact_level
    coefficients = {name: to_extended(x) for name, x in conserved.coefficients.items()}
    return Level(conserved, coefficients, tuple(to_extended(x) for x in (2 * h, f, Fraction(1))))


def zero_of(on: LevelBody, by: str) -> SectionZero:
    """A section's function, scaled to order one; of an expression the odd part."""
    side = -1.0 if on.weight < 0 and by != HEIGHT else 1.0
    size = on.largest_momentum if by == MOMENTUM else on.fastest
    a, b, c = on.moments.tolist()
    x, y, z = (side * on.arm_axes[2] / (size or 1.0)).tolist()
    rows = tuple(map(tuple, on.frame.matrix(DOUBLE).tolist()))
    return SectionZero(odd_part(by), (a, b, c), (x, y, z), rows, float(on.unit))


def worker_count(jobs: int, crossings: int) -> int:
    """Processes: as many as pay, for each costs half a second to begin.

    Threads would not do: at every crossing they wait for each other.
    """
    return max(1, min(cores(), jobs, jobs * LANES * crossings // WORTH_A_PROCESS))


# --- crossing accuracy ----------------------------------------------------------------------------
#
# How many digits a crossing has: what the motion makes of a rounding on the way to it.
#
# One tangent u along each orbit, across the flow and the gradients of h, f and |gamma|^2, on
# whose values the orbit is kept:
#
#     G(t) = max over s <= t' <= t of |u(t')| / |u(s)|,    digits(t) = -log10(eps G(t))
#
# from 0 to those of a double: what one rounding on the way is multiplied by. Where the orbit
# grazes the section, an error across it moves the crossing along the orbit by |x'| |grad z|/|z'|
# of itself, z the section's function; G is multiplied by what of that exceeds STRAIGHT. A run
# makes many, and the tangent has one direction of two: found were from two digits fewer to one
# more, of the state at the crossing. On a chaotic orbit G grows exponentially, and from some
# crossing on no digit is left: later ones are those of a neighbour, right for pictures and
# statistics and not this orbit's. w counts in radians of the inner unit of time, gamma as it is;
# G is taken at looks, each crossing's at the next one.


EPS = 2.0**-52
LOOK = 8.0  # units of the inner time between two looks at the tangent
STRAIGHT = 10.0  # so much more does the scatter of errors hide
LOST = math.log(1 / EPS)  # of ln G


def digits(on: LevelBody, starts: Doubles, times: Doubles, slants: Doubles) -> Doubles:
    """Correct digits to be expected of each crossing, nan where there is none: (n, m).

    ``starts`` (n, 6); ``times`` (n, m): of the crossings, nan past an orbit's last one.  ``slants``
    (n, m): see :func:`slant`.
    """
    digits_left: Doubles = np.full(times.shape, np.nan)
    is_crossing = np.isfinite(times)
    grazing = np.log(np.maximum(slants / STRAIGHT, 1.0))
    last = np.where(is_crossing, times, 0.0).max(axis=1, initial=0.0)
    orbits = np.argsort(last, kind="stable")
    orbits = orbits[last[orbits] > 0]
    if len(orbits) == 0:
        return digits_left
    names, constants = tuple(on.numbers), [*on.numbers.values()]
    groups = [orbits[first : first + LANES] for first in range(0, len(orbits), LANES)]
    jobs, spans = [], []
    for group in groups:
        # no further than the last crossing: on a high level a whole look holds millions of turns
        span = min(LOOK, float(last[group].max()))
        spans.append(span)
        looks = math.ceil(last[group].max() / span)
        first = tangents_of(starts[group], on.moments, on.torque, alike=True)
        coefficients = np.tile(constants, (len(group), 1))
        end, early = looks * span, tuple(range(2, looks, 2))
        jobs.append(
            variations.TangentJob(
                names, coefficients, starts[group], first, end, looks, None, early, LOST
            )
        )
    finished = run_jobs(variations.solve, jobs, [len(group) for group in groups])
    if finished.interrupted:
        raise KeyboardInterrupt
    for group, span, result in zip(groups, spans, finished.done, strict=True):
        least = np.minimum.accumulate(np.where(np.isfinite(result.sizes), result.sizes, np.inf), 1)
        grown = np.where(np.isfinite(result.sizes), result.sizes - least, LOST)
        grown = np.maximum.accumulate(grown, axis=1)
        looks_at = np.ceil(np.where(is_crossing[group], times[group], 0.0) / span).astype(int)
        at = np.take_along_axis(grown, looks_at, axis=1)
        right = np.clip((LOST - at - grazing[group]) / math.log(10), 0.0, DOUBLE.most_digits)
        digits_left[group] = np.where(is_crossing[group], right, np.nan)
    return digits_left


def slant(on: LevelBody, zero: SectionZero, states: Doubles) -> Doubles:
    """|x'| |grad z|/|z'| of states (n, m, 6), w measured by its bound."""
    scales = np.array([on.fastest or 1.0] * 3 + [1.0] * 3)
    x = np.moveaxis(states, -1, 0)
    steps = TINY * 1j * np.diag(scales)[:, :, None, None]
    across = slope = speed = 0.0 * x[0]
    with np.errstate(all="ignore"):
        rates = principal.field([*x], on.numbers, ARRAYS)
        for step, rate, scale in zip(steps, rates, scales, strict=True):
            gradient = np.imag(zero.value([*(x + step)], ARRAYS)) / TINY
            across = across + gradient**2
            slope = slope + gradient * rate / scale
            speed = speed + (rate / scale) ** 2
        slants: Doubles = np.sqrt(across * speed) / np.abs(slope)
    return slants


# --- section --------------------------------------------------------------------------------------


MOST_CROSSINGS = 1_000_000
_RATIO = "cosine of the angle between r0 and the angular momentum"
_BYTES = 400  # of a crossing, while it is found and put in order
_STEP = 1e-8  # along the motion, a complex one: of numbers of 1e-300, too, some digits are left


@dataclass(frozen=True, repr=False, eq=False)
class Section(Result, ByValue):
    """Crossings of a section by orbits on one level, one row per orbit; nan after its last one.

    ``by``: momentum, height, or an expression.  ``starts`` (n, 2): coordinates of the starts;
    ``start_states`` (n, 6): their states, like those of the crossings.
    ``states`` (n, m, 6): p q r gamma1 gamma2 gamma3 in the scene's axes and units.  ``times``,
    ``times_low`` (n, m): a time is the sum of both.  ``l``, ``L_over_G`` (n, m): Andoyer's angle l
    and L/G about r0.  ``counts`` (n,): the crossings of each orbit; ``outcomes``: how each orbit
    ended.  ``drift``: the largest residual of h, f and |gamma|^2 before a projection, relative.
    ``accuracy``: whether its table has the digits that are expected of each crossing.

    >>> import numpy as np
    >>> import polhode
    >>> found = polhode.section("lagrange/nutation", starts=[[1, 0.2]], crossings=20)
    >>> found
    <Section of lagrange/nutation by momentum: 1 orbit, 20 crossings>
    >>> bool(np.ptp(found.L_over_G[0]) < 1e-14)  # L is an integral, and so is G
    True
    """

    scene: Scene
    h: Exact
    f: Exact
    by: str
    extremum: str
    starts: Doubles
    start_states: Doubles
    states: Doubles
    times: Doubles
    times_low: Doubles
    l: Doubles
    L_over_G: Doubles
    counts: Integers
    outcomes: tuple[str, ...]
    drift: float
    interrupted: bool = False
    kept: JobCheckpoint | None = None
    provenance: Mapping[str, object] = field(default_factory=dict)
    accuracy: bool = True

    def __repr__(self) -> str:
        orbits = counted(len(self.counts), "orbit")
        crossings = counted(int(self.counts.sum()), "crossing")
        return f"<Section of {self.scene.name} by {self.by}: {orbits}, {crossings}>"

    @cached_property
    def digits(self) -> Doubles:
        """Expected correct digits of each crossing's state, nan after the last one: (n, m).

        From the growth of a rounding error since the start, estimated by one tangent along each
        orbit, which takes as long as the section itself, or longer: :func:`section` does it unless
        ``accuracy`` is False, and they are then computed when first asked for.  All are nan for a
        section that was interrupted.

        >>> import polhode
        >>> scene = polhode.load("general/asymmetric-chaotic")
        >>> found = polhode.section(scene, starts="scene", crossings=80)
        >>> [bool(found.digits[0, m] > 8) for m in (0, 19, 59)], 40 < found.none_left_from[0] < 80
        ([True, True, False], np.True_)
        """
        if self.interrupted:
            return self.times * float("nan")
        on = LevelBody(self.scene, self.h, self.f).in_own_time
        slants = slant(on, zero_of(on, self.by), on.within(self.states))
        return digits(on, on.within(self.start_states), self.times / float(on.unit), slants)

    @property
    def none_left_from(self) -> Integers:
        """The number, from 1 on, of each orbit's first crossing without a digit.

        0: of none, or of a section that was interrupted, whose digits are not known.
        """
        gone = self.digits < 1
        return np.where(gone.any(axis=1), gone.argmax(axis=1) + 1, 0)

    @property
    def complete(self) -> bool:
        """Whether every orbit made all its crossings, and none may be lost."""
        all_made = bool((self.counts == self.times.shape[1]).all())
        return all_made and not self.interrupted and UNSURE not in self.outcomes

    def table(self) -> Table:
        """One row per crossing: its orbit, time, coordinates, and state."""
        there = np.arange(self.times.shape[1]) < self.counts[:, None]
        orbit, crossing = np.nonzero(there)
        columns = [
            Column("orbit", orbit + 1),
            Column("crossing", crossing + 1, "number of the crossing of its orbit"),
            time_column(self.scene, (self.times + self.times_low)[there], DOUBLE, digits=15),
            Column("l", self.l[there], "Andoyer's angle about r0", "rad", digits=15),
            Column("L_over_G", self.L_over_G[there], _RATIO, digits=15),
        ]
        if self.accuracy:
            digits = self.digits[there]
            columns.append(Column("digits_expected", digits, "correct digits", digits=3))
        states = self.states[there]
        return Table([*columns, *row_columns(self.scene, STATE, states, DOUBLE, digits=0)], 2)

    def facts(self) -> list[Fact]:
        """The level, the section, and of each orbit its start and its end."""
        first, second = ("azimuth", "cosine") if self.by == "height" else ("l", "L_over_G")
        starts = [f"start_{name}" for name in (first, second, *STATE)]
        values = np.concatenate([self.starts, self.start_states], axis=1)
        orbits = [
            Column("orbit", np.arange(1, len(self.counts) + 1)),
            *(Column(name, values[:, k]) for k, name in enumerate(starts)),
            Column("crossings", self.counts),
            Column("outcome", self.outcomes, type=TEXT),
        ]
        if self.accuracy:
            meaning = "first crossing without a digit, 0 for none"
            orbits.append(Column("none_left_from", self.none_left_from, meaning))
        return [
            *scene_facts(self.scene),
            Fact("h", self.h, "energy"),
            Fact("f", self.f, "vertical momentum"),
            Fact("by", self.by, "what makes the section"),
            Fact("extremum", self.extremum),
            Fact("drift", self.drift, "largest residual of h, f and |gamma|^2, relative"),
            Fact("complete", self.complete, "whether every orbit made all its crossings"),
            Fact("orbits", Table(orbits)),
            provenance_fact(self.provenance),
        ]


@with_progress
def section(
    scene: Scene | str | Path,
    by: str | None = None,
    extremum: str | None = None,
    starts: Iterable[AnyVector] | str | Path | None = None,
    grid: tuple[int, int] | None = None,
    crossings: int | None = None,
    h: AnyNumber | None = None,
    f: AnyNumber | None = None,
    workers: int | None = None,
    executor: Executor | None = None,
    parts: str | Path | None = None,
    progress: Progress | None = None,
    accuracy: bool = True,
) -> Section:
    """Follow orbits of a scene's body on a level to their crossings of a section.

    Arguments that are left out have the values of the scene's [section].

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, a path, or the name of a case.
    by : str, optional
        "momentum" (extrema of |G|, taken unless given) or "height" (extrema of r0·gamma), both of
        which every orbit crosses; or an expression in p q r gamma1 gamma2 gamma3, whose zeros in
        either direction are taken.
    extremum : {"max", "min"}, optional
        Which extrema are crossings, max unless given.
    starts : iterable of vectors, "scene" or path, optional
        "scene" for the scene's own start, or a text file with one start per line.  Or rows: [l,
        L/G], or [l, L/G, k], the k-th of several by rising y, for momentum and expressions;
        [gamma1, gamma2, gamma3, ±1] in the scene's axes for height.
    grid : tuple of int, optional
        Cells of both coordinates, with starts in their centres (9x8 by default).
    crossings : int, optional
        The number of crossings of each orbit.
    h, f : number, optional
        The level's energy h or vertical momentum f, if not the scene's.
    workers : int, optional
        Processes, as many as there are cores unless given.
    executor : Executor, optional
        An executor of ``concurrent.futures`` instead.
    parts : str or Path, optional
        A folder for finished jobs, from which the same call continues after a kill.
    progress : callable, optional
        Called with the fraction done and the orbits done.
    accuracy : bool
        Whether to estimate the correct digits of each crossing, at about the section's own cost.

    Returns
    -------
    Section
        The crossings of each orbit: states in the scene's body axes, times and the section's
        coordinates.

    Raises
    ------
    BadInput
        A level that does not exist, a start outside the section, an expression that does not change
        or is never zero.

    Examples
    --------
    >>> import polhode
    >>> scene = polhode.load("general/asymmetric-chaotic")
    >>> found = polhode.section(scene, grid=(2, 2), crossings=5, h=3, f="1/2")
    >>> found.states.shape
    (4, 5, 6)
    """
    scene = library.load(scene, takes=REQUESTS)
    refuse_other_rounding(scene)
    if workers is not None:
        workers = whole(scene.name, "workers", workers, 1)
    if starts is not None and grid is not None:
        raise BadInput(scene.name, "grid", plain(grid), "no grid together with starts")
    plan, cut = scene.section, cut_of(scene, by, extremum, h, f)
    if extremum is not None and cut.by not in (MOMENTUM, HEIGHT):
        expected = "none beside an expression, whose zeros are taken in either direction"
        raise BadInput(scene.name, "extremum", extremum, expected)
    count = plan.crossings if crossings is None else crossings
    count = whole(scene.name, "crossings", count, 1, MOST_CROSSINGS)
    if starts is None and grid is None and plan.starts:
        starts = plan.starts
    on = cut.on.in_own_time
    cut = cut._replace(on=on)

    def forecast(orbits: int, more_than: str = "") -> None:
        work = f"{more_than}{orbits} orbits to {count} crossings"
        words = "crossings in all; a coarser grid, or fewer of each orbit"
        refuse_too_much(scene.name, "section", work, orbits * count, _BYTES, words)

    initial = starts_of(cut, starts, grid, lambda orbits: forecast(orbits, "more than "))
    forecast(len(initial.states))
    zero = zero_of(on, cut.by)
    direction = 0
    if cut.by in (MOMENTUM, HEIGHT):
        direction = -1 if cut.maxima else 1
    _refuse_constant(cut, zero, initial.states)
    jobs = jobs_of(on, zero, direction, count, initial.states)
    key = scene.text, str((on.h, on.f, *cut[1:])), count, direction, initial.states
    checkpoint = JobCheckpoint.at(parts, "section", *key)
    with _refused(cut, checkpoint):
        finished = run_jobs(
            event_batches.solve,
            jobs,
            [len(job.starts) for job in jobs],
            workers or worker_count(len(jobs), count),
            executor,
            checkpoint,
            event_batches.Crossed._asdict,
            event_batches.Crossed.of,
            progress,
            processes=True,
        )
    crossed = event_batches.joined(finished.done)
    if cut.by not in (MOMENTUM, HEIGHT) and not crossed.found.any():
        with _refused(cut, checkpoint):
            _refuse_never_zero(cut, zero)
    states = initial.states[finished.rows]
    angles = height_coordinates if cut.by == HEIGHT else coordinates
    l, ratio = coordinates(on, crossed.states)
    unit = float(on.unit)
    result = Section(
        scene,
        on.h,
        on.f,
        *cut[1:],
        np.stack(angles(on, states), axis=-1),
        on.outside(states),
        on.outside(crossed.states),
        crossed.times * unit,
        crossed.rests * unit,
        l,
        ratio,
        crossed.found,
        crossed.outcomes,
        crossed.drift,
        finished.interrupted,
        checkpoint,
        scene.provenance(),
        accuracy,
    )
    if accuracy:
        _ = result.digits
    return result


def _refuse_constant(cut: Cut, zero: SectionZero, states: Doubles) -> None:
    """Raise BadInput for an expression that has no value at a start, or no rate at any of them."""
    if cut.by in (MOMENTUM, HEIGHT):
        return
    moved = states.T + 1e-3 * np.random.default_rng(0).normal(size=states.T.shape)
    try:
        with np.errstate(all="ignore"):
            rates = principal.field([*moved], cut.on.numbers, ARRAYS)
            ahead = np.array([x + _STEP * 1j * rate for x, rate in zip(moved, rates, strict=True)])
            speed = np.imag(zero.value([*ahead], ARRAYS)) / _STEP
            value = np.real(zero.value(list(moved), ARRAYS))
            here = zero.value(list(states.T), ARRAYS) + 0 * states[:, 0]
        if not np.isfinite(here).all():
            raise _not_finite(cut, states[int(np.argmin(np.isfinite(here)))], 0.0)
    except (ArithmeticError, AttributeError, TypeError):  # no name in it
        speed = value = np.zeros(1)
    if not np.any(np.abs(speed) > 1e-12 * np.maximum(1e-300, np.abs(value))):
        expected = "an expression that changes along the motion; this one is constant"
        raise BadInput(cut.on.scene.name, "by", cut.by, expected)


@contextmanager
def _refused(cut: Cut, checkpoint: JobCheckpoint | None) -> Iterator[None]:
    """Leave nothing behind where the section's function is refused, on the way too."""
    try:
        try:
            yield
        except Singular as met:
            raise _not_finite(cut, met.start, met.time) from None
    except BadInput:
        if checkpoint is not None:
            checkpoint.remove()
        raise


def _not_finite(cut: Cut, start: Sequence[float], time: float) -> BadInput:
    """The refusal of an expression that has no finite value on an orbit, at a time of the run."""
    l, ratio = (float(x) for x in coordinates(cut.on, np.array(start)))
    t = math.ldexp(time, cut.on.frame.exponent)
    expected = (
        "an expression that is real and finite on all orbits; on the one from "
        f"l = {l:.6g}, L/G = {ratio:.6g} it has a pole or stops being real at t = {t:.6g}"
    )
    return BadInput(cut.on.scene.name, "by", cut.by, expected)


def _refuse_never_zero(cut: Cut, zero: SectionZero) -> None:
    grid = cell_centres(60, 60)
    states = [momentum_states(cut.on, *grid, kind).states for kind in (True, False)]
    values = np.real(zero.value(list(np.concatenate(states).T), ARRAYS))
    expected = (
        "an expression that becomes zero; at the extrema of |G| on this level it is from "
        f"{np.nanmin(values):.4g} to {np.nanmax(values):.4g}, and no orbit crosses 0"
    )
    raise BadInput(cut.on.scene.name, "by", cut.by, expected)

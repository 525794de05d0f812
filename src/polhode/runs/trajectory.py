"""What a run gives back: times, states, outcome. Immutable."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, Any, Generic, Literal, NamedTuple, SupportsFloat, cast, overload

import numpy as np

from polhode.common.arguments import numbers_given
from polhode.common.errors import BadInput, counted, few, nearest, plain
from polhode.common.interrupts import Progress
from polhode.common.values import ByValue, cached_property, may_wait, waiting
from polhode.equations.columns import derived, derived_words
from polhode.equations.form import equations
from polhode.equations.integrals import Drift, drift
from polhode.equations.kinematics import Hodographs
from polhode.motion.outcomes import NO_EVENTS, Events, Interpolant, Outcome, Projection
from polhode.numbers import number_types
from polhode.numbers.conversion import TIME, ExactNumbers, reader, to_double
from polhode.numbers.decimals import in_full, shown, strings
from polhode.numbers.exact import sign
from polhode.numbers.number_types import AnyNumber, Flat, Given, NumberType, Real, Row, Rows, States
from polhode.results.cells import DOUBLE
from polhode.results.result import Result
from polhode.results.table import Column, Fact, Table
from polhode.runs.options import USUAL, Options, cadence
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import provenance_fact, row_columns, scene_facts, time_column
from polhode.scenes.vocabulary import ATTITUDE, COLUMNS, Several, Single
from polhode.taylor import defaults

# --- error estimate -------------------------------------------------------------------------------
#
# How many digits of a run are to be expected, at a small part of the run's own cost.


_SHARE = 0.05  # of the run's time, for the tangent
_TANGENT = 4e-6  # seconds that a step of it takes
_FEWEST_STEPS = 2000


class Expected(NamedTuple):
    """Correct digits that a run is expected to have.

    ``digits``: at each output time.  ``halved_after``, ``lost_after``: the times from which on
    fewer than half of the type's digits, and none, are left; None where more are throughout.
    """

    digits: tuple[float, ...]
    halved_after: float | None
    lost_after: float | None


def expected(
    scene: Scene,
    number_type: NumberType,
    tolerance: float,
    steps: int,
    times: Sequence[Fraction],
    every: int = 0,
) -> Expected:
    """What a run of so many steps at this tolerance is expected to have; see Expected.

    ``every``: the steps after which it was put back on all integrals of an integrable top, or 0.

    One tangent is followed, see :mod:`polhode.taylor.error_growth`, in double for a
    twentieth of the run's time or some milliseconds; then its law is continued.  It tells what has
    become of errors made at the start: those made near an unstable rotation that a motion comes
    back to may have grown more (euler/dzhanibekov to t = 60: 13 digits told, 8 had).
    polhode.compare and polhode.conditioning follow all of them.  Where the run's type is wider, and
    the motion multiplies errors more than a double can follow, another integration leads it.
    """
    from polhode.taylor.error_growth import LED_FROM, growth

    if not times:
        return Expected((), None, None)
    full = tolerance <= float(number_type.eps)
    digits_held = number_type.most_digits if full else -math.log10(tolerance)
    until_last = scene.at((times[-1],))
    most = max(_FEWEST_STEPS, int(_SHARE * defaults.seconds(number_type, steps) / _TANGENT))
    growths = growth(until_last, digits_held, most, every=every)
    if not number_type.flat and max(growths.lost) > LED_FROM:
        growths = growth(until_last, digits_held, most, True, every=every)
    digits = tuple(max(0.0, digits_held - growths.at(t)) for t in times)
    return Expected(digits, growths.reaches(digits_held / 2), growths.reaches(digits_held))


def by_errors(
    errors: Sequence[float | None], number_type: NumberType, times: Sequence[Fraction], states: Rows
) -> Expected:
    """What a refined run is expected to have: by its own estimates, None for no digit left."""
    digits_held = number_type.most_digits
    speed = max((math.hypot(*(float(x) for x in row[:3])) for row in states), default=0.0) or 1.0

    def right(error: float | None) -> float:
        if not error:
            return 0.0 if error is None else digits_held
        return max(0.0, min(digits_held, -math.log10(error / min(1.0, speed))))

    digits = tuple(right(error) for error in errors)
    below = [
        next((to_double(t) for t, d in zip(times, digits, strict=True) if d <= least), None)
        for least in (digits_held / 2, 0.0)
    ]
    return Expected(digits, below[0], below[1])


# --- trajectory -----------------------------------------------------------------------------------


if TYPE_CHECKING:
    import numpy.typing as npt
    from matplotlib.axes import Axes
    from typing_extensions import TypeVar  # whose variables have defaults

    from polhode.common.texts import Page

    #: The type of a run's states: by its number type, any of them where that is not known.
    S_co = TypeVar("S_co", bound=States, default=States, covariant=True)
else:
    from typing import TypeVar

    S_co = TypeVar("S_co", covariant=True)

ERROR = "estimate of the largest error of the state"
_LOOKED_AT = 400  # times, for the fewest digits to be expected
_TORUS = 4  # integrals that fix the torus of an integrable top with gamma


@may_wait("provenance")
@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(Result, ByValue, Generic[S_co]):
    """States of a scene at its output times, in body axes, as numbers of one type.

    >>> import polhode
    >>> run = polhode.integrate("euler/largest-axis", at=[0, 1])
    >>> run
    <Trajectory of euler/largest-axis: double, 2 times to t = 1, reached end>
    >>> run.states.shape, run.columns[:3], run.outcome.done
    ((2, 6), ('p', 'q', 'r'), True)
    >>> [round(float(x), 12) for x in run("1/2")[:3]]  # the state at any time that was reached
    [0.393669412155, -0.27086132721, 1.11466936938]

    ``times``: exact values of the times at which the states hold (already rounded to the type).
    ``states``: shape (len(times), 3 or 6), p q r [gamma1 gamma2 gamma3] in the scene's body axes
    and units, a read-only ndarray, of mpf in types wider than extended.  ``angles``: psi, theta,
    phi in radians; ``attitude``: the quaternion body to space, scalar first, also if hodographs
    were asked for.
    ``steps``: Taylor steps taken.  ``events``: one for each event of the scene.  ``projection``:
    None if the state was not projected onto the first integrals.  ``method``: "taylor" or
    "refined"; the ``errors`` of a refined run are estimates, one for each state, of the largest
    error over its columns: None if the motion multiplies errors too much for an estimate.
    ``digits``: those asked for; ``correct_digits``: how many were found correct, by what
    ``checked_by`` says.  ``inputs``: the narrower type that start and coefficients were rounded to
    first, if any.
    """

    scene: Scene
    number: NumberType
    times: Sequence[Fraction]
    states: S_co
    outcome: Outcome
    steps: int
    reached: Fraction
    tolerance: float
    digits: int | None = None
    attitude: S_co | None = None
    angles: Sequence[Sequence[Real | None]] | None = None
    events: Events = NO_EVENTS
    projection: Projection | None = None
    provenance: Mapping[str, object] = field(default_factory=dict, compare=False)
    dense: Interpolant | None = field(default=None, repr=False, compare=False)
    method: str = "taylor"
    errors: tuple[float | None, ...] | None = None
    correct_digits: float | None = None
    checked_by: str = ""
    inputs: NumberType | None = None

    def __setstate__(self, state: Mapping[str, object]) -> None:
        super().__setstate__(state)
        for rows in (self.states, self.attitude):
            if rows is not None:
                rows.flags.writeable = False

    def __call__(self, t: AnyNumber | Iterable[AnyNumber]) -> S_co:
        """The state at time t, or the states at several times.

        ``t``: an int, Fraction, float, numpy or mpmath number, or text such as ``"1/3"``, taken
        exactly; or a sequence of them, for as many rows.  The first question takes as long as the
        run, later ones less than a millisecond in double; at a time of the run's outputs it is
        that row.

        Raises BadInput (a ValueError) for a time that the run did not reach.
        """
        if self.dense is None:
            raise ValueError("states at the output times only: nothing was integrated here")
        rows = _at_times(self, "states", t)
        states = np.array(rows, dtype=number_types.kind_of(self.number))
        if len(rows) == 0:
            states = states.reshape(0, len(self.columns))
        return cast("S_co", states)

    def __repr__(self) -> str:
        return (
            f"<Trajectory of {self.scene.name}: {self.number.name}, "
            f"{counted(len(self.times), 'time')} "
            f"to t = {shown(self.reached)}, {self.outcome.value}>"
        )

    @overload
    def __getitem__(self, name: Literal["t"]) -> npt.NDArray[np.float64]: ...
    @overload
    def __getitem__(self, name: str) -> S_co: ...
    def __getitem__(self, name: str) -> S_co | npt.NDArray[np.float64]:
        """A column by its name, an array of the run's type, nan where a number is not defined.

        ``name``: t, p, q, r, gamma1, gamma2, gamma3, or of an output that was asked for.

        >>> import polhode
        >>> run = polhode.integrate("lagrange/nutation", at=[1, 2])
        >>> [round(float(x), 6) for x in run["theta"]]
        [0.948788, 1.319247]
        """
        if name == "t":
            return self.t
        for names, rows in self.named:
            if name in names:
                return cast("S_co", self._column(rows, names.index(name)))
        names_here = ["t", *(name for names, _ in self.named for name in names)]
        raise KeyError(f"{name}: expected {nearest(name, names_here)}; outputs= adds others")

    __iter__ = None  # columns have names, and no order

    def _column(self, rows: Given, place: int) -> Flat | number_types.Objects:
        if isinstance(rows, np.ndarray):
            return rows[:, place]
        column = np.empty(len(rows), dtype=number_types.kind_of(self.number))
        for k, row in enumerate(rows):
            column[k] = math.nan if row[place] is None else row[place]
        column.flags.writeable = False
        return column

    @property
    def named(self) -> list[tuple[tuple[str, ...], Given]]:
        """All rows that are there, each with the names of its columns."""
        outputs = [(COLUMNS[word].names, rows) for word, rows in self.outputs.items()]
        return [(self.columns, self.states), *outputs]

    @property
    def omega(self) -> S_co:
        """p q r, shape (len(times), 3)."""
        return cast("S_co", self.states[:, :3])

    @property
    def gamma(self) -> S_co:
        """gamma1 gamma2 gamma3, shape (len(times), 3); no columns where the scene has no gamma."""
        return cast("S_co", self.states[:, 3:])

    @property
    def psi(self) -> S_co:
        """The precession angle, where angles were asked for."""
        return self["psi"]

    @property
    def theta(self) -> S_co:
        """The nutation angle, where angles were asked for."""
        return self["theta"]

    @property
    def phi(self) -> S_co:
        """The angle of proper rotation, where angles were asked for."""
        return self["phi"]

    @property
    def t(self) -> npt.NDArray[np.float64]:
        """The times as doubles, the nearest ones."""
        if isinstance(self.times, ExactNumbers):
            return self.times.doubles()
        return np.array([to_double(t) for t in self.times])

    @overload
    def attitude_at(self, t: str) -> Row: ...  # type: ignore[overload-overlap]
    @overload
    def attitude_at(self, t: Iterable[AnyNumber]) -> list[Row]: ...
    @overload
    def attitude_at(self, t: SupportsFloat) -> Row: ...
    def attitude_at(self, t: AnyNumber | Iterable[AnyNumber]) -> number_types.Reread:
        """The quaternion q0 q1 q2 q3 at time t, or rows of it; made as states are."""
        return _at_times(self, "attitude", t)

    @overload
    def angles_at(self, t: str) -> list[Real | None]: ...  # type: ignore[overload-overlap]
    @overload
    def angles_at(self, t: Iterable[AnyNumber]) -> list[list[Real | None]]: ...
    @overload
    def angles_at(self, t: SupportsFloat) -> list[Real | None]: ...
    def angles_at(self, t: AnyNumber | Iterable[AnyNumber]) -> number_types.Reread:
        """psi, theta, phi at time t, or rows of them; made as states are."""
        return _at_times(self, "angles", t)

    @overload
    def plot(
        self, what: Several, ax: object = None, **options: object
    ) -> npt.NDArray[np.object_]: ...
    @overload
    def plot(self, what: Single, ax: object = None, **options: object) -> Axes: ...
    @overload
    def plot(
        self, what: str | None = None, ax: object = None, **options: object
    ) -> Axes | npt.NDArray[np.object_]: ...
    def plot(
        self, what: str | None = None, ax: object = None, **options: object
    ) -> Axes | npt.NDArray[np.object_]:
        """Draw a figure with matplotlib, see :func:`polhode.plot`; the axes drawn into."""
        return super().plot(what, ax, **options)

    def view(self, *, end: AnyNumber | None = None) -> Page:
        """The motion as an animated page, see :func:`polhode.view`."""
        import polhode

        return polhode.view(self, end=end)

    @property
    def seconds(self) -> Mapping[str, float]:
        """Seconds that computing took: of building the integrator and of the run."""
        seconds = self.provenance.get("seconds", {})
        return seconds if isinstance(seconds, dict) else {}

    @cached_property
    def drift(self) -> Drift:
        """Largest drift of the first integrals from the exact scene's values.

        No evidence of accuracy where they were projected: then see ``projection``.
        """
        if not self.times:
            return Drift(None, None, None)
        return drift(self.scene, self.states, self.number.bits)

    @cached_property
    def expected(self) -> Expected:
        """The correct digits to expect, from how much the motion multiplies errors.

        For a method that rounds the state once a step; of an integrable top, what putting it back
        on all its integrals leaves.  A refined run has its own estimates.

        >>> import polhode
        >>> run = polhode.integrate("euler/separatrix", at=[1, 30, 400])
        >>> [round(d) for d in run.expected.digits], 40 < run.expected.lost_after < 140
        ([15, 12, 0], True)
        """
        return self._expected_at(range(len(self.times)))

    def _expected_at(self, places: Sequence[int]) -> Expected:
        """The same at some of the times."""
        times = [self.times[k] for k in places]
        if self.errors is not None:
            errors, states = [self.errors[k] for k in places], self.states[list(places)]
            return by_errors(errors, self.number, times, states)
        projection = self.projection
        every = projection.every if projection is not None and len(projection.onto) == _TORUS else 0
        return expected(self.scene, self.number, self.tolerance, self.steps, times, every)

    @cached_property
    def _least_expected(self) -> tuple[float | None, float | None]:
        if not self.times or self.correct_digits is not None:
            return None, None
        forecast = self._expected_at(few(len(self.times), _LOOKED_AT))
        return min(forecast.digits), forecast.lost_after

    @property
    def digits_expected(self) -> float | None:
        """The fewest digits to expect, at some hundred of the times; None where they were found."""
        return self._least_expected[0]

    @property
    def lost_after(self) -> float | None:
        """The time after which no digit is to be expected; None where some is throughout."""
        return self._least_expected[1]

    @cached_property
    def outputs(self) -> Mapping[str, number_types.DerivedRows]:
        """Rows of all outputs besides the states, by the words of ``run.outputs``.

        Outputs that others need are included; that of hodographs is omega in space.

        >>> import polhode
        >>> run = polhode.integrate("lagrange/nutation", at=[1, 2])
        >>> {word: len(rows) for word, rows in run.outputs.items()}
        {'attitude': 2, 'angles': 2}
        """
        values: dict[str, number_types.DerivedRows | None] = {
            word: getattr(self, word) for word, x in COLUMNS.items() if x.how == "integrated"
        }
        needs: dict[str, Given | None] = {"state": self.states, **values}
        for word in derived_words():
            parts = [part for need in COLUMNS[word].needs if (part := needs[need]) is not None]
            if word in self.scene.outputs and len(parts) == len(COLUMNS[word].needs):
                values[word] = column = derived(word, self.scene, parts, self.number)
                if not isinstance(column, list):
                    column.flags.writeable = False
        return {word: rows for word in COLUMNS if (rows := values.get(word)) is not None}

    @cached_property
    def others(self) -> dict[str, Interpolant]:
        """What tells attitude and angles at any time, where they are no outputs, once asked."""
        return {}

    @property
    def hodographs(self) -> Hodographs | None:
        """omega in the body and in space, if asked for."""
        space = self.outputs.get("hodographs")
        if space is None:
            return None
        return Hodographs(number_types.part_of(self.states, slice(3)), space)

    @property
    def options(self) -> Options:
        """How it was made; of one that steps did not bring to the end, to end soon after it did.

        And of one of more steps than are usual.
        """
        every = None if self.projection is None else self.projection.every
        tolerance = None if self.at_full_tolerance else Fraction(self.tolerance)
        choices, most = defaults.of(self.number), None
        early = self.outcome in (Outcome.STEP_LIMIT, Outcome.INTERRUPTED)
        if self.method == "taylor" and (early or self.steps > choices.max_steps):
            most = self.steps + choices.chunk  # the last may have gone uncounted
        return Options(self.method, most, every or False, tolerance, self.inputs, self.digits)

    @property
    def cause(self) -> str:
        """Why the run ended."""
        if self.outcome is Outcome.SINGULAR:
            return f"the form {self.scene.form} met its singular set"
        return self.outcome.cause

    @property
    def advice(self) -> str:
        """What to do about it; empty where the run did what was asked."""
        if self.outcome is Outcome.SINGULAR:
            return f"use --form {equations(self.scene).instead}"
        return self.outcome.advice

    @property
    def projected(self) -> bool:
        """Whether the state was ever put back on the integrals: their drift then says nothing."""
        projection = self.projection
        return projection is not None and projection.count > 0 and "h" in projection.onto

    @property
    def at_full_tolerance(self) -> bool:
        """Whether the steps were made at the type's own eps."""
        return self.tolerance <= float(self.number.eps)

    @property
    def complete(self) -> bool:
        """Whether the run did what was asked: it reached its end, with the digits wanted."""
        return self.outcome.done

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C ended it."""
        return self.outcome is Outcome.INTERRUPTED

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the state's columns."""
        return self.scene.columns

    def table(self) -> Table:
        """A row a time: t, the state, outputs, and of a refined run the estimate of its error."""
        columns = [time_column(self.scene, self.times, self.number)]
        for names, rows in self.named:
            columns += row_columns(self.scene, names, rows, self.number)
        if self.errors is not None:
            columns.append(Column("error", self.errors, ERROR, type=DOUBLE, digits=2))
        return Table(columns)

    def facts(self) -> list[Fact]:
        """How the run was made, how it ended, and what is to be expected of it."""
        facts = scene_facts(self.scene, times=self.times)
        text, source = facts[-1].value, self.scene.source
        facts += [
            Fact("scene_source", None if source == text else source, "where that is no scene_text"),
            Fact("number", self.number.name, "the type of the numbers"),
            Fact("bits", self.number.bits, "of its significand"),
            Fact("digits", self.digits, "correct digits asked for"),
            Fact("correct_digits", self.correct_digits, "digits that were found correct"),
            Fact("checked_by", self.checked_by, "by what they were found correct"),
            Fact("digits_expected", self.digits_expected, "fewest digits to be expected"),
            Fact("lost_after", self.lost_after, "no digits are to be expected from then on"),
            Fact("form", self.scene.form, "of the equations"),
            Fact("method", self.method),
            Fact("outcome", self.outcome.value, "how the run ended"),
            Fact("reached", self.reached, "the time that it reached"),
            Fact("steps", self.steps),
            Fact("tolerance", self.tolerance, "of a step, relative"),
        ]
        for name, value in self.drift._asdict().items():
            facts.append(Fact(f"drift_{name}", value, "largest departure of an integral, relative"))
        if self.inputs is not None:
            facts.append(Fact("inputs", asdict(self.inputs), "what was rounded to it at the start"))
        if self.projection is not None:
            facts.append(Fact("projection", asdict(self.projection), "onto the first integrals"))
        if self.scene.events:
            meaning = "whether all events were found"
            facts.append(Fact("events", self.events.table(self.scene, self.number)))
            facts.append(Fact("events_complete", [x.complete for x in self.events], meaning))
        return [*facts, provenance_fact(self.provenance)]

    def time_strings(self) -> list[str]:
        """The times, every digit."""
        return [in_full(t) for t in self.times]

    def state_strings(self) -> list[list[str]]:
        """The states as decimal strings that round-trip."""
        return strings(self.states, self.number)


# --- solve ----------------------------------------------------------------------------------------


def solve(
    scene: Scene,
    number: NumberType,
    options: Options = USUAL,
    progress: Progress | None = None,
    *,
    interruptible: bool = True,
) -> Trajectory:
    """Solve the Euler–Poisson equations (3.29) of a scene in one number type, once.

    Ctrl-C ends the run within a second, and the trajectory holds what was reached; of a run on the
    way to something else, not ``interruptible``, it goes on as KeyboardInterrupt.  Raises BadInput
    for what cannot be integrated.
    """
    from polhode.runs.methods import followed_motion  # heyoka: a run in a file is looked at without

    motion, times, rows, outcome, seconds, failed = followed_motion(
        scene, number, options, progress, interruptible=interruptible
    )
    read = motion.read
    states, attitude, angles = read.states(rows), None, None
    if scene.modelled:
        attitude, angles = read.attitude(rows, states), read.angles(rows, states)
    return Trajectory(
        scene=scene,
        number=number,
        times=times if len(rows) == len(times) else times[: len(rows)],
        states=number_types.read_only(states, len(scene.columns)),
        attitude=None if attitude is None else number_types.read_only(attitude, len(ATTITUDE)),
        angles=None if angles is None else tuple(map(tuple, angles)),
        events=Events(motion.events),
        projection=motion.projection,
        outcome=outcome,
        steps=motion.steps,
        reached=motion.reached,
        tolerance=float(options.tolerance or 2.0 ** (1 - number.bits)),
        digits=options.digits,
        provenance=waiting(partial(_made_of, scene, seconds, {**failed, **motion.remarks})),
        dense=motion,
        method=motion.method,
        errors=motion.errors,
        inputs=options.inputs,
    )


def _made_of(
    scene: Scene, seconds: Mapping[str, float], more: Mapping[str, str]
) -> Mapping[str, object]:
    """A trajectory's provenance, made when it is wanted: it takes as long as a short run."""
    return {**scene.provenance(), "seconds": seconds, **more}


# --- other times ----------------------------------------------------------------------------------
#
# State, attitude and angles of a run at any time: its own rows, or rows made when asked for.


def _at_times(
    run: Trajectory, output: str, t: AnyNumber | Iterable[AnyNumber]
) -> number_types.Reread:
    """States, attitude or angles at time t, or rows of them; raises BadInput beyond what was
    reached.

    At a time of the run's outputs they are that row.  psi and phi count whole turns from the start
    on, so they are integrated from there.
    """
    scene = run.scene
    if output != "states" and scene.gamma is None:
        raise BadInput(scene.name, "start.gamma", None, f"a unit vector, for {output}")
    numbers, several = numbers_given(t)
    times = [_time(run, x) for x in numbers]
    own: Given | None = getattr(run, output)
    rows: dict[Fraction, Any] = {}
    if own is not None:
        places = ((x, bisect_left(run.times, abs(x), key=abs)) for x in times)
        rows |= {x: own[k] for x, k in places if k < len(run.times) and run.times[k] == x}
    others = sorted({x for x in times if x not in rows}, key=abs)
    if others:
        rows |= zip(others, _rows(run, output, others), strict=True)
    answers = [rows[x] for x in times]
    return answers if several else answers[0]


def _rows(run: Trajectory, output: str, times: list[Fraction]) -> Sequence[number_types.GivenRow]:
    """Rows at times of which none is one of the run's own, in the order of the motion."""
    from polhode.runs.methods import followed_motion
    from polhode.taylor.heyoka import OutOfRange

    raw: Given
    scene, refined = run.scene, output != "states" and run.method == "refined"
    if refined:
        scene = _with_output(run, output, times)
        refined = run.options.hindrance(scene, run.number) is None  # no angles from a pole on
    if refined:
        again = followed_motion(scene, run.number, run.options, interruptible=False)
        motion: Interpolant = again.motion
        raw, outcome, reached = again.rows, again.outcome, again.motion.reached
    else:
        motion = _motion(run, output)
        try:
            raw, outcome, reached = motion.at(times)
        except OutOfRange as fault:
            expected = f"a time that {run.number.name} holds ({fault})"
            raise BadInput(run.scene.name, "t", shown(times[0]), expected) from None
    states = motion.read.states(raw)
    rows = cast("Sequence[number_types.GivenRow]", states)
    if output != "states":
        rows = getattr(motion.read, output)(raw, states)
    if len(rows) < len(times):  # angles are singular where the state is not
        expected = f"a time at which there are {output}; {outcome.cause} at t = {shown(reached)}"
        raise BadInput(run.scene.name, "t", shown(times[len(rows)]), expected)
    return rows


def _motion(run: Trajectory, output: str) -> Interpolant:
    """What tells rows of this kind: the run's own motion, or one with it to the same time."""
    from polhode.taylor.motion import Motion
    from polhode.taylor.system import system_of

    if output == "states" or (run.dense is not None and output in run.scene.modelled):
        if run.dense is None:
            raise ValueError("states at the output times only: nothing was integrated here")
        return run.dense
    if output not in run.others:
        scene, options = _with_output(run, output, run.times), run.options
        system = system_of(scene, run.number, options.tolerance, options.inputs)
        motion = Motion(system, scene, cadence(scene, run.number, options), options.max_steps)
        motion.reached = run.reached
        run.others[output] = motion
    return run.others[output]


def _with_output(run: Trajectory, output: str, times: Sequence[Fraction]) -> Scene:
    """The scene of a run with one output, without events."""
    return replace(run.scene, outputs=(output,), events=(), times=tuple(times))


def _time(run: Trajectory, t: object) -> Fraction:
    """A time that was reached, exact, or to far more bits than a row has."""
    try:
        exact = reader(run.scene.units, TIME)(t)
    except ValueError:
        raise _beyond(run, plain(t)) from None
    if sign(exact) * sign(run.reached) < 0 or sign(abs(exact) - abs(run.reached)) > 0:
        raise _beyond(run, shown(exact))
    if isinstance(exact, Fraction):
        return exact
    return NumberType("mp", 2 * run.number.bits + 128).rounded(exact)


def _beyond(run: Trajectory, t: str) -> BadInput:
    expected = f"a time from 0 to {shown(run.reached)}, what the run reached"
    return BadInput(run.scene.name, "t", t, expected)

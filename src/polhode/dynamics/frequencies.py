"""The frequencies of a motion, from its samples; beside them what a closed form says."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polhode.common.arguments import each, whole
from polhode.common.errors import BadInput, nearest
from polhode.common.provenance import provenance
from polhode.common.values import ByValue
from polhode.dynamics import naff
from polhode.dynamics.level_body import LevelBody
from polhode.judging.reference import reference
from polhode.judging.tables.table import TrajectoryTable
from polhode.judging.tables.table_file import is_table, read_table
from polhode.numbers.conversion import TIME, doubles, reader, to_double
from polhode.numbers.decimals import brief
from polhode.numbers.exact import Exact, sign
from polhode.numbers.number_types import DOUBLE, AnyNumber, Complexes, Doubles
from polhode.numbers.vectors import quaternion_product
from polhode.results.cells import INTEGER
from polhode.results.result import Result
from polhode.results.table import Column, Fact, Table
from polhode.runs.trajectory import Trajectory, solve
from polhode.scenes import library
from polhode.scenes.scene import Scene, even_times
from polhode.scenes.scene_facts import provenance_fact, scene_facts, text_column
from polhode.scenes.vocabulary import ATTITUDE, REQUESTS, STATE

LINES = 6
LENGTH = 200  # units of time, where neither the caller nor the scene says an end
PER_LINE = 6.0  # samples in a radian of the fastest rate: lines up to nine times as fast are seen
MOST_SAMPLES = 400_000
LARGEST_FACTOR, MOST_ORDER = 12, 16  # of an integer combination: each, and their sizes' sum
_SURE = 30.0  # errors within which a combination is a line
_SHARP = 1e-5  # of 2 pi/T: a line with a larger error stands too near to others

#: Signals by name: the real part's column and the imaginary part's.
SIGNALS = {
    "p+iq": ("p", "q"),
    "gamma1+i gamma2": ("gamma1", "gamma2"),
    **{name: (name, "") for name in STATE},
}
AXIS = "axis"  # the third body axis in space, across the vertical; of a free body across G


class Line(NamedTuple):
    """A line of one signal; see :class:`polhode.dynamics.naff.SpectralLine`.

    ``combination``: integers by name of the frequency, empty where none fits.
    """

    frequency: float
    amplitude: complex
    error: float
    half: float
    combination: Mapping[str, int]


@dataclass(frozen=True, repr=False, eq=False)
class Frequencies(Result, ByValue):
    """The lines of each signal, strongest first, in radians per unit of time.

    ``known``: frequencies by name that the lines are combinations of: a closed form's where
    ``closed_form``, else lines that are no combination of those before.  ``rates_of``:
    which axis turns, and about which, where a rate's name leaves it open.  The mean of a real
    signal is taken away.  ``step``: the time between two samples, and ``step_error`` what it may
    be off where the times are rounded, which the errors of the lines include.  ``scene``: with the
    times of the samples; None of a table or of listed times.

    >>> import polhode
    >>> found = polhode.frequencies("lagrange/nutation", of=["gamma3"], end=200)
    >>> found.lines["gamma3"][0].combination
    {'nutation': 1}
    >>> abs(found.lines["gamma3"][0].frequency - found.known["nutation"]) < 1e-13
    True
    """

    name: str
    end: float
    samples: int
    lines: Mapping[str, tuple[Line, ...]]
    known: Mapping[str, float]
    closed_form: bool
    rates_of: Mapping[str, str] = field(default_factory=dict)
    signals: Mapping[str, Doubles | Complexes] = field(default_factory=dict)
    step: float = 0.0
    step_error: float = 0.0
    scene: Scene | None = None
    provenance: Mapping[str, object] = field(default_factory=dict)

    def __repr__(self) -> str:
        strongest = {name: lines[0].frequency for name, lines in self.lines.items() if lines}
        words = ", ".join(f"{name} {x:.10g}" for name, x in strongest.items())
        return f"<Frequencies of {self.name}: strongest {words or 'none'}, to t = {self.end:g}>"

    def table(self) -> Table:
        """One row per spectral line, of each signal the strongest first."""
        rows = [(name, k + 1, x) for name, lines in self.lines.items() for k, x in enumerate(lines)]
        lines = [line for _, _, line in rows]
        phases = [math.atan2(x.amplitude.imag, x.amplitude.real) for x in lines]
        return Table(
            [
                text_column("signal", [name for name, _, _ in rows]),
                Column("line", [k for _, k, _ in rows], type=INTEGER),
                Column("frequency", [x.frequency for x in lines], "angular", "rad/time", digits=12),
                Column("error", [x.error for x in lines], "estimate", "rad/time", digits=2),
                Column("half", [x.half for x in lines], "from half of the time", "rad/time"),
                Column("amplitude", [abs(x.amplitude) for x in lines]),
                Column("phase", phases, "at the first time", "rad"),
                text_column("combination", [in_words(x.combination) for x in lines]),
            ],
            2,
        )

    def facts(self) -> list[Fact]:
        """Of what motion, to which time, and which frequencies are known."""
        columns = [
            text_column("name", [*self.known]),
            Column("frequency", [*self.known.values()]),
            text_column("of", [self.rates_of.get(name, "") for name in self.known]),
        ]
        source = [Fact("scene", self.name, "a scene's name, or a file")]
        return [
            *(source if self.scene is None else scene_facts(self.scene)),
            Fact("end", self.end, "the last time"),
            Fact("samples", self.samples),
            Fact("step", self.step, "time between two samples"),
            Fact("step_error", self.step_error, "what the step may be off by the times' rounding"),
            Fact("known", Table(columns), "of which lines are combinations"),
            Fact("closed_form", self.closed_form, "whether a closed form tells them"),
            provenance_fact(self.provenance),
        ]


def in_words(combination: Mapping[str, int]) -> str:
    """An integer combination of frequencies as text."""
    return " ".join(
        f"{'-' if k < 0 else '+'} {'' if abs(k) == 1 else f'{abs(k)} '}{name}"
        for name, k in combination.items()
    ).removeprefix("+ ")


def frequencies(
    source: Scene | str | Path | Trajectory,
    of: Sequence[str] | None = None,
    end: AnyNumber | None = None,
    lines: int = LINES,
) -> Frequencies:
    """Find the spectral lines of a motion's signals by Laskar's frequency analysis.

    Parameters
    ----------
    source : Scene, Trajectory, str or Path
        A scene, a run, or the file of one, or of a table with a column t, as for
        :func:`polhode.compare`; the times of a run or file are equally spaced, those of a file
        within half a unit of their last printed decimal.
    of : sequence of str, optional
        Among "p+iq", "gamma1+i gamma2", "p", "q", "r", "gamma1", "gamma2", "gamma3" and "axis", the
        third body axis in space; "p+iq" and "gamma3" unless given.
    end : number, optional
        The last time of a scene's run; by default its own end, or 200 if it has none.
    lines : int
        The most lines of each signal: N of a real one are N frequencies above 0, for +f and -f are
        one line, and its mean is none; of a complex one such as "p+iq" f and -f are two, and a
        constant is a line at 0.

    Returns
    -------
    Frequencies
        Angular frequencies in radians per unit of time, amplitudes, phases, and combinations of the
        motion's basic frequencies where they are known.

    Raises
    ------
    BadInput
        Times that are not equally spaced, an unknown signal, too few samples.

    References
    ----------
    J. Laskar, "Introduction to frequency map analysis", in *Hamiltonian Systems with Three or More
    Degrees of Freedom*, NATO ASI Series C 533 (1999).

    Examples
    --------
    >>> import polhode
    >>> run = polhode.integrate("euler/attitude", at=[k / 10 for k in range(1, 2001)])
    >>> line = polhode.frequencies(run, of=["r"]).lines["r"][0]
    >>> line.combination
    {'polhode': 2}
    """
    count = whole("frequencies", "lines", lines, 1, 100)
    if isinstance(source, Trajectory):
        if end is not None:
            raise BadInput(source.scene.name, "end", end, "no end: a run is analysed whole")
        return _of_run(source, _names(source.scene.name, of, source.scene), count)
    if isinstance(source, (str, Path)) and is_table(source):
        if end is not None:
            raise BadInput(str(source), "end", end, "no end: a file is analysed whole")
        table = read_table(Path(source))
        if table.run is None:
            return _of_table(table, of, count)
        return _of_run(table.run, _names(table.name, of, table.run.scene), count)
    scene = library.load(source, takes=REQUESTS)
    names = _names(scene.name, of, scene)
    last: Exact = Fraction(LENGTH) if sign(scene.end) == 0 else scene.end
    if end is not None:
        (last,) = each(scene.name, "end", (end,), reader(scene.units, TIME), "a time")
    if sign(last) == 0:
        raise BadInput(scene.name, "end", "0", "a time other than 0")
    outputs = ("attitude",) if AXIS in names else ()
    on = LevelBody.of(scene)
    speed = max(on.fastest, on.swing) / float(on.unit) or 1.0
    samples_needed = PER_LINE * speed * abs(to_double(last))
    samples = math.ceil(min(samples_needed, MOST_SAMPLES)) + 2
    if samples > MOST_SAMPLES:
        expected = f"a time up to {MOST_SAMPLES / PER_LINE / speed:.6g}: more samples take too long"
        raise BadInput(scene.name, "end", to_double(last), expected)
    bare = replace(scene, outputs=outputs, events=(), published=(), source=scene.source)
    run = solve(bare.at(even_times(last, max(64, samples))), DOUBLE, interruptible=False)
    if not run.outcome.done:
        expected = f"a time that is reached: {run.outcome.cause}"
        raise BadInput(scene.name, "end", to_double(last), expected)
    return _of_run(run, names, count)


def _names(source: str, of: Sequence[str] | None, scene: Scene | None) -> tuple[str, ...]:
    heavy = scene is None or scene.gamma is not None
    if of is None:
        return ("p+iq", "gamma3") if heavy else ("p+iq", "r")
    names = each(source, "of", of, str, "a list of signals")
    for name in names:
        if name not in (*SIGNALS, AXIS):
            raise BadInput(source, "of", name, nearest(name, [*SIGNALS, AXIS]))
        if "gamma" in name and not heavy:
            raise BadInput(source, "of", name, "a scene with start.gamma")
    if not names:
        raise BadInput(source, "of", None, "at least one signal")
    return names


def _of_run(run: Trajectory, names: tuple[str, ...], count: int) -> Frequencies:
    scene = run.scene
    step = spacing(scene.name, run.times)
    columns = dict(zip(run.columns, doubles(run.states).T, strict=True))
    if run.attitude is not None:
        columns |= zip(ATTITUDE, doubles(run.attitude).T, strict=True)
    closed = reference(scene)
    rates: dict[str, float] = {}
    half = {"s1", "s2", "u", "v"}  # of separated variables: the state has twice their period
    for name, x in closed.frequencies.items():
        rates |= {f"{name}/2": float(x) / 2} if name in half else {name: float(x)}
    signals = {name: _signal(scene.name, name, columns, scene) for name in names}
    last, origin = to_double(run.times[-1]), scene.provenance()
    result = _lines_of(scene.name, signals, step, last, count, rates, origin)
    result = replace(result, rates_of=closed.rates_of)
    listed = scene.output_times.floats is not None  # which a text would hold one by one
    return result if listed else replace(result, scene=scene)


def _of_table(table: TrajectoryTable, of: Sequence[str] | None, count: int) -> Frequencies:
    step = spacing(table.name, table.times, table.time_errors)
    columns, lacking = {}, {}
    for name, column in table.columns.items():
        if None in column:
            lacking[name] = column.index(None)
        else:
            columns[name] = np.array([float(x) for x in column if x is not None])
    if of is None:
        of = [name for name in ("p+iq", "gamma3") if all(c in columns for c in _columns(name))]
        of = of or [name for name in STATE if name in columns]
    names = _names(table.name, of, None)
    for name in (column for signal in names for column in _columns(signal) if column in lacking):
        row = lacking[name]
        key, expected = (
            f"{name} at t = {brief(table.times[row])}",
            "a number in each row of a signal",
        )
        raise BadInput(table.name, key, None, f"{expected} (row {row + 1} has none)")
    signals = {name: _signal(table.name, name, columns, None) for name in names}
    last, origin = to_double(table.times[-1]), provenance(table.name)
    return _lines_of(table.name, signals, step, last, count, {}, origin)


def _columns(name: str) -> tuple[str, ...]:
    if name == AXIS:
        return ATTITUDE
    return tuple(column for column in SIGNALS[name] if column)


def _signal(source: str, name: str, columns: Mapping[str, Any], scene: Scene | None) -> Any:
    for column in _columns(name):
        if column not in columns:
            expected = f"a column {column}, besides {', '.join(columns) or 'none'}"
            raise BadInput(source, "of", name, expected)
    if name == AXIS:
        return _axis(columns, scene)
    real, imaginary = SIGNALS[name]
    if imaginary:
        return columns[real] + 1j * columns[imaginary]
    return columns[real].astype(complex)


def _axis(columns: Mapping[str, Any], scene: Scene | None) -> Any:
    """X + iY of the third body axis; of a free body in the plane across G, which stands still."""
    q0, q1, q2, q3 = (columns[name] for name in ATTITUDE)
    axis = np.array(
        [2 * (q1 * q3 + q0 * q2), 2 * (q2 * q3 - q0 * q1), q0**2 - q1**2 - q2**2 + q3**2]
    )
    if scene is None or not scene.body.torque_free:
        return axis[0] + 1j * axis[1]
    inertia = np.array([[to_double(x) for x in row] for row in scene.body.inertia])
    momentum = inertia @ [columns[name][0] for name in STATE[:3]]
    a, *b = (float(x[0]) for x in (q0, q1, q2, q3))
    rotated = quaternion_product((a, *b), (0.0, *momentum.tolist()))
    up = np.array(quaternion_product(rotated, (a, *(-x for x in b)))[1:])
    up = up / np.linalg.norm(up)
    first = np.cross(np.eye(3)[int(np.argmin(np.abs(up)))], up)
    first = first / np.linalg.norm(first)
    return first @ axis + 1j * (np.cross(up, first) @ axis)


def _lines_of(
    name: str,
    signals: Mapping[str, Any],
    step: Spacing,
    last: float,
    count: int,
    rates: dict[str, float],
    origin: Mapping[str, Any],
) -> Frequencies:
    closed = bool(rates)
    lines: dict[str, tuple[Line, ...]] = {}
    for signal, samples in signals.items():
        bin_width = 2 * math.pi / abs(step.step * (len(samples) - 1))
        parts = []
        for line in naff.lines(samples, step.step, count):
            stretched = abs(line.frequency * (step.error / step.step))
            line = line._replace(error=line.error + stretched)
            sharp = line.error < _SHARP * bin_width
            combination = combined(line.frequency, line.error, rates) if sharp else {}
            zero = abs(line.frequency) < 10 * line.error
            if sharp and not (combination or closed or zero) and len(rates) < 3:
                label = f"{signal}: {len(rates) + 1}"
                rates[label] = float(line.frequency)
                combination = {label: 1}
            parts.append(Line(*line, combination))
        lines[signal] = tuple(parts)
    n = len(next(iter(signals.values())))
    return Frequencies(
        name,
        last,
        n,
        lines,
        rates,
        closed,
        signals=dict(signals),
        step=step.step,
        step_error=step.error,
        provenance=origin,
    )


def combined(frequency: float, error: float, rates: Mapping[str, float]) -> dict[str, int]:
    """The simplest integer combination of known frequencies that is this one; {} without any."""
    names = [name for name, value in rates.items() if value][:3]
    best: tuple[int, dict[str, int]] | None = None
    span = range(-LARGEST_FACTOR, LARGEST_FACTOR + 1)
    for factors in itertools.product(span, repeat=len(names)):
        order = sum(map(abs, factors))
        if not 0 < order <= MOST_ORDER or (best is not None and order >= best[0]):
            continue
        value = sum(k * rates[name] for k, name in zip(factors, names, strict=True))
        if abs(value - frequency) < _SURE * error + 2.0**-48 * abs(frequency):
            best = order, {n: k for n, k in zip(names, factors, strict=True) if k}
    return {} if best is None else best[1]


# --- spacing --------------------------------------------------------------------------------------
#
# The spacing of sample times, of rounded ones, too.
#
# Times t_k that are equally spaced before they are rounded by up to e_k admit every spacing s for
# which some c has |t_k - c - k s| <= e_k for all k.  These s are an interval, the set in which
#
#     room(s) = min (t_k + e_k - k s) - max (t_k - e_k - k s),
#
# a concave function of s, is not negative; Newton's method ends at both its edges.


LEAST_SAMPLES = 64  # samples
_NEWTON = 100  # steps, of which about ten are made
_TIES = 1 + 1e-9  # times the errors: a double halfway between two decimals may go either way
_EVEN = 10**9  # off by less than this part of a step, times need no rounding to be equally spaced


class Spacing(NamedTuple):
    """The time between two samples, and what it may be off."""

    step: float
    error: float


def spacing(name: str, times: Sequence[Fraction], errors: Sequence[float] = ()) -> Spacing:
    """The spacing of times that are rounded by up to ``errors``, none if empty.

    Raises BadInput, which calls the source of the times by ``name``, unless one fits all.

    >>> sixtieths = [Fraction(round(k * 1000 / 60), 1000) for k in range(100)]
    >>> even = spacing("clock", sixtieths, [0.0005] * 100)
    >>> abs(even.step - 1 / 60) < even.error < 1e-5
    True
    """
    if len(times) < LEAST_SAMPLES:
        raise BadInput(name, "times", len(times), f"{LEAST_SAMPLES} samples or more")
    last = len(times) - 1
    step = (times[-1] - times[0]) / last
    off = [t - times[0] - k * step for k, t in enumerate(times)]
    farthest = max(map(abs, off))
    if farthest <= abs(step) / _EVEN:
        return Spacing(to_double(step), to_double(2 * farthest / last))
    if errors:
        # in parts of the largest error, from the chord: no digit is lost
        size = max(errors)
        own = np.array([to_double(x / Fraction(size)) for x in off])
        wide = _TIES * np.array(errors) / size
        lowest, highest = (_edge(own, wide, side) for side in (-1, 1))
        if lowest <= highest:
            middle, half = (highest + lowest) / 2 * size, (highest - lowest) / 2 * size
            return Spacing(to_double(step + Fraction(middle)), half)
    expected = "equally spaced times, to a billionth of their step or their last printed decimal"
    raise BadInput(name, "times", None, expected)


def _edge(off: Doubles, errors: Doubles, side: int) -> float:
    """The largest spacing that fits (``side`` 1), or the smallest (-1); beyond it if none fits."""
    count = np.arange(len(off))
    low, high = off - errors, off + errors
    s = side * float(np.ptp(off) + 2 * errors.max())  # no pair of times allows more
    for _ in range(_NEWTON):
        first, then = int(np.argmax(low - count * s)), int(np.argmin(high - count * s))
        if side * (then - first) <= 0:
            break  # none fits, or all do
        edge = float(high[then] - low[first]) / (then - first)
        if side * (s - edge) <= 0:
            break
        s = edge
    return s

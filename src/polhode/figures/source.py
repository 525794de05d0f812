"""What is drawn of a scene, a result or a file: a result, or a motion in columns."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias, overload

import numpy as np

from polhode.common.errors import BadInput, nearest
from polhode.common.interrupts import Progress
from polhode.equations import integrals
from polhode.figures import canvas, catalogue
from polhode.figures import samples as sampling
from polhode.figures.samples import ANOTHER, Samples, of_samples
from polhode.judging.correct_digits import largest, log10_differences, log10_rate, scaled
from polhode.judging.reference import Reference
from polhode.judging.reference import reference as reference_of
from polhode.judging.score import Comparison
from polhode.judging.tables.column_aliases import PLAIN, naming
from polhode.judging.tables.explanations import table_as_told
from polhode.judging.tables.table import PARTS, TrajectoryTable, of_run
from polhode.judging.tables.table_file import is_table, read_table
from polhode.numbers import exact
from polhode.numbers.conversion import TIME, doubles, exactly, mpf_row, to_double
from polhode.numbers.conversion import reader as read_times
from polhode.numbers.decimals import brief
from polhode.numbers.double_double import Pairs
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import AnyNumber, NumberType, Rows, States
from polhode.results import reader
from polhode.results.result import Storable
from polhode.runs.options import USUAL, choose_number
from polhode.runs.saved import Saved, load_result
from polhode.runs.trajectory import Trajectory, solve
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import ANGLES, ATTITUDE, REQUESTS, SPACE, STATE, Several, Single

if TYPE_CHECKING:
    import numpy.typing as npt
    from matplotlib.axes import Axes

# --- departures -----------------------------------------------------------------------------------
#
# Errors and departures of the integrals over time, as the figures draw them: decimal logarithms.
#
# nan stands for a departure of exactly 0, and where nothing was judged.


SAMPLES = 501  # noise, not a curve
SPARE_DIGITS = 6
_NAMES = {integrals.ENERGY: "h", integrals.AREA: "f", integrals.LENGTH: "gamma"}


def errors(table: TrajectoryTable, reference: Reference, number: NumberType | None) -> Samples:
    """Errors against a reference: of omega over its largest modulus, and of gamma.

    As far as the table has columns of the state; ``number``: the type of its numbers, if known.
    """
    scene = reference.scene
    table = in_order(table)
    if not {*scene.columns} & table.columns.keys():
        raise BadInput(table.name, "header", None, f"a column of {', '.join(scene.columns)}")
    most = number.most_digits if number else table.printed + 2
    states_alone = {name: x for name, x in table.columns.items() if name in scene.columns}
    table = replace(table, columns=states_alone)
    true = Comparison(table, reference, table).rows("at", math.ceil(min(most, 1000)) + SPARE_DIGITS)
    states = table.numbers(scene.columns, in_pairs=isinstance(true, Pairs))
    log10_errors = scaled(log10_differences(states, true), log10_rate(true, scene))
    parts = {"omega": largest(log10_errors[:, :3]), "gamma": largest(log10_errors[:, 3:])}
    for name, logs in parts.items():
        logs[table.gaps(PARTS[name])] = math.nan  # of no whole vector
    judged = {name: logs for name, logs in parts.items() if not np.isnan(logs).all()}
    shown = {name: np.where(np.isinf(logs), math.nan, logs) for name, logs in judged.items()}
    return _samples(table, shown, scene, number)


def departures(table: TrajectoryTable, scene: Scene, number: NumberType | None) -> Samples:
    """Relative departures of the integrals from the exact scene's (see integrals.Drift).

    The table needs every column of the state.
    """
    missing = [name for name in scene.columns if name not in table.columns]
    if missing:
        raise BadInput(table.name, "header", None, f"columns {', '.join(missing)} for integrals")
    rows = table.rows(scene.columns) or []
    table = in_order(table.some([k for k, row in enumerate(rows) if None not in row]))
    bits = number.bits if number else math.ceil(table.printed * math.log2(10)) + 8
    states: Rows = [mpf_row(row, bits) for row in table.rows(scene.columns) or []]
    if table.run is not None:
        states = table.run.states
    by_integral = integrals.departures(scene, states, bits)
    shown = {_NAMES.get(name, "fourth"): _log10(values) for name, values in by_integral.items()}
    return _samples(table, shown, scene, number)


def in_order(table: TrajectoryTable) -> TrajectoryTable:
    """A table's rows in order of time; a run's are."""
    if table.run is not None:
        return table
    return table.some(sorted(range(len(table.times)), key=lambda k: table.times[k]))


def _samples(
    table: TrajectoryTable, logs: dict[str, Any], scene: Scene, number: NumberType | None
) -> Samples:
    columns = {"t": np.array([to_double(t) for t in table.times])} | logs
    return Samples(table.name, columns, scene, float(number.eps) if number else None)


def _log10(values: States) -> Any:
    return np.array([exact.log10(abs(exactly(x))) if x else math.nan for x in values])


# --- source ---------------------------------------------------------------------------------------


#: The outputs that a run for a figure of a motion needs; of the others none.
OUTPUTS = {
    "angles": ("angles",),
    "attitude": ("attitude",),
    "hodographs": ("attitude", "hodographs"),
    "motion": ("attitude",),
    "sphere": ("attitude",),
}
OVER_TIME = ("integrals", "error")  # of the whole run: not cut to a window
FREE_OF_GAMMA = ("omega", "momentum", *OVER_TIME)
LARGEST = 1e150  # of numbers whose squares are doubles
MOTION = "motion"  # what pages and films show

#: What figures are drawn of.
Source: TypeAlias = Storable | Scene | str | Path


class Unreached(BadInput):
    """A run that did not reach the last time that was to be drawn."""


@dataclass(frozen=True)
class Request:
    """How a motion is drawn, where that was said.

    ``end``: the last time.  ``number``, ``digits``: the type of the run's numbers.  ``scene``,
    ``read``, ``columns``: of a table the scene that it belongs to, its conventions, its columns.
    """

    end: AnyNumber | None = None
    number: str | None = None
    digits: int | None = None
    scene: str | Path | None = None
    read: str | None = None
    columns: str | None = None

    def refuse(self, source: str, names: Sequence[str], expected: str) -> None:
        """Raise BadInput where one of these was said."""
        for name in names:
            if (value := getattr(self, name)) is not None:
                raise BadInput(source, f"--{name}", value, expected.format(name))


class Drawing(NamedTuple):
    """What is drawn, ``subject``: a result, or samples of a motion; and as what.

    ``notes``: what is to be said of it.  ``measured``: whether the samples are a file's.
    """

    subject: Storable | Samples
    what: str
    name: str
    notes: tuple[str, ...] = ()
    measured: bool = False

    @property
    def motion(self) -> Samples:
        """The samples of a motion that is shown; raises BadInput where that is none."""
        if not isinstance(self.subject, Samples):
            raise BadInput(self.name, "--what", MOTION, "a scene, a run, or a table of a motion")
        return self.subject


def drawing_of(
    source: Source,
    word: str | None,
    request: Request,
    progress: Progress | None = None,
    usual: str = "angles",
) -> Drawing:
    """What is drawn of a source; ``word``: one of its figures, unless given its default.

    A run is made anew, in its own way, at as many times as curves need; a table of another program
    is drawn as it is, and so is a file of which a scene, conventions or columns were told.
    ``usual``: the default of a motion.
    """
    name = type(source).__name__
    if isinstance(source, (str, Path)) and is_table(source):
        path, name = Path(source), str(source)
        is_described = (request.scene, request.read, request.columns) != (None, None, None)
        is_result = path.suffix.lower() == ".json" or reader.is_result(path)
        if is_described or not is_result:
            return _of_table(path, word or usual, request)
        source = load_result(path)
    if isinstance(source, Trajectory):
        return _of_scene(source.scene, word or usual, request, source, progress)
    if isinstance(source, Storable):
        kind = catalogue.kind_of(source)
        request.refuse(name, [*vars(request)], "no --{}: it is for a motion")
        notes = []
        if isinstance(source, Saved) and kind == "Frequencies":
            notes.append(f"{name}: the lines alone, no spectrum: a file has no samples")
        return Drawing(source, catalogue.chosen(kind, word, name), name, tuple(notes))
    scene = library.load(source, takes=REQUESTS)
    return _of_scene(scene, word or usual, request, None, progress)


def _check(word: str, source: str) -> None:
    """Raise BadInput for what is no figure of a motion."""
    figures = [*catalogue.MOTION, MOTION]
    if word not in figures:
        raise BadInput(source, "--what", word, nearest(word, figures))


def _of_scene(
    scene: Scene,
    word: str,
    request: Request,
    source: Trajectory | None,
    progress: Progress | None,
) -> Drawing:
    """A scene's motion, integrated at even times; of a ``source`` that is a run in the same way."""
    _check(word, scene.name)
    request.refuse(scene.name, ("scene", "read", "columns"), "no --{}: it is for a FILE")
    if word not in FREE_OF_GAMMA and scene.gamma is None:
        raise BadInput(scene.name, "--what", word, "a scene with start.gamma")
    end = None if request.end is None else _time(scene, request.end)
    long = word in OVER_TIME
    times = sampling.shown_times(scene, end, SAMPLES if long else None)
    number: str | NumberType | None = request.number
    options = USUAL
    if source is not None and request.number is None and request.digits is None:
        number, options = source.number, source.options
        if not source.outcome.done:  # it is drawn to the end that it did not reach
            options = options._replace(max_steps=None)
    if word == "integrals":
        options = options._replace(project=False)
    if request.digits is not None:
        options = options._replace(digits=request.digits)
    stops = tuple(event for event in scene.events if event.stop)
    plain = replace(scene, times=times, outputs=OUTPUTS.get(word, ()), events=stops)
    chosen = choose_number(plain, number, request.digits)
    if options.method == "refined" and options.hindrance(plain, chosen) is not None:
        options = options._replace(method="taylor")  # no angles from a pole on
    run = solve(plain, chosen, options, progress, interruptible=False)
    if not run.outcome.done:
        expected = f"an earlier end: {run.outcome.cause}; {run.outcome.advice}"
        raise Unreached(scene.name, "end", brief(times[-1]), expected)
    notes = []
    if word == "integrals":
        note = "without projection, after which the integrals would say nothing"
        notes.append(f"{scene.name}: {note}")
    if abs(times[-1]) < abs(scene.end) and end is None:
        span = f"t = 0 to {brief(times[-1])} of {brief(scene.end)}, {sampling.WINDOW} radians"
        notes.append(f"{scene.name}: showing {span}; --end shows another time")
    apart = sampling.radians_apart(scene, times)
    if not long and apart > 0.5:
        note = f"{apart:.2g} radians between two samples: a shorter --end draws curves"
        notes.append(f"{scene.name}: {note}")
    samples = _samples_of(of_run(run), word, scene, run.number)
    return Drawing(samples, word, scene.name, tuple(notes))


def _time(scene: Scene, end: AnyNumber) -> Exact:
    try:
        return read_times(scene.units, TIME)(end)
    except ValueError as fault:
        raise BadInput(scene.name, "--end", end, f"a time ({fault})") from None


def _of_table(path: Path, word: str, request: Request) -> Drawing:
    """A table as it is."""
    source = str(path)
    _check(word, source)
    scene = None if request.scene is None else library.load(request.scene, takes=REQUESTS)
    if word in (*OVER_TIME, "momentum", MOTION) and scene is None:
        raise BadInput(source, "--scene", None, f"the scene that the file belongs to, for {word}")
    request.refuse(source, ("end",), "no --{}: a file is drawn whole")
    if scene is None:
        request.refuse(source, ("number", "digits"), "a --scene to judge the file with it")
        request.refuse(source, ("read",), "a --scene whose conventions are meant")
    number = None
    if scene is not None and (request.number is not None or request.digits is not None):
        number = choose_number(scene, request.number, request.digits)
    table = read_table(path, number, PLAIN if request.columns is None else naming(request.columns))
    if scene is not None and request.read is not None:
        table = table_as_told(table, reference_of(scene), request.read)
    notes = [f"{table.name}: {remark}" for remark in table.remarks]
    samples = _samples_of(table, word, scene, number)
    if word == MOTION:
        notes += _on_motion(samples)
    return Drawing(samples, word, str(table.name), tuple(notes), measured=True)


def _samples_of(
    table: TrajectoryTable, word: str, scene: Scene | None, number: NumberType | None
) -> Samples:
    """What a figure shows of a table, or of that of a run; raises BadInput where it cannot."""
    if scene is not None and word == "error":
        return errors(table, reference_of(scene), number)
    if scene is not None and word == "integrals":
        return departures(table, scene, number)
    if table.run is not None:
        samples = sampling.of_run(table.run)
    else:
        samples = sampling.of_table(in_order(table), scene)
        _refuse_what_is_missing(samples, word)
    _refuse_extreme_numbers(samples)
    return samples


def _refuse_extreme_numbers(samples: Samples) -> None:
    """Raise BadInput where the squares that figures take of rates or of the body leave doubles."""
    sizes = [np.abs(samples.columns[name]) for name in STATE[:3] if samples.has([name])]
    if samples.scene is not None:
        body = samples.scene.body
        moments = doubles([body.moments])[0]
        with np.errstate(all="ignore"):
            sizes += [moments, 1 / moments, np.abs(doubles([body.torque])[0])]
    largest = max((float(np.nanmax(column)) for column in sizes), default=0.0)
    if largest > LARGEST:
        expected = f"rates, moments, their inverses and the weight up to {LARGEST:g}, for a figure"
        raise BadInput(samples.name, "body, start", f"{largest:g}", expected)


def _on_motion(samples: Samples) -> list[str]:
    """What a file that is shown in motion is not."""
    motion = of_samples(samples)
    notes = [f"{samples.name}: {far}"] if (far := motion.coarse()) else []
    if not motion.on_level():
        note = "polhode compare FILE SCENE says which convention or cause"
        notes.append(f"{samples.name}: {ANOTHER[0].lower()}{ANOTHER[1:].rstrip('.')}; {note}")
    return notes


def _refuse_what_is_missing(samples: Samples, word: str) -> None:
    """Raise BadInput where a file lacks the columns of a figure, or has too few rows."""
    needs = {
        "omega": (any(samples.has([name]) for name in STATE[:3]), "one of p, q, r"),
        "momentum": (samples.has(STATE[:3]), "columns p, q, r"),
        "attitude": (samples.has(ATTITUDE), "columns q0, q1, q2, q3"),
        "motion": (samples.has((*STATE[:3], *ATTITUDE)), "columns p, q, r and q0, q1, q2, q3"),
        "angles": (any(samples.has([name]) for name in ANGLES), "one of psi, theta, phi"),
        "sphere": (samples.has(STATE[3:]), "columns gamma1, gamma2, gamma3"),
        "hodographs": (
            samples.has(STATE[:3]) and (samples.has(ATTITUDE) or samples.has(SPACE)),
            "columns p, q, r and the attitude q0, q1, q2, q3 (or omega_x, omega_y, omega_z)",
        ),
    }
    there, expected = needs[word]
    if not there:
        expected = f"{expected} for {word}"
        if word == "angles" and samples.has(ATTITUDE):
            expected += "; --what attitude draws its q0, q1, q2, q3"
        raise BadInput(samples.name, "header", ",".join(samples.columns), expected)
    if len(samples.columns["t"]) < 3:
        raise BadInput(samples.name, "file", None, "three rows or more, to draw a curve")


# --- plot -----------------------------------------------------------------------------------------


_REQUEST = [x.name for x in fields(Request)]


@overload
def plot(
    what_of: Source, what: Several, ax: object = None, **options: object
) -> npt.NDArray[np.object_]: ...
@overload
def plot(what_of: Source, what: Single, ax: object = None, **options: object) -> Axes: ...
@overload
def plot(
    what_of: Source, what: str | None = None, ax: object = None, **options: object
) -> Axes | npt.NDArray[np.object_]: ...
def plot(
    what_of: Source, what: str | None = None, ax: object = None, **options: object
) -> Axes | npt.NDArray[np.object_]:
    """Draw a figure with matplotlib; the colours of a style that is in use are taken.

    Parameters
    ----------
    what_of : Scene, str, Path or any result
        A scene; a run, which is made anew in its number type, with its tolerance, at as many times
        as curves need (beside a ``number`` or ``digits`` with the usual one); any other result; or
        the path of the file of one, or of a table as for :func:`polhode.compare`.
    what : str, optional
        Of a scene or a run: angles, omega, momentum, attitude, hodographs, sphere, integrals or
        error; of a map: fli, megno, exponent or verdict; any other result has one figure.  Unless
        given the first of these, of a motion omega into one pair of axes.
    ax : matplotlib axes, optional
        As many as the figure has panels, to draw into; new ones unless given.
    **options
        ``title``, in place of the figure's own.  Of a motion: ``end``, the last time drawn, in the
        scene's unit (unless given the scene's own, but no more than 100 radians; of integrals and
        error all), ``number``, ``digits``; of a table also ``scene``, ``read`` and ``columns``.  Of
        a map and an ensemble ``cmap``; of levels ``f_range`` and ``h_range``, two numbers each.

    Returns
    -------
    Axes or ndarray of Axes
        The axes drawn into, an array of them where there are several.

    Raises
    ------
    BadInput
        A figure that there is not, or that the scene cannot have.

    Examples
    --------
    >>> import polhode
    >>> panels = polhode.plot("lagrange/looping", "angles", end=4)
    >>> [panel.get_ylabel() for panel in panels]
    ['ψ (rad)', 'θ (rad)', 'φ (rad)']
    """
    plt = canvas.pyplot(own=False)
    drawn: dict[str, Any] = dict(options)
    request = {name: drawn.pop(name) for name in _REQUEST if name in options}
    usual = "omega" if hasattr(ax, "plot") else "angles"
    drawing = drawing_of(what_of, what, Request(**request), usual=usual)
    figure = catalogue.draw(plt, drawing.subject, ax, drawing.what, **drawn)
    panels = catalogue.own_panels(figure) if ax is None else ax
    several: npt.NDArray[np.object_] = np.ravel(np.asarray(panels, dtype=object))
    if len(several) != 1:
        return several
    only: Axes = several[0]
    return only

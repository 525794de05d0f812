"""How accurate the runs of a scene are, and files of other programs beside them: all measured."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from itertools import groupby
from typing import Any, NamedTuple, TypeAlias

from polhode.common.errors import BadInput, TooManySteps, few
from polhode.common.interrupts import Message, heard
from polhode.dynamics.lyapunov import Lyapunov, lyapunov
from polhode.judging.adaptive_precision import integrate
from polhode.judging.compare import compare
from polhode.judging.conditioning import conditioning
from polhode.judging.convergence_order import order_between
from polhode.judging.judgement import Judgement
from polhode.judging.reference import ProofTooLong, Reference, reference
from polhode.judging.score import RowDigits, fewest
from polhode.judging.tables.column_aliases import AbsentColumn
from polhode.motion.outcomes import Outcome
from polhode.numbers.conversion import to_double
from polhode.numbers.decimals import brief
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import named
from polhode.output.description import describe
from polhode.runs.propagator import propagator
from polhode.runs.trajectory import Trajectory
from polhode.scenes.scene import Scene

ReportRow: TypeAlias = tuple[Any, ...]

NUMBERS = ("double", "extended", "quad")
#: Tolerances of a step beside the type's own; of other types that alone.
TOLERANCES: Mapping[str, Sequence[str]] = {
    "double": ("1e-4", "1e-6", "1e-8", "1e-10", "1e-12", "1e-14"),
    "extended": ("1e-8", "1e-12", "1e-16"),
}
MOST_TIMES = 401  # of a scene with more so many are looked at
MOTION_STEPS = 100_000  # of the tangent that tells the exponent
REPEATS, PATIENCE = 5, 0.2  # calls that are timed, and the seconds beyond which one is enough
VERDICTS = GOOD, FAIR, BAD, UNKNOWN = "good", "fair", "bad", "unknown"
NO_PROOF = "no reference to these digits within the time that a proof may take"
#: What a scene's first lines tell, of what ``polhode show`` does.
DESCRIBED = (
    *("body", "regime", "conditions", "near", "motion", "units", "moments", "torque", "axes"),
    *("integrals", "frequencies", "tends"),
)


@dataclass(frozen=True)
class ReportRequest:
    """What a report is asked for: the options of :func:`polhode.report`."""

    number: str | None = None
    digits: int | None = None
    max_seconds: float = 20.0
    columns: Sequence[str] | None = None
    read: str | None = None

    def limits(self, scene: Scene) -> dict[str, Any]:
        """What limits a comparison's proofs: one foretold to take longer is not begun."""

        def foretold(seconds: float) -> None:
            if seconds > self.max_seconds:
                expected = "earlier times, more seconds"
                raise ProofTooLong(scene.name, "max_seconds", seconds, expected)

        return {"max_seconds": self.max_seconds, "forecast": foretold}

    @property
    def runs(self) -> Mapping[str, dict[str, Any]]:
        """The runs that are made of each scene: their names, and the options of integrate."""
        if self.number is not None:
            return {self.number: {"number": self.number, "digits": self.digits}}
        runs: dict[str, dict[str, Any]] = {name: {"number": name} for name in NUMBERS}
        if self.digits is not None:
            runs[f"{self.digits} digits"] = {"digits": self.digits}
        return runs


class GivenTable(NamedTuple):
    """A table of another program: what :func:`polhode.compare` takes, and what is told beside it.

    ``seconds``: what it cost; ``step``: that of its method; None where that is not told.
    """

    name: str
    table: Any
    seconds: float | None = None
    step: str | None = None


class AccuracyLine(NamedTuple):
    """A run or a table, and how many of its digits are right.

    ``judgement``: None where there is none, and ``why`` says why.  ``run``, ``until``: of a run,
    and the last time that was judged, where that is not its own.  ``source``: of a table.
    """

    name: str
    judgement: Judgement | None
    why: str = ""
    run: Trajectory | None = None
    until: Exact | None = None
    source: GivenTable | None = None

    @property
    def digits(self) -> RowDigits:
        """The fewest correct digits of any part at each time."""
        return () if self.judgement is None else self.judgement.fewest_digits

    @property
    def fewest(self) -> float | None:
        """The fewest of them."""
        return fewest(self.digits, None)

    @property
    def sentence(self) -> str:
        """What is said of it."""
        if self.judgement is None or self.fewest is None:
            return self.why or "nothing could be judged"
        return self.judgement.verdict

    def mark(self, goal: int | None) -> str:
        """Good: as many digits as are wanted, or half of those held; fair: one or more; or bad."""
        if self.judgement is None or self.fewest is None:
            return UNKNOWN
        subject = self.judgement.subject
        enough = min(subject.held, subject.number.most_digits) / 2 if goal is None else goal
        return GOOD if self.fewest >= enough else FAIR if self.fewest >= 1 else BAD

    def row(self, motion: Lyapunov) -> ReportRow:
        """What limits the digits; the fewest, when, those at the end, when half and all are lost.

        The last two of a table as measured, of a run as expected; beyond the end by the exponent of
        a motion on which nearby ones separate exponentially.  None: not by the end.
        """
        judgement = self.judgement
        cells: ReportRow = ("", None, None, None)
        if judgement is not None and self.fewest is not None:
            worst_time = to_double(judgement.worst_time)
            cells = judgement.limit, judgement.worst, worst_time, self.digits[-1]
        return (*cells, *self._reach(motion))

    def _reach(self, motion: Lyapunov) -> ReportRow:
        if self.run is None:
            if self.judgement is None:
                return None, None
            rows = [*zip(self.judgement.times, self.digits, strict=True)]
            return tuple(
                next((to_double(t) for t, d in rows if d is not None and d < least), None)
                for least in (self.judgement.subject.held / 2, 1.0)
            )
        expected, end = self.run.expected, to_double(self.run.scene.end)
        after, rate = [expected.halved_after, expected.lost_after], motion.exponent / math.log(10)
        if motion.verdict in ("chaotic", "unstable") and rate > 0 and expected.digits:
            for k, least in enumerate((self.run.number.most_digits / 2, 0.0)):
                if after[k] is None:
                    after[k] = end + math.copysign((expected.digits[-1] - least) / rate, end)
        return tuple(after)


@dataclass(frozen=True)
class SceneSection:
    """What was measured of a scene, and of the files beside it.

    ``verdict``: that of the worst file; of the best run where there are no files.  ``rows``: of
    each of the report's tables, without the scene's name.  ``words``: what is said beside them, by
    the same names; several lines are a text whose columns are aligned.
    """

    scene: Scene
    verdict: str
    rows: Mapping[str, Sequence[ReportRow]]
    words: Mapping[str, Sequence[str]]


def section(
    scene: Scene, files: Sequence[AccuracyLine], request: ReportRequest, say: Message
) -> SceneSection:
    """Measure a scene's runs in every number type, their cost, and the motion itself."""
    times = len(scene.times)
    if times > MOST_TIMES:
        scene = scene.at([scene.times[k] for k in few(times, MOST_TIMES)])
    lines, faults = [], []
    for name, options in request.runs.items():
        say(f"{scene.name}: {name}")
        try:
            lines.append(_judged(name, _run(scene, options), request, options))
        except BadInput as fault:
            faults.append(fault)
            lines.append(AccuracyLine(name, None, str(fault)))
    if len(faults) == len(lines):
        raise faults[0]
    say(f"{scene.name}: what the motion does to errors")
    motion = lyapunov(scene, max_steps=MOTION_STEPS)
    against, every = reference(scene), [*lines, *files]
    say(f"{scene.name}: speed against error")
    marks = [x.mark(request.digits) for x in files or lines]
    verdict = (max if files else min)(marks, key=VERDICTS.index)
    of_runs = {line.name: line.fewest for line in lines}
    of_files = fewest((x.fewest for x in files), None)
    by_digits = sorted(files, key=lambda x: math.inf if x.fewest is None else x.fewest)
    judgements = (x.judgement for x in (*by_digits, *lines) if x.fewest is not None)
    limit = next((str(x.limit) for x in judgements if x is not None), "")
    runs = [of_runs.get(name) for name in NUMBERS]
    kind = motion.verdict, limit, against.regime, against.kind
    described = [line.split(None, 1) for line in str(describe(scene)).splitlines()]
    orders = [*_orders(files)]
    rows: dict[str, Sequence[ReportRow]] = {
        "overview": [(verdict, *runs, len(files), of_files, *kind)],
        "description": [tuple(x) for x in described if len(x) == 2 and x[0] in DESCRIBED],
        "digits": [row for line in every for row in _digit_rows(line)],
        "runs": [_run_row(line, motion) for line in lines],
        "files": [_file_row(line, motion, request.digits) for line in files],
        "orders": [row for _, row in orders if row],
        "drift": [*_drift_rows(scene, every)],
        "events": [row for line in lines for row in _event_rows(line)],
        "work": [*_work_rows(scene, lines, files, request)],
    }
    words = {
        "digits": [_measured(against, times, len(scene.times)), *map(_sentence, lines)],
        "runs": [f"The motion is {motion}.{_conditioned(scene)}"],
        "files": [
            text
            for line in files
            for text in (f"*{line.name}*:", str(line.judgement or line.sentence))
        ],
        "orders": [text for text, _ in orders],
    }
    return SceneSection(scene, verdict, rows, words)


def _run(scene: Scene, options: Mapping[str, Any]) -> Trajectory:
    """A run; Ctrl-C, which ends it early without an exception, ends all."""
    run = integrate(scene, **options)
    if run.outcome is Outcome.INTERRUPTED or heard.came:
        raise KeyboardInterrupt
    return run


def _judged(
    name: str, run: Trajectory, request: ReportRequest, options: Mapping[str, Any]
) -> AccuracyLine:
    """A run held against its reference, as far as a proof goes in the time that it may take."""
    part, why = run, "" if run.outcome.done else f"the run ended early: {run.cause}"
    while any(part.times):
        try:
            judgement = compare(part, **request.limits(run.scene), details=True)
        except (ProofTooLong, TooManySteps) as fault:
            why = NO_PROOF
            seconds = fault.value if isinstance(fault.value, float) else 0.0
            share = min(0.5, request.max_seconds / max(seconds, 1e-9))
            part = _run(run.scene.at(run.scene.times[: int(len(part.times) * share)]), options)
        except BadInput as fault:
            return AccuracyLine(name, None, str(fault), run)
        else:
            until = part.times[-1] if len(part.times) < len(run.times) else None
            return AccuracyLine(name, judgement, why, run, until)
    return AccuracyLine(name, None, why or "no output time was reached", run)


def of_table(
    source: GivenTable, scene: Scene, request: ReportRequest, absent: list[AbsentColumn]
) -> AccuracyLine:
    """A table held against a scene; raises BadInput for one that cannot be read.

    ``absent``: what is said of columns that it has not, for another may have them.
    """
    how: dict[str, Any] = {"columns": request.columns, "read": request.read}
    if isinstance(source.table, Trajectory):
        how = {}
    try:
        judgement = compare(source.table, scene, **how, **request.limits(scene))
    except ProofTooLong:
        return AccuracyLine(source.name, None, f"not judged: {NO_PROOF}", source=source)
    except AbsentColumn as fault:
        absent.append(fault)
        items = ",".join(request.columns or ()).split(",")
        rest = [x for x in items if x.partition("=")[0].strip() != fault.value]
        return of_table(source, scene, replace(request, columns=rest or None), absent)
    return AccuracyLine(source.name, judgement, source=source)


# --- rows of the tables ---------------------------------------------------------------------------


def _run_row(line: AccuracyLine, motion: Lyapunov) -> ReportRow:
    run = line.run
    how = ("", "", None) if run is None else (run.number.name, run.method, run.steps)
    until = None if line.until is None else to_double(line.until)
    return (line.name, *line.row(motion), until, *how, line.why)


def _file_row(line: AccuracyLine, motion: Lyapunov, goal: int | None) -> ReportRow:
    reading = "" if line.judgement is None else line.judgement.reading or ""
    seconds = line.source and line.source.seconds
    return (line.name, line.mark(goal), *line.row(motion), seconds, reading, line.sentence)


def _digit_rows(line: AccuracyLine) -> Iterator[ReportRow]:
    if line.judgement is not None:
        times = line.judgement.times
        bands = (line.run and line.judgement.expected) or (None,) * len(times)
        for t, d, band in zip(times, line.digits, bands, strict=True):
            edges = (None, None) if band is None else (band.least, band.most)
            yield (line.name, to_double(t), d, *edges)


def _drift_rows(scene: Scene, lines: Sequence[AccuracyLine]) -> Iterator[ReportRow]:
    """Of runs and files; where the first run was corrected of one that is not, too."""
    first = lines[0].run
    if first is not None and first.projection is not None and first.projection.count:
        run = _run(scene, {"number": first.number, "project": False})
        if run.times:
            yield (f"{run.number.name}, not projected", *run.drift)
    for line in lines:
        drift = line.run.drift if line.run else line.judgement and line.judgement.drift
        if drift:
            yield (line.name, *drift)


def _event_rows(line: AccuracyLine) -> Iterator[ReportRow]:
    for event in line.run.events if line.run else ():
        columns = event.signs, event.uncertainty, event.depths
        for k, row in enumerate(zip(*columns, strict=True)):
            yield (line.name, event.name, event.shown(k), k + 1, *row)


def _orders(files: Sequence[AccuracyLine]) -> Iterator[tuple[str, ReportRow]]:
    """The order of each method of which there are several files: names equal but for digits."""

    def method(line: AccuracyLine) -> str:
        return re.sub(r"[\d.]+", "", line.name)

    for _, group in groupby(sorted(files, key=method), method):
        lines = [x for x in group if x.source and isinstance(x.source.table, str)]
        judgements = [x.judgement for x in lines if x.judgement is not None]
        steps = [x.source.step for x in lines if x.judgement and x.source and x.source.step]
        if len(judgements) > 1:
            try:
                sizes = steps if len(steps) == len(judgements) else None
                order = order_between(judgements, sizes, "after each name, FILE=h=0.01")
                row = ", ".join(order.names), order.order, order.least, order.most
                yield str(order), row
            except BadInput as fault:
                yield f"No order of convergence: {fault}", ()


def _work_rows(
    scene: Scene,
    lines: Sequence[AccuracyLine],
    files: Sequence[AccuracyLine],
    request: ReportRequest,
) -> Iterator[ReportRow]:
    """What digits cost: prepared runs to the last time judged, in each type at several tolerances.

    Of files what is told of them.
    """
    if any(line.judgement for line in lines):
        until = min((x.until for x in lines if x.until is not None), key=abs, default=scene.end)
        plain = replace(scene, outputs=(), events=(), form="principal").at((to_double(until),))
        against = reference(plain, **request.limits(plain))
        for number in NUMBERS if request.number is None else [request.number]:
            with suppress(BadInput):  # of which the table of runs tells
                for tolerance in (None, *TOLERANCES.get(number, ())):
                    yield _costed(plain, against, number, tolerance)
    for line in files:
        if line.fewest is not None and line.source and line.source.seconds is not None:
            yield (line.name, None, line.digits[-1], line.source.seconds)


def _costed(scene: Scene, against: Reference, number: str, tolerance: str | None) -> ReportRow:
    """The digits at the scene's end of a prepared run, and the least seconds of several calls."""
    call: Callable[[], Any] = (
        partial(propagator(scene, number=number, tol=tolerance), t=to_double(scene.end))
        if number in TOLERANCES
        else lambda: _run(scene, {"number": number}).states[-1]
    )
    row, seconds = call(), list[float]()
    while len(seconds) < REPEATS and sum(seconds) < PATIENCE:
        began = time.process_time()
        row = call()
        seconds.append(time.process_time() - began)
    judgement = compare([row], against, number=number, at=[scene.end], as_it_stands=True)
    return (number, float(tolerance or named(number).eps), judgement.worst, min(seconds))


# --- words beside them ----------------------------------------------------------------------------


def _measured(against: Reference, times: int, judged: int) -> str:
    how = "the closed form in balls" if against.is_closed_form else "a proven enclosure"
    thinned = f" of the scene's {times}" if times > judged else ""
    return f"Measured against {how} ({against.kind}: {against.regime}) at {judged}{thinned} times."


def _sentence(line: AccuracyLine) -> str:
    until = f"; beyond t = {brief(line.until)} {line.why}" if line.until is not None else ""
    return f"*{line.name}*: {line.sentence}{until}."


def _conditioned(scene: Scene) -> str:
    """By how much the motion multiplies errors."""
    growth = conditioning(scene, [scene.end])
    kappa, amplification = growth.kappa[-1], growth.log10_amplification[-1]
    if kappa is None:
        return ""
    sentence = f" At the end kappa is {kappa:.3g}"
    if amplification is not None:
        sentence += f", and an error made on the way is multiplied by up to {10**amplification:.3g}"
    return f"{sentence}."

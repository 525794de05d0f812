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
from typing import Any, NamedTuple

from polhode.common.errors import BadInput, TooManySteps, few
from polhode.common.interrupts import Message, heard
from polhode.dynamics.lyapunov import Lyapunov, lyapunov
from polhode.judging.adaptive_precision import integrate
from polhode.judging.certified import Certified, ProofTooLong
from polhode.judging.compare import JudgingOptions, compare, scored
from polhode.judging.conditioning import Conditioning, conditioning
from polhode.judging.convergence_order import ObservedOrder, order_between
from polhode.judging.judgement import Judgement
from polhode.judging.reference import AnyReference, reference
from polhode.motion.outcomes import Outcome
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Exact
from polhode.output.description import Description, describe
from polhode.results.cells import DOUBLE, TEXT
from polhode.results.table import Table, table_of_rows
from polhode.runs.propagator import propagator
from polhode.runs.trajectory import Trajectory
from polhode.scenes.scene import Scene

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
                raise ProofTooLong(
                    scene.name, "max_seconds", seconds, "earlier times, more seconds"
                )

        return {"max_seconds": self.max_seconds, "forecast": foretold}


class Given(NamedTuple):
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
    and the last time that was judged, where that is not its own.  ``given``: of a table.
    """

    name: str
    judgement: Judgement | None
    why: str = ""
    run: Trajectory | None = None
    until: Exact | None = None
    given: Given | None = None

    @property
    def parts(self) -> list[Sequence[float | None]]:
        """The digits of all that was judged, by parts, at each time."""
        if self.judgement is None:
            return []
        return [x for x in (self.judgement.digits, *self.judgement.part_digits.values()) if x]

    @property
    def digits(self) -> list[float | None]:
        """The fewest correct digits of any part at each time."""
        rows = zip(*self.parts, strict=True)
        return [min((d for d in row if d is not None), default=None) for row in rows]

    @property
    def fewest(self) -> float | None:
        """The fewest of them."""
        return min((d for d in self.digits if d is not None), default=None)

    @property
    def sentence(self) -> str:
        """What is said of it."""
        if self.judgement is None or self.fewest is None:
            return self.why or "nothing could be judged"
        return self.judgement.verdict

    def below(self, digits: float) -> float | None:
        """The first time with fewer digits than these; None where that is never."""
        if self.judgement is None:
            return None
        rows = zip(self.judgement.times, self.digits, strict=True)
        return next((float(t) for t, d in rows if d is not None and d < digits), None)

    def mark(self, goal: int | None) -> str:
        """Good: as many digits as are wanted, or half of those held; fair: one or more; or bad."""
        if self.judgement is None or self.fewest is None:
            return UNKNOWN
        subject = self.judgement.subject
        enough = min(subject.held, subject.number.most_digits) / 2 if goal is None else goal
        return GOOD if self.fewest >= enough else FAIR if self.fewest >= 1 else BAD


class Work(NamedTuple):
    """A prepared run to the end: its correct digits there, and the processor seconds it takes."""

    number: str
    tolerance: float
    digits: float
    seconds: float


@dataclass(frozen=True)
class SceneSection:
    """All that is measured of a scene, and of the files beside it.

    ``times``: how many the scene has, of which as many are looked at as ``scene`` has here.
    ``growth``: the conditioning at the end.  ``unprojected``: a run that shows how the integrals
    drift.  ``wanted``: the digits asked for.
    """

    scene: Scene
    times: int
    description: Description
    reference: AnyReference
    lines: Sequence[AccuracyLine]
    files: Sequence[AccuracyLine]
    orders: Sequence[ObservedOrder | str]
    motion: Lyapunov
    growth: Conditioning
    work: Sequence[Work]
    unprojected: Trajectory | None
    wanted: int | None

    @property
    def verdict(self) -> str:
        """That of the worst file; of the best run where there are no files."""
        marks = [x.mark(self.wanted) for x in self.files or self.lines]
        return (max if self.files else min)(marks, key=VERDICTS.index)

    def reach(self, line: AccuracyLine) -> tuple[float | None, float | None]:
        """The times after which half of the digits and all of them are lost; None: not by the end.

        Of a table as measured.  Of a run as expected; beyond the end by the exponent of a motion on
        which nearby ones separate exponentially.
        """
        if line.run is None:
            most = 0.0 if line.judgement is None else line.judgement.subject.held
            return line.below(most / 2), line.below(1.0)
        expected, end = line.run.expected, to_double(self.scene.end)
        rate = self.motion.exponent / math.log(10)
        separates = self.motion.verdict in ("chaotic", "unstable") and rate > 0
        half = line.run.number.most_digits / 2

        def beyond(after: float | None, least: float) -> float | None:
            if after is not None or not (separates and expected.digits):
                return after
            return end + math.copysign((expected.digits[-1] - least) / rate, end)

        return beyond(expected.halved_after, half), beyond(expected.lost_after, 0.0)


def section(
    scene: Scene, files: Sequence[AccuracyLine], request: ReportRequest, say: Message
) -> SceneSection:
    """Measure a scene's runs in every number type, their cost, and the motion itself."""
    times = len(scene.times)
    if times > MOST_TIMES:
        scene = scene.at([scene.times[k] for k in few(times, MOST_TIMES)])
    lines, faults = [], []
    for name, options in _kinds(request):
        say(f"{scene.name}: {name}")
        try:
            lines.append(_judged(name, integrate(scene, **options), request, options))
        except BadInput as fault:
            faults.append(fault)
            lines.append(AccuracyLine(name, None, str(fault)))
    if len(faults) == len(lines):
        raise faults[0]
    say(f"{scene.name}: what the motion does to errors")
    motion, growth = lyapunov(scene, max_steps=MOTION_STEPS), conditioning(scene, [scene.end])
    unprojected = None
    with suppress(BadInput):
        unprojected = _run(scene, {"number": request.number or "double", "project": False})
    say(f"{scene.name}: speed against error")
    until = min((x.until for x in lines if x.until is not None), key=abs, default=scene.end)
    work = _work(scene, until, request) if any(x.judgement for x in lines) else []
    orders, about = _orders(files), (describe(scene), reference(scene))
    parts = *about, lines, files, orders, motion, growth, work, unprojected, request.digits
    return SceneSection(scene, times, *parts)


def _kinds(request: ReportRequest) -> list[tuple[str, dict[str, Any]]]:
    """The runs that are made of each scene: a name, and the options of integrate."""
    if request.number is not None:
        return [(request.number, {"number": request.number, "digits": request.digits})]
    kinds: list[tuple[str, dict[str, Any]]] = [(x, {"number": x}) for x in NUMBERS]
    if request.digits is not None:
        kinds.append((f"{request.digits} digits", {"digits": request.digits}))
    return kinds


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
            _ = judgement.worst
        except BadInput as fault:
            if not isinstance(fault, (ProofTooLong, TooManySteps)):
                return AccuracyLine(name, None, str(fault), run)
            why = "no reference to these digits within the time that a proof may take"
            seconds = fault.value if isinstance(fault.value, float) else 0.0
            share = min(0.5, request.max_seconds / max(seconds, 1e-9))
            part = _run(run.scene.at(run.scene.times[: int(len(part.times) * share)]), options)
            continue
        until = part.times[-1] if len(part.times) < len(run.times) else None
        return AccuracyLine(name, judgement, why, run, until)
    return AccuracyLine(name, None, why or "no output time was reached", run)


def of_table(source: Given, scene: Scene, request: ReportRequest) -> AccuracyLine:
    """A table held against a scene; raises BadInput for one that cannot be read."""
    how: dict[str, Any] = {"columns": request.columns, "read": request.read}
    if isinstance(source.table, Trajectory):
        how = {}
    try:
        judgement = compare(source.table, scene, **how, **request.limits(scene))
    except ProofTooLong:
        why = "not judged: no reference within the time that a proof may take"
        return AccuracyLine(source.name, None, why, given=source)
    return AccuracyLine(source.name, judgement, given=source)


def _orders(files: Sequence[AccuracyLine]) -> Sequence[ObservedOrder | str]:
    """The order of each method of which there are several files: names equal but for digits."""

    def method(line: AccuracyLine) -> str:
        return re.sub(r"[\d.]+", "", line.name)

    orders: list[ObservedOrder | str] = []
    for _, group in groupby(sorted(files, key=method), method):
        lines = [*group]
        judgements = [x.judgement for x in lines if x.judgement is not None]
        steps = [x.given.step for x in lines if x.judgement and x.given and x.given.step]
        if len(judgements) < 2:
            continue
        try:
            orders.append(order_between(judgements, steps if len(steps) == len(lines) else None))
        except BadInput as fault:
            orders.append(f"no order of convergence: {fault}")
    return orders


def _work(scene: Scene, end: Exact, request: ReportRequest) -> list[Work]:
    """What digits at the end cost: prepared runs in each number type at several tolerances."""
    plain = replace(scene, outputs=(), events=(), form="principal").at((end,))
    against = reference(plain)
    if isinstance(against, Certified):
        against = Certified(plain, **request.limits(plain))
    rows = []
    for number in NUMBERS if request.number is None else [request.number]:
        with suppress(BadInput):  # of which the table of runs tells
            for tolerance in (None, *TOLERANCES.get(number, ())):
                rows.append(_costed(plain, against, number, tolerance))
    return rows


def _costed(scene: Scene, against: AnyReference, number: str, tolerance: str | None) -> Work:
    """The digits at the scene's end of one prepared run, and the least seconds of several calls."""
    call: Callable[[], Any]
    if number in TOLERANCES:
        go = propagator(scene, number=number, tol=tolerance)
        end = go.number.rounded(scene.end)
        call = partial(go, t=to_double(end) if number == "double" else end)
        step = float(tolerance or go.number.eps)
    else:
        run = _run(scene, {"number": number})
        end, step = run.times[-1], run.tolerance
        call = partial(_last_state, scene, number)
    row = call()
    seconds: list[float] = []
    while len(seconds) < REPEATS and sum(seconds) < PATIENCE:
        began = time.process_time()
        row = call()
        seconds.append(time.process_time() - began)
    score, _ = scored([row], against, JudgingOptions(number, at=[end], as_it_stands=True))
    return Work(number, step, score.worst, min(seconds))


def _last_state(scene: Scene, number: str) -> Any:
    return _run(scene, {"number": number}).states[-1]


# --- report tables --------------------------------------------------------------------------------
#
# The tables of numbers of an accuracy report: in each the first column is the scene.


SHOWN = 4  # digits, where people read them

_Row = tuple[Any, ...]


class _Maker(NamedTuple):
    """What makes a table: its columns of texts, then those of numbers, and a scene's rows."""

    texts: str
    numbers: str
    rows: Callable[[SceneSection], Iterator[_Row]]


def tables(sections: Sequence[SceneSection]) -> Mapping[str, Table]:
    """All of them by name."""
    by_name = {}
    for name, (texts, numbers, rows) in _MAKERS.items():
        types = dict.fromkeys(["scene", *texts.split()], TEXT)
        types |= dict.fromkeys(numbers.split(), DOUBLE)
        every = [(x.scene.name, *row) for x in sections for row in rows(x)]
        columns = table_of_rows(types, every).columns
        by_name[name] = Table([column._replace(digits=SHOWN) for column in columns])
    return by_name


def _overview_rows(of: SceneSection) -> Iterator[_Row]:
    fewest = {line.name: line.fewest for line in of.lines}
    judged = [x.judgement for x in of.lines if x.judgement is not None]
    limit = judged[0].limit if judged else ""
    kind = of.reference.kind, of.reference.regime, of.motion.verdict
    files = min((d for x in of.files if (d := x.fewest) is not None), default=None)
    yield (of.verdict, limit, *kind, *map(fewest.get, NUMBERS), len(of.files), files)


def _run_rows(of: SceneSection) -> Iterator[_Row]:
    for line in of.lines:
        run = line.run
        texts = ("", "") if run is None else (run.number.name, run.method)
        steps = None if run is None else run.steps
        until = None if line.until is None else to_double(line.until)
        yield (line.name, *texts, _limit(line), line.why, steps, *_digits_of(of, line), until)


def _file_rows(of: SceneSection) -> Iterator[_Row]:
    for line in of.files:
        reading = "" if line.judgement is None else line.judgement.reading or ""
        texts = line.mark(of.wanted), _limit(line), reading, line.sentence
        yield (line.name, *texts, *_digits_of(of, line), line.given and line.given.seconds)


def _limit(line: AccuracyLine) -> str:
    return "" if line.judgement is None else line.judgement.limit


def _digits_of(of: SceneSection, line: AccuracyLine) -> _Row:
    """The fewest digits, when, those at the end, and when half of them and all are lost."""
    if line.judgement is None or line.fewest is None:
        return (None,) * 3 + of.reach(line)
    worst = line.judgement.worst, to_double(line.judgement.worst_time)
    return (*worst, line.digits[-1], *of.reach(line))


def _digit_rows(of: SceneSection) -> Iterator[_Row]:
    for line in (*of.lines, *of.files):
        if line.judgement is None:
            continue
        times = line.judgement.times
        bands = (line.run and line.judgement.expected) or (None,) * len(times)
        for t, d, band in zip(times, line.digits, bands, strict=True):
            edges = (None, None) if band is None else (band.least, band.most)
            yield (line.name, to_double(t), d, *edges)


def _drift_rows(of: SceneSection) -> Iterator[_Row]:
    if of.unprojected is not None and of.unprojected.times:
        yield (f"{of.unprojected.number.name}, not projected", *of.unprojected.drift)
    for line in (*of.lines, *of.files):
        drift = line.run.drift if line.run else line.judgement and line.judgement.drift
        if drift:
            yield (line.name, *drift)


def _event_rows(of: SceneSection) -> Iterator[_Row]:
    for line in of.lines:
        for event in line.run.events if line.run else ():
            columns = event.signs, event.uncertainty, event.depths
            for k, row in enumerate(zip(*columns, strict=True)):
                yield (line.name, event.name, event.shown(k), k + 1, *row)


def _work_rows(of: SceneSection) -> Iterator[_Row]:
    yield from of.work
    for line in of.files:
        if line.fewest is not None and line.given and line.given.seconds is not None:
            yield (line.name, None, line.digits[-1], line.given.seconds)


def _order_rows(of: SceneSection) -> Iterator[_Row]:
    for order in of.orders:
        if not isinstance(order, str):
            yield (", ".join(order.names), order.order, order.least, order.most)


_KNOWN = "digits t_of_digits digits_end half_lost_after lost_after"
_MAKERS = {
    "overview": _Maker(
        "verdict limit reference regime motion",
        f"{' '.join(f'digits_{x}' for x in NUMBERS)} files digits_files",
        _overview_rows,
    ),
    "runs": _Maker("run number method limit remark", f"steps {_KNOWN} judged_until", _run_rows),
    "digits": _Maker(
        "of", "t correct_digits digits_expected_least digits_expected_most", _digit_rows
    ),
    "drift": _Maker("of", "h f gamma fourth", _drift_rows),
    "events": _Maker("run event t", "count sign uncertainty depth", _event_rows),
    "work": _Maker("of", "tolerance digits seconds", _work_rows),
    "files": _Maker("file verdict limit reading sentence", f"{_KNOWN} seconds", _file_rows),
    "orders": _Maker("files", "order order_least order_most", _order_rows),
}

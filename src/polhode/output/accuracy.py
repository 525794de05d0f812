"""How accurate the runs of a scene are, and files of other programs beside them: all measured."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from itertools import groupby
from typing import Any, NamedTuple

from polhode.common.errors import BadInput
from polhode.common.interrupts import heard
from polhode.common.progress import Message
from polhode.common.text_tables import few
from polhode.judging.adaptive_precision import integrate
from polhode.judging.conditioning.conditioning import Conditioning, conditioning
from polhode.judging.conditioning.lyapunov import Lyapunov, lyapunov
from polhode.judging.convergence_order import ObservedOrder, order_between
from polhode.judging.references.certified import Certified
from polhode.judging.references.reference import AnyReference, reference
from polhode.judging.score.compare import compare
from polhode.judging.score.judgement import Judgement
from polhode.motion.outcomes import Outcome
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Exact
from polhode.runs.propagator import propagator
from polhode.runs.trajectory import Trajectory
from polhode.scenes.scene import Scene

NUMBERS = ("double", "extended", "quad")
#: Tolerances of a step beside the type's own; quad has that alone.
TOLERANCES: Mapping[str, Sequence[str]] = {
    "double": ("1e-4", "1e-6", "1e-8", "1e-10", "1e-12", "1e-14"),
    "extended": ("1e-8", "1e-12", "1e-16"),
}
MOST_TIMES = 401  # of a scene with more so many are looked at
MOTION_STEPS = 100_000  # of the tangent that tells the exponent
REPEATS, PATIENCE = 5, 0.2  # calls that are timed, and the seconds beyond which one is enough
GOOD, FAIR, BAD, UNKNOWN = "good", "fair", "bad", "unknown"


@dataclass(frozen=True)
class Asked:
    """What a report is asked for: the options of :func:`polhode.report`."""

    number: str | None = None
    digits: int | None = None
    max_seconds: float = 20.0
    columns: Sequence[str] | None = None
    read: str | None = None


class Given(NamedTuple):
    """A table of another program: what :func:`polhode.compare` takes, and what is told beside it.

    ``seconds``: what it cost; ``step``: that of its method; None where that is not told.
    """

    name: str
    table: Any
    seconds: float | None = None
    step: str | None = None


class Line(NamedTuple):
    """A run in one number type: how many digits are right, as far as a reference goes.

    ``judgement``: None where there is none, and ``why`` says why.  ``until``: the last time that
    was judged, where that is not the run's.
    """

    name: str
    run: Trajectory | None
    judgement: Judgement | None
    until: Exact | None = None
    why: str = ""

    @property
    def at_end(self) -> float | None:
        """The correct digits at the last time that was judged."""
        return None if self.judgement is None else last_of(self.judgement)


class FileLine(NamedTuple):
    """A table that was judged; ``judgement`` None where that was not possible, and why."""

    given: Given
    judgement: Judgement | None
    why: str = ""


class Work(NamedTuple):
    """A prepared run to the end: its correct digits there, and the processor seconds it takes."""

    number: str
    tolerance: float
    digits: float
    seconds: float


@dataclass(frozen=True)
class Section:
    """All that is measured of a scene, and of the files beside it."""

    scene: Scene
    thinned: int  # how many times the scene has, where not all are looked at; else 0
    reference: AnyReference
    lines: Sequence[Line]
    files: Sequence[FileLine]
    orders: Sequence[ObservedOrder | str]
    motion: Lyapunov
    growth: Conditioning
    work: Sequence[Work]
    unprojected: Trajectory | None
    wanted: int | None

    @property
    def verdict(self) -> str:
        """Good, fair or bad: the worst of the files, or the best of the runs where there are none.

        Good: as many digits as were asked for, or half of the number type's; fair: one or more.
        """
        words = [GOOD, FAIR, BAD]
        if self.files:
            known = [self.mark(x.judgement) for x in self.files]
            return max(known, key=[*words, UNKNOWN].index)
        known = [self.mark(x.judgement) for x in self.lines]
        return min(known, key=[*words, UNKNOWN].index)

    def mark(self, judgement: Judgement | None) -> str:
        """The word for the fewest digits of a judgement."""
        if judgement is None:
            return UNKNOWN
        worst = fewest(judgement)
        if worst is None:
            return UNKNOWN
        held = min(judgement.subject.held, judgement.subject.number.most_digits)
        enough = held / 2 if self.wanted is None else self.wanted
        return GOOD if worst >= enough else FAIR if worst >= 1 else BAD

    def reach(self, line: Line) -> tuple[float | None, float | None]:
        """The times after which half of the digits and all of them are lost; None: not by the end.

        Beyond the end by the exponent of a motion in which nearby ones separate exponentially.
        """
        if line.run is None:
            return None, None
        expected = line.run.expected
        held, end = line.run.number.most_digits, to_double(self.scene.end)
        rate = self.motion.exponent / math.log(10)
        growing = self.motion.verdict in ("chaotic", "unstable") and rate > 0
        times = []
        for after, least in ((expected.halved_after, held / 2), (expected.lost_after, 0.0)):
            if after is None and growing and expected.digits:
                after = end + math.copysign((expected.digits[-1] - least) / rate, end)
            times.append(after)
        return times[0], times[1]


def fewest(judgement: Judgement) -> float | None:
    """The fewest correct digits of all that was judged; None where nothing was."""
    try:
        return judgement.worst
    except BadInput:
        return None


def last_of(judgement: Judgement) -> float | None:
    """The fewest correct digits of any part at the last time."""
    rows = [judgement.digits, *judgement.part_digits.values()]
    return min((row[-1] for row in rows if row and row[-1] is not None), default=None)


def section(scene: Scene, files: Sequence[FileLine], asked: Asked, say: Message) -> Section:
    """Measure a scene's runs in every number type, their cost, and the motion itself."""
    count = len(scene.times)
    if count > MOST_TIMES:
        scene = scene.at([scene.times[k] for k in few(count, MOST_TIMES)])
    lines, faults = [], []
    for name, options in _kinds(asked):
        say(f"{scene.name}: {name}")
        try:
            run = integrate(scene, **options)
        except BadInput as fault:
            faults.append(fault)
            lines.append(Line(name, None, None, why=str(fault)))
            continue
        if run.outcome is Outcome.INTERRUPTED:
            raise KeyboardInterrupt
        lines.append(_judged(name, run, asked, options))
        end_if_interrupted()
    if len(faults) == len(lines):
        raise faults[0]
    say(f"{scene.name}: what the motion does to errors")
    motion = lyapunov(scene, max_steps=MOTION_STEPS)
    growth = conditioning(scene, [scene.end])
    unprojected = None
    with suppress(BadInput):
        unprojected = integrate(scene, asked.number or "double", project=False)
    end_if_interrupted()
    say(f"{scene.name}: speed against error")
    until = min((x.until for x in lines if x.until is not None), key=abs, default=scene.end)
    work = _work(scene, until, asked) if any(x.judgement for x in lines) else []
    end_if_interrupted()
    return Section(
        scene,
        count if count > MOST_TIMES else 0,
        reference(scene),
        lines,
        files,
        [*_orders(files)],
        motion,
        growth,
        work,
        unprojected,
        asked.digits,
    )


def _kinds(asked: Asked) -> list[tuple[str, dict[str, Any]]]:
    """The runs that are made of each scene: a name, and the options of integrate."""
    if asked.number is not None:
        return [(asked.number, {"number": asked.number, "digits": asked.digits})]
    kinds: list[tuple[str, dict[str, Any]]] = [(x, {"number": x}) for x in NUMBERS]
    if asked.digits is not None:
        kinds.append((f"{asked.digits} digits", {"digits": asked.digits}))
    return kinds


def _judged(name: str, run: Trajectory, asked: Asked, options: Mapping[str, Any]) -> Line:
    """A run held against its reference, as far as a proof goes in the time that it may take."""
    times = run.times
    part, why = run, "" if run.outcome.done else f"the run ended early: {run.cause}"
    while len(part.times):
        try:
            judgement = compare(part, **_limits(asked, part.scene))
            _ = judgement.worst
        except BadInput as fault:
            if fault.key not in ("max_seconds", "at"):
                return Line(name, run, None, why=str(fault))
            seconds = fault.value if isinstance(fault.value, float) else math.inf
            share = min(0.5, asked.max_seconds / seconds if seconds > 0 else 0.5)
            count = int(len(part.times) * share)
            why = "no reference to these digits within the time that a proof may take"
            if not any(part.times[:count]):
                break
            part = integrate(run.scene.at(run.scene.times[:count]), **options)
            continue
        until = part.times[-1] if len(part.times) < len(times) else None
        return Line(name, run, judgement, until, why)
    return Line(name, run, None, why=why or "no output time was reached")


def _limits(asked: Asked, scene: Scene) -> dict[str, Any]:
    """What limits the proofs of a comparison: one foretold to take longer is not begun."""

    def foretold(seconds: float) -> None:
        if seconds > asked.max_seconds:
            raise BadInput(scene.name, "max_seconds", seconds, "earlier times, or more seconds")

    return {"max_seconds": asked.max_seconds, "forecast": foretold}


def file_line(given: Given, scene: Scene, asked: Asked) -> FileLine:
    """A table held against a scene; raises BadInput for one that cannot be read."""
    how: dict[str, Any] = {"columns": asked.columns, "read": asked.read}
    if isinstance(given.table, Trajectory):
        how = {}
    try:
        judgement = compare(given.table, scene, **how, **_limits(asked, scene))
        _ = judgement.worst
    except BadInput as fault:
        if fault.key != "max_seconds":
            raise
        return FileLine(given, None, "no reference within the time that a proof may take")
    return FileLine(given, judgement)


def _orders(files: Sequence[FileLine]) -> Sequence[ObservedOrder | str]:
    """The order of each method of which there are several files: names equal but for digits."""

    def method(line: FileLine) -> str:
        return re.sub(r"[\d.]+", "", line.given.name)

    orders: list[ObservedOrder | str] = []
    for _, group in groupby(sorted(files, key=method), method):
        lines = [line for line in group if line.judgement is not None]
        steps = [line.given.step for line in lines]
        if len(lines) < 2:
            continue
        try:
            told = None if None in steps else steps
            orders.append(order_between([x.judgement for x in lines if x.judgement], told))
        except BadInput as fault:
            orders.append(f"no order of convergence: {fault}")
    return orders


def _work(scene: Scene, end: Exact, asked: Asked) -> list[Work]:
    """What digits at the end cost: prepared runs in each number type at several tolerances."""
    plain = replace(scene, outputs=(), events=(), form="principal").at((end,))
    against = reference(plain)
    if isinstance(against, Certified):
        against = Certified(plain, **_limits(asked, plain))
    rows = []
    for name in NUMBERS if asked.number is None else [asked.number]:
        for tolerance in (None, *TOLERANCES.get(name, ())):
            try:
                rows.append(_costed(plain, against, name, tolerance))
            except BadInput:  # which the table of runs tells of
                break
            end_if_interrupted()
    return rows


def _costed(scene: Scene, against: AnyReference, number: str, tolerance: str | None) -> Work:
    """The digits at the scene's end of one prepared run, and the least seconds of several calls."""
    call: Callable[[], Any]
    if number in TOLERANCES:
        go = propagator(scene, number=number, tol=tolerance)
        end = go.number.rounded(scene.end)
        t = to_double(end) if number == "double" else end
        call, held = partial(go, t=t), float(tolerance or go.number.eps)
    else:
        run = integrate(scene, number)
        end, held = run.times[-1], run.tolerance
        call = partial(_last_state, scene, number)
    row = call()
    seconds: list[float] = []
    while len(seconds) < REPEATS and sum(seconds) < PATIENCE:
        began = time.process_time()
        row = call()
        seconds.append(time.process_time() - began)
    judgement = compare([row], against, at=[end], number=number, as_it_stands=True)
    return Work(number, held, judgement.worst, min(seconds))


def _last_state(scene: Scene, number: str) -> Any:
    return integrate(scene, number).states[-1]


def end_if_interrupted() -> None:
    """Ctrl-C during a run ends the run early, without an exception."""
    if heard.came:
        raise KeyboardInterrupt

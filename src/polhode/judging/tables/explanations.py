"""How a table is read that is wrong as it stands, and what explains one that stays wrong.

Its times may have another unit or another beginning, each part another convention; it may be the
motion of another scene.  All of that is found from a few rows (:func:`probed_rows`), by the rule
of :mod:`polhode.judging.tables.hypotheses`; the rows of very many that a file has are then judged
once, as they are read.  Or somebody tells the readings, which are applied whatever they give:
``omega degrees; attitude scalar-last``.  The words are those that a judgement prints, no others.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from difflib import get_close_matches
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from polhode.common.errors import BadInput, few, listed
from polhode.judging.reference import Reference
from polhode.judging.tables.column_aliases import lengths, of_length_one
from polhode.judging.tables.conventions import (
    ALIKE_AT_START,
    SCALAR_FIRST,
    conventions,
    is_unit_alone,
)
from polhode.judging.tables.hypotheses import (
    AS_THEY_STAND,
    EXACT,
    SURE,
    Evidence,
    Hypothesis,
    Right,
    Trial,
    at_other_times,
    clock_remark,
    constant_omega,
    errors_of_rows,
    explains,
    integrated,
    is_alike,
    other_numbers,
    other_scenes,
    other_times,
    size_of_motion,
)
from polhode.judging.tables.table import (
    LENGTH,
    PARTS,
    WRONG,
    Reading,
    TimeChange,
    TrajectoryTable,
    as_judged,
)
from polhode.numbers.conversion import doubles, to_double
from polhode.numbers.number_types import Doubles
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import ATTITUDE

_FIRST_ROWS, _LATER_ROWS = 5, 6  # that are looked at: the first, and later ones ever farther apart
_FARTHEST = (1e4, 1e5)  # radians or so, to which motions at other times are followed
_FEWEST = 2  # rows that tell other times
_APPLIED = "a reading that can be applied; this one is reported, and not applied"

# --- a table beside a motion ----------------------------------------------------------------------


class View(NamedTuple):
    """The parts of a table of which every number is there, in the rows that tell, as doubles.

    ``right``: the scene's motion at the times as they stand; None where it is not known there.
    ``parts``: of each part its plainest convention of the best, beside the part as it stands.
    """

    values: dict[str, Doubles]
    times: list[Fraction]
    right: Right | None
    parts: dict[str, Trial]

    @property
    def is_explained(self) -> bool:
        """Whether the first rows of all parts are right, as they stand or in a convention."""
        return all(
            part.is_told or float(np.min(part.rival.rows[:_FIRST_ROWS])) >= WRONG
            for part in self.parts.values()
        )

    def readings(self) -> list[Reading]:
        """Of each part that is wrong the convention that makes its first rows right, if any."""
        return [
            _reading(name, part.rival.digits, part.evidence, self.times)
            for name, part in self.parts.items()
            if part.is_told
        ]

    def readings_in(self, scene: Hypothesis, parts: Mapping[str, Trial]) -> list[Reading]:
        """Of each part that is wrong its convention in another scene's motion."""
        readings = []
        for name, there in parts.items():
            plain, best = self.parts[name].rival, there.convention
            same = is_alike(self.parts[name].evidence.course, best.course)
            if plain.digits >= WRONG or (same and not there.is_told):
                continue
            words = ", ".join(filter(None, (scene.words, best.hypothesis.words)))
            reading = _reading(name, plain.digits, best, self.times)
            readings.append(reading._replace(convention=words, change=None, how="right with"))
        return readings


def view(subject: TrajectoryTable, reference: Reference) -> View:
    """A table beside the motion of a reference."""
    parts, common = [], {*range(len(subject.times))}  # that have all their numbers in some rows
    for part, names in PARTS.items():
        if rows := common.intersection(subject.whole_rows(names)):
            parts.append(part)
            common = rows
    whole = sorted(common)
    some = subject.some([whole[k] for k in probed_rows([subject.times[k] for k in whole])])
    values, times = {part: doubles(some.rows(PARTS[part]) or []) for part in parts}, [*some.times]
    right = _motion(reference, times)
    return View(values, times, right, _parts(values, right))


def probed_rows(times: Sequence[Fraction]) -> list[int]:
    """The rows that tell a convention: from the start on, the last one too."""
    order = sorted(range(len(times)), key=lambda k: abs(to_double(times[k])))
    count = len(order)
    if count <= _FIRST_ROWS + _LATER_ROWS:
        return order
    later = np.geomspace(_FIRST_ROWS, count - 1, _LATER_ROWS)
    return [order[k] for k in sorted({*range(_FIRST_ROWS), *(round(float(x)) for x in later)})]


def shown_rows(evidence: Evidence, times: Sequence[Fraction]) -> tuple[tuple[Fraction, float], ...]:
    """Times with the digits there: the first row, one on the way, the last one."""
    first, last = evidence.rows_fitted, len(times) - 1
    middle = min(range(first, last + 1), key=lambda k: abs(abs(times[k]) - abs(times[last]) / 4))
    return tuple((times[k], float(evidence.rows[k])) for k in sorted({first, middle, last}))


def _reading(
    part: str, before: float | None, evidence: Evidence, times: Sequence[Fraction]
) -> Reading:
    """A part in its convention; ``before``: its digits as it stands."""
    words, rows = evidence.hypothesis.words, shown_rows(evidence, times)
    return Reading(part, before, words, evidence.digits, evidence.hypothesis.change, rows)


def _motion(reference: Reference, times: Sequence[Fraction]) -> Right | None:
    """The reference's motion with its attitude; a run in double tells what is enclosed, whose proof
    may have far to go."""

    def rows(question: Callable[..., Any]) -> Any:
        try:
            return np.array([[float(x) for x in row] for row in question(times, 18)])
        except (TypeError, ValueError):  # no closed form for it, a pole
            return None

    run = integrated(reference.scene, times) if reference.encloses_attitude else None
    if not reference.is_closed_form:
        return run
    states = rows(reference.at)
    if states is None:
        return None
    attitude = run and run.attitude if reference.encloses_attitude else rows(reference.attitude)
    return Right(states, attitude)


def _parts(
    values: Mapping[str, Doubles], right: Right | None, must_move: bool = False
) -> dict[str, Trial]:
    """Parts beside a motion, each in its best convention; of none that is known as they stand.

    ``must_move``: whether a motion that stands still tells nothing.
    """
    if right is None:
        nothing = {k: Evidence(Hypothesis(), np.zeros(len(rows))) for k, rows in values.items()}
        return {k: Trial(plain, plain, False) for k, plain in nothing.items()}
    count = len(right.states)
    parts = {k: _part(k, rows[:count], right, must_move) for k, rows in values.items()}
    return _with_same_axes({k: part for k, part in parts.items() if part is not None})


def _part(part: str, values: Doubles, right: Right, must_move: bool) -> Trial | None:
    """The best convention of a part; as it stands, where no other tells more or the part is right.

    A rotation that is fitted has to explain what the best of the others leaves.
    """
    tried = conventions(part, values, right)
    plain = next(tried, None)
    if plain is None:
        return None
    moved = right.moved(part)
    if plain.digits >= WRONG:
        return Trial(plain, plain, not must_move or plain.follows(moved, must_move))
    every = [plain, *tried]
    named = _best(part, [x for x in every if not x.rows_fitted], plain, moved, must_move)
    rotations = [x for x in every if x.rows_fitted]
    if not rotations:
        return named
    fitted = _best(part, rotations, plain, moved, must_move)
    explained = fitted.is_told and fitted._replace(rival=named.convention).is_told
    return fitted if explained else named


def _best(
    part: str, evidence: Sequence[Evidence], plain: Evidence, moved: Doubles, must_move: bool
) -> Trial:
    """The plainest of the best conventions beside the part as it stands.

    A start of numbers that are not round is one in few conventions: there, it alone tells.
    """
    courses = [x.course for x in evidence]
    most = max(courses, key=np.sum)
    pairs = zip(evidence, courses, strict=True)
    best = next(x for x, course in pairs if is_alike(course, most))
    starts = sum(float(course[0]) >= SURE for course in courses)
    is_named = is_unit_alone(best.hypothesis) or starts <= ALIKE_AT_START[part]
    is_named = is_named and not best.hypothesis.words.startswith(SCALAR_FIRST)
    goes = best.follows(moved, must_move, is_named and not best.rows_fitted)
    return Trial(best, plain, goes)


def _with_same_axes(parts: dict[str, Trial]) -> dict[str, Trial]:
    """Parts of which gamma or omega, in axes that the other one tells, is the only one tried."""
    for name, partner in (("gamma", "omega"), ("omega", "gamma")):
        mine, its = parts.get(name), parts.get(partner)
        if mine is None or its is None or mine.is_told or not its.is_told:
            continue
        own, theirs = mine.evidence.hypothesis.change, its.evidence.hypothesis.change
        if own is None or theirs is None or own.order != theirs.order:
            continue
        same = own.signs in (theirs.signs, tuple(-s for s in theirs.signs))  # omega: a pseudovector
        if same and (alone := mine.of_tries(1)).is_told:
            parts[name] = alone
    return parts


# --- other motions --------------------------------------------------------------------------------


def other_motion(
    current: View, subject: TrajectoryTable, scene: Scene
) -> tuple[Hypothesis, dict[str, Trial]] | None:
    """The motion of which a table that is wrong is right in its first rows; None where none is.

    The one that explains most, the first of those that are alike.
    """
    best, parts_of_best = None, current.parts
    if all(part.convention.digits >= WRONG for part in parts_of_best.values()):
        return None
    for hypothesis, right in _other_motions(current.times, subject.times, scene):
        parts = _parts(current.values, right, must_move=True)
        if parts.keys() != parts_of_best.keys():
            continue
        beside = []
        for name, part in parts.items():
            convention = part.evidence.hypothesis  # as many as these were tried in each motion
            tries = hypothesis.tries * (convention.tries if convention.words else 1)
            beside.append(part.of_tries(tries)._replace(rival=parts_of_best[name].evidence))
        if explains(beside):
            best, parts_of_best = hypothesis, parts
            if all(part.goes and part.convention.digits >= SURE for part in parts.values()):
                break  # in all its rows: the others are farther away
    return None if best is None else (best, parts_of_best)


def _other_motions(
    times: Sequence[Fraction], all_times: Sequence[Fraction], scene: Scene
) -> Iterator[tuple[Hypothesis, Right]]:
    """The scene's motion at other times as far as it is followed, and that of other scenes."""
    rate = 10.0**scene.log10_rate
    for hypothesis in at_other_times(all_times, scene):
        _, change = hypothesis.of(Fraction(0))
        some = [change.of(t) for t in times]
        for farthest in _FARTHEST:
            far = [k for k, t in enumerate(some) if abs(t) * rate > farthest]
            there = some[: far[0]] if far else some
            if len(there) >= _FEWEST:
                break
        right = integrated(scene, there) if len(there) >= _FEWEST else None
        if right is not None:
            yield hypothesis, right
    for hypothesis in other_scenes(scene):
        right = integrated(hypothesis.of(Fraction(0))[0], times)
        if right is not None:
            yield hypothesis, right


# --- other numbers --------------------------------------------------------------------------------
#
# One number at a time is fitted to the table, by Gauss's and Newton's method on the motion
# integrated in double, over rows from the first ones on, so that a motion that turns many times is
# not lost.  Nothing is changed: it may be the program's mistake, or the scene's.
#
# A rough method is late or early as a slow clock is, or as a body of other moments: so a change of
# less than ``LEAST`` is told only if the table is then right to more digits than such a method's.


LEAST, _LEAST_IF_EXACT = 1e-4, 1e-7  # of a number
_ROWS = 40
_FIRST = 6  # rows that are fitted first; then twice as many, and so on
_STEPS, _HALVINGS = 8, 5  # of Gauss and Newton; of a step that leads nowhere
_SMALL = 1e-6  # a change that a derivative is taken by
_LEADS = 0.5  # of the square of what is left of the first rows, at least, is along the change
_FARTHEST_FITTED = 3e3  # radians or so
_TOLD = 3  # causes at most
_MOST_DIGITS, _MOST_TOLD = 16.0, 15.0  # of doubles that are equal; that are told


class Cause(NamedTuple):
    """A number that makes a table right, in words, and the fewest digits of the table then."""

    words: str
    digits: float

    def __str__(self) -> str:
        return f"explained by {self.words}, which gives {self.digits:.1f} digits"


def causes(subject: TrajectoryTable, scene: Scene) -> tuple[Cause, ...]:
    """What explains a table of states that is wrong, the best first; empty where nothing does."""
    whole = subject.some(subject.whole_rows(subject.state))
    chosen = few(len(whole.times), _ROWS)
    some = whole.some(sorted(chosen, key=lambda k: abs(whole.times[k])))
    times, cells = [*some.times], some.rows(some.state)
    columns = [k for k, name in enumerate(scene.columns) if name in some.state]
    speed = max([1e-300, *(abs(to_double(x)) for x in scene.start[:3])])
    if not cells or abs(to_double(times[-1])) * speed > _FARTHEST_FITTED:
        return ()
    plain = integrated(scene, times, attitude=False)
    if plain is None:
        return ()
    fit = FittedTable(doubles(cells), times, columns, plain.states)
    if {*columns} & {0, 1, 2} and (cause := fit.cause(constant_omega(scene))) is not None:
        return (cause[0],)
    explanations = [x for number in other_numbers(scene) if (x := fit.cause(number)) is not None]
    if not explanations:
        return ()
    best = max((evidence.course for _, evidence in explanations), key=lambda x: float(x[0]))
    best_causes = [cause for cause, x in explanations if is_alike(x.course, best)]
    return tuple(sorted(best_causes, key=lambda cause: -cause.digits)[:_TOLD])


class FittedTable:
    """Rows of states that numbers are fitted to."""

    def __init__(
        self, rows: Doubles, times: list[Fraction], columns: list[int], states: Doubles
    ) -> None:
        self.rows, self.times, self.columns = rows, times, columns
        self.scale = np.array([size_of_motion(states[:, :3], c < 3) for c in columns])
        plain = states[:, columns]
        self.plain = self._evidence(Hypothesis(), (plain - rows) / self.scale)
        self.moved = errors_of_rows((plain - plain[0]) / self.scale, 0)

    def _evidence(self, hypothesis: Hypothesis, error: Doubles) -> Evidence:
        """The digits of all rows, of what is left of them; they are fitted as a whole."""
        worst = errors_of_rows(error.reshape(len(self.rows), -1), 0)
        with np.errstate(divide="ignore"):
            digits = np.where(worst > 0, -np.log10(worst), _MOST_DIGITS)
        return Evidence(hypothesis, digits, len(self.rows), self.rows.size)

    def _error(self, hypothesis: Hypothesis, x: float, count: int) -> Doubles | None:
        """The scaled difference from the first rows, in one column; None if too large."""
        try:
            scene, change = hypothesis.of(Fraction(x))
        except ValueError:  # moments of no body
            return None
        motion = integrated(scene, [change.of(t) for t in self.times[:count]], attitude=False)
        if motion is None:
            return None
        with np.errstate(over="ignore", invalid="ignore"):
            off = motion.states[:, self.columns] - self.rows[:count]
            error: Doubles = (off / self.scale).ravel()
            return error if math.isfinite(error @ error) else None

    def cause(self, hypothesis: Hypothesis) -> tuple[Cause, Evidence] | None:
        """The hypothesis with its number fitted, where it explains the table."""
        fit = self._fit(hypothesis)
        if fit is None:
            return None
        x, slope, error = fit
        evidence = self._evidence(hypothesis, error)
        trial = Trial(evidence, self.plain, evidence.follows(self.moved))
        if not trial.is_told or evidence.digits < WRONG:
            return None
        words = hypothesis.words
        if hypothesis.fitted:
            least = _LEAST_IF_EXACT if evidence.digits >= EXACT else LEAST
            value = hypothesis.origin + hypothesis.unit * x
            if abs(x) < least or not slope or value < hypothesis.smallest:
                return None
            size = abs(hypothesis.unit) / max(abs(value), 1e-300)
            sure = 10.0**-evidence.digits / slope * size
            places = max(1, min(15, math.floor(-math.log10(sure)) if sure > 0 else 15))
            words = words.format(f"{value:.{places}g}").replace("+ -", "- ")
        return Cause(words, min(evidence.digits, _MOST_TOLD)), evidence

    def _fit(self, hypothesis: Hypothesis) -> tuple[float, float, Doubles] | None:
        """The number that fits all rows, by ever more of them, the largest change by it, and what
        is left; None where it leads nowhere."""
        x, slope, count = 0.0, 0.0, _FIRST if hypothesis.fitted else len(self.times)
        while (error := self._error(hypothesis, x, count)) is not None:
            if hypothesis.fitted:
                leads = _LEADS if count < len(self.times) else 0.0
                fit = self._fit_of_first(hypothesis, x, error, leads, count)
                if fit is None or float(np.max(np.abs(fit[2]))) > 10.0**-WRONG:
                    return None  # the first rows any number makes right
                x, slope, error = fit
            if count >= len(self.times):
                return x, slope, error
            count *= 2
        return None

    def _fit_of_first(
        self, hypothesis: Hypothesis, x: float, error: Doubles, leads: float, count: int
    ) -> tuple[float, float, Doubles] | None:
        """The number for the first rows, from one near it on, where a share ``leads`` of the
        square of the error is along its change; that, and what is left.

        The change by the number is that over the last step, as long as that is no small one.
        """
        changed = self._error(hypothesis, x + _SMALL, count)
        if changed is None:
            return None
        slope = (changed - error) / _SMALL
        for _ in range(_STEPS):
            along, square = float(slope @ error), float(slope @ slope)
            if not square > 0:
                return None
            if along * along < leads * square * float(error @ error):
                break
            step = -along / square
            for _ in range(_HALVINGS):
                nearer = self._error(hypothesis, x + step, count)
                if nearer is not None and nearer @ nearer < error @ error:
                    break
                step /= 2
            else:
                break
            if abs(step) > _SMALL:
                slope = (nearer - error) / step
            x, error = x + step, nearer
        return x, float(np.max(np.abs(slope))), error


# --- readings -------------------------------------------------------------------------------------


def read_as_told(subject: TrajectoryTable, reference: Reference, readings: str) -> TrajectoryTable:
    """A table as it is read in readings separated by semicolons, in the words that tell them.

    Raises BadInput for one that is none of the table's.
    """
    if LENGTH in readings:
        subject = with_unit_quaternions(subject, view(subject, reference))
    phrases = [" ".join(text.split()) for text in readings.split(";") if text.strip()] or [readings]
    of_parts: list[str] = []
    for phrase in phrases:
        words = phrase.removeprefix("t ")
        change = None if words == phrase else other_times(subject.times).get(words)
        if change is not None:
            subject, _ = at_times_told(subject, view(subject, reference), reference, words, change)
        elif phrase != f"attitude {LENGTH}":  # applied before
            of_parts.append(phrase)
    return subject.read_as(_readings(subject, reference, of_parts)) if of_parts else subject


def at_times_told(
    subject: TrajectoryTable, current: View, reference: Reference, words: str, change: TimeChange
) -> tuple[TrajectoryTable, View]:
    """A table at changed times, with the reading that says so, and how it is seen there.

    ``current``: the table before.
    """
    moved = subject.at_other_times(change)
    there = view(moved, reference)
    before = min((part.rival.digits for part in current.parts.values()), default=None)
    ways = [part.convention for part in there.parts.values()]
    reading = Reading("t", before, words, None)
    if ways:
        reading = _reading("t", before, min(ways, key=lambda x: x.digits), there.times)
        reading = reading._replace(convention=words, change=None)
    return replace(moved, readings=(*moved.readings, reading)), there


def table_as_told(table: TrajectoryTable, reference: Reference, words: str) -> TrajectoryTable:
    """A table whose state, angles and attitude are read so; raises BadInput likewise."""
    reread = read_as_told(as_judged(table, reference.scene), reference, words)
    return replace(table, times=reread.times, columns={**table.columns, **reread.columns})


def _readings(
    subject: TrajectoryTable, reference: Reference, phrases: Sequence[str]
) -> list[Reading]:
    """Readings of parts, in the words that tell them."""
    sample = view(subject, reference)
    if sample.right is None and sample.parts:
        raise BadInput(subject.name, "read", phrases[0], "numbers that can be followed in double")
    by_phrase: dict[str, tuple[str, Evidence]] = {}
    for part, values in sample.values.items():
        for evidence in conventions(part, values, sample.right) if sample.right else ():
            if words := evidence.hypothesis.words:
                by_phrase.setdefault(f"{part} {words}", (part, evidence))
    readings: dict[str, Reading] = {}
    for phrase in phrases:
        if phrase not in by_phrase:
            raise BadInput(subject.name, "read", phrase, _possible(phrase, by_phrase, subject))
        part, evidence = by_phrase[phrase]
        reading = _reading(part, sample.parts[part].rival.digits, evidence, sample.times)
        if reading.change is None or part in readings:
            expected = f"no second reading of {part}" if reading.change else _APPLIED
            raise BadInput(subject.name, "read", phrase, expected)
        readings[part] = reading
    return [*readings.values()]


def _possible(
    phrase: str, by_phrase: Mapping[str, tuple[str, Evidence]], subject: TrajectoryTable
) -> str:
    """Readings that a table may have, of those that rename axes only the nearest ones."""
    applied = [words for words, (_, x) in by_phrase.items() if x.hypothesis.change]
    near = get_close_matches(phrase, applied)
    plain = [words for words in applied if "=" not in words and words not in near]
    times = [f"t {words}" for words in other_times(subject.times)]
    return f"readings that this table can have: {listed(phrase, [*near, *plain, *times])}"


def as_meant(
    subject: TrajectoryTable, against: Reference
) -> tuple[TrajectoryTable, tuple[Reading, ...]]:
    """A table in the conventions in which its wrong parts begin right, where some do; and the
    readings that are told and not applied."""
    current = view(subject, against)
    if all(part.rival.digits >= WRONG for part in current.parts.values()):
        return with_unit_quaternions(subject, current), ()
    if (explanation := other_motion(current, subject, against.scene)) is not None:
        hypothesis, parts = explanation
        _, change = hypothesis.of(Fraction(0))
        if change == AS_THEY_STAND:
            offers = tuple(current.readings_in(hypothesis, parts))
            return with_unit_quaternions(subject, current), offers
        subject, current = at_times_told(subject, current, against, hypothesis.words, change)
    elif not current.is_explained:
        remarks = (*subject.remarks, *clock_remark(subject, against.scene))
        subject = replace(subject, remarks=remarks)
    subject, readings = with_unit_quaternions(subject, current), current.readings()
    applied = [reading for reading in readings if reading.change is not None]
    return subject.read_as(applied), tuple(x for x in readings if x.change is None)


def with_unit_quaternions(subject: TrajectoryTable, current: View) -> TrajectoryTable:
    """A table whose quaternions are of length 1, if they have another one."""
    attitude = subject.rows(ATTITUDE)
    sizes = None if attitude is None else lengths(attitude)
    if attitude is None or sizes is None:
        return subject
    unit = [of_length_one(row, subject.number.bits) for row in attitude]
    before = max(0.0, -math.log10(max(abs(x - 1) for x in sizes)))
    now = current.parts["attitude"].rival.digits if "attitude" in current.parts else 0.0
    reading = Reading("attitude", before, LENGTH, now)
    subject = subject.with_rows(ATTITUDE, unit)
    return replace(subject, readings=(*subject.readings, reading))

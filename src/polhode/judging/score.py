"""A subject held against a reference: how many of its digits are right, of each part."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import NamedTuple, TypeAlias, TypeVar

import numpy as np

from polhode.common.errors import BadInput, few
from polhode.common.interrupts import Progress
from polhode.common.values import ByValue, cached_property
from polhode.equations import kinematics
from polhode.equations.kinematics import principal_angles
from polhode.judging.correct_digits import (
    digits_of,
    largest,
    log10_differences,
    log10_rate,
    plain_rows,
    scaled,
)
from polhode.judging.reference import NoAnswer, Reference, reference
from polhode.judging.tables.hypotheses import integrated
from polhode.judging.tables.table import PARTS, WRONG, TrajectoryTable
from polhode.numbers import double_double
from polhode.numbers.conversion import doubles, to_mpf
from polhode.numbers.double_double import Pairs
from polhode.numbers.number_types import DOUBLE, EXTENDED, Doubles, Given, Scalar
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import ANGLES, ATTITUDE

# --- part digits ----------------------------------------------------------------------------------
#
# Correct digits of one part of a table, row by row.


T = TypeVar("T")

#: Digits at each time, None where no cell of the part is there or could be judged.
RowDigits: TypeAlias = tuple[float | None, ...]

SHOWN = 11  # times that are printed, and judged in any case


def fewest(digits: Iterable[float | None], otherwise: T) -> float | T:
    """The fewest of the digits that were judged; ``otherwise`` where none was."""
    return min((d for d in digits if d is not None), default=otherwise)


def row_digits(differences: Doubles, most: float) -> RowDigits:
    """The fewest digits of each row, of log10 of its numbers' differences; None where none is."""
    digits = digits_of(largest(differences), most)
    return tuple(None if math.isnan(x) else x for x in digits.tolist())


def angles_of_attitudes(
    attitudes: Given, bits: int, beyond: bool = False
) -> list[list[Scalar | None]]:
    """psi, theta and phi of quaternions, psi and phi up to whole turns and None at a pole.

    ``beyond``: the other names of the same rotations, theta of the other sign, psi and phi half a
    turn further, as an integrator of angles has them once theta has passed a pole.
    """
    from polhode.numbers.mpmath_context import mpmath, own

    angles: list[list[Scalar | None]] = []
    with mpmath.workprec(bits):
        for row in attitudes:
            quaternion = [own(x) for x in row]
            psi, theta, phi = kinematics.principal_angles(quaternion, mpmath.atan2, mpmath.hypot)
            is_pole = mpmath.sin(theta) < mpmath.ldexp(2, -bits // 2)
            if beyond:
                psi, theta, phi = psi + mpmath.pi, -theta, phi + mpmath.pi
            angles.append([None, theta, None] if is_pole else [psi, theta, phi])
    return angles


def _passes_poles(angles: Given | Pairs) -> bool:
    """Whether a theta is beyond 0 and pi, or next to them in doubles, which do not tell."""
    thetas = doubles([[row[1]] for row in plain_rows(angles)])
    with np.errstate(invalid="ignore"):
        return bool(np.any(np.sin(thetas) < np.spacing(np.abs(thetas))))


# --- row selection --------------------------------------------------------------------------------
#
# The rows of a table that are judged: all, or some of very many whose reference is dear.
#
# A row of such a closed form takes up to milliseconds. Of more than :data:`MOST_DEAR` rows so
# many are judged, evenly spread, the first and the last among them; and the one that is farthest
# from a run in extended precision, which takes microseconds a row.


MOST_DEAR = 5000  # rows of a dear closed form that are asked for


class RowSelection(NamedTuple):
    """Rows of a table, in order; whether the one farthest from a run could be told."""

    rows: tuple[int, ...]
    has_farthest: bool

    def note(self, count: int) -> str:
        """What of ``count`` rows was not judged, and why."""
        chosen = f"{len(self.rows)} evenly spread ones"
        if self.has_farthest:
            chosen += ", with the one that is farthest from a run in extended precision"
        left = count - len(self.rows)
        return f"{left} of {count} rows, for their closed form is dear; judged were {chosen}"


def selection(subject: TrajectoryTable, reference: Reference) -> RowSelection | None:
    """The rows that are judged; None for all of them."""
    count = len(subject.times)
    if count <= MOST_DEAR or not reference.is_dear:
        return None
    rows = {*few(count, MOST_DEAR), *few(count, SHOWN)}
    far = _farthest(subject, reference.scene)
    return RowSelection(tuple(sorted({*rows, *far})), bool(far))


def _farthest(subject: TrajectoryTable, scene: Scene) -> tuple[int, ...]:
    """The row whose numbers are farthest from a run; none where there is no run.

    Of a quaternion up to its sign, of angles up to whole turns and by either names of a rotation.
    """
    states, attitude, angles = map(subject.rows, (scene.columns, ATTITUDE, ANGLES))
    run = integrated(scene, subject.times, bool(attitude or angles), EXTENDED)
    if run is None:
        return ()
    away = [np.zeros(len(subject.times))]
    if states is not None:
        scale = np.ones(len(scene.columns))
        scale[:3] = np.max(np.linalg.norm(run.states[:, :3], axis=1)) or 1.0
        away.append(_largest((doubles(states) - run.states) / scale))
    if run.attitude is not None and attitude is not None:
        own = doubles(attitude)
        away.append(np.fmin(*(_largest(side * own - run.attitude) for side in (1, -1))))
    if run.attitude is not None and angles is not None:
        true = np.stack(principal_angles(run.attitude.T, np.arctan2, np.hypot), axis=1)
        names = true, true * [1, -1, 1] + [np.pi, 0, np.pi]
        off = [np.exp(1j * (doubles(angles) - x)) for x in names]
        away.append(np.fmin(*(_largest(np.angle(x)) for x in off)))
    return (int(np.argmax(np.fmax.reduce(away))),)


def _largest(differences: Doubles) -> Doubles:
    """The largest of each row of those that are there; 0 where none is."""
    most: Doubles = np.fmax.reduce(np.abs(differences), axis=1, initial=0.0)
    return most


# --- score ----------------------------------------------------------------------------------------


FIRST_ASKED = 100  # digits of a reference, before it is known that more of them are needed
SPARE_DIGITS = 6  # of a reference beyond those that can be told
_DIGITS = 15  # of the angles that are asked for where a table has none
NEAR_POLE = 20  # of its attitude, which psi and phi lose near a pole

STATE_PART = "state"  # omega and gamma together


def bits_of(table: TrajectoryTable) -> int:
    """The working precision in which a table is compared."""
    return math.ceil((math.ceil(table.held) + SPARE_DIGITS) * math.log2(10)) + 32


#: Rows of a reference, one a time: each number the sum of two doubles where these hold the digits,
#: else a number of so many, or None where the motion has none.
Answer: TypeAlias = "Pairs | Given"

_PIECE = 500  # rows asked for at once: how far it is is told between two pieces


@dataclass(frozen=True, eq=False)
class Comparison:
    """A table beside a reference, which is asked each question once.

    What was asked for more digits answers for fewer: runs of one scene in several number types are
    judged by the rows that the widest of them needs.

    ``subject``: the table.  ``selected``: the rows that are judged, None for all of them;
    ``judged``: the table of these.  ``progress``: told of the reference's rows.  ``answers``: its
    answers, or why there is none, by the question and the digits asked for.  ``agreements``: the
    accuracy in digits of the last answer to each question.
    """

    subject: TrajectoryTable
    reference: Reference
    judged: TrajectoryTable
    selected: RowSelection | None = None
    progress: Progress | None = None
    answers: dict[tuple[str, int], Answer | ValueError] = field(default_factory=dict)
    agreements: dict[str, float] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        subject: TrajectoryTable,
        reference: Reference,
        progress: Progress | None = None,
        earlier: Comparison | None = None,
    ) -> Comparison:
        """A comparison, by answers of an earlier one where it asked the same."""
        selected = selection(subject, reference)
        judged = subject if selected is None else subject.some(selected.rows)
        comparison = cls(subject, reference, judged, selected, progress)
        if earlier and earlier.reference is reference and earlier.judged.times == judged.times:
            return replace(comparison, answers=earlier.answers, agreements=earlier.agreements)
        return comparison

    @property
    def digits_wanted(self) -> int:
        """The digits of the reference that tell all of the table's."""
        return math.ceil(self.subject.held) + SPARE_DIGITS

    def rows(self, question: str, digits: int) -> Answer:
        """The reference's rows of the state ("at") or the attitude, to so many digits or more.

        One that was refused may not be for fewer digits.  Raises ValueError.
        """
        answers = self.answers
        earlier = ((n, x) for (name, n), x in answers.items() if name == question and n >= digits)
        enough = [n for n, x in earlier if n == digits or not isinstance(x, ValueError)]
        digits = min(enough, default=digits)
        if not enough:
            # a closed form in balls finds states with attitudes, so both are asked for together
            is_enclosed = self.reference.encloses_attitude
            turns = not is_enclosed and {*ATTITUDE, *ANGLES} & self.subject.columns.keys()
            questions = ("attitude", "at") if turns else (question,)
            is_proof = not self.reference.is_closed_form or (is_enclosed and question != "at")
            answers_now = self._together(questions, digits, is_proof)
            answers |= {(name, digits): answer for name, answer in answers_now.items()}
        answer = answers[question, digits]
        if isinstance(answer, ValueError):
            raise answer
        return answer

    @property
    def agreement(self) -> float:
        """The accuracy in digits of these answers: of the states, else of the attitude."""
        whole = math.inf if self.reference.is_closed_form else math.nan
        return self.agreements.get("at", self.agreements.get("attitude", whole))

    def _together(
        self, questions: Sequence[str], digits: int, is_proof: bool
    ) -> dict[str, Answer | ValueError]:
        """Answers to questions that are asked together, or why not.

        Many rows in pieces, but for a proof, which goes through all times.
        """
        pieces: dict[str, list[Answer]] = {name: [] for name in questions}
        faults: dict[str, ValueError] = {}
        times, count = self.judged.times, len(self.judged.times)
        size = count if is_proof else _PIECE
        in_pairs = digits <= double_double.DIGITS and not is_proof
        for begin in range(0, count, size):
            piece = times[begin : begin + size]
            for name in questions:
                try:
                    if name not in faults:
                        pairs = self.reference.pairs(name, piece, digits) if in_pairs else None
                        ask = getattr(self.reference, name)
                        pieces[name].append(ask(piece, digits) if pairs is None else pairs)
                        self.agreements[name] = self.reference.agreement
                except ValueError as fault:  # BadInput is one
                    faults[name] = fault
            if self.progress is not None and size < count:
                self.progress((begin + len(piece)) / count, begin + len(piece))
        return {name: faults.get(name) or _joined(pieces[name]) for name in questions}

    def by_enough(
        self, question: str, judged: Callable[[Answer], T], right: Callable[[T], float], more: int
    ) -> T:
        """What is judged by the reference, asked for more digits until none hide behind its own.

        So a table of a thousand digits, few of them right, costs no reference of a thousand.
        ``right``: how many are right by it.  ``more``: digits that are asked for in any case.
        Raises ValueError.
        """
        requested = min(self.digits_wanted, FIRST_ASKED)
        while True:
            value = judged(self.rows(question, requested + more))
            if requested == self.digits_wanted or right(value) < requested - SPARE_DIGITS:
                return value
            requested = min(self.digits_wanted, 4 * requested)

    def first_answer(self, question: str) -> Answer:
        """The reference's rows to the digits that were asked for at first."""
        return self.rows(question, min(self.digits_wanted, FIRST_ASKED))

    def residuals(
        self, question: str, names: Sequence[str], difference: Callable[[Answer, Answer], Doubles]
    ) -> Doubles:
        """What is left of columns beside the reference at all times; raises ValueError."""
        true = self.first_answer(question)
        own = self.judged.numbers(names, in_pairs=isinstance(true, Pairs))
        rows = difference(own, true)
        if self.selected is None:
            return rows
        everywhere = np.full((len(self.subject.times), rows.shape[1]), math.nan)
        everywhere[list(self.selected.rows)] = rows
        return everywhere

    def part(self, name: str) -> RowDigits:
        """Digits of angles or of the attitude in the rows that are judged; raises ValueError.

        Angles against attitudes: up to whole turns, and where theta passes a pole and goes on by
        the other names of the same rotation.  A quaternion and its opposite are one attitude.
        """
        most, bits = self.subject.held, bits_of(self.subject)

        def judged(true: Answer) -> RowDigits:
            own = self.judged.numbers(PARTS[name], in_pairs=isinstance(true, Pairs))
            if name == "angles":
                attitudes = plain_rows(true)
                angles = angles_of_attitudes(attitudes, bits)
                turning = range(len(ANGLES))
                errors = largest(log10_differences(own, angles, turning=turning, bits=bits))
                if _passes_poles(own):
                    angles = angles_of_attitudes(attitudes, bits, beyond=True)
                    others = log10_differences(own, angles, turning=turning, bits=bits)
                    errors = np.fmin(errors, others.max(axis=1))  # nan where an angle is missing
                return row_digits(errors[:, None], most)
            sides = (largest(log10_differences(own, true, side=side)) for side in (1, -1))
            return row_digits(np.fmin(*sides)[:, None], most)

        more = NEAR_POLE if name == "angles" else 0
        return self.by_enough("attitude", judged, lambda row: fewest(row, most), more)

    def state_errors(self) -> Doubles:
        """log10 of the scaled errors of the state's numbers, shape (rows, columns)."""
        scene, times = self.reference.scene, self.judged.times
        begins = [k for k, t in enumerate(times) if not t]
        start = [to_mpf(x, bits_of(self.subject)) for x in scene.start]

        def errors(true: Answer) -> Doubles:
            in_pairs = isinstance(true, Pairs)
            rows: Answer = true
            if not in_pairs:  # of more digits than are asked for at first
                rows = [row if t else start for t, row in zip(times, plain_rows(true), strict=True)]
            states = self.judged.numbers(scene.columns, in_pairs=in_pairs)
            return scaled(log10_differences(states, rows), log10_rate(rows, scene))

        def most_right(logs: Doubles) -> float:
            later = row_digits(np.delete(logs, begins, axis=0), self.subject.held)
            return max((d for d in later if d is not None), default=0.0)

        return self.by_enough("at", errors, most_right, 0)

    def missing(self) -> dict[str, tuple[int, ...]]:
        """The rows in which a column lacks a number that the motion has there, of each that does.

        An angle may be missing where the motion has none: psi and phi at a pole.
        """
        gaps = {name: self.subject.gaps([name]) for name in self.subject.columns}
        if rows := self.subject.gaps(ANGLES):
            with suppress(ValueError):  # what the motion has there is not known
                times = [self.subject.times[k] for k in rows]
                attitude = self.reference.attitude(times, _DIGITS)
                true = dict(zip(rows, angles_of_attitudes(attitude, DOUBLE.bits), strict=True))
                for place, name in enumerate(ANGLES):
                    here = gaps.get(name, [])
                    gaps[name] = [k for k in here if true[k][place] is not None]
        return {name: tuple(rows) for name, rows in gaps.items() if rows}


def _joined(pieces: Sequence[Answer]) -> Answer:
    """The rows of all pieces."""
    parts = [x for x in pieces if isinstance(x, Pairs)]
    if parts and len(parts) == len(pieces):
        return double_double.joined(parts)
    return [row for x in pieces for row in plain_rows(x)]


def _fewest_of_rows(parts: Mapping[str, RowDigits]) -> RowDigits:
    return tuple(fewest(row, None) for row in zip(*parts.values(), strict=True))


class _Worst(NamedTuple):
    """The fewest digits, the part that has them, and its first such row."""

    digits: float
    part: str
    row: int


@dataclass(frozen=True, eq=False, repr=False)
class Score(ByValue):
    """The right digits of a table, part by part.

    ``subject``: what was judged; ``reference``: what it was judged against.  ``halves``: the digits
    of omega and gamma at each time; ``other_parts``: those of angles and attitude.
    ``refusals``: parts that were not judged, and why.  ``missing``: the rows in which a column
    lacks a number that the motion has there, of each that does; ``gaps``: those of a part, for a
    vector that lacks a component is none, and has no digits.  ``selected``: the rows that were
    judged, None for all of them.  ``agreement``: the accuracy of the reference in digits; inf for a
    closed form, nan if it is not known.  ``comparison``: of which all of this was made, as long as
    it is there.
    """

    subject: TrajectoryTable
    reference: Reference
    halves: Mapping[str, RowDigits]
    other_parts: Mapping[str, RowDigits]
    refusals: Mapping[str, str]
    missing: Mapping[str, tuple[int, ...]]
    gaps: Mapping[str, tuple[int, ...]]
    selected: RowSelection | None
    agreement: float
    comparison: Comparison | None = field(compare=False)

    def __getstate__(self) -> dict[str, object]:
        """Without the reference's rows, which nobody asks for elsewhere."""
        return super().__getstate__() | {"comparison": None}

    @property
    def times(self) -> tuple[Fraction, ...]:
        """The times judged."""
        return self.subject.times

    @cached_property
    def digits(self) -> RowDigits:
        """Correct digits of the state at each time; empty where no number of it is there."""
        digits = _fewest_of_rows(self.halves)
        return () if all(d is None for d in digits) else digits

    @property
    def part_digits(self) -> dict[str, RowDigits]:
        """Correct digits of each part at each time, None where it has no value there.

        omega, gamma; angles and attitude, by absolute error.
        """
        return {**self.halves, **self.other_parts}

    @property
    def fewest_digits(self) -> RowDigits:
        """The fewest correct digits of any part at each time."""
        return _fewest_of_rows(self.part_digits)

    @property
    def parts(self) -> dict[str, float]:
        """The fewest correct digits over all times of angles and attitude."""
        most = self.subject.held
        return {name: fewest(digits, most) for name, digits in self.other_parts.items()}

    @property
    def rows_judged(self) -> int:
        """How many rows were judged: all, or some of very many where a row of the closed form costs
        milliseconds."""
        return len(self.times) if self.selected is None else len(self.selected.rows)

    @property
    def state_worst(self) -> float:
        """The fewest correct digits of the state; ValueError where it was not judged."""
        return min(d for d in self.digits if d is not None)

    @property
    def lowest_row(self) -> int:
        """The first row at which the digits of the state are fewest."""
        return self.digits.index(self.state_worst)

    @property
    def worst_row(self) -> int:
        """The first row at which the digits are fewest; BadInput where none were judged."""
        return self._worst.row

    @property
    def worst(self) -> float:
        """The fewest correct digits of any part that was judged; BadInput where none was."""
        return self._worst.digits

    @property
    def worst_time(self) -> Fraction:
        """The first time at which the digits are fewest; BadInput where none were judged."""
        return self.times[self._worst.row]

    @property
    def worst_part(self) -> str:
        """The part that has the fewest: "state", or one of ``part_digits``; BadInput likewise."""
        return self._worst.part

    @property
    def has_digits(self) -> bool:
        """Whether any number was judged."""
        return any(d is not None for row in self.part_digits.values() for d in row)

    @cached_property
    def _worst(self) -> _Worst:
        if not self.has_digits:
            why = "; ".join(self.unjudged) or "all cells are empty"
            expected = f"a number in a column that can be judged ({why})"
            raise BadInput(self.subject.name, "columns", None, expected)
        parts = {STATE_PART: self.digits, **self.other_parts}
        numbers = (
            _Worst(d, part, k)
            for part, digits in parts.items()
            for k, d in enumerate(digits)
            if d is not None
        )
        return min(numbers, key=lambda number: number.digits)

    @property
    def is_wrong(self) -> bool:
        """Whether a part, or the state, is right to fewer digits than a convention costs."""
        worst = [*self.parts.values(), *([self.state_worst] if self.digits else [])]
        return min(worst, default=WRONG) < WRONG

    @property
    def reading(self) -> str | None:
        """The convention that was applied, None where the numbers are judged as they stand."""
        words = dict.fromkeys(f"{r.part} {r.convention}" for r in self.subject.readings)
        return "; ".join(words) or None

    @property
    def unjudged(self) -> list[str]:
        """Rows, and parts beside the state, that were not judged, and why."""
        rows = [] if self.selected is None else [self.selected.note(len(self.times))]
        return rows + [
            f"{name} {'were' if name == 'angles' else 'was'} not judged: {why}"
            for name, why in self.refusals.items()
        ]


def score(
    subject: TrajectoryTable,
    reference: Reference,
    progress: Progress | None = None,
    earlier: Score | None = None,
) -> Score:
    """How many digits of a table are right.

    The reference is asked for no more digits than tell them.  ``progress``: called with its rows
    where they are many.  ``earlier``: a score by the same reference at the same times, to spare the
    rows that it asked for.  Raises BadInput where the state cannot be judged, which is
    :class:`NoAnswer` where another reference may have an answer.
    """
    comparison_before = None if earlier is None else earlier.comparison
    comparison = Comparison.of(subject, reference, progress, comparison_before)
    errors = comparison.state_errors() if subject.state else None
    missing = comparison.missing()
    selected, everywhere = comparison.selected, range(len(subject.times))
    gaps = {
        part: rows
        for part, names in PARTS.items()
        if (rows := tuple(sorted({k for name in names for k in missing.get(name, ())})))
    }

    def at_rows(part: str, digits: RowDigits) -> RowDigits:
        """Digits at all rows, None in those that are not judged, and that lack a number of it."""
        lacking = {*gaps.get(part, ())}
        if selected is None and not lacking:
            return digits
        by_row = dict(zip(everywhere if selected is None else selected.rows, digits, strict=True))
        return tuple(None if k in lacking else by_row.get(k) for k in everywhere)

    halves: dict[str, RowDigits] = {}
    for name, half in (("omega", slice(0, 3)), ("gamma", slice(3, 6))):
        if errors is not None and {*PARTS[name]} & {*subject.state}:
            halves[name] = at_rows(name, row_digits(errors[:, half], subject.held))
    others: dict[str, RowDigits] = {}
    refusals: dict[str, str] = {}
    for name in ("angles", "attitude"):
        own = comparison.judged.rows(PARTS[name])
        if own is None:
            continue
        if all(x is None for row in own for x in row):
            refusals[name] = f"none of {'them' if name == 'angles' else 'it'} has a value"
            continue
        try:
            digits = _part(comparison, name)
        except ValueError as fault:  # BadInput is one
            refusals[name] = str(fault)
        else:
            others[name] = at_rows(name, digits)
    parts = halves, others, refusals, missing, gaps
    return Score(subject, reference, *parts, selected, comparison.agreement, comparison)


def _part(comparison: Comparison, name: str) -> RowDigits:
    """A part's digits, by a proof where the closed form has no answer; raises ValueError."""
    try:
        return comparison.part(name)
    except NoAnswer:
        if comparison.reference.is_closed_form:
            with suppress(ValueError):
                proven = reference(comparison.reference.scene, "certified")
                return replace(comparison, reference=proven, answers={}).part(name)
        raise

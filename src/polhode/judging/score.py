"""Correct digits of one part of a table, row by row: of a quaternion, of angles, of columns."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias, TypeVar

import numpy as np

from polhode.common.errors import BadInput, few
from polhode.common.interrupts import Progress
from polhode.common.values import ByValue, cached_property
from polhode.equations import kinematics
from polhode.equations.integrals import Drift
from polhode.equations.kinematics import principal_angles
from polhode.judging.certified import Certified
from polhode.judging.correct_digits import (
    digits_of,
    largest,
    log10_differences,
    log10_rate,
    log10_sizes,
    plain_rows,
    scaled,
)
from polhode.judging.diagnosis.error_budget import integrated
from polhode.judging.reference import AnyReference, Reference, column_of
from polhode.judging.report_text import SHOWN
from polhode.judging.residuals import FEWEST, Residual, are_white, differences, residuals, rotations
from polhode.judging.tables.table import PARTS, Table
from polhode.numbers import double_double
from polhode.numbers.conversion import doubles, to_mpf
from polhode.numbers.double_double import Pairs
from polhode.numbers.number_types import DOUBLE, EXTENDED, Doubles, Given, Scalar
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import ANGLES, ATTITUDE, COLUMNS, STATE

#: Digits at each time, None where no cell of the part is there or could be judged.
RowDigits: TypeAlias = tuple[float | None, ...]

TURNING = (ANGLES.index("psi"), ANGLES.index("phi"))  # angles whose whole turns mean nothing


def fewest(digits: RowDigits, held: float) -> float:
    """The fewest of the digits; ``held`` where none was judged."""
    return min((d for d in digits if d is not None), default=held)


def row_digits(differences: Doubles, held: float) -> RowDigits:
    """The fewest digits of each row, of log10 of its numbers' differences; None where none is."""
    digits = digits_of(largest(differences), held)
    return tuple(None if math.isnan(x) else x for x in digits.tolist())


def part_digits(
    name: str,
    own: Given | Pairs,
    true: Given | Pairs,
    held: float,
    bits: int,
) -> RowDigits:
    """A part's rows against the reference's; ``held``: the most digits that can be told.

    Angles against attitudes: psi and phi up to whole turns, with ``bits`` of pi.  A quaternion and
    its opposite are one attitude.
    """
    if name == "angles":
        angles = angles_of_attitudes(plain_rows(true), bits)
        return row_digits(log10_differences(own, angles, turning=TURNING, bits=bits), held)
    scale = 0.0 if COLUMNS[name].how == "integrated" else _log10_largest(true)
    differences = log10_differences(own, true)
    if name == "attitude":
        sides = differences, log10_differences(own, true, side=-1)
        differences = np.fmin(*map(largest, sides))[:, None]
    return row_digits(differences - scale, held)


def angles_of_attitudes(attitudes: Given, bits: int) -> list[list[Scalar | None]]:
    """psi, theta and phi of quaternions, psi and phi up to whole turns and None at a pole."""
    from polhode.numbers.mpmath_context import mpmath, own

    found: list[list[Scalar | None]] = []
    with mpmath.workprec(bits):
        for row in attitudes:
            quaternion = [own(x) for x in row]
            psi, theta, phi = kinematics.principal_angles(quaternion, mpmath.atan2, mpmath.hypot)
            is_pole = mpmath.sin(theta) < mpmath.ldexp(2, -bits // 2)
            found.append([None, theta, None] if is_pole else [psi, theta, phi])
    return found


def _log10_largest(rows: Given | Pairs) -> float:
    """log10 of the largest size of a derived column's numbers; of 1 where all are 0."""
    most = float(np.nanmax(log10_sizes(rows), initial=-math.inf))
    return most if most > -math.inf else 0.0


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


def selection(subject: Table, reference: AnyReference) -> RowSelection | None:
    """The rows that are judged; None for all of them."""
    count = len(subject.times)
    if count <= MOST_DEAR or not reference.is_dear:
        return None
    rows = {*few(count, MOST_DEAR), *few(count, SHOWN)}
    far = _farthest(subject, reference.scene)
    return RowSelection(tuple(sorted({*rows, *far})), bool(far))


def _farthest(subject: Table, scene: Scene) -> tuple[int, ...]:
    """The row whose numbers are farthest from a run; none where there is no run.

    Of a quaternion up to its sign, of psi and phi up to whole turns.
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
        away.append(_largest(np.angle(np.exp(1j * (doubles(angles) - true)))))
    return (int(np.argmax(np.fmax.reduce(away))),)


def _largest(differences: Doubles) -> Doubles:
    """The largest of each row of those that are there; 0 where none is."""
    found: Doubles = np.fmax.reduce(np.abs(differences), axis=1, initial=0.0)
    return found


# --- answers --------------------------------------------------------------------------------------
#
# A reference's rows at the times that are judged, each question asked once.
#
# What was asked for more digits answers for fewer: runs of one scene in several number types are
# judged by the rows that the widest of them needs.


#: Rows of a reference, one a time: each number the sum of two doubles where these hold the digits,
#: else a number of so many, or None where the motion has none.
Answer: TypeAlias = "Pairs | Given"

_LEAST, _MOST = 1e-250, 1e250  # sizes of w of which two doubles hold all digits
_PIECE = 500  # rows asked for at once: how far it is is told between two pieces


@dataclass(frozen=True, eq=False)
class Answers:
    """What a reference answers at some times.

    ``attitude``: whether the attitude will be asked for too.  A closed form in balls finds states
    with attitudes, so that both are asked for together.  ``progress``: told of the rows.
    """

    reference: AnyReference
    times: Sequence[Fraction]
    attitude: bool
    progress: Progress | None
    _known: dict[tuple[str, int], Answer | ValueError] = field(default_factory=dict)

    def rows(self, word: str, digits: int) -> Answer:
        """Rows of the state ("at") or of an output, to so many digits; raises ValueError."""
        if word == "at" or COLUMNS[word].how == "integrated":
            return self._asked(word, digits)

        def ask(question: str) -> Any:
            return lambda times, more: plain_rows(self._asked(question, digits))

        return column_of(ask, self.reference.scene, word, self.times, digits)

    def _asked(self, question: str, digits: int) -> Answer:
        """The answer to one question, as it was given, to more digits or as many, or now."""
        given = [n for name, n in self._known if name == question and n >= digits]
        enough = (n for n in sorted(given) if n == digits or self._is_answered(question, n))
        digits = next(enough, digits)
        if (question, digits) not in self._known:
            both = self.attitude and not self.reference.encloses_attitude
            group = ("attitude", "at") if both and question in ("attitude", "at") else (question,)
            for name, answer in self._found(group, digits).items():
                self._known[name, digits] = answer
        found = self._known[question, digits]
        if isinstance(found, ValueError):
            raise found
        return found

    def _is_answered(self, question: str, digits: int) -> bool:
        """Whether a question that was asked was not refused: for fewer digits it may not be."""
        return not isinstance(self._known[question, digits], ValueError)

    def _found(
        self, questions: Sequence[str], digits: int, in_pairs: bool | None = None
    ) -> dict[str, Answer | ValueError]:
        """Answers to questions that are asked together, of each or why there is none."""
        pieces: dict[str, list[Answer]] = {name: [] for name in questions}
        faults: dict[str, ValueError] = {}
        # turns are counted from t = 0 on, and a proof goes through all times: not in pieces
        enclosed = "attitude" in questions and self.reference.encloses_attitude
        whole = enclosed or "angles" in questions or not self.reference.is_closed_form
        count = len(self.times)
        size = count if whole else _PIECE
        if in_pairs is None:
            asked_alone = {"at", "attitude"}.issuperset(questions) and not enclosed
            in_pairs = asked_alone and digits <= double_double.DIGITS
        for begin in range(0, count, size):
            piece = self.times[begin : begin + size]
            for name in questions:
                try:
                    if name not in faults:
                        pieces[name].append(self._piece(name, piece, digits, in_pairs))
                except ValueError as fault:  # BadInput is one
                    faults[name] = fault
            done = begin + len(piece)
            if self.progress is not None and size < count:
                self.progress(done / count, done)
        answers = {name: faults.get(name) or _joined(pieces[name]) for name in questions}
        if in_pairs and not all(map(_is_held, answers.values())):
            return self._found(questions, digits, in_pairs=False)
        return answers

    def _piece(
        self, question: str, times: Sequence[Fraction], digits: int, in_pairs: bool
    ) -> Answer:
        """Rows at some of the times."""
        if in_pairs and isinstance(self.reference, Reference):
            return self.reference.pairs(question, times, digits)
        rows: Answer = getattr(self.reference, question)(times, digits)
        return rows


def _joined(pieces: Sequence[Answer]) -> Answer:
    """The rows of all pieces, which are of one kind."""
    parts = [x for x in pieces if isinstance(x, Pairs)]
    return double_double.joined(parts) if parts else [row for x in pieces for row in plain_rows(x)]


def _is_held(answer: Answer | ValueError) -> bool:
    """Whether pairs have all the digits that they may have: of w, whatever its unit of time."""
    if not isinstance(answer, Pairs):
        return True
    return bool(_LEAST < np.max(np.abs(answer.hi[:, :3]), initial=0.0) < _MOST)


# --- score ----------------------------------------------------------------------------------------
#
# A subject held against a reference: how many of its digits are right, of each part.


FIRST_ASKED = 100  # digits of a reference, before it is known that more of them are needed
SPARE_DIGITS = 6  # of a reference beyond those that can be told
_DIGITS = 15  # of the angles that are asked for where a table has none
_NOISY, _RADIAN = 0.1, 57.3  # of a column's size: noise that leaves digits; degrees
ROTATION = ("rotation_x", "rotation_y", "rotation_z")
NEAR_POLE = 20  # of its attitude, which psi and phi lose near a pole

T = TypeVar("T")


STATE_PART = "state"  # omega and gamma together


class _Worst(NamedTuple):
    """The fewest digits, the part that has them, and its first such row."""

    digits: float
    part: str
    row: int


@dataclass(frozen=True, eq=False, repr=False)
class Scores(ByValue):
    """The right digits of a subject, the reference asked for no more digits than tell them.

    ``progress``: called with the reference's rows where they are many.  ``answers``: rows of the
    reference that were asked for already, if they are.
    """

    subject: Table
    reference: AnyReference
    progress: Progress | None = field(default=None, compare=False)
    answers: Answers | None = field(default=None, compare=False)

    def __getstate__(self) -> dict[str, object]:
        """Without what is told of progress: nobody waits for it elsewhere."""
        return super().__getstate__() | {"progress": None, "answers": None}

    @property
    def times(self) -> tuple[Fraction, ...]:
        """The times judged."""
        return self.subject.times

    @cached_property
    def _selected(self) -> RowSelection | None:
        """The rows that are judged; None for all of them."""
        return selection(self.subject, self.reference)

    @cached_property
    def _judged(self) -> Table:
        """The rows that are judged."""
        return self.subject if self._selected is None else self.subject.some(self._selected.rows)

    def _everywhere(self, digits: RowDigits) -> RowDigits:
        """Digits at all rows, None where they are not judged."""
        if self._selected is None:
            return digits
        known = dict(zip(self._selected.rows, digits, strict=True))
        return tuple(known.get(k) for k in range(len(self.subject.times)))

    @cached_property
    def digits(self) -> RowDigits:
        """Correct digits of the state at each time; empty where no number of it is there."""
        if not self.subject.state:
            return ()
        rows = zip(*self._halves.values(), strict=True)
        found = tuple(min((d for d in row if d is not None), default=None) for row in rows)
        return () if all(d is None for d in found) else found

    @cached_property
    def _halves(self) -> dict[str, RowDigits]:
        """Digits of omega and of gamma at each time, of what is there of them."""
        found: dict[str, RowDigits] = {}
        for name, half in (("omega", slice(0, 3)), ("gamma", slice(3, 6))):
            if {*STATE[half]} & {*self.subject.state}:
                digits = row_digits(self._errors[:, half], self.subject.held)
                found[name] = self._of_whole(name, self._everywhere(digits))
        return found

    @cached_property
    def gaps(self) -> dict[str, tuple[int, ...]]:
        """The rows in which a part lacks a number that the motion has there, of each that does.

        A vector that lacks a component is none, and has no digits.
        """
        parts = PARTS | {word: x.names for word, x in COLUMNS.items()}
        rows = {
            part: sorted({k for name in names for k in self.missing.get(name, ())})
            for part, names in parts.items()
        }
        return {part: tuple(lacking) for part, lacking in rows.items() if lacking}

    @cached_property
    def missing(self) -> dict[str, tuple[int, ...]]:
        """The rows in which a column lacks a number that the motion has there, of each that does.

        An angle may be missing where the motion has none: psi and phi at a pole.
        """
        columns = self.subject.columns
        found = {name: self.subject.gaps([name]) for name in columns}
        if rows := self.subject.gaps(ANGLES):
            with suppress(ValueError):  # what the motion has there is not known
                attitude = self.reference.attitude([self.times[k] for k in rows], _DIGITS)
                true = dict(zip(rows, angles_of_attitudes(attitude, DOUBLE.bits), strict=True))
                for place, name in enumerate(ANGLES):
                    here = found.get(name, [])
                    found[name] = [k for k in here if true[k][place] is not None]
        return {name: tuple(lacking) for name, lacking in found.items() if lacking}

    def _of_whole(self, part: str, digits: RowDigits) -> RowDigits:
        """Digits of a part, None in rows that lack a number of it."""
        lacking = {*self.gaps.get(part, ())}
        if not lacking:
            return digits
        return tuple(None if k in lacking else d for k, d in enumerate(digits))

    @cached_property
    def _judged_parts(self) -> dict[str, RowDigits | str]:
        """Digits of angles, attitude and derived columns, or why there are none."""
        found: dict[str, RowDigits | str] = {}
        for name in COLUMNS:
            own = self._judged.rows(COLUMNS[name].names)
            if own is None:
                continue
            if all(x is None for row in own for x in row):
                found[name] = f"none of {'them' if name == 'angles' else 'it'} has a value"
                continue
            try:
                found[name] = self._part(name)
            except ValueError as fault:  # BadInput is one
                found[name] = str(fault)
                if does_not_answer(self.reference, fault):
                    proven = replace(self, reference=Certified(self.reference.scene))
                    with suppress(ValueError):
                        found[name] = proven._part(name)
        return found

    def _part(self, name: str) -> RowDigits:
        """Digits of such a part; raises ValueError."""
        held = self.subject.held
        word, more = ("attitude", NEAR_POLE) if name == "angles" else (name, 0)

        def judged(true: Answer) -> RowDigits:
            own = self._judged.numbers(COLUMNS[name].names, in_pairs=isinstance(true, Pairs))
            return part_digits(name, own, true, held, self._bits)

        found = self._told(word, judged, lambda digits: fewest(digits, held), more)
        return self._of_whole(name, self._everywhere(found))

    @cached_property
    def _errors(self) -> Doubles:
        """log10 of the scaled errors of the state's numbers, shape (rows, columns)."""
        scene, times = self.reference.scene, self._judged.times
        begins = [k for k, t in enumerate(times) if not t]
        start = [to_mpf(x, self._bits) for x in scene.start]

        def errors(true: Answer) -> Doubles:
            in_pairs = isinstance(true, Pairs)
            rows: Answer = true
            if not in_pairs:  # of more digits than are asked for at first
                rows = [row if t else start for t, row in zip(times, plain_rows(true), strict=True)]
            states = self._judged.numbers(scene.columns, in_pairs=in_pairs)
            return scaled(log10_differences(states, rows), log10_rate(rows, scene))

        def most_right(found: Doubles) -> float:
            later = row_digits(np.delete(found, begins, axis=0), self.subject.held)
            return max((d for d in later if d is not None), default=0.0)

        return self._told("at", errors, most_right)

    def _told(
        self, word: str, judged: Callable[[Answer], T], right: Callable[[T], float], more: int = 0
    ) -> T:
        """What is judged by the reference, asked for more digits until none hide behind its own.

        So a table of a thousand digits, few of them right, costs no reference of a thousand.
        ``right``: how many are right by it.  ``more``: digits that are asked for in any case.
        Raises ValueError.
        """
        wanted = min(self._wanted, FIRST_ASKED)
        while True:
            found = judged(self.known_answers.rows(word, wanted + more))
            if wanted == self._wanted or right(found) < wanted - SPARE_DIGITS:
                return found
            wanted = min(self._wanted, 4 * wanted)

    @cached_property
    def known_answers(self) -> Answers:
        """The reference at the times that are judged."""
        known, times = self.answers, self._judged.times
        if known is not None and known.reference is self.reference and known.times == times:
            return known
        there = [word for word, x in COLUMNS.items() if {*x.names} & self.subject.columns.keys()]
        attitude = any({"attitude", "angles"} & {word, *COLUMNS[word].needs} for word in there)
        return Answers(self.reference, times, attitude, self.progress)

    @property
    def _wanted(self) -> int:
        return math.ceil(self.subject.held) + SPARE_DIGITS

    @property
    def _bits(self) -> int:
        """The working precision of what is compared."""
        return math.ceil(self._wanted * math.log2(10)) + 32

    @property
    def rows_judged(self) -> int:
        """How many rows were judged: all, or some of very many where a row of the closed form costs
        milliseconds."""
        selected = self._selected
        return len(self.times) if selected is None else len(selected.rows)

    @property
    def state_worst(self) -> float:
        """The fewest correct digits of the state; ValueError where it was not judged."""
        return min(d for d in self.digits if d is not None)

    @property
    def worst(self) -> float:
        """The fewest correct digits of any part that was judged; BadInput where none was."""
        return self._worst.digits

    @property
    def worst_time(self) -> Fraction:
        """The first time at which the digits are fewest; BadInput likewise."""
        return self.times[self._worst.row]

    @property
    def worst_part(self) -> str:
        """The part that has the fewest: "state", or one of ``part_digits``; BadInput likewise."""
        return self._worst.part

    @cached_property
    def _worst(self) -> _Worst:
        parts = {STATE_PART: self.digits, **self._others}
        found = [
            _Worst(d, part, k)
            for part, digits in parts.items()
            for k, d in enumerate(digits)
            if d is not None
        ]
        if not found:
            why = "; ".join(self._unjudged) or "all cells are empty"
            expected = f"a number in a column that can be judged ({why})"
            raise BadInput(self.subject.name, "columns", None, expected)
        return min(found, key=lambda one: one.digits)

    @cached_property
    def _others(self) -> dict[str, RowDigits]:
        """Digits of what is no column of the state; of angles psi and phi up to whole turns."""
        return {k: part for k, part in self._judged_parts.items() if not isinstance(part, str)}

    @cached_property
    def rotation_errors(self) -> Doubles:
        """Rotations from the true attitudes to the subject's, vectors along body axes in degrees,
        shape (rows, 3); not a number where the attitude was not judged, no rows where nowhere."""
        if "attitude" not in self._others:
            return np.zeros((0, 3))
        try:
            found = self._left("attitude", ATTITUDE, rotations)
        except ValueError:  # a proof judged it, and its digits alone are known
            return np.zeros((0, 3))
        found[[k for k, d in enumerate(self._others["attitude"]) if d is None]] = math.nan
        return found

    def _left(
        self, word: str, names: Sequence[str], difference: Callable[[Answer, Answer], Doubles]
    ) -> Doubles:
        """What is left of columns beside the reference at all times; raises ValueError."""
        true = self.known_answers.rows(word, min(self._wanted, FIRST_ASKED))
        own = self._judged.numbers(names, in_pairs=isinstance(true, Pairs))
        found = difference(own, true)
        if self._selected is None:
            return found
        everywhere = np.full((len(self.times), found.shape[1]), math.nan)
        everywhere[list(self._selected.rows)] = found
        return everywhere

    @cached_property
    def _residual_rows(self) -> tuple[tuple[str, ...], Doubles]:
        """Names of what is left of a table's state and attitude, and its whole rows in time."""
        names: list[str] = []
        parts = []
        if self.digits:
            columns = self.reference.scene.columns
            there = [k for k, name in enumerate(columns) if name in self.subject.state]
            names += [columns[k] for k in there]
            parts.append(self._left("at", columns, differences)[:, there])
        if len(self.rotation_errors):
            names += ROTATION
            parts.append(self.rotation_errors)
        if not parts:
            return (), np.zeros((0, 0))
        order = sorted(range(len(self.times)), key=lambda k: self.times[k])
        rows = np.hstack(parts)[order]
        return tuple(names), rows[np.all(np.isfinite(rows), axis=1)]

    @cached_property
    def residuals(self) -> tuple[Residual, ...]:
        """What is left of each column of the state, and of the attitude as a rotation in degrees:
        root mean square, bias, and the bias's standard error, over rows that are whole."""
        return residuals(*self._residual_rows)

    @cached_property
    def is_noisy(self) -> bool:
        """Whether what is left of a table may be white noise, of a tenth of its size or less."""
        names, rows = self._residual_rows
        if self.subject.run is not None or len(rows) < FEWEST:
            return False
        rate = 1.0
        if self.digits:
            true = self.known_answers.rows("at", min(self._wanted, FIRST_ASKED))
            rate = 10.0 ** log10_rate(true, self.reference.scene)
        sizes = [rate if n in STATE[:3] else _RADIAN if n in ROTATION else 1.0 for n in names]
        level = np.sqrt(np.mean(rows**2, axis=0)) / sizes
        return bool(np.all(level < _NOISY)) and are_white(rows)

    @property
    def reading(self) -> str | None:
        """The convention that was applied, None where the numbers are judged as they stand."""
        told = dict.fromkeys(f"{r.part} {r.convention}" for r in self.subject.readings)
        return "; ".join(told) or None

    @property
    def part_digits(self) -> dict[str, RowDigits]:
        """Correct digits of each part at each time, None where it has no value there.

        omega, gamma; angles and attitude, by absolute error; derived columns, by errors relative
        to their largest value.
        """
        return self._halves | self._others

    @property
    def _lowest(self) -> int:
        """The first row at which the digits of the state are fewest."""
        return self.digits.index(self.state_worst)

    @property
    def parts(self) -> dict[str, float]:
        """The fewest correct digits over all times of angles, attitude and derived columns."""
        return {name: fewest(found, self.subject.held) for name, found in self._others.items()}

    @property
    def _unjudged(self) -> list[str]:
        """Rows, and parts beside the state, that were not judged, and why."""
        selected = self._selected
        unjudged = [] if selected is None else [selected.note(len(self.times))]
        return unjudged + [
            f"{name} {'were' if name == 'angles' else 'was'} not judged: {found}"
            for name, found in self._judged_parts.items()
            if isinstance(found, str)
        ]

    @property
    def drift(self) -> Drift | None:
        """Drift of the integrals; None where it says nothing, see ``notes``."""
        return self._drift if isinstance(self._drift, Drift) else None

    @cached_property
    def _drift(self) -> Drift | str:
        return self.subject.drift(self.reference.scene, self._bits)


def does_not_answer(reference: AnyReference, fault: ValueError) -> bool:
    """Whether it is a closed form that has no answer here, as a proven enclosure may have."""
    refused = isinstance(fault, BadInput) and fault.key == "reference"
    return refused and isinstance(reference, Reference)

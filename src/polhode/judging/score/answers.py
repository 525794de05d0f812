"""A reference's rows at the times that are judged, each question asked once.

What was asked for more digits answers for fewer: runs of one scene in several number types are
judged by the rows that the widest of them needs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np

from polhode.common.interrupts import Progress
from polhode.judging.correct_digits import plain_rows
from polhode.judging.references.derived import column_of
from polhode.judging.references.reference import AnyReference, Reference
from polhode.numbers import double_double
from polhode.numbers.double_double import Pairs
from polhode.numbers.rows import Given
from polhode.scenes.vocabulary import COLUMNS

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

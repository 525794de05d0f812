"""A subject held against a reference: how many of its digits are right, of each part."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TypeVar

from polhode.common.cached_property import cached_property
from polhode.common.errors import BadInput
from polhode.common.progress import Progress
from polhode.judging.correct_digits import log10_differences, log10_rate, scaled
from polhode.judging.references.certified import Certified
from polhode.judging.references.reference import AnyReference, Reference
from polhode.judging.score.answers import Answer, Answers
from polhode.judging.score.part_digits import (
    PartDigits,
    RowDigits,
    fewest,
    part_digits,
    principal_angles,
    row_digits,
)
from polhode.judging.score.row_selection import RowSelection, selection
from polhode.judging.tables.candidate import Subject
from polhode.numbers.conversion import to_mpf
from polhode.numbers.rows import Doubles, Given
from polhode.scenes.vocabulary import COLUMNS, STATE

FIRST_ASKED = 100  # digits of a reference, before it is known that more of them are needed
SPARE_DIGITS = 6  # of a reference beyond those that can be told

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class HeldAgainst:
    """The right digits of a subject, the reference asked for no more digits than tell them.

    ``progress``: told of the reference's rows where they are many.
    """

    subject: Subject
    reference: AnyReference
    progress: Progress | None = None

    @cached_property
    def selected(self) -> RowSelection | None:
        """The rows that are judged; None for all of them."""
        return selection(self.subject, self.reference)

    @cached_property
    def _judged(self) -> Subject:
        """The rows that are judged."""
        return self.subject if self.selected is None else self.subject.some(self.selected.rows)

    def _everywhere(self, digits: RowDigits) -> RowDigits:
        """Digits at all rows, None where they are not judged."""
        if self.selected is None:
            return digits
        known = dict(zip(self.selected.rows, digits, strict=True))
        return tuple(known.get(k) for k in range(len(self.subject.times)))

    @cached_property
    def digits(self) -> RowDigits:
        """Correct digits of the state at each time; empty where no number of it is there."""
        if not self.subject.columns:
            return ()
        found = row_digits(self._errors, self.subject.held)
        return () if all(d is None for d in found) else self._everywhere(found)

    @cached_property
    def halves(self) -> dict[str, RowDigits]:
        """Digits of omega and of gamma at each time, of what is there of them."""
        found: dict[str, RowDigits] = {}
        for name, half in (("omega", slice(0, 3)), ("gamma", slice(3, 6))):
            if {*STATE[half]} & {*self.subject.columns}:
                digits = row_digits(self._errors[:, half], self.subject.held)
                found[name] = self._everywhere(digits)
        return found

    @cached_property
    def parts(self) -> dict[str, PartDigits | str]:
        """Digits of angles, attitude and derived columns, or why there are none."""
        found: dict[str, PartDigits | str] = {}
        for name in COLUMNS:
            own = self._judged.part(name)
            if own is None:
                continue
            if all(x is None for row in own for x in row):
                found[name] = f"none of {'them' if name == 'angles' else 'it'} has a value"
                continue
            try:
                found[name] = self.part(name, own)
            except ValueError as fault:  # BadInput is one
                found[name] = str(fault)
                if does_not_answer(self.reference, fault):
                    if name == "angles":
                        with suppress(ValueError):
                            found[name] = self._up_to_turns(own)
                            continue
                    proven = replace(self, reference=Certified(self.reference.scene))
                    with suppress(ValueError):
                        found[name] = proven.part(name, own)
        return found

    def part(self, name: str, own: Given) -> PartDigits:
        """Digits of such a part; raises ValueError."""
        held, signless = self.subject.held, self.subject.signless

        def judged(true: Answer) -> PartDigits:
            return part_digits(name, own, true, held, self.bits, signless)

        found = self._told(name, judged, lambda part: fewest(part.digits, held))
        turned = None if found.turned is None else self._everywhere(found.turned)
        return PartDigits(self._everywhere(found.digits), turned)

    def _up_to_turns(self, own: Given) -> PartDigits:
        """Digits of angles of which the reference has the attitude alone; raises ValueError."""
        held = self.subject.held

        def judged(true: Answer) -> RowDigits:
            angles = principal_angles(true, self.bits)
            return part_digits("angles", own, angles, held, self.bits).turned or ()

        found = self._told("attitude", judged, lambda digits: fewest(digits, held))
        digits = self._everywhere(found)
        return PartDigits(digits, digits, uncounted=True)

    @cached_property
    def _errors(self) -> Doubles:
        """log10 of the scaled errors of the state's numbers, shape (rows, columns)."""
        start = [to_mpf(x, self.bits) for x in self.reference.scene.start]
        times, states = self._judged.times, self._judged.states

        def errors(true: Answer) -> Doubles:
            rows = [row if t else start for t, row in zip(times, true, strict=True)]
            rate = log10_rate(rows, self.reference.scene)
            return scaled(log10_differences(states, rows), rate)

        def most_right(found: Doubles) -> float:
            later = row_digits(found[[k for k, t in enumerate(times) if t]], self.subject.held)
            return max((d for d in later if d is not None), default=0.0)

        return self._told("at", errors, most_right)

    def _told(self, word: str, judged: Callable[[Answer], T], right: Callable[[T], float]) -> T:
        """What is judged by the reference, asked for more digits until none hide behind its own.

        So a table of a thousand digits, few of them right, costs no reference of a thousand.
        ``right``: how many are right by it.  Raises ValueError.
        """
        wanted = min(self._wanted, FIRST_ASKED)
        while True:
            found = judged(self._answers.rows(word, wanted))
            if wanted == self._wanted or right(found) < wanted - SPARE_DIGITS:
                return found
            wanted = min(self._wanted, 4 * wanted)

    @cached_property
    def _answers(self) -> Answers:
        """The reference at the times that are judged."""
        needs = {need for word in self.subject.derived for need in COLUMNS[word].needs}
        attitude = self.subject.attitude is not None or "attitude" in needs
        return Answers(self.reference, self._judged.times, attitude, self.progress)

    @property
    def _wanted(self) -> int:
        return math.ceil(self.subject.held) + SPARE_DIGITS

    @property
    def bits(self) -> int:
        """The working precision of what is compared."""
        return math.ceil(self._wanted * math.log2(10)) + 32


def does_not_answer(reference: AnyReference, fault: ValueError) -> bool:
    """Whether it is a closed form that has no answer here, as a proven enclosure may have."""
    refused = isinstance(fault, BadInput) and fault.key == "reference"
    return refused and isinstance(reference, Reference)

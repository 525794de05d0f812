"""A subject held against a reference: how many of its digits are right, of each part."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from typing import TypeAlias

import numpy as np

from polhode.common.cached_property import cached_property
from polhode.common.errors import BadInput
from polhode.common.progress import Progress
from polhode.common.text_tables import few
from polhode.judging._dense_reference.parallel_evaluation import Ask, asked_by
from polhode.judging.correct_digits import digits_of, errors, rate_scale
from polhode.judging.references.certified import Certified
from polhode.judging.references.derived import column_of
from polhode.judging.references.reference import Reference, Remembered, rows
from polhode.judging.score.part_digits import (
    PartDigits,
    RowDigits,
    fewest,
    part_digits,
    principal_angles,
)
from polhode.judging.score.vectorized_score import SPARE_DIGITS, ManyRows, digits, many_rows
from polhode.judging.tables.candidate import Subject
from polhode.numbers.conversion import to_mpf
from polhode.numbers.rows import Given
from polhode.numbers.scalars import Scalar
from polhode.scenes.vocabulary import COLUMNS, STATE

_FIRST_ROWS, _MORE = 32, 16  # of rows asked for piece by piece: the first piece, and its growth
FIRST_ASKED = 100  # digits of a reference, before it is known that more of them are needed

AnyReference: TypeAlias = Reference | Certified | Remembered


@dataclass(frozen=True, eq=False)
class HeldAgainst:
    """The right digits of a subject, the reference asked for no more digits than tell them.

    ``workers``: processes that may ask the reference; ``progress``: told of its rows where
    they take long.
    """

    subject: Subject
    reference: AnyReference
    workers: int = 1
    progress: Progress | None = None

    @cached_property
    def digits(self) -> RowDigits:
        """Correct digits of the state at each time; empty where no number of it is there."""
        states = self.subject.states
        if not self.subject.columns or not any(there := _there(states)):
            return ()
        if self.many is not None:
            return _where(there, digits(self.many.errors, self.subject.held))
        return self._digits(states)

    @cached_property
    def many(self) -> ManyRows | None:
        """The rows judged all at once, where that can be."""
        return many_rows(self.subject, self.reference, self.workers, self.progress)

    @property
    def _wanted(self) -> int:
        return math.ceil(self.subject.held) + SPARE_DIGITS

    @property
    def bits(self) -> int:
        """The working precision of what is compared."""
        return math.ceil(self._wanted * math.log2(10)) + 32

    @cached_property
    def rows(self) -> list[list[Scalar]]:
        """The reference's states at the times, to as many digits as tell those that are right."""
        ask, states = self._ask("at"), self.subject.states
        if not self.subject.columns:
            return rows(ask, self.subject.times, self._wanted)
        start = [to_mpf(x, self.bits) for x in self.reference.scene.start]
        there = [
            k
            for k, t in enumerate(self.subject.times)
            if t != 0 and any(x is not None for x in states[k])
        ]

        def most_right(found: list[list[Scalar]]) -> float:
            digits = self._digits(states, found)
            return max((d for k in there if (d := digits[k]) is not None), default=0.0)

        found = self._true(ask, most_right)
        return [row if t else start for t, row in zip(self.subject.times, found, strict=True)]

    def _ask(self, question: str) -> Ask:
        """What the reference answers, by as many processes as there are to be."""
        if isinstance(self.reference, Reference):
            return asked_by(self.reference, question, self.workers, self.progress)
        found: Ask = getattr(self.reference, question)
        return found

    def _true(self, ask: Ask, right: Callable[[list[list[Scalar]]], float]) -> list[list[Scalar]]:
        """A reference's rows, asked for more digits until none that are right hide behind them.

        So a table of a thousand digits, few of them right, costs no reference of a thousand.
        ``right``: how many are right, held against given rows.
        """
        wanted = min(self._wanted, FIRST_ASKED)
        while True:
            found = rows(ask, self.subject.times, wanted)
            if wanted == self._wanted or right(found) < wanted - SPARE_DIGITS:
                return found
            wanted = min(self._wanted, 4 * wanted)

    def _digits(self, states: Given, true: list[list[Scalar]] | None = None) -> RowDigits:
        true = self.rows if true is None else true
        scale = rate_scale(true, self.reference.scene, self.bits)
        found = errors(states, true, scale, self.bits)
        return _where(_there(states), [digits_of(error, self.subject.held) for error in found])

    @cached_property
    def halves(self) -> dict[str, RowDigits]:
        """Digits of omega and of gamma at each time, of what is there of them."""
        found: dict[str, RowDigits] = {}
        columns = self.subject.columns
        for name, half in (("omega", slice(0, 3)), ("gamma", slice(3, 6))):
            if not {*STATE[half]} & {*columns}:
                continue
            states = self.subject.states
            if self.many is not None:
                there = _there(_some_columns(states, half))
                found[name] = _where(there, digits(self.many.halves[name], self.subject.held))
                continue
            own = [
                [x if k in range(*half.indices(6)) else None for k, x in enumerate(row)]
                for row in states
            ]
            found[name] = self._digits(own)
        return found

    @cached_property
    def parts(self) -> dict[str, PartDigits | str]:
        """Digits of angles, attitude and derived columns, or why there are none."""
        found: dict[str, PartDigits | str] = {}
        for name in COLUMNS:
            own = self.subject.part(name)
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
        """Digits of such a part at all rows; raises ValueError."""
        held, bits, signless = self.subject.held, self.bits, self.subject.signless
        many = None if self.many is None else self.many.part(name)
        if many is None or self.many is None:

            def right(true: list[list[Scalar]]) -> float:
                return fewest(part_digits(name, own, true, held, bits, signless).digits, held)

            ask = partial(column_of, self._ask, self.reference.scene, name)
            return part_digits(name, own, self._true(ask, right), held, bits, signless)
        there = _there(own)
        told = PartDigits(_where(there, digits(many, held)))
        if name != "angles" or self.many.turned is None:
            return told
        told = told._replace(turned=_where(there, digits(self.many.turned, held)))
        return self._with_untold(told, own, self.many.untold)

    def _up_to_turns(self, own: Given) -> PartDigits:
        """Digits of angles of which the reference has the attitude alone; raises ValueError."""
        ask = self._ask("attitude")

        def angles(times: Sequence[Fraction], digits: int) -> list[list[Scalar]]:
            return principal_angles(ask(times, digits), self.bits)

        def judged(true: list[list[Scalar]]) -> RowDigits:
            turned = part_digits("angles", own, true, self.subject.held, self.bits).turned
            assert turned is not None
            return turned

        found = judged(self._true(angles, lambda x: fewest(judged(x), self.subject.held)))
        return PartDigits(found, found, uncounted=True)

    def _with_untold(self, told: PartDigits, own: Given, untold: Sequence[int]) -> PartDigits:
        """Angles with the rows that are asked for one by one, None where no digit is left."""
        held, known = self.subject.held, (told.digits, told.turned)
        both = [[*one] for one in known if one is not None]
        left = [fewest(tuple(one), held) for one in both]  # theta of untold rows among them
        for one in both:
            for k in untold:
                one[k] = one[k] and None  # 0 digits of theta are 0 of all
        for some in _spread(untold):
            if max(left) == 0:  # they cannot be fewer
                break
            times = [self.subject.times[k] for k in some]
            true = rows(self._ask("angles"), times, self._wanted)
            found = part_digits("angles", [own[k] for k in some], true, held, self.bits)
            for n, (one, more) in enumerate(zip(both, (found.digits, found.turned), strict=True)):
                assert more is not None
                for k, d in zip(some, more, strict=True):
                    one[k] = d
                left[n] = min(left[n], fewest(more, held))
        first, turned = (tuple(one) for one in both)
        return PartDigits(first, turned)


def does_not_answer(reference: AnyReference, fault: ValueError) -> bool:
    """Whether it is a closed form that has no answer here, as a proven enclosure may have."""
    refused = isinstance(fault, BadInput) and fault.key == "reference"
    return refused and isinstance(reference, Reference)


def _there(own: Given) -> Sequence[bool]:
    """Whether rows have any cell."""
    if isinstance(own, np.ndarray) and own.dtype.kind != "O":  # of numbers: all are there
        return [True] * len(own)
    return [any(x is not None for x in row) for row in own]


def _some_columns(rows: Given, which: slice) -> Given:
    if isinstance(rows, np.ndarray):
        return rows[:, which]
    return [row[which] for row in rows]


def _where(there: Sequence[bool], found: Sequence[float]) -> RowDigits:
    return tuple(d if has else None for has, d in zip(there, found, strict=True))


def _spread(rows: Sequence[int]) -> Iterator[list[int]]:
    """Rows in pieces, each spread over all of them."""
    given: set[int] = set()
    size = _FIRST_ROWS
    while len(given) < len(rows):
        piece = [k for k in few(len(rows), size) if k not in given]
        given |= {*piece}
        size *= _MORE
        yield [rows[k] for k in piece]

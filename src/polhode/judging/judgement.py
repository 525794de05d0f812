"""A judgement: how many digits of a subject are right, what limits them, and how it reads."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from polhode.common.errors import BadInput, aligned, few
from polhode.equations.integrals import Drift
from polhode.judging.conditioning import Band
from polhode.judging.limits import (
    LAST,
    NOISES,
    Departure,
    Expectation,
    Limit,
    chance,
    is_lost,
    lost_digits,
    shown_digits,
)
from polhode.judging.residuals import Residual
from polhode.judging.score import SHOWN, STATE_PART, Score
from polhode.judging.tables.explanations import Cause
from polhode.judging.tables.table import WRONG, Reading
from polhode.numbers.decimals import brief, in_full, shortest
from polhode.numbers.number_types import Doubles, NumberType
from polhode.results.cells import DOUBLE, EXACT, TEXT
from polhode.results.result import Result
from polhode.results.table import Column, Fact, table_of_rows
from polhode.results.table import Table as ResultTable
from polhode.scenes.scene_facts import provenance_fact, scene_facts, unit_of
from polhode.taylor import heyoka

_SHORT = 24  # characters of a time that is printed with all its digits

#: What a limit says of the digits, by its name; ``how``: its words in brackets.
LIMITS = {
    "rounding": "as many as {number} precision allows for this motion",
    "conditioning": "as many as {number} precision allows for this motion",
    "inputs": "as many as the scene's numbers, rounded to {number}, allow",
    "reference": "as many as the reference can tell",
    "method": "fewer than {number} precision allows: {how}",
    "noise": "fewer than {number} precision allows: noise that is {how} at this level",
    "bias": "fewer than {number} precision allows: a {how} bias, with white noise about it",
    "unknown": "{how}",
}
ROUNDED = "as many as rounding {how} leaves"
FOREIGN = "the program's steps, noise, or another motion"
BY_CHANCE = "; or by chance: one run in {runs:.0f} has so few"
EXPLAINED = "another number explains the error"
ELSEWHERE = "another convention gives more digits"
WRONG_AT_ONCE = "wrong in the first digit"
NOTHING = "nothing was judged"
OWN_EQUATIONS = (
    "of a program's own equations polhode.compare_field(f, {scene!r}) names the terms that differ"
)
_ROUGH = 6.0  # digits of an attitude of which an angle says more
RARE = 1e-4  # a share of runs of which nobody judges so many


@dataclass(frozen=True, eq=False, repr=False)
class Judgement(Result, Score):
    """Correct digits of a run or a table at each of its times, and what limits them.

    ``subject``: what was judged.  ``reference``: what it was judged against.
    ``digits[k]`` belongs to ``times[k]``: -log10 of the larger of the error of omega over the
    largest |omega| of the reference at these times, and the error of gamma, in the scene's body
    axes.  ``worst``: the fewest of these and of those of every other part that was judged.
    ``limit``: what limits the digits of the state; empty where it was not judged, and of a table
    that is wrong in the first digit or would be right in a convention that is not applied, for then
    its method is not to blame; ``attitude_limit``: what limits those of the attitude.
    ``expectation``: the digits to expect, None where no limit needs them and they were not asked
    for.  ``departures``: parts that leave the motion: right until one time, wrong from the next one
    on.  ``offers``: conventions in which parts still wrong would be right, not applied; ``causes``:
    numbers of which one, if it were another, would make a wrong table right, the best first, fitted
    and changed nowhere; ``start``: that a wrong table begins with another state, in words.
    ``residuals``: what is left of each column of a table's state, and of its attitude as a rotation
    in degrees, where that is noise or was asked for.  ``rotation_errors``: rotations from the true
    attitudes to the subject's, vectors along body axes in degrees, shape (rows, 3).
    ``integrals``: their drift, or why it says nothing.  ``motion``: whether the scene's motion is
    chaotic, where that was asked for.

    Printed, it is the answer of ``polhode compare``; :meth:`details` has all that is known.

    >>> import polhode
    >>> judgement = polhode.compare(polhode.integrate("euler/separatrix", at=[1, 20]))
    >>> 12.5 < judgement.worst < 14.5, judgement.worst_time, judgement.limit
    (True, Fraction(20, 1), 'conditioning')
    """

    limit: Limit
    attitude_limit: Limit
    expectation: Expectation | None
    departures: Mapping[str, Departure]
    offers: tuple[Reading, ...]
    causes: tuple[Cause, ...]
    start: str
    residuals: tuple[Residual, ...]
    rotation_errors: Doubles
    integrals: Drift | str
    motion: Result | None = None

    @property
    def expected(self) -> tuple[Band | None, ...]:
        """The digits of runs that round once a step of the subject's type; None where unknown.

        Followed at some hundred times; of more times, linear between those.

        Of a projected run those that projection leaves; see :func:`polhode.conditioning`.
        """
        if self.expectation is None:
            return (None,) * len(self.digits)
        return self.expectation.bands if self.digits else ()

    @property
    def inputs(self) -> tuple[float | None, ...]:
        """The digits that rounding the scene's numbers to the subject's type leaves.

        Of a projected run those that are left where projection has taken its part away.
        """
        if self.expectation is None:
            return (None,) * len(self.digits)
        return self.expectation.inputs if self.digits else ()

    @property
    def lost_after(self) -> float | None:
        """The time after which kappa leaves no digits; None where it leaves some throughout."""
        return None if self.expectation is None else self.expectation.lost_after

    @property
    def lost(self) -> str:
        """That no digits are left, and after which time; empty where some are left throughout."""
        return "" if self.expectation is None else lost_digits(self.digits, self.expectation)

    @property
    def drift(self) -> Drift | None:
        """Drift of the integrals; None where it says nothing, see ``notes``."""
        return self.integrals if isinstance(self.integrals, Drift) else None

    @property
    def rotation_angles(self) -> list[float | None]:
        """The angle in degrees between the true attitude and the subject's at each time, None where
        the attitude was not judged; empty where it nowhere was."""
        angles = np.linalg.norm(self.rotation_errors, axis=1).tolist()
        return [None if math.isnan(x) else x for x in angles]

    @property
    def _most_rotated(self) -> float | None:
        return max((x for x in self.rotation_angles if x is not None), default=None)

    @property
    def chance(self) -> float | None:
        """The share of runs that have so few digits by rounding alone, or fewer; None where the
        method is not what limits them."""
        if self.limit.name != "method":
            return None
        expected = self.expected[self.lowest_row]
        return None if expected is None else chance(self.state_worst, expected, self.rows_judged)

    @property
    def notes(self) -> tuple[str, ...]:
        """What was not judged, and why."""
        notes = self.unjudged
        if isinstance(self.integrals, str):
            notes.append(f"drift of the integrals was not judged: {self.integrals}")
        if not heyoka.installed:
            notes.append("what limits the digits was not computed: heyoka is not installed")
        return (*self.subject.notes, *notes)

    @property
    def _named(self) -> set[str]:
        """All parts that are there, whether they could be judged or not."""
        return {*self.halves, *self.other_parts, *self.refusals}

    @property
    def complete(self) -> bool:
        """False of a table whose last row has no numbers, and of a run that ended early."""
        if self.subject.run is not None:
            return not self.subject.early
        last = len(self.times) - 1
        return not all(last in self.gaps.get(part, ()) for part in self._named)

    @property
    def readings(self) -> tuple[Reading, ...]:
        """Conventions in which parts of a table that is wrong as it stands are right: those that
        were applied, and those in which parts still wrong would be."""
        applied = self.subject.readings
        parts = {reading.part for reading in applied}
        return (*applied, *(offer for offer in self.offers if offer.part not in parts))

    def table(self) -> ResultTable:
        """One row per time: the digits that are correct, and what was to be expected."""
        unit = unit_of(self.reference.scene, "t")
        columns = [Column("t", list(self.times), "time", unit)]
        if self.digits:
            bands = self.expected
            digits_of_state = {
                "correct_digits": self._known_digits,
                "digits_expected_least": [None if x is None else x.least for x in bands],
                "digits_expected_median": [None if x is None else x.middle for x in bands],
                "digits_expected_most": [None if x is None else x.most for x in bands],
                "digits_inputs": self.inputs,
            }
            columns += (Column(k, x, type=DOUBLE, digits=4) for k, x in digits_of_state.items())
        for name, digits in self.part_digits.items():
            columns.append(Column(f"correct_digits_{name}", digits, type=DOUBLE, digits=4))
        if len(self.rotation_errors):
            angles = self.rotation_angles
            columns.append(Column("attitude_error", angles, "angle of rotation", "deg", DOUBLE, 4))
        return ResultTable(columns)

    @property
    def _known_digits(self) -> list[float | None]:
        """The correct digits, none where no digit was left to be correct."""
        pairs = zip(self.digits, self.expected, strict=True)
        return [None if d is None or is_lost(d, band) else d for d, band in pairs]

    def facts(self) -> list[Fact]:
        """What was judged against what, the fewest digits, and what limits them."""
        subject, against = self.subject, self.reference
        has_digits = any(d is not None for row in self.part_digits.values() for d in row)
        agreement = None if against.is_closed_form else self.agreement
        readings = table_of_rows(
            {"part": TEXT, "convention": TEXT, "digits": DOUBLE},
            [(x.part, x.convention, x.digits) for x in self.readings],
            labels=0,
        )
        left = table_of_rows(
            {"column": TEXT, "rms": DOUBLE, "bias": DOUBLE, "bias_error": DOUBLE},
            self.residuals,
        )
        causes = table_of_rows({"cause": TEXT, "digits": DOUBLE}, [*self.causes], labels=0)
        departures = table_of_rows(
            {"part": TEXT, "until": EXACT, "since": EXACT},
            [(part, x.until, x.since) for part, x in self.departures.items()],
        )
        facts = [
            *scene_facts(against.scene),
            Fact("file", str(subject.name), "what was judged"),
            Fact("number", subject.number.name, "the type against which it was held"),
            Fact("reference", against.kind, "what it was judged against"),
            Fact("regime", against.regime, "of the motion"),
            Fact("proven", against.proven is True, "whether the reference is proven"),
            Fact("assumed", against.proven if isinstance(against.proven, str) else None, type=TEXT),
            Fact("reference_digits", agreement, "of the reference"),
            Fact("judged", [*subject.state, *self.parts], "columns and outputs", type=TEXT),
            Fact("rows_judged", self.rows_judged),
            Fact("rows_lacking", len({k for rows in self.gaps.values() for k in rows})),
            Fact("worst", self.worst if has_digits and not self.lost else None, "fewest digits"),
            Fact("worst_time", self.worst_time if has_digits else None, "where they are"),
            Fact("worst_part", self.worst_part if has_digits else None, "of what they are"),
            Fact("limit", self.limit or None, "what limits the digits of the state"),
            Fact("attitude_error", self._most_rotated, "largest angle of rotation", "deg"),
            Fact(
                "attitude_limit", self.attitude_limit or None, "what limits the attitude's digits"
            ),
            Fact("residuals", left, "what is left of columns, in rows that are whole"),
            Fact("chance", self.chance, "the share of runs that have so few by chance alone"),
            Fact("lost_after", self.lost_after if self.lost else None, "no digits are left then"),
            Fact("reading", self.reading, "the convention that was applied"),
            Fact("readings", readings, "conventions in which parts would be right"),
            Fact("causes", causes, "numbers that would make it right"),
            Fact("departures", departures, "parts that leave the motion: right until, wrong since"),
            Fact("not_judged", list(self.notes), type=TEXT),
            Fact("remarks", list(subject.remarks), type=TEXT),
        ]
        if self.motion is not None:
            facts.append(Fact("motion", self.motion.table(), "whether it is chaotic"))
        if isinstance(self.integrals, Drift):
            for name, value in self.integrals._asdict().items():
                facts.append(Fact(f"drift_{name}", value, "of a first integral, relative"))
        return [*facts, provenance_fact(against.scene.provenance())]

    def __str__(self) -> str:
        """The verdict: the digits at a few times, the fewest of all, what makes them more."""
        if not self.digits and not self.other_parts:
            return "\n".join([self._nothing, *self._unread])
        lines = [*self._digits(self.worst_row), self.verdict, *self._why, *self._unread]
        return "\n".join([*self._begins_elsewhere, *lines])

    def details(self) -> str:
        """All that is known, in words.

        >>> import polhode
        >>> found = polhode.compare(polhode.integrate("euler/largest-axis"))
        >>> "drift h" in found.details(), "drift h" in str(found)
        (True, False)
        """
        against = self.reference
        how = f", proven to {self.agreement:.1f} digits"
        if against.is_closed_form:
            proven = "proven" if against.proven is True else against.proven
            how = f", {proven}" if proven else ""
        elif math.isnan(self.agreement):
            how = ""
        scene = f"{against.scene.name} ({against.regime})"
        lines = [f"{self.subject.name} against {against.kind} of {scene}{how}"]
        lines += (
            [*self._digits(None), self.verdict]
            if self.digits or self.other_parts
            else [self._nothing]
        )
        if self.limit and not self._is_foreign:
            lines.append(f"limit {self.limit}")
        if self.motion is not None:
            lines.append(f"motion {self.motion}")
        lines += [f"{name}: {digits:.2f} correct digits" for name, digits in self.parts.items()]
        if "attitude" in self.parts:
            lines.append(f"limit of the attitude {self.attitude_limit}")
            lines += [self._rotation] if self.parts["attitude"] >= _ROUGH else []
        lines += self._why
        if isinstance(self.integrals, Drift):
            lines.append(f"drift {self.integrals}")
        if self.subject.projected and self.subject.run is not None:
            lines.append(f"projected {self.subject.run.projection}")
        return "\n".join([*self._begins_elsewhere, *lines, *self._unread])

    @property
    def _begins_elsewhere(self) -> list[str]:
        """That a table of which nothing is right begins elsewhere, which is to be said first."""
        return [f"{self.subject.name}: {self.start}"] if self.start else []

    def _digits(self, worst: int | None) -> list[str]:
        """The table of the digits, see :func:`digit_table`."""
        number = self.subject.number
        return digit_table(self.times, self.digits, self.expected, number, self.other_parts, worst)

    @property
    def _why(self) -> list[str]:
        """Where parts leave the motion, and what would make them right."""
        lines = [f"{name}: {where}" for name, where in self.departures.items()]
        if self.parts.get("attitude", _ROUGH) < _ROUGH:
            lines.append(self._rotation)
        if (self.limit or self.attitude_limit) in NOISES:
            lines.append(residual_text(self.residuals))
        why = [*map(str, self.readings), *map(str, self.causes)]
        if not why and self._leaves_its_start:
            why = [OWN_EQUATIONS.format(scene=self.reference.scene.name)]
        return [*lines, *why]

    @property
    def _rotation(self) -> str:
        """By which angles the attitude is off."""
        angles = [-1.0 if x is None else x for x in self.rotation_angles]
        most = max(angles, default=-1.0)
        if most < 0:
            return "attitude: its angle of rotation is not known"
        square = [x * x for x in angles if x >= 0]
        rms = math.sqrt(sum(square) / len(square))
        when = brief(self.times[angles.index(most)])
        return f"attitude off by {most:.3g}° at worst (t = {when}), {rms:.3g}° rms"

    @property
    def _leaves_its_start(self) -> bool:
        """Whether a table begins right at t = 0, and is then wrong in the first digit."""
        if self.subject.run is not None or not self.digits or self.state_worst >= LAST:
            return False
        return any(
            not t and (d or 0) >= WRONG for t, d in zip(self.times, self.digits, strict=True)
        )

    @property
    def _without_numbers(self) -> str:
        """In which rows numbers are missing; empty where none is."""
        parts = self._named
        return without_numbers(
            {k: x for k, x in self.gaps.items() if k in parts}, parts, self.times
        )

    @property
    def _nothing(self) -> str:
        """That nothing was judged, and why."""
        return ": ".join(filter(None, [NOTHING, self._without_numbers]))

    @property
    def _unread(self) -> list[str]:
        """How the table was read, and what was not judged."""
        return [*self.subject.remarks, *(f"not judged: {note}" for note in self.notes)]

    @property
    def _is_foreign(self) -> bool:
        """Whether the limit is called a method of which nothing is known: that of a table."""
        return self.subject.run is None and self.limit.name == "method"

    @property
    def _meaning(self) -> str:
        """What the digits of the state mean."""
        if self.causes:
            return EXPLAINED
        if not self.limit:
            return ELSEWHERE if self.offers else WRONG_AT_ONCE
        words = meaning(self.limit, self.subject.number, self._is_foreign)
        if self.chance is not None and self.chance > RARE:
            words += BY_CHANCE.format(runs=1 / self.chance)
        return words

    @property
    def _meaning_alone(self) -> list[str]:
        """What the fewest digits mean where there is no state: of an attitude its limit."""
        if self.worst < LAST and self.attitude_limit not in NOISES:
            return [WRONG_AT_ONCE]
        if self.worst_part != "attitude" or self.offers:
            return []
        limit, number = self.attitude_limit, self.subject.number
        return [meaning(limit, number, self.subject.run is None and limit.name == "method")]

    @property
    def verdict(self) -> str:
        """The fewest digits of all, and what those of the state mean; BadInput where none was
        judged."""
        return "; ".join(filter(None, [self._without_numbers, self._verdict]))

    @property
    def _verdict(self) -> str:
        """The verdict on the numbers that are there."""
        read = f"; read as {self.reading}" if self.reading else ""
        if self.digits and self.lost:
            return f"{self.lost}: {self._meaning}{read}"
        words = f"{self.worst:.2f} correct digits at worst (t = {brief(self.worst_time)})"
        if self.rows_judged < len(self.times):
            words += f" of {self.rows_judged} rows judged of {len(self.times)}"
        if self.worst_part != STATE_PART:
            words += f", of {self.worst_part}"
            if not self.digits:
                return ", ".join([words, *self._meaning_alone]) + read
            time = brief(self.times[self.lowest_row])
            words += f"; of the state {self.state_worst:.2f} (t = {time})"
        return f"{words}, {self._meaning}{read}"

    def __repr__(self) -> str:
        try:
            words = f"worst {self.worst:.2f} correct digits at t = {brief(self.worst_time)}"
            words += f", limited by {self.limit}" if self.limit else ""
            words += f", {self._without_numbers}" if self.gaps else ""
            words += f", read as {self.reading}" if self.reading else ""
        except BadInput:
            words = self._nothing
        return f"<Judgement of {self.subject.name} against {self.reference.kind}: {words}>"


# --- words ----------------------------------------------------------------------------------------
#
# A judgement in words: its table of digits, what its limit means.


def meaning(limit: Limit, number: NumberType, foreign: bool) -> str:
    """What a limit says of digits; ``foreign``: of those of a table of another program."""
    how = FOREIGN if limit.name == "method" and foreign else limit.detail
    words = ROUNDED if limit.name == "rounding" and how else LIMITS[limit.name]
    return words.format(number=number.name, how=how)


def without_numbers(
    gaps: Mapping[str, Sequence[int]], parts: Collection[str], times: Sequence[Fraction]
) -> str:
    """In which rows which of the parts have no numbers; empty where all have them everywhere."""
    alike: dict[tuple[int, ...], list[str]] = {}
    for part, rows in gaps.items():
        alike.setdefault(tuple(rows), []).append(part)
    phrases = []
    for rows, names in alike.items():
        of = "" if len(names) == len(parts) else f" of {' and '.join(names)}"
        count, share, first = len(times), f"{len(rows)} of {len(times)} rows", brief(times[rows[0]])
        if len(rows) == count:
            where = "in any row"
        elif len(rows) == 1:
            where = f"at t = {first} ({share})"
        elif rows == (*range(rows[0], count),):
            where = f"from t = {first} on ({share})"
        else:
            where = f"in {share}, the first at t = {first}"
        phrases.append(f"no numbers{of} {where}")
    return ", ".join(phrases)


def residual_text(left: Sequence[Residual]) -> str:
    """Residuals in words: of each column the root mean square and the bias."""
    phrases = [f"{x.column} {x.rms:.2g} ({x.bias:+.1g} ± {x.bias_error:.1g})" for x in left]
    return f"noise, rms (and bias): {', '.join(phrases)}"


def digit_table(
    times: Sequence[Fraction],
    digits: Sequence[float | None],
    expected: Sequence[Band | None],
    number: NumberType,
    parts: Mapping[str, Sequence[float | None]],
    worst: int | None,
) -> list[str]:
    """The lines of the digits at a few of the times.

    ``digits``: of the state, empty where it was not judged, None where it has no number;
    ``parts``: of others.  ``worst``: the row that is shown beside the first and the last; None for
    more rows, and those beside the digits that are expected.
    """
    count = len(times)
    shown = few(count, SHOWN) if worst is None else sorted({0, worst, count - 1})
    columns = {"t": [_time(times[k], number) for k in shown]}
    if digits:
        columns["correct digits"] = [shown_digits(digits[k], expected[k]) for k in shown]
    if digits and worst is None:
        bands = ["unknown" if (b := expected[k]) is None else b.shown(number) for k in shown]
        columns[f"expected in {number.name}"] = bands
    for name, of_part in parts.items():
        columns[name] = ["-" if (d := of_part[k]) is None else f"{d:.2f}" for k in shown]
    lines = aligned([*columns], [*zip(*columns.values(), strict=True)])
    if worst is None and len(shown) < count:
        lines.append(f"({len(shown)} of {count} times; all of them with --json)")
    return lines


def _time(t: Fraction, number: NumberType) -> str:
    """Every digit of a time, where they are few; of a number of the type as few as tell it.

    Sixty times a double of minutes may be 0.99999999999999994, which is 1 here.
    """
    text = shortest(t, number) if number.rounded(t) == t else in_full(t)
    near = brief(t, 14)
    return near if len(text) > _SHORT or len(near) + 2 < len(text) else text

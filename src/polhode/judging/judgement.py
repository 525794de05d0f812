"""A judgement: how many digits of a subject are right, what limits them, and how it reads."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from polhode.common.errors import aligned, few
from polhode.common.values import may_wait
from polhode.equations.integrals import Drift
from polhode.judging import limits
from polhode.judging.conditioning import Band
from polhode.judging.limits import LAST, NOISES, Departure, Expectation, Limit, Residual
from polhode.judging.score import SHOWN, STATE_PART, Score, bits_of
from polhode.judging.tables import explanations, hypotheses
from polhode.judging.tables.explanations import Cause
from polhode.judging.tables.table import WRONG, Reading
from polhode.numbers.decimals import brief, in_full, shortest
from polhode.numbers.number_types import Doubles, NumberType
from polhode.results.cells import DOUBLE, EXACT, TEXT
from polhode.results.result import Result
from polhode.results.table import Column, Fact, Table, table_of_rows
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


class Diagnosis(NamedTuple):
    """What limits the digits of a score, and what may be wrong: what has to know the motion.

    ``limit``: what limits the digits of the state; empty where it was not judged, and of a table
    that is wrong in the first digit or would be right in a convention that is not applied, for then
    its method is not to blame; ``attitude_limit``: what limits those of the attitude.
    ``expectation``: the digits to expect, unknown where no limit needs them and they were not asked
    for.  ``departures``: parts that leave the motion: right until one time, wrong from the next one
    on.  ``offers``: conventions in which parts still wrong would be right, not applied; ``causes``:
    numbers of which one, if it were another, would make a wrong table right, the best first, fitted
    and changed nowhere; ``start``: that a wrong table begins with another state, in words.
    ``residuals``: what is left of each column of a table's state, and of its attitude as a rotation
    in degrees, where that is noise or was asked for.  ``rotation_errors``: rotations from the true
    attitudes to the subject's, vectors along body axes in degrees, shape (rows, 3).
    ``integrals``: their drift, or why it says nothing.
    """

    limit: Limit
    attitude_limit: Limit
    expectation: Expectation
    departures: Mapping[str, Departure]
    offers: tuple[Reading, ...]
    causes: tuple[Cause, ...]
    start: str
    residuals: tuple[Residual, ...]
    rotation_errors: Doubles
    integrals: Drift | str


def diagnosis(score: Score, offered: tuple[Reading, ...], details: bool) -> Diagnosis:
    """What the digits of a score mean: those to expect, what limits them, what may be wrong."""
    table, scene = score.subject, score.reference.scene
    is_foreign = table.run is None
    offers = offered if score.is_wrong else ()
    digits = score.part_digits
    falls = {name: limits.departure(score.times, row) for name, row in digits.items()}
    limited = (STATE_PART, "attitude")
    loses_all = bool(score.digits) and score.state_worst < LAST
    is_plain = limits.UNKNOWN not in [limits.limit_of(score, part) for part in limited]
    is_plain = is_plain and not any(falls.values())
    unknown = (None,) * len(score.times)
    expected = None if is_plain and not (loses_all or details) else limits.expectation(score)
    limit, limit_of_attitude = (limits.limit_of(score, part, expected) for part in limited)
    rotation = limits.rotation_errors(score)
    residuals: tuple[Residual, ...] = ()
    blamed = is_foreign and "method" in (limit.name, limit_of_attitude.name)
    if is_foreign and (details or (blamed and not offers)):
        rows = limits.ResidualRows.of(score, rotation)
        noise = rows.noise(score) if blamed and not offers else None
        if noise is not None:
            both = limit, limit_of_attitude
            limit, limit_of_attitude = (noise if x.name == "method" else x for x in both)
        residuals = rows.residuals if details or noise is not None else ()
    causes: tuple[Cause, ...] = ()
    if is_foreign and score.digits and not offers and (loses_all or limit.name == "method"):
        causes = explanations.causes(table, scene)
    if is_foreign and limit.name == "method" and (loses_all or offers):
        limit = limits.NO_LIMIT  # its method is not to blame
    start, is_explained = "", bool(table.readings or offers or causes)
    if is_foreign and not is_explained and score.has_digits and score.worst < LAST:
        start = hypotheses.other_start(table, scene)
    departures = {
        name: fall
        for name, fall in falls.items()
        if fall and expected and fall.is_unexpected(score.times, digits[name], expected.bands)
    }
    return Diagnosis(
        limit,
        limit_of_attitude,
        expected or Expectation(unknown, unknown, None, ""),
        departures,
        offers,
        causes,
        start,
        residuals,
        rotation,
        table.drift(scene, bits_of(table)),
    )


@may_wait("diagnosis")
@dataclass(frozen=True, eq=False, repr=False)
class Judgement(Result, Score):
    """Correct digits of a run or a table at each of its times, and what limits them.

    ``subject``: what was judged.  ``reference``: what it was judged against.
    ``digits[k]`` belongs to ``times[k]``: -log10 of the larger of the error of omega over the
    largest |omega| of the reference at these times, and the error of gamma, in the scene's body
    axes.  ``worst``: the fewest of these and of those of every other part that was judged.
    ``limit``, ``causes``, ``residuals`` and what else has to know the motion are those of the
    ``diagnosis``, which is made when it is first asked for.  ``motion``: whether the scene's motion
    is chaotic, where that was asked for.

    Printed, it is the answer of ``polhode compare``; :meth:`details` has all that is known.

    >>> import polhode
    >>> judgement = polhode.compare(polhode.integrate("euler/separatrix", at=[1, 20]))
    >>> 12.5 < judgement.worst < 14.5, judgement.worst_time, judgement.limit
    (True, Fraction(20, 1), 'conditioning')
    """

    diagnosis: Diagnosis
    motion: Result | None = None

    @property
    def limit(self) -> Limit:
        """What limits the digits of the state, a text; empty where nothing is to blame."""
        return self.diagnosis.limit

    @property
    def attitude_limit(self) -> Limit:
        """What limits the digits of the attitude."""
        return self.diagnosis.attitude_limit

    @property
    def departures(self) -> Mapping[str, Departure]:
        """Parts that leave the motion: right until one time, wrong from the next one on."""
        return self.diagnosis.departures

    @property
    def causes(self) -> tuple[Cause, ...]:
        """Numbers of which one, if it were another, would make a wrong table right."""
        return self.diagnosis.causes

    @property
    def residuals(self) -> tuple[Residual, ...]:
        """What is left of each column, where that is noise or was asked for."""
        return self.diagnosis.residuals

    @property
    def expected(self) -> tuple[Band | None, ...]:
        """The digits of runs that round once a step of the subject's type; None where unknown.

        Followed at some hundred times; of more times, linear between those.

        Of a projected run those that projection leaves; see :func:`polhode.conditioning`.
        """
        return self.diagnosis.expectation.bands if self.digits else ()

    @property
    def inputs(self) -> tuple[float | None, ...]:
        """The digits that rounding the scene's numbers to the subject's type leaves.

        Of a projected run those that are left where projection has taken its part away.
        """
        return self.diagnosis.expectation.inputs if self.digits else ()

    @property
    def lost_after(self) -> float | None:
        """The time after which kappa leaves no digits; None where it leaves some throughout."""
        return self.diagnosis.expectation.lost_after

    @property
    def lost(self) -> str:
        """That no digits are left, and after which time; empty where some are left throughout."""
        return limits.lost_digits(self.digits, self.diagnosis.expectation)

    @property
    def drift(self) -> Drift | None:
        """Drift of the integrals; None where it says nothing, see ``notes``."""
        integrals = self.diagnosis.integrals
        return integrals if isinstance(integrals, Drift) else None

    @property
    def rotation_angles(self) -> list[float | None]:
        """The angle in degrees between the true attitude and the subject's at each time, None where
        the attitude was not judged; empty where it nowhere was."""
        angles = np.linalg.norm(self.diagnosis.rotation_errors, axis=1).tolist()
        return [None if math.isnan(x) else x for x in angles]

    @property
    def chance(self) -> float | None:
        """The share of runs that have so few digits by rounding alone, or fewer; None where the
        method is not what limits them."""
        if self.limit.name != "method":
            return None
        band, count = self.expected[self.lowest_row], self.rows_judged
        return None if band is None else limits.chance(self.state_worst, band, count)

    @property
    def notes(self) -> tuple[str, ...]:
        """What was not judged, and why."""
        notes = self.unjudged
        if isinstance(self.diagnosis.integrals, str):
            notes.append(f"drift of the integrals was not judged: {self.diagnosis.integrals}")
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
        offers = self.diagnosis.offers
        return (*applied, *(offer for offer in offers if offer.part not in parts))

    def table(self) -> Table:
        """One row per time: the digits that are correct, and what was to be expected."""
        unit = unit_of(self.reference.scene, "t")
        columns = [Column("t", list(self.times), "time", unit)]
        if self.digits:
            bands = self.expected
            pairs = zip(self.digits, bands, strict=True)
            digits_of_state = {
                "correct_digits": [None if limits.is_lost(d, band) else d for d, band in pairs],
                "digits_expected_least": [band and band.least for band in bands],
                "digits_expected_median": [band and band.middle for band in bands],
                "digits_expected_most": [band and band.most for band in bands],
                "digits_inputs": self.inputs,
            }
            columns += (Column(k, x, type=DOUBLE, digits=4) for k, x in digits_of_state.items())
        for name, digits in self.part_digits.items():
            columns.append(Column(f"correct_digits_{name}", digits, type=DOUBLE, digits=4))
        if angles := self.rotation_angles:
            columns.append(Column("attitude_error", angles, "angle of rotation", "deg", DOUBLE, 4))
        return Table(columns)

    def facts(self) -> list[Fact]:
        """What was judged against what, the fewest digits, and what limits them."""
        subject, against = self.subject, self.reference
        agreement = None if against.is_closed_form else self.agreement
        worst = self._worst if self.has_digits else None
        rotated = max((x for x in self.rotation_angles if x is not None), default=None)
        rows = [(x.part, x.convention, x.digits) for x in self.readings]
        types = {"part": TEXT, "convention": TEXT, "digits": DOUBLE}
        readings = table_of_rows(types, rows, labels=0)
        types = {"column": TEXT, "rms": DOUBLE, "bias": DOUBLE, "bias_error": DOUBLE}
        left = table_of_rows(types, self.residuals)
        causes = table_of_rows({"cause": TEXT, "digits": DOUBLE}, [*self.causes], labels=0)
        falls = [(part, x.until, x.since) for part, x in self.departures.items()]
        departures = table_of_rows({"part": TEXT, "until": EXACT, "since": EXACT}, falls)
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
            Fact("worst", worst.digits if worst and not self.lost else None, "fewest digits"),
            Fact("worst_time", worst and self.times[worst.row], "where they are"),
            Fact("worst_part", worst and worst.part, "of what they are"),
            Fact("limit", self.limit or None, "what limits the digits of the state"),
            Fact("attitude_error", rotated, "largest angle of rotation", "deg"),
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
        for name, value in self.drift._asdict().items() if self.drift is not None else ():
            facts.append(Fact(f"drift_{name}", value, "of a first integral, relative"))
        return [*facts, provenance_fact(against.scene.provenance())]

    def __str__(self) -> str:
        """The verdict: the digits at a few times, the fewest of all, what makes them more."""
        return self._text(details=False)

    def details(self) -> str:
        """All that is known, in words.

        >>> import polhode
        >>> found = polhode.compare(polhode.integrate("euler/largest-axis"))
        >>> "drift h" in found.details(), "drift h" in str(found)
        (True, False)
        """
        return self._text(details=True)

    def _text(self, details: bool) -> str:
        """The verdict, how the table was read, and what was not judged; ``details``: and the rest.

        That a table of which nothing is right begins elsewhere is said first.
        """
        subject, start, is_judged = self.subject, self.diagnosis.start, self.has_digits
        lines = [f"{subject.name}: {start}"] if start else []
        if details:
            lines.append(self._head)
        if is_judged:
            lines += [*self._digit_lines(None if details else self.worst_row), self.verdict]
        else:
            lines.append(": ".join(filter(None, [NOTHING, self._without_numbers])))
        if details:
            lines += self._limits_of_parts
        if is_judged or details:
            lines += self._why
        if details and self.drift is not None:
            lines.append(f"drift {self.drift}")
        if details and subject.projected and subject.run is not None:
            lines.append(f"projected {subject.run.projection}")
        return "\n".join([*lines, *subject.remarks, *(f"not judged: {x}" for x in self.notes)])

    @property
    def _head(self) -> str:
        """What was judged against what, and how well that is known."""
        against = self.reference
        how = "" if math.isnan(self.agreement) else f", proven to {self.agreement:.1f} digits"
        if against.is_closed_form:
            proven = "proven" if against.proven is True else against.proven
            how = f", {proven}" if proven else ""
        scene = f"{against.scene.name} ({against.regime})"
        return f"{self.subject.name} against {against.kind} of {scene}{how}"

    @property
    def _limits_of_parts(self) -> list[str]:
        """What limits the state, the kind of motion, and the digits of the other parts."""
        is_method_of_others = self.subject.run is None and self.limit.name == "method"
        lines = [f"limit {self.limit}"] if self.limit and not is_method_of_others else []
        if self.motion is not None:
            lines.append(f"motion {self.motion}")
        lines += [f"{name}: {digits:.2f} correct digits" for name, digits in self.parts.items()]
        if "attitude" in self.parts:
            lines.append(f"limit of the attitude {self.attitude_limit}")
            lines += [self._rotation] if self.parts["attitude"] >= _ROUGH else []
        return lines

    @property
    def _why(self) -> list[str]:
        """Where parts leave the motion, and what would make them right."""
        lines = [f"{name}: {where}" for name, where in self.departures.items()]
        if self.parts.get("attitude", _ROUGH) < _ROUGH:
            lines.append(self._rotation)
        if (self.limit or self.attitude_limit) in NOISES:
            noise = [
                f"{x.column} {x.rms:.2g} ({x.bias:+.1g} ± {x.bias_error:.1g})"
                for x in self.residuals
            ]
            lines.append(f"noise, rms (and bias): {', '.join(noise)}")
        why = [*map(str, self.readings), *map(str, self.causes)]
        if not why and self.subject.run is None and self.digits and self.state_worst < LAST:
            starts = [self.digits[k] or 0.0 for k, t in enumerate(self.times) if not t]
            if max(starts, default=0.0) >= WRONG:
                why = [OWN_EQUATIONS.format(scene=self.reference.scene.name)]
        return [*lines, *why]

    @property
    def _rotation(self) -> str:
        """By which angles the attitude is off."""
        angles = self.rotation_angles
        known = [x for x in angles if x is not None]
        if not known:
            return "attitude: its angle of rotation is not known"
        rms = math.sqrt(sum(x * x for x in known) / len(known))
        when = brief(self.times[angles.index(max(known))])
        return f"attitude off by {max(known):.3g}° at worst (t = {when}), {rms:.3g}° rms"

    @property
    def _without_numbers(self) -> str:
        """In which rows which of the parts have no numbers; empty where all have them."""
        parts, times, count = self._named, self.times, len(self.times)
        alike: dict[tuple[int, ...], list[str]] = {}
        for part, rows in self.gaps.items():
            if part in parts:
                alike.setdefault(rows, []).append(part)
        phrases = []
        for rows, names in alike.items():
            of = "" if len(names) == len(parts) else f" of {' and '.join(names)}"
            share, first = f"{len(rows)} of {count} rows", brief(times[rows[0]])
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

    @property
    def _meaning(self) -> str:
        """What the digits of the state mean; where there is none those of the attitude, if any."""
        limit, offers = self.limit, self.diagnosis.offers
        if self.causes:
            return EXPLAINED
        if self.digits and not limit:
            return ELSEWHERE if offers else WRONG_AT_ONCE
        if not self.digits:
            limit = self.attitude_limit
            if self.worst < LAST and limit not in NOISES:
                return WRONG_AT_ONCE
            if self.worst_part != "attitude" or offers:
                return ""
        how = limit.detail
        if limit.name == "method" and self.subject.run is None:
            how = FOREIGN
        words = ROUNDED if limit.name == "rounding" and how else LIMITS[limit.name]
        words = words.format(number=self.subject.number.name, how=how)
        if self.chance is not None and self.chance > RARE:
            words += BY_CHANCE.format(runs=1 / self.chance)
        return words

    @property
    def verdict(self) -> str:
        """The fewest digits of all, and what those of the state mean; BadInput where none was
        judged."""
        worst, meaning = self._worst, self._meaning
        words = f"{worst.digits:.2f} correct digits at worst (t = {brief(self.worst_time)})"
        if self.rows_judged < len(self.times):
            words += f" of {self.rows_judged} rows judged of {len(self.times)}"
        if worst.part != STATE_PART:
            words += f", of {worst.part}"
            if self.digits:
                time = brief(self.times[self.lowest_row])
                words += f"; of the state {self.state_worst:.2f} (t = {time})"
        words = ", ".join(filter(None, [words, meaning]))
        if self.lost:
            words = f"{self.lost}: {meaning}"
        if self.reading:
            words += f"; read as {self.reading}"
        return "; ".join(filter(None, [self._without_numbers, words]))

    def __repr__(self) -> str:
        if not self.has_digits:
            words = ": ".join(filter(None, [NOTHING, self._without_numbers]))
        else:
            words = f"worst {self.worst:.2f} correct digits at t = {brief(self.worst_time)}"
            words += f", limited by {self.limit}" if self.limit else ""
            words += f", {self._without_numbers}" if self.gaps else ""
            words += f", read as {self.reading}" if self.reading else ""
        return f"<Judgement of {self.subject.name} against {self.reference.kind}: {words}>"

    def _digit_lines(self, worst: int | None) -> list[str]:
        """The lines of the digits at a few of the times.

        ``worst``: the row that is shown beside the first and the last; None for more rows, and
        those beside the digits that are expected.
        """
        count, number, expected = len(self.times), self.subject.number, self.expected
        shown = few(count, SHOWN) if worst is None else sorted({0, worst, count - 1})
        columns = {"t": [_time(self.times[k], number) for k in shown]}
        if self.digits:
            digits = [limits.shown_digits(self.digits[k], expected[k]) for k in shown]
            columns["correct digits"] = digits
        if self.digits and worst is None:
            bands = ["unknown" if (b := expected[k]) is None else b.shown(number) for k in shown]
            columns[f"expected in {number.name}"] = bands
        for name, of_part in self.other_parts.items():
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

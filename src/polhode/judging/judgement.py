"""What rounding leaves of a motion's digits at the times that are judged."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from polhode.common.errors import BadInput, few
from polhode.common.values import cached_property
from polhode.judging.conditioning import Band, Conditioning, conditioning
from polhode.judging.diagnosis.causes import Cause, causes, other_start
from polhode.judging.diagnosis.error_budget import (
    LAST,
    Departure,
    between,
    chance,
    departure,
    is_lost,
    is_thin,
    limit,
    selected,
    time_rounding,
)
from polhode.judging.lyapunov import Lyapunov, lyapunov
from polhode.judging.reference import by_sign
from polhode.judging.report_text import (
    BIASED,
    BY_CHANCE,
    ELSEWHERE,
    EXPLAINED,
    NOTHING,
    OWN_EQUATIONS,
    SHOWN,
    WHITE,
    WRONG_AT_ONCE,
    meaning,
    residual_text,
    table,
    without_numbers,
)
from polhode.judging.score import STATE_PART, Scores
from polhode.judging.tables.table import WRONG, Reading, Table
from polhode.numbers.conversion import doubles, to_double
from polhode.numbers.decimals import brief
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import DIGITS_HELD
from polhode.results.cells import DOUBLE, EXACT, TEXT
from polhode.results.result import Result
from polhode.results.table import Column, Fact, table_of_rows
from polhode.results.table import Table as ResultTable
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import provenance_fact, scene_facts, unit_of
from polhode.taylor import heyoka

FOLLOWED = 400  # times at which what rounding does to the motion is followed


@dataclass(frozen=True, eq=False)
class Expectation:
    """The digits to expect of a subject at its times.

    Followed at ``FOLLOWED`` times or so; of more times, linear between those.  ``also``: a row that
    is followed in any case.  ``known``: the conditioning at the scene's times, if it is known.
    """

    scene: Scene
    subject: Table
    also: int | None = None
    known: Conditioning | None = None

    @cached_property
    def conditionings(self) -> tuple[Conditioning, ...]:
        """Kappa at the times judged: from t = 0 ahead, and from t = 0 back."""
        if self.known is not None:
            return (self.known,)
        if not heyoka.installed:
            return ()
        parts = by_sign([self.subject.times[k] for k in self._rows])
        return tuple(conditioning(self.scene, part, self.subject.number) for part in parts)

    @cached_property
    def _rows(self) -> list[int]:
        """Those that are followed."""
        count = len(self.subject.times)
        also = set() if self.also is None else {self.also}
        return sorted({*few(count, FOLLOWED), *few(count, SHOWN)} | also)

    @cached_property
    def bands(self) -> tuple[Band | None, ...]:
        """The digits of runs that round once a step of the subject's type."""
        return self._told(lambda known: known.expected(self.subject.number, self.every))

    @cached_property
    def inputs(self) -> tuple[float | None, ...]:
        """The digits that rounding the scene's numbers to the subject's type leaves."""
        return self._told(lambda known: known.inputs(self.subject.number, self.every))

    @property
    def every(self) -> int:
        """Steps between two projections of the run; 0 where there are none."""
        run = self.subject.run
        return 0 if run is None or run.projection is None else run.projection.every

    def _told(self, what: Callable[[Conditioning], tuple[Any, ...]]) -> tuple[Any, ...]:
        """What is known of the times judged."""
        times = self.subject.times
        if self.known is not None:
            return what(self.known)[: len(times)]
        if not self.conditionings:
            return (None,) * len(times)
        found: dict[Exact, Any] = {}
        for part in self.conditionings:
            found |= dict(zip(part.times, what(part), strict=True))
        return between({k: found[times[k]] for k in self._rows}, times)


# --- judgement ------------------------------------------------------------------------------------
#
# A judgement: how many digits of a subject are right, what limits them, and how it reads.


PRINTED = "rounding (of the printed digits)"
_NOISES, _BIASED = (WHITE, BIASED), 5.0  # limits; a bias, times the noise about it, that limits
_ROUGH = 6.0  # digits of an attitude of which an angle says more
RARE = 1e-4  # a share of runs of which nobody judges so many
MOTION_STEPS = 100_000  # a moment's work on whether the motion is chaotic


@dataclass(frozen=True, eq=False, repr=False)
class Judgement(Result, Scores):
    """Correct digits of a run or a table at each of its times, and what limits them.

    ``subject``: what was judged.  ``reference``: what it was judged against.  ``known``: the
    conditioning at the scene's times, if it is known already.  ``progress``: called with the
    reference's rows where they are many.
    ``offered``: conventions in which parts are right that are told and not applied.
    ``digits[k]`` belongs to ``times[k]``: -log10 of the larger of the error of omega over the
    largest |omega| of the reference at these times, and the error of gamma, in the scene's body
    axes.  ``worst``: the fewest of these and of those of every other part that was judged.
    Printed, it is the answer of ``polhode compare``; :meth:`details` has all that is known.

    >>> import polhode
    >>> found = polhode.compare(polhode.integrate("euler/separatrix", at=[1, 20]))
    >>> 12.5 < found.worst < 14.5, found.worst_time, found.limit
    (True, Fraction(20, 1), 'conditioning')
    """

    known: Conditioning | None = field(default=None, compare=False)
    offered: tuple[Reading, ...] = field(default=(), compare=False)

    @cached_property
    def departures(self) -> dict[str, Departure]:
        """Parts that leave the motion: right until one time, wrong from the next one on."""
        found = {
            name: departure(self.times, digits, lambda: self._expectation.bands)
            for name, digits in self.part_digits.items()
        }
        return {name: where for name, where in found.items() if where is not None}

    @cached_property
    def _expectation(self) -> Expectation:
        also = self._lowest if self.digits else None
        return Expectation(self.reference.scene, self.subject, also, self.known)

    @property
    def expected(self) -> tuple[Band | None, ...]:
        """The digits of runs that round once a step of the subject's type; None where unknown.

        Followed at some hundred times; of more times, linear between those.

        Of a projected run those that projection leaves; see :func:`polhode.conditioning`.
        """
        return self._expectation.bands if self.digits else ()

    @property
    def inputs(self) -> tuple[float | None, ...]:
        """The digits that rounding the scene's numbers to the subject's type leaves.

        Of a projected run those that are left where projection has taken its part away.
        """
        return self._expectation.inputs if self.digits else ()

    @property
    def lost_after(self) -> float | None:
        """The time after which kappa leaves no digits; None where it leaves some throughout."""
        after = [
            part.lost_after
            for part in self._expectation.conditionings
            if part.lost_after is not None
        ]
        return min(after, key=abs, default=None)

    @property
    def lost(self) -> str:
        """That no digits are left, and after which time; empty where some are left throughout."""
        if not any(x is not None and x < LAST for x in self.digits):
            return ""  # what was to be expected need not be known, which is dear
        gone = any(map(is_lost, self.digits, self.expected))
        return next(
            (part.lost for part in self._expectation.conditionings if gone and part.lost), ""
        )

    @cached_property
    def motion(self) -> Lyapunov | None:
        """Whether the scene's motion is regular or chaotic, from a limited number of steps; None
        where heyoka is not installed."""
        if not heyoka.installed:
            return None
        return lyapunov(self.reference.scene, max_steps=MOTION_STEPS)

    @cached_property
    def agreement(self) -> float:
        """The accuracy of the reference in digits, from its last answer; inf for a closed form, nan
        if it is not known."""
        _ = self.digits, self._others
        return self.reference.agreement

    @cached_property
    def limit(self) -> str:
        """What limits the digits of the state, see
        :func:`polhode.judging.diagnosis.error_budget.limit`.

        Empty where the state was not judged, and of a table that is wrong in the first digit or
        would be right in a convention that is not applied: then its method is not to blame.
        """
        if not self.digits:
            return ""
        found = self._limit
        if self._may_be_noise(found):
            return self._noise
        blamed = self.subject.run is None and found.startswith("method")
        return "" if blamed and (self.state_worst < LAST or self.offers) else found

    @cached_property
    def _limit(self) -> str:
        about, agreement, worst = self.subject, self.reference.agreement, self.state_worst
        if about.run is None and worst >= about.printed - 1:
            return PRINTED
        held, steps = min(about.held, about.number.most_digits), about.steps
        cheap = limit(worst, held, None, None, agreement, steps)
        if cheap in ("rounding", "reference"):  # needs nothing of the motion
            return cheap
        at, times = self._lowest, self.rows_judged
        known, inputs = self.known, self.inputs[at]
        expected = (
            known.band(at, about.number, self._expectation.every) if known else self.expected[at]
        )
        thin = is_thin(self.reference.scene.body)
        found = limit(worst, held, expected, inputs, agreement, steps, times, thin)
        moved = self._time_rounding if found.startswith("method") else None
        return found if moved is None else f"rounding (of the times, by up to {moved:.1g})"

    @property
    def _time_rounding(self) -> float | None:
        """By how much the times are off at most, if that explains the digits of the state."""
        about, scene, digits = self.subject, self.reference.scene, self.digits
        if not about.time_errors:
            return None
        kept = sorted({*few(len(self.times), FOLLOWED), self._lowest})
        rows = about.some(kept).rows(scene.columns) or [[None]] * len(kept)
        states = {k: row for k, row in zip(kept, rows, strict=True) if None not in row}
        if not states:
            (row,) = self.reference.at([self.times[self._lowest]], DIGITS_HELD["double"])
            states = {self._lowest: [*row]}
        worst = selected(len(self.times))
        return time_rounding(
            scene,
            doubles([*states.values()]),
            [about.time_errors[k] for k in states],
            [about.held if (d := digits[k]) is None else d for k in states],
            [about.held if (e := self.expected[k]) is None else e.least - worst for k in states],
        )

    @property
    def rotation_angles(self) -> list[float | None]:
        """The angle in degrees between the true attitude and the subject's at each time, None where
        the attitude was not judged; empty where it nowhere was."""
        angles = np.linalg.norm(self.rotation_errors, axis=1).tolist()
        return [None if math.isnan(x) else x for x in angles]

    @property
    def _most_rotated(self) -> float | None:
        return max((x for x in self.rotation_angles if x is not None), default=None)

    @cached_property
    def attitude_limit(self) -> str:
        """What limits the digits of the attitude; empty where it was not judged.

        The rate at which an attitude goes wrong is the error of omega, and that of the state is
        what it was expected to be: so it is expected to lose the digits of the state, and those of
        the angle that was turned until then.
        """
        digits, about = self._others.get("attitude", ()), self.subject
        there = [d for d in digits if d is not None]
        if not there:
            return ""
        worst = min(there)
        at = digits.index(worst)
        if about.run is None and worst >= about.printed - 1:
            return PRINTED
        held, agreement = min(about.held, about.number.most_digits), self.reference.agreement
        cheap = limit(worst, held, None, None, agreement, about.steps)
        if cheap in ("rounding", "reference"):
            return cheap
        band = self._expectation.bands[at]
        if band is not None:
            turned = 10.0**self.reference.scene.log10_rate * abs(to_double(self.times[at]))
            band = band._replace(least=max(0.0, band.least - math.log10(1 + turned)))
        thin = is_thin(self.reference.scene.body)
        found = limit(worst, held, band, None, agreement, about.steps, len(there), thin)
        return self._noise if self._may_be_noise(found) else found

    def _may_be_noise(self, limit: str) -> bool:
        """Whether what is blamed on a method of which nothing is known may be white noise."""
        blamed = self.subject.run is None and limit.startswith("method")
        return blamed and not self.offers and self.is_noisy

    @property
    def _noise(self) -> str:
        """What white noise is called: by its bias, where that is more than the noise."""
        biased = any(abs(x.bias) > _BIASED * x.rms for x in self.residuals)
        return BIASED if biased else WHITE

    @cached_property
    def chance(self) -> float | None:
        """The share of runs that have so few digits by chance alone; None unless the limit is the
        method.

        The limit allows for the many times of one run.  Among hundreds of runs a share of one in
        hundreds is explained by chance.
        """
        if not self.limit.startswith("method"):
            return None
        expected = self.expected[self._lowest]
        return None if expected is None else chance(self.state_worst, expected, self.rows_judged)

    @property
    def notes(self) -> tuple[str, ...]:
        """What was not judged, and why."""
        unjudged = self._unjudged
        if isinstance(self._drift, str):
            unjudged.append(f"drift of the integrals was not judged: {self._drift}")
        if not heyoka.installed:
            unjudged.append("what limits the digits was not computed: heyoka is not installed")
        return (*self.subject.notes, *unjudged)

    @property
    def complete(self) -> bool:
        """False of a table whose last row has no numbers, and of a run that ended early."""
        if self.subject.run is not None:
            return not self.subject.early
        parts = {*self._halves, *self._judged_parts}
        last = len(self.times) - 1
        return not all(last in self.gaps.get(part, ()) for part in parts)

    @property
    def readings(self) -> tuple[Reading, ...]:
        """Conventions in which parts of a table that is wrong as it stands are right: those that
        were applied, and those in which parts still wrong would be."""
        known = self.subject.readings
        read = {one.part for one in known}
        return (*known, *(one for one in self.offers if one.part not in read))

    @property
    def offers(self) -> tuple[Reading, ...]:
        """Those that are not applied, of a table of which a part is wrong."""
        worst = [*self.parts.values(), *([self.state_worst] if self.digits else [])]
        return self.offered if min(worst, default=WRONG) < WRONG else ()

    @cached_property
    def causes(self) -> tuple[Cause, ...]:
        """Numbers of which one, if it were another, would make a table right that is not: constants
        of the body, the start, a clock; the best first, fitted, and changed nowhere."""
        if self.subject.run is not None or not self.digits or self.offers or self.limit in _NOISES:
            return ()
        if self.state_worst >= LAST and not self.limit.startswith("method"):
            return ()
        return causes(self.subject, self.reference.scene)

    def table(self) -> ResultTable:
        """One row per time: the digits that are correct, and what was to be expected."""
        unit = unit_of(self.reference.scene, "t")
        columns = [Column("t", list(self.times), "time", unit)]
        if self.digits:
            bands = self.expected
            told = {
                "correct_digits": self._known_digits,
                "digits_expected_least": [None if x is None else x.least for x in bands],
                "digits_expected_median": [None if x is None else x.middle for x in bands],
                "digits_expected_most": [None if x is None else x.most for x in bands],
                "digits_inputs": self.inputs,
            }
            columns += (Column(k, x, type=DOUBLE, digits=4) for k, x in told.items())
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
        told = any(d is not None for digits in self.part_digits.values() for d in digits)
        agreement = None if against.is_closed_form else self.agreement
        readings = table_of_rows(
            {"part": TEXT, "convention": TEXT, "digits": DOUBLE},
            [(x.part, x.convention, x.digits) for x in self.readings],
            labels=0,
        )
        left = table_of_rows(
            {"column": TEXT, "rms": DOUBLE, "bias": DOUBLE, "bias_error": DOUBLE},
            [*self.residuals] if self.subject.run is None else [],
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
            Fact("worst", self.worst if told and not self.lost else None, "fewest digits"),
            Fact("worst_time", self.worst_time if told else None, "where they are"),
            Fact("worst_part", self.worst_part if told else None, "of what they are"),
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
        if self.drift is not None:
            for name, value in self.drift._asdict().items():
                facts.append(Fact(f"drift_{name}", value, "of a first integral, relative"))
        return [*facts, provenance_fact(against.scene.provenance())]

    def __str__(self) -> str:
        """The verdict: the digits at a few times, the fewest of all, what makes them more."""
        if not self.digits and not self._others:
            return "\n".join([self._nothing, *self._unread])
        lines = [*self._digits(self._worst.row), self.verdict, *self._why, *self._unread]
        return "\n".join([*self._other_start, *lines])

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
            [*self._digits(None), self.verdict] if self.digits or self._others else [self._nothing]
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
        if self.drift is not None:
            lines.append(f"drift {self.drift}")
        if self.subject.projected and self.subject.run is not None:
            lines.append(f"projected {self.subject.run.projection}")
        return "\n".join([*self._other_start, *lines, *self._unread])

    @cached_property
    def _other_start(self) -> list[str]:
        """That a table of which nothing is right begins elsewhere, which is to be said first."""
        subject = self.subject
        if subject.run is not None or not (self.digits or self._others) or self.worst >= LAST:
            return []
        told = "" if self.readings or self.causes else other_start(subject, self.reference.scene)
        return [f"{subject.name}: {told}"] if told else []

    def _digits(self, worst: int | None) -> list[str]:
        """The table of the digits, see :func:`polhode.judging.report_text.table`."""
        number = self.subject.number
        return table(self.times, self.digits, self.expected, number, self._others, worst)

    @property
    def _why(self) -> list[str]:
        """Where parts leave the motion, and what would make them right."""
        told = [f"{name}: {where}" for name, where in self.departures.items()]
        if self.parts.get("attitude", _ROUGH) < _ROUGH:
            told.append(self._rotation)
        if (self.limit or self.attitude_limit) in _NOISES:
            told.append(residual_text(self.residuals))
        why = [*map(str, self.readings), *map(str, self.causes)]
        if not why and self._leaves_its_start:
            why = [OWN_EQUATIONS.format(scene=self.reference.scene.name)]
        return [*told, *why]

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
        parts = {*self._halves, *self._judged_parts}
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
        return self.subject.run is None and self.limit.startswith("method")

    @property
    def _meaning(self) -> str:
        """What the digits of the state mean."""
        if self.causes:
            return EXPLAINED
        if not self.limit:
            return ELSEWHERE if self.offers else WRONG_AT_ONCE
        told = meaning(self.limit, self.subject.number, self._is_foreign)
        if self.chance is not None and self.chance > RARE:
            told += BY_CHANCE.format(runs=1 / self.chance)
        return told

    @property
    def _meaning_alone(self) -> list[str]:
        """What the fewest digits mean where there is no state: of an attitude its limit."""
        if self.worst < LAST and self.attitude_limit not in _NOISES:
            return [WRONG_AT_ONCE]
        if self.worst_part != "attitude" or self.offers:
            return []
        name, number = self.attitude_limit, self.subject.number
        return [meaning(name, number, self.subject.run is None and name.startswith("method"))]

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
        told = f"{self.worst:.2f} correct digits at worst (t = {brief(self.worst_time)})"
        if self.rows_judged < len(self.times):
            told += f" of {self.rows_judged} rows judged of {len(self.times)}"
        if self.worst_part != STATE_PART:
            told += f", of {self.worst_part}"
            if not self.digits:
                return ", ".join([told, *self._meaning_alone]) + read
            time = brief(self.times[self._lowest])
            told += f"; of the state {self.state_worst:.2f} (t = {time})"
        return f"{told}, {self._meaning}{read}"

    def __repr__(self) -> str:
        try:
            told = f"worst {self.worst:.2f} correct digits at t = {brief(self.worst_time)}"
            told += f", limited by {self.limit}" if self.limit else ""
            told += f", {self._without_numbers}" if self.gaps else ""
            told += f", read as {self.reading}" if self.reading else ""
        except BadInput:
            told = self._nothing
        return f"<Judgement of {self.subject.name} against {self.reference.kind}: {told}>"

"""A judgement: how many digits of a subject are right, what limits them, and how it reads."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from polhode.common.cached_property import cached_property
from polhode.common.errors import BadInput
from polhode.common.progress import Progress
from polhode.common.result import Result
from polhode.common.text_tables import few
from polhode.common.value_semantics import ByValue
from polhode.equations.integrals import Drift
from polhode.judging.conditioning.conditioning import Conditioning, conditioning
from polhode.judging.conditioning.lyapunov import Lyapunov, lyapunov
from polhode.judging.conditioning.rounding_errors import Band
from polhode.judging.diagnosis.causes import Cause, causes
from polhode.judging.diagnosis.departure import Departure, departure
from polhode.judging.diagnosis.error_budget import (
    BEYOND_ROUNDING,
    LAST,
    between,
    chance,
    is_lost,
    is_thin,
    limit,
    selected,
)
from polhode.judging.diagnosis.time_rounding import explained, reading
from polhode.judging.references.reference import AnyReference, by_sign
from polhode.judging.score.part_digits import PartDigits, RowDigits, fewest
from polhode.judging.score.report_text import SHOWN, table, together
from polhode.judging.score.score import HeldAgainst
from polhode.judging.tables.candidate import Subject, of_table
from polhode.judging.tables.reading import TURNS, WRONG, Reading
from polhode.judging.tables.table import Table
from polhode.numbers.conversion import exactly, to_double
from polhode.numbers.decimals import brief
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import DIGITS_HELD
from polhode.taylor.backend import engine

RARE = 1e-4  # a share of runs of which nobody judges so many
FOLLOWED = 400  # times at which what rounding does to the motion is followed
MOTION_STEPS = 100_000  # a moment's work on whether the motion is chaotic

STATE_PART = "state"  # omega and gamma together


class _Worst(NamedTuple):
    """The fewest digits, the part that has them, and its first such row."""

    digits: float
    part: str
    row: int


@dataclass(frozen=True, eq=False, repr=False)
class Judgement(Result, ByValue):
    """Correct digits of a run or a table at each of its times, and what limits them.

    ``subject``: what was judged.  ``reference``: what it was judged against.  ``known``: the
    conditioning at the scene's times, if it is known already.  ``progress``: called with the
    reference's rows where they are many.
    ``as_it_stands``: whether no other convention is tried.  ``offered``: those that are told and
    not applied, if they are known already.
    ``digits[k]`` belongs to ``times[k]``: -log10 of the larger of the error of omega over the
    largest |omega| of the reference at these times, and the error of gamma, in the scene's body
    axes.  ``worst``: the fewest of these and of those of every other part that was judged.
    Printed, it is the answer of ``polhode compare``.

    >>> import polhode
    >>> found = polhode.compare(polhode.integrate("euler/separatrix", at=[1, 20]))
    >>> 12.5 < found.worst < 14.5, found.worst_time, found.limit
    (True, Fraction(20, 1), 'conditioning')
    """

    subject: Subject
    reference: AnyReference
    known: Conditioning | None = field(default=None, compare=False)
    progress: Progress | None = field(default=None, compare=False)
    as_it_stands: bool = False
    offered: tuple[Reading, ...] | None = field(default=None, compare=False)

    def __getstate__(self) -> dict[str, object]:
        """Without what is told of progress: nobody waits for it elsewhere."""
        return super().__getstate__() | {"progress": None}

    @property
    def times(self) -> tuple[Fraction, ...]:
        """The times judged."""
        return self.subject.times

    @cached_property
    def _held(self) -> HeldAgainst:
        return HeldAgainst(self.subject, self.reference, self.progress)

    @property
    def digits(self) -> RowDigits:
        """Correct digits of the state at each time, None where no number of it is there; empty
        where none is at any time."""
        return self._held.digits

    @property
    def rows_judged(self) -> int:
        """How many rows were judged: all, or some of very many where a row of the closed form costs
        milliseconds."""
        selected = self._held.selected
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
        """Digits of what is no column of the state, as it is read."""
        found = {k: part for k, part in self._held.parts.items() if isinstance(part, PartDigits)}
        strict = not self._may_turn
        return {
            name: part.digits if strict or not part.is_turned else part.turned or ()
            for name, part in found.items()
        }

    @property
    def _may_turn(self) -> bool:
        """Whether angles may be right up to whole turns: unless told to judge them as they are."""
        return not self.as_it_stands or any(x.part == "angles" for x in self.subject.readings)

    @property
    def _turns(self) -> tuple[Reading, ...]:
        """That psi and phi are read up to whole turns, where they are."""
        angles = self._held.parts.get("angles")
        if not self._may_turn or not isinstance(angles, PartDigits) or not angles.is_turned:
            return ()
        if any(one.convention == TURNS for one in self.subject.readings):
            return ()
        both = angles.digits, angles.turned
        before, now = (fewest(d or (), self.subject.held) for d in both)
        return (Reading("angles", before, TURNS, now),)

    @property
    def reading(self) -> str | None:
        """The convention that was applied, None where the numbers are judged as they stand."""
        told = [*dict.fromkeys(f"{r.part} {r.convention}" for r in self.subject.readings)]
        return "; ".join([*told, *(one.convention for one in self._turns)]) or None

    @property
    def part_digits(self) -> dict[str, RowDigits]:
        """Correct digits of each part at each time, None where it has no value there.

        omega, gamma; angles and attitude, by absolute error; derived columns, by errors relative
        to their largest value.
        """
        return self._held.halves | self._others

    @cached_property
    def departures(self) -> dict[str, Departure]:
        """Parts that leave the motion: right until one time, wrong from the next one on."""
        found = {
            name: departure(self.times, digits, lambda: self._followed_digits)
            for name, digits in self.part_digits.items()
        }
        return {name: where for name, where in found.items() if where is not None}

    @property
    def _lowest(self) -> int:
        """The first row at which the digits of the state are fewest."""
        return self.digits.index(self.state_worst)

    @property
    def asked(self) -> int | None:
        """The digits that the run was asked for, None where none were."""
        return None if self.subject.run is None else self.subject.run.digits

    @property
    def reached(self) -> bool | None:
        """Whether the digits asked for were reached; None where none were asked for."""
        return None if self.asked is None else self.state_worst >= self.asked

    @cached_property
    def conditionings(self) -> tuple[Conditioning, ...]:
        """Kappa at the times judged: from t = 0 ahead, and from t = 0 back."""
        if self.known is not None:
            return (self.known,)
        if not engine.installed:
            return ()
        scene, number = self.reference.scene, self.subject.number
        count = len(self.times)
        kept = {*range(count)}
        if count > FOLLOWED:
            kept = {*few(count, FOLLOWED), *few(count, SHOWN)}
            kept |= {self._lowest} if self.digits else set()
        times = [self.times[k] for k in sorted(kept)]
        return tuple(conditioning(scene, part, number) for part in by_sign(times))

    @cached_property
    def expected(self) -> tuple[Band | None, ...]:
        """The digits of runs that round once a step of the subject's type; None where unknown.

        Followed at ``FOLLOWED`` times or so; of more times, linear between those.

        Of a projected run those that projection leaves; see :func:`polhode.conditioning`.
        """
        return self._followed_digits if self.digits else ()

    @cached_property
    def _followed_digits(self) -> tuple[Band | None, ...]:
        """Those of ``expected``, also where no column of the state is there."""
        return self._told(lambda known: known.expected(self.subject.number, self._every))

    @cached_property
    def inputs(self) -> tuple[float | None, ...]:
        """The digits that rounding the scene's numbers to the subject's type leaves.

        Of a projected run those that are left where projection has taken its part away.
        """
        if not self.digits:
            return ()
        return self._told(lambda known: known.inputs(self.subject.number, self._every))

    @cached_property
    def amplification(self) -> tuple[float | None, ...]:
        """What a change of the state on the way is multiplied by at most; None where unknown.

        Of more times than are followed the logarithm is linear between those; inf beyond doubles.
        """
        if not self.digits:
            return ()
        found = self._told(lambda known: known.log10_amplification)
        return tuple(None if x is None else 10.0**x if x < 308 else math.inf for x in found)

    @property
    def _every(self) -> int:
        """Steps between two projections of the run; 0 where there are none."""
        run = self.subject.run
        return 0 if run is None or run.projection is None else run.projection.every

    def _told(self, what: Callable[[Conditioning], tuple[Any, ...]]) -> tuple[Any, ...]:
        """What is known of the times judged."""
        if self.known is not None:
            return what(self.known)[: len(self.times)]
        if not self.conditionings:
            return (None,) * len(self.times)
        found: dict[Exact, Any] = {}
        for part in self.conditionings:
            found |= dict(zip(part.times, what(part), strict=True))
        return between(found, self.times)

    @property
    def lost_after(self) -> float | None:
        """The time after which kappa leaves no digits; None where it leaves some throughout."""
        after = [part.lost_after for part in self.conditionings if part.lost_after is not None]
        return min(after, key=abs, default=None)

    @property
    def lost(self) -> str:
        """That no digits are left, and after which time; empty where some are left throughout."""
        if not any(x is not None and x < LAST for x in self.digits):
            return ""  # what was to be expected need not be known, which is dear
        gone = any(map(is_lost, self.digits, self.expected))
        return next((part.lost for part in self.conditionings if gone and part.lost), "")

    @cached_property
    def motion(self) -> Lyapunov | None:
        """Whether the scene's motion is regular or chaotic, from a limited number of steps; None
        where heyoka is not installed."""
        if not engine.installed:
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
        blamed = self.subject.run is None and found.startswith("method")
        return "" if blamed and (self.state_worst < LAST or self.offers) else found

    @cached_property
    def _limit(self) -> str:
        about, agreement, worst = self.subject, self.reference.agreement, self.state_worst
        if about.printed is not None and worst >= about.printed - 1:
            return "rounding (of the printed digits)"
        held, steps = min(about.held, about.number.most_digits), about.steps
        cheap = limit(worst, held, None, None, agreement, steps)
        if cheap in ("rounding", "reference"):  # needs nothing of the motion
            return cheap
        at, times = self._lowest, self.rows_judged
        known, inputs = self.known, self.inputs[at]
        expected = known.band(at, about.number, self._every) if known else self.expected[at]
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
        count = len(self.times)
        kept = [k for k in {*few(count, FOLLOWED), self._lowest} if None not in about.states[k]]
        if kept and len(about.columns) == len(scene.columns):
            states = [about.states[k] for k in kept]
        else:
            kept = [self._lowest]
            states = self.reference.at([self.times[k] for k in kept], DIGITS_HELD["double"])
        worst = selected(count)
        return explained(
            scene,
            np.array([[to_double(exactly(x)) for x in row] for row in states]),
            [about.time_errors[k] for k in kept],
            [about.held if (d := digits[k]) is None else d for k in kept],
            [about.held if (e := self.expected[k]) is None else e.least - worst for k in kept],
        )

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
    def parts(self) -> dict[str, float]:
        """The fewest correct digits over all times of angles, attitude and derived columns."""
        return {name: fewest(found, self.subject.held) for name, found in self._others.items()}

    @property
    def drift(self) -> Drift | None:
        """Drift of the integrals; None where it says nothing, see ``notes``."""
        return self._drift if isinstance(self._drift, Drift) else None

    @property
    def notes(self) -> tuple[str, ...]:
        """What was not judged, and why."""
        unjudged = self._unjudged
        if isinstance(self._drift, str):
            unjudged.append(f"drift of the integrals was not judged: {self._drift}")
        if not engine.installed:
            unjudged.append("what limits the digits was not computed: heyoka is not installed")
        return (*self.subject.notes, *unjudged)

    @property
    def _unjudged(self) -> list[str]:
        """Rows, and parts beside the state, that were not judged, and why."""
        parts, selected = self._held.parts, self._held.selected
        unjudged = [] if selected is None else [selected.note(len(self.times))]
        unjudged += [
            f"{name} {'were' if name == 'angles' else 'was'} not judged: {found}"
            for name, found in parts.items()
            if isinstance(found, str)
        ]
        angles = parts.get("angles")
        if isinstance(angles, PartDigits) and angles.uncounted:
            unjudged.append("whole turns of psi and phi: the closed form did not count them so far")
        return unjudged

    @property
    def readings(self) -> tuple[Reading, ...]:
        """Conventions in which parts of a table that is wrong as it stands are right: those that
        were applied, and those in which parts still wrong would be."""
        known = (*self.subject.readings, *self._turns)
        read = {one.part for one in known}
        return (*known, *(one for one in self.offers if one.part not in read))

    @cached_property
    def offers(self) -> tuple[Reading, ...]:
        """Those that are not applied, of a table."""
        from polhode.judging.diagnosis.conventions import readings

        source = self.subject.source
        if self.as_it_stands or not isinstance(source, Table):
            return ()
        wrong = {name for name, digits in self.parts.items() if digits < WRONG}
        if self.digits and self.state_worst < WRONG:
            wrong |= {"omega", "gamma"}
        if wrong and self.offered is not None:
            return self.offered
        if wrong or not self.digits:
            return tuple(readings(self.subject, self.reference, wrong)) if wrong else ()
        at, worst, scene = self._lowest, self.state_worst, self.reference.scene

        def judged(table: Table) -> float:
            return Judgement(of_table(table, scene), self.reference).state_worst

        found = reading(source, scene, at, worst, 10.0**-worst, judged)
        return () if found is None else (found,)

    @cached_property
    def causes(self) -> tuple[Cause, ...]:
        """Numbers of which one, if it were another, would make a table right that is not: constants
        of the body, the start, a clock; the best first, fitted, and changed nowhere."""
        source, digits = self.subject.source, self.digits
        if not isinstance(source, Table) or not digits or self.offers:
            return ()
        if self.state_worst >= LAST and not self.limit.startswith("method"):
            return ()
        return causes(self.subject, self.reference.scene)

    def __str__(self) -> str:
        against, others = self.reference, self._others
        how = f", proven to {self.agreement:.1f} digits"
        if against.is_closed_form:
            proven = "proven" if against.proven is True else against.proven
            how = f", {proven}" if proven else ""
        elif math.isnan(self.agreement):
            how = ""
        scene = f"{against.scene.name} ({against.regime})"
        lines = [f"{self.subject.name} against {against.kind} of {scene}{how}"]
        if self.digits or others:
            number = self.subject.number
            lines += table(self.times, self.digits, self.expected, number, others)
            lines.append(self._headline)
        if self.motion is not None:
            lines.append(f"motion {self.motion}")
        told = {name: [f"{digits:.2f} correct digits"] for name, digits in self.parts.items()}
        for name, where in self.departures.items():
            told.setdefault(name, []).append(str(where))
        lines += [f"{name}: {'; '.join(texts)}" for name, texts in told.items()]
        lines += [str(reading) for reading in self.readings]
        lines += [str(cause) for cause in self.causes]
        if self.drift is not None:
            lines.append(f"drift {self.drift}")
        if self.subject.projected and self.subject.run is not None:
            lines.append(f"projected {self.subject.run.projection}")
        lines += self.subject.remarks
        lines += [f"not judged: {note}" for note in together(self.notes)]
        return "\n".join(lines)

    @property
    def _is_foreign(self) -> bool:
        """Whether the limit is called a method of which nothing is known: that of a table."""
        return self.subject.run is None and self.limit.startswith("method")

    @property
    def _limit_in_words(self) -> str:
        """The limit as it is printed: of a table it may be anything but rounding."""
        return BEYOND_ROUNDING if self._is_foreign else self.limit

    @property
    def _unlimited(self) -> str:
        """Why no limit is named."""
        if self.offers:
            return "no limit is named, since another convention gives more digits"
        return "wrong in the first digit, so no limit is named"

    @property
    def _headline(self) -> str:
        """The fewest digits of all, and what limits those of the state."""
        read = f"; read as {self.reading}" if self.reading else ""
        limited = f"limited by {self._limit_in_words}" if self.limit else self._unlimited
        if self.causes:
            limited = "no limit is named, since another number explains the error"
        elif self.chance is not None and self.chance > RARE:
            limited += f", or by chance: one run in {1 / self.chance:.0f} has so few digits"
        limited += read
        if self.digits and self.lost:
            return f"{self.lost}; {limited}"
        worst = f"worst {self.worst:.2f} correct digits at t = {brief(self.worst_time)}"
        if self.rows_judged < len(self.times):
            worst += f" (of {self.rows_judged} rows judged of {len(self.times)})"
        if self.worst_part == STATE_PART:
            return f"{worst}; {limited}"
        worst += f", of {self.worst_part}"
        if not self.digits:
            return worst + read
        time = brief(self.times[self._lowest])
        return f"{worst}; of the state {self.state_worst:.2f} at t = {time}, {limited}"

    def __repr__(self) -> str:
        try:
            told = f"worst {self.worst:.2f} correct digits at t = {brief(self.worst_time)}"
            told += f", limited by {self._limit_in_words}" if self.limit else ""
            told += f", read as {self.reading}" if self.reading else ""
        except BadInput:
            told = "nothing was judged"
        return f"<Judgement of {self.subject.name} against {self.reference.kind}: {told}>"

    @cached_property
    def _drift(self) -> Drift | str:
        return self.subject.drift(self.reference.scene, self._held.bits)

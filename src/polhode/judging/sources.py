"""What a reference has its rows from: a closed form, a proven enclosure, a textbook's formulas."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, TypeVar

from polhode.closed_forms.families import ClosedForm, closed_form
from polhode.closed_forms.kovalevskaya.place import DEGENERATE, ONE_FREQUENCY
from polhode.common.errors import BadInput, ConstantZero
from polhode.common.interrupts import Progress
from polhode.motion.outcomes import Outcome
from polhode.numbers import exact
from polhode.numbers.conversion import exactly, to_double
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact, Irrational
from polhode.numbers.mpmath_context import mpmath, ordinary
from polhode.numbers.number_types import DOUBLE, EXTENDED, MOST_ASKED, QUAD, NumberType, Real, Row
from polhode.scenes.body import kind_of_body
from polhode.scenes.scene import Event, Scene

if TYPE_CHECKING:
    from polhode.enclosures.result import Enclosure

SAVED_DIGITS = 30  # of a reference that is saved as it is
ROUGH = 53  # bits in which a closed form plans; it computes with more

T = TypeVar("T")


class NoAnswer(BadInput):
    """That a reference has no answer to a question that another one may answer."""


class ProofTooLong(BadInput):
    """That a proof would take longer than it may."""


class Source:
    """What gives the rows of a scene's motion.

    ``backend``: its word in :func:`polhode.reference`; ``kind``: which closed form, or "certified";
    ``regime``: the kind of motion.  ``agreement``: the accuracy in digits; inf where no rounding
    enters that the digits asked for would show.  ``has_attitude``: whether it has more than states;
    ``encloses_attitude``: whether attitude and angles are proven by an enclosure.  ``is_dear``:
    whether of a table of very many rows only some are judged.
    """

    backend: ClassVar[str]
    is_closed_form: ClassVar[bool] = True
    has_attitude: ClassVar[bool] = True
    agreement: float = math.inf
    encloses_attitude = False
    is_dear = False

    def __init__(self, scene: Scene, kind: str, regime: str) -> None:
        self.scene, self.kind, self.regime = scene, kind, regime

    @property
    def most_digits(self) -> int:
        """How many digits may be asked for."""
        return MOST_ASKED

    @property
    def proven(self) -> bool | str:
        """Whether every digit given so far is proven, or what that rests on besides."""
        return True

    def rows(self, word: str, times: Sequence[Exact], digits: int) -> list[list[Any]]:
        """Rows of the state ("at"), "attitude" or "angles"; raises BadInput, NoAnswer."""
        raise NotImplementedError

    def answer(self, question: Callable[[ClosedForm], T]) -> T | None:
        """What a closed form tells of its motion; None where there is none."""
        del question
        return None

    @property
    def proof(self) -> Enclosure | None:
        """What is saved of it, where that is a proof."""
        return None


# --- enclosure ------------------------------------------------------------------------------------


class ProofLimits(NamedTuple):
    """What is called during each proof as by :func:`polhode.certify`, and the most seconds of all
    proofs of a source together, from its making on."""

    progress: Progress | None = None
    forecast: Callable[[float], None] | None = None
    max_seconds: float | None = None


class EnclosureSource(Source):
    """Balls that contain the exact motion of any scene, and their midpoints.

    ``agreement`` holds the digits proven for the last request of states, at its worst time; if
    states were never asked for, of the last attitude or angles.
    """

    backend = "certified"
    is_closed_form = False
    encloses_attitude = True

    def __init__(self, scene: Scene, limits: ProofLimits) -> None:
        super().__init__(scene, "certified", kind_of_body(scene.body))
        self._limits, self._began = limits, time.monotonic()
        self.agreement, self._has_states = math.nan, False
        self._proofs: list[tuple[tuple[str, ...], list[Exact], Enclosure]] = []

    @property
    def most_digits(self) -> int:
        """As many as may be proven."""
        from polhode.enclosures.task import MOST_DIGITS  # a closed form needs no enclosure

        return MOST_DIGITS

    @property
    def proof(self) -> Enclosure:
        """The enclosure at the times of the scene, to 30 digits."""
        return self._enclosure(self.scene.outputs, self.scene.times, SAVED_DIGITS)

    def rows(self, word: str, times: Sequence[Exact], digits: int) -> list[list[Any]]:
        """Midpoints, proven to so many digits."""
        if word != "at" and self.scene.gamma is None:
            raise BadInput(self.scene.name, "start.gamma", None, "a unit vector, for an attitude")
        enclosure = self._enclosure(() if word == "at" else (word,), times, digits)
        if word == "at":
            self.agreement, self._has_states = enclosure.proven, True
            return [[*row] for row in enclosure.midpoints]
        part = enclosure.attitude if word == "attitude" else enclosure.angles
        assert part is not None
        if not self._has_states:
            self.agreement = min(part.digits)
        if word == "angles":
            self._refuse_lost(enclosure)
        return part.midpoints(enclosure.noise + 128)

    def _enclosure(
        self, outputs: tuple[str, ...], times: Sequence[Exact], digits: int
    ) -> Enclosure:
        """The balls; what was proven to as many digits at the same times is not proven again."""
        from polhode.enclosures.certify import certify  # a closed form needs no heyoka

        for words, instants, earlier in self._proofs:
            if words == outputs and instants == [*times] and earlier.asked >= digits:
                return earlier
        scene, limits = replace(self.scene, outputs=outputs), self._limits
        if limits.max_seconds is not None:
            left = limits.max_seconds + self._began - time.monotonic()
            limits = limits._replace(max_seconds=max(1e-3, left))
        enclosure = certify(scene, times, digits=digits, **limits._asdict())
        if enclosure.outcome is Outcome.TIME_LIMIT:
            last = shown(max(times, key=abs))
            expected = f"seconds in which the motion is proven to t = {last}, or earlier times"
            raise ProofTooLong(scene.name, "max_seconds", self._limits.max_seconds, expected)
        if not enclosure.outcome.done:
            raise KeyboardInterrupt
        self._proofs.append((outputs, [*times], enclosure))
        return enclosure

    def _refuse_lost(self, enclosure: Enclosure) -> None:
        """Raise NoAnswer where psi and phi are lost, and the third axis does not stay vertical."""
        from polhode.equations.kinematics import departure

        assert enclosure.angles is not None
        pairs = zip(enclosure.angles.centres, enclosure.times, strict=True)
        if not any(row[0] is None and t != 0 for row, t in pairs):
            return
        if self.scene.starts_at_pole and departure(self.scene) is None:
            return
        since = ", ".join(f"{t:.6g}" for t in enclosure.lost)
        expected = f"a motion that keeps away from the poles: psi and phi are lost at t = {since}"
        raise NoAnswer(self.scene.name, "angles", None, expected)


# --- textbook -------------------------------------------------------------------------------------
#
# Euler's and Lagrange's tops by Jacobi's functions and Legendre's third integral, generic motions
# of Kovalevskaya's by Abel's sums.  The digits are those that two working precisions agree on.


FAMILIES = ("euler", "lagrange", "kovalevskaya")
_SPECIAL = (*DEGENERATE, *ONE_FREQUENCY)  # of Kovalevskaya's: two branch points are equal


class TextbookSource(Source):
    """The state of a classical top as a textbook has it, computed by mpmath alone.

    Raises BadInput for a scene of another family, and for a motion that the formulas do not have.
    """

    backend = "mpmath"
    has_attitude = False

    def __init__(self, scene: Scene) -> None:
        fitting = closed_form(scene, scene.reference if scene.reference in FAMILIES else "auto")
        if fitting is None or fitting[0] not in FAMILIES:
            kind = "no family" if fitting is None else fitting[0]
            expected = f"{', '.join(FAMILIES[:-1])} or {FAMILIES[-1]}, for backend mpmath"
            raise BadInput(scene.name, "reference", kind, expected)
        super().__init__(scene, fitting[0], fitting[1].regime)
        if self.kind == "kovalevskaya" and self.regime in _SPECIAL:
            expected = "a generic motion, for backend mpmath"
            raise BadInput(scene.name, "reference", self.regime, expected)

    @property
    def proven(self) -> bool | str:
        """That the digits are reproduced, and no more."""
        return False

    def rows(self, word: str, times: Sequence[Exact], digits: int) -> list[list[Any]]:
        """Rows of the state, to digits that repeat themselves."""
        from polhode.closed_forms import textbook

        if word != "at":
            raise BadInput(self.scene.name, "outputs", word, "none: mpmath has states alone")
        try:
            with mpmath.workprec(ROUGH):
                rows: list[list[Real]] = ordinary(
                    textbook.states(self.scene, self.kind, self.regime, times, digits)
                )
                return rows
        except (ValueError, ArithmeticError, mpmath.NoConvergence) as fault:
            why = str(fault) or "they divide by 0 or do not converge"
            expected = f"a motion that mpmath's functions reach ({why})"
            raise BadInput(self.scene.name, "reference", self.regime, expected) from None


# --- closed form ----------------------------------------------------------------------------------


_FORETOLD_SECONDS, _MOST_SECONDS = 60, 300  # of an enclosure where there is no other attitude
_MOST_SHOWN = 3  # numbers that are called 0 by the rule
_TURNING = (
    (DOUBLE, 1e5),
    (EXTENDED, 1e4),
    (QUAD, 3e3),
)  # runs that tell turns; radians, some seconds
_NEAR = 0.01  # radians between the angles of a motion and of a run that follows it
# a run's side of a pole is the motion's where it keeps away by so many of its errors of theta, and
# of its eps
_ERRORS, _ROUNDINGS = 1e3, 1e6
_MOST_PASSAGES = 500  # that are looked at, whether they are exactly through a pole
_PASSAGE_DIGITS, _PASSED, _NEWTON = 56, 45, 7  # digits, those of a distance of 0, steps


class ClosedFormSource(Source):
    """A closed form in balls, in the scene's body axes and units."""

    backend = "flint"

    def __init__(self, scene: Scene, kind: str, motion: ClosedForm) -> None:
        super().__init__(scene, kind, motion.regime)
        self.motion, self.is_dear = motion, motion.place.is_dear
        self.encloses_attitude = not motion.place.has_attitude

    @property
    def proven(self) -> bool | str:
        """Whether every digit given so far is proven."""
        how, zero = self.motion.place.proven, self.motion.assumed
        if not how or not zero:
            return how
        bounds = [*dict.fromkeys(map(_shown, zero))]  # of several numbers one may be the same
        numbers = ", ".join(bounds[:_MOST_SHOWN])
        if (more := len(bounds) - _MOST_SHOWN) > 0:
            numbers += f" and {more} more"
        condition = f"if these numbers are 0: {numbers}"
        return f"{how}; {condition}" if isinstance(how, str) else condition

    def rows(self, word: str, times: Sequence[Exact], digits: int) -> list[list[Any]]:
        """Rows right to so many digits."""
        if word == "at":
            return self.answer(lambda motion: motion.at(times, digits))
        if self.encloses_attitude and any(map(exact.sign, times)):
            return self._enclosed(word, times, digits)
        if word == "attitude":
            return self.answer(lambda motion: motion.attitude(times, digits))
        return self._angles(times, digits)

    def answer(self, question: Callable[[ClosedForm], T]) -> T:
        """What the closed form tells of its motion; raises NoAnswer where it has no answer."""
        try:
            with mpmath.workprec(ROUGH):  # one question at a time; each sets what it needs
                return ordinary(question(self.motion))
        except BadInput:
            raise
        except (ValueError, ArithmeticError) as fault:
            expected = f"a question that this closed form answers ({fault})"
            raise NoAnswer(self.scene.name, "reference", self.kind, expected) from None

    def _enclosed(self, word: str, times: Sequence[Exact], digits: int) -> list[list[Any]]:
        """Attitude or angles by a proof, where the closed form has the state alone."""

        def foretold(seconds: float) -> None:
            if seconds > _FORETOLD_SECONDS:
                expected = (
                    f"times that take at most {_FORETOLD_SECONDS} s (these take about "
                    f"{seconds:.0f} s), or reference.kind = certified"
                )
                raise BadInput(self.scene.name, "t", None, expected)

        proof = EnclosureSource(self.scene, ProofLimits(None, foretold, _MOST_SECONDS))
        try:
            return proof.rows(word, times, digits)
        except BadInput as fault:  # past a pole there is no answer here, but the attitude is one
            key = "reference" if isinstance(fault, NoAnswer) else fault.key
            expected = f"{fault.expected}: {self.kind} has the state alone, {word} is enclosed"
            raise type(fault)(fault.source, key, fault.value, expected) from None

    def _angles(self, times: Sequence[Exact], digits: int) -> list[list[Any]]:
        """psi and phi of the attitude, in the turns that a run tells."""
        if self.scene.gamma is None:
            return self.answer(lambda motion: motion.angles(times, digits))  # which says why not
        plain = replace(self.scene, form="principal")  # other forms are singular at times
        passages: list[Fraction] | None = None
        for number, farthest in _TURNING:
            run = _turning_run(plain, times, number, farthest)
            if run is None:
                continue
            near = [[x if x is None else float(x) for x in row] for row in run.angles]
            rows = self.answer(partial(ClosedForm.angles, times=times, digits=digits, near=near))
            if all(map(_is_near, rows, near)):
                passages = run.passages(rows)
                if not passages:
                    return rows
        if passages and len(passages) <= _MOST_PASSAGES and all(map(self._is_through, passages)):
            return rows
        last = shown(max(times, key=abs))
        expected = (
            "a question that this closed form answers (how often psi and phi went round to "
            f"t = {last} is not known: ask for the attitude)"
        )
        raise NoAnswer(self.scene.name, "reference", self.kind, expected)

    def _is_through(self, time: Fraction) -> bool:
        """Whether the third axis is vertical, exactly for all that can be told, near a time."""
        for _ in range(_NEWTON):  # for the least distance from the pole: gamma' = gamma x w
            row = self.rows("at", [_FINE.rounded(time)], _PASSAGE_DIGITS)[0]
            p, q, r, *gamma = (exactly(x) for x in row)
            if max(map(abs, gamma[:2])) < Fraction(1, 10**_PASSED):
                return True
            across = gamma[1] * r - gamma[2] * q, gamma[2] * p - gamma[0] * r
            square = across[0] ** 2 + across[1] ** 2
            if not square:
                return False
            time = _FINE.rounded(time - (gamma[0] * across[0] + gamma[1] * across[1]) / square)
        return False


def _shown(x: Irrational) -> str:
    """A number that is called 0 by the rule, by the bound of it that is known."""
    top = x.enclosure(exact.EQUAL_BITS).abs_upper()
    return f"|x| < 1e{math.ceil(float(top.log()) / math.log(10))}" if top > 0 else "0"


def _is_near(row: Sequence[Real | None], about: Sequence[float | None]) -> bool:
    """Whether angles are about those of a run, psi and phi in their turns too, if they are any."""
    pairs = zip(row, about, strict=True)
    return None in row or all(
        x is not None and y is not None and abs(float(x) - y) < _NEAR for x, y in pairs
    )


# --- runs beside it -------------------------------------------------------------------------------


FARTHEST = 1e6  # radians, to which the steps of a run do not go
_FINE = NumberType("mp", 192)  # of times at which a run is asked


class TurningRun(NamedTuple):
    """A run that tells how often psi and phi went round: at the times asked for, and its poles.

    ``extremes``: times at which theta is extreme, and how far the third axis is from the vertical
    there, as a sine; ``eps``: of its numbers.
    """

    angles: list[Row]
    extremes: list[tuple[Fraction, float]]
    eps: float

    def passages(self, rows: Sequence[Sequence[Real | None]]) -> list[Fraction]:
        """Times at which it passes a pole so near that rounding may have chosen the side.

        ``rows``: the true angles at the times asked for.
        """
        pairs = [(x, y) for (_, x, _), (_, y, _) in zip(rows, self.angles, strict=True)]
        errors = [abs(float(x) - float(y)) for x, y in pairs if x is not None and y is not None]
        clear = max(_ERRORS * max(errors, default=0.0), _ROUNDINGS * self.eps)
        return [t for t, sine in self.extremes if not sine > clear]


def _turning_run(
    scene: Scene, times: Sequence[Exact], number: NumberType, farthest: float
) -> TurningRun | None:
    """The run in a number type; None where it does not come so far."""
    try:
        rows = in_double(scene, times, ("angles",), number, farthest, (Event("nutation"),))
    except ConstantZero:  # theta stays what it is at the start
        rows = in_double(scene, times, ("angles",), number, farthest)
    if not rows:
        return None
    extremes = [(t, math.hypot(*map(float, row[3:5]))) for t, row in rows["events"]]
    if not scene.starts_at_pole:
        extremes.append((Fraction(0), math.hypot(*map(to_double, scene.start[3:5]))))
    return TurningRun(rows["angles"], extremes, float(number.eps))


def in_double(
    scene: Scene,
    times: Sequence[Exact],
    outputs: tuple[str, ...],
    number: NumberType = DOUBLE,
    farthest: float = FARTHEST,
    events: tuple[Event, ...] = (),
) -> dict[str, list[Any]]:
    """Rows of a run at times of either sign in any order: states, and outputs that are integrated.

    By "events" the times and states of all events, of both senses of time.

    Nothing where it does not come so far.  ``number``: the type in which it is integrated;
    ``farthest``: radians, to which it is.  Raises ConstantZero for an event that is zero all along,
    and ImportError where heyoka is not installed.
    """
    if max((abs(to_double(t)) for t in times), default=0.0) * 10.0**scene.log10_rate > farthest:
        return {}
    from polhode.runs.trajectory import solve

    plain = replace(scene, outputs=outputs, events=events)
    met: list[tuple[Fraction, Any]] = []
    instants = [t if isinstance(t, Fraction) else _FINE.rounded(t) for t in times]
    by_time: dict[str, dict[Fraction, Any]] = {word: {} for word in ("states", *outputs)}
    try:
        for part in by_sign(instants):
            run = solve(plain.at(part), number, interruptible=False)
            if len(run.times) < len(part):
                return {}
            for word, rows in by_time.items():
                rows |= zip(part, getattr(run, word), strict=True)
            for event in run.events:
                if not event.complete:
                    return {}
                met += zip(event.times, event.states, strict=True)
    except ConstantZero:
        raise
    except (BadInput, ValueError, OverflowError):
        return {}
    return {word: [rows[t] for t in instants] for word, rows in by_time.items()} | {"events": met}


def by_sign(times: Sequence[Fraction]) -> list[list[Fraction]]:
    """The different times from 0 ahead, and those from 0 back, each in order; none empty."""
    different = dict.fromkeys(times)  # in the order given, which is nearly always sorted
    ahead, behind = ([t for t in different if s * t.numerator > 0] for s in (1, -1))
    if 0 in different:
        (ahead if ahead or not behind else behind).append(Fraction(0))
    return [part for part in (sorted(ahead), sorted(behind, reverse=True)) if part]

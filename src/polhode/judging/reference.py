"""The reference of a scene: its closed form, a proven enclosure, or a textbook's formulas.

All answer the same questions; ``kind`` says which it is, and nothing else is called exact.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, TypeVar

from polhode.closed_forms.families import ClosedForm, closed_form, misfit
from polhode.closed_forms.kovalevskaya.place import DEGENERATE, ONE_FREQUENCY
from polhode.common.arguments import each, whole, with_progress
from polhode.common.errors import BadInput, nearest
from polhode.common.interrupts import Progress
from polhode.equations.columns import derived
from polhode.equations.kinematics import Hodographs, departure
from polhode.judging.auxiliary_runs import FINE, turning_run
from polhode.judging.reference_table import (
    ReferenceTable,
    bounds,
    held_times,
    number_of,
    right_rows,
)
from polhode.motion.outcomes import Outcome
from polhode.numbers import exact, number_types
from polhode.numbers.conversion import TIME, exactly, reader, to_double
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact, Irrational
from polhode.numbers.mpmath_context import mpmath, ordinary
from polhode.numbers.number_types import DOUBLE, EXTENDED, MOST_ASKED, QUAD, AnyNumber, Real
from polhode.results.result import Result, Storable
from polhode.results.table import Content
from polhode.scenes import library
from polhode.scenes.body import kind_of_body
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import COLUMNS, REQUESTS

if TYPE_CHECKING:
    from polhode.enclosures.result import Enclosure
    from polhode.numbers.double_double import Pairs

BACKENDS = ("flint", "mpmath", "certified")
MAX_LOG10_ANGLE = 100
SAVED_DIGITS = 30  # of a reference that is saved as it is
ROUGH = 53  # bits in which a closed form plans; it computes with more
_LEAST, _MOST = 1e-250, 1e250  # sizes of w of which two doubles hold all digits

T = TypeVar("T")


class NoAnswer(BadInput):
    """That a reference has no answer to a question that another one may answer."""


class ProofTooLong(BadInput):
    """That a proof would take longer than it may."""


class Reference(Storable):
    """What is true of a scene's motion: its closed form, or a proven enclosure.

    ``kind``: which closed form, or "certified"; ``regime``: the kind of motion.  Answers are in the
    scene's body axes and units, at ``times`` that are ints, Fractions, floats, mpf or decimal
    strings, taken exactly.  A question to which there is no answer raises BadInput; of numbers that
    a closed form alone can tell, an enclosure tells None.

    ``agreement``: the accuracy in digits: inf of a closed form; of an enclosure the digits proven
    for the last request, at its worst time, nan before the first.  ``backend``: its word
    in :func:`polhode.reference`.  ``encloses_attitude``: whether attitude and angles are proven by
    an enclosure.  ``is_dear``: whether of a table of very many rows only some are judged.

    >>> import polhode
    >>> exact = polhode.reference("euler/largest-axis")
    >>> print(exact.at([1], digits=20)[0][0])  # p at t = 1, an mpf
    0.447808688218415
    """

    __hash__ = None  # type: ignore[assignment]

    backend: ClassVar[str]
    is_closed_form: ClassVar[bool] = True
    agreement = math.inf
    encloses_attitude = False
    is_dear = False

    def __init__(self, scene: Scene, kind: str, regime: str) -> None:
        self.scene, self.kind, self.regime = scene, kind, regime

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Reference):
            return NotImplemented
        mine, its = ((x.backend, x.kind, x.scene) for x in (self, other))
        return mine == its

    def __reduce__(self) -> tuple[object, ...]:
        return reference, (self.scene, self.backend)  # what was computed is computed again

    def __repr__(self) -> str:
        return f"<Reference of {self.scene.name}: {self.kind}, {self.regime}>"

    @property
    def kind_of_file(self) -> str:
        """The kind of :meth:`result`."""
        return "ReferenceTable" if self.is_closed_form else "Enclosure"

    def result(self) -> Result:
        """What a file of it holds: rows at the times of the scene, to 30 digits, or the proof."""
        return self.tabulated(SAVED_DIGITS, self.scene.outputs)

    def content(self) -> Content:
        """That of :meth:`result`."""
        return self.result().content()

    @property
    def most_digits(self) -> int:
        """How many digits may be asked for."""
        return MOST_ASKED

    @property
    def proven(self) -> bool | str:
        """Whether every digit given so far is proven: by a theorem, exact decisions and balls.

        False where the digits are only reproduced, with more bits; a text where the proof rests on
        something more, such as the numbers that are called 0 by the rule for irrational ones.
        """
        return True

    def at(self, times: Iterable[AnyNumber], digits: int = 50) -> list[list[Real]]:
        """Rows p q r [gamma1 gamma2 gamma3] as mpf, right to ``digits`` digits."""
        return self._rows("at", times, digits)

    def attitude(self, times: Iterable[AnyNumber], digits: int = 50) -> list[list[Real]]:
        """Rows q0 q1 q2 q3: the quaternion body to space, scalar first, continuous from q0 >= 0."""
        return self._rows("attitude", times, digits)

    def angles(self, times: Iterable[AnyNumber], digits: int = 50) -> list[list[Real | None]]:
        """Rows psi theta phi in radians, continuous; None where a pole leaves them undefined.

        psi and phi are those of the attitude, right to ``digits`` digits.  How often they went
        round is told of a closed form by a run in double, or in more digits where that one ends at
        a pole, leaves the motion or passes a pole so near that rounding may have chosen the side;
        past a passage exactly through a pole either branch is right.  Of an enclosure turns are
        followed in doubles.  Raises BadInput where that does not decide.
        """
        return self._rows("angles", times, digits)

    def column(
        self, word: str, times: Iterable[AnyNumber], digits: int = 50
    ) -> list[list[Real | None]]:
        """Rows of an output by its word, such as "angles"; of hodographs omega in space.

        What is derived is the same formula as a run's, of the state to ``digits`` digits and of
        other rows to one more, in more precision than either.  Raises BadInput.
        """
        if word not in COLUMNS:
            raise BadInput(self.scene.name, "outputs", word, nearest(word, [*COLUMNS]))
        times = _times(self.scene, times)
        if COLUMNS[word].how == "integrated":
            return self._rows(word, times, digits)
        parts = [
            self.at(times, digits) if need == "state" else self._rows(need, times, digits + 1)
            for need in COLUMNS[word].needs
        ]
        rows = derived(word, self.scene, parts, number_types.mp(digits + 1))
        return [list(row) for row in rows]

    def hodographs(self, times: Iterable[AnyNumber], digits: int = 50) -> Hodographs:
        """Rows of omega in the body and in space, right to ``digits`` digits of the largest |w|."""
        times = _times(self.scene, times)
        space = self.column("hodographs", times, digits)
        return Hodographs([row[:3] for row in self.at(times, digits)], space)

    def pairs(self, word: str, times: Sequence[Exact], digits: int) -> Pairs | None:
        """Many rows of ``word``, "at" or "attitude", each number the sum of two doubles.

        Right to ``digits`` digits, at most :data:`polhode.numbers.double_double.DIGITS`; None of
        what has no such rows, or whose omega is too large or too small for them.
        """
        _refuse_far(self.scene, times)
        attitude = word == "attitude"
        pairs = self._answer(lambda motion: motion.pairs(times, digits, attitude=attitude))
        if pairs is None or attitude:
            return pairs
        return pairs if _LEAST < abs(pairs.hi[:, :3]).max(initial=0.0) < _MOST else None

    def error(self, times: Iterable[AnyNumber], digits: int = 50) -> Real:
        """A bound of the error of :meth:`at`, of w over its largest modulus, or of gamma.

        It is an estimate where the digits are only reproduced.
        """
        instants, digits = self._question(times, digits)
        bound: Real | None = self._answer(lambda motion: motion.error(digits, instants))
        if bound is not None:
            return bound
        self._rows_at("at", instants, digits)  # which are proven to so many
        own: Real = ordinary(mpmath.mpf(10) ** -digits)
        return own

    def radii(self, times: Iterable[AnyNumber], digits: int = 50) -> list[list[Real]] | None:
        """Proven bounds of the errors of :meth:`at` of a closed form, number by number.

        None where it is only reproduced.

        >>> import polhode
        >>> (row,) = polhode.reference("euler/largest-axis").radii([1], digits=20)
        >>> max(row) < 1e-20
        True
        """
        instants, digits = self._question(times, digits)
        return self._answer(lambda motion: motion.radii(instants, digits))

    @property
    def conditions(self) -> tuple[str, ...]:
        """The conditions on body and start that hold exactly, of a family that names them."""
        return self._answer(lambda motion: motion.place.held) or ()

    @property
    def curve(self) -> dict[str, object] | None:
        """The algebraic curve of a Kovalevskaya top: H, K2, its roots e and period matrix tau."""
        return self._answer(lambda motion: motion.curve(50))

    @property
    def approach(self) -> Real | None:
        """The rate at which a motion of Hess's tends to a periodic one; None where it does not."""
        return self._answer(lambda motion: motion.approach(50))

    @property
    def period(self) -> Real | None:
        """The least period of omega in the body, to 50 digits; None where none is known.

        Of a Lagrange top that nutates, omega does not return when theta does:
        ``frequencies["nutation"]`` is the rate of theta.

        >>> import polhode
        >>> polhode.reference("lagrange/nutation").period is None
        True
        >>> exact = polhode.reference("lagrange/planar-librating")
        >>> print(round(exact.period * exact.frequencies["nutation"] / 6.283185307179586, 9))
        2.0
        """
        return self._answer(lambda motion: motion.period(50))

    @property
    def frequencies(self) -> dict[str, Real]:
        """The motion's frequencies by name, radians per unit of time, to 50 digits."""
        return self._answer(lambda motion: motion.frequencies(50)) or {}

    @property
    def rates_of(self) -> dict[str, str]:
        """Of which axis about which a frequency is, by its name, where the name leaves it open.

        >>> import polhode
        >>> polhode.reference("euler/attitude").rates_of["precession"]
        'of principal axis 3 (of the largest moment) about the angular momentum'
        """
        rates = self._answer(lambda motion: motion.place.rates_of) or {}
        frequencies = self.frequencies if rates else {}
        return {name: words for name, words in rates.items() if name in frequencies}

    def _rows(self, word: str, times: Iterable[AnyNumber], digits: int) -> list[list[Any]]:
        instants, digits = self._question(times, digits)
        return self._rows_at(word, instants, digits) if instants else []

    def _question(self, times: Iterable[AnyNumber], digits: int) -> tuple[list[Exact], int]:
        """Times and digits of a question; raises BadInput."""
        digits = whole(self.scene.name, "digits", digits, 1, self.most_digits)
        return _times(self.scene, times), digits

    def tabulated(self, digits: int, outputs: Sequence[str] = ()) -> ReferenceTable:
        """Its rows at the times of its scene, each number to so many digits of its own."""
        scene = self.scene
        digits = whole(scene.name, "digits", digits, 1, number_types.MAX_DIGITS)
        printed = number_of(digits).printed_digits
        times = held_times(scene, scene.times, digits)
        words = [word for word in COLUMNS if word in outputs]
        columns = {word: right_rows(partial(self.column, word), times, printed) for word in words}
        states, radii = right_rows(self.at, times, printed), self.radii(times, printed)
        return ReferenceTable(
            scene,
            self.kind,
            self.regime,
            digits,
            tuple(times),
            states,
            None if radii is None else bounds(states, radii, printed),
            columns,
            self.proven,
            scene.provenance(),
        )

    def _rows_at(self, word: str, times: Sequence[Exact], digits: int) -> list[list[Any]]:
        """Rows of the state ("at"), "attitude" or "angles"; raises BadInput, NoAnswer."""
        raise NotImplementedError

    def _answer(self, question: Callable[[ClosedForm], T]) -> T | None:
        """What a closed form tells of its motion; None where there is none."""
        del question
        return None


# --- enclosure ------------------------------------------------------------------------------------


class ProofLimits(NamedTuple):
    """What is called during each proof as by :func:`polhode.certify`, and the most seconds of all
    proofs of a source together, from its making on."""

    progress: Progress | None = None
    forecast: Callable[[float], None] | None = None
    max_seconds: float | None = None


class EnclosureReference(Reference):
    """Balls that contain the exact motion of any scene, and their midpoints.

    ``agreement`` holds the digits proven for the last request, at its worst time.
    """

    backend = "certified"
    is_closed_form = False
    encloses_attitude = True

    @property
    def most_digits(self) -> int:
        """As many as may be proven."""
        from polhode.enclosures.task import MOST_DIGITS  # a closed form needs no enclosure

        return MOST_DIGITS

    def __init__(self, scene: Scene, limits: ProofLimits) -> None:
        super().__init__(scene, "certified", kind_of_body(scene.body))
        self._limits, self._began = limits, time.monotonic()
        self.agreement = math.nan
        self._proofs: list[tuple[tuple[str, ...], list[Exact], Enclosure]] = []

    def result(self) -> Enclosure:
        """The enclosure at the times of the scene, to 30 digits."""
        return self._enclosure(self.scene.outputs, self.scene.times, SAVED_DIGITS)

    def _rows_at(self, word: str, times: Sequence[Exact], digits: int) -> list[list[Any]]:
        """Midpoints, proven to so many digits."""
        if word != "at" and self.scene.gamma is None:
            raise BadInput(self.scene.name, "start.gamma", None, "a unit vector, for an attitude")
        enclosure = self._enclosure(() if word == "at" else (word,), times, digits)
        if word == "at":
            self.agreement = enclosure.proven
            return [[*row] for row in enclosure.midpoints]
        part = enclosure.attitude if word == "attitude" else enclosure.angles
        assert part is not None
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


class TextbookReference(Reference):
    """The state of a classical top as a textbook has it, computed by mpmath alone.

    Raises BadInput for a scene of another family, and for a motion that the formulas do not have.
    """

    backend = "mpmath"

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

    def result(self) -> Result:
        """What a file of it holds: it has states alone."""
        return self.tabulated(SAVED_DIGITS)

    def _rows_at(self, word: str, times: Sequence[Exact], digits: int) -> list[list[Any]]:
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
_MOST_PASSAGES = 500  # that are looked at, whether they are exactly through a pole
_PASSAGE_DIGITS, _PASSED, _NEWTON = 56, 45, 7  # digits, those of a distance of 0, steps


class ClosedFormReference(Reference):
    """A closed form in balls, in the scene's body axes and units."""

    backend = "flint"

    def __init__(self, scene: Scene, kind: str, motion: ClosedForm) -> None:
        super().__init__(scene, kind, motion.regime)
        self._motion, self.is_dear = motion, motion.place.is_dear
        self.encloses_attitude = not motion.place.has_attitude

    @property
    def proven(self) -> bool | str:
        """Whether every digit given so far is proven."""
        how, zero = self._motion.place.proven, self._motion.assumed
        if not how or not zero:
            return how
        bounds = [*dict.fromkeys(map(_shown, zero))]  # of several numbers one may be the same
        numbers = ", ".join(bounds[:_MOST_SHOWN])
        if (more := len(bounds) - _MOST_SHOWN) > 0:
            numbers += f" and {more} more"
        condition = f"if these numbers are 0: {numbers}"
        return f"{how}; {condition}" if isinstance(how, str) else condition

    def _rows_at(self, word: str, times: Sequence[Exact], digits: int) -> list[list[Any]]:
        """Rows right to so many digits."""
        if word == "at":
            return self._answer(lambda motion: motion.at(times, digits))
        if self.encloses_attitude and any(map(exact.sign, times)):
            return self._enclosed(word, times, digits)
        if word == "attitude":
            return self._answer(lambda motion: motion.attitude(times, digits))
        return self._angles(times, digits)

    def _answer(self, question: Callable[[ClosedForm], T]) -> T:
        """What the closed form tells of its motion; raises NoAnswer where it has no answer."""
        try:
            with mpmath.workprec(ROUGH):  # one question at a time; each sets what it needs
                return ordinary(question(self._motion))
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

        proof = EnclosureReference(self.scene, ProofLimits(None, foretold, _MOST_SECONDS))
        try:
            return proof._rows_at(word, times, digits)
        except BadInput as fault:  # past a pole there is no answer here, but the attitude is one
            key = "reference" if isinstance(fault, NoAnswer) else fault.key
            expected = f"{fault.expected}: {self.kind} has the state alone, {word} is enclosed"
            raise type(fault)(fault.source, key, fault.value, expected) from None

    def _angles(self, times: Sequence[Exact], digits: int) -> list[list[Any]]:
        """psi and phi of the attitude, in the turns that a run tells."""
        if self.scene.gamma is None:
            return self._answer(lambda motion: motion.angles(times, digits))  # which says why not
        plain = replace(self.scene, form="principal")  # other forms are singular at times
        passages: list[Fraction] | None = None
        for number, farthest in _TURNING:
            run = turning_run(plain, times, number, farthest)
            if run is None:
                continue
            near = [[x if x is None else float(x) for x in row] for row in run.angles]
            rows = self._answer(partial(ClosedForm.angles, times=times, digits=digits, near=near))
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
            row = self._rows_at("at", [FINE.rounded(time)], _PASSAGE_DIGITS)[0]
            p, q, r, *gamma = (exactly(x) for x in row)
            if max(map(abs, gamma[:2])) < Fraction(1, 10**_PASSED):
                return True
            across = gamma[1] * r - gamma[2] * q, gamma[2] * p - gamma[0] * r
            square = across[0] ** 2 + across[1] ** 2
            if not square:
                return False
            time = FINE.rounded(time - (gamma[0] * across[0] + gamma[1] * across[1]) / square)
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


# --- by scene -------------------------------------------------------------------------------------


@with_progress
def reference(
    scene: Scene | str | Path,
    backend: str = "flint",
    *,
    progress: Progress | None = None,
    forecast: Callable[[float], None] | None = None,
    max_seconds: float | None = None,
) -> Reference:
    """Give the reference of a scene: the closed form that fits, else a proven enclosure.

    If the scene's ``reference`` names one, it is that one.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, a path, or the name of a case.
    backend : {"flint", "mpmath", "certified"}
        ``"mpmath"``: of the three classical tops, by mpmath's own functions in a textbook's
        formulas, which share nothing with the closed forms in balls; states alone.
        ``"certified"``: a proven enclosure, whether there is a closed form or not.
    progress, forecast : callable, optional
        Called during each proof of an enclosure, as by :func:`polhode.certify`.
    max_seconds : float, optional
        A limit on all of its proofs together, from now on.  These three are not those of an
        attitude that is enclosed beside a closed form, which has limits of its own.

    Returns
    -------
    Reference
        It gives the state p q r [gamma1 gamma2 gamma3] in the scene's body axes, to the digits
        wanted, at any time.

    Raises
    ------
    BadInput
        A scene that asks for a closed form that does not fit: the condition, and by how much.
        Another backend, or a family that it does not have.

    Examples
    --------
    >>> import polhode
    >>> polhode.reference("euler/separatrix")
    <Reference of euler/separatrix: euler, separatrix>
    >>> body = polhode.Body.of_moments((3, 2, 1.5), (1, 1, 0), 1)
    >>> proven = polhode.reference(polhode.Scene(body, (1, 0, 0), (0, 0, 1)))
    >>> proven
    <Reference of scene: certified, heavy asymmetric body>
    >>> rows = proven.at([1], digits=20)
    >>> 20 <= proven.agreement < 30
    True
    """
    scene = library.load(scene, takes=REQUESTS)
    if backend not in BACKENDS:
        raise BadInput(scene.name, "backend", backend, " or ".join(BACKENDS))
    if backend == "mpmath":
        return TextbookReference(scene)
    fitting = None
    if "certified" not in (backend, scene.reference):
        with mpmath.workprec(ROUGH):
            fitting = closed_form(scene, scene.reference)
        if fitting is None and scene.reference != "auto":
            fit = closed_form(scene)
            fits = f"{fit[0] if fit else 'certified'}, which fits body and start"
            if (why := misfit(scene, scene.reference)) is not None:
                fits += f"; {scene.reference} needs {why}"
            raise BadInput(scene.name, "reference.kind", scene.reference, fits)
    if fitting is not None:
        return ClosedFormReference(scene, *fitting)
    return EnclosureReference(scene, ProofLimits(progress, forecast, max_seconds))


def reference_table(
    scene: Scene | str | Path,
    at: Iterable[AnyNumber] | None = None,
    digits: int = 50,
    outputs: Iterable[str] | None = None,
    backend: str = "flint",
) -> ReferenceTable:
    """Tabulate the closed form of a scene, every printed digit right; no integration.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, a path, or the name of a case.
    at : iterable of numbers, optional
        The times, in the scene's unit; the scene's own by default.
    digits : int
        Correct digits of each number.
    outputs : iterable of str, optional
        Words of what is tabulated beside the state; the scene's own by default.
    backend : {"flint", "mpmath"}
        As of :func:`polhode.reference`; mpmath has states alone.

    Returns
    -------
    ReferenceTable
        The rows, with proven bounds of the errors where the closed form has them.

    Raises
    ------
    BadInput
        A scene without a closed form, or times or outputs that it does not have.

    Examples
    --------
    >>> import polhode
    >>> found = polhode.reference_table("lagrange/nutation", at=["1/3"], digits=30)
    >>> found.fact("reference"), found.fact("proven")
    ('lagrange', True)
    """
    scene = library.load(scene, takes=REQUESTS)
    if outputs is not None:
        scene = replace(scene, outputs=tuple(outputs))
    if at is not None:
        scene = scene.at(at)
    if not len(scene.times):
        raise BadInput(scene.name, "run.end", None, "a time, or times given")
    if backend == "mpmath" and outputs is None:
        scene = replace(scene, outputs=())  # it has states alone
    truth = reference(scene, backend)
    if not truth.is_closed_form:
        expected = "a scene with a closed form, or polhode.certify"
        raise BadInput(scene.name, "reference", truth.regime, expected)
    return truth.tabulated(digits, scene.outputs)


def _times(scene: Scene, times: Iterable[AnyNumber]) -> list[Exact]:
    """Times taken exactly; raises BadInput for those that are too far."""
    instants = [*each(scene.name, "t", times, reader(scene.units, TIME), "a list of times")]
    _refuse_far(scene, instants)
    return instants


def _refuse_far(scene: Scene, times: Sequence[Exact]) -> None:
    """Raise BadInput for times beyond 10**100 radians, where digits cost more each."""
    far = exact.log10(max(times, key=lambda t: abs(to_double(t)), default=exact.ZERO))
    if scene.log10_rate + far > MAX_LOG10_ANGLE:
        expected = f"at most 10**{MAX_LOG10_ANGLE} radians turned"
        raise BadInput(scene.name, "t", f"10**{far:.0f}", expected)

"""The reference of a scene: its closed form, or a proven enclosure.

Both answer the same questions; ``kind`` says which it is, and nothing else is called exact.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias, TypeVar, overload

from polhode.closed_forms.families import ClosedForm, closed_form, misfit
from polhode.common.arguments import each, whole
from polhode.common.errors import BadInput, ConstantZero, nearest
from polhode.equations.columns import derived
from polhode.equations.kinematics import Hodographs
from polhode.judging.certified import Certified, NoAnswer
from polhode.judging.reference_rows import ReferenceTable, tabulated
from polhode.numbers import exact, number_types
from polhode.numbers.conversion import TIME, exactly, reader, to_double
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact, Irrational
from polhode.numbers.mpmath_context import mpmath, ordinary
from polhode.numbers.number_types import DOUBLE, EXTENDED, QUAD, AnyNumber, NumberType, Real, Row
from polhode.results.result import Storable
from polhode.results.table import Content
from polhode.scenes import library
from polhode.scenes.scene import Event, Scene
from polhode.scenes.vocabulary import COLUMNS, REQUESTS

if TYPE_CHECKING:
    from polhode.judging.textbook import Textbook
    from polhode.numbers.double_double import Pairs


# --- derived --------------------------------------------------------------------------------------
#
# Columns of a reference, those that are derived too.


#: A reference's answer to a question by its name: rows at times, to so many digits.
Asked = Callable[[str], Callable[..., list[list[Real | None]]]]


def column_of(
    ask: Asked, scene: Scene, word: str, times: Iterable[AnyNumber], digits: int
) -> list[list[Real | None]]:
    """Rows of an output at the times; raises BadInput.

    A derived one is the formula of the reference's own rows: those of the state to so many digits,
    others to one more, and the formula to more than either.
    """
    if word not in COLUMNS:
        raise BadInput(scene.name, "outputs", word, nearest(word, [*COLUMNS]))
    times = list(times)
    if COLUMNS[word].how == "integrated":
        return ask(word)(times, digits)
    parts = [
        ask("at")(times, digits) if need == "state" else ask(need)(times, digits + 1)
        for need in COLUMNS[word].needs
    ]
    rows = derived(word, scene, parts, number_types.mp(digits + 1))
    return [list(row) for row in rows]


# --- reference table ------------------------------------------------------------------------------
#
# The closed form of a scene as a table: what ``polhode reference`` prints.


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
    source = reference(scene, backend)
    if isinstance(source, Certified):
        expected = "a scene with a closed form, or polhode.certify"
        raise BadInput(scene.name, "reference", source.regime, expected)
    return tabulated(source, digits)


# --- reference ------------------------------------------------------------------------------------


BACKENDS = ("flint", "mpmath")
MAX_LOG10_ANGLE = 100
_FORETOLD_SECONDS, _MOST_SECONDS = 60, 300  # of an enclosure where there is no other attitude
_MOST_SHOWN = 3  # numbers that are called 0 by the rule
FARTHEST = 1e6  # radians, to which the steps of a run do not go
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
_FINE = NumberType("mp", 192)  # of times at which a run is asked
ROUGH = 53  # bits in which a closed form plans; it computes with more


T = TypeVar("T")


class Reference(Storable):
    """The closed form of a scene.

    ``kind``: which closed form; ``regime``: the kind of motion.  Answers are in the scene's body
    axes and units.

    >>> import polhode
    >>> exact = polhode.reference("euler/largest-axis")
    >>> print(exact.at([1], digits=20)[0][0])  # p at t = 1, an mpf
    0.447808688218415
    """

    is_closed_form = True
    agreement = math.inf  # no rounding enters that the digits asked for would show
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, scene: Scene, kind: str, motion: ClosedForm) -> None:
        self.scene, self.kind, self._motion = scene, kind, motion
        self.regime = motion.regime

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Reference):
            return NotImplemented
        return self.kind == other.kind and self.scene == other.scene

    def __reduce__(self) -> tuple[object, ...]:
        return reference, (self.scene,)  # what was computed so far is computed again

    def __repr__(self) -> str:
        return f"<Reference of {self.scene.name}: {self.kind}, {self.regime}>"

    def content(self) -> Content:
        """Its rows at the times of the scene, to 30 digits."""
        return tabulated(self).content()

    def at(self, times: Iterable[AnyNumber], digits: int = 50) -> list[list[Real]]:
        """Rows p q r [gamma1 gamma2 gamma3] as mpf, right to ``digits`` digits.

        ``times``: ints, Fractions, floats, mpf or decimal strings, taken exactly.
        """
        return self._asked(self._motion.at, times, digits)

    def attitude(self, times: Iterable[AnyNumber], digits: int = 50) -> list[list[Real]]:
        """Rows q0 q1 q2 q3: the quaternion body to space, scalar first, continuous from q0 >= 0."""
        instants = _times(self.scene, times)
        if self._is_enclosed(instants):
            return self._enclosed("attitude", instants, digits)
        return self._asked(self._motion.attitude, instants, digits)

    def angles(self, times: Iterable[AnyNumber], digits: int = 50) -> list[list[Real | None]]:
        """Rows psi theta phi in radians, continuous; None where a pole leaves them undefined.

        psi and phi are those of the attitude, right to ``digits`` digits; how often they went round
        is told by a run in double, or in more digits where that one ends at a pole, leaves the
        motion or passes a pole so near that rounding may have chosen the side.  Past a passage
        exactly through a pole either branch is right.  Raises BadInput where no run decides.
        """
        instants = _times(self.scene, times)
        if self._is_enclosed(instants):
            return self._enclosed("angles", instants, digits)
        if self.scene.gamma is None:
            return self._asked(self._motion.angles, instants, digits)  # which says why not
        plain = replace(self.scene, form="principal")  # other forms are singular at times
        passages: list[Fraction] | None = None
        for number, farthest in _TURNING:
            run = _turning_run(plain, instants, number, farthest)
            if run is None:
                continue
            near = [[x if x is None else float(x) for x in row] for row in run.angles]
            rows = self._asked(partial(self._motion.angles, near=near), instants, digits)
            if all(map(_is_near, rows, near)):
                passages = run.passages(rows)
                if not passages:
                    return rows
        if passages and len(passages) <= _MOST_PASSAGES and all(map(self._is_through, passages)):
            return rows
        last = shown(max(instants, key=abs))
        expected = (
            "a question that this closed form answers (how often psi and phi went round to "
            f"t = {last} is not known: ask for the attitude)"
        )
        raise NoAnswer(self.scene.name, "reference", self.kind, expected)

    def _is_through(self, time: Fraction) -> bool:
        """Whether the third axis is vertical, exactly for all that can be told, near a time."""
        for _ in range(_NEWTON):  # for the least distance from the pole: gamma' = gamma x w
            row = self._asked(self._motion.at, [_FINE.rounded(time)], _PASSAGE_DIGITS)[0]
            p, q, r, *gamma = (exactly(x) for x in row)
            if max(map(abs, gamma[:2])) < Fraction(1, 10**_PASSED):
                return True
            across = gamma[1] * r - gamma[2] * q, gamma[2] * p - gamma[0] * r
            square = across[0] ** 2 + across[1] ** 2
            if not square:
                return False
            time = _FINE.rounded(time - (gamma[0] * across[0] + gamma[1] * across[1]) / square)
        return False

    def pairs(self, word: str, times: Sequence[Exact], digits: int) -> Pairs:
        """Many rows of ``word``, "at" or "attitude", each number the sum of two doubles.

        Right to ``digits`` digits, at most :data:`polhode.numbers.double_double.DIGITS`.
        """
        _refuse_far(self.scene, times)
        attitude = word == "attitude"
        return self._told(partial(self._motion.pairs, times, digits, attitude=attitude))

    def _is_enclosed(self, times: Sequence[Exact]) -> bool:
        """Whether the attitude at these times is enclosed: the closed form has the state alone."""
        return self.encloses_attitude and any(exact.sign(t) for t in times)

    def _enclosed(self, word: str, times: Sequence[Exact], digits: int) -> list[list[Any]]:
        """Attitude or angles by a proof, where the closed form has the state alone."""

        def foretold(seconds: float) -> None:
            if seconds > _FORETOLD_SECONDS:
                expected = (
                    f"times that take at most {_FORETOLD_SECONDS} s (these take about "
                    f"{seconds:.0f} s), or reference.kind = certified"
                )
                raise BadInput(self.scene.name, "t", None, expected)

        proof = Certified(self.scene, forecast=foretold, max_seconds=_MOST_SECONDS)
        try:
            rows: list[list[Any]] = getattr(proof, word)(times, digits)
        except NoAnswer as fault:  # past a pole: no answer here, but the attitude is one
            expected = f"{fault.expected}: {self.kind} has the state alone, {word} is enclosed"
            raise NoAnswer(fault.source, "reference", fault.value, expected) from None
        except BadInput as fault:
            expected = f"{fault.expected}: {self.kind} has the state alone, {word} is enclosed"
            raise type(fault)(fault.source, fault.key, fault.value, expected) from None
        return rows

    def column(
        self, word: str, times: Iterable[AnyNumber], digits: int = 50
    ) -> list[list[Real | None]]:
        """Rows of an output by its word, such as "angles"; of hodographs omega in space.

        What is derived is the same formula as a run's, of rows right to ``digits`` digits.
        """
        return column_of(partial(getattr, self), self.scene, word, times, digits)

    def hodographs(self, times: Iterable[AnyNumber], digits: int = 50) -> Hodographs:
        """Rows of omega in the body and in space, right to ``digits`` digits of the largest |w|."""
        times = _times(self.scene, times)
        rows, attitude = self.at(times, digits), self.attitude(times, digits + 1)
        space = derived("hodographs", self.scene, (rows, attitude), number_types.mp(digits + 1))
        return Hodographs([row[:3] for row in rows], space)

    def error(self, times: Iterable[AnyNumber], digits: int = 50) -> Real:
        """A bound of the error of :meth:`at`, of w over its largest modulus, or of gamma.

        It is an estimate where the closed form is only reproduced.
        """
        own: Real = self._asked(
            lambda exactly, places: self._motion.error(places, exactly), times, digits
        )
        return own

    def radii(self, times: Iterable[AnyNumber], digits: int = 50) -> list[list[Real]] | None:
        """Proven bounds of the errors of :meth:`at`, number by number.

        None where the closed form is only reproduced.

        >>> import polhode
        >>> (row,) = polhode.reference("euler/largest-axis").radii([1], digits=20)
        >>> max(row) < 1e-20
        True
        """
        return self._asked(self._motion.radii, times, digits)

    @property
    def proven(self) -> bool | str:
        """Whether every digit given so far is proven: by a theorem, exact decisions and balls.

        False where the digits are only reproduced, with more bits; a text where the proof rests on
        something more, such as the numbers that are called 0 by the rule for irrational ones.
        """
        how, zero = self._motion.place.proven, self._motion.assumed
        if not how or not zero:
            return how
        bounds = [*dict.fromkeys(map(_shown, zero))]  # of several numbers one may be the same
        numbers = ", ".join(bounds[:_MOST_SHOWN])
        if (more := len(bounds) - _MOST_SHOWN) > 0:
            numbers += f" and {more} more"
        condition = f"if these numbers are 0: {numbers}"
        return f"{how}; {condition}" if isinstance(how, str) else condition

    @property
    def encloses_attitude(self) -> bool:
        """Whether the closed form has the state alone: attitude and angles are then enclosed."""
        return not self._motion.place.has_attitude

    @property
    def is_dear(self) -> bool:
        """Whether a row costs so much that of a table of very many only some are judged."""
        return self._motion.place.is_dear

    @property
    def conditions(self) -> tuple[str, ...]:
        """The conditions on body and start that hold exactly, of a family that names them."""
        return self._motion.place.held

    @property
    def curve(self) -> dict[str, object] | None:
        """The algebraic curve of a Kovalevskaya top: H, K2, its roots e and period matrix tau."""
        return self._told(partial(self._motion.curve, 50))

    @property
    def approach(self) -> Real | None:
        """The rate at which a motion of Hess's tends to a periodic one; None where it does not."""
        return self._told(partial(self._motion.approach, 50))

    def _asked(
        self, question: Callable[[list[Exact], int], T], times: Iterable[AnyNumber], digits: int
    ) -> T:
        digits = whole(self.scene.name, "digits", digits, 1, number_types.MOST_ASKED)
        return self._told(partial(question, _times(self.scene, times), digits))

    def _told(self, answer: Callable[[], T]) -> T:
        """An answer of the closed form; raises BadInput where it has none."""
        try:
            with mpmath.workprec(ROUGH):  # one question at a time; each sets what it needs
                return ordinary(answer())
        except BadInput:
            raise
        except (ValueError, ArithmeticError) as fault:
            expected = f"a question that this closed form answers ({fault})"
            raise NoAnswer(self.scene.name, "reference", self.kind, expected) from None

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
        period: Real | None = self._told(partial(self._motion.period, 50))
        return period

    @property
    def frequencies(self) -> dict[str, Real]:
        """The motion's frequencies by name, radians per unit of time, to 50 digits."""
        frequencies: dict[str, Real] = self._told(partial(self._motion.frequencies, 50))
        return frequencies

    @property
    def rates_of(self) -> dict[str, str]:
        """Of which axis about which a frequency is, by its name, where the name leaves it open.

        >>> import polhode
        >>> polhode.reference("euler/attitude").rates_of["precession"]
        'of principal axis 3 (of the largest moment) about the angular momentum'
        """
        return {
            k: words for k, words in self._motion.place.rates_of.items() if k in self.frequencies
        }


#: Anything that a table or a run can be held against.
AnyReference: TypeAlias = Reference | Certified


@overload
def reference(
    scene: Scene | str | Path, backend: Literal["flint"] = "flint"
) -> Reference | Certified: ...


@overload
def reference(scene: Scene | str | Path, backend: str) -> Reference | Certified | Textbook: ...


def reference(
    scene: Scene | str | Path, backend: str = "flint"
) -> Reference | Certified | Textbook:
    """Give the reference of a scene: the closed form that fits, else a proven enclosure.

    If the scene's ``reference`` names one, it is that one.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, a path, or the name of a case.
    backend : {"flint", "mpmath"}
        ``"mpmath"``: of the three classical tops, by mpmath's own functions in a textbook's
        formulas, which share nothing with the closed forms in balls; states alone.

    Returns
    -------
    Reference, Certified or Textbook
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
    >>> polhode.reference(polhode.Scene(body, (1, 0, 0), (0, 0, 1)))
    <Certified of scene: heavy asymmetric body>
    """
    scene = library.load(scene, takes=REQUESTS)
    if backend not in BACKENDS:
        raise BadInput(scene.name, "backend", backend, " or ".join(BACKENDS))
    if backend == "mpmath":
        from polhode.judging.textbook import Textbook

        return Textbook(scene)
    if scene.reference == "certified":
        return Certified(scene)
    with mpmath.workprec(ROUGH):
        fitting = closed_form(scene, scene.reference)
    if fitting is not None:
        return Reference(scene, *fitting)
    if scene.reference != "auto":
        fit = closed_form(scene)
        fits = f"{fit[0] if fit else 'certified'}, which fits body and start"
        if (why := misfit(scene, scene.reference)) is not None:
            fits += f"; {scene.reference} needs {why}"
        raise BadInput(scene.name, "reference.kind", scene.reference, fits)
    return Certified(scene)


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
    from polhode.runs.solve import solve

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

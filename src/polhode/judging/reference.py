"""The reference of a scene: its closed form, a proven enclosure, or a textbook's formulas.

All answer the same questions; ``kind`` says which it is, and nothing else is called exact.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from polhode.closed_forms.families import closed_form, misfit
from polhode.common.arguments import each, whole, with_progress
from polhode.common.errors import BadInput, counted, nearest
from polhode.common.interrupts import Progress
from polhode.common.values import ByValue
from polhode.equations.columns import derived
from polhode.equations.kinematics import Hodographs
from polhode.judging.sources import (
    ROUGH,
    SAVED_DIGITS,
    ClosedFormSource,
    EnclosureSource,
    ProofLimits,
    Source,
    TextbookSource,
)
from polhode.numbers import exact, number_types
from polhode.numbers.conversion import TIME, reader, to_double
from polhode.numbers.decimals import is_decimal
from polhode.numbers.exact import Exact
from polhode.numbers.mpmath_context import mpmath, ordinary, own
from polhode.numbers.number_types import AnyNumber, Given, NumberType, Real, Scalar
from polhode.results.cells import EXACT, TEXT, digits_word
from polhode.results.result import Result, Storable
from polhode.results.table import Column, Content, Fact, Table
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import provenance_fact, row_columns, scene_facts, unit_of
from polhode.scenes.vocabulary import COLUMNS, REQUESTS

if TYPE_CHECKING:
    from polhode.numbers.double_double import Pairs

BACKENDS = ("flint", "mpmath", "certified")
MAX_LOG10_ANGLE = 100


class Reference(Storable):
    """What is true of a scene's motion: its closed form, or a proven enclosure.

    ``kind``: which closed form, or "certified"; ``regime``: the kind of motion.  Answers are in the
    scene's body axes and units, at ``times`` that are ints, Fractions, floats, mpf or decimal
    strings, taken exactly.  A question to which there is no answer raises BadInput; of numbers that
    a closed form alone can tell, an enclosure tells None.  ``source``: what gives the rows.

    >>> import polhode
    >>> exact = polhode.reference("euler/largest-axis")
    >>> print(exact.at([1], digits=20)[0][0])  # p at t = 1, an mpf
    0.447808688218415
    """

    __hash__ = None  # type: ignore[assignment]

    def __init__(self, scene: Scene, source: Source) -> None:
        self.scene, self.source = scene, source
        self.kind, self.regime = source.kind, source.regime
        self.is_closed_form, self.is_dear = source.is_closed_form, source.is_dear
        self.encloses_attitude = source.encloses_attitude

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Reference):
            return NotImplemented
        mine, its = ((x.source.backend, x.kind, x.scene) for x in (self, other))
        return mine == its

    def __reduce__(self) -> tuple[object, ...]:
        return reference, (self.scene, self.source.backend)  # what was computed is computed again

    def __repr__(self) -> str:
        return f"<Reference of {self.scene.name}: {self.kind}, {self.regime}>"

    @property
    def kind_of_file(self) -> str:
        """The kind of :meth:`result`."""
        return "ReferenceTable" if self.is_closed_form else "Enclosure"

    def result(self) -> Result:
        """What a file of it holds: rows at the times of the scene, to 30 digits, or the proof."""
        outputs = self.scene.outputs if self.source.has_attitude else ()
        return self.source.proof or tabulated(self, outputs=outputs)

    def content(self) -> Content:
        """That of :meth:`result`."""
        return self.result().content()

    def save(self, path: str | Path) -> None:
        """Write :meth:`result` to a file."""
        self.result().save(path)

    @property
    def agreement(self) -> float:
        """The accuracy in digits: inf of a closed form; of an enclosure the digits proven for the
        last request of states, at its worst time, nan before the first."""
        return self.source.agreement

    @property
    def proven(self) -> bool | str:
        """Whether every digit given so far is proven: by a theorem, exact decisions and balls.

        False where the digits are only reproduced, with more bits; a text where the proof rests on
        something more, such as the numbers that are called 0 by the rule for irrational ones.
        """
        return self.source.proven

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

        What is derived is the same formula as a run's, of rows right to ``digits`` digits.
        """
        return column_of(partial(getattr, self), self.scene, word, times, digits)

    def hodographs(self, times: Iterable[AnyNumber], digits: int = 50) -> Hodographs:
        """Rows of omega in the body and in space, right to ``digits`` digits of the largest |w|."""
        times = _times(self.scene, times)
        rows, attitude = self.at(times, digits), self.attitude(times, digits + 1)
        space = derived("hodographs", self.scene, (rows, attitude), number_types.mp(digits + 1))
        return Hodographs([row[:3] for row in rows], space)

    def pairs(self, word: str, times: Sequence[Exact], digits: int) -> Pairs | None:
        """Many rows of ``word``, "at" or "attitude", each number the sum of two doubles.

        Right to ``digits`` digits, at most :data:`polhode.numbers.double_double.DIGITS`; None of
        what has no such rows.
        """
        _refuse_far(self.scene, times)
        attitude = word == "attitude"
        return self.source.answer(lambda motion: motion.pairs(times, digits, attitude=attitude))

    def error(self, times: Iterable[AnyNumber], digits: int = 50) -> Real:
        """A bound of the error of :meth:`at`, of w over its largest modulus, or of gamma.

        It is an estimate where the digits are only reproduced.
        """
        instants, digits = self._question(times, digits)
        bound: Real | None = self.source.answer(lambda motion: motion.error(digits, instants))
        if bound is not None:
            return bound
        self.source.rows("at", instants, digits)  # which are proven to so many
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
        return self.source.answer(lambda motion: motion.radii(instants, digits))

    @property
    def conditions(self) -> tuple[str, ...]:
        """The conditions on body and start that hold exactly, of a family that names them."""
        return self.source.answer(lambda motion: motion.place.held) or ()

    @property
    def curve(self) -> dict[str, object] | None:
        """The algebraic curve of a Kovalevskaya top: H, K2, its roots e and period matrix tau."""
        return self.source.answer(lambda motion: motion.curve(50))

    @property
    def approach(self) -> Real | None:
        """The rate at which a motion of Hess's tends to a periodic one; None where it does not."""
        return self.source.answer(lambda motion: motion.approach(50))

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
        return self.source.answer(lambda motion: motion.period(50))

    @property
    def frequencies(self) -> dict[str, Real]:
        """The motion's frequencies by name, radians per unit of time, to 50 digits."""
        return self.source.answer(lambda motion: motion.frequencies(50)) or {}

    @property
    def rates_of(self) -> dict[str, str]:
        """Of which axis about which a frequency is, by its name, where the name leaves it open.

        >>> import polhode
        >>> polhode.reference("euler/attitude").rates_of["precession"]
        'of principal axis 3 (of the largest moment) about the angular momentum'
        """
        rates = self.source.answer(lambda motion: motion.place.rates_of) or {}
        frequencies = self.frequencies if rates else {}
        return {name: words for name, words in rates.items() if name in frequencies}

    def _rows(self, word: str, times: Iterable[AnyNumber], digits: int) -> list[list[Any]]:
        instants, digits = self._question(times, digits)
        return self.source.rows(word, instants, digits) if instants else []

    def _question(self, times: Iterable[AnyNumber], digits: int) -> tuple[list[Exact], int]:
        """Times and digits of a question; raises BadInput."""
        digits = whole(self.scene.name, "digits", digits, 1, self.source.most_digits)
        return _times(self.scene, times), digits


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
        return Reference(scene, TextbookSource(scene))
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
        return Reference(scene, ClosedFormSource(scene, *fitting))
    limits = ProofLimits(progress, forecast, max_seconds)
    return Reference(scene, EnclosureSource(scene, limits))


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


# --- columns and tables ---------------------------------------------------------------------------


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
    return tabulated(truth, digits, scene.outputs)


def tabulated(
    truth: Reference, digits: int = SAVED_DIGITS, outputs: Sequence[str] = ()
) -> ReferenceTable:
    """A closed form at the times of its scene."""
    scene = truth.scene
    digits = whole(scene.name, "digits", digits, 1, number_types.MAX_DIGITS)
    printed = number_of(digits).printed_digits
    times = held_times(scene, scene.times, digits)
    columns = {
        word: right_rows(partial(truth.column, word), times, printed)
        for word in COLUMNS
        if word in outputs
    }
    states, radii = right_rows(truth.at, times, printed), truth.radii(times, printed)
    return ReferenceTable(
        scene,
        truth.kind,
        truth.regime,
        digits,
        tuple(times),
        states,
        None if radii is None else bounds(states, radii, printed),
        columns,
        truth.proven,
        scene.provenance(),
    )


# --- rows -----------------------------------------------------------------------------------------
#
# Rows of a reference at given times: what a file or a terminal has of it, every digit right.
#
# A closed form answers to so many digits of the largest |w|, or of 1: a small component then has
# fewer digits of its own, and one that is zero may come out as a rounding error.  So it is asked
# for more, by what the smallest components lack; what has no digit in common at two precisions is
# zero.


_RADIUS_DIGITS = 3
_SPARE = 4  # digits beyond the last printed one: the last is then right to 0.5001 of its unit


@dataclass(frozen=True, eq=False, repr=False)
class ReferenceTable(Result, ByValue):
    """A reference at given times, each number to as many correct digits as were asked for.

    ``scene``: with these times and outputs.  ``kind``: which closed form; ``regime``: the kind of
    motion.  ``times``: decimals as they were asked for, others rounded where no digit notices.
    ``states``: rows p q r [gamma1 gamma2 gamma3] as mpf; ``radii``: proven bounds of the errors of
    these as they are printed, None where the digits are only reproduced.  ``outputs``: rows by the
    words of the scene's outputs.  ``proven``: as of the reference.

    >>> import polhode
    >>> found = polhode.reference_table("euler/largest-axis", at=[1], digits=20)
    >>> found.regime, found.digits
    ('polhode about the largest-moment axis', 20)
    >>> print(found.column("p")[0])
    0.447808688218415
    """

    scene: Scene
    kind: str
    regime: str
    digits: int
    times: tuple[Exact, ...]
    states: list[list[Real]]
    radii: list[list[Real]] | None
    outputs: Mapping[str, list[list[Real | None]]]
    proven: bool | str
    provenance: Mapping[str, object] = field(compare=False)

    @property
    def number(self) -> NumberType:
        """The number type whose decimals hold the digits."""
        return number_of(self.digits)

    def table(self) -> Table:
        """A row a time: the state and the outputs, and bounds of the state's errors."""
        printed = self.number.printed_digits
        word = digits_word(printed)
        columns = [Column("t", list(self.times), "time", unit_of(self.scene, "t"), EXACT, printed)]
        parts: list[tuple[Sequence[str], Given]] = [(self.scene.columns, self.states)]
        parts += [(COLUMNS[name].names, rows) for name, rows in self.outputs.items()]
        for names, rows in parts:
            of_part = row_columns(self.scene, names, rows, self.number, digits=printed)
            columns += [column._replace(type=word) for column in of_part]
        if self.radii is not None:
            bound = digits_word(_RADIUS_DIGITS)
            for k, name in enumerate(self.scene.columns):
                radii, unit = [row[k] for row in self.radii], unit_of(self.scene, name)
                columns.append(Column(f"{name}_radius", radii, "proven bound", unit, bound, 0))
        return Table(columns)

    def facts(self) -> list[Fact]:
        """Which reference, and whether its digits are proven."""
        assumed = self.proven if isinstance(self.proven, str) else None
        return [
            *scene_facts(self.scene),
            Fact("reference", self.kind, "which closed form"),
            Fact("regime", self.regime, "the kind of motion"),
            Fact("digits", self.digits, "correct digits asked for"),
            Fact("proven", self.proven is True, "whether every digit is"),
            Fact("assumed", assumed, "what a proof rests on besides", type=TEXT),
            provenance_fact(self.provenance),
        ]

    def __repr__(self) -> str:
        summary = f"{self.kind}, {self.regime}, {counted(len(self.times), 'time')}"
        return f"<ReferenceTable of {self.scene.name}: {summary}, {self.digits} digits>"


def held_times(scene: Scene, times: Sequence[Exact], digits: int) -> list[Exact]:
    """Times to be printed in full: decimals as they are, others rounded where no digit notices."""
    bits = number_types.bits_for(digits + 1)
    fine = NumberType("mp", 3 * bits + 64 + int(4 * scene.at(tuple(times)).log10_angle))
    return [t if is_decimal(t) else fine.rounded(t) for t in times]


def number_of(digits: int) -> NumberType:
    """The number type whose decimals hold so many digits."""
    return NumberType("mp", number_types.bits_for(digits + 1))


def bounds(
    rows: Sequence[Sequence[Real]], radii: Sequence[Sequence[Real]], printed: int
) -> list[list[Real]]:
    """Bounds of the errors of rows as they are printed, from those of the numbers."""
    pairs = zip(rows, radii, strict=True)
    return [[*map(partial(_bound, printed), row, radius)] for row, radius in pairs]


def _bound(printed: int, x: Real, radius: Real) -> Real:
    """A bound of the error of x as it is printed: one that may be rounded to three digits."""
    with mpmath.workprec(64):
        rounding = abs(own(x)) * 5 * mpmath.mpf(10) ** -printed
        bound = (own(radius) + rounding) * (1 + mpmath.mpf(2) ** -7)
        plain: Real = ordinary(bound)
        return plain


def right_rows(
    ask: Callable[[Sequence[Exact], int], list[list[Scalar]]], times: Sequence[Exact], printed: int
) -> list[list[Scalar]]:
    """The rows of a closed form at the times, each component to so many digits of its own.

    ``ask``: its question, of times and digits.  None in a row stays None.
    """
    digits = printed + _SPARE
    rows = ask(times, digits)
    lacking = _lacking(rows, digits)
    if not lacking:
        return rows
    finer = ask(times, digits + lacking)
    return [
        [_zero_or(x, y, digits) for x, y in zip(row, fine, strict=True)]
        for row, fine in zip(rows, finer, strict=True)
    ]


def _lacking(rows: list[list[Scalar]], digits: int) -> int:
    """The digits that the smallest component lacks, as far as twice the digits asked for."""
    sizes = [mpmath.mag(x) for row in rows for x in row if x]
    if not sizes:
        return 0
    bits = max(0, *sizes) - min(sizes)
    return min(2 * digits, int(bits * number_types.LOG10_2) + 1) if bits > 3 else 0


def _zero_or(coarse: Scalar, fine: Scalar, digits: int) -> Scalar:
    """The finer value; 0 where it is below what was asked for first and shares no digit with it."""
    if not fine or not coarse:
        return fine
    if mpmath.mag(coarse) >= -digits / number_types.LOG10_2 + 8:
        return fine
    with mpmath.workprec(53):
        alike = abs(own(coarse) - own(fine)) <= abs(own(fine)) / 2
    return fine if alike else ordinary(mpmath.mpf(0))

"""A scene: one body, one start, the output times. Exact, immutable, checked once.

Body axes O xyz, O the fixed point; omega = (p, q, r) and gamma, the upward vertical, in body
axes, as in Yehia, *Rigid Body Dynamics: A Lagrangian Approach*, chapter 3. The first integrals
are its (3.30): h = ½ w·I w + Mg r0·gamma, f = I w·gamma, |gamma|² = 1.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import InitVar, dataclass, field
from fractions import Fraction
from itertools import chain
from typing import Any, NamedTuple, TypeGuard

from polhode.common.arguments import each, numbers_given, of_kind
from polhode.common.errors import BadInput, counted, nearest, one_line, plain, say_change, say_doubt
from polhode.common.provenance import provenance
from polhode.common.values import cached_property, may_wait
from polhode.numbers import exact, expression
from polhode.numbers.conversion import TIME, ExactNumbers, derived_number, reader
from polhode.numbers.decimals import shown
from polhode.numbers.exact import ZERO, Exact, Irrational, sign
from polhode.numbers.expression import ExpressionError
from polhode.numbers.number_types import AnyNumber
from polhode.numbers.vectors import Vector, dot, scaled
from polhode.scenes import vocabulary
from polhode.scenes.body import Body, exact_vector, kind_of_body
from polhode.scenes.vocabulary import COLUMNS, FORMS, READY_MADE, SECTION, STATE, UNITS, check

# --- event ----------------------------------------------------------------------------------------
#
# An event of a scene: what vanishes, in which direction, and whether the run ends there.


class Event(NamedTuple):
    """An event: the zeros of an expression in p q r gamma1 gamma2 gamma3 t, in the scene's units.

    >>> from dataclasses import replace
    >>> import polhode
    >>> event = polhode.Event("level", "gamma3 - 1/2", "rising", stop=True)
    >>> scene = replace(polhode.load("lagrange/nutation"), events=(event,))
    >>> polhode.integrate(scene).outcome.value
    'stopped at event'

    ``zero``: the expression; empty for a name that is known, such as "nutation".  ``direction``:
    rising, falling or any, as t grows, in backward runs too.  ``stop``: the run ends at the first
    one.
    """

    name: str
    zero: str = ""
    direction: str = "any"
    stop: bool = False

    @property
    def table(self) -> dict[str, object]:
        """Its keys in a scene file; None for a zero that its name says."""
        return self._asdict() | {"zero": self.zero or None}

    @property
    def expression(self) -> str | None:
        """What vanishes, as text; None for w along the middle principal axis."""
        if self.zero:
            return self.zero
        if self.name.startswith(SECTION):
            return self.name.removeprefix(SECTION)
        return READY_MADE.get(self.name, "")

    @property
    def timed(self) -> bool:
        """Whether the time enters what vanishes."""
        return "t" in re.findall(r"\w+", self.expression or "")

    @property
    def needs_zero(self) -> bool:
        """Whether the name alone does not say what vanishes."""
        return self.name not in READY_MADE and not self.name.startswith(SECTION)

    def counts(self, slope: int) -> bool:
        """Whether a zero of that slope is one asked for; a grazing contact (0) always is."""
        return slope * vocabulary.DIRECTIONS[self.direction] >= 0


def check_event(event: Event, scene: str, key: str) -> None:
    """Refuse what no event can be; raises BadInput in the name of a scene and a key of it."""
    for word in ("name", "zero", "direction"):
        of_kind(scene, f"{key}.{word}", getattr(event, word), str, "text")
    if not event.name.isprintable():  # it is the name of a row, a column and a key
        raise BadInput(scene, f"{key}.name", event.name, "text of one line that can be printed")
    of_kind(scene, f"{key}.stop", event.stop, bool, "True or False")
    if event.direction not in vocabulary.DIRECTIONS:
        expected = nearest(event.direction, [*vocabulary.DIRECTIONS])
        raise BadInput(scene, f"{key}.direction", event.direction, expected)
    if event.expression is not None:
        names = (*STATE, "t")
        try:
            check(event.expression, names)
        except ValueError as fault:
            expected = f"an expression in {' '.join(names)} ({fault})"
            word = "zero" if event.zero or event.needs_zero else "name"
            raise BadInput(scene, f"{key}.{word}", event.expression, expected) from None


def middle_axis(scene: Scene) -> int:
    """The principal axis of the moment between the other two; raises BadInput."""
    moments = scene.body.moments
    order = sorted(range(3), key=lambda i: moments[i])
    if moments[order[0]] == moments[order[1]] or moments[order[1]] == moments[order[2]]:
        expected = "a body with three different moments"
        raise BadInput(scene.name, "events.name", vocabulary.FLIP, expected)
    return order[1]


# --- output times ---------------------------------------------------------------------------------
#
# Output times, exact: evenly spaced, or listed.


def even_times(end: Exact, samples: int) -> ExactNumbers[Exact]:
    """The times end·k/(samples - 1), 0 and end included."""
    return ExactNumbers(ends=(ZERO, end), size=samples)


def listed_times(
    source: str, key: str, values: Iterable[AnyNumber], units: str = ""
) -> ExactNumbers[Exact]:
    """Times of any kind taken exactly; those of an array of doubles stay one.  Raises BadInput.

    ``units``: the scene's.
    """
    numpy = sys.modules.get("numpy")
    if numpy is not None and isinstance(values, numpy.ndarray):
        bare = type(values) is numpy.ndarray  # no masked one
        flat = bare and values.ndim == 1 and values.dtype == numpy.float64
        if flat and len(values) and bool(numpy.isfinite(values).all()):
            return ExactNumbers(floats=values.copy())
    return ExactNumbers(each(source, key, values, reader(units, TIME), "a list of times"))


# --- validation -----------------------------------------------------------------------------------
#
# Typed access to the tables of a scene: every value checked, every fault named by its key.


_LONG = 24  # characters: no double is printed with more

#: Output times, or crossings of an orbit.
MAX_SAMPLES = 1_000_000


class Literal(str):
    """A decimal of the file, digit for digit."""


class SceneTables:
    """One scene being read: typed access to its keys, faults named by key."""

    def __init__(self, name: str, data: dict[str, Any]) -> None:
        self.name, self.data = name, data
        self.change = ""  # of the start, which rounding alone kept from being possible
        self.doubt = ""  # what of it is hardly meant
        self.in_si = False  # a number was written with a unit, and is more than an angle

    def bad(self, key: str, value: object, expected: str) -> BadInput:
        """The fault of a key's value, to be raised."""
        return BadInput(self.name, key, as_written(value), expected)

    def refuse_unknown(self, section: str, table: Mapping[str, Any], where: str = "") -> None:
        """Refuse a key that the section has not; ``where``: the table of several."""
        allowed = vocabulary.BY_NAME[section]
        for key, value in table.items():
            if key not in allowed:
                every = vocabulary.BY_NAME.items()
                homes = [vocabulary.HEADS[home] for home, keys in every if key in keys]
                expected = f"one of the keys {nearest(key, [*allowed])}"
                if homes:
                    expected = f"no such key here: it belongs in {' or '.join(homes)}"
                if section == "start":
                    expected = vocabulary.OF_OTHERS.get(key, expected)
                raise self.bad(".".join(filter(None, (where or section, key))), value, expected)

    def table(self, section: str, required: bool = True) -> Mapping[str, Any]:
        """A section that is one table."""
        table = self.data.get(section)
        if table is None and not required:
            return {}
        if not isinstance(table, dict):
            raise self.bad(section, table, f"a table [{section}]")
        self.refuse_unknown(section, table)
        return table

    def tables(self, section: str) -> Iterator[tuple[str, dict[str, Any]]]:
        """The tables of a section of several, and what each is called."""
        tables = self.data.get(section, [])
        for index, table in enumerate(tables if isinstance(tables, list) else [tables]):
            if tables is table or not isinstance(table, dict):
                raise self.bad(section, tables, f"tables [[{section}]]")
            where = f"{section}[{index + 1}]"
            self.refuse_unknown(section, table, where)
            yield where, table

    def alone(
        self, section: str, table: Mapping[str, Any], others: Iterable[str], expected: str
    ) -> None:
        """Refuse the first of some keys that the section has all the same."""
        for key in others:
            if key in table:
                raise self.bad(f"{section}.{key}", table[key], expected)

    def read(self, section: str, table: Mapping[str, Any], name: str, where: str = "") -> Any:
        """What a section holds under a key, or the key's default, read as its kind says.

        ``where``: the table of several, as ``events[1]``.
        """
        key = f"{where or section}.{name}".lstrip(".")
        kind = vocabulary.BY_NAME[section][name].kind
        value = table[name] if name in table else vocabulary.default(section, name)
        if kind == vocabulary.NUMBER:
            return self.number(key, value)
        if kind == vocabulary.VECTOR:
            return self.vector(key, value)
        if kind == vocabulary.TRUTH:
            if not isinstance(value, bool):
                raise self.bad(key, value, "true or false")
            return value
        texts = self.array(key, value) if kind == vocabulary.WORDS else [value]
        for text in texts:
            if not is_text(text):
                raise self.bad(key, text, "a text")
        return tuple(texts) if kind == vocabulary.WORDS else value

    def whole(self, section: str, table: Mapping[str, Any], name: str, least: int) -> int:
        """What a section holds under a key, or its default: a whole number up to a million."""
        value: object = table.get(name, vocabulary.default(section, name))
        if not isinstance(value, int) or value is True or not least <= value <= MAX_SAMPLES:
            expected = f"a whole number from {least} to {MAX_SAMPLES}"
            raise self.bad(f"{section}.{name}", value, expected)
        return value

    def array(self, key: str, value: Any, length: int | None = None) -> list[Any]:
        """An array, of so many numbers."""
        if not isinstance(value, list) or (length is not None and len(value) != length):
            expected = "an array" if length is None else f"an array of {length} numbers"
            raise self.bad(key, value, expected)
        return value

    def vector(self, key: str, value: Any) -> Vector:
        """Three numbers."""
        a, b, c = self.array(key, value, 3)
        return self.number(key, a), self.number(key, b), self.number(key, c)

    def number(self, key: str, value: Any) -> Exact:
        """The exact number that a value stands for."""
        try:
            if isinstance(value, Literal):
                return expression.decimal(value)
            if isinstance(value, str):
                exactly, in_si = expression.number_in_text(value, vocabulary.unit(key))
                self.in_si |= in_si
                return exactly
            if isinstance(value, int) and not isinstance(value, bool):
                if abs(value).bit_length() > expression.MAX_BITS:
                    raise ExpressionError("too large")
                return Fraction(value)
            if hasattr(value, "__float__") and not isinstance(value, bool):  # given in Python
                return derived_number(value)
        except ValueError as fault:
            if isinstance(value, str) and expression.interval_mark(value):
                expected = "a number; intervals are allowed in start.omega, for proofs only: "
                raise self.bad(key, value, expected + "polhode certify") from None
            raise self.bad(key, value, f"a number ({fault})") from None
        raise self.bad(key, value, "a number")


def is_text(value: object) -> TypeGuard[str]:
    """Whether a value is a text, which holds an exact expression; a decimal of the file is none."""
    return isinstance(value, str) and not isinstance(value, Literal)


def as_written(value: object, depth: int = 4) -> Any:
    """A TOML value for an error message: as TOML, without quotes around decimals."""
    if isinstance(value, (list, dict)) and depth == 0:
        return "..."
    if isinstance(value, list):
        return "[" + ", ".join(_shown(item, depth) for item in value[:20]) + "]"
    if isinstance(value, dict):
        items = list(value.items())[:20]
        return "{" + ", ".join(f"{key} = {_shown(item, depth)}" for key, item in items) + "}"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, exact.Irrational):
        return shown(value)
    if isinstance(value, Fraction) or (isinstance(value, Literal) and len(value) > _LONG):
        return _as_double(value)
    return value


def _as_double(value: Literal | Fraction) -> str:
    """A number that is a double as Python prints that one; any other as it is."""
    try:
        number = expression.decimal(value) if isinstance(value, str) else value
        if number == Fraction(near := float(number)):
            return repr(near).removesuffix(".0")
    except (ExpressionError, OverflowError):
        pass
    return value if isinstance(value, str) else shown(value)


def _shown(item: object, depth: int) -> str:
    return plain(as_written(item, depth - 1))


# --- scene ----------------------------------------------------------------------------------------


class Published(NamedTuple):
    """A published value: an expression in the columns and its printed value.

    >>> import polhode
    >>> figure = polhode.load("published/nasa-brick").published[0]
    >>> figure.quantity, figure.cite
    ('180/pi*p', 'NASA/TM-2015-218675 case 2 (recomputed to 20 digits)')

    A cite that ends in "(recomputed to N digits)": the scene is published, the value is not.
    """

    t: Exact
    quantity: str
    value: str
    cite: str
    right: int | None = None  # significant digits that are right at least, where not all are

    @property
    def recomputed(self) -> bool:
        """Whether the scene alone is the source's, and the figure was computed for this case."""
        return "(recomputed" in self.cite


#: What a scene holds several of.
#: All are compiled: 100 took 1.5 to 4 s where it was measured, 200 with long expressions minutes.
MOST_EVENTS = 100
_PARTS = {"tags": str, "cite": str, "outputs": str, "events": Event, "published": Published}


class SectionPlan(NamedTuple):
    """The section of a scene's level: see :func:`polhode.section`.

    ``by``: momentum, height or an expression.  ``extremum``: max or min.  ``starts``: rows of
    numbers in the section's coordinates.

    >>> import polhode
    >>> polhode.SectionPlan(by="height", crossings=100)
    SectionPlan(by='height', extremum='max', crossings=100, starts=())
    """

    by: str = "momentum"
    extremum: str = "max"
    crossings: int = 500
    starts: tuple[tuple[Exact, ...], ...] = ()


class Integrals(NamedTuple):
    """h and f, which is None without gamma."""

    energy: Exact
    area: Exact | None


class _Identity:
    """Nothing but itself: what is kept of a scene is found by it, and goes when it goes."""


#: What a scene keeps that is the same at other times, and what is not.
_OF_ANY_TIMES = ("identity", "log10_rate", "time_unit", "modelled")
_OF_TIMES = ("text",)
#: The fields by which a scene's text tells its motion, and the bits that tell irrational numbers.
MOTION_FIELDS = ("body", "omega", "gamma", "psi")
_BITS = 4096


class SceneText(str):
    """The text of a scene file, and what the reader had of it.

    ``tables``: those of TOML, not to be written to.  ``values``: what became of them, by the
    scene's fields.  A scene that was changed since has the text still, and other values.
    """

    tables: dict[str, Any]
    values: dict[str, Any]

    def tells(self, scene: Scene, *fields: str) -> bool:
        """Whether these fields of a scene, by default all, are still what the text says."""
        names = fields or tuple(self.values)
        return all(
            (getattr(scene, name),) == (self.values[name],)  # of the same object without a look
            for name in names
        )


@may_wait("source")
@dataclass(frozen=True, repr=False)
class Scene:
    """A body, a start at t = 0, and output times; exact.

    ``omega`` (3,): the angular velocity; ``gamma`` (3,): the upward vertical unit vector; both in
    body axes.  ``gamma`` None: a torque-free body of which only omega is asked.  ``psi``: the
    precession angle at t = 0.  ``times``: output times, all of one sign (0 may be the first), |t|
    increasing.  Numbers of any kind are exact, a float the binary number that it is.
    ``normalise``: bring gamma to length 1.  ``units``: "SI", or "" for any consistent units.
    Raises BadInput for an impossible value.

    >>> import polhode
    >>> body = polhode.Body.of_moments([2, 2, 1], centre=[1, 0, 0], weight=1)
    >>> start = {"omega": ("0.3", "0.2", "1.1"), "gamma": ("3/5", 0, "4/5")}
    >>> scene = polhode.Scene(body, **start, times=(1, 2))
    >>> scene
    <Scene scene: moments 2, 2, 1, 2 times to t = 2>
    >>> scene.integrals.energy, polhode.reference(scene).kind
    (Fraction(267, 200), 'kovalevskaya')
    """

    body: Body
    omega: Vector
    gamma: Vector | None = None
    psi: Exact = ZERO
    times: Sequence[Exact] = ()
    name: str = "scene"
    title: str = ""
    tags: tuple[str, ...] = ()
    cite: tuple[str, ...] = ()
    form: str = "principal"
    outputs: tuple[str, ...] = ()
    events: tuple[Event, ...] = ()
    published: tuple[Published, ...] = ()
    reference: str = "auto"
    expect: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    source: str = ""  # the text it was read from, for the provenance
    section: SectionPlan = field(default_factory=SectionPlan)
    units: str = ""  # "SI" where the numbers are in m, kg, s and rad
    normalise: InitVar[bool] = False
    change: str = field(default="", compare=False)  # of gamma; the body has its own
    doubt: str = field(default="", compare=False)  # what is hardly meant

    def __post_init__(self, normalise: bool) -> None:
        for key in ("name", "title", "form", "reference", "units"):
            of_kind("Scene", key, getattr(self, key), str, "text")
        if not self.name.isprintable():  # it stands in every line that is said of it
            object.__setattr__(self, "name", one_line(self.name))
        if not callable(vars(self)["_source"]):
            of_kind("Scene", "source", self.source, str, "text")
        for key, kind in _PARTS.items():
            parts, several = numbers_given(getattr(self, key))
            if not several:
                raise self._bad(key, parts[0], f"a list of {kind.__name__}")
            for k, part in enumerate(parts):
                of_kind(self.name, f"{key}[{k + 1}]", part, kind, f"{kind.__name__}")
            object.__setattr__(self, key, tuple(parts))
        if len(self.events) > MOST_EVENTS:
            raise self._bad("events", f"{len(self.events)} events", f"at most {MOST_EVENTS}")
        for k, event in enumerate(self.events):
            check_event(event, self.name, f"events[{k + 1}]")
            if any(event.name == earlier.name for earlier in self.events[:k]):
                expected = "a name of its own, which its rows are told by"
                raise self._bad(f"events[{k + 1}].name", event.name, expected)
        of_kind(self.name, "section", self.section, SectionPlan, "a SectionPlan")
        of_kind(self.name, "expect", self.expect, Mapping, "bands of digits by number type")
        of_kind(self.name, "body", self.body, Body, "a Body")
        omega, gamma = exact_vector(self.omega, self.name, "start.omega"), self.gamma
        (psi,) = each(self.name, "start.psi", (self.psi,), derived_number, "a number")
        times = self._checked_times("run.at", self.times)
        if gamma is not None:
            gamma = exact_vector(gamma, self.name, "start.gamma")
            square = dot(gamma, gamma)
            if square != 1 and not (normalise and sign(square)):
                raise self._bad(
                    "start.gamma",
                    f"length {shown(exact.sqrt(square))}",
                    "a vector of length exactly 1, or normalise = true",
                )
            gamma = gamma if square == 1 else scaled(1 / exact.sqrt(square), gamma)
        elif not self.body.torque_free:
            raise self._bad("start.gamma", None, "a unit vector, since the weight has a moment")
        elif self.outputs:
            raise self._bad("run.outputs", ", ".join(self.outputs), "none without start.gamma")
        vars(self).update(omega=omega, gamma=gamma, psi=psi, times=times)
        if self.units not in UNITS:
            raise self._bad("units", self.units, "SI, or left out for any consistent units")
        for output in self.outputs:
            if output not in COLUMNS:
                raise self._bad("run.outputs", output, nearest(output, [*COLUMNS]))
        if self.form not in FORMS:
            raise self._bad("run.form", self.form, nearest(self.form, [*FORMS]))

    def __repr__(self) -> str:
        moments = ", ".join(shown(x) for x in self.body.moments)
        until = (
            f", {counted(len(self.times), 'time')} to t = {shown(self.end)}" if self.times else ""
        )
        return f"<Scene {self.name}: moments {moments}{until}>"

    def _repr_html_(self) -> str:
        from polhode.results.cells import to_html

        facts = {
            "": self.title or self.name,
            "body": kind_of_body(self.body),
            **{key: ", ".join(map(shown, row)) for key, row in self._vectors()},
            "times": f"{len(self.times)}, to t = {shown(self.end)}" if self.times else "none",
        }
        return to_html(repr(self), "\n".join(f"{k:<9}{v}".strip() for k, v in facts.items()))

    def _vectors(self) -> list[tuple[str, Sequence[Exact]]]:
        body, gamma = self.body, [] if self.gamma is None else [("gamma", self.gamma)]
        rows = [("moments", body.moments), ("Mg r0", body.torque), ("omega", self.omega)]
        return [*rows, *gamma]

    def _bad(self, key: str, value: object, expected: str) -> BadInput:
        return BadInput(self.name, key, value, expected)

    def _checked_times(self, key: str, values: Iterable[AnyNumber]) -> ExactNumbers[Exact]:
        """The times exactly; raises BadInput for what is no number, and where the order is wrong.

        ``key``: of the argument or the scene file that gives them.
        """
        times: ExactNumbers[Exact] = (
            values
            if isinstance(values, ExactNumbers)
            else listed_times(self.name, key, values, self.units)
        )
        wrong = times.misplaced()
        if wrong is not None:
            expected = "times of one sign, strictly monotone away from 0"
            raise self._bad(f"run.at[{wrong + 1}]", shown(times[wrong]), expected)
        return times

    def at(self, times: Iterable[AnyNumber]) -> Scene:
        """The same scene, asked for at other times, numbers of any kind; raises BadInput."""
        checked = self._checked_times("at", times)
        for name in _OF_ANY_TIMES:  # made here, so that the next scene like this has them, too
            getattr(self, name)
        scene = object.__new__(type(self))
        scene.__dict__.update(vars(self), times=checked)
        for name in _OF_TIMES:
            scene.__dict__.pop(name, None)
        return scene

    @cached_property
    def identity(self) -> object:
        """An object that this scene shares with those alone that :meth:`at` makes of it."""
        return _Identity()

    def apart(self) -> Scene:
        """The same scene with an identity of its own, for who is to live no longer than this."""
        scene = object.__new__(type(self))
        scene.__dict__.update(vars(self))
        scene.__dict__.pop("identity", None)
        return scene

    def __getstate__(self) -> dict[str, object]:
        state = {name: x for name, x in vars(self).items() if name != "identity"}
        return state | {"_source": self.source}

    @cached_property
    def text(self) -> str:
        """The text that identifies the scene: its file's, or its exact numbers.

        Of a scene that was changed since its text was read or written, it is the numbers.
        """
        source = self.source
        is_old = isinstance(source, SceneText) and not source.tells(self, *MOTION_FIELDS)
        if source and not is_old:
            return source
        body, gamma = self.body, self.gamma or ()
        numbers = (*chain(*body.inertia), *body.centre, body.weight, *self.omega, *gamma, self.psi)
        digits = [exact.rounded(x, _BITS) if isinstance(x, Irrational) else x for x in numbers]
        return repr((digits, self.times))

    @property
    def notes(self) -> tuple[str, ...]:
        """What was changed of its numbers, as far as rounding alone kept them from being possible.

        And what of them is possible, and hardly meant.
        """
        return tuple(filter(None, (*self.changes, self.doubt)))

    @property
    def extras(self) -> Iterator[tuple[str, str, object, str]]:
        """What it has beyond a heavy body, a start and times, of which not every door knows.

        Of each its word, its key, its value, and what a scene without it has there.
        """
        if self.outputs:
            yield "outputs", "outputs", ", ".join(self.outputs), "none"
        if self.events:
            yield "events", "events", ", ".join(event.name for event in self.events), "none"
        if self.form != "principal":
            yield "form", "run.form", self.form, "principal"

    @property
    def changes(self) -> tuple[str, ...]:
        """What was changed of its numbers."""
        return tuple(filter(None, (self.body.change, self.change)))

    def provenance(self) -> dict[str, object]:
        """Where a result comes from: versions, processor, the text's fingerprint, notes if any."""
        facts = provenance(self.text)
        return facts | {"notes": list(self.notes)} if self.notes else facts

    def speak(self) -> None:
        """Say its notes on stderr: a change once in a process, a doubt as a warning."""
        for text in self.changes:
            say_change(self.name, text)
        if self.doubt:
            say_doubt(self.name, self.doubt)

    @property
    def output_times(self) -> ExactNumbers[Exact]:
        """The times, which know their doubles all at once."""
        times: ExactNumbers[Exact] = self.times  # type: ignore[assignment]  # made so at its birth
        return times

    @property
    def end(self) -> Exact:
        """The last time asked for."""
        return self.times[-1] if self.times else ZERO

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the state's columns."""
        return STATE if self.gamma is not None else STATE[:3]

    @property
    def start(self) -> tuple[Exact, ...]:
        """The state at t = 0 in body axes: p q r [gamma1 gamma2 gamma3]."""
        return (*self.omega, *self.gamma) if self.gamma is not None else self.omega

    @cached_property
    def integrals(self) -> Integrals:
        """The exact values of h and f.

        h = ½ w·I w + Mg r0·gamma and f = I w·gamma, (3.30) of Yehia, *Rigid Body Dynamics: A
        Lagrangian Approach*.
        """
        momentum = self.body.momentum(self.omega)
        kinetic = dot(momentum, self.omega) / 2
        if self.gamma is None:
            return Integrals(kinetic, None)
        energy = kinetic + dot(self.body.torque, self.gamma)
        return Integrals(energy, dot(momentum, self.gamma))

    @cached_property
    def log10_rate(self) -> float:
        """log10 of the fastest rate in the start: |w| or sqrt(Mg|r0|/largest moment)."""
        return exact.log10(max(dot(self.omega, self.omega), self.pendulum_rate_squared)) / 2

    @property
    def log10_angle(self) -> float:
        """log10 of the angle turned to the end: the fastest rate times |end|; at least 0."""
        return max(0.0, self.log10_rate + exact.log10(self.end))

    @cached_property
    def pendulum_rate_squared(self) -> Exact:
        """Mg|r0| / largest moment: the square of the slowest small oscillation's scale."""
        return exact.sqrt(self.body.pendulum_rate_fourth)

    @cached_property
    def time_unit(self) -> int:
        """The exponent n for which time is measured inside in units of 2**n.

        Chosen from the fourth power of the fastest rate, a number that scales exactly with the
        unit of time, so that scaling a scene by powers of two changes no bit of a run.
        """
        square = dot(self.omega, self.omega)
        fourth = max(square * square, self.body.pendulum_rate_fourth)
        if sign(fourth) == 0:
            return 0
        return -((exact.exponent_above(fourth) - 1) // 4)

    @cached_property
    def modelled(self) -> tuple[str, ...]:
        """The outputs that are integrated beside the state, or needed for those that are not."""
        needed: set[str] = set()
        for name in self.outputs:
            needed |= {name} if COLUMNS[name].how == "integrated" else {*COLUMNS[name].needs}
        return tuple(name for name in COLUMNS if name in needed)

    @property
    def starts_at_pole(self) -> bool:
        """Whether the third axis is vertical at t = 0, where psi and phi have no meaning."""
        return self.gamma is not None and sign(self.gamma[0]) == 0 == sign(self.gamma[1])

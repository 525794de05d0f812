"""A scene: one body, one start, the output times.  Exact, immutable, checked once.

Body axes O xyz, O the fixed point; omega = (p, q, r) and gamma, the upward vertical, in body axes,
as in Yehia, *Rigid Body Dynamics: A Lagrangian Approach*, chapter 3.  The first integrals are its
(3.30): h = ½ w·I w + Mg r0·gamma, f = I w·gamma, |gamma|² = 1.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import InitVar, dataclass, field
from typing import NamedTuple

from polhode.common.arguments import each, of_kind
from polhode.common.errors import BadInput, counted, nearest, one_line, say_change, say_doubt
from polhode.common.provenance import provenance
from polhode.common.values import cached_property, may_wait
from polhode.numbers import exact
from polhode.numbers.conversion import derived_number
from polhode.numbers.decimals import shown
from polhode.numbers.exact import ZERO, Exact, sign
from polhode.numbers.exact_sequences import ExactNumbers
from polhode.numbers.scalars import AnyNumber
from polhode.numbers.vectors import Vector, dot, scaled
from polhode.scenes.body import Body, exact_vector
from polhode.scenes.event import Event, check_event
from polhode.scenes.output_times import listed_times
from polhode.scenes.vocabulary import COLUMNS, FORMS, STATE, UNITS


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
    """h, f and |gamma|² - 1 with the scales they are judged on; f and gamma None without gamma."""

    energy: Exact
    area: Exact | None
    energy_scale: Exact
    area_scale: Exact


class _Identity:
    """Nothing but itself: what is kept of a scene is found by it, and goes when it goes."""


#: What a scene keeps that is the same at other times, and what is not.
_OF_ANY_TIMES = ("identity", "log10_rate", "time_unit", "modelled")
_OF_TIMES = ("text",)


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
        if (name := one_line(self.name)) != self.name:  # it stands in every line that is said of it
            object.__setattr__(self, "name", name)
        if not callable(vars(self)["_source"]):
            of_kind("Scene", "source", self.source, str, "text")
        for key, kind in _PARTS.items():
            parts = each(
                self.name, key, getattr(self, key), lambda x: x, f"a list of {kind.__name__}"
            )
            for k, part in enumerate(parts):
                of_kind(self.name, f"{key}[{k + 1}]", part, kind, f"{kind.__name__}")
            object.__setattr__(self, key, parts)
        if len(self.events) > MOST_EVENTS:
            raise self._bad("events", f"{len(self.events)} events", f"at most {MOST_EVENTS}")
        for k, event in enumerate(self.events):
            check_event(event, self.name, f"events[{k + 1}]")
            if any(event.name == other.name for other in self.events[:k]):
                expected = "a name of its own, which its rows are told by"
                raise self._bad(f"events[{k + 1}].name", event.name, expected)
        of_kind(self.name, "section", self.section, SectionPlan, "a SectionPlan")
        of_kind(self.name, "expect", self.expect, Mapping, "bands of digits by number type")
        of_kind(self.name, "body", self.body, Body, "a Body")
        object.__setattr__(self, "omega", exact_vector(self.omega, self.name, "start.omega"))
        (psi,) = each(self.name, "start.psi", (self.psi,), derived_number, "a number")
        object.__setattr__(self, "psi", psi)
        object.__setattr__(self, "times", self._checked_times("run.at", self.times))
        if self.gamma is not None:
            gamma = exact_vector(self.gamma, self.name, "start.gamma")
            square = dot(gamma, gamma)
            if normalise and square != 1 and sign(square) != 0:
                gamma = scaled(1 / exact.sqrt(square), gamma)
            object.__setattr__(self, "gamma", gamma)
        if self.gamma is None:
            if not self.body.torque_free:
                raise self._bad("start.gamma", None, "a unit vector, since the weight has a moment")
            if self.outputs:
                raise self._bad("run.outputs", ", ".join(self.outputs), "none without start.gamma")
        elif dot(self.gamma, self.gamma) != 1:
            raise self._bad(
                "start.gamma",
                f"length {shown(exact.sqrt(dot(self.gamma, self.gamma)))}",
                "a vector of length exactly 1, or normalise = true",
            )
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
        from polhode.output import notebook

        return notebook.of_scene(self)

    def _bad(self, key: str, value: object, expected: str) -> BadInput:
        return BadInput(self.name, key, value, expected)

    def _checked_times(self, key: str, given: Iterable[AnyNumber]) -> ExactNumbers[Exact]:
        """The times exactly; raises BadInput for what is no number, and where the order is wrong.

        ``key``: of the argument or the scene file that gives them.
        """
        times = (
            given
            if isinstance(given, ExactNumbers)
            else listed_times(self.name, key, given, self.units)
        )
        wrong = times.misplaced()
        if wrong is not None:
            expected = "times of one sign, strictly monotone away from 0"
            raise self._bad(f"run.at[{wrong + 1}]", shown(times[wrong]), expected)
        return times

    def at(self, times: Iterable[AnyNumber]) -> Scene:
        """The same scene, asked for at other times, numbers of any kind; raises BadInput."""
        asked = self._checked_times("at", times)
        for name in _OF_ANY_TIMES:  # made here, so that the next scene like this has them, too
            getattr(self, name)
        found = object.__new__(type(self))
        found.__dict__.update(vars(self), times=asked)
        for name in _OF_TIMES:
            found.__dict__.pop(name, None)
        return found

    @cached_property
    def identity(self) -> object:
        """An object that this scene shares with those alone that :meth:`at` makes of it."""
        return _Identity()

    def apart(self) -> Scene:
        """The same scene with an identity of its own, for who is to live no longer than this."""
        found = object.__new__(type(self))
        found.__dict__.update(vars(self))
        found.__dict__.pop("identity", None)
        return found

    def __getstate__(self) -> dict[str, object]:
        found = {name: x for name, x in vars(self).items() if name != "identity"}
        return found | {"_source": self.source}

    @cached_property
    def text(self) -> str:
        """The text that identifies the scene: its file's, or its exact numbers."""
        body = self.body
        parts = (body.inertia, body.centre, body.weight, self.omega, self.gamma, self.psi)
        return self.source or repr((parts, self.times))

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
        found = provenance(self.text)
        return found | {"notes": list(self.notes)} if self.notes else found

    def speak(self) -> None:
        """Say its notes on stderr: a change once in a process, a doubt as a warning."""
        for text in self.changes:
            say_change(self.name, text)
        if self.doubt:
            say_doubt(self.name, self.doubt)

    @property
    def output_times(self) -> ExactNumbers[Exact]:
        """The times, which know their doubles all at once."""
        found: ExactNumbers[Exact] = self.times  # type: ignore[assignment]  # made so at its birth
        return found

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
        """The exact values of h and f, and their scales T(0) + Mg|r0| and |G(0)|.

        h = ½ w·I w + Mg r0·gamma and f = I w·gamma, (3.30) of Yehia, *Rigid Body Dynamics: A
        Lagrangian Approach*.
        """
        momentum = self.body.momentum(self.omega)
        kinetic = dot(momentum, self.omega) / 2
        torque = self.body.torque
        energy, area = kinetic, None
        if self.gamma is not None:
            energy = kinetic + dot(torque, self.gamma)
            area = dot(momentum, self.gamma)
        return Integrals(
            energy,
            area,
            kinetic + exact.sqrt(dot(torque, torque)),
            exact.sqrt(dot(momentum, momentum)),
        )

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
        mantissa, exponent = exact.rounded(fourth, 8)
        return -((exponent + mantissa.bit_length() - 1) // 4)

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

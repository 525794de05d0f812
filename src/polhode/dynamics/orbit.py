"""Periodic orbits of omega and gamma to many digits, and what tells their stability."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple, TypedDict, Unpack

import numpy as np

from polhode.common.arguments import (
    each,
    of_kind,
    refuse_unknown,
    whole,
    with_options,
    with_progress,
)
from polhode.common.errors import BadInput, counted
from polhode.common.files import check_writable, refuse_foreign, write_whole
from polhode.common.interrupts import Message
from polhode.common.values import ByValue
from polhode.dynamics import newton_shooting as newton
from polhode.dynamics.level_body import LevelBody, level_of
from polhode.numbers import exact
from polhode.numbers.conversion import TIME, exactly, reader, to_double, to_mpf
from polhode.numbers.decimals import decimal_string, in_full, shown
from polhode.numbers.exact import ZERO, Exact, sign
from polhode.numbers.mpmath_context import mpmath, ordinary
from polhode.numbers.number_types import DOUBLE, AnyNumber, Doubles, NumberType, Real, bits_for
from polhode.results.cells import EXACT, digits_word
from polhode.results.result import Result
from polhode.results.table import Column, Fact, Table
from polhode.runs.options import Options
from polhode.runs.trajectory import solve
from polhode.scenes import library, scene_file
from polhode.scenes.scene import Literal, Scene
from polhode.scenes.scene_facts import provenance_fact, row_columns, scene_facts, unit_of
from polhode.scenes.scene_file import as_toml, tables_of, written
from polhode.scenes.vocabulary import REQUESTS, STATE
from polhode.taylor.variations import NotFollowed

# --- azimuth advance ------------------------------------------------------------------------------
#
# How far psi advances while omega and gamma come round: whether the motion in space closes.
#
# After a period gamma is what it was, so the attitude has turned about the vertical alone:
# R(T) = Rz(D) R(0).  The attitude tells D up to whole turns at any motion; psi itself tells those,
# too, where the third axis does not pass through the vertical.


class Advance(NamedTuple):
    """psi's advance as an mpf, None where it cannot be had; ``whole``: with its whole turns."""

    psi: Real | None
    whole: bool


def advance(scene: Scene, number: NumberType) -> Advance:
    """Of a scene that ends after one period, by one run from 0 to there."""
    period = replace(scene, outputs=("angles", "attitude"), events=(), times=(ZERO, scene.end))
    options = Options(project=False)
    run = solve(period, number, options, interruptible=False)
    if run.outcome.done and run.angles is not None:
        try:
            first, last = (exactly(row[0]) for row in run.angles)
            return Advance(ordinary(to_mpf(last - first, number.bits)), True)
        except ValueError:  # no number: the third axis is vertical
            pass
    run = solve(replace(period, outputs=("attitude",)), number, options, interruptible=False)
    if not run.outcome.done or run.attitude is None:
        return Advance(None, False)
    with mpmath.workprec(number.bits):
        (a, b, c, d), (p, q, r, s) = (
            [to_mpf(exactly(x), number.bits) for x in row] for row in run.attitude
        )
        along, across = a * p + b * q + c * r + d * s, a * s - d * p + c * q - b * r
        return Advance(ordinary(2 * mpmath.atan2(across, along)), False)


# --- recurrences ----------------------------------------------------------------------------------
#
# When a motion comes near its start again: guesses of a period.


STEP = 0.05  # radians of the fastest rate between two looks
LOOKS = 800  # at a time
FARTHEST = 2000.0  # radians that a motion is followed
NEAR = 0.25  # of the largest distance so far: a return, no mere swing


class Return(NamedTuple):
    """A time at which the distance to the start is least, and that distance, scaled."""

    time: float
    distance: float


def near_returns(on: LevelBody, start: Doubles, most: int) -> list[Return]:
    """When a motion in double comes near its start: as many times, or until it has gone too far.

    Raises BadInput where it never does.
    """
    scale = on.scale(start)
    dt = STEP / float(scale[0])
    times: Doubles = np.linspace(0.0, LOOKS * dt, LOOKS + 1).astype(np.float64)
    state, elapsed = start, 0.0
    before, here, largest, nearest = 0.0, 0.0, 0.0, np.inf
    returns: list[Return] = []
    while elapsed < FARTHEST / float(scale[0]):
        try:
            rows = on.plain_flow.along(state, times)
        except NotFollowed:
            break
        squares = (((rows - start) / scale) ** 2).sum(axis=1)
        for k in range(1, len(times)):
            after = float(squares[k])
            if here <= after and here < before:
                bend = before - 2 * here + after
                shift = (before - after) / (2 * bend) if bend > 0 else 0.0
                least = max(0.0, here - bend * shift * shift / 2) ** 0.5
                nearest = min(nearest, least / largest)
                if least < NEAR * largest:
                    returns.append(Return(elapsed + float(times[k - 1]) + shift * dt, least))
                    if len(returns) == most:
                        return returns
            largest = max(largest, after**0.5)
            before, here = here, after
        state, elapsed = rows[-1], elapsed + float(times[-1])
    if not returns:
        expected = (
            f"a start near which the motion returns: up to t = {elapsed * float(on.unit):.3g} it "
            f"stays {nearest:.2g} of its size away"
        )
        raise BadInput(on.scene.name, "start", None, expected)
    return returns


# --- report ---------------------------------------------------------------------------------------
#
# A periodic orbit for people: of each number the digits that are known.


def _advance(orbit: Orbit) -> str:
    error = orbit.psi_error  # 0 where the decimals are the orbit's own
    digits = math.floor(-math.log10(error)) if error else orbit.digits - 2
    places = min(orbit.digits, digits)
    if orbit.psi is None or places < 1:
        return "not known"
    closes = "the motion in space does not close in few periods"
    if orbit.digits < newton.DIGITS_OF_TURNS:
        closes = "too few digits to tell whether the motion in space closes"
    if orbit.turns is not None:
        count = counted(orbit.turns.denominator, "period")
        closes = f"the motion in space closes after {count}"
    return f"{_to_places(exactly(orbit.psi), places)} per period; {closes}"


def _multipliers(orbit: Orbit) -> list[tuple[str, str]]:
    """Real and imaginary part of both, with the digits that are known."""
    pairs, most = [], orbit.digits
    for parts in orbit.multipliers:
        real, imaginary = map(exactly, parts)
        multiplier, size = complex(*map(float, parts)), max(1.0, abs(float(real)))
        # mu - 1/mu divides the error of mu + 1/mu = 2 - 4R; near +-1 its root is taken
        apart = abs(multiplier - 1 / multiplier)
        error = 4 * orbit.residue_error * size / max(apart, math.sqrt(orbit.residue_error))
        pairs.append((_sure_digits(real, error, most), _sure_digits(imaginary, error, most)))
    return pairs


def _decimal(x: Exact, digits: int) -> str:
    """x to so many digits: its own where it has no more."""
    if isinstance(x, Fraction):
        text = in_full(x)
        if "/" not in text and len(text.strip("-0.")) <= digits:
            return text
    return decimal_string(exact.nearest(x, 4 * digits + 8), digits)


def _to_places(x: Exact, digits: int) -> str:
    """A component of a unit vector to so many places."""
    return newton.decimal(exact.nearest(x, 4 * digits + 8), Fraction(1), digits)


def _sure_digits(x: Fraction, error: float, most: int) -> str:
    """x as far as an error leaves digits, and no more than so many; 0 where it leaves none."""
    if not x:
        return "0"
    left = math.floor(exact.log10(abs(x)) - math.log10(error))
    return decimal_string(x, min(left, most)) if left >= 1 else "0"


# --- orbit ----------------------------------------------------------------------------------------


DIGITS = 15
MOST_DIGITS = 300  # whose errors doubles hold
RETURNS = 10
MOST_RETURNS = 1000
FARTHER = 3.0  # times a guess: the longest period that it may lead to
ASTRAY = 5.0  # times the guess's own miss: an orbit farther away is another one
PSI_BY_START = 4.0  # 2.9 at most on 26 orbits of two bodies, found to 5 to 20 digits
SAME = 1e-7  # of the state's scale: the orbit has closed already
PARTS = (2, 3, 5, 7, 11, 13)
ELLIPTIC, HYPERBOLIC, INVERSE, PARABOLIC = (
    "elliptic",
    "hyperbolic",
    "inverse hyperbolic",
    "parabolic",
)


@dataclass(frozen=True, repr=False, eq=False)
class Orbit(Result, ByValue):
    """A periodic orbit of (omega, gamma) on one level: its start, its period, its stability.

    In the scene's body axes and units.  ``scene``: the start as an exact scene that ends after one
    period.  ``period``: exactly the decimal of that scene.  ``error``: the largest relative error
    of start and period, estimated by a correction in a wider type.  ``h``, ``f``: the level.
    ``residue``: Greene's (6 - tr M)/4, M the monodromy matrix, ``residue_error`` an estimate of its
    error; below 0 the orbit is hyperbolic, between 0 and 1 elliptic, above 1 inverse hyperbolic.
    ``determinant``: |det M - 1|.  ``psi``: the advance of psi in a period in radians, None if it is
    not known; ``psi_whole``: whether it includes whole turns, which are unknown if the third axis
    passes through the vertical.  ``moved``: the distance of the start from the guess, scaled.
    ``corrections``: the numbers of corrections in double and in the wider type.

    >>> import polhode
    >>> found = polhode.orbit("grioli/precession", digits=20)
    >>> found
    <Orbit of grioli/precession: period 6.28319, elliptic, residue 0.00244842, 20 digits>
    >>> polhode.as_toml(found.scene).splitlines()[-2]
    'end = 6.283185307179586476925'
    >>> found.turns  # psi advances by one turn: the motion in space closes, too
    Fraction(1, 1)
    """

    scene: Scene
    name: str
    h: Exact
    f: Exact
    digits: int
    period: Exact
    error: float
    residue: Real
    residue_error: float
    determinant: float
    psi: Real | None
    psi_whole: bool
    moved: float
    corrections: tuple[int, int]
    surface: LevelBody
    closed: newton.Closed
    provenance: Mapping[str, object] = field(default_factory=dict)

    @property
    def kind(self) -> str:
        """elliptic, hyperbolic, inverse hyperbolic; parabolic where the residue is 0 or 1."""
        return kind_of(float(self.residue), self.residue_error)

    @property
    def multipliers(self) -> tuple[tuple[Real, Real], tuple[Real, Real]]:
        """Real and imaginary part of the two that may differ from 1; their product is 1."""
        with mpmath.workprec(bits_for(self.digits) + 20):
            half = 1 - 2 * to_mpf(exactly(self.residue), bits_for(self.digits) + 20)
            if abs(half) <= 1:
                side = mpmath.sqrt(1 - half * half)
                return ordinary((half, side)), ordinary((half, -side))
            size = abs(half) + mpmath.sqrt(half * half - 1)
            first = size if half > 0 else -size
            return ordinary((first, 0 * first)), ordinary((1 / first, 0 * first))

    @property
    def psi_error(self) -> float:
        """About the error of psi's advance: that of the start, as a period multiplies it."""
        growth = float(np.linalg.norm(self.closed.monodromy, 2))
        return PSI_BY_START * max(1.0, growth) * self.error

    @property
    def turns(self) -> Fraction | None:
        """psi's advance over 2 pi if that is a fraction to the digits known, else None.

        With k below, the motion in space closes after k periods.  Of fewer than eight digits nearly
        every advance is near some fraction: none is told.
        """
        if self.psi is None or self.digits < newton.DIGITS_OF_TURNS:
            return None
        with mpmath.workprec(bits_for(self.digits) + 20):
            ratio = to_mpf(exactly(self.psi), bits_for(self.digits) + 20)
            exact = exactly(ratio / (2 * mpmath.pi))
        near = exact.limit_denominator(MOST_PERIODS)
        return near if abs(exact - near) < Fraction(100, 10**self.digits) else None

    def table(self) -> Table:
        """One row: period, stability, and the start, to two digits more than were asked for."""
        scene, word = self.scene, digits_word(self.digits + 2)
        state = (*scene.omega, *(scene.gamma or ()))
        columns = zip(row_columns(scene, STATE, [state], DOUBLE), state, strict=True)
        return Table(
            [
                Column("orbit", [1]),
                Column("period", [self.period], "", unit_of(scene, "t"), word, 17),
                Column("residue", [float(self.residue)], "Greene's"),
                Column("kind", [self.kind]),
                *(column._replace(values=[x], type=word, digits=17) for column, x in columns),
            ]
        )

    def facts(self) -> list[Fact]:
        """The level, the period, the multipliers, and how they were found."""
        word = digits_word(self.digits + 2)
        pairs = self.multipliers
        multipliers = [
            Column(name, [pair[k] for pair in pairs], type=word)
            for k, name in enumerate(("real", "imaginary"))
        ]
        return [
            *scene_facts(self.scene, name=self.name),
            Fact("h", self.h, "energy"),
            Fact("f", self.f, "vertical momentum"),
            Fact("digits", self.digits, "correct digits of start and period"),
            Fact("period", self.period, "", unit_of(self.scene, "t"), word),
            Fact("error", self.error, "of start and period, estimated, relative"),
            Fact("kind", self.kind, "of its stability"),
            Fact("residue", self.residue, "Greene's", type=word),
            Fact("residue_error", self.residue_error, "estimated"),
            Fact("multipliers", Table(multipliers, 0), "that may differ from 1"),
            Fact("determinant", self.determinant, "|det M - 1|"),
            Fact("psi_advance", self.psi, "in a period", "rad", word),
            Fact("psi_error", self.psi_error, "estimated", "rad"),
            Fact("psi_with_turns", self.psi_whole, "whether that includes whole turns"),
            Fact("psi_turns", self.turns, "that over 2 pi, where it is a fraction", type=EXACT),
            Fact("moved", self.moved, "distance of the start from the guess, scaled"),
            Fact("corrections", list(self.corrections), "in double, and in the wider type"),
            provenance_fact(self.provenance),
        ]

    def save(self, path: str | Path) -> None:
        """Write the orbit as any result, or as .toml its start: a scene that ends after a period.

        Raises
        ------
        BadInput
            A place that cannot be written to.
        """
        of_kind("save", "path", path, (str, Path), "the path of a file")
        if Path(path).suffix.lower() not in (".toml", ""):  # "-" is stdout
            super().save(path)
            return
        check_writable(Path(path), [".toml"])
        refuse_foreign(Path(path))
        write_whole({Path(path): as_toml(self.scene)})

    def __str__(self) -> str:
        """Start, period and stability, a line each; of each number the digits that are known."""
        more = self.digits + 2
        residue = _sure_digits(exactly(self.residue), self.residue_error, self.digits)
        lines = [
            f"period      {_decimal(self.period, more)}",
            f"omega       {', '.join(_decimal(x, more) for x in self.scene.omega)}",
            f"gamma       {', '.join(_to_places(x, more) for x in self.scene.gamma or ())}",
            f"level       h = {shown(self.h)}, f = {shown(self.f)}",
            f"residue     {residue}, {self.kind}",
        ]
        for real, imaginary in _multipliers(self):
            side = "-" if imaginary.startswith("-") else "+"
            beside = f" {side} {imaginary.lstrip('-')} i" if imaginary != "0" else ""
            lines.append(f"multiplier  {real}{beside}")
        return "\n".join([*lines, f"psi         {_advance(self)}"])

    def __repr__(self) -> str:
        period, residue = to_double(self.period), float(self.residue)
        return (
            f"<Orbit of {self.name}: period {period:.6g}, {self.kind}, residue {residue:.6g}, "
            f"{self.digits} digits>"
        )


MOST_PERIODS = 24  # after which a motion in space is looked for to close


class NearOrbit(TypedDict, total=False):
    """Which periodic orbit near a start is meant: options of :func:`orbit` and what begins with it.

    Parameters
    ----------
    h, f : number, optional
        The level's energy h or vertical momentum f, exact, if not the scene's.
    period : number, optional
        A guess of the period, in the scene's unit of time.  Without one the times at which the
        motion returns near its start are tried.
    returns : int, optional
        The number of near returns of the motion to try (10).
    progress : callable, optional
        Called with a line of text now and then.
    """

    h: AnyNumber | None
    f: AnyNumber | None
    period: AnyNumber | None
    returns: int | None
    progress: Message | None


@with_options(NearOrbit)
@with_progress
def orbit(scene: Scene | str | Path, digits: int = DIGITS, **near: Unpack[NearOrbit]) -> Orbit:
    """Find a periodic orbit of omega and gamma near a scene's start, to the digits wanted.

    Newton's method in double, then in a type wide enough.  h and f are kept fixed.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, a path, or the name of a case.
    digits : int
        The correct digits of start and period (15, at most 300).

    Returns
    -------
    Orbit
        Start, shortest period, multipliers and kind.

    Raises
    ------
    BadInput
        A permanent rotation, a motion that does not return near its start, a level that does not
        exist, or no orbit found near the start by Newton's method.

    Examples
    --------
    >>> import polhode
    >>> body = {"moments": [2, 1.5, 1], "gamma": ["4/5", "3/5", 0]}
    >>> near = polhode.top(**body, omega=["1.001", "0.002", 0])
    >>> found = polhode.orbit(near, h=1, f="1.6")  # there omega = (1, 0, 0), period 2 pi
    >>> abs(float(found.period) - 6.283185307179586) < 1e-14, found.kind
    (True, 'elliptic')
    """
    refuse_unknown("orbit", orbit, near)
    period, returns = near.get("period"), near.get("returns")
    scene = library.load(scene, takes=REQUESTS)
    digit_count = whole(scene.name, "digits", digits, 1, MOST_DIGITS)
    most = RETURNS if returns is None else whole(scene.name, "returns", returns, 1, MOST_RETURNS)
    if scene.gamma is not None:
        own = LevelBody.of(scene)
        if own.is_still(own.start, 1e-9):
            raise BadInput(scene.name, "start", None, "a motion: this is a permanent rotation")
    on = level_of(scene, near.get("h"), near.get("f"))
    start = on.start
    if period is None:
        guesses = near_returns(on, start, most)
    else:
        (duration,) = each(scene.name, "period", (period,), reader(scene.units, TIME), "a time")
        if sign(duration) <= 0:
            raise BadInput(scene.name, "period", period, "a time above 0")
        if not math.isfinite(to_double(duration / on.unit)):
            raise BadInput(scene.name, "period", period, "a time that double precision can hold")
        if to_double(duration / on.unit) < on.shortest / FARTHER:
            least = on.shortest * to_double(on.unit)
            expected = f"one near {least:.3g} or longer: no motion on this level closes in less"
            raise BadInput(scene.name, "period", period, expected)
        guesses = [Return(to_double(duration / on.unit), math.inf)]
    first = _first(on, start, guesses)
    return completed(on, first, digit_count, on.exact_start, near.get("progress"))


def _first(on: LevelBody, start: Doubles, guesses: list[Return]) -> newton.Closed:
    """The orbit of the first guess that leads to one near the start; raises BadInput."""
    off = float(np.linalg.norm(on.integrals(start) - on.relative[2]))
    why = ""
    for guess in guesses:
        try:
            return orbit_near(on, start, guess.time, ASTRAY * (guess.distance + off) + SAME)
        except newton.NotClosed as fault:
            why = str(fault)
    expected = f"a start nearer to a periodic orbit: Newton's method found none ({why})"
    raise BadInput(on.scene.name, "start", None, expected)


def orbit_near(on: LevelBody, start: Doubles, time: float, most: float) -> newton.Closed:
    """The orbit, with its shortest period, to which a start and a guess of the period lead.

    Raises NotClosed, also for one that lies farther than ``most`` from the start.
    """
    orbit = newton.closed(on, start, time)
    moved = moved_from(on, orbit, start)
    if not moved <= most:
        raise newton.NotClosed(f"it led {moved:.2g} away from the start")
    return primitive(on, orbit)


def moved_from(on: LevelBody, orbit: newton.Closed, start: Doubles) -> float:
    """How far a found start lies from another one, scaled."""
    return float(np.linalg.norm((orbit.state - start) / on.scale(start)))


def primitive(on: LevelBody, orbit: newton.Closed) -> newton.Closed:
    """The same orbit with its shortest period."""
    scale = on.scale(orbit.state)
    for part in PARTS:
        while True:
            time = orbit.period / part
            try:
                end = np.asarray(on.plain_flow.after(orbit.state, time).state, dtype=np.float64)
                if np.max(np.abs(end - orbit.state) / scale) > SAME:
                    break
                orbit = newton.closed(on, orbit.state, time)
            except (newton.NotClosed, NotFollowed):
                break
    return orbit


def completed(
    on: LevelBody,
    orbit: newton.Closed,
    digits: int,
    guess: Sequence[Exact] | None = None,
    progress: Message | None = None,
) -> Orbit:
    """An orbit known in double, to all digits, with residue and advance of psi; raises BadInput.

    ``guess``: the state that led to it, from which it starts across the motion; its own in double
    unless given.
    """
    name = on.scene.name
    digits = whole(name, "digits", digits, 1, MOST_DIGITS)
    near = orbit.state if guess is None else np.array([to_double(x) for x in guess])
    try:
        fine = newton.refined(on, orbit, digits, guess, progress)
        if progress is not None:
            progress("the monodromy matrix")
        matrix = newton.monodromy(on, fine.state, fine.time, digits)
    except (newton.NotClosed, NotFollowed) as fault:
        expected = f"an orbit that can be computed to {digits} digits ({fault})"
        raise BadInput(name, "digits", digits, expected) from None
    scene = _scene(on.scene, name, fine)
    rotation = advance(scene, fine.number)
    bits = bits_for(digits) + 20
    return Orbit(
        scene,
        name,
        on.h,
        on.f,
        digits,
        scene.end,
        fine.error,
        ordinary(to_mpf(matrix.residue, bits)),
        _residue_error(matrix, orbit, fine),
        matrix.determinant,
        rotation.psi,
        rotation.whole,
        moved_from(on, orbit, near),
        (orbit.corrections, fine.corrections),
        on,
        orbit,
        scene.provenance(),
    )


def _residue_error(matrix: newton.Monodromy, orbit: newton.Closed, fine: newton.Refined) -> float:
    """About the error of a residue: what the matrix's exact properties miss, times its size."""
    size = float(np.linalg.norm(orbit.monodromy, 2))
    return max(matrix.missed, float(matrix.number.eps), fine.error) * max(1.0, size)


def kind_of(residue: float, error: float) -> str:
    """The word for a residue that is known within an error."""
    if abs(residue) <= error or abs(residue - 1) <= error:
        return PARABOLIC
    return HYPERBOLIC if residue < 0 else ELLIPTIC if residue < 1 else INVERSE


def _scene(near: Scene, name: str, fine: newton.Refined) -> Scene:
    """The found start as a scene: the body as it was given, decimals, one period."""
    tables, psi, places = tables_of(near), near.psi, len(fine.period)
    tables["start"] = {
        "omega": [Literal(x) for x in fine.omega],
        "gamma": [Literal(x) for x in fine.gamma],
        "normalise": True,
        "psi": psi
        if isinstance(psi, Fraction)
        else Literal(decimal_string(exact.nearest(psi, 4 * places), places)),
    }
    data: dict[str, Any] = {"title": f"A periodic orbit near {name}", "run": {}, **tables}
    data["run"] = {"end": Literal(fine.period), "samples": 101}
    return scene_file.parse(written(data, name), f"orbit near {name}")

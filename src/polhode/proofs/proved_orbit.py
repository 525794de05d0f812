"""Proved periodic orbits: of a scene, or of an approximate orbit, a theorem in its axes."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from decimal import ROUND_CEILING, Context
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple, Unpack

from flint import arb

from polhode.certificates import verify
from polhode.certificates.certificate_file import JsonObject, by_checker
from polhode.common.arguments import refuse_unknown, whole, with_options, with_progress
from polhode.common.errors import BadInput, aligned
from polhode.common.interrupts import Message
from polhode.common.values import ByValue
from polhode.dynamics.families import OrbitSearch, orbit_search
from polhode.dynamics.level_body import LevelBody, level_of
from polhode.dynamics.newton_shooting import Closed
from polhode.dynamics.orbit import NearOrbit, Orbit
from polhode.dynamics.orbit import orbit as approximate
from polhode.enclosures.fixed_point_problem import upper
from polhode.numbers.decimals import Ball, shown
from polhode.numbers.exact import Exact, as_ball
from polhode.numbers.flint_context import ctx
from polhode.numbers.number_types import DOUBLE, AnyNumber
from polhode.numbers.polynomials import middle
from polhode.proofs.orbit_certificate import closed_near, proof_of
from polhode.proofs.theorem import NotProved, Theorem
from polhode.results import cells
from polhode.results.result import Result
from polhode.results.table import Column, Fact, Table
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import provenance_fact, row_columns, scene_facts, unit_of
from polhode.scenes.vocabulary import REQUESTS, STATE

# --- theorem --------------------------------------------------------------------------------------


_CEILING = Context(prec=6, rounding=ROUND_CEILING)


class Within(NamedTuple):
    """How near a motion passes by, and how near its period is; lower bounds."""

    omega: float
    gamma: float
    period: float


@dataclass(frozen=True, eq=False, repr=False)
class ProvedOrbit(Theorem, ByValue):
    """A periodic orbit of (omega, gamma) that exists: a theorem about the exact level.

    ``scene``, ``h``, ``f``: the body and the level, exact.  ``period``: the least one; ``omega``,
    ``gamma``: a point of the orbit; both in the scene's body axes and units.  ``residue``:
    Greene's, (6 - tr M)/4, M the monodromy matrix.  ``kind``: hyperbolic, elliptic or inverse
    hyperbolic, of the linear motion on this level alone.  ``unique_within``: a periodic motion of
    the level that passes within these distances of the point (Euclidean norms of omega and gamma)
    and whose period is within this distance of ``period`` is this orbit.  ``digits``: proven ones
    of start and period.  ``bits``: of the certificate's polynomials; ``runs``: of the checker,
    until it proved a certificate with the digits wanted; ``seconds``: CPU time.  ``certificate``:
    the JSON text that ``polhode verify`` checks.

    >>> import polhode
    >>> found = polhode.prove_orbit("grioli/precession")
    >>> found.kind, str(found.residue)[:8]
    ('elliptic', '0.002448')
    >>> found.unique_within.period > 1e-26
    True
    """

    scene: Scene
    h: Exact
    f: Exact
    period: Ball
    omega: tuple[Ball, ...]
    gamma: tuple[Ball, ...]
    residue: Ball
    kind: str
    unique_within: Within
    digits: float
    bits: int
    runs: int
    seconds: float = field(compare=False)
    certificate: str
    provenance: Mapping[str, object] = field(default_factory=dict, compare=False)

    @property
    def multipliers(self) -> tuple[tuple[Ball, Ball], tuple[Ball, Ball]]:
        """Real and imaginary part of the two that may differ from 1; their product is 1."""
        with ctx.workprec(self.bits + 128):
            r = as_arb(self.residue)
            half, square = 1 - 2 * r, 4 * r * (r - 1)  # mu + 1/mu = 2 half, square = half**2 - 1
            zero = Ball(Fraction(0), 0.0)
            if self.kind == "elliptic":
                side = ball_of((-square).sqrt())
                middle = ball_of(half)
                return (middle, side), (middle, Ball(-side.centre, side.radius))
            root = square.sqrt()
            first = half + root if self.kind == "hyperbolic" else half - root
            return (ball_of(first), zero), (ball_of(1 / first), zero)

    @property
    def near(self) -> Scene:
        """A scene that starts in the middle of the balls and ends after about one period."""
        p, q, r = (x.centre for x in self.omega)
        a, b, c = (x.centre for x in self.gamma)
        scene = replace(self.scene, omega=(p, q, r), gamma=(a, b, c), normalise=True)
        return scene.at([self.period.centre])

    def table(self) -> Table:
        """One row: period, residue and a point of the orbit, as balls."""
        state = [*self.omega, *self.gamma]
        return Table(
            [
                Column("orbit", [1]),
                Column("kind", [self.kind], "of its stability"),
                Column("period", [self.period], "the least", unit_of(self.scene, "t")),
                Column("residue", [self.residue], "Greene's"),
                *(
                    column._replace(type=cells.EXACT)
                    for column in row_columns(self.scene, STATE, [state], DOUBLE)
                ),
            ]
        )

    def facts(self) -> list[Fact]:
        """The theorem, its numbers as balls, and what it took."""
        near, pairs = self.unique_within, self.multipliers
        real, imaginary = zip(*pairs, strict=True)
        multipliers = [Column("real", real), Column("imaginary", imaginary)]
        return [
            *scene_facts(self.scene),
            Fact("proven", True),
            Fact("theorem", self.theorem),
            Fact("h", self.h, "energy"),
            Fact("f", self.f, "vertical momentum"),
            Fact("period", self.period, "the least", unit_of(self.scene, "t")),
            Fact("kind", self.kind, "of its stability"),
            Fact("residue", self.residue, "Greene's"),
            Fact("multipliers", Table(multipliers, 0), "that may differ from 1"),
            *(Fact(f"unique_within_{k}", x, "lower bound") for k, x in near._asdict().items()),
            Fact("digits_proven", self.digits),
            Fact("bits", self.bits, "of the certificate's polynomials"),
            Fact("runs", self.runs, "of the checker"),
            provenance_fact(self.provenance),
        ]

    def __repr__(self) -> str:
        name, period = self.scene.name, float(self.period)
        return f"<ProvedOrbit of {name}: period {period:.6g}, {self.kind}>"

    def __str__(self) -> str:
        """The numbers, a line each, and the theorem."""
        near, multipliers = self.unique_within, []
        for real, imaginary in self.multipliers:
            sign, size = "-" if imaginary.centre < 0 else "+", str(imaginary).lstrip("-")
            multipliers.append(f"{real} {sign} {size} i" if imaginary.centre else str(real))
        lines = [
            f"period      {self.period}",
            f"omega       {', '.join(map(str, self.omega))}",
            f"gamma       {', '.join(map(str, self.gamma))}",
            f"level       {self.level}",
            f"residue     {self.residue}, {self.kind}",
            *(f"multiplier  {text}" for text in multipliers),
            f"alone       within {down(near.omega)} of omega and {down(near.gamma)} of gamma, "
            f"with a period within {down(near.period)}",
        ]
        return "\n".join([*lines, self.theorem])

    @property
    def theorem(self) -> str:
        """The theorem in words."""
        near, (middle, radius) = self.unique_within, self.period.decimals
        mu = self.multipliers[0]
        side = f" + {mu[1]} i" if self.kind == "elliptic" else ""
        return (
            f"proved: on the level {self.level} exactly one periodic orbit with a "
            f"period within {down(near.period)} of {self.period} passes within "
            f"{down(near.omega)} and {down(near.gamma)} of {self.point}; its least period is "
            f"{middle} +- {radius}; {self.kind}, multiplier {mu[0]}{side}"
        )

    @property
    def point(self) -> str:
        """A point of the orbit in words."""
        vectors = {"omega": self.omega, "gamma": self.gamma}
        return " and ".join(f"{name} ({', '.join(map(str, v))})" for name, v in vectors.items())

    @property
    def level(self) -> str:
        """h and f in words; irrational ones rounded."""
        return ", ".join(
            f"{name} = {shown(x)}" + " (rounded)" * (not isinstance(x, Fraction))
            for name, x in (("h", self.h), ("f", self.f))
        )


def _below(x: arb) -> float:
    """A double not above a positive number; 0 where that is none."""
    low = float(x.lower()) * (1.0 - 1e-9)
    return low if math.isfinite(low) else 0.0


def ball_of(x: arb) -> Ball:
    """A ball with a radius that is a double."""
    return Ball(middle(x), upper(x - x.mid()))


def as_arb(x: Ball) -> arb:
    """A ball of FLINT's that holds this one."""
    return as_ball(x.centre) + arb(0, x.radius)


def down(value: float) -> str:
    """A positive bound as a decimal of two digits that is not above it."""
    return verify.decimal(Fraction(value), up=False, minus=False)


def up(value: float) -> str:
    """A bound as a decimal of six digits that is not below it."""
    return f"{float(_CEILING.create_decimal(value)):.6g}"


# --- prove orbit ----------------------------------------------------------------------------------


DIGITS = 30
MOST_DIGITS = 200


@with_options(NearOrbit)
@with_progress
def prove_orbit(
    scene: Scene | str | Path,
    orbit: Orbit | Scene | str | Path | None = None,
    digits: int = DIGITS,
    **near: Unpack[NearOrbit],
) -> ProvedOrbit:
    """Prove that a periodic orbit exists, and where: start, period, residue, multipliers, kind.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, a path, or the name of a case: its body, and the level unless that is given.
    orbit : Orbit, Scene, str or Path, optional
        A guess: an orbit of the scene's body, as :func:`polhode.orbit` gives it, or a scene that
        ends after one period.  Without one, an orbit near the scene's start is searched for.
    digits : int
        The digits wanted of start and period (30, at most 200).

    Returns
    -------
    ProvedOrbit
        What is proved, as balls in the scene's body axes and units.

    Raises
    ------
    NotProved
        Which condition failed, and by how much.
    BadInput
        A level that does not exist, a period that cannot be.

    Notes
    -----
    The theorem and where each step is in the code: ``polhode guide proofs``.

    Examples
    --------
    >>> import polhode
    >>> found = polhode.prove_orbit("grioli/precession")
    >>> found
    <ProvedOrbit of grioli/precession: period 6.28319, elliptic>
    >>> print(str(found.period)[:32])  # 2 pi
    6.283185307179586476925286766559
    """
    refuse_unknown("prove_orbit", prove_orbit, near)
    scene = library.load(scene, takes=REQUESTS)
    digit_count = whole(scene.name, "digits", digits, 1, MOST_DIGITS)
    if orbit is None:
        orbit = approximate(scene, **near)
    elif near.get("period") is not None or near.get("returns") is not None:
        raise BadInput(scene.name, "orbit", None, "no period, returns with it")
    on = level_of(scene, near.get("h"), near.get("f"))
    return theorem_of(on, closed_orbit(on, orbit), digit_count, near.get("progress"))


def closed_orbit(on: LevelBody, guess: Orbit | Scene | str | Path) -> Closed:
    """An approximate orbit of a level, in double; raises BadInput, NotProved."""
    if not isinstance(guess, Orbit):
        return closed_near(on, library.load(guess, takes=REQUESTS))
    levels = [(x.scene.body, x.h, x.f, x.unit) for x in (guess.surface, on)]
    return guess.closed if levels[0] == levels[1] else closed_near(on, guess.scene)


def theorem_of(
    on: LevelBody, orbit: Closed, digits: int, progress: Message | None = None
) -> ProvedOrbit:
    """The theorem of an approximate orbit; raises NotProved."""
    began, name, tests = time.process_time(), on.scene.name, verify.STABILITY.items()
    zero, guesses, proven_digits, runs = proof_of(on, orbit, digits, progress)
    kind = next((word for word, test in tests if test(zero.residue) is True), None)
    if kind is None:
        line = f"the residue {zero.residue.str(6)} may be 0 or 1: a multiplier may be 1 or -1"
        raise NotProved(f"{name}: {line}; try more digits")
    within = Within(*map(_below, zero.alone))
    if not min(within) > 0.0:
        raise NotProved(f"{name}: the box is no larger than the error of its centre")
    state = [ball_of(x) for x in zero.start]
    period, residue = ball_of(zero.period), ball_of(zero.residue)
    statement: JsonObject = {
        "kind": kind,
        "start": [list(x.decimals) for x in state],
        "period": list(period.decimals),
        "residue": list(residue.decimals),
        "least": True,
        "alone": [down(x) for x in within],
    }
    bits = int(str(guesses["bits"]))
    claim = verify.read_orbit(statement)
    by_checker(verify.check_orbit, claim, zero, bits=bits + verify.COARSE)
    return ProvedOrbit(
        on.scene,
        on.h,
        on.f,
        period,
        tuple(state[:3]),
        tuple(state[3:]),
        residue,
        kind,
        within,
        proven_digits,
        bits,
        runs,
        time.process_time() - began,
        json.dumps({**guesses, "statement": statement}),
        on.scene.provenance(),
    )


# --- prove orbits ---------------------------------------------------------------------------------
#
# ``polhode.prove_orbits``: the periodic orbits that a search of a level finds, each proved.


@dataclass(frozen=True, repr=False, eq=False)
class ProvedOrbits(Result, ByValue):
    """The orbits of a search, and of each its proof, or why there is none.

    ``search``: what was found, by increasing period.  ``proofs``: a :class:`ProvedOrbit` or a
    :class:`NotProved` for each.

    >>> import polhode
    >>> polhode.prove_orbits("general/asymmetric-regular", (4, 4), crossings=1)
    <ProvedOrbits of general/asymmetric-regular: 1 of 1 proved>
    """

    search: OrbitSearch
    proofs: tuple[ProvedOrbit | NotProved, ...]

    @property
    def scene(self) -> Scene:
        """The scene on whose level they are."""
        return self.search.scene

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C ended the search."""
        return self.search.interrupted

    @property
    def complete(self) -> bool:
        """Whether all guesses were tried, and nothing was refused."""
        return not self.interrupted and all(isinstance(x, ProvedOrbit) for x in self.proofs)

    def table(self) -> Table:
        """One row per orbit: what the search found of it, and whether it is proved."""
        proved = [isinstance(x, ProvedOrbit) for x in self.proofs]
        digits = [x.digits if isinstance(x, ProvedOrbit) else None for x in self.proofs]
        causes = ["" if isinstance(x, ProvedOrbit) else str(x) for x in self.proofs]
        return Table(
            [
                *self.search.table().columns,
                Column("proven", proved, type=cells.TRUTH),
                Column("digits_proven", digits, "of start and period", type=cells.DOUBLE),
                Column("cause", causes, "why it is not proved", type=cells.TEXT),
            ]
        )

    def facts(self) -> list[Fact]:
        """The level, and how many guesses were tried."""
        meaning = "whether all guesses were tried, and all is proved"
        complete = Fact("complete", self.complete, meaning)
        return [complete if x.name == complete.name else x for x in self.search.facts()]

    def __repr__(self) -> str:
        count = sum(isinstance(x, ProvedOrbit) for x in self.proofs)
        return f"<ProvedOrbits of {self.scene.name}: {count} of {len(self.proofs)} proved>"

    def __str__(self) -> str:
        rows = [[str(k), _line(proof)] for k, proof in enumerate(self.proofs, 1)]
        return "\n".join(aligned(["orbit", "proof"], rows))


def _line(proof: ProvedOrbit | NotProved) -> str:
    if isinstance(proof, NotProved):
        return f"not proved: {proof}"
    period, radius = proof.period.decimals
    return f"proved: {proof.kind}, least period {period} +- {radius}, residue {proof.residue}"


@with_progress
def prove_orbits(
    scene: Scene | str | Path,
    grid: tuple[int, int] | None = None,
    crossings: int | None = None,
    h: AnyNumber | None = None,
    f: AnyNumber | None = None,
    digits: int = DIGITS,
    progress: Message | None = None,
) -> ProvedOrbits:
    """Prove the periodic orbits that a search of a level finds; others may be missed.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, a path, or the name of a case.
    grid : tuple of int, optional
        The cells of the section's coordinates l and L/G (20x20 unless given).
    crossings : int, optional
        The largest number of crossings in a period (3 unless given).
    h, f : number, optional
        The level's energy h or vertical momentum f, exact, if not the scene's.
    digits : int
        The digits wanted of start and period (30, at most 200).
    progress : callable, optional
        Called with a line of text now and then.

    Returns
    -------
    ProvedOrbits
        The orbits, and of each its proof or why there is none.

    Raises
    ------
    BadInput
        A level that does not exist.

    Examples
    --------
    >>> import polhode
    >>> found = polhode.prove_orbits("general/asymmetric-regular", (4, 4), crossings=1)
    >>> found.column("proven"), found.proofs[0].kind
    ([True], 'elliptic')
    """
    scene = library.load(scene, takes=REQUESTS)
    digit_count = whole(scene.name, "digits", digits, 1, MOST_DIGITS)
    search = orbit_search(scene, grid, crossings, h, f, progress)
    proofs: list[ProvedOrbit | NotProved] = []
    for orbit in search.closed:
        try:
            proofs.append(theorem_of(search.surface, orbit, digit_count))
        except NotProved as why:
            proofs.append(why)
    return ProvedOrbits(search, tuple(proofs))

"""A proved periodic orbit: the theorem in the scene's axes and units."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from fractions import Fraction
from typing import NamedTuple

from flint import arb

from polhode.certificates import orbit_certificate, verify
from polhode.certificates.certificate_file import Made
from polhode.common.values import ByValue
from polhode.dynamics.level_body import LevelBody
from polhode.enclosures.fixed_point_problem import upper
from polhode.enclosures.polynomial import ball
from polhode.numbers.decimals import Ball, brief, shown
from polhode.numbers.exact import Exact, as_ball
from polhode.numbers.flint_context import ctx
from polhode.numbers.number_types import DOUBLE
from polhode.numbers.polynomials import middle
from polhode.proofs import certified_orbit
from polhode.proofs.proved_result import ProvedResult
from polhode.proofs.refusals import NotProved
from polhode.results.cells import EXACT
from polhode.results.table import Column, Fact, Table
from polhode.scenes.body import PrincipalAxes
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import provenance_fact, row_columns, scene_facts, unit_of
from polhode.scenes.vocabulary import STATE

_FLOOR = Context(prec=2, rounding=ROUND_FLOOR)
_CEILING = Context(prec=6, rounding=ROUND_CEILING)
_TURN_BITS = 256  # of a state of many bodies, which has few digits


class Within(NamedTuple):
    """How near a motion passes by, and how near its period is; lower bounds."""

    omega: float
    gamma: float
    period: float


@dataclass(frozen=True, eq=False, repr=False)
class ProvedOrbit(ProvedResult, ByValue):
    """A periodic orbit of (omega, gamma) that exists: a theorem about the exact level.

    ``scene``, ``h``, ``f``: the body and the level, exact.  ``period``: the least one; ``omega``,
    ``gamma``: a point of the orbit; both in the scene's body axes and units.  ``residue``:
    Greene's, (6 - tr M)/4, M the monodromy matrix.  ``kind``: hyperbolic, elliptic or inverse
    hyperbolic, of the linear motion on this level alone.  ``unique_within``: a periodic motion of
    the level that passes within these distances of the point (Euclidean norms of omega and gamma)
    and whose period is within this distance of ``period`` is this orbit.  ``digits``: proven ones
    of start and period.  ``bits``: of the certificate's polynomials; ``runs``: of the checker,
    until it proved a certificate with the digits wanted; ``seconds``: CPU time.  ``certificate``:
    the JSON text that ``polhode verify`` checks.  ``tolerance``: relative, of every moment and
    every component of Mg r0 in principal axes; the theorem then holds for each body within it, and
    the balls for all of them.

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
    tolerance: Fraction = Fraction(0)

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
                    column._replace(type=EXACT)
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
            Fact("tolerance", self.tolerance, "of the body's numbers, relative"),
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
            *([f"bodies      {self.bodies.rstrip(', ')}"] if self.tolerance else []),
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
        point = " and ".join(
            f"{name} ({', '.join(map(str, balls))})"
            for name, balls in (("omega", self.omega), ("gamma", self.gamma))
        )
        mu = self.multipliers[0]
        side = f" + {mu[1]} i" if self.kind == "elliptic" else ""
        return (
            f"proved: {self.bodies}on the level {self.level} exactly one periodic orbit with a "
            f"period within {down(near.period)} of {self.period} passes within "
            f"{down(near.omega)} and {down(near.gamma)} of {point}; its least period is {middle} "
            f"+- {radius}; {self.kind}, multiplier {mu[0]}{side}"
        )

    @property
    def bodies(self) -> str:
        """Of which bodies, in words; empty for the scene's alone."""
        if not self.tolerance:
            return ""
        return (
            "for every body whose moments and components of Mg r0, in principal axes, are within "
            f"{brief(self.tolerance)} (relative) of the scene's, "
        )

    @property
    def level(self) -> str:
        """h and f in words; irrational ones rounded."""
        return ", ".join(
            f"{name} = {shown(x)}" + " (rounded)" * (not isinstance(x, Fraction))
            for name, x in (("h", self.h), ("f", self.f))
        )


def of_proof(
    on: LevelBody, proof: certified_orbit.OrbitProof, tolerance: Fraction, seconds: float
) -> ProvedOrbit:
    """What the checker proved, stated in its certificate; raises NotProved."""
    zero, name = proof.zero, on.scene.name
    tests = verify.STABILITY.items()
    kind = next((word for word, test in tests if test(zero.residue) is True), None)
    if kind is None:
        line = f"the residue {zero.residue.str(6)} may be 0 or 1: a multiplier may be 1 or -1"
        raise NotProved(f"{name}: {line}; try more digits")
    within = Within(*map(_below, zero.alone))
    if not min(within) > 0.0:
        raise NotProved(f"{name}: the box is no larger than the error of its centre")
    state = [ball_of(x) for x in zero.start]
    period, residue = ball_of(zero.period), ball_of(zero.residue)
    statement: Made = {
        "kind": kind,
        "start": [list(x.decimals) for x in state],
        "period": list(period.decimals),
        "residue": list(residue.decimals),
        "least": True,
        "alone": [down(x) for x in within],
    }
    certificate = orbit_certificate.stated(proof.made, statement, zero)
    if tolerance:
        state = [ball_of(x) for x in _in_scene_axes(on.scene.body.axes, zero.start)]
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
        proof.digits,
        int(str(certificate["bits"])),
        proof.runs,
        seconds,
        json.dumps(certificate),
        on.scene.provenance(),
        tolerance,
    )


def _in_scene_axes(axes: PrincipalAxes, start: Sequence[arb]) -> list[arb]:
    """A state of principal axes."""
    if axes.trivial:
        return [*start]
    turn = [[ball(x, _TURN_BITS) for x in unit] for unit in axes.rows]
    with ctx.workprec(_TURN_BITS):
        return [
            turn[0][i] * x + turn[1][i] * y + turn[2][i] * z
            for x, y, z in (start[:3], start[3:])
            for i in range(3)
        ]


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
    return f"{float(_FLOOR.create_decimal(value)):.1e}"


def up(value: float) -> str:
    """A bound as a decimal of six digits that is not below it."""
    return f"{float(_CEILING.create_decimal(value)):.6g}"

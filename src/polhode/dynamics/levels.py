"""The levels (h, f) of a body in closed form: permanent rotations, regions, where a scene lies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from flint import arb, arb_poly, fmpq_poly

from polhode.common.arguments import each
from polhode.common.errors import BadInput, aligned, counted
from polhode.common.values import ByValue, cached_property
from polhode.dynamics import exact_levels
from polhode.dynamics.exact_levels import RationalBody, Region
from polhode.dynamics.level_body import LevelBody
from polhode.equations.integrals import exact_values, first_integrals
from polhode.motion.frame import Frame
from polhode.numbers.conversion import AREA, reader, to_double
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact
from polhode.numbers.flint_context import ctx
from polhode.numbers.mpmath_context import mpf
from polhode.numbers.number_types import AnyNumber, Doubles
from polhode.numbers.polynomials import fraction_near, middle, nearest, rational, real_roots
from polhode.results.result import Result
from polhode.results.table import Column, Fact, Table
from polhode.scenes import body as classification
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import provenance_fact, scene_facts, text_column
from polhode.scenes.vocabulary import REQUESTS

# --- fourth integral ------------------------------------------------------------------------------
#
# Where the fourth integral of an integrable top is critical on a level (h, f).
#
# There its tori shrink to circles or points, or to what is asymptotic to them. T = Mg r0, C the
# moment about the axis of symmetry:
#
#     Euler            |G|^2 = 2hA, 2hB, 2hC;  |G|^2 = f^2: G vertical
#     Lagrange         L = C r at which A(1 - u^2)(2h - L^2/C - 2 T3 u) - (f - L u)^2, which is
#                      (A u')^2, has a double root u in [-1, 1]: steady precession, or, u = ±1,
#                      what is asymptotic to the vertical or stays there
#     Kovalevskaya     K^2 of Appelrot's four classes (G. G. Appelrot 1894), with H = h/C,
#                      a = |T|/C, m = f a/2C:  I: 0, if H >= 2m^2/a^2;  II (k1 > 0), III (k1 < 0):
#                      k1^2, k1 = H - 2m^2/a^2, if 4 k1 m^2 <= a^4;  IV: a^2 + 3s^2 + 2Hs,
#                      m^2 = -s(s + H)^2, s < 0
#     Goryachev-       F = 0 and 108 F^2 = (2h/C ± 2a)^3, on f = 0 alone
#     Chaplygin


class CriticalValue(NamedTuple):
    """A value at which the integral is critical, and the class of motions that have it."""

    value: float
    what: str


class FourthIntegral(NamedTuple):
    """``name``: |G|^2, L, K^2 or F; ``value``: the scene's own; ``critical``: ascending."""

    name: str
    value: float
    critical: tuple[CriticalValue, ...]


def fourth_integral(
    scene: Scene, body: RationalBody, h: Fraction, f: Fraction
) -> FourthIntegral | None:
    """Of a scene on the level (h, f); None where its body has no fourth integral there."""
    torque = scene.body.axes.components(scene.body.torque)
    top = classification.classical_top(scene.body.moments, torque)
    with ctx.workprec(exact_levels.BITS):
        size = arb(rational(body.heavy)).sqrt()
        values: Sequence[tuple[arb | Fraction, str]]
        if top.kind == classification.EULER:
            name, values = "|G|^2", _euler(body, h, f)
        elif top.kind in (classification.LAGRANGE, classification.SPHERE):
            name, values = "L", _lagrange(body, top.axis, size, h, f)
        elif top.kind == classification.KOVALEVSKAYA and top.axis is not None:
            name, values = "K^2", _kovalevskaya(body.moments[top.axis], body.heavy, h, f)
        elif top.kind == classification.CHAPLYGIN and top.axis is not None and f == 0:
            name, values = "F", _chaplygin(body.moments[top.axis], size, h)
        else:
            return None
    critical = sorted({CriticalValue(float(value), motions) for value, motions in values})
    return FourthIntegral(name, _own(scene, name, top.axis or 0), tuple(critical))


def _own(scene: Scene, name: str, axis: int) -> float:
    """The scene's value, in its own units."""
    frame = Frame.of(scene)
    inside = frame.inside(scene)
    integral: Exact = exact_values(inside, first_integrals(inside))[-1]
    unit, largest = frame.unit, max(scene.body.moments)
    if name == "|G|^2":
        return to_double(integral * (largest / unit) * (largest / unit))
    if name == "L":
        return to_double(integral / unit * scene.body.moments[axis])
    return to_double(integral / unit ** (4 if name == "K^2" else 3))


def _euler(body: RationalBody, h: Fraction, f: Fraction) -> list[tuple[Fraction, str]]:
    bounds = [2 * h * min(body.moments), 2 * h * max(body.moments)]
    values = [
        (2 * h * a, f"rotation about axis {i + 1}")
        for i, a in enumerate(body.moments)
        if 2 * h * a >= f * f
    ]
    return values + [(f * f, "G vertical")] * (bounds[0] <= f * f <= bounds[1])


def _lagrange(
    body: RationalBody, axis: int | None, torque: arb, h: Fraction, f: Fraction
) -> list[tuple[arb, str]]:
    """The axis is turned so that T3 > 0; a sphere's runs through its centre of mass."""
    k = 2 if axis is None else axis
    across, along = rational(body.moments[k - 1]), rational(body.moments[k])
    t = rational(middle(torque))
    spin = fmpq_poly([0, 1])
    energy = 2 * rational(h) - spin * spin / along
    area = rational(f)
    a = fmpq_poly([2 * t * across])
    b = -across * energy - spin * spin
    c = 2 * area * spin - 2 * t * across
    d = across * energy - area * area
    gap = 18 * a * b * c * d - 4 * b**3 * d + b**2 * c**2 - 4 * a * c**3 - 27 * a**2 * d**2
    values = []
    for root in real_roots(gap):
        at = root.ball
        ball = [_value(x, at) for x in (a, b, c, d)]
        below = 2 * (ball[1] ** 2 - 3 * ball[0] * ball[2])
        if below.contains(0):  # a triple root
            u = -ball[1] / (3 * ball[0])
        else:
            u = (9 * ball[0] * ball[3] - ball[1] * ball[2]) / below
        pole = [name for sign, name in ((1, "upright"), (-1, "hanging")) if u.overlaps(arb(sign))]
        if pole:
            values.append((at, f"{pole[0]}, or asymptotic to it"))
        elif abs(u) < 1:
            values.append((at, f"steady precession, u = {float(u):.6g}"))
    return values


def _kovalevskaya(
    c: Fraction, torque_square: Fraction, h: Fraction, f: Fraction
) -> list[tuple[arb | Fraction, str]]:
    energy, a2 = h / c, torque_square / (c * c)
    m2 = f * f * a2 / (4 * c * c)
    k1 = energy - 2 * m2 / a2
    values: list[tuple[arb | Fraction, str]] = []
    if k1 >= 0:
        values.append((Fraction(0), "I"))
    if k1 != 0 and 4 * k1 * m2 <= a2 * a2:
        values.append((k1 * k1, "II" if k1 > 0 else "III"))
    s = fmpq_poly([0, 1])
    cubic = s * (s + rational(energy)) ** 2 + rational(m2)
    for root in real_roots(cubic):
        value = _value(rational(a2) + 3 * s * s + 2 * rational(energy) * s, root.ball)
        if root.ball < 0 and not value < 0:
            values.append((value, "IV"))
    return values


def _chaplygin(c: Fraction, torque: arb, h: Fraction) -> list[tuple[arb, str]]:
    values = [(arb(0), "F = 0")]
    for sign in (1, -1):
        cube = (2 * rational(h / c) + sign * 2 * torque / rational(c)) ** 3 / 108
        if cube > 0:
            root = cube.sqrt()
            values += [(root, "edge"), (-root, "edge")]
    return values


def _value(polynomial: fmpq_poly, at: arb) -> arb:
    return arb_poly(polynomial)(at)


# --- levels ---------------------------------------------------------------------------------------


DIGIT_BITS = 128  # of what is isolated exactly: 38 digits
_MORSE = "directions on the sphere that lower the potential"
COLUMNS = 48  # of the regions of a diagram


class Mark(NamedTuple):
    """A special point: ``kind`` cusp, Hamiltonian-Hopf or branch; numbers to 38 digits.

    ``parameter``: s on the first family, om on a second one.  A branch is where a second family
    leaves the first.
    """

    kind: str
    family: str
    parameter: mpf
    f: mpf
    h: mpf


class Curve(NamedTuple):
    """A piece of an arc of one type: f and h along it, by rising parameter; f > 0.

    ``type``: centre-centre, centre-saddle, saddle-saddle, focus-focus or degenerate.  ``morse``:
    how many directions on the sphere lower W_f (0: stable by Liapunov); None where degenerate.
    ``axis``: of a second family, else None.  ``first``, ``last``: ends of the parameter, None for
    an infinite one.  ``points``: doubles (n, 2).
    """

    family: str
    axis: int | None
    type: str
    morse: int | None
    first: mpf | None
    last: mpf | None
    points: Doubles


class DiagramColumn(NamedTuple):
    """At one f: the energies of permanent rotations, ascending, and the region above each.

    Both empty where they are not decided.
    """

    f: float
    energies: tuple[float, ...]
    regions: tuple[Region, ...]


class Here(NamedTuple):
    """Where the scene lies.  ``region``: the edges of each part of U; None on a bifurcation.

    ``least``: the least energy at this f.  ``remark``: why there is no region, or empty.
    """

    f: Exact
    h: Exact
    least: float
    region: Region | None
    remark: str
    fourth: FourthIntegral | None


@dataclass(frozen=True, repr=False, eq=False)
class Levels(Result, ByValue):
    """The (f, h) diagram of a body, and where a scene lies in it; f and -f mirror each other.

    h and f are in the scene's units.  ``exact``: whether the body's numbers and the scene's level
    are rational, so that types, cusps and regions are decided for them and not for numbers rounded
    to 1024 bits.

    >>> import polhode
    >>> found = polhode.levels("general/asymmetric-chaotic")
    >>> [round(float(mark.f), 9) for mark in found.cusps]
    [1.624935039, 1.995702802]
    >>> found.here.region
    (1,)
    """

    scene: Scene
    curves: tuple[Curve, ...]
    marks: tuple[Mark, ...]
    here: Here
    exact: bool
    provenance: Mapping[str, object] = field(default_factory=dict)

    def __repr__(self) -> str:
        curves = counted(len(self.curves), "curve")
        return f"<Levels of {self.scene.name}: {curves}, {counted(len(self.cusps), 'cusp')}>"

    def __str__(self) -> str:
        """Special points, branches, and lines about the scene."""
        lines: list[str] = []
        rows = [
            [x.kind, x.family, *(f"{float(y):.12g}" for y in (x.parameter, x.f, x.h))]
            for x in self.marks
        ]
        if rows:
            lines += aligned(["special point", "family", "s or om", "f", "h"], rows)
        rows = [
            [
                x.family + ("" if x.axis is None else f" (axis {x.axis + 1})"),
                x.type + (", Liapunov stable" if x.morse == 0 else ""),
                "-inf" if x.first is None else f"{float(x.first):.6g}",
                "inf" if x.last is None else f"{float(x.last):.6g}",
            ]
            for x in self.curves
        ]
        lines += aligned(["permanent rotations", "type", "from s or om", "to"], rows)
        here = self.here
        edges = "" if here.region is None else f": edges {', '.join(map(str, here.region))}"
        least = f"least h at this f {here.least:.12g}"
        lines.append(f"scene  f = {shown(here.f)}, h = {shown(here.h)}, {least}")
        remark = here.remark and f" ({here.remark})"
        lines.append(f"level  {topology(here.region)}{edges}{remark}")
        if here.fourth is not None:
            name, own = here.fourth.name, here.fourth.value
            lines.append(f"fourth integral  {name} = {own:.12g}; critical:")
            lines += (f"  {value.value:<20.12g}{value.what}" for value in here.fourth.critical)
        if not self.exact:
            lines.append("irrational numbers of the body, or h and f, were rounded to 1024 bits")
        return "\n".join(lines)

    @cached_property
    def _body(self) -> RationalBody:
        return RationalBody.of(self.scene.body)

    @property
    def cusps(self) -> tuple[Mark, ...]:
        """The cusps, where two permanent rotations meet."""
        return tuple(mark for mark in self.marks if mark.kind == exact_levels.CUSP)

    def table(self) -> Table:
        """One row per point of the branches of permanent rotations."""
        sizes = [len(curve.points) for curve in self.curves]
        each = np.repeat(np.arange(len(sizes)), sizes)
        points = np.concatenate([np.empty((0, 2)), *(curve.points for curve in self.curves)])
        places = [k for size in sizes for k in range(1, size + 1)]
        return Table(
            [
                Column("arc", each + 1),
                Column("point", np.array(places, dtype=np.int64), "of its arc"),
                text_column("family", [self.curves[k].family for k in each.tolist()]),
                text_column("type", [self.curves[k].type for k in each.tolist()]),
                Column("f", points[:, 0], "vertical momentum"),
                Column("h", points[:, 1], "energy"),
            ],
            2,
        )

    def facts(self) -> list[Fact]:
        """Where the scene lies, the arcs, and their special points."""
        here, fourth = self.here, []
        region = None if here.region is None else list(here.region)
        if here.fourth is not None:
            critical = [
                Column("value", [x.value for x in here.fourth.critical]),
                text_column("what", [x.what for x in here.fourth.critical]),
            ]
            fourth = [
                Fact("fourth", here.fourth.value, "the fourth integral"),
                Fact("fourth_name", here.fourth.name),
                Fact("critical", Table(critical), "its critical values"),
            ]
        return [
            *scene_facts(self.scene),
            Fact("f", here.f, "vertical momentum of the scene"),
            Fact("h", here.h, "energy of the scene"),
            Fact("least_h", here.least, "least energy at this f"),
            Fact("region", region, "edges of each part"),
            Fact("topology", topology(here.region), "of the level"),
            Fact("remark", here.remark, "why there is no region"),
            *fourth,
            Fact("exact", self.exact, "whether all is decided exactly"),
            Fact("arcs", self._arcs()),
            Fact("marks", self._marks(), "cusps, branches, Hamiltonian-Hopf bifurcations"),
            provenance_fact(self.provenance),
        ]

    def _arcs(self) -> Table:
        curves, word = self.curves, f"{DIGIT_BITS} bits"
        return Table(
            [
                Column("arc", [*range(1, len(curves) + 1)]),
                text_column("family", [x.family for x in curves]),
                Column("axis", [None if x.axis is None else x.axis + 1 for x in curves]),
                text_column("type", [x.type for x in curves]),
                Column("morse_index", [x.morse for x in curves], _MORSE),
                Column("first", [x.first for x in curves], "of the parameter", type=word),
                Column("last", [x.last for x in curves], "of the parameter", type=word),
            ]
        )

    def _marks(self) -> Table:
        word = f"{DIGIT_BITS} bits"
        names = ("parameter", "f", "h")
        return Table(
            [
                text_column("kind", [x.kind for x in self.marks]),
                text_column("family", [x.family for x in self.marks]),
                *(
                    Column(name, [getattr(x, name) for x in self.marks], type=word)
                    for name in names
                ),
            ],
            0,
        )

    def regions(self, f: AnyNumber) -> list[tuple[float, Region]]:
        """At one f: the energies of permanent rotations, ascending, and the region above each.

        Energies of rotations that meet at this f are listed once.  Raises BadInput where regions
        are not decided, such as f = 0 of a free body, where every position is a rotation's.
        """
        (area,) = each(self.scene.name, "f", (f,), reader(self.scene.units, AREA), "a number")
        near = fraction_near(area, exact_levels.BODY_BITS)[0]
        exact_levels.refuse_far(self.scene.name, "f", self._body, near)
        try:
            return exact_levels.regions_between(self._body, near)
        except exact_levels.Undecided as fault:
            expected = f"an f at which the regions are decided ({fault})"
            raise BadInput(self.scene.name, "f", shown(area), expected) from None

    def columns(self, first: float, last: float, count: int = COLUMNS) -> list[DiagramColumn]:
        """The regions at ``count`` evenly spaced f; none in a column where they are not decided."""
        body, columns = self._body, []
        for end in (first, last):
            exact_levels.refuse_far(self.scene.name, "f", body, Fraction(end))
        step = (Fraction(last) - Fraction(first)) / max(1, count - 1)
        for f in (Fraction(first) + k * step for k in range(count)):
            pairs: tuple[Any, ...] = ((), ())
            with suppress(exact_levels.Undecided):
                pairs = (*zip(*exact_levels.regions_between(body, f), strict=True),)
            columns.append(DiagramColumn(float(f), *pairs))
        return columns


def topology(region: Region | None) -> str:
    """The level's manifold in words, a part at a time."""
    if region is None:
        return "not decided"
    names = {0: "RP3", 1: "S3", 2: "S2 x S1"}
    parts = [names.get(k, f"sum of {k - 1} S2 x S1") for k in region]
    return " and ".join(parts) if parts else "none"


def levels(scene: Scene | str | Path) -> Levels:
    """Compute the (f, h) diagram of a scene's body in closed form, and the scene's place in it.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene with gamma, a path, or the name of a case.

    Returns
    -------
    Levels
        The branches of permanent rotations, the regions between them, and ``here``: the scene's
        region, its f and h, and critical values of its fourth integral where it has one.

    Raises
    ------
    BadInput
        A scene without gamma, which has no f.

    Examples
    --------
    >>> import polhode
    >>> here = polhode.levels("kovalevskaya/delaunay").here
    >>> here.region, here.fourth.name, here.fourth.critical[0]
    ((1,), 'K^2', CriticalValue(value=0.0, what='I'))
    """
    scene = library.load(scene, takes=REQUESTS)
    if scene.gamma is None:
        raise BadInput(scene.name, "start.gamma", None, "a unit vector, since a level has h and f")
    body = RationalBody.of(scene.body)
    area = scene.integrals.area
    assert area is not None
    exact_levels.refuse_far(
        scene.name, "start: f", body, fraction_near(area, exact_levels.BODY_BITS)[0]
    )
    curves = tuple(_curve(family, piece) for family in body.families for piece in family.pieces)
    marks = tuple(
        _mark(family, end)
        for family in body.families
        for end in family.ends
        if end.kind not in (exact_levels.POLE, exact_levels.START)
    )
    here, exact = _here(scene, body)
    return Levels(scene, curves, marks, here, body.exact and exact, scene.provenance())


def _curve(family: exact_levels.RotationFamily, piece: exact_levels.Piece) -> Curve:
    ends = [None if end is None else _parameter(family, end) for end in (piece.first, piece.last)]
    points = family.points(piece)
    return Curve(family.name, family.axis, piece.type, piece.morse, ends[0], ends[1], points)


def _mark(family: exact_levels.RotationFamily, end: exact_levels.PieceEnd) -> Mark:
    with ctx.workprec(exact_levels.BITS):
        point = family.at(end.x)
    f, h = (nearest(x, DIGIT_BITS) for x in (point.f, point.h))
    return Mark(end.kind, family.name, _parameter(family, end), f, h)


def _parameter(family: exact_levels.RotationFamily, end: exact_levels.PieceEnd) -> mpf:
    with ctx.workprec(exact_levels.BITS):
        return nearest(family.parameter(end.x), DIGIT_BITS)


def _here(scene: Scene, body: RationalBody) -> tuple[Here, bool]:
    own = LevelBody.of(scene)
    (h, h_exact), (f, f_exact) = (fraction_near(x, exact_levels.BODY_BITS) for x in (own.h, own.f))
    region, remark = None, ""
    try:
        region = exact_levels.region(body, h, f)
    except exact_levels.Undecided as fault:
        remark = str(fault)
    least = exact_levels.least_energy(body, f)
    fourth = fourth_integral(scene, body, h, f)
    return Here(own.f, own.h, least, region, remark, fourth), h_exact and f_exact

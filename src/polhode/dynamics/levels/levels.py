"""The levels (h, f) of a body in closed form: permanent rotations, regions, where a scene lies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

from polhode.common.arguments import each
from polhode.common.errors import BadInput, counted
from polhode.common.values import ByValue
from polhode.dynamics.levels import permanent_rotations, regions
from polhode.dynamics.levels.fourth_integral import FourthIntegral, fourth_integral
from polhode.dynamics.levels.permanent_rotations import POLE, START, End, Family, Piece
from polhode.dynamics.levels.rational_body import (
    BITS,
    BODY_BITS,
    RationalBody,
    refuse_far,
    simplest,
)
from polhode.dynamics.levels.regions import Region, Undecided
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact
from polhode.numbers.flint_context import ctx
from polhode.numbers.mpmath_context import mpf
from polhode.numbers.polynomials import fraction_near, nearest
from polhode.numbers.rows import Doubles
from polhode.numbers.scalars import AnyNumber
from polhode.results import table as told
from polhode.results.result import Result
from polhode.results.table import Fact, Table
from polhode.scenes import library
from polhode.scenes.given_numbers import AREA, reader
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import provenance_fact, scene_facts, text_column
from polhode.scenes.vocabulary import REQUESTS

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


class Column(NamedTuple):
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
        from polhode.dynamics.levels.report import report

        return report(self, topology(self.here.region))

    @property
    def cusps(self) -> tuple[Mark, ...]:
        """The cusps, where two permanent rotations meet."""
        return tuple(mark for mark in self.marks if mark.kind == permanent_rotations.CUSP)

    def table(self) -> Table:
        """One row per point of the branches of permanent rotations."""
        import numpy as np

        sizes = [len(curve.points) for curve in self.curves]
        each = np.repeat(np.arange(len(sizes)), sizes)
        points = np.concatenate([np.empty((0, 2)), *(curve.points for curve in self.curves)])
        places = [k for size in sizes for k in range(1, size + 1)]
        return Table(
            [
                told.Column("arc", each + 1),
                told.Column("point", np.array(places, dtype=np.int64), "of its arc"),
                text_column("family", [self.curves[k].family for k in each.tolist()]),
                text_column("type", [self.curves[k].type for k in each.tolist()]),
                told.Column("f", points[:, 0], "vertical momentum"),
                told.Column("h", points[:, 1], "energy"),
            ],
            2,
        )

    def facts(self) -> list[Fact]:
        """Where the scene lies, the arcs, and their special points."""
        here, fourth = self.here, []
        region = None if here.region is None else list(here.region)
        if here.fourth is not None:
            critical = [
                told.Column("value", [x.value for x in here.fourth.critical]),
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
                told.Column("arc", [*range(1, len(curves) + 1)]),
                text_column("family", [x.family for x in curves]),
                told.Column("axis", [None if x.axis is None else x.axis + 1 for x in curves]),
                text_column("type", [x.type for x in curves]),
                told.Column("morse_index", [x.morse for x in curves], _MORSE),
                told.Column("first", [x.first for x in curves], "of the parameter", type=word),
                told.Column("last", [x.last for x in curves], "of the parameter", type=word),
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
                    told.Column(name, [getattr(x, name) for x in self.marks], type=word)
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
        (given,) = each(self.scene.name, "f", (f,), reader(self.scene.units, AREA), "a number")
        near, body = fraction_near(given, BODY_BITS)[0], RationalBody.of(self.scene.body)
        refuse_far(self.scene.name, "f", body, near)
        try:
            return regions.regions_between(body, permanent_rotations.families(body), near)
        except Undecided as fault:
            expected = f"an f at which the regions are decided ({fault})"
            raise BadInput(self.scene.name, "f", shown(given), expected) from None

    def columns(self, first: float, last: float, count: int = COLUMNS) -> list[Column]:
        """The regions at ``count`` evenly spaced f; none in a column where they are not decided."""
        body = RationalBody.of(self.scene.body)
        for end in (first, last):
            refuse_far(self.scene.name, "f", body, Fraction(end))
        step = (Fraction(last) - Fraction(first)) / max(1, count - 1)
        families, found = permanent_rotations.families(body), []
        for f in (Fraction(first) + k * step for k in range(count)):
            pairs: tuple[Any, ...] = ((), ())
            with suppress(Undecided):
                pairs = (*zip(*regions.regions_between(body, families, f), strict=True),)
            found.append(Column(float(f), *pairs))
        return found


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
    refuse_far(scene.name, "start: f", body, fraction_near(area, BODY_BITS)[0])
    families = permanent_rotations.families(body)
    curves = tuple(_curve(family, piece) for family in families for piece in family.pieces)
    marks = tuple(
        _mark(family, end)
        for family in families
        for end in family.ends
        if end.kind not in (POLE, START)
    )
    here, exact = _here(scene, body, families)
    return Levels(scene, curves, marks, here, body.exact and exact, scene.provenance())


def _curve(family: Family, piece: Piece) -> Curve:
    ends = [None if end is None else _parameter(family, end) for end in (piece.first, piece.last)]
    points = family.points(piece)
    return Curve(family.name, family.axis, piece.type, piece.morse, ends[0], ends[1], points)


def _mark(family: Family, end: End) -> Mark:
    with ctx.workprec(BITS):
        point = family.at(end.x)
    f, h = (nearest(x, DIGIT_BITS) for x in (point.f, point.h))
    return Mark(end.kind, family.name, _parameter(family, end), f, h)


def _parameter(family: Family, end: End) -> mpf:
    with ctx.workprec(BITS):
        return nearest(family.parameter(end.x), DIGIT_BITS)


def _here(scene: Scene, body: RationalBody, families: Sequence[Family]) -> tuple[Here, bool]:
    energy, area = scene.integrals.energy, scene.integrals.area
    assert area is not None
    energy, area = simplest(energy), simplest(area)
    (h, h_exact), (f, f_exact) = (fraction_near(x, BODY_BITS) for x in (energy, area))
    region, remark = None, ""
    try:
        region = regions.region(body, families, h, f)
    except Undecided as fault:
        remark = str(fault)
    least = regions.least_energy(body, families, f)
    fourth = fourth_integral(scene, body, h, f)
    return Here(area, energy, least, region, remark, fourth), h_exact and f_exact

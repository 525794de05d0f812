"""A certificate of proved chaos: its statement, and the sets that its checker carries on."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

from flint import arb

from polhode.certificates import grid, verify
from polhode.certificates.certificate_file import Made, checked, write
from polhode.common.progress import Progress
from polhode.numbers.exact import ONE, Exact
from polhode.numbers.flint_context import ctx
from polhode.scenes.body import Body

_BITS = 80  # of the polynomials: far finer than the sets
_SCALE = 120  # bits of the charts' numbers
_STEPS = (
    0.045,
    0.03,
    0.03,
    0.02,
    0.02,
)  # of the radius of convergence: the noise is cubic in e^alpha
_TIME_BITS = 64


class Chart(NamedTuple):
    """In the scene's axes and units: c, the columns of E and K, a, as balls; eta."""

    centre: Sequence[arb]
    wide: Sequence[Sequence[arb]]
    deep: Sequence[Sequence[arb]]
    plane: Sequence[arb]
    eta: float


class Rectangle(NamedTuple):
    """The number of a set's chart, and its sizes."""

    chart: int
    middle: float
    width: float
    height: float


class Stated(NamedTuple):
    """What is to be proved: the level, the entropy and the times of both loops; the sets.

    ``times``: of each set's way to the next one's plane.
    """

    h: Exact
    f: Exact
    entropy: str
    short: str
    long: str
    charts: Sequence[Chart]
    sets: Sequence[Rectangle]
    times: Sequence[Fraction]


def save(
    name: str, body: Body, stated: Stated, path: str | Path, progress: Progress | None = None
) -> None:
    """Write the certificate of chaos of a body, checked before; raises BadInput."""
    write(path, json.dumps(certificate(name, body, stated, progress)))


def certificate(name: str, body: Body, stated: Stated, progress: Progress | None = None) -> Made:
    """The certificate as JSON's objects, checked; raises BadInput."""
    statement = {"entropy": stated.entropy, "short": stated.short, "long": stated.long}

    def made(bits: int, tried: int) -> Made:
        numbers = grid.body_numbers(body, bits + verify.COARSE)
        level = [grid.number(x, bits + verify.COARSE) for x in (stated.h, stated.f, ONE)]
        with ctx.workprec(bits + 2 * verify.COARSE):
            transits = [
                _transit(numbers, stated, n, bits, _STEPS[tried]) for n in range(len(stated.sets))
            ]
            charts = [_integers(x) for x in stated.charts]
            sets = [
                {"chart": x.chart} | {word: _nearest(arb(getattr(x, word))) for word in _SIZES}
                for x in stated.sets
            ]
        return {
            "format": verify.FORMAT,
            "kind": "chaos",
            "scene": {**numbers, "level": level},
            "bits": bits,
            "scale": _SCALE,
            "charts": charts,
            "sets": sets,
            "transits": transits,
            "statement": statement,
        }

    return checked(name, made, _BITS, progress)


_SIZES = ("middle", "width", "height")


def _transit(
    numbers: dict[str, object], stated: Stated, n: int, bits: int, part: float
) -> dict[str, object]:
    """Steps from the middle of a set to the next plane."""
    what = stated.sets[n]
    chart = stated.charts[what.chart]
    start = [
        (c + e * arb(what.middle)).mid() for c, e in zip(chart.centre, chart.wide[0], strict=True)
    ]
    found = grid.steps(numbers, start, stated.times[n], bits, _TIME_BITS, part)
    return {word: found[word] for word in verify.Guesses._fields[:-1]}


def _integers(chart: Chart) -> dict[str, object]:
    """A chart's numbers as the checker reads them, in rows."""
    return {
        "centre": [[_nearest(x)] for x in chart.centre],
        "wide": [[_nearest(x) for x in row] for row in zip(*chart.wide, strict=True)],
        "deep": [[_nearest(x) for x in row] for row in zip(*chart.deep, strict=True)],
        "plane": [[_nearest(x)] for x in chart.plane],
        "eta": [[math.floor(chart.eta * 2.0**_SCALE)]],
    }


def _nearest(x: arb) -> int:
    found = (x.mid() * arb(2) ** _SCALE + arb("0.5")).floor().mid().unique_fmpz()
    assert found is not None
    return int(found)

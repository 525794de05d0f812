"""A certificate of proved chaos: charts and sets near a homoclinic orbit, what the checker proves.

Nothing here is believed but the body's and the level's numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from flint import arb

from polhode.certificates import certificate_file, verify
from polhode.certificates.certificate_file import Made, by_checker
from polhode.common.interrupts import Progress
from polhode.numbers.exact import ONE, Exact
from polhode.numbers.flint_context import ctx
from polhode.numbers.number_types import Doubles
from polhode.scenes.body import Body

_BITS = 48  # of the polynomials: far finer than the sets
_SCALE = 120  # bits of the charts' numbers
_GROWTH = 1.0  # int |A| of a step: the noise is cubic in its exponential
_TIME_BITS = 64


class Chart(NamedTuple):
    """c, E (6, 2), K (6, 4), a, and eta, in the scene's axes and units."""

    centre: Doubles
    wide: Doubles
    deep: Doubles
    plane: Doubles
    eta: float


class Rectangle(NamedTuple):
    """The number of a set's chart, and its sizes."""

    chart: int
    middle: float
    width: float
    height: float


class Chain(NamedTuple):
    """A body and a level; N0, M1, ..., Mk, and the time from each to the plane of the next one."""

    body: Body
    h: Exact
    f: Exact
    charts: list[Chart]
    sets: list[Rectangle]
    times: list[float]


def guesses(chain: Chain) -> Made:
    """A certificate but for its statement."""
    bits = _BITS + verify.COARSE
    numbers = certificate_file.body_numbers(chain.body, bits)
    level = [certificate_file.number(x, bits) for x in (chain.h, chain.f, ONE)]
    with ctx.workprec(bits + verify.COARSE):
        transits = [_transit(numbers, chain, n) for n in range(len(chain.sets))]
    sizes = Rectangle._fields[1:]
    return {
        "format": verify.FORMAT,
        "kind": "chaos",
        "scene": {**numbers, "level": level},
        "bits": _BITS,
        "scale": _SCALE,
        "charts": [_integers(x) for x in chain.charts],
        "sets": [
            {"chart": x.chart} | {word: _nearest(getattr(x, word)) for word in sizes}
            for x in chain.sets
        ],
        "transits": transits,
    }


def proved(certificate: Made, progress: Progress | None = None) -> verify.Horseshoe:
    """What the checker proves of guesses; raises its NotProved."""
    return by_checker(verify.horseshoe, certificate, progress)


def passes(theorem: verify.Horseshoe, start: Sequence[arb], period: arb) -> None:
    """That a periodic motion is the one of the first set; raises the checker's NotProved."""
    by_checker(verify.is_orbit_of, theorem, start, period)


def stated(certificate: Made, statement: Made, theorem: verify.Horseshoe) -> Made:
    """The certificate with its statement, which the checker compares with what it proved."""
    by_checker(verify.check_chaos, verify.read_chaos(statement), theorem)
    return {**certificate, "statement": statement}


def _transit(numbers: Made, chain: Chain, n: int) -> Made:
    """Steps from the middle of a set to the next plane."""
    rectangle = chain.sets[n]
    chart = chain.charts[rectangle.chart]
    start = [arb(x) for x in (chart.centre + chart.wide[:, 0] * rectangle.middle).tolist()]
    end = Fraction(chain.times[n])
    numbers_of_steps = certificate_file.steps(
        numbers, start, end, _BITS, _TIME_BITS, growth=_GROWTH
    )
    return {word: numbers_of_steps[word] for word in verify.Guesses._fields[:-1]}


def _integers(chart: Chart) -> Made:
    """A chart's numbers as the checker reads them, in rows."""
    return {
        name: [[_nearest(x) for x in row] for row in np.reshape(value, shape).tolist()]
        for (name, value), shape in zip(chart._asdict().items(), verify.CHART.values(), strict=True)
    }


def _nearest(x: float) -> int:
    return int(x * 2.0**_SCALE)  # exact, but for what is below 2^-scale

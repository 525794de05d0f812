"""What a certificate of proved chaos is made of: the sets in the scene's axes and units.

Nothing of it is believed by who checks it, and it is rounded here and there: the sets of the
certificate are near those of the proof.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from flint import arb

from polhode.certificates.chaos_certificate import Chart, Rectangle, Stated
from polhode.enclosures.fixed_point_problem import Motion, in_scene_axes
from polhode.numbers.flint_context import ctx
from polhode.numbers.rows import Doubles
from polhode.proofs.chaos import h_set
from polhode.proofs.chaos.chain_candidate import NOISE
from polhode.proofs.chaos.theorem import Horseshoe
from polhode.proofs.chaos.transit import Image
from polhode.proofs.level import Level
from polhode.proofs.proved_orbit import down, up

_BITS = NOISE + 128
_LONGER = 1.0001  # a time that is stated, beside the one proved: its checker has other bounds


def stated(level: Level, proof: Horseshoe) -> Stated:
    """The statement and the sets of a proof."""
    chain, what = proof.chain, level.motion
    by = 2.0**what.unit
    sets = [chain.home, *chain.sets]
    charts: list[h_set.Chart] = []
    for one in sets:
        if not any(one.chart is chart for chart in charts):
            charts.append(one.chart)
    places = [next(k for k, x in enumerate(charts) if x is one.chart) for one in sets]
    return Stated(
        level.h,
        level.f,
        down(proof.entropy / by),
        up(float(proof.short.upper()) * by * _LONGER),
        up(float(proof.long.upper()) * by * _LONGER),
        [_chart(what, chart) for chart in charts],
        [
            Rectangle(place, one.middle, one.width, one.height)
            for place, one in zip(places, sets, strict=True)
        ],
        [_time(what, image) for image in chain.images],
    )


def _chart(what: Motion, chart: h_set.Chart) -> Chart:
    with ctx.workprec(_BITS):
        return Chart(
            in_scene_axes(what, chart.point, _BITS),
            _columns(what, chart.wide),
            _columns(what, chart.deep),
            _covector(what, chart.plane),
            chart.eta,
        )


def _columns(what: Motion, matrix: Doubles) -> list[Sequence[arb]]:
    return [in_scene_axes(what, [arb(x) for x in column], _BITS) for column in matrix.T.tolist()]


def _covector(what: Motion, row: Doubles) -> list[arb]:
    """a of a·x, turned; where x is divided by the unit, a is multiplied by it."""
    turned = in_scene_axes(what, [arb(x) for x in row.tolist()], _BITS)
    return [x * arb((1, 2 * what.unit)) for x in turned[:3]] + list(turned[3:])


def _time(what: Motion, image: Image) -> Fraction:
    """The middle of a transit's times, in the scene's unit."""
    middle = (float(image.least.mid()) + float(image.most.mid())) / 2
    return Fraction(middle) * Fraction(2) ** what.unit

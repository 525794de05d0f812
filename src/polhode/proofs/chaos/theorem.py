"""Chaos from covering relations: the theorem, and the entropy.

Trusted.  Theorem C.  Let N0 and M1 be disjoint and in one chart, N0 => N0 and N0 => M1 coverings of
*one* image of N0, so that both are of one section map, and M1 => M2 => ... => Mk => N0, all with
cones.  Then every path of the graph is followed by a motion of the level, every closed path by a
periodic one; each bi-infinite path is followed by exactly one motion, and the path
N0^inf M1 ... Mk N0^inf is a transversal homoclinic orbit of the periodic orbit in N0.

Of each point of N0 the section map tells whether N0 or M1 comes next, of the others the label does:
the point and its label determine the path.  So the labelled invariant set, compact, has the graph's
shift as a factor, and the flow's entropy is at least the root x > 0 of

    exp(-x tau_0) + exp(-x (tau_1 + ... )) = 1,                                              (1)

tau_0 an upper bound of the time N0 => N0, the others those of the loop (Abramov; a motion meets
each plane only finitely often in a time, since a·f is not 0 on the sets).  One image for both
coverings is essential: two different planes or times out of N0 may tell one motion by two paths,
and then nothing follows.
"""

from __future__ import annotations

from dataclasses import dataclass

from flint import arb

from polhode.enclosures.fixed_point_problem import Refused
from polhode.numbers.flint_context import ctx
from polhode.proofs.chaos.covering import Margins, covers
from polhode.proofs.chaos.h_set import HSet, apart, column
from polhode.proofs.chaos.transit import Image, crossing
from polhode.proofs.level import Level


@dataclass(frozen=True, eq=False)
class Chain:
    """``home``: N0; ``sets``: M1, ..., Mk; ``images``: of N0 and of these, in the same order."""

    home: HSet
    sets: tuple[HSet, ...]
    images: tuple[Image, ...]


@dataclass(frozen=True, eq=False)
class Horseshoe:
    """What is proved: margins of N0 => N0, N0 => M1, ..., Mk => N0; times; the entropy.

    ``short``, ``long``: upper bounds of the times of both loops; ``entropy``: a lower bound; both
    in the proof's unit of time.
    """

    chain: Chain
    margins: tuple[Margins, ...]
    short: arb
    long: arb
    entropy: float


def horseshoe(chain: Chain) -> Horseshoe:
    """Theorem C of a chain of proved images; raises Refused."""
    home, sets, images = chain.home, chain.sets, chain.images
    if not sets or len(images) != len(sets) + 1:
        raise Refused("a chain has no loop")
    if sets[0].chart is not home.chart or images[0].chart is not home.chart:
        raise Refused("the coverings out of the periodic orbit's set are not of one section map")
    if not apart(home, sets[0]):
        raise Refused("the first two sets may meet")
    for image, source in zip(images, (home, *sets), strict=True):
        if image.source is not source:
            raise Refused("an image is not that of its set")
    margins = [covers(images[0], home), covers(images[0], sets[0])]
    margins += [covers(x, y) for x, y in zip(images[1:], (*sets[1:], home), strict=True)]
    short = images[0].most
    long = arb(0)
    for image in images:
        long = (long + image.most).upper()
    return Horseshoe(chain, tuple(margins), short, long, least_entropy(short, long))


def least_entropy(short: arb, long: arb) -> float:
    """A lower bound of the root of (1)."""
    if not (short > 0 and long > 0):
        raise Refused("a loop takes no time")
    low, high = 0.0, float((arb(2).log() / short).upper())
    for _ in range(60):
        x = (low + high) / 2
        total = (-x * short).exp() + (-x * long).exp()
        if total > 1:
            low = x
        else:
            high = x
    return low


def holds(level: Level, chain: Chain, start: list[arb], period: arb, bits: int) -> None:
    """The proof that a periodic orbit, known as balls, is the one in N0; raises Refused.

    It meets N0's plane in N0, and its period is within the times of N0 => N0, so that meeting is a
    fixed point of the section map; with cones there is one only.
    """
    home, chart = chain.home, chain.home.chart
    with ctx.workprec(bits):
        known = level.balls(bits - 20)
        off = [x - c for x, c in zip(start, chart.point, strict=True)]
        _, reached = crossing(known, chart, start, (chart.row * column(off))[0, 0].abs_upper())
        rates = column(known.field(reached.box))
        frame = chart.frame.inv()
        to_chart = frame - frame * (rates * chart.row / (chart.row * rates)[0, 0])
        y = to_chart * column(off)
        inside = abs(y[0, 0] - home.middle) < home.width and abs(y[1, 0]) < home.height
        inside = inside and all(abs(y[i, 0]) < chart.eta for i in range(2, 6))
        if not inside:
            raise Refused("the periodic orbit does not pass through its set")
        first = chain.images[0]
        if not (first.least < period and period < first.most):
            raise Refused("the period of the orbit is not the time of its set's return")

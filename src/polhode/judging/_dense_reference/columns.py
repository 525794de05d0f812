"""A closed form at very many times: its states, quaternions and angles, by panels.

Where w and gamma have a period T, panels cover one of them: then

    w(t + T) = w(t),    gamma(t + T) = gamma(t),    q(t + T) = (cos D, 0, 0, sin D) q(t),

and psi and phi grow by the same in each.
"""

from __future__ import annotations

from collections.abc import Container, Sequence
from contextlib import suppress
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from polhode.closed_forms.functions.quaternion import conjugate, product
from polhode.common.errors import BadInput
from polhode.common.progress import Progress
from polhode.judging._dense_reference.angle_unwrapping import SPARE as NEAR_A_POLE
from polhode.judging._dense_reference.angle_unwrapping import Angles, angles
from polhode.judging._dense_reference.attitude_propagation import Attitudes
from polhode.judging._dense_reference.parallel_evaluation import Ask, asked_by
from polhode.judging._dense_reference.taylor_panels import SPARE, NotSo, Source, covering
from polhode.judging._dense_reference.winding import follow
from polhode.judging.references.reference import Reference, rows
from polhode.numbers.conversion import exactly
from polhode.numbers.double_double import Pairs, cos_sin, of_fractions, pairs
from polhode.numbers.mpmath_context import mpmath, own
from polhode.numbers.rows import Doubles

_BITS = 200
_MOST = 27  # digits that pairs carry through panels
_MOMENTS = (1, 5, 11)  # sixteenths of a period after which it is looked for
_BACK = (-27, -11)  # the same of times before 0
_TURN = 1e-3  # radians by which psi and phi may grow differently: they do by 2 pi or not at all


class Columns(NamedTuple):
    """States, quaternions and angles, each column an array; None where they were not asked for.

    Angles are no numbers where a pole leaves them undefined, and psi and phi in rows ``untold``;
    None too where panels cannot tell.
    """

    states: list[Pairs] | None
    quaternion: list[Pairs] | None
    angles: list[Pairs] | None = None
    untold: Sequence[int] = ()


class Cycle(NamedTuple):
    """After ``period`` w and gamma repeat; the body has turned by 2 ``half`` about the vertical.

    ``grown``: by which the arguments of q0 + i q3 and q1 + i q2 grow, where angles were asked for.
    """

    period: Fraction
    half: Any  # an mpf
    grown: Doubles  # shape (2, 1)


def in_panels(
    reference: Reference,
    times: Sequence[Fraction],
    digits: int,
    asked: Sequence[str],
    workers: int,
    tell: Progress | None = None,
) -> Columns | None:
    """The reference at the times, right to about so many digits of max |w| and of 1.

    ``asked``: some of "at", "attitude", "angles".  None where panels do not pay, or where they
    cannot reach the digits.  ``tell``: see
    :func:`polhode.judging._dense_reference.parallel_evaluation.asked_by`.
    """
    turning = "attitude" in asked or "angles" in asked
    questions = ("at", "attitude") if turning else ("at",)
    finer = min(digits + NEAR_A_POLE, _MOST) if "angles" in asked else digits

    def ask(question: str) -> Ask:
        return asked_by(reference, question, workers, tell)

    def some_angles(which: Sequence[int]) -> list[Any]:
        return rows(ask("angles"), [times[k] for k in which], digits)

    try:
        cycle = _cycle(reference, {*questions, *asked}, times, digits)
        here, counts = _folded(times, cycle)
        held = np.unique(here.hi)
        panels = covering(Source(reference, finer, turning, ask("at")), held)
        of = panels.of(here.hi)
        summed = panels.summed(of, here)
        columns = [summed[i] for i in range(len(summed.hi))]
        if not turning:
            return Columns(columns, None)
        attitudes = Attitudes(panels, held, finer, ask("attitude"))
    except NotSo:
        return None
    turned = attitudes.at(of, summed)
    q = [turned[i] for i in range(4)]
    followed = follow(panels, attitudes, q, here.hi) if "angles" in asked else None
    if cycle is not None:
        q = _turned(q, counts * pairs(cycle.half))
    told = Angles(None, [])
    if followed is not None:
        before = counts * (cycle.grown if cycle is not None else np.zeros((2, 1)))
        with suppress(NotSo, BadInput):  # such as a time to which turns cannot be counted
            told = angles(q, followed, before, some_angles)
    return Columns(
        columns[:-4] if "at" in asked else None, q if "attitude" in asked else None, *told
    )


def _cycle(
    reference: Reference, asked: Container[str], times: Sequence[Fraction], digits: int
) -> Cycle | None:
    """The period of the state, where it has one shorter than the times; seen at some moments."""
    period = reference.period
    if period is None or not mpmath.isfinite(own(period)):
        return None
    whole = exactly(period)
    if whole >= max(map(abs, times)):
        return None
    moments = [whole * k / 16 for k in (*(_BACK if min(times) < 0 else ()), *_MOMENTS)]
    small = 10.0**-digits
    with mpmath.workprec(_BITS):

        def pairs_of(question: str) -> list[Any]:
            ask = getattr(reference, question)
            both = sorted({*moments, *(t + whole for t in moments)})
            there = dict(zip(both, map(own, rows(ask, both, digits + SPARE)), strict=True))
            return [(there[t], there[t + whole]) for t in moments]

        size = max(1.0, 10.0**reference.scene.log10_rate)
        for before, after in pairs_of("at"):
            if _apart(before, after) > small * size:
                return None
        turns, grown = [(mpmath.mpf(1), mpmath.mpf(0))], [(0.0, 0.0)]
        if "attitude" in asked:
            products = [product(b, conjugate(a)) for a, b in pairs_of("attitude")]
            if max(max(abs(x), abs(y)) for _, x, y, _ in products) > small:
                return None
            turns = [(c, s) for c, _, _, s in products]
        if "angles" in asked:
            found = pairs_of("angles")
            if any(None in (*a, *b) for a, b in found):
                return None
            more = [(b[0] - a[0], b[2] - a[2]) for a, b in found]
            grown = [(float(psi + phi) / 2, float(psi - phi) / 2) for psi, phi in more]
        if any(_apart(turn, turns[0]) > small for turn in turns):
            return None
        if any(_apart(one, grown[0]) > _TURN for one in grown):
            return None
        half = mpmath.atan2(turns[0][1], turns[0][0])
    return Cycle(whole, half, np.array(grown[:1]).T)


def _apart(a: Sequence[Any], b: Sequence[Any]) -> Any:
    return max(abs(x - y) for x, y in zip(a, b, strict=True))


def _folded(times: Sequence[Fraction], cycle: Cycle | None) -> tuple[Pairs, Doubles]:
    """Times within a period, and how many periods were taken away."""
    at = of_fractions(times)
    if cycle is None:
        return at, np.zeros(len(times))
    counts: Doubles = np.floor(at.hi / float(cycle.period))
    return at - counts * pairs(cycle.period), counts


def _turned(q: Sequence[Pairs], half: Pairs) -> list[Pairs]:
    """(cos, 0, 0, sin) q."""
    c, s = cos_sin(half)
    q0, q1, q2, q3 = q
    return [c * q0 - s * q3, c * q1 - s * q2, c * q2 + s * q1, c * q3 + s * q0]

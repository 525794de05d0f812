"""Printed figures that are off because they hold at another time than their label says.

The figures of one source at one time differ from ours by d_i, and ours change at the rates r_i.
Where one shift s of the time explains them, s = sum d_i r_i / sum r_i² leaves next to nothing of
all the differences at once, which one number cannot do by chance for two figures or more.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

from polhode.checks.published_figures import PrintedFigure, columns_at, ours_of
from polhode.judging.references.certified import Certified
from polhode.judging.references.reference import Reference
from polhode.numbers.expression import decimal
from polhode.scenes.scene import Scene

EXPLAINS = 100  # times smaller: what is left of the differences at the shifted time
_STEP = Fraction(1, 10**9)  # of the time for the rates, relative
_ROUNDS = 3  # of Newton's method: the rates change over the shift


class TimeLabel(NamedTuple):
    """A source whose figures hold at ``t + shift``.

    ``before``, ``after``: the largest difference from ours at t, and at the shifted time.
    """

    cite: str
    t: Fraction
    shift: float
    before: float
    after: float


def time_labels(
    scene: Scene,
    reference: Reference | Certified,
    found: Sequence[PrintedFigure],
) -> Iterator[TimeLabel]:
    """The sources of which a shift of the time explains all figures at once."""
    groups: dict[tuple[str, Any], list[PrintedFigure]] = {}
    for figure in found:
        if isinstance(figure.published.t, Fraction):
            groups.setdefault((figure.published.cite, figure.published.t), []).append(figure)
    for (cite, t), figures in groups.items():
        off = any(figure.difference and not figure.complete for figure in figures)
        if len(figures) < 2 or not t or not off:
            continue
        printed = [decimal(figure.published.value) for figure in figures]

        def differences(
            at: Fraction, figures: list[PrintedFigure] = figures, printed: list[Fraction] = printed
        ) -> list[Fraction]:
            columns: Mapping[str, Any] = columns_at(scene, reference, at, 30)
            ours = [ours_of(figure.published, columns) for figure in figures]
            return [x - y for x, y in zip(printed, ours, strict=True)]

        shift, step = Fraction(0), abs(t) * _STEP
        before = differences(t)
        for _ in range(_ROUNDS):
            here, there = differences(t + shift), differences(t + shift + step)
            rates = [(a - b) / step for a, b in zip(here, there, strict=True)]
            shift += sum(d * r for d, r in zip(here, rates, strict=True)) / sum(
                r * r for r in rates
            )
            shift = shift.limit_denominator(10**15)
        after = max(map(abs, differences(t + shift)))
        if after * EXPLAINS < max(map(abs, before)):
            yield TimeLabel(cite, t, float(shift), float(max(map(abs, before))), float(after))

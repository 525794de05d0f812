"""The reference of the study of events: zeros along periodic closed forms, found without a run."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

from polhode.judging.reference import Reference
from polhode.judging.reference import reference as reference_of
from polhode.numbers import exact
from polhode.numbers.conversion import exactly, to_mpf
from polhode.numbers.mpmath_context import mpmath, own
from polhode.scenes import vocabulary as columns_
from polhode.scenes.scene import Scene

DIGITS = 65  # of the closed form where its zeros are located
BITS = 240


class Zeros:
    """The zeros of an expression along a periodic closed form, to 60 digits, any number of periods.

    The expression has the period of omega, or of the nutation where omega has none.
    They are found in one period alone, by signs at many times and then by the secant rule.
    """

    def __init__(self, scene: Scene, zero: str, samples: int = 64) -> None:
        reference = reference_of(replace(scene, events=()))
        assert isinstance(reference, Reference)
        self._reference, self._zero, self._columns = reference, zero, scene.columns
        period = reference.period
        if period is None:  # of a top that nutates, whose zeros these are
            with mpmath.workprec(BITS):
                period = 2 * mpmath.pi / own(reference.frequencies["nutation"])
        self.period = exactly(period)
        times = [self.period * k / samples for k in range(samples + 1)]
        values = [exact.sign(v) for v in self._values(times, 20)]
        self.first: list[Fraction] = []
        for k in range(samples):
            if values[k] * values[k + 1] < 0:
                self.first.append(self._refined(times[k], times[k + 1]))
            elif values[k] == 0 and k > 0:
                self.first.append(times[k])

    def until(self, end: int) -> list[Fraction]:
        """All zeros in 0 < t <= end."""
        count = math.ceil(end / self.period) + 1
        every = [self.period * n + t for n in range(count) for t in self.first]
        return [t for t in every if 0 < t <= end]

    def _values(self, times: Sequence[Any], digits: int) -> list[Fraction]:
        found = []
        for t, row in zip(times, self._reference.at(times, digits), strict=True):
            columns = dict(zip(self._columns, row, strict=True), t=to_mpf(exactly(t), BITS))
            value = exactly(columns_.value(self._zero, columns, BITS))
            found.append(value if abs(value) > Fraction(1, 10 ** (digits - 3)) else Fraction(0))
        return found

    def _refined(self, low: Fraction, high: Fraction) -> Fraction:
        from polhode.numbers.mpmath_context import mpmath

        def value(t: Any) -> Any:
            row = self._reference.at([t], DIGITS)[0]
            columns = dict(zip(self._columns, row, strict=True), t=t)
            return columns_.value(self._zero, columns, BITS)

        with mpmath.workprec(BITS):
            between = (to_mpf(low, BITS), to_mpf(high, BITS))
            root = mpmath.findroot(value, between, solver="anderson", tol=1e-120, maxsteps=60)
            return exactly(root)


def ulp(t: Fraction, bits: int) -> Fraction:
    """The distance between neighbours of a type of so many bits at t."""
    mantissa, exponent = exact.rounded(t, bits)
    return Fraction(2) ** (exponent + abs(mantissa).bit_length() - bits)

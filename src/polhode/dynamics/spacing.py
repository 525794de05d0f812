"""The spacing of sample times, of rounded ones, too.

Times t_k that are equally spaced before they are rounded by up to e_k admit every spacing s for
which some c has |t_k - c - k s| <= e_k for all k.  These s are an interval, the set in which

    room(s) = min (t_k + e_k - k s) - max (t_k - e_k - k s),

a concave function of s, is not negative; Newton's method ends at both its edges.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from polhode.common.errors import BadInput
from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import Doubles

LEAST = 64  # samples
_NEWTON = 100  # steps, of which about ten are made
_TIES = 1 + 1e-9  # times the errors: a double halfway between two decimals may go either way
_EVEN = 10**9  # off by less than this part of a step, times need no rounding to be equally spaced


class Spacing(NamedTuple):
    """The time between two samples, and what it may be off."""

    step: float
    error: float

    @property
    def relative_error(self) -> float:
        """Of the step, and of a frequency that is told by it."""
        return abs(self.error / self.step)


def spacing(name: str, times: Sequence[Fraction], errors: Sequence[float] = ()) -> Spacing:
    """The spacing of times that are rounded by up to ``errors``, none if empty.

    Raises BadInput, which calls the source of the times by ``name``, unless one fits all.

    >>> sixtieths = [Fraction(round(k * 1000 / 60), 1000) for k in range(100)]
    >>> found = spacing("clock", sixtieths, [0.0005] * 100)
    >>> abs(found.step - 1 / 60) < found.error < 1e-5
    True
    """
    if len(times) < LEAST:
        raise BadInput(name, "times", len(times), f"{LEAST} samples or more")
    last = len(times) - 1
    step = (times[-1] - times[0]) / last
    off = [t - times[0] - k * step for k, t in enumerate(times)]
    farthest = max(map(abs, off))
    if farthest <= abs(step) / _EVEN:
        return Spacing(to_double(step), to_double(2 * farthest / last))
    if errors:
        # in parts of the largest error, from the chord: no digit is lost
        size = max(errors)
        own = np.array([to_double(x / Fraction(size)) for x in off])
        wide = _TIES * np.array(errors) / size
        lowest, highest = (_edge(own, wide, side) for side in (-1, 1))
        if lowest <= highest:
            middle, half = (highest + lowest) / 2 * size, (highest - lowest) / 2 * size
            return Spacing(to_double(step + Fraction(middle)), half)
    expected = "equally spaced times, to a billionth of their step or their last printed decimal"
    raise BadInput(name, "times", None, expected)


def _edge(off: Doubles, errors: Doubles, side: int) -> float:
    """The largest spacing that fits (``side`` 1), or the smallest (-1); beyond it if none fits."""
    count = np.arange(len(off))
    low, high = off - errors, off + errors
    s = side * float(np.ptp(off) + 2 * errors.max())  # no pair of times allows more
    for _ in range(_NEWTON):
        first, then = int(np.argmax(low - count * s)), int(np.argmin(high - count * s))
        if side * (then - first) <= 0:
            break  # none fits, or all do
        edge = float(high[then] - low[first]) / (then - first)
        if side * (s - edge) <= 0:
            break
        s = edge
    return s

"""The scene's axes, the principal axes, and their numbering for the motion."""

from __future__ import annotations

import functools
from collections.abc import Sequence

from polhode.closed_forms._engine.axes import MotionAxes
from polhode.closed_forms.euler.regimes import excess
from polhode.numbers.exact import Exact, sign


def numbered_axes(
    rows: tuple[tuple[Exact, ...], ...] | None, moments: Sequence[Exact], omega: Sequence[Exact]
) -> tuple[MotionAxes, int]:
    """The axes numbered for the motion, and the sign of G^2 - 2hB (B the middle moment).

    The third is the axis that the polhode circles, of the largest moment where G^2 >= 2hB and of
    the smallest where G^2 < 2hB; the second is that of B.
    """

    def compared(i: int, j: int) -> int:
        return sign(moments[i] - moments[j])

    ranking = sorted(range(3), key=functools.cmp_to_key(compared))
    side = excess(moments, MotionAxes(rows).principal(omega), moments[ranking[1]])
    if side < 0:
        ranking.reverse()
    return MotionAxes(rows, tuple(ranking)), side

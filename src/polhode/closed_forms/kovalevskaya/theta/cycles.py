"""The cycles of the two separation variables of the Kovalevskaya top, and their mean rates."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from flint import acb, arb

from polhode.closed_forms.balls.clocks import Linear, circle
from polhode.closed_forms.balls.core import TooFewBits
from polhode.closed_forms.kovalevskaya.branch_points import ascending
from polhode.closed_forms.kovalevskaya.theta.jacobian import segment


def rates(points: Sequence[acb]) -> tuple[arb, arb]:
    """Mean rates of s1 and s2: u = (th1 L1 + th2 L2)/2 pi = u(0) + t (0, 1).

    L1 and L2 are the integrals of (1, s) ds/w around their cycles: s1 goes from -infinity to the
    lowest real branch point, s2 between the two highest.
    """
    line = [x.real for x in points if x.imag.is_zero()]
    line = [line[i] for i in ascending(line, range(len(line)))]
    if not all(x < y for x, y in pairwise(line)):
        raise TooFewBits
    a, c = _unbounded(line[0], points)
    rest = [x for x in points if not x.overlaps(acb(line[-2])) and not x.overlaps(acb(line[-1]))]
    b, d = (2 * x.real for x in segment(acb(line[-2]), acb(line[-1]), rest, []))
    det = abs(a * d - b * c)
    turn = 2 * arb.pi()
    return turn * abs(b) / det, turn * abs(a) / det


def _unbounded(a: arb, points: Sequence[acb]) -> tuple[arb, arb]:
    """Twice the integral of (1, s) ds/|w| from -infinity to a.

    s = a - size (1 + cos phi)/(1 - cos phi).
    """
    gaps = [c - a for c in points if not c.overlaps(acb(a))]
    size = arb(0)
    for gap in gaps:
        size = size.max(abs(gap))
    size = size.mid()
    one, two = circle([Linear(acb(2 * size), 2 * gap, 2 * (gap - size)) for gap in gaps])
    below, above = one.real - two.real, one.real + two.real
    root = 2 * (2 * size).sqrt()
    return root * below, root * (a * below - size * above)

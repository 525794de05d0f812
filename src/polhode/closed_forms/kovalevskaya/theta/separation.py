"""From a state of the Kovalevskaya top to its point on the Jacobian, in balls.

A(s1, w1) + A(s2, w2) moves as u(0) + t (0, 1) (:mod:`..divisor`).  Where q = 0, s1 is infinite and
A of it 0.  Next to q = 0 the form loses some five digits for a decade of q; more bits pay for them.
"""

from __future__ import annotations

from flint import acb

from polhode.closed_forms.balls.core import ball
from polhode.closed_forms.balls.quadrature import Pair
from polhode.closed_forms.kovalevskaya.axes import KovalevskayaStart
from polhode.closed_forms.kovalevskaya.divisor import State
from polhode.closed_forms.kovalevskaya.theta.jacobian import Jacobian
from polhode.numbers.exact import sign


def place(start: KovalevskayaStart, jacobian: Jacobian) -> Pair:
    """u(0)."""
    state = State(*(ball(x) for x in start.state))
    if sign(start.state.q) == 0:
        s, w = state.finite_point()
        return jacobian.image(acb(s), acb(w))
    (R, R1), (T1, N1), q2 = state.polars(), state.rates(), state.q * state.q
    root = (R * R / 4 - q2 * R1).sqrt()
    larger = -(R / 2 + (root if R.mid() >= 0 else -root)) / 2  # q^2 s1, no difference
    one, two = (jacobian.image(acb(s), acb(T1 * s - N1)) for s in (larger / q2, R1 / (4 * larger)))
    return one[0] + two[0], one[1] + two[1]

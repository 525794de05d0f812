"""A geometric integrator: Lie–Poisson splitting of the heavy top, composed to order 4, 6 or 8.

With G = I w and T = Mg r0 the Hamiltonian is a sum of parts whose motions are known:

    H = |G|²/(2 Ik) + (1/Ii - 1/Ik) Gi²/2 + (1/Ij - 1/Ik) Gj²/2 + T·gamma.

The first turns gamma about G, which stays; the next two turn G and gamma about an axis of the body;
the last adds h gamma × T to G.  Axis k is that of the middle moment: a symmetric body has one turn
less, and its free motion is exact.  Every part keeps the Poisson structure and with it |gamma|² and
f = G·gamma; h swings about its value.  McLachlan 1993, Touma & Wisdom 1994, Reich 1994.  A step is
a symmetric composition of leapfrogs: order 4 with five of them, Suzuki 1990; order 6 with nine,
Kahan & Li 1997; order 8 with fifteen, the weights of Rein & Tamayo's JANUS, 2017.

The step is fixed, at most tol^(1/order) over the larger of |w| at the start and the square root of
|T| over the least moment.
``order compensated``: increments are added to the state with their rounding carried along.
"""

from __future__ import annotations

from collections.abc import Sequence

from peers.field import Array, Run, Top

_FIVE = 1 / (4 - 4 ** (1 / 3))
#: Weights of the leapfrogs of a step by order, up to the middle one.
WEIGHTS = {
    4: (_FIVE, _FIVE, 1 - 4 * _FIVE),
    6: (
        *(0.39216144400731413928, 0.33259913678935943860, -0.70624617255763935981),
        *(0.082213596293550800230, 0.79854399093482996340),
    ),
    8: (
        *(0.74167036435061295345, -0.40910082580003159400, 0.19075471029623837995),
        *(-0.57386247111608226666, 0.29906418130365592384, 0.33462491824529818378),
        *(0.31529309239676659663, -0.79688793935291635402),
    ),
}


def prepared(present: Sequence[bool], method: str) -> Run:
    """The steps and the loop over the times in compiled functions.

    ``present``: unused, the parts that vanish are left out as the steps are made.
    """
    import numpy as np

    from peers.splitting_steps import along

    order, _, word = method.partition(" ")
    half = WEIGHTS[int(order)]
    weights, carry = np.array([*half, *half[-2::-1]]), word == "compensated"

    def run(top: Top, start: Array, times: Array, tol: float) -> Array:
        return along(
            *(start, times, top.moments, top.torque, weights, tol ** (1 / int(order)), carry)
        )

    return run

"""What a program looks like once it is prepared: a function of body, start, times and tolerance.

Each program is made ready once for a pattern of the equations, which says what coefficients are
not zero, and then called with any body of the pattern and any start: what a loop over many starts
pays.  Its module has a function ``prepared(present, method)`` that returns a :data:`Run`.  Where a
program has a way of its own of many starts, a loop in compiled code at the least, there is also
``prepared_many``: a Run from starts (N, 6), times 0 and end, to the states at the end, (N, 6).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias

#: numpy's, and in compiled functions numba's or JAX's: they have no type in common.
Array: TypeAlias = Any


class Top(NamedTuple):
    """A body in principal axes: the nine coefficients of its equations, its moments, Mg r0.

    Arrays of doubles; the coefficients in the order of :mod:`polhode.peers.field`.
    """

    coefficients: Array
    moments: Array
    torque: Array


#: From a body, a start of shape (6,), n times from 0 on and a tolerance to the states at the times,
#: shape (n, 6).  With two times it may return the last state alone, shape (1, 6).  Raises
#: ArithmeticError where it does not arrive.
Run = Callable[[Top, Array, Array, float], Array]

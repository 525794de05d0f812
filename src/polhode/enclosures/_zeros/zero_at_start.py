"""Whether a polynomial of the state is 0 at t = 0, how often, and whether it is 0 all along.

Trusted in one thing: ``first_derivative``.  For rational data the derivatives of g along the exact
motion at t = 0 are fractions: what is 0 of them is 0.
"""

from __future__ import annotations

from fractions import Fraction

from flint import arb_poly

from polhode.enclosures.fixed_point_problem import Motion
from polhode.enclosures.polynomial import Polynomial, ball, rate
from polhode.numbers.flint_context import ctx

_ORDERS = 24  # Taylor coefficients that are looked at
_MOST_ORDER, _MOST_TERMS = 4, 2000  # of a derivative as a polynomial
_BITS = 2000


def first_derivative(what: Motion, g: Polynomial) -> Polynomial | None:
    """The first derivative of g along the motion that is not 0 at t = 0, where g is 0 there.

    None where g is not, where that is not decided exactly, or is of too high an order; and where
    the start is a box.
    """
    start = [x for x in what.start if isinstance(x, Fraction)]
    exactly = len(start) == 6 and all(isinstance(x, Fraction) for x in what.constants)
    if what.radii or not (exactly and g.rational):
        return None
    found = g
    for order in range(_MOST_ORDER + 1):
        if found.at(start):
            return found if order else None
        found = rate(found, what.field)
        if not 0 < len(found.terms) <= _MOST_TERMS:
            return None
    return None


def is_still(what: Motion, g: Polynomial) -> bool:
    """Whether nothing tells g from 0 all along the motion.

    Not trusted: said of the first Taylor coefficients to many digits, and only where a product of
    as many factors as g has would show, each 0 twice at most.  Those of the motion come one by one
    of x = x(0) + int f(x).
    """
    degree = max(sum(key) for key in g.terms)
    if 2 * degree > _ORDERS:
        return False
    with ctx.workprec(_BITS):
        start = [ball(x, _BITS) for x in what.start]
        along = g.balls(_BITS)
        if not along.at(start).contains(0):
            return False
        field = [row.balls(_BITS) for row in what.field]
        x = [arb_poly([value]) for value in start]
        for order in range(1, _ORDERS + 1):
            rates = [arb_poly(row.at(x)).truncate(order) for row in field]
            x = [arb_poly([a]) + row.integral() for a, row in zip(start, rates, strict=True)]
        found = arb_poly(along.at(x))
        return all(found[k].contains(0) for k in range(_ORDERS + 1))

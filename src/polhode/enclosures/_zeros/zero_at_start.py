"""Whether a polynomial of the state is 0 at t = 0, how often, and whether it is 0 all along.

Trusted in one thing: ``first_derivative``.  For rational data the Taylor coefficients of the exact
motion are fractions, and so are those of g along it: what is 0 of them is 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from flint import arb

from polhode.enclosures.fixed_point_problem import CYCLE, Motion
from polhode.enclosures.polynomial import Polynomial, ball, rate
from polhode.numbers.flint_context import ctx
from polhode.numbers.scalars import Scalar

_ORDERS = 24  # Taylor coefficients that are looked at
_MOST_ORDER, _MOST_TERMS = 4, 2000  # of a derivative as a polynomial
_BITS = 2000


def first_derivative(what: Motion, g: Polynomial) -> Polynomial | None:
    """The first derivative of g along the motion that is not 0 at t = 0, where g is 0 there.

    None where g is not, where that is not decided exactly, or is of too high an order; and where
    the start is a box.
    """
    if what.radii or not _rational(what, g):
        return None
    found, zero = g, Fraction(0)
    start = [x for x in what.start if isinstance(x, Fraction)]
    for order in range(_MOST_ORDER + 1):
        if _value(found, start, zero):
            return found if order else None
        found = rate(found, what.field)
        if not 0 < len(found.terms) <= _MOST_TERMS:
            return None
    return None


def is_still(what: Motion, g: Polynomial) -> bool:
    """Whether nothing tells g from 0 all along the motion.

    Not trusted: said of the first Taylor coefficients, exactly or to many digits, and only where a
    product of as many factors as g has would show, each 0 twice at most.
    """
    degree = max(sum(key) for key in g.terms)
    if 2 * degree > _ORDERS:
        return False
    if _rational(what, g):
        exactly = [x for x in (*what.constants, *what.start) if isinstance(x, Fraction)]
        if _value(g, exactly[9:], Fraction(0)):
            return False
        return not any(_along(g, _series(exactly[:9], exactly[9:]), Fraction(0)))
    with ctx.workprec(_BITS):
        balls = [ball(x, _BITS) for x in (*what.constants, *what.start)]
        if not _value(g, balls[9:], arb(0)).contains(0):
            return False
        return all(x.contains(0) for x in _along(g, _series(balls[:9], balls[9:]), arb(0)))


def _rational(what: Motion, g: Polynomial) -> bool:
    return g.rational and all(isinstance(x, Fraction) for x in (*what.constants, *what.start))


def _value(g: Polynomial, state: Sequence[Scalar], zero: Scalar) -> Scalar:
    """g at a state."""
    return _along(g, [[x] for x in state], zero)[0]


def _series(constants: Sequence[Scalar], start: Sequence[Scalar]) -> list[list[Scalar]]:
    """Taylor coefficients of the six components of the motion."""
    bend, pull, push = constants[:3], constants[3:6], constants[6:]
    x = [[value] for value in start]
    for k in range(_ORDERS):
        rates = []
        for i, (a, b) in enumerate(CYCLE):
            turned = bend[i] * _coefficient(x[a], x[b], k)
            rates.append(turned + pull[i] * x[3 + a][k] + push[i] * x[3 + b][k])
        for a, b in CYCLE:
            rates.append(_coefficient(x[3 + a], x[b], k) - _coefficient(x[3 + b], x[a], k))
        for row, found in zip(x, rates, strict=True):
            row.append(found / (k + 1))
    return x


def _coefficient(x: Sequence[Scalar], y: Sequence[Scalar], k: int) -> Scalar:
    """That of order k of a product."""
    found = x[0] * y[k]
    for j in range(1, k + 1):
        found += x[j] * y[k - j]
    return found


def _along(g: Polynomial, x: Sequence[Sequence[Scalar]], zero: Scalar) -> list[Scalar]:
    """Taylor coefficients of g along the motion with those of its state, to the same order."""
    count: int = len(x[0])
    found = [zero] * count
    for key, value in g.terms.items():
        # of the kind that is computed with
        known: Scalar = value if isinstance(zero, Fraction) else ball(value, _BITS)
        term = [known, *[zero] * (count - 1)]
        for row, power in zip(x, key, strict=True):
            for _ in range(power):
                term = [_coefficient(term, row, k) for k in range(count)]
        found = [a + b for a, b in zip(found, term, strict=True)]
    return found

"""Where a form of the equations is singular: a run ends near there."""

from __future__ import annotations

from fractions import Fraction

from polhode.numbers.number_types import NumberType
from polhode.taylor.backend.engine import hy
from polhode.taylor.backend.heyoka_numbers import scalar, type_options
from polhode.taylor.backend.types import Expression, HeyokaEvent


def nearest(number: NumberType) -> Fraction:
    """The smallest distance to a form's singular set, about sqrt(eps): a run ends there.

    A distance is a square (sin² theta), so the set is met within about eps**(1/4).  A passage at
    d was measured to cost log10(1/d) digits: a run that goes on keeps three quarters of its own.
    """
    return Fraction(2) ** -((number.bits - 1) // 2)


def terminal_event(distance: Expression, number: NumberType) -> HeyokaEvent:
    """heyoka's event that ends the steps where the distance falls to :func:`nearest`.

    It is scaled down, so that it takes no part in choosing the steps.
    """
    near, damping = (scalar(x, number) for x in (nearest(number), _damping(number)))
    kind = {name: x for name, x in type_options(number).items() if name == "fp_type"}
    return hy.t_event(hy.expression(damping) * (distance - hy.expression(near)), **kind)


def _damping(number: NumberType) -> Fraction:
    return Fraction(2) ** -(number.bits // 2)

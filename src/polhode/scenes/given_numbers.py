"""Numbers given beside a scene, in options and arguments: exact, and with units where it has them.

A scene in SI takes ``"100 ms"`` for a time as a scene file does.  Where a scene's numbers have any
consistent units, a number with a unit means nothing, but for an angle.
"""

from __future__ import annotations

from collections.abc import Callable

from polhode.numbers import expression
from polhode.numbers.conversion import exact_number
from polhode.numbers.exact import Exact
from polhode.numbers.expression import ExpressionError

TIME, ENERGY, AREA = "s", "J", "kg*m**2/s"

_UNITLESS = 'with a unit, and the scene has none; units = "SI" in it says that its numbers are SI'


def in_units(text: str) -> bool:
    """Whether a number is written with a unit."""
    from polhode.numbers.quantity import mentions_unit

    return mentions_unit(text)


def reader(units: str, unit: str) -> Callable[[object], Exact]:
    """What reads a number beside a scene of these ``units``; ``unit``: as in ``quantity.in_unit``.

    It raises ValueError for what is none, and for another dimension.
    """

    def read(value: object) -> Exact:
        return in_text(value, units, unit) if isinstance(value, str) else exact_number(value)

    return read


def in_text(text: str, units: str, unit: str) -> Exact:
    """The number in a text; raises ExpressionError, a ValueError."""
    found, in_si = number_in_text(text, unit)
    if in_si and not units:
        raise ExpressionError(_UNITLESS)
    return found


def number_in_text(text: str, unit: str) -> tuple[Exact, bool]:
    """The value of an expression, and whether its units make it a number in SI.

    Those of an angle do not: it is the same number in any units.  ``unit``: as in
    ``quantity.in_unit``.  Raises ExpressionError.
    """
    try:
        return expression.number(text), False
    except ExpressionError:
        from polhode.numbers.quantity import in_unit, is_angle, mentions_unit

        if not mentions_unit(text):
            raise
        return in_unit(text, unit), not is_angle(text)

"""Expressions in the columns of a state: events and published figures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from polhode.numbers import expression
from polhode.numbers.conversion import to_mpf
from polhode.numbers.exact import Exact
from polhode.numbers.expression import Algebra


def check(text: str, names: tuple[str, ...]) -> None:
    """Raise ExpressionError unless ``text`` reads as an expression in these names."""
    expression.evaluate(
        text,
        dict.fromkeys(names, _ANY),
        Algebra(_lift_any, dict.fromkeys(expression.FUNCTIONS, _same)),
    )


def value(text: str, columns: Mapping[str, Any], bits: int) -> Any:
    """The value of an expression at one instant, its columns given as mpf, to so many bits."""
    from polhode.numbers.mpmath_context import mpmath, own

    functions = {"sqrt": mpmath.sqrt, "sin": mpmath.sin, "cos": mpmath.cos}
    given = {name: own(x) for name, x in columns.items()}
    with mpmath.workprec(bits):
        found = expression.evaluate(text, given, Algebra(lambda x: to_mpf(x, bits + 8), functions))
        return found if isinstance(found, mpmath.mpf) else to_mpf(found, bits)


class _Any:
    """A value of which nothing is known: any operation gives it back."""

    def _same(self, *_: Any) -> _Any:
        return self

    __add__ = __sub__ = __mul__ = __truediv__ = __pow__ = __neg__ = _same


_ANY = _Any()


def _lift_any(_: Exact) -> _Any:
    return _ANY


def _same(argument: object) -> Any:
    return argument

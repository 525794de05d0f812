"""What vanishes on a section of the flow, written once for any scalar.

    momentum    D = gamma.(a x G), a along r0:  d(|G|^2/2)/dt = Mg rho D, extrema of |G|
    height      gamma.(w x a) = d(a.gamma)/dt,                       extrema of the centre's height
    any         an expression in p q r gamma1 gamma2 gamma3, in the scene's axes and units

The state is in principal axes; ``arm`` is a with the sign and size that make D's fall a maximum and
its values of order one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import NamedTuple

from polhode.numbers import expression
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Irrational, Number
from polhode.numbers.expression import Algebra
from polhode.numbers.number_types import Functions, Scalar
from polhode.scenes.vocabulary import STATE

MOMENTUM, HEIGHT = "momentum", "height"

#: How an orbit ended of which a crossing may be lost.
UNSURE = "not certain of a crossing"


class SectionZero(NamedTuple):
    """A section's function, as plain data.

    ``by``: momentum, height, or an expression's text.  ``moments``, ``arm``: doubles in principal
    axes.  ``rows``: the principal axes in the scene's, ``unit``: the run's unit of time; both for
    an expression alone.
    """

    by: str
    moments: tuple[float, float, float]
    arm: tuple[float, float, float]
    rows: tuple[tuple[float, ...], ...] = ()
    unit: float = 1.0

    def value(
        self,
        state: Sequence[Scalar],
        fn: Functions,
        lift: Callable[[float], Scalar] = lambda x: x,
    ) -> Scalar:
        """At a state in principal axes, for floats, arrays (complex ones too) and expressions."""
        w, g = state[:3], state[3:6]
        if self.by == MOMENTUM:
            momentum = [lift(a) * x for a, x in zip(self.moments, w, strict=True)]
            return self._triple(g, momentum, lift, fn.zero)
        if self.by == HEIGHT:
            return -self._triple(g, w, lift, fn.zero)
        columns = [
            sum((lift(row[i]) * x for row, x in zip(self.rows, v, strict=True) if row[i]), fn.zero)
            for v in (w, g)
            for i in range(3)
        ]
        columns[:3] = [lift(1 / self.unit) * x for x in columns[:3]]
        return in_columns(self.by, STATE, columns, None, lambda x: lift(to_double(x)), fn)

    def _triple(
        self,
        g: Sequence[Scalar],
        v: Sequence[Scalar],
        lift: Callable[[float], Scalar],
        zero: Scalar,
    ) -> Scalar:
        """g.(arm x v), terms of an arm's zero components left out."""
        total = zero
        for i, a in enumerate(self.arm):
            if a:
                j, k = (i + 1) % 3, (i + 2) % 3
                total = total + lift(a) * (v[j] * g[k] - v[k] * g[j])
        return total


def in_columns(
    text: str,
    columns: Sequence[str],
    values: Sequence[Scalar],
    clock: Scalar,
    constant: Callable[[Number], Scalar],
    fn: Functions,
) -> Scalar:
    """A text in t, the ``clock``, and the names of columns, with these values."""
    names = dict(zip(columns, values, strict=True), t=clock)
    functions = {"sqrt": fn.sqrt, "sin": fn.sin, "cos": fn.cos}
    value = expression.evaluate(text, names, Algebra(constant, functions, power=fn.power))
    return constant(value) if isinstance(value, (Fraction, Irrational)) else value

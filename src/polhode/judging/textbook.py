"""The reference of a classical top by mpmath's own functions: a second witness."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from polhode.closed_forms import textbook
from polhode.closed_forms.families import closed_form
from polhode.closed_forms.kovalevskaya.place import DEGENERATE, ONE_FREQUENCY
from polhode.common.arguments import each, whole
from polhode.common.errors import BadInput
from polhode.judging.reference_rows import tabulated
from polhode.numbers import number_types
from polhode.numbers.conversion import TIME, reader
from polhode.numbers.mpmath_context import mpmath, ordinary
from polhode.numbers.number_types import AnyNumber, Real
from polhode.results.result import Storable
from polhode.results.table import Content
from polhode.scenes.scene import Scene

FAMILIES = ("euler", "lagrange", "kovalevskaya")
_SPECIAL = (*DEGENERATE, *ONE_FREQUENCY)  # of Kovalevskaya's: two branch points are equal


class Textbook(Storable):
    """The state of a classical top as a textbook has it, computed by mpmath alone.

    Euler's and Lagrange's tops by Jacobi's functions and Legendre's third integral, generic motions
    of Kovalevskaya's by Abel's sums.  The digits are those that two working precisions agree on:
    reproduced, not proven.  It shares no formula and no arithmetic with :class:`Reference`.

    ``kind``: which top; ``regime``: the kind of motion.  Answers are in the scene's body axes and
    units.  Raises BadInput for a scene of another family, and for a motion that the formulas do not
    have.

    >>> import polhode
    >>> witness = polhode.reference("lagrange/nutation", backend="mpmath")
    >>> (row,), (same,) = (
    ...     top.at([7], digits=30) for top in (witness, polhode.reference("lagrange/nutation"))
    ... )
    >>> max(abs(x - y) for x, y in zip(row, same)) < 1e-30
    True
    """

    is_closed_form = True
    proven = False
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, scene: Scene) -> None:
        fitting = closed_form(scene, scene.reference if scene.reference in FAMILIES else "auto")
        if fitting is None or fitting[0] not in FAMILIES:
            kind = "no family" if fitting is None else fitting[0]
            expected = f"{', '.join(FAMILIES[:-1])} or {FAMILIES[-1]}, for backend mpmath"
            raise BadInput(scene.name, "reference", kind, expected)
        self.scene, self.kind, self.regime = scene, fitting[0], fitting[1].regime
        if self.kind == "kovalevskaya" and self.regime in _SPECIAL:
            expected = "a generic motion, for backend mpmath"
            raise BadInput(scene.name, "reference", self.regime, expected)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Textbook):
            return NotImplemented
        return self.scene == other.scene

    def __reduce__(self) -> tuple[object, ...]:
        return Textbook, (self.scene,)

    def __repr__(self) -> str:
        return f"<Textbook of {self.scene.name}: {self.kind}, {self.regime}>"

    def content(self) -> Content:
        """Its states at the times of the scene, to 30 digits."""
        return tabulated(Textbook(replace(self.scene, outputs=()))).content()

    def at(self, times: Iterable[AnyNumber], digits: int = 50) -> list[list[Real]]:
        """Rows p q r [gamma1 gamma2 gamma3] as mpf, to ``digits`` digits that repeat themselves.

        ``times``: ints, Fractions, floats, mpf or decimal strings, taken exactly.
        """
        name = self.scene.name
        digits = whole(name, "digits", digits, 1, number_types.MOST_ASKED)
        instants = [*each(name, "t", times, reader(self.scene.units, TIME), "a list of times")]
        if not instants:
            return []
        try:
            with mpmath.workprec(53):
                rows: list[list[Real]] = ordinary(
                    textbook.states(self.scene, self.kind, self.regime, instants, digits)
                )
                return rows
        except (ValueError, ArithmeticError, mpmath.NoConvergence) as fault:
            why = str(fault) or "they divide by 0 or do not converge"
            expected = f"a motion that mpmath's functions reach ({why})"
            raise BadInput(name, "reference", self.regime, expected) from None

    def radii(self, times: Iterable[AnyNumber], digits: int = 50) -> None:
        """None: the digits are reproduced, and no bound of their error is proven."""
        del times, digits

    def column(self, word: str, times: Iterable[AnyNumber], digits: int = 50) -> list[list[Real]]:
        """Refused: it has states alone."""
        del times, digits
        raise BadInput(self.scene.name, "outputs", word, "none: mpmath has states alone")

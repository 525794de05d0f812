"""Dense output: the state of a run at any time that it reached, as accurate as its step ends."""

from __future__ import annotations

from bisect import bisect_right
from collections import OrderedDict
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from typing import NamedTuple

from polhode.common.cached_property import cached_property
from polhode.common.errors import BadInput, plain
from polhode.equations.form import equations
from polhode.equations.readout import Readout
from polhode.equations.system import System
from polhode.numbers.conversion import number_value
from polhode.numbers.decimals import shown
from polhode.numbers.exact import sign
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Row, Rows
from polhode.numbers.scalars import AnyNumber, numbers_given, of_mpmath
from polhode.scenes.given_numbers import TIME, reader
from polhode.scenes.scene import Scene
from polhode.taylor.integrator.protocols import Integrating, Mark, Piece

_MOST_BYTES = 2**28  # of polynomials kept at a time


class Leg(NamedTuple):
    """One integrator's part of a motion: its system, when that began, where its chunks began."""

    system: System
    origin: Fraction
    marks: list[Mark]
    projected: bool


class Dense:
    """A run's state at time t, from the Taylor polynomials of the step that t lies in.

    A run keeps only where its chunks began.  When asked for a time, the chunk that holds it is
    integrated again, the same steps to the bit, and its polynomials are kept: that costs about
    twice the chunk's own time once, then a tenth of a millisecond a state.

    t is taken exactly: what its rounding to the run's type leaves over is made good by the rates,
    so that the state is that at t and not at a number nearby.
    """

    def __init__(
        self,
        scene: Scene,
        number: NumberType,
        reached: Fraction,
        legs: Sequence[Leg],
        first: Rows,
        again: Callable[[Leg], Integrating],
    ) -> None:
        self.scene, self.number, self.reached = scene, number, reached
        self._legs, self._first, self._again = tuple(legs), first, again
        self._kept: OrderedDict[int, Sequence[Piece]] = OrderedDict()
        # the leg taken up last, and its integrator
        self._ready: tuple[Leg, Integrating] | None = None

    def __getstate__(self) -> dict[str, object]:
        """Without polynomials and integrator, which are made again when asked for."""
        return {**vars(self), "_kept": OrderedDict(), "_ready": None}

    @cached_property
    def _chunks(self) -> list[tuple[Leg, Mark]]:
        return [(leg, mark) for leg in self._legs for mark in leg.marks]

    @cached_property
    def _begun(self) -> list[Fraction]:
        return [abs(mark.offset) for _, mark in self._chunks]

    def __call__(self, t: AnyNumber | Iterable[AnyNumber]) -> Row | Rows:
        """The state at t in the scene's axes and units, a row of the kind that ``.states`` has.

        ``t``: an int, Fraction, float, numpy or mpmath number, or text such as ``"1/3"``; or a
        sequence of them, for as many rows.  Raises BadInput outside of what was reached.
        """
        given, several = numbers_given(t)
        rows = [self._row(self._time(x)) for x in given]
        states = Readout(self.scene, self.number).states(rows)
        return states if several else states[0]

    def _time(self, t: object) -> Fraction:
        """A time in the run's own unit, exact to far more bits than the state has."""
        reach = f"a time from 0 to {shown(self.reached)}, what the run reached"
        try:
            exact = reader(self.scene.units, TIME)(t)
        except ValueError:
            raise BadInput(self.scene.name, "t", plain(t), reach) from None
        if sign(exact) * sign(self.reached) < 0 or sign(abs(exact) - abs(self.reached)) > 0:
            raise BadInput(self.scene.name, "t", shown(exact), reach)
        if not isinstance(exact, Fraction):
            exact = NumberType("mp", 2 * self.number.bits + 128).rounded(exact)
        return exact / Fraction(2) ** self.scene.time_unit

    def _row(self, t: Fraction) -> Row:
        """The variables of the run's form, in its own unit."""
        if not self._chunks:
            first: Row = self._first[0][: len(equations(self.scene).variables)]
            return first
        from polhode.taylor.backend import heyoka_numbers

        index = bisect_right(self._begun, abs(t)) - 1
        pieces = self._pieces(index)
        leg, mark = self._chunks[index]
        ahead = t - mark.offset
        near = self.number.rounded(ahead)
        at = heyoka_numbers.scalar(near, self.number)
        piece = pieces[max(0, bisect_right(pieces, abs(at), key=lambda p: abs(p.begun)) - 1)]
        row = piece.at(at, self.number)
        if ahead != near:
            row = self._moved(row, ahead - near, leg.system)
        return row[: len(leg.system.form.variables)]

    def _moved(self, row: Row, by: Fraction, what: System) -> Row:
        """A row moved on by less than the last bit of its time."""
        from polhode.numbers.mpmath_context import mpmath, ordinary, own

        with mpmath.workprec(self.number.bits):
            k = {name: own(number_value(x, self.number)) for name, x in what.coefficients.items()}
            zero, step = (own(number_value(x, self.number)) for x in (Fraction(0), by))
            fn = of_mpmath()._replace(zero=zero)
            state = [own(x) for x in row]
            rates = what.field(state, k, fn)
            return [ordinary(x + step * rate) for x, rate in zip(state, rates, strict=True)]

    def _pieces(self, index: int) -> Sequence[Piece]:
        """A chunk's polynomials; those used last are kept."""
        if index not in self._kept:
            leg, mark = self._chunks[index]
            if self._ready is None or self._ready[0] is not leg:
                self._ready = leg, self._again(leg)
            self._kept[index] = self._ready[1].again(mark)
            while len(self._kept) > 1 and self._bytes() > _MOST_BYTES:
                self._kept.popitem(last=False)
        self._kept.move_to_end(index)
        return self._kept[index]

    def _bytes(self) -> int:
        return sum(piece.bytes for pieces in self._kept.values() for piece in pieces)

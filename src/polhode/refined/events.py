"""Events of a refined run: places found along the run in double, decided from refined states.

At each place the state is refined as at an output time; from there its Taylor series leads to the
zero or the contact, by the rules of :mod:`polhode.taylor.events.root_refinement` that the steps of
a run in the same number type follow, with the same thresholds.  An extremum on the far side of
zero, which the run in double may have missed, gives the two zeros beside it.

An event is lost only where the run in double has no place for it: where the expression and its rate
and its bend all are smaller than 1e-8 of their sizes at a time.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from polhode.numbers import expression
from polhode.numbers.conversion import to_mpf
from polhode.numbers.exact import Exact, sign
from polhode.numbers.expression import Algebra, ExpressionError
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.number_types import NumberType
from polhode.numbers.scalars import Scalar
from polhode.refined.dual_numbers import Dual
from polhode.refined.errors import CannotRefine
from polhode.refined.event_candidates import Candidates
from polhode.refined.taylor_series import Series
from polhode.scenes.event import Event
from polhode.scenes.scene import Scene
from polhode.taylor.events.magnitudes import middle_axis, sign_at_start, size_of
from polhode.taylor.events.root_refinement import Mark, Place, is_start, polished, sorted_out
from polhode.taylor.events.rules import Limits

if TYPE_CHECKING:
    from polhode.refined.double_run import Base

_GUARD = 32  # bits beyond the run's type
_ALIKE = Fraction(1, 1 << 28)  # within it two zeros of one slope are one, found twice
_FARTHEST = 0.125  # from an extremum to the zeros beside it, in the run's own unit


class Search:
    """The events of one scene during one refined run in a number type.

    ``stop``: the time (run's own unit) of the event that ended the run.
    """

    def __init__(self, scene: Scene, number: NumberType) -> None:
        self.scene, self.number = scene, number
        self.backward = sign(scene.end) < 0
        self.stop: Fraction | None = None
        self.start = [sign_at_start(scene, k) for k in range(len(scene.events))]
        self.candidates = Candidates(scene, self.backward)
        self._marks: list[list[Mark]] = [[] for _ in scene.events]
        self._bits = number.bits + _GUARD
        self._limits = [
            Limits(size_of(scene, event), number, number.eps, False, self._typed)
            for event in scene.events
        ]
        unit = Fraction(2) ** scene.time_unit
        self._unit = self._typed(unit)
        axes = scene.body.axes
        self._turn = None if axes.trivial else [[self._typed(x) for x in row] for row in axes.rows]
        functions = {"sin": self._sine, "cos": self._cosine}
        self._algebra = Algebra(lambda x: Dual(self._typed(x), self._typed(0)), functions)

    def refuse_what_never_moves(self, now: Base) -> None:
        """Raise CannotRefine for an event that starts at zero and stays there along a base."""
        for k, before in enumerate(self.start):
            if before == 0 and self.candidates.still(now.polynomials, k):
                raise CannotRefine("an event is zero at all times of the motion")

    def look(self, time: Fraction, series: Series, k: int, extremum: bool) -> None:
        """Decide about a place of event k: ``time`` (own unit), ``series`` from the state then."""
        with mpmath.workprec(self._bits):
            self._look(time, series, k, extremum)

    def _look(self, time: Fraction, series: Series, k: int, extremum: bool) -> None:
        event, limits = self.scene.events[k], self._limits[k]

        def at(ago: Scalar) -> tuple[Scalar, Scalar]:
            return self._value(event, time, series, ago)

        zero = limits.zero
        guesses = [zero, *(self._beside(at, limits) if extremum else [])]
        for guess in guesses:
            place = polished(at, guess, limits)
            if place is not None:
                self._mark(k, time, series, place)

    def _beside(self, at: Any, limits: Limits) -> list[Scalar]:
        """Where the zeros beside an extremum at about 0 are, if there are any."""
        by, when = limits.nearby, limits.zero
        for _ in range(3):
            bend = (at(when + by)[1] - at(when - by)[1]) / (2 * by)
            value, slope = at(when)
            if not abs(slope) < abs(bend) * _FARTHEST:
                return []
            when = when - slope / bend
        value = at(when)[0]
        if not value * bend < 0:
            return []
        away = mpmath.sqrt(-2 * value / bend)
        return [when - away, when + away] if away < _FARTHEST else []

    def _mark(self, k: int, time: Fraction, series: Series, place: Place) -> None:
        event, when = self.scene.events[k], time + _exactly(place.time)
        if self.backward != (when < 0) and when != 0:
            return  # before the start
        row = [Fraction(x, 1 << series.bits) for x in series.at(self._ahead(series, place.time))]
        self._marks[k].append(Mark(when, row, place.slope, _exactly(place.width)))
        stops = event.stop and place.slope and event.counts(place.slope)
        if not stops or is_start(when, place.slope, self.start[k], self.number):
            return
        if self.stop is None or abs(when) < abs(self.stop):
            self.stop = when

    def sorted_out(self, end: Fraction) -> list[tuple[list[Mark], bool]]:
        """Of each event its marks up to ``end``, those asked for; and whether none was lost."""
        found = []
        last = end if self.stop is None else self.stop
        for k, event in enumerate(self.scene.events):
            before = -self.start[k] if self.backward else self.start[k]
            marks, complete = sorted_out(self._marks[k], before, last, self.number, _ALIKE)
            found.append(([m for m in marks if event.counts(m.slope)], complete))
        return found

    def _value(
        self, event: Event, time: Fraction, series: Series, ago: Scalar
    ) -> tuple[Scalar, Scalar]:
        state = series.at(self._ahead(series, ago))
        pairs = zip(state, series.rates(state), strict=True)
        scale = -series.bits
        columns = [Dual(mpmath.ldexp(a, scale), mpmath.ldexp(b, scale)) for a, b in pairs]
        if event.expression is None:
            found = columns[middle_axis(self.scene)]
            return found.value, found.rate
        if self._turn is not None:
            columns = [*self._turned(columns[:3]), *self._turned(columns[3:])]
        columns[:3] = [Dual(x.value / self._unit, x.rate / self._unit) for x in columns[:3]]
        clock = Dual((self._typed(time) + ago) * self._unit, self._unit)
        names = dict(zip(self.scene.columns, columns, strict=False), t=clock)
        try:
            found = expression.evaluate(event.expression, names, self._algebra)
        except ExpressionError:
            return mpmath.nan, mpmath.nan
        return found.value, found.rate

    def _turned(self, vector: Sequence[Dual]) -> list[Dual]:
        """Components along the principal axes, along the scene's."""
        assert self._turn is not None
        return [
            Dual(
                mpmath.fdot((self._turn[i][j], vector[i].value) for i in range(3)),
                mpmath.fdot((self._turn[i][j], vector[i].rate) for i in range(3)),
            )
            for j in range(3)
        ]

    def _ahead(self, series: Series, ago: Scalar) -> int:
        return int(mpmath.floor(mpmath.ldexp(ago, series.bits)))

    def _typed(self, x: Exact | int) -> Scalar:
        exact = Fraction(x) if isinstance(x, int) else x
        return to_mpf(exact, self._bits)

    def _sine(self, x: Dual) -> Dual:
        return Dual(mpmath.sin(x.value), mpmath.cos(x.value) * x.rate)

    def _cosine(self, x: Dual) -> Dual:
        return Dual(mpmath.cos(x.value), -mpmath.sin(x.value) * x.rate)


def _exactly(x: Scalar) -> Fraction:
    """The exact value of a number of mpmath's."""
    negative, mantissa, exponent, _ = x._mpf_
    size = Fraction(int(mantissa)) * Fraction(2) ** int(exponent)
    return -size if negative else size

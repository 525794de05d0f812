"""How much a motion multiplies errors: what rounding costs, what is expected of a run.

Three quantities, and a bound:

*inputs(t)*: the error that rounding this scene's numbers to the type causes; known differences, to
first order (:mod:`polhode.judging.conditioning.rounding_errors`); of projected runs, what
projection leaves of it.

*amplification(t)* = max over s <= t of |Phi(t, s)|: what a change of the state on the way is
multiplied by, w relative to the largest |w| at the output times, gamma as it is.

*expected(t)*: the error of a method that rounds the state once a Taylor step, and what the step
adds while it is computed, beside that of the inputs, as the band in which nine in ten such runs
end; of projected runs, what projection leaves.

*bound(t)* = kappa(t)·eps, kappa(t) = max over i of the sum over j of |d x_i/d ln u_j|, x the state,
u every input that is not zero: p q r gamma1 gamma2 gamma3 at the start, A, B, C and the components
of Mg r0, in principal axes, each changed by one unit of itself at once.  Rounding the inputs can
cost so much, and costs less nearly always.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from polhode.common.arguments import steps
from polhode.common.values import ByValue, cached_property
from polhode.judging.conditioning import rounding_errors
from polhode.judging.conditioning.rounding_errors import Band, Rounding
from polhode.motion.frame import Frame
from polhode.numbers import number_types
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import DOUBLE, LOG10_2, NumberType
from polhode.numbers.scalars import AnyNumber
from polhode.results import cells
from polhode.results.result import Result
from polhode.results.table import Column, Fact, Table
from polhode.runs.options import choose_number
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import provenance_fact, scene_facts, unit_of
from polhode.scenes.vocabulary import REQUESTS
from polhode.taylor import defaults
from polhode.taylor.error_growth import Growth, Passage, passage
from polhode.taylor.heyoka import OutOfRange

T = TypeVar("T")

MAX_STEPS = 400_000  # of 10 µs in the lanes of a batch: about four seconds
_BEYOND = 4  # digits of |Phi| beyond those of the type: kappa, of the inputs alone, may be smaller


@dataclass(frozen=True, eq=False, repr=False)
class Conditioning(Result, ByValue):
    """How much a motion multiplies errors at each time, as far as it was followed.

    ``times``: in the scene's unit.  ``number``: the type for whose digits it was followed.
    ``along``: the motion's intervals.  ``kappa``: max over i of the sum over j of
    |d x_i/d ln u_j|, x the state (omega relative to the largest |omega| at the times), u_j the
    components of omega and gamma at the start, A, B, C and the components of Mg r0 that are not 0.
    ``amplification``: the largest |Phi(t, s)|, 0 <= s <= t, Phi(t, s) the derivative of the state
    at t by that at s.

    >>> import polhode
    >>> found = polhode.conditioning("euler/separatrix", [10, 120])
    >>> print(found)
                 t      kappa  amplification  expected in double  inputs  bound
                10       41.2           14.6         14.80-15.58    15.4   14.0
    no digits left after t = 100
    >>> found.digits_bound("double")[1], found.lost
    (0.0, 'no digits left after t = 100')
    """

    scene: Scene
    times: Sequence[Exact]
    number: NumberType
    along: Passage = field(compare=False)

    @cached_property
    def log10_kappa(self) -> tuple[float | None, ...]:
        """log10 of kappa at each time, None where it is not known or no digits are left."""
        return tuple(None if k is None else self._kappas[k] for k in self._places)

    @property
    def kappa(self) -> tuple[float | None, ...]:
        """kappa at each time; inf beyond the range of double."""
        return tuple(None if x is None else _power(x) for x in self.log10_kappa)

    @cached_property
    def log10_amplification(self) -> tuple[float | None, ...]:
        """log10 of the amplification at each time."""
        return tuple(
            None if k is None else rounding_errors.amplification(self.along, k)
            for k in self._places
        )

    def inputs(
        self, number: NumberType | str | None = None, every: int = 0
    ) -> tuple[float | None, ...]:
        """Correct digits that rounding the inputs alone leaves, at each time; None where unknown.

        ``number``: the type asked about, that of the computation unless given.  ``every``: steps
        between two projections, which take away what leads off the exact scene's level; 0 for none.
        """
        kind = self._kind(number)

        def left(k: int) -> float:
            return _digits(self._rounding(kind, every)[k].inputs_size(self.along), kind)

        return tuple(self._at(n, kind, left, 0.0) for n in range(len(self.times)))

    def expected(
        self, number: NumberType | str | None = None, every: int | None = None
    ) -> tuple[Band | None, ...]:
        """The correct digits of runs that round once a step, at each time; None where unknown.

        ``number``: as in ``inputs``.  ``every``: steps between two projections, 0 for none; those
        of the type's runs unless given.
        """
        return tuple(self.band(n, number, every) for n in range(len(self.times)))

    def band(
        self, place: int, number: NumberType | str | None = None, every: int | None = None
    ) -> Band | None:
        """What ``expected`` gives at ``times[place]``."""
        kind = self._kind(number)
        if every is None:
            row = defaults.of(kind)
            every = row.project_every if row.projected else 0

        def band(k: int) -> Band:
            sizes = self._rounding(kind, every)[k].quantiles(self.along)
            return Band(*(_digits(size, kind) for size in reversed(sizes)))

        return self._at(place, kind, band, Band(0.0, 0.0, 0.0))

    def digits_bound(self, number: NumberType | str | None = None) -> tuple[float | None, ...]:
        """-log10 of the bound at each time, between 0 and what the type holds.

        0 where no digits are left, None where kappa is not known.
        """
        kind = self._kind(number)

        def left(k: int) -> float:
            return _digits(self._kappas[k], kind)

        return tuple(self._at(n, kind, left, 0.0) for n in range(len(self.times)))

    @cached_property
    def lost_after(self) -> float | None:
        """The time at which kappa·eps of ``number`` reaches 1; None where it does not."""
        times = tuple(stretch.time for stretch in self.along.stretches)
        grown = Growth(times, tuple(self._kappas), math.inf, 0, Frame.of(self.scene).exponent)
        return grown.reaches(_limit(self.number))

    @property
    def lost(self) -> str:
        """That no digits are left, and after which time; empty where some are."""
        after = self.lost_after
        return "" if after is None else f"no digits left after t = {after:.3g}"

    @property
    def note(self) -> str:
        """Why the motion was not followed to the end, else empty."""
        if self.lost_after is not None or not self.along.note:
            return ""
        return f"kappa {self.along.note}"

    def table(self) -> Table:
        """One row per time: what the motion multiplies, and the digits that this leaves."""
        bands = self.expected()
        columns = [
            Column("t", list(self.times), "time", unit_of(self.scene, "t"), cells.EXACT),
            Column("kappa", self.kappa, "what relative changes of the inputs are multiplied by"),
            Column("log10_amplification", self.log10_amplification, "of the state's errors"),
        ]
        for k, name in enumerate(("least", "median", "most")):
            found = [None if band is None else band[k] for band in bands]
            columns.append(Column(f"digits_expected_{name}", found, "of a run", digits=4))
        columns.append(Column("digits_inputs", self.inputs(), "that rounding them leaves"))
        columns.append(Column("digits_bound", self.digits_bound(), "that are left in any case"))
        return Table([x._replace(type=x.type or cells.DOUBLE) for x in columns])

    def facts(self) -> list[Fact]:
        """The number type, and how far the motion was followed."""
        return [
            *scene_facts(self.scene),
            Fact("number", self.number.name, "number type"),
            Fact("bits", self.number.bits),
            Fact("lost_after", self.lost_after, "no digits are left then", type=cells.DOUBLE),
            Fact("note", self.note, "why it was not followed to the end"),
            provenance_fact(self.scene.provenance()),
        ]

    def __repr__(self) -> str:
        known = [x for x in self.log10_kappa if x is not None]
        largest = f"kappa up to {_power(max(known)):.3g}" if known else "kappa not computed"
        return f"<Conditioning of {self.scene.name}: {largest}>"

    def __str__(self) -> str:
        name = self.number.name
        head = f"{'t':>14}  {'kappa':>9}  {'amplification':>13}  {'expected in ' + name:>18}"
        lines = [f"{head}  inputs  bound"]
        rows = zip(
            *(self.times, self.kappa, self.log10_amplification, self.expected()),
            *(self.inputs(), self.digits_bound()),
            strict=True,
        )
        for t, kappa, log10_a, band, inputs, bound in rows:
            if kappa is not None and log10_a is not None and band is not None:
                told = band.shown(self.number)
                lines.append(
                    f"{to_double(t):14g}  {kappa:9.3g}  {_power(log10_a):13.3g}  {told:>18}"
                    f"  {inputs:6.1f}  {bound:5.1f}"
                )
        return "\n".join([*lines, *filter(None, (self.lost, self.note))])

    def _at(
        self, place: int, number: NumberType, what: Callable[[int], T], none_left: T
    ) -> T | None:
        """What is known of the stretch that ends at ``times[place]``; None where that is unknown.

        ``none_left``: what is told where it is known that no digits of the type are left.
        """
        k = self._places[place]
        if k is not None:
            return what(k)
        lost = self._gone(self.along.outputs[place]) and number.bits <= self.number.bits
        return none_left if lost else None

    def _rounding(self, number: NumberType, every: int) -> list[Rounding]:
        """What rounding has done at the end of each stretch, computed once a type."""
        if (number, every) not in self._known:
            self._known[number, every] = [*rounding_errors.rounding(self.along, number, every)]
        return self._known[number, every]

    @cached_property
    def _known(self) -> dict[tuple[NumberType, int], list[Rounding]]:
        return {}

    def _kind(self, number: NumberType | str | None) -> NumberType:
        if number is None:
            return self.number
        return number_types.named(number) if isinstance(number, str) else number

    def _gone(self, own: float) -> bool:
        """Whether no digits are left at a time of the scene's own unit."""
        after = self.lost_after
        return after is not None and abs(own) * float(Frame.of(self.scene).unit) >= abs(after)

    @cached_property
    def _kappas(self) -> list[float]:
        """log10 of kappa at the end of each stretch."""
        return [*rounding_errors.kappa(self.along)]

    @cached_property
    def _places(self) -> tuple[int | None, ...]:
        """Which stretch ends at each time; None where none does, or no digits are left."""
        ends = {s.time: k for k, s in enumerate(self.along.stretches) if not self._gone(s.time)}
        return tuple(ends.get(t) for t in self.along.outputs)


def conditioning(
    scene: Scene | str | Path,
    times: Iterable[AnyNumber] | None = None,
    number: NumberType | str = DOUBLE,
    max_steps: int = MAX_STEPS,
) -> Conditioning:
    """Compute how much a scene's motion multiplies errors, by its variational equations.

    kappa(t) is the largest change of the state at t per unit of relative change of every number of
    the scene at once.  It is followed until kappa·eps of ``number`` reaches 1 and is right to two
    digits or more: if the motion in double is no longer the scene's, it follows one in a wider
    type.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, a path, or the name of a case.
    times : iterable of numbers, optional
        The times, in the scene's unit; the scene's own by default.
    number : NumberType or str
        The number type whose rounding errors are meant.
    max_steps : int
        A limit on the steps of the variational equations; beyond it kappa is not known.

    Returns
    -------
    Conditioning
        kappa, amplification, expected digits, and the digits that rounding of the scene's numbers
        alone leaves, at each time.

    Raises
    ------
    BadInput
        A scene or a time that cannot be integrated.

    Examples
    --------
    >>> import polhode
    >>> found = polhode.conditioning("euler/separatrix", [10, 20])
    >>> [round(x, 1) for x in found.digits_bound()], [round(x, 1) for x in found.inputs()]
    ([14.0, 12.5], [15.4, 13.8])
    """
    scene = library.load(scene, takes=REQUESTS)
    if times is not None:
        scene = scene.at(times)
    kind = number if isinstance(number, NumberType) else choose_number(scene, number, None)
    most = steps(scene.name, max_steps)
    try:
        along = passage(scene, most, _limit(kind) + _BEYOND)
    except OutOfRange as fault:  # tangents are doubles, whatever the type
        raise fault.refusal(scene.name, DOUBLE) from None
    return Conditioning(scene, scene.times, kind, along)


def _digits(log10_size: float, number: NumberType) -> float:
    """Correct digits at an error of so many eps."""
    return min(number.most_digits, max(0.0, _limit(number) - log10_size))


def _limit(number: NumberType) -> float:
    """log10 of the kappa at which kappa·eps is 1."""
    return (number.bits - 1) * LOG10_2


def _power(log10: float) -> float:
    return 10.0**log10 if log10 < 308 else math.inf

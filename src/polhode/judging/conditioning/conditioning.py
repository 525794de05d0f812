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

*bound(t)* = kappa(t)·eps + |state'|·ulp(t), kappa(t) = max over i of the sum over j of
|d x_i/d ln u_j|, x the state, u every input that is not zero: p q r gamma1 gamma2 gamma3 at the
start, A, B, C and the components of Mg r0, in principal axes, each changed by one unit of itself at
once.  Rounding the inputs and the time can cost so much, and costs less nearly always.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from polhode.common.arguments import steps
from polhode.common.cached_property import cached_property
from polhode.common.value_semantics import ByValue
from polhode.equations.forms import principal
from polhode.judging.conditioning import rounding_errors
from polhode.judging.conditioning.rounding_errors import Band, Scaled
from polhode.numbers import exact, number_types
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Exact, sign
from polhode.numbers.number_types import DOUBLE, LOG10_2, NumberType
from polhode.numbers.scalars import FLOATS, AnyNumber
from polhode.runs.problem.options import choose_number
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.taylor.backend import defaults
from polhode.taylor.variations.state_transition import Passage, passage

MAX_STEPS = 400_000  # of 35 µs: about fifteen seconds
_BEYOND = 4  # digits of |Phi| beyond those of the type: kappa, of the inputs alone, may be smaller


@dataclass(frozen=True, eq=False, repr=False)
class Conditioning(ByValue):
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
        known = {t: x for t, x in self._kappas if not self._gone(t)}
        return tuple(known.get(t) for t in self.along.outputs)

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
        found = self._inputs(kind, every)
        return tuple(
            _digits(rounding_errors.size(self.along, found[k]), kind)
            if k is not None
            else 0.0
            if self._lost(t, kind)
            else None
            for t, k in zip(self.along.outputs, self._places, strict=True)
        )

    def expected(
        self, number: NumberType | str | None = None, every: int | None = None
    ) -> tuple[Band | None, ...]:
        """The correct digits of runs that round once a step, at each time; None where unknown.

        ``number``: as in ``inputs``.  ``every``: steps between two projections, 0 for none; those
        of the type's runs unless given.
        """
        kind = self._kind(number)
        if every is None:
            row = defaults.of(kind)
            every = row.project_every if row.projected else 0
        both = zip(
            self._inputs(kind, every), rounding_errors.scatter(self.along, every), strict=True
        )
        wanted = {k for k in self._places if k is not None}
        bands: dict[int, Band] = {}
        for k, (error, spread) in enumerate(both):
            if k in wanted:
                sizes = rounding_errors.quantiles(self.along, error, spread)
                bands[k] = Band(*(_digits(size, kind) for size in reversed(sizes)))
        none = Band(0.0, 0.0, 0.0)
        return tuple(
            bands[k] if k is not None else none if self._lost(t, kind) else None
            for t, k in zip(self.along.outputs, self._places, strict=True)
        )

    def digits_bound(self, number: NumberType | str | None = None) -> tuple[float | None, ...]:
        """-log10 of the bound at each time, between 0 and what the type holds.

        0 where no digits are left, None where kappa is not known.
        """
        kind = self._kind(number)
        found: list[float | None] = []
        rates = dict(zip(self.along.outputs, self._rates, strict=False))
        for t, own, kappa in zip(self.times, self.along.outputs, self.log10_kappa, strict=True):
            if kappa is None:
                found.append(0.0 if self._lost(own, kind) else None)
                continue
            clock = rates[own] + _log2_ulp(t, kind) * LOG10_2
            taken = _log10_sum(kappa - _limit(kind), clock)
            found.append(min(kind.most_digits, max(0.0, -taken)))
        return tuple(found)

    @cached_property
    def lost_after(self) -> float | None:
        """The time at which kappa·eps of ``number`` reaches 1; None where it does not."""
        before, height, limit = 0.0, 0.0, _limit(self.number)
        for t, here in self._kappas:
            if here >= limit:
                part = (limit - height) / (here - height) if here > height else 1.0
                own = before + min(1.0, max(0.0, part)) * (t - before)
                return own * 2.0**self.scene.time_unit
            before, height = t, here
        return None

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

    def _inputs(self, number: NumberType, every: int = 0) -> list[Scaled]:
        """What rounding the inputs causes at the end of each stretch, computed once a type.

        ``every``: steps between two projections, 0 for none.
        """
        if (number, every) not in self._known_inputs:
            self._known_inputs[number, every] = [*rounding_errors.inputs(self.along, number, every)]
        return self._known_inputs[number, every]

    @cached_property
    def _known_inputs(self) -> dict[tuple[NumberType, int], list[Scaled]]:
        return {}

    def _kind(self, number: NumberType | str | None) -> NumberType:
        if number is None:
            return self.number
        return number_types.named(number) if isinstance(number, str) else number

    def _gone(self, own: float) -> bool:
        """Whether no digits are left at a time of the scene's own unit."""
        after = self.lost_after
        return after is not None and abs(own) * 2.0**self.scene.time_unit >= abs(after)

    def _lost(self, own: float, number: NumberType) -> bool:
        """Whether it is known that no digits of a type are left."""
        return self._gone(own) and number.bits <= self.number.bits

    @cached_property
    def _kappas(self) -> list[tuple[float, float]]:
        return list(rounding_errors.kappa(self.along))

    @cached_property
    def _places(self) -> tuple[int | None, ...]:
        """Which stretch ends at each time; None where none does, or no digits are left."""
        ends = {s.time: k for k, s in enumerate(self.along.stretches) if not self._gone(s.time)}
        return tuple(ends.get(t) for t in self.along.outputs)

    @cached_property
    def _rates(self) -> list[float]:
        """log10 of |state'| at each time that was reached, per unit of the scene's time."""
        along = self.along
        k = {name: to_double(x) for name, x in along.plain.coefficients.items()}
        ends = {s.time: s.state for s in along.stretches}
        found = []
        for t in along.outputs:
            if t in ends:
                rates = np.array(principal.field([float(c) for c in ends[t]], k, FLOATS))
                w, gamma = (float(np.max(np.abs(along.turn @ rates[i : i + 3]))) for i in (0, 3))
                largest = max(w / along.rate_scale, gamma)
                log10 = math.log10(largest) if largest > 0 else -math.inf
                found.append(log10 - self.scene.time_unit * LOG10_2)
        return found


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
    scene = library.load(scene)
    if times is not None:
        scene = scene.at(times)
    kind = number if isinstance(number, NumberType) else choose_number(scene, number, None)
    most = steps(scene.name, max_steps)
    along = passage(scene, most, _limit(kind) + _BEYOND)
    return Conditioning(scene, scene.times, kind, along)


def _digits(log10_size: float, number: NumberType) -> float:
    """Correct digits at an error of so many eps."""
    return min(number.most_digits, max(0.0, _limit(number) - log10_size))


def _limit(number: NumberType) -> float:
    """log10 of the kappa at which kappa·eps is 1."""
    return (number.bits - 1) * LOG10_2


def _log2_ulp(t: Exact, number: NumberType) -> float:
    """log2 of the distance between neighbours at t."""
    if sign(t) == 0:
        return -math.inf
    mantissa, exponent = exact.rounded(t, number.bits)
    return exponent + abs(mantissa).bit_length() - number.bits


def _log10_sum(a: float, b: float) -> float:
    """log10 of 10**a + 10**b."""
    low, high = sorted((a, b))
    return high if low == -math.inf else high + math.log10(1 + 10 ** (low - high))


def _power(log10: float) -> float:
    return 10.0**log10 if log10 < 308 else math.inf

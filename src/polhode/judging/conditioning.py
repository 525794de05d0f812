"""How much a motion multiplies errors: what rounding costs, what is expected of a run.

Three quantities, and a bound:

*inputs(t)*: the error that rounding this scene's numbers to the type causes; known differences,
to first order; of projected runs, what projection leaves of it.

*amplification(t)* = max over s <= t of |Phi(t, s)|: what a change of the state on the way is
multiplied by, w relative to the largest |w| at the output times, gamma as it is.

*expected(t)*: the error of a method that rounds the state once a Taylor step, and what the step
adds while it is computed, beside that of the inputs, as the band in which nine in ten such runs
end; of projected runs, what projection leaves.

*bound(t)* = kappa(t)·eps, kappa(t) = max over i of the sum over j of |d x_i/d ln u_j|, x the
state, u every input that is not zero: p q r gamma1 gamma2 gamma3 at the start, A, B, C and the
components of Mg r0, in principal axes, each changed by one unit of itself at once. Rounding the
inputs can cost so much, and costs less nearly always.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache
from pathlib import Path
from statistics import NormalDist
from typing import NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from polhode.common.arguments import steps
from polhode.common.values import ByValue, cached_property
from polhode.equations.forms import principal
from polhode.equations.integrals import first_integrals
from polhode.equations.readout import at_rest
from polhode.equations.terms import NAMES
from polhode.motion.frame import Frame
from polhode.numbers import exact, number_types
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import ZERO, Exact, sign
from polhode.numbers.number_types import DOUBLE, FLOATS, LOG10_2, AnyNumber, Doubles, NumberType
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
from polhode.taylor.projection import constant_columns, kept_at_zero
from polhode.taylor.variations import six

# --- rounding errors ------------------------------------------------------------------------------
#
# What rounding does to a motion: the inputs', and that of the steps.
#
# All from one quantity, Phi(t, s): what a change of the state at s has become at t, which
# :mod:`polhode.taylor.error_growth` gives stretch by stretch.
#
# **Inputs.**  The scene's numbers are rounded to the type once.  The differences are known, and so
# is what they cause, to first order: v(t) = Phi(t, 0) dx(0) + U(t) dk.  Where a run is projected
# onto the exact scene's first integrals, the part of v across their level is taken away as often,
# as far as a constant component of w can take a number between those of the type: on average alone.
#
# **Steps.**  A step x + d, d = h (x' + higher terms), rounds the state once and its increment four
# times, independent from step to step and from component to component; rounding to numbers so far
# apart has the squared spacing over 12 as its variance:
#
#     R = (ulp(x)² + 4 ulp(h x')²)/12,    C(t) = sum over the steps s of Phi(t, s) R(s) Phi(t, s)^T,
#
# taken half at the start and half at the end of each stretch.  The four stand for where products
# are summed to x', where x' and the higher terms are, where h multiplies, and for the products
# themselves: a count of the roundings of each product gives the same C(t), to 0.013 digits at 98 in
# 100 times of the library's cases; near permanent rotations, whose rates are small sums of large
# products, up to 0.35 digits more, of which runs show half.  Of C, too, projection takes the part
# across the level away, and rounds the state once more.
#
# **Together.**  The error of such a run is v(t) plus a normal deviate of covariance C(t), and its
# size has a distribution: half of such runs have less than its median, nine in ten lie between its
# 5 % and 95 % quantiles.
#
# Sizes are those of *correct digits*: the larger of the largest component of w over the largest |w|
# at the outputs, and of gamma, in scene axes.  They are kept in eps of the type, as a number times
# a power of two, for a motion may multiply them beyond any double.


VARIANCE = 1 / 12  # of a rounding, in squared spacings
INCREMENT = 4  # roundings of the whole increment
_SAMPLES = 512  # normal deviates; fixed ones, so that the quantiles are always the same
_QUANTILES = (0.05, 0.5, 0.95)
_TINY = 2.0**-300  # of derivatives by an imaginary step, which take no difference
_DEPENDENT = 1e-7  # of the largest: gradients that are combinations of the others


class Scaled(NamedTuple):
    """An array times a power of two."""

    values: Doubles
    exponent: int

    def normalised(self) -> Scaled:
        """The same, its largest element about 1."""
        largest = float(np.max(np.abs(self.values), initial=0.0))
        if largest == 0 or not math.isfinite(largest):
            return self
        by = math.frexp(largest)[1]
        return Scaled(np.ldexp(self.values, -by), self.exponent + by)


class Band(NamedTuple):
    """Correct digits that runs are expected to have: nine in ten between ``least`` and ``most``.

    ``middle``: half of them have more.
    """

    least: float
    middle: float
    most: float

    def shown(self, number: NumberType) -> str:
        """The band to hundredths, rounded outward, with no more digits than the type has."""
        if self.most == 0:
            return "none"
        least = math.floor(100 * self.least)
        most = min(math.ceil(100 * self.most), math.floor(100 * number.most_digits))
        return f"{min(least, most) / 100:.2f}-{most / 100:.2f}"


class Rounding(NamedTuple):
    """What rounding has done to a motion at one time.

    ``inputs``: the error that rounding the inputs causes, (6,), in eps.  ``steps``: the covariance
    of what the steps' rounding causes, (6, 6), in eps².
    """

    inputs: Scaled
    steps: Scaled


def inputs_sizes(along: Passage, roundings: Sequence[Rounding]) -> Doubles:
    """log10 of the size of the inputs' part of each; -inf for none."""
    values = np.array([x.inputs.values for x in roundings]).reshape(-1, 6, 1)
    return _logs(_sizes(along, values)[:, 0], [x.inputs.exponent for x in roundings])


def quantiles(along: Passage, roundings: Sequence[Rounding]) -> Doubles:
    """log10 of the 5 %, 50 % and 95 % quantiles of the size of inputs and steps together, a row
    for each."""
    exponents = np.array([x.steps.exponent for x in roundings], int)
    of_inputs = np.array([x.inputs.exponent for x in roundings], int)
    squares, axes = np.linalg.eigh(np.array([x.steps.values for x in roundings]).reshape(-1, 6, 6))
    sizes = np.sqrt(np.maximum(squares, 0) * 2.0 ** (exponents % 2)[:, None])
    # the symmetric root: of eigenvectors any signs, and in a plane any pair, may be found
    roots = axes * sizes[:, None, :] @ axes.transpose(0, 2, 1)
    common = np.maximum(exponents // 2, of_inputs)
    roots = np.ldexp(roots, (exponents // 2 - common)[:, None, None])
    inputs = np.array([x.inputs.values for x in roundings]).reshape(-1, 6)
    inputs = np.ldexp(inputs, (of_inputs - common)[:, None])
    errors = roots @ _deviates() + inputs[:, :, None]
    return _logs(np.quantile(_sizes(along, errors), _QUANTILES, axis=1), common).T


def kappa(along: Passage) -> Iterator[float]:
    """log10 of kappa, the bound of this file's head, at the end of each stretch.

    The start and each number of the body, changed by one unit of itself.
    """
    start = six(along.plain.start)
    by = principal.sensitivities(along.inside.body)
    changes = np.array([[to_double(d.get(name, 0)) for d in by] for name in NAMES])
    chain = changes / [[unit or 1.0] for unit in along.units]
    tangents = Scaled(np.hstack([np.diag(start), np.zeros((len(start), len(by)))]), 0)
    scale = along.rate_scale
    for stretch in along.stretches:
        values = stretch.carried @ tangents.values
        values[:, 6:] += np.ldexp(stretch.driven @ chain, -tangents.exponent)
        tangents = Scaled(values, tangents.exponent).normalised()
        sums = [np.abs(along.turn @ tangents.values[i : i + 3]).sum(axis=1).max() for i in (0, 3)]
        yield _log10(max(sums[0] / scale, sums[1])) + tangents.exponent * LOG10_2


def rounding(along: Passage, number: NumberType, every: int = 0) -> Iterator[Rounding]:
    """What rounding to a type has done at the end of each stretch.

    ``every``: steps between two projections, which leave what lies in the level; 0 for none.
    """
    k = along.plain.coefficients
    start = [_off(x, number) for x in along.plain.start]
    v, c = Scaled(np.array([*start, *[0.0] * (6 - len(start))]), 0), Scaled(np.zeros((6, 6)), 0)
    if at_rest(along.scene).state:  # a run keeps its rounded state
        yield from (Rounding(v, c) for _ in along.stretches)
        return
    off = np.array([_off(k.get(name, ZERO), number) for name in NAMES])
    drive = off / [unit or 1.0 for unit in along.units]
    counts, rests = _projections(along, every), _Rests(along, v.values)
    ends = [stretch.state for stretch, count in zip(along.stretches, counts, strict=True) if count]
    keeps: Iterator[Doubles] = iter(level_projections(along, np.array(ends)) if ends else ())
    for stretch, variances, count in zip(along.stretches, _of_steps(along), counts, strict=True):
        first, rest, once = (np.diag(np.ldexp(x, -c.exponent)) for x in variances)
        half, carried = stretch.steps / 2, stretch.carried
        errors = carried @ v.values + np.ldexp(stretch.driven @ drive, -v.exponent)
        spread = carried @ (c.values + half * first) @ carried.T + half * rest
        if count:
            keep = next(keeps)
            errors = keep @ errors
            rests.keep(errors, v.exponent, count)
            spread = keep @ (spread + (count - 1) * once) @ keep.T + once
        v, c = Scaled(errors, v.exponent).normalised(), Scaled(spread, c.exponent).normalised()
        yield Rounding(v, c)


def amplification(along: Passage, until: int) -> float:
    """log10 of the most that a change on the way is multiplied by, up to a stretch's end.

    The largest |Phi(t, s)| over s <= t, w and gamma in their scales, spectral norm.
    """
    sizes = np.array([along.rate_scale] * 3 + [1.0] * 3)
    back, largest = Scaled(np.eye(6), 0), 0.0
    for stretch in reversed(along.stretches[: until + 1]):
        carried = stretch.carried / sizes[:, None] * sizes
        back = Scaled(back.values @ carried, back.exponent).normalised()
        here = _log10(float(np.linalg.norm(back.values, 2))) + back.exponent * LOG10_2
        largest = max(largest, here)
    return largest


def variances(along: Passage, states: Doubles, steps: npt.ArrayLike) -> Doubles:
    """What one step rounds of each component, in eps²: at states, shape (n, 6), steps so long.

    A step of length 0 rounds the state alone.  Components that the equations themselves keep take
    no rounding.
    """
    k = {name: to_double(x) for name, x in along.plain.coefficients.items()}
    parts = np.broadcast_arrays(*principal.field([*states.T], k, FLOATS))
    rates = np.stack(parts, axis=-1)
    rounded = rates != 0
    rounded[:, list(kept_at_zero(along.scene))] = False
    increments = np.asarray(steps)[..., None] * rates
    squares = spacing(states) ** 2 + INCREMENT * spacing(increments) ** 2
    squared: Doubles = VARIANCE * np.where(rounded, squares, 0.0)
    return squared


def spacing(x: npt.ArrayLike) -> Doubles:
    """From each number to the next one of a type, in eps; 0 for zero."""
    mantissas, exponents = np.frexp(x)
    gaps: Doubles = np.where(mantissas != 0, np.ldexp(1.0, exponents - 1), 0.0)
    return gaps


def _of_steps(along: Passage) -> Iterator[tuple[Doubles, Doubles, Doubles]]:
    """Of each stretch the variances of a step at its start and at its end, and of the state alone
    there."""
    ends = np.array([stretch.state for stretch in along.stretches]).reshape(-1, 6)
    starts = np.vstack([six(along.plain.start), ends])[:-1]
    lengths = np.diff([0.0, *(stretch.time for stretch in along.stretches)])
    steps = lengths / [stretch.steps or 1.0 for stretch in along.stretches]
    places = np.vstack([starts, ends, ends]), np.concatenate([steps, steps, 0 * steps])
    yield from zip(*np.split(variances(along, *places), 3), strict=True)


@cache
def _deviates() -> Doubles:
    """Normal deviates in six dimensions, (6, n), the same ones for every motion.

    Of the points k a that fill a cube evenly, a_j = g**-j with g**7 = g + 1 (Kronecker; Roberts).
    """
    g = 1.0
    for _ in range(60):
        g = (1 + g) ** (1 / 7)
    multiples = np.arange(1, _SAMPLES + 1) * g ** -np.arange(1.0, 7.0)[:, None]
    normal = NormalDist()
    return np.array([[*map(normal.inv_cdf, row)] for row in ((0.5 + multiples) % 1).tolist()])


def _projections(along: Passage, every: int) -> list[int]:
    """How many projections a run makes in each stretch, one every so many steps; 0 for none."""
    counts, left = [], float(every)
    for stretch in along.stretches:
        left -= stretch.steps
        count = 0 if not every or left > 0 else 1 + math.floor(-left / every)
        left += count * every
        counts.append(count)
    return counts


def level_projections(along: Passage, states: Doubles) -> Doubles:
    """The projections onto the level's tangent spaces at states, shape (n, 6), as (n, 6, 6).

    By the least change of the state in the unit of time of a run, as the run does it.
    """
    n, integrals = len(along.plain.start), first_integrals(along.inside)
    k = {name: to_double(x) for name, x in integrals.coefficients.items()}
    moved = states[:, :n, None] + 1j * _TINY * np.eye(n)  # the last index: which component moves
    values = integrals.values([*moved.swapaxes(0, 1)], k, 0.0)
    gradients = np.imag(np.stack(values, axis=1)) / _TINY
    _, strengths, rows = np.linalg.svd(gradients, full_matrices=False)
    rows = rows * (strengths > _DEPENDENT * strengths[:, :1])[..., None]
    keep: Doubles = np.tile(np.eye(6), (len(states), 1, 1))
    keep[:, :n, :n] -= rows.swapaxes(1, 2) @ rows
    return keep


class _Rests:
    """Components of w that the equations keep: a projection chooses among the type's numbers.

    What it rounds off it adds to the next one, so that on average they are what they should be; the
    first ones change nothing.  ``start``: what rounding the inputs did to the state, in eps.
    """

    def __init__(self, along: Passage, start: Doubles) -> None:
        self._start = start
        self._gaps = {
            i: float(spacing(x))
            for i in constant_columns(along.scene)
            if (x := to_double(along.plain.start[i])) != 0
        }
        self._left = dict.fromkeys(self._gaps, 0.0)

    def keep(self, values: Doubles, exponent: int, count: int) -> None:
        """Put the components where so many projections leave them on average.

        ``values``: where they should be, off the exact motion, in eps times 2**exponent.
        """
        for i, gap in self._gaps.items():
            target, chosen = math.ldexp(float(values[i]), exponent), []
            for _ in range(count):
                off = target + self._left[i]
                chosen.append(self._start[i] + gap * round((off - self._start[i]) / gap))
                self._left[i] = off - chosen[-1]
            values[i] = math.ldexp(sum(chosen) / count, -exponent)


def _sizes(along: Passage, errors: Doubles) -> Doubles:
    """The size of each error, of columns of six."""
    w, gamma = (np.abs(along.turn @ errors[..., i : i + 3, :]).max(axis=-2) for i in (0, 3))
    sizes: Doubles = np.maximum(w / along.rate_scale, gamma)
    return sizes


def _logs(sizes: Doubles, exponents: npt.ArrayLike) -> Doubles:
    """log10 of sizes times powers of two; -inf for none."""
    with np.errstate(divide="ignore"):
        logs: Doubles = np.log10(sizes) + LOG10_2 * np.asarray(exponents)
    return logs


def _off(x: Exact, number: NumberType) -> float:
    """The rounded number minus the number, in eps."""
    if sign(x) == 0:
        return 0.0
    mantissa, exponent = exact.rounded(x, number.bits)
    difference = Fraction(mantissa) * Fraction(2) ** exponent - x
    return to_double(difference * Fraction(2) ** (number.bits - 1))


def _log10(x: float) -> float:
    return math.log10(x) if x > 0 else -math.inf


# --- conditioning ---------------------------------------------------------------------------------


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
                10       41.2           14.6         14.78-15.56    15.4   14.0
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
        return tuple(None if k is None else amplification(self.along, k) for k in self._places)

    def inputs(
        self, number: NumberType | str | None = None, every: int = 0
    ) -> tuple[float | None, ...]:
        """Correct digits that rounding the inputs alone leaves, at each time; None where unknown.

        ``number``: the type asked about, that of the computation unless given.  ``every``: steps
        between two projections, which take away what leads off the exact scene's level; 0 for none.
        """
        kind = self._kind(number)
        sizes = inputs_sizes(self.along, self._rounding(kind, every))
        return self._at_times(kind, _digits(sizes, kind).tolist(), 0.0)

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
        logs = quantiles(self.along, self._rounding(kind, every))
        bands = (Band(*row) for row in _digits(logs, kind)[:, ::-1].tolist())
        return self._at_times(kind, bands, Band(0.0, 0.0, 0.0))

    def digits_bound(self, number: NumberType | str | None = None) -> tuple[float | None, ...]:
        """-log10 of the bound at each time, between 0 and what the type holds.

        0 where no digits are left, None where kappa is not known.
        """
        kind = self._kind(number)
        logs = np.array([x for x in self.log10_kappa if x is not None])
        return self._at_times(kind, _digits(logs, kind).tolist(), 0.0)

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
            edges = [None if band is None else band[k] for band in bands]
            columns.append(Column(f"digits_expected_{name}", edges, "of a run", digits=4))
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
        finite = [x for x in self.log10_kappa if x is not None]
        largest = f"kappa up to {_power(max(finite)):.3g}" if finite else "kappa not computed"
        return f"<Conditioning of {self.scene.name}: {largest}>"

    def __str__(self) -> str:
        name = self.number.name
        head = f"{'t':>14}  {'kappa':>9}  {'amplification':>13}  {'expected in ' + name:>18}"
        lines = [f"{head}  inputs  bound"]
        columns = self.times, self.kappa, self.log10_amplification, self.expected()
        rows = zip(*columns, self.inputs(), self.digits_bound(), strict=True)
        for t, kappa, log10_a, band, inputs, bound in rows:
            if kappa is not None and log10_a is not None and band is not None:
                shown = band.shown(self.number)
                lines.append(
                    f"{to_double(t):14g}  {kappa:9.3g}  {_power(log10_a):13.3g}  {shown:>18}"
                    f"  {inputs:6.1f}  {bound:5.1f}"
                )
        return "\n".join([*lines, *filter(None, (self.lost, self.note))])

    def _at_times(
        self, number: NumberType, ends: Iterable[T], none_left: T
    ) -> tuple[T | None, ...]:
        """What is known at each time of the stretch that ends there; None where that is unknown.

        ``ends``: of the stretches that end at a time.  ``none_left``: what is told where it is
        known that no digits of the type are left.
        """
        values, beyond = iter(ends), none_left if number.bits <= self.number.bits else None
        pairs = zip(self._places, self.along.outputs, strict=True)
        return tuple(
            next(values) if k is not None else beyond if self._gone(t) else None for k, t in pairs
        )

    def _rounding(self, number: NumberType, every: int) -> list[Rounding]:
        """What rounding has done at the times where a stretch ends, computed once a type."""
        if (number, every) not in self._known:
            of_stretches = [*rounding(self.along, number, every)]
            there = [of_stretches[k] for k in self._places if k is not None]
            self._known[number, every] = there
        return self._known[number, every]

    @cached_property
    def _known(self) -> dict[tuple[NumberType, int], list[Rounding]]:
        return {}

    def _kind(self, number: NumberType | str | None) -> NumberType:
        return number_types.named(number) if isinstance(number, str) else number or self.number

    def _gone(self, own: float) -> bool:
        """Whether no digits are left at a time of the scene's own unit."""
        after = self.lost_after
        return after is not None and abs(own) * float(Frame.of(self.scene).unit) >= abs(after)

    @cached_property
    def _kappas(self) -> list[float]:
        """log10 of kappa at the end of each stretch."""
        return [*kappa(self.along)]

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


def _digits(log10_sizes: Doubles, number: NumberType) -> Doubles:
    """Correct digits at errors of so many eps."""
    digits: Doubles = np.clip(_limit(number) - log10_sizes, 0.0, number.most_digits)
    return digits


def _limit(number: NumberType) -> float:
    """log10 of the kappa at which kappa·eps is 1."""
    return (number.bits - 1) * LOG10_2


def _power(log10: float) -> float:
    return 10.0**log10 if log10 < 308 else math.inf

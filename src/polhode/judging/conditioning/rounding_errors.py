"""What rounding does to a motion: the inputs', and that of the steps.

All from one quantity, Phi(t, s): what a change of the state at s has become at t, which
:mod:`polhode.taylor.error_growth` gives stretch by stretch.

**Inputs.**  The scene's numbers are rounded to the type once.  The differences are known, and so
is what they cause, to first order: v(t) = Phi(t, 0) dx(0) + U(t) dk.  Where a run is projected onto
the exact scene's first integrals, the part of v across their level is taken away as often, as far
as a constant component of w can take a number between those of the type: on average alone.

**Steps.**  A step x + d, d = h (x' + higher terms), rounds the state once and its increment four
times, independent from step to step and from component to component; rounding to numbers so far
apart has the squared spacing over 12 as its variance:

    R = (ulp(x)² + 4 ulp(h x')²)/12,    C(t) = sum over the steps s of Phi(t, s) R(s) Phi(t, s)^T,

taken half at the start and half at the end of each stretch.  The four stand for where products are
summed to x', where x' and the higher terms are, where h multiplies, and for the products
themselves: a count of the roundings of each product gives the same C(t), to 0.013 digits at 98 in
100 times of the library's cases; near permanent rotations, whose rates are small sums of large
products, up to 0.35 digits more, of which runs show half.  Of C, too, projection takes the part
across the level away, and rounds the state once more.

**Together.**  The error of such a run is v(t) plus a normal deviate of covariance C(t), and its
size has a distribution: half of such runs have less than its median, nine in ten lie between its
5 % and 95 % quantiles.

Sizes are those of *correct digits*: the larger of the largest component of w over the largest |w|
at the outputs, and of gamma, in scene axes.  They are kept in eps of the type, as a number times a
power of two, for a motion may multiply them beyond any double.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from functools import cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.equations.equilibrium import at_rest
from polhode.equations.forms import principal
from polhode.equations.integrals import first_integrals
from polhode.equations.terms import NAMES
from polhode.numbers import exact
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import ZERO, Exact, sign
from polhode.numbers.number_types import LOG10_2, NumberType
from polhode.numbers.rows import Doubles
from polhode.numbers.scalars import FLOATS
from polhode.taylor.error_growth import Passage
from polhode.taylor.projection import constant_columns, kept_at_zero
from polhode.taylor.variations import six

VARIANCE = 1 / 12  # of a rounding, in squared spacings
INCREMENT = 4  # roundings of the whole increment
_SAMPLES = 2000  # of the normal deviates; fixed ones, so that the quantiles are always the same
_QUANTILES = (0.05, 0.5, 0.95)
_TINY = 2.0**-300  # of derivatives by an imaginary step, which take no difference


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

    def inputs_size(self, along: Passage) -> float:
        """log10 of the size of the inputs' part; -inf for none."""
        (size,) = _sizes(along, self.inputs.values[None, :])
        return _log10(float(size)) + self.inputs.exponent * LOG10_2

    def quantiles(self, along: Passage) -> tuple[float, ...]:
        """log10 of the 5 %, 50 % and 95 % quantiles of the size of both together."""
        squares, axes = np.linalg.eigh(self.steps.values)
        exponent, odd = divmod(self.steps.exponent, 2)
        # the symmetric root: of eigenvectors any signs, and in a plane any pair, may be found
        root = axes * np.sqrt(np.maximum(squares, 0) * 2.0**odd) @ axes.T
        common = max(exponent, self.inputs.exponent)
        values = np.ldexp(self.inputs.values, self.inputs.exponent - common)
        values = values + np.ldexp(_deviates() @ root, exponent - common)
        found = np.quantile(_sizes(along, values), _QUANTILES)
        return tuple(_log10(float(x)) + common * LOG10_2 for x in found)


def kappa(along: Passage) -> Iterator[float]:
    """log10 of kappa at the end of each stretch: :mod:`polhode.judging.conditioning.conditioning`.

    The start and each number of the body, changed by one unit of itself.
    """
    start = six(along.plain.start)
    by = principal.sensitivities(along.inside.body)
    chain = np.array(
        [
            [to_double(d.get(name, 0)) / (unit or 1.0) for d in by]
            for name, unit in zip(NAMES, along.units, strict=True)
        ]
    )
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
    drive = np.array(
        [
            _off(k.get(name, ZERO), number) / (unit or 1.0)
            for name, unit in zip(NAMES, along.units, strict=True)
        ]
    )
    clear, rests = _Clearing(along, every), _Rests(along, v.values)
    for stretch, variances in zip(along.stretches, _of_steps(along), strict=True):
        one, other, once = (np.diag(np.ldexp(x, -c.exponent)) for x in variances)
        half, carried = stretch.steps / 2, stretch.carried
        errors = carried @ v.values + np.ldexp(stretch.driven @ drive, -v.exponent)
        spread = carried @ (c.values + half * one) @ carried.T + half * other
        if (count := clear.made(stretch.steps)) > 0:
            keep = clear.removed(stretch.state)
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
    found: Doubles = VARIANCE * np.where(rounded, squares, 0.0)
    return found


def spacing(x: npt.ArrayLike) -> Doubles:
    """From each number to the next one of a type, in eps; 0 for zero."""
    mantissas, exponents = np.frexp(x)
    found: Doubles = np.where(mantissas != 0, np.ldexp(1.0, exponents - 1), 0.0)
    return found


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
    """Normal deviates in six dimensions, the same ones for every motion."""
    return np.random.default_rng(1850).standard_normal((_SAMPLES, 6))


class _Clearing:
    """Takes away what lies across the level of the first integrals, as often as a run does."""

    def __init__(self, along: Passage, every: int) -> None:
        self._every, self._left = every, float(every)
        self._columns = len(along.plain.start)
        self._known = first_integrals(along.inside)
        self._k = {name: to_double(x) for name, x in self._known.coefficients.items()}

    def made(self, steps: float) -> int:
        """How many projections a run makes in so many steps more."""
        self._left -= steps
        if not self._every or self._left > 0:
            return 0
        count = 1 + math.floor(-self._left / self._every)
        self._left += count * self._every
        return count

    def removed(self, state: Doubles) -> Doubles:
        """The projection onto the level's tangent space at a state, (6, 6).

        By the least change of the state in the unit of time of a run, as the run does it.
        """
        n = self._columns
        moved = state[:n, None] + 1j * _TINY * np.eye(n)  # a column for each component
        gradients = np.imag(np.stack(self._known.values([*moved], self._k, 0.0))) / _TINY
        _, strengths, rows = np.linalg.svd(gradients, full_matrices=False)
        rows = rows[strengths > 1e-7 * strengths[0]]
        keep = np.eye(6)
        keep[:n, :n] -= rows.T @ rows
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
            wanted, chosen = math.ldexp(float(values[i]), exponent), []
            for _ in range(count):
                off = wanted + self._left[i]
                chosen.append(self._start[i] + gap * round((off - self._start[i]) / gap))
                self._left[i] = off - chosen[-1]
            values[i] = math.ldexp(sum(chosen) / count, -exponent)


def _sizes(along: Passage, errors: Doubles) -> Doubles:
    """The size of each row."""
    w, gamma = (np.abs(errors[:, i : i + 3] @ along.turn.T).max(axis=1) for i in (0, 3))
    found: Doubles = np.maximum(w / along.rate_scale, gamma)
    return found


def _off(x: Exact, number: NumberType) -> float:
    """The rounded number minus the number, in eps."""
    if sign(x) == 0:
        return 0.0
    mantissa, exponent = exact.rounded(x, number.bits)
    difference = Fraction(mantissa) * Fraction(2) ** exponent - x
    return to_double(difference * Fraction(2) ** (number.bits - 1))


def _log10(x: float) -> float:
    return math.log10(x) if x > 0 else -math.inf

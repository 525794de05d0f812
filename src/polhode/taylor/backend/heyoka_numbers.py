"""heyoka's numbers, arrays and options in the four number types, and its cache of compiled code.

heyoka folds constants of its own making in double, so every constant that enters there is computed
exactly, rounded once to the run's type, and handed over typed.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Sequence
from contextlib import AbstractContextManager, nullcontext
from fractions import Fraction
from typing import Any

import numpy as np

from polhode.common.errors import BadInput
from polhode.numbers import exact
from polhode.numbers.conversion import exactly, to_double, to_extended
from polhode.numbers.exact import Number, sign
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Array, Numbers, Row, flat
from polhode.numbers.scalars import Functions, Real
from polhode.taylor.backend import defaults
from polhode.taylor.backend.engine import constant, hy
from polhode.taylor.backend.process_settings import uncached
from polhode.taylor.backend.types import Expression, HeyokaNumber


def _power(base: Expression, exponent: int) -> Expression:
    """A whole power by squares and products.

    heyoka divides by the base in the series of all powers but squares: where that is zero at the
    beginning of a step, or near it, nothing of them is right.
    """
    if exponent < 3:
        return base**exponent
    square = _power(base, exponent // 2) ** 2
    return square * base if exponent % 2 else square


#: The scalar functions of heyoka's expressions.
EXPRESSIONS = constant(lambda: Functions(hy.expression(0.0), hy.sin, hy.cos, hy.sqrt, _power))

_SMALLEST_DOUBLE = 2.0**-1022


class OutOfRange(ValueError):
    """A number that the run's type cannot hold to its full precision."""

    def refusal(self, source: str, number: NumberType) -> BadInput:
        """What is told of a scene with such a number."""
        return BadInput(source, "number", number.name, f"a type of wider range ({self})")


def scalar(x: Number, number: NumberType) -> HeyokaNumber:
    """The number of heyoka's type for ``number`` nearest to x; raises OutOfRange."""
    if number.name == "double":
        value = to_double(x)
        if not (_SMALLEST_DOUBLE <= abs(value) < math.inf or (value == 0 and sign(x) == 0)):
            raise OutOfRange(f"10**{exact.log10(x):.0f} is outside the range of double")
        return value
    if number.name == "extended":
        if x != 0 and abs(exact.log10(x)) > 4900:
            raise OutOfRange(f"10**{exact.log10(x):.0f} is outside the range of extended")
        return to_extended(x)
    bits = number.bits
    mantissa, exponent = exact.rounded(x, bits)
    real = hy.real(mantissa, bits) * hy.real(2, bits) ** exponent
    if number.name == "quad":
        return hy.real128(real)
    return hy.real(real, bits) if real.prec != bits else real  # an exponent has 64 at least


def scalars(values: Sequence[Number], number: NumberType) -> list[HeyokaNumber]:
    """The numbers of heyoka's type nearest to each; raises OutOfRange."""
    if number.name == "double":
        found = [*map(to_double, values)]
        for k, value in enumerate(found):
            if not _SMALLEST_DOUBLE <= abs(value) < math.inf:  # 0, or out of range
                found[k] = scalar(values[k], number)
        return found
    return [scalar(x, number) for x in values]


def numbers(row: Numbers, number: NumberType) -> Row:
    """A row of heyoka's numbers as a trajectory holds them: an array, or mpf above extended."""
    if number.flat:
        return flat(row)
    return as_mpf(row, number)


def as_mpf(row: Numbers, number: NumberType) -> list[Real]:
    """The same above extended."""
    from polhode.numbers.mpmath_context import mpmath, ordinary

    with mpmath.workprec(number.bits):
        return [ordinary(mpmath.mpf(str(x))) for x in row]


# How far LLVM optimises changes no bit where every operation is a call of a library, only the time
# of a build and of a step.  A quad step is as fast unoptimised, and built in half the time.  An mp
# step is slower by a sixth then, but not at level 1; extended's takes 1.6 times as long.  Doubles
# are left alone: theirs are contracted.
_TYPES: dict[str, Callable[[NumberType], dict[str, Any]]] = {
    "double": lambda _: {},
    "extended": lambda _: {"fp_type": np.longdouble},
    "quad": lambda _: {"fp_type": hy.real128, "opt_level": 0},
    "mp": lambda number: {"fp_type": hy.real, "prec": number.bits, "opt_level": 1},
}


def type_options(number: NumberType) -> dict[str, Any]:
    """heyoka's options that choose a number type, for integrators and compiled functions."""
    compact = {"compact_mode": True} if defaults.of(number).compact else {}
    return _TYPES[number.name](number) | compact


def compact_beyond(most: int, expressions: Iterable[Expression]) -> dict[str, bool]:
    """heyoka's option for expressions of more operations than these, in all.

    Unrolled code is faster, but compiling that of a hundred operations takes minutes, in which no
    signal is heard.
    """
    return {"compact_mode": True} if sum(map(len, expressions)) > most else {}


def array(values: Numbers, number: NumberType) -> Array:
    """Numbers of heyoka's type as the array that it takes."""
    if number.flat:
        return np.array(values, dtype=np.float64 if number.name == "double" else np.longdouble)
    return np.array(values)


def as_fraction(value: HeyokaNumber, number: NumberType) -> Fraction:
    """The exact value of a number of heyoka's."""
    if number.flat:
        return exactly(value)
    from polhode.numbers.mpmath_context import mpmath

    with mpmath.workprec(number.bits):
        return exactly(mpmath.mpf(str(value)))


#: The variable of the environment that bounds the cache, in megabytes; 0 is off, meanwhile.
CACHE_LIMIT = "POLHODE_CACHE_MB"


def _bound_cache() -> None:
    """Apply CACHE_LIMIT, once, where it is set; raises BadInput.

    heyoka keeps a limit in the cache's file, for all who come after: one of 0 would make every
    later process compile anew.  So 0 switches the cache off, in this process alone.
    """
    told = os.environ.get(CACHE_LIMIT)
    if told is None:
        return
    if not (told.isascii() and told.isdigit() and len(told) < 10):
        raise BadInput("environment", CACHE_LIMIT, told, "a whole number of megabytes, 0 for none")
    if int(told) == 0:
        hy.llvm_state.set_diskcache_enabled(False)
    else:
        hy.llvm_state.set_diskcache_limit(1_000_000 * int(told))


_bound_cache()


def cache() -> dict[str, Any]:
    """heyoka's disk cache of compiled code: on or not, where, size and limit, or what is wrong."""
    state = hy.llvm_state
    enabled = bool(state.get_diskcache_enabled())
    try:
        return {
            "enabled": enabled,
            "path": str(state.get_diskcache_path()),
            "bytes": int(state.get_diskcache_size()),
            "limit": int(state.get_diskcache_limit()),
        }
    except (RuntimeError, ValueError) as fault:  # damaged, full, read-only, no folder, no home
        return {"enabled": enabled, "path": None, "bytes": None, "limit": None, "fault": str(fault)}


def disk_cache(number: NumberType) -> AbstractContextManager[None]:
    """heyoka's disk cache, switched off where it never hits and only grows."""
    return uncached() if number.name == "mp" else nullcontext()

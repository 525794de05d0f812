"""heyoka, as polhode uses it: its numbers, settings of the process, outcomes of steps."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from fractions import Fraction
from functools import cache
from typing import TYPE_CHECKING, Any, Generic, NoReturn, TypeAlias, TypeVar
from weakref import WeakSet

import numpy as np

from polhode.common.errors import BadInput
from polhode.common.interrupts import Lock, LockPlace
from polhode.motion.outcomes import Outcome
from polhode.numbers import exact, number_types
from polhode.numbers.conversion import exactly, to_double, to_extended
from polhode.numbers.exact import Number, sign
from polhode.numbers.number_types import EXTENDED, QUAD, Array, Functions, Numbers, NumberType, Real
from polhode.taylor import defaults

# --- types ----------------------------------------------------------------------------------------
#
# heyoka's things by kind: it brings no types along, and these names say what is meant.


#: float, numpy.longdouble, heyoka.real128 or heyoka.real, by the number type of the run.
HeyokaNumber: TypeAlias = Any

#: heyoka.expression, of variables, parameters and the time.
Expression: TypeAlias = Any

#: heyoka.taylor_adaptive, or taylor_adaptive_batch: compiled code, state and time of a system.
HeyokaIntegrator: TypeAlias = Any

#: heyoka.nt_event or t_event, and their batch kinds.
HeyokaEvent: TypeAlias = Any

#: heyoka.taylor_outcome: how steps ended.
HeyokaOutcome: TypeAlias = Any

#: heyoka.continuous_output: the polynomials of some steps.
HeyokaOutput: TypeAlias = Any

#: heyoka.cfunc: compiled code of some expressions.
CompiledFunction: TypeAlias = Any


# --- engine ---------------------------------------------------------------------------------------
#
# heyoka, or what stands for it where it is not installed: every module imports, no call works.
#
# So results of any kind are read, judged against a closed form, drawn and saved without it;
# whatever integrates says in one line how to get it.


__all__ = ["NoHeyoka", "constant", "hy", "installed"]

T = TypeVar("T")


class NoHeyoka(ModuleNotFoundError):
    """Something has to be integrated, and heyoka is not installed."""

    def __init__(self) -> None:
        sentence = "heyoka: expected to be installed, since integration needs it: "
        sentence += "conda install -c conda-forge heyoka.py, or on Linux pip install heyoka"
        super().__init__(sentence, name="heyoka")


class Missing:
    """heyoka or a part of it, where it is not installed: a name until it is called."""

    def __getattr__(self, name: str) -> Missing:
        if name.startswith("__"):
            raise AttributeError(name)
        return Missing()

    def __call__(self, *given: object, **named: object) -> NoReturn:
        """Refuse: there is nothing to call."""
        raise NoHeyoka

    __int__ = __call__


#: Whether something can be integrated here.
installed = True
if TYPE_CHECKING:
    import heyoka as hy
else:
    try:
        import heyoka as hy
    except ModuleNotFoundError as fault:
        if fault.name != "heyoka":
            raise
        hy, installed = Missing(), False
    else:
        # heyoka logs on stdout, the place for results.  What it has to say is known from
        # elsewhere: a cache that cannot be used costs compiling again and shows in
        # ``compiled_code_cache``; a multiple zero that it gives up on is found through the
        # derivative, or shows in ``EventTimes.complete``.
        hy.set_logger_level_critical()


def constant(make: Callable[[], T]) -> T:
    """What heyoka makes once, when a module is imported; raises nothing where it is missing."""
    try:
        return make()
    except NoHeyoka:
        missing: T = Missing()  # type: ignore[assignment]
        return missing


# --- process settings -----------------------------------------------------------------------------
#
# Settings of libraries for the whole process, changed while any thread is in need of it.


class _Block:
    """One thread inside."""


class Meanwhile(Generic[T]):
    """``with meanwhile():`` a setting has this value; the last to leave puts back what was there.

    However a block is ended, by Ctrl-C at its very end too: who is inside is known by what lives
    as long as the block does, not by counting.  Its end may come in a garbage collection, below any
    lock of the thread that collects, so it waits for none: who holds this one looks again.
    """

    def __init__(self, read: Callable[[], T], write: Callable[[T], object], value: T) -> None:
        self._read, self._write, self._value = read, write, value
        self._before: T | None = None
        self._inside: WeakSet[_Block] = WeakSet()
        self._lock = Lock(LockPlace.STORE)

    @contextmanager
    def __call__(self) -> Iterator[None]:
        """The block."""
        block = _Block()
        try:
            with self._lock.held():
                if self._before is None:
                    self._before = self._read()
                self._inside.add(block)
                self._write(self._value)
            yield
        finally:
            del block
            self._put_back()

    def _put_back(self) -> None:
        """What was there before, if nobody is inside."""
        bare = self._lock.bare
        while self._before is not None and not self._inside and bare.acquire(blocking=False):
            try:
                if self._before is not None and not self._inside:
                    self._write(self._before)
                    self._before = None
            finally:
                bare.release()


#: heyoka's compiled functions run on the caller's thread alone.
one_thread = Meanwhile(hy.get_nthreads, hy.set_nthreads, 1)

#: Code is neither looked for in heyoka's cache on the disk nor kept there.
uncached = Meanwhile(
    hy.llvm_state.get_diskcache_enabled, hy.llvm_state.set_diskcache_enabled, False
)


def one_blas_thread() -> AbstractContextManager[None]:
    """A block in which numpy's linear algebra runs on the caller's thread alone.

    With matrices of 6 x 6 a second thread has nothing to do and spins: a refined run then takes
    twice the processor time of its wall clock, and on a busy machine many times that.
    """
    return _blas()()


@cache
def _blas() -> Meanwhile[tuple[int, ...]]:
    from threadpoolctl import ThreadpoolController

    libraries = ThreadpoolController().select(user_api="blas").lib_controllers

    def read() -> tuple[int, ...]:
        return tuple(library.get_num_threads() for library in libraries)

    def write(threads: tuple[int, ...]) -> None:
        for library, count in zip(libraries, threads, strict=True):
            library.set_num_threads(count)

    return Meanwhile(read, write, (1,) * len(libraries))


# --- heyoka numbers -------------------------------------------------------------------------------
#
# heyoka's numbers, arrays and options in the four number types, and its cache of compiled code.
#
# heyoka folds constants of its own making in double, so every constant that enters there is
# computed exactly, rounded once to the run's type, and handed over typed.


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
        doubles = [*map(to_double, values)]
        for k, value in enumerate(doubles):
            if not _SMALLEST_DOUBLE <= abs(value) < math.inf:  # 0, or out of range
                doubles[k] = scalar(values[k], number)
        return doubles
    return [scalar(x, number) for x in values]


def as_mpf(row: Numbers, number: NumberType) -> list[Real]:
    """A row of heyoka's numbers above extended as a trajectory holds it."""
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
    limit = os.environ.get(CACHE_LIMIT)
    if limit is None:
        return
    if not (limit.isascii() and limit.isdigit() and len(limit) < 10):
        raise BadInput("environment", CACHE_LIMIT, limit, "a whole number of megabytes, 0 for none")
    if int(limit) == 0:
        hy.llvm_state.set_diskcache_enabled(False)
    else:
        hy.llvm_state.set_diskcache_limit(1_000_000 * int(limit))


_bound_cache()


def compiled_code_cache() -> dict[str, Any]:
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


# --- step outcomes --------------------------------------------------------------------------------
#
# How heyoka's steps ended, in polhode's words.


TIME_LIMIT = hy.taylor_outcome.time_limit  # of a call that came to its end

_WORDS = constant(
    lambda: {
        int(hy.taylor_outcome.err_nf_state): Outcome.NON_FINITE,
        int(TIME_LIMIT): Outcome.REACHED_END,
        int(hy.taylor_outcome.cb_stop): Outcome.STOPPED_AT_EVENT,  # callbacks ask for nothing else
        -1: Outcome.SINGULAR,  # the first and only terminal event
    }
)


def ending(outcome: HeyokaOutcome) -> Outcome:
    """The outcome of heyoka's call; STEP_LIMIT where the steps allowed were taken."""
    return _WORDS.get(int(outcome), Outcome.STEP_LIMIT)


# --- wider type -----------------------------------------------------------------------------------
#
# The next wider number type, in which corrections are computed, and ways there and back.


#: Between two number types: a state into an array, an array to a state, one number.
Conversions: TypeAlias = tuple[
    Callable[[Array, Array], None], Callable[[Array], Array], Callable[[HeyokaNumber], HeyokaNumber]
]


def wider(number: NumberType) -> NumberType:
    """The type in which corrections of a run in ``number`` are computed."""
    if number.name == "double" and number_types.extended_here():
        return EXTENDED
    if number.flat:
        return QUAD
    return NumberType("mp", number.bits + 64)


def conversions(number: NumberType, wide: NumberType) -> Conversions:
    """Ways between the two types: a state into an array, an array to a state, one number."""
    if wide.name == "extended":
        return np.copyto, lambda row: row.astype(np.float64), np.longdouble
    bits = number.bits

    def widened(x: HeyokaNumber) -> HeyokaNumber:
        return hy.real128(x) if wide.name == "quad" else hy.real(x, wide.bits)

    def narrowed(x: HeyokaNumber) -> HeyokaNumber:
        if number.name == "double":
            return float(x)
        if number.name == "extended":
            high = float(x)
            return np.longdouble(high) + np.longdouble(float(x - hy.real128(high)))
        rounded = hy.real(x, bits)
        return hy.real128(rounded) if number.name == "quad" else rounded

    def load(into: Array, row: Array) -> None:
        for i, x in enumerate(row):
            into[i] = widened(x)

    return load, lambda row: array([narrowed(x) for x in row], number), widened

"""mpmath for polhode alone: a context of its own, so that nobody else's precision is read or set.

mpmath keeps the precision in force in its context, and all its numbers belong to one.  The context
that a program shares by ``import mpmath`` is the caller's.  Everything here computes with the one
of this module, and only inside ``with mpmath.workprec(bits)``, which holds a lock: threads take
turns, each at the precision that it asked for.  What leaves polhode is made :func:`ordinary`.
"""

from __future__ import annotations

import os
from collections.abc import Generator, Mapping
from threading import get_ident
from typing import TYPE_CHECKING, Any, TypeVar, cast

import mpmath as shared
from mpmath import libmp
from mpmath.ctx_mp import MPContext

from polhode.common.interrupts import Held, Lock, LockPlace

if TYPE_CHECKING:
    from mpmath import mpc as mpc
    from mpmath import mpf as mpf


#: Of the precision of :data:`mpmath`, and of FLINT's: :mod:`polhode.numbers.flint_context`.
PRECISION = Lock(LockPlace.PRECISION)


class _Private(MPContext):  # type: ignore[misc]
    """An mpmath context that one thread uses at a time."""

    prec: int  # of mpmath's class, a property there
    _prec: int
    _dps: int

    def __init__(self) -> None:
        super().__init__()
        self._outer = 0, 0, 0  # the thread that is inside, and the precision that it found
        self.mpf.__reduce__ = lambda x: (_real, (_plain(x._mpf_),))  # mpmath's own would round
        self.mpc.__reduce__ = lambda x: (_pair, tuple(map(_plain, x._mpc_)))

    def _holding(self, bits: int) -> Generator[None, None, None]:
        """The lock and so many bits, as long as this generator lives."""
        with PRECISION.held():
            before, digits = self._prec, self._dps
            outermost = self._outer[0] != get_ident()
            if outermost:
                self._outer = get_ident(), before, digits
            try:
                self.prec = bits
                yield
            finally:  # without a call, where Ctrl-C could come between: plain assignments
                self._prec_rounding[0] = self._prec = before
                self._dps = digits
                if outermost:
                    self._outer = 0, 0, 0

    def forget(self) -> None:
        """In a forked child: another thread's precision, which computes in the parent, is gone."""
        thread, before, digits = self._outer
        if thread not in (0, get_ident()):
            self._prec_rounding[0] = self._prec = before
            self._dps = digits
            self._outer = 0, 0, 0

    def workprec(self, bits: int) -> Held:
        """``with mpmath.workprec(bits)``: so many bits, and no other thread, until its end."""
        return Held(self._holding(bits))

    def workdps(self, digits: int) -> Held:
        """The same for so many decimal digits."""
        return Held(self._holding(libmp.dps_to_prec(digits)))

    def extraprec(self, bits: int) -> Held:
        """The same for so many bits more than are in force."""
        return Held(self._holding(self.prec + bits))


#: To be imported in place of the package ``mpmath``.
mpmath: Any = _Private()

if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=mpmath.forget)

#: What mpmath holds of a number: sign, mantissa, exponent, bits.
Raw = tuple[int, int, int, int]
T = TypeVar("T")

if not TYPE_CHECKING:
    mpf, mpc = mpmath.mpf, mpmath.mpc


def _real(raw: Raw) -> mpf:
    """One of this module's from what was pickled."""
    return mpmath.make_mpf(raw)


def _pair(*raw: Raw) -> mpc:
    return mpmath.make_mpc(raw)


def _plain(raw: Raw) -> Raw:
    """Without the type of integers that mpmath was built on, which may not be there on arrival."""
    sign, mantissa, exponent, bits = raw
    return int(sign), int(mantissa), int(exponent), int(bits)


# --- ordinary numbers -----------------------------------------------------------------------------
#
# The numbers that leave polhode: plain mpmath's mpf and mpc, which keep all bits when copied.
#
# mpmath rounds an mpf that is copied, pickled or sent to another process to the precision in force
# where it arrives, 53 bits as a rule, and says nothing. These are of mpmath's own classes in all
# else: arithmetic with them gives mpmath's numbers, at the caller's precision.


class OrdinaryReal(shared.mpf):  # type: ignore[misc]
    """An mpf whose copies are it, to the bit."""

    __slots__ = ()

    def __reduce__(self) -> tuple[object, ...]:
        return ordinary_real, (_plain(self._mpf_),)


class OrdinaryComplex(shared.mpc):  # type: ignore[misc]
    """An mpc whose copies, and whose parts' copies, are them, to the bit."""

    __slots__ = ()

    @property
    def real(self) -> OrdinaryReal:
        """The real part."""
        return ordinary_real(self._mpc_[0])

    @property
    def imag(self) -> OrdinaryReal:
        """The imaginary part."""
        return ordinary_real(self._mpc_[1])

    def __reduce__(self) -> tuple[object, ...]:
        return ordinary_complex, tuple(map(_plain, self._mpc_))


OrdinaryComplex.__name__ = "mpc"  # which mpmath's repr writes


def ordinary_real(raw: Raw) -> OrdinaryReal:
    """The mpf that mpmath holds as these."""
    number = object.__new__(OrdinaryReal)
    number._mpf_ = raw
    return number


def rounded_real(raw: Raw, bits: int) -> OrdinaryReal:
    """The nearest mpf of so many bits."""
    return ordinary_real(libmp.mpf_pos(raw, bits, "n"))


def ordinary_complex(first: Raw, second: Raw) -> OrdinaryComplex:
    """The mpc whose parts mpmath holds as these."""
    number = object.__new__(OrdinaryComplex)
    number._mpc_ = first, second
    return number


def ordinary(value: T) -> T:
    """A value with its mpf and mpc, in lists, tuples and dicts too, as those of plain mpmath."""
    copy: Any = value
    if (raw := getattr(value, "_mpf_", None)) is not None:
        copy = ordinary_real(raw)
    elif (parts := getattr(value, "_mpc_", None)) is not None:
        copy = ordinary_complex(*parts)
    elif type(value) in (list, tuple):
        copy = type(copy)(map(ordinary, copy))
    elif isinstance(value, Mapping):
        copy = {name: ordinary(x) for name, x in value.items()}
    return cast("T", copy)


def own(value: T) -> T:
    """The way back: a number, or rows of them, to be computed with here; exact."""
    copy: Any = value
    if (raw := getattr(value, "_mpf_", None)) is not None:
        copy = mpmath.make_mpf(raw)
    elif type(value) in (list, tuple):
        copy = type(copy)(map(own, copy))
    elif getattr(getattr(value, "dtype", None), "kind", "") == "O":  # an array of mpf
        copy = own(copy.tolist())
    return cast("T", copy)

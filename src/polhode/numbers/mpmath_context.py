"""mpmath for polhode alone: a context of its own, so that nobody else's precision is read or set.

mpmath keeps the precision in force in its context, and all its numbers belong to one.  The context
that a program shares by ``import mpmath`` is the caller's.  Everything here computes with the one
of this module, and only inside ``with mpmath.workprec(bits)``, which holds a lock: threads take
turns, each at the precision that it asked for.  What leaves polhode is made :func:`ordinary`
(:mod:`polhode.numbers.lossless_mpf`).
"""

from __future__ import annotations

import os
from collections.abc import Generator, Mapping
from threading import get_ident
from typing import TYPE_CHECKING, Any, TypeVar

from mpmath import libmp
from mpmath.ctx_mp import MPContext

from polhode.common.interrupts import Held, Lock, Place
from polhode.numbers.lossless_mpf import Raw, pair, plain, real

if TYPE_CHECKING:
    from mpmath import mpc as mpc
    from mpmath import mpf as mpf


#: Of the precision of :data:`mpmath`, and of FLINT's: :mod:`polhode.numbers.flint_context`.
PRECISION = Lock(Place.PRECISION)


class _Private(MPContext):  # type: ignore[misc]
    """An mpmath context that one thread uses at a time."""

    prec: int  # of mpmath's class, a property there
    _prec: int
    _dps: int

    def __init__(self) -> None:
        super().__init__()
        self._outer = 0, 0, 0  # the thread that is inside, and the precision that it found
        self.mpf.__reduce__ = lambda x: (_real, (plain(x._mpf_),))  # mpmath's own would round
        self.mpc.__reduce__ = lambda x: (_pair, tuple(map(plain, x._mpc_)))

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

T = TypeVar("T")

if not TYPE_CHECKING:
    mpf, mpc = mpmath.mpf, mpmath.mpc


def _real(raw: Raw) -> mpf:
    """One of this module's from what was pickled."""
    return mpmath.make_mpf(raw)


def _pair(*raw: Raw) -> mpc:
    return mpmath.make_mpc(raw)


def ordinary(value: T) -> T:
    """A value with its mpf and mpc, in lists, tuples and dicts too, as those of plain mpmath."""
    copy: Any = value
    if (raw := getattr(value, "_mpf_", None)) is not None:
        copy = real(raw)
    elif (parts := getattr(value, "_mpc_", None)) is not None:
        copy = pair(*parts)
    elif type(value) in (list, tuple):
        copy = type(copy)(map(ordinary, copy))
    elif isinstance(value, Mapping):
        copy = {name: ordinary(x) for name, x in value.items()}
    same: T = copy
    return same


def own(value: T) -> T:
    """The way back: a number, or rows of them, to be computed with here; exact."""
    copy: Any = value
    if (raw := getattr(value, "_mpf_", None)) is not None:
        copy = mpmath.make_mpf(raw)
    elif type(value) in (list, tuple):
        copy = type(copy)(map(own, copy))
    elif getattr(getattr(value, "dtype", None), "kind", "") == "O":  # an array of mpf
        copy = own(copy.tolist())
    same: T = copy
    return same

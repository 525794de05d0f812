"""mpmath for polhode alone: a context of its own, so that nobody else's precision is read or set.

mpmath keeps the precision in force in its context, and all its numbers belong to one.  The context
that a program shares by ``import mpmath`` is the caller's.  Everything here computes with the one
of this module, and only inside ``with mpmath.workprec(bits)``, which holds a lock: threads take
turns, each at the precision that it asked for.  What leaves polhode is made :func:`ordinary`
(:mod:`polhode.numbers.lossless_mpf`).
"""

from __future__ import annotations

from collections.abc import Generator, Mapping
from typing import TYPE_CHECKING, Any

from mpmath import libmp
from mpmath.ctx_mp import MPContext

from polhode.common.locks import Held, Lock, Place
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
        self.mpf.__reduce__ = lambda x: (_real, (plain(x._mpf_),))  # mpmath's own would round
        self.mpc.__reduce__ = lambda x: (_pair, tuple(map(plain, x._mpc_)))

    def _holding(self, bits: int) -> Generator[None, None, None]:
        """The lock and so many bits, as long as this generator lives."""
        with PRECISION.held():
            before, digits = self._prec, self._dps
            try:
                self.prec = bits
                yield
            finally:  # without a call, where Ctrl-C could come between: three plain assignments
                self._prec_rounding[0] = self._prec = before
                self._dps = digits

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

if not TYPE_CHECKING:
    mpf, mpc = mpmath.mpf, mpmath.mpc


def _real(raw: Raw) -> mpf:
    """One of this module's from what was pickled."""
    return mpmath.make_mpf(raw)


def _pair(*raw: Raw) -> mpc:
    return mpmath.make_mpc(raw)


def ordinary(value: Any) -> Any:
    """A value with its mpf and mpc, in lists, tuples and dicts too, as those of plain mpmath."""
    if (raw := getattr(value, "_mpf_", None)) is not None:
        return real(raw)
    if (parts := getattr(value, "_mpc_", None)) is not None:
        return pair(*parts)
    if type(value) in (list, tuple):
        return type(value)(map(ordinary, value))
    if isinstance(value, Mapping):
        return {name: ordinary(x) for name, x in value.items()}
    return value


def own(value: Any) -> Any:
    """The way back: a number, or rows of them, to be computed with here; exact."""
    if (raw := getattr(value, "_mpf_", None)) is not None:
        return mpmath.make_mpf(raw)
    return type(value)(map(own, value)) if type(value) in (list, tuple) else value

"""mpmath for polhode alone: a context of its own, so that nobody else's precision is read or set.

mpmath keeps the precision in force in its context, and all its numbers belong to one.  The context
that a program shares by ``import mpmath`` is the caller's.  Everything here computes with the one
of this module, and only inside ``with mpmath.workprec(bits)``, which holds a lock: threads take
turns, each at the precision that it asked for.  What leaves polhode is made :func:`ordinary`.
"""

from __future__ import annotations

import os
from collections.abc import Generator, Mapping
from threading import RLock
from typing import TYPE_CHECKING, Any

import mpmath as shared
from mpmath import libmp
from mpmath.ctx_mp import MPContext

if TYPE_CHECKING:
    from mpmath import mpc as mpc
    from mpmath import mpf as mpf


class Held:
    """``with Held(steps):`` runs a generator to its one yield, and on to its end afterwards.

    Ctrl-C or an alarm may raise between any two steps of Python.  What the generator holds it
    gives back however it ends: by an exception inside, or because nobody knows it any more.
    """

    __slots__ = ("_steps",)

    def __init__(self, steps: Generator[None, None, None]) -> None:
        self._steps = steps

    def __enter__(self) -> None:
        try:
            next(self._steps)
        except BaseException:
            self._steps.close()
            raise

    def __exit__(self, *fault: object) -> None:
        self._steps.close()


class _Private(MPContext):  # type: ignore[misc]
    """An mpmath context that one thread uses at a time."""

    prec: int  # of mpmath's class, a property there

    def __init__(self) -> None:
        super().__init__()
        self.unlock()
        if hasattr(os, "register_at_fork"):  # the thread that held it is not there
            os.register_at_fork(after_in_child=self.unlock)

    def unlock(self) -> None:
        """A lock that nobody holds."""
        self.lock = RLock()

    def _holding(self, bits: int) -> Generator[None, None, None]:
        """The lock and so many bits, as long as this generator lives."""
        with self.lock:
            before = self.prec
            try:
                self.prec = bits
                yield
            finally:
                self.prec = before

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


_make_mpf = shared.mp.make_mpf


def ordinary(value: Any) -> Any:
    """A value with its mpf and mpc, in lists, tuples and dicts too, as those of plain mpmath."""
    if (raw := getattr(value, "_mpf_", None)) is not None:
        return _make_mpf(raw)
    if (parts := getattr(value, "_mpc_", None)) is not None:
        return shared.mp.make_mpc(parts)
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

"""The precision of FLINT's balls, one thread at a time.

python-flint keeps one precision for the whole process.  Here it is set only inside ``with
ctx.workprec(bits)``, which holds the lock of :mod:`polhode.numbers.mpmath_context` and leaves what
it found.  A caller who sets ``flint.ctx.prec`` in another thread meanwhile widens balls (what is
proven stays so) and may cost digits.
"""

from __future__ import annotations

import os
from collections.abc import Generator
from threading import get_ident

import flint

from polhode.common.interrupts import Held
from polhode.numbers.mpmath_context import PRECISION

_outer = 0, 0  # the thread that is inside, and the precision that it found


def _holding(bits: int) -> Generator[None, None, None]:
    """The lock and so many bits, as long as this generator lives."""
    global _outer
    with PRECISION.held():
        before = flint.ctx.prec
        outermost = _outer[0] != get_ident()
        if outermost:
            _outer = get_ident(), before
        try:
            flint.ctx.prec = bits
            yield
        finally:
            flint.ctx.prec = before
            if outermost:
                _outer = 0, 0


class _Context:
    """What is used of ``flint.ctx``."""

    def workprec(self, bits: int) -> Held:
        """``with ctx.workprec(bits)``: balls of so many bits, and no other thread's."""
        return Held(_holding(bits))

    @property
    def prec(self) -> int:
        """The bits in force."""
        return int(flint.ctx.prec)


#: To be imported in place of flint's own ``ctx``.
ctx = _Context()


def _forget() -> None:
    """In a forked child: the precision of another thread, which computes in the parent, is gone."""
    global _outer
    thread, before = _outer
    if thread not in (0, get_ident()):
        flint.ctx.prec = before
        _outer = 0, 0


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)

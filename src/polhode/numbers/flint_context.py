"""The precision of FLINT's balls, one thread at a time.

python-flint keeps one precision for the whole process.  Here it is set only inside ``with
ctx.workprec(bits)``, which holds the lock of :mod:`polhode.numbers.mpmath_context` and leaves what
it found.  A caller who sets ``flint.ctx.prec`` in another thread meanwhile widens balls (what is
proven stays so) and may cost digits.
"""

from __future__ import annotations

from collections.abc import Generator

import flint

from polhode.common.locks import Held
from polhode.numbers.mpmath_context import PRECISION


def _holding(bits: int) -> Generator[None, None, None]:
    """The lock and so many bits, as long as this generator lives."""
    with PRECISION.held():
        before = flint.ctx.prec
        try:
            flint.ctx.prec = bits
            yield
        finally:
            flint.ctx.prec = before


class _Context:
    """What is used of ``flint.ctx``."""

    def workprec(self, bits: int) -> Held:
        """``with ctx.workprec(bits)``: balls of so many bits, and no other thread's."""
        return Held(_holding(bits))


#: To be imported in place of flint's own ``ctx``.
ctx = _Context()

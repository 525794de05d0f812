"""The precision of FLINT's balls, one thread at a time.

python-flint keeps one precision for the whole process.  Here it is set only inside ``with
ctx.workprec(bits)``, which holds the lock of :mod:`polhode.numbers.private` and leaves what it
found.  A caller who sets ``flint.ctx.prec`` in another thread meanwhile widens balls (what is
proven stays so) and may cost digits.
"""

from __future__ import annotations

from types import TracebackType

import flint

from polhode.numbers.private import mpmath


class _Within:
    """A precision of balls in force."""

    def __init__(self, bits: int) -> None:
        self._bits, self._before = bits, 0

    def __enter__(self) -> None:
        mpmath.lock.acquire()
        self._before = flint.ctx.prec
        flint.ctx.prec = self._bits

    def __exit__(
        self,
        kind: type[BaseException] | None,
        fault: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        flint.ctx.prec = self._before
        mpmath.lock.release()


class _Context:
    """What is used of ``flint.ctx``."""

    def workprec(self, bits: int) -> _Within:
        """``with ctx.workprec(bits)``: balls of so many bits, and no other thread's."""
        return _Within(bits)


#: To be imported in place of flint's own ``ctx``.
ctx = _Context()

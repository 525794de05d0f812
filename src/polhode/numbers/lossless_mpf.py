"""The numbers that leave polhode: plain mpmath's mpf and mpc, which keep all bits when copied.

mpmath rounds an mpf that is copied, pickled or sent to another process to the precision in force
where it arrives, 53 bits as a rule, and says nothing.  These are of mpmath's own classes in all
else: arithmetic with them gives mpmath's numbers, at the caller's precision.
"""

from __future__ import annotations

import mpmath

Raw = tuple[int, int, int, int]

_new = object.__new__


class mpf(mpmath.mpf):  # type: ignore[misc]  # noqa: N801
    """An mpf whose copies are it, to the bit."""

    __slots__ = ()

    def __reduce__(self) -> tuple[object, ...]:
        return real, (plain(self._mpf_),)


class mpc(mpmath.mpc):  # type: ignore[misc]  # noqa: N801
    """An mpc whose copies, and whose parts' copies, are them, to the bit."""

    __slots__ = ()

    @property
    def real(self) -> mpf:
        """The real part."""
        return real(self._mpc_[0])

    @property
    def imag(self) -> mpf:
        """The imaginary part."""
        return real(self._mpc_[1])

    def __reduce__(self) -> tuple[object, ...]:
        return pair, tuple(map(plain, self._mpc_))


def real(raw: Raw) -> mpf:
    """The mpf that mpmath holds as these."""
    number = _new(mpf)
    number._mpf_ = raw
    return number


def pair(first: Raw, second: Raw) -> mpc:
    """The mpc whose parts mpmath holds as these."""
    number = _new(mpc)
    number._mpc_ = first, second
    return number


def plain(raw: Raw) -> Raw:
    """Without the type of integers that mpmath was built on, which may not be there on arrival."""
    sign, mantissa, exponent, bits = raw
    return int(sign), int(mantissa), int(exponent), int(bits)

"""Why a proof was refused."""

from __future__ import annotations


class NotProved(ArithmeticError):
    """A claim that polhode did not prove: the first inequality that does not hold, what to try.

    >>> import polhode
    >>> polhode.prove_orbit("euler/largest-axis")  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ...
    polhode.proofs.refusals.NotProved: euler/largest-axis: the orbit is not isolated, ...
    """

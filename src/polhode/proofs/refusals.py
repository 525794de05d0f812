"""Why a proof was refused."""

from __future__ import annotations

from polhode.enclosures.fixed_point_problem import Refused
from polhode.proofs.krawczyk import Contraction

NAMES = ("p", "q", "r", "gamma1", "gamma2", "gamma3", "T", "lam1", "lam2", "lam3")


class NotProved(ArithmeticError):
    """A claim that polhode did not prove: the message says which condition failed, and by how much.

    >>> import polhode
    >>> polhode.prove_orbit("euler/largest-axis")  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ...
    polhode.proofs.refusals.NotProved: euler/largest-axis: the orbit is not isolated, ...
    """


class Unproved(Refused):
    """A condition of a theorem that no more digits will mend."""


class NotContracted(Refused):
    """Krawczyk's test did not hold.  ``tested``: what it found; ``condition``: of DF."""

    def __init__(self, tested: Contraction, condition: float) -> None:
        self.tested, self.condition = tested, condition
        worst = max(range(len(NAMES)), key=lambda i: _rank(tested.ratios[i]))
        super().__init__(
            f"Krawczyk's test fails in {NAMES[worst]}, by a factor {tested.ratios[worst]:.2g}"
        )


def _rank(ratio: float) -> float:
    return ratio if ratio == ratio else float("inf")

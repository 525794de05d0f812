"""What a file that holds omega alone says of gamma, and whether it is a motion of the body at all.

A solution of the equation in omega alone (3.61) need not solve Euler–Poisson.  gamma from omega,
its derivative and the energy (3.60) tells: its length must be 1 and Iw·gamma must stay f.  The
derivative is that of the polynomial through neighbouring samples.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from polhode.equations.forms.without_gamma import gamma_from_omega
from polhode.equations.integrals import Drift, drift
from polhode.judging.correct_digits import digits_of
from polhode.judging.finite_differences import derivative_weights
from polhode.numbers.conversion import to_mpf
from polhode.scenes.body import is_zero
from polhode.scenes.scene import Scene

SAMPLES = 9  # that a derivative is taken from
TELLING = 3.0  # digits of a derivative that tells anything
SOURCE = "Yehia, Rigid Body Dynamics, eq. 3.60"


@dataclass(frozen=True)
class OmegaAlone:
    """gamma by (3.60) at the times that have four samples on either side.

    ``digits``: its correct digits, the fewest.  ``derivative``: the digits that the derivative is
    good for at least, by leaving out the outermost two samples, relative to the torque Mg|r0|.
    ``drift``: the departures of f and |gamma|²; that of h is none by construction.
    """

    digits: float
    derivative: float
    drift: Drift

    @property
    def satisfied(self) -> float:
        """The digits to which omega satisfies the body's equations: by |gamma|² and f."""
        off = max(abs(x) for x in (self.drift.gamma, self.drift.f) if x is not None)
        return -math.log10(off) if off > 0 else math.inf

    @property
    def concludes(self) -> bool:
        """Whether it says anything of omega: derivatives tell, and gamma has about length 1."""
        return self.derivative >= TELLING and self.satisfied >= 0

    def __str__(self) -> str:
        found = (
            f"gamma from omega, its derivative and the energy ({SOURCE}): "
            f"{self.digits:.2f} correct digits, |gamma|^2 off by {self.drift.gamma:.1e} "
            f"and f by {self.drift.f:.1e}; "
        )
        if self.derivative < TELLING:
            return f"{found}the samples are too far apart for derivatives: no conclusion"
        good = f"{found}derivatives of these samples are good for {self.derivative:.2f} digits"
        if self.satisfied >= self.derivative - 1:
            return f"{good} or more, and so far omega satisfies the body's equations"
        return f"{good} or more, omega satisfies the body's equations to {self.satisfied:.1f}"


def omega_alone(
    scene: Scene,
    times: Sequence[Fraction],
    omega: Sequence[Sequence[Any]],
    reference: Sequence[Sequence[Any]],
    bits: int,
) -> OmegaAlone | None:
    """gamma from rows p q r at these times; None where the samples or the scene do not allow it.

    ``reference``: its states at these times.  Times need not be in order, but different.
    """
    from polhode.numbers.mpmath_context import mpmath, own

    allowed = scene.gamma is not None and not is_zero(scene.body.torque)
    if not allowed or len(set(times)) != len(times) or len(times) < SAMPLES:
        return None
    order = sorted(range(len(times)), key=times.__getitem__)
    half, states, off, worst = SAMPLES // 2, [], mpmath.mpf(0), mpmath.mpf(0)
    with mpmath.workprec(bits):
        omega = [own(list(row)) for row in omega]

        def number(x: Any) -> Any:
            return to_mpf(x, bits)

        def slope(samples: Sequence[int]) -> list[Any]:
            weights = derivative_weights([number(times[i]) for i in samples])
            columns = zip(*(omega[i] for i in samples), strict=True)
            return [mpmath.fdot(weights, column) for column in columns]

        h = number(scene.integrals.energy)
        for k in range(half, len(order) - half):
            window, here = order[k - half : k + half + 1], order[k]
            near, rough = (
                gamma_from_omega(scene.body, omega[here], rate, h, number)
                for rate in (slope(window), slope(window[1:-1]))
            )
            states.append([*omega[here], *near])
            off = max(off, *(abs(x - y) for x, y in zip(near, rough, strict=True)))
            true = own(list(reference[here][3:]))
            worst = max(worst, *(abs(x - y) for x, y in zip(near, true, strict=True)))
    cap = bits * 0.3
    return OmegaAlone(digits_of(worst, cap), digits_of(off, cap), drift(scene, states, bits))

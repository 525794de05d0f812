"""The asymptotic motion that one of Bobylev and Steklov's is near to."""

from __future__ import annotations

from collections.abc import Iterator

from polhode.closed_forms._engine.misfit import Misfit
from polhode.closed_forms._engine.normal_form import equal, missing, placed_in, positive
from polhode.closed_forms._engine.principal_scene import PrincipalScene
from polhode.closed_forms.bobylev_steklov.conditions import conditions


def special(scene: PrincipalScene) -> Iterator[tuple[str, Misfit | None]]:
    """By how much the motion misses Ga = gamma1 + C r^2/2 Mg x0 = 1 (with C p^2 < Mg x0)."""
    found = placed_in(conditions, scene)
    if found is None:
        return
    placed = found[1]
    p, _, r = placed.omega
    k = placed.torque[0] / placed.moments[2]
    limit = equal("gamma1 + C r^2/(2 Mg x0) = 1", placed.gamma[0] + r * r / (2 * k), 1)
    yield "asymptotic to a rotation", missing(positive("C p^2 < Mg x0", k - p * p), limit)

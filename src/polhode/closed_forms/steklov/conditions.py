"""Which scenes are Steklov's motions; their coefficients."""

from __future__ import annotations

from collections.abc import Iterator

from polhode.closed_forms._engine.misfit import Misfit
from polhode.closed_forms._engine.normal_form import (
    Condition,
    Placed,
    matching,
    on_axis_1,
    placed_in,
    positive,
    shortfall,
)
from polhode.closed_forms._engine.principal_scene import PrincipalScene
from polhode.numbers.exact import Exact, exact, sign


def coefficients(scene: Placed) -> dict[str, Exact]:
    """Of a body that fits."""
    (A, B, C), c = scene.moments, scene.torque[0]
    e, a1 = sign(B - A), (B - C) / A
    M, N = ((A - B) * (A - C) / (A - 2 * X) for X in (C, B))
    return {
        "b0": -e * c / (M * a1),
        "b2": A * (A - C) / ((A - 2 * B) * (B - C)),
        "c0": e * c / (N * a1),
        "c2": -A * (A - B) / ((A - 2 * C) * (B - C)),
        "e": exact(e),
        "M": M / c,
        "N": N / c,
        "G": (M - N) * A / (2 * (B - C) * c),
    }


def conditions(scene: Placed) -> Iterator[Condition]:
    """Those of the body, then q^2, r^2 and gamma as functions of p."""
    A, B, C = scene.moments
    yield from on_axis_1(scene)
    yield positive("A > 2C", A - 2 * C)
    yield positive("A < 2B", 2 * B - A)
    yield positive("A != B", abs(A - B))
    x, (p, q, r) = coefficients(scene), scene.omega
    gamma = x["e"] + x["G"] * p * p, x["M"] * p * q, x["N"] * p * r
    yield from matching(scene, gamma, (x["b0"] + x["b2"] * p * p, x["c0"] + x["c2"] * p * p))


def fits(scene: PrincipalScene) -> bool:
    """Whether body and start belong to the family."""
    return placed_in(conditions, scene) is not None


def misfit(scene: PrincipalScene) -> Misfit | None:
    """The condition that fails; None where all hold."""
    return shortfall(conditions, scene)

"""The special motions of a torque-free body that another one is near to."""

from __future__ import annotations

from collections.abc import Iterator

from polhode.closed_forms._engine.misfit import Misfit
from polhode.closed_forms._engine.normal_form import equal, missing
from polhode.closed_forms._engine.principal_scene import PrincipalScene
from polhode.closed_forms.euler.regimes import is_permanent
from polhode.numbers.exact import ZERO, sqrt
from polhode.scenes.body import dot

_PAIRS = ((0, 1), (1, 2), (2, 0))


def special(scene: PrincipalScene) -> Iterator[tuple[str, Misfit | None]]:
    """Each special motion and by how much this one, which is not permanent, misses it."""
    I, w = scene.moments, scene.omega
    if is_permanent(I, w):
        return
    low, middle, high = sorted(range(3), key=lambda i: I[i])
    if all(I[i] != I[j] for i, j in _PAIRS):
        sides = (I[i] * abs(I[i] - I[middle]) * w[i] * w[i] for i in (high, low))
        yield "separatrix", missing(equal("G^2 = 2 h B, B the middle moment", *sides))
    for i, j in _PAIRS:
        names = f"{'ABC'[i]} = {'ABC'[j]}"
        yield "symmetric body", missing(equal(names, I[i], I[j]))
    speed = sqrt(dot(w, w))
    for i in range(3):
        across = sqrt(dot(w, w) - w[i] * w[i])
        rotation = equal(f"w along principal axis {i + 1}", across, ZERO, speed)
        yield "permanent rotation", missing(rotation)

"""The special motions on Hess's surface that another one is near to."""

from __future__ import annotations

from collections.abc import Iterator

from polhode.closed_forms._engine.misfit import Misfit
from polhode.closed_forms._engine.normal_form import equal, missing
from polhode.closed_forms._engine.principal_scene import PrincipalScene
from polhode.closed_forms.hess.axes import start
from polhode.numbers.exact import ZERO, sign, sqrt


def special(scene: PrincipalScene) -> Iterator[tuple[str, Misfit | None]]:
    """Each special motion and by how much this one misses it; symbols as in :mod:`.axes`."""
    assert scene.gamma is not None
    s = start(scene.moments, scene.torque, scene.omega, scene.gamma, None)
    (M2, M3), (g2, g3) = s.Z, s.g
    square, level = M2 * M2 + M3 * M3, g2 * g2 + g3 * g3
    if sign(s.f) == 0:
        yield "separatrix", missing(equal("h = |Mg r0|", s.h, s.P))
        return
    size = sqrt(max(square, s.P))
    yield "f = 0", missing(equal("Iw.gamma = 0", s.f, ZERO, size))
    along = equal("gamma1' = 0", g2 * M3 - g3 * M2, ZERO, size)
    even = equal("gamma1'' = 0", s.u * square, -s.P * level, square + s.P)
    yield "steady cone", missing(along, even)

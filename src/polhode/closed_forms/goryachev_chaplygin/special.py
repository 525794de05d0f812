"""The special motions of Goryachev and Chaplygin's case that another one is near to."""

from __future__ import annotations

from collections.abc import Iterator

from polhode.closed_forms._engine.misfit import Misfit
from polhode.closed_forms._engine.normal_form import equal, missing, positive
from polhode.closed_forms._engine.principal_scene import PrincipalScene
from polhode.closed_forms.goryachev_chaplygin.axes import start
from polhode.closed_forms.goryachev_chaplygin.regimes import discriminants
from polhode.numbers.exact import ZERO, sign, sqrt


def special(scene: PrincipalScene) -> Iterator[tuple[str, Misfit | None]]:
    """Each special motion and by how much this one misses it; symbols as in :mod:`.regimes`.

    G and D+ >= 0 by their roots over (H + 2a)^(3/2), which bounds them: so both grow as the
    distance from the special motion.
    """
    assert scene.gamma is not None
    s = start(scene.moments, scene.torque, scene.omega, scene.gamma, None)
    above, below = s.H + 2 * s.a, s.H - 2 * s.a
    if sign(s.G) == 0:
        yield "G = 0, H = 2a", missing(equal("h = |Mg r0|", s.H, 2 * s.a))
        return
    size = sqrt(above * above * above)
    yield "G = 0", missing(equal("G = 0", sqrt(108 * s.G * s.G), ZERO, size))
    plus, _ = discriminants(s)
    yield "v constant, eta = 0", missing(equal("D+ = 0", sqrt(abs(plus)), ZERO, size))
    cube = equal("D- = 0", below * below * below, 108 * s.G * s.G)
    yield "v constant or asymptotic, eta = pi", missing(positive("H > 2a", below), cube)

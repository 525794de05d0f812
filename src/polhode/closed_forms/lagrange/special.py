"""The special motions of a Lagrange top that another one is near to."""

from __future__ import annotations

from collections.abc import Iterator

from polhode.closed_forms._engine.misfit import Misfit
from polhode.closed_forms._engine.normal_form import equal, missing, positive, size_of
from polhode.closed_forms._engine.principal_scene import PrincipalScene
from polhode.closed_forms.lagrange.axes import top_axes
from polhode.closed_forms.lagrange.regimes import constants
from polhode.numbers.exact import ZERO


def special(scene: PrincipalScene) -> Iterator[tuple[str, Misfit | None]]:
    """Each special motion and by how much this one misses it.

    Rates are relative to the size of w (:func:`..attitude.normal_form.size_of`), their squares to
    its square; b = gamma3 + A (p^2 + q^2)/2 Mg z0 in the top's axes.
    """
    if scene.gamma is None:
        return
    axes = top_axes(scene.moments, scene.torque, None)
    c = constants(*axes.moments, axes.torque, axes.top(scene.omega), axes.top(scene.gamma))
    rate = size_of(scene)
    if c.steady:
        if c.level > 0:
            critical = equal("C^2 r^2 = 4 A Mg z0", c.n * c.n, 2 * c.a)
            yield "sleeping, critical spin", missing(critical)
        return
    upper = equal("f = C r", c.above, ZERO, rate)
    yield "through the upper pole", missing(positive("b > 1", c.b - 1), upper)
    yield "through the lower pole", missing(equal("f = -C r", c.below, ZERO, rate))
    between = positive("|f| < C |r|", -c.above * c.below)
    yield "cusped", missing(between, equal("f = C r b", c.looping, ZERO, rate))
    if not c.homoclinic:
        slow = positive("C^2 r^2 < 4 A Mg z0", 2 * c.a - c.n * c.n)
        level = equal("b = 1", c.a * (c.b - 1), ZERO, rate * rate)
        yield "homoclinic to the sleeping top", missing(slow, upper, level)
    still = equal("theta' = 0", c.rate, ZERO, rate)
    even = equal("theta'' = 0", c.slope, ZERO, 2 * rate * rate)
    yield "steady precession", missing(still, even)

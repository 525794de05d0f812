"""First integrals (3.30) along a trajectory, and their drift from the exact scene's values.

h = ½ w·I w + Mg r0·gamma,    f = I w·gamma,    |gamma|² = 1
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from polhode import exact
from polhode.body import Body
from polhode.exact import Exact, sign
from polhode.precision import to_extended, to_mpf
from polhode.scene import Scene

GUARD_BITS = 64


class Drift(NamedTuple):
    """Largest departures of h, f, |gamma|² over all output times.

    They are relative to T(0) + Mg|r0|, |G(0)|, 1.
    A scale that is zero is replaced: |G(0)| by the momentum of the pendulum's rate,
    sqrt(Mg|r0|·largest moment), and any zero scale that is left by 1.  f and gamma are None for a
    scene without gamma, all of them where no state was reached.
    """

    h: float | None
    f: float | None
    gamma: float | None


def drift(scene: Scene, states: Any, bits: int) -> Drift:
    """Drift of a trajectory's integrals, computed in more precision than the states have.

    ``states``: rows p q r [gamma1 gamma2 gamma3] in body axes, an ndarray of doubles or rows of mpf
    with ``bits`` significant bits.
    """
    import numpy as np

    if isinstance(states, np.ndarray) and states.dtype == np.float64:
        columns = list(states.astype(np.longdouble).T)
        return _largest(scene, columns, to_extended)
    import mpmath

    precision = bits + GUARD_BITS
    with mpmath.workprec(precision):
        rows = [_departures(scene, row, lambda x: to_mpf(x, precision)) for row in states]
        worst = [max(abs(row[i]) for row in rows) for i in range(len(rows[0]))]
        return _named([float(x) for x in worst])


def _largest(scene: Scene, columns: list[Any], number: Any) -> Drift:
    import numpy as np

    return _named([float(np.max(np.abs(d))) for d in _departures(scene, columns, number)])


def _named(values: list[float]) -> Drift:
    return Drift(values[0], *values[1:]) if len(values) == 3 else Drift(values[0], None, None)


def _departures(scene: Scene, state: Sequence[Any], number: Any) -> list[Any]:
    """Relative departures of the integrals at one state (or at columns of states)."""
    body, exactly = scene.body, scene.integrals
    inertia = [[number(x) for x in row] for row in body.inertia]
    omega, gamma = state[:3], state[3:]
    momentum = [_dot(row, omega) for row in inertia]
    energy = _dot(momentum, omega) / 2
    energy_scale, area_scale = (number(x) for x in scales(scene))
    if len(gamma) == 0:
        return [(energy - number(exactly.energy)) / energy_scale]
    energy = energy + _dot([number(x) for x in body.torque], gamma)
    assert exactly.area is not None
    return [
        (energy - number(exactly.energy)) / energy_scale,
        (_dot(momentum, gamma) - number(exactly.area)) / area_scale,
        _dot(gamma, gamma) - 1,
    ]


def scales(scene: Scene) -> tuple[Exact, Exact]:
    """The scales of h and f, see Drift."""
    found = scene.integrals
    area = found.area_scale
    if sign(area) == 0:
        area = exact.sqrt(_weight_moment(scene.body) * max(scene.body.moments))
    return tuple(x if sign(x) else exact.ONE for x in (found.energy_scale, area))  # type: ignore[return-value]


def _weight_moment(body: Body) -> Exact:
    x, y, z = body.torque
    return exact.sqrt(x * x + y * y + z * z)


def _dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]

"""Names of bodies by their exact special structure."""

from __future__ import annotations

from polhode.numbers.exact import sign
from polhode.scenes.body import Body


def kind_of_body(body: Body) -> str:
    """The classical name of a body: Euler, Lagrange or Kovalevskaya top, or what it is instead."""
    if body.torque_free:
        return "Euler top"
    moments = body.moments
    x, y, z = (sign(component) == 0 for component in body.axes.components(body.torque))
    if moments[0] == moments[1] == moments[2]:
        return "Lagrange top (three equal moments)"
    for third, (first, second), centred in (
        (2, (0, 1), (x and y, z)),
        (0, (1, 2), (y and z, x)),
        (1, (2, 0), (z and x, y)),
    ):
        if moments[first] != moments[second]:
            continue
        on_axis, across = centred
        if on_axis:
            return "Lagrange top"
        if across and moments[first] == 2 * moments[third]:
            return "Kovalevskaya top"
        if across and moments[first] == 4 * moments[third]:
            return "Goryachev-Chaplygin body"
        return "heavy symmetric body, centre of mass off its axis"
    return "heavy asymmetric body"

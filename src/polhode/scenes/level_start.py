"""States on a level of energy and area, exactly: the start form ``gamma, h, f, sign``.

Of all w with the area f = Iw·gamma at a given gamma, w = f gamma/(gamma·I gamma) has the least
energy, the reduced potential

    W_f(gamma) = f²/(2 gamma·I gamma) + Mg r0·gamma,

and what is added to it is at right angles to I gamma.  With v = I gamma × (gamma × r0)

    w = f gamma/(gamma·I gamma) ± sqrt(2(h − W_f)/(v·Iv)) v

is the one whose rate of Mg r0·gamma vanishes: r0 is at an extremum of its height.  Without a moment
of the weight r0 stands for the body's third principal axis.
"""

from __future__ import annotations

from polhode.common.errors import BadInput
from polhode.numbers import exact
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact, sign
from polhode.numbers.vectors import Vector, cross, dot, is_zero, scaled
from polhode.scenes.body import Body


def reduced_potential(body: Body, gamma: Vector, f: Exact) -> Exact:
    """W_f at gamma, a unit vector in body axes: the least energy that the area f allows there."""
    return f * f / (2 * dot(gamma, body.momentum(gamma))) + dot(body.torque, gamma)


def omega_on_level(
    body: Body, gamma: Vector, h: Exact, f: Exact, positive: bool, name: str
) -> Vector:
    """w in body axes on the level (h, f) at gamma, at an extremum of the centre's height.

    ``positive``: the sign in front of the root.  Raises BadInput, as of the scene ``name``, where h
    is below W_f(gamma), and where gamma is along r0: there a circle of w fits.
    """
    least = reduced_potential(body, gamma, f)
    spare = h - least
    if sign(spare) < 0:
        expected = f"at least {shown(least)}, the least energy at this gamma and f"
        raise BadInput(name, "start.h", shown(h), expected)
    along = body.axes.directions[2] if body.torque_free else body.centre
    inertial = body.momentum(gamma)
    v = cross(inertial, cross(gamma, along))
    if is_zero(v):
        where = "the third principal axis" if body.torque_free else "the centre of mass"
        expected = f"a gamma that is not along {where}: there h and f leave a circle of omega"
        shown_gamma = ", ".join(shown(x) for x in gamma)
        raise BadInput(name, "start.gamma", f"[{shown_gamma}]", expected)
    least_w = scaled(f / dot(gamma, inertial), gamma)
    size = exact.sqrt(2 * spare / dot(v, body.momentum(v)))
    p, q, r = (a + b for a, b in zip(least_w, scaled(size if positive else -size, v), strict=True))
    return p, q, r

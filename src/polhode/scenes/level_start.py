"""States on a level of energy and area, exactly: the start form ``gamma, h, f, sign``.

Of all w with the area f = Iw·gamma at a given gamma, w = f gamma/(gamma·I gamma) has the least
energy, the reduced potential

    W_f(gamma) = f²/(2 gamma·I gamma) + Mg r0·gamma,

and what is added to it is at right angles to I gamma.  With v = I gamma × (gamma × r0)

    w = f gamma/(gamma·I gamma) ± sqrt(2(h − W_f)/(v·Iv)) v

is the one whose rate of Mg r0·gamma vanishes: r0 is at an extremum of its height.  Without a moment
of the weight r0 stands for the body's third principal axis.

With p_phi = G3 as well, the momentum conjugate to phi as f = G·gamma is that to psi, omega has one
number left: with N = (gamma2, -gamma1, 0), along the line of nodes and of length sin(theta),

    G = (f - p_phi gamma3)/sin²(theta) (gamma1, gamma2, 0) + p_phi (0, 0, 1) + x N,

and, G0 being G at x = 0, the energy is a quadratic in x whose two roots have the same theta' =
omega·N/sin(theta) but for its sign.  Of a top, A = B and r0 = z e3, all three are constant, and
theta' = 0 at the roots u = cos(theta) of the cubic

    (1 - u²) 2A(h - p_phi²/(2C) - Mg z u) - (f - p_phi u)²

(Goldstein, *Classical Mechanics*, section 5.7; his phi is psi here, his psi phi).
"""

from __future__ import annotations

from polhode.common.errors import BadInput
from polhode.numbers import exact
from polhode.numbers.decimals import shown
from polhode.numbers.exact import ZERO, Exact, sign
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


def omega_of_momenta(
    body: Body, gamma: Vector, h: Exact, f: Exact, p_phi: Exact, positive: bool, name: str
) -> Vector:
    """w in body axes at gamma with the energy h, the area f and the momentum p_phi about e3.

    ``positive``: whether theta grows.  Raises BadInput, as of the scene ``name``, where h is too
    small for it, and at a pole, where a circle of w fits, or none.
    """
    x, y, z = gamma
    square = x * x + y * y
    if sign(square) == 0:
        expected = "theta other than 0 or pi: there h, f and p_phi leave a circle of omega, or none"
        raise BadInput(name, "start.gamma", f"[0, 0, {shown(z)}]", expected)
    across = (f - p_phi * z) / square
    base: Vector = (across * x, across * y, p_phi)
    nodes: Vector = (y, -x, ZERO)
    moved, turned = body.omega(base), body.omega(nodes)
    size, mixed = dot(nodes, turned), dot(nodes, moved)
    spare = h - dot(body.torque, gamma) - dot(base, moved) / 2 + mixed * mixed / (2 * size)
    if sign(spare) < 0:
        expected = f"at least {shown(h - spare)}, the least energy at this theta, f and p_phi"
        raise BadInput(name, "start.h", shown(h), expected)
    root = exact.sqrt(2 * size * spare)
    along = ((root if positive else -root) - mixed) / size
    p, q, r = (a + along * b for a, b in zip(moved, turned, strict=True))
    return p, q, r


def turning_point(
    body: Body, h: Exact, f: Exact, p_phi: Exact, upper: bool, name: str
) -> tuple[Vector, Vector]:
    """w and gamma of a top, with phi = 0, where its nutation turns: at the smaller theta, or not.

    Raises BadInput, as of the scene ``name``, of another body, where no theta has so little energy,
    and where theta is 0 or pi.
    """
    a, b, c = body.moments
    if not body.axes.trivial or a != b or any(sign(x) for x in body.torque[:2]):
        expected = "an orientation, since only a top, A = B with its centre on e3, nutates by these"
        raise BadInput(name, "start.gamma", None, expected)
    spare, slope = 2 * a * h - a / c * p_phi * p_phi, 2 * a * body.torque[2]
    roots = _roots(slope, -(spare + p_phi * p_phi), 2 * f * p_phi - slope, spare - f * f)
    pair = roots[1:] if sign(slope) > 0 else roots[:2]  # the other is beyond 1, or beyond -1
    if not pair or pair[0] > 1 or pair[1] < -1:
        expected = "as much energy as f and p_phi need at some theta"
        raise BadInput(name, "start.h", shown(h), expected)
    u = pair[0 if upper else 1]
    square = 1 - u * u
    if sign(square) == 0:
        expected = "an orientation, since this end of the nutation is theta = 0 or pi"
        raise BadInput(name, "start.gamma", None, expected)
    sine = exact.sqrt(square)
    return (ZERO, (f - p_phi * u) / (a * sine), p_phi / c), (ZERO, sine, u)


def _roots(a: Exact, b: Exact, c: Exact, d: Exact) -> list[Exact]:
    """The real roots of a u³ + b u² + c u + d, the largest first; none where only one is real.

    Where a is 0, those of the quadratic.  With u = t - b/(3a) the cubic is t³ + p t + q, and t is
    2 sqrt(-p/3) cos(angle - 2 pi k/3), with cos(3 angle) = (-q/2)/sqrt(-p/3)³.
    """
    if sign(a) == 0:
        if sign(b) == 0 or sign(root := c * c - 4 * b * d) < 0:
            return []
        ends = [(-c + side * exact.sqrt(root)) / (2 * b) for side in (1, -1)]
        return ends if sign(b) > 0 else ends[::-1]
    shift, c, d = b / (3 * a), c / a, d / a
    p, q = c - 3 * shift * shift, 2 * shift * shift * shift - shift * c + d
    left = -p * p * p / 27 - q * q / 4
    if sign(left) < 0:
        return []
    angle = exact.arctan2(exact.sqrt(left), -q / 2) / 3 if sign(p) else ZERO
    radius, third = 2 * exact.sqrt(-p / 3), 2 * exact.pi() / 3
    return [radius * exact.cos(angle - k * third) - shift for k in range(3)]

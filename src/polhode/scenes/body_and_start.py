"""A scene's body and start from its tables: every way in which a scene may give them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import chain
from operator import mul
from typing import Any, NamedTuple

from polhode.common.errors import BadInput
from polhode.numbers import exact
from polhode.numbers.decimals import brief, shown
from polhode.numbers.exact import ONE, ZERO, Exact, sign
from polhode.numbers.expression import in_units
from polhode.numbers.vectors import Vector, cross, dot, quaternion_products, rotation, scaled
from polhode.scenes.body import GRACE, MATRIX, Body, UnphysicalBody, diagonal, is_rounded_unit
from polhode.scenes.scene import SceneTables, is_text
from polhode.scenes.shapes import Part
from polhode.scenes.vocabulary import CENTRE, FIXED_POINT, SIGNS

# --- level start ----------------------------------------------------------------------------------
#
# States on a level of energy and area, exactly: the start form ``gamma, h, f, sign``.
#
# Of all w with the area f = Iw·gamma at a given gamma, w = f gamma/(gamma·I gamma) has the least
# energy, the reduced potential
#
#     W_f(gamma) = f²/(2 gamma·I gamma) + Mg r0·gamma,
#
# and what is added to it is at right angles to I gamma.  With v = I gamma × (gamma × r0)
#
#     w = f gamma/(gamma·I gamma) ± sqrt(2(h − W_f)/(v·Iv)) v
#
# is the one whose rate of Mg r0·gamma vanishes: r0 is at an extremum of its height.  Without a
# moment of the weight r0 stands for the body's third principal axis.
#
# With p_phi = G3 as well, the momentum conjugate to phi as f = G·gamma is that to psi, omega has
# one number left: with N = (gamma2, -gamma1, 0), along the line of nodes and of length sin(theta),
#
#     G = (f - p_phi gamma3)/sin²(theta) (gamma1, gamma2, 0) + p_phi (0, 0, 1) + x N,
#
# and, G0 being G at x = 0, the energy is a quadratic in x whose two roots have the same theta' =
# omega·N/sin(theta) but for its sign.  Of a top, A = B and r0 = z e3, all three are constant, and
# theta' = 0 at the roots u = cos(theta) of the cubic
#
#     (1 - u²) 2A(h - p_phi²/(2C) - Mg z u) - (f - p_phi u)²
#
# (Goldstein, *Classical Mechanics*, section 5.7; his phi is psi here, his psi phi).


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
    if not any(map(sign, v)):
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
    at_base, along_nodes = body.omega(base), body.omega(nodes)
    size, mixed = dot(nodes, along_nodes), dot(nodes, at_base)
    spare = h - dot(body.torque, gamma) - dot(base, at_base) / 2 + mixed * mixed / (2 * size)
    if sign(spare) < 0:
        expected = f"at least {shown(h - spare)}, the least energy at this theta, f and p_phi"
        raise BadInput(name, "start.h", shown(h), expected)
    root = exact.sqrt(2 * size * spare)
    along = ((root if positive else -root) - mixed) / size
    p, q, r = (a + along * b for a, b in zip(at_base, along_nodes, strict=True))
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


# --- body and start -------------------------------------------------------------------------------


THETA = "start.angles[2]"
_NOWHERE: Vector = (ZERO, ZERO, ZERO)
#: The keys of an orientation, and what may not stand beside each.
_BESIDE = {
    "gamma": (),
    "angles": ("psi", "normalise"),
    "quaternion": ("psi",),
    "mrp": ("psi", "normalise"),
    "matrix": ("psi",),
}
_SKEWED = Fraction(1, 1000)  # of an element of a matrix that is still meant as a rotation
_WAYS_TO_MOVE = ("omega", "momentum", "rates", "h")


class Orientation(NamedTuple):
    """An orientation: gamma, and psi as it is counted at t = 0; phi where angles gave it."""

    gamma: Vector
    psi: Exact
    phi: tuple[Exact, Exact] | None = None  # its sine and cosine


def body_of(reading: SceneTables, table: Mapping[str, Any]) -> Body:
    """The body of a table [body]; raises BadInput."""
    if "parts" in table:
        return _of_parts(reading, table)
    key, second = ("moments", "inertia") if "moments" in table else ("inertia", "moments")
    if key not in table:
        expected = "moments = [A, B, C], inertia = a 3 x 3 matrix, or [[body.parts]]"
        raise reading.bad("body.moments", None, expected)
    reading.alone("body", table, [second], "only one of moments and inertia")
    if key == "moments":
        rows = [table["moments"]]
        inertia = diagonal(reading.read("body", table, "moments"))
    else:
        rows = table["inertia"]
        if not isinstance(rows, list) or len(rows) != 3:
            raise reading.bad("body.inertia", rows, MATRIX)
        if not any(isinstance(row, list) for row in rows):
            raise reading.bad("body.inertia", rows, "moments = [A, B, C], or " + MATRIX)
        a, b, c = (reading.vector(f"body.inertia[{i + 1}]", row) for i, row in enumerate(rows))
        inertia = (a, b, c)
    centre = reading.read("body", table, "centre") if "centre" in table else _NOWHERE
    mass = reading.read("body", table, "mass") if "mass" in table else None
    if mass is not None and sign(mass) <= 0:
        raise reading.bad("body.mass", table["mass"], "a mass above 0")
    if "g" in table:
        if mass is None:
            raise reading.bad("body.mass", None, "a number, with g")
        reading.alone("body", table, ["weight"], "only one of weight and g")
        weight = mass * reading.read("body", table, "g")
    elif mass is not None and "weight" not in table:
        raise reading.bad("body.g", None, "g or weight together with mass; 0 for none")
    else:
        weight = reading.read("body", table, "weight")
    if "centre" not in table and sign(weight) != 0:
        raise reading.bad("body.centre", None, "three numbers, since weight is not 0")
    about = reading.read("body", table, "about")
    if about not in (FIXED_POINT, CENTRE):
        raise reading.bad("body.about", about, f"{FIXED_POINT!r} or {CENTRE!r}")
    if about == CENTRE and (mass is None or "centre" not in table):
        missing = "mass" if mass is None else "centre"
        raise reading.bad(f"body.{missing}", None, "a value, with about = 'centre'")
    rounded = not any(map(is_text, chain(*rows)))
    try:
        if about == CENTRE and mass is not None:
            return Body.about_centre(inertia, centre, mass, weight, rounded)
        return Body(inertia, centre, weight, rounded=rounded)
    except UnphysicalBody as fault:
        raise reading.bad(f"body.{key}", table[key], fault.expected) from None


def _of_parts(reading: SceneTables, table: Mapping[str, Any]) -> Body:
    others = ("moments", "inertia", "about", "centre", "mass")
    reading.alone("body", table, others, "no value together with parts")
    tables = table["parts"]
    if not isinstance(tables, list) or not tables or not all(isinstance(p, dict) for p in tables):
        raise reading.bad("body.parts", tables, "tables [[body.parts]]")
    parts = tuple(_part(reading, k, part) for k, part in enumerate(tables))
    if ("g" in table) == ("weight" in table):
        raise reading.bad("body.g", table.get("g"), "one of g and weight; 0 for none")
    gravity = "weight" if "weight" in table else "g"
    try:
        return Body.of_parts(parts, **{gravity: reading.read("body", table, gravity)})
    except UnphysicalBody as fault:
        raise reading.bad("body.parts", None, f"parts of {fault.expected}") from None


def _part(reading: SceneTables, index: int, table: dict[str, Any]) -> Part:
    key = f"body.parts[{index + 1}]"
    reading.refuse_unknown("body.parts", table, key)
    for needed in ("shape", "mass"):
        if needed not in table:
            raise reading.bad(f"{key}.{needed}", None, "a value for each part")
    try:
        return Part(**{name: reading.read("body.parts", table, name, key) for name in table})
    except BadInput as fault:
        shown = table.get(fault.key, fault.value)
        raise reading.bad(f"{key}.{fault.key}", shown, fault.expected) from None


def start_of(
    reading: SceneTables, table: Mapping[str, Any], body: Body
) -> tuple[Vector, Vector | None, Exact]:
    """Omega, gamma and psi of a table [start]; raises BadInput."""
    turns = [key for key in _BESIDE if key in table]
    if turns:
        others = [*turns[1:], *_BESIDE[turns[0]]]
        reading.alone("start", table, others, f"no value together with {turns[0]}")
    motions = [key for key in _WAYS_TO_MOVE if key in table]
    for whole in ("rates", "h"):
        if whole in motions:
            others = [key for key in motions if key != whole]
            reading.alone("start", table, others, f"no value together with {whole}")
    for idle in ("f", "sign", "p_phi"):
        if idle in table and "h" not in table:
            raise reading.bad("start.h", None, "a number, for a start on the level h, f")
    if len(motions) != 1:
        expected = "one of omega, momentum, h with f, or angles with rates"
        raise reading.bad("start.omega", table.get("omega"), expected)
    if "rates" in table and "angles" not in table:
        raise reading.bad("start.angles", None, "three numbers (psi, theta, phi)")
    if "p_phi" in table and not turns:
        reading.alone("start", table, ["normalise"], "no value without an orientation")
        h, f, p_phi, upper = _momenta(reading, table)
        assert p_phi is not None
        omega, gamma = turning_point(body, h, f, p_phi, upper, reading.name)
        return omega, gamma, reading.read("start", table, "psi")
    turn = _turn(reading, table, body)
    if "omega" in table:
        omega = reading.read("start", table, "omega")
    elif "h" in table:
        if turn is None:
            expected = "a unit vector, for a start on the level h, f"
            raise reading.bad("start.gamma", None, expected)
        h, f, p_phi, positive = _momenta(reading, table)
        name = reading.name
        if p_phi is None:
            omega = omega_on_level(body, turn.gamma, h, f, positive, name)
        else:
            omega = omega_of_momenta(body, turn.gamma, h, f, p_phi, positive, name)
    elif "momentum" in table:
        omega = body.omega(reading.read("start", table, "momentum"))
    else:
        assert turn is not None
        omega = _of_rates(turn, reading.read("start", table, "rates"))
    return (omega, None, ZERO) if turn is None else (omega, turn.gamma, turn.psi)


def _momenta(
    reading: SceneTables, table: Mapping[str, Any]
) -> tuple[Exact, Exact, Exact | None, bool]:
    """The energy, the momenta about the vertical and about the third axis, and the sign."""
    if "f" not in table:
        raise reading.bad("start.f", None, "a number, for a start on the level h, f")
    h, f = (reading.read("start", table, key) for key in ("h", "f"))
    p_phi = reading.read("start", table, "p_phi") if "p_phi" in table else None
    side = reading.read("start", table, "sign")
    if side not in SIGNS:
        raise reading.bad("start.sign", side, " or ".join(SIGNS))
    return h, f, p_phi, side == SIGNS[0]


def _turn(reading: SceneTables, table: Mapping[str, Any], body: Body) -> Orientation | None:
    """The orientation, None of a torque-free body of which none is given."""
    normalise = reading.read("start", table, "normalise")
    if "angles" in table:
        return _of_angles(reading, table)
    if "quaternion" in table:
        numbers = reading.array("start.quaternion", table["quaternion"], 4)
        q = [reading.number("start.quaternion", x) for x in numbers]
        _square(reading, "quaternion", numbers, q, normalise)
        return _turn_of(*q)
    if "mrp" in table:
        sigma = reading.read("start", table, "mrp")
        return _turn_of(1 - dot(sigma, sigma), *(2 * x for x in sigma))
    if "matrix" in table:
        return _of_matrix(reading, table["matrix"], normalise)
    if "gamma" not in table:
        if not body.torque_free:
            raise reading.bad("start.gamma", None, "a unit vector, since the weight has a moment")
        reading.alone("start", table, ("psi", "normalise"), "no value without start.gamma")
        return None
    psi = reading.read("start", table, "psi")
    gamma = reading.read("start", table, "gamma")
    square = _square(reading, "gamma", table["gamma"], gamma, normalise)
    return Orientation(gamma if square == 1 else scaled(1 / exact.sqrt(square), gamma), psi)


def _square(
    reading: SceneTables, key: str, values: list[object], numbers: Sequence[Exact], normalise: bool
) -> Exact:
    """The squared length of a unit vector, 1 or anything above 0 that may be normalised."""
    square = sum(map(mul, numbers, numbers), ZERO)
    if square != 1 and not normalise:
        over = square - 1
        amount = f"1 {'-' if sign(over) < 0 else '+'} {brief(abs(over), 2)}"
        if not is_rounded_unit(values):
            expected = f"length exactly 1, or normalise = true: its square is {amount}"
            raise reading.bad(f"start.{key}", values, expected)
        reading.change = f"start.{key} brought to length 1 (its square was {amount}: rounding)"
    if sign(square) == 0:
        raise reading.bad(f"start.{key}", values, "a vector that is not zero")
    return square


def _of_angles(reading: SceneTables, table: Mapping[str, Any]) -> Orientation:
    """R = Rz(psi) Rx(theta) Rz(phi)."""
    psi, theta, phi = reading.read("start", table, "angles")
    nutation = table["angles"][1]
    if abs(theta) > 2 * exact.pi() and not (is_text(nutation) and in_units(nutation)):
        reading.doubt = doubtful_theta(theta)
    try:
        sine, cosine = exact.sin(theta), exact.cos(theta)
        s, c = exact.sin(phi), exact.cos(phi)
    except ValueError as fault:
        raise reading.bad("start.angles", table["angles"], f"smaller angles ({fault})") from None
    if sign(sine) == 0:  # a pole: only psi ± phi has a meaning, and phi is counted as 0
        psi, phi = psi + phi * (1 if sign(cosine) > 0 else -1), ZERO
        s, c = ZERO, ONE
    elif sign(sine) < 0:  # psi is counted where theta is from 0 to pi
        psi = psi + exact.pi()
    return Orientation((sine * s, sine * c, cosine), psi, (s, c))


def doubtful_theta(theta: Exact) -> str:
    """What is said of a theta of more than a turn, without a unit."""
    reading = f"start.angles: theta = {brief(theta)} is taken in radians, and is more than a turn"
    return f'{reading}; for degrees write "{brief(theta)} deg"'


def _of_rates(turn: Orientation, rates: Vector) -> Vector:
    """Omega by (3.32)."""
    assert turn.phi is not None
    psi_rate, theta_rate, phi_rate = rates
    s, c = turn.phi
    return (
        psi_rate * turn.gamma[0] + theta_rate * c,
        psi_rate * turn.gamma[1] - theta_rate * s,
        psi_rate * turn.gamma[2] + phi_rate,
    )


def _of_matrix(reading: SceneTables, value: object, normalise: bool) -> Orientation:
    """By the quaternion, whose largest component times itself the matrix tells without a root."""
    rows: list[Any] = value if isinstance(value, list) and len(value) == 3 else [None] * 3
    r = [x for i, row in enumerate(rows) for x in reading.vector(f"start.matrix[{i + 1}]", row)]
    products = quaternion_products(r)
    q = products[max(range(4), key=lambda k: products[k][k])]
    off = max(abs(x - y) for x, y in zip(r, rotation(q), strict=True))
    if sign(off) and not normalise:
        if any(map(is_text, chain(*rows))) or off > GRACE:
            expected = f"a rotation, or normalise = true: it is off by {brief(off, 2)}"
            raise reading.bad("start.matrix", None, expected)
        reading.change = f"start.matrix made a rotation (it was off by {brief(off, 2)}: rounding)"
    if off > _SKEWED:
        raise reading.bad("start.matrix", None, f"a rotation: it is off by {brief(off, 2)}")
    return _turn_of(*q)


def _turn_of(a: Exact, b: Exact, c: Exact, d: Exact) -> Orientation:
    """Gamma is the third row of R, and psi the direction of its third column.

    R is quadratic in the quaternion: it is divided by the squared length, no root is drawn.
    """
    square = a * a + b * b + c * c + d * d
    third = (a * a - b * b - c * c + d * d) / square
    gamma = (2 * (b * d - a * c) / square, 2 * (c * d + a * b) / square, third)
    x, y = 2 * (b * d + a * c), 2 * (a * b - c * d)  # R13 and -R23: sin theta (sin psi, cos psi)
    if sign(x) == 0 == sign(y):  # a pole: phi is counted as 0, and psi is the turn itself
        x, y = 2 * (b * c + a * d), a * a + b * b - c * c - d * d
    return Orientation(gamma, exact.arctan2(x, y))

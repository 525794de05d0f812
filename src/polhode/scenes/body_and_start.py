"""A scene's body and start from its tables: every way in which a scene may give them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

from polhode.common.errors import BadInput
from polhode.numbers import exact
from polhode.numbers.decimals import brief
from polhode.numbers.exact import ONE, ZERO, Exact, sign
from polhode.numbers.rounding import GRACE, is_unit_but_for_rounding
from polhode.numbers.vectors import Vector, dot, quaternion_products, rotation, scaled
from polhode.scenes.body import MATRIX, Body, UnphysicalBody, diagonal
from polhode.scenes.given_numbers import in_units
from polhode.scenes.level_start import omega_of_momenta, omega_on_level, turning_point
from polhode.scenes.shapes import Part
from polhode.scenes.validation import Reading, as_written, is_expression
from polhode.scenes.vocabulary import CENTRE, FIXED_POINT, SIGNS

THETA = "start.angles[2]"
_NOWHERE: Vector = (ZERO, ZERO, ZERO)
_WAYS_TO_TURN = ("gamma", "angles", "quaternion", "mrp", "matrix")
_SKEWED = Fraction(1, 1000)  # of an element of a matrix that is still meant as a rotation
_WAYS_TO_MOVE = ("omega", "momentum", "rates", "h")


class Turn(NamedTuple):
    """An orientation: gamma, and psi as it is counted at t = 0; phi where angles gave it."""

    gamma: Vector
    psi: Exact
    phi: tuple[Exact, Exact] | None = None  # its sine and cosine


def body_of(reading: Reading, table: Mapping[str, Any]) -> Body:
    """The body of a table [body]; raises BadInput."""
    if "parts" in table:
        return _of_parts(reading, table)
    key, other = ("moments", "inertia") if "moments" in table else ("inertia", "moments")
    if key not in table:
        expected = "moments = [A, B, C], inertia = a 3 x 3 matrix, or [[body.parts]]"
        raise reading.bad("body.moments", None, expected)
    reading.alone("body", table, [other], "only one of moments and inertia")
    if key == "moments":
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
    mass = _mass(reading, table)
    weight = _weight(reading, table, mass)
    if "centre" not in table and sign(weight) != 0:
        raise reading.bad("body.centre", None, "three numbers, since weight is not 0")
    about = reading.read("body", table, "about")
    if about not in (FIXED_POINT, CENTRE):
        raise reading.bad("body.about", about, f"{FIXED_POINT!r} or {CENTRE!r}")
    if about == CENTRE and (mass is None or "centre" not in table):
        missing = "mass" if mass is None else "centre"
        raise reading.bad(f"body.{missing}", None, "a value, with about = 'centre'")
    value = table[key]
    rounded = not any(
        is_expression(x) for row in (value if key == "inertia" else [value]) for x in row
    )
    try:
        if about == CENTRE and mass is not None:
            return Body.about_centre(inertia, centre, mass, weight, rounded)
        return Body(inertia, centre, weight, rounded=rounded)
    except UnphysicalBody as fault:
        raise reading.bad(f"body.{key}", value, fault.expected) from None


def _of_parts(reading: Reading, table: Mapping[str, Any]) -> Body:
    others = ("moments", "inertia", "about", "centre", "mass")
    reading.alone("body", table, others, "no value together with parts")
    given = table["parts"]
    if not isinstance(given, list) or not given or not all(isinstance(p, dict) for p in given):
        raise reading.bad("body.parts", given, "tables [[body.parts]]")
    parts = tuple(_part(reading, k, part) for k, part in enumerate(given))
    if ("g" in table) == ("weight" in table):
        raise reading.bad("body.g", table.get("g"), "one of g and weight; 0 for none")
    gravity = "weight" if "weight" in table else "g"
    try:
        return Body.of_parts(parts, **{gravity: reading.read("body", table, gravity)})
    except UnphysicalBody as fault:
        raise reading.bad("body.parts", None, f"parts of {fault.expected}") from None


def _part(reading: Reading, index: int, table: dict[str, Any]) -> Part:
    key = f"body.parts[{index + 1}]"
    reading.known("body.parts", table, key)
    for needed in ("shape", "mass"):
        if needed not in table:
            raise reading.bad(f"{key}.{needed}", None, "a value for each part")
    try:
        return Part(**{name: reading.read("body.parts", table, name, key) for name in table})
    except BadInput as fault:
        shown = table.get(fault.key, fault.value)
        raise reading.bad(f"{key}.{fault.key}", shown, fault.expected) from None


def _mass(reading: Reading, table: Mapping[str, Any]) -> Exact | None:
    if "mass" not in table:
        return None
    mass: Exact = reading.read("body", table, "mass")
    if sign(mass) <= 0:
        raise reading.bad("body.mass", table["mass"], "a mass above 0")
    return mass


def _weight(reading: Reading, table: Mapping[str, Any], mass: Exact | None) -> Exact:
    if "g" in table:
        if mass is None:
            raise reading.bad("body.mass", None, "a number, with g")
        reading.alone("body", table, ["weight"], "only one of weight and g")
        return mass * reading.number("body.g", table["g"])
    if mass is not None and "weight" not in table:
        raise reading.bad("body.g", None, "g or weight together with mass; 0 for none")
    weight: Exact = reading.read("body", table, "weight")
    return weight


def start_of(
    reading: Reading, table: Mapping[str, Any], body: Body
) -> tuple[Vector, Vector | None, Exact]:
    """Omega, gamma and psi of a table [start]; raises BadInput."""
    turned = [way for way in _WAYS_TO_TURN if way in table]
    if turned:
        reading.alone("start", table, turned[1:], f"no value together with {turned[0]}")
    moved = [way for way in _WAYS_TO_MOVE if way in table]
    for whole in ("rates", "h"):
        if whole in moved:
            others = [way for way in moved if way != whole]
            reading.alone("start", table, others, f"no value together with {whole}")
    for idle in ("f", "sign", "p_phi"):
        if idle in table and "h" not in table:
            raise reading.bad("start.h", None, "a number, for a start on the level h, f")
    if len(moved) != 1:
        expected = "one of omega, momentum, h with f, or angles with rates"
        raise reading.bad("start.omega", table.get("omega"), expected)
    if "rates" in table and "angles" not in table:
        raise reading.bad("start.angles", None, "three numbers (psi, theta, phi)")
    if "p_phi" in table and not turned:
        reading.alone("start", table, ["normalise"], "no value without an orientation")
        h, f, p_phi, upper = _momenta(reading, table)
        assert p_phi is not None
        omega, gamma = turning_point(body, h, f, p_phi, upper, reading.name)
        return omega, gamma, reading.read("start", table, "psi")
    turn = _turn(reading, table, body)
    if "omega" in table:
        omega = reading.read("start", table, "omega")
    elif "h" in table:
        omega = _on_level(reading, table, body, turn)
    elif "momentum" in table:
        omega = body.omega(reading.read("start", table, "momentum"))
    else:
        assert turn is not None
        omega = _of_rates(turn, reading.read("start", table, "rates"))
    return (omega, None, ZERO) if turn is None else (omega, turn.gamma, turn.psi)


def _on_level(reading: Reading, table: Mapping[str, Any], body: Body, turn: Turn | None) -> Vector:
    if turn is None:
        expected = "a unit vector, for a start on the level h, f"
        raise reading.bad("start.gamma", None, expected)
    h, f, p_phi, positive = _momenta(reading, table)
    if p_phi is not None:
        return omega_of_momenta(body, turn.gamma, h, f, p_phi, positive, reading.name)
    return omega_on_level(body, turn.gamma, h, f, positive, reading.name)


def _momenta(reading: Reading, table: Mapping[str, Any]) -> tuple[Exact, Exact, Exact | None, bool]:
    """The energy, the momenta about the vertical and about the third axis, and the sign."""
    if "f" not in table:
        raise reading.bad("start.f", None, "a number, for a start on the level h, f")
    h, f = (reading.read("start", table, key) for key in ("h", "f"))
    p_phi = reading.read("start", table, "p_phi") if "p_phi" in table else None
    side = reading.read("start", table, "sign")
    if side not in SIGNS:
        raise reading.bad("start.sign", side, " or ".join(SIGNS))
    return h, f, p_phi, side == SIGNS[0]


def _turn(reading: Reading, table: Mapping[str, Any], body: Body) -> Turn | None:
    """The orientation, None of a torque-free body of which none is given."""
    normalise = reading.read("start", table, "normalise")
    if "angles" in table:
        reading.alone("start", table, ("psi", "normalise"), "no value together with angles")
        return _of_angles(reading, table)
    if "quaternion" in table:
        reading.alone("start", table, ["psi"], "no value together with quaternion")
        return _of_quaternion(reading, table["quaternion"], normalise)
    if "mrp" in table:
        reading.alone("start", table, ("psi", "normalise"), "no value together with mrp")
        sigma = reading.read("start", table, "mrp")
        return _turned(1 - dot(sigma, sigma), *(2 * x for x in sigma))
    if "matrix" in table:
        reading.alone("start", table, ["psi"], "no value together with matrix")
        return _of_matrix(reading, table["matrix"], normalise)
    if "gamma" not in table:
        if not body.torque_free:
            raise reading.bad("start.gamma", None, "a unit vector, since the weight has a moment")
        reading.alone("start", table, ("psi", "normalise"), "no value without start.gamma")
        return None
    psi = reading.read("start", table, "psi")
    gamma = reading.read("start", table, "gamma")
    square = _square(reading, "gamma", table["gamma"], gamma, normalise)
    return Turn(gamma if square == 1 else scaled(1 / exact.sqrt(square), gamma), psi)


def _square(
    reading: Reading, key: str, given: list[object], numbers: Sequence[Exact], normalise: bool
) -> Exact:
    """The squared length of a unit vector, 1 or anything above 0 that may be normalised."""
    shown = as_written(given)
    square = sum((x * x for x in numbers), ZERO)
    if square != 1 and not normalise:
        amount = f"1 {_signed(square - 1)}"
        if not is_unit_but_for_rounding(given):
            expected = f"length exactly 1, or normalise = true: its square is {amount}"
            raise reading.bad(f"start.{key}", shown, expected)
        reading.change = f"start.{key} brought to length 1 (its square was {amount}: rounding)"
    if sign(square) == 0:
        raise reading.bad(f"start.{key}", shown, "a vector that is not zero")
    return square


def _signed(x: Exact) -> str:
    return f"{'-' if sign(x) < 0 else '+'} {brief(abs(x), 2)}"


def _of_angles(reading: Reading, table: Mapping[str, Any]) -> Turn:
    """R = Rz(psi) Rx(theta) Rz(phi)."""
    psi, theta, phi = reading.read("start", table, "angles")
    given = table["angles"][1]
    if abs(theta) > 2 * exact.pi() and not (is_expression(given) and in_units(given)):
        reading.doubt = doubtful_theta(theta)
    try:
        sine, cosine = exact.sin(theta), exact.cos(theta)
        s, c = exact.sin(phi), exact.cos(phi)
    except ValueError as fault:
        shown = as_written(table["angles"])
        raise reading.bad("start.angles", shown, f"smaller angles ({fault})") from None
    if sign(sine) == 0:  # a pole: only psi ± phi has a meaning, and phi is counted as 0
        psi, phi = psi + phi * (1 if sign(cosine) > 0 else -1), ZERO
        s, c = ZERO, ONE
    return Turn((sine * s, sine * c, cosine), psi, (s, c))


def doubtful_theta(theta: Exact) -> str:
    """What is said of a theta of more than a turn, without a unit."""
    taken = f"start.angles: theta = {brief(theta)} is taken in radians, and is more than a turn"
    return f'{taken}; for degrees write "{brief(theta)} deg"'


def _of_rates(turn: Turn, rates: Vector) -> Vector:
    """Omega by (3.32)."""
    assert turn.phi is not None
    psi_rate, theta_rate, phi_rate = rates
    s, c = turn.phi
    return (
        psi_rate * turn.gamma[0] + theta_rate * c,
        psi_rate * turn.gamma[1] - theta_rate * s,
        psi_rate * turn.gamma[2] + phi_rate,
    )


def _of_quaternion(reading: Reading, given: object, normalise: bool) -> Turn:
    numbers = reading.array("start.quaternion", given, 4)
    q = [reading.number("start.quaternion", x) for x in numbers]
    _square(reading, "quaternion", numbers, q, normalise)
    return _turned(*q)


def _of_matrix(reading: Reading, given: object, normalise: bool) -> Turn:
    """By the quaternion, whose largest component times itself the matrix tells without a root."""
    rows: list[Any] = given if isinstance(given, list) and len(given) == 3 else [None] * 3
    r = [x for i, row in enumerate(rows) for x in reading.vector(f"start.matrix[{i + 1}]", row)]
    products = quaternion_products(r)
    q = products[max(range(4), key=lambda k: products[k][k])]
    off = max(abs(x - y) for x, y in zip(r, rotation(q), strict=True))
    if sign(off) and not normalise:
        rounded = not any(is_expression(x) for row in rows for x in row)
        if not rounded or off > GRACE:
            expected = f"a rotation, or normalise = true: it is off by {brief(off, 2)}"
            raise reading.bad("start.matrix", None, expected)
        reading.change = f"start.matrix made a rotation (it was off by {brief(off, 2)}: rounding)"
    if off > _SKEWED:
        raise reading.bad("start.matrix", None, f"a rotation: it is off by {brief(off, 2)}")
    return _turned(*q)


def _turned(a: Exact, b: Exact, c: Exact, d: Exact) -> Turn:
    """Gamma is the third row of R, and psi the direction of its third column.

    R is quadratic in the quaternion: it is divided by the squared length, no root is drawn.
    """
    square = a * a + b * b + c * c + d * d
    third = (a * a - b * b - c * c + d * d) / square
    gamma = (2 * (b * d - a * c) / square, 2 * (c * d + a * b) / square, third)
    x, y = 2 * (b * d + a * c), 2 * (a * b - c * d)  # R13 and -R23: sin theta (sin psi, cos psi)
    if sign(x) == 0 == sign(y):  # a pole: phi is counted as 0, and psi is the turn itself
        x, y = 2 * (b * c + a * d), a * a + b * b - c * c - d * d
    return Turn(gamma, exact.arctan2(x, y))

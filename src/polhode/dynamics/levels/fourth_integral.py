"""Where the fourth integral of an integrable top is critical on a level (h, f).

There its tori shrink to circles or points, or to what is asymptotic to them.  T = Mg r0, C the
moment about the axis of symmetry:

    Euler            |G|^2 = 2hA, 2hB, 2hC;  |G|^2 = f^2: G vertical
    Lagrange         L = C r at which A(1 - u^2)(2h - L^2/C - 2 T3 u) - (f - L u)^2, which is
                     (A u')^2, has a double root u in [-1, 1]: steady precession, or, u = ±1,
                     what is asymptotic to the vertical or stays there
    Kovalevskaya     K^2 of Appelrot's four classes (G. G. Appelrot 1894), with H = h/C, a = |T|/C,
                     m = f a/2C:  I: 0, if H >= 2m^2/a^2;  II (k1 > 0), III (k1 < 0): k1^2,
                     k1 = H - 2m^2/a^2, if 4 k1 m^2 <= a^4;  IV: a^2 + 3s^2 + 2Hs,
                     m^2 = -s(s + H)^2, s < 0
    Goryachev-       F = 0 and 108 F^2 = (2h/C ± 2a)^3, on f = 0 alone
    Chaplygin
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

from flint import arb, arb_poly, fmpq_poly

from polhode.dynamics.levels.rational_body import BITS, RationalBody
from polhode.equations.integrals import exact_values, first_integrals
from polhode.motion.frame import Frame
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Exact
from polhode.numbers.flint_context import ctx
from polhode.numbers.polynomials import Polynomial, middle, rational, real_roots
from polhode.scenes import classification
from polhode.scenes.scene import Scene


class CriticalValue(NamedTuple):
    """A value at which the integral is critical, and the class of motions that have it."""

    value: float
    what: str


class FourthIntegral(NamedTuple):
    """``name``: |G|^2, L, K^2 or F; ``value``: the scene's own; ``critical``: ascending."""

    name: str
    value: float
    critical: tuple[CriticalValue, ...]


def fourth_integral(
    scene: Scene, body: RationalBody, h: Fraction, f: Fraction
) -> FourthIntegral | None:
    """Of a scene on the level (h, f); None where its body has no fourth integral there."""
    torque = scene.body.axes.components(scene.body.torque)
    top = classification.classical_top(scene.body.moments, torque)
    with ctx.workprec(BITS):
        size = arb(rational(body.heavy)).sqrt()
        values: Sequence[tuple[arb | Fraction, str]]
        if top.kind == classification.EULER:
            name, values = "|G|^2", _euler(body, h, f)
        elif top.kind in (classification.LAGRANGE, classification.SPHERE):
            name, values = "L", _lagrange(body, top.axis, size, h, f)
        elif top.kind == classification.KOVALEVSKAYA and top.axis is not None:
            name, values = "K^2", _kovalevskaya(body.moments[top.axis], body.heavy, h, f)
        elif top.kind == classification.CHAPLYGIN and top.axis is not None and f == 0:
            name, values = "F", _chaplygin(body.moments[top.axis], size, h)
        else:
            return None
    critical = sorted({CriticalValue(float(value), what) for value, what in values})
    return FourthIntegral(name, _own(scene, name, top.axis or 0), tuple(critical))


def _own(scene: Scene, name: str, axis: int) -> float:
    """The scene's value, in its own units."""
    frame = Frame.of(scene)
    inside = frame.inside(scene)
    found: Exact = exact_values(inside, first_integrals(inside))[-1]
    unit, largest = frame.unit, max(scene.body.moments)
    if name == "|G|^2":
        return to_double(found * (largest / unit) * (largest / unit))
    if name == "L":
        return to_double(found / unit * scene.body.moments[axis])
    return to_double(found / unit ** (4 if name == "K^2" else 3))


def _euler(body: RationalBody, h: Fraction, f: Fraction) -> list[tuple[Fraction, str]]:
    bounds = [2 * h * min(body.moments), 2 * h * max(body.moments)]
    values = [
        (2 * h * a, f"rotation about axis {i + 1}")
        for i, a in enumerate(body.moments)
        if 2 * h * a >= f * f
    ]
    return values + [(f * f, "G vertical")] * (bounds[0] <= f * f <= bounds[1])


def _lagrange(
    body: RationalBody, axis: int | None, torque: arb, h: Fraction, f: Fraction
) -> list[tuple[arb, str]]:
    """The axis is turned so that T3 > 0; a sphere's runs through its centre of mass."""
    k = 2 if axis is None else axis
    across, along = rational(body.moments[k - 1]), rational(body.moments[k])
    t = rational(middle(torque))
    spin = fmpq_poly([0, 1])
    energy = 2 * rational(h) - spin * spin / along
    area = rational(f)
    a = fmpq_poly([2 * t * across])
    b = -across * energy - spin * spin
    c = 2 * area * spin - 2 * t * across
    d = across * energy - area * area
    gap = 18 * a * b * c * d - 4 * b**3 * d + b**2 * c**2 - 4 * a * c**3 - 27 * a**2 * d**2
    values = []
    for root in real_roots(gap):
        at = root.ball
        ball = [_value(x, at) for x in (a, b, c, d)]
        below = 2 * (ball[1] ** 2 - 3 * ball[0] * ball[2])
        if below.contains(0):  # a triple root
            u = -ball[1] / (3 * ball[0])
        else:
            u = (9 * ball[0] * ball[3] - ball[1] * ball[2]) / below
        pole = [name for sign, name in ((1, "upright"), (-1, "hanging")) if u.overlaps(arb(sign))]
        if pole:
            values.append((at, f"{pole[0]}, or asymptotic to it"))
        elif abs(u) < 1:
            values.append((at, f"steady precession, u = {float(u):.6g}"))
    return values


def _kovalevskaya(
    c: Fraction, torque_square: Fraction, h: Fraction, f: Fraction
) -> list[tuple[arb | Fraction, str]]:
    energy, a2 = h / c, torque_square / (c * c)
    m2 = f * f * a2 / (4 * c * c)
    k1 = energy - 2 * m2 / a2
    values: list[tuple[arb | Fraction, str]] = []
    if k1 >= 0:
        values.append((Fraction(0), "I"))
    if k1 != 0 and 4 * k1 * m2 <= a2 * a2:
        values.append((k1 * k1, "II" if k1 > 0 else "III"))
    s = fmpq_poly([0, 1])
    cubic = s * (s + rational(energy)) ** 2 + rational(m2)
    for root in real_roots(cubic):
        value = _value(rational(a2) + 3 * s * s + 2 * rational(energy) * s, root.ball)
        if root.ball < 0 and not value < 0:
            values.append((value, "IV"))
    return values


def _chaplygin(c: Fraction, torque: arb, h: Fraction) -> list[tuple[arb, str]]:
    values = [(arb(0), "F = 0")]
    for sign in (1, -1):
        cube = (2 * rational(h / c) + sign * 2 * torque / rational(c)) ** 3 / 108
        if cube > 0:
            root = cube.sqrt()
            values += [(root, "edge"), (-root, "edge")]
    return values


def _value(polynomial: Polynomial, at: arb) -> arb:
    return arb_poly(polynomial)(at)

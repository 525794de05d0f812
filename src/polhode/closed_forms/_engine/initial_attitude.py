"""The attitude at t = 0 from gamma and psi, and the sign that the quaternion then takes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from polhode.closed_forms.functions.quaternion import Quaternion
from polhode.closed_forms.functions.rounding import number
from polhode.numbers import exact
from polhode.numbers.exact import ZERO, Exact, sign
from polhode.numbers.mpmath_context import mpmath


def first_quaternion(gamma: Sequence[Exact], psi: Exact, bits: int) -> Quaternion:
    """Rz(psi) Rx(theta) Rz(phi) with phi = atan2(g1, g2), to ``bits`` bits; the sign is open.

    Of cos and sin of theta/2 the smaller one comes from sin theta: nothing is lost near a pole.
    """
    with mpmath.workprec(bits):
        g1, g2, g3 = gamma
        near = (1 + number(abs(g3), bits)) / 2
        far = number(g1 * g1 + g2 * g2, bits) / (4 * near)
        near, far = mpmath.sqrt(near), mpmath.sqrt(far)
        cos, sin = (near, far) if sign(g3) >= 0 else (far, near)
        turn, phi = number(psi, bits), mpmath.atan2(number(g1, bits), number(g2, bits))
        c1, s1 = mpmath.cos_sin((turn + phi) / 2)
        c2, s2 = mpmath.cos_sin((turn - phi) / 2)
        return cos * c1, sin * c2, sin * s2, cos * s1


def start_sign(gamma: Sequence[Exact], psi: Exact) -> int:
    """The factor that makes the first component of :func:`first_quaternion` that is not 0 positive.

    Signs of exact numbers, at any precision the same: no rounding of a component that is 0 decides.
    """
    pole = sign(gamma[0]) == 0 == sign(gamma[1])
    phi = ZERO if pole else exact.arctan2(gamma[0], gamma[1])
    cos = not pole or sign(gamma[2]) > 0  # of theta/2, where it is not 0
    sin = not pole or sign(gamma[2]) < 0
    parts = (
        (cos, exact.cos, psi + phi),
        (sin, exact.cos, psi - phi),
        (sin, exact.sin, psi - phi),
        (cos, exact.sin, psi + phi),
    )
    return next(side for there, f, x in parts if there and (side := sign(f(x / 2))))


def start_angles(gamma: Sequence[Exact], psi: Exact, bits: int) -> list[Any]:
    """psi, theta and phi = atan2(g1, g2) at t = 0 to ``bits`` bits; psi and phi None at a pole."""
    with mpmath.workprec(bits):
        g1, g2, g3 = (number(x, bits) for x in gamma)
        theta = mpmath.atan2(mpmath.hypot(g1, g2), g3)
        if sign(gamma[0]) == 0 == sign(gamma[1]):
            return [None, theta, None]
        return [number(psi, bits), theta, mpmath.atan2(g1, g2)]


def start_quaternion(gamma: Sequence[Exact], psi: Exact, side: int, bits: int) -> Quaternion:
    """The attitude at t = 0 to ``bits`` bits, with the sign of :func:`start_sign`."""
    with mpmath.workprec(bits):
        a, b, c, d = (side * x for x in first_quaternion(gamma, psi, bits))
    return a, b, c, d

"""Attitude and Euler angles (3.31–3.33) of a motion, beside its state.

R (body -> space, z up) = Rz(psi) Rx(theta) Rz(phi); gamma = (sin theta sin phi, sin theta cos phi,
cos theta); the unit quaternion of R, scalar first.  With w = (p, q, r) in body axes

    q' = ½ q ⊗ (0, w)
    psi' = (p gamma1 + q gamma2)/(gamma1² + gamma2²),    phi' = r - psi' cos theta.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from typing import NamedTuple

from polhode.numbers import exact
from polhode.numbers.conversion import exactly, to_mpf
from polhode.numbers.exact import ONE, Exact, sign
from polhode.numbers.number_types import DerivedRows, GivenRow, Rows, Scalar, combination
from polhode.numbers.vectors import Triple, Vector, cross, dot
from polhode.scenes.scene import Scene


def starting_attitude(gamma: Vector, psi: Exact) -> tuple[Exact, ...]:
    """The quaternion at t = 0: the first component that is not 0 is positive.

    At a pole phi is counted as 0.
    """
    sine = exact.sqrt(gamma[0] * gamma[0] + gamma[1] * gamma[1])
    half_theta = _half_angle(gamma[2], ONE)
    half_phi = (ONE, exact.ZERO) if sign(sine) == 0 else _half_angle(gamma[1] / sine, gamma[0])
    c, s = exact.cos(psi / 2), exact.sin(psi / 2)
    (ct, st), (cp, sp) = half_theta, half_phi
    q = (
        ct * (c * cp - s * sp),
        st * (c * cp + s * sp),
        st * (s * cp - c * sp),
        ct * (s * cp + c * sp),
    )
    leading = next(side for x in q if (side := sign(x)))
    return tuple(-x for x in q) if leading < 0 else q


def _half_angle(cosine: Exact, side: Exact) -> tuple[Exact, Exact]:
    """Cosine and sine of half the angle in (-pi, pi] of that cosine, its sign that of ``side``."""
    c, s = exact.sqrt((1 + cosine) / 2), exact.sqrt((1 - cosine) / 2)
    return (c, -s) if sign(side) < 0 else (c, s)


def starting_phi(gamma: Vector) -> Exact:
    """phi = atan2(gamma1, gamma2) at t = 0, and 0 at a pole."""
    at_pole = sign(gamma[0]) == 0 and sign(gamma[1]) == 0
    return exact.ZERO if at_pole else exact.arctan2(gamma[0], gamma[1])


def in_scene_axes(vector: Sequence[Scalar], k: Mapping[str, Scalar], zero: Scalar) -> list[Scalar]:
    """A vector inside a frame along the scene's axes, by the coefficients of the frame's turn."""
    if not any(name.startswith("turn") for name in k):
        return list(vector)
    return [combination(k, zero, *((f"turn{i}{j}", vector[i]) for i in range(3))) for j in range(3)]


def attitude_rates(quaternion: Sequence[Scalar], omega: Sequence[Scalar]) -> list[Scalar]:
    """The quaternion's time derivative; omega along the axes whose attitude it is."""
    return quaternion_spin(quaternion, [x / 2 for x in omega])


def quaternion_spin(quaternion: GivenRow, omega: GivenRow) -> list[Scalar]:
    """q ⊗ (0, w)."""
    (q0, q1, q2, q3), (p, q, r) = quaternion, omega
    return [
        -(q1 * p) - q2 * q - q3 * r,
        q0 * p + q2 * r - q3 * q,
        q0 * q + q3 * p - q1 * r,
        q0 * r + q1 * q - q2 * p,
    ]


def angle_rates(omega: Sequence[Scalar], gamma: Sequence[Scalar]) -> list[Scalar]:
    """psi' and phi'; infinite at a pole."""
    p, q, r = omega
    g1, g2, g3 = gamma
    psi_rate = (p * g1 + q * g2) / (g1 * g1 + g2 * g2)
    return [psi_rate, r - psi_rate * g3]


def angles_off_the_pole(
    quaternion: Sequence[Scalar], gamma: Sequence[Scalar], psi: Exact, leaving: float, bits: int
) -> tuple[Fraction, Fraction]:
    """psi and phi a moment after a start at a pole with that psi, from attitude and gamma.

    ``leaving``: the limit of phi at the pole, which tells its turn.

    psi + phi = 2 arg(q0 + i q3) and psi - phi = 2 arg(q1 + i q2): the former is continuous over the
    upper pole, the latter over the lower one.
    """
    from polhode.numbers.mpmath_context import mpmath

    with mpmath.workprec(bits + 16):
        q0, q1, q2, q3, g1, g2, g3 = (to_mpf(exactly(x), bits) for x in (*quaternion, *gamma))
        start, phi = to_mpf(psi, bits + 16), mpmath.atan2(g1, g2)
        phi += 2 * mpmath.pi * mpmath.nint((leaving - phi) / (2 * mpmath.pi))
        whole = 2 * (mpmath.atan2(q3, q0) if g3 > 0 else mpmath.atan2(q2, q1))
        whole += 2 * mpmath.pi * mpmath.nint((start - whole) / (2 * mpmath.pi))
        return exactly(whole - phi if g3 > 0 else whole + phi), exactly(phi)


def principal_angles(
    quaternion: Iterable[Scalar],
    atan2: Callable[[Scalar, Scalar], Scalar],
    hypot: Callable[[Scalar, Scalar], Scalar],
) -> Triple:
    """psi theta phi of a quaternion, psi and phi up to whole turns; without a meaning at a pole.

    psi and phi are the sum and the difference of the arguments of q0 + i q3 and q1 + i q2.
    ``atan2``, ``hypot``: those of the numbers.
    """
    q0, q1, q2, q3 = quaternion
    half_sum, half_difference = atan2(q3, q0), atan2(q2, q1)
    return (
        half_sum + half_difference,
        2 * atan2(hypot(q1, q2), hypot(q0, q3)),
        half_sum - half_difference,
    )


class AngleFunctions(NamedTuple):
    """What angles take of columns of numbers of one kind."""

    hypot: Callable[[Scalar, Scalar], Scalar]
    atan2: Callable[[Scalar, Scalar], Scalar]
    sqrt: Callable[[Scalar], Scalar]
    rint: Callable[[Scalar], Scalar]
    pi: Scalar


def angles(
    gamma: Sequence[Scalar], psi_and_phi: Sequence[Scalar], fn: AngleFunctions
) -> list[Scalar]:
    """psi theta phi: theta and phi from gamma, phi on the integrated one's branch.

    A motion that passes exactly through a pole turns phi by pi against the integrated one: psi then
    turns by pi too.  At a pole itself psi and phi have no meaning.
    """
    (g1, g2, g3), (psi, phi) = gamma, psi_and_phi
    theta = fn.atan2(fn.hypot(g1, g2), g3)
    principal = fn.atan2(g1, g2)
    halves = fn.rint((phi - principal) / fn.pi)
    odd = halves % 2
    return [
        psi - odd * (2 * (g3 > 0) - 1) * fn.pi,
        theta,
        principal + (halves + odd) * fn.pi,
    ]


# --- hodographs -----------------------------------------------------------------------------------
#
# Hodographs of omega in the body and in space, and what else rolls and turns (3.34).
#
# The body's motion is the rolling, without slipping, of the cone that omega describes in the body
# upon the one that it describes in space: as w × w = 0,
#
#     d(R w)/dt = R (w' + w × w) = R w'
#
# so the two curves have a common tangent and equal arcs. For a free body they are the polhode and
# the herpolhode. R (body -> space, z up) is that of the attitude quaternion, of whatever length:
# R(q) v = q ⊗ (0, v) ⊗ q* / |q|², an exact rotation though |q| drifts by rounding.


class Hodographs(NamedTuple):
    """Rows of omega along the body's axes and along those of space (z up), one row per time.

    Arrays for double and extended, rows of mpf above; ``space`` is formed in more precision than
    the numbers have and rounded once.
    """

    body: Rows
    space: DerivedRows


def turned(quaternion: GivenRow, vector: GivenRow) -> list[Scalar]:
    """R(q) v of one quaternion of any length, or of columns of them."""
    q0: Scalar = quaternion[0]
    axis: Scalar = (quaternion[1], quaternion[2], quaternion[3])
    square = q0 * q0 + dot(axis, axis)
    half: Scalar = cross(axis, (vector[0], vector[1], vector[2]))
    across = cross(axis, half)
    return [v + 2 * (q0 * a + b) / square for v, a, b in zip(vector, half, across, strict=True)]


# --- pole passage ---------------------------------------------------------------------------------
#
# Poles, where the third axis is vertical and psi and phi have no meaning: the rule for branches.
#
# Over a pole one of psi + phi (the upper pole) and psi - phi (the lower one) stays continuous;
# the other jumps by 2 pi up or down, and both are right. A start at a pole is left with phi in
# [-pi, pi) from the upper one, in (-pi, pi] from the lower (:func:`phi_leaving_the_pole`), on
# either side of t = 0. A motion that passes exactly through a pole later may have either branch
# from there on: a run passes it at a distance of rounding, on either side, proofs lose the angles.


def departure(scene: Scene) -> tuple[int, Vector] | None:
    """How a start at a pole leaves it; None where the third axis stays vertical for ever.

    The order of the derivative with which gamma leaves it, gamma x a vector, and that vector: w for
    order 1, w' for order 2.
    gamma' = gamma x w, and gamma'' = gamma x w' where w is along the third axis.  Where both vanish
    all derivatives do: I w' is then across gamma and w' along it, so that w'.I w' = 0 and w' = 0.
    """
    slope = scene.body.omega(scene.body.moment(scene.omega, scene.gamma))
    for order, vector in ((1, scene.omega), (2, slope)):
        if not sign(vector[0]) == 0 == sign(vector[1]):
            return order, vector
    return None


def phi_leaving_the_pole(scene: Scene, sense: int) -> float:
    """The limit of phi at a start at a pole, as time goes on (``sense`` 1) or back (-1).

    On the negative axis, where phi could be either, it is -pi from the upper pole and pi from the
    lower one.  0 where the pole is never left.
    """
    assert scene.gamma is not None
    up, leaving = sign(scene.gamma[2]), departure(scene)
    if leaving is None:
        return 0.0
    order, w = leaving
    sense = sense if order == 1 else 1  # t^2 has the same sign on both sides
    across, along = -sense * up * sign(w[1]), sense * up * sign(w[0])
    if across == 0 and along < 0:
        return -up * math.pi
    largest = max(abs(w[0]), abs(w[1]))
    p, q = (float(x / largest) if sign(x) else 0.0 for x in w[:2])
    return math.atan2(-sense * up * q if across else 0.0, sense * up * p)

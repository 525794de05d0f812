"""Axes with z through the centre of mass in which a symmetric matrix has no 12 component."""

from __future__ import annotations

from polhode.numbers import exact
from polhode.numbers.exact import sign
from polhode.numbers.vectors import Matrix, Vector, apply, cross, dot, is_zero, scaled
from polhode.scenes.body import IDENTITY, OWN_AXES, Body, PrincipalAxes


def centre_axes(body: Body, matrix: Matrix) -> PrincipalAxes:
    """The axes for ``matrix``, the inertia matrix or its inverse: the body's own where they fit.

    Across z they are the principal directions of the matrix cut down to that plane.  A body
    without torque has no such z: its principal axes are taken.
    """
    z = body.torque
    if is_zero(z):
        return body.axes
    if sign(z[0]) == 0 == sign(z[1]) and sign(z[2]) > 0 and sign(matrix[0][1]) == 0:
        return OWN_AXES
    x = _flat(matrix, z)
    y = cross(z, x)
    return PrincipalAxes((x, y, z), (dot(x, x), dot(y, y), dot(z, z)))


def _flat(matrix: Matrix, z: Vector) -> Vector:
    """A vector x across z with x·matrix·(z × x) = 0.

    With a across z, b = z × a, x = s a + t b: z × x = s b - t z² a, and what has to vanish is
    m_ab s² + (m_bb - z² m_aa) s t - z² m_ab t².
    """
    a = next(v for u in IDENTITY if not is_zero(v := cross(u, z)))
    b = cross(z, a)
    m_ab = dot(a, apply(matrix, b))
    if sign(m_ab) == 0:
        return a
    square = dot(z, z)
    half = (square * dot(a, apply(matrix, a)) - dot(b, apply(matrix, b))) / 2
    root = exact.sqrt(half * half + square * m_ab * m_ab)
    s = half - root if sign(half) < 0 else half + root
    x, y, w = (u + v for u, v in zip(scaled(s, a), scaled(m_ab, b), strict=True))
    return x, y, w

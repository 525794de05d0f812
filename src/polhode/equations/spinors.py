"""The attitude as a spinor: two complex numbers whose common phase is half the turn about gamma.

A unit quaternion (scalar first) is z = (q0 + i q3, i (q1 + i q2)); the upward vertical in the
body's axes is z's point on the sphere, gamma = z† sigma z with Pauli's matrices.  A fixed spinor k
of a direction a of the body gives every gamma but -a a spinor of its own, (1 + gamma·sigma) k.  In
units of it z has the phase X/2, and with w the angular velocity

    X' = w·(gamma + a)/(1 + gamma·a),

which has a pole nowhere but at gamma = -a: with a the third axis X is psi + phi.

Arrays of numpy, in double or extended; a vector's components come first.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np

#: Three components, or the two of a spinor, each of any shape.
Components: TypeAlias = Any


def spinor(quaternion: Components) -> Components:
    """z of a quaternion."""
    q0, q1, q2, q3 = quaternion
    return np.stack([q0 + 1j * q3, 1j * q1 - q2])


def quaternion(z: Components) -> Components:
    """The quaternion of length one with the directions of z."""
    found = np.stack([z[0].real, z[1].imag, -z[1].real, z[0].imag])
    return found / np.sqrt((found * found).sum(axis=0))


def of_direction(a: Components) -> Components:
    """A spinor, of any length and phase, whose point on the sphere is the direction a."""
    a1, a2, a3 = a
    across, upper = a1 + 1j * a2, a3 >= 0
    return np.stack([np.where(upper, 1 + a3, across.conj()), np.where(upper, across, 1 - a3)])


def section(k: Components, gamma: Components) -> Components:
    """The spinor of gamma that k gives, of a length that depends on both; none for -k's point."""
    g1, g2, g3 = gamma
    across = g1 + 1j * g2
    return np.stack([(1 + g3) * k[0] + across.conj() * k[1], across * k[0] + (1 - g3) * k[1]])


def rate(omega: Components, gamma: Components, a: Components) -> Components:
    """X', of arrays of states and a direction for each row of them."""
    (p, q, r), (g1, g2, g3) = omega, gamma
    a1, a2, a3 = (x[..., None] for x in a)
    above = p * (g1 + a1) + q * (g2 + a2) + r * (g3 + a3)
    return above / (1 + (g1 * a1 + g2 * a2 + g3 * a3))


def product(y: Components, z: Components) -> Components:
    """<y, z>: its phase is by how much z is ahead of y where both are of one gamma."""
    return y[0].conj() * z[0] + y[1].conj() * z[1]

"""What every family's attitude is made of, on a body that turns uniformly: q0 (cos x, n sin x)."""

import numpy as np
import pytest

from polhode.closed_forms._engine import azimuth_quadrature
from polhode.closed_forms._engine.azimuth_quadrature import Azimuth
from polhode.closed_forms._engine.periodic_attitude import OneOrbit
from polhode.closed_forms.functions.quaternion import of_matrix, product
from polhode.numbers.mpmath_context import mpf, mpmath
from shared.closed_form_checks import rotation

BITS = 128
#: The axis, in the body, and the attitude at t = 0; both arguments pass 0 at a small distance.
AXIS = 2, 3, 6  # over 7
START = 5, -7, 1, 5  # over 10


def begun():
    return tuple(mpf(x) / 10 for x in START)


def axis():
    return tuple(mpf(x) / 7 for x in AXIS)


def turned(t):
    """|w| = 1: the body has turned by t about the axis."""
    c, s = mpmath.cos_sin(t / 2)
    return product(begun(), (c, *(s * x for x in axis())))


def counted(t):
    """The growth of both arguments, by many small differences in doubles."""
    x = np.linspace(0, float(t) / 2, 4001)
    now, later = (np.array([float(v) for v in turned(s)]) for s in (mpf(0), mpmath.pi))
    q = np.outer(np.cos(x), now) + np.outer(np.sin(x), later)
    points = q[:, 0] + 1j * q[:, 3], q[:, 1] + 1j * q[:, 2]
    return [float(np.angle(z[1:] / z[:-1]).sum()) for z in points]


def test_the_arguments_of_a_periodic_motion_are_counted_wherever_it_is_asked():
    """Between two marks of the count too, where up to half a turn is left to count."""
    with mpmath.workprec(BITS):
        # It comes back, but for a turn about the vertical by 2 pi, after each 2 pi.
        found, grown = OneOrbit(begun(), turned, mpf(1), 2 * mpmath.pi), []
        for t in map(mpf, ("0.7", "2.9", "4.6", "9.8", "33.1", "100.3", "-1.9", "-5.5", "-77.7")):
            mine, right = found.arguments(t), counted(t)
            assert max(abs(a - b) for a, b in zip(mine, right, strict=True)) < 1e-11, t
            grown += right
        assert max(grown) > 40
        assert min(grown) < -30


def test_a_quaternion_from_an_azimuth_is_continuous_through_zeros_of_its_components():
    """gamma = R^T e3 of the rotation is all that the azimuth is told."""

    def state(s):
        a, x, y, z = turned(s)
        gamma = 2 * (x * z - a * y), 2 * (y * z + a * x), a * a - x * x - y * y + z * z
        return axis(), gamma, mpf(1)

    with mpmath.workprec(BITS):
        found = Azimuth(state, begun(), mpf(1), lambda t: t)
        signs = set()
        for k in range(1, 25):
            t = mpf(k) / 3
            mine, right = found.at(t), turned(t)
            assert max(abs(a - b) for a, b in zip(mine, right, strict=True)) < mpf(2) ** -110, t
            signs.add(tuple(x > 0 for x in right))
        assert len(signs) > 4


@pytest.mark.parametrize("e", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, -1, 0), (1, 1, 1)])
def test_the_upright_turn_takes_the_vertical_up_and_its_direction_to_the_front(e):
    with mpmath.workprec(BITS):
        gamma = tuple(mpf(x) / 9 for x in (4, -7, 4))
        turned = rotation(azimuth_quadrature._upright(gamma, e))
        up, front = (turned * mpmath.matrix(v) for v in (gamma, e))
        assert mpmath.norm(up - mpmath.matrix([0, 0, 1])) < mpf(2) ** -120
        assert front[0] > 0.4
        assert abs(front[1]) < mpf(2) ** -120


@pytest.mark.parametrize("largest", range(4))
def test_the_quaternion_of_a_matrix_whichever_part_is_the_largest(largest):
    with mpmath.workprec(BITS):
        q = np.roll([mpf(x) / 10 for x in (7, 5, -5, -1)], largest)
        found = of_matrix(rotation(q).tolist())
        assert max(abs(a - b) for a, b in zip(found, q, strict=True)) < mpf(2) ** -120

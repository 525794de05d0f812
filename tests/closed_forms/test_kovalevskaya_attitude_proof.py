"""The steps of the guide's page on the attitude of Kovalevskaya's top, each by itself."""

import random
from itertools import product

import numpy as np
import pytest

from polhode.closed_forms.kovalevskaya.attitude.cayley_klein import CayleyKlein
from polhode.closed_forms.kovalevskaya.top import KovalevskayaTop
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from shared.members import motion_table, read_start

GENERIC = motion_table()["kovalevskaya"]
NAMES = ["e-ee+", pytest.param("-e+ (complex pair)", marks=pytest.mark.campaign)]
_BITS = 200  # 50 digits, and ten to spare


def time_flow(p, q, r, G1, G2, G3):
    return q * r / 2, (G3 - p * r) / 2, -G2, G2 * r - G3 * q, G3 * p - G1 * r, G1 * q - G2 * p


def second_flow(p, q, r, G1, G2, G3):
    """Of k^2/2: M = (2p, 2q, r) and G by M' = M x Om + G x dK/dG, G' = G x Om."""
    x = p + 1j * q
    X = x * x - G1 - 1j * G2
    a, b = (x.conj() * X).real, (x.conj() * X).imag  # Om = (a, b, 0)
    c, d = -X.real, -X.imag
    return (
        (-r * b - G3 * d) / 2,
        (r * a + G3 * c) / 2,
        2 * p * b - 2 * q * a + G1 * d - G2 * c,
        -G3 * b,
        G3 * a,
        G1 * b - G2 * a,
    )


def time_matrix(p, q, r, *_):
    """2/i times the matrix of (xi, eta)' = ((i/2)(x eta - r xi), (i/2)(r eta + conj(x) xi))."""
    x = p + 1j * q
    return [[-r, x], [x.conj(), r]]


def second_matrix(p, q, r, G1, G2, _):
    x = p + 1j * q
    X = x * x - G1 - 1j * G2
    return [[0 * r, x.conj() * X], [x * X.conj(), 0 * r]]


def along(matrix, state, flow):
    """The derivative of a matrix of polynomials of degree 4 at most, by its fourth differences."""
    weights = {-2: 1 / 12, -1: -2 / 3, 1: 2 / 3, 2: -1 / 12}
    parts = []
    for n, weight in weights.items():
        moved = [x + n * y for x, y in zip(state, flow, strict=True)]
        parts.append([[weight * z for z in row] for row in matrix(*moved)])
    return [[sum(part[i][j] for part in parts) for j in (0, 1)] for i in (0, 1)]


def test_step_1_the_two_flows_of_the_spinors_commute():
    """A polynomial of degree below 7 in each of six variables that is 0 on a grid of 7^6 is 0."""
    values = np.arange(-3.0, 4.0)
    state = [x.ravel() for x in np.meshgrid(*[values] * 6, indexing="ij")]
    one, other = time_matrix(*state), second_matrix(*state)
    left = along(time_matrix, state, second_flow(*state))
    right = along(second_matrix, state, time_flow(*state))
    for i, j in product((0, 1), repeat=2):
        bracket = sum(one[i][k] * other[k][j] - other[i][k] * one[k][j] for k in (0, 1))
        curvature = left[i][j] - right[i][j] + 0.5j * bracket
        assert abs(curvature).max() < 1e-6
        assert abs(bracket).max() > 1


def test_step_2_exponents_at_every_pole_are_1_and_minus_1():
    """w = w0/ta, G = g/ta^2: the balances of the page, in Gaussian integers."""
    balances = [(0, side * 2j, 0, 4, 0, -side * 4j) for side in (1, -1)]
    for side, q in product((1, -1), (0, 1, 2 - 3j, 5j)):
        p = -side * 1j * q  # q r = -2p, r = 2i side
        balances.append((p, q, side * 2j, 2, side * 2j, p * side * 2j - 2 * q))
    for p, q, r, a, b, c in balances:
        found = time_flow(p, q, r, a, b, c)
        assert found == (-p, -q, -r, -2 * a, -2 * b, -2 * c)
        # the residue (i/2)((-r, x), (x*, r)) has trace 0 and this determinant
        assert (r * r + p * p + q * q) / 4 == -1


def formula(name) -> CayleyKlein:
    top = KovalevskayaTop(*read_start(GENERIC[name]))
    return top._attitudes.at(_BITS).formula(0)


def missed(made, u1, t):
    """By how much xi' and eta' miss their equations at a complex place."""
    step = mpmath.ldexp(1, -60)
    (U, V), z0 = made.ways, made.motion.z0
    z = tuple(a + u1 * b + t * c for a, b, c in zip(z0, U, V, strict=True))
    p, q, r, *_ = made.motion.state((z[0], z[1]))
    xi, eta = made.at(t, u1)
    ends = [made.at(t + n * step, u1) for n in (-2, -1, 1, 2)]
    slopes = [
        (a[i] - 8 * b[i] + 8 * c[i] - d[i]) / (12 * step) for i in (0, 1) for a, b, c, d in [ends]
    ]
    x, y = p + 1j * q, p - 1j * q
    size = abs(xi) + abs(eta) + max(map(abs, slopes))
    return max(
        abs(slopes[0] - 0.5j * (x * eta - r * xi)) / size,
        abs(slopes[1] - 0.5j * (r * eta + y * xi)) / size,
    )


@pytest.mark.parametrize(
    ("name", "places"),
    [
        ("e-ee+", 12),
        pytest.param("e-ee+", 104, marks=pytest.mark.slow),
        pytest.param("-e+ (complex pair)", 104, marks=pytest.mark.campaign),
    ],
)
def test_step_6_the_equations_hold_at_more_places_than_they_have_constants(name, places):
    """100 constants; the quotient of differences is right to 2^-240."""
    made = formula(name)
    pick = random.Random(7)
    with mpmath.workprec(_BITS + 100):
        for _ in range(places):
            u1, t = (mpc(pick.uniform(-2, 2), pick.uniform(-0.4, 0.4)) for _ in range(2))
            assert missed(made, u1, t) < mpf("1e-50")
    wrong = made.__class__(**{**made.__dict__, "rates": (made.rates[0], made.rates[1] + 1e-30)})
    with mpmath.workprec(_BITS + 100):
        assert missed(wrong, mpc("0.3"), mpc("0.2")) > mpf("1e-32")


@pytest.mark.parametrize("name", NAMES)
def test_step_4_both_gain_one_factor_over_twice_a_lattice_vector(name):
    """Real or complex, at places of the plane taken at random."""
    made = formula(name)
    first, second, _ = made.motion.curve.periods
    pick = random.Random(3)
    with mpmath.workprec(_BITS):
        for period in (*first, *second):
            factors = []
            for _ in range(3):
                u1, t = (mpc(pick.uniform(-1, 1), pick.uniform(-0.3, 0.3)) for _ in range(2))
                here, there = made.at(t, u1), made.at(t + 2 * period[1], u1 + 2 * period[0])
                factors += [b / a for a, b in zip(here, there, strict=True)]
            assert max(abs(x / factors[0] - 1) for x in factors) < mpf("1e-50")
            c = made.at(mpf(1) / 3 + 2 * period[1], 2 * period[0])[0] / made.at(mpf(0))[0]
            assert abs(c / factors[0] - 1) > mpf("1e-3")

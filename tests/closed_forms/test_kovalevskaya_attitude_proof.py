"""The steps of the guide's page on the attitude of Kovalevskaya's top, each by itself."""

import random
from itertools import product

import numpy as np
import pytest
from flint import acb, arb, ctx

from shared.closed_forms import form
from shared.members import motion_table, read_start

GENERIC = motion_table()["kovalevskaya"]
NAMES = ["e-ee+"]
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
    first, second = time_matrix(*state), second_matrix(*state)
    left = along(time_matrix, state, second_flow(*state))
    right = along(second_matrix, state, time_flow(*state))
    for i, j in product((0, 1), repeat=2):
        bracket = sum(first[i][k] * second[k][j] - second[i][k] * first[k][j] for k in (0, 1))
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
        flow = time_flow(p, q, r, a, b, c)
        assert flow == (-p, -q, -r, -2 * a, -2 * b, -2 * c)
        # the residue (i/2)((-r, x), (x*, r)) has trace 0 and this determinant
        assert (r * r + p * p + q * q) / 4 == -1


def formula(name):
    """The attitude's constants, and the second way on the Jacobian."""
    top = form("kovalevskaya", *read_start(GENERIC[name]))
    attitude = top._motion().attitude
    return attitude, attitude.motion.jacobian.reduced((acb(1), acb(0)))


def dot(row, jets, which):
    """A combination of values (0) or of derivatives (1)."""
    return sum((x * jet[which] for x, jet in zip(row, jets, strict=True)), acb(0))


def values_at(attitude, choice, u1, t):
    """The complex state, xi and eta and their slopes at a complex place; e^(c1 u1) is left out."""
    motion = attitude.motion
    quotients, V = motion.choices[0], motion.velocity
    z = tuple(a + u1 * b + t * c for a, b, c in zip(motion.z0, choice, V, strict=True))
    z, _, k = motion.jacobian.lattice.reduced(z, 2)
    state = quotients.state(motion.H, motion.values_at(z))
    low = tuple(a + b for a, b in zip(z, attitude.h, strict=True))
    below = attitude.functions.at(low)
    above = attitude.functions.at(tuple(a + b for a, b in zip(low, attitude.e, strict=True)))
    e = attitude.e
    moved = acb(0, 2) * arb.pi() * (k[0] * e[0] + k[1] * e[1])
    factor = (attitude.rate * t - moved + above.log - below.log).exp()
    rows = []
    (choice,) = attitude.choices
    for top, bottom in zip(choice.tops, choice.bottoms, strict=True):
        N, d = (dot(row, jets.along(V), 0) for row, jets in ((top, above), (bottom, below)))
        N1, d1 = (dot(row, jets.along(V), 1) for row, jets in ((top, above), (bottom, below)))
        value = factor * N / d
        rows.append((value, value * (attitude.rate + N1 / N - d1 / d)))
    return state, *rows


def missed(attitude, choice, u1, t):
    """By how much xi' and eta' miss their equations at a complex place, in balls."""
    (p, q, r, *_), (xi, xi1), (eta, eta1) = values_at(attitude, choice, u1, t)
    half = acb(0, 0.5)
    x, y = p + 2 * half * q, p - 2 * half * q
    size = abs(xi) + abs(eta) + abs(xi1) + abs(eta1)
    return [
        (xi1 - half * (x * eta - r * xi)) / size,
        (eta1 - half * (r * eta + y * xi)) / size,
    ]


def place(pick, high):
    return acb(pick.uniform(-2, 2), pick.uniform(-high, high))


@pytest.mark.parametrize(
    ("name", "places"),
    [
        ("e-ee+", 12),
        pytest.param("e-ee+", 104, marks=pytest.mark.slow),
    ],
)
def test_step_6_the_equations_hold_at_more_places_than_they_have_constants(name, places):
    """100 constants; the residuals are balls that hold 0 and are small."""
    pick = random.Random(7)
    with ctx.workprec(_BITS + 100):
        attitude, choice = formula(name)
        for _ in range(places):
            for rest in missed(attitude, choice, place(pick, 0.4), place(pick, 0.4)):
                assert rest.contains(0)
                assert rest.real.rad() < 1e-50
        attitude.rate += arb("1e-30")
        rests = missed(attitude, choice, acb(0.3), acb(0.2))
        assert not all(rest.contains(0) for rest in rests)


@pytest.mark.parametrize("name", NAMES)
def test_step_4_both_gain_one_factor_over_twice_a_lattice_vector(name):
    """Real or complex, at places of the plane taken at random."""
    pick = random.Random(3)
    with ctx.workprec(_BITS):
        attitude, choice = formula(name)
        jacobian = attitude.motion.jacobian
        for period in jacobian.columns:
            factors = []
            for _ in range(3):
                u1, t = place(pick, 0.3), place(pick, 0.3)
                here = values_at(attitude, choice, u1, t)
                there = values_at(attitude, choice, u1 + 2 * period[0], t + 2 * period[1])
                factors += [b[0] / a[0] for a, b in zip(here[1:], there[1:], strict=True)]
            assert all(x.overlaps(factors[0]) for x in factors)
            assert factors[0].real.rad() < 1e-45

"""Bodies: principal axes recognised exactly after any rational rotation, and what no body has."""

import re
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

import polhode
from polhode import BadInput, Body, Part
from shared.members import rotation
from shared.tools import number

small = st.integers(-6, 6)
entries = st.fractions(min_value=-3, max_value=3, max_denominator=12)


@st.composite
def rotations(draw):
    """The rotation of a rational quaternion: rows of rational numbers, exactly orthonormal."""
    w, x, y, z = (Fraction(draw(small)) for _ in range(4))
    assume(w or x or y or z)
    return rotation(w, x, y, z)


@st.composite
def three_moments(draw):
    """Moments of a cloud of points, so physical; some of the points may lie in one plane."""
    x, y, z = (draw(st.fractions(0, 5, max_denominator=9)) for _ in range(3))
    assume(x + y and y + z and z + x)
    return y + z, z + x, x + y


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def applied(matrix, v):
    a, b, c = (dot(row, v) for row in matrix)
    return a, b, c


def transposed(matrix):
    a, b, c = zip(*matrix, strict=True)
    return a, b, c


def inertia_matrix(moments, rotation):
    """R·diag(moments)·Rᵀ: the inertia matrix whose axes are the columns of R."""
    scaled = transposed(
        tuple(tuple(m * x for x in c) for m, c in zip(moments, transposed(rotation), strict=True))
    )
    a, b, c = (applied(rotation, row) for row in scaled)
    return a, b, c


def vector(*entries):
    a, b, c = (number(str(x)) for x in entries)
    return a, b, c


def assert_principal(body):
    """Right-handed orthonormal axes, and the matrix rebuilt from moments and axes."""
    rows = body.axes.rows
    for i in range(3):
        for j in range(3):
            assert dot(rows[i], rows[j]) == (1 if i == j else 0)
            rebuilt = sum(m * u[i] * u[j] for m, u in zip(body.moments, rows, strict=True))
            assert rebuilt == body.inertia[i][j]
    for i, x in enumerate(rows[2]):
        assert x == rows[0][i - 2] * rows[1][i - 1] - rows[0][i - 1] * rows[1][i - 2]


FLAT = Fraction(1, 3), Fraction(2, 7), Fraction(13, 21)
SOME = Fraction(1), Fraction(-2), Fraction(1, 2)


@settings(max_examples=15)
@given(three_moments(), rotations(), st.tuples(entries, entries, entries))
@example(FLAT, ((1, 0, 0), (0, 1, 0), (0, 0, 1)), SOME)
def test_rational_moments_are_found_exactly_after_any_rotation(moments, rotation, w):
    body = Body(inertia_matrix(moments, rotation), (0, 0, 0), 0)
    assert all(isinstance(m, Fraction) for m in body.moments)
    assert sorted(body.moments) == sorted(moments)
    assert_principal(body)
    assert body.omega(body.momentum(w)) == w == body.momentum(body.omega(w))


@settings(max_examples=15)
@given(three_moments(), rotations())
def test_equal_moments_are_recognised_and_the_axis_of_symmetry_is_the_third(moments, rotation):
    single, equal = moments[0], moments[1]
    assume(single != equal and single <= 2 * equal)
    body = Body(inertia_matrix((single, equal, equal), rotation), (0, 0, 0), 0)
    if not body.axes.trivial:
        assert body.moments == (equal, equal, single)
    assert sorted(body.moments) == sorted((single, equal, equal))
    assert_principal(body)


@settings(max_examples=15)
@given(three_moments(), rotations(), st.integers(0, 2), entries)
def test_a_centre_on_an_axis_is_recognised_exactly(moments, rotation, axis, height):
    assume(height and len(set(moments)) > 1)
    along = transposed(rotation)[axis]
    centre = (height * along[0], height * along[1], height * along[2])
    body = Body(inertia_matrix(moments, rotation), centre, 1)
    # A matrix that is diagonal already keeps its axes: with two equal moments any across would do.
    assume(len(set(moments)) == 3 or not body.axes.trivial)
    components = body.axes.components(body.centre)
    assert sum(x != 0 for x in components) == 1
    assert sum(x * x for x in components) == height * height
    moment = next(m for m, x in zip(body.moments, components, strict=True) if x != 0)
    assert moment == moments[axis]


@settings(max_examples=15)
@given(rotations(), entries, entries)
def test_with_two_equal_moments_the_second_axis_is_across_the_centre(rotation, x, z):
    assume(x and z)
    centre = applied(rotation, (x, 0, z))
    body = Body(inertia_matrix((2, 2, 1), rotation), centre, 1)
    assume(not body.axes.trivial)
    components = body.axes.components(centre)
    assert components[1] == 0
    assert abs(components[0]) == abs(x)
    assert abs(components[2]) == abs(z)


@settings(max_examples=15)
@given(st.lists(entries, min_size=6, max_size=6))
def test_any_symmetric_matrix_has_axes_or_is_refused(six):
    a, b, c, d, e, f = six
    inertia = ((abs(a), d, e), (d, abs(b), f), (e, f, abs(c)))
    with mpmath.workdps(40):
        values = mpmath.eigsy(
            mpmath.matrix([[mpmath.mpf(x.numerator) / x.denominator for x in r] for r in inertia]),
            eigvals_only=True,
        )
        low, middle, high = sorted(values)
        tiny = mpmath.mpf(10) ** -30
        physical = low > tiny and low + middle > high + tiny
        unphysical = low < -tiny or low + middle < high - tiny
    try:
        body = Body(inertia, (0, 0, 0), 0)
    except BadInput:
        assert not physical
        return
    assert not unphysical
    assert_principal(body)
    if not body.axes.trivial:
        assert list(body.moments) == sorted(body.moments) or body.moments[0] == body.moments[1]
    with mpmath.workdps(40):
        for ours, theirs in zip(sorted(body.moments), (low, middle, high), strict=True):
            assert abs(mpmath.mpf(polhode.as_decimal(ours, 40)) - theirs) < tiny


@pytest.mark.parametrize(
    ("rows", "rational"),
    [
        (((3, 0, 0), (0, 1, 1), (0, 1, 3)), 3),  # 2 +- sqrt(2): the larger is nearest to 3
        (((2, 0, 0), (0, 3, "1/2"), (0, "1/2", 2)), 2),  # (5 +- sqrt(2))/2: near 2 in halves
        (((1, 1, 0), (1, 2, 0), (0, 0, "5/2")), "5/2"),
        ((("sqrt(2)", "1/9", "sin(1)/9"), ("1/9", "pi/2", "1/7"), ("sin(1)/9", "1/7", 2)), None),
        (((2, "sqrt(2)/10", 0), ("sqrt(2)/10", 2, 0), (0, 0, 2)), 2),
        ((("2e600", "1e599", "1e590"), ("1e599", "2.5e600", 0), ("1e590", 0, "3e600")), None),
        (((3, 0, 0), (0, 2, 0), (0, 0, 4)), None),
    ],
)
def test_irrational_and_huge_matrices_are_rebuilt_by_the_rule(rows, rational):
    """An irrational moment next to a rational one is not that."""
    a, b, c = (vector(*row) for row in rows)
    body = Body((a, b, c), (1, 0, 0), 1)
    assert_principal(body)
    if rational is not None:
        assert [x for x in body.moments if x == number(str(rational))] == [number(str(rational))]
    assert sum(body.moments) == a[0] + b[1] + c[2]
    if rows[0][0] == 3 and rows[1][2] == 0:  # a diagonal matrix keeps its own axes and order
        assert body.axes.trivial
        assert body.moments == vector(3, 2, 4)


def test_irrational_moments_that_are_equal_or_flat_are_recognised():
    cosine, sine = number("sqrt(3)/2"), number("1/2")
    rotation = ((cosine, 0, -sine), (0, 1, 0), (sine, 0, cosine))
    moments = vector("sqrt(2)", "sqrt(2)", "sqrt(3)/2")
    body = Body(inertia_matrix(moments, rotation), applied(rotation, vector(0, 0, "pi")), 1)
    assert body.moments[0] == body.moments[1] == moments[0]
    assert body.moments[2] == moments[2]
    x, y, z = body.axes.components(body.centre)
    assert (x, y, z * z) == (0, 0, number("pi**2"))
    Body.of_moments(vector("sqrt(2)", "sqrt(3)", "sqrt(5+2*sqrt(6))"))


@pytest.mark.parametrize(
    ("rows", "reason"),
    [
        ((((2, 0, "1e-1000"), (0, 3, 0), (0, 0, 4))), "symmetric"),
        ((((2, 9, 0), (9, 3, 0), (0, 0, 4))), "positive"),
        ((((1, 1, 1), (1, 1, 1), (1, 1, 1))), "positive"),
        ((((0, 0, 0), (0, 1, 0), (0, 0, 1))), "positive"),
        ((((1, 0, 0), (0, 2, 0), (0, 0, "3+1e-1000"))), "sum"),
        ((((5, "1/100", 0), ("1/100", 2, 0), (0, 0, 2))), "sum"),
        ((((1, 0, 0), (0, "sqrt(2)", 0), (0, 0, "1+sqrt(2)+1e-900"))), "sum"),
    ],
)
def test_what_no_body_has_is_refused(rows, reason):
    a, b, c = (vector(*row) for row in rows)
    with pytest.raises(BadInput, match=reason):
        Body((a, b, c), (0, 0, 0), 0)


@pytest.mark.parametrize(
    ("centre", "weight", "free"),
    [
        ((0, 0, 0), 1, True),
        ((1, 2, 3), 0, True),
        ((1, 2, 3), "sqrt(2)*sqrt(3)-sqrt(6)", True),
        (("sin(pi)", 0, 0), 5, True),
        (("1e-1000", 0, 0), "1e-200", False),
        ((0, 0, -1), -1, False),
    ],
)
def test_torque_free_is_decided_exactly(centre, weight, free: bool):
    weighed = number(str(weight))
    body = Body.of_moments([2, 3, 4], vector(*centre), weighed)
    assert body.torque_free is free
    assert not free or body.torque == (0, 0, 0)


def test_axes_that_no_rule_tells_apart_are_refused():
    """A huge flat cone a little off an axis: the products of inertia are beyond all bits."""
    cone = Part("cone", "1e-300", radius="1e4000", height="1e150", at=[0, "1e-300", "1e300"])
    with pytest.raises(BadInput, match="a matrix whose axes 4096 bits tell apart"):
        Body.of_parts([cone], g=1)


# -- test problems that are no bodies, and the bodies that move so ---------------------------------


def refusal_of(moments, **more):
    with pytest.raises(BadInput) as fault:
        Body.of_moments(moments, **more)
    return fault.value.expected


NO_BODIES = {
    ("0.5", "2", "3"): ("5/11, 10/7, 15/8", "1/5"),
    ("2", "1", "2/3"): ("1, 2/3, 1/2", "1/2"),
    ("3", "5", "9"): ("60/23, 4, 180/29", "1/20"),
    ("1", "1", "30"): ("1/2, 1/2, 30/31", "1"),
}


@pytest.mark.parametrize("moments", NO_BODIES)
def test_the_free_body_that_is_named_has_the_same_path_of_the_momentum(moments):
    text, c = NO_BODIES[moments]
    said = refusal_of(moments)
    assert f"of moments {text}, which are 1/(1/I + c) with c = {c}, has the same path" in said
    own = [Fraction(x) for x in moments]
    others = [number(x) for x in text.split(", ")]
    assert others == [1 / (1 / x + Fraction(c)) for x in own]
    start, t = [Fraction(1, 3), Fraction(1), Fraction(-2, 5)], Fraction(3, 2)

    def rate(_, momentum):
        """G' = G × omega with omega = G / I."""
        return [*np.cross(momentum, [x / i for x, i in zip(momentum, theirs, strict=True)])]

    with mpmath.workdps(25):
        theirs, new, at_first = (
            [mpmath.mpf(x.numerator) / x.denominator for x in numbers]
            for numbers in (own, others, start)
        )
        momentum = mpmath.odefun(rate, 0, at_first)(mpmath.mpf("1.5"))
        free = polhode.top(moments=others, momentum=start, at=[t], name="free")
        (state,) = polhode.reference(free).at([t], 25)
        for i, w, g in zip(new, state, momentum, strict=True):
            assert abs(i * w - g) < 1e-22
    for x, i, w in zip(start, own, free.omega, strict=True):  # omega + cG at the start
        assert w == x / i + Fraction(c) * x


@given(st.lists(st.fractions("1e-6", "1e6"), min_size=3, max_size=3))
@example([Fraction(1), Fraction(1, 10**40), Fraction(10**40)])
@example([Fraction(1), Fraction(1), 2 + Fraction(1, 10**9)])
@example([Fraction(10**300), Fraction(10**300), Fraction(10**302)])
def test_a_free_body_is_named_whatever_the_moments(moments):
    assume(2 * max(moments) > sum(moments))
    said = refusal_of(moments)
    c = Fraction(re.search(r" with c = (\S+),", said)[1])
    x, y, z = sorted(1 / (1 / Fraction(moment) + c) for moment in moments)
    assert x + y >= z
    x, y, z = sorted(1 / (1 / Fraction(moment) + c / 10) for moment in moments)
    assert x + y < z or c * max(moments) <= Fraction(1, 9)  # no c far above what is needed


TORQUE = {"centre": [0, 0, 1], "weight": 1}
NO_OTHER = "with a torque of the weight no other body moves so (of free bodies others do)"


@pytest.mark.parametrize(
    ("moments", "more", "words"),
    [
        ([4, 4, 0], {}, "as 4, 4, 2: see lagrange/spherical-pendulum"),
        ([0, 1, 1], {"centre": [2, 0, 0], "weight": 1}, "as 1/2, 1, 1: see"),
        ([1, 1, 0], {"centre": [0, 0, -1], "weight": 1}, "as 1, 1, 1/2: see"),
        ([1, 2, 4], TORQUE, NO_OTHER),
        ([1, 2, 4], {"centre": [0, 0, 1]}, "1/(1/I + c)"),
        # no point on a rod
        ([1, 1, 0], {"centre": [1, 0, 1], "weight": 1}, ""),
        *((moments, {}, "") for moments in ([1, 2, 0], [1, 1, -1], [-1, -1, 0], [1, 0, 0])),
    ],
)
def test_a_body_that_moves_so_is_named_where_there_is_one(moments, more, words):
    said = refusal_of(moments, **more)
    assert words in said
    assert words or "pendulum" not in said

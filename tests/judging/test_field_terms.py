"""Equations with planted errors: each is named, by its term; right ones are right."""

import json

import numpy as np
import pytest

import polhode
from polhode import BadInput
from shared.tools import case_names

INERTIA = np.array([[1.3, 0.1, -0.2], [0.1, 1.1, 0.15], [-0.2, 0.15, 0.9]])
FULL = polhode.top(
    inertia=[[repr(x) for x in row] for row in INERTIA.tolist()],
    centre=["0.1", "0.2", "0.3"],
    weight="1.5",
    omega=["0.5", "1.2", "-0.7"],
    gamma=["0.6", 0, "0.8"],
)
PRINCIPAL = polhode.top(
    moments=["0.9", "1.1", "1.3"],
    centre=["0.1", "0.2", "0.3"],
    weight="1.5",
    omega=[30, "1.2", "-0.7"],
    gamma=["0.6", 0, "0.8"],
)
FREE = polhode.top(moments=[1, 2, 3], weight=0, omega=["0.5", "1.2", "-0.7"])
SCENES = {
    "full": (FULL, INERTIA, 1.5 * np.array([0.1, 0.2, 0.3])),
    "principal": (PRINCIPAL, np.diag([0.9, 1.1, 1.3]), 1.5 * np.array([0.1, 0.2, 0.3])),
    "lagrange": ("lagrange/nutation", np.diag([1, 1, 0.5]), np.array([0, 0, 1.0])),
    "free": (FREE, np.diag([1.0, 2, 3]), np.zeros(3)),
}


def equations(which, gyro=1.0, torque=1.0, turning=1.0, **others):
    """The equations, written out here, with factors and what is added."""
    _, inertia, arm = SCENES[which]
    inertia = others.get("inertia", inertia)
    inverse = others.get("inverse", np.linalg.inv(inertia))

    def f(t, y):
        w, gamma = y[:3], y[3:]
        moment = -gyro * np.cross(w, inertia @ w)
        if len(gamma):
            moment = moment + torque * np.cross(gamma, arm)
        rates = inverse @ moment
        if len(gamma):
            rates = np.concatenate([rates, turning * np.cross(gamma, w)])
        return rates + others.get("more", lambda t, y: 0)(t, y)

    return f


@pytest.mark.parametrize("single", [False, True])
def test_no_more_digits_are_claimed_than_are_told(single):
    # an error of 5e-10 was called right "to 1e-15 of the rates"
    exact, off = equations("lagrange"), equations("lagrange", torque=1 + (0 if single else 5e-10))

    def f(t, y):
        return exact(t, y).astype(np.float32) if single else off(t, y)

    text = str(polhode.compare_field(f, "lagrange/nutation"))
    told = float(text.partition(", to ")[2].split()[0])
    assert 1e-9 <= told < (1e-4 if single else 1.1e-9)


def products(which, signs):
    return {"inertia": SCENES[which][1] * signs}


def unit(k, n=6):
    return np.eye(n)[k]


def normalised(t, y):
    return equations("full")(t, np.concatenate([y[:3], y[3:] / np.linalg.norm(y[3:])]))


PLANTED = {
    "gyroscopic sign": ("full", {"gyro": -1}, ["term -omega x I omega has the other sign"]),
    "no gyroscopic term": ("lagrange", {"gyro": 0}, ["-omega x I omega is missing"]),
    "free, sign": ("free", {"gyro": -1}, ["-omega x I omega has the other sign"]),
    "r0 x gamma": ("full", {"torque": -1}, ["torque Mg gamma x r0 has the other sign"]),
    "g = 1": ("lagrange", {"torque": 1 / 9.81}, ["gamma x r0 is 0.101937 times the right one"]),
    "no torque": ("principal", {"torque": 0}, ["gamma x r0 is missing"]),
    "omega x gamma": ("lagrange", {"turning": -1}, ["gamma' = gamma x omega has the other sign"]),
    "half a turn": ("full", {"turning": 0.5}, ["gamma x omega is half the right one"]),
    "constant": (
        "full",
        {"gyro": 0, "torque": 0},
        ["-omega x I omega is missing", "gamma x r0 is missing"],
    ),
    "two signs": ("principal", {"gyro": -1, "turning": -1}, ["-omega x I omega has", "gamma' = "]),
    "undivided": (
        "full",
        {"inverse": np.eye(3)},
        ["-omega x I omega is not divided by the moments", "r0 is not divided by the moments"],
    ),
    "products": (
        "full",
        products("full", 2 * np.eye(3) - 1),
        ["a body with products of inertia of the other sign (Ixy, Ixz, Iyz)"],
    ),
    "one product": (
        "full",
        products("full", np.array([[1, 1, 1], [1, 1, -1], [1, -1, 1]])),
        ["a body with products of inertia of the other sign (Iyz)"],
    ),
    "moments": (
        "principal",
        {"inertia": np.diag([1.1, 0.9, 1.3])},
        ["a body with the moments A B C = B A C of the scene"],
    ),
    "damping": (
        "lagrange",
        {"more": lambda t, y: -0.01 * y[0] * unit(0)},
        ["p' has a term -0.01 in p, not in the equations"],
    ),
    "push": (
        "full",
        {"more": lambda t, y: 0.25 * unit(1)},
        ["q' has a term 0.25, not in the equations"],
    ),
    "one sign": (
        "lagrange",
        {"more": lambda t, y: -2 * y[1] * y[3] * unit(5)},  # gamma3' has q gamma1 - p gamma2
        ["gamma3': the term in q gamma1 has the other sign, -1 for 1"],
    ),
    "one missing": (
        "lagrange",
        {"more": lambda t, y: y[4] * y[0] * unit(5)},
        ["gamma3': the term in p gamma2 is missing"],
    ),
}


@pytest.mark.parametrize("name", PLANTED)
def test_a_planted_error_is_named(name):
    which, how, words = PLANTED[name]
    comparison = polhode.compare_field(equations(which, **how), SCENES[which][0])
    assert not comparison.right
    assert comparison.polynomial
    assert len(comparison.terms) == len(words), comparison.terms
    for term, expected in zip(comparison.terms, words, strict=True):
        assert expected in term
    assert str(comparison).splitlines()[1:] == list(comparison.terms)
    assert comparison.differences


@pytest.mark.parametrize("which", SCENES)
def test_right_equations_are_right(which):
    scene = SCENES[which][0]
    for f in (equations(which), polhode.field(scene), lambda t, y: [*equations(which)(t, y)]):
        comparison = polhode.compare_field(f, scene)
        assert (comparison.right, comparison.terms, comparison.differences) == (True, (), ())
        assert comparison.residual < 1e-14
    single = polhode.compare_field(lambda t, y: np.float32(equations(which)(t, y)), scene)
    assert single.right
    assert 1e-9 < single.residual < 1e-6


def test_every_case_has_its_own_equations():
    for name in case_names()[::9]:
        assert polhode.compare_field(polhode.field(name), name).right, name


def small(moments, arm):
    """A body whose terms, not divided by its moments, are a billionth of the right ones."""
    moments = 1e-9 * np.array(moments)
    scene = polhode.top(
        moments=[repr(x) for x in moments.tolist()],
        centre=arm,
        weight="1e-9",
        omega=["0.5", "1.2", "-0.7"],
        gamma=["0.6", 0, "0.8"],
    )
    return scene, moments, 1e-9 * np.array(arm)


@pytest.mark.parametrize("power", [-1, 0, 1])
@pytest.mark.parametrize("moments", [[0.9, 1.1, 1.3], [1.3, 1.3, 0.9]])
@pytest.mark.parametrize("arm", [[0, 0, 1], [1, 2, -1]])
def test_undivided_terms_are_named_in_any_unit_and_of_symmetric_bodies(moments, arm, power):
    """Rounding of rates that are far too large was taken for terms, and of A = B the missing
    division for a factor."""
    scene, I, arm = small(moments, arm)

    def f(t, y):
        torque = np.cross(y[3:], arm) - np.cross(y[:3], I * y[:3])
        return np.concatenate([torque * I**power, np.cross(y[3:], y[:3])])

    comparison = polhode.compare_field(f, scene)
    assert comparison.right == (power == -1)
    assert all("-omega x I omega" in term or "torque Mg" in term for term in comparison.terms)
    assert len(comparison.terms) == (0 if power == -1 else 2)
    if power == 0:
        assert all("not divided by the moments" in term for term in comparison.terms)


def test_a_full_inertia_along_axes_in_another_order_is_named():
    """Its coefficients were listed, a dozen and more."""
    reordered = INERTIA[np.ix_([1, 2, 0], [1, 2, 0])]
    comparison = polhode.compare_field(equations("full", inertia=reordered), FULL)
    words = "a body with an inertia whose axes x y z are y z x of the scene's"
    assert comparison.terms == (f"the equations are those of {words}",)


def test_gamma_of_length_one_is_one():
    """A program may normalise; between its states that is nothing."""
    assert polhode.compare_field(normalised, FULL).right


@pytest.mark.parametrize("factor", [1, 1 + 1e-8, 1 + 1e-10])
def test_a_coefficient_counts_from_a_billionth_on(factor):
    comparison = polhode.compare_field(equations("lagrange", torque=factor), "lagrange/nutation")
    assert comparison.right == (factor - 1 < 1e-9)


def test_momentum():
    def f(sign):
        def rates(t, y):
            w = np.linalg.solve(INERTIA, y[:3])
            first = np.cross(y[:3], w) + sign * np.cross(y[3:], 1.5 * np.array([0.1, 0.2, 0.3]))
            return np.concatenate([first, np.cross(y[3:], w)])

        return rates

    assert polhode.compare_field(f(1), FULL, "momentum").right
    comparison = polhode.compare_field(f(-1), FULL, "momentum")
    assert comparison.terms == ("the torque Mg gamma x r0 has the other sign",)
    assert {difference.rate for difference in comparison.differences} == {"G1'", "G2'", "G3'"}
    assert not polhode.compare_field(f(1), FULL).right


def test_what_is_no_polynomial_and_what_depends_on_time_is_told():
    cubic = equations("full", more=lambda t, y: -0.1 * np.linalg.norm(y[:3]) * y[0] * unit(0))
    comparison = polhode.compare_field(cubic, FULL)
    assert (comparison.right, comparison.polynomial) == (False, False)
    assert comparison.terms[0].startswith("f is no polynomial of degree two in p q r gamma1")
    driven = polhode.compare_field(equations("full", more=lambda t, y: 0.1 * t * unit(2)), FULL)
    assert driven.terms == ("f depends on t",)


def test_coefficients_are_those_of_f():
    comparison = polhode.compare_field(equations("lagrange", torque=2), "lagrange/nutation")
    coefficients = {(x.rate, x.term): (x.right, x.coefficient) for x in comparison.differences}
    assert coefficients.keys() == {("p'", "gamma2"), ("q'", "gamma1")}
    assert coefficients["p'", "gamma2"] == pytest.approx((1, 2), rel=1e-13)
    assert coefficients["q'", "gamma1"] == pytest.approx((-1, -2), rel=1e-13)
    answer = json.loads(comparison.to_json())
    assert answer["columns"]["term"] == ["gamma2", "gamma1"]
    assert (answer["right"], answer["terms"]) == (False, [*comparison.terms])


@pytest.mark.parametrize(
    ("f", "words"),
    [
        (3, "f = 3: expected a function f(t, y)"),
        (lambda t, y: y[:3], "expected 6 finite numbers, the rates of p q r gamma1"),
        (lambda t, y: y * np.nan, "expected 6 finite numbers"),
        (lambda t, y: "x", "expected 6 finite numbers"),
        (lambda t, y: None, "expected 6 finite numbers"),
    ],
)
def test_what_is_no_field_is_refused(f, words):
    with pytest.raises(BadInput) as refused:
        polhode.compare_field(f, FULL)
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


def test_unknown_variables_are_refused():
    with pytest.raises(BadInput, match="variables = angles: expected omega or momentum"):
        polhode.compare_field(polhode.field(FULL), FULL, "angles")

"""The equations as data say what the vectors say, exactly, and so does what is made of them."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import mpmath
import numpy as np
import pytest

import polhode
from polhode.enclosures import fixed_point_problem, step_bound, task, taylor_polynomials, zonotope
from polhode.equations import terms
from polhode.taylor.projection import staying_zero


def test_a_plane_that_is_kept_is_found_among_generic_numbers() -> None:
    # A pendulum about its second axis: p, r and gamma2 stay 0, and nothing else does.
    body = polhode.Body.of_moments([3, 2, 1], centre=[1, 0, 2], weight=1)
    state = [Fraction(0), Fraction(1), Fraction(0), Fraction(3, 5), Fraction(0), Fraction(4, 5)]
    assert staying_zero(body, state) == {0, 2, 4}
    assert staying_zero(body, [*state[:4], Fraction(1, 7), state[5]]) == set()


def test_a_body_is_replaced_but_for_what_is_given() -> None:
    cone = polhode.Body.of_parts([polhode.Part("cone", 1, radius=3, height=4)], g="9.8")
    heavier = cone.replaced(weight=2 * cone.weight)
    assert heavier.parts == cone.parts
    assert heavier.inertia == cone.inertia
    assert heavier.torque[2] == 2 * cone.torque[2]
    moved = cone.replaced(centre=(Fraction(0), Fraction(0), Fraction(1)))
    assert moved.parts == ()
    assert (moved.inertia, moved.weight) == (cone.inertia, cone.weight)
    with pytest.raises(polhode.BadInput, match="sum of the others"):
        cone.replaced(inertia=((1, 0, 0), (0, 1, 0), (0, 0, 3)))  # type: ignore[arg-type]


def test_a_door_refuses_what_it_does_not_take() -> None:
    scene = replace(
        polhode.load("lagrange/nutation"),
        outputs=("angles", "attitude"),
        events=(polhode.Event("nutation"),),
        form="momentum",
    )
    assert polhode.load(scene) is scene
    assert polhode.load(scene, takes=("outputs", "events", "form")) is scene
    for takes, said in (
        (("events", "form"), "outputs = angles, attitude: expected none, or polhode.integrate"),
        (("outputs", "form"), "events = nutation: expected none, or polhode.integrate"),
        (("outputs", "events"), "run.form = momentum: expected principal, or polhode.integrate"),
    ):
        with pytest.raises(polhode.BadInput, match=said):
            polhode.load(scene, takes=takes)


def test_a_sum_in_the_derivative_is_not_proven(monkeypatch: pytest.MonkeyPatch) -> None:
    # A term in q beside that in q r: an entry would be rounded once more than is bounded.
    beside = terms.Slope(0, 1, terms.Term(0, (1,), 0), None)
    motion = fixed_point_problem.motion(polhode.load("general/asymmetric-regular"))
    problem = fixed_point_problem.problem(motion, 60)
    state = zonotope.beginning(problem)
    window = task.HONEST.window(problem, state, 1 << 12, 1, 1.0)
    assert window is not None
    pieces = taylor_polynomials.of_doubles(window.times, window.series)
    usual = taylor_polynomials.defects(problem, pieces)
    start = np.zeros(pieces.near.shape), np.eye(6)[None, None].repeat(pieces.count, 0)
    assert np.all(np.isfinite(step_bound.bounds(problem, usual, *start).alpha))
    monkeypatch.setattr(step_bound, "SLOPES", (*terms.SLOPES, beside))
    with pytest.raises(fixed_point_problem.TooImprecise, match="entries are sums"):
        step_bound.bounds(problem, usual, *start)
    spared = replace(problem, factors=(0.0, *problem.factors[1:]))
    spared = replace(spared, factor_slack=(0.0, *problem.factor_slack[1:]))
    assert np.all(np.isfinite(step_bound.bounds(spared, usual, *start).alpha))


@pytest.mark.parametrize(
    "name", ["lagrange/turned-axes", "kovalevskaya/generic", "euler/separatrix"]
)
def test_the_rates_are_those_of_the_closed_form(name):
    """By central differences of 40 digits, at t = 1/2."""
    exact = polhode.reference(name)
    with mpmath.workdps(40):
        step = mpmath.mpf(10) ** -12
        ahead, here, back = exact.at([0.5 + step, 0.5, 0.5 - step], 40)
        rates = np.array([float((a - b) / (2 * step)) for a, b in zip(ahead, back, strict=True)])
    f = polhode.field(name)
    own = f(0.5, [float(x) for x in here])
    assert np.max(np.abs(own - rates)) < 64 * 2.0**-52 * max(1.0, np.max(np.abs(rates)))
    both = f(0, np.array([here, here], dtype=float).T)
    assert both.shape == (len(here), 2)
    assert np.max(np.abs(both[:, 0] - own)) < 8 * 2.0**-52 * max(1.0, np.max(np.abs(own)))


def test_a_scene_without_gamma_has_three_rates():
    f = polhode.field(polhode.top(moments=[1, 2, 3], omega=[1, 2, 3]))
    assert f(0, f.start).tolist() == [-6.0, 3.0, pytest.approx(-2 / 3, rel=2 * 2.0**-52)]

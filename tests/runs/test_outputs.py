"""Angles and attitude of runs against closed forms, for every case that asks for them."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import pytest

import polhode
from polhode.closed_forms.families import FAMILIES
from polhode.numbers import conversion
from polhode.numbers.conversion import exactly
from polhode.numbers.mpmath_context import mpmath
from polhode.scenes import library
from shared.policies import change_policy

#: The folder of a family holds what has that closed form: see ``checks/test_regression.py``.
FAMILY = {family.name for family in FAMILIES}
CASES = [
    name
    for name in library.names()
    if "outputs" in (library.folder() / f"{name}.toml").read_text()
    and polhode.load(name).outputs
    and (name.partition("/")[0] in FAMILY or polhode.reference(name).is_closed_form)
]


def worst_error(mine, exact) -> float:
    """The largest difference; a value that one side leaves undefined must be so on both."""
    worst = mpmath.mpf(0)
    with mpmath.workprec(200):
        for row, true in zip(mine, exact, strict=True):
            for x, y in zip(row, true, strict=True):
                assert (x is None) == (y is None)
                if x is not None:
                    worst = max(worst, abs(conversion.to_mpf(exactly(x), 200) - y))
        return float(worst)


@pytest.mark.sample(7)
@pytest.mark.parametrize("name", CASES)
def test_outputs_of_a_run_are_those_of_the_closed_form(name):
    """In quad at a few times, 300 radians: absolute errors as small as the state's allow."""
    scene = polhode.load(name)
    truth = polhode.reference(scene)
    end = min(abs(scene.end), 10, Fraction(300) / Fraction(10) ** math.ceil(scene.log10_rate))
    end *= 1 if scene.end > 0 else -1
    scene = replace(scene, times=tuple(end * Fraction(k, 7) for k in range(8)))
    run = polhode.integrate(scene, "quad")
    state = 10.0 ** -min(polhode.compare(run, truth).digits)
    bound = 1e4 * max(state, 1e-33)
    assert (run.attitude is not None) == bool({"attitude", "hodographs"} & set(scene.outputs))
    assert (run.angles is not None) == ("angles" in scene.outputs)
    if "attitude" in scene.modelled:
        assert worst_error(run.attitude, truth.attitude(run.times, 40)) < bound
    if "angles" in scene.modelled:
        assert worst_error(run.angles, truth.angles(run.times, 40)) < bound


@pytest.mark.sample(1)
@pytest.mark.parametrize("project", [False, None])
@pytest.mark.parametrize("number", ["double", "extended"])
def test_angles_that_grow_loosen_no_step(number, project, monkeypatch):
    """phi of a fast top grows to thousands of radians, and steps are as accurate as the largest
    variable asks: its state would lose as many digits.  Chunks end between two set-backs."""
    change_policy(monkeypatch, chunk=1000)
    scene = polhode.load("hard/fast-top").at((Fraction(1, 2), Fraction(1)))
    alone = polhode.integrate(replace(scene, outputs=()), number, project=project)
    along = polhode.integrate(scene, number, project=project)
    assert along.steps >= alone.steps > 5000
    truth = polhode.reference(scene)
    digits = [min(polhode.compare(run, truth).digits) for run in (along, alone)]
    assert digits[0] > digits[1] - 0.5
    assert abs(along(along.times)[1] - along.states[1])[3:].max() < 1e4 * along.number.eps
    for row, true in zip(along.angles, truth.angles(along.times, 40), strict=True):
        ulp = float(true[2]) * float(along.number.eps)
        assert float(abs(conversion.to_mpf(exactly(row[2]), 200) - true[2])) < 4 * ulp
        assert float(abs(conversion.to_mpf(exactly(row[0]), 200) - true[0])) < 100 * float(
            along.number.eps
        )


@pytest.mark.parametrize("number", ["quad", "mp"])
def test_angles_keep_their_whole_in_wide_types(number):
    """Several set-backs of the angles, an end before the start, psi not 0 at the start."""
    scene = replace(polhode.load("lagrange/looping"), psi=Fraction(22, 7))
    scene = scene.at((Fraction(-3), Fraction(-6)))
    run = polhode.integrate(scene, number)
    assert run.steps > 16
    assert worst_error(run.angles, polhode.reference(scene).angles(run.times, 70)) < 1e3 * float(
        run.number.eps
    )


@pytest.mark.parametrize("asked", [{"number": "quad"}, {"digits": 50}])
def test_what_is_zero_at_the_start_of_a_turned_body_is_zero(asked):
    """Through the principal axes and back it would be 1e-35, or 1e-56."""
    scene = polhode.top(
        inertia=[[2, "1/3", "1/7"], ["1/3", 3, "1/5"], ["1/7", "1/5", 2]],
        centre=[0, 0, 1],
        weight=1,
        angles=[0, "pi/6", 0],
        rates=[0, 0, 3],
        outputs=["angles"],
        at=[0, 1],
    )
    run = polhode.integrate(scene, **asked)
    assert run.states[0].tolist()[:4] == [0, 0, 3, 0]
    assert run["phi"][0] == run["psi"][0] == 0
    assert (run(0) == run.states[0]).all()
    assert 0 < abs(run.states[1, 0]) < 1
    vary = {"start.rates[3]": [3, 4]}
    many = polhode.integrate_many(scene, vary, **asked)
    for k, spin in enumerate((3, 4)):
        assert many.states[k, 0].tolist()[:4] == [0, 0, spin, 0]

"""The sign of the quaternion at t = 0: its first component that is not 0 is positive."""

from __future__ import annotations

from dataclasses import replace

import pytest

import polhode

ZERO = 1e-15
LAGRANGE = {"moments": [1, 1, 2], "centre": [0, 0, 1], "weight": 1}
BODIES = {
    "lagrange": LAGRANGE,
    "euler": {"moments": [1, 2, 3]},
    "kovalevskaya": {"moments": [2, 2, 1], "centre": [1, 0, 0], "weight": 1},
    "general": {"moments": [2, "1.5", 1], "centre": ["0.3", "0.2", "0.5"], "weight": 1},
}
#: A start with q0 = 0, and the quaternion's signs.
STARTS = [
    ({"angles": ["pi", 0, 0]}, "000+"),
    ({"angles": ["-pi", 0, 0]}, "000+"),
    ({"angles": [0, "pi", 0]}, "0+00"),
    ({"angles": ["-pi/3", "pi", 0]}, "0+-0"),
    ({"angles": ["pi/2", 1, "pi/2"]}, "0+0+"),
    ({"angles": ["-pi/2", 1, "-pi/2"]}, "0+0-"),
    ({"angles": ["-pi", 1, 0]}, "00++"),
    ({"angles": ["pi/2 + sqrt(2)", 1, "pi/2 - sqrt(2)"]}, "0+++"),
    ({"quaternion": [0, "-3/5", "4/5", 0]}, "0+-0"),
    ({"quaternion": [0, 0, "-3/5", "4/5"]}, "00+-"),
    ({"quaternion": [0, 0, 0, -1]}, "000+"),
]


def signs(row) -> str:
    return "".join("0" if abs(x) < ZERO else "+" if x > 0 else "-" for x in row)


def scene(body: dict, start: dict):
    """One body from one start, with its attitude."""
    omega = ["0.3", "0.2", "1.1"]
    return polhode.top(**body, **start, omega=omega, end=1, samples=2, outputs=["attitude"])


@pytest.mark.sample(4, slow=4)
@pytest.mark.parametrize("body", [*BODIES])
@pytest.mark.parametrize(("start", "expected"), STARTS, ids=str)
def test_runs_of_every_type_and_references_agree_where_q0_is_0(body, start, expected):
    """So do runs in the quaternion form, and the closed form if there is one."""
    made = scene(BODIES[body], start)
    found = {"form": polhode.integrate(replace(made, form="quaternion"), at=[0]).attitude[0]}
    for number in ("double", "extended", "quad", "mp"):
        found[number] = polhode.integrate(made, number, at=[0]).attitude[0]
    if body != "general":
        found["reference"] = polhode.reference(made).attitude([0], 20)[0]
    assert {name: signs(row) for name, row in found.items()} == dict.fromkeys(found, expected)


@pytest.mark.slow
@pytest.mark.parametrize("body", ["lagrange", "general"])
def test_the_sign_stays_that_of_the_start(body):
    """Later on, refined runs, enclosures and dense output have no sign of their own."""
    made = scene(BODIES[body], {"angles": ["-pi/2", 1, "-pi/2"]})
    run = polhode.integrate(made, at=[0, 1])
    later = run.attitude[1]
    others = {
        "extended": polhode.integrate(made, "extended", at=[0, 1]).attitude[1],
        "refined": polhode.integrate(made, "quad", method="refined", at=[0, 1]).attitude[1],
        "taylor": polhode.integrate(made, "quad", method="taylor", at=[0, 1]).attitude[1],
        "dense": run.attitude_at([1])[0],
        "reference": polhode.reference(made).attitude([1], 20)[0],
    }
    assert max(map(abs, later)) > 0.5
    for row in others.values():
        assert max(abs(float(x) - float(y)) for x, y in zip(row, later, strict=True)) < 1e-13


@pytest.mark.parametrize(("side", "last"), [("+", "-"), ("-", "+")])
@pytest.mark.parametrize("digits", [60, 700, 1200])
def test_a_component_that_is_hardly_not_0_decides(digits, side, last):
    """cos(psi/2) at psi = pi +- 10^-digits: of a run and a closed form the same."""
    made = scene(LAGRANGE, {"angles": [f"pi {side} 1e-{digits}", 1, 0]})
    assert signs(polhode.integrate(made, "mp", at=[0]).attitude[0])[3] == last
    assert signs(polhode.reference(made).attitude([0], 20)[0])[3] == last


def test_a_run_in_extended_may_be_its_start_alone():
    run = polhode.integrate("lagrange/nutation", "extended", at=[0])
    assert run.times == (0,)
    assert run(0)[0] == run.states[0][0]

"""The branch of psi and phi of a start at a pole: runs, closed forms and proofs count alike.

Where phi's limit is +-pi both are right; one rule decides, and a run's angles are not a turn off.
"""

import math

import pytest

import polhode
from polhode.equations.pole_passage import phi_leaving_the_pole
from polhode.scenes import scene_file

TOP, BRICK, ASKEW = "[1, 1, 0.5]", "[1.2, 1, 0.5]", "[0.2, 0.3, 1]"


def scene(omega, up, end, moments=TOP, centre="[0, 0, 1]"):
    return scene_file.parse(
        f"schema = 1\n[body]\nmoments = {moments}\ncentre = {centre}\nweight = 1\n"
        f"[start]\nomega = {omega}\ngamma = [0, 0, {up}]\n[run]\nend = {end}\nsamples = 2\n"
        "outputs = ['angles']\n"
    )


STARTS = {
    "upper, phi falls": ("[-1, 0, 2]", 1, 1),
    "upper, phi rises": ("[-1, 0, -2]", 1, 1),
    "upper, back": ("[1, 0, 2]", 1, -1),
    "lower, phi falls": ("[1, 0, 2]", -1, 1),
    "lower, back": ("[-1, 0, -2]", -1, -1),
    "a swing": ("[-1, 0, 0]", 1, 1, BRICK),
    "proven": ("[-1, 0, 2]", -1, -1, BRICK, ASKEW),
    "proven, upper": ("[-1, 0, -2]", 1, 1, BRICK, ASKEW),
    "released": ("[0, 0, 0]", 1, 1, "[4, 4, 1]", "[0, -1, 0]"),
}
SLOW = {"released"}


@pytest.mark.sample(4)
@pytest.mark.parametrize(
    "name", [pytest.param(x, marks=[pytest.mark.slow] * (x in SLOW)) for x in STARTS]
)
def test_a_run_counts_as_its_reference_does(name):
    start = scene(*STARTS[name])
    (true,) = polhode.reference(start).angles([start.end], 15)
    got = polhode.integrate(start).angles[-1]
    assert max(abs(float(x) - float(y)) for x, y in zip(true, got, strict=True)) < 1e-11


@pytest.mark.parametrize(
    ("omega", "up", "sense", "expected"),
    [
        ("[-1, 0, 7]", 1, 1, -math.pi),
        ("[-1, 0, 7]", -1, -1, math.pi),
        ("[1, 0, 7]", 1, 1, 0.0),
        ("[0, 1, 7]", 1, 1, -math.pi / 2),
        ("[0, 1, 7]", 1, -1, math.pi / 2),
        ("[0, 1, 7]", -1, 1, math.pi / 2),
        ("['-1e-400', '1e-400', 7]", 1, 1, -3 * math.pi / 4),
    ],
)
def test_the_limit_of_phi(omega, up, sense, expected):
    assert phi_leaving_the_pole(scene(omega, up, 1), sense) == expected


@pytest.mark.parametrize("sense", [1, -1])
def test_without_w_across_the_limit_is_that_of_its_rate(sense):
    """gamma'' = gamma x w', w' = I^-1 (gamma x Mg r0): for r0 = -e2, gamma = e3, w' = e1/A."""
    at_rest = scene("[0, 0, 0]", 1, 1, "[4, 4, 1]", "[0, -1, 0]")
    assert phi_leaving_the_pole(at_rest, sense) == 0.0
    other = scene("[0, 0, 0]", 1, 1, "[4, 4, 1]", "[1, 0, 0]")  # w' = e2/A
    assert phi_leaving_the_pole(other, sense) == -math.pi / 2

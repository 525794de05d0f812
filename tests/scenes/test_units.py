"""Scenes with units: every key knows its own."""

from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.common.errors import BadInput
from polhode.scenes import keys, scene_file

TEXT = """
schema = 1
[body]
moments = ["20 kg*cm**2", "20 kg cm**2", "0.001 kg m**2"]
centre  = [0, 0, "5 cm"]
mass    = "200 g"
g       = "9.81 m/s**2"
[start]
angles = [0, "30 deg", 0]
rates  = [0, 0, "600 rpm"]
[run]
end = "250 ms"
samples = 3
"""
PLAIN = """
schema = 1
[body]
moments = [0.002, 0.002, 0.001]
centre  = [0, 0, 0.05]
mass    = 0.2
g       = 9.81
[start]
angles = [0, "pi/6", 0]
rates  = [0, 0, "20*pi"]
[run]
end = 0.25
samples = 3
"""


def test_a_scene_with_units_is_the_scene_in_si():
    found, plain = scene_file.parse(TEXT), scene_file.parse(PLAIN)
    assert found.units == "SI"
    assert plain.units == ""
    assert (found.body, found.omega, found.gamma) == (plain.body, plain.omega, plain.gamma)
    assert found.times == plain.times
    assert np.array_equal(polhode.integrate(found).states, polhode.integrate(plain).states)


def test_units_survive_other_times():
    scene = scene_file.parse(TEXT).at([1, 2])
    text = polhode.as_toml(scene)
    assert 'units = "SI"' in text
    assert '"600 rpm"' in text
    assert scene_file.parse(text).units == "SI"


def test_python_takes_units_too():
    top = polhode.top(
        moments=[1, 1, "500 g m**2"], omega=["1 rev/s", 0, 1], end="1 min", units="SI"
    )
    assert top.body.moments[2] == Fraction(1, 2)
    assert float(top.omega[0]) == 2 * np.pi
    assert top.end == 60


def test_a_sweep_takes_units():
    many = polhode.integrate_many(
        "lagrange/nutation", vary={"start.omega[3]": "60 rpm:120 rpm:2"}, at=[0]
    )
    spins = [float(x) for x, *_ in many.varied.rows]
    assert spins == [2 * np.pi, 4 * np.pi]


@pytest.mark.parametrize(
    ("given", "key"),
    [
        ({"omega": ["5 cm", 0, 0]}, "start.omega.*in m, not in rad/s"),
        ({"moments": ["2 kg", 2, 1]}, "body.moments.*in kg, not in kg"),
        ({"centre": [0, 0, "1 s"]}, "body.centre.*in s, not in m"),
        ({"weight": "1 kg"}, r"body.weight.*in kg, not in N"),
        ({"gamma": ["90 deg", 0, 0]}, "start.gamma.*no unit belongs"),
        ({"end": "10 m"}, "run.end.*in m, not in s"),
        ({"units": "cgs"}, "units = cgs: expected SI"),
    ],
)
def test_a_wrong_dimension_is_one_line(given, key):
    right = {"moments": [2, 2, 1], "centre": [0, 0, 1], "weight": 1, "omega": [0, 0, 1]}
    right |= {"gamma": [0, 0, 1], "end": 1}
    with pytest.raises(BadInput, match=key):
        polhode.top(**(right | given))


def test_every_unit_in_the_table_of_keys_is_one():
    from polhode.numbers.quantity import Quantity, quantity

    units = [key.unit for section in keys.KEYS.values() for key in section if key.unit]
    assert len(units) > 20
    assert all(isinstance(quantity(unit), Quantity) for unit in units)
    assert keys.unit("body.parts[2].size[1]") == "m"
    assert keys.unit("run.at[17]") == "s"
    assert keys.unit("start.gamma[1]") == ""
    assert keys.unit("nowhere") == ""


@pytest.mark.parametrize("gamma", [[0.6, 0, 0.8], np.array([0.6, 0.0, 0.8]), (1 / 3, 2 / 3, 2 / 3)])
def test_floats_of_length_one_but_for_rounding_are_normalised(gamma):
    top = polhode.top(moments=[2, 2, 1], centre=[0, 0, 1], weight=1, omega=[1, 0, 0], gamma=gamma)
    assert sum(x * x for x in top.gamma) == 1
    assert "normalise = true" in polhode.as_toml(top)


@pytest.mark.parametrize(
    "gamma", [[0.6, 0, 0.8 + 1e-14], ["0.6", 0, "0.80000000000000001"], np.float32([0.6, 0, 0.8])]
)
def test_what_is_not_of_length_one_is_refused(gamma):
    given = {"moments": [2, 2, 1], "omega": [1, 0, 0], "gamma": gamma}
    with pytest.raises(BadInput, match="normalise"):
        polhode.top(**given)


def test_exact_floats_are_left_as_they_are():
    top = polhode.top(moments=[2, 2, 1], omega=[1, 0, 0], gamma=[0.0, 1.0, 0])
    assert "normalise" not in polhode.as_toml(top)


def test_an_unknown_argument_is_one_line_with_the_nearest():
    with pytest.raises(BadInput, match=r"moment = \[2, 2, 1\].*did you mean 'moments'"):
        polhode.top(moment=[2, 2, 1], omega=[1, 0, 0])

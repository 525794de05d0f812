"""Scenes with units: every key knows its own."""

from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode import BadInput
from polhode.cli import main
from shared.motions import scene_of

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


def test_a_scene_with_units_is_the_scene_in_si():
    body = {"moments": ["0.002", "0.002", "0.001"], "mass": "0.2", "g": "9.81"}
    start = {"centre": [0, 0, "0.05"], "angles": [0, "pi/6", 0], "rates": [0, 0, "20*pi"]}
    with_units, plain = scene_of(TEXT), polhode.top(**body, **start, end="0.25", samples=3)
    assert (with_units.units, plain.units) == ("SI", "")
    assert with_units.body == plain.body
    assert (with_units.omega, with_units.gamma) == (plain.omega, plain.gamma)
    assert with_units.times == plain.times
    text = polhode.as_toml(with_units.at([1, 2]))  # units survive other times
    assert '"600 rpm"' in text
    assert scene_of(text).units == "SI"
    top = polhode.top(moments=[1, 1, "500 g m**2"], omega=["1 rev/s", 0, 1], end="1 min")
    assert (top.body.moments[2], float(top.omega[0]), top.end) == (Fraction(1, 2), 2 * np.pi, 60)


@pytest.mark.parametrize(
    ("unit", "keys"),
    [
        ("", {"angles": [0, "25°", 0], "rates": [0, 0, 5]}),
        ("", {"angles": ["90 deg", "25 degrees", "pi/6"], "rates": [0, 0, 5]}),
        ("SI", {"angles": [0, "25°", 0], "rates": [0, 0, "5 °/s"]}),
        ("SI", {"angles": [0, "25°", 0], "rates": [0, 0, "5 s⁻¹"]}),
        ("SI", {"angles": [0, "25°", 0], "rates": [0, 0, 5], "end": "1 hr"}),
    ],
)
def test_an_angle_alone_makes_no_scene_in_si(unit, keys):
    scene = polhode.top(moments=[1, 1, 0.5], centre=[0, 0, 1], weight=1, **keys)
    assert scene.units == unit == scene_of(scene.source, "top").units
    assert float(scene.gamma[2]) == pytest.approx(np.cos(np.radians(25)), rel=4e-16)


def _in_si(**more):
    keys = {"moments": [2, 2, 1], "centre": [0, 0, "10 cm"], "weight": 1, "gamma": [0.6, 0, 0.8]}
    return polhode.top(**keys, omega=[0, 0, 1], end=1, **more)


def test_numbers_given_beside_a_scene_in_si_have_units_too():
    scene = _in_si()
    for column in ("60 rpm:120 rpm:2", ["1 rev/s", "120 rpm"]):
        many = polhode.integrate_many(scene, vary={"start.omega[3]": column}, at=["0 ms"])
        assert [float(x) for x, *_ in many.varied.rows] == [2 * np.pi, 4 * np.pi]
    run = polhode.integrate(scene, at=["100 ms", "1/2 s"])
    assert run.times == (Fraction(float("0.1")), Fraction(1, 2))
    assert (run("500 ms") == run(0.5)).all()
    exact = polhode.reference(scene)
    assert exact.at(["1 ms"], 20) == exact.at(["0.001"], 20)
    assert polhode.certify(scene, at=["10 ms"]).times == (Fraction(1, 100),)
    assert polhode.frequencies(scene, of=["gamma3"], end="1 min").end == 60
    level = {"starts": [[1, 0.2]], "crossings": 2}
    assert polhode.section(scene, h="600 mJ", f="0.8 kg m**2/s", **level) == polhode.section(
        scene, h="0.6", f="0.8", **level
    )


def test_a_range_has_a_unit_at_both_ends_or_at_neither():
    """``500:600 rpm`` was a range from 500 rad/s; 0 is 0 in any unit."""
    for column in ("500:600 rpm:3", "60 rpm:2*pi:2", "1,500:600 rpm:3"):
        with pytest.raises(BadInput, match="expected a unit at FROM and at TO, or at neither"):
            polhode.integrate_many(_in_si(), vary={"start.omega[3]": column}, at=[0])
    for column in ("0:60 rpm:2", "-60 rpm:0:2", "0 rpm:2*pi:2"):
        many = polhode.integrate_many(_in_si(), vary={"start.omega[3]": column}, at=[0])
        assert sum(abs(float(x)) for x, *_ in many.varied.rows) == 2 * np.pi


def test_where_a_scene_has_no_units_a_number_beside_it_has_none_but_an_angles():
    vary = {"start.psi": "90°:180 deg:2"}
    many = polhode.integrate_many("lagrange/nutation", vary=vary, at=[0])
    assert [float(x) for x, *_ in many.varied.rows] == [np.pi / 2, np.pi]
    scene = polhode.load("lagrange/nutation")
    refused = [
        lambda: polhode.integrate_many(scene, vary={"start.omega[3]": "1 rpm:2 rpm:2"}, at=[0]),
        lambda: polhode.integrate_many(scene, vary={"start.omega[3]": ["1 rpm"]}, at=[0]),
        lambda: polhode.integrate(scene, at=["1 s"]),
        lambda: polhode.orbit(scene, period="1 s"),
        lambda: polhode.reference(scene).at(["1 s"]),
    ]
    for call in refused:
        with pytest.raises(BadInput, match='the scene has none; units = "SI" in it says'):
            call()


@pytest.mark.parametrize("verb", ["run", "reference", "frequencies"])
def test_times_in_options_have_units(verb, tmp_path, capsys):
    path = tmp_path / "si.toml"
    path.write_text(polhode.as_toml(_in_si()))
    option = "--end" if verb == "frequencies" else "--at"
    assert main([verb, str(path), option, "1000 ms"]) == 0
    capsys.readouterr()
    assert main([verb, str(path), option, "1 kg"]) == 2
    assert "in kg, not in s" in capsys.readouterr().err


def test_a_part_with_units_makes_a_scene_in_si():
    cone = polhode.Part("cone", mass="50 g", radius="3 cm", height="1/20 m")
    assert (cone.mass, cone.radius, cone.units) == (Fraction(1, 20), Fraction(3, 100), "SI")
    scene = polhode.top(parts=[cone], g=10, omega=[0, 0, 1], gamma=[0, 0, 1])
    assert scene.units == "SI"
    plain = polhode.Part("cone", mass=1, radius=1, height=1)
    assert polhode.top(parts=[plain], g=1, omega=[0, 0, 1], gamma=[0, 0, 1]).units == ""

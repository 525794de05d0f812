"""Scenes from people's numbers: in Python and in files, what is the same and what is refused."""

import copy
import pickle
import re
from dataclasses import dataclass, replace
from fractions import Fraction

import mpmath
import numpy as np
import pytest

import polhode
from polhode.scenes import vocabulary
from shared.motions import scene_of
from shared.tools import case_names

EPS = np.finfo(float).eps
FREE = {"moments": [1, 2, 2.5], "omega": [0.1, 1, 0]}


def test_floats_arrays_and_fractions_are_taken_exactly():
    scene = polhode.top(
        moments=np.array([1, 1, 0.3]),
        centre=(0, 0, np.float32(0.1)),
        weight=mpmath.mpf(0.1),
        omega=[Fraction(1, 3), 0.1, "0.1"],
        gamma=[0, 0, 1],
        at=np.linspace(0, 1, 4),
    )
    assert scene.body.moments[2] == Fraction(0.3)
    assert scene.body.centre[2] == Fraction(float(np.float32(0.1)))
    assert scene.omega == (Fraction(1, 3), Fraction(0.1), Fraction(1, 10))
    assert scene.times == tuple(Fraction(float(t)) for t in np.linspace(0, 1, 4))
    assert "# the doubles 0.3 in full" in polhode.as_toml(scene)
    assert scene.body.weight == Fraction(0.1) != Fraction(1, 10)
    assert polhode.top(**FREE, end=np.array(3.0)).times == (0, 3)


ODD = [5e-324, 1.7e308, 2.0**-1074 * 3, 1e22, 0.1, -1e-300, 123456789.123456789]
MOVED = [
    {"omega": np.array([0.1, 2, 3]), "gamma": [0, 0, 1], "psi": np.float32(0.3), "end": 3},
    {"momentum": (1, Fraction(1, 3), "sqrt(2)"), "quaternion": [1, 0, 2, 0], "normalise": True},
    {"angles": ["pi/3", 1, mpmath.mpf("0.1")], "rates": [0, 0.5, np.longdouble("0.1")], "at": [1]},
    {"gamma": [0, 1, 0], "h": 3.25, "f": "1/3", "sign": "+", "at": np.linspace(0, 1, 4)[1:]},
    {"omega": ODD[:3], "gamma": [1, 0, 0], "end": 1e5, "samples": np.int64(5)},
    {"omega": ODD[3:6], "gamma": [1, 0, 0], "end": 2, "events": [polhode.Event("section:p-1/2")]},
    {"omega": ODD[1:4], "gamma": [1, 0, 0], "end": 2, "outputs": ("angles",), "form": "principal"},
    {"omega": [0, 0, 1], "gamma": [1, 0, 0], "title": "one\ntwo", "name": "x"},
    {"omega": [0, 0, 1], "gamma": [1, 0, 0], "reference": "certified"},
]


@pytest.mark.parametrize("start", MOVED, ids=range(len(MOVED)))
def test_the_text_of_a_scene_from_numbers_gives_it_back_to_the_bit(start):
    scene = polhode.top(moments=[1, 2, 2.3], centre=[0.1, 0, 0.2], weight=2.5, **start)
    assert scene_of(scene.source, scene.name) == scene
    assert pickle.loads(pickle.dumps(scene)) == scene == copy.deepcopy(scene)
    written = polhode.top(moments=[1, 2, 2.3], centre=[0.1, 0, 0.2], weight=2.5, **start)
    assert written == scene  # before its text is made


#: Irrational numbers, tiny units, angles, a band, events, a start on a level.
CASES = ["bobylev-steklov/asymptotic", "euler/irrational", "euler/separatrix"]
CASES += ["goryachev-chaplygin/rotating", "hard/heavy-tiny-units", "published/nasa-brick"]


@pytest.mark.parametrize(
    "names", [CASES, pytest.param(case_names(), marks=pytest.mark.slow)], ids=["some", "all"]
)
def test_every_case_written_and_read_again_is_itself(names):
    long = re.compile(r"\d{25,}")  # a band of 12.6 was the double 12.59999..., in full
    for name in names:
        assert polhode.as_toml(polhode.load(name)) == polhode.load(name).source
        scene = replace(polhode.load(name), title="another")
        assert scene.source not in polhode.as_toml(scene)
        text = polhode.as_toml(scene)
        again = scene_of(text, name)
        assert replace(again, source="") == replace(scene, source="")
        assert {*long.findall(text)} <= {*long.findall(scene.source)}


def test_what_no_file_can_hold_is_refused():
    odd = polhode.Scene(polhode.Body.of_moments([1, 1, 1]), [0, 0, 1], [1, 1, 0], normalise=True)
    with pytest.raises(polhode.BadInput, match="finitely many digits"):
        polhode.as_toml(odd)


# -- orientations -------------------------------------------------------------------------------


def turn(axis, angle):
    c, s = np.cos(angle), np.sin(angle)
    if axis == "z":
        return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


def quaternion_of(psi, theta, phi):
    half, plus, less = theta / 2, (psi + phi) / 2, (psi - phi) / 2
    c, s = np.cos(half), np.sin(half)
    return [c * np.cos(plus), s * np.cos(less), s * np.sin(less), c * np.sin(plus)]


@pytest.mark.parametrize(
    "angles",
    [
        *((0.3, 0.7, -1.1), (-2.5, 2.9, 0.4), (3.0, 0.001, 3.0), (1.0, np.pi / 2, -3.0)),
        *((0.7, -0.5, -1.3), (0.7, 4.0, -1.3), (-2.0, -3.5, 0.4)),  # of a theta beyond 0 to pi
    ],
)
def test_a_quaternion_is_the_same_start_as_its_angles(angles):
    """Both against rotation matrices, R = Rz(psi) Rx(theta) Rz(phi)."""
    psi, theta, phi = angles
    matrix = turn("z", psi) @ turn("x", theta) @ turn("z", phi)
    body = {"moments": [1, 1, 1], "omega": [0, 0, 1], "end": 1}
    of_angles = polhode.top(angles=angles, **body)
    quaternion = quaternion_of(*angles)
    of_quaternion = polhode.top(quaternion=quaternion, normalise=True, **body)
    doubled = polhode.top(quaternion=[-2 * x for x in quaternion], normalise=True, **body)
    for scene in (of_angles, of_quaternion, doubled):
        assert np.allclose([float(x) for x in scene.gamma], matrix[2], rtol=0, atol=8 * EPS)
        # psi is found by an arc tangent of sin(theta) sin(psi), sin(theta) cos(psi)
        gap = float(scene.psi) - psi - np.pi * (np.sin(theta) < 0)
        assert abs(gap - 2 * np.pi * round(gap / 2 / np.pi)) < 8 * EPS / abs(np.sin(theta))
        run = polhode.integrate(replace(scene, outputs=("matrix",)), at=[0])
        assert np.allclose(run.outputs["matrix"][0].reshape(3, 3), matrix, rtol=0, atol=8 * EPS)


@pytest.mark.parametrize(
    ("quaternion", "gamma", "psi"),
    [
        ([1, 0, 0, 0], (0, 0, 1), 0.0),
        ([0, 1, 0, 0], (0, 0, -1), 0.0),
        ([0, 0, 1, 0], (0, 0, -1), np.pi),
        ([1, 0, 0, 1], (0, 0, 1), np.pi / 2),
    ],
)
def test_at_a_pole_phi_is_counted_as_zero(quaternion, gamma, psi):
    body = {"moments": [1, 1, 1], "omega": [0, 0, 1], "normalise": True}
    scene = polhode.top(quaternion=quaternion, **body)
    assert scene.gamma == gamma
    assert float(scene.psi) == psi
    # the attitude at the start is the quaternion's rotation
    run = polhode.integrate(replace(scene, outputs=("attitude",)), at=[0])
    unit = np.array(quaternion) / np.linalg.norm(quaternion)
    assert min(np.max(np.abs(run.attitude[0] - s * unit)) for s in (1, -1)) < 4 * EPS


@pytest.mark.parametrize(
    "where", [{"angles": ["pi/3", "pi/6", 0]}, {"quaternion": [1, 2, 3, 4], "normalise": True}]
)
def test_omega_and_momentum_go_with_angles_and_quaternion(where):
    for how in ({"omega": [2, 1, 3]}, {"momentum": [4, 3, 12]}):
        assert polhode.top(moments=[2, 3, 4], **where, **how).omega == (2, 1, 3)


# -- bodies -------------------------------------------------------------------------------------

SI = """
schema = 1
[body]
g = "9.80665"
parts = [{ shape = "cone", mass = "0.1", radius = "0.03", height = "0.05" }]
[start]
angles = [0, "pi/6", 0]
rates = [0, 0, 200]
"""


def test_a_top_in_si_units_is_the_same_by_shape_by_mass_and_by_weight():
    shape = scene_of(SI)
    height = Fraction(3, 4) * Fraction(5, 100)
    across = Fraction(1, 10) * (Fraction(3, 20) * Fraction(9, 10_000) + Fraction(3, 80) / 400)
    moments = [across, across, Fraction(1, 10) * Fraction(3, 10) * Fraction(9, 10_000)]
    start = {"angles": [0, "pi/6", 0], "rates": [0, 0, 200]}
    mass = {"mass": "0.1", "g": "9.80665", "centre": [0, 0, height]}
    about = polhode.top(moments=moments, about="centre", **mass, **start)
    carried = [across + height * height / 10] * 2 + moments[2:]
    weight = polhode.top(moments=carried, weight="0.980665", centre=[0, 0, height], **start)
    for scene in (about, weight):
        assert replace(scene.body, parts=()) == replace(shape.body, parts=())
        assert (scene.omega, scene.gamma, scene.psi) == (shape.omega, shape.gamma, shape.psi)


def test_numbers_of_parts_can_be_varied():
    scene = scene_of(SI, "si")
    varied = {"body.parts[1].radius": ["0.03", "0.06"], "body.g": [0, "9.80665"]}
    many = polhode.integrate_many(scene, varied, at=[0])
    third = [member.body.moments[2] for member in many.members]
    assert third == [Fraction(27, 10**6)] * 2 + [Fraction(108, 10**6)] * 2
    assert many.members[1].body.torque == scene.body.torque
    with pytest.raises(polhode.BadInput, match="a number of the scene"):
        polhode.integrate_many(scene, {"body.parts[1].shape": [1]})


# -- the table of keys --------------------------------------------------------------------------


#: A small scene, and what stands in its sections instead, where a key needs or excludes others.
LINES = {
    "": "schema = 1",
    "body": "moments = [2, 2, 1]\nweight = 0",
    "body.parts": 'mass = 1\nshape = "sphere"\nradius = 1',
    "start": "omega = [1, 0, 0]\ngamma = [0, 0, 1]",
    "run": "end = 1",
    "reference": "",
    "section": "",
    "expect": "",
    "events": 'name = "x"\nzero = "p"',
    "published": 't = 1\nquantity = "p"\nvalue = "1"\ncite = "me"',
}
HEAVY = "moments = [2, 2, 1]\nmass = 1\ncentre = [0, 0, 1]\ng = 1"
LEVEL = 'gamma = ["3/5", 0, "4/5"]\nh = 3\nf = 1'
CONE = 'mass = 1\nshape = "cone"\nradius = 1\nheight = 1'
INSTEAD = {
    **{("body", key): "weight = 0" for key in ("moments", "inertia")},
    **{("body", key): HEAVY for key in ("about", "mass", "g")},
    ("body", "weight"): "moments = [2, 2, 1]\ncentre = [0, 0, 1]",
    ("body.parts", "size"): 'mass = 1\nshape = "box"',
    ("body.parts", "semi_axes"): 'mass = 1\nshape = "ellipsoid"',
    **{("body.parts", key): CONE for key in ("height", "shape", "axis")},
    ("start", "momentum"): "gamma = [0, 0, 1]",
    ("start", "rates"): "angles = [0, 1, 0]",
    **{("start", key): "omega = [1, 0, 0]" for key in ("angles", "quaternion", "mrp", "matrix")},
    **{("start", key): LEVEL for key in ("h", "f", "p_phi", "sign")},
    **{("run", key): "" for key in ("end", "at")},
}


def scene_with(section, key, value):
    """A small scene with one more key, and without what that excludes; None: without the key."""
    lines = LINES | {section: INSTEAD.get((section, key), LINES[section])}
    others = [line for line in lines[section].splitlines() if line.split(" ")[0] != key]
    lines[section] = "\n".join(others + ([] if value is None else [f"{key} = {value}"]))
    if section == "body.parts":
        lines["body"] = "weight = 0"
    alone = {name for name in ("body.parts", "events", "published") if name != section}
    heads = {"": "", **{name: f"[[{name}]]" for name in ("body.parts", "events", "published")}}
    text = [f"{heads.get(n, f'[{n}]')}\n{x}" for n, x in lines.items() if n not in alone]
    return scene_of("\n".join(text), "x")


PLAIN = [
    (section, key)
    for section, listed in vocabulary.KEYS.items()
    for key in listed
    if key.kind not in (vocabulary.TABLE, vocabulary.TABLES)
]


@pytest.mark.parametrize(("section", "key"), PLAIN, ids=lambda x: getattr(x, "name", x))
def test_the_example_of_every_key_is_read(section, key):
    assert key.example
    scene_with(section, key.name, key.example)
    if key.default:  # as if left out
        with_default, without = (scene_with(section, key.name, x) for x in (key.default, None))
        assert replace(with_default, source="") == replace(without, source="")
    if section != "expect":
        with pytest.raises(polhode.BadInput, match=r"one of the keys|a table"):
            scene_with(section, "nonsense", 1)


@pytest.mark.parametrize(("section", "key"), PLAIN, ids=lambda x: getattr(x, "name", x))
def test_what_every_key_says_is_written_back(section, key):
    """The writer had its own list of the body's and the start's keys; parts were lost."""
    scene = scene_with(section, key.name, '"1/3"' if key.name == "psi" else key.example)
    bare = replace(scene, source="")
    if all(isinstance(x, Fraction) for x in (*scene.start, scene.psi)):
        assert replace(scene_of(polhode.as_toml(bare), "x"), source="") == bare
    else:  # of angles, or on a level
        with pytest.raises(polhode.BadInput, match="finitely many digits"):
            polhode.as_toml(bare)


def test_a_new_key_of_the_body_is_written_and_read_by_the_same_list(monkeypatch):
    """One more field of the body, of a key by its name: it stands in the text of its scene."""

    @dataclass(frozen=True)
    class Gyrostat(polhode.Body):
        rotor: tuple[Fraction, ...] = (Fraction(0), Fraction(0), Fraction(0))

    key = vocabulary.BY_NAME["body"]["centre"]._replace(name="rotor")
    monkeypatch.setitem(vocabulary.KEYS, "body", (*vocabulary.KEYS["body"], key))
    plain = polhode.top(**FREE)
    body = Gyrostat(plain.body.inertia, rotor=(Fraction(1), Fraction(2), Fraction(3)))
    assert "rotor = [1, 2, 3]" in polhode.as_toml(replace(plain, body=body, source=""))


@pytest.mark.parametrize("title", ["\U0001f600 Zhukovski\u012d \\ud83d", "\x7f \t", np.str_("a")])
def test_every_title_is_read_as_it_was_given(title):
    scene = polhode.top(**FREE, title=title)
    assert (scene.title, type(scene.title)) == (title, str)
    assert scene_of(scene.source, "top") == scene
    assert polhode.as_toml(replace(scene, psi=1)).count(chr(10)) > 5

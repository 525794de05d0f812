"""Numbers from numpy that rounding alone keeps from being a body's or a direction's."""

import json
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.cli import main
from polhode.scenes import scene_file

EPS = np.finfo(float).eps
FREE = {"omega": [0.3, 0.2, 1.1], "end": 1}
TOP = {"moments": [2, 2, 1], "centre": [0, 0, 1], "weight": 1, "omega": [0.3, 0.2, 1.1]}


def rotation(rng):
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


def turned(rng, moments):
    r = rotation(rng)
    return r @ np.diag(moments) @ r.T


def unit(rng, n):
    x = rng.normal(size=n)
    return x / np.linalg.norm(x)


@pytest.mark.parametrize("part", range(5))
def test_inertia_from_numpy_is_made_symmetric_by_the_mean_of_each_pair(part):
    rng, made = np.random.default_rng([44, part]), 0
    for k in range(60):
        given = turned(rng, rng.uniform(1, 1.9, 3) * 10.0 ** (k % 13 - 6))
        scene = polhode.top(inertia=given, **FREE)
        exact = [[Fraction(float(x)) for x in row] for row in given]
        mean = [[(exact[i][j] + exact[j][i]) / 2 for j in range(3)] for i in range(3)]
        assert [[*row] for row in scene.body.inertia] == mean
        assert bool(scene.notes) == (not np.array_equal(given, given.T))
        made += bool(scene.notes)
    assert made > 40


@pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")
def test_inertia_may_be_a_matrix_of_numpy():
    """Its rows are matrices again, without end."""
    given = np.matrix([[2, 0.5, 0], [0.5, 3, 0], [0, 0, 4]])
    assert polhode.top(inertia=given, **FREE).body.inertia[0] == (2, Fraction(1, 2), 0)


@pytest.mark.parametrize("places", [(0, 1, 2), (2, 0, 1), (1, 2, 0)])
def test_thin_plates_are_flat_exactly(places):
    rng, made = np.random.default_rng(44), 0
    for _ in range(500):
        a, b = rng.uniform(0.01, 1, 2)
        moments = np.array([a, b, a + b])[[*places]]
        scene = polhode.top(moments=moments, **FREE)
        over = 2 * max(map(Fraction, moments)) - sum(map(Fraction, moments))
        assert bool(scene.notes) == (over > 0)
        left = 2 * max(scene.body.moments) - sum(scene.body.moments)
        assert left == min(over, 0)  # one that is thicker by rounding is a body as it is
        assert all(abs(x - y) <= EPS for x, y in zip(moments, scene.body.moments, strict=True))
        made += bool(scene.notes)
    assert 60 < made < 400


def test_turned_thin_plates_are_bodies():
    rng = np.random.default_rng(44)
    for _ in range(40):
        a, b = rng.uniform(0.1, 1, 2)
        given = turned(rng, [a, b, a + b])
        body = polhode.Body(given)
        sizes = [float(x) for x in body.moments]
        assert max(sizes) <= sum(sizes) - max(sizes) + 2 * EPS
        assert np.allclose(np.array(body.inertia, float), given, rtol=0, atol=16 * EPS)


@pytest.mark.parametrize("key", ["gamma", "quaternion"])
def test_unit_vectors_from_numpy_are_of_length_one_exactly(key):
    rng = np.random.default_rng(44)
    for _ in range(60):
        given = unit(rng, 3 if key == "gamma" else 4)
        scene = polhode.top(**TOP, **{key: given})
        assert sum(x * x for x in scene.gamma) == 1
        if key == "gamma":
            assert np.allclose([float(x) for x in scene.gamma], given, rtol=0, atol=2 * EPS)
        again = scene_file.parse(scene.source, "top")
        assert again == scene
    for row in rotation(rng):  # of a rotation matrix
        assert polhode.top(**TOP, gamma=row).gamma is not None


@pytest.mark.parametrize("kind", [np.float64, np.longdouble, float])
def test_other_numbers_beside_floats_are_forgiven_too(kind):
    gamma = [np.int64(0), kind(0.6), kind(0.8)]
    assert sum(x * x for x in polhode.top(**TOP, gamma=gamma).gamma) == 1
    thin = [kind(0.1), kind(0.2), kind(0.1 + 0.2)]
    assert polhode.Body.of_moments(thin).change
    matrix = [[2, kind(0.1 + 0.2), 0], [kind(0.3), 2, 0], [0, 0, np.int64(3)]]
    assert polhode.Body(matrix).inertia[0][1] == (Fraction(0.1 + 0.2) + Fraction(0.3)) / 2


def test_a_sweep_over_directions_from_numpy_is_read_and_told(capsys):
    rng = np.random.default_rng(44)
    vary = [{f"start.gamma[{i + 1}]": x for i, x in enumerate(unit(rng, 3))} for _ in range(300)]
    scene = polhode.top(**TOP, gamma=[0, 0, 1], name="directions")
    many = polhode.integrate_many(scene, vary, at=[0, 0.5])
    assert many.states.shape == (300, 2, 6)
    given = np.array([[*row.values()] for row in vary])
    assert np.allclose(many.states[:, 0, 3:], given, rtol=0, atol=2 * EPS)
    (note,) = many.provenance["notes"]
    assert note.startswith("members: start.gamma brought to length 1 (its square was 1 ")
    assert capsys.readouterr().err.count("directions: members: start.gamma brought") == 1
    thin = polhode.integrate_many(scene, {"body.moments[3]": [3, np.nextafter(4, 5)]}, at=[1])
    assert thin.members[1].body.moments == (2, 2, 4)
    assert thin.members[1].notes
    assert not thin.members[0].notes
    with pytest.raises(polhode.BadInput, match=r"member 2.*square is 1 \+ 2e-14"):
        polhode.integrate_many(
            scene, [vary[0], {k: x * (1 + 1e-14) for k, x in vary[1].items()}], at=[1]
        )


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (
            {"inertia": [[2, 0.1, 0], [0.1 + 1e-14, 2, 0], [0, 0, 3]]},
            "[1][2] and [2][1] differ by 1e-14",
        ),
        ({"inertia": [["2", "0.1", 0], ["0.1+1e-17", "2", 0], [0, 0, 3]]}, "differ by 1e-17"),
        (
            {"inertia": [[2, 0.5, 0], [-0.5, 2, 0], [0, 0, 3]]},
            "differ by 1; off the diagonal stand minus",
        ),
        (
            {"inertia": [[1, 0.5, 0], [0.5, 1, 0], [0, 0, 3]]},
            "they are 0.5, 1.5, 3, too much by 1; off",
        ),
        (
            {"inertia": [[1, 2, 0], [2, 1, 0], [0, 0, 3]]},
            "positive principal moments: they are 3, 3, -1;",
        ),
        ({"moments": [0.1, 0.2, 0.3 + 1e-14]}, "they are 0.1, 0.2, 0.3, too much by 9.9"),
        ({"moments": [1, 2, "3.0000000000000000001"]}, "they are 1, 2, 3, too much by 1e-19"),
        ({"moments": [1, 2, -3]}, "positive principal moments: they are 1, 2, -3"),
        ({"inertia": np.float32([[2, 0.1, 0], [0.100001, 2, 0], [0, 0, 3]])}, "differ by 9.98e-07"),
        ({"moments": [1, 1, 1], "gamma": [0.6, 0, 0.8 + 1e-14]}, "its square is 1 + 1.6e-14"),
        ({"moments": [1, 1, 1], "gamma": ["0.6", 0, "0.8-1e-17"]}, "its square is 1 - 1.6e-17"),
        ({"moments": [1, 1, 1], "quaternion": [0.5, 0.5, 0.5, 0.4]}, "its square is 1 - 0.09"),
    ],
)
def test_what_is_more_than_rounding_is_refused_with_its_amount(given, said):
    with pytest.raises(polhode.BadInput) as fault:
        polhode.top(**FREE, **given)
    assert said in str(fault.value)


def test_exact_numbers_are_held_to_what_they_say():
    """Texts, Fractions and Decimals of a Body are not rounded, so nothing is forgiven."""
    for one in (Fraction(1, 10), Decimal("0.1"), "0.1"):
        rows = [[2, one, 0], [Fraction(1, 10) + Fraction(1, 10**17), 2, 0], [0, 0, 3]]
        with pytest.raises(polhode.BadInput, match="differ by 1e-17"):
            polhode.Body(rows)
    with pytest.raises(polhode.BadInput, match="normalise = true"):
        polhode.top(
            **TOP, gamma=[Fraction(1, 3), Fraction(2, 3), Fraction(2, 3) + Fraction(1, 10**17)]
        )


SCENE = """
schema = 1
body.inertia = [
  [2.123456789012345, 0.12345678901234567, 0],
  [0.12345678901234568, 2, 0],
  [0, 0, 2.5],
]
start.omega = [0.3, 0.2, 1.1]
run.end = 1
"""


def test_a_file_with_a_matrix_as_numpy_prints_it_is_read_and_told_once(tmp_path, capsys):
    path = tmp_path / "top.toml"
    path.write_text(SCENE)
    for _ in range(2):  # each command says it anew
        assert main(["run", str(path), "--json"]) == 0
        answer = capsys.readouterr()
        said = "inertia made symmetric (elements differed by 1e-17 at most: rounding)"
        assert json.loads(answer.out)["provenance"]["notes"] == [said]
        assert [line for line in answer.err.splitlines() if "symmetric" in line] == [
            f"{path.name}: {said}"
        ]
    path.write_text(SCENE.replace("0.12345678901234568,", "0.123,"))
    assert main(["run", str(path)]) == 2
    assert "[1][2] and [2][1] differ by" in capsys.readouterr().err


def test_an_inertia_about_the_centre_is_forgiven_and_carried():
    rng = np.random.default_rng(44)
    given = turned(rng, [0.1, 0.2, 0.25])
    more = {"about": "centre", "mass": 2, "centre": [0, 0, "0.1"], "g": 0}
    scene = polhode.top(inertia=given, **more, **FREE)
    body = polhode.Body.about_centre(given, [0, 0, "0.1"], 2)
    assert body.inertia == scene.body.inertia
    assert body.change == scene.body.change != ""
    assert scene.body.inertia[0][0] == Fraction(float(given[0, 0])) + Fraction(1, 50)


# -- six numbers, signs, and keys that stand elsewhere ------------------------------------------


@pytest.mark.parametrize(
    "given", [[1, 0, 0, 2, 0, 2], {"ixx": 1, "iyy": 2, "izz": 2}, 5, [[1, 0, 0]]]
)
def test_six_numbers_of_urdf_are_told_how_to_be_written(given):
    for call in (lambda: polhode.top(inertia=given, **FREE), lambda: polhode.Body(given)):
        with pytest.raises(polhode.BadInput) as fault:
            call()
        assert "[[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]], signs unchanged" in str(
            fault.value
        )


def test_three_numbers_as_inertia_are_told_that_they_are_moments():
    with pytest.raises(polhode.BadInput) as fault:
        polhode.top(inertia=[2, 3, 4], **FREE)
    assert "body.inertia = [2, 3, 4]: expected moments = [A, B, C], or a 3 x 3" in str(fault.value)


def test_the_sign_off_the_diagonal_is_minus_that_of_the_product():
    """Two masses at (1, 1, 0) and (-1, -1, 0), and a sphere: the sum of m x y is 2."""
    points = [polhode.Part("point", 1, at=[x, x, 0]) for x in (1, -1)]
    body = polhode.Body.of_parts([*points, polhode.Part("sphere", 1, radius=1)], g=0)
    assert body.inertia[0][1] == -2
    for text in (polhode.top.__doc__, polhode.Body.__doc__):
        assert "minus the products of inertia" in " ".join(text.split())


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (
            "moments = [1, 1, 1]",
            "moments = [1, 1, 1]: expected no such key here: it belongs in [body]",
        ),
        (
            "omega = [1, 1, 1]",
            "omega = [1, 1, 1]: expected no such key here: it belongs in [start]",
        ),
        ("end = 3", "end = 3: expected no such key here: it belongs in [run]"),
        ("mass = 3", "mass = 3: expected no such key here: it belongs in [body] or [[body.parts]]"),
        ("start.end = 3", "start.end = 3: expected no such key here: it belongs in [run]"),
        (
            "start.title = 'x'",
            "start.title = x: expected no such key here: it belongs in the top level",
        ),
        ("momens = [1, 1, 1]", "momens = [1, 1, 1]: expected one of the keys schema"),
    ],
)
def test_a_key_that_stands_elsewhere_is_told_where_it_belongs(line, said):
    with pytest.raises(polhode.BadInput) as fault:
        scene_file.parse(f"schema = 1\n{line}\nbody.moments = [1, 1, 1]\nstart.omega = [0, 0, 1]")
    assert said in str(fault.value)


# -- angles in degrees, given as radians --------------------------------------------------------

SPUN = {"moments": [1, 1, 0.5], "centre": [0, 0, 1], "weight": 1, "rates": [0, 0, 8]}


@pytest.mark.parametrize(
    ("theta", "doubted"),
    [
        (20, True),
        (-90, True),
        (6.3, True),
        (6.28, False),
        ("400 deg", False),
        ("20°", False),
        (0.5, False),
    ],
)
def test_a_theta_of_more_than_a_turn_is_doubted(theta, doubted, tmp_path, capsys):
    path = tmp_path / "top.toml"
    shown = theta if isinstance(theta, (int, float)) else f'"{theta}"'
    path.write_text(
        "schema = 1\nbody.moments = [1, 1, 0.5]\nbody.centre = [0, 0, 1]\nbody.weight = 1\n"
        f"start.angles = [0, {shown}, 0]\nstart.rates = [0, 0, 8]\n"
    )
    assert main(["show", str(path)]) == 0
    said = (
        f"{path.name}: start.angles: theta = {theta} is taken in radians, and is more than a turn; "
    )
    assert (said in capsys.readouterr().err) == doubted
    if doubted:
        for call in (lambda: polhode.top(**SPUN, angles=[0, theta, 0]), lambda: polhode.load(path)):
            with pytest.warns(UserWarning, match=f'for degrees write "{theta} deg"'):
                call()
    else:
        polhode.top(**SPUN, angles=[0, theta, 0])


def test_a_sweep_of_theta_in_degrees_is_doubted(capsys, tmp_path):
    scene = polhode.top(**SPUN, angles=[0, 1, 0])
    with pytest.warns(UserWarning, match=r"theta = 80 is taken in radians"):
        polhode.integrate_many(scene, {"start.angles[2]": "10:80:3"}, at=[0])
    polhode.integrate_many(scene, {"start.angles[2]": "10 deg:80 deg:3"}, at=[0])
    path = tmp_path / "top.toml"
    path.write_text(polhode.as_toml(scene))
    assert main(["sweep", str(path), "--vary", "start.angles[2]=10:80:3", "--at", "0"]) == 0
    assert capsys.readouterr().err.count("theta = 80 is taken in radians") == 1

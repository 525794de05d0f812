"""Numbers from numpy that rounding alone keeps from being a body's or a direction's."""

import contextlib
import json
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.cli import main
from shared.motions import scene_of

EPS = np.finfo(float).eps
FREE = {"omega": [0.3, 0.2, 1.1], "end": 1}
TOP = {"moments": [2, 2, 1], "centre": [0, 0, 1], "weight": 1, "omega": [0.3, 0.2, 1.1]}


def rotation(rng):
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


def rotated_inertia(rng, moments):
    r = rotation(rng)
    return r @ np.diag(moments) @ r.T


def unit(rng, n):
    x = rng.normal(size=n)
    return x / np.linalg.norm(x)


def test_inertia_from_numpy_is_made_symmetric_by_the_mean_of_each_pair():
    rng, changes = np.random.default_rng(44), 0
    for k in range(60):
        inertia = rotated_inertia(rng, rng.uniform(1, 1.9, 3) * 10.0 ** (k % 13 - 6))
        scene = polhode.top(inertia=inertia, **FREE)
        exact = [[Fraction(float(x)) for x in row] for row in inertia]
        mean = [[(exact[i][j] + exact[j][i]) / 2 for j in range(3)] for i in range(3)]
        assert [[*row] for row in scene.body.inertia] == mean
        assert bool(scene.notes) == (not np.array_equal(inertia, inertia.T))
        changes += bool(scene.notes)
    assert changes > 40


@pytest.mark.parametrize(("by", "rounding"), [(7, True), (-8, True), (9, False), (-9, False)])
def test_eight_eps_of_the_largest_number_are_rounding_and_nine_are_not(by, rounding):
    inertia = np.array([[1.0, 0.25, 0], [0.25 + by * EPS, 1, 0], [0, 0, 1]])
    fault = contextlib.nullcontext() if rounding else pytest.raises(polhode.BadInput, match="symm")
    with fault:
        assert polhode.top(inertia=inertia, **FREE).notes


@pytest.mark.parametrize("places", [(0, 1, 2), (2, 0, 1), (1, 2, 0)])
def test_thin_plates_are_flat_exactly(places):
    rng, changes = np.random.default_rng(44), 0
    for _ in range(100):
        a, b = rng.uniform(0.01, 1, 2)
        moments = np.array([a, b, a + b])[[*places]]
        scene = polhode.top(moments=moments, **FREE)
        over = 2 * max(map(Fraction, moments)) - sum(map(Fraction, moments))
        assert bool(scene.notes) == (over > 0)
        left = 2 * max(scene.body.moments) - sum(scene.body.moments)
        assert left == min(over, 0)  # one that is thicker by rounding is a body as it is
        assert all(abs(x - y) <= EPS for x, y in zip(moments, scene.body.moments, strict=True))
        changes += bool(scene.notes)
    assert 10 < changes < 90
    for _ in range(10):
        inertia = rotated_inertia(rng, [a, b, a + b])
        sizes = [float(x) for x in polhode.Body(inertia).moments]
        assert max(sizes) <= sum(sizes) - max(sizes) + 2 * EPS


@pytest.mark.parametrize("key", ["gamma", "quaternion"])
def test_unit_vectors_from_numpy_are_of_length_one_exactly(key):
    rng = np.random.default_rng(44)
    for _ in range(60):
        vector = unit(rng, 3 if key == "gamma" else 4)
        scene = polhode.top(**TOP, **{key: vector})
        assert sum(x * x for x in scene.gamma) == 1
        if key == "gamma":
            assert np.allclose([float(x) for x in scene.gamma], vector, rtol=0, atol=2 * EPS)
        again = scene_of(scene.source, "top")
        assert again == scene
    for row in rotation(rng):  # of a rotation matrix
        assert polhode.top(**TOP, gamma=row).gamma is not None


@pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")
@pytest.mark.parametrize("kind", [np.float64, np.longdouble, float])
def test_other_numbers_beside_floats_are_forgiven_too(kind):
    gamma = [np.int64(0), kind(0.6), kind(0.8)]
    assert sum(x * x for x in polhode.top(**TOP, gamma=gamma).gamma) == 1
    thin = [kind(0.1), kind(0.2), kind(0.1 + 0.2)]
    assert polhode.Body.of_moments(thin).change
    rows = [[2, kind(0.1 + 0.2), 0], [kind(0.3), 2, 0], [0, 0, np.int64(3)]]
    body = polhode.Body.about_centre(rows, [0, 0, "0.1"], 2)
    assert body.inertia[0][1] == (Fraction(0.1 + 0.2) + Fraction(0.3)) / 2
    assert (body.inertia[0][0], body.change != "") == (2 + Fraction(1, 50), True)
    matrix = np.matrix(rows, dtype=float)  # whose rows are matrices again, without end
    assert polhode.top(inertia=matrix, **FREE).body.inertia[0][1] == body.inertia[0][1]


def test_a_sweep_over_directions_from_numpy_is_read_and_told(capsys):
    rng = np.random.default_rng(44)
    vary = [{f"start.gamma[{i + 1}]": x for i, x in enumerate(unit(rng, 3))} for _ in range(60)]
    scene = polhode.top(**TOP, gamma=[0, 0, 1], name="directions")
    many = polhode.integrate_many(scene, vary, at=[0, 0.5])
    directions = np.array([[*row.values()] for row in vary])
    assert np.allclose(many.states[:, 0, 3:], directions, rtol=0, atol=2 * EPS)
    (note,) = many.provenance["notes"]
    assert note.startswith("members: start.gamma brought to length 1 (its square was 1 ")
    assert capsys.readouterr().err.count("directions: members: start.gamma brought") == 1
    thin = polhode.integrate_many(scene, {"body.moments[3]": [3, np.nextafter(4, 5)]}, at=[1])
    assert thin.members[1].body.moments == (2, 2, 4)
    assert [bool(member.notes) for member in thin.members] == [False, True]
    off = {k: x * (1 + 1e-14) for k, x in vary[1].items()}
    with pytest.raises(polhode.BadInput, match=r"member 2.*square is 1 \+ 2e-14"):
        polhode.integrate_many(scene, [vary[0], off], at=[1])


def test_exact_numbers_are_held_to_what_they_say():
    """Texts, Fractions and Decimals of a Body are not rounded, so nothing is forgiven."""
    for tenth in (Fraction(1, 10), Decimal("0.1"), "0.1"):
        rows = [[2, tenth, 0], [Fraction(1, 10) + Fraction(1, 10**17), 2, 0], [0, 0, 3]]
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


# -- angles in degrees, given as radians --------------------------------------------------------

SPUN = {"moments": [1, 1, 0.5], "centre": [0, 0, 1], "weight": 1, "rates": [0, 0, 8]}


@pytest.mark.parametrize(
    ("theta", "doubted"),
    [(20, True), (-90, True), (6.3, True), (6.28, False), ("400 deg", False), ("20°", False)],
)
def test_a_theta_of_more_than_a_turn_is_doubted(theta, doubted, tmp_path, capsys):
    def top():
        return polhode.top(**SPUN, angles=[0, theta, 0])

    words = pytest.warns(UserWarning, match=f'for degrees write "{theta} deg"')
    with words if doubted else contextlib.nullcontext():
        scene = top()
    path = tmp_path / "top.toml"
    path.write_text(polhode.as_toml(scene))
    with words if doubted else contextlib.nullcontext():
        polhode.load(path)
    assert main(["show", str(path)]) == 0
    said = f"{path.name}: start.angles: theta = {theta} is taken in radians, and is more"
    assert (said in capsys.readouterr().err) == doubted


def test_a_sweep_of_theta_in_degrees_is_doubted(capsys, tmp_path):
    scene = polhode.top(**SPUN, angles=[0, 1, 0])
    with pytest.warns(UserWarning, match=r"theta = 80 is taken in radians"):
        polhode.integrate_many(scene, {"start.angles[2]": "10:80:3"}, at=[0])
    polhode.integrate_many(scene, {"start.angles[2]": "10 deg:80 deg:3"}, at=[0])
    path = tmp_path / "top.toml"
    path.write_text(polhode.as_toml(scene))
    assert main(["sweep", str(path), "--vary", "start.angles[2]=10:80:3", "--at", "0"]) == 0
    assert capsys.readouterr().err.count("theta = 80 is taken in radians") == 1

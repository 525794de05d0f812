"""Names, units and forms of columns as other programs write them; cells that are no numbers."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode import BadInput, cli
from polhode.judging.tables.column_aliases import columns
from polhode.scenes.vocabulary import ANGLES, ATTITUDE, STATE

SCENE = "lagrange/nutation"
RATES, GAMMA = list(STATE[:3]), list(STATE[3:])
NINE = [f"R{i}{j}" for i in "123" for j in "123"]

#: Headers, separated by bars, and what their columns are: empty of one that is not known.
HEADERS = [
    ("gx|gy|gz", GAMMA),
    ("ax|ay|az|gx|gy|gz", ["", "", "", *RATES]),
    ("accel x [m/s²]|gx|gy|gz", ["", *RATES]),
    ("Acc_X (g)|GyrX|GyrY|GyrZ", ["", *RATES]),
    ("gamma1|gamma2|gamma3|gx|gy|gz", [*GAMMA, *RATES]),
    ("ax|wx|gx", ["", "p", "gamma1"]),
    ("gx [dps]|gy [dps]|gz [dps]", RATES),
    ("Gyroscope x (rad/s)|Gyroscope y (rad/s)|Gyroscope z (rad/s)|Absolute (rad/s)", [*RATES, ""]),
    ("Rotation Rate X|Rotation Rate Y|Rotation Rate Z", RATES),
    ("rotationRateX(rad/s)|rotationRateY(rad/s)|gyroRotationZ(rad/s)", RATES),
    ("body.w_a[1]|body.w_a[2]|body.w_a[3]", RATES),
    ("gyr_x|gyr_y|gyr_z", RATES),
    ("gyro[0]|gyro[1]|gyro[2]", RATES),
    ("gyro_1|gyro_2|gyro_3", RATES),
    ("p_dps|q_dps|r_dps", RATES),
    ("P [deg/s]|Q [°/s]|R (rad s^-1)", RATES),
    ("omega_BN_B[0]|omega_BN_B[1]|omega_BN_B[2]", RATES),
    ("ω1|ω2|ω3", RATES),
    ("roll_rate|pitchRate|yawspeed", RATES),
    ("imu/angular_velocity/x|imu/angular_velocity/y|angularVelocity.z", RATES),
    ("vehicle_angular_velocity.xyz[0]|vehicle_angular_velocity.xyz[1]", RATES[:2]),
    ("omega_x", ["omega_x"]),
    ("velocity_x|vel.y|mx|t11|accel_rate|note|rotation|Temperature|lin_acc_x|p_s", [""] * 10),
    ("Psi [deg]|θ|phi_deg", list(ANGLES)),
    ("q_w|quat_x|pose.orientation.y|Rotation_Z", list(ATTITUDE)),
    ("Q[1]|Q[2]|Q[3]|Q[4]", ["q1", "q2", "q3", "q0"]),
    ("vehicle_attitude.q[0]|vehicle_attitude.q[1]", ["q0", "q1"]),
    ("|".join(NINE), NINE),
    ("|".join(f"R[{i}][{j}]" for i in range(3) for j in range(3)), NINE),
    ("|".join(f"R({i},{j})" for i in "123" for j in "123"), NINE),
    ("|".join(f"dcm_{i}{j}" for i in "012" for j in "012"), NINE),
    ("R11|R12", ["", ""]),
    ("sigma_1|sigma_2|sigma_3", ["sigma1", "sigma2", "sigma3"]),
    ("sigma_BN[0]|sigma_BN[1]|sigma_BN[2]", ["sigma1", "sigma2", "sigma3"]),
    ("rotvec_x|rotvec_y|rotvec_z", ["rotvec1", "rotvec2", "rotvec3"]),
    ("seconds_elapsed|p", ["t", "p"]),
    ("Time (s)|p", ["t", "p"]),
    ("t [ms]|p", ["t", "p"]),
]


@pytest.mark.parametrize(("header", "names"), HEADERS)
def test_what_a_header_means(header, names):
    assert [found.name or "" for found in columns(header.split("|"))] == names


@pytest.mark.parametrize(
    ("header", "size"),
    [
        ("wx (rad/s)", 1.0),
        ("wx", 1.0),
        ("wx [deg/s]", 180 / np.pi),
        ("p_dps", 180 / np.pi),
        ("gyro_x [mdps]", 180_000 / np.pi),
        ("gyro_x (mrad/s)", 1000.0),
        ("wx [rpm]", 30 / np.pi),
        ("wx [rev/s]", 0.5 / np.pi),
        ("wx [Hz]", 0.5 / np.pi),
    ],
)
def test_units_of_a_rate(header, size):
    found = polhode.compare({"t": [0.0], header: [0.16 * size]}, SCENE)
    assert found.worst > 15


# -- forms of the attitude ------------------------------------------------------------------------


def matrix(q):
    """The components of matrices body -> space, row by row."""
    w, x, y, z = q.T
    return [
        *(1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        *(2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        *(2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    ]


def forms(q):
    """Columns by name that have the same attitudes as quaternions, in each form."""
    sigma = q[:, 1:] / (1 + q[:, :1])
    square = np.sum(sigma**2, axis=1, keepdims=True)
    shadow = np.where(square > 1, -sigma / square, sigma)
    size = np.linalg.norm(q[:, 1:], axis=1, keepdims=True)
    vector = q[:, 1:] / size * 2 * np.arctan2(size, q[:, :1])
    axes = "xyz"
    return {
        "matrix": dict(zip(NINE, matrix(q), strict=True)),
        "MRP": {f"sigma_{i + 1}": sigma[:, i] for i in range(3)},
        "shadow": {f"MRP_{axes[i]}": shadow[:, i] for i in range(3)},
        "vector": {f"rotvec_{axes[i]}": vector[:, i] for i in range(3)},
        "degrees": {f"rotvec_{axes[i]} [deg]": np.degrees(vector[:, i]) for i in range(3)},
    }


@pytest.fixture(scope="module")
def attitudes():
    """Times, some of them far apart, and quaternions of the exact motion."""
    times = [Fraction(3 * k, 4) for k in range(1, 14)]
    rows = polhode.reference(SCENE).attitude(times, 20)
    return np.array(times, dtype=float), np.array([[float(x) for x in row] for row in rows])


@pytest.mark.parametrize("form", ["matrix", "MRP", "shadow", "vector", "degrees"])
def test_an_attitude_in_any_form(attitudes, form, tmp_path):
    t, q = attitudes
    table = {"t": t} | forms(q)[form]
    found = polhode.compare(table, SCENE)
    assert 14 < found.worst < 17
    assert found.worst_part == "attitude"
    cells = np.column_stack([*table.values()])
    path = tmp_path / "x.csv"
    np.savetxt(path, cells, delimiter=",", header=",".join(table), fmt="%.17g")
    assert 14 < polhode.compare(path, SCENE).worst < 17
    name = [*table][2]
    table[name] = table[name] + 1e-6
    assert polhode.compare(table, SCENE).worst < 8.5


def test_many_matrices_and_arrays_of_them(tmp_path):
    scene = replace(polhode.load(SCENE), outputs=("attitude",))
    times = [Fraction(k, 10) for k in range(1, 200)]
    q = np.array(polhode.integrate(scene, at=times).attitude)
    turned = np.array(matrix(q)).T.reshape(-1, 3, 3)
    np.savez(tmp_path / "x.npz", t=np.array(times, dtype=float), R=turned)
    found = polhode.compare(tmp_path / "x.npz", SCENE)
    assert found.worst > 13.5
    np.savez(tmp_path / "x.npz", t=np.array(times, dtype=float), R=turned.transpose(0, 2, 1))
    assert polhode.compare(tmp_path / "x.npz", SCENE).reading == "attitude body from space"


@pytest.mark.parametrize("digits", [25, 40])
def test_a_matrix_keeps_its_digits(tmp_path, digits):
    from mpmath import mp, mpf

    times = [Fraction(k, 3) for k in range(1, 5)]
    lines = ["t," + ",".join(NINE)]
    with mp.workdps(60):
        for t, row in zip(times, polhode.reference(SCENE).attitude(times, 50), strict=True):
            q = np.array([[mpf(x) for x in row]])
            cells = [mp.nstr(x[0], digits) for x in matrix(q)]
            lines.append(",".join([mp.nstr(mpf(t.numerator) / t.denominator, 50), *cells]))
    (tmp_path / "x.csv").write_text("\n".join(lines))
    assert digits - 2 < polhode.compare(tmp_path / "x.csv", SCENE).worst < digits + 2


# -- lengths, empty cells, refusals ---------------------------------------------------------------


@pytest.mark.parametrize("length", [2.0, 0.5, np.linspace(1, 1.3, 13)[:, None]])
@pytest.mark.parametrize("door", ["mapping", "csv"])
def test_a_quaternion_of_another_length_is_said_to_be(attitudes, tmp_path, length, door):
    t, q = attitudes
    table = {"t": t} | dict(zip(ATTITUDE, (q * length).T, strict=True))
    if door == "csv":
        cells = np.column_stack([*table.values()])
        np.savetxt(tmp_path / "x.csv", cells, delimiter=",", header=",".join(table), comments="")
        table = tmp_path / "x.csv"
    found = polhode.compare(table, SCENE)
    assert found.worst > 14
    assert found.reading == "attitude of length 1"
    assert "the quaternion's length is " in str(found)
    assert polhode.compare(table, SCENE, read="of length 1").worst == found.worst
    strict = polhode.compare(table, SCENE, as_it_stands=True)
    assert strict.worst < 1
    assert "the quaternion's length is " in str(strict)


def test_a_small_error_of_length_is_an_error(attitudes):
    t, q = attitudes
    found = polhode.compare({"t": t} | dict(zip(ATTITUDE, q.T * (1 + 1e-7), strict=True)), SCENE)
    assert found.reading is None
    assert 6.9 < found.worst < 7.5


@pytest.mark.parametrize("cell", ["nan", "NaN", "-nan", "NA", "null", ""])
def test_a_cell_that_is_no_number_is_not_judged_whatever_the_door(tmp_path, cell):
    run = polhode.integrate(SCENE, at=[0, 1, 2])
    rows = np.array(run.states)
    rows[1, 1] = np.nan
    table = {"t": [0.0, 1.0, 2.0]} | dict(zip(STATE, rows.T, strict=True))
    lines = [",".join(("t", *STATE))]
    for t, row in enumerate(rows.tolist()):
        lines.append(",".join([str(t), *(cell if x != x else repr(x) for x in row)]))
    (tmp_path / "x.csv").write_text("\n".join(lines))
    told = [
        polhode.compare(tmp_path / "x.csv", SCENE),
        polhode.compare(table, SCENE),
        polhode.compare(rows, SCENE, at=[0, 1, 2]),
    ]
    for found in told:
        assert found.worst > 14.5
        assert "not judged: empty cells were not judged" in str(found)
    (tmp_path / "x.csv").write_text(
        "\n".join([lines[2], *lines[3:]])  # the first row, without a header, has the cell
    )
    names = ["t", *STATE]
    assert len(polhode.compare(tmp_path / "x.csv", SCENE, columns=names).times) == 2


@pytest.mark.parametrize(
    ("header", "said"),
    [
        ("t,foo,bar", "columns besides t that can be judged"),
        ("clock,p,q", "a header with a column t"),
        ("t,time,p", "each column once ('t', 'time')"),
        ("t,p,wx", "each column once ('p', 'wx')"),
    ],
)
def test_a_refusal_names_the_option_that_helps(tmp_path, capsys, header, said):
    (tmp_path / "x.csv").write_text(f"{header}\n0,1,0.16\n")
    assert cli.main(["compare", str(tmp_path / "x.csv"), SCENE]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert "--columns" in error
    if not header.startswith("clock"):
        with pytest.raises(BadInput, match="--columns"):
            polhode.compare({name: [0.0] for name in header.split(",")}, SCENE)


def test_a_column_that_is_told_is_chosen(tmp_path):
    table = {"t": [0.0], "wx": [0.16], "gyro_x": [7.0], "foo": [0.3]}
    found = polhode.compare(table, SCENE, columns=["wx=p", "foo=q"])
    assert found.worst > 15
    assert found.subject.columns == ("p", "q")
    with pytest.raises(BadInput, match="NAME=COLUMN of each"):
        polhode.compare(table, SCENE, columns=["t", "p", "q", "r"])


@pytest.mark.parametrize("name", ["ref.csv", "ref.npz", "REF.CSV"])
def test_a_table_is_judged_by_a_scene(tmp_path, capsys, name):
    assert cli.main(["compare", "mine.csv", name]) == 2
    error = capsys.readouterr().err
    assert f"compare: SCENE = {name}: expected a scene, a case's name or a .toml file" in error
    assert error.count("\n") == 1

"""Names, units and forms of columns as other programs write them."""

import random
from dataclasses import replace
from fractions import Fraction

import mpmath
import numpy as np
import pytest

import polhode
from polhode import NumberType
from polhode.judging.tables.column_aliases import columns
from shared.tables import ANGLES, ATTITUDE, STATE, right, text, through
from shared.tools import DOUBLE, EXTENDED

SCENE = "lagrange/nutation"
TIMES = [Fraction(3 * k, 4) for k in range(1, 14)]
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
    ("time|qw|qx|w_x [rad/s]|wz|gamma_y|g3", ["t", "q0", "q1", "p", "r", "gamma2", "gamma3"]),
    ("psi_old|deg|", ["", "", ""]),
    ("psi_deg|theta (degrees)", ["psi", "theta"]),
    ("timestamp|orientation.w|pose.orientation.x", ["t", "q0", "q1"]),
    ("AngularVelocity.x|angular_velocity.z|Rotation.w|Rotation_Z", ["p", "r", "q0", "q3"]),
    ("rotation_quaternion[0]|rotation_quaternion[3]|rotation", ["q0", "q3", ""]),
    ("qpos0|qpos[3]|qvel2|qvel3|position.x", ["q0", "q3", "r", "", ""]),
]


@pytest.mark.parametrize(("header", "names"), HEADERS)
def test_what_a_header_means(header, names):
    assert [column.name or "" for column in columns(header.split("|"))] == names


@pytest.mark.parametrize(
    ("header", "size"),
    [
        *((name, 1.0) for name in ("wx", "wx (rad/s)")),
        *((name, 180 / np.pi) for name in ("wx [deg/s]", "p_dps")),
        ("gyro_x [mdps]", 180_000 / np.pi),
        ("gyro_x (mrad/s)", 1000.0),
        ("wx [rpm]", 30 / np.pi),
        ("wx [rev/s]", 0.5 / np.pi),
        ("wx [Hz]", 0.5 / np.pi),
    ],
)
def test_units_of_a_rate(header, size):
    assert polhode.compare({"t": [0.0], header: [0.16 * size]}, SCENE).worst > 15


def test_synonyms_and_degrees_are_judged_as_what_they_are():
    plain = right(SCENE, TIMES, "at", "attitude", "angles")
    others = ("t", "wx", "wy", "wz", *GAMMA, "qw", "qx", "qy", "qz")
    table = dict(zip(others, plain.values(), strict=False))
    table |= {f"{name}_deg": np.degrees(plain[name]) for name in ANGLES}
    judgement, second = (polhode.compare(x, SCENE) for x in (plain, table))
    assert judgement.digits == second.digits
    assert judgement.parts["attitude"] == second.parts["attitude"] > 15
    assert 14 < second.parts["angles"] < 16.5
    assert not second.readings


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


def attitudes():
    """Times, some of them far apart, and quaternions of the exact motion."""
    t, *q = right(SCENE, TIMES, "attitude").values()
    return t, np.array(q).T


@pytest.mark.parametrize("form", ["matrix", "MRP", "shadow", "vector", "degrees"])
def test_an_attitude_in_any_form(form, tmp_path):
    t, q = attitudes()
    table = {"t": t} | forms(q)[form]
    for source in (table, through("%.17g", table, tmp_path)):
        judgement = polhode.compare(source, SCENE)
        assert 14 < judgement.worst < 17
        assert judgement.worst_part == "attitude"
    name = [*table][2]
    table[name] = table[name] + 1e-6
    assert polhode.compare(table, SCENE).worst < 8.5


def test_many_matrices_and_arrays_of_them(tmp_path):
    times = [Fraction(k, 10) for k in range(1, 200)]
    t, *q = right(SCENE, times, "attitude").values()
    matrices_there = np.array(matrix(np.array(q).T)).T.reshape(-1, 3, 3)
    for r, reading in (
        (matrices_there, None),
        (matrices_there.transpose(0, 2, 1), "attitude body from space"),
    ):
        np.savez(tmp_path / "x.npz", t=t, R=r)
        judgement = polhode.compare(tmp_path / "x.npz", SCENE)
        assert judgement.worst > 13.5
        assert judgement.reading == reading


@pytest.mark.parametrize("digits", [25, 40])
def test_a_matrix_keeps_its_digits(tmp_path, digits):
    times = [Fraction(k, 8) for k in range(1, 5)]
    lines = ["t," + ",".join(NINE)]
    with mpmath.workdps(60):
        for t, row in zip(times, polhode.reference(SCENE).attitude(times, 50), strict=True):
            cells = [mpmath.nstr(x[0], digits) for x in matrix(np.array([row]))]
            lines.append(",".join([str(float(t)), *cells]))
    (tmp_path / "x.csv").write_text("\n".join(lines))
    assert digits - 2 < polhode.compare(tmp_path / "x.csv", SCENE).worst < digits + 2


@pytest.mark.parametrize("length", [2.0, 0.5, np.linspace(1, 1.3, 13)[:, None]])
@pytest.mark.parametrize("door", ["mapping", "csv"])
def test_a_quaternion_of_another_length_is_said_to_be(tmp_path, length, door):
    t, q = attitudes()
    table = {"t": t} | dict(zip(ATTITUDE, (q * length).T, strict=True))
    table = through(door, table, tmp_path)
    judgement = polhode.compare(table, SCENE)
    assert judgement.worst > 14
    assert judgement.reading == "attitude of length 1"
    assert "the quaternion's length is " in str(judgement)
    assert polhode.compare(table, SCENE, read="attitude of length 1").worst == judgement.worst
    strict = polhode.compare(table, SCENE, as_it_stands=True)
    assert strict.worst < 1
    assert "the quaternion's length is " in str(strict)


def test_a_small_error_of_length_is_an_error():
    t, q = attitudes()
    judgement = polhode.compare(
        {"t": t} | dict(zip(ATTITUDE, q.T * (1 + 1e-7), strict=True)), SCENE
    )
    assert judgement.reading is None
    assert 6.9 < judgement.worst < 7.5


def test_gx_beside_a_quaternion_is_what_its_length_says(tmp_path):
    """A gyroscope's rates were read as gamma, and wrong in the first digit."""
    scene = polhode.load("lagrange/nutation")
    run = polhode.integrate(replace(scene, outputs=("attitude",)), at=[0, 0.5, 1, 2])
    quaternion = dict(zip(("qw", "qx", "qy", "qz"), np.array(run.attitude).T, strict=True))
    rates, gamma = (
        dict(zip(("gx", "gy", "gz"), x.T, strict=True)) for x in np.split(run.states, 2, 1)
    )
    table = {"t": np.array(run.t), **quaternion}
    judgement = polhode.compare(table | rates, scene)
    assert judgement.worst > 14
    assert {"omega", "attitude"} == {*judgement.part_digits}
    assert "gx gy gz were read as rates, for they are no unit vector" in str(judgement)
    (tmp_path / "x.csv").write_text(text(table | rates))
    assert polhode.compare(tmp_path / "x.csv", scene).worst > 14
    noisy = {name: x + 0.01 * np.sin(9 * table["t"]) for name, x in gamma.items()}
    for vertical in (gamma, noisy):
        assert {"gamma", "attitude"} == {*polhode.compare(table | vertical, scene).part_digits}


# -- Cells of a file: as exact decimals, rounded once, whatever way is taken


ODD = ["0", "-0.0", "1.", ".5", "+2e3", "1e-310", "4.9e-324", "1e308", "1e400", "-1E-400", "0e300"]
HALFWAY = "1.00000000000000011102230246251565404236316680908203125"  # 1 + 2**-53


def printed(count: int) -> list[str]:
    draw = random.Random(5)
    forms = ("%.17g", "%.16e", "%.3f", "%.20f", "%+.12g")
    return [
        draw.choice(forms) % (draw.gauss(0, 1) * 10 ** draw.uniform(-12, 9)) for _ in range(count)
    ]


@pytest.mark.parametrize("number", [DOUBLE, EXTENDED, NumberType("mp", 53)])
def test_a_cell_is_its_decimal_rounded_once(tmp_path, number):
    cells = [*printed(500), *ODD, HALFWAY, HALFWAY + "1", "0." + "3" * 70, "1_000.5"]
    path = tmp_path / "x.csv"
    path.write_text("t,p\n" + "".join(f"{k},{cell}\n" for k, cell in enumerate(cells)))
    how = {"number": number.name, "digits": 15} if number.name == "mp" else {"number": number.name}
    table = polhode.compare(path, SCENE, as_it_stands=True, **how).subject
    for cell, x in zip(cells, table.columns["p"], strict=True):
        assert x == table.number.rounded(Fraction(cell))


def test_a_unit_multiplies_the_decimal_and_not_its_double(tmp_path):
    path = tmp_path / "degrees.csv"
    path.write_text("t,p [deg/s]\n0,0.123456789012345678\n")
    (cell,) = polhode.compare(path, SCENE).subject.columns["p"]
    with mpmath.workdps(60):
        ratio = mpmath.mpf(cell.numerator) / cell.denominator * 180 / mpmath.pi
        assert abs(ratio - mpmath.mpf("0.123456789012345678")) < 1e-50

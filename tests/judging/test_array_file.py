"""Files of arrays, times of a robot's clock, and what of them is refused."""

from __future__ import annotations

import io
import zipfile
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode import BadInput, cli
from polhode.judging.references.certified import Certified
from polhode.judging.tables import array_file
from polhode.scenes.vocabulary import STATE

TIMES = [Fraction(k, 4) for k in range(13)]
SCENE = "lagrange/nutation"


@pytest.fixture(scope="module")
def exact():
    """The exact motion in doubles: t, the state, the quaternion."""
    found = polhode.reference(SCENE)
    states, attitude = found.at(TIMES, 20), found.attitude(TIMES, 20)
    return [np.array(rows, dtype=float) for rows in (TIMES, states, attitude)]


def saved(path, **arrays):
    np.savez(path, **arrays)
    return path


def test_columns_and_arrays_of_three_or_four_are_read(exact, tmp_path):
    t, states, attitude = exact
    named = dict(zip(STATE, states.T, strict=True))
    omega, gamma = states[:, :3], states[:, 3:]
    for arrays in (
        {"t": t, **named},
        {"time": t, "omega": omega, "gamma": gamma},
        {"t": t, "gyro": omega, "gamma": gamma, "quaternion": attitude, "dt": np.array(0.1)},
        {"t": t, "w": omega, "gamma": gamma, "orientation": attitude},
    ):
        found = polhode.compare(saved(tmp_path / "x.npz", **arrays), SCENE)
        assert found.worst > 15
        assert found.subject.number.name == "double"
        assert len(found.digits) == len(TIMES)
        assert set(found.part_digits) >= {"omega", "gamma"}


def test_one_array_has_fields_or_names_beside_it(exact, tmp_path, capsys):
    t, states, _ = exact
    path = tmp_path / "x.npy"
    np.save(path, np.column_stack([t, states]))
    names = ",".join(("t", *STATE))
    assert cli.main(["compare", str(path), SCENE, "--columns", names, "--at-least", "15"]) == 0
    assert "correct digits" in capsys.readouterr().out
    assert cli.main(["compare", str(path), SCENE]) == 2
    assert "shape = (13, 7): expected fields with names" in capsys.readouterr().err
    fields = np.zeros(len(t), dtype=[(name, float) for name in ("t", *STATE)])
    for name, column in zip(("t", *STATE), (t, *states.T), strict=True):
        fields[name] = column
    np.save(path, fields)
    assert polhode.compare(path, SCENE).worst > 15


@pytest.mark.parametrize("number", ["double", "quad"])
def test_a_trajectory_that_polhode_saved_is_read_with_its_type(number, tmp_path):
    run = polhode.integrate(SCENE, number, at=TIMES)
    run.save(tmp_path / "x.npz")
    found = polhode.compare(tmp_path / "x.npz", SCENE)
    assert found.subject.number.name == number
    assert found.digits == polhode.compare(run).digits


def test_parquet_is_read_where_pandas_reads_it(exact, tmp_path, monkeypatch):
    pd = pytest.importorskip("pandas")
    t, states, _ = exact
    frame = pd.DataFrame({"t": t, **dict(zip(STATE, states.T, strict=True))})
    path = tmp_path / "x.parquet"
    path.write_bytes(b"as if")
    monkeypatch.setattr(pd, "read_parquet", lambda file: frame)
    assert polhode.compare(path, SCENE).worst > 15
    faults = (ImportError("pyarrow"), "pyarrow"), (ValueError("no\nfooter"), "(no)")
    for fault, expected in faults:

        def read(file, fault=fault):
            raise fault

        monkeypatch.setattr(pd, "read_parquet", read)
        with pytest.raises(BadInput) as error:
            polhode.compare(path, SCENE)
        assert expected in str(error.value)


def _npy(shape):
    file = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        file, {"descr": "<f8", "fortran_order": False, "shape": shape}
    )
    return file.getvalue()


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"t,p,q,r",
        b"\x93NUMPY\x01\x00",
        _npy((10**15,)),
        _npy((10**30, 7)),
        b"PK\x03\x04 and no more",
    ],
)
@pytest.mark.parametrize("ending", [".npz", ".npy"])
def test_what_numpy_did_not_write_is_one_line(content, ending, tmp_path):
    path = tmp_path / f"x{ending}"
    path.write_bytes(content)
    with pytest.raises(BadInput, match="arrays of numbers that NumPy wrote"):
        polhode.compare(path, SCENE)


def test_objects_bombs_and_false_archives_are_refused(exact, tmp_path, monkeypatch):
    path = tmp_path / "x.npz"
    np.savez(path, t=np.array([0, 1], dtype=object), p=np.zeros(2))
    with pytest.raises(BadInput, match="NumPy wrote"):
        polhode.compare(path, SCENE)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("t.npy", bytes(10**6))
    monkeypatch.setattr(array_file, "MAX_BYTES", 10**5)
    with pytest.raises(BadInput, match="bytes of arrays, more than 100000"):
        polhode.compare(path, SCENE)
    monkeypatch.undo()
    for about in ("[]", "{", '{"number": "double", "bits": 1000000000000000000}', '{"bits": 53}'):
        np.savez(path, about=np.array(about), times=np.array(["0"]), states=np.array([["1"] * 6]))
        with pytest.raises(BadInput, match="a trajectory that polhode saved"):
            polhode.compare(path, SCENE)
    for arrays, key in (
        ({"t": np.zeros(3), "omega": np.zeros((3, 2))}, "omega"),
        ({"t": np.zeros(3), "picture": np.zeros((3, 3))}, "picture"),
        ({"t": np.zeros(3), "p": np.zeros(2)}, "columns"),
        ({"p": np.zeros(3)}, "columns"),
        ({"t": np.array([1 + 1j]), "p": np.zeros(1)}, "t[1]"),
        ({"t": np.array(["now"]), "p": np.zeros(1)}, "t[1]"),
    ):
        np.savez(path, **arrays)
        with pytest.raises(BadInput) as error:
            polhode.compare(path, SCENE)
        assert error.value.key == key
        assert "\n" not in str(error.value)


# -- a robot's clock --------------------------------------------------------------------------


def stamped(exact, begin):
    t, states, attitude = exact
    nanoseconds = np.round(t % 1 * 1e9).astype(int)
    return {
        "header.stamp.sec": np.floor(t).astype(int) + begin,
        "header.stamp.nanosec": nanoseconds,
        "angular_velocity": states[:, :3],
        "orientation": attitude,
    }


@pytest.mark.parametrize("begin", [0, 1_700_000_000])
def test_seconds_and_nanoseconds_are_one_time(exact, tmp_path, begin):
    arrays = stamped(exact, begin)
    found = polhode.compare(saved(tmp_path / "x.npz", **arrays), SCENE)
    assert found.worst > 14
    assert [*found.times] == TIMES
    assert found.reading == (f"t from its first row on ({begin / 1e9:g}e+09)" if begin else None)
    header = [*("x.header.stamp.secs", "x.header.stamp.nsecs"), *("gyro_x", "gyro_y", "gyro_z")]
    rows = zip(*list(arrays.values())[:2], *arrays["angular_velocity"].T, strict=True)
    text = "\n".join([",".join(header), *(",".join(map(repr, map(float, row))) for row in rows)])
    text = text.replace("1700000000.0", "1700000000").replace("17000000", "17000000")
    (tmp_path / "x.csv").write_text(text)
    assert polhode.compare(tmp_path / "x.csv", SCENE).worst > 14


def test_a_motion_without_a_formula_begins_at_its_first_row_too(tmp_path):
    scene = "general/asymmetric-regular"
    run = polhode.integrate(scene, at=TIMES)
    t = np.array([float(x) for x in TIMES]) + 1.7e9
    columns = {"t": t, **{name: run.states[:, k] for k, name in enumerate(STATE)}}
    found = polhode.compare(columns, scene)
    assert found.reading == "t from its first row on (1.7e+09)"
    assert found.worst > 14
    with pytest.raises(BadInput):
        polhode.compare(columns, scene, as_it_stands=True)
    back = {name: values[::-1] for name, values in columns.items()}
    assert polhode.compare(back, scene).reading == found.reading


@pytest.mark.parametrize("scene", ["general/asymmetric-regular", "general/asymmetric-chaotic"])
def test_a_convention_is_told_without_a_proof_to_a_far_time(scene, monkeypatch):
    asked = []
    enclosure = Certified.enclosure

    def noted(self, times, *more):
        asked.append(max(abs(t) for t in times))
        return enclosure(self, times, *more)

    monkeypatch.setattr(Certified, "enclosure", noted)
    run = polhode.integrate(scene, at=TIMES)
    columns = {"t": run.t, **{name: run.states[:, k] for k, name in enumerate(STATE)}}
    swapped = columns | {"p": columns["q"], "q": columns["p"]}
    for times, words in ((run.t * 1000, "milliseconds"), (run.t + 1234.5, "t from 1234.5 on")):
        found = polhode.compare(swapped | {"t": times}, scene)
        assert words in found.reading
        assert "p q r = q p r" in found.reading
        assert found.worst > 11
    assert max(asked) <= 3


def test_rows_that_begin_later_are_as_they_are(exact):
    t, states, _ = exact
    columns = {"t": t[3:], **{name: states[3:, k] for k, name in enumerate(STATE)}}
    assert polhode.compare(columns, SCENE).reading is None
    wrong = columns | {"t": t[3:] - 0.5}  # no row is the start
    assert "from its first row" not in (polhode.compare(wrong, SCENE).reading or "")


@pytest.mark.parametrize(
    "names",
    [
        ("t", "stamp.sec"),
        ("stamp.sec", "stamp.secs"),
        ("stamp.nsec", "stamp.nanosec"),
        ("time", "%time"),
    ],
)
def test_two_times_are_refused(names):
    columns = {name: [0.0, 1.0] for name in (*names, "p")}
    with pytest.raises(BadInput, match="each column once"):
        polhode.compare(columns, SCENE)


# -- a threshold ------------------------------------------------------------------------------


def test_a_table_with_fewer_digits_than_wanted_ends_with_three(exact, tmp_path, capsys):
    t, states, attitude = exact
    attitude = attitude.copy()
    attitude[5] *= 1 + 1e-7
    path = saved(tmp_path / "x.npz", t=t, w=states[:, :3], gamma=states[:, 3:], q=attitude)
    assert cli.main(["compare", str(path), SCENE, "--at-least", "6"]) == 0
    assert cli.main(["compare", str(path), SCENE, "--at-least", "8", "--json"]) == 3
    told = capsys.readouterr().err.splitlines()[-1]
    assert "correct digits of attitude at t = 1.25, where at least 8 are wanted" in told
    for wrong in ("x", "nan", "inf"):
        assert cli.main(["compare", str(path), SCENE, "--at-least", wrong]) == 2
        assert "a number of digits" in capsys.readouterr().err

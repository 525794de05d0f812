"""What a gate refuses: tables with gaps, which have no digits there."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import polhode
from polhode import cli

SCENE = "lagrange/nutation"
STATE = ("p", "q", "r", "gamma1", "gamma2", "gamma3")
ATTITUDE = ("q0", "q1", "q2", "q3")
ANGLES = ("psi", "theta", "phi")
TIMES = [0.5 * k for k in range(9)]


@pytest.fixture(scope="module")
def columns():
    """All columns, right to the last digits."""
    run = polhode.integrate(replace(polhode.load(SCENE), outputs=("attitude", "angles")), at=TIMES)
    found = {"t": run.t}
    for names, rows in ((STATE, run.states), (ATTITUDE, run.attitude), (ANGLES, run.angles)):
        found |= {name: np.array([float(row[k]) for row in rows]) for k, name in enumerate(names)}
    return found


def some(columns, names, gaps=()):
    """Some columns, not a number in some rows (counted from 1)."""
    found = {name: np.array(columns[name]) for name in ("t", *names)}
    for name in names:
        found[name][[k - 1 for k in gaps]] = np.nan
    return found


def as_mapping(found, folder):
    return found


def as_frame(found, folder):
    return pytest.importorskip("pandas").DataFrame(found)


def as_npz(found, folder):
    np.savez(folder / "x.npz", **found)
    return folder / "x.npz"


def as_npy(found, folder):
    np.save(folder / "x.npy", np.rec.fromarrays([*found.values()], names=[*found]))
    return folder / "x.npy"


def as_parquet(found, folder):
    pytest.importorskip("pyarrow")
    as_frame(found, folder).to_parquet(folder / "x.parquet")
    return folder / "x.parquet"


def as_csv(found, folder):
    cells = [["" if x != x else repr(float(x)) for x in column] for column in found.values()]
    lines = [[*found], *zip(*cells, strict=True)]
    (folder / "x.csv").write_text("".join(",".join(line) + "\n" for line in lines))
    return folder / "x.csv"


FILES = (as_npz, as_npy, as_parquet, as_csv)
GAPS = [
    (STATE, range(1, 10), "p in row 1, t = 0"),
    (ATTITUDE, range(1, 10), "q0 in row 1, t = 0"),
    (ANGLES, range(1, 10), "psi in row 1, t = 0"),
    (STATE, range(4, 10), "p in row 4, t = 1.5"),
    (ATTITUDE, [9], "q0 in row 9, t = 4"),
]


@pytest.mark.parametrize("write", [as_mapping, as_frame, *FILES])
@pytest.mark.parametrize(("names", "gaps", "place"), GAPS)
def test_a_gap_is_refused_by_its_place(columns, tmp_path, write, names, gaps, place):
    mine = write(some(columns, names, gaps), tmp_path)
    assert polhode.testing.assert_digits(some(columns, names), SCENE, 12).worst > 12
    with pytest.raises(polhode.BadInput, match=rf": {place}: expected a number in each cell"):
        polhode.testing.assert_digits(mine, SCENE, 12)


@pytest.mark.parametrize("write", FILES)
@pytest.mark.parametrize(("names", "gaps", "place"), GAPS)
def test_the_command_refuses_it_too(columns, tmp_path, write, names, gaps, place, capsys):
    file = write(some(columns, names, gaps), tmp_path)
    assert cli.main(["compare", str(file), SCENE, "--at-least", "12"]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert place in told.err
    assert len(told.err.splitlines()) == 1


def test_a_gap_beside_a_good_state_is_refused(columns):
    mine = some(columns, STATE) | some(columns, ATTITUDE, range(1, 10))
    with pytest.raises(polhode.BadInput, match="q0 in row 1"):
        polhode.testing.assert_digits(mine, SCENE, 12)


def test_angles_that_the_motion_does_not_have_may_be_missing():
    """psi and phi of a top that sleeps."""
    top = replace(polhode.load("lagrange/sleeping-stable"), outputs=("angles",))
    run = polhode.integrate(top, at=[0, 1, 2])
    assert run.angles[1][0] is None or np.isnan(float(run.angles[1][0]))
    mine = {"t": run.t, **dict(zip(STATE, np.transpose(run.states), strict=True))}
    mine |= {name: [row[k] for row in run.angles] for k, name in enumerate(ANGLES)}
    assert polhode.testing.assert_digits(mine, top, 12).worst > 12
    with pytest.raises(polhode.BadInput, match="theta in row 1"):
        polhode.testing.assert_digits(mine | {"theta": [None] * 3}, top, 12)


@pytest.mark.parametrize("count", [9, 200])  # row by row, and all at once
def test_a_time_without_numbers_has_no_digits(count, tmp_path, capsys):
    run = polhode.integrate(SCENE, at=[0.25 * k for k in range(count)])
    mine = some({"t": run.t, **dict(zip(STATE, run.states.T, strict=True))}, STATE, range(5, 9))
    mine["p"][8:] = np.nan  # of omega q and r are left
    found = polhode.compare(mine, SCENE)
    assert [k for k, d in enumerate(found.digits) if d is None] == [4, 5, 6, 7]
    for name in ("omega", "gamma"):
        assert [k for k, d in enumerate(found.part_digits[name]) if d is None] == [4, 5, 6, 7]
    assert found.worst > 12
    assert cli.main(["compare", str(as_npz(mine, tmp_path)), SCENE, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["correct_digits"]
    assert told[4:8] == [None] * 4
    assert None not in [*told[:4], *told[8:]]


def test_a_table_without_numbers_has_no_digits(columns, tmp_path, capsys):
    file = as_csv(some(columns, STATE, range(1, 10)), tmp_path)
    found = polhode.compare(file, SCENE)
    assert found.digits == ()
    assert "correct digits" not in str(found)
    assert cli.main(["compare", str(file), SCENE, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["worst"] is None
    assert told["correct_digits"] == []


def test_where_nothing_can_be_judged_nothing_passes(tmp_path, capsys):
    """psi and phi of a top that sleeps: there are none, and there is nothing else."""
    case = "lagrange/sleeping-stable"
    with pytest.raises(polhode.BadInput, match="expected a number in a column that can be judged"):
        polhode.testing.assert_digits({"t": [0, 1], "psi": [None] * 2, "phi": [None] * 2}, case, 1)
    (tmp_path / "x.csv").write_text("t,psi,phi\n0,,\n1,,\n")
    assert cli.main(["compare", str(tmp_path / "x.csv"), case, "--at-least", "1"]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert len(told.err.splitlines()) == 1
    assert cli.main(["compare", str(tmp_path / "x.csv"), case]) == 0


@pytest.mark.slow
def test_the_command_judges_as_it_stands_unless_conventions_are_named(columns, tmp_path, capsys):
    mine = some(columns, STATE)
    for name in STATE[:3]:
        mine[name] = np.degrees(mine[name])
    gate = ["compare", str(as_csv(mine, tmp_path)), SCENE, "--at-least", "6"]
    assert cli.main(gate) == cli.main([*gate, "--as-it-stands"]) == 3
    assert cli.main([*gate, "--read", "degrees"]) == 0
    assert cli.main(gate[:-2]) == 0
    told = capsys.readouterr()
    assert "read as omega degrees" in told.out


@pytest.mark.parametrize(
    ("names", "ours", "there"),
    [
        (STATE, "gamma1", "gamma2, gamma3"),
        (STATE, "r", "p, q"),
        (ATTITUDE, "q2", "q0, q1, q3"),
    ],
)
def test_a_vector_with_a_misspelt_component_is_refused(
    columns, tmp_path, capsys, names, ours, there
):
    mine = {name if name != ours else "gam1": x for name, x in some(columns, names).items()}
    told = rf"{ours}: expected it beside {there} \(columns that are not known: gam1\)$"
    with pytest.raises(polhode.BadInput, match=told):
        polhode.testing.assert_digits(mine, SCENE, 7)
    file = as_csv(mine, tmp_path)
    assert cli.main(["compare", str(file), SCENE]) == 0
    capsys.readouterr()
    assert cli.main(["compare", str(file), SCENE, "--at-least", "7"]) == 2
    assert f"x.csv: {ours}: expected it beside" in capsys.readouterr().err


def test_components_of_rows_that_are_not_named_are_refused(columns):
    rows = np.transpose([columns["p"], columns["q"]])
    with pytest.raises(polhode.BadInput, match=r"states: r: expected it beside p, q$"):
        polhode.testing.assert_digits(rows, SCENE, 7, at=TIMES, columns=["p", "q"])


def test_whole_vectors_are_enough(columns):
    for names in (STATE[:3], STATE[3:], ATTITUDE, ["theta"]):
        assert polhode.testing.assert_digits(some(columns, names), SCENE, 12).worst > 12


def test_angles_without_whole_turns_pass_where_that_is_named(columns, tmp_path, capsys):
    mine = some(columns, ANGLES)
    mine["psi"] = np.remainder(mine["psi"] + np.pi, 2 * np.pi) - np.pi
    mine["phi"] = np.remainder(mine["phi"] + np.pi, 2 * np.pi) - np.pi
    gate = ["compare", str(as_csv(mine, tmp_path)), SCENE, "--at-least", "12"]
    assert cli.main(gate) == 3
    assert cli.main([*gate, "--read", "psi and phi up to whole turns"]) == 0
    assert "read as psi and phi up to whole turns" in capsys.readouterr().out
    mine["phi"] = np.degrees(mine["phi"])
    mine["psi"], mine["theta"] = np.degrees(mine["psi"]), np.degrees(mine["theta"])
    as_csv(mine, tmp_path)
    assert cli.main([*gate, "--read", "whole turns"]) == 3
    as_csv(some(columns, STATE), tmp_path)
    assert cli.main([*gate, "--read", "whole turns"]) == 2

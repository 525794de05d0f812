"""What a result may replace: nothing, or an unchanged file of a result of its kind."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from invented import Bare, Odd

import polhode
from polhode.cli import main
from polhode.results import writer
from polhode.results.reader import check_place
from polhode.results.writer import ENDINGS


def contents(folder: Path) -> dict[str, bytes]:
    return {x.name: x.read_bytes() for x in folder.iterdir()}


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_result_replaces_its_own_kind_alone(ending: str, tmp_path: Path) -> None:
    if ending == ".parquet":
        pytest.importorskip("pyarrow")
    path = tmp_path / f"x{ending}"
    path.write_bytes(b"")  # an empty file is nothing
    Odd(2).save(path)
    Odd(3).save(path)
    before = contents(tmp_path)
    with pytest.raises(polhode.BadInput, match="another name: it holds a result Odd"):
        Bare().save(path)
    assert contents(tmp_path) == before
    path.write_bytes(b"t,x\n1,2\n")
    changed = contents(tmp_path)
    with pytest.raises(polhode.BadInput, match="another name: "):
        Odd(3).save(path)
    assert contents(tmp_path) == changed


def test_a_table_that_was_changed_is_not_replaced(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    Odd().save(path)
    path.write_bytes(path.read_bytes() + b"\n")
    with pytest.raises(polhode.BadInput, match="it was changed since polhode wrote it"):
        Odd().save(path)


def test_facts_that_are_somebody_s_are_not_replaced(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    beside = writer.beside(path)
    beside.write_text('{"a": 1}')
    with pytest.raises(polhode.BadInput, match=r"x\.csv\.json: .* polhode did not write it"):
        Odd().save(path)
    assert not path.exists()
    beside.unlink()
    Odd().save(path)
    path.unlink()  # of a table that is gone the facts are replaced
    Odd(1).save(path)
    path.unlink()
    with pytest.raises(polhode.BadInput, match="it holds a result Odd"):
        Bare().save(path)


def test_the_name_of_a_table_s_facts_is_no_result_s(tmp_path: Path) -> None:
    """A result there would take the facts from a table that is whole."""
    Odd().save(tmp_path / "x.csv")
    before = contents(tmp_path)
    with pytest.raises(polhode.BadInput, match=r"another name: this is of the facts of x\.csv"):
        Odd().save(tmp_path / "x.csv.json")
    assert contents(tmp_path) == before
    names = ["x.csv", "x.csv.json"]
    for verb in ("run", "certify"):
        places = [word for name in names for word in ("-o", str(tmp_path / name))]
        assert main([verb, "lagrange/nutation", "--at", "1", *places]) == 2
    assert contents(tmp_path) == before


def test_json_that_is_cut_is_ours_still(tmp_path: Path) -> None:
    """What was cut, by a full disk, can be written again."""
    path = tmp_path / "x.json"
    Odd().save(path)
    whole = path.read_bytes()
    path.write_bytes(whole[:500])
    Odd().save(path)
    assert path.read_bytes() == whole


def test_inputs_and_folders_are_refused(tmp_path: Path) -> None:
    source = tmp_path / "x.csv.json"
    source.write_text("x")
    for path in (tmp_path / "x.csv", source):
        with pytest.raises(polhode.BadInput, match="another file than the one that is read"):
            check_place(path, "Odd", [source])
    with pytest.raises(polhode.BadInput, match="an existing folder"):
        Odd().save(tmp_path / "no" / "x.csv")
    (tmp_path / "y.csv").mkdir()
    with pytest.raises(polhode.BadInput, match="a file, not a folder"):
        Odd().save(tmp_path / "y.csv")


def test_links_are_followed(tmp_path: Path) -> None:
    Odd().save(tmp_path / "x.json")
    (tmp_path / "link.json").symlink_to(tmp_path / "x.json")
    Odd(1).save(tmp_path / "link.json")
    assert (tmp_path / "link.json").is_symlink()
    shutil.copy(tmp_path / "x.json", tmp_path / "y.json")
    with pytest.raises(polhode.BadInput, match="it holds a result Odd"):
        Bare().save(tmp_path / "link.json")

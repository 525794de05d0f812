"""``polhode list`` shows of each case what its file says, though it reads few of them."""

from __future__ import annotations

import json
import shutil

import pytest

from polhode.cli import main
from polhode.output.cases import entry_of
from polhode.scenes import library
from shared.tools import case_names


@pytest.mark.slow
def test_the_catalogue_is_of_the_files_as_they_are():
    again = {name: entry_of(name) for name in case_names()}
    maker = "python tests/measure/catalogue.py"
    assert library.written(again) == (library.folder() / library.FILE).read_text("utf-8"), maker


@pytest.fixture
def cases(tmp_path, monkeypatch):
    """A small library of its own."""
    for name in ("euler/sphere", "lagrange/nutation"):
        (tmp_path / name).parent.mkdir()
        shutil.copy(library.folder() / f"{name}.toml", tmp_path / f"{name}.toml")
    shutil.copy(library.folder() / library.FILE, tmp_path / library.FILE)
    monkeypatch.setattr(library, "folder", lambda: tmp_path)
    return tmp_path


def listed(capsys):
    assert main(["list", "--json"]) == 0
    columns = json.loads(capsys.readouterr().out)["columns"]
    rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    return {row["scene"]: row for row in rows}


def test_known_cases_are_listed_without_being_read(cases, capsys, monkeypatch):
    right = listed(capsys)
    assert right["lagrange/nutation"]["reference"] == "lagrange"
    monkeypatch.setattr(library, "load", lambda name: pytest.fail(name))
    assert listed(capsys) == right


@pytest.mark.parametrize("broken", ["gone", "{", "[]", '{"x": 1}'])
def test_a_changed_case_and_a_catalogue_that_is_none_are_seen(cases, capsys, broken):
    right = listed(capsys)
    path = cases / "euler/sphere.toml"
    path.write_text(path.read_text().replace("Sphere turning freely", "another"))
    changed = listed(capsys)
    assert changed["euler/sphere"] == right["euler/sphere"] | {"title": "another"}
    if broken == "gone":
        (cases / library.FILE).unlink()
    else:
        (cases / library.FILE).write_text(broken)
    assert listed(capsys) == changed

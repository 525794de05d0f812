"""Cases by their names: exactly those that ship, and nothing that is a path."""

from __future__ import annotations

import pytest

import polhode
from polhode.scenes import library
from shared.tools import case_names


def test_every_name_ships():
    assert all(map(library.ships, case_names()))


NO_NAMES = [
    *("", "/", "euler", "euler/", "/euler/sphere", "euler//sphere", "./euler/sphere", "sphere"),
    *("euler/../euler/sphere", "euler/sphere.toml", "euler/sphere.toml/x", "Euler/sphere"),
    *("euler/*", "euler/\0", "euler\nsphere", "euler/" + 300 * "x", 300 * "x"),
]


@pytest.mark.parametrize("name", NO_NAMES)
def test_what_is_no_name_is_refused(name):
    assert name not in case_names()
    assert not library.ships(name)
    with pytest.raises(polhode.BadInput):
        polhode.load(name)


def test_without_cases_a_path_is_read_all_the_same(tmp_path, monkeypatch):
    path = tmp_path / "own.toml"
    path.write_text(polhode.as_toml(polhode.top(moments=[1, 2, 2.5], omega=[1, 0, 0])))
    monkeypatch.setattr(library, "folder", lambda: tmp_path / "nowhere")
    assert polhode.load(path).omega == (1, 0, 0)
    with pytest.raises(polhode.BadInput, match="euler/sphere"):
        polhode.load("euler/sphere")


def test_a_top_stands_for_its_cases_unless_a_file_has_its_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    cases = [f"grioli/{name}" for name in ("irrational", "precession", "turned-axes")]
    assert library.matching(["grioli"]) == cases
    assert library.matching(["grioli/precession", "grioli"])[0] == "grioli/precession"
    assert library.matching(["griol"]) == ["griol"]
    (tmp_path / "grioli").write_text("schema = 1\n")
    assert library.matching(["grioli"]) == ["grioli"]

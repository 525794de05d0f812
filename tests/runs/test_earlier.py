"""JSON files that polhode 0.2 saved (tests/data/results-0.2.zip, made by that version)."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path
from typing import Any

import pytest

import polhode
from polhode.cli import main
from polhode.common.errors import DoubtfulInput
from polhode.runs.sweep import starts_file

KEPT = Path(__file__).parents[1] / "data" / "results-0.2.zip"
RUNS = ("run", "quad", "digits", "refined", "nogamma")
#: Of other kinds a column, and where the file has its numbers.
OTHERS = {
    "map": ("fli", lambda held: held["fli"]),
    "section": ("gamma3", lambda held: [row[5] for rows in held["states"] for row in rows]),
    "levels": ("h", lambda held: [x for arc in held["arcs"] for x in arc["h"]]),
    "frequencies": ("frequency", lambda held: [x["frequency"] for x in held["frequencies"]]),
    "search": ("r", lambda held: [x["state"][2] for x in held["orbits"]]),
    "family": ("period", lambda held: [x["period"] for x in held["orbits"]]),
}


def loaded(name: str, folder: Path) -> tuple[Any, dict[str, Any]]:
    """What load_result makes of a file, with a word, and what the file holds."""
    path = folder / f"{name}.json"
    with zipfile.ZipFile(KEPT) as held:
        path.write_bytes(held.read(path.name))
    with pytest.warns(DoubtfulInput, match=r"of polhode 0\.2; save it again"):
        found = polhode.load_result(path)
    return found, json.loads(path.read_text())


@pytest.mark.parametrize("name", RUNS)
def test_a_run_is_whole(name: str, tmp_path: Path) -> None:
    run, held = loaded(name, tmp_path)
    assert run.state_strings() == held["states"]
    assert run.time_strings() == held["times"]
    assert {k: x and f"{x:.3e}" for k, x in run.drift._asdict().items()} == held["drift"]
    if "digits_left" in held:
        assert run.digits_expected == pytest.approx(min(held["digits_left"]), abs=0.02)
    if "error" in held:
        assert [f"{x:.1e}" for x in run.errors] == held["error"]
    for word in ("angles", "attitude"):
        assert (getattr(run, word) is not None) == (word in held)
    half = run.reached / 2
    again = polhode.integrate(run.scene, run.number, method=run.method)
    assert abs(run(half) - again(half)).max() < 1e-13
    run.save(tmp_path / "new.npz")
    assert polhode.load_result(tmp_path / "new.npz") == run


@pytest.mark.parametrize("name", OTHERS)
def test_of_another_result_the_columns_are_read(name: str, tmp_path: Path) -> None:
    found, held = loaded(name, tmp_path)
    column, of = OTHERS[name]
    assert list(found.column(column)) == of(held)
    assert found.fact("scene") in (held.get("scene_name"), held.get("scene"), held.get("source"))
    found.save(tmp_path / "new.json")
    again = polhode.load_result(tmp_path / "new.json")
    assert (again.kind, again.to_json()) == (found.kind, found.to_json())


def test_of_one_without_rows_the_facts_are_read(tmp_path: Path) -> None:
    found, held = loaded("orbit", tmp_path)
    assert found.fact("period") == held["period"]
    assert found.fact("digits") == 20


def test_the_command_says_a_word_and_events_are_refused(tmp_path, capsys, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    loaded("run", tmp_path)
    assert main(["compare", "run.json", "lagrange/nutation"]) == 0
    assert "run.json: a result Trajectory of polhode 0.2" in capsys.readouterr().err
    with zipfile.ZipFile(KEPT) as held:
        Path("events.json").write_bytes(held.read("events.json"))
    with pytest.raises(polhode.BadInput, match="with events, which are found otherwise"):
        polhode.load_result("events.json")


def test_a_run_is_shown_and_of_others_a_figure_is_refused(tmp_path, capsys, monkeypatch) -> None:
    """A page asked for --scene, a figure blamed a column or a fact."""
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    for name in ("run", "map", "levels", "section", "orbit"):
        loaded(name, tmp_path)
    assert main(["view", "run.json", "--end", "1", "-o", "run.html"]) == 0
    assert main(["plot", "run.json", "--end", "1", "-o", "run.svg"]) == 0
    capsys.readouterr()
    for name, kind in (("map", "ChaosMap"), ("levels", "Levels"), ("section", "Section")):
        assert main(["plot", f"{name}.json", "-o", "x.svg"]) == 2
        assert f"expected a file of polhode 0.3: this {kind} lacks" in capsys.readouterr().err
    assert not Path("x.svg").exists()


@pytest.mark.parametrize("change", ["a state", "a sum", "a class", "no result"])
def test_one_that_was_changed_is_refused(change: str, tmp_path: Path) -> None:
    path = tmp_path / "run.json"
    held = loaded("run", tmp_path)[1]
    stored = json.loads(held["result"])
    if change == "a state":
        stored["value"]["run"][3][1]["a"][2][0] = "0.5"
    elif change == "a sum":
        stored["sum"] = "0" * 64
    elif change == "a class":
        stored["kind"] = "Path"
    held["result"] = json.dumps(stored) if change != "no result" else "{}"
    path.write_text(json.dumps(held))
    with pytest.raises(polhode.BadInput) as refusal:
        polhode.load_result(path)
    assert "\n" not in str(refusal.value)


@pytest.mark.filterwarnings("ignore::polhode.common.errors.DoubtfulInput")
def test_crossings_of_a_section_are_starts(tmp_path: Path) -> None:
    _, held = loaded("section", tmp_path)
    scene = polhode.load(held["scene"])
    starts = starts_file.read(tmp_path / "section.json", scene)
    assert starts.tolist() == [row for rows in held["states"] for row in rows]

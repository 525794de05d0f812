"""Every kind of result: what it tells, in files of every ending, read again."""

import copy
import json
import pickle
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from invented import ENDINGS

import polhode
from polhode import Result, load_result
from polhode.numbers.decimals import Ball
from polhode.results.table import Column, Fact, Table
from polhode.results.writer import written_facts, written_table
from shared.results import CERTIFIED, MAKERS, result_of_kind, watched
from shared.tools import tiers

#: Whose files hold a table of them, at the times of their scene.
TABULATED = ("Reference", "Certified", "Textbook")
WITHOUT_SCENE = (
    *("About", "Cases", "CheckReport", "CheckReport of bands", "EventTimes", "CertifiedEvents"),
    *("FieldComparison", "ObservedOrder", "Report", "Verdict"),
)


def saved(result: Any, path: Path) -> dict[str, bytes]:
    """The files of a result in a folder of its own, by name."""
    if path.suffix == ".parquet":
        pytest.importorskip("pyarrow")
    path.parent.mkdir(exist_ok=True)
    result.save(path)
    return {x.name: x.read_bytes() for x in path.parent.iterdir()}


QUICK = {"About", "Trajectory", "Conditioning", "Reductions", "Frequencies", "ProvedStability"}
BY_NAME = tiers([x for x in MAKERS if x in QUICK], [x for x in MAKERS if x not in QUICK])
#: Each kind with an ending, of certificates none that is one; its command writes all of them.
FILES = [
    (".npz" if name in CERTIFIED and k % 4 == 1 else ENDINGS[k % 4], name)
    for k, name in enumerate(MAKERS)
]
FIRST = [(ending, name) for ending, name in FILES if name in QUICK]


@pytest.mark.parametrize(("ending", "name"), tiers(FIRST, [x for x in FILES if x not in FIRST]))
def test_a_result_is_read_and_written_again_to_the_same_bytes(
    name: str, ending: str, tmp_path: Path
) -> None:
    result = result_of_kind(name)
    content = result.content()
    written = saved(result, tmp_path / f"first/x{ending}")
    again = load_result(tmp_path / f"first/x{ending}")
    assert saved(again, tmp_path / f"second/x{ending}") == written
    if hasattr(again, "result"):  # as it was saved, of no class of its own
        assert again.result == content.kind
        assert repr(again) == f"<Saved {content.title[1:]}"
        facts = {x.name for x in content.facts}
        columns = {x.name for x in content.table.columns} - facts
        assert facts | columns <= {*dir(again)}
        for names, value in ((facts, again.fact), (columns, again.column)):
            for name_of in names - {*dir(type(again))}:
                assert repr(getattr(again, name_of)) == repr(value(name_of))
    else:
        assert again == result
    alike = zip(again.content().table.columns, content.table.columns, strict=True)
    for first, second in alike:
        assert first.name == second.name
        if first.type in ("double", "integer", "truth", "text", "exact"):
            pairs = zip(first.values, second.values, strict=True)
            gaps = (np.nan, None, "")
            assert all(
                a == b or ((a != a or a in gaps) and (b != b or b in gaps)) for a, b in pairs
            )


@pytest.mark.parametrize("name", BY_NAME)
def test_names_are_names_once_and_the_scene_comes_first(name: str) -> None:
    content = result_of_kind(name).content()
    columns = [x.name for x in content.table.columns]
    facts = [x.name for x in content.facts]
    assert len({*columns}) == len(columns)
    assert len({*facts}) == len(facts)
    assert "about" not in columns
    tables = [x for x in content.facts if isinstance(x.value, type(content.table))]
    inner = [f"{x.name}.{column.name}" for x in tables for column in x.value.columns]
    assert {*inner}.isdisjoint(columns)
    if name not in WITHOUT_SCENE:
        assert facts[0] == "scene"
        assert facts[-1] == "provenance"
        assert "seconds" not in dict(content.facts[-1].value)
    assert name in TABULATED or content.title == repr(result_of_kind(name))
    for column in content.table.columns[: content.table.labels]:
        assert None not in [*column.values]
    answer = json.loads(result_of_kind(name).to_json(), parse_constant=lambda text: 1 / 0)
    assert answer["about"]["columns"].keys() == answer["columns"].keys()
    reserved = "format", "result", "version", "title", "labels", "about", "columns", "sha256"
    assert {*facts}.isdisjoint(reserved)
    assert {*answer["about"]["facts"]} == {*answer} - {*reserved}


#: Which take little, made a second time.
VALUES = [
    *("Trajectory", "Trajectory in quad", "Reference", "Certified", "Conditioning", "Enclosure"),
    *("CertifiedEvents", "EventTimes", "Judgement", "Ensemble", "Lyapunov"),
]


@pytest.mark.parametrize("name", VALUES)
def test_results_compare_by_value_pickle_and_print_short(name: str) -> None:
    first, second = result_of_kind(name), MAKERS[name]()
    assert first == second != result_of_kind("About")
    again = pickle.loads(pickle.dumps(first))
    assert again == first
    assert repr(again) == repr(first)
    assert "0x" not in repr(first)
    assert len(repr(first)) < 250


@pytest.mark.parametrize("ending", [".json", ".csv", ".npz"])
def test_a_loaded_orbit_has_what_an_orbit_has(ending: str, tmp_path: Path) -> None:
    """It was called <Orbit ...>, was of the kind "Orbit", and had no period."""
    live, path = result_of_kind("Orbit"), tmp_path / f"x{ending}"
    live.save(path)
    again = load_result(path)
    assert repr(again) == repr(live).replace("<", "<Saved ")
    assert (again.result, again.kind) == ("Orbit", live.kind) == ("Orbit", "elliptic")
    for name in ("period", "h", "f"):
        assert getattr(again, name) == getattr(live, name)
    assert again.residue == again.fact("residue") == pytest.approx(float(live.residue), rel=1e-15)
    with pytest.raises(AttributeError, match=r"has no perod: .*'period'"):
        _ = again.perod
    assert pickle.loads(pickle.dumps(again)) == copy.copy(again) == again


def test_the_class_s_name_is_still_the_kind_of_what_has_none(tmp_path: Path) -> None:
    result_of_kind("Levels").save(tmp_path / "x.json")
    with pytest.warns(DeprecationWarning, match="result"):
        assert load_result(tmp_path / "x.json").kind == "Levels"


def test_a_result_is_made_of_every_kind_that_there_is() -> None:
    for name in polhode.__all__:  # all rooms are imported
        getattr(polhode, name)

    def all_of(kind: type) -> Iterator[type]:
        for below in kind.__subclasses__():
            yield below
            yield from all_of(below)

    ours = {x.__name__ for x in all_of(Result) if x.__module__.startswith("polhode")}
    made = {name.partition(" ")[0] for name in MAKERS} - {*TABULATED}
    assert ours - {"SweepResult", "Theorem", "Saved"} == made  # which are written and read


SCENE = replace(watched(), outputs=("angles", "attitude", "hodographs"))
RUNS: dict[str, dict[str, Any]] = {
    "double": {"scene": "lagrange/nutation"},
    "events": {"scene": SCENE, "at": [1, 2, 10]},
    "events in quad": {"scene": SCENE, "number": "quad", "at": [1, 2]},
    "extended": {"scene": SCENE, "number": "extended", "at": [1, "7/3"]},
    "quad": {"scene": SCENE, "number": "quad", "at": [1, "7/3"]},
    "60 digits": {"scene": "kovalevskaya/generic", "digits": 60, "at": [1, 2]},
    "without gamma": {"scene": "euler/largest-axis", "at": [0, 1]},
    "an array of times": {"scene": "euler/largest-axis", "at": np.linspace(0, 1, 7)},
    "an array in extended": {
        "scene": "euler/largest-axis",
        "at": np.linspace(0, 1, 7),
        "number": "extended",
    },
    "cut short": {"scene": "euler/long", "max_steps": 100},
    "nothing": {"scene": "euler/long", "max_steps": 1, "at": [1e3]},
    "nothing in quad": {"scene": "lagrange/nutation", "number": "quad", "at": [1], "max_steps": 2},
    "from a pole": {"scene": "lagrange/upper-pole", "at": [0, 1]},
    # more digits than a number of a scene file may have, a tolerance below all doubles
    "350 digits": {"scene": "euler/sphere", "digits": 350, "at": ["1e-3000"]},
    "a scene of no file": {"scene": polhode.top(moments=[1, 2, 2.5], omega=[1, 0.1, 0], end=1)},
    "projected": {"scene": "kovalevskaya/generic", "at": [1000]},
    "refined": {"scene": "lagrange/nutation", "number": "quad", "method": "refined", "at": [30]},
    "rounded inputs": {
        "scene": "lagrange/nutation",
        "number": "quad",
        "inputs": polhode.NumberType("double", 53),
        "at": [1],
    },
    "few bits": {"scene": SCENE, "number": polhode.NumberType("mp", 50), "at": [1, "4/3"]},
    "as many bits as a double": {
        "scene": SCENE,
        "number": polhode.NumberType("mp", 53),
        "at": [1, "4/3"],
    },
    "as many bits as extended": {"scene": SCENE, "number": "mp", "digits": 5, "at": [1, "4/3"]},
}


RUN_FILES = [(ENDINGS[k % 4], name) for k, name in enumerate(RUNS)]


@pytest.mark.parametrize(("ending", "name"), tiers(RUN_FILES[::2], RUN_FILES[1::2]))
def test_a_run_comes_back_whole(name: str, ending: str, tmp_path: Path) -> None:
    run = polhode.integrate(**RUNS[name])
    written = saved(run, tmp_path / f"first/x{ending}")
    again = load_result(tmp_path / f"first/x{ending}")
    assert again == run
    assert again.drift == run.drift
    assert again.digits_expected == run.digits_expected
    assert again.lost_after == run.lost_after
    assert again.scene.source == run.scene.source
    assert saved(again, tmp_path / f"second/x{ending}") == written
    half = run.reached / 2
    assert [*again(half)] == [*run(half)]


def test_two_runs_of_one_scene_have_the_same_bytes(tmp_path: Path) -> None:
    first, second = (polhode.integrate("lagrange/nutation", at=[1, 2]) for _ in range(2))
    assert first.provenance["seconds"] != second.provenance["seconds"]
    assert saved(first, tmp_path / "first/x.npz") == saved(second, tmp_path / "second/x.npz")


RUN_CHANGES = {
    "another time": lambda run: run["columns"].update(t=[1.0, 3.0]),
    "times out of order": lambda run: run["columns"].update(t=[2.0, 1.0]),
    "a state that is none": lambda run: run["columns"].update(p=["inf", None]),
    "fewer columns": lambda run: (run["columns"].pop("p"), run["about"]["columns"].pop("p")),
    "a wider state": lambda run: (
        run["about"]["columns"]["p"].update(type="64 bits"),
        run["columns"].update(p=["1", "2"]),
    ),
    "an outcome": lambda run: run.update(outcome="arrived"),
    "a number type": lambda run: run.update(number="half"),
    "bits of another type": lambda run: run.update(bits=54),
    "bits of mp": lambda run: run.update(number="mp", bits=10),
    "no steps": lambda run: run.update(steps=-1),
    "a method": lambda run: run.update(method="guess"),
    "a tolerance": lambda run: run.update(tolerance=-1.0),
    "digits": lambda run: run.update(digits=10**9),
    "a provenance": lambda run: (
        run.update(provenance="x"),
        run["about"]["facts"]["provenance"].update(type="text"),
    ),
    "a scene": lambda run: run.update(scene_text="schema = 2"),
    "no scene": lambda run: run.update(scene_text=None),
    "a scene of other outputs": lambda run: run.update(
        scene_text=run["scene_text"].replace("[2, 2, 1]", "[1, 1, 9]").replace("1", "x", 1)
    ),
    "a projection": lambda run: (
        run.update(projection={"onto": 3}),
        run["about"]["facts"].update(projection={"type": "object"}),
    ),
    "a fact that is gone": lambda run: (run.pop("reached"), run["about"]["facts"].pop("reached")),
    "a name of an event": lambda run: run["events"]["event"].__setitem__(0, "another"),
    "a sign of an event": lambda run: run["events"]["sign"].__setitem__(0, 7),
    "a time of an event": lambda run: run["events"]["t"].__setitem__(0, None),
    "a state of an event": lambda run: run["events"]["p"].__setitem__(0, None),
}


@pytest.mark.parametrize("name", RUN_CHANGES)
def test_a_run_that_is_none_is_refused_in_one_line(name: str, tmp_path: Path) -> None:
    saved_run = result_of_kind("Trajectory")
    if name.endswith("of an event"):
        saved_run = polhode.integrate(watched(), number="quad", at=[2])
    run = json.loads(saved_run.to_json())
    path = tmp_path / "x.json"
    path.write_text(json.dumps(run))
    assert load_result(path) == saved_run
    RUN_CHANGES[name](run)
    path.write_text(json.dumps(run))
    with pytest.raises(polhode.BadInput, match=r"^[^\n]*$"):
        load_result(path)


def test_a_ball_in_a_file_holds_the_ball() -> None:
    """The two numbers that are written are true by themselves."""
    draw = np.random.default_rng(3)
    balls = [Ball(Fraction(1, 3), 0.0), Ball(Fraction(7), 1e-30), Ball(Fraction(-5), 3.0), None]
    for _ in range(200):
        centre = Fraction(draw.normal()) * Fraction(10) ** int(draw.integers(-40, 40)) / 3
        balls.append(Ball(centre, float(10.0 ** draw.uniform(-60, 30))))
    columns = written_table(Table([Column("x", balls), Column("k", [1] * len(balls))])).columns
    assert [x.name for x in columns] == ["x", "k", "x_radius"]
    for ball, centre, radius in zip(balls, columns[0].values, columns[2].values, strict=True):
        if ball is None:
            assert centre is radius is None
        elif ball.radius:
            gap = abs(ball.centre - centre) + Fraction(ball.radius)
            assert gap <= Fraction(radius)
            assert radius <= 1.02 * ball.radius
    near, far = written_facts([Fact("x", Ball(Fraction(1, 3), np.inf), unit="s")])
    assert (near.value, far.name, far.value, far.unit) == (0, "x_radius", np.inf, "s")


@pytest.mark.parametrize("name", BY_NAME)
def test_frames_are_the_table(name: str) -> None:
    pytest.importorskip("pandas")
    pytest.importorskip("xarray")
    result = result_of_kind(name)
    frame, table = result.to_pandas(), result.content().table
    names = [x.name for x in table.columns]
    assert [*frame.index.names, *frame.columns] == names or table.labels == 0
    assert len(frame) == table.rows
    assert {*frame.columns} <= {*map(str, result.to_xarray().variables)}
    assert result._repr_html_().startswith(("<table", "<p", "<pre"))
    assert repr(result).startswith(tuple(f"<{x.__name__}" for x in type(result).__mro__))


def test_what_is_varied_stands_in_the_rows_of_its_member() -> None:
    """Of a product the last key changes fastest; of arrays each member has its own numbers."""
    vary = {"start.omega[1]": ["1/3", "1/2"], "start.omega[3]": [2, 3, "sqrt(5)"]}
    many = polhode.integrate_many("lagrange/nutation", vary, at=[0, 1])
    expected = [Fraction(1, 3)] * 6 + [Fraction(1, 2)] * 6
    assert many.column("start.omega[1]") == expected
    (*exact, irrational) = many.column("start.omega[3]")[:6:2]
    assert exact == [2, 3]
    assert float(irrational) == 5**0.5
    assert many.column("member").tolist() == [1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6]
    assert many.column("t") == [0.0, 1.0] * 6
    assert many.column("p")[2] == many[1].states[0, 0]
    starts = np.array([[1, 0, 2, 0, 0, 1], [0.1, 0, 3, 0, 0, 1.0]])
    arrays = polhode.integrate_many("lagrange/nutation", starts=starts, at=[1])
    assert arrays.column("start.omega[1]").tolist() == [1.0, 0.1]
    assert arrays.column("start.omega[3]").tolist() == [2.0, 3.0]


def test_a_document_has_a_line_a_column() -> None:
    assert '\n  "L_over_G": [' in result_of_kind("Section").to_json()

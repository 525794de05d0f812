"""Files that polhode saved are judged as what they are; one that was changed as any other table."""

from __future__ import annotations

import json
import os

import pytest

import polhode
from polhode import cli

SCENE = "lagrange/nutation"
TIMES = ["1/10", "7/10", "2.3", "10/3"]


@pytest.fixture(scope="module")
def run():
    return polhode.integrate(SCENE, at=TIMES)


@pytest.fixture(scope="module")
def judged(run):
    return polhode.compare(run)


@pytest.mark.slow
@pytest.mark.parametrize(("ending", "number"), [("csv", "double"), ("npz", "extended")])
def test_a_run_is_judged_as_itself(tmp_path, ending, number):
    run = polhode.integrate(SCENE, at=TIMES, number=number)
    path = tmp_path / f"x.{ending}"
    run.save(path)
    judgement, alone = polhode.compare(path, SCENE), polhode.compare(run)
    assert judgement.digits == alone.digits
    assert judgement.part_digits == alone.part_digits
    assert judgement.drift == alone.drift
    assert judgement.limit == alone.limit
    assert judgement.times == alone.times  # of thirds, rounded to the type
    own = f"polhode's own run of {SCENE} in {number} ({run.number.bits} bits)"
    assert judgement.subject.remarks == (own,)
    assert own in str(polhode.compare(path, "lagrange/looping"))  # of which scene it is, then
    assert str(judgement.subject.name) == f"x.{ending}"


def test_what_a_file_says_of_its_digits_is_not_believed(tmp_path, run, judged):
    """JSON has no digest: columns that are changed by hand have their own drift."""
    path = tmp_path / "x.json"
    run.save(path)
    document = json.loads(path.read_text())
    document["columns"]["p"][-1] *= 1.001
    path.write_text(json.dumps(document))
    judgement = polhode.compare(path, SCENE)
    assert judgement.worst < 4
    assert judged.drift.h < 1e-14 < 1e-6 < judgement.drift.h < 1e-2


@pytest.mark.slow
def test_a_run_of_another_scene_is_another_table(tmp_path, run):
    """Its integrals are those of the scene that it is judged against."""
    run.save(tmp_path / "x.npz")
    judgement = polhode.compare(tmp_path / "x.npz", "lagrange/looping")
    assert judgement.worst < 1
    assert judgement.drift.h > 1e-3


def test_readings_that_were_told_are_applied(tmp_path, run):
    run.save(tmp_path / "x.npz")
    judgement = polhode.compare(tmp_path / "x.npz", SCENE, read="omega degrees")
    assert judgement.worst < 1
    assert judgement.reading == "omega degrees"


def test_columns_that_were_named_are_taken(tmp_path, run):
    run.save(tmp_path / "x.npz")
    judgement = polhode.compare(tmp_path / "x.npz", SCENE, columns=["p=-p"], as_it_stands=True)
    assert judgement.worst < 1


def test_a_run_that_reached_no_time_has_no_rows(tmp_path):
    scene = polhode.load(SCENE).at([1])
    run = polhode.integrate(scene, max_steps=1)
    assert not run.times
    run.save(tmp_path / "x.json")
    with pytest.raises(polhode.BadInput, match="rows: expected a time that the run reached"):
        polhode.compare(tmp_path / "x.json", SCENE)


def test_other_results_are_judged_by_their_columns(tmp_path):
    """Balls of an enclosure by their midpoints, which are decimals."""
    scene = polhode.load(SCENE).at(["1/2", "1"])
    polhode.certify(scene, digits=20).save(tmp_path / "x.npz")
    judgement = polhode.compare(tmp_path / "x.npz", scene)
    assert judgement.worst > 20
    (note,) = judgement.notes
    assert note.startswith("columns digits_proven p_radius q_radius ")
    assert note.endswith(" are not known and were not judged")


def changed(tmp_path, run):
    path = tmp_path / "x.csv"
    run.save(path)
    text = path.read_text().replace("\n0.1,", "\n0.10,")
    path.write_text(text)
    return path


def test_a_table_that_was_changed_is_any_table_and_that_is_told(tmp_path, run, judged):
    path = changed(tmp_path, run)
    judgement = polhode.compare(path, SCENE)
    sentence = "x.csv.json was not read: the table was changed since then"
    assert sentence in judgement.subject.remarks
    assert sentence in str(judgement)
    assert judgement.subject.run is None
    assert judgement.worst == pytest.approx(judged.worst, abs=1.5)


@pytest.mark.parametrize(
    "make", [os.mkfifo, lambda place: place.symlink_to("/dev/zero"), lambda place: place.mkdir()]
)
@pytest.mark.parametrize("beside", ["x.csv.json", "x.json"])
def test_what_is_no_file_is_not_waited_for(tmp_path, run, make, beside):
    path = changed(tmp_path, run)
    os.remove(tmp_path / "x.csv.json")
    make(tmp_path / beside)
    assert polhode.compare(path, SCENE).subject.run is None


@pytest.mark.parametrize(
    ("name", "text", "refusal_text"),
    [
        ("x.json", "{}", "x.json: file: expected a result that polhode saved"),
        ("x.json", "[" * 50_000, "x.json: file: expected a result that polhode saved"),
        ("x.npz", "PK", "x.npz: file: expected arrays of numbers that NumPy wrote"),
    ],
)
def test_other_files_are_refused_in_one_line(tmp_path, capsys, name, text, refusal_text):
    path = tmp_path / name
    path.write_text(text)
    assert cli.main(["compare", str(path), SCENE]) == 2
    _, err = capsys.readouterr()
    assert refusal_text in err
    assert err.count("\n") == 1


def test_a_file_that_was_cut_off_is_refused(tmp_path, run):
    run.save(tmp_path / "x.json")
    data = (tmp_path / "x.json").read_text()
    (tmp_path / "x.json").write_text(data[:-20])
    with pytest.raises(polhode.BadInput, match="a result that polhode saved"):
        polhode.compare(tmp_path / "x.json", SCENE)

"""Accuracy reports: every number is found again by compare and by what verdicts mean."""

import json
import re
import sys
import xml.etree.ElementTree as ET
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import polhode
from polhode import BadInput
from polhode.cli import main
from polhode.common.interrupts import heard
from shared.tools import tiers

TOP = "lagrange/nutation"
TIMES = np.linspace(0, 2, 9)
HEADER = "t,p,q,r,gamma1,gamma2,gamma3"


def table(path: Path, t: np.ndarray, rows: np.ndarray) -> str:
    np.savetxt(path, np.column_stack([t, rows]), "%.17g", ",", header=HEADER, comments="")
    return str(path)


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> dict[str, str]:
    """A right file, one that drifts, a wrong one; and a method's with two steps."""
    folder = tmp_path_factory.mktemp("files")
    t, rows = TIMES, polhode.integrate(TOP, at=TIMES).states
    drifting, wrong = rows.copy(), rows[:, ::-1] ** 2
    drifting[:, 0] += 1e-9 * t**4
    paths = {
        "right": table(folder / "right.csv", t, rows),
        "drifting": table(folder / "drifting.csv", t, drifting),
        "wrong": table(folder / "wrong.csv", t, wrong),
    }
    f = polhode.field(TOP)
    for steps in (256, 512):
        y, h, rows = f.start, 2 / steps, [f.start]
        for k in range(steps):
            y = y + h * f(0, y + h / 2 * f(0, y))
            rows += [y] * ((k + 1) % (steps // 8) == 0)
        paths[f"mid{steps}"] = table(folder / f"mid{steps}.csv", t, np.array(rows))
    return paths


@pytest.fixture(scope="module")
def report(files) -> polhode.Report:
    """Of one scene, with a right file and a wrong one."""
    return polhode.report(TOP, files["right"], files["wrong"], at=TIMES, number="double")


@pytest.fixture(scope="module")
def methods(files) -> polhode.Report:
    """With a file that drifts, and two of one method."""
    named = f"{files['mid256']}=20ms,h=0.0078125", f"{files['mid512']}=0.04s,h=0.00390625"
    return polhode.report(TOP, *named, files["drifting"], at=TIMES, number="double")


def rows(report: polhode.Report, name: str) -> list[dict[str, object]]:
    columns = report.tables[name].columns
    cells = zip(*(x.values for x in columns), strict=True)
    return [dict(zip((x.name for x in columns), row, strict=True)) for row in cells]


# -- numbers ---------------------------------------------------------------------------------------


@pytest.mark.slow
def test_every_number_is_found_again_by_compare(report, files):
    scene = polhode.load(TOP)
    own = polhode.compare(polhode.integrate(report.sections[0].scene), details=True)
    (run,) = rows(report, "runs")
    assert (run["digits"], run["limit"]) == (own.worst, own.limit)
    digits = [x for x in rows(report, "digits") if x["of"] == "double"]
    fewest = np.min([own.digits, *own.part_digits.values()], axis=0)
    assert [x["correct_digits"] for x in digits] == fewest.tolist()
    assert [x["digits_expected_least"] for x in digits] == [band.least for band in own.expected]
    assert run["digits_end"] == fewest[-1]
    for line in rows(report, "files"):
        judged = polhode.compare(str(line["file"]).partition("=")[0], scene)
        assert line["digits"] == judged.worst
        assert line["t_of_digits"] == float(judged.worst_time)
        assert line["sentence"] == judged.verdict


@pytest.mark.parametrize(
    ("end", "runs"), tiers([(2, ["double"])], [(200, ["double, not projected", "double"])])
)
def test_the_drift_of_a_run_that_is_not_projected_stands_beside_one_that_was_corrected(end, runs):
    """It stood there a second time, to the digit, where a run was too short for a correction."""
    drifts = rows(polhode.report(TOP, at=[end], number="double"), "drift")
    assert [x["of"] for x in drifts] == runs
    assert len({x["h"] for x in drifts}) == len(runs)


def test_a_right_and_a_wrong_file_are_told_apart(report):
    right, wrong = rows(report, "files")
    assert (right["verdict"], wrong["verdict"]) == ("good", "bad")
    (overview,) = rows(report, "overview")
    assert (overview["verdict"], overview["limit"]) == ("bad", wrong["limit"])  # of the worst file
    assert wrong["limit"] != right["limit"]
    assert right["half_lost_after"] is None
    assert wrong["lost_after"] == 0.0


@pytest.mark.slow
def test_a_file_that_drifts_and_those_of_a_method_are_told_by_their_digits(methods):
    first, second, drifting = rows(methods, "files")
    assert [x["verdict"] for x in (first, second, drifting)] == ["fair", "fair", "good"]
    assert 0.5 < second["digits"] - first["digits"] < 0.7  # of order 2
    # 1e-9 t^4 at t = 2, over the largest rate, which is above 4
    assert 8 < drifting["digits"] < 9
    assert 0 < first["half_lost_after"] < 1


def test_digits_wanted_decide_the_verdict(files):
    report = polhode.report(TOP, files["drifting"], at=TIMES, number="double", digits=12)
    assert report.sections[0].verdict == "fair"


@pytest.mark.slow
def test_what_a_file_cost_and_its_step_are_taken_from_its_name(methods):
    (order,) = rows(methods, "orders")
    assert 1.9 < order["order"] < 2.1
    work = [x for x in rows(methods, "work") if x["of"] != "double"]
    assert [x["seconds"] for x in work] == [0.02, 0.04]


def test_files_of_a_method_without_steps_are_told_how_a_report_is_given_them(files):
    """It named an option that reports do not have."""
    told = polhode.report(TOP, files["mid256"], files["mid512"], at=TIMES, number="double")
    (text,) = told.sections[0].words["orders"]
    assert "the step sizes of the method after each name, FILE=h=0.01: the files' rows" in text
    assert "--steps" not in text


def test_a_prepared_run_has_the_digits_of_its_tolerance(report):
    prepared = [x for x in rows(report, "work") if x["of"] == "double"]
    assert [x["tolerance"] for x in prepared][:2] == [2.0**-52, 1e-4]
    by_tolerance = [x["digits"] for x in sorted(prepared, key=lambda x: -x["tolerance"])]
    assert by_tolerance[0] < 7 < 13 < by_tolerance[-1] <= 16
    assert all(0 < x["seconds"] < 1 for x in prepared)


def test_tables_survive_a_file(report, tmp_path):
    report.save(tmp_path / "x.json")
    again = polhode.load_result(tmp_path / "x.json")
    for name in ("runs", "digits", "files", "work", "drift"):
        columns = again.fact(name)
        assert [x.name for x in columns.columns] == [x.name for x in report.tables[name].columns]
        assert columns.rows == report.tables[name].rows > 0
    assert again.column("scene")[0] == TOP


def test_what_has_no_scene_before_it_must_hold_one(files, tmp_path):
    run = polhode.integrate(TOP, at=[1, 2])
    run.save(tmp_path / "run.csv")
    report = polhode.report(tmp_path / "run.csv", number="double")
    assert report.sections[0].scene.name == TOP
    with pytest.raises(BadInput, match=r"right.csv: scene: expected a scene before it"):
        polhode.report(files["right"])


@pytest.mark.slow
def test_columns_and_runs_are_tables_too():
    run = polhode.integrate("euler/no-gamma", at=[1, 2])
    columns = {"t": run.t, **{x: run[x] for x in "pqr"}}
    report = polhode.report("euler/no-gamma", columns, run, at=[1, 2], number="extended")
    assert [x["verdict"] for x in rows(report, "files")] == ["good", "good"]
    assert rows(report, "runs")[0]["digits"] > 17


def test_tables_of_one_name_are_told_apart_and_are_no_files_of_one_method():
    """The second's digits stood for both, and of tables 2 and 3 an order was told.

    One of them alone has the column that is named; the second scene found no times left.
    """
    run = polhode.integrate(TOP, at=[1, 2])
    columns = {x: run[x] for x in ("p", "q", "r")}
    of_clock = {"clock": run.t, **columns}
    report = polhode.report(
        *(TOP, of_clock, {"t": run.t, **columns}, run, run, "euler/rest"),
        columns=["clock=t"],
        at=iter([1, 2]),
        number="double",
    )
    names = ["table 2", "table 3", f"run of {TOP}", f"run of {TOP} (2)"]
    assert [x["file"] for x in rows(report, "files")] == names
    assert report.sections[0].words["orders"] == []
    assert report.sections[1].scene.times == (1, 2)


@pytest.mark.slow
def test_steps_are_told_of_the_files_that_were_judged(tmp_path):
    """Those of all were forgotten where no proof reached the times of one."""
    case, files = "general/asymmetric-chaotic", []
    f = polhode.field(case)
    for steps in (64, 128):
        y, h = f.start, 1 / steps
        for _ in range(steps):
            y = y + h * f(0, y + h / 2 * f(0, y))
        path = table(tmp_path / f"mid{steps}.csv", np.array([0, 1]), np.array([f.start, y]))
        files.append(f"{path}=h={h}")
    far = table(tmp_path / "mid1.csv", np.array([0, 2000]), np.array([f.start, f.start]))
    report = polhode.report(case, *files, f"{far}=h=1", at=[1], number="double")
    (order,) = rows(report, "orders")
    assert 1.9 < order["order"] < 2.1


@pytest.mark.slow
def test_a_proof_that_would_take_too_long_is_not_begun_and_the_page_says_how_far_it_goes():
    scene = polhode.load("general/asymmetric-chaotic").at([1, *range(10, 210, 10)])
    report = polhode.report(scene, number="double", max_seconds=0.2)
    (run,) = rows(report, "runs")
    assert 0 < run["judged_until"] < 200
    assert "no reference to these digits" in run["remark"]
    digits = rows(report, "digits")
    assert digits[-1]["t"] == run["judged_until"]
    assert all(11 < x["correct_digits"] <= 16 for x in digits if x["t"] <= 40)


@pytest.mark.slow
def test_every_number_type_the_events_and_the_reach_of_a_chaotic_motion(tmp_path):
    scene = polhode.load("general/asymmetric-chaotic")
    text = polhode.as_toml(scene) + '\n[[events]]\nname = "level"\nzero = "gamma3"\n'
    (tmp_path / "top.toml").write_text(text)
    report = polhode.report(tmp_path / "top.toml", digits=40)
    runs = rows(report, "runs")
    assert [x["run"] for x in runs] == ["double", "extended", "quad", "40 digits"]
    assert all(a["digits"] < b["digits"] for a, b in pairwise(runs))
    assert runs[3]["digits"] >= 40
    for shorter, longer in pairwise(runs[:3]):
        assert 30 < shorter["half_lost_after"] < shorter["lost_after"] < longer["lost_after"]
    events = rows(report, "events")
    counts = {x["run"]: [y for y in events if y["run"] == x["run"]] for x in runs}
    assert len({len(x) for x in counts.values()}) == 1
    assert len(events) > 4
    for double, quad in zip(counts["double"], counts["quad"], strict=True):
        assert abs(float(double["time"]) - float(quad["time"])) < 100 * double["uncertainty"]


# -- pages -----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def pages(report, tmp_path_factory) -> Path:
    pytest.importorskip("matplotlib")
    folder = tmp_path_factory.mktemp("pages")
    report.save(folder / "r.html")
    report.save(folder / "r.md")
    report.save(folder / "r.md")  # its own kind is replaced
    return folder


def test_a_page_needs_nothing_else_and_is_dark_and_light(pages):
    text = (pages / "r.html").read_text()
    assert "prefers-color-scheme: dark" in text
    assert "@media print" in text
    assert not re.search(r'(src|href)="(?!#)', text.replace('xlink:href="#', ""))
    assert text.count("<svg") == 3
    assert "#000000" not in text
    assert len(text) < 300_000
    body = text[text.index("<body>") : text.rindex("</body>") + len("</body>")]
    body = body.replace("<wbr>", "")
    ET.fromstring(re.sub(r"xlink:href", "href", body))  # every tag is closed


def test_markdown_has_the_same_words_and_its_figures_beside_it(pages, report):
    text, html = (pages / "r.md").read_text(), (pages / "r.html").read_text()
    named = re.findall(r"!\[.*?\]\((.*?)\)", text)
    assert sorted(named) == sorted(f"r-figures/{x.name}" for x in (pages / "r-figures").iterdir())
    for svg in (pages / "r-figures").iterdir():
        ET.fromstring(svg.read_text())
    for heading in re.findall(r"^##+ (.*)$", text, re.M):
        assert f">{heading}</h" in html
    for line in rows(report, "files"):
        assert f"{line['digits']:.2f}" in text
        assert f"{line['digits']:.2f}" in html


def saved_text(report: polhode.Report, path: Path) -> str:
    report.save(path)
    return path.read_text(encoding="utf-8")


def test_without_matplotlib_a_page_has_no_figures_and_says_what_to_install(
    report, monkeypatch, tmp_path
):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    text = saved_text(report, tmp_path / "x.md")
    assert "pip install 'polhode[figures]'" in text
    assert "![" not in text


def test_thirty_scenes_have_a_row_and_a_section_each(report, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    (only,) = report.sections
    names = [f"top {k}|<i>" for k in range(30)]
    sections = [replace(only, scene=replace(only.scene, name=name)) for name in names]
    many = replace(report, sections=sections)
    text = saved_text(many, tmp_path / "x.html")
    assert len(re.findall(r'<h2 id="scene-', text)) == 30 == text.count('<a href="#scene-')
    assert "<i>" not in text
    text = saved_text(many, tmp_path / "x.md")
    first = text[: text.index("Verdict and limit are")].strip().splitlines()[2:]
    assert len(first) == 32
    assert {len(re.findall(r"(?<!\\)\|", line)) for line in first} == {8}  # of seven columns


# -- the verb --------------------------------------------------------------------------------------


def test_the_verb_prints_the_first_table_and_writes_all(files, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = ["report", TOP, files["right"], "--at", "1,2", "--number", "double"]
    assert main([*words, "-o", "r.md", "-o", "r.json"]) == 0
    out, err = capsys.readouterr()
    assert out.startswith("scene")
    assert f"{Path(files['right']).name}: 15" in out.replace(f"{Path(files['right']).parent}/", "")
    assert "report: 1 scene and 1 table: about" in err
    assert "written: r.md, r.json" in err
    answer = json.loads(Path("r.json").read_text())
    assert answer["result"] == "Report"
    assert answer["runs"]["digits"] == [pytest.approx(15, abs=1)]


def test_ctrl_c_ends_a_report_in_python(monkeypatch):
    """The run that it cut was judged, and the report went on."""
    own = polhode.output.accuracy.integrate

    def integrate(*scene, **how):
        return replace(own(*scene, **how), outcome=polhode.Outcome.INTERRUPTED)

    monkeypatch.setattr("polhode.output.accuracy.integrate", integrate)
    with pytest.raises(KeyboardInterrupt):
        polhode.report("euler/rest", at=[1], number="double")


def test_an_interruption_leaves_nothing(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(heard, "came", False)
    own = polhode.output.accuracy.integrate

    def integrate(*scene, **how):
        heard.came = True  # as the handler does while heyoka steps
        return own(*scene, **how)

    monkeypatch.setattr("polhode.output.accuracy.integrate", integrate)
    assert main(["report", TOP, "--at", "1", "-o", "r.html", "-o", "r.md"]) == 130
    assert "interrupted" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []

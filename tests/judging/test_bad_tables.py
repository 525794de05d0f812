"""What is no table that can be judged: one line with the place, exit code 2, and nothing more."""

import io
import json
import math
import os
import zipfile
from pathlib import Path

import numpy as np
import pytest

import polhode
from polhode import BadInput, cli
from shared.tables import ANGLES, ATTITUDE, STATE, right, text, through

CASE = "lagrange/nutation"
TIMES = [k / 2 for k in range(9)]
ZEROS = np.zeros(3)


def csv(content, name="x.csv"):
    def written(folder):
        path = folder / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return written


def commas(cell):
    """Decimal commas between semicolons, and a last cell that is another."""
    lines = text(right(CASE, TIMES), ";").replace(".", ",")
    return csv(lines.rpartition(";")[0] + f";{cell}\n")


def npz(**arrays):
    def saved(folder):
        np.savez(folder / "x.npz", **arrays)
        return folder / "x.npz"

    return saved


def mapping(**changes):
    """Columns of which some are changed, or left out."""
    columns = {"t": [0.5, 1, 2]} | {name: [1.0, 1.0, 1.0] for name in STATE} | changes
    return {name: x for name, x in columns.items() if x is not None}


def header(names):
    return csv(f"{names}\n{','.join('1' for _ in names.split(','))}\n")


def array_header(shape):
    file = io.BytesIO()
    about = {"descr": "<f8", "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(file, about)
    return file.getvalue()


#: What NumPy did not write.
NO_ARRAYS = [
    *(b"", b"t,p,q,r", b"PK", b"\x93NUMPY\x01\x00", b"PK\x03\x04 and no more"),
    *(array_header((10**15,)), array_header((10**30, 7))),
]
HEADED, NUMBERS = "a header with a column t (or time, timestamp)", "rows of finite numbers"
CUT_OFF = polhode.cases("chaotic").to_json()[:-20]
PQR = {"columns": ["p", "q", "r"]}

#: What is given, with which options, and words of the line.
BAD = [
    (header("t,note"), {}, "header"),
    (header("t"), {}, "header"),
    (header("t,omega_x,omega_y,omega_z"), {}, "header"),
    (header("t,foo,bar"), {}, "columns besides t that can be judged; --columns"),
    (header("clock,p,q"), {}, f"{HEADED}; --columns t,p,q,..."),
    (header("t,time,p"), {}, "each column once ('t', 'time'); --columns"),
    (header("t,p,wx"), {}, "each column once ('p', 'wx'); --columns"),
    (header("time,%time,p"), {}, "each column once"),
    (header("stamp,p"), {"columns": ["stamp=time"]}, "NAME=COLUMN"),
    (header("stamp,p"), {"columns": ["stamp=t*x"]}, "NAME=COLUMN"),
    (header("stamp,p"), {"columns": ["=t"]}, "NAME=COLUMN"),
    (
        csv(b"t,p\n0,\xff\n"),
        {},
        "x.csv: file: expected a readable CSV file (not a CSV text: byte 0xff in line 2",
    ),
    (csv(""), {}, "expected a header"),
    (csv("t,p\n"), {}, "at least one line of numbers"),
    (csv("t,p\n0,1,2\n"), {}, "x.csv:2: line = 0,1,2: expected 2 values"),
    (csv("t,p\n,1\n"), {}, "x.csv:2: t"),
    (csv("t,p\n0,1/3\n"), {}, "x.csv:2: p = 1/3"),
    (csv("x" * 3_000_000), {}, "x.csv"),
    (csv("t,p\n" + "1," * 300_000 + "\n"), {}, "expected 2 values"),
    (csv("t,p\n0,'" + '"' * 999 + "\n"), {}, "x.csv"),
    (csv("t,p\n0,1\n1,x\n"), {}, "x.csv:3: p = x: expected a finite"),
    (csv('t,p,note\n0,1,"a\nb"\n1,x,2\n'), {}, "x.csv:4: p = x"),
    (csv("0,1\n1,x\n"), {"columns": ["t", "p"]}, "x.csv:2: p = x"),
    (csv("0,1\n1,2\n"), {}, HEADED),
    (csv("t,p\n0,1\n1,inf\n"), {}, "p = inf: expected a finite"),
    (csv("t,p\n0,1\n1,0x1\n"), {}, "p = 0x1: expected a finite"),
    (csv("t,p\n0,1\n1,1e5000\n"), {}, "p = 1e5000: expected"),
    *((commas(cell), {}, "expected a finite decimal number") for cell in ("0.5", "1.000,5")),
    *((commas(cell), {}, "expected a finite decimal number") for cell in ("1,000,5", "x,5")),
    (npz(t=np.array([0, 1], dtype=object), p=np.zeros(2)), {}, "arrays of numbers that NumPy"),
    *(
        (csv(content, f"x{ending}"), {}, f"x{ending}: file: expected arrays of numbers that NumPy")
        for content in NO_ARRAYS
        for ending in (".npz", ".npy")
    ),
    *(
        (csv(content, "x.json"), {}, "x.json: file: expected a result that polhode saved")
        for content in ("{}", "[" * 50_000, CUT_OFF)
    ),
    (lambda folder: folder / "none.json", {}, "none.json: file: expected a result that polhode"),
    (npz(t=ZEROS, omega=np.zeros((3, 2))), {}, ": omega"),
    (npz(t=ZEROS, picture=np.zeros((3, 3))), {}, ": picture"),
    (npz(t=ZEROS, p=np.zeros(2)), {}, ": columns"),
    (npz(p=ZEROS), {}, ": columns"),
    (npz(t=np.array([1 + 1j]), p=np.zeros(1)), {}, ": t[1]"),
    (npz(t=np.array(["now"]), p=np.zeros(1)), {}, ": t[1]"),
    (lambda folder: folder / "none.csv", {}, "readable"),
    (lambda _: mapping(t=None, time=None), {}, "a column t among them"),
    (lambda _: mapping(time=[1, 2, 3]), {}, "columns = t: expected each column once"),
    (lambda _: mapping(p=[1.0]), {}, "columns as long as t"),
    (lambda _: mapping(p=["a", 1, 2]), {}, "p[1] = a: expected a number"),
    (lambda _: mapping(), {"columns": ["t", "p", "q", "r"]}, "NAME=COLUMN of each"),
    (lambda _: [[1, 2, 3]], {"at": [1]}, "6 numbers in each row"),
    (lambda _: [[1, 2, 3]], {"at": [1, 2]} | PQR, "a time for each of 1 rows"),
    (lambda _: [[1, 2, 3]], PQR, "a time for each of 1 rows"),
    (lambda _: [["x", 2, 3]], {"at": [1]} | PQR, "p[1] = x; a number"),
    (lambda _: [[math.inf, 2, 3]], {"at": [1]} | PQR, "p[1] = inf; a number"),
    (lambda _: [[1]], {"at": [1], "columns": ["s"]}, "columns = s"),
    (lambda _: [[1, 2]], {"at": [1], "columns": ["p", "p"]}, "columns = p: expected each column"),
    (lambda _: 3, {"at": [1]}, NUMBERS),
    (lambda _: mapping(), {"read": 5}, "compare: read = 5: expected a text"),
    (lambda _: mapping(), {"read": ["omega degrees"]}, "compare: read = "),
    (lambda _: mapping(), {"against": None}, "a reference, or a scene"),
    (lambda _: mapping(), {"against": "ref.csv"}, "SCENE = ref.csv: expected a scene"),
    (lambda _: mapping(), {"against": "REF.NPZ"}, "SCENE = REF.NPZ: expected a scene"),
]


@pytest.mark.parametrize(("table_of", "options", "words"), BAD, ids=[x[2][:40] for x in BAD])
def test_it_is_refused_in_one_line(table_of, options, words, tmp_path, refusal):
    table = table_of(tmp_path)
    with pytest.raises(BadInput) as fault:
        polhode.compare(table, **({"against": CASE} | options))
    said = [str(fault.value)]
    if isinstance(table, Path):
        columns = ["--columns", ",".join(options["columns"])] if options else []
        said.append(refusal("compare", table, CASE, *columns))
    for line in said:
        assert all(word in line for word in words.split("; ")), line
        assert "\n" not in line.rstrip("\n")


def test_an_archive_that_unpacks_to_too_much_is_refused(tmp_path):
    """By the sizes that its directory tells, before anything is unpacked."""
    path, size = tmp_path / "x.npz", 123_457
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("t.npy", bytes(size))
    most = (2**32 - 2).to_bytes(4, "little")
    path.write_bytes(path.read_bytes().replace(size.to_bytes(4, "little"), most))
    with pytest.raises(BadInput, match="bytes of arrays, more than "):
        polhode.compare(path, CASE)


# -- what a gate refuses: gaps, which have no digits ------------------------------------------


def some(names, gaps=()):
    """Some columns, not a number in some rows (counted from 1)."""
    table = right(CASE, TIMES, "at", "attitude", "angles")
    table = {name: table[name] for name in ("t", *names)}
    for name in names:
        table[name][[k - 1 for k in gaps]] = np.nan
    return table


GAPS = [
    (STATE, range(1, 10), "p in row 1, t = 0"),
    (ATTITUDE, range(1, 10), "q0 in row 1, t = 0"),
    (ANGLES, range(1, 10), "psi in row 1, t = 0"),
    (STATE, range(4, 10), "p in row 4, t = 1.5"),
    (ATTITUDE, [9], "q0 in row 9, t = 4"),
]


@pytest.mark.parametrize("door", ["mapping", "frame", "npz", "npy", "parquet", "csv"])
@pytest.mark.parametrize(("names", "gaps", "place"), GAPS, ids=[x[2] for x in GAPS])
def test_a_gap_is_refused_by_its_place(tmp_path, refusal, door, names, gaps, place):
    mine = through(door, some(names, gaps), tmp_path)
    with pytest.raises(BadInput, match=rf": {place}: expected a number in each cell"):
        polhode.testing.assert_digits(mine, CASE, 12)
    if isinstance(mine, Path):
        assert place in refusal("compare", mine, CASE, "--at-least", "12")


@pytest.mark.parametrize(
    ("names", "misspelt", "there"),
    [(STATE, "gamma1", "gamma2, gamma3"), (STATE, "r", "p, q"), (ATTITUDE, "q2", "q0, q1, q3")],
)
def test_a_vector_with_a_misspelt_component_passes_no_gate(
    tmp_path, refusal, names, misspelt, there
):
    mine = {"gam1" if name == misspelt else name: x for name, x in some(names).items()}
    refusal_text = rf"{misspelt}: expected it beside {there} \(columns that are not known: gam1\)$"
    with pytest.raises(BadInput, match=refusal_text):
        polhode.testing.assert_digits(mine, CASE, 7)
    file = through("csv", mine, tmp_path)
    assert cli.main(["compare", str(file), CASE]) == 0
    said = refusal("compare", file, CASE, "--at-least", "7")
    assert f"x.csv: {misspelt}: expected it beside" in said


def test_whole_vectors_pass_and_parts_of_them_do_not():
    for names in (STATE[:3], STATE[3:], ATTITUDE, ["theta"]):
        assert polhode.testing.assert_digits(some(names), CASE, 12).worst > 12
    beside = some(STATE) | some(ATTITUDE, range(1, 10))
    with pytest.raises(BadInput, match="q0 in row 1"):
        polhode.testing.assert_digits(beside, CASE, 12)
    with pytest.raises(BadInput, match=r"q, r: expected it beside p$"):
        polhode.testing.assert_digits(some(["p"]), CASE, 7)
    rows = np.transpose([*some(["p", "q"]).values()][1:])
    with pytest.raises(BadInput, match=r"states: r: expected it beside p, q$"):
        polhode.testing.assert_digits(rows, CASE, 7, at=TIMES, columns=["p", "q"])


def test_angles_that_the_motion_does_not_have_may_be_missing(tmp_path, refusal):
    """psi and phi of a top that sleeps; where there is nothing else, nothing passes."""
    sleeping = "lagrange/sleeping-stable"
    mine = right(sleeping, [0, 1, 2], "at", "angles")
    assert np.isnan(mine["psi"][1])
    assert polhode.testing.assert_digits(mine, sleeping, 12).worst > 12
    with pytest.raises(BadInput, match="theta in row 1"):
        polhode.testing.assert_digits(mine | {"theta": [None] * 3}, sleeping, 12)
    alone = {name: mine[name] for name in ("t", "psi", "phi")}
    with pytest.raises(BadInput, match="expected a number in a column that can be judged"):
        polhode.testing.assert_digits(alone, sleeping, 1)
    path = through("csv", alone, tmp_path)
    refusal("compare", path, sleeping, "--at-least", "1")
    assert cli.main(["compare", str(path), sleeping]) == 0


@pytest.mark.parametrize("threshold", ["x", "nan", "inf", "12", math.nan])
def test_a_threshold_that_is_no_number_is_refused(tmp_path, refusal, threshold):
    path = through("csv", some(STATE), tmp_path)
    with pytest.raises(BadInput, match=r"^assert_digits: at_least = .* a number of digits"):
        polhode.testing.assert_digits(path, CASE, at_least=threshold)
    if threshold != "12":
        said = refusal("compare", path, CASE, "--at-least", threshold)
        assert f"--at-least = {threshold}: expected a number" in said


def test_fewer_digits_than_wanted_end_with_three(tmp_path, capsys):
    table = some((*STATE, *ATTITUDE))
    for name in ATTITUDE:
        table[name][5] *= 1 + 1e-7
    path = through("csv", table, tmp_path)
    command = ["compare", str(path), CASE, "--at-least"]
    assert cli.main([*command, "6"]) == 0
    assert cli.main([*command, "8", "--json"]) == 3
    output = capsys.readouterr().err.splitlines()[-1]
    assert "correct digits of attitude at t = 2.5, where at least 8 are wanted" in output
    turns = some(ANGLES)
    for name in ("psi", "phi"):
        turns[name] = np.remainder(turns[name] + np.pi, 2 * np.pi) - np.pi
    through("csv", turns, tmp_path)
    assert cli.main([*command, "12"]) == 0


# -- files that polhode saved: judged as what they are; one that was changed as any other ----------


SCENE = "lagrange/nutation"
OWN_TIMES = ["1/10", "7/10", "2.3", "10/3"]


@pytest.fixture(scope="module")
def run():
    return polhode.integrate(SCENE, at=OWN_TIMES)


@pytest.fixture(scope="module")
def judged(run):
    return polhode.compare(run)


@pytest.mark.slow
@pytest.mark.parametrize(("ending", "number"), [("csv", "double"), ("npz", "extended")])
def test_a_run_is_judged_as_itself(tmp_path, ending, number):
    run = polhode.integrate(SCENE, at=OWN_TIMES, number=number)
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

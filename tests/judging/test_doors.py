"""One table through every door, in every layout and type of numbers: the same verdict."""

import json
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode import BadInput, cli
from shared.tables import ANGLES, ATTITUDE, DOORS, STATE, of_run, right, text, through
from shared.tools import EXTENDED, EXTENDED_HERE, judged, mp

CASE = "lagrange/nutation"
TIMES = [Fraction(k, 4) for k in range(13)]
NAMES = ("t", *STATE, *ATTITUDE)


def table():
    return right(CASE, TIMES, "at", "attitude")


def verdict(path, capsys, *options, code=0):
    """What the verb says, as JSON."""
    assert cli.main(["compare", str(path), CASE, "--json", *options]) == code
    return judged(capsys.readouterr().out)


@pytest.mark.parametrize("door", [*DOORS, "%.17e", "%.16e", "%.18e", "%.20g"])
def test_the_same_verdict_through_every_door(tmp_path, door):
    judgement = polhode.compare(through(door, table(), tmp_path), CASE)
    plain = polhode.compare(table(), CASE)
    assert judgement.subject.number.name == "double"
    assert judgement.part_digits == plain.part_digits
    assert (judgement.worst, judgement.limit) == (plain.worst, "rounding")
    assert judgement.worst > 15


# -- layouts of texts -------------------------------------------------------------------------


def lines(separator=",", header=True, names=None, comment="", **columns):
    changed = table() | columns
    if names is not None:
        changed = dict(zip(names, changed.values(), strict=True))
    content = text(changed, separator, header)
    return f"# made by a program, of t and such\n\n# {content}" if comment else content


def indexed(content):
    """A first column without a name."""
    return "\n".join(f"{k - 1 if k else ''},{x}" for k, x in enumerate(content.split()))


def in_two_lines(content):
    """A column that is not known, of which a cell is in quotation marks, over two lines."""
    rows = content.splitlines()
    return "\n".join(f'{x},"a\nb"' if k == 3 else f"{x},c" for k, x in enumerate(rows))


OTHER = [f"c{k}" for k in range(len(NAMES))]
FACTORS = ("stamp", "p", "q", "R", *STATE[3:], "Q.W", *ATTITUDE[1:])
UNITS = ("time_ms", "wx [rpm]", "wy [rpm]", "wz [rpm]", *STATE[3:], *ATTITUDE)
MS = {"t": 1000 * table()["t"]}
NAMED = ["--columns", ",".join(NAMES)]

#: What a file says, how it is called, and what is said of it.
LAYOUTS = {
    **{f"between {x!r}": (lines(x), [], []) for x in (",", ";", "\t", " ", "   ")},
    **{f"after #, {x!r}": (lines(x, comment="#"), [], []) for x in (",", ";", "\t", " ")},
    "decimal commas": (lines(";").replace(".", ","), [], ["read as: decimal commas"]),
    "decimal commas, no header": (
        lines(";", header=False).replace(".", ","),
        NAMED,
        ["read as: decimal commas"],
    ),
    "no header": (lines(header=False), NAMED, []),
    "another header": (lines(names=OTHER), NAMED, []),
    "names with factors": (
        lines(names=FACTORS, r=-table()["r"], **MS),
        ["--columns", "stamp=t*1e-3, R=-r, Q.W=q0"],
        [],
    ),
    "units in names": (
        lines(names=UNITS, **MS, **{n: table()[n] * 30 / np.pi for n in "pqr"}),
        [],
        [],
    ),
    "a column without a name": (indexed(lines()), [], []),
    "a cell of two lines": (in_two_lines(lines()), [], []),
    "spaces about commas": (lines(" , "), [], []),
    "no number, between blanks": (lines(" , ").rstrip().rpartition(" ")[0] + " nan \n", [], []),
    "names in quotation marks": (lines(names=[f'"{name}"' for name in NAMES]), [], []),
    "an open quotation mark in a comment": ('#,"open\n' + lines().rstrip(), [], []),
    "no zero before the point": (lines().replace(",0.", ",+.").replace("e-", "E-0"), [], []),
    "a mark of bytes, and Windows": ("\ufeff" + lines().replace("\n", "\r\n"), [], []),
}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_every_layout_of_a_text_is_read(tmp_path, capsys, layout):
    content, options, remarks = LAYOUTS[layout]
    path = tmp_path / "x.csv"
    path.write_bytes(content.encode())
    answer = verdict(path, capsys, *options)
    assert answer["worst"] > 14.5
    assert {*answer["parts"]} == {"omega", "gamma", "attitude"}
    assert (answer["remarks"], answer["reading"]) == (remarks, None)


def test_a_column_without_a_name_is_quoted(tmp_path, capsys):
    (tmp_path / "x.csv").write_text(indexed(lines()))
    assert cli.main(["compare", str(tmp_path / "x.csv"), CASE]) == 0
    said = "not judged: column '' is not known and was not judged"
    assert said in capsys.readouterr().out.splitlines()


def test_a_second_form_of_the_attitude_is_said_to_be_one(tmp_path, capsys):
    """Not to be unknown; and what is said of several columns is one line."""
    path = tmp_path / "x.csv"
    scene = polhode.load(CASE).at([0, 1])
    polhode.integrate(replace(scene, outputs=("mrp", "integrals"))).save(path)
    (tmp_path / "x.csv.json").unlink()
    assert cli.main(["compare", str(path), CASE]) == 0
    output = capsys.readouterr().out.splitlines()
    said = "not judged: columns sigma1 sigma2 sigma3 were not judged: the quaternion is"
    assert said in output
    assert sum("p q r and gamma are" in line for line in output) == 1


@pytest.mark.slow
def test_a_table_from_the_standard_input():
    command = [sys.executable, "-m", "polhode", "compare", "-", CASE, "--json"]
    process = subprocess.run(command, input=lines(), capture_output=True, text=True)
    assert process.returncode == 0, process.stderr
    assert json.loads(process.stdout)["file"] == "standard input"
    process = subprocess.run(command, input="t,p\n0,x\n", capture_output=True, text=True)
    assert (process.returncode, process.stdout) == (2, "")
    assert process.stderr.startswith("polhode: standard input:2: p = x: expected a finite")


# -- arrays -----------------------------------------------------------------------------------


def arrays_of(*names):
    """The table with its vectors as arrays that have these names."""
    columns = table()
    vectors = [np.array([columns[n] for n in v]).T for v in (STATE[:3], STATE[3:], ATTITUDE)]
    return {"t": columns["t"], **dict(zip(names, vectors, strict=True))}


@pytest.mark.parametrize(
    "names", [("omega", "gamma", "q"), ("gyro", "gamma", "quaternion"), ("w", "g", "orientation")]
)
def test_arrays_of_three_or_four_are_read(tmp_path, names):
    np.savez(tmp_path / "x.npz", **arrays_of(*names), dt=np.array(0.1))
    judgement = polhode.compare(tmp_path / "x.npz", CASE)
    assert judgement.worst > 15
    assert set(judgement.part_digits) >= {"omega", "gamma"}
    assert len(judgement.digits) == len(TIMES)


def test_an_array_without_names_needs_them(tmp_path, capsys):
    path = tmp_path / "x.npy"
    np.save(path, np.column_stack([*table().values()]))
    assert verdict(path, capsys, *NAMED)["worst"] > 15
    assert cli.main(["compare", str(path), CASE]) == 2
    assert "shape = (13, 11): expected fields with names" in capsys.readouterr().err


def test_a_saved_run_may_have_more_bits_than_digits_can_be_asked_for(tmp_path):
    """Those that its motion loses."""
    number = mp(4100)
    polhode.integrate(CASE, number, at=[0]).save(tmp_path / "x.npz")
    assert polhode.compare(tmp_path / "x.npz", CASE).subject.number == number


def test_an_array_has_no_column_twice(tmp_path):
    """The last one was judged, without a word."""
    single, many = tmp_path / "x.npy", tmp_path / "x.npz"
    np.save(single, np.column_stack([*table().values()]))
    names = [*table()]
    with pytest.raises(BadInput, match=rf"columns = {names[1]}: expected each column once"):
        polhode.compare(single, CASE, columns=[*names[:2], names[1], *names[3:]])
    arrays = arrays_of("omega", "gamma", "q")
    for name, again in (("w", arrays["omega"]), ("w_x", arrays["omega"][:, 0])):
        np.savez(many, **arrays, **{name: 2 * again})
        refusal_text = rf"columns = w_x: expected each column once \('{name}' has it again\)"
        with pytest.raises(BadInput, match=refusal_text):
            polhode.compare(many, CASE)


def test_parquet_is_read_where_pandas_reads_it(tmp_path, monkeypatch):
    pd = pytest.importorskip("pandas")
    path = tmp_path / "x.parquet"
    path.write_bytes(b"as if")
    for answer, said in ((ImportError("pyarrow"), "pyarrow"), (ValueError("no\nfoot"), "(no)")):

        def read(_, fault=answer):
            raise fault

        monkeypatch.setattr(pd, "read_parquet", read)
        with pytest.raises(BadInput) as error:
            polhode.compare(path, CASE)
        assert said in str(error.value)
    monkeypatch.setattr(pd, "read_parquet", lambda _: pd.DataFrame(table()))
    assert polhode.compare(path, CASE).worst > 15


def test_a_data_frame_is_judged_with_its_index_as_time():
    frame = pytest.importorskip("pandas").DataFrame(table()).rename(columns={"t": "time"})
    judgement = polhode.compare(frame.set_index("time"), CASE)
    assert judgement.digits == polhode.compare(frame, CASE).digits


def test_a_column_that_is_told_is_chosen():
    some = {"t": [0.0], "wx": [0.16], "gyro_x": [7.0], "foo": [0.3]}
    judgement = polhode.compare(some, CASE, columns=["wx=p", "foo=q"])
    assert judgement.worst > 15
    assert judgement.subject.state == ("p", "q")


# -- types of numbers -------------------------------------------------------------------------


def rows():
    return np.column_stack([table()[n] for n in STATE])


AS_TYPES = {
    "lists of floats": (lambda: rows().tolist(), "double"),
    "a list of arrays": (lambda: [*rows()], "double"),
    "an array of objects": (lambda: rows().astype(object), "double"),
    "a generator": (lambda: (row for row in rows()), "double"),
    "single": (lambda: rows().astype(np.float32), "single"),
    "single and double": (lambda: [[np.float32(x[0]), *x[1:]] for x in rows().tolist()], "double"),
    "fractions": (lambda: [[Fraction(x) for x in row] for row in rows().tolist()], "mp"),
    "a fraction among floats": (lambda: [[Fraction(x[0]), *x[1:]] for x in rows().tolist()], "mp"),
    "texts": (lambda: [[repr(x) for x in row] for row in rows().tolist()], "mp"),
    "half": (lambda: rows().astype(np.float16), "mp"),
}


@pytest.mark.parametrize("kind", AS_TYPES)
def test_rows_are_of_the_widest_type_of_their_cells(kind):
    cells, number = AS_TYPES[kind]
    judgement = polhode.compare(cells(), CASE, at=TIMES)
    assert judgement.subject.number.name == number
    assert number == "mp" or f"expected in {number}" in judgement.details()


def test_what_is_held_in_single_has_its_digits():
    judgement = polhode.compare(rows().astype(np.float32), CASE, at=TIMES)
    assert 7 < judgement.worst <= judgement.subject.number.most_digits < 7.3
    assert judgement.limit == "rounding"
    with pytest.raises(BadInput, match="number = single"):
        polhode.integrate(CASE, number=judgement.subject.number)


@pytest.mark.skipif(not EXTENDED_HERE, reason="long double is another type here")
def test_doubles_kept_as_long_doubles_are_short_of_digits():
    judgement = polhode.compare(rows().astype(np.longdouble), CASE, at=TIMES)
    assert judgement.subject.number == EXTENDED
    assert judgement.limit.startswith("method")


@pytest.mark.parametrize("digits", [19, 25, 36])
def test_more_digits_than_a_doubles_stay_more_digits(tmp_path, digits):
    command = ["reference", CASE, "--at", "1/4,1/2,3/2", "--digits", str(digits), "-o"]
    assert cli.main([*command, str(tmp_path / "x.csv")]) == 0
    judgement = polhode.compare(tmp_path / "x.csv", CASE)
    assert judgement.subject.number.name == "mp"
    assert digits - 1 < judgement.worst < digits + 4


def test_doubles_printed_longer_than_they_are_are_doubles(tmp_path):
    path = tmp_path / "x.csv"
    cells = [[f"{float(x):.18e}" for x in row] for row in rows()]

    def judged():
        body = [",".join([str(float(t)), *row]) for t, row in zip(TIMES, cells, strict=True)]
        path.write_text("\n".join([",".join(("t", *STATE)), *body]))
        return polhode.compare(path, CASE)

    judgement = judged()
    assert (judgement.subject.number.name, judgement.limit) == ("double", "rounding")
    assert judgement.subject.remarks == ("read as: numbers of double, printed to 19 digits",)
    cells[7][2] = cells[7][2][:-7] + "1" + cells[7][2][-6:]  # the decimal of no double
    assert judged().subject.number.name == "mp"
    cells = [[f"{np.float32(x):.18e}" for x in row] for row in rows()]
    assert judged().subject.number.name == "single"


# -- runs -------------------------------------------------------------------------------------


@pytest.mark.parametrize("number", ["double", "extended", "quad"])
def test_a_run_its_files_and_its_array_are_judged_alike(tmp_path, number):
    """A CSV that was changed has the type that its decimals tell."""
    run = polhode.integrate(CASE, number, at=[4, 20])
    path = tmp_path / "x.csv"
    command = ["run", CASE, "--number", number, "--at", "4,20", "-o", str(path)]
    assert cli.main(command) == 0
    run.save(tmp_path / "y.npz")
    own = polhode.compare(run)
    array = run.states, {"at": run.times, "number": number}
    for source, options in ((path, {}), (tmp_path / "y.npz", {}), array):
        judgement = polhode.compare(source, CASE, **options)
        assert judgement.subject.number == run.number
        assert judgement.digits == own.digits
    lines = path.read_text().splitlines()
    cells = lines[-1].split(",")
    cells[lines[0].split(",").index("gamma3")] += "1" * 9
    path.write_text("\n".join([*lines[:-1], ",".join(cells)]) + "\n")
    changed = polhode.compare(path, CASE).subject
    assert (changed.run, changed.number.name) == (None, "mp")


def test_a_run_that_is_not_projected_its_file_and_its_array_have_the_same_limits(tmp_path):
    run = polhode.integrate("euler/largest-axis", project=False)
    path = tmp_path / "x.csv"
    assert cli.main(["run", run.scene.name, "--no-project", "-o", str(path)]) == 0
    judged = [polhode.compare(run), polhode.compare(run.states, run.scene, at=run.times)]
    judged.append(polhode.compare(path, run.scene, number="double"))
    single, *others = ([x.expected, x.inputs, x.limit, x.digits] for x in judged)
    assert others == [single, single]
    assert judged[2].drift == judged[0].drift
    assert judged[1].drift == pytest.approx(judged[0].drift, rel=1e-3)
    some = polhode.compare(run.states[:, 3:], run.scene, at=run.times, columns=STATE[3:])
    assert some.subject.state == STATE[3:]
    assert all(d >= w for d, w in zip(some.digits, judged[0].digits, strict=True))
    assert "columns p q r are not in the file" in some.notes


def test_a_run_without_rows_is_refused_with_what_ended_it():
    """It was told 15.95 correct digits of angles, of none."""
    scene = replace(polhode.load("lagrange/lower-pole").at([50]), outputs=("angles",))
    run = polhode.integrate(scene)
    assert not run.times
    with pytest.raises(BadInput, match="rows: expected a time that the run reached"):
        polhode.compare(run)
    ended = polhode.integrate(CASE, at=[1, 2], max_steps=2)
    assert (ended.times, ended.expected.digits, ended.expected.lost_after) == ((), (), None)


# -- cells that are no numbers ----------------------------------------------------------------


@pytest.mark.parametrize("cell", ["nan", "NaN", "-nan", "NA", "null", ""])
def test_a_cell_that_is_no_number_is_not_judged_whatever_the_door(tmp_path, cell):
    columns = of_run(polhode.integrate(CASE, at=[0, 1, 2]))
    columns["q"][1] = np.nan
    path = tmp_path / "x.csv"
    path.write_text(text(columns, empty=cell))
    array = np.column_stack([columns[n] for n in STATE])
    sources = [(path, {}), (columns, {}), (array, {"at": [0, 1, 2]})]
    for source, options in sources:
        judgement = polhode.compare(source, CASE, **options)
        assert judgement.worst > 14.5
        assert "not judged: empty cells were not judged" in str(judgement)
    rest = text(columns, empty=cell).splitlines()[2:]  # of which the first row has the cell
    path.write_text("\n".join(rest))
    assert len(polhode.compare(path, CASE, columns=["t", *STATE]).times) == 2


@pytest.mark.parametrize("count", [9, 200])  # row by row, and all at once
def test_a_time_without_numbers_has_no_digits(count):
    mine = right("euler/largest-axis", [Fraction(k, 4) for k in range(count)])
    for name in STATE:
        mine[name][4:8] = np.nan
    mine["p"][8:] = np.nan  # of omega q and r are left
    judgement = polhode.compare(mine, "euler/largest-axis")
    for digits in (judgement.digits, judgement.part_digits["gamma"]):
        assert [k for k, d in enumerate(digits) if d is None] == [4, 5, 6, 7]
    assert {*judgement.part_digits["omega"][4:]} == {None}  # a vector without p is none
    assert judgement.worst > 15


def without(names, rows):
    """Columns of three rows of a right table, of which some cells are none."""

    def table():
        columns = right(CASE, [0, 1, 2], "at", "attitude", "angles")
        for name in names:
            columns[name][rows] = np.nan
        return columns

    return table


def masked():
    table = {n: np.ma.array(x) for n, x in right(CASE, [0, 1, 2]).items()}
    for name in STATE:
        table[name][1:] = np.ma.masked
    return table


def nullable():
    frame = pytest.importorskip("pandas").DataFrame(right(CASE, [0, 1, 2])).astype("Float64")
    frame.loc[1:, "p"] = None
    return frame


WHOLE = (*STATE, *ATTITUDE, *ANGLES)
NUMBERLESS = [
    # columns, their cells, what the verdict says, whether the table goes to its end
    (without(WHOLE, slice(1, 3)), "no numbers from t = 1 on (2 of 3 rows); ", False),
    (without([n for n in WHOLE if n not in ("r", "q0", "phi")], slice(1, 3)), None, False),
    (without(WHOLE, 0), "no numbers at t = 0 (1 of 3 rows); ", True),
    (without(WHOLE, slice(0, 3, 2)), "no numbers in 2 of 3 rows, the first at t = 0; ", False),
    (without(["gamma1"], 2), "no numbers of gamma at t = 2 (1 of 3 rows); ", True),
    (without(["q1"], slice(1, 3)), "no numbers of attitude from t = 1 on (2 of 3 rows); ", True),
    (without(["psi"], 1), "no numbers of angles at t = 1 (1 of 3 rows); ", True),
    (without(["p", "theta"], 1), "no numbers of omega and angles at t = 1 (1 of 3 rows); ", True),
    (without(WHOLE, slice(0, 3)), "nothing was judged: no numbers in any row", False),
    (masked, "no numbers from t = 1 on (2 of 3 rows); ", False),
    (nullable, "no numbers of omega from t = 1 on (2 of 3 rows); ", True),
]


@pytest.mark.parametrize(("table", "words", "complete"), NUMBERLESS)
def test_rows_without_numbers_are_never_right(table, words, complete, tmp_path, capsys):
    """A run that turned nan, with one column that stays, had as many digits as there are."""
    words = words or "no numbers from t = 1 on (2 of 3 rows); "
    columns = table()
    judgement = polhode.compare(columns, CASE)
    (verdict,) = [line for line in str(judgement).splitlines() if "no numbers" in line]
    assert verdict.startswith(words)
    assert words.strip("; ").split(": ")[-1] in repr(judgement)
    assert judgement.complete is complete
    for part, rows in judgement.gaps.items():
        digits = judgement.part_digits.get(part, [None] * 3)
        assert [k for k, d in enumerate(digits) if d is None] == [*rows]
    with pytest.raises(BadInput, match="expected a number in each cell that is judged"):
        polhode.testing.assert_digits(columns, CASE, at_least=3)
    path = tmp_path / "x.csv"
    path.write_text(text({n: np.array(np.ma.filled(x, np.nan), float) for n, x in columns.items()}))
    assert cli.main(["compare", str(path), CASE]) == (0 if complete else 3)
    assert words in capsys.readouterr().out
    assert cli.main(["compare", str(path), CASE, "--at-least", "3"]) == 2


def test_a_pole_has_no_psi_and_phi_to_lack():
    times = [0, 1, 2]
    table = right("lagrange/sleeping-stable", times, "angles")
    assert np.isnan(table["psi"]).all()
    assert polhode.compare(table, "lagrange/sleeping-stable").gaps == {}


def test_a_run_that_ended_early_is_not_right():
    run = polhode.integrate(CASE, at=[1, 20], max_steps=40)
    judgement = polhode.compare(run)
    words = "the run ended early, with 1 of 2 rows: the end needs more steps than the limit allows"
    assert words in str(judgement)
    assert not judgement.complete
    with pytest.raises(BadInput, match=words):
        polhode.testing.assert_digits(run, CASE, at_least=3)


@pytest.mark.parametrize("names", ["p,q,r", "p,q,r,psi,theta,phi", "gamma1"])
def test_a_table_without_numbers_has_no_digits(names, tmp_path, capsys):
    path = tmp_path / "x.csv"
    path.write_text(f"t,{names}\n1{',' * len(names.split(','))}\n")
    answer = verdict(path, capsys, code=3)
    assert (answer["worst"], "correct_digits" in answer) == (None, False)
    assert [*answer["parts"].values()] == [[None]] * len(answer["parts"])
    assert "correct digits" not in str(polhode.compare(path, CASE))


def test_a_table_of_another_case_is_told_with_the_plain_cases_that_begin_so():
    run = polhode.integrate("lagrange/nutation", at=[0, 1])
    columns = {"t": run.t} | dict(zip(STATE, run.states.T, strict=True))
    judged = str(polhode.compare(columns, "euler/largest-axis"))
    assert "; lagrange/backward and lagrange/long (and 3 more) begin so" in judged


@pytest.mark.slow
def test_a_start_beyond_doubles_is_another_start(tmp_path, capsys):
    (tmp_path / "x.csv").write_text("t,p,q,r\n0,1e400,1,1\n1,5,5,5\n2,7,8,9\n")
    assert cli.main(["compare", str(tmp_path / "x.csv"), CASE]) == 0
    assert "x.csv: at t = 0 it has p = inf, q = 1, r = 1, where" in capsys.readouterr().out


def test_columns_about_the_vertical_are_named_where_the_scene_has_none():
    some = {"t": [0], "p": [1], "gamma1": [1], "psi": [1]}
    judgement = polhode.compare(some, "euler/no-gamma")
    unjudged = "columns gamma1 psi were not judged: the scene has no gamma"
    missing = "columns q r are not in the file"
    assert [x for x in judgement.notes if x in (unjudged, missing)] == [unjudged, missing]
    assert judgement.subject.state == ("p",)


@pytest.mark.slow
def test_rows_that_begin_later_are_as_they_are():
    later = {name: x[3:] for name, x in table().items()}
    assert polhode.compare(later, CASE).reading is None
    wrong = later | {"t": later["t"] - 0.5}  # no row is the start
    assert "from its first row" not in (polhode.compare(wrong, CASE).reading or "")

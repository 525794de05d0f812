"""Files as other programs write them: spellings, codings, layouts, names of data sets."""

import codecs
import re
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode import BadInput
from shared.tables import ATTITUDE, STATE, right, text

CASE = "lagrange/nutation"
TIMES = [Fraction(k, 4) for k in range(9)]


def table(*parts):
    return right(CASE, TIMES, *parts)


def read(tmp_path, content, name="x.csv", **how):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return polhode.compare(path, CASE, **how)


def refused(tmp_path, content, **how):
    with pytest.raises(BadInput) as fault:
        read(tmp_path, content, **how)
    line = str(fault.value)
    assert "\n" not in line
    return line


# -- spellings of numbers --------------------------------------------------------------------------


def three_digits(cell):
    """A number as Fortran writes one whose exponent has three digits."""
    mantissa, _, power = f"{float(cell):.16e}".partition("e")
    return f"{mantissa}{int(power):+04d}"


SPELLINGS = {
    "Fortran": lambda x: f"{float(x):.16e}".replace("e", "D"),
    "Fortran, three digits": three_digits,
    "Mathematica": lambda x: f"{float(x):.16e}".replace("e", "*^"),
    "NumPy's repr": lambda x: f"np.float64({x})",
    "NumPy's repr of long doubles": lambda x: f"np.longdouble('{x}')",
    "Decimal": lambda x: f"Decimal('{x}')",
    "mpmath": lambda x: f"mpf('{x}')",
    "a minus as in print": lambda x: x.replace("-", "\N{MINUS SIGN}"),
}


@pytest.mark.parametrize("spelling", SPELLINGS)
@pytest.mark.parametrize("header", [True, False])
def test_a_number_is_read_however_it_is_spelt(tmp_path, spelling, header):
    plain = table()
    spelt = {
        name: [SPELLINGS[spelling](repr(float(x))) for x in column]
        for name, column in plain.items()
    }
    rows = [",".join(row) for row in zip(*spelt.values(), strict=True)]
    content = "\n".join([",".join(spelt)] * header + rows)
    columns_read = read(tmp_path, content, columns=None if header else [*spelt])
    assert columns_read.digits == polhode.compare(plain, CASE).digits
    assert columns_read.subject.times == tuple(TIMES)


@pytest.mark.parametrize(
    ("cell", "plain"),
    [
        ("1.5D+02", "1.5e+02"),
        ("-.5d-3", "-.5e-3"),
        ("1.Q0", "1.e0"),
        ("5*^-7", "5e-7"),
        ("0.123-101", "0.123e-101"),
        ("-1.+120", "-1.e+120"),
        ("np.float32(1.5)", "1.5"),
        *((x, "") for x in ("-nan(ind)", "nan(snan)", "-1.#IND", "1.#QNAN00", "nan(0x8000000)")),
        *((x, "") for x in ("np.float64(nan)", "#N/A", "<NA>", r"\N", "missing", "NULL", "+NaN")),
        # What only looks like one stays as it is, and is refused.
        *((x, x) for x in ("12-101", "1.5-3", "1.5-1010", "2024-101", "1D5", "1.5D", "1.5DD2")),
        *(
            (x, x)
            for x in ("inf", "1.#INF", "****", "f(1)", "sqrt(2)", "np.sqrt(2)", "nano", "1*2")
        ),
        *((x, x) for x in ("np.float64(1", "(1)", "(1,2)", "1/3", "0x1p-3", "1.000,5")),
    ],
)
def test_a_cell_as_a_plain_decimal(tmp_path, cell, plain):
    content = f"t\tp\n0\t0.16\n1\t{cell}\n"
    if plain and plain == cell:
        assert f"x.csv:3: p = {cell}: expected" in refused(tmp_path, content)
    else:
        value = Fraction(plain) if plain else None
        assert read(tmp_path, content).subject.columns["p"][1] == value


def test_asterisks_of_fortran_are_named(tmp_path):
    lines = text(table()).replace("0.8", "******", 1)
    line = refused(tmp_path, lines)
    assert re.search(
        r"x\.csv:2: gamma1 = \*{6}: .*decimal number \(asterisks .* Fortran was too narrow", line
    )


def test_a_row_without_a_time_is_no_comment(tmp_path):
    assert "x.csv:3: t = : expected" in refused(tmp_path, "t,p\n0,1\n#N/A,2\n1,2\n")


# -- codings and layouts ---------------------------------------------------------------------------


@pytest.mark.parametrize("coding", ["utf-8-sig", "utf-16", "utf-32", "utf-16-be", "utf-32-le"])
def test_a_text_in_any_unicode_with_its_mark(tmp_path, coding):
    marks = {"utf-16-be": codecs.BOM_UTF16_BE, "utf-32-le": codecs.BOM_UTF32_LE}
    content = text(table()).replace("p,q,r", "ω1,ω2,ω3", 1)
    columns_read = read(tmp_path, marks.get(coding, b"") + content.encode(coding))
    assert columns_read.digits == polhode.compare(table(), CASE).digits


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (text({"t": [0.0], "p": [1.0]}).encode("utf-16-le"), "as UTF-16 has without its mark"),
        ("t,p [°/s]\n0,1\n".encode("latin-1"), "byte 0xb0 in line 1 is not UTF-8"),
        (codecs.BOM_UTF16_LE + b"t,p\n0", "is not UTF-16"),
        (b"PK\x03\x04 and so on", "it is a spreadsheet or an archive: save it as CSV"),
        (b"\x1f\x8b\x08", "it is compressed: unpack it"),
        (b"ULog\x01\x12\x35\x01", "it is PX4's log: ulog2csv writes"),
        (b"#ROSBAG V2.0\n", "it is a bag of ROS"),
        (b"\x89HDF\r\n\x1a\n", "it is HDF5: write its columns"),
    ],
)
def test_what_is_no_text_is_named(tmp_path, refusal, content, words):
    assert words in refused(tmp_path, content)
    assert words in refusal("compare", tmp_path / "x.csv", CASE)


def as_r(content, quoted=True):
    """What R's write.table makes of a table: names of rows, and none above them."""
    head, *rows = content.splitlines()
    quote = '"' if quoted else ""
    names = " ".join(f"{quote}{name}{quote}" for name in head.split(" "))
    rows = [f"{quote}{k}{quote} {row}" for k, row in enumerate(rows, 1)]
    return "\n".join([names, *rows])


LAYOUTS = {
    "sep=;": "sep=;\n" + text(table(), ";"),
    "sep=; in quotes": '"sep=;"\r\n' + text(table(), ";").replace("\n", "\r\n"),
    "sep=; and decimal commas": "sep=;\n" + text(table(), ";").replace(".", ","),
    "tabs and decimal commas": text(table(), "\t").replace(".", ","),
    "Excel's Unicode text": ("\ufeff" + text(table(), "\t").replace(".", ",")).encode("utf-16-le"),
    "decimal commas of Fortran": text(table(), ";").replace("e-", "D-").replace(".", ","),
    "sep=|": "SEP=|\n" + text(table(), "|"),
    "sep and a tab": "sep=\t\n" + text(table(), "\t"),
    "// before": "// made by a program\n// t and such\n" + text(table()),
    "// among the rows": text(table()).replace("\n", "\n// a remark, with commas\n"),
    "a header after //": "// " + text(table()),
    "a header after %": "% " + text(table(), " "),
    "a header after !": "! " + text(table(), " "),
    "a header after ##": "## " + text(table()),
    "R's names of rows": as_r(text(table(), " ")),
    "a separator at the end": text(table()).replace("\n", ",\n").replace("gamma3,", "gamma3", 1),
    "separators at all ends": text(table()).replace("\n", ";\n").replace(",", ";"),
}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_layout(tmp_path, layout):
    columns_read = read(tmp_path, LAYOUTS[layout])
    assert columns_read.digits == polhode.compare(table(), CASE).digits
    named = "read as: the first cell of each row is its name, as R writes them"
    assert (named in columns_read.subject.remarks) == layout.startswith("R's")


def without_a_name(quote=""):
    """A table whose header lacks a name, that of its last column."""
    head, *rows = text({"t": [1.0, 2.0], "p": [0.1, 0.2], "q": [0.1, 0.2], "r": [1.0, 2.0]}).split()
    rows = [",".join(f"{quote}{x}{quote}" for x in row.split(",")) for row in rows]
    return "\n".join([head.removesuffix(",r"), *rows])


@pytest.mark.parametrize(
    "content",
    [without_a_name(), without_a_name('"'), as_r(text(table(), " "), quoted=False)],
    ids=["a name is missing", "in quotes", "names of rows that are numbers"],
)
def test_a_header_that_is_too_short_is_refused(tmp_path, content):
    """A column of times must not pass for names of rows, nor names of rows for times."""
    assert "names of rows, as R's, in quotes" in refused(tmp_path, content)


def test_names_of_rows_may_be_words(tmp_path):
    content = re.sub(r'"(\d)"', r'"row ""\1"""', as_r(text(table(), " ")))
    assert read(tmp_path, content).worst > 15


# -- names of data sets ----------------------------------------------------------------------------


def clock(unit, offset=0):
    """The times as whole numbers of a clock's unit."""
    return [int(offset + t * unit) for t in TIMES]


def spelt(table):
    rows = zip(*([repr(x) for x in np.asarray(x).tolist()] for x in table.values()), strict=True)
    return "\n".join([",".join(table), *map(",".join, rows)])


ZERO = np.zeros(len(TIMES))


def euroc(unit=10**9, offset=0, stamp="#timestamp"):
    """The ground truth of EuRoC's data sets: positions, attitude, velocity, biases."""
    mine = table("attitude")
    columns_read = {stamp: clock(unit, offset)}
    columns_read |= {f" p_RS_R_{x} [m]": ZERO + 9 for x in "xyz"}
    columns_read |= {f" q_RS_{x} []": mine[n] for x, n in zip("wxyz", ATTITUDE, strict=True)}
    columns_read |= {f" v_RS_R_{x} [m s^-1]": ZERO + 9 for x in "xyz"}
    columns_read |= {f" b_w_RS_S_{x} [rad s^-1]": ZERO + 9 for x in "xyz"}
    return columns_read | {f" b_a_RS_S_{x} [m s^-2]": ZERO + 9 for x in "xyz"}


def imu():
    """The gyroscope and the accelerometer of EuRoC's data sets."""
    mine = table()
    columns_read = {"#timestamp [ns]": clock(10**9)}
    columns_read |= {f"w_RS_S_{x} [rad s^-1]": mine[n] for x, n in zip("xyz", STATE, strict=False)}
    return columns_read | {f"a_RS_S_{x} [m s^-2]": ZERO + 9 for x in "xyz"}


def px4(*before, first="timestamp", unit=10**6):
    """An attitude as PX4's logs have it, in columns that ulog2csv writes."""
    mine = table("attitude")
    columns_read = {first: clock(unit)} | {name: clock(unit) for name in before}
    columns_read |= {f"q[{k}]": mine[n] for k, n in enumerate(ATTITUDE)}
    return columns_read


def rates_of_px4():
    mine = table()
    columns_read = {"timestamp": clock(10**6), "timestamp_sample": clock(10**6)}
    columns_read |= {f"xyz[{k}]": mine[n] for k, n in enumerate(STATE[:3])}
    return columns_read | {f"xyz_derivative[{k}]": ZERO + 9 for k in range(3)}


def ros(offset=0, names=("header.stamp.sec", "header.stamp.nanosec")):
    mine = table("attitude")
    seconds, rest = zip(*(divmod(t, 10**9) for t in clock(10**9, offset)), strict=True)
    columns_read = dict(zip(names, (seconds, rest), strict=True))
    return columns_read | {
        f"orientation.{x}": mine[n] for x, n in zip("wxyz", ATTITUDE, strict=True)
    }


NANO, MICRO = "nanoseconds, as in EuRoC's data sets", "microseconds, as in PX4's logs"
#: A data set, the part that is judged, and what its clock is said to count.
DATA_SETS = {
    "EuRoC's ground truth": (euroc(), "attitude", f"timestamp in {NANO}"),
    "EuRoC's gyroscope": (imu(), "omega", ""),
    "PX4's attitude": (px4("timestamp_sample"), "attitude", f"timestamp in {MICRO}"),
    "PX4's rates": (rates_of_px4(), "omega", f"timestamp in {MICRO}"),
    "ROS 2's stamps": (ros(), "attitude", ""),
    "ROS 1's stamps": (ros(names=("stamp.secs", "stamp.nsecs")), "attitude", ""),
    "stamps without a path": (ros(names=("sec", "nanosec")), "attitude", ""),
}


@pytest.mark.parametrize("name", DATA_SETS)
def test_a_data_set(tmp_path, name):
    columns_given, part, digits = DATA_SETS[name]
    table = read(tmp_path, spelt(columns_given))
    assert table.subject.times == tuple(TIMES)
    assert table.worst > 14.5
    assert table.worst_part == part or part == "omega"
    assert any(f"read as: {digits}" == x for x in table.subject.remarks) == bool(digits)
    plain = {header.strip(" #"): x for header, x in columns_given.items()}
    assert polhode.compare(plain, CASE).part_digits == table.part_digits


@pytest.mark.parametrize(
    "columns_given", [euroc(offset=1_403_636_579_758_555_392), ros(1_403_636_579_758_555_392)]
)
def test_a_clock_of_the_year_counts_from_the_first_row(tmp_path, columns_given):
    table = read(tmp_path, spelt(columns_given))
    assert table.worst > 14
    assert table.subject.readings[0].part == "t"


def test_a_timestamp_in_seconds_stays_one(tmp_path):
    mine = euroc(stamp="timestamp") | {"timestamp": [float(t) for t in TIMES]}
    assert read(tmp_path, spelt(mine)).subject.times == tuple(TIMES)
    bare = px4(unit=4)  # names that other programs have as well
    assert read(tmp_path, spelt(bare)).subject.times == tuple(4 * t for t in TIMES)


def test_vectors_of_px4_that_may_be_accelerations_are_not_read(tmp_path):
    columns_given = {n: x for n, x in rates_of_px4().items() if not n.startswith("xyz_d")}
    line = refused(tmp_path, spelt(columns_given))
    assert "PX4's xyz[0] is p in vehicle_angular_velocity alone" in line
    names = ["xyz[0]=p", "xyz[1]=q", "xyz[2]=r"]
    table = read(tmp_path, spelt(columns_given), columns=names)
    assert table.worst > 14.5


@pytest.mark.parametrize("rest", [10**9, -1, "0.5"])
def test_nanoseconds_are_the_rest_of_a_second(tmp_path, rest):
    columns_given = ros()
    columns_given["header.stamp.nanosec"] = [0] * 8 + [rest]
    with pytest.raises(BadInput, match=r"header\.stamp\.nanosec.*(whole|number)"):
        polhode.compare({n.strip(): x for n, x in columns_given.items()}, CASE)
    line = refused(tmp_path, spelt(columns_given).replace("'", ""))
    assert "x.csv: header.stamp.sec, row 9 = 2, " in line
    assert "whole nanoseconds below 1e9" in line


@pytest.mark.parametrize("seconds", [1, np.array(1), None, "12", {0, 1}, {0: 1}])
def test_seconds_of_a_stamp_are_a_column(seconds):
    # such were read letter by letter, or ended with a traceback
    with pytest.raises(BadInput, match=r"compare: sec.*: expected a column of whole numbers"):
        polhode.compare({"sec": seconds, "nanosec": [0, 0], "p": [0.0, 0.0]}, CASE)


def test_other_parts_of_names_are_no_parts_of_a_time():
    others = ("stamp.sec", "stamp.nanosec", "b_w_RS_S_x [rad s^-1]", "p_RS_R_x [m]")
    columns_given = {"time": [0.0], "p": [0.16]} | {name: [9.0] for name in others}
    assert polhode.compare(columns_given, CASE).subject.ignored == others

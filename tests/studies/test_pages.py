"""Pages of studies: tables of rows and columns, figures with a mark a row, one HTML page of all."""

from __future__ import annotations

import copy
import re
import shlex
import sys
from collections.abc import Iterator
from importlib import import_module
from importlib.resources import files
from string import Formatter
from typing import Any
from xml.etree import ElementTree

import pytest

from polhode.common.texts import JsonObject
from polhode.studies import report
from polhode.studies.page.html import html
from polhode.studies.page.tables import Column, PageTable, table, yes
from polhode.studies.page.template import filled
from polhode.studies.row_filter import Only
from shared.reports import COMMITTED, committed


def module(name: str, part: str) -> Any:
    return import_module(f"polhode.studies.{name.replace('-', '_')}.{part}")


# -- tables -------------------------------------------------------------------------------------

ROW = {"name": "a", "digits": 12.34, "seconds": {"run": 0.5}, "found": [1, 2], "gap": None}


@pytest.mark.parametrize(
    ("value", "form", "cell", "side"),
    [
        ("name", "", "a", "l"),
        ("name", "code", "`a`", "l"),
        ("name", ">", "a", "r"),
        ("digits", ".1f", "12.3", "r"),
        ("seconds.run", ".2g", "0.5", "r"),
        ("found.1", "d", "2", "r"),
        ("gap", ".1f", "–", "r"),
        ("gap.deeper", "", "–", "l"),
        ("name", ".1f", "a", "r"),  # such as how a run ended, in place of its digits
        (lambda row: 2 * row["digits"], ".2f", "24.68", "r"),
        (yes("digits"), "", "yes", "l"),
        (yes("gap", "NO"), "", "NO", "l"),
        (yes("not there"), "", "–", "l"),
    ],
)
def test_a_cell_is_a_value_of_the_row_in_the_form_of_its_column(value, form, cell, side):
    column = Column("header", value, form)
    assert (column.cell(ROW), column.side) == (cell, side)


def test_a_table_is_rows_of_columns_with_what_they_hold_and_how_to_make_them_again():
    meaning = "as `much` < *that*"
    columns = Column("a|b", "name", "code"), Column("p", "digits", ".1f", meaning)
    columns = *columns, Column("q", "digits", ".0f", meaning)
    made = table([ROW, {"name": "b"}], columns, "x {0} '{1}'")
    assert made.rows == (("`a`", "12.3", "12"), ("`b`", "–", "–"))
    assert made.command(made.rows[1]) == "x b '–'"
    assert made.markdown == (
        "| a\\|b | p | q |\n|---|--:|--:|\n| `a` | 12.3 | 12 |\n| `b` | – | – |\n\n"
        f"Columns: *p, q*: {meaning}.\nTo make rows again, here the first: `x a '12.3'`."
    )
    assert table([], columns).markdown == ""


def test_a_part_without_rows_is_left_out_under_its_heading():
    template = "# A\n\n{n} of it\n\n## B\n\nwords\n\n{b}\n\n{c}\n\n### C\n\nmore {n}\n\n{c}\n"
    whole = PageTable(("x",), (("1",),), "l")
    none = whole._replace(rows=())
    text = filled(template, {"b": whole, "c": none}, {"n": 2})
    assert text == "# A\n\n2 of it\n\n## B\n\nwords\n\n| x |\n|---|\n| 1 |\n"
    assert filled(template, {"b": none, "c": none}, {"n": 2}) == "# A\n\n2 of it\n"


@pytest.mark.parametrize("name", report.STUDIES)
def test_every_table_and_every_fact_stands_on_the_page_once_and_is_explained(name):
    """A name for each, and each in the template; a table and a fact of one name would hide it."""
    found, page = committed(name), module(name, "page")
    tables, facts = page.tables(found), page.facts(found)
    template = (files(page.__package__) / "page.md").read_text(encoding="utf-8")
    named = [field for _, field, _, _ in Formatter().parse(template) if field is not None]
    assert not {*tables} & {*facts}
    assert sorted(field for field in named if field in tables) == sorted(tables)
    assert {field.partition("[")[0] for field in named} == {*tables, *facts, "question", "origin"}
    meanings = {meaning for made in tables.values() for meaning in made.meanings if meaning}
    assert meanings
    assert not [line for line in meanings if ";" in line or line.endswith(".")]
    for made in tables.values():  # two columns of one name tell a reader nothing
        assert len({*made.header}) == len(made.header)


# -- every row can be made again ------------------------------------------------------------------


class Listed(Only):
    """Wants nothing, and keeps the labels of every row that it was asked for."""

    def __call__(self, *labels: str) -> bool:
        self.passed.append(labels)
        return False


def finds(command: str, name: str, rows: list[tuple[str, ...]]) -> bool:
    """Whether a command names this study and a row of it, or the study as a whole."""
    program, verb, study, *rest = shlex.split(command)
    assert (program, verb, study) == ("polhode", "study", name)
    assert rest
    wanted = Only(tuple(rest[1::2]))
    return rest == ["-o", "DIR"] or (
        set(rest[::2]) == {"--only"} and any(wanted(*row) for row in rows)
    )


@pytest.mark.sample(2, first=3)
@pytest.mark.parametrize("name", report.STUDIES)
def test_every_row_has_a_command_that_finds_it(name):
    listed, found = Listed(("nothing",)), committed(name)
    module(name, "rows").rows(False, print, listed)  # nothing is run
    tables = module(name, "page").tables(found)
    assert all(
        made.again or place in ("summary", "standing", "faults") for place, made in tables.items()
    )
    made = [x.command(row) for x in tables.values() if x.again for row in x.rows]
    text = report.page(found).partition("## Provenance")[0]
    made += re.findall(r"`(polhode study [^`]+)`", text)
    assert made
    assert [command for command in made if not finds(command, name, listed.passed)] == []
    assert not finds(f"polhode study {name} --only 'no such row'", name, listed.passed)


# -- results with few rows ------------------------------------------------------------------------


def rows_in(found: JsonObject) -> Iterator[tuple[JsonObject, str]]:
    """Where there are lists of rows in a study's results: the object that has one, and its key."""
    for key, value in found.items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            yield found, key
        elif isinstance(value, dict) and key != "provenance":
            yield from rows_in(value)


@pytest.mark.sample(6)
@pytest.mark.parametrize("name", report.STUDIES)
@pytest.mark.parametrize("kept", [0, 1])
def test_a_page_of_no_rows_and_of_one_row_of_each_kind_can_be_made(name, kept):
    whole = committed(name)
    for k in range(len([*rows_in(whole)])):
        found = copy.deepcopy(whole)
        for j, (place, key) in enumerate(rows_in(found)):
            if not (name == "stability" and key == "cases"):  # which its kinds name
                place[key] = place[key][: kept * (j == k)]
        assert report.page(found).startswith(report.page(whole).partition("\n")[0])


def marks(found: JsonObject, figure: str) -> int:
    """How many marks and ticks a figure has."""
    return report.figures(found)[figure].count("<use ")


def one_run_less(case: str) -> Any:
    def change(found: JsonObject) -> None:
        del next(row["runs"] for row in found["cases"] if row["case"] == case)[0]

    return change


@pytest.mark.slow
@pytest.mark.parametrize(
    ("study", "change"),
    [
        ("accuracy", one_run_less("kovalevskaya/generic")),
        ("stability", one_run_less("hard/near-cusp")),
        ("proofs", lambda found: found["orbits"][0]["orbits"].pop(0)),
    ],
)
def test_a_row_less_is_a_mark_less(study, change):
    found = committed(study)
    before = marks(found, study)
    change(found)
    assert before - marks(found, study) == 1


@pytest.mark.slow
def test_a_run_with_fewer_digits_than_expected_has_a_ring():
    found = committed("stability")
    runs = [run for case in found["cases"] for run in case["runs"] if run.get("expected")]
    behind = sum(run["correct_digits"] < run["expected"][0] for run in runs)
    before = marks(found, "stability")
    for run in runs:
        run["expected"] = None
    assert before - marks(found, "stability") == behind > 10


@pytest.mark.slow
def test_a_study_of_which_a_part_has_no_rows_has_its_figures():
    empty: list[JsonObject] = [
        {"study": "events", "motions": [], "cost": []},
        {"study": "accuracy", "cases": []},
        {"study": "proofs", "orbits": [{"what": "a top", "orbits": []}], "chaos": []},
    ]
    for found in empty:
        (drawn,) = report.figures(found).values()
        assert drawn.startswith("<?xml")


# -- one page of all ------------------------------------------------------------------------------

SVG = '<?xml version="1.0"?>\n<svg viewBox="0 0 1 1"><path d="M 0 0"/></svg>\n'
TEXTS = {
    "first.svg": SVG,
    "first.md": """# First <study>

A < B & *C*: `a<b` at [the source](https://example.org/x?a=1&b=2), <script>alert()</script>

| case | digits |
|---|--:|
| `x < y`, a\\|b | 13.5 |

## Numbers & more

![What it "shows"](first.svg)
""",
    "second.md": "# Second\n\nSee [first](first.md).\n",
}


def tags_of(text: str) -> list[str]:
    """A page's elements; it is well formed, names each thing once, asks the network for nothing."""
    root = ElementTree.fromstring(re.sub(r"<(!DOCTYPE|meta)[^>]*>", "", text))
    ids = [x.get("id") for x in root.iter() if x.get("id") is not None]
    assert len(ids) == len(set(ids))
    for x in root.iter():
        assert not {"srcset", "data", "action", "poster"} & set(x.attrib)
        assert x.get("src", "data:image/svg+xml;base64,").startswith("data:image/svg+xml;base64,")
        target = x.get("href", "https://")
        assert target[1:] in ids or target.startswith(("https://", "http://")), target
        assert x.tag == "a" or "href" not in x.attrib
    tags = [x.tag for x in root.iter()]
    assert not {"script", "link", "iframe", "object", "embed", "base", "svg"} & set(tags)
    assert "@import" not in text
    assert "url(" not in text
    return tags


def test_the_page_is_whole_escaped_and_needs_nothing_else():
    text = html(TEXTS)
    tags = tags_of(text)
    counts = [tags.count(tag) for tag in ("table", "img", "section", "h1", "h2", "h3")]
    assert counts == [1, 1, 2, 1, 2, 1]
    for part in (
        "A &lt; B &amp; <em>C</em>: <code>a&lt;b</code>",
        '<a href="https://example.org/x?a=1&amp;b=2">the source</a>',
        "&lt;script&gt;",
        'alt="What it &quot;shows&quot;"',
        '<td style="text-align:right">13.5</td>',
        "First &lt;study&gt;</a>",
    ):
        assert part in text
    assert text.count('<a href="#first">') == 2  # of the contents, and of the other page


def test_the_committed_page_is_that_of_the_committed_pages():
    paths = [*sorted(COMMITTED.glob("*.svg")), *(COMMITTED / f"{x}.md" for x in report.STUDIES)]
    texts = {path.name: path.read_text() for path in paths}
    text = (COMMITTED / report.PAGE).read_text()
    assert text == html(texts)
    tags = tags_of(text)
    assert tags.count("section") == len(report.STUDIES) <= tags.count("img")
    assert tags.count("table") == sum(text.count("\n|--") for text in texts.values())


def test_without_markdown_it_a_report_says_so_before_its_work(monkeypatch, refusal):
    monkeypatch.setitem(sys.modules, "markdown_it", None)
    told = "study: markdown-it-py: expected it to be installed: pip install 'polhode[report]'"
    assert refusal("study", "all", "-o", "out") == f"polhode: {told}\n"

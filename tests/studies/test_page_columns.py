"""Tables of rows and columns, and pages of results that have few rows or none."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from importlib import import_module
from importlib.resources import files
from pathlib import Path
from string import Formatter

import pytest

from polhode.output.json_object import JsonObject
from polhode.studies import report
from polhode.studies.page import words
from polhode.studies.page.tables import Column, PageTable, at, at_times, table, yes
from polhode.studies.page.template import filled

COMMITTED = Path(__file__).parents[2] / "reports"
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
        ("not there", "code", "–", "l"),
        ("name", ".1f", "a", "r"),  # such as how a run ended, in place of its digits
        (lambda row: 2 * row["digits"], ".2f", "24.68", "r"),
        (yes("digits"), "", "yes", "l"),
        (yes("gap", "NO"), "", "NO", "l"),
        (yes("not there"), "", "–", "l"),
    ],
)
def test_a_cell_is_a_value_of_the_row_in_the_form_of_its_column(value, form, cell, side):
    column = Column("header", value, form)
    assert column.cell(ROW) == cell
    assert column.side == side


def test_a_table_is_rows_of_columns():
    columns = (Column("name", "name"), Column("digits", "digits", ".1f"))
    made = table([ROW, {"name": "b"}], columns, "again {0}")
    assert made.header == ("name", "digits")
    assert made.rows == (("a", "12.3"), ("b", "–"))
    assert made.align == "lr"
    assert made.command(made.rows[1]) == "again b"
    assert table([], columns).rows == ()


def test_a_column_for_each_time_reads_its_own_place():
    columns = at_times([1, 10], lambda row, place: at(row, "found")[place])
    assert [(column.header, column.cell(ROW)) for column in columns] == [
        ("t = 1", "1"),
        ("t = 10", "2"),
    ]


def test_counts_and_ranges_in_words():
    assert words.share([True, False, True]) == "2 of 3"
    assert words.between([3.0, 1.0], ".1f") == "1.0 to 3.0"
    assert words.between([], ".1f") == "–" == words.median([], ".1f") == words.listed([])
    assert words.median([1.0, 2.0, 9.0], "g") == "2" == words.spread([2.0], "g")
    assert words.spread([1.0, 2.0, 9.0], "g") == "2 (1–9)"
    assert words.counted({"a": 2, "b": 0, "c": 1}) == "2 a, 1 c"
    assert words.listed(["b", "a", "b"]) == "a, b"


def rows_in(found: JsonObject) -> Iterator[tuple[JsonObject, str]]:
    """Where there are lists of rows in a study's results: the object that has one, and its key."""
    for key, value in found.items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            yield found, key
        elif isinstance(value, dict) and key != "provenance":
            yield from rows_in(value)


@pytest.mark.parametrize("name", report.STUDIES)
@pytest.mark.parametrize("kept", [0, 1])
def test_a_page_of_no_rows_and_of_one_row_of_each_kind_can_be_made(name, kept):
    whole = report.results(COMMITTED, name)
    assert whole is not None
    for k in range(len([*rows_in(whole)])):
        found = copy.deepcopy(whole)
        for j, (place, key) in enumerate(rows_in(found)):
            if not (name == "stability" and key == "cases"):  # which its kinds name
                place[key] = place[key][: kept * (j == k)]
        assert report.page(found).startswith(report.page(whole).partition("\n")[0])


@pytest.mark.parametrize("name", report.STUDIES)
def test_every_table_and_every_fact_stands_on_the_page_once(name):
    """A name for each, and each in the template; a table and a fact of one name would hide it."""
    found = report.results(COMMITTED, name)
    module = import_module(f"polhode.studies.{name.replace('-', '_')}.page")
    tables, facts = module.tables(found), module.facts(found)
    template = (files(module.__package__) / "page.md").read_text(encoding="utf-8")
    named = [field for _, field, _, _ in Formatter().parse(template) if field is not None]
    assert not {*tables} & {*facts}
    assert sorted(field for field in named if field in tables) == sorted(tables)
    assert {field.partition("[")[0] for field in named} == {*tables, *facts, "question"}


def test_a_part_without_rows_is_left_out_under_its_heading():
    template = "# A\n\n{n} of it\n\n## B\n\nwords\n\n{b}\n\n{c}\n\n### C\n\nmore {n}\n\n{c}\n"
    whole = PageTable(("x",), (("1",),), "l")
    none = whole._replace(rows=())
    text = filled(template, {"b": whole, "c": none}, {"n": 2})
    assert text == "# A\n\n2 of it\n\n## B\n\nwords\n\n| x |\n|---|\n| 1 |\n"
    assert filled(template, {"b": none, "c": none}, {"n": 2}) == "# A\n\n2 of it\n"


def test_columns_are_explained_by_their_headers():
    meaning = "as `much` < *that*"
    made = PageTable(("p", "q", "r"), (("1", "2", "3"),), "rrr", meanings=(meaning, meaning, ""))
    assert made.markdown.endswith(f"\n\nColumns: *p, q*: {meaning}.")
    assert "Columns" not in made._replace(meanings=()).markdown
    assert "| a\\|b |" in PageTable(("p",), (("a|b",),), "l").markdown


@pytest.mark.parametrize("name", report.STUDIES)
def test_what_is_explained_of_a_study_can_stand_in_one_line(name):
    found = report.results(COMMITTED, name)
    module = import_module(f"polhode.studies.{name.replace('-', '_')}.page")
    tables = module.tables(found).values()
    explained = {meaning for made in tables for meaning in made.meanings if meaning}
    assert explained
    assert not [line for line in explained if ";" in line or line.endswith(".")]
    for made in tables:  # two columns of one name tell a reader nothing
        assert len({*made.header}) == len(made.header)

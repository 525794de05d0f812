"""Every row of every table says how to make its numbers again, and that command finds the row."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest

from polhode.studies import report
from polhode.studies.page.tables import PageTable
from polhode.studies.row_filter import Only

COMMITTED = Path(__file__).parents[2] / "reports"


class Listed(Only):
    """Wants nothing, and keeps the labels of every row that it was asked for."""

    def __call__(self, *labels: str) -> bool:
        self.passed.append(labels)
        return False


def labels(name: str) -> list[tuple[str, ...]]:
    """The labels of all rows of a study; nothing is run."""
    listed = Listed(("nothing",))
    import_module(f"polhode.studies.{name.replace('-', '_')}.rows").rows(False, None, listed)
    return listed.passed


def commands(name: str) -> Iterator[tuple[str, str]]:
    """The commands of all rows of the committed page, and of its text, each with its place."""
    found = report.results(COMMITTED, name)
    module = import_module(f"polhode.studies.{name.replace('-', '_')}.page")
    for place, table in module.tables(found).items():
        assert table.again or place in ("elsewhere", "faults"), place
        if table.again:
            yield from ((table.command(row), str(row[:2])) for row in table.rows)
    own = report.page(found).partition("## Provenance")[0]
    yield from ((told, told) for told in re.findall(r"`(polhode study [^`]+)`", own))


def finds(command: str, name: str, rows: list[tuple[str, ...]]) -> bool:
    """Whether a command names this study and a row of it, or the study as a whole."""
    program, verb, study, *rest = shlex.split(command)
    assert (program, verb, study) == ("polhode", "study", name)
    if rest == ["-o", "DIR"]:
        return True
    assert rest
    assert set(rest[::2]) == {"--only"}
    wanted = Only(tuple(rest[1::2]))
    return any(wanted(*row) for row in rows)


@pytest.mark.sample(4)
@pytest.mark.parametrize("name", report.STUDIES)
def test_every_row_has_a_command_that_finds_it(name):
    rows = labels(name)
    made = list(commands(name))
    assert made
    assert [where for command, where in made if not finds(command, name, rows)] == []


def test_a_command_that_finds_nothing_is_seen():
    rows = [("euler t=10 outputs=2", "heyoka by hand"), ("euler/rest",)]
    assert finds("polhode study speed --only 't=10 outputs=2' --only heyoka", "speed", rows)
    assert not finds("polhode study speed --only 't=10 outputs=3'", "speed", rows)
    assert not finds("polhode study speed --only rest --only heyoka", "speed", rows)


def test_the_command_stands_below_the_table():
    table = PageTable(("case", "number"), (("`a/b`", "quad"), ("c/d", "mp")), "ll", "x {0} '{1}'")
    assert "To make rows again, here the first: `x a/b 'quad'`" in table.markdown
    assert "again" not in table._replace(again="").markdown
    assert table._replace(rows=()).markdown == ""

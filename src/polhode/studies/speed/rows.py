"""Study ``speed``: seconds against digits, in every number type and beside other programs."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from polhode.common.errors import BadInput
from polhode.common.progress import Message
from polhode.studies.row_filter import Only
from polhode.studies.speed import cells, first_result, number_types
from polhode.studies.speed.programs import ENGINE, OURS, PROGRAMS, RUN, Program, left_out, missing
from polhode.studies.speed.refined import contests

NAME = "speed"
QUESTION = (
    "What does a correct digit cost: the first result in a new process, a new start of a prepared "
    "body, a long run, beside other programs called at their best; and how does the cost grow with "
    "the digits in polhode's number types?"
)
QUICK_PROGRAMS = (OURS, RUN, ENGINE)  # what needs no compiler


def rows(
    quick: bool = False,
    tick: Message | None = None,
    only: Only | None = None,
    without: Sequence[str] = (),
) -> dict[str, Any]:
    """The study's results as a JSON object; seconds vary from run to run, digits do not.

    ``without``: packages or programs that are not run.  Raises BadInput where another cannot be
    imported: a table of those that happen to be there is no comparison.
    """
    wanted, said = only or Only(), _named(tick)
    asked_cells = cells.wanted_cells(quick, wanted)
    asked = number_types.motions(quick, wanted)
    first = not wanted or wanted("first result")
    programs = taking_part(quick, without) if asked_cells or first else []
    with tempfile.TemporaryDirectory() as cache:
        starting = [*first_result.rows(programs, quick, said)] if first else []
        held = cells.rows(asked_cells, [p for p in programs if p.last], Path(cache), quick, said)
    found = []
    for motion, ways in asked.items():
        if said is not None:
            said(f"number types: {motion.name}")
        found.append(number_types.row(motion, ways, quick))
    return {
        "study": NAME,
        "question": QUESTION,
        "quick": quick,
        "once_above": number_types.PATIENCE,
        "programs": [program.name for program in programs],
        "without": [*without],
        "first": starting,
        "cells": held,
        "motions": found,
        "refined": contests(quick, said, wanted),
    }


def versions() -> dict[str, str]:
    """Of the programs that are there."""
    from importlib.metadata import PackageNotFoundError, version

    found = {}
    for name in sorted({need for program in PROGRAMS for need in program.needs}):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def taking_part(quick: bool, without: Sequence[str]) -> list[Program]:
    """Those that take part; raises BadInput for one that is not there, or not known."""
    known = {word.lower() for p in PROGRAMS for word in (p.name, *p.needs)}
    for word in without:
        if word.lower() not in known:
            packages = sorted({need for p in PROGRAMS for need in p.needs})
            raise BadInput("study", "--without", word, f"one of {', '.join(packages)}")
    chosen = [
        program
        for program in PROGRAMS
        if not left_out(program, without) and (not quick or program.name in QUICK_PROGRAMS)
    ]
    absent = missing(chosen)
    if absent:
        package = next(iter(absent))
        told = f"installed (pip install 'polhode[peers]'), or left out: --without {package}"
        raise BadInput("study", "speed", package, told)
    return chosen


def _named(tick: Message | None) -> Message | None:
    return None if tick is None else lambda what: tick(f"{NAME}: {what}")

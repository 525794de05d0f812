"""Study ``speed``: seconds against digits, in every number type and beside other programs."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from polhode.common.interrupts import Message
from polhode.studies.row_filter import Only
from polhode.studies.speed import cells, first_result, number_types
from polhode.studies.speed.programs import ENGINE, OURS, PROGRAMS, RUN
from polhode.studies.speed.refined import contests

QUESTION = (
    "What does a correct digit cost: the first result in a new process, a new start of a prepared "
    "body, a long run, beside other programs called at their best; and how does the cost grow with "
    "the digits in polhode's number types?"
)
QUICK_PROGRAMS = (OURS, RUN, ENGINE)  # what needs no compiler


def rows(quick: bool, say: Message, wanted: Only) -> dict[str, Any]:
    """The study's rows; seconds vary from run to run, digits do not.

    ``without``: the programs that are not installed.
    """
    asked_cells = cells.wanted_cells(quick, wanted)
    asked = number_types.motions(quick, wanted)
    first = wanted("first result")
    chosen = [p for p in PROGRAMS if not quick or p.name in QUICK_PROGRAMS]
    programs = [p for p in chosen if p.is_there]
    with tempfile.TemporaryDirectory() as cache:
        starting = [*first_result.rows(programs, quick, say)] if first else []
        held = cells.rows(asked_cells, [p for p in programs if p.last], Path(cache), quick, say)
    found = []
    for motion, ways in asked.items():
        say(f"number types: {motion.name}")
        found.append(number_types.row(motion, ways, quick))
    return {
        "once_above": number_types.PATIENCE,
        "programs": [program.name for program in programs],
        "without": [p.name for p in chosen if not p.is_there],
        "first": starting,
        "cells": held,
        "motions": found,
        "refined": contests(quick, say, wanted),
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

"""What a table must have where digits are demanded of it: whole vectors, a number in each cell."""

from __future__ import annotations

from polhode.common.errors import BadInput
from polhode.judging.score.judgement import Judgement
from polhode.judging.tables.table import Table
from polhode.numbers.decimals import brief
from polhode.scenes.vocabulary import ATTITUDE


def refuse_incomplete(judged: Judgement) -> None:
    """Raise BadInput for what is judged in part only, or where nothing was judged.

    That is a vector of which components are missing, or a cell that is empty or not a number.  An
    angle may be missing where the motion has none: psi and phi at a pole.
    """
    table = judged.subject
    if table.early:
        raise BadInput(table.name, "rows", len(table.times), f"all of them ({table.early})")
    if table.run is None:
        _refuse_parts(judged, table)
        _refuse_gaps(judged, table)
    _ = judged.worst  # raises BadInput where nothing was judged


def _refuse_parts(judged: Judgement, table: Table) -> None:
    columns = judged.reference.scene.columns
    for vector in (columns[:3], columns[3:], ATTITUDE if columns[3:] else ()):
        missing = [name for name in vector if name not in table.columns]
        if 0 < len(missing) < len(vector):
            there = ", ".join(name for name in vector if name in table.columns)
            expected = f"it beside {there}"
            if table.ignored:
                expected += f" (columns that are not known: {', '.join(table.ignored)})"
            raise BadInput(table.name, ", ".join(missing), None, expected)


def _refuse_gaps(judged: Judgement, table: Table) -> None:
    if judged.missing:
        name = min(judged.missing, key=lambda name: judged.missing[name][0])
        row = judged.missing[name][0]
        place = f"{name} in row {row + 1}, t = {brief(table.times[row])}"
        expected = "a number in each cell that is judged (it is empty or not a number)"
        raise BadInput(table.name, place, None, expected)

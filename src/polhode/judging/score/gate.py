"""What a table must have where digits are demanded of it: whole vectors, a number in each cell."""

from __future__ import annotations

from collections.abc import Iterator

from polhode.common.errors import BadInput
from polhode.judging.score.judgement import Judgement
from polhode.judging.score.part_digits import principal_angles
from polhode.judging.tables.table import Table
from polhode.numbers.decimals import brief
from polhode.numbers.number_types import DOUBLE
from polhode.scenes.vocabulary import ANGLES, ATTITUDE

_DIGITS = 15  # of the angles that are asked for where a table has none


def refuse_incomplete(judged: Judgement) -> None:
    """Raise BadInput for what is judged in part only, or where nothing was judged.

    That is a vector of which components are missing, or a cell that is empty or not a number.  An
    angle may be missing where the motion has none: psi and phi at a pole.
    """
    table = judged.subject
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
    gaps = [gap for name in table.columns for gap in _gaps(judged, table, name)]
    if gaps:
        row, name = min(gaps, key=lambda gap: gap[0])
        place = f"{name} in row {row + 1}, t = {brief(table.times[row])}"
        expected = "a number in each cell that is judged (it is empty or not a number)"
        raise BadInput(table.name, place, None, expected)


def _gaps(judged: Judgement, table: Table, name: str) -> Iterator[tuple[int, str]]:
    """The first row of a column that has no number, though the motion has one there."""
    missing = [k for k, x in enumerate(table.columns[name]) if x is None]
    if missing and name in ANGLES:
        times, column = [judged.times[k] for k in missing], ANGLES.index(name)
        try:
            attitude = judged.reference.attitude(times, _DIGITS)
        except ValueError:  # what the motion has there is not known
            pass
        else:
            pairs = zip(missing, principal_angles(attitude, DOUBLE.bits), strict=True)
            missing = [k for k, row in pairs if row[column] is not None]
    yield from ((k, name) for k in missing[:1])

"""Anything judged: a run, somebody's file, columns, an array of states.

First the truth and the table, then how the table is read and how many of its digits are right, then
what was to be expected, what limits the digits and what may be wrong.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Never

from polhode.common.arguments import each, of_kind, refuse_unknown, with_progress
from polhode.common.errors import BadInput, TooManySteps
from polhode.common.interrupts import Progress
from polhode.common.values import waiting
from polhode.judging.judgement import Judgement, diagnosis
from polhode.judging.reference import NoAnswer, ProofLimits, Reference, reference
from polhode.judging.score import Score, score
from polhode.judging.tables.column_aliases import PLAIN, Naming, naming
from polhode.judging.tables.csv_file import table_of_columns, table_of_rows
from polhode.judging.tables.explanations import as_meant, read_as_told
from polhode.judging.tables.hypotheses import clock_remark
from polhode.judging.tables.table import Reading, TrajectoryTable, as_judged, of_run
from polhode.judging.tables.table_file import ENDINGS, read_table
from polhode.numbers.decimals import brief
from polhode.numbers.number_types import AnyNumber, AnyVector, NumberType
from polhode.runs.options import choose_number
from polhode.runs.trajectory import Trajectory
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import ATTITUDE

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

_MOTION = ("units", "body", "omega", "gamma")  # fields of a scene that tell its motion


@with_progress
def compare(
    what: Trajectory
    | TrajectoryTable
    | str
    | Path
    | Iterable[AnyVector]
    | Mapping[str, AnyVector]
    | pd.DataFrame
    | xr.Dataset,
    against: Reference | Scene | str | Path | None = None,
    *,
    number: str | NumberType | None = None,
    digits: int | None = None,
    at: Iterable[AnyNumber] | None = None,
    columns: Sequence[str] | None = None,
    progress: Progress | None = None,
    as_it_stands: bool = False,
    read: str | None = None,
    max_seconds: float | None = None,
    forecast: Callable[[float], None] | None = None,
    details: bool = False,
    **unknown: Never,
) -> Judgement:
    """Judge a run, a trajectory file, columns or an array of states against a reference.

    Parameters
    ----------
    what : Trajectory, str, Path, mapping, DataFrame, Dataset or rows
        A run, or the path of a file that polhode saved; the path of a CSV file (``-``: the standard
        input) with a column t and any of p q r gamma1 gamma2 gamma3 psi theta phi q0 q1 q2 q3, or
        of a derived output; of an .npz, .npy or .parquet file of such columns; the same columns as
        a mapping of names to arrays, a pandas DataFrame or an xarray Dataset; or rows of numbers,
        which hold at the times ``at`` and have the columns ``columns``.
    against : reference, Scene, str or Path, optional
        A reference, or the scene whose reference it is; of a run its own scene unless given.
    number : str or NumberType, optional
        The type to which a file's decimals, or the rows, were rounded.  Floats, of Python or of
        arrays (single, double or long double), are recognised.  A run has its own.
    digits : int, optional
        The digits of the type, if ``number`` is mp.
    at : iterable of numbers, optional
        The times of rows, in the scene's unit.
    columns : sequence of str, optional
        Of rows, by default those of the scene.  Of a file without a header, or with another, its
        columns in order; or what single names of its header, or of a mapping or frame, mean:
        ``["time_ms=t*1e-3", "Q.W=q0"]``.
    progress : callable, optional
        Called with the fraction of the reference's rows that are computed, and how many (of a
        proof, with the fraction of the time, and the steps), if that takes long.
    as_it_stands : bool
        Judge the numbers in the conventions of the scene alone.  Otherwise another convention that
        makes a part right is applied, and ``reading`` says which.
    read : str, optional
        Readings to apply to a table, whatever digits they give, in the words of a judgement's
        ``reading``: "omega degrees; attitude scalar-last".
    max_seconds : float, optional
        A limit on proofs, if there is no closed form; none beside a certified reference, which has
        its own.
    forecast : callable, optional
        Called before each proof with a rough estimate of its seconds; none beside such a one.
    details : bool
        Also find what no limit needs: the digits to expect where a table has the last digits of its
        type, and the root mean square and bias of what is left of it.
    **unknown
        No other argument is accepted; one is refused with the nearest known names.

    Returns
    -------
    Judgement
        Correct digits of each part at each time, the band that is expected, and what limits them.

    Raises
    ------
    BadInput
        Input that cannot be read or judged, or a proof that takes longer than ``max_seconds``.

    Examples
    --------
    >>> import polhode
    >>> scene = polhode.load("lagrange/nutation").at((1,))
    >>> rows = [[float(x) for x in polhode.reference(scene).at([1], 20)[0]]]
    >>> judgement = polhode.compare(rows, scene, at=[1], number="double")
    >>> 15.4 < judgement.worst <= 16, judgement.limit
    (True, 'rounding')
    >>> rows[0][0] += 1e-6  # in p, where the largest |omega| is that at t = 1
    >>> 6 < polhode.compare(rows, scene, at=[1]).worst < 7
    True
    """
    gate = "no threshold: polhode.testing.assert_digits(run, scene, at_least) has one"
    refuse_unknown("compare", compare, unknown, at_least=gate)
    of_kind("compare", "details", details, bool, "True or False")
    of_kind("compare", "as_it_stands", as_it_stands, bool, "True or False")
    of_kind("compare", "read", read, (str, type(None)), "a text: 'omega degrees'")
    limits = ProofLimits(progress, forecast, max_seconds)
    truth = _truth(what, against, limits)
    scene = truth.scene
    table_given = _table(what, scene, number, digits, at, columns)
    run = None if isinstance(what, Trajectory) else table_given.run
    if run and (read or any(getattr(run.scene, x) != getattr(scene, x) for x in _MOTION)):
        table_given = replace(table_given, run=None)  # another's table, as it were
    table_given = as_judged(table_given, scene)
    if not table_given.columns:
        expected = f"columns of {', '.join(scene.columns)}, angles or attitude"
        raise BadInput(table_given.name, "header", None, expected)
    is_read = table_given.run is None and read is None and not as_it_stands
    table, offered = table_given, tuple[Reading, ...]()
    if table_given.run is None and read is not None:
        table = read_as_told(table_given, truth, read)
    elif is_read:
        table, offered = as_meant(table_given, truth)
    try:
        result: Score | None = score(table, truth, progress)
    except TooManySteps as fault:
        expected = "; ".join([fault.expected, *clock_remark(table, scene)])
        raise TooManySteps(fault.source, "t", fault.value, expected) from None
    except NoAnswer:
        if not truth.is_closed_form:
            raise
        result = None
    if result is None:  # what the closed form cannot tell, a proof may
        truth = reference(scene, "certified", **limits._asdict())
        if is_read:
            table, offered = as_meant(table_given, truth)
        result = score(table, truth, progress)
    meaning = waiting(partial(diagnosis, result, offered, details))
    return Judgement(**{x.name: getattr(result, x.name) for x in fields(Score)}, diagnosis=meaning)


def _truth(
    source: Any, against: Reference | Scene | str | Path | None, limits: ProofLimits
) -> Reference:
    """The reference that judges; raises BadInput."""
    if against is None:
        if not isinstance(source, Trajectory):
            raise BadInput("compare", "against", None, "a reference, or a scene")
        against = source.scene
    kinds = (Reference, Scene, str, Path)
    of_kind("compare", "against", against, kinds, "a reference, or a scene")
    if isinstance(against, (str, Path)) and Path(against).suffix.lower() in ENDINGS:
        expected = (
            "a scene, a case's name or a .toml file: a table is judged by a motion, and not by "
            f"another table (polhode compare {against} SCENE judges that one)"
        )
        if isinstance(source, (str, Path)) and Path(source).suffix.lower() == ".toml":
            expected = f"the scene after the table: polhode compare {against} {source}"
        raise BadInput("compare", "SCENE", str(against), expected)
    if isinstance(against, Reference):
        if not against.is_closed_form:  # beside a closed form they limit the proof in its place
            of_proofs = {"forecast": limits.forecast, "max_seconds": limits.max_seconds}
            _refuse_given(of_proofs, "none beside a certified reference, which has its own")
        return against
    return reference(against, **limits._asdict())


def _table(
    source: Any,
    scene: Scene,
    number: str | NumberType | None,
    digits: int | None,
    at: Iterable[AnyNumber] | None,
    columns: Sequence[str] | None,
) -> TrajectoryTable:
    """What is judged, as a table; raises BadInput."""
    is_table = isinstance(source, (str, Path)) or hasattr(source, "keys")
    if isinstance(source, Trajectory):
        its_own = {"number": number, "digits": digits, "at": at, "columns": columns}
        _refuse_given(its_own, "none beside a run, which has its own")
        return of_run(source)
    if is_table:
        _refuse_given({"at": at}, "none beside a table, which has its times in a column")
    if digits is not None and number is None:
        raise BadInput(scene.name, "digits", digits, "number given with it: mp")
    kind = None if number is None else choose_number(scene, number, digits)
    if isinstance(source, (str, Path)):
        return read_table(Path(source), kind, _naming(columns))
    if hasattr(source, "keys"):
        return table_of_columns(source, kind, names=_naming(columns, of_file=False))
    if isinstance(source, TrajectoryTable):
        return source
    return table_of_rows(source, at, scene.columns if columns is None else columns, kind)


def _refuse_given(options: Mapping[str, object], expected: str) -> None:
    """Raise BadInput for the first option that was given: nothing would come of it."""
    for option, value in options.items():
        if value is not None:
            raise BadInput("compare", option, value, expected)


def _naming(columns: Sequence[str] | None, of_file: bool = True) -> Naming:
    """What columns are called, where that was told; of a file it may be all of them."""
    if columns is None:
        return PLAIN
    names = naming(",".join(each("compare", "columns", columns, str, "a list of names")))
    if names.header and not of_file:
        expected = "NAME=COLUMN of each, for these columns have names"
        raise BadInput("compare", "columns", ",".join(names.header), expected)
    return names


# --- demands --------------------------------------------------------------------------------------
#
# What a table must have where digits are demanded of it: whole vectors, a number in each cell.


def refuse_incomplete(judged: Score) -> None:
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


def _refuse_parts(judged: Score, table: TrajectoryTable) -> None:
    columns = judged.reference.scene.columns
    for vector in (columns[:3], columns[3:], ATTITUDE if columns[3:] else ()):
        missing = [name for name in vector if name not in table.columns]
        if 0 < len(missing) < len(vector):
            there = ", ".join(name for name in vector if name in table.columns)
            expected = f"it beside {there}"
            if table.ignored:
                expected += f" (columns that are not known: {', '.join(table.ignored)})"
            raise BadInput(table.name, ", ".join(missing), None, expected)


def _refuse_gaps(judged: Score, table: TrajectoryTable) -> None:
    if judged.missing:
        name = min(judged.missing, key=lambda name: judged.missing[name][0])
        row = judged.missing[name][0]
        place = f"{name} in row {row + 1}, t = {brief(table.times[row])}"
        expected = "a number in each cell that is judged (it is empty or not a number)"
        raise BadInput(table.name, place, None, expected)

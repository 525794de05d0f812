"""What a table must have where digits are demanded of it: whole vectors, a number in each cell."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Never

from polhode.common.arguments import each, of_kind, refuse_unknown
from polhode.common.errors import BadInput
from polhode.common.interrupts import Progress
from polhode.judging.certified import Certified
from polhode.judging.conditioning import Conditioning
from polhode.judging.diagnosis.conventions import view
from polhode.judging.diagnosis.readings import as_meant, read_as_told, with_unit_quaternions
from polhode.judging.diagnosis.ways import clock_remark
from polhode.judging.judgement import Judgement
from polhode.judging.reference import AnyReference, Reference, reference
from polhode.judging.score import does_not_answer
from polhode.judging.tables.column_aliases import PLAIN, Naming, naming
from polhode.judging.tables.csv_file import table_of_columns, table_of_rows
from polhode.judging.tables.table import LENGTH, Reading, Table, as_judged, of_run
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


# --- compare --------------------------------------------------------------------------------------
#
# Anything judged: a run, somebody's file, columns, an array of states.


def compare(
    what: Trajectory
    | Table
    | str
    | Path
    | Iterable[AnyVector]
    | Mapping[str, AnyVector]
    | pd.DataFrame
    | xr.Dataset,
    against: AnyReference | Scene | str | Path | None = None,
    *,
    number: str | NumberType | None = None,
    digits: int | None = None,
    at: Iterable[AnyNumber] | None = None,
    columns: Sequence[str] | None = None,
    known: Conditioning | Judgement | None = None,
    progress: Progress | None = None,
    as_it_stands: bool = False,
    read: str | None = None,
    max_seconds: float | None = None,
    forecast: Callable[[float], None] | None = None,
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
        arrays (single, double or long double), are recognised.
    digits : int, optional
        The digits of the type, if ``number`` is mp.
    at : iterable of numbers, optional
        The times of rows, in the scene's unit.
    columns : sequence of str, optional
        Of rows, by default those of the scene.  Of a file without a header, or with another, its
        columns in order; or what single names of its header, or of a mapping or frame, mean:
        ``["time_ms=t*1e-3", "Q.W=q0"]``.
    known : Conditioning or Judgement, optional
        The scene's conditioning, or a judgement by the same reference at the same times, to spare
        what they hold.
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
        A limit on proofs, if there is no closed form.
    forecast : callable, optional
        Called before each proof with a rough estimate of its seconds.
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
    >>> found = polhode.compare(rows, scene, at=[1], number="double")
    >>> 15.4 < found.worst <= 16, found.limit
    (True, 'rounding')
    >>> rows[0][0] += 1e-6  # in p, where the largest |omega| is that at t = 1
    >>> 6 < polhode.compare(rows, scene, at=[1]).worst < 7
    True
    """
    gate = "no threshold: polhode.testing.assert_digits(run, scene, at_least) has one"
    refuse_unknown("compare", compare, unknown, at_least=gate)
    of_kind("compare", "as_it_stands", as_it_stands, bool, "True or False")
    if against is None:
        if not isinstance(what, Trajectory):
            raise BadInput("compare", "against", None, "a reference, or a scene")
        against = what.scene
    kinds = (Reference, Certified, Scene, str, Path)
    of_kind("compare", "against", against, kinds, "a reference, or a scene")
    proof = partial(Certified, progress=progress, max_seconds=max_seconds, forecast=forecast)
    if isinstance(against, (str, Path)) and Path(against).suffix.lower() in ENDINGS:
        expected = (
            "a scene, a case's name or a .toml file: a table is judged by a motion, and not by "
            f"another table (polhode compare {against} SCENE judges that one)"
        )
        if isinstance(what, (str, Path)) and Path(what).suffix.lower() == ".toml":
            expected = f"the scene after the table: polhode compare {against} {what}"
        raise BadInput("compare", "SCENE", str(against), expected)
    if isinstance(against, (Scene, str, Path)):
        against = reference(against)
        if isinstance(against, Certified):
            against = proof(against.scene)
    scene = against.scene
    if isinstance(what, Trajectory):
        subject = of_run(what)
    else:
        if digits is not None and number is None:
            raise BadInput(scene.name, "digits", digits, "number given with it: mp")
        kind = None if number is None else choose_number(scene, number, digits)
        if isinstance(what, (str, Path)):
            what = read_table(Path(what), kind, _naming(columns))
        elif hasattr(what, "keys"):
            what = table_of_columns(what, kind, names=_naming(columns, of_file=False))
        elif not isinstance(what, Table):
            named = scene.columns if columns is None else columns
            what = table_of_rows(what, at, named, kind)
        if what.run is not None and (read or not _is_of(what.run.scene, scene)):
            what = replace(what, run=None)  # another's table, as it were
        subject = as_judged(what, scene)
    if not subject.columns:
        expected = f"columns of {', '.join(against.scene.columns)}, angles or attitude"
        raise BadInput(subject.name, "header", None, expected)
    given = subject
    offered: tuple[Reading, ...] = ()
    reads = not as_it_stands and read is None and subject.run is None
    if read is not None and subject.run is None:
        if LENGTH in read:
            subject = with_unit_quaternions(subject, view(subject, against))
        subject = read_as_told(subject, against, read)
    elif reads:
        subject, offered = as_meant(given, against)
    found = Judgement(
        subject,
        against,
        progress,
        answers=known.known_answers if isinstance(known, Judgement) else None,
        known=known.known if isinstance(known, Judgement) else known,
        offered=offered,
    )
    try:
        _ = found.digits  # what cannot be judged is refused here
    except BadInput as refused:
        if not does_not_answer(against, refused):
            if refused.key == "at":  # a proof of too many steps
                expected = "; ".join([refused.expected, *clock_remark(subject, scene)])
                raise BadInput(refused.source, "t", refused.value, expected) from None
            raise
        proven = proof(scene)
        if reads:
            subject, offered = as_meant(given, proven)
        found = replace(found, subject=subject, reference=proven, offered=offered)
        _ = found.digits
    return found


def _is_of(one: Scene, other: Scene) -> bool:
    """Whether two scenes have the same motion, in the same units."""
    keys = ("units", "body", "omega", "gamma")
    return all(getattr(one, key) == getattr(other, key) for key in keys)


def _naming(columns: Sequence[str] | None, of_file: bool = True) -> Naming:
    """What columns are called, where that was told; of a file it may be all of them."""
    if columns is None:
        return PLAIN
    names = naming(",".join(each("compare", "columns", columns, str, "a list of names")))
    if names.header and not of_file:
        expected = "NAME=COLUMN of each, for these columns have names"
        raise BadInput("compare", "columns", ",".join(names.header), expected)
    return names

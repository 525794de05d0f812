"""The rows of a table that are judged: all, or some of very many whose reference is dear.

A row of such a closed form takes milliseconds.  Of more than :data:`MOST_DEAR` rows so many are
judged, evenly spread, the first and the last among them; and the one that is farthest from a run in
extended precision, which takes microseconds a row.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from polhode.common.text_tables import few
from polhode.judging.diagnosis.motion_in_double import integrated
from polhode.judging.references.reference import AnyReference, Reference
from polhode.judging.score.report_text import SHOWN
from polhode.judging.tables.candidate import Subject
from polhode.numbers.conversion import exactly, to_double
from polhode.numbers.number_types import EXTENDED
from polhode.numbers.rows import Doubles, Given
from polhode.scenes.scene import Scene

MOST_DEAR = 5000  # rows of a dear closed form that are asked for


class RowSelection(NamedTuple):
    """Rows of a table, in order; whether the one farthest from a run could be told."""

    rows: tuple[int, ...]
    has_farthest: bool

    def note(self, count: int) -> str:
        """What of ``count`` rows was not judged, and why."""
        chosen = f"{len(self.rows)} evenly spread ones"
        if self.has_farthest:
            chosen += ", with the one that is farthest from a run in extended precision"
        left = count - len(self.rows)
        return f"{left} of {count} rows, for each takes milliseconds; judged were {chosen}"


def selection(subject: Subject, reference: AnyReference) -> RowSelection | None:
    """The rows that are judged; None for all of them."""
    count = len(subject.times)
    if count <= MOST_DEAR or not (isinstance(reference, Reference) and reference.is_dear):
        return None
    rows = {*few(count, MOST_DEAR), *few(count, SHOWN)}
    farthest = _farthest(subject, reference.scene)
    if farthest is not None:
        rows.add(farthest)
    return RowSelection(tuple(sorted(rows)), farthest is not None)


def _farthest(subject: Subject, scene: Scene) -> int | None:
    """The row whose numbers are farthest from a run; None where there is none."""
    turning = subject.attitude is not None or subject.angles is not None
    run = integrated(scene, subject.times, turning, EXTENDED)
    if run is None:
        return None
    away = [np.zeros(len(subject.times))]
    if subject.columns:
        scale = np.ones(len(scene.columns))
        scale[:3] = np.max(np.linalg.norm(run.states[:, :3], axis=1)) or 1.0
        away.append(_largest((_doubles(subject.states) - run.states) / scale))
    if run.attitude is not None and subject.attitude is not None:
        own = _doubles(subject.attitude)
        away.append(np.fmin(*(_largest(side * own - run.attitude) for side in (1, -1))))
    if run.attitude is not None and subject.angles is not None:
        turns = np.exp(1j * (_doubles(subject.angles) - _angles(run.attitude)))
        away.append(_largest(np.angle(turns)))
    return int(np.argmax(np.fmax.reduce(away)))


def _angles(attitude: Doubles) -> Doubles:
    """psi, theta and phi of quaternions, up to whole turns."""
    q0, q1, q2, q3 = attitude.T
    one, other = np.arctan2(q3, q0), np.arctan2(q2, q1)
    theta = 2 * np.arctan2(np.hypot(q1, q2), np.hypot(q0, q3))
    return np.stack([one + other, theta, one - other], axis=1)


def _largest(differences: Doubles) -> Doubles:
    """The largest of each row of those that are there; 0 where none is."""
    found: Doubles = np.fmax.reduce(np.abs(differences), axis=1, initial=0.0)
    return found


def _doubles(rows: Given) -> Doubles:
    """Rows as doubles, not numbers where a cell is not there."""
    if isinstance(rows, np.ndarray) and rows.dtype.kind == "f":
        return rows.astype(np.float64)
    return np.array([[np.nan if x is None else to_double(exactly(x)) for x in row] for row in rows])

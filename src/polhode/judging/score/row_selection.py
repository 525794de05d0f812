"""The rows of a table that are judged: all, or some of very many whose reference is dear.

A row of such a closed form takes up to milliseconds.  Of more than :data:`MOST_DEAR` rows so many
are judged, evenly spread, the first and the last among them; and the one that is farthest from a
run in extended precision, which takes microseconds a row.  How far is told up to the quaternion's
sign and whole turns of psi and phi, which a table may have its own way; so a row that has them
otherwise than the judged ones on both sides of it is judged, too.
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from polhode.common.text_tables import few
from polhode.equations.kinematics import principal_angles
from polhode.judging.diagnosis.motion_in_double import integrated
from polhode.judging.references.reference import AnyReference
from polhode.judging.score.report_text import SHOWN
from polhode.judging.tables.table import Table
from polhode.numbers.conversion import doubles
from polhode.numbers.number_types import EXTENDED
from polhode.numbers.rows import Doubles
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import ANGLES, ATTITUDE

Indices: TypeAlias = npt.NDArray[np.int64]

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
        return f"{left} of {count} rows, for their closed form is dear; judged were {chosen}"


def selection(subject: Table, reference: AnyReference) -> RowSelection | None:
    """The rows that are judged; None for all of them."""
    count = len(subject.times)
    if count <= MOST_DEAR or not reference.is_dear:
        return None
    rows = {*few(count, MOST_DEAR), *few(count, SHOWN)}
    far = _far(subject, reference.scene, np.array(sorted(rows)))
    return RowSelection(tuple(sorted({*rows, *far})), bool(far))


def _far(subject: Table, scene: Scene, spread: Indices) -> tuple[int, ...]:
    """The row whose numbers are farthest from a run, and strays; none where there is no run."""
    states, attitude, angles = map(subject.rows, (scene.columns, ATTITUDE, ANGLES))
    run = integrated(scene, subject.times, bool(attitude or angles), EXTENDED)
    if run is None:
        return ()
    away = [np.zeros(len(subject.times))]
    strays: list[int] = []
    if states is not None:
        scale = np.ones(len(scene.columns))
        scale[:3] = np.max(np.linalg.norm(run.states[:, :3], axis=1)) or 1.0
        away.append(_largest((doubles(states) - run.states) / scale))
    if run.attitude is not None and attitude is not None:
        own = doubles(attitude)
        away.append(np.fmin(*(_largest(side * own - run.attitude) for side in (1, -1))))
        strays += _stray(np.sign(np.sum(own * run.attitude, axis=1, keepdims=True)), spread)
    if run.attitude is not None and angles is not None:
        true = np.stack(principal_angles(run.attitude.T, np.arctan2, np.hypot), axis=1)
        beside = doubles(angles) - np.unwrap(true, axis=0)
        away.append(_largest(np.angle(np.exp(1j * beside))))
        strays += _stray(np.rint(beside / (2 * np.pi)), spread)
    return int(np.argmax(np.fmax.reduce(away))), *strays


def _stray(ways: Doubles, spread: Indices) -> list[int]:
    """The first row with a number that neither the spread row before nor the one after has."""
    rows = np.arange(len(ways))
    before = ways[spread[np.searchsorted(spread, rows, side="right") - 1]]
    after = ways[spread[np.searchsorted(spread, rows)]]
    alone = (np.abs(ways - before) > 0) & (np.abs(ways - after) > 0)  # nan is not above 0
    first: list[int] = np.flatnonzero(alone.any(axis=1))[:1].tolist()
    return first


def _largest(differences: Doubles) -> Doubles:
    """The largest of each row of those that are there; 0 where none is."""
    found: Doubles = np.fmax.reduce(np.abs(differences), axis=1, initial=0.0)
    return found

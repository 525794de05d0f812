"""The rows of a table that are judged: all, or some of very many whose reference is dear.

A row of such a closed form takes up to milliseconds.  Of more than :data:`MOST_DEAR` rows so many
are judged, evenly spread, the first and the last among them; and the one that is farthest from a
run in extended precision, which takes microseconds a row.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from polhode.common.errors import few
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
    far = _farthest(subject, reference.scene)
    return RowSelection(tuple(sorted({*rows, *far})), bool(far))


def _farthest(subject: Table, scene: Scene) -> tuple[int, ...]:
    """The row whose numbers are farthest from a run; none where there is no run.

    Of a quaternion up to its sign, of psi and phi up to whole turns.
    """
    states, attitude, angles = map(subject.rows, (scene.columns, ATTITUDE, ANGLES))
    run = integrated(scene, subject.times, bool(attitude or angles), EXTENDED)
    if run is None:
        return ()
    away = [np.zeros(len(subject.times))]
    if states is not None:
        scale = np.ones(len(scene.columns))
        scale[:3] = np.max(np.linalg.norm(run.states[:, :3], axis=1)) or 1.0
        away.append(_largest((doubles(states) - run.states) / scale))
    if run.attitude is not None and attitude is not None:
        own = doubles(attitude)
        away.append(np.fmin(*(_largest(side * own - run.attitude) for side in (1, -1))))
    if run.attitude is not None and angles is not None:
        true = np.stack(principal_angles(run.attitude.T, np.arctan2, np.hypot), axis=1)
        away.append(_largest(np.angle(np.exp(1j * (doubles(angles) - true)))))
    return (int(np.argmax(np.fmax.reduce(away))),)


def _largest(differences: Doubles) -> Doubles:
    """The largest of each row of those that are there; 0 where none is."""
    found: Doubles = np.fmax.reduce(np.abs(differences), axis=1, initial=0.0)
    return found

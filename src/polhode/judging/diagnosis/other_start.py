"""That a table begins with another state than the scene, and with which case's, in words."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from polhode.judging.diagnosis.rotation_matrices import matrices
from polhode.judging.tables.reading import WRONG
from polhode.judging.tables.table import Table
from polhode.numbers.conversion import exactly, to_double
from polhode.scenes import library
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import ATTITUDE, STATE

_ALIKE = 6.0  # digits of a start that is a case's
_SHOWN = 2  # cases


def other_start(subject: Table, scene: Scene) -> str:
    """That a table's row at t = 0 is not the scene's start; empty where it is, or there is none."""
    row = _start_of(subject)
    off = {name: digits for name, digits in _digits(row, scene).items() if digits < WRONG}
    if not off:
        return ""
    own = dict(zip(scene.columns, map(to_double, scene.start), strict=True))
    theirs = ", ".join(f"{name} = {row[name]:.6g}" for name in off)
    right = ", ".join(f"{name} = {own[name]:.6g}" for name in off)
    cases = (library.load(name) for name in library.names())
    alike = [case.name for case in cases if min(_digits(row, case).values()) >= _ALIKE]
    return f"at t = 0 it has {theirs}, where {scene.name} has {right}{_begin_so(alike)}"


def _begin_so(cases: list[str]) -> str:
    """Which cases begin as the table does, the hard ones last; nothing where none does."""
    if not cases:
        return ""
    shown = sorted(cases, key=lambda name: name.startswith("hard/"))[:_SHOWN]
    more = f" (and {len(cases) - _SHOWN} more)" * (len(cases) > _SHOWN)
    return f"; {' and '.join(shown)}{more} begin{'s' * (len(cases) == 1)} so"


def _start_of(subject: Table) -> Mapping[str, float]:
    """The numbers of the state at t = 0, as far as they are there; gamma also of a quaternion."""
    if 0 not in subject.times:
        return {}
    place = subject.times.index(0)
    cells = {
        name: subject.columns[name][place]
        for name in (*subject.state, *ATTITUDE)
        if name in subject.columns
    }
    row = {name: to_double(exactly(x)) for name, x in cells.items() if x is not None}
    if {*ATTITUDE} <= row.keys():
        (turned,) = matrices(np.array([[row[name] for name in ATTITUDE]]))
        row = dict(zip(STATE[3:], turned[2].tolist(), strict=True)) | row
    return {name: x for name, x in row.items() if name in STATE}


def _digits(row: Mapping[str, float], scene: Scene) -> Mapping[str, float]:
    """To how many digits each number is that of a scene's start; 0 where the scene has none."""
    start = dict(zip(scene.columns, map(to_double, scene.start), strict=True))
    size = math.hypot(*(start[name] for name in STATE[:3])) or 1.0
    off = {name: abs(x - start.get(name, math.inf)) for name, x in row.items()}
    for name in {*STATE[:3]} & off.keys():
        off[name] /= size
    return {name: -math.log10(x) if x else math.inf for name, x in off.items()}

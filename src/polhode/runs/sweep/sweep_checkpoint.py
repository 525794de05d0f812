"""What a sweep has done so far, in a folder: a killed sweep goes on from there.

``part-00000.npz`` and so on, see :mod:`polhode.common.checkpoint`, hold plain arrays: ``members``,
``states`` (members, times, columns; decimal strings above extended), ``outcomes``, ``steps``,
``reached``, ``errors`` (JSON).
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, TypeVar

from polhode.common.checkpoint import Checkpoint
from polhode.motion.outcomes import OUTCOMES, Outcome, code
from polhode.numbers.conversion import number_value
from polhode.numbers.decimals import strings
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Stack, flat

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

K = TypeVar("K", bound="np.generic")

EVERY = 1.0  # seconds between two parts: what a kill may lose


class Part(NamedTuple):
    """Some members of a sweep, finished; see :class:`polhode.runs.sweep.ensemble.Ensemble`."""

    members: npt.NDArray[np.int64]
    states: Stack
    outcomes: npt.NDArray[np.uint8]  # indices into polhode.motion.outcomes.OUTCOMES
    steps: npt.NDArray[np.int64]
    reached: Stack  # Fractions
    errors: dict[int, tuple[float | None, ...]]  # by member, of those that have any


class SweepCheckpoint(Checkpoint):
    """The parts of one sweep in ``folder``, which is made when there is something to keep.

    ``what``: all that decides the results.  Raises BadInput where the folder holds
    anything else, or another process works in it.
    """

    def __init__(self, folder: Path, what: bytes, number: NumberType) -> None:
        self.number = number
        self._last = time.monotonic()
        digest = hashlib.sha256(what).hexdigest()
        manifest = {"parts of": "polhode sweep", "sweep": digest}
        super().__init__(folder, manifest, ("parts", "sweep"))

    def done(self) -> Iterator[Part]:
        """What is there already.  A part that cannot be read is left out: it is made again."""
        import numpy as np

        for path in self.pieces():
            found = self.read(path)
            if found is None:
                continue
            members = np.asarray(found["members"], dtype=np.int64)
            told = zip(members.tolist(), found["errors"].tolist(), strict=True)
            yield Part(
                members,
                self._numbers(found["states"]),
                _looked_up(found["outcomes"], lambda text: code(Outcome(text)), np.uint8),
                np.asarray(found["steps"], dtype=np.int64),
                _looked_up(found["reached"], Fraction, np.object_),
                {k: tuple(json.loads(text)) for k, text in told if text != "null"},
            )

    @property
    def due(self) -> bool:
        """Whether it is time for a part again."""
        return time.monotonic() - self._last > EVERY

    def keep(self, part: Part) -> None:
        """Write one more part, whole; raises BadInput where that cannot be."""
        import numpy as np

        arrays = {
            "members": part.members,
            "states": self._plain(part.states),
            "outcomes": np.array([outcome.value for outcome in OUTCOMES])[part.outcomes],
            "steps": part.steps,
            "reached": np.array([str(t) for t in part.reached]),
            "errors": np.array([json.dumps(part.errors.get(k)) for k in part.members.tolist()]),
        }
        numbers = [int(path.stem.removeprefix("part-")) for path in self.pieces()]
        self.write(f"part-{max(numbers, default=-1) + 1:05d}.npz", arrays)
        self._last = time.monotonic()

    def _plain(self, states: Stack) -> npt.NDArray[np.generic]:
        """States as an array that needs no pickle."""
        import numpy as np

        if self.number.flat:
            return states
        rows = states.reshape(-1, states.shape[-1]).tolist()
        text = [
            strings([row], self.number)[0] if row[0] == row[0] else ["nan"] * len(row)
            for row in rows
        ]
        return np.array(text).reshape(states.shape)

    def _numbers(self, states: npt.NDArray[np.generic]) -> Stack:
        if self.number.flat:
            return flat(states)
        import numpy as np

        from polhode.numbers.mpmath_context import mpmath, ordinary

        found = np.full(states.shape, ordinary(mpmath.nan), dtype=object)
        for index in np.ndindex(states.shape):
            if states[index] != "nan":
                found[index] = number_value(Fraction(str(states[index])), self.number)
        return found


def _looked_up(
    texts: npt.NDArray[np.generic], read: Callable[[str], object], kind: type[K]
) -> npt.NDArray[K]:
    """An array of texts, of which there are few different ones, read."""
    import numpy as np

    different, which = np.unique(texts, return_inverse=True)
    known = np.empty(len(different), dtype=kind)
    for k, text in enumerate(different.tolist()):
        known[k] = read(text)
    return known[which]

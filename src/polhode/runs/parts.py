"""What a sweep has done so far, in a folder: a killed sweep goes on from there.

``manifest.json`` says which sweep the parts belong to, by a fingerprint of all that decides its
results; ``part-00000.npz`` and so on hold plain arrays: ``members``, ``states`` (members, times,
columns; decimal strings above extended), ``outcomes``, ``steps``, ``reached``, ``errors`` (JSON).
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import time
import zipfile
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from polhode.common.errors import BadInput
from polhode.common.files import make_folder, write_whole
from polhode.common.provenance import versions
from polhode.numbers.convert import number_value
from polhode.numbers.decimals import strings
from polhode.numbers.number_types import NumberType
from polhode.numbers.scalars import Rows
from polhode.taylor.outcomes import OUTCOMES, Outcome, code

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

MANIFEST = "manifest.json"
EVERY = 1.0  # seconds between two parts: what a kill may lose
_SAME = ("polhode", "heyoka", "numpy")  # packages whose versions must be the same, too


class Part(NamedTuple):
    """Some members of a sweep, finished; see :class:`polhode.runs.sweep.Ensemble`."""

    members: npt.NDArray[np.int64]
    states: Rows
    outcomes: npt.NDArray[np.uint8]  # indices into polhode.taylor.outcomes.OUTCOMES
    steps: npt.NDArray[np.int64]
    reached: Rows  # Fractions
    errors: dict[int, tuple[float | None, ...]]  # by member, of those that have any


class Parts:
    """The parts of one sweep in ``folder``, which is made when there is something to keep.

    ``what``: all that decides the results.  Raises BadInput where the folder holds
    anything else, or another process works in it.
    """

    def __init__(self, folder: Path, what: bytes, number: NumberType) -> None:
        self.folder, self.number = folder, number
        digest = hashlib.sha256(what).hexdigest()
        self._manifest = {
            "parts of": "polhode sweep",
            "sweep": digest,
            "versions": {name: versions()[name] for name in _SAME},
        }
        self._lock: Any = None
        self._last = time.monotonic()
        if folder.exists():
            self._check()
            self._hold()

    def done(self) -> Iterator[Part]:
        """What is there already.  A part that cannot be read is left out: it is made again."""
        import numpy as np

        for path in self._paths():
            try:
                with np.load(path, allow_pickle=False) as held:
                    found = {name: held[name] for name in Part._fields}
            except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
                path.unlink(missing_ok=True)
                continue
            members = found["members"]
            told = zip(members.tolist(), found["errors"].tolist(), strict=True)
            yield Part(
                members,
                self._numbers(found["states"]),
                _looked_up(found["outcomes"], lambda text: code(Outcome(text)), np.uint8),
                found["steps"],
                _looked_up(found["reached"], Fraction, object),
                {k: tuple(json.loads(text)) for k, text in told if text != "null"},
            )

    @property
    def due(self) -> bool:
        """Whether it is time for a part again."""
        return time.monotonic() - self._last > EVERY

    def keep(self, part: Part) -> None:
        """Write one more part, whole; raises BadInput where that cannot be."""
        try:
            self._write(part)
        except BadInput:
            if not self._paths():
                self.remove()
            raise
        self._last = time.monotonic()

    def _write(self, part: Part) -> None:
        import numpy as np

        if self._lock is None:
            make_folder(self.folder)
            write_whole({self.folder / MANIFEST: json.dumps(self._manifest, indent=1) + "\n"})
            self._hold()
        text = io.BytesIO()
        np.savez(
            text,
            members=part.members,
            states=self._plain(part.states),
            outcomes=np.array([outcome.value for outcome in OUTCOMES])[part.outcomes],
            steps=part.steps,
            reached=np.array([str(t) for t in part.reached]),
            errors=np.array([json.dumps(part.errors.get(k)) for k in part.members.tolist()]),
        )
        numbers = [int(path.stem.removeprefix("part-")) for path in self._paths()]
        name = f"part-{max(numbers, default=-1) + 1:05d}.npz"
        write_whole({self.folder / name: text.getvalue()})

    def release(self) -> None:
        """No more parts come from here."""
        if self._lock is not None:
            self._lock.close()
            self._lock = None

    def remove(self) -> None:
        """The whole result is written: the parts go, the manifest last."""
        self.release()
        unfinished = self.folder.glob(".*.npz.*")  # of a process that was killed
        for path in [*self._paths(), *unfinished, self.folder / MANIFEST]:
            path.unlink(missing_ok=True)
        with contextlib.suppress(OSError):  # somebody else's files, which stay
            self.folder.rmdir()

    def _paths(self) -> list[Path]:
        return sorted(self.folder.glob("part-[0-9]*.npz"))

    def _check(self) -> None:
        path = self.folder / MANIFEST
        try:
            found = json.loads(path.read_text())
        except (OSError, ValueError):
            if self.folder.is_dir() and not any(self.folder.iterdir()):
                return
            found = None
        if found != self._manifest:
            expected = "the parts of this very sweep; remove the folder to start afresh"
            raise BadInput(str(self.folder), "parts", None, expected)

    def _hold(self) -> None:
        """Let no other process work here; the system ends this with the process."""
        path = self.folder / MANIFEST
        if not path.exists():
            return
        self._lock = path.open("rb")
        try:
            import fcntl
        except ImportError:  # a system without such locks
            return
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise BadInput(str(self.folder), "parts", None, "no other sweep at work here") from None

    def _plain(self, states: Rows) -> Any:
        """States as an array that needs no pickle."""
        import numpy as np

        if self.number.flat:
            return states
        rows = states.reshape(-1, states.shape[-1])
        text = [
            strings([row], self.number)[0] if row[0] == row[0] else ["nan"] * len(row)
            for row in rows
        ]
        return np.array(text).reshape(states.shape)

    def _numbers(self, states: Any) -> Rows:
        if self.number.flat:
            return states
        import numpy as np

        from polhode.numbers.private import mpmath, ordinary

        found = np.full(states.shape, ordinary(mpmath.nan), dtype=object)
        for index in np.ndindex(states.shape):
            if states[index] != "nan":
                found[index] = number_value(Fraction(str(states[index])), self.number)
        return found


def _looked_up(texts: Any, read: Callable[[str], Any], kind: Any) -> Any:
    """An array of texts, of which there are few different ones, read."""
    import numpy as np

    different, which = np.unique(texts, return_inverse=True)
    known = np.empty(len(different), dtype=kind)
    for k, text in enumerate(different.tolist()):
        known[k] = read(text)
    return known[which]

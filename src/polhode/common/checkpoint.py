"""Finished work of one computation in a folder: what was killed goes on from there.

``manifest.json`` says which computation it is, by a fingerprint of all that decides the results.
Pieces beside it are whole NPZ files of plain arrays, each with a checksum of them, its name and
its manifest: one that is no longer what was written there is made again.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import time
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, Self, TypeAlias

from polhode.common.arguments import of_kind
from polhode.common.errors import UNREADABLE, BadInput
from polhode.common.files import is_stream, make_folder, npz, read_npz, write_whole
from polhode.common.provenance import versions

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

#: A piece's arrays by name.
JobArrays: TypeAlias = "dict[str, npt.NDArray[np.generic]]"

MANIFEST = "manifest.json"
_CHECKSUM = "checksum"  # of a piece, among its arrays
EVERY = 1.0  # seconds between two writings of finished jobs: what a kill may lose
_SAME = ("polhode", "heyoka", "numpy")  # packages whose versions must be the same, too


def beside(path: Path) -> Path | None:
    """The folder beside an output in which finished work is kept; None beside a stream."""
    return None if is_stream(path) else path.with_name(path.name + ".parts")


class JobCheckpoint:
    """The finished jobs of a command in ``folder``: ``job-00000.npz`` and so on, one's arrays each.

    ``verb``: of the command line.  ``key``: all that decides the results; arrays count by their
    bytes.  The folder is made when there is something to keep: jobs are written about once a
    second, and a command that ends sooner makes none.  Raises BadInput where the folder holds
    anything else, or another process works in it.
    """

    def __init__(self, folder: str | Path, verb: str, *key: object) -> None:
        import numpy as np

        of_kind("polhode", "parts", folder, (str, Path), "a folder")
        self.folder = Path(folder)
        parts = [x.tobytes() if isinstance(x, np.ndarray) else x for x in key]
        digest = hashlib.sha256(repr(parts).encode()).hexdigest()
        same = {name: versions()[name] for name in _SAME}
        self._manifest = {"jobs of": f"polhode {verb}", "key": digest, "versions": same}
        self._lock: BinaryIO | None = None
        self._waiting: dict[int, Mapping[str, npt.ArrayLike]] = {}
        self._last = time.monotonic()
        if self.folder.exists():
            self._check()
            self._hold()

    @classmethod
    def at(cls, folder: str | Path | None, verb: str, *key: object) -> Self | None:
        """That of a folder, if there is one."""
        return None if folder is None else cls(folder, verb, *key)

    def load(self, job: int) -> JobArrays | None:
        """A finished job's arrays; None where they are not there, or not as they were written."""
        path = self._path(job)
        try:
            piece = dict(read_npz(path))
        except FileNotFoundError:
            return None
        except (OSError, ValueError):
            piece = {}
        checksum = piece.pop(_CHECKSUM, None)
        if checksum is None or str(checksum) != self._checksum(path.name, piece):
            path.unlink(missing_ok=True)
            return None
        return piece

    def save(self, job: int, arrays: Mapping[str, npt.ArrayLike]) -> None:
        """Keep a finished job; it is written when it is time for that.

        Raises BadInput where that cannot be.
        """
        self._waiting[job] = arrays
        if time.monotonic() - self._last > EVERY:
            self.write_waiting()

    def write_waiting(self) -> None:
        """Write the jobs that are not written yet, each whole; raises BadInput."""
        for job in list(self._waiting):
            self._write(self._path(job).name, self._waiting[job])
            del self._waiting[job]
        self._last = time.monotonic()

    def _write(self, name: str, arrays: Mapping[str, npt.ArrayLike]) -> None:
        """One more piece, whole, or BadInput, and no empty folder where it is the first."""
        import numpy as np

        piece = {key: np.asarray(array) for key, array in arrays.items()}
        piece[_CHECKSUM] = np.array(self._checksum(name, piece))
        try:
            if self._lock is None:
                make_folder(self.folder)
                write_whole({self.folder / MANIFEST: json.dumps(self._manifest, indent=1) + "\n"})
                self._hold()
            write_whole({self.folder / name: npz(piece)})
        except BadInput:
            if not self.pieces():
                self.remove()
            self.release()
            raise

    def pieces(self) -> list[Path]:
        """The files there are, by name."""
        return sorted(self.folder.glob("[a-z]*-[0-9]*.npz"))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()

    def release(self) -> None:
        """No more pieces come from here."""
        if self._lock is not None:
            self._lock.close()
            self._lock = None

    def remove(self) -> None:
        """The whole result is written: the pieces go, the manifest last."""
        self.release()
        unfinished = self.folder.glob(".*.npz.*")  # of a process that was killed
        for path in [*self.pieces(), *unfinished, self.folder / MANIFEST]:
            path.unlink(missing_ok=True)
        with contextlib.suppress(OSError):  # somebody else's files, which stay
            self.folder.rmdir()

    def _checksum(self, name: str, arrays: JobArrays) -> str:
        """Of a piece by name: it is no other, of no other work, and its arrays are as written."""
        import numpy as np

        checksum = hashlib.sha256(json.dumps([name, self._manifest], sort_keys=True).encode())
        for key in sorted(arrays):
            array = arrays[key]
            checksum.update(f"{key} {array.dtype.str} {array.shape}".encode())
            checksum.update(np.ascontiguousarray(array).data)
        return checksum.hexdigest()

    def _check(self) -> None:
        try:
            manifest = json.loads((self.folder / MANIFEST).read_text(encoding="utf-8"))
        except (OSError, *UNREADABLE):
            if self.folder.is_dir() and not any(self.folder.iterdir()):
                return
            manifest = None
        if manifest != self._manifest:
            expected = "the jobs of the same command; remove the folder to start again"
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
            self.release()
            expected = "no other command running in this folder"
            raise BadInput(str(self.folder), "parts", None, expected) from None

    def _path(self, job: int) -> Path:
        return self.folder / f"job-{job:05d}.npz"

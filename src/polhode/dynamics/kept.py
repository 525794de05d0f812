"""Finished jobs of a long computation, in a folder: a rerun with the same key goes on from there.

``manifest.json`` holds the key, a fingerprint of all that decides the results; ``job-00000.npz``
and so on the arrays of one job each.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from polhode.common.errors import BadInput
from polhode.common.files import make_folder, write_whole
from polhode.common.provenance import versions

MANIFEST = "manifest.json"
_SAME = ("polhode", "heyoka", "numpy")  # packages whose versions must be the same, too


class Kept:
    """The jobs kept in ``folder``, which is made when there is something to keep.

    Raises BadInput where the folder holds anything else.
    """

    def __init__(self, folder: Path, what: str, key: str) -> None:
        self.folder = folder
        self._manifest = {
            "jobs of": f"polhode {what}",
            "key": hashlib.sha256(key.encode()).hexdigest(),
            "versions": {name: versions()[name] for name in _SAME},
        }
        if folder.exists():
            self._check()

    def load(self, job: int) -> dict[str, Any] | None:
        """A finished job's arrays; None where it is not there, or cannot be read."""
        import numpy as np

        path = self._path(job)
        try:
            with np.load(path, allow_pickle=False) as held:
                return {name: held[name] for name in held.files}
        except FileNotFoundError:
            return None
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
            path.unlink(missing_ok=True)
            return None

    def save(self, job: int, arrays: Mapping[str, Any]) -> None:
        """Keep a finished job, whole; raises BadInput where that cannot be."""
        import numpy as np

        if not (self.folder / MANIFEST).exists():
            make_folder(self.folder)
            write_whole({self.folder / MANIFEST: json.dumps(self._manifest, indent=1) + "\n"})
        held = io.BytesIO()
        np.savez(held, **arrays)
        write_whole({self._path(job): held.getvalue()})

    def remove(self) -> None:
        """The whole result is written: the jobs go, the manifest last."""
        for path in [*self.folder.glob("job-[0-9]*.npz"), self.folder / MANIFEST]:
            path.unlink(missing_ok=True)
        with contextlib.suppress(OSError):  # somebody else's files, which stay
            self.folder.rmdir()

    def _path(self, job: int) -> Path:
        return self.folder / f"job-{job:05d}.npz"

    def _check(self) -> None:
        try:
            found = json.loads((self.folder / MANIFEST).read_text())
        except (OSError, ValueError):
            if self.folder.is_dir() and not any(self.folder.iterdir()):
                return
            found = None
        if found != self._manifest:
            expected = "the jobs of this very command; remove the folder to start afresh"
            raise BadInput(str(self.folder), "parts", None, expected)

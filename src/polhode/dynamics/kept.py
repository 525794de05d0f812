"""Finished jobs of a long computation, in a folder: a rerun with the same key goes on from there.

``job-00000.npz`` and so on, see :mod:`polhode.common.checkpoint`, hold the arrays of one job each.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from polhode.common.checkpoint import KeptFolder


class Kept(KeptFolder):
    """The jobs kept in ``folder``.  ``what``: the verb.  ``key``: all that decides the results."""

    def __init__(self, folder: Path, what: str, key: str) -> None:
        digest = hashlib.sha256(key.encode()).hexdigest()
        super().__init__(folder, {"jobs of": f"polhode {what}", "key": digest}, ("jobs", "command"))

    def load(self, job: int) -> dict[str, Any] | None:
        """A finished job's arrays; None where it is not there, or cannot be read."""
        return self.read(self._path(job))

    def save(self, job: int, arrays: Mapping[str, Any]) -> None:
        """Keep a finished job, whole; raises BadInput where that cannot be."""
        self.write(self._path(job).name, arrays)

    def _path(self, job: int) -> Path:
        return self.folder / f"job-{job:05d}.npz"

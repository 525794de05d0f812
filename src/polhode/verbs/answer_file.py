"""The file of ``-o`` of a verb that draws what it found, or writes it as arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from polhode.common.files import check_writable, is_stdout, npz, write_whole
from polhode.figures import catalogue
from polhode.figures.canvas import canvas
from polhode.results.result import Storable
from polhode.verbs.terminal import refuse_two_on_stdout

ARRAYS = ".npz"


@dataclass(frozen=True)
class AnswerFile:
    """Where an answer is written; ``suffix`` says as what, of a stream too."""

    path: Path
    suffix: str

    @property
    def on_stdout(self) -> bool:
        """Whether nothing else may be printed there."""
        return is_stdout(self.path)

    @property
    def holds_arrays(self) -> bool:
        """Whether arrays are asked for, and no figure."""
        return self.suffix == ARRAYS

    def save(self, arrays: Mapping[str, Any]) -> None:
        """Write arrays, whole."""
        write_whole({self.path: npz(arrays)})

    def draw(self, found: Storable, of: str, what: str | None = None, **options: Any) -> None:
        """Write a figure of a result, whole; ``of``: whose it is."""
        write_whole({self.path: catalogue.drawn(found, self.suffix, of, what, **options)})


def answer_file(
    name: str | None, kinds: Sequence[str], inputs: Sequence[Path | None], json: bool
) -> AnswerFile | None:
    """The file that ``-o`` names, if it can be written; raises BadInput before any work is done.

    ``kinds``: suffixes, the first that of a stream.  ``inputs``: files that are read.  ``json``:
    whether the answer is printed as JSON besides.
    """
    if name is None:
        return None
    path = Path(name)
    check_writable(path, kinds, inputs)
    refuse_two_on_stdout(path, json)
    suffix = path.suffix.lower() if path.suffix.lower() in kinds else kinds[0]
    if suffix != ARRAYS:
        canvas.require()
    return AnswerFile(path, suffix)

"""Certificates are checked by their own checker before they are written."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias, TypeVar

from polhode.certificates import verify
from polhode.common.arguments import of_kind
from polhode.common.errors import UNREADABLE, BadInput
from polhode.common.files import check_writable, write_whole
from polhode.common.interrupts import Progress
from polhode.numbers.flint_context import ctx

#: The part of the time that guesses take; the check, which takes the rest, counts from 0 again.
MAKING = 0.2
#: JSON's objects.
Made: TypeAlias = dict[str, object]
Proved = TypeVar("Proved")

_MORE = (0, 48, 112, 192)  # bits, where those given are too few


def checked(
    name: str, made: Callable[[int, int], Made], bits: int, progress: Progress | None = None
) -> Made:
    """The first of several tries that its checker proves, each with more bits; raises BadInput.

    ``name``: of the scene; ``made``: a certificate with so many bits, and the number of the try,
    which shows the progress up to :data:`MAKING`.
    """
    fault = ""
    for n, more in enumerate(_MORE):
        found = made(bits + more, n)
        try:
            checking = part_of(progress, MAKING, 1.0)
            by_checker(verify.KINDS[str(found["kind"])], found, checking)
        except (verify.NotProved, verify.Damaged) as refused:
            fault = str(refused)
            if isinstance(refused, verify.Damaged):
                break
            continue
        return found
    raise BadInput(name, "certificate", fault, "a statement that its own checker proves")


def part_of(progress: Progress | None, begin: float, end: float) -> Progress | None:
    """What shows the progress of a part of the work, which is all from ``begin`` to ``end``."""
    if progress is None:
        return None
    return lambda fraction, steps: progress(begin + (end - begin) * fraction, steps)


def by_checker(function: Callable[..., Proved], *arguments: object) -> Proved:
    """What a function of the checker gives; raises its NotProved and Damaged."""
    with ctx.workprec(verify.COARSE):  # which the checker changes as it likes
        try:
            return function(*arguments)
        except (ZeroDivisionError, OverflowError):
            raise verify.NotProved("a number is too large, or too small") from None


def refuse_another(path: str | Path) -> None:
    """Raise BadInput where a file is there that is no certificate; an empty one is nothing."""
    of_kind("save", "path", path, (str, Path), "the path of a .json file")
    place = Path(path)
    if not os.path.isfile(place) or not place.stat().st_size:
        return
    try:
        there = json.loads(place.read_text(encoding="utf-8"))
    except (OSError, *UNREADABLE):
        there = None
    if not isinstance(there, dict) or there.get("kind") not in verify.KINDS:
        expected = "a new file, or a certificate's (there is another, perhaps that of a table)"
        raise BadInput(str(place), "file", None, expected)


def write(path: str | Path, text: str) -> None:
    """A certificate's file, whole or not at all; raises BadInput."""
    check_writable(Path(path), [".json"], [])
    refuse_another(path)
    write_whole({Path(path): text + "\n"})

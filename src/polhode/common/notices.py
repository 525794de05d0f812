"""What is said on stderr of input that was taken, beside the answer.

A *change*: input that rounding alone kept from being possible, made possible exactly; said once in
a process, and never in the way of a program whose warnings are errors.  A *doubt*: input that is
possible, and hardly meant; in Python a warning, of a verb a line.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

from polhode.common.text_tables import printable

_said: set[str] = set()
_of_verb = [False]


class DoubtfulInput(UserWarning):
    """Input that is possible, and hardly meant."""


@contextmanager
def of_verb() -> Iterator[None]:
    """While a verb runs: doubts are lines on stderr, and changes are said anew."""
    before = _of_verb[0]
    _of_verb[0] = True
    _said.clear()
    try:
        yield
    finally:
        _of_verb[0] = before


def change(source: str, text: str) -> None:
    """Say what was changed; ``text``: its amount in brackets, which makes it no other change."""
    kind = f"{source}: {text.partition(' (')[0]}"
    if kind not in _said:
        _said.add(kind)
        _print(f"{source}: {text}")


def doubt(source: str, text: str) -> None:
    """Say what is hardly meant."""
    if _of_verb[0]:
        _print(f"{source}: {text}")
    else:
        warnings.warn(f"{source}: {text}", DoubtfulInput, stacklevel=4)


def _print(line: str) -> None:
    try:
        print(printable(line), file=sys.stderr)
    except (OSError, ValueError):  # closed: nobody could be told
        return

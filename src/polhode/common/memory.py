"""What a computation will hold, told before it begins."""

from __future__ import annotations

from polhode.common.errors import BadInput

MOST_BYTES = 4 * 10**9


def refuse_too_much(
    source: str, key: str, value: object, count: int, size: int, words: str
) -> None:
    """Raise BadInput where ``count`` things of so many bytes, while they are made, are too much.

    ``words``: what they are, and what to do.
    """
    most = MOST_BYTES // size
    if count > most:
        raise BadInput(source, key, value, f"at most {most} {words}")

"""The processor seconds of a call: the least of several after one that warms up."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import NamedTuple, TypeVar

Answer = TypeVar("Answer")


class Timing(NamedTuple):
    """The least processor seconds, and of how many calls."""

    seconds: float
    calls: int


def timed(call: Callable[[], Answer], repeats: int, patience: float) -> tuple[Answer, Timing]:
    """What a call returns, and its seconds; one that takes more than the patience is made once."""
    answer, seconds = _once(call)
    if seconds > patience:
        return answer, Timing(seconds, 1)
    return answer, Timing(min(_once(call)[1] for _ in range(repeats)), repeats)


def _once(call: Callable[[], Answer]) -> tuple[Answer, float]:
    began = time.process_time()
    answer = call()
    return answer, time.process_time() - began

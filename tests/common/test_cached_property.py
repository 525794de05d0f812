"""A property computed once an instance, that holds no lock meanwhile."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import pytest

from polhode.common.cached_property import cached_property


@dataclass(frozen=True)
class Asked:
    """Counts how often a value is computed; threads meet while they compute it."""

    counted: list[int]
    met: threading.Barrier | None = None

    @cached_property
    def value(self) -> list[int]:
        """What it is."""
        self.counted.append(1)
        if self.met is not None:
            self.met.wait(60)
        return [7]

    @cached_property
    def faulty(self) -> int:
        self.counted.append(1)
        if len(self.counted) < 3:
            raise ZeroDivisionError
        return len(self.counted)


def test_it_is_computed_once_and_is_no_field():
    one, other = Asked([]), Asked([])
    assert one.value is one.value
    assert (one.counted, other.counted) == ([1], [])
    assert one.value is not other.value
    assert one == Asked([1])
    assert Asked.value.__doc__ == "What it is."


def test_what_raised_is_computed_again():
    asked = Asked([])
    for _ in range(2):
        with pytest.raises(ZeroDivisionError):
            _ = asked.faulty
    assert asked.faulty == asked.faulty == 3


def test_threads_compute_at_once_and_are_given_the_same():
    """With a lock the first would wait at the barrier for the others for ever."""
    asked = Asked([], threading.Barrier(4))
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda _: asked.value, range(4)))
    assert len(asked.counted) == 4
    assert all(x is found[0] is asked.value for x in found)

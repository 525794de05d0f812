"""A property computed once an instance, that holds no lock meanwhile."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import pytest

from polhode.common.values import cached_property


@dataclass(frozen=True)
class Counting:
    """Counts how often a value is computed; threads meet while they compute it."""

    counted: list[int]
    met: threading.Barrier | None = None

    @cached_property
    def value(self) -> list[int]:
        """What it is."""
        self.counted.append(1)
        if self.met is not None:
            self.met.wait(60)
        if len(self.counted) == 1:
            raise ZeroDivisionError
        return [7]


def test_it_is_computed_once_and_is_no_field_but_what_raised_again():
    counting = Counting([])
    with pytest.raises(ZeroDivisionError):
        _ = counting.value
    assert counting.value is counting.value
    assert counting.counted == [1, 1]
    assert counting.value is not Counting([1, 1]).value
    assert counting == Counting([1, 1])
    assert Counting.value.__doc__ == "What it is."


def test_threads_compute_at_once_and_are_given_the_same():
    """With a lock the first would wait at the barrier for the others for ever."""
    counting = Counting([1, 1], threading.Barrier(4))
    with ThreadPoolExecutor(4) as pool:
        values = list(pool.map(lambda _: counting.value, range(4)))
    assert len(counting.counted) == 6
    assert all(x is values[0] is counting.value for x in values)

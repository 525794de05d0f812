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
    one = Counting([])
    with pytest.raises(ZeroDivisionError):
        _ = one.value
    assert one.value is one.value
    assert one.counted == [1, 1]
    assert one.value is not Counting([1, 1]).value
    assert one == Counting([1, 1])
    assert Counting.value.__doc__ == "What it is."


def test_threads_compute_at_once_and_are_given_the_same():
    """With a lock the first would wait at the barrier for the others for ever."""
    one = Counting([1, 1], threading.Barrier(4))
    with ThreadPoolExecutor(4) as pool:
        values = list(pool.map(lambda _: one.value, range(4)))
    assert len(one.counted) == 6
    assert all(x is values[0] is one.value for x in values)

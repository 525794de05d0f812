"""Jobs shared by processes: results in order, dead workers, callers that go."""

import multiprocessing
import os
import time

import pytest

from polhode.runs.workers import in_order


def squared(k):
    return k * k


def deadly(k):
    """Ends any process but the first one."""
    if multiprocessing.parent_process() is not None:
        os._exit(1)
    return -k


def refused(k):
    if k == 1:
        raise ValueError(f"no {k}")
    return k


def long(k):
    if k:
        time.sleep(600)
    return k


@pytest.mark.parametrize("workers", [1, 2])
def test_results_come_in_the_order_of_the_jobs(workers):
    begun = []
    assert [*in_order(squared, range(5), workers, begun.append)] == [0, 1, 4, 9, 16]
    assert begun == [0, 1, 2, 3, 4]


def test_the_jobs_of_a_process_that_died_are_done_here():
    assert [*in_order(deadly, range(3), 2)] == [0, -1, -2]


@pytest.mark.parametrize("workers", [1, 2])
def test_a_fault_is_the_caller_s(workers):
    found = in_order(refused, range(3), workers)
    assert next(found) == 0
    with pytest.raises(ValueError, match="no 1"):
        next(found)


def test_where_the_caller_goes_the_processes_end():
    before = {*multiprocessing.active_children()}
    found = in_order(long, range(3), 2)
    assert next(found) == 0
    assert len({*multiprocessing.active_children()} - before) == 2
    begun = time.monotonic()
    found.close()
    assert time.monotonic() - begun < 60
    assert {*multiprocessing.active_children()} <= before

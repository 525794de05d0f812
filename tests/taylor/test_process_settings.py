"""Settings of the whole process are put back, whoever leaves last and however."""

from __future__ import annotations

from threading import Barrier, Thread

import pytest
from threadpoolctl import threadpool_info

from polhode.taylor.heyoka import one_blas_thread, one_thread


def threads():
    return [x["num_threads"] for x in threadpool_info() if x["user_api"] == "blas"]


@pytest.fixture
def before():
    """Two BLAS threads, whatever the machine or the environment."""
    from threadpoolctl import threadpool_limits

    with threadpool_limits(2, user_api="blas"):
        yield threads()


def test_blas_has_one_thread_inside_and_those_of_before_outside(before):
    with one_blas_thread():
        assert set(threads()) == {1}
        with one_blas_thread():
            pass
        assert set(threads()) == {1}
    assert threads() == before != [1] * len(before)
    with pytest.raises(KeyError), one_blas_thread():
        raise KeyError
    assert threads() == before


def test_the_last_of_two_threads_puts_it_back(before):
    inside, values = Barrier(2, timeout=30), []

    def work():
        with one_blas_thread():
            inside.wait()
        values.append(threads())

    workers = [Thread(target=work) for _ in range(2)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert values[-1] == before == threads()


def test_heyoka_has_one_thread_inside_and_those_of_before_outside():
    import heyoka

    before = heyoka.get_nthreads()
    heyoka.set_nthreads(3)
    try:
        with one_thread():
            assert heyoka.get_nthreads() == 1
        assert heyoka.get_nthreads() == 3
    finally:
        heyoka.set_nthreads(before)

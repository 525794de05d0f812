"""The suite of timings: its protocol, and its groups."""

from __future__ import annotations

import itertools

import pytest

from measure import benchmark
from measure.benchmark import GROUPS, main, side_by_side


class Clock:
    """A clock that jobs advance."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now

    def job(self, *seconds: float):
        taken = itertools.cycle(seconds)

        def work() -> None:
            self.now += next(taken)

        return work


@pytest.mark.parametrize("scale", [1e-5, 1.0])
def test_a_ratio_is_the_median_of_rounds_with_an_interval(scale):
    clock = Clock()
    jobs = [clock.job(scale), clock.job(*(scale * x for x in (3, 1, 2, 2, 2, 2, 2, 2, 9)))]
    first, second = side_by_side(jobs, 100 * scale, 1, clock)
    assert first == pytest.approx((scale, 1, 1, 1))
    assert (second.seconds, second.ratio) == pytest.approx((scale, 2))
    assert second.low == pytest.approx(2)
    assert second.high == pytest.approx(2)


def test_an_interval_holds_what_few_rounds_leave_open():
    clock = Clock()
    _, timing = side_by_side([clock.job(1), clock.job(5, 1, 2, 3, 4, 5)], 0, 1, clock)
    assert timing == pytest.approx((1, 3, 1, 5))


def test_a_short_job_is_called_often_between_two_looks():
    clock, calls = Clock(), []
    tick = clock.job(1e-4)
    timings = side_by_side([lambda: calls.append(tick()), clock.job(1)], 0, None, clock)
    assert len(calls) == 1 + 5 * 20
    assert timings[0].seconds == pytest.approx(1e-4)
    assert timings[1].ratio == pytest.approx(1e4)


@pytest.mark.parametrize("name", GROUPS)
def test_a_group_is_a_function_of_its_module(name):
    assert iter(benchmark.lines(name, 0.0))


def test_a_group_that_there_is_not_is_refused(capsys):
    assert main(["scenes", "speed"]) == 2
    assert "benchmark: speed: expected one of scenes, " in capsys.readouterr().err


@pytest.mark.slow
def test_scenes_are_measured(capsys):
    assert main(["scenes", "--seconds", "0"]) == 0
    assert "polhode.top, ms" in capsys.readouterr().out

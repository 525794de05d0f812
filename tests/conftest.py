"""What holds for every test: the caller's precision is none that polhode would choose."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator

import mpmath
import pytest
from hypothesis import HealthCheck, settings

# no example fails for a slow machine; CI draws the same ones each time, everybody else new ones
settings.register_profile(
    "polhode",
    deadline=None,
    derandomize="CI" in os.environ,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("polhode")


def pytest_configure() -> None:
    """Tests of Ctrl-C need the signal, which a job in the background is started without."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(autouse=True)
def callers_precision() -> Iterator[None]:
    """Plain mpmath at far more bits than any test asks for: what polhode gives is not rounded.

    Nothing in polhode may depend on it; see ``judging/test_threads.py`` for other precisions.
    """
    with mpmath.workprec(6000):
        yield


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """``sample(n)``: n cases of the test, evenly spread, are fast; the others are slow."""
    cases: dict[str, list[pytest.Item]] = {}
    for item in items:
        if item.get_closest_marker("sample") and not item.get_closest_marker("slow"):
            cases.setdefault(item.nodeid.partition("[")[0], []).append(item)
    for those in cases.values():
        count = those[0].get_closest_marker("sample").args[0]
        kept = {len(those) * k // count for k in range(count)}
        for k, item in enumerate(those):
            if k not in kept and len(those) > count:
                item.add_marker(pytest.mark.slow)

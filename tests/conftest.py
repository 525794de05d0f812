"""What holds for every test: the caller's precision is none that polhode would choose."""

from __future__ import annotations

from collections.abc import Iterator

import mpmath
import pytest


@pytest.fixture(autouse=True)
def callers_precision() -> Iterator[None]:
    """Plain mpmath at far more bits than any test asks for: what polhode gives is not rounded.

    Nothing in polhode may depend on it; see ``judging/test_threads.py`` for other precisions.
    """
    with mpmath.workprec(6000):
        yield

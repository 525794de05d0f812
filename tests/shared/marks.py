"""Which values of a parameter the fast suite takes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest


def fast(values: Iterable[Any], *kept: Any) -> list[Any]:
    """The values, all but those kept marked slow."""
    return [v if v in kept else pytest.param(v, marks=pytest.mark.slow) for v in values]

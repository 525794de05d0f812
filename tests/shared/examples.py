"""How many examples of a property are drawn where it says so itself."""

from __future__ import annotations

from hypothesis import settings

_CI = 100  # conftest's profile of CI


def examples(count: int) -> int:
    """So many in CI; elsewhere a quarter as many, as of those that say nothing."""
    return max(1, count * settings.default.max_examples // _CI)

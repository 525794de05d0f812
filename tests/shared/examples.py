"""How many examples of a property are drawn where it says so itself."""

from __future__ import annotations

from hypothesis import settings

_CI = 100  # of which CI draws a half


def examples(count: int) -> int:
    """A half of so many in CI; elsewhere a quarter, as of those that say nothing."""
    return max(1, count * settings.default.max_examples // _CI)

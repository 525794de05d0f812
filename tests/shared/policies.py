"""Runs by another policy than that of the table."""

from __future__ import annotations

import pytest

from polhode.taylor import defaults


def change_policy(monkeypatch: pytest.MonkeyPatch, **changes: int) -> None:
    """Change columns of the policy table, for every number type and the rest of a test."""
    for name, row in defaults.TABLE.items():
        monkeypatch.setitem(defaults.TABLE, name, row._replace(**changes))

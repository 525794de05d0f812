"""What tests of integrators share."""

from __future__ import annotations

import pytest

from polhode.taylor.backend.integrator_pool import Pool
from polhode.taylor.integrator import compiled


@pytest.fixture
def built(monkeypatch) -> list:
    """The integrators that are built from now on, none being idle."""
    monkeypatch.setattr(compiled, "POOL", Pool())
    made: list = []
    build = compiled.built

    def counted(*arguments):
        made.append(build(*arguments))
        return made[-1]

    monkeypatch.setattr(compiled, "built", counted)
    return made

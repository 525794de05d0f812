"""Rows that a reference keeps for several runs: those of it, in another process as well."""

from __future__ import annotations

import pickle
from typing import Any

import mpmath
import pytest

import polhode
from polhode.judging.references.reference import Remembered

CASES = ["euler/separatrix-irrational", "kovalevskaya/anchor", "bobylev-steklov/cn"]


def _sent(value: Any) -> Any:
    """As another process takes it up."""
    with mpmath.workprec(53):
        return pickle.loads(pickle.dumps(value))


@pytest.mark.parametrize("case", CASES)
def test_rows_keep_all_their_digits_on_the_way_to_another_process(case: str) -> None:
    kept = Remembered(polhode.reference(case))
    times = [kept.scene.end / 3]
    rows = kept.at(times, 60)
    sent = _sent(kept)
    assert [x._mpf_ for x in sent.at(times, 60)[0]] == [x._mpf_ for x in rows[0]]
    assert sent._kept.keys() == kept._kept.keys()  # nothing was asked for again
    assert sent.at(times, 70) != rows  # more digits than are kept are

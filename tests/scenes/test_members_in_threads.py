"""Members of one sweep that several threads ask for are each their own."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction

import pytest

import polhode
from polhode.scenes.members import Members
from polhode.scenes.vary import grid


@pytest.fixture
def quick_changes() -> Iterator[None]:
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(interval)


def test_threads_do_not_mix_members_up(quick_changes):
    scene = polhode.load("general/asymmetric-regular")
    members = Members(
        scene, grid({"start.omega[1]": "0:1:101", "body.weight": "1:2:3"}, scene.name)
    )
    alone = [members[k] for k in range(len(members))]
    assert {m.omega[0] for m in alone} == {Fraction(k, 100) for k in range(101)}
    with ThreadPoolExecutor(8) as pool:
        together = list(pool.map(members.__getitem__, range(len(members))))
    assert together == alone

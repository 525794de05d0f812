"""A family with one orbit is one file, its place and its word: a synthetic one."""

from __future__ import annotations

from fractions import Fraction

import pytest

import polhode
from polhode.closed_forms import families
from polhode.numbers.mpmath_context import mpmath
from polhode.scenes import scene_file
from shared import steady_precession

KIND = steady_precession.FAMILY.name
TIMES = [Fraction(0), Fraction(1, 3), Fraction(-7), Fraction(1000)]
TOP = """schema = 1
[body]
moments = [1, 1, 2]
centre = [0, 0, {up}]
weight = 4
[start]
omega = ["{along}", 0, "{spin}"]
gamma = ["3/5", 0, "{height}"]
[run]
end = 1
[reference]
kind = "{kind}"
"""
# n = 2: n (s + r) = T with r = 8/5 + s gives s = 1/5 and r = 9/5
STEADY = {"up": 1, "along": "6/5", "spin": "9/5", "height": "4/5"}
# the centre below: its normal axes are a reflection of these
MIRRORED = {"up": -1, "along": "-6/5", "spin": "9/5", "height": "-4/5"}


@pytest.fixture
def given(monkeypatch):
    """Its place among the families, and its word."""
    monkeypatch.setattr(families, "FAMILIES", (*families.FAMILIES, steady_precession.FAMILY))
    monkeypatch.setattr(scene_file, "REFERENCES", (*scene_file.REFERENCES, KIND))


def scene(path, kind, **start):
    (file := path / "steady.toml").write_text(TOP.format(kind=kind, **(STEADY | start)))
    return polhode.load(str(file))


@pytest.mark.parametrize("start", [STEADY, MIRRORED], ids=["own axes", "a reflection"])
def test_it_answers_as_the_family_that_knows_the_motion_too(given, tmp_path, start):
    mine = polhode.reference(scene(tmp_path, KIND, **start))
    known = polhode.reference(scene(tmp_path, "lagrange", **start))
    assert (mine.kind, mine.regime) == (KIND, steady_precession.REGIME)
    assert len(mine.conditions) == 8
    for question in ("at", "attitude", "angles"):
        rows, others = (getattr(x, question)(TIMES, 40) for x in (mine, known))
        with mpmath.workdps(50):
            for row, other in zip(rows, others, strict=True):
                for x, y in zip(row, other, strict=True):
                    assert abs(x - y) <= 2e-40 * max(1, abs(y)), question
    with mpmath.workdps(50):
        assert abs(mine.period - 10 * mpmath.pi) < 1e-45  # 2 pi over s = 1/5


def test_a_start_that_misses_is_refused_with_the_condition_and_by_how_much(given, tmp_path):
    with pytest.raises(polhode.BadInput, match=r"A n s \+ \(C - A\) n r = T, off by 0\.0\d+"):
        polhode.reference(scene(tmp_path, KIND, spin="19/10"))


def test_without_its_word_a_scene_cannot_ask_for_it(tmp_path):
    with pytest.raises(polhode.BadInput, match=r"reference\.kind"):
        scene(tmp_path, KIND)

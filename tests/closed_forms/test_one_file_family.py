"""A family from outside is one file: registered by a process, or by a package's entry point."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import mpmath
import pytest

import polhode
from polhode.scenes import vocabulary
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


@pytest.fixture
def own_family(monkeypatch):
    """Registered until the test ends."""
    monkeypatch.setattr(vocabulary, "_OF_PROCESS", {})
    polhode.register_family(steady_precession.FAMILY)
    polhode.register_family(steady_precession.FAMILY)  # the same again changes nothing


def scene(path, kind, **start):
    (file := path / "steady.toml").write_text(TOP.format(kind=kind, **(STEADY | start)))
    return polhode.load(str(file))


@pytest.mark.slow
def test_it_answers_as_the_family_that_knows_the_motion_too(own_family, tmp_path):
    mine = polhode.reference(scene(tmp_path, KIND))
    lagrange = polhode.reference(scene(tmp_path, "lagrange"))
    assert (mine.kind, mine.regime) == (KIND, steady_precession.REGIME)
    assert len(mine.conditions) == 8
    for question in ("at", "attitude", "angles"):
        rows, others = (getattr(x, question)(TIMES, 40) for x in (mine, lagrange))
        with mpmath.workdps(50):
            for row, right in zip(rows, others, strict=True):
                for x, y in zip(row, right, strict=True):
                    assert abs(x - y) <= 2e-40 * max(1, abs(y)), question
    with mpmath.workdps(50):
        assert abs(mine.period - 10 * mpmath.pi) < 1e-45  # 2 pi over s = 1/5


def test_a_start_that_misses_is_refused_with_the_condition_and_by_how_much(own_family, tmp_path):
    with pytest.raises(polhode.BadInput, match=r"A n s \+ \(C - A\) n r = T, off by 0\.0\d+"):
        polhode.reference(scene(tmp_path, KIND, spin="19/10"))


def test_without_its_word_a_scene_cannot_ask_for_it(tmp_path):
    with pytest.raises(polhode.BadInput, match=r"reference\.kind"):
        scene(tmp_path, KIND)


def test_names_that_are_taken_and_what_is_no_family_are_refused(own_family):
    named_euler, rival = (replace(steady_precession.FAMILY, name=name) for name in ("euler", KIND))
    for family, word in ((named_euler, "euler"), (rival, KIND), ("a word", "a Family")):
        with pytest.raises(polhode.BadInput, match=word):
            polhode.register_family(family)


@pytest.mark.slow
def test_a_package_gives_its_family_to_the_command_line(tmp_path):
    shared = Path(steady_precession.__file__).read_text(encoding="utf-8")
    (tmp_path / "my_tops.py").write_text(shared, encoding="utf-8")
    (about := tmp_path / "my_tops-1.dist-info").mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: my-tops\nVersion: 1\n")
    points = "[polhode.families]\n{} = {}\n"
    (about / "entry_points.txt").write_text(points.format(KIND, "my_tops:FAMILY"))
    (file := tmp_path / "steady.toml").write_text(TOP.format(kind=KIND, **STEADY))

    def command(*words):
        path = os.pathsep.join([str(tmp_path), *filter(None, [os.environ.get("PYTHONPATH")])])
        return subprocess.run(
            [sys.executable, "-m", "polhode", *words],
            capture_output=True,
            text=True,
            check=False,
            env={**os.environ, "PYTHONPATH": path},
        )

    process = command("reference", str(file), "--at", "1", "--digits", "30")
    note = "steady.toml: the digits are reproduced, not proven\n"
    assert (process.returncode, process.stderr) == (0, note)
    assert "0.588039946704744978674517910048" in process.stdout
    (about / "entry_points.txt").write_text(points.format(KIND, "my_tops:NOTHING"))
    process = command("reference", str(file), "--at", "1", "--digits", "30")
    assert (process.returncode, process.stderr.count("\n")) == (2, 1)
    assert "my_tops:NOTHING" in process.stderr

"""A program that drifts is told its convention by its first rows; a wrong file is told none."""

from __future__ import annotations

import re
from collections import Counter

import numpy as np
import pytest

import polhode
from polhode.common.errors import BadInput
from polhode.scenes.vocabulary import ATTITUDE, STATE
from shared import drifting_files as files

PARTS = {"omega": STATE[:3], "gamma": STATE[3:], "attitude": ATTITUDE}
STARTS_RIGHT = 3.0  # digits of the first rows of an exact program


def scene_of(file):
    top = file.top
    return polhode.top(
        inertia=[[str(x) for x in row] for row in top.inertia],
        centre=[str(x) for x in top.centre],
        weight=str(top.weight),
        omega=[str(x) for x in top.omega],
        quaternion=[float(x) for x in file.turn],
        normalise=True,
        outputs=["attitude"],
    )


def judged(file):
    return polhode.compare(file.columns, scene_of(file))


def is_named(file, found):
    told = {one.part: one.convention for one in found.readings}
    return all(words in told.get(part, "") for part, words in file.words.items())


def plainly(convention):
    """A convention without the numbers of a rotation."""
    return re.sub(r"rotation of .* in", "rotation in", convention)


def right_digits(file, part):
    """Digits of a program that drifts, by one that does not, in the first rows: of vectors by
    components, of attitudes by elements of R."""
    theirs, exact = (
        np.array([one[name][: files.EXACT_ROWS] for name in PARTS[part]]).T
        for one in (file.columns, file.exact)
    )
    if part == "attitude":
        order = [3, 0, 1, 2] if file.words[part] == "scalar-last" else [0, 1, 2, 3]
        theirs, exact = (files.matrix(q[:, order]).reshape(-1, 9) for q in (theirs, exact))
    size = np.linalg.norm(exact, axis=1).max() if part == "omega" else 1
    with np.errstate(divide="ignore"):
        return -np.log10(np.abs(theirs - exact).max(axis=1) / size)


def is_wrong(file, reading):
    """Whether a program that does not drift is not right in a reading."""
    scene = scene_of(file)
    if any(words in reading.convention for words in file.words.values()):
        return False
    if reading.change is None:
        exact = polhode.compare(file.exact, scene).readings
        told = {(one.part, plainly(one.convention)) for one in exact}
        return (reading.part, plainly(reading.convention)) not in told
    try:
        exact = polhode.compare(file.exact, scene, read=f"{reading.part} {reading.convention}")
    except BadInput:
        return True
    return min(exact.part_digits[reading.part]) < STARTS_RIGHT


@pytest.mark.sample(0, slow=2)
@pytest.mark.parametrize("name", files.NAMES)
def test_a_drifting_file_is_told_its_convention(name):
    """The digits of its first row and of later ones, in the convention that is named."""
    file = files.plain_file(name)
    found = judged(file)
    assert found.worst < 3
    assert is_named(file, found), found.readings
    for part in file.words:
        (reading,) = [one for one in found.readings if one.part == part]
        first, *_, last = reading.rows
        assert 12 > first[1] > 2 > last[1] or first[1] > 12 > 3 > last[1]
        assert f"{last[1]:.1f} at t = 4" in str(reading)
        for t, digits in reading.rows[1:-1]:
            known = right_digits(file, part)[list(file.columns["t"]).index(float(t))]
            assert digits == pytest.approx(known, abs=0.4)
        exact = "turned" not in name  # where the first row tells the rotation
        assert ("exact at t = 0, " in str(reading)) == exact


@pytest.mark.sample(0, slow=1)
@pytest.mark.parametrize(("moments", "spin"), [([4, 4, "1.5"], 94), ([1, "1.1", "0.4"], -60)])
def test_a_fast_top_is_told_the_unit_of_omega(moments, spin):
    """Its spin is hardly moved, so that what comes after the first row says little of the axes."""
    given = {"centre": [0, 0, 1], "weight": 20, "angles": [0, "25°", 0], "rates": [0, 0, spin]}
    top = polhode.top(moments=moments, **given)
    f, h = polhode.field(top), 2e-4
    states = [np.array(f.start)]
    for _ in range(1500):
        states.append(states[-1] + h * np.array(f(0, states[-1])))
    rows = np.array(states[::50])
    for unit, word in ((180 / np.pi, "degrees"), (30 / np.pi, "rpm")):
        table = {"t": np.arange(31) / 100, **dict(zip("pqr", unit * rows[:, :3].T, strict=True))}
        (reading,) = polhode.compare(table, top).readings
        assert reading.convention == word
        assert reading.rows[0][1] > 12 > 4 > reading.rows[-1][1]
    table["r"] = table["r"] * 1.3  # a factor that is no unit
    assert polhode.compare(table, top).readings == ()


@pytest.mark.campaign
def test_drifting_files_are_named_right():
    """At least 95 in a hundred are named, and none wrongly."""
    count = 300
    missed, wrong = Counter(), []
    for seed in range(count):
        name = files.NAMES[seed % len(files.NAMES)]
        file = files.of_convention(seed, name)
        found = judged(file)
        missed[name] += not is_named(file, found)
        wrong += [(seed, name, str(one)) for one in found.readings if is_wrong(file, one)]
    assert wrong == []
    assert missed.total() <= 0.05 * count, +missed


@pytest.mark.sample(0, slow=3)
@pytest.mark.parametrize("seed", range(60))
@pytest.mark.parametrize("name", files.WRONG)
def test_wrong_files_are_told_no_convention(name, seed):
    assert judged(files.wrong_file(seed, name)).readings == ()

"""Two conventions at once are read or recognised, and a wrong file has none by chance."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

import polhode
from polhode.judging.diagnosis.conventions import readings
from polhode.judging.references.reference import reference
from polhode.judging.tables.candidate import of_table
from polhode.judging.tables.table import table_of_columns
from polhode.scenes.vocabulary import ATTITUDE, STATE

CASES = ("lagrange/nutation", "euler/turned-axes", "lagrange/looping")
PARTS = {"omega", "gamma", "attitude"}
TIMES = [k / 16 for k in range(33)]


def columns_of(run, name):
    rows = run.attitude if name in ATTITUDE else run.states
    place = ATTITUDE.index(name) if name in ATTITUDE else STATE.index(name)
    return np.array([float(row[place]) for row in rows])


@pytest.fixture(scope="module")
def files():
    """Columns of runs in double, one of each case."""
    found = {}
    for name in CASES:
        scene = replace(polhode.load(name).at(TIMES), outputs=("attitude",))
        run = polhode.integrate(scene)
        names = (*STATE, *ATTITUDE)
        columns = {"t": np.array([float(t) for t in run.t])}
        found[name] = columns | {n: columns_of(run, n) for n in names}
    return found


def vector(columns, names, matrix):
    new = matrix @ np.array([columns[n] for n in names])
    return columns | dict(zip(names, new, strict=True))


def quaternion_times(columns, left=None, right=None):
    def product(a, b):
        return np.array(
            [
                a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
                a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
                a[0] * b[2] + a[2] * b[0] + a[3] * b[1] - a[1] * b[3],
                a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1],
            ]
        )

    held = np.array([columns[n] for n in ATTITUDE])
    held = held if left is None else product(left, held)
    held = held if right is None else product(held, right)
    return columns | dict(zip(ATTITUDE, held, strict=True))


HALF = math.sqrt(0.5)
FRD = np.diag([1.0, -1.0, -1.0])


def flipped_body(columns):
    turned = vector(vector(columns, STATE[:3], FRD), STATE[3:], FRD)
    return quaternion_times(turned, right=[0.0, 1.0, 0.0, 0.0])


def degrees(columns):
    return columns | {n: np.degrees(columns[n]) for n in STATE[:3]}


def exchanged(columns):
    return columns | {"p": columns["q"], "q": columns["p"]}


def scalar_last(columns):
    return columns | dict(
        zip(ATTITUDE, [columns[n] for n in ("q1", "q2", "q3", "q0")], strict=True)
    )


def late(columns):
    moved = {n: c[:-1] for n, c in columns.items() if n != "t"}
    return {"t": columns["t"][1:]} | moved


#: Distortions by the words that a reading of them has.
DISTORTIONS = {
    "y up": lambda c: quaternion_times(c, left=[HALF, -HALF, 0.0, 0.0]),
    "z down": lambda c: quaternion_times(c, left=[0.0, 1.0, 0.0, 0.0]),
    "body x y z = x -y -z": flipped_body,
    "degrees": degrees,
    "p q r = q p r": exchanged,
    "scalar-last": scalar_last,
    "body from space": lambda c: c | {n: -c[n] for n in ATTITUDE[1:]},
    "the downward vertical": lambda c: c | {n: -c[n] for n in STATE[3:]},
    "one step of t late": late,
}


def judged(columns, case):
    scene = polhode.load(case).at([1])
    subject = of_table(table_of_columns(columns, None), replace(scene, outputs=("attitude",)))
    return readings(subject, reference(scene), PARTS)


def shortfall(found):
    return [one for one in found if one.digits < 9]


@pytest.mark.parametrize("case", CASES)
def test_each_distortion_is_read(files, case):
    for word, distorted in DISTORTIONS.items():
        found = judged(distorted(files[case]), case)
        assert found, (case, word)
        assert any(word in one.convention for one in found), (case, word, found)
        assert not shortfall(found), (case, word, found)


@pytest.mark.slow
def test_pairs_of_distortions_are_read(files):
    """Nine of ten at least; what is read is read with all its digits."""
    read, all_pairs = 0, 0
    for first, second in itertools.combinations(sorted(DISTORTIONS), 2):
        columns = DISTORTIONS[second](DISTORTIONS[first](files["lagrange/nutation"]))
        found = judged(columns, "lagrange/nutation")
        assert not shortfall(found), (first, second, found)
        all_pairs += 1
        read += bool(found)
    print(f"{read} of {all_pairs} pairs read")
    assert read >= 0.9 * all_pairs, (read, all_pairs)


def wrong_files(files, cases, kinds):
    """Noise, and motions that depart."""
    random = np.random.default_rng(20)
    for case, kind in itertools.product(cases, range(kinds)):
        columns = dict(files[case])
        count = len(columns["t"])
        for name in (*STATE, *ATTITUDE):
            if kind % 2:
                columns[name] = random.normal(size=count)
            else:
                columns[name] = columns[name] + 0.03 * random.normal(size=count).cumsum()
        yield case, columns


@pytest.mark.parametrize(
    ("cases", "kinds"), [(CASES[:1], 2), pytest.param(CASES, 20, marks=pytest.mark.slow)]
)
def test_a_wrong_file_has_no_reading_by_chance(files, cases, kinds):
    assert [judged(columns, case) for case, columns in wrong_files(files, cases, kinds)] == [
        [] for _ in range(len(cases) * kinds)
    ]


@pytest.mark.slow
def test_another_motion_is_no_reading(files):
    for mine, case in itertools.permutations(CASES, 2):
        assert judged(files[mine], case) == [], (mine, case)


@pytest.mark.parametrize("words", [("y up",), ("z down", "degrees"), ("body x y z = x -y -z",)])
def test_what_is_read_is_applied(files, words):
    columns, case = files[CASES[0]], CASES[0]
    for word in words:
        columns = DISTORTIONS[word](columns)
    found = polhode.compare(columns, case)
    assert found.worst > 13, found
    assert all(word in found.reading for word in words)
    assert found.limit == "rounding"
    assert polhode.compare(columns, case, as_it_stands=True).worst < 1


def test_times_from_another_beginning_are_applied(files):
    columns = files[CASES[0]]
    found = polhode.compare(columns | {"t": columns["t"] + 100.0}, CASES[0])
    assert found.worst > 13
    assert found.reading == "t from its first row on (100)"


def test_a_weight_of_the_other_sign_is_told_and_not_applied():
    scene = polhode.load("lagrange/looping").at(TIMES)
    other = replace(scene, body=replace(scene.body, weight=-scene.body.weight))
    run = polhode.integrate(other)
    columns = {"t": run.t, **{n: run.states[:, k] for k, n in enumerate(STATE)}}
    found = polhode.compare(columns, scene)
    assert found.worst < 1
    assert {one.convention for one in found.readings} == {"a weight of the other sign"}
    assert found.reading is None

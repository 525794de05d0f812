"""Hodographs of omega in body and space: shape, digits, the rolling condition, classic facts."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import mpmath
import numpy as np
import pytest

import polhode
from polhode.cli import main
from shared.closed_forms import number as number_at
from shared.members import rotation
from shared.tools import DOUBLE, EXTENDED, QUAD, exactly, mp, tiers

SPACE = ("omega_x", "omega_y", "omega_z")


def scene_of(name, outputs=("hodographs",), step=Fraction(1, 200), count=60, **changes):
    scene = polhode.load(name)
    times = tuple(step * k for k in range(count))
    return replace(scene, outputs=tuple(outputs), times=times, events=(), **changes)


# -- the space vector ---------------------------------------------------------------------------


@pytest.mark.parametrize("number", [DOUBLE, EXTENDED, QUAD, mp(50)], ids=lambda n: n.name)
def test_a_vector_is_turned_exactly_and_rounded_once(number):
    """Of a run's own numbers: half an ulp of the largest component; the body's are the state's."""
    run = polhode.integrate(scene_of("kovalevskaya/generic", step=Fraction(1, 3), count=12), number)
    body, space = run.hodographs
    assert [*map(list, body)] == [list(row[:3]) for row in run.states]
    assert not number.flat or space.dtype == run.states.dtype
    for q, v, row in zip(run.attitude, body, space, strict=True):
        turn, vector = rotation(*map(exactly, q)), [exactly(x) for x in v]
        exact = [sum(x * y for x, y in zip(line, vector, strict=True)) for line in turn]
        largest = max(abs(x) for x in exact)
        for component, true in zip(row, exact, strict=True):
            assert abs(exactly(component) - true) <= largest * number.eps * Fraction(51, 100)


@pytest.mark.parametrize("number", tiers(["double", "quad"], ["extended", "mp"]))
def test_a_runs_hodographs_are_those_of_the_closed_form(number):
    scene = scene_of("lagrange/nutation", step=Fraction(1, 2), count=9)
    run = polhode.integrate(scene, number)
    curves = polhode.reference(scene).hodographs(run.times, 60)
    worst = 0
    with mpmath.workprec(220):
        for mine, true in zip(run.hodographs, curves, strict=True):
            for row, exact in zip(mine, true, strict=True):
                for x, y in zip(row, exact, strict=True):
                    worst = max(worst, abs(number_at(exactly(x)) - y) / 5)
    eps = float(run.number.eps)
    assert eps / 20 < worst < 60 * eps
    assert curves.body == [row[:3] for row in polhode.reference(scene).at(run.times, 60)]


# -- rolling ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("number", "name"),
    tiers(
        [
            ("double", "euler/largest-axis"),
            ("extended", "lagrange/turned-axes"),
            ("quad", "kovalevskaya/generic"),
        ],
        [
            ("extended", "euler/largest-axis"),
            ("quad", "lagrange/turned-axes"),
            ("mp", "kovalevskaya/generic"),
        ],
    ),
)
def test_the_hodographs_roll_on_each_other(name, number):
    """Common tangent and equal arcs, to what rounding leaves of differences over 1/200."""
    run = polhode.integrate(scene_of(name), number)
    cones, eps = polhode.rolling(run), float(run.number.eps)
    floor = 1e-45 if number == "mp" else 0.0  # what the differences leave
    assert eps < cones.tangent < 3000 * eps + floor
    assert 0 <= cones.arc < 30 * eps + floor


@pytest.mark.slow
def test_a_curve_that_slips_is_seen():
    """Ahead about the vertical by a millionth; arcs go by the time between samples, not its date.

    The second curve runs ahead more and more, seen now and a hundred units of time later.
    """

    def ahead(run, angle):
        (a, b, c, d), half = run.attitude.T, angle / 2
        quaternions = np.array([a - half * d, b - half * c, c + half * b, d + half * a]).T
        return replace(run, attitude=quaternions)

    run = polhode.integrate(scene_of("kovalevskaya/generic"))
    t = np.array([float(x) for x in run.times])
    assert 1e-7 < polhode.rolling(ahead(run, 1e-6 * t)).tangent < 1e-5
    assert polhode.rolling(run).tangent < 1e-11
    early = ahead(run, 1e-3 * t**2)
    late = replace(early, times=tuple(x + 100 for x in run.times))
    now, then = polhode.rolling(early), polhode.rolling(late)
    assert 1e-7 < now.arc < 1e-2
    assert then == pytest.approx(now, rel=1e-12)


# -- what is printed, and what is refused -------------------------------------------------------


@pytest.mark.parametrize("verb", ["run", "reference"])
def test_json_shows_hodographs_of_one_length_and_a_table_of_them_is_not_judged(
    verb, tmp_path, monkeypatch, capsys
):
    """A run's file holds the attitude, too, from which its hodographs are made again."""
    monkeypatch.chdir(tmp_path)
    words = [verb, "kovalevskaya/generic", "--at", "1,2", "--outputs", "hodographs"]
    assert main([*words, "--json"]) == 0
    columns = json.loads(capsys.readouterr().out)["columns"]
    assert ("psi" in columns, "q0" in columns) == (False, verb == "run")
    for names in zip(*(columns[name] for name in ("p", "q", "r", *SPACE)), strict=True):
        row = [Fraction(x) ** 2 for x in names]
        assert sum(row[:3]) == pytest.approx(sum(row[3:]), rel=1e-14)
    Path("x.csv").write_text("t,p,omega_x,omega_y,omega_z\n1,0.1,0.1,0.2,0.3\n")
    assert main(["compare", "x.csv", "kovalevskaya/generic"]) == 0
    assert "columns omega_x omega_y omega_z were not judged" in capsys.readouterr().out


@pytest.mark.parametrize(("count", "outputs"), [(5, ("hodographs",)), (60, ("attitude",))])
def test_the_rolling_condition_needs_hodographs_and_samples(count, outputs):
    run = polhode.integrate(scene_of("kovalevskaya/generic", outputs, count=count))
    with pytest.raises(ValueError, match="25 times"):
        polhode.rolling(run)


def test_hodographs_need_a_vertical():
    with pytest.raises(polhode.BadInput, match=r"start\.gamma"):
        replace(polhode.load("euler/no-gamma"), outputs=("hodographs",))

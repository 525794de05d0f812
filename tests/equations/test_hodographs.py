"""Hodographs of omega in body and space: shape, digits, the rolling condition, classic facts."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import polhode
from polhode.cli import main
from polhode.equations.columns import derived
from polhode.numbers import number_types
from polhode.numbers.conversion import to_extended, to_mpf
from shared.closed_forms import number as number_at
from shared.tools import DOUBLE, EXTENDED, QUAD, exactly, examples, mp, tiers

SPACE = ("omega_x", "omega_y", "omega_z")
COMPONENT = st.floats(-10, 10, allow_subnormal=False)


def scene_of(name, outputs=("hodographs",), step=Fraction(1, 200), count=60, **changes):
    scene = polhode.load(name)
    times = tuple(step * k for k in range(count))
    return replace(scene, outputs=tuple(outputs), times=times, events=(), **changes)


def exact_rotation(q, v):
    """R(q) v by the matrix of the quaternion, in fractions."""
    a, b, c, d = q
    square = a * a + b * b + c * c + d * d
    matrix = (
        (a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)),
        (2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)),
        (2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d),
    )
    return [sum(x * y for x, y in zip(row, v, strict=True)) / square for row in matrix]


# -- the space vector ---------------------------------------------------------------------------


@settings(max_examples=examples(60), deadline=None)
@given(
    st.tuples(*[COMPONENT] * 4).filter(lambda q: max(map(abs, q)) > 1e-3),
    st.tuples(*[COMPONENT] * 3),
    st.sampled_from([DOUBLE, EXTENDED, QUAD, mp(50)]),
)
def test_a_vector_is_turned_exactly_and_rounded_once(q, v, number):
    """Against fractions: half an ulp of the largest component, whatever the quaternion's length."""
    state = (*v, 0.0, 0.0, 1.0)
    if number.name == "double":
        rows = np.array([q]), np.array([state])
    elif number.name == "extended":
        rows = tuple(np.array([[to_extended(exactly(x)) for x in r]]) for r in (q, state))
    else:
        rows = tuple([[to_mpf(exactly(x), number.bits) for x in r]] for r in (q, state))
    exact = exact_rotation([exactly(x) for x in q], [exactly(x) for x in v])
    largest = max(abs(x) for x in exact)
    (row,) = derived("hodographs", polhode.load("euler/sphere"), rows[::-1], number)
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


def test_the_body_hodograph_is_the_states_own_numbers(monkeypatch):
    """And the space one is the same where long double is no wider than double."""
    run = polhode.integrate(scene_of("kovalevskaya/generic", count=5))
    body, space = run.hodographs
    assert np.array_equal(body, run.states[:, :3])
    assert space.dtype == np.float64
    wide = polhode.integrate(scene_of("kovalevskaya/generic", count=2), "extended")
    assert wide.hodographs.space.dtype == np.longdouble
    monkeypatch.setattr(number_types, "extended_here", lambda: False)
    parts = run.states, run.attitude
    assert np.array_equal(derived("hodographs", run.scene, parts, run.number), space)


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

"""Levels, sections, maps and frequencies in units of any size; their results as values."""

import pickle
from fractions import Fraction

import mpmath
import numpy as np
import pytest

import polhode
from shared.tools import tiers

BIG = Fraction(2) ** 500
UNITS = [(BIG, 1), (1 / BIG, 1), (1, BIG), (1, 1 / BIG), (1 / BIG, BIG)]  # of inertia, of rates


def scene(inertia=1, rate=1):
    """A body of moments 1, 2, 5/2 in other units: every number of its motion is scaled exactly."""
    size, rate = Fraction(inertia), Fraction(rate)
    return polhode.top(
        moments=[size, 2 * size, size * 5 / 2],
        centre=[size * rate**2 / 2, 0, size * rate**2],
        weight=1,
        omega=[rate, rate, 0],
        gamma=[0, "3/5", "4/5"],
        end=1 / rate,
    )


@pytest.mark.parametrize(("inertia", "rate"), [(BIG, 1), (1, BIG)])
def test_a_section_is_to_the_bit_that_in_other_units(inertia, rate):
    options = {"grid": (2, 2), "crossings": 2, "accuracy": False}
    plain = polhode.section(scene(), **options)
    cut = polhode.section(scene(inertia, rate), **options)
    assert len(plain.counts) > 1
    for name in ("l", "L_over_G", "counts", "starts"):
        assert np.array_equal(getattr(cut, name), getattr(plain, name))
    assert np.array_equal(cut.times * float(rate), plain.times)


@pytest.mark.parametrize(("inertia", "rate"), tiers([(BIG, 1)], [UNITS[1], UNITS[3]]))
def test_a_map_and_frequencies_are_those_in_other_units(inertia, rate):
    plain, chart = (
        polhode.chaos_map(top, (2, 2), end=20 / Fraction(by))
        for top, by in ((scene(), 1), (scene(inertia, rate), rate))
    )
    assert np.array_equal(chart.fli, plain.fli)
    lines = polhode.frequencies(scene(), of=["gamma3"], end=50, lines=2).lines["gamma3"]
    second = polhode.frequencies(
        scene(inertia, rate), of=["gamma3"], end=50 / Fraction(rate), lines=2
    )
    for first, again in zip(lines, second.lines["gamma3"], strict=True):
        assert again.frequency == first.frequency * float(rate)


@pytest.mark.parametrize(("inertia", "rate"), tiers([UNITS[1], UNITS[3]], [(BIG, 1)]))
def test_levels_are_those_in_other_units(inertia, rate):
    plain, diagram = polhode.levels(scene()), polhode.levels(scene(inertia, rate))
    assert [mark.kind for mark in diagram.marks] == [mark.kind for mark in plain.marks]
    assert diagram.here.region == plain.here.region
    unit = np.array([float(Fraction(inertia) * Fraction(rate) ** k) for k in (1, 2)])
    for curve, second in zip(diagram.curves, plain.curves, strict=True):
        assert len(curve.points) > 200
        np.testing.assert_allclose(curve.points / unit, second.points, rtol=1e-14, atol=1e-14)


def test_a_gamma_that_the_level_forbids_is_told_the_least_energy_in_the_scenes_units():
    top = scene(1 / BIG, BIG)
    with pytest.raises(polhode.BadInput, match="h is at least") as caught:
        polhode.section(top, by="height", starts=[[0, 0, 1, 1]], h=BIG * Fraction(-9, 10), f=0)
    least = float(str(caught.value).split("at least ")[1].split()[0])
    assert least == pytest.approx(float(BIG), rel=1e-11)


@pytest.mark.parametrize("by", [Fraction(1, 3), Fraction(1, 10), Fraction(10) ** -46])
def test_a_branch_is_a_branch_whatever_the_denominators(by):
    """s = A and s = B of a body whose centre of mass lies on its third axis."""
    top = polhode.top(
        moments=[by, 2 * by, by * 5 / 2],
        centre=[0, 0, by],
        weight=1,
        omega=[1, 1, 0],
        gamma=[0, "3/5", "4/5"],
        end=1,
    )
    diagram = polhode.levels(top)
    assert [(mark.kind, mark.family) for mark in diagram.marks] == [
        ("branch", "first"),
        ("branch", "first"),
        ("cusp", "second"),
    ]
    assert [float(mark.parameter / by) for mark in diagram.marks[:2]] == [1.0, 2.0]


@pytest.mark.slow
def test_results_are_values():
    """Equal to themselves when read again, every digit of mpmath numbers included."""
    top = scene()
    results = [
        polhode.levels(top),
        polhode.section(top, grid=(2, 1), crossings=2),
        polhode.chaos_map(top, (1, 2), end=10),
        polhode.frequencies(top, of=["gamma3"], end=50, lines=1),
        polhode.orbit("grioli/precession", digits=20),
        polhode.orbit_family("grioli/precession", "h", "0.85"),
    ]
    for result in results:
        with mpmath.workprec(53):  # what a process begins with
            again = pickle.loads(pickle.dumps(result))
        assert again == result
        assert all(again != second for second in results if second is not result)
    assert results[0].marks[-1].f._mpf_[3] > 100  # bits
    assert repr(polhode.field(top)) == "<field of top: f(t, y)>"


@pytest.mark.parametrize(("by", "far"), [("momentum", 33), ("q", -33)])
def test_a_level_far_from_the_scenes_own_is_cut_in_its_own_unit_of_time(by, far):
    """Without weight every level is the same in other units: h 2**66 times as high, or as low.

    Half a unit of the scene's start was taken for a step: all was within rounding of zero there.
    """
    free = polhode.top(moments=[4, 3, 2], omega=[1, 1, 0], gamma=[0, "3/5", "4/5"], end=1)
    rate = Fraction(2) ** far
    plain, cut = (
        polhode.section(*(free, by, None, None, (2, 2), 3, 2 * x * x, 0), workers=1, accuracy=False)
        for x in (1, rate)
    )
    assert plain.complete
    for name in ("l", "L_over_G", "starts", "outcomes"):
        assert np.array_equal(getattr(cut, name), getattr(plain, name))
    assert np.array_equal(cut.times * float(rate), plain.times)
    assert np.array_equal(cut.states[..., :3] / float(rate), plain.states[..., :3])

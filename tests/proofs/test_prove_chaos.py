"""Proved chaos: what is claimed holds, what is false is refused, each condition is needed."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from flint import arb

import polhode
from polhode.cli import main
from polhode.enclosures.fixed_point_problem import Refused
from polhode.numbers.flint_context import ctx
from polhode.proofs.chaos import chain_candidate, h_set, homoclinic, theorem, transit
from polhode.proofs.chaos.h_set import HSet
from polhode.proofs.chaos.prove_chaos import balls_on
from polhode.proofs.chaos.theorem import Chain
from polhode.proofs.level import largest
from shared import chaos_chains as chains
from shared import orbit_proofs as proofs

BITS = chains.NOISE + 128
CORNERS = [(a, b) for a in (-1.0, 0.3, 1.0) for b in (-1.0, -0.4, 1.0)]


def point_of(what, xi, eta):
    """A point of a set in double, the four equations solved by Newton's method."""
    chart = what.chart
    c = np.ldexp(np.array([float(x) for x in chart.centre]), -chart.fine)
    y = np.array([what.middle + xi * what.width, eta * what.height])
    x = c + chart.wide @ y
    n = np.zeros(4)
    known = proofs.level().balls(200)
    with ctx.workprec(200):
        exact = [arb(v) for v in (chart.wide @ y).tolist()]
        base = [p + d for p, d in zip(chart.point, exact, strict=True)]
        for _ in range(4):
            deep = h_set.matrix(chart.deep) * h_set.column([arb(v) for v in n.tolist()])
            at = h_set.shifted(base, deep)
            miss = [float(a - b) for a, b in zip(known.integrals(at), known.values, strict=True)]
            off = h_set.column([p - q for p, q in zip(at, chart.point, strict=True)])
            miss.append(float((chart.row * off)[0, 0]))
            left = h_set.equations(known, chart, at) * h_set.matrix(chart.deep)
            slope = np.array([float(v) for v in left.entries()]).reshape(4, 4)
            n = n - np.linalg.solve(slope, miss)
        x = np.array([float(v) for v in at])
    return x, n


def crossed(chart, x, ticks):
    """Where a motion meets the plane of a chart, in its coordinates, in double."""
    lanes = chains.example().lanes
    c = np.ldexp(np.array([float(v) for v in chart.centre]), -chart.fine)
    time = math.ldexp(ticks, -14)
    for _ in range(5):
        end = lanes.after(x[:, None], np.array([time]))
        rate = chart.plane @ lanes.field(end)[:, 0]
        time -= float(chart.plane @ (end[:, 0] - c) / rate)
    frame = np.hstack([chart.wide, chart.deep])
    return np.linalg.solve(frame, end[:, 0] - c), time


@pytest.mark.slow
def test_directions_keep_their_sign_whatever_linear_algebra_chooses(monkeypatch):
    made, orbit = np.linalg.eig, chains.example().orbit
    point = np.array([float(x.mid()) for x in orbit.start])
    period = float(orbit.period.mid())
    found = []
    for sign in (1.0, -1.0):
        monkeypatch.setattr(np.linalg, "eig", lambda a, s=sign: (made(a)[0], s * made(a)[1]))
        found.append(homoclinic.saddle(chains.example().lanes, point, period))
    for name in ("unstable", "stable"):
        one, other = (getattr(x, name) for x in found)
        assert np.array_equal(one, other)
        assert np.max(one) == 1.0 == np.max(np.abs(one))


def test_the_example_is_proved_with_the_entropy_of_its_times():
    found = chains.example().proof
    assert len(found.margins) == 19
    assert min(x.stretch for x in found.margins) > 1.4
    assert max(x.height for x in found.margins) < 0.8
    assert min(x.cone for x in found.margins) > 0.4
    short, long = (float(x) for x in (found.short, found.long))
    assert 4.26575 < short < 4.26577
    assert 77.69 < long < 77.71
    total = math.exp(-found.entropy * short) + math.exp(-found.entropy * long)
    assert total + 1e-12 >= 1.0
    assert total < 1.0 + 1e-6
    assert abs(found.entropy - 0.028076) < 1e-5


def tilted(late):
    """A set whose directions leave the level, and its image, in time or 2e-3 after it."""
    what = chains.example()
    chart = what.charts[0]
    chart = replace(chart, wide=chart.wide + 0.1 * chart.deep[:, :2])
    ticks = what.ticks[0] + late
    source = HSet(chart, 0.0, 1e-6, 1e-6)
    return transited(source, ticks), ticks


def transited(source, ticks, noise=chains.NOISE):
    """The image of a set at the first chart's plane."""
    chart = chains.example().charts[0]
    return transit.transit(proofs.level(), source, chart, ticks, noise, chain_candidate.follow)


@pytest.mark.parametrize("k", [0, 1, 9, 17, "tilted", "tilted and late"])
def test_points_of_a_set_are_where_its_image_says(k):
    """At corners and between; the slope holds the differences of the section map."""
    what = chains.example()
    if isinstance(k, int):
        image, ticks = what.chain.images[k], what.ticks[k]
    else:
        image, ticks = tilted(32 if k.endswith("late") else 0)
    source = image.source
    with ctx.workprec(BITS):
        disk = h_set.disk(proofs.level().balls(BITS), source)
    nearest, places = math.inf, {}
    for xi, eta in CORNERS:
        x, n = point_of(source, xi, eta)
        assert all(
            abs(a - float(b.mid())) <= 1.001 * float(b.rad()) + 1e-17
            for a, b in zip(n, disk.depth, strict=True)
        )
        where, time = crossed(image.chart, x, ticks)
        places[xi, eta] = where
        assert float(image.least) < time < float(image.most)
        for i in range(6):
            terms = image.turn.tolist()[i]
            middle = image.shift[i, 0] + terms[0] * xi + terms[1] * eta
            off = abs(where[i] - float(middle.mid()))
            room = sum(float(v.abs_upper()) for v in terms[2:]) + float(middle.rad())
            assert off <= room + 2e-14  # the doubles' own error
            nearest = min(nearest, room)
    if isinstance(k, int):
        assert nearest < 1e-8  # and the image is sharp
    begin = places[-1.0, -1.0]
    for j, (corner, size) in enumerate([((1.0, -1.0), source.width), ((-1.0, 1.0), source.height)]):
        for i in range(2):
            off = abs((places[corner][i] - begin[i]) / (2 * size) - float(image.slope[i, j].mid()))
            assert off <= float(image.slope[i, j].rad()) + 1e-13 / size


def test_the_derivative_holds_at_every_time_of_the_crossing(monkeypatch):
    what, kept = chains.example(), []
    honest = transit.derivative

    def seen(known, watch, reached, span):
        kept.append((span, honest(known, watch, reached, span)))
        return kept[-1][1]

    monkeypatch.setattr(transit, "derivative", seen)
    ticks = what.ticks[0] + 32
    transited(what.chain.home, ticks)
    ((span, balls),) = kept
    point = what.saddle.point[:, None]
    for sign in (-1, 0, 1):
        time = np.array([math.ldexp(ticks, -14) + sign * float(span)])
        truth = what.lanes.derivative(point, time)[0]
        for i in range(6):
            for j in range(6):
                off = abs(truth[i, j] - float(balls[i, j].mid()))
                assert off <= float(balls[i, j].rad()) + 1e-7


def test_a_plane_that_may_be_missed_or_was_met_at_the_start_is_refused(monkeypatch):
    what = chains.example()
    for ticks, why in ((0, "not positive"), (1, "positive")):
        with pytest.raises(Refused, match=why):
            transited(what.chain.home, ticks, 80)
    monkeypatch.setattr(transit, "_SPARE", 0.5)
    with pytest.raises(Refused, match="miss"):
        transited(what.chain.home, what.ticks[0], 80)


def moved(charts, k, by):
    """The charts with one centre moved along its first direction."""
    off = [round(x * 2 ** charts[k].fine) for x in (charts[k].wide[:, 0] * by).tolist()]
    centre = tuple(a + b for a, b in zip(charts[k].centre, off, strict=True))
    return [replace(c, centre=centre) if i == k else c for i, c in enumerate(charts)]


def attempt(charts=None, ticks=None, first=None):
    what = chains.example()
    chain = chains.made(
        charts or what.charts, ticks or what.ticks, what.size, first or what.found.unstable
    )
    return theorem.horseshoe(chain)


def charts(**changes):
    """The example's charts, each changed."""
    return [replace(c, **{k: f(c) for k, f in changes.items()}) for c in chains.example().charts]


def first_time(ticks):
    """The times of the chain, the first one another."""
    return [ticks, *chains.example().ticks[1:]]


#: What a chain is made of, wrong; and why it is refused.
FALSE = {
    "the first centre": (lambda e: {"charts": moved(e.charts, 0, 3 * e.size)}, None),
    "the second centre": (lambda e: {"charts": moved(e.charts, 1, 3 * e.size)}, None),
    "a time": (lambda e: {"ticks": first_time(e.ticks[0] + 1638)}, None),
    "no time": (lambda e: {"ticks": first_time(0)}, "not positive"),
    "a time before 0": (lambda e: {"ticks": first_time(-e.ticks[0])}, "not positive"),
    "too small a depth": (lambda e: {"charts": charts(eta=lambda c: 1e-12)}, None),
    "too large a depth": (lambda e: {"charts": charts(eta=lambda c: 0.3)}, None),
    "exchanged directions": (
        lambda e: {"charts": charts(wide=lambda c: c.wide[:, ::-1].copy())},
        None,
    ),
    "first sets that meet": (lambda e: {"first": 0.5 * e.size}, None),
}


@pytest.mark.parametrize("what", FALSE)
def test_a_false_chain_is_refused(what):
    change, why = FALSE[what]
    with pytest.raises(Refused, match=why):
        attempt(**change(chains.example()))


def test_an_orbit_of_another_level_is_refused():
    chain = chains.example().chain
    orbit = chains.example().orbit
    theorem.holds(proofs.level(), chain, orbit.start, orbit.period, BITS)
    other = balls_on(proofs.level(), proofs.proved(proofs.ELLIPTIC))
    with pytest.raises(Refused):
        theorem.holds(proofs.level(), chain, other.start, orbit.period, BITS)
    with pytest.raises(Refused, match="period"):
        theorem.holds(proofs.level(), chain, orbit.start, orbit.period + arb("0.001"), BITS)
    beside = [x + (arb("1e-4") if i == 0 else 0) for i, x in enumerate(orbit.start)]
    with pytest.raises(Refused):
        theorem.holds(proofs.level(), chain, beside, orbit.period, BITS)


def test_a_set_off_the_level_is_refused():
    home = chains.example().chain.home
    level = proofs.level(h=proofs.H + Fraction(1, 1000))
    with ctx.workprec(BITS), pytest.raises(Refused, match="no graph"):
        h_set.disk(level.balls(BITS), home)


def test_a_plane_along_the_motion_is_refused():
    home = chains.example().chain.home
    chart, rates = home.chart, home.chart.deep[:, 3]
    plane = chart.wide[:, 0] - rates * (chart.wide[:, 0] @ rates) / (rates @ rates)
    turned = replace(
        chart,
        wide=np.column_stack([rates, chart.wide[:, 1]]),
        deep=np.column_stack([chart.deep[:, :3], plane]),
        plane=plane,
    )
    known = proofs.level().balls(BITS)
    with ctx.workprec(BITS), pytest.raises(Refused, match="touch the motion"):
        h_set.disk(known, replace(home, chart=turned))


def test_both_coverings_out_of_the_first_set_are_of_one_section_map():
    # with two maps the theorem is false: a free body's steady rotation and half a turn of it
    chain = chains.example().chain
    first = chain.sets[0]
    twin = replace(first, chart=replace(first.chart))
    for changed in (
        Chain(chain.home, (twin, *chain.sets[1:]), chain.images),
        Chain(replace(chain.home, chart=replace(first.chart)), chain.sets, chain.images),
        Chain(chain.home, chain.sets, (chain.images[1], *chain.images[1:])),
    ):
        with pytest.raises(Refused, match=r"section map|not that of its set"):
            theorem.horseshoe(changed)
    with pytest.raises(Refused, match="not that of its set"):
        theorem.horseshoe(
            Chain(chain.home, chain.sets, (chain.images[0], *reversed(chain.images[1:])))
        )
    near = replace(first, middle=0.5 * chain.home.width)
    images = (chain.images[0], replace(chain.images[1], source=near), *chain.images[2:])
    with pytest.raises(Refused, match="may meet"):
        theorem.horseshoe(Chain(chain.home, (near, *chain.sets[1:]), images))
    with pytest.raises(Refused, match="no loop"):
        theorem.horseshoe(Chain(chain.home, (), chain.images[:1]))


@pytest.mark.parametrize("values", [["nan", 1], [1, "nan"], [1, "nan", 2], [0, "inf", 1]])
def test_what_is_no_number_is_the_largest(values):
    assert not largest([arb(x) for x in values]) < arb(10) ** 100


def test_an_entropy_needs_times():
    assert theorem.least_entropy(arb(1), arb(1)) == pytest.approx(math.log(2), rel=1e-9)
    assert theorem.least_entropy(arb(1), arb(1)) <= math.log(2)
    for short in (arb(0), arb(-1), arb(0, 1)):
        with pytest.raises(Refused):
            theorem.least_entropy(short, arb(1))


@pytest.mark.slow
def test_an_elliptic_orbit_and_integrable_tops_are_refused(capsys):
    orbit = polhode.orbit("general/asymmetric-regular")
    with pytest.raises(polhode.NotProved, match="elliptic"):
        polhode.prove_chaos("general/asymmetric-regular", orbit)
    assert main(["prove", "chaos", "lagrange/backward"]) == 3
    told = capsys.readouterr()
    assert told.out == ""
    assert "not proved: lagrange/backward" in told.err

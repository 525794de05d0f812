"""The checker with one inequality or term less: a case that is false then passes.

What cannot be noticed so, and why: the sign of a grid of an orbit (a period below 0 is no longer
than its box, either), and the steepness near the period's end (it is that of the start, but for
what the box moves, so only a product of period and steepness within the box of a prime tells).
Noise of a step and of D are those of states and orbits: see ``test_verify`` and
``test_orbit_certificate``; the inequalities of a covering are in ``test_chaos_certificate``.
"""

from __future__ import annotations

from fractions import Fraction

import pytest

from polhode.certificates import verify
from polhode.proofs import chaos_certificate, orbit_certificate
from polhode.proofs.orbit_certificate import Choice, Problem
from shared import proofs as chains
from shared.tools import without

# -- orbits ---------------------------------------------------------------------------------------


def several(point, times, off=Fraction(0), radius=Fraction(1, 10**22)):
    """What is proved of several times an orbit; the centre off by a part of the box."""
    orbit = chains.proved(point)
    start = [x.centre for x in (*orbit.omega, *orbit.gamma)]
    if off:
        rows = chains.guess()[1].saddle.unstable.tolist()
        start = [x + off * radius * Fraction(y) for x, y in zip(start, rows, strict=True)]
    problem = Problem(orbit.scene.body, orbit.h, orbit.f, start, times * orbit.period.centre)
    guesses = orbit_certificate.guesses(problem, Choice(radius, 140, 0.2))
    return orbit_certificate.zero_of(guesses).repeated


TWICE = "the period may be 2 times the least one"


@pytest.mark.slow
def test_the_box_and_not_its_centre_is_followed_to_a_part_of_the_period():
    assert several(chains.HYPERBOLIC, 4, Fraction(3, 10)) == TWICE
    with without(verify, "zero_near", "row[1] for row in stage.at", "row[0] for row in stage.at"):
        assert several(chains.HYPERBOLIC, 4, Fraction(3, 10)) == ""


@pytest.mark.slow
def test_primes_up_to_the_steepness_times_the_period_are_tried():
    assert several(chains.ELLIPTIC, 3) == "the period may be 3 times the least one"
    with without(verify, "zero_near", "2 * arb.pi()", "16 * arb.pi()"):
        assert several(chains.ELLIPTIC, 3) == ""


# -- chaos ----------------------------------------------------------------------------------------


def refusal(change=lambda x: x):
    """What is said of the example's chain, changed; empty where it is proved."""
    try:
        chaos_certificate.horseshoe_of(chaos_certificate.guesses(change(chains.example().chain)))
    except verify.NotProved as why:
        return str(why)
    return ""


def meeting(chain):
    first = chain.sets[1]._replace(middle=0.5 * chain.sets[0].width)
    return chain._replace(sets=[chain.sets[0], first, *chain.sets[2:]])


def of_two_maps(chain):
    """M1 in a chart of its own, though it is the same one."""
    first = chain.sets[1]._replace(chart=len(chain.charts))
    sets = [chain.sets[0], first, *chain.sets[2:]]
    return chain._replace(charts=[*chain.charts, chain.charts[0]], sets=sets)


#: A line of the checker that is left out, a chain that is false, what is said of it.
CHAINS = {
    "the first two sets may meet": (
        'certainly(gap > 0, "the first two sets may meet")',
        meeting,
        "the first two sets may meet",
    ),
    "one section map": (
        'certainly(home.chart == first.chart, "the first two sets are not of one section map")',
        of_two_maps,
        "not of one section map",
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CHAINS)
def test_a_hypothesis_of_the_theorem_is_needed(name):
    line, change, said = CHAINS[name]
    assert said in refusal(change)
    with without(verify, "horseshoe", line, "pass"):
        assert said not in refusal(change)


def claimed(**changes):
    """What is said of a statement about the example."""
    example = chains.example()
    statement = {"entropy": "0.028", "short": "4.26577", "long": "77.71"} | changes
    try:
        chaos_certificate.with_statement(example.guesses, statement, example.proof)
    except verify.NotProved as why:
        return str(why)
    return ""


#: An inequality that is weakened, and a statement that is false.
CLAIMS = {
    "entropy": ("sum_of_both > 1", "sum_of_both > 0", {"entropy": "0.029"}),
    "the short loop": ("(-x * found.short).exp()", "1", {"entropy": "0.04"}),
    "the long loop": ("(-x * found.long).exp()", "1", {"entropy": "0.04"}),
    "short": ("found.short <= ball", "arb(0) <= ball", {"short": "4.26"}),
    "long": ("found.long <= ball", "arb(0) <= ball", {"long": "77.6"}),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CLAIMS)
def test_a_false_statement_is_noticed(name):
    old, new, changes = CLAIMS[name]
    assert claimed() == ""
    assert claimed(**changes)
    with without(verify, "check_chaos", old, new):
        assert not claimed(**changes)


MIDDLE = "begin = _moved(begin, chart.deep * arb_mat([[x.mid()] for x in depth]))"
#: A function's part that is left out, so that points of a set or differences are outside; how late
#: the image is, how far the set leaves the level, and how far above that its centre lies: the first
#: two hide the terms of second order, and the second one the last.
TERMS = {
    "the depth": ("_starts", "*(upper(x - x.mid()) for x in depth)", "*[arb(0)] * 4", 0, 0.1, 0),
    "the middle of the depth": ("_starts", MIDDLE, "pass", 0, 0, 1e-6),
    "the plane": ("_image", "frame - frame * shadow", "frame", 2e-3, 0.1, 0),
    "the slope of n": ("_image", "chart.wide + chart.deep * slope_of_n", "chart.wide", 0, 0.1, 0),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", TERMS)
def test_points_or_slopes_are_outside_without_a_term(name):
    *changed, late, by, above = TERMS[name]
    assert chains.misses(*chains.tilted(late, by, above)) == 0
    with without(verify, *changed):
        assert chains.misses(*chains.tilted(late, by, above)) > 0

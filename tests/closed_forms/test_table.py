"""Families times questions: every closed form, asked as users ask it.

Rows are the library's cases, ``tests/data/motions.toml`` and some that formulas give.  Each
question is put to some rows of every family, other ones each: a few by the fast tests, more by the
slow ones, all of them by hand.  Errors lie in bands: what is compared has the digits asked for, and
is not the same computation.
"""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import mpmath
import pytest
from mpmath import mpc, mpf

import polhode
from shared.closed_forms import (
    IDENTITY,
    Motion,
    all_motions,
    by_series,
    gap,
    in_scene,
    number,
    quaternion_of,
    relabel,
    scene_of,
    table_gap,
    turn_between,
    vertical_of,
)
from shared.members import motion_table, rotation
from shared.tools import exact_number, exactly, tiers

F = Fraction
MOTIONS: dict[str, list[Motion]] = {}
for motion in all_motions():
    MOTIONS.setdefault(motion.family, []).append(motion)
FREQUENCIES = motion_table()["frequencies"]
#: Any start of the body is one of the family.
ANY_START = "euler", "lagrange", "kovalevskaya"
#: Whose answers cost next to nothing: more rows of them are fast.
CHEAP = {"euler": 3, "lagrange": 3, "pendulum": 2}
#: Of 200 digits it costs seconds.
SLOW = ("hess",)
#: Those that have the state alone: a reference encloses the attitude, and that costs seconds.
ENCLOSED = ("goryachev-chaplygin",)


def has_attitude(motion):
    """Whether Kovalevskaya's top has more than the state, too."""
    alone = "degenerate curve" in motion.regime or "separatrix" in motion.name
    return motion.family != "kovalevskaya" or not alone


STILL = ("rest", "permanent", "sleeping", "hanging", "steady precession", "spherical pendulum, con")


def is_still(motion):
    """Whether w and gamma stay or turn about one axis: numbers may be equal to the last bit."""
    return motion.regime.startswith(STILL)


#: Asked by the slow tests what power series answer: a question was once not answered; they go
#: through a pole, or circle so fast that psi and phi turn often.
SERIES = (
    *("hard/near-axial-pendulum", "hard/near-quasi-periodic", "kovalevskaya: at rest, level"),
    *("pendulum: rotation", "lagrange/turned-axes"),
)


def has_gamma(motion):
    """Whether it has a vertical; without its scene, where that is known."""
    return motion.start is not None or motion.scene.gamma is not None


#: In whose order rows are drawn from other places of the families.
QUESTIONS = (
    *("series", "equations", "digits", "far attitude", "integrals", "period", "places"),
    *("onwards", "error"),
)


def rows(question, *, fast=1, slow=1, keep=lambda motion: True, dear=()):
    """Rows for a question, evenly spread over each family and other ones for each question.

    ``dear``: families of which none is fast.
    """
    params, shift = [], QUESTIONS.index(question)
    for family, motions in MOTIONS.items():
        chosen = [motion for motion in motions if has_gamma(motion) and keep(motion)]
        quick = [] if family in dear else spread(chosen, CHEAP.get(family, 1) * fast, shift)
        later = spread([m for m in chosen if m not in quick], slow, shift)
        for motion in chosen:
            special = question == "series" and str(motion) in SERIES
            if motion in quick or motion in later or special:
                marks = [] if motion in quick else [pytest.mark.slow]
                params.append(pytest.param(motion, id=str(motion), marks=marks))
    return pytest.mark.parametrize("motion", params)


def spread(motions, count, shift):
    """So many of them, evenly spread."""
    count = min(count, len(motions))
    return [motions[(shift + k * len(motions) // count) % len(motions)] for k in range(count)]


@pytest.mark.parametrize("family", MOTIONS)
def test_kinds_of_motion(family):
    for motion in MOTIONS[family]:
        top = motion.reference
        assert (top.kind, motion.regime or top.regime) == (family, top.regime), str(motion)


#: Where the third axis is exactly vertical ever again, which way it turns is a rule's matter.
THROUGH_POLES = (
    *("through", "planar", "pendulum", "homoclinic", "rest", "sleeping", "hanging"),
    "Steklov",
)
#: Which pass it so closely that close samples do not tell on which side.
NEAR_POLES = (
    *("hard/near-quasi-periodic", "hard/near-pole", "near pole 1e-12", "near cusp 1e-15"),
    *("next to the pole 1e-30", "next to the pole -1e-30", "almost hanging 1e-60"),
    "slow near poles of the scene",
)
#: Whose attitude takes seconds, and whose is dear: the same code makes it.
DEAREST = ("goryachev", "n-kowalewski", "chaplygin", *ENCLOSED)
DEAR = ("bobylev-steklov", "steklov", *DEAREST)


#: Whose third axis passes exactly through the vertical: psi and phi are not told beyond.
PAST_A_POLE = ("v constant, et = 0",)


#: Families of which angles are asked: of all, one function makes them of the attitude.
TURNING = (*ANY_START, "pendulum", "hess", *ENCLOSED)


@rows("series", dear=DEAR, keep=lambda motion: motion.name not in PAST_A_POLE)
def test_state_attitude_and_angles_by_power_series(motion):
    """On both sides of t = 0; the sign at t = 0 and the turns too."""
    top, attitude = motion.reference, has_attitude(motion)
    for times in (motion.times(2, 5), motion.times(-4)):
        truth = by_series(motion, times, 30, attitude=attitude)
        error = table_gap([row[:6] for row in truth], top.at(times, 30), motion.rate)
        assert error < mpf("1e-30")
        assert error > mpf("1e-75") or is_still(motion)
        if not attitude:
            continue
        turns = top.attitude(times, 20)
        for row, q in zip(truth, turns, strict=True):
            assert gap(row[6:10], q) < mpf("1e-20")
            assert gap(row[6:10], q) > mpf("1e-60") or is_still(motion)
        if motion.family in TURNING:
            angles_are_those_of_series(motion, truth, times)


def angles_are_those_of_series(motion, truth, times):
    top, scene = motion.reference, motion.scene
    first, *angles = top.angles([0, *times], 20)
    assert (first[0] is None) == (scene.gamma[0] == scene.gamma[1] == 0)
    with mpmath.workdps(60):
        for row, (psi, theta, phi) in zip(truth, angles, strict=True):
            assert (psi is None) == (phi is None)
            if psi is None:
                assert max(map(abs, row[3:5])) < mpf("1e-25")
                assert abs(mpmath.cos(theta) - row[5]) < mpf("1e-20")
                continue
            sides = [[side * x for x in quaternion_of(psi, theta, phi)] for side in (1, -1)]
            assert min(gap(row[6:10], side) for side in sides) < mpf("2e-20")
            if first[0] is None or len(row) < 12 or motion.name in NEAR_POLES:
                continue
            assert abs(first[0] - number(scene.psi)) < mpf("1e-20")
            off = [psi - first[0] - row[10] - row[11], phi - first[2] - row[10] + row[11]]
            if motion.regime.startswith(THROUGH_POLES):
                off = [x - 2 * mpmath.pi * mpmath.nint(x / 2 / mpmath.pi) for x in off]
            assert max(map(abs, off)) < 1e-9


#: Next to a degenerate curve, where the periods' quadrature is too long; and too near to rest.
UNTOLD = (
    *("hard/near-axial-pendulum", "hard/near-bobylev-steklov"),
    "1e-200 from a permanent rotation",
)


@rows(
    "equations",
    dear=SLOW,
    keep=lambda motion: motion.principal and motion.name not in UNTOLD,
)
def test_the_equations_hold_to_150_digits(motion):
    """By the five-point rule on 200 digits, a step of 1e-40: truncation and rounding of 1e-160."""
    step = F(1, 10**40) / motion.rate
    times = [t + k * step for t in motion.times(F(13, 10)) for k in (-2, -1, 0, 1, 2)]
    with mpmath.workdps(240):
        first, second, now, four, five = motion.reference.at(times, 200)
        slopes = [
            (s - 8 * t + 8 * u - v) / (12 * number(step))
            for s, t, u, v in zip(first, second, four, five, strict=True)
        ]
        (A, B, C), (K1, K2, K3) = ([number(x) for x in row] for row in motion.principal[:2])
        p, q, r, g1, g2, g3 = now
        rules = [
            ((B - C) * q * r + g2 * K3 - g3 * K2) / A,
            ((C - A) * r * p + g3 * K1 - g1 * K3) / B,
            ((A - B) * p * q + g1 * K2 - g2 * K1) / C,
            *(g2 * r - g3 * q, g3 * p - g1 * r, g1 * q - g2 * p),
        ]
        error = gap(slopes, rules) / max(1, *map(abs, now), *map(abs, rules))
    assert error < mpf("1e-150")
    assert error > mpf("1e-230") or is_still(motion)


#: How far kinds of motion are asked, in their own unit of time.
REACH = {"degenerate curve, asymptotic": 20}


def far(motion, time):
    """The time, or as far as the motion is asked."""
    reach = [n for kind, n in REACH.items() if motion.regime.startswith(kind)]
    return motion.times(min(time, *reach, time))[0]


@rows(
    "digits",
    dear=("kovalevskaya", "n-kowalewski", "chaplygin", *SLOW, *ENCLOSED),
    keep=lambda motion: motion.name not in UNTOLD,
)
def test_fewer_digits_are_those_of_more(motion):
    """The state at any time, 15, 50 and 200 digits."""
    top, times = motion.reference, [F(0), *motion.times(F(7, 3), -11)]
    times += [far(motion, 10**4), -far(motion, 10**12)]
    for few, many in (
        ((15, 33), (50, 90)) if motion.family in ("kovalevskaya", *SLOW) else ((15, 50), (200, 220))
    ):
        error = table_gap(top.at(times, few), top.at(times, many), motion.rate)
        assert error < mpf(10) ** -few
        assert error > mpf(10) ** (-2 * few - 40) or is_still(motion)


@rows(
    "far attitude",
    dear=(*DEAR, "kovalevskaya"),
    keep=lambda motion: has_attitude(motion) and motion.family not in DEAREST,
)
def test_attitude_at_any_time(motion):
    """Digits as asked, of length 1, it carries the vertical, and a million periods are as many."""
    top, times = motion.reference, [-far(motion, 10**9)]
    few, many = top.attitude(times, 20), top.attitude(times, 35)
    with mpmath.workdps(60):
        for row, finer, state in zip(few, many, top.at(times, 35), strict=True):
            assert gap(row, finer) < mpf("1e-20")
            assert gap(row, finer) > mpf("1e-80") or is_still(motion)
            assert abs(mpmath.norm(mpmath.matrix(finer)) - 1) < mpf("1e-34")
            assert gap(vertical_of(finer), state[3:]) < mpf("4e-35")
        if top.period is None or motion.family == "euler":  # whose vertical does not come back
            return
        turns = top.attitude([exactly(n * top.period) for n in (0, 1, 10**6)], 35)
        (first, second, last), (third, fourth, end) = (
            [mpc(row[i], row[j]) for row in turns] for i, j in ((0, 3), (1, 2))
        )
        about = second / first if abs(first) > abs(third) else fourth / third
        assert max(abs(last - about**10**6 * first), abs(end - about**10**6 * third)) < mpf("1e-27")


@rows("integrals", keep=lambda motion: motion.principal)
def test_integrals_far_away(motion):
    """Energy, area, length, and the family's fourth."""
    then, now = motion.reference.at([0, far(motion, 10**12)], 50)
    with mpmath.workdps(70):
        A, K = ([number(x) for x in row] for row in motion.principal[:2])

        def integrals(row):
            w, g = row[:3], row[3:]
            G = [a * x for a, x in zip(A, w, strict=True)]
            energy = mpmath.fdot(G, w) / 2 + mpmath.fdot(K, g)
            return [energy, mpmath.fdot(G, g), mpmath.fdot(g, g), fourth(motion.family, A, K, w, g)]

        speed, pull = max(number(motion.rate), *map(abs, now[:3])), max(map(abs, K))
        inertia = max(A)
        sizes = [inertia * speed**2 + pull, inertia * speed, 1]
        sizes.append(
            {"euler": sizes[1] ** 2, "lagrange": sizes[1] * pull}.get(motion.family, speed**4)
        )
        for x, y, size in zip(integrals(then), integrals(now), sizes, strict=True):
            assert abs(x - y) < mpf("1e-47") * size


def fourth(family, A, K, w, g):
    """Iw squared, Iw along the axis, Kovalevskaya's; 0 where there is none."""
    momentum = [a * x for a, x in zip(A, w, strict=True)]
    if family == "euler":
        return mpmath.fdot(momentum, momentum)
    if family == "lagrange":
        return mpmath.fdot(momentum, K)
    if family == "kovalevskaya":
        third = min(range(3), key=lambda i: A[i])
        z, up, pull = (mpc(*(v[i] for i in range(3) if i != third)) for v in (w, g, K))
        return abs(z * z - pull / A[third] * up) ** 2
    return mpf(0)


def expected_frequencies(motion):
    """Their names by the kind of motion, and whether there is a period."""
    kinds = FREQUENCIES.get(motion.family, FREQUENCIES["others"])
    regime = motion.reference.regime
    return kinds[max((kind for kind in kinds if regime.startswith(kind)), key=len)]


@rows("period", keep=lambda motion: motion.name not in UNTOLD)
def test_a_period_brings_the_state_back_and_no_part_of_it_does(motion):
    """omega alone of a free body; one of the frequencies is 2 pi over it."""
    top = motion.reference
    period, frequencies = top.period, top.frequencies
    names = " ".join(frequencies) + (", periodic" if period is not None else "")
    assert names in expected_frequencies(motion)
    if period is None:
        return
    with mpmath.workdps(70):
        turns = [period * x / 2 / mpmath.pi for x in frequencies.values()]
        # theta of a swing is back twice as often
        once = 2 if motion.regime == "planar pendulum, librating" else 1
        assert min(abs(abs(turn) - once) for turn in turns) < mpf("1e-48")
        begin, *parts = (F(1) / motion.rate + exactly(period / n) for n in (1, 2, 3, 5))
    last = 3 if motion.family == "euler" else 6
    start, after, *early = (row[:last] for row in top.at([*motion.times(1), begin, *parts], 45))
    assert table_gap([start], [after], motion.rate) < mpf("1e-43")
    if not is_still(motion):
        assert min(table_gap([start], [row], motion.rate) for row in early) > mpf("1e-40")


#: Orders and senses of the axes, axes of the scene, units of time and mass.
PLACES = (
    ((1, 2, 0), (1, 1, 1), IDENTITY, F(1, 10**30), F(10**30)),
    ((1, 0, 2), (1, -1, 1), rotation(1, 2, 4, 2), F(1), F(1)),
    ((2, 1, 0), (-1, -1, -1), rotation(exact_number("sqrt(2)"), 1, 0, 1), F(10**20), F(1)),
)


@rows(
    "places",
    keep=lambda motion: motion.principal and has_attitude(motion),
    dear=(*DEAR, *SLOW),
)
def test_other_axes_and_units_give_the_same_motion(motion):
    """Axes renamed, reflected and turned, also by irrational matrices."""
    top, (time,) = motion.reference, motion.times(F(-7, 3))
    (state,) = top.at([time], 35)
    for order, signs, axes, unit, mass in PLACES:
        start = relabel(motion.principal, order, signs)
        twin = polhode.reference(scene_of(start, motion.family, axes, unit, mass))
        assert twin.regime == top.regime
        with mpmath.workdps(50):
            matrix = [[number(x) for x in row] for row in axes]
            _, _, w, up = relabel((state, state, state[:3], state[3:]), order, signs)
            right = [*in_scene([x * number(unit) for x in w], matrix), *in_scene(up, matrix)]
            assert table_gap(twin.at([time / unit], 35), [right], motion.rate * unit) < mpf("4e-35")
            if motion.family in DEAREST:
                continue
            turn, there = (
                turn_between(*reversed(reference.attitude([0, t], 25)))[1:]
                for reference, t in ((top, time), (twin, time / unit))
            )
            _, _, turn, _ = relabel((turn, turn, turn, turn), order, signs)  # axial, as w is
            assert gap(there, in_scene(turn, matrix)) < mpf("4e-25")


@rows(
    "onwards",
    dear=("kovalevskaya",),
    keep=lambda motion: motion.family in ANY_START and motion.principal,
)
def test_a_state_on_the_way_is_a_start_of_the_same_motion(motion):
    """From the state at t = 2, rounded to 70 digits and hence irrational, back by 2."""
    (row,) = motion.reference.at(motion.times(2), 80)
    values = list(map(exactly, row))
    length = exact_number(f"sqrt({sum(x * x for x in values[3:])})")
    moments, torque, _, _ = motion.principal
    start = moments, torque, values[:3], [x / length for x in values[3:]]
    then = polhode.reference(scene_of(start, motion.family)).at(motion.times(-2), 60)
    assert table_gap(then, motion.reference.at([0], 60), motion.rate) < mpf("1e-58")


@rows("error")
def test_the_error_told_is_above_the_true_one(motion):
    top, times = motion.reference, motion.times(2, 9)
    rows, better = top.at(times, 30), top.at(times, 60)
    bound = top.error(times, 30)
    assert bound < mpf("1e-30")
    assert bound > mpf("1e-42") or is_still(motion)
    assert bound >= table_gap(rows, better, motion.rate) or is_still(motion)


def test_the_curve_of_a_kovalevskaya_top_is_shown():
    curve = next(m for m in MOTIONS["kovalevskaya"] if m.name == "-eee+").reference.curve
    with mpmath.workdps(45):
        assert abs(sum(curve["e"]) + curve["H"]) < mpf("1e-40")
    assert all(t.imag > 0 for t in (curve["tau"][0], curve["tau"][2]))


# -- states that other programs printed to 50 digits, and a second axis that the attitude carries -

DATA = Path(__file__).parents[1] / "data"
#: Errors: the first file has 55 digits, the other 50 of numbers up to 6.
LIMITS = {"closed-form-50-digits": "1e-54", "other-50-digits": "5e-50"}
CASES = [
    case | {"limit": limit}
    for name, limit in LIMITS.items()
    for case in json.loads((DATA / f"{name}.json").read_text(encoding="utf-8"))["cases"]
    if case["group"] != "generic"
]


def matrix_of(q):
    """The matrix of a unit quaternion, body to space."""
    a, x, y, z = q
    return mpmath.matrix(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - a * z), 2 * (x * z + a * y)],
            [2 * (x * y + a * z), 1 - 2 * (x * x + z * z), 2 * (y * z - a * x)],
            [2 * (x * z - a * y), 2 * (y * z + a * x), 1 - 2 * (x * x + y * y)],
        ]
    )


@pytest.mark.parametrize("case", tiers(CASES[::3], CASES[1::3]))
def test_stored_values(case):
    body = polhode.Body.of_moments(case["moments"], case["centre"], case["weight"])
    reference = polhode.reference(polhode.Scene(body, case["omega"], case["gamma"]))
    assert reference.is_closed_form
    rows = reference.at(case["times"], 55)
    with mpmath.workdps(70):
        stored = [list(map(mpf, row)) for row in case["states"]]
        error = table_gap(stored, rows)
        assert error < mpf(case["limit"])
        assert error > mpf("1e-62") or "sleeping" in reference.regime
        if "psi" in case:
            angles = reference.angles(case["times"], 50)
            for psi, row in zip(case["psi"], angles, strict=True):
                assert abs(mpf(psi) - row[0]) < mpf("1e-49")
        if "second_axis" not in case:
            return
        start, *turns = reference.attitude([0, *case["times"]], 52)
        fixed = matrix_of(start) * mpmath.matrix([mpf(x) for x in case["second_axis_start"]])
        for row, attitude in zip(case["second_axis"], turns, strict=True):
            vector = matrix_of(attitude).T * fixed
            assert max(abs(mpf(x) - y) for x, y in zip(row, vector, strict=True)) < mpf("1e-49")

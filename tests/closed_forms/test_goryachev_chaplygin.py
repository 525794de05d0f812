"""Goryachev and Chaplygin's case against its equations, Taylor runs and states to 50 digits.

Any u, v > 0 and angles xi, et make a start with f = 0; where uv and the sines are rational squares
it is rational.  Errors lie in bands: asked for 40 digits, less than 1e-38 (the truth's) and, so
that nothing is compared with itself, more than 1e-90.
"""

import contextlib
import random
from dataclasses import replace
from fractions import Fraction

import pytest

from polhode.closed_forms import families
from polhode.closed_forms._engine import attitude_series
from polhode.closed_forms._engine.principal_scene import PrincipalScene
from polhode.closed_forms.functions import fourier
from polhode.closed_forms.goryachev_chaplygin import (
    abel_integrals,
    conditions,
    family,
    local_coordinates,
    motion,
    regimes,
    separation_variables,
)
from polhode.closed_forms.goryachev_chaplygin import top as goryachev_chaplygin
from polhode.closed_forms.goryachev_chaplygin.attitude import attitude
from polhode.closed_forms.goryachev_chaplygin.axes import failure
from polhode.closed_forms.goryachev_chaplygin.top import GoryachevChaplyginTop
from polhode.common.errors import BadInput
from polhode.judging.references.reference import reference
from polhode.numbers import exact
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.scenes import scene_file
from shared import surface_checks as checks
from shared.closed_form_checks import number, unwound
from shared.surface_checks import LEAST

F = Fraction
BODY = (F(4), F(4), F(1))
TINY = F(1, 10**30)
TIMES = (F(2), F(7, 2))


def start(u, v, a, xi, et, sg=1):
    """omega and gamma, from (sin, cos) of xi/2 and et/2; a body of moments 4, 4, 1."""
    (sx, cx), (se, ce) = xi, et
    root, total = exact.sqrt(u * v), u + v
    omega = (sg * root * (se * cx - ce * sx) / 2, sg * root * (cx * ce + sx * se) / 2, u - v)
    gamma = (
        -(u * (cx * cx - sx * sx) + v * (ce * ce - se * se)) / total,
        -2 * (u * sx * cx - v * se * ce) / total,
        2 * sg * root * (sx * ce + cx * se) / total,
    )
    return omega, gamma, (a, F(0), F(0))


def half(cos2, sin_sign=1):
    """(sin, cos) of an angle with that square of its cosine."""
    return sin_sign * exact.sqrt(1 - cos2), exact.sqrt(cos2)


def tangent(t):
    """(sin, cos) of an angle by a rational parameter."""
    return 2 * t / (1 + t * t), (1 - t * t) / (1 + t * t)


def on_cubics(u, v, a, H, G, signs=(1, 1)):
    """A start with given constants: cos^2 of the halves from the cubics."""
    below = H - 2 * a
    xi = half((u * u - below - 4 * G / u) / (4 * a), signs[0])
    et = half((v * v - below + 4 * G / v) / (4 * a), signs[1])
    return start(u, v, a, xi, et)


#: u, v, a, H, G and the regime.
CONSTANTS = {
    "whole": (F(5, 4), F(2, 3), F(1), F(1), F(1, 3), regimes.GENERIC_WHOLE),
    "low": (F(13, 4), F(3, 4), F(1), F(9), F(3, 2), regimes.GENERIC_LOW),
    "high": (F(13, 4), F(5, 2), F(1), F(9), F(3, 2), regimes.GENERIC_HIGH),
    "standing 0": (F(3, 2), F(1), F(1), F(1), F(1, 2), regimes.CONSTANT_ZERO),
    "standing pi": (F(9, 4), F(1), F(2), F(7), F(1, 2), regimes.CONSTANT_PI),
    "from above": (F(9, 4), F(5, 4), F(2), F(7), F(1, 2), regimes.ASYMPTOTIC_HIGH),
    "from below": (F(9, 4), F(3, 4), F(2), F(7), F(1, 2), regimes.ASYMPTOTIC_LOW),
    "libration": (F(5, 4), F(2, 3), F(1), F(1), F(0), regimes.LIBRATING),
    "rotation": (F(3, 2), F(5, 4), F(1), F(3), F(0), regimes.ROTATING),
    "separatrix": (F(3, 2), F(5, 4), F(1), F(2), F(0), regimes.SEPARATRIX),
}


def named(name):
    """The start of that name."""
    return place(on_cubics(*CONSTANTS[name][:5]))


def place(parts, body=BODY):
    """A start from omega, gamma and the torque."""
    omega, gamma, torque = parts
    return body, torque, omega, gamma


def top(moments, torque, omega, gamma):
    return GoryachevChaplyginTop(moments=moments, torque=torque, omega=omega, gamma=gamma)


def off(start, times=TIMES, digits=40, attitudes=False):
    return checks.off(top, start, times, digits, attitudes)


@pytest.mark.sample(4)
@pytest.mark.parametrize("name", CONSTANTS)
def test_every_regime_agrees_with_a_taylor_run(name):
    start = named(name)
    assert top(*start).regime == CONSTANTS[name][5]
    assert LEAST < off(start, times=(F(-3, 2),)) < mpf("1e-38")
    assert LEAST < off(start) < mpf("1e-38")


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    "name", ["low", "standing 0", "standing pi", "libration", "rotation", "separatrix"]
)
def test_attitude_agrees_with_a_taylor_run(name):
    assert mpf("1e-70") < off(named(name), digits=25, attitudes=True) < mpf("1e-23")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["whole", "high", "from above", "from below"])
def test_attitude_of_the_others_agrees_with_a_taylor_run(name):
    assert mpf("1e-70") < off(named(name), digits=25, attitudes=True) < mpf("1e-23")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["whole", "low", "high"])
def test_attitude_near_and_far_is_one(name, monkeypatch):
    """By series of the body, and by the azimuth of its momentum."""
    times = [F(30), F(-17)]
    near, angles = top(*named(name)).attitude(times, 25), top(*named(name)).angles(times, 20)
    monkeypatch.setattr(goryachev_chaplygin, "_REACH", 0)
    far, others = top(*named(name)).attitude(times, 25), top(*named(name)).angles(times, 20)
    for one, other in zip(near + angles, far + others, strict=True):
        assert checks.largest(one, other) < mpf("1e-20")
    assert max(checks.largest(*rows) for rows in zip(near, far, strict=True)) < mpf("1e-25")


#: Released with omega in the direction that f = 0 asks for, times these.
NEAR_REST = ["1e-2", "1e-9", "1e-30"]


@pytest.mark.slow
@pytest.mark.sample(3, first=1, rest="campaign")
@pytest.mark.parametrize("size", NEAR_REST)
def test_near_rest(size):
    """u and v both nearly vanish: their phases run on there while time nearly stands."""
    torque = F(-105 * 9, 233 * 4), F(208 * 9, 233 * 4), F(0)
    gamma = F(40, 77), F(-45, 77), F(48, 77)
    start = BODY, torque, (F(size), F(0), -F(size) * 10 / 3), gamma
    assert top(*start).regime in regimes.TWO_FREQUENCIES
    assert LEAST < off(start, (F(1), F(5)), 30, attitudes=True) < mpf("1e-28")
    assert LEAST < off(start, (F(-3),), 25, attitudes=True) < mpf("1e-23")
    found = top(*start)
    (psi, _, phi), (psi_1, _, phi_1) = found.angles([F(1, 10), F(5)], 15)
    grown = unwound(found, F(1, 10), F(5), 50)
    assert abs(psi_1 - psi - grown[0]) < mpf("1e-11")
    assert abs(phi_1 - phi - grown[1]) < mpf("1e-11")


def test_a_corrupted_body_is_noticed_where_pieces_meet(monkeypatch):
    honest = attitude_series.Body.series

    def corrupt(body, *parts):
        a, *rest = body.torque
        return honest(attitude_series.Body(body.moments, (a * (1 + mpf("1e-25")), *rest)), *parts)

    monkeypatch.setattr(attitude_series.Body, "series", corrupt)
    with pytest.raises(ArithmeticError, match="do not meet"):
        top(*named("low")).attitude([F(3)], 30)


def test_published_states_to_50_digits():
    checks.check_stored(top, "goryachev-chaplygin")


@pytest.mark.sample(5, first=1)
@pytest.mark.parametrize("name", CONSTANTS)
def test_two_precisions_agree_far_away(name):
    found = top(*named(name))
    far = 20 if name == "separatrix" else 10**4  # at rest upright it has no digits to lose
    times = [F(far), F(-far)]
    for one, other in zip(found.at(times, 30), found.at(times, 60), strict=True):
        assert mpf("1e-45") < checks.largest(one, other) < mpf("1e-29")


@pytest.mark.parametrize("name", CONSTANTS)
def test_the_six_equations_hold(name):
    checks.check_equations(top, named(name), mpf("1e-44"))


def random_member(seed):
    """A rational start: v = u k^2, angles by rational parameters; any sign of G."""
    pick = random.Random(seed)

    def ratio(low, high):
        return F(pick.randint(int(low * 40), int(high * 40)), 40)

    u, k = ratio(0.2, 3), ratio(0.25, 2)
    xi, et = (tangent(ratio(-2, 2)) for _ in range(2))
    return place(start(u, u * k * k, ratio(0.2, 2), xi, et, pick.choice((1, -1))))


def random_members_agree(seeds, time, digits):
    for seed in seeds:
        body, torque, omega, gamma = member = random_member(seed)
        assert conditions.fits(PrincipalScene(body, torque, omega, gamma))
        error = off(member, (time,), digits)
        assert LEAST < error < mpf(10) ** (2 - digits), (seed, mpmath.nstr(error, 3))


def test_random_members_agree_with_a_taylor_run():
    random_members_agree(range(6), F(1), 25)


@pytest.mark.slow
def test_30_random_members():
    random_members_agree(range(6, 30), F(1), 25)


@pytest.mark.campaign
def test_300_random_members():
    random_members_agree(range(30, 330), F(5), 30)


CORRUPTIONS = {
    "speed of u": (
        separation_variables.Variable,
        "rate",
        lambda old: lambda *a: old(*a) * (1 + mpf(10) ** -30 if isinstance(a[1], mpf) else 1),
    ),
    "mean of a series": (
        fourier,
        "_series",
        lambda old: lambda *a: (x := old(*a)) and replace(x, mean=x.mean * (1 + mpf(10) ** -30)),
    ),
    "gamma2": (
        motion,
        "state",
        lambda old: lambda *a: [x * (1 + mpf(10) ** -35) for x in old(*a)],
    ),
}


@pytest.mark.slow
@pytest.mark.sample(2, rest="campaign")
@pytest.mark.parametrize("name", CORRUPTIONS)
def test_a_corrupted_formula_fails(name, monkeypatch):
    where, what, change = CORRUPTIONS[name]
    monkeypatch.setattr(where, what, change(getattr(where, what)))
    with contextlib.suppress(ArithmeticError):  # where the start is not reproduced
        assert off(named("low"), (F(2),)) > mpf("1e-38")


def test_a_corrupted_attitude_fails(monkeypatch):
    old = attitude.placed
    monkeypatch.setattr(attitude, "placed", lambda point, sg, fn: old(point, -sg, fn))
    assert off(named("libration"), digits=25, attitudes=True) > mpf("1e-3")


def test_renamed_reflected_and_turned_axes():
    """The same motion with the axes in another order, some reversed, or a turned body."""
    _, torque, omega, gamma = named("low")
    (plain,) = top(*named("low")).at([F(3)], 30)
    p, q, r, g1, g2, g3 = plain
    # Axes x -> y, y -> -x (a turn), then x -> z, y -> x, z -> y.
    found = top(
        (F(1), F(4), F(4)),
        (F(0), F(0), torque[0]),
        (omega[2], -omega[1], omega[0]),
        (gamma[2], -gamma[1], gamma[0]),
    )
    (row,) = found.at([F(3)], 30)
    with mpmath.workdps(50):
        assert checks.largest(row, [r, -q, p, g3, -g2, g1]) < mpf("1e-29")
    # A reflection y -> -y: w is axial.
    found = top(BODY, torque, (-omega[0], omega[1], -omega[2]), (gamma[0], -gamma[1], gamma[2]))
    (row,) = found.at([F(3)], 30)
    with mpmath.workdps(50):
        assert checks.largest(row, [-p, q, -r, g1, -g2, g3]) < mpf("1e-29")


def test_a_scene_in_turned_axes_is_recognised():
    start = random_member(3)
    name, form = families.closed_form(checks.turned_scene(start))
    assert name == "goryachev-chaplygin"
    checks.check_turned(top, form, start)


@pytest.mark.parametrize("which", range(4))
def test_1e_30_off_is_refused(which):
    body, torque, omega, gamma = named("low")
    if which == 0:
        omega = (omega[0] + TINY, *omega[1:])
    elif which == 1:
        body = (F(4) + TINY, F(4), F(1))
    elif which == 2:
        body = (F(4), F(4), F(1) + TINY)
    else:
        torque = (torque[0], torque[1], TINY)
    scene = PrincipalScene(body, torque, omega, gamma)
    assert not conditions.fits(scene)
    wrong = family.FAMILY.misfit(scene)
    assert wrong is not None
    assert 1e-31 < abs(float(wrong.off)) < 1e-29
    with pytest.raises(ValueError, match="does not meet this condition"):
        top(body, torque, omega, gamma)


def test_asked_for_by_name_the_failing_condition_is_told():
    scene = checks.turned_scene(random_member(3), "goryachev-chaplygin", F(1, 1000))
    with pytest.raises(BadInput, match=r"f = Iw\.gamma = 0, off by"):
        reference(scene)


def test_pendulums_about_the_third_axis_are_left_to_the_pendulum():
    scene = PrincipalScene(BODY, (F(1), F(0), F(0)), (F(0), F(0), F(2)), (F(3, 5), F(4, 5), F(0)))
    assert not conditions.fits(scene)


def test_elliptic_angles_change_nothing_but_the_length():
    """Near D- = 0 (gap 1e-8) the elliptic chart has the means of the plain one, in fewer terms."""
    near = place(on_cubics(F(9, 4), F(5, 4), F(2), F(7) + F(1, 10**8), F(1, 2)))
    found = top(*near)
    with mpmath.workprec(192):
        variable = separation_variables.v_part(found._start, 192, high=True)
        made, _ = local_coordinates.chart(variable, 64)
        assert not isinstance(made, local_coordinates.Plain)
        elliptic = abel_integrals.oscillating(variable)

        def integrands(x):
            c, s = mpmath.cos_sin(x / 2)
            z = variable.at(c, s)
            slope = 1 / variable.rate(z, mpmath.sqrt)
            return slope, z * slope

        wanted = mpmath.quad(
            lambda x: integrands(x)[0], [0, mpf(1) / 1000, mpf(1) / 30, 1, mpmath.pi]
        )
        assert abs(elliptic.S.mean * mpmath.pi - wanted) < mpf("1e-40") * wanted
        assert len(elliptic.S.terms) < 400
    assert off(near, (F(3),), 25) < mpf("1e-22")


def test_a_body_that_does_not_belong_is_told_its_worst_moment():
    """Every axis may be the third; the one nearest to belonging is named C."""
    rest = (F(0),) * 3, (F(1), F(0), F(0))
    for k, (third, one, other) in enumerate(((1, 4, 5), (2, 9, 8), (1, 4, 3))):
        for axis in range(3):
            moments, torque = [F(0)] * 3, [F(0)] * 3
            for n, x in enumerate((third, one, other)):
                moments[(axis + n) % 3] = F(x)
            torque[(axis + 1) % 3] = F(1)
            found = failure(PrincipalScene(tuple(moments), tuple(torque), *rest))
            assert found.condition == f"{'BAB'[k]} = 4C (in units of C)"
            assert found.off == (1, F(1, 2), 1)[k]


@pytest.mark.parametrize("unit", [F(2) ** 60, F(2) ** -60])
def test_the_same_motion_in_other_units_of_time(unit):
    """So far on that phases cost more bits than the guard has."""
    moments, torque, omega, gamma = named("rotation")
    times = [F(10**45), F(-(10**45))]
    plain = top(moments, torque, omega, gamma).at(times, 20)
    quick = moments, [unit * unit * x for x in torque], [unit * x for x in omega], gamma
    for row, scaled in zip(plain, top(*quick).at([t / unit for t in times], 20), strict=True):
        with mpmath.workdps(40):
            back = [*(x / number(unit) for x in scaled[:3]), *scaled[3:]]
        assert checks.largest(row, back) < mpf("1e-20") * 4


@pytest.mark.sample(1, first=1)
@pytest.mark.parametrize("name", ["low", "libration", "standing pi"])
def test_angles_are_continuous(name):
    found = top(*named(name))
    (psi, _, phi), (psi_1, _, phi_1) = found.angles([F(1, 10), F(20)], 15)
    grown = unwound(found, F(1, 10), F(20), 240)
    assert abs(psi_1 - psi - grown[0]) < mpf("1e-11")
    assert abs(phi_1 - phi - grown[1]) < mpf("1e-11")


@pytest.mark.parametrize("name", ["libration", "rotation", "standing 0", "standing pi"])
def test_periods_bring_the_state_back(name):
    checks.check_period(top, named(name))


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["low", "high"])
def test_a_generic_motion_has_the_two_frequencies_told(name):
    checks.check_frequencies(top, named(name), ("u", "v"))


def test_an_asymptotic_motion_has_no_frequencies():
    assert top(*named("from below")).frequencies(20) == {}


def test_bad_kind_is_one_line():
    text = (
        "schema = 1\n[body]\nmoments = [4, 4, 1]\ncentre = [1, 0, 0]\nweight = 1\n"
        "[start]\nomega = [0, 1, 0]\ngamma = [0, 1, 0]\n[run]\nend = 1\n"
        "[reference]\nkind = 'goryachev-chaplygin'\n"
    )
    with pytest.raises(BadInput) as caught:
        reference(scene_file.parse(text))
    assert "\n" not in str(caught.value)


NEAR = {
    "D- from above": lambda gap: on_cubics(F(9, 4), F(3, 4), F(2), F(7) + gap, F(1, 2)),
    "D- from below": lambda gap: on_cubics(F(9, 4), F(3, 4), F(2), F(7) - gap, F(1, 2)),
    "D+": lambda gap: on_cubics(F(3, 2), F(1), F(1), F(1) + gap, F(1, 2)),
    "G, librating": lambda gap: on_cubics(F(5, 4), F(2, 3), F(1), F(1), gap),
    "G, rotating": lambda gap: on_cubics(F(3, 2), F(5, 4), F(1), F(3), gap),
}


@pytest.mark.campaign
@pytest.mark.parametrize("power", [8, 20])
@pytest.mark.parametrize("name", NEAR)
def test_near_degenerate_motions(name, power):
    near = place(NEAR[name](F(1, 10**power)))
    assert top(*near).regime in regimes.TWO_FREQUENCIES
    assert LEAST < off(near, (F(8),), 25) < mpf("1e-25")


@pytest.mark.slow
@pytest.mark.sample(2, rest="campaign")
@pytest.mark.parametrize("name", ["D- from above", "D- from below"])
def test_far_away_where_doubles_do_not_part_two_roots(name):
    near = place(NEAR[name](F(1, 10**20)))
    times = [F(10**4), F(-(10**4))]
    found = top(*near)
    for one, other in zip(found.at(times, 20), found.at(times, 40), strict=True):
        assert LEAST < checks.largest(one, other) < mpf("1e-20")


@pytest.mark.campaign
def test_too_near_two_degenerate_motions_at_once_is_refused():
    """G and H - 2a both nearly 0: near roots on both sides, more than one chart can part."""
    near = place(on_cubics(F(3, 2), F(5, 4), F(1), F(2), F(1, 10**20)))
    with pytest.raises(ArithmeticError, match="too near a degenerate motion"):
        top(*near).at([F(1)], 15)

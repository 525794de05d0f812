"""Periodic orbits: closed forms of period, start and residue, exact properties, honest errors."""

import math
from fractions import Fraction

import numpy as np
import pytest
from mpmath import MPContext

import polhode
from polhode.cli import main
from polhode.dynamics import newton_shooting, orbit
from polhode.dynamics.level_body import LevelBody
from polhode.dynamics.newton_shooting import at_level, bordered
from polhode.dynamics.orbit import Return
from shared import plain_taylor
from shared.tools import EXTENDED, exactly, mp, tiers

GRIOLI = polhode.load("grioli/precession")


def mp_of(digits):
    mp = MPContext()
    mp.dps = digits
    return mp


def value(mp, x):
    """A number of polhode's in a context of ours."""
    exact = exactly(x)
    return mp.mpf(exact.numerator) / exact.denominator


def perturbed(size, seed):
    """Grioli's start, every component off by about ``size``."""
    rng = np.random.default_rng(seed)
    omega, gamma = (
        [x + Fraction(float(size * rng.normal())) for x in v] for v in (GRIOLI.omega, GRIOLI.gamma)
    )
    return polhode.Scene(
        GRIOLI.body, omega, gamma, Fraction(1, 3), name="near Grioli", normalise=True
    )


def grioli_orbit(mp, q):
    """Closed form (Grioli 1947): the state at which w2 = q, spin 1, near the case's start."""
    a, b, c = (mp.mpf(x.numerator) / x.denominator for x in GRIOLI.body.moments)
    e1, e2 = (mp.mpf(4) / 5, mp.mpf(3) / 5), (-mp.mpf(3) / 5, mp.mpf(4) / 5)
    s = q
    co = mp.sqrt(1 - s * s)
    i11, j = a + c - b, (c - a) * e1[0] * e1[1]
    first, two = -j * co, i11 * co - j * s * s
    return [
        *(e1[0] + co * e2[0], s, e1[1] + co * e2[1]),
        *(first * e1[0] + two * e2[0], s * (i11 + j * co), first * e1[1] + two * e2[1]),
    ]


@pytest.mark.parametrize("seed", tiers([0], [1]))
def test_griolis_orbit_to_thirty_digits_from_a_start_off_by_a_thousandth(seed):
    mp = mp_of(50)
    near = perturbed(1e-3, seed)
    level = GRIOLI.integrals
    closed_orbit = polhode.orbit(near, digits=30, h=level.energy, f=level.area)
    assert 1e-4 < closed_orbit.moved < 1e-2
    off = abs(value(mp, closed_orbit.period) / (2 * mp.pi) - 1)
    state = [value(mp, x) for x in closed_orbit.scene.omega]
    gamma = [value(mp, x) for x in gamma_of(closed_orbit.scene, 40)]
    exact = grioli_orbit(mp, state[1])
    worst = max(off, *(abs(a - b) for a, b in zip([*state, *gamma], exact, strict=True)))
    assert 1e-35 < worst < 1e-30
    assert worst < 5 * closed_orbit.error < 5e-30
    assert closed_orbit.residue == pytest.approx(0.002448416424848809, rel=1e-14)
    assert closed_orbit.turns == 1  # of psi, from 1/3 on
    assert abs(value(mp, closed_orbit.psi) / (2 * mp.pi) - 1) < 1e-25
    assert closed_orbit.scene.psi == Fraction(1, 3)


def test_another_orbit_of_griolis_whose_residue_is_known():
    """Moments 3, 2, 1, T = 2 pi (5/2)^(1/4); R by an earlier program at 160 and 237 bits alike."""
    mp = mp_of(50)
    near = polhode.top(
        moments=[3, 2, 1],
        centre=[1, 0, 1],
        weight=1,
        omega=["0.0005", 0, "1.1247"],
        gamma=["-0.3162", "0.0003", "0.9487"],
        normalise=True,
    )
    closed_orbit = polhode.orbit(near, digits=30, h="2*sqrt(2/5)", f="sqrt(9/5*sqrt(2/5))")
    top = mp.mpf("0.07633098281651145408432311840734126483")
    assert abs(value(mp, closed_orbit.residue) - top) < closed_orbit.residue_error < 1e-28
    exact = 2 * mp.pi * mp.mpf("2.5") ** 0.25
    assert abs(value(mp, closed_orbit.period) / exact - 1) < 1e-30


def gamma_of(scene, digits):
    """gamma of a found scene, an irrational unit vector, to many digits."""
    return [polhode.NumberType("mp", 4 * digits).rounded(x) for x in scene.gamma]


def test_what_the_monodromy_matrix_keeps_exactly():
    """grad F M = grad F, M x' = x', det M = 1; of the period as many digits are right."""
    closed_orbit = polhode.orbit(GRIOLI, digits=30)
    assert 1e-33 < closed_orbit.error < 1e-30
    assert closed_orbit.residue_error < 1e-28
    assert closed_orbit.determinant < 1e-29
    mp = mp_of(80)
    assert abs(value(mp, closed_orbit.period) / (2 * mp.pi) - 1) < 1e-30
    second = polhode.orbit(GRIOLI, digits=20)
    assert abs(value(mp, closed_orbit.residue) - value(mp, second.residue)) < second.residue_error


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_residues_of_rotations_of_a_free_body(axis):
    """About axis 1: mu = exp(2 pi i sqrt((A-B)(A-C)/(BC))), period 2 pi/w."""
    mp = mp_of(60)
    moments = [Fraction(2), Fraction(3, 2), Fraction(1)]
    omega, gamma = [0, 0, 0], [0, 0, 0]
    omega[axis], gamma[axis], gamma[(axis + 1) % 3] = 2, Fraction(3, 5), Fraction(4, 5)
    closed_orbit = polhode.orbit(polhode.top(moments=moments, omega=omega, gamma=gamma), digits=30)
    a, b, c = (moments[(axis + k) % 3] for k in range(3))
    ratio = (a - b) * (a - c) / (b * c)
    exact = mp.re(mp.sinpi(mp.sqrt(mp.mpf(ratio.numerator) / ratio.denominator)) ** 2)
    assert abs(value(mp, closed_orbit.residue) - exact) < closed_orbit.residue_error < 1e-28
    assert abs(value(mp, closed_orbit.period) / mp.pi - 1) < 1e-30
    assert closed_orbit.kind == ("hyperbolic" if axis == 1 else "elliptic")
    first, second = (mp.mpc(*(value(mp, x) for x in parts)) for parts in closed_orbit.multipliers)
    assert abs(first * second - 1) < 1e-30
    if axis != 1:
        assert abs(abs(first) - 1) < 1e-30
        assert abs(mp.arg(first) - mp.acos(1 - 2 * exact)) < 1e-28
    else:
        root = mp.acosh(1 - 2 * exact)
        assert abs(first / mp.exp(root) - 1) < 1e-28


@pytest.mark.parametrize("residue", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_the_way_back_and_the_residue_by_somebody_elses_integrator(residue):
    """By tests/shared/plain_taylor: the start again; tr M by central differences of 1e-10."""
    closed_orbit = polhode.orbit("general/asymmetric-regular", digits=25)
    body = closed_orbit.scene.body
    start = [*closed_orbit.scene.omega, *gamma_of(closed_orbit.scene, 40)]

    def end(state):
        own = body.moments, body.torque, state[:3], state[3:]
        return plain_taylor.integrate(*own, [closed_orbit.period], 34)[0]

    if not residue:
        off = max(abs(float(a - b)) for a, b in zip(start, end(start), strict=True))
        assert 1e-30 < off < 1e-25
        return
    step, trace = Fraction(1, 10**10), Fraction(0)
    for i in range(6):
        ahead, behind = (
            end([x + side * (k == i) for k, x in enumerate(start)])[i] for side in (step, -step)
        )
        trace += (ahead - behind) / (2 * step)
    assert abs((6 - trace) / 4 - exactly(closed_orbit.residue)) < Fraction(1, 10**17)


@pytest.mark.slow
def test_in_turned_axes_and_in_other_units():
    """The same orbit of the same body: its axes turned; time three times as fast, mass fivefold."""
    rotated = polhode.orbit("grioli/turned-axes", digits=20)
    assert float(rotated.residue) == pytest.approx(0.002448416424848809, rel=1e-14)
    assert float(rotated.period) == pytest.approx(2 * np.pi, rel=1e-15)
    body = GRIOLI.body
    second = polhode.Body.of_moments([5 * x for x in body.moments], body.centre, 45 * body.weight)
    start = polhode.Scene(second, [3 * x for x in GRIOLI.omega], GRIOLI.gamma)
    closed_orbit = polhode.orbit(start, digits=20)
    assert float(closed_orbit.residue) == pytest.approx(0.002448416424848809, rel=1e-14)
    assert float(closed_orbit.period) == pytest.approx(2 * np.pi / 3, rel=1e-15)
    assert closed_orbit.h == 45 * GRIOLI.integrals.energy
    last = polhode.orbit_family(closed_orbit, "h", float(closed_orbit.h) * 1.01).points[-1]
    assert last.h / 45 == pytest.approx(63 / 74 * 1.01, rel=1e-13)
    assert last.f / 15 == pytest.approx(836 / 1369, rel=1e-13)


def test_a_type_that_is_too_narrow_is_left_for_a_wider_one(monkeypatch):
    """The error of the decimals decides, not what was foreseen."""
    narrow = "polhode.dynamics.newton_shooting.type_for"
    monkeypatch.setattr(narrow, lambda digits, least=0: EXTENDED)
    closed_orbit = polhode.orbit(perturbed(1e-3, 0), digits=22)
    assert 1e-26 < closed_orbit.error < 1e-22
    monkeypatch.setattr("polhode.dynamics.newton_shooting.MOST_TYPES", 1)
    with pytest.raises(polhode.BadInput, match="not below 1e-22"):
        polhode.orbit(perturbed(1e-3, 0), digits=22)


def test_a_start_on_the_orbit_is_returned_as_it_is_and_the_period_is_the_shortest():
    closed_orbit = polhode.orbit(GRIOLI, period="18.85")  # three periods
    assert float(closed_orbit.period) == pytest.approx(2 * np.pi, rel=1e-15)
    assert closed_orbit.scene.omega == GRIOLI.omega
    assert closed_orbit.scene.gamma[1] == 0
    with pytest.raises(polhode.BadInput, match="save: path = 5: expected the path of a file"):
        closed_orbit.save(5)


@pytest.mark.slow
def test_the_scene_that_is_written_is_the_orbit(tmp_path, capsys):
    path = tmp_path / "orbit.toml"
    command = ["orbit", "grioli/precession", "--digits", "30"]
    command += ["-o", str(path)]
    assert main(command) == main(command) == 0  # its own kind is replaced
    output = capsys.readouterr()
    assert "period      6.283185307179586476925286766559\n" in output.out
    assert "the motion in space closes after 1 period" in output.out
    scene = polhode.load(path)
    run = polhode.integrate(scene.at([scene.end]), mp(36), project=False)
    off = max(
        abs(exactly(a) - b)
        for a, b in zip(run.states[0], [*scene.omega, *gamma_of(scene, 60)], strict=True)
    )
    assert 1e-36 < off < 1e-30
    assert main(["orbit", str(path), "--json"]) == 0


def test_an_orbit_far_from_the_start_is_not_the_one_asked_for():
    """A return that missed by 1e-9 has its orbit there, not a thousandth away."""
    near = perturbed(1e-3, 0)
    on = LevelBody(near, *near.integrals[:2])
    start = np.array([float(x) for x in on.exact_start])
    time = 2 * np.pi / float(on.unit)
    with pytest.raises(polhode.BadInput, match=r"it led 0\.00.* away from the start"):
        orbit._first(on, start, [Return(time, 1e-9)])
    assert orbit._first(on, start, [Return(time, 1e-3)]).residue > 0


def test_a_motion_that_does_not_come_near_itself(monkeypatch):
    monkeypatch.setattr("polhode.dynamics.orbit.FARTHEST", 30.0)  # it falls again later on
    with pytest.raises(polhode.BadInput, match="near which the motion returns: up to t = "):
        polhode.orbit("pendulum/separatrix")


def test_digits_are_measured_from_the_decimals_that_are_written():
    """A start that is wrong in its 12th digit is told to be."""
    on = LevelBody(GRIOLI, *GRIOLI.integrals[:2])
    x = np.array([float(v) for v in on.exact_start])
    result = newton_shooting.closed(on, x, 2 * np.pi / float(on.unit), at_level(on, x))
    fine = newton_shooting.refined(on, result, 20, on.exact_start)
    rows = at_level(on, result.state)(result.state, result.period)[1]
    matrix = bordered(on, result.state, result.state, result.monodromy, rows)
    chord = newton_shooting.Chord(
        on, result.state, on.exact_start, newton_shooting.inverse_of(matrix)
    )
    wrong = [*fine.state]
    wrong[0] += Fraction(1, 10**12)
    text = newton_shooting._written(chord, wrong, fine.time, fine.number, 20, 1)
    assert 0.1e-12 < text.error < 10e-12
    assert fine.error < 1e-21


@pytest.mark.slow
def test_the_advance_of_psi_is_told_as_far_as_it_is_known():
    """Of few digits it was printed to as many places, and was nearly always called closed."""
    search = polhode.orbit_search("general/asymmetric-chaotic", (12, 12), 2)
    for k in (1, 3):
        few, many = (search.orbit(k, digits) for digits in (5, 20))
        off = abs(float(few.psi) - float(many.psi))
        assert few.psi_error / 1e3 < off < few.psi_error < 1e-3
        line = str(few).splitlines()[-1]
        text = line.split()[1]
        assert abs(float(text) - float(many.psi)) < 1.5 * 10.0 ** -len(text.partition(".")[2])
        assert few.turns is None
        assert "too few digits to tell whether" in line


# -- Families of periodic orbits and the search of a level -----------------------------------------

#: Where Grioli's family turns in h at his f, by this program: the tests say how it is one.
FOLD = 0.74971327932623


@pytest.fixture(scope="module")
def family():
    """Grioli's orbit towards smaller h, through a branch point and a fold, and back."""
    return polhode.orbit_family("grioli/precession", "h", "0.7", points=60)


@pytest.mark.slow
def test_a_family_passes_its_fold(family):
    assert family.ended == "came back to h = 63/74"
    assert [mark.what for mark in family.bifurcations] == ["branch point", "fold"]
    fold = family.bifurcations[-1].point
    assert fold.h == min(fold.h, *(point.h for point in family.points))
    assert abs(fold.residue) < 1e-11
    assert fold.h == pytest.approx(FOLD, abs=1e-12)
    for point in family.points:
        assert point.f == pytest.approx(836 / 1369, rel=1e-13)
        assert point.h >= fold.h
    first, last = family.points[0], family.points[-1]
    assert first.h == pytest.approx(last.h, rel=1e-14)
    assert abs(first.period - last.period) > 0.1  # another orbit of the same level


@pytest.mark.slow
def test_two_orbits_on_this_side_of_a_fold_and_none_on_the_other(family):
    fold = family.bifurcations[-1]
    above = family.points[fold.after - 1], family.points[fold.after]
    assert above[0].residue * above[1].residue < 0
    assert {point.kind for point in above} == {"elliptic", "hyperbolic"}
    near = family.orbit(fold.after, digits=20)
    assert near.kind == above[1].kind
    assert float(near.residue) == pytest.approx(above[1].residue, rel=1e-9)
    with pytest.raises(polhode.BadInput, match="start nearer to a periodic orbit"):
        polhode.orbit(near.scene, h=FOLD - 0.001, period=near.period)


@pytest.mark.slow
def test_rotations_of_a_free_body_are_a_family_with_one_residue():
    """T = 2 pi/w with h = A w^2/2 at every point; R = sin^2(pi sqrt((A-B)(A-C)/(BC)))."""
    spun = polhode.top(moments=[2, 1.5, 1], omega=[1, 0, 0], gamma=["4/5", "3/5", 0])
    family = polhode.orbit_family(spun, "h", 3)
    exact = math.sin(math.pi * math.sqrt(1 / 3)) ** 2
    assert len(family.points) > 5
    for point in family.points:
        assert point.period == pytest.approx(2 * math.pi / math.sqrt(point.h), rel=1e-12)
        assert point.residue == pytest.approx(exact, abs=1e-12)
    assert family.points[-1].h == pytest.approx(3, rel=1e-15)
    assert not family.bifurcations


def test_a_period_doubles_where_the_residue_passes_one():
    """Beside it there is an orbit of twice the period, of a residue near zero."""
    family = polhode.orbit_family("grioli/precession", "h", "1.19")
    assert [point.what for point in family.bifurcations] == ["period doubling"]
    first = family.bifurcations[0].point
    assert first.residue == pytest.approx(1, abs=1e-11)
    assert family.points[-1].kind == "inverse hyperbolic"
    # at R = 1 + d, the same orbit taken twice has R2 = 4 R (1 - R) = -4 d + ...
    last = family.points[-1]
    twice = 4 * last.residue * (1 - last.residue)
    matrix = family.members[-1].orbit.monodromy
    assert (6 - np.trace(matrix @ matrix)) / 4 == pytest.approx(twice, rel=1e-9)


def test_along_f_too():
    family = polhode.orbit_family("grioli/precession", "f", "0.66", points=20)
    assert family.by == "f"
    assert "fold" in [point.what for point in family.bifurcations]
    assert {round(point.h, 12) for point in family.points} == {round(63 / 74, 12)}


def test_ctrl_c_keeps_what_is_done():
    def stop(text):
        if text.startswith("4 orbits"):
            raise KeyboardInterrupt

    family = polhode.orbit_family("grioli/precession", "h", "0.7", progress=stop)
    assert family.interrupted
    assert not family.complete
    assert len(family.points) == 4
    assert family.orbit(3).kind == "elliptic"


def test_a_search_finds_orbits_that_close(monkeypatch):
    search = polhode.orbit_search("general/asymmetric-regular", (10, 10), crossings=2)
    assert len(search.orbits) >= 5
    scene = search.scene
    for point in search.orbits:
        assert point.h == pytest.approx(float(scene.integrals.energy), rel=1e-13)
        there = polhode.Scene(
            scene.body, point.state[:3], point.state[3:], times=(point.period,), normalise=True
        )
        run = polhode.integrate(there)
        assert np.max(np.abs(run.states[0] - point.state)) < 1e-10
    pairs = {(round(point.period, 8), round(point.residue, 8)) for point in search.orbits}
    assert len(pairs) == len(search.orbits)  # of this body no two are alike
    kinds = {point.kind for point in search.orbits}
    assert kinds == {"elliptic", "hyperbolic"}  # islands have both (Poincare, Birkhoff)
    with pytest.raises(polhode.BadInput, match=r"digits = 20\.5: .*, 1 to 300"):
        search.orbit(0, digits=20.5)


def test_a_family_that_cannot_be_followed_ends_with_code_3(monkeypatch, capsys):
    def lost(*_):
        raise newton_shooting.NotClosed("no step is short enough")

    monkeypatch.setattr(newton_shooting, "stepped", lost)
    assert main(["family", "grioli/precession", "--by", "h", "--to", "0.9"]) == 3
    assert "not followed beyond h = 0.851351" in capsys.readouterr().err


@pytest.mark.slow
def test_a_point_given_as_a_start_is_told_which_call_makes_an_orbit_of_it():
    family = polhode.orbit_family("grioli/precession", "h", "0.76")
    for call in (polhode.orbit, lambda x: polhode.orbit_family(x, "h", 1), polhode.integrate):
        with pytest.raises(polhode.BadInput) as refusal:
            call(family.points[0])
        assert "the orbit of point k of a family or a search is" in str(refusal.value)
        assert "\n" not in str(refusal.value)
    first = polhode.orbit_family(family.orbit(0), "h", "0.752")
    assert first.points[0].period == pytest.approx(family.points[0].period, rel=1e-12)


def test_a_result_given_as_a_scene_is_told_what_was_meant():
    run = polhode.integrate("euler/sphere", at=[1])
    with pytest.raises(polhode.BadInput, match=r"did you mean its \.scene\?"):
        polhode.integrate(run)

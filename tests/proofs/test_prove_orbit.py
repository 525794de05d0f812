"""Proved periodic orbits: the truth is inside, what is false is refused, faults never prove it."""

from __future__ import annotations

import json
import random
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from mpmath import MPContext

import polhode
from polhode.cli import main
from polhode.dynamics.periodic_orbits.level_set import Surface
from polhode.enclosures.fixed_point_problem import Refused
from polhode.enclosures.proof_loop import SHORT_STEPS
from polhode.proofs import krawczyk, least_period, orbit_candidate, periodic_orbit, prove_orbit
from polhode.proofs.refusals import NotContracted, Unproved
from shared import enclosure_faults, orbit_newton
from shared import orbit_proofs as proofs
from shared.mutation import without

MP = MPContext()
MP.dps = 70


def truth_of(found):
    """The orbit beside a proved candidate, by Newton's method in plain mpmath."""
    made = found.candidate
    point = [Fraction(x, 1 << (made.noise + 12)) for x in made.start]
    near = [proofs.middle_of(x) for x in found.theorem.start]
    plane = [Fraction(x) for x in made.a.tolist()], point
    return orbit_newton.corrected(
        proofs.MOMENTS,
        proofs.TORQUE,
        [proofs.H, proofs.F, Fraction(1)],
        near,
        proofs.middle_of(found.theorem.period),
        plane,
    )


def ratio(ball, truth):
    """|truth - middle| over the radius."""
    return float(abs(truth - proofs.middle_of(ball)) / proofs.middle_of(ball.rad()))


EXAMPLES = {
    "elliptic": (proofs.ELLIPTIC, "3.22190206296088781308", "0.5401858"),
    "hyperbolic": (proofs.HYPERBOLIC, "4.26575102284615062779", "-1.0298137"),
    "inverse hyperbolic": (proofs.INVERSE, "5.62511669631810373081", "1.135290"),
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", EXAMPLES)
def test_the_orbit_lies_in_its_balls(kind):
    point, period, residue = EXAMPLES[kind]
    found = proofs.proved(point)
    theorem, truth = found.theorem, truth_of(found)
    assert theorem.kind == kind
    assert theorem.open == ()
    # about 1e-20 as printed, the residue to seven figures
    assert abs(Fraction(period) - truth.period) < Fraction(1, 10**20)
    assert abs(Fraction(residue) - truth.residue) < Fraction(1, 10**6)
    ratios = [ratio(x, y) for x, y in zip(theorem.start, truth.start, strict=True)]
    ratios += [ratio(theorem.period, truth.period), ratio(theorem.residue, truth.residue)]
    assert max(ratios) <= 1
    assert max(ratios) > 1e-8  # and the balls are not slack


@pytest.mark.slow
def test_the_orbits_of_a_search_lie_in_their_balls():
    found = polhode.orbit_search(proofs.BODY, (20, 20), 3, proofs.H, proofs.F)
    points = [(*one.state.tolist(), float(one.period)) for one in found.closed if one.period < 12]
    kinds, ratios = set(), []
    for point in points:
        one = proofs.proved(point)
        truth = truth_of(one)
        kinds.add(one.theorem.kind)
        ratios += [ratio(x, y) for x, y in zip(one.theorem.start, truth.start, strict=True)]
        ratios.append(ratio(one.theorem.period, truth.period))
        assert ratio(one.theorem.residue, truth.residue) <= 1
    assert len(points) >= 10
    assert kinds == {"elliptic", "hyperbolic", "inverse hyperbolic"}
    assert max(ratios) <= 1
    assert float(np.median(ratios)) > 1e-6


def test_griolis_period_is_two_pi():
    found = polhode.prove_orbit("grioli/precession", digits=50)
    off = abs(MP.mpf(found.period.centre.numerator) / found.period.centre.denominator - 2 * MP.pi)
    assert off <= found.period.radius < 1e-50


@pytest.mark.slow
def test_a_scene_in_turned_axes_and_irrational_data_has_the_same_orbit():
    plain = polhode.prove_orbit("grioli/precession")
    turned = polhode.prove_orbit("grioli/turned-axes")
    apart = abs(plain.period.centre - turned.period.centre)
    assert apart <= plain.period.radius + turned.period.radius
    size = sum(x.centre**2 for x in turned.gamma)
    assert abs(size - 1) < 1e-30


def test_the_front_door_names_level_kind_and_what_is_alone():
    orbit = polhode.orbit("general/asymmetric-regular")
    found = polhode.prove_orbit("general/asymmetric-regular", orbit)
    assert (found.h, found.f) == (Fraction(26, 5), Fraction(69, 25))
    assert found.kind == orbit.kind == "elliptic"
    assert abs(found.period.centre - orbit.period) < 1e-14
    (real, side), (same, below) = found.multipliers
    assert real == same
    assert side.centre == -below.centre
    assert abs(float(real) ** 2 + float(side) ** 2 - 1) < 1e-8
    assert 0 < found.unique_within.gamma < 2.0**-85
    assert 0 < found.unique_within.period <= 4 * 2.0**-85
    assert "exactly one periodic orbit" in str(found)


def test_a_candidate_that_is_right_is_proved_in_one_run():
    made = proofs.sharp(proofs.ELLIPTIC)
    theorem = periodic_orbit.prove(proofs.level(), made, proofs.FOLLOW)
    assert theorem.kind == "elliptic"
    assert max(map(float, theorem.contraction.ratios)) < 0.1


OFF = Fraction(1, 10**20)


@pytest.mark.parametrize("component", range(7))
def test_a_start_or_a_period_off_by_1e_20_is_refused(component):
    made = proofs.moved(proofs.sharp(proofs.ELLIPTIC), component, OFF)
    with pytest.raises(NotContracted, match="by a factor"):
        periodic_orbit.prove(proofs.level(), made, proofs.FOLLOW)


@pytest.mark.parametrize("what", ["h", "f", "moment", "centre"])
def test_a_level_or_a_body_off_by_1e_20_is_refused(what):
    h, f, moments, torque = proofs.H, proofs.F, list(proofs.MOMENTS), list(proofs.TORQUE)
    if what == "h":
        h += OFF
    elif what == "f":
        f += OFF
    elif what == "moment":
        moments[1] += OFF
    else:
        torque[2] += OFF
    body = polhode.top(
        moments=moments, centre=torque, weight=1, omega=[0, 0, 1], gamma=["3/5", 0, "4/5"]
    )
    made = proofs.sharp(proofs.ELLIPTIC)
    with pytest.raises(NotContracted):
        periodic_orbit.prove(proofs.level(h, f, body), made, proofs.FOLLOW)
    wide = replace(made, bits=50)  # a box in which there is an orbit of that level
    theorem = periodic_orbit.prove(proofs.level(h, f, body), wide, proofs.FOLLOW)
    assert theorem.kind == "elliptic"


@pytest.mark.slow
def test_many_digits_are_proved_by_and_by():
    found = polhode.prove_orbit("grioli/precession", digits=200)
    mp = MPContext()
    mp.dps = 220
    off = abs(mp.mpf(found.period.centre.numerator) / found.period.centre.denominator - 2 * mp.pi)
    assert off <= found.period.radius < mp.mpf(10) ** -199


def test_half_the_period_is_refused():
    point = [*proofs.ELLIPTIC[:6], proofs.ELLIPTIC[6] / 2]
    with pytest.raises(Unproved, match="no periodic orbit is near"):
        proofs.proved(point)


def test_twice_the_period_is_told_with_the_least_one(tmp_path, capsys):
    orbit = polhode.orbit("grioli/precession")
    *head, end = polhode.as_toml(orbit.scene).splitlines()[:-1]
    assert end == "end = 6.2831853071795865"
    path = tmp_path / "twice.toml"
    path.write_text("\n".join([*head, "end = 12.566370614359173"]))
    with pytest.raises(polhode.NotProved, match=r"the period is 2 times the least one, 6\.2831853"):
        polhode.prove_orbit("grioli/precession", path)
    assert main(["prove", "orbit", "grioli/precession", "--orbit", str(path)]) == 3
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.count("\n") == 1
    assert "2 times the least one" in told.err
    assert list(tmp_path.iterdir()) == [path]


#: On a resonant torus of Kovalevskaya's and of Lagrange's top, as searches found them.
TORI = {
    "kovalevskaya/generic": (
        *(-0.09356027906795326, -0.8088610393017476, -1.7698828995014064),
        *(-0.8942524456933294, -0.3119512609933422, -0.32093453247689424),
        11.923560586069057,
    ),
    "lagrange/nutation": (
        *(0.3057968418058629, 0.792249993748683, -0.07197004546693597),
        *(0.19965454798580418, 0.30923023702957153, -0.929792838203876),
        2.0047658025660637,
    ),
}


@pytest.mark.parametrize("case", TORI)
def test_an_orbit_of_a_resonant_torus_is_refused(case):
    scene = polhode.load(case)
    own = scene.integrals
    on = Surface(scene, own.energy, own.area)
    *state, period = (Fraction(x) for x in TORI[case])
    guess = (*(w / on.unit for w in state[:3]), *state[3:])
    with pytest.raises(polhode.NotProved, match="not isolated"):
        prove_orbit.proved(on, (guess, period), 30)


def corrupted(made):
    """Candidates of which an untrusted part is wrong, by what."""
    w, a = made.w, made.a
    yield "C = 0", replace(made, inverse=lambda m: 0 * m)
    yield "-C", replace(made, inverse=lambda m: -np.linalg.inv(m))
    yield (
        "a row of C",
        replace(made, inverse=lambda m: np.diag([0.0] + [1.0] * 9) @ np.linalg.inv(m)),
    )
    yield "nan in C", replace(made, inverse=lambda m: np.full_like(m, np.nan))
    yield "C of another shape", replace(made, inverse=lambda m: np.eye(9))
    yield "C = 2 C", replace(made, inverse=lambda m: 2.1 * np.linalg.inv(m))
    yield "two columns of W alike", replace(made, w=w[:, [0, 0, 2]])
    yield "W = 0", replace(made, w=0 * w)
    yield "nan in W", replace(made, w=w * np.nan)
    yield "a = 0", replace(made, a=0 * a)
    yield "nan in a", replace(made, a=a * np.nan)
    across = np.array([a[1], -a[0], 0, 0, 0, 0])
    yield "a across the field", replace(made, a=across)
    yield "a box too small", replace(made, bits=126)
    yield "a box too large", replace(made, bits=2)
    yield "a large box", replace(made, bits=12)


@pytest.mark.parametrize("what", [name for name, _ in corrupted(proofs.sharp(proofs.ELLIPTIC))])
def test_a_corrupted_candidate_is_refused(what):
    made = dict(corrupted(proofs.sharp(proofs.ELLIPTIC)))[what]
    with pytest.raises(Refused):
        periodic_orbit.prove(proofs.level(), made, proofs.FOLLOW)


def open_motion():
    """Of a motion that does not close W's first column leads from the end back to the start."""
    made = replace(proofs.sharp(proofs.ELLIPTIC), bits=40)
    start = [Fraction(x, 1 << 122) for x in made.start]
    period = Fraction(made.period, 1 << 122) * 3 / 4
    end = orbit_newton.flow(proofs.MOMENTS, proofs.TORQUE, start, period)
    assert max(abs(x - y) for x, y in zip(start, end, strict=True)) > 0.2
    w = made.w.copy()
    w[:, 0] = [float((x - y) * 2**39) for x, y in zip(end, start, strict=True)]
    return replace(made, period=round(period * 2**122), w=w)


def test_a_motion_that_does_not_close_is_refused_by_the_determinant_alone():
    with pytest.raises(Unproved, match="gradients of h, f"):
        periodic_orbit.prove(proofs.level(), open_motion(), proofs.FOLLOW)


def doubled():
    made = proofs.sharp(proofs.ELLIPTIC)
    return replace(made, period=2 * made.period)


def test_a_doubled_period_is_left_open():
    theorem = periodic_orbit.prove(proofs.level(), doubled(), proofs.FOLLOW)
    assert theorem.open == (2,)
    # what was not looked at is open as well
    unasked = replace(doubled(), parts=(2,))
    assert periodic_orbit.prove(proofs.level(), unasked, proofs.FOLLOW).open == (2, 3)


#: A condition, the candidate that it refuses, and how it is dropped.
CONDITIONS = {
    "K inside Y": (
        lambda: proofs.moved(proofs.sharp(proofs.ELLIPTIC), 1, OFF),
        (krawczyk, "contraction", "bool(most < radii[i])", "True"),
    ),
    "C F(y*)": (
        lambda: proofs.moved(proofs.sharp(proofs.ELLIPTIC), 1, OFF),
        (krawczyk, "contraction", "found = -newton[i] +", "found ="),
    ),
    "H(x*) - c": (
        lambda: replace(proofs.sharp(proofs.ELLIPTIC), noise=110),
        (periodic_orbit, "_tested", "value += [x - c for", "value += [x - x for"),
    ),
    "I - C DF(Y)": (
        lambda: dict(corrupted(proofs.sharp(proofs.ELLIPTIC)))["C = 0"],
        (krawczyk, "contraction", "+ arb(0, 1) * size.abs_upper()", "+ 0"),
    ),
    "the determinant": (
        open_motion,
        (periodic_orbit, "_independent", "if not abs(determinant) > 0:", "if False:"),
    ),
    "shorter periods": (
        doubled,
        (least_period, "undecided", "reached, strict=True)):", "reached, strict=True)) and False:"),
    ),
    "the steepness": (
        doubled,
        (least_period, "undecided", "* steepness /", "* 0 /"),
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("condition", CONDITIONS)
def test_what_a_condition_refuses_passes_without_it(condition):
    made, change = CONDITIONS[condition]
    level = proofs.level(h=proofs.H + OFF) if condition == "H(x*) - c" else proofs.level()
    candidate = made()
    with without(*change):
        theorem = periodic_orbit.prove(level, candidate, proofs.FOLLOW)
    assert theorem.open == ()


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # of guesses that are made wrong
@pytest.mark.sample(3)
@pytest.mark.parametrize("seed", range(40))
def test_faults_in_the_enclosures_untrusted_parts_prove_nothing_false(seed):
    rng = random.Random(seed)
    name, fault = enclosure_faults.random_fault(rng)
    if not name.startswith("window"):
        fault = replace(fault, window=SHORT_STEPS.window)
    kind = rng.choice(["elliptic", "hyperbolic"])
    try:
        point = [Fraction(x) for x in EXAMPLES[kind][0]]
        found = orbit_candidate.corrected(proofs.level(), point, 30, (2, 3, 5), fault)
    except Refused:
        return
    truth = truth_of(found)
    assert found.theorem.kind == kind
    for ball, x in zip(found.theorem.start, truth.start, strict=True):
        assert ratio(ball, x) <= 1, name
    assert ratio(found.theorem.period, truth.period) <= 1, name
    assert ratio(found.theorem.residue, truth.residue) <= 1, name


def test_the_verb_prints_the_theorem(capsys):
    assert main(["prove", "orbit", "grioli/precession"]) == 0
    told = capsys.readouterr()
    assert told.out.startswith("period      6.2831853071795864769252867665590")
    assert "proved: on the level h = 63/74, f = 836/1369 exactly one" in told.out
    assert "every digit is proven" in told.err


def test_orbit_prove_adds_one_line_and_one_field(capsys):
    assert main(["orbit", "grioli/precession"]) == 0
    plain = capsys.readouterr().out
    assert main(["orbit", "grioli/precession", "--prove"]) == 0
    told = capsys.readouterr().out
    assert told.startswith(plain)
    (line,) = told[len(plain) :].splitlines()
    assert line.startswith("proof       proved: on the level h = 63/74")


def test_a_refused_proof_leaves_nothing(tmp_path, capsys):
    path = tmp_path / "orbit.toml"
    asked = ["euler/largest-axis", "--prove", "-o", str(path)]
    assert main(["orbit", *asked]) == 3
    told = capsys.readouterr()
    assert not path.exists()
    assert told.out == ""
    assert told.err.count("\n") == 1
    assert "not isolated" in told.err


@pytest.mark.parametrize(
    ("arguments", "key"),
    [
        (["--digits", "201"], "digits"),
        (["--pick", "2"], "--pick"),
        (["--period", "6", "--search"], "--search"),
        (["--orbit", "nowhere.toml"], "nowhere.toml"),
        (["--period", "-1"], "period"),
        (["--period", "1e400"], "period"),
        (["--h", "x"], "h"),
    ],
)
def test_bad_input_is_one_line(arguments, key, capsys):
    assert main(["prove", "orbit", "grioli/precession", *arguments]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.count("\n") == 1
    assert key in told.err


def test_a_search_is_proved_orbit_by_orbit(capsys):
    asked = ["general/asymmetric-regular", "--search", "8x8", "--returns", "1", "--json"]
    assert main(["prove", "orbit", *asked]) == 0
    told = json.loads(capsys.readouterr().out)
    assert len(told["proofs"]) == len(told["orbits"]) == 3
    for orbit, proof in zip(told["orbits"], told["proofs"], strict=True):
        assert proof["proved"]
        assert abs(float(proof["period"]) - orbit["period"]) < 1e-12
        assert proof["kind"] == orbit["kind"]
        assert abs(float(proof["residue"]) - orbit["residue"]) < 1e-6

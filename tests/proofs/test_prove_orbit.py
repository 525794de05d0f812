"""Proved periodic orbits: the truth is inside, what is false is refused, faults never prove it."""

from __future__ import annotations

import json
import random
from dataclasses import replace
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from flint import arb
from mpmath import MPContext

import polhode
from polhode import BadInput, NotProved
from polhode.certificates import verify
from polhode.cli import main
from polhode.enclosures.fixed_point_problem import Refused
from polhode.enclosures.proof_loop import SHORT_STEPS
from polhode.proofs import (
    body_tolerance,
    krawczyk,
    least_period,
    orbit_candidate,
    periodic_orbit,
    prove_orbit,
)
from polhode.proofs.refusals import NotContracted, Unproved
from shared import enclosure_faults, orbit_newton
from shared import orbit_proofs as proofs
from shared.mutation import without

BODY = proofs.MOMENTS, proofs.TORQUE


@cache
def closed(kind):
    """An orbit by Newton's method in plain mpmath, near its proof."""
    found = proofs.proved(EXAMPLES[kind][0])
    near = [proofs.middle_of(x) for x in found.theorem.start]
    level = [proofs.H, proofs.F, Fraction(1)]
    period = proofs.middle_of(found.theorem.period)
    return orbit_newton.corrected(*BODY, level, near, period, plane_of(found))


def plane_of(found):
    made = found.candidate
    return [Fraction(x) for x in made.a.tolist()], [
        Fraction(x, 1 << (made.noise + 12)) for x in made.start
    ]


def truth_of(found, kind):
    """The same, where it meets the plane of a candidate."""
    truth = closed(kind)
    a, point = plane_of(found)
    x = truth.start
    for _ in range(2):
        along = sum(c * v for c, v in zip(a, orbit_newton.rates(*BODY, x), strict=True))
        off = sum(c * (p - y) for c, p, y in zip(a, point, x, strict=True))
        x = orbit_newton.flow(*BODY, x, off / along)
    return truth._replace(start=x)


def ratios(found, kind):
    """|truth - middle|/radius of the start, the period and the residue."""
    theorem, truth = found.theorem, truth_of(found, kind)
    pairs = [*zip(theorem.start, truth.start, strict=True)]
    pairs += [(theorem.period, truth.period), (theorem.residue, truth.residue)]
    return [ratio(*pair) for pair in pairs]


def ratio(ball, truth):
    """|truth - middle| over the radius."""
    return float(abs(truth - proofs.middle_of(ball)) / proofs.middle_of(ball.rad()))


EXAMPLES = {
    "elliptic": (proofs.ELLIPTIC, "3.22190206296088781308", "0.5401858"),
    "hyperbolic": (proofs.HYPERBOLIC, "4.26575102284615062779", "-1.0298137"),
    "inverse hyperbolic": (proofs.INVERSE, "5.62511669631810373081", "1.135290"),
}


@pytest.mark.slow
@pytest.mark.sample(2, first=1, rest="campaign")
@pytest.mark.parametrize("kind", EXAMPLES)
def test_the_orbit_lies_in_its_balls(kind):
    point, period, residue = EXAMPLES[kind]
    found = proofs.proved(point)
    truth = closed(kind)
    assert found.theorem.kind == kind
    assert found.theorem.open == ()
    # about 1e-20 as printed, the residue to seven figures
    assert abs(Fraction(period) - truth.period) < Fraction(1, 10**20)
    assert abs(Fraction(residue) - truth.residue) < Fraction(1, 10**6)
    assert 1e-8 < max(ratios(found, kind)) <= 1  # and the balls are not slack


@pytest.mark.parametrize("digits", [50, pytest.param(110, marks=pytest.mark.slow)])
def test_griolis_period_is_two_pi(digits):
    found = polhode.prove_orbit("grioli/precession", digits=digits)
    mp = MPContext()
    mp.dps = 220
    off = abs(mp.mpf(found.period.centre.numerator) / found.period.centre.denominator - 2 * mp.pi)
    assert off <= found.period.radius < mp.mpf(10) ** (1 - digits)


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


OFF = Fraction(1, 10**20)


def test_another_unit_of_time_scales_the_orbit_and_how_far_it_is_alone():
    p, q, r, *gamma, period = map(Fraction, proofs.ELLIPTIC)
    found = []
    for rate in (1, 2):
        scene = polhode.top(
            moments=proofs.MOMENTS,
            centre=proofs.TORQUE,
            weight=rate**2,
            omega=[rate * x for x in (p, q, r)],
            gamma=gamma,
            normalise=True,
            end=period / rate,
        )
        found.append(polhode.prove_orbit(scene, scene, h=rate**2 * proofs.H, f=rate * proofs.F))
    one, two = found
    assert two.kind == one.kind
    assert two.period.centre == pytest.approx(one.period.centre / 2)
    omega, gamma, period = one.unique_within
    expected = [2 * omega, gamma, period / 2]
    assert [*two.unique_within] == pytest.approx(expected, rel=1e-6, abs=0.0)


@pytest.mark.parametrize("what", [*range(7), "h", "f", "moment", "centre"])
def test_a_candidate_a_level_or_a_body_off_by_1e_20_is_refused(what):
    h, f, moments, torque = proofs.H, proofs.F, list(proofs.MOMENTS), list(proofs.TORQUE)
    h, f = h + OFF * (what == "h"), f + OFF * (what == "f")
    moments[1] += OFF * (what == "moment")
    torque[2] += OFF * (what == "centre")
    body = polhode.top(
        moments=moments, centre=torque, weight=1, omega=[0, 0, 1], gamma=["3/5", 0, "4/5"]
    )
    made = proofs.sharp(proofs.ELLIPTIC)
    if isinstance(what, int):
        made = proofs.moved(made, what, OFF)
    with pytest.raises(NotContracted, match="by a factor"):
        periodic_orbit.prove(proofs.level(h, f, body), made, proofs.FOLLOW)
    if not isinstance(what, int):  # in a wide box there is an orbit of that level
        wide = replace(made, bits=50)
        theorem = periodic_orbit.prove(proofs.level(h, f, body), wide, proofs.FOLLOW)
        assert theorem.kind == "elliptic"


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
    with pytest.raises(NotProved, match=r"the period is 2 times the least one, 6\.2831853"):
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
    p, q, r, *gamma, period = TORI[case]
    omega = [w / 2.0**scene.time_unit for w in (p, q, r)]
    near = polhode.Scene(scene.body, omega, gamma, times=(period,), normalise=True)
    with pytest.raises(NotProved, match="not isolated"):
        polhode.prove_orbit(scene, near)


def corrupted(made):
    """Candidates of which an untrusted part is wrong, by what; and the right one."""
    w, a, inv = made.w, made.a, np.linalg.inv
    wrong = {
        "C = 0": {"inverse": lambda m: 0 * m},
        "-C": {"inverse": lambda m: -inv(m)},
        "a row of C": {"inverse": lambda m: np.diag([0.0] + [1.0] * 9) @ inv(m)},
        "nan in C": {"inverse": lambda m: np.full_like(m, np.nan)},
        "C of another shape": {"inverse": lambda m: np.eye(9)},
        "C = 2 C": {"inverse": lambda m: 2.1 * inv(m)},
        "two columns of W alike": {"w": w[:, [0, 0, 2]]},
        "W = 0": {"w": 0 * w},
        "nan in W": {"w": w * np.nan},
        "a = 0": {"a": 0 * a},
        "nan in a": {"a": a * np.nan},
        "a across the field": {"a": np.array([a[1], -a[0], 0, 0, 0, 0])},
        "a box too small": {"bits": 126},
        "a box too large": {"bits": 2},
        "a large box": {"bits": 12},
        "nothing": {},
    }
    return {what: replace(made, **changes) for what, changes in wrong.items()}


@pytest.mark.parametrize("what", corrupted(proofs.sharp(proofs.ELLIPTIC)))
def test_a_corrupted_candidate_is_refused(what):
    made = corrupted(proofs.sharp(proofs.ELLIPTIC))[what]
    if what == "nothing":
        theorem = periodic_orbit.prove(proofs.level(), made, proofs.FOLLOW)
        assert theorem.kind == "elliptic"
        assert max(map(float, theorem.contraction.ratios)) < 0.1
        return
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


def test_the_primes_by_which_a_period_is_divided_are_all():
    first = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29]
    assert least_period.primes(arb("30.5")) == first
    assert least_period.primes(arb(29)) == first
    assert verify._primes(30) == first[::-1]


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
        lambda: corrupted(proofs.sharp(proofs.ELLIPTIC))["C = 0"],
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
@pytest.mark.slow
@pytest.mark.sample(6, rest="campaign")
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
    assert found.theorem.kind == kind
    assert max(ratios(found, kind)) <= 1, name


def test_the_verbs_tell_the_theorem(capsys):
    assert main(["prove", "orbit", "grioli/precession"]) == 0
    told = capsys.readouterr()
    assert told.out.startswith("period      6.2831853071795864769252867665590")
    assert "proved: on the level h = 63/74, f = 836/1369 exactly one" in told.out
    assert "every digit is proven" in told.err
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


# -- bodies within a tolerance --------------------------------------------------------------------

CHAOTIC = "general/asymmetric-chaotic"


@pytest.fixture(scope="module")
def near():
    return polhode.orbit_search(CHAOTIC, grid=(8, 8), crossings=2)


@pytest.mark.sample(1)
@pytest.mark.parametrize("k", [0, 1])
def test_periods_and_residues_of_bodies_at_corners_lie_in_the_balls(near, k):
    tolerance = Fraction(1, 10**9)
    wide = prove_orbit.prove_found(near, k, 15, tolerance=tolerance)
    assert "for every body whose moments" in str(wide)
    exact = prove_orbit.prove_found(near, k, 15)
    offs = []
    for corner in ((1, 1, 1, 1, 1, 1), (-1, 1, -1, 1, -1, 1), (1, -1, -1, -1, -1, 1)):
        numbers = [*proofs.MOMENTS, *proofs.TORQUE]
        numbers = [x * (1 + side * tolerance) for x, side in zip(numbers, corner, strict=True)]
        scene = polhode.top(
            moments=numbers[:3],
            centre=numbers[3:],
            weight=1,
            omega=[x.centre for x in exact.omega],
            gamma=[x.centre for x in exact.gamma],
            normalise=True,
            end=exact.period.centre,
        )
        other = polhode.prove_orbit(scene, orbit=scene, digits=15, h=wide.h, f=wide.f)
        assert other.kind == wide.kind
        for x, y in ((other.period, wide.period), (other.residue, wide.residue)):
            offs.append(abs(x.centre - y.centre) / Fraction(y.radius))
    assert 0.001 < max(offs) <= 1


@pytest.mark.slow
def test_a_tolerance_that_is_too_wide_names_one_that_works(near):
    works = r"within 1e-06 \(.*\): the largest power of 10 .* is 1e-09"
    with pytest.raises(NotProved, match=works):
        prove_orbit.prove_found(near, 1, 15, tolerance=Fraction(1, 10**6))


def test_no_certificate_tells_of_many_bodies(near, tmp_path, refusal, monkeypatch):
    """And the theorem is that of all bodies that are told."""
    tolerance, proved = Fraction(1, 10**8), []
    prove = body_tolerance.prove
    monkeypatch.setattr(
        body_tolerance, "prove", lambda on, *rest: proved.append(on) or prove(on, *rest)
    )
    wide = prove_orbit.prove_found(near, 0, 15, tolerance=tolerance)
    assert {on.motion.tolerance for on in proved} == {wide.tolerance} == {tolerance}
    with pytest.raises(BadInput, match="one body"):
        wide.save(tmp_path / "orbit.json")
    asked = ("prove", "orbit", CHAOTIC, "--tolerance", "1e-9", "-o", "orbit.json")
    assert "one body" in refusal(*asked)

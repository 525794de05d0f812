"""polhode.certify: what is asked, what is answered, and only as many digits as are proven."""

from __future__ import annotations

import random
import time
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from typing import Any

import pytest

import polhode
from polhode.enclosures import fixed_point_problem, integral_contraction, proof_loop
from polhode.enclosures.approximation import precision_choice
from polhode.enclosures.fixed_point_problem import Refused
from polhode.enclosures.result import guaranteed
from polhode.numbers.conversion import exact_number, exactly
from polhode.numbers.exact import Irrational
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene
from shared import enclosure_trials as trials
from shared.motions import ASYMMETRIC, asymmetric


def top(body: Body = ASYMMETRIC, omega: Any = ("0.3", "0.2", 3), gamma: Any = None) -> Scene:
    return Scene(body, omega, gamma or ("0.6", 0, "0.8"))


def _inside(found: Any, rows: Any) -> bool:
    return all(
        abs(exactly(x) - centre) <= Fraction(radius)
        for row, centres, radii in zip(rows, found.centres, found.radii, strict=True)
        for x, centre, radius in zip(row, centres, radii, strict=True)
    )


@pytest.mark.sample(1)
@pytest.mark.parametrize("digits", [8, 15, 30, 60])
def test_the_digits_asked_for_are_proven_and_not_many_more(digits: int) -> None:
    scene = top()
    found = polhode.certify(scene, at=[1, "1/3", 20], digits=digits)
    assert found.reached
    assert found.proven == min(found.digits)
    # at few digits the 60 bits of the first polynomials prove more than the noise level asks
    assert digits <= found.digits[2] <= max(digits + 8, 18)
    assert _inside(found, [trials.truth(scene, [t], 320)[0] for t in found.times])


def test_times_of_both_signs_in_any_order_some_twice_and_irrational() -> None:
    scene = top()
    asked = [3, "-sqrt(2)", 0, "1/3", 3, "sqrt(2)", -5]
    found = polhode.certify(scene, at=asked, digits=20)
    assert found.centres[0] == found.centres[4]
    assert [exact_number(t) == s for t, s in zip(asked, found.times, strict=True)] == [True] * 7
    assert found.radii[2] == pytest.approx(found.radii[2])
    for n, t in enumerate(found.times):
        if n == 2:
            assert _inside(replaced(found, n), [scene.start])
        elif not isinstance(t, Irrational):
            assert _inside(replaced(found, n), trials.truth(scene, [t], 200))
    # a time beside sqrt(2) by 1e-40 has the same 20 digits
    near = Fraction(14142135623730950488016887242096980785697, 10**40)
    beside = polhode.certify(scene, at=[near])
    for x, y, r in zip(beside.centres[0], found.centres[5], found.radii[5], strict=True):
        assert abs(x - y) <= Fraction(r) + Fraction(max(beside.radii[0]))


def replaced(found: Any, n: int) -> Any:
    """The enclosure at one of its times."""
    return replace(found, centres=found.centres[n : n + 1], radii=found.radii[n : n + 1])


def test_a_full_inertia_matrix_gives_balls_in_its_own_axes() -> None:
    inertia = ((2, "1/5", "1/7"), ("1/5", "1.7", "1/10"), ("1/7", "1/10", "1.4"))
    body = Body(inertia, ("0.3", "0.2", "0.5"), 1)
    scene = Scene(body, ("0.3", "0.2", "1.1"), ("0.6", 0, "0.8"))
    found = polhode.certify(scene, at=[2, 10], digits=25)
    assert found.reached
    assert _inside(found, trials.truth(scene, [2, 10], 240))


def test_irrational_data_lie_inside_and_their_rational_neighbours_do_not() -> None:
    def scene(root: Any) -> Scene:
        body = Body.of_moments((root, "1.5", 1), (0, "sqrt(2)/7", "0.3"), 1)
        return Scene(body, ("0.2", "0.1", "pi/3"), ("sqrt(3)/2", 0, "1/2"))

    exactly_root = scene("sqrt(5)/1.6")
    found = polhode.certify(exactly_root, at=[10], digits=30)
    assert found.reached
    assert _inside(found, trials.truth(exactly_root, [10], 240))
    beside = scene(exact_number("sqrt(5)/1.6 + 1/10**28"))
    assert not _inside(found, trials.truth(beside, [10], 240))


def test_a_scene_without_gamma_has_three_components() -> None:
    scene = Scene(Body.of_moments((3, 2, 1)), ("0.4", 1, "0.2"))
    found = polhode.certify(scene, at=[7], digits=20)
    assert len(found.centres[0]) == len(found.midpoints[0]) == 3
    assert _inside(found, trials.truth(scene, [7], 200))


@pytest.mark.parametrize("gamma", [(0, 0, 1), (0, 0, -1)])
def test_a_body_at_rest_stays_and_its_digits_are_of_the_pendulums_rate(gamma: Any) -> None:
    scene = Scene(Body.of_moments((2, 3, 1), (0, 0, 1), 1), (0, 0, 0), gamma)
    found = polhode.certify(scene, at=[5], digits=12)
    assert found.reached
    assert _inside(found, [scene.start])


@pytest.mark.parametrize("power", [-100, 100])
def test_units_of_any_size_cost_no_digit(power: int) -> None:
    scale = Fraction(10) ** power
    scene = asymmetric(rate=scale)
    found = polhode.certify(scene, at=[10 / scale], digits=15)
    plain = polhode.certify(top(), at=[10], digits=15)
    # the proof's unit is a power of two, so that its steps are others, up to twice as long
    assert found.proven == pytest.approx(plain.proven, abs=2.0)
    assert found.noise == pytest.approx(plain.noise, abs=2)


@pytest.mark.slow
def test_chaos_is_answered_and_grows_no_faster_than_its_exponent() -> None:
    scene = top(omega=("0.3", "0.2", "1.1"))
    found = polhode.certify(scene, at=[60, 120], digits=15)
    assert found.reached
    assert found.tries == 1
    assert _inside(found, trials.truth(scene, [60, 120], 260))


@pytest.mark.slow
def test_the_integrals_make_the_radii_smaller_and_keep_the_truth() -> None:
    scene = top()
    motion = fixed_point_problem.motion(scene)
    problem = fixed_point_problem.problem(motion, 90)
    times = [fixed_point_problem.ball(Fraction(1200), 300)]  # t = 300
    known = integral_contraction.prepared(motion, 400)
    with_them = proof_loop.run(problem, times, known).rows[0]
    without = proof_loop.run(problem, times).rows[0]
    gain = max(float(x.rad()) for x in without) / max(float(x.rad()) for x in with_them)
    assert 2.0 < gain < 1000.0


@pytest.mark.parametrize(
    ("moments", "centre", "weight", "names"),
    [
        ((2, "1.5", 1), ("0.3", "0.2", "0.5"), 1, {"h", "f", "|gamma|^2"}),
        ((2, "1.5", 1), (0, 0, 0), 0, {"h", "f", "|gamma|^2", "|G|^2"}),
        ((2, 2, 1), (0, 0, 1), 1, {"h", "f", "|gamma|^2", "r", "w.k"}),
        ((2, 1, 2), (0, -3, 0), 1, {"h", "f", "|gamma|^2", "q", "w.k"}),
        ((2, 2, 1), ("0.6", "0.8", 0), 1, {"h", "f", "|gamma|^2", "K^2, axis 3"}),
        ((1, 2, 2), (0, "0.6", "0.8"), 1, {"h", "f", "|gamma|^2", "K^2, axis 1"}),
        ((2, 2, 1), ("0.6", "0.8", "1e-30"), 1, {"h", "f", "|gamma|^2"}),
        (("2", "2", "1.000000000000000000000001"), (1, 0, 0), 1, {"h", "f", "|gamma|^2"}),
    ],
)
def test_the_integrals_used_are_those_that_hold_exactly(
    moments: Any, centre: Any, weight: Any, names: set[str]
) -> None:
    scene = top(Body.of_moments(moments, centre, weight))
    assert set(integral_contraction.first_integrals(fixed_point_problem.motion(scene))) == names


def test_backward_and_forward_are_the_same_motion() -> None:
    scene = top()
    there = polhode.certify(scene, at=[4], digits=40)
    start = Scene(scene.body, there.centres[0][:3], scene.gamma)
    assert there.reached
    back = polhode.certify(scene, at=[-4], digits=40)
    mirrored = Scene(scene.body, tuple(-w for w in scene.omega), scene.gamma)
    again = polhode.certify(mirrored, at=[4], digits=40)
    for k in range(6):
        sign = -1 if k < 3 else 1
        off = abs(back.centres[0][k] - sign * again.centres[0][k])
        assert off <= Fraction(back.radii[0][k]) + Fraction(again.radii[0][k])
    assert start.body is scene.body


@pytest.mark.parametrize(
    ("centre", "radius", "text"),
    [
        (Fraction(1, 3), 1e-5, "0.3333"),
        (Fraction(-1, 3), 1e-5, "-0.3333"),
        (Fraction(1, 2), 1e-6, "0.50000"),
        (Fraction(0), 1e-7, "0.000000"),
        (Fraction(12345, 10), 0.01, "1234.5"),
        (Fraction(2, 3), 0.6, ""),
        (Fraction(9999999, 10**7), 1e-9, "0.99999990"),
        (Fraction(1, 7), float("inf"), ""),
        (Fraction(8079370361), 20.0, "8.079370e+09"),
        (Fraction(-8079370361) * 10**60, 1e61, "-8.0793704e+69"),
        (Fraction(96), 3.0, "1e+02"),
        (Fraction(1, 3 * 10**40), 1e-45, "3.333e-41"),
        (Fraction(0), 1e9, ""),
        (Fraction(7, 10**6), 1e-9, "0.00000700"),
    ],
)
def test_a_ball_prints_the_digits_that_all_its_numbers_round_to(
    centre: Fraction, radius: float, text: str
) -> None:
    assert guaranteed(centre, radius) == text


def test_printed_digits_are_those_of_every_number_in_the_ball() -> None:
    rng = random.Random(5)
    for _ in range(500):
        size = Fraction(10) ** rng.choice([-60, 0, 0, 60])  # units of any size
        centre = size * Fraction(rng.randrange(-(10**12), 10**12), 10 ** rng.randrange(6, 14))
        radius = float(size) * 10.0 ** rng.uniform(-9, 1)
        text = guaranteed(centre, radius)
        if not text:
            assert radius > abs(centre) / 20
            continue
        unit = Fraction(10) ** Decimal(text).as_tuple().exponent
        for part in (-1, -0.5, 0, 0.3, 1):
            assert abs(centre + Fraction(part) * Fraction(radius) - Fraction(text)) <= unit / 2


#: The start, the times, the outputs, and what of them the rule for "equal" decides.
BY_THE_RULE: list[tuple[Any, list[Any], tuple[str, ...], list[str]]] = [
    (("3/5", 0, "4/5"), [1, 2], ("angles", "attitude"), []),
    ((0, 0, 1), [1], ("angles", "attitude"), []),
    (("sqrt(3)/2", 0, "1/2"), [1], (), []),
    (("sqrt(3)/2", 0, "1/2"), [1], ("attitude",), []),  # the squares of roots are known
    (("sin(1)", 0, "cos(1)"), [1], ("attitude",), ["that gamma has"]),
    # 4096 bits do not tell it from a start at the pole, where phi is another
    (
        ("sqrt(2)*sqrt(3) - sqrt(6) + 1e-1300", 0, 1),
        [1],
        ("angles",),
        ["that gamma has", "whether the start is at a pole"],
    ),
    (("3/5", 0, "4/5"), ["sqrt(2)*sqrt(3)", "sqrt(6)"], (), ["which of the times"]),
]


@pytest.mark.parametrize(("gamma", "at", "outputs", "told"), BY_THE_RULE)
def test_what_the_rule_for_equal_decides_is_told(
    gamma: Any, at: list[Any], outputs: tuple[str, ...], told: list[str]
) -> None:
    found = polhode.certify(replace(top(gamma=gamma), outputs=outputs), at=at, digits=12)
    assert [x.startswith(y) for x, y in zip(found.assumed, told, strict=True)] == [True] * len(told)


def test_a_rational_moment_of_a_full_matrix_is_known_to_be_one() -> None:
    body = Body(((2, "1/2", 0), ("1/2", 2, "1/3"), (0, "1/3", 3)), ("0.3", "0.2", "0.5"), 1)
    twice = Body(((2, "1/2", 0), ("1/2", 2, 0), (0, 0, 3)), ("0.3", "0.2", "0.5"), 1)
    assert twice.moments == (Fraction(3, 2), Fraction(5, 2), 3)
    for one in (body, twice):
        assert polhode.certify(top(one), at=[1], digits=12).assumed == ()


def test_bad_questions_are_refused_in_one_line() -> None:
    scene = top()
    with pytest.raises(polhode.BadInput, match="digits = 0"):
        polhode.certify(scene, at=[1], digits=0)
    with pytest.raises(polhode.BadInput, match="at least one time"):
        polhode.certify(scene)
    with pytest.raises(polhode.BadInput, match="digits = 251"):
        polhode.certify(scene, at=[1], digits=251)


#: What is given, and what is said of it: as of ``integrate`` and ``reference``, but for bounds.
REFUSED = [
    ({"digits": 15.5}, "digits = 15.5: expected a whole number, 1 to 250"),
    ({"digits": True}, "digits = True: expected a whole number, 1 to 250"),
    ({"digits": "20"}, "digits = 20: expected a whole number, 1 to 250"),
    ({"max_steps": 2.5}, "max_steps = 2.5: expected a whole number, 1 or more"),
    ({"max_steps": True}, "max_steps = True: expected a whole number, 1 or more"),
    ({"max_seconds": "1"}, "max_seconds = 1: expected a number above 0"),
    ({"max_seconds": True}, "max_seconds = True: expected a number above 0"),
]


@pytest.mark.parametrize(("given", "told"), REFUSED)
def test_arguments_are_checked_as_everywhere(given: dict[str, Any], told: str) -> None:
    scene = replace(top(), events=(polhode.Event("equator"),))
    with pytest.raises(polhode.BadInput) as refused:
        polhode.certify(scene, at=[1], **given)
    assert str(refused.value) == f"scene: {told}"
    with pytest.raises(polhode.BadInput) as refused:
        polhode.certify_events(scene, end=1, **given)
    assert str(refused.value) == f"scene: {told}"
    if not {"digits", "max_steps"}.isdisjoint(given):
        with pytest.raises(polhode.BadInput) as refused:
            polhode.integrate(scene, at=[1], **given)
        assert str(refused.value) == f"scene: {told.replace('250', '4000')}"


def test_what_follows_the_times_is_given_by_name() -> None:
    for door in (polhode.certify, polhode.certify_events):
        with pytest.raises(TypeError, match="positional"):
            door(top(), [1], 20)  # type: ignore[arg-type, misc]


@pytest.mark.parametrize(
    ("at", "told"),
    [
        (1, "at = 1: expected a list of times"),
        ("12", "at = 12: expected a list of times"),
        ({1, 2}, "at = {1, 2}: expected a list of times"),
        ([1, "x"], "at[2] = x: expected a number (unknown name 'x'; known are sqrt, sin, cos, pi)"),
        ([True], "at[1] = True: expected a number (not a number: True)"),
    ],
)
def test_times_are_read_as_everywhere(at: Any, told: str) -> None:
    scene = top()
    for door in (polhode.certify, polhode.integrate):
        with pytest.raises(polhode.BadInput) as refused:
            door(scene, at=at)
        assert str(refused.value) == f"scene: {told}"
    with pytest.raises(polhode.BadInput) as refused:
        polhode.Certified(scene).at(at)
    assert str(refused.value) == f"scene: {told.replace('at', 't', 1)}"


@pytest.mark.parametrize("end", ["x", [1], True])
def test_an_end_is_read_as_everywhere(end: Any) -> None:
    for door in (polhode.certify_events, polhode.lyapunov):
        with pytest.raises(polhode.BadInput, match=r"^scene: end\[1\] = .*: expected a number \("):
            door(top(), end=end)


def test_a_time_out_of_reach_is_refused_with_a_forecast() -> None:
    with pytest.raises(polhode.BadInput, match="300000 steps reach; this one takes about"):
        polhode.certify(top(), at=[10**10])
    with pytest.raises(polhode.BadInput, match="a time that 10 steps reach"):
        polhode.certify(top(), at=[100], max_steps=10)


def test_times_beside_a_point_of_the_grid_are_on_their_sides() -> None:
    near = Fraction(1, 2**600)
    found = polhode.certify(top(), at=[1 + near, 1, 1 - near], digits=20)
    for x, y, z, r in zip(*found.centres, found.radii[1], strict=True):
        assert abs(x - y) <= 2 * Fraction(r)
        assert abs(z - y) <= 2 * Fraction(r)


def test_a_constant_that_does_not_sharpen_is_refused() -> None:
    from flint import arb

    with pytest.raises(Refused, match="not known sharply"):
        fixed_point_problem.sharp(lambda bits: arb(1, 1e-9), 80)


def test_a_refusal_tells_how_far_the_proof_came_and_the_next_try_goes_by_that() -> None:
    scene = top(omega=("0.3", "0.2", "1.1"))
    motion = fixed_point_problem.motion(scene)
    problem = fixed_point_problem.problem(motion, 60)
    times = fixed_point_problem.times(motion, [Fraction(300)])
    with pytest.raises(Refused, match="too large") as refused:
        proof_loop.run(problem, times, integral_contraction.prepared(motion, 300))
    why = refused.value
    assert 0.3 < why.reached < 1.0
    assert 10 < why.grown < 60
    found = precision_choice.raised(60, 51, why)
    enough = fixed_point_problem.problem(motion, found)
    (row,) = proof_loop.run(enough, times, integral_contraction.prepared(motion, 400)).rows
    assert 1e-22 < max(float(x.rad()) for x in row) < 1e-15
    # nothing is known of the way where it was hardly begun
    assert precision_choice.raised(60, 51, Refused("x", 0.01, 30.0)) == 95
    assert precision_choice.raised(60, 51, Refused("x")) == 95


@pytest.mark.slow
def test_chaos_to_a_thousand_takes_one_try_more_at_most() -> None:
    found = polhode.certify("general/asymmetric-chaotic", at=[1000], digits=16)
    assert found.reached
    assert found.tries <= 2
    assert found.proven < 20


@pytest.mark.slow
def test_first_tries_suffice() -> None:
    rng = random.Random(17)
    tries, spare = [], []
    for n in range(20):
        scene = trials.random_scene(rng, trials.KINDS[n % len(trials.KINDS)])
        digits = rng.choice((12, 16, 24))
        found = polhode.certify(scene, at=[rng.choice((1, 5, 20))], digits=digits)
        tries.append(found.tries)
        spare.append(found.proven - digits)
    assert sum(t == 1 for t in tries) >= 18
    assert sorted(spare)[10] < 4.0


@pytest.mark.campaign
def test_the_radius_follows_the_exponent_of_the_motion_alone() -> None:
    scene = top(omega=("0.3", "0.2", "1.1"))
    found = polhode.certify(scene, at=[300], digits=18)
    assert found.reached
    assert found.noise < 150


@pytest.mark.campaign
def test_a_proof_costs_about_an_uncertified_quad_run() -> None:
    scene = top()
    polhode.certify(scene, at=[1], digits=30)  # compiles
    proofs, runs = [], []
    for _ in range(3):
        began = time.process_time()
        polhode.certify(scene, at=[200], digits=30)
        middle = time.process_time()
        polhode.integrate(scene.at((200,)), "quad", project=False, method="taylor")
        proofs.append(middle - began)
        runs.append(time.process_time() - middle)
    assert 0.5 < min(proofs) / min(runs) < 3.0


def test_a_number_that_the_rule_calls_zero_is_told():
    """1/2 but for 1e-1300, and 0 by the rule: the proof is of a body without weight."""
    body = {
        "moments": [3, 2, 4],
        "centre": [0, 0, 1],
        "omega": [0, 1, 1],
        "gamma": [0, "3/5", "4/5"],
    }
    found = polhode.certify(
        polhode.top(**body, weight="(sqrt(1+10**-1300)-1)*10**1300"), at=[1], digits=12
    )
    assert found.assumed[0].startswith("which numbers under a root")
    tiny = "sqrt(sqrt(1+10**-1300)-1)"
    free = polhode.top(moments=[2, 3, 4], omega=[tiny, 0, 1], gamma=[0, 0, 1])
    assert polhode.certify(free, at=[1], digits=12).assumed[0] == found.assumed[0]
    plain = polhode.top(**body | {"moments": [3, "sqrt(5)", 4]}, weight="sqrt(2)")
    assert polhode.certify(plain, at=[1], digits=12).assumed == ()

"""polhode.certify: what is asked, what is answered, and only as many digits as are proven."""

from __future__ import annotations

import random
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from typing import Any

import pytest

import polhode
from polhode import Body, Scene
from polhode.enclosures import fixed_point_problem, integral_contraction
from polhode.enclosures.fixed_point_problem import TooImprecise
from polhode.numbers.exact import Irrational
from shared import enclosures as trials
from shared.motions import ASYMMETRIC, asymmetric
from shared.tools import exact_number, exactly, of_table


def top(body: Body = ASYMMETRIC, omega: Any = ("0.3", "0.2", 3), gamma: Any = None) -> Scene:
    return Scene(body, omega, gamma or ("0.6", 0, "0.8"))


def _inside(enclosure: Any, rows: Any) -> bool:
    return all(
        abs(exactly(x) - centre) <= Fraction(radius)
        for row, centres, radii in zip(rows, enclosure.centres, enclosure.radii, strict=True)
        for x, centre, radius in zip(row, centres, radii, strict=True)
    )


@pytest.mark.slow
def test_the_digits_asked_for_are_proven_and_not_many_more() -> None:
    scene, digits = top(), 30
    enclosure = polhode.certify(scene, at=[1, "1/3", 8], digits=digits)
    assert enclosure.complete
    assert enclosure.proven == min(enclosure.digits)
    # at few digits the 60 bits of the first polynomials prove more than the noise level asks
    assert digits <= enclosure.digits[2] <= max(digits + 8, 18)
    assert _inside(enclosure, [trials.truth(scene, [t], 320)[0] for t in enclosure.times])


def test_times_of_both_signs_in_any_order_some_twice_and_irrational() -> None:
    scene = top()
    times = [3, "-sqrt(2)", 0, "1/3", 3, "sqrt(2)", -5]
    enclosure = polhode.certify(scene, at=times, digits=20)
    assert enclosure.centres[0] == enclosure.centres[4]
    assert [exact_number(t) == s for t, s in zip(times, enclosure.times, strict=True)] == [True] * 7
    for n, t in enumerate(enclosure.times):
        true = scene.start if n == 2 else None
        if isinstance(t, Fraction):
            row = replace(
                enclosure, centres=enclosure.centres[n : n + 1], radii=enclosure.radii[n : n + 1]
            )
            assert _inside(row, [true] if true else trials.truth(scene, [t], 200))
    # a time beside sqrt(2) by 1e-40 has the same 20 digits
    near = Fraction(14142135623730950488016887242096980785697, 10**40)
    beside = polhode.certify(scene, at=[near])
    for x, y, r in zip(beside.centres[0], enclosure.centres[5], enclosure.radii[5], strict=True):
        assert abs(x - y) <= Fraction(r) + Fraction(max(beside.radii[0]))


#: Scenes that differ in kind, and a time.
KINDS = {
    "a full inertia matrix": (
        Scene(
            Body(
                ((2, "1/5", "1/7"), ("1/5", "1.7", "1/10"), ("1/7", "1/10", "1.4")),
                ("0.3", "0.2", "0.5"),
                1,
            ),
            ("0.3", "0.2", "1.1"),
            ("0.6", 0, "0.8"),
        ),
        10,
    ),
    "no gamma": (Scene(Body.of_moments((3, 2, 1)), ("0.4", 1, "0.2")), 7),
    "chaotic": (top(omega=("0.3", "0.2", "1.1")), 30),
}


@pytest.mark.parametrize("kind", of_table(KINDS, "a full inertia matrix"))
def test_the_truth_is_inside_in_the_scenes_own_axes(kind: str) -> None:
    scene, t = KINDS[kind]
    enclosure = polhode.certify(scene, at=[t], digits=20)
    assert enclosure.complete
    assert enclosure.tries == 1
    assert len(enclosure.centres[0]) == len(enclosure.midpoints[0]) == (6 if scene.gamma else 3)
    assert _inside(enclosure, trials.truth(scene, [t], 260))


def test_irrational_data_lie_inside_and_their_rational_neighbours_do_not() -> None:
    def scene(root: Any) -> Scene:
        body = Body.of_moments((root, "1.5", 1), (0, "sqrt(2)/7", "0.3"), 1)
        return Scene(body, ("0.2", "0.1", "pi/3"), ("sqrt(3)/2", 0, "1/2"))

    exactly_root = scene("sqrt(5)/1.6")
    enclosure = polhode.certify(exactly_root, at=[10], digits=30)
    assert enclosure.complete
    assert _inside(enclosure, trials.truth(exactly_root, [10], 240))
    beside = scene(exact_number("sqrt(5)/1.6 + 1/10**28"))
    assert not _inside(enclosure, trials.truth(beside, [10], 240))


@pytest.mark.parametrize("gamma", [(0, 0, 1), (0, 0, -1)])
def test_a_body_at_rest_stays_and_its_digits_are_of_the_pendulums_rate(gamma: Any) -> None:
    scene = Scene(Body.of_moments((2, 3, 1), (0, 0, 1), 1), (0, 0, 0), gamma)
    enclosure = polhode.certify(scene, at=[5], digits=12)
    assert enclosure.complete
    assert _inside(enclosure, [scene.start])


@pytest.mark.parametrize("power", [-100, 100])
def test_units_of_any_size_cost_no_digit(power: int) -> None:
    scale = Fraction(10) ** power
    scene = asymmetric(rate=scale)
    enclosure = polhode.certify(scene, at=[10 / scale], digits=15)
    plain = polhode.certify(top(), at=[10], digits=15)
    # the proof's unit is a power of two, so that its steps are others, up to twice as long
    assert enclosure.proven == pytest.approx(plain.proven, abs=2.0)
    assert enclosure.noise == pytest.approx(plain.noise, abs=2)


def test_steps_are_as_long_as_the_norm_in_which_a_motion_hardly_stretches_allows() -> None:
    """By the norm of w and gamma as they are this takes 31."""
    assert 15 <= polhode.certify("lagrange/nutation", at=[10], digits=30).steps <= 22


@pytest.mark.parametrize(
    ("moments", "centre", "weight", "names"),
    [
        ((2, "1.5", 1), ("0.3", "0.2", "0.5"), 1, {"h", "f", "|gamma|^2"}),
        ((2, "1.5", 1), (0, 0, 0), 0, {"h", "f", "|gamma|^2", "|G|^2"}),
        ((2, 2, 1), (0, 0, 1), 1, {"h", "f", "|gamma|^2", "r", "w.k"}),
        ((2, 1, 2), (0, -3, 0), 1, {"h", "f", "|gamma|^2", "q", "w.k"}),
        ((2, 2, 1), ("0.6", "0.8", 0), 1, {"h", "f", "|gamma|^2", "K^2"}),
        ((1, 2, 2), (0, "0.6", "0.8"), 1, {"h", "f", "|gamma|^2", "K^2"}),
        ((2, 2, 1), ("0.6", "0.8", "1e-30"), 1, {"h", "f", "|gamma|^2"}),
        (("2", "2", "1.000000000000000000000001"), (1, 0, 0), 1, {"h", "f", "|gamma|^2"}),
    ],
)
def test_the_integrals_used_are_those_that_hold_exactly(
    moments: Any, centre: Any, weight: Any, names: set[str]
) -> None:
    scene = top(Body.of_moments(moments, centre, weight))
    assert set(integral_contraction.first_integrals(fixed_point_problem.motion(scene))) == names


#: Middle and radius of a ball, and what is printed.
PRINTED = [
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
]


def test_a_ball_prints_the_digits_that_all_its_numbers_round_to() -> None:
    enclosure = polhode.certify("euler/rest", at=[1], digits=1)

    def printed(centre: Fraction, radius: float) -> str:
        (row,) = replace(enclosure, centres=((centre,),), radii=((radius,),)).strings()
        return str(row[0])

    assert [printed(centre, radius) for centre, radius, _ in PRINTED] == [x[2] for x in PRINTED]
    rng = random.Random(5)
    for _ in range(200):
        size = Fraction(10) ** rng.choice([-60, 0, 0, 60])  # units of any size
        centre = size * Fraction(rng.randrange(-(10**12), 10**12), 10 ** rng.randrange(6, 14))
        radius = float(size) * 10.0 ** rng.uniform(-9, 1)
        text = printed(centre, radius)
        if not text:
            assert radius > abs(centre) / 20
            continue
        unit = Fraction(10) ** Decimal(text).as_tuple().exponent
        for part in (-1, -0.5, 0, 0.3, 1):
            assert abs(centre + Fraction(part) * Fraction(radius) - Fraction(text)) <= unit / 2


ROOT = "sqrt(sqrt(1+10**-1300)-1)"  # not 0, which the rule for "equal" calls it
HEAVY = {"centre": [0, 0, 1], "omega": [0, 1, 1], "gamma": [0, "3/5", "4/5"]}
UNDER = "which numbers under a root"
#: A body whose constants need a decision, or none.
BODIES: list[tuple[dict[str, Any], list[str]]] = [
    ({"moments": [3, 2, 4], "weight": "(sqrt(1+10**-1300)-1)*10**1300"} | HEAVY, [UNDER]),
    ({"moments": [2, 3, 4], "omega": [ROOT, 0, 1], "gamma": [0, 0, 1]}, [UNDER]),
    ({"moments": [3, "sqrt(5)", 4], "weight": "sqrt(2)"} | HEAVY, []),
    # a rational moment of a full matrix is known to be one
    ({"inertia": [[2, "1/2", 0], ["1/2", 2, "1/3"], [0, "1/3", 3]], "weight": 1} | HEAVY, []),
    ({"inertia": [[2, "1/2", 0], ["1/2", 2, 0], [0, 0, 3]], "weight": 1} | HEAVY, []),
]


@pytest.mark.parametrize(("body", "assumed"), BODIES)
def test_what_the_rule_decides_of_a_body_is_told(body: dict[str, Any], assumed: list[str]) -> None:
    enclosure = polhode.certify(polhode.top(**body), at=[1], digits=12)
    assert [x.startswith(y) for x, y in zip(enclosure.assumed, assumed, strict=False)] == [
        True
    ] * len(assumed)
    assert bool(enclosure.assumed) == bool(assumed)


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


@pytest.mark.parametrize(("gamma", "at", "outputs", "assumed"), BY_THE_RULE)
def test_what_the_rule_for_equal_decides_is_told(
    gamma: Any, at: list[Any], outputs: tuple[str, ...], assumed: list[str]
) -> None:
    enclosure = polhode.certify(replace(top(gamma=gamma), outputs=outputs), at=at, digits=12)
    assert [x.startswith(y) for x, y in zip(enclosure.assumed, assumed, strict=True)] == [
        True
    ] * len(assumed)


WHOLE = "expected a whole number, 1 to 250"
POSITIVE = "expected a number above 0"
NUMBER = "expected a number ("
#: What is asked, and what is said of it: as of ``integrate``, but for the most digits.
REFUSED: list[tuple[dict[str, Any], str]] = [
    *(({"digits": x}, f"digits = {x}: {WHOLE}") for x in (0, 251, 15.5, True, "20")),
    ({"max_steps": 2.5}, "max_steps = 2.5: expected a whole number, 1 or more"),
    ({"max_steps": True}, "max_steps = True: expected a whole number, 1 or more"),
    *(({"max_seconds": x}, f"max_seconds = {x}: {POSITIVE}") for x in ("1", True, -1)),
    ({"at": None}, "at least one time"),
    *(({"at": x}, f"at = {x}: expected a list of times") for x in (1, "12", {1, 2})),
    ({"at": [1, "x"]}, f"at[2] = x: {NUMBER}unknown name 'x'"),
    ({"at": [True]}, f"at[1] = True: {NUMBER}not a number"),
    ({"at": [10**10]}, "300000 steps reach; this one takes about"),
    ({"at": [100], "max_steps": 10}, "a time that 10 steps reach"),
]


@pytest.mark.parametrize(("options", "line"), REFUSED)
def test_bad_questions_are_refused_in_one_line(options: dict[str, Any], line: str) -> None:
    scene = replace(top(), events=(polhode.Event("equator"),))
    doors: dict[Any, dict[str, Any]] = {polhode.certify: {"at": [1]} | options}
    if "at" not in options:
        doors[polhode.certify_events] = {"end": 1} | options
    elif isinstance(options["at"], (int, str, set)) or "number" in line:
        doors[polhode.integrate] = options
    for door, question in doors.items():
        with pytest.raises(polhode.BadInput) as refused:
            door(scene, **question)
        assert line in str(refused.value)
        assert "\n" not in str(refused.value)


def test_what_follows_the_times_is_given_by_name() -> None:
    for door in (polhode.certify, polhode.certify_events):
        with pytest.raises(TypeError, match="positional"):
            door(top(), [1], 20)  # type: ignore[arg-type, misc]


@pytest.mark.parametrize("end", ["x", [1], True])
def test_an_end_is_read_as_everywhere(end: Any) -> None:
    for door in (polhode.certify_events, polhode.lyapunov):
        with pytest.raises(polhode.BadInput, match=r"^scene: end\[1\] = .*: expected a number \("):
            door(top(), end=end)


def test_times_beside_a_point_of_the_grid_are_on_their_sides() -> None:
    near = Fraction(1, 2**600)
    enclosure = polhode.certify(top(), at=[1 + near, 1, 1 - near], digits=20)
    for x, y, z, r in zip(*enclosure.centres, enclosure.radii[1], strict=True):
        assert abs(x - y) <= 2 * Fraction(r)
        assert abs(z - y) <= 2 * Fraction(r)


def test_a_constant_that_does_not_sharpen_is_refused() -> None:
    from flint import arb

    with pytest.raises(TooImprecise, match="not known sharply"):
        fixed_point_problem.sharp(Irrational(lambda: arb(1, 1e-9)), 80)


@pytest.mark.slow
def test_first_tries_suffice() -> None:
    rng = random.Random(17)
    tries, spare = [], []
    for kind in trials.KINDS:
        scene = trials.random_scene(rng, kind)
        digits = rng.choice((12, 16, 24))
        enclosure = polhode.certify(scene, at=[rng.choice((1, 5))], digits=digits)
        tries.append(enclosure.tries)
        spare.append(enclosure.proven - digits)
    assert sum(t == 1 for t in tries) >= 10
    assert sorted(spare)[5] < 4.0
